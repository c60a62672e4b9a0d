//! What is accepted, what is refused and in which words, and that a wrong run fails.

use mpm_core::scene::{DarcyChoice, Fields, LoadOn, ShapeChoice, Start, Surcharge, WaterProperties};

use super::super::faster;
use super::*;

fn built_in(name: &str) -> Scene {
    crate::scenes::built_in(name).expect("the built-in scene")
}

#[test]
fn every_exact_solution_of_the_suite_is_found() {
    for (name, words) in [
        ("terzaghi", "finite strain"),
        ("terzaghi-quasi-static", "Terzaghi's series with compressible water, drained at the top"),
        ("terzaghi-double", "both ends drained"),
        ("terzaghi-ramp", "finite strain"),
        ("dynamic-column", "finite strain"),
        ("terzaghi-large-strain", "finite strain"),
        ("self-weight-consolidation", "drained at the top"),
        ("hydrostatic", "finite strain"),
        ("layers", "2 layers"),
        ("mandel", "Mandel's problem"),
        ("dry-bar", "dry column"),
        ("oedometer-plastic", "dry column at rest"),
        ("wetting-front", "Green and Ampt, level"),
        ("infiltration", "Green and Ampt, downwards"),
        ("rising-front", "Green and Ampt, upwards"),
        ("dam", "rectangular dam"),
        ("boussinesq", "Boussinesq"),
        ("block-stops", "rigid block"),
        ("slope-seepage", "infinite slope"),
    ] {
        let scene = built_in(name);
        let own = OwnScene::new(&scene, &[]);
        let about = own.as_ref().map(OwnScene::about).unwrap_or_else(ToString::to_string);
        assert!(own.is_ok() && about.contains(words), "{name}: {about}");
        assert!(!own.expect("a solution").beside().is_empty(), "{name}");
    }
}

#[test]
fn what_has_no_exact_solution_is_refused_in_words() {
    let refused = |change: fn(&mut Fields), words: &str| {
        // Some are no scenes at all.
        let scene = crate::scenes::terzaghi().altered_unchecked(change);
        let message = OwnScene::new(&scene, &[]).expect_err("a refusal").to_string();
        assert!(message.contains(words) && message.contains(": expected "), "{words}: {message}");
    };
    refused(|s| (s.surcharge, s.gravity) = (None, None), "[surcharge]: expected a load");
    refused(|s| s.surcharge = s.surcharge.map(|l| Surcharge { on: LoadOn::Particles, ..l }), "found \"particles\"");
    refused(|s| s.surcharge = s.surcharge.map(|l| Surcharge { on: LoadOn::Plate, ..l }), "Mandel's problem under it");
    refused(|s| s.surcharge = s.surcharge.map(|l| Surcharge { pressure: 1e9, ..l }), "strains that leave water");
    refused(
        |s| {
            s.stages[0].drained[2] = true;
            s.observe_times.truncate(1);
        },
        "no exact solution with inertia has both ends drained",
    );
    let soft = |s: &mut Fields| {
        let bulk_modulus = s.porosity * s.oedometer_modulus();
        s.darcy_inertia = true;
        s.water = s.water.map(|water| WaterProperties { bulk_modulus, ..water });
    };
    refused(soft, "Q/(M + Q) = 0.500, than of the weight, rho_w/rho = 0.641");
    refused(|s| s.stages.push(s.stages[0].clone()), "[[stages]]: expected one");
    refused(|s| s.start = Start::Unloaded, "surcharge.ramp_time: expected at least");
    refused(|s| s.solid_sides[1] = mpm_core::scene::SolidSide::Free, "between rollers");
    for name in ["levee", "strip", "terzaghi-paper", "collapse-dry"] {
        let message = OwnScene::new(&built_in(name), &[]).expect_err("a refusal").to_string();
        assert!(message.contains(": expected ") && message.contains(", found "), "{name}: {message}");
    }
    for rows in [&[10, 20][..], &[20, 10, 40], &[1, 2, 4]] {
        let message = OwnScene::new(&crate::scenes::terzaghi(), rows).expect_err("a refusal").to_string();
        assert!(message.starts_with("--rows: expected three"), "{message}");
    }
}

#[test]
fn the_scene_keeps_its_load_and_says_what_it_carries() {
    let scene = crate::scenes::terzaghi();
    let own = OwnScene::new(&scene, &[5, 10, 20]).expect("it applies");
    assert_eq!(own.scene.surcharge, scene.surcharge);
    let beside = own.beside().join("; ");
    for words in
        ["strain: 3.71e-4 in the end, large in the solution", "weight: none", "inertia: in the solution", "0.9963"]
    {
        assert!(beside.contains(words), "{words}: {beside}");
    }
    let own = OwnScene::new(&built_in("terzaghi-quasi-static"), &[]).expect("it applies");
    assert!(own.about().contains("10, 14, 20, 28 rows") && own.about().contains("tolerance 1e-8"), "{}", own.about());
}

fn judged(scene: &Scene, rows: &[usize]) -> Judged {
    OwnScene::new(scene, rows).expect("it applies").judged().expect("runs that finish")
}

#[test]
fn a_sound_scene_passes_and_a_wrong_run_fails() {
    for (name, rows) in [("terzaghi-quasi-static", [5, 8, 10, 14]), ("mandel", [2, 4, 6, 8])] {
        let own = OwnScene::new(&built_in(name), &rows).expect("it applies");
        let judged = own.judged().expect("runs that finish");
        assert!(judged.row.passed(), "{name}: {}", judged.reason);
        assert_eq!((judged.row.case.as_str(), judged.samples.is_empty()), (name, false));
        let case = Named { name: "scene", about: "", mutant: None };
        let spoilt = judge(case, own.outcome(&|scene| Ok(scene.edited(faster)?)).expect("runs that finish"), 0.0);
        assert!(!spoilt.row.passed(), "{name}: {}", spoilt.reason);
    }
    let linear = built_in("terzaghi-semi-implicit")
        .edited(|linear| (linear.shape, linear.darcy) = (ShapeChoice::Linear, DarcyChoice::Face))
        .expect("a sound scene");
    let judged = judged(&linear, &[20, 28, 40, 56]);
    assert!(judged.row.passed(), "{}", judged.reason);
}

/// A fault of one percent in a number that the settlement or the pressure goes with.
#[test]
fn an_error_of_one_percent_cannot_pass() {
    let own = OwnScene::new(&built_in("terzaghi-quasi-static"), &[8, 11, 16, 22]).expect("it applies");
    type Fault = fn(&mut Fields);
    let faults: [(&str, Fault); 4] = [
        ("stiffness", |s| s.elastic.youngs_modulus *= 1.01),
        ("load", |s| s.surcharge = s.surcharge.map(|l| Surcharge { pressure: 1.01 * l.pressure, ..l })),
        ("conductivity", |s| {
            s.water = s.water.map(|w| WaterProperties { hydraulic_conductivity: 1.01 * w.hydraulic_conductivity, ..w })
        }),
        ("height", |s| (s.height, s.cell) = (1.01 * s.height, 1.01 * s.cell)),
    ];
    for (what, fault) in faults {
        let case = Named { name: "scene", about: "", mutant: None };
        let spoilt = judge(case, own.outcome(&|scene| Ok(scene.edited(fault)?)).expect("runs that finish"), 0.0);
        assert!(!spoilt.row.passed() && spoilt.reason.contains("above 0.003"), "{what}: {}", spoilt.reason);
    }
}

#[test]
fn what_was_a_false_alarm_passes() {
    // Soft water on small cells: an error of 2e-9 failed by the particles' sweep.
    let mut soft = built_in("terzaghi-quasi-static");
    let bulk_modulus = soft.porosity * soft.oedometer_modulus();
    soft = soft
        .edited(|soft| soft.water = soft.water.map(|water| WaterProperties { bulk_modulus, ..water }))
        .expect("a sound scene");
    // Large strain of the default: 2e-7 of true finite strain counted as error.
    let large =
        built_in("terzaghi-quasi-static").edited(|large| large.strain = StrainChoice::Large).expect("a sound scene");
    for (scene, most) in [(soft, 1e-4), (large, 2e-4)] {
        let judged = judged(&scene, &[10, 14, 20, 28]);
        assert!(judged.row.passed() && judged.row.error < most, "{}", judged.reason);
    }
}

#[test]
fn dry_columns_and_blocks_are_judged() {
    let dry = built_in("dry-bar").edited(|dry| dry.gravity = Some(9.81)).expect("a sound scene");
    let own = judged(&dry, &[10, 14, 20, 28]);
    assert!(own.row.passed(), "{}", own.reason);
    let own = OwnScene::new(&dry, &[10, 14, 20]).expect("it applies");
    let case = Named { name: "scene", about: "", mutant: None };
    let stiff = |s: &mut Fields| s.elastic.youngs_modulus *= 1.02;
    assert!(!judge(case, own.outcome(&|scene| Ok(scene.edited(stiff)?)).expect("runs"), 0.0).row.passed());
    let own = judged(&built_in("oedometer-plastic"), &[5, 8, 10]);
    assert!(own.row.passed(), "{}", own.reason);
    let own = judged(&built_in("rising-front"), &[10, 14, 20, 28]);
    assert!(own.row.passed(), "{}", own.reason);
}

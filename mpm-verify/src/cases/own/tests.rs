//! What is accepted, what is refused and in which words, and that a wrong run falls short.

use mpm_core::scene::{DarcyChoice, ShapeChoice};

use super::super::faster;
use super::*;

fn built_in(name: &str) -> Scene {
    crate::scenes::built_in(name).and_then(Result::ok).expect("the built-in scene")
}

fn solution(scene: &Scene) -> Result<Solution, String> {
    applies::solution(&lightly_loaded(scene).0, scene)
}

#[test]
fn every_consolidation_finds_its_exact_solution() {
    let found = |name: &str| solution(&built_in(name)).map(|s| s.words()).unwrap_or_else(|e| e);
    assert_eq!(found("terzaghi"), "the exact u-p column with inertia");
    assert_eq!(found("terzaghi-semi-implicit"), "the exact u-p column with inertia");
    assert_eq!(found("terzaghi-quasi-static"), "Terzaghi's series with compressible water");
    assert_eq!(found("terzaghi-double"), "Terzaghi's series with compressible water, both ends drained");
    assert_eq!(found("terzaghi-ramp"), "the exact u-p column with inertia");
    assert_eq!(found("dynamic-column"), "the exact u-p column with inertia");
    assert_eq!(found("terzaghi-large-strain"), "the converged column of large strain");
    assert_eq!(found("mandel"), "Mandel's problem");
}

#[test]
fn what_has_no_exact_solution_is_refused_in_words() {
    let refused = |change: fn(&mut Scene), words: &str| {
        let mut scene = crate::scenes::terzaghi();
        change(&mut scene);
        let message = OwnScene::new(&scene, &[]).err().unwrap_or_default();
        assert!(message.contains(words) && message.contains(": expected "), "{words}: {message}");
    };
    refused(|s| s.water = None, "[water]: expected pore water");
    refused(|s| s.gravity = Some(9.81), "found 9.81 m/s2");
    refused(|s| s.surcharge = None, "[surcharge]: expected a load");
    refused(|s| s.surcharge = s.surcharge.map(|l| Surcharge { on: LoadOn::Particles, ..l }), "found \"particles\"");
    refused(|s| s.surcharge = s.surcharge.map(|l| Surcharge { on: LoadOn::Plate, ..l }), "Mandel's problem under it");
    refused(|s| s.surcharge = s.surcharge.map(|l| Surcharge { pressure: 1e7, ..l }), "expected at most 0.02 M");
    refused(|s| s.stages[0].drained = [false; 4], "found none");
    refused(|s| s.stages[0].drained = [false, false, true, false], "found [\"bottom\"]");
    refused(|s| s.stages[0].drained[2] = true, "no exact solution has both ends drained and inertia");
    let soft = |s: &mut Scene| {
        let bulk_modulus = s.porosity * s.oedometer_modulus();
        s.water = s.water.map(|water| mpm_core::scene::WaterProperties { bulk_modulus, ..water });
    };
    refused(soft, "Q/(M + Q) = 0.500, than of the weight, rho_w/rho = 0.641");
    refused(|s| s.stages.push(s.stages[0].clone()), "[[stages]]: expected one");
    refused(|s| s.start = mpm_core::scene::Start::Unloaded, "surcharge.ramp_time: expected at least");
    refused(|s| s.solid_sides[1] = mpm_core::scene::SolidSide::Free, "between rollers");
    refused(|s| s.observe_times.clear(), "[observe]: expected times");
    refused(
        |s| {
            s.integrator = Integrator::SemiImplicit;
            s.observe_times.truncate(2);
        },
        "where semi-implicit runs are compared",
    );
    for name in ["levee", "dam", "oedometer-plastic", "self-weight", "strip", "block-stops", "terzaghi-paper"] {
        let message = OwnScene::new(&built_in(name), &[]).err().unwrap_or_default();
        assert!(message.contains(": expected ") && message.contains(", found "), "{name}: {message}");
    }
    for rows in [&[10, 20][..], &[20, 10, 40], &[1, 2, 4]] {
        let message = OwnScene::new(&crate::scenes::terzaghi(), rows).err().unwrap_or_default();
        assert!(message.starts_with("--rows: expected three"), "{message}");
    }
}

#[test]
fn a_light_load_and_a_small_tolerance_are_told() {
    let own = OwnScene::new(&crate::scenes::terzaghi(), &[5, 10, 20]).expect("it applies");
    assert!(own.about().contains("q/M = 1e-6") && own.about().contains("5, 10, 20 rows"), "{}", own.about());
    let own = OwnScene::new(&built_in("terzaghi-quasi-static"), &[]).expect("it applies");
    assert!(own.about().contains("10, 20, 40 rows") && own.about().contains("tolerance 1e-8"), "{}", own.about());
}

#[test]
fn a_sound_scene_holds_and_a_wrong_run_falls_short() {
    for (name, rows) in [("terzaghi-quasi-static", [5, 8, 10]), ("mandel", [2, 4, 8])] {
        let own = OwnScene::new(&built_in(name), &rows).expect("it applies");
        let climb = own.climb().expect("runs that finish");
        assert!(climb.step.held(), "{name}: {}", climb.reason);
        assert_eq!((climb.step.rung.as_str(), climb.samples.is_empty()), (name, false));
        let rung = Rung { name: "scene", about: "", climb: || Err(String::new()), mutant: None };
        let spoilt = judge(rung, own.outcome(faster).expect("runs that finish"), 0.0);
        assert!(!spoilt.step.held(), "{name}: {}", spoilt.reason);
    }
    let mut linear = built_in("terzaghi-semi-implicit");
    (linear.shape, linear.darcy) = (ShapeChoice::Linear, DarcyChoice::Face);
    let own = OwnScene::new(&linear, &[10, 14, 20]).expect("it applies");
    let climb = own.climb().expect("runs that finish");
    assert!(climb.step.held(), "{}", climb.reason);
}

//! Guards the physics: rest under gravity, undrained and dry equilibrium, steady flow, and the errata of the paper.

use crate::by_hand::started;
use crate::common::{
    CONDUCTIVITY, MODULUS, PORE_STIFFNESS, POROSITY, SURCHARGE, UNIT_WEIGHT, apart, completed, figures, scene,
};
use mpm_core::drive::{Run, drive};
use mpm_core::observe::{BalanceTerms, Observation};
use mpm_core::scene::{DarcyChoice, Integrator, LoadedStrip, Scene, WaterProperties};
use mpm_core::stability::explicit_limit;

const GRAVITY: f64 = 9.81;

/// A column at rest under its own weight, drained at its top.
fn at_rest(dimension: &str, darcy: &str, shape: &str) -> Scene {
    scene(&[
        &format!("dimension = \"{dimension}\""),
        &format!("darcy = \"{darcy}\""),
        &format!("shape = \"{shape}\""),
        "start = \"geostatic\"\ngravity = 9.81",
        "-[surcharge]",
        "cell = 0.1",
        "width = 0.2",
        "-time_factors",
        "until.time_factor = 0.1",
    ])
}

/// How far a run has come from rest: speed as a share of g t; pore pressure and effective stress as shares of their
/// hydrostatic values.
fn unrest(scene: &Scene, run: &Run) -> [f64; 3] {
    let buoyant = scene.mixture_density() * GRAVITY - UNIT_WEIGHT;
    let mut worst = [0.0_f64; 3];
    for sample in run.samples.iter().filter(|s| s.stage_time > 0.0) {
        worst[0] = worst[0].max(sample.state.max_speed / (GRAVITY * sample.stage_time));
        for row in &sample.state.profile {
            let depth = scene.height - row.material_height_m;
            worst[1] = worst[1].max(apart(row.pressure_pa, UNIT_WEIGHT * depth));
            worst[2] = worst[2].max(apart(row.effective_stress_pa, -buoyant * depth));
        }
    }
    worst
}

fn rests(scene: &Scene, run: &Run) -> bool {
    unrest(scene, run).iter().all(|share| *share < 1e-12)
}

#[test]
fn a_hydrostatic_column_stays_at_rest() {
    for dimension in ["column", "plane-strain"] {
        for darcy in ["face", "nodal"] {
            for shape in ["centre", "linear"] {
                let scene = at_rest(dimension, darcy, shape);
                let run = completed(&scene);
                println!("{dimension} {darcy} {shape}: {}", figures(&unrest(&scene, &run)));
                assert!(rests(&scene, &run), "{dimension} {darcy} {shape}");
            }
        }
    }
}

/// Whether a column stays at rest over stencils.
fn rests_over_stencils(dimension: &str, integrator: &str, shape: &str, gravity: &str) -> bool {
    let mut scene = at_rest(dimension, "face", shape)
        .edited(|scene| {
            scene.integrator = if integrator == "explicit" { Integrator::Explicit } else { Integrator::SemiImplicit }
        })
        .expect("a sound scene");
    if gravity == "none" {
        // A weight of nothing, which no scene has, in place of none at all.
        scene = scene.altered_unchecked(|scene| scene.gravity = Some(0.0));
    }
    let run = completed(&scene);
    println!("{dimension} {integrator} {shape}: {}", figures(&unrest(&scene, &run)));
    rests(&scene, &run)
}

#[test]
fn a_hydrostatic_column_stays_at_rest_over_stencils() {
    for dimension in ["column", "plane-strain"] {
        for (integrator, shape) in
            [("explicit", "gimp"), ("semi-implicit", "centre"), ("semi-implicit", "linear"), ("semi-implicit", "gimp")]
        {
            assert!(rests_over_stencils(dimension, integrator, shape, "9.81"), "{dimension} {integrator} {shape}");
        }
    }
    assert!(!rests_over_stencils("column", "semi-implicit", "centre", "none"));
}

/// Vertical effective stress and pore pressure of a column at rest under gravity, Pa.
fn hydrostatic(scene: &Scene, height: f64) -> (f64, f64) {
    let depth = scene.height - height;
    ((UNIT_WEIGHT - scene.mixture_density() * GRAVITY) * depth, UNIT_WEIGHT * depth)
}

#[test]
fn rest_check_can_fail() {
    let scene = at_rest("column", "face", "centre");
    let under = |gravity| {
        let scene = scene.edited(|s| s.gravity = Some(gravity)).expect("a sound scene");
        drive(&scene, started(&scene, hydrostatic).as_mut(), 0.9 * explicit_limit(&scene), &mut |_| {})
    };
    assert!(rests(&scene, &under(GRAVITY)));
    // The standard value instead of the rounded one that the first state was made with.
    let moved = under(9.80665);
    println!("wrong gravity: {}", figures(&unrest(&scene, &moved)));
    assert!(!rests(&scene, &moved));
}

/// Erratum 1: the Darcy flux in a hydrostatic column, from the two readings of Eq. (2).
#[test]
fn the_printed_sign_of_darcys_law_makes_still_water_flow() {
    let (slope, body) = (-UNIT_WEIGHT, -UNIT_WEIGHT); // dp/dz and rho_w g
    let flux = |sign: f64| -(CONDUCTIVITY / UNIT_WEIGHT) * (slope + sign * body);
    assert_eq!(flux(-1.0), 0.0);
    assert!(apart(flux(1.0), 2.0 * CONDUCTIVITY) < 1e-14);

    // The same from the solver: relative velocity v* = flux/n of the water away from the ends after one step.
    let scene = at_rest("column", "face", "centre");
    assert!(first_flow(&scene, GRAVITY).abs() < 1e-12 * CONDUCTIVITY);
    let nodal = scene.edited(|s| s.darcy = DarcyChoice::Nodal).expect("a sound scene");
    assert!(first_flow(&nodal, GRAVITY).abs() < 1e-12 * CONDUCTIVITY);
    // `grad p` and `rho_w g` with the same sign: the corrected equation under gravity that points upwards.
    let upwards = scene.edited(|s| s.darcy_inertia = false).expect("a sound scene");
    assert!(apart(first_flow(&upwards, -GRAVITY), 2.0 * CONDUCTIVITY / POROSITY) < 1e-12);
}

/// Velocity of the water beside the soil at mid height after one step from the hydrostatic state under a gravity, m/s.
fn first_flow(scene: &Scene, gravity: f64) -> f64 {
    // It may point upwards, which no scene has.
    let scene = scene.clone().altered_unchecked(|scene| scene.gravity = Some(gravity));
    let first = |scene: &Scene, height| hydrostatic(scene, height);
    let mut model = started(&scene, first);
    model.enter_stage(&scene.stages[0], &[]).expect("a stage");
    model.advance(1e-6, 1, &mut 0).expect("one step");
    let (water, solid) = (model.water_particles(), model.particles());
    water[water.len() / 2].velocity[1] - solid[solid.len() / 2].velocity[1]
}

/// Erratum 2: the pressure of a skeleton compressed without drainage, from the two readings of Eq. (5).
#[test]
fn the_printed_sign_of_the_mass_balance_makes_compression_suck() {
    // tr(eps) of a column that carries q undrained, and no seepage: tr(eps*) = 0.
    let (strain, seepage) = (-SURCHARGE / (MODULUS + PORE_STIFFNESS), 0.0);
    let pressure = |sign: f64| -PORE_STIFFNESS * (sign * strain + POROSITY * seepage);
    assert!((pressure(1.0) - 9963.4).abs() < 0.05, "{}", pressure(1.0));
    assert!((pressure(-1.0) + 9963.4).abs() < 0.05, "{}", pressure(-1.0));
}

/// A column loaded without drainage and damped until the given end.
fn undrained(until: &str, changes: &[&str]) -> Observation {
    let until = format!("until.time_factor -> {until}");
    let common = [
        "start = \"unloaded\"",
        "cell = 0.1",
        // The critical rate of the first mode. It also holds back the water that the wave has moved from cell to
        // cell: after 0.1 s the mean pressure is still low by 4e-4, and only the time of a consolidation mends that.
        "drained = \"none\"\ndamping = 6800.0",
        &until,
        "-[observe]",
    ];
    let run = completed(&scene(&[&common, changes].concat()));
    run.samples[run.samples.len() - 1].state.clone()
}

/// How far the mean pressure, and that of the worst cell, are from `q Q/(M + Q)`.
fn off_undrained(state: &Observation) -> [f64; 2] {
    let expected = SURCHARGE * PORE_STIFFNESS / (MODULUS + PORE_STIFFNESS);
    assert!((expected - 9963.4).abs() < 0.05);
    let cells = state.profile.iter().map(|row| apart(row.pressure_pa, expected)).fold(0.0, f64::max);
    [apart(state.mean_pressure, expected), cells]
}

#[test]
fn undrained_compression_reaches_its_pressure() {
    for dimension in ["dimension = \"column\"", "dimension = \"plane-strain\""] {
        for shape in ["shape = \"centre\"", "shape = \"linear\""] {
            let settled = "until.pore_pressure_within = 1.0e-4\nuntil.everywhere = true\nuntil.at_most = 1.0";
            let first = undrained(settled, &[dimension, shape]);
            let late = undrained("until.time = 1.0", &[dimension, shape]);
            let (first_off, off) = (off_undrained(&first), off_undrained(&late));
            println!("{dimension} {shape}: {} at {:.2} s, {} late", figures(&first_off), first.time, figures(&off));
            assert!(first_off.iter().all(|share| *share < 1e-4), "{dimension} {shape}: {}", figures(&first_off));
            assert!(off.iter().all(|share| *share < 1e-6), "{dimension} {shape}: {}", figures(&off));
        }
    }
}

/// Largest departure of the pressures of a closed column from their undrained value, compressed semi-implicitly.
fn compressed(shape: &str, bulk_modulus: &str, expected: f64) -> f64 {
    let run = completed(&scene(&[
        "integrator = \"semi-implicit\"",
        &format!("shape = \"{shape}\""),
        &format!("bulk_modulus = {bulk_modulus}"),
        "start = \"unloaded\"",
        "cell = 0.1",
        "drained = \"none\"\ndamping = 1000.0",
        "until.time_factor -> until.time = 10.0",
        "-time_factors",
    ]));
    let last = &run.samples[run.samples.len() - 1];
    last.state.profile.iter().map(|row| apart(row.pressure_pa, expected)).fold(0.0, f64::max)
}

#[test]
fn semi_implicit_compression_reaches_its_pressure() {
    let undrained = SURCHARGE * PORE_STIFFNESS / (MODULUS + PORE_STIFFNESS);
    for shape in ["centre", "linear", "gimp", "bspline2"] {
        let worst = [compressed(shape, "2.2e9", undrained), compressed(shape, "inf", SURCHARGE)];
        println!("{shape}: {}", figures(&worst));
        assert!(worst.iter().all(|share| *share < 1e-5), "{shape}: {}", figures(&worst));
    }
    assert!(compressed("centre", "2.2e9", SURCHARGE) > 1e-3);
}

#[test]
fn water_that_can_neither_yield_nor_flow_is_a_fault() {
    let scene = scene(&[
        "integrator = \"semi-implicit\"",
        "start = \"unloaded\"",
        "drained = \"none\"",
        "until.time_factor -> until.time = 1.0",
        "-time_factors",
        "-[surcharge]",
        "top = \"roller\"",
        "cell = 0.1",
    ])
    .altered_unchecked(|scene| {
        scene.history = 0;
        // The reader of scenes would refuse this.
        scene.water = scene.water.map(|w| WaterProperties { bulk_modulus: f64::INFINITY, ..w });
    });
    let failure = mpm_core::run::run(&scene, &mut |_| {}).expect("a run").failure.expect("a fault");
    println!("{failure}");
    assert!(failure.place.contains("pore pressure") && failure.what.contains("singular"), "{failure}");
}

/// Settlement (m) under a load on a part of the top.
fn settled_under(integrator: &str, shape: &str, strip: Option<[f64; 2]>) -> f64 {
    let scene = scene(&[
        "dimension = \"plane-strain\"",
        "start = \"unloaded\"",
        &format!("integrator = \"{integrator}\""),
        &format!("shape = \"{shape}\""),
        "pressure = 100.0",
        "cell = 0.1",
        "width = 0.4",
        "until.time_factor = 0.02",
        "-time_factors",
    ])
    .edited(|scene| {
        if let Some(surcharge) = &mut scene.surcharge {
            surcharge.strip = strip.map(|[from, to]| LoadedStrip { from, to, taper: 0.0 });
        }
    })
    .expect("a sound scene");
    let run = completed(&scene);
    run.samples[run.samples.len() - 1].state.settlement
}

#[test]
fn loads_on_parts_of_the_top_add_up() {
    for (integrator, shape) in [("explicit", "centre"), ("explicit", "gimp"), ("semi-implicit", "bspline2")] {
        let of = |strip| settled_under(integrator, shape, strip);
        let (whole, all) = (of(None), of(Some([0.0, 0.4])));
        let parts = of(Some([0.0, 0.1])) + of(Some([0.1, 0.4]));
        println!("{integrator} {shape}: whole {whole:.4e} m, parts {:.1e} off", apart(whole, parts));
        // Large strain makes the sum of two solutions differ by their strain, 4e-6.
        assert!(whole > 0.0 && whole == all && apart(whole, parts) < 1e-4, "{integrator} {shape}");
        assert!(apart(whole, of(Some([0.1, 0.4]))) > 0.1);
    }
}

#[test]
fn pressure_check_can_fail() {
    let softer = off_undrained(&undrained("until.time = 1.0", &["bulk_modulus = 2.1e9"]));
    println!("water softer by 5 %: {}", figures(&softer));
    assert!(softer.iter().all(|share| *share > 1e-6));
}

/// Settlement of a dry elastic bar under a surcharge (Pa), damped to rest, m.
fn dry_settlement(pressure: f64, changes: &[&str]) -> f64 {
    let pressure = format!("pressure = {pressure:?}");
    let common = [
        pressure.as_str(),
        "-[water]",
        "-darcy",
        "-darcy_inertia",
        "start = \"unloaded\"",
        "cell = 0.1",
        "drained -> damping = 460.0",
        "until.time_factor -> until.time = 0.2",
        "-[observe]",
    ];
    let run = completed(&scene(&[&common, changes].concat()));
    run.samples[run.samples.len() - 1].state.settlement
}

#[test]
fn a_dry_bar_settles_by_its_modulus() {
    for dimension in ["dimension = \"column\"", "dimension = \"plane-strain\""] {
        // So small a load that its strain of 4e-7 is nothing beside 1.
        let (pressure, height) = (10.0, 1.0);
        let small = apart(dry_settlement(pressure, &[dimension]), pressure * height / MODULUS);
        let full = apart(dry_settlement(SURCHARGE, &[dimension]), SURCHARGE * height / MODULUS);
        // The top row of particles stands a quarter of a cell below the surface: that much of the bar is unloaded.
        let loaded = height - 0.25 * 0.1;
        let on_particles = dry_settlement(pressure, &[dimension, "on = \"particles\""]);
        let below = apart(on_particles, pressure * loaded / MODULUS);
        println!("{dimension}: {small:.1e}, {full:.1e} under the full load, {below:.1e} on the particles");
        // Loaded particles go down with the surface, by the strain.
        assert!(small < 1e-7 && below < pressure / MODULUS, "{dimension}: {small:.1e} {below:.1e}");
        // A strain of 3.7e-4.
        assert!(full < 1e-4, "{dimension}: {full:.1e}");
    }
}

#[test]
fn settlement_check_can_fail() {
    // Young's modulus for the oedometer modulus is off by a quarter.
    assert!(apart(dry_settlement(10.0, &["poisson_ratio = 0.0"]), 10.0 / MODULUS) > 0.2);
}

/// Erratum 5: v* is the Darcy flux divided by the porosity. A column that drains downwards at p = 0 under a unit
/// gradient carries the flux k, and its water moves at k/n.
fn seeps(scene: &Scene) {
    // The skeleton carries the whole weight, its water included.
    let first = |scene: &Scene, height| (-scene.mixture_density() * GRAVITY * (scene.height - height), 0.0);
    let mut model = started(scene, first);
    let run = drive(scene, model.as_mut(), 0.9 * explicit_limit(scene), &mut |_| {});
    assert_eq!(run.failure, None);

    let speed = CONDUCTIVITY / POROSITY;
    let water = model.water_particles().iter().map(|p| apart(p.velocity[1], -speed)).fold(0.0, f64::max);
    let last = &run.samples[run.samples.len() - 1];
    let solid = last.state.max_speed / speed;
    let through = UNIT_WEIGHT / GRAVITY * CONDUCTIVITY * scene.width * last.stage_time;
    let BalanceTerms { water_in_kg, water_out_kg, water_residual_kg, .. } = last.balance;
    let booked = [apart(water_in_kg, through), apart(water_out_kg, through), water_residual_kg.abs() / through];
    let case = format!("{:?} {:?}", scene.dimension, scene.darcy);
    println!("{case}: water {water:.1e}, solid {solid:.1e}, ledger {}", figures(&booked));
    // Not round-off: the water particles sink through the mesh and take their weight along.
    assert!(water < 1e-6 && solid < 1e-6, "{case}: water {water:.1e}, solid {solid:.1e}");
    assert!(booked.iter().all(|share| *share < 1e-6), "{case}: {}", figures(&booked));
}

fn seepage(dimension: &str) -> Scene {
    scene(&[
        &format!("dimension = \"{dimension}\""),
        "start = \"unloaded\"\ngravity = 9.81",
        "-[surcharge]",
        "cell = 0.1",
        "width = 0.2",
        "drained = [\"bottom\", \"top\"]",
        "until.time_factor -> until.time = 1.0e-4",
        "-time_factors",
    ])
}

#[test]
fn steady_seepage_moves_the_water_at_the_flux_over_the_porosity() {
    for dimension in ["column", "plane-strain"] {
        for darcy in [DarcyChoice::Face, DarcyChoice::Nodal] {
            seeps(&seepage(dimension).edited(|s| s.darcy = darcy).expect("a sound scene"));
        }
    }
}

/// v_w - v_s and -(k/(n gamma_w)) dp/dz of the two cells at mid height, m/s, late in a consolidation.
fn consolidation_flow(darcy: DarcyChoice) -> [f64; 2] {
    // So small a load that the particles stay where they were.
    let scene = scene(&["cell = 0.05", "pressure = 1.0", "until.time_factor = 0.3", "-time_factors"]);
    let scene = scene.edited(|s| s.darcy = darcy).expect("a sound scene");
    let first = |scene: &Scene, _| {
        let pressure = scene.undrained_pressure();
        (pressure - 1.0, pressure)
    };
    let mut model = started(&scene, first);
    let run = drive(&scene, model.as_mut(), 0.9 * explicit_limit(&scene), &mut |_| {});
    assert_eq!(run.failure, None);
    // Rows 9 and 10 of 20: their water moves at the mean of the flows through their three faces.
    let pressure: Vec<f64> =
        run.samples[run.samples.len() - 1].state.profile.iter().map(|row| row.pressure_pa).collect();
    let slope = (pressure[11] + pressure[10] - pressure[9] - pressure[8]) / (4.0 * scene.cell);
    let middle = |z: f64| (0.45..0.55).contains(&z);
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let water = model.water_particles();
    let water = mean(water.iter().filter(|p| middle(p.x[1])).map(|p| p.velocity[1]).collect());
    let solid = mean(model.particles().iter().filter(|p| middle(p.x[1])).map(|p| p.velocity[1]).collect());
    [water - solid, -CONDUCTIVITY / (POROSITY * UNIT_WEIGHT) * slope]
}

#[test]
fn consolidating_water_follows_darcys_law() {
    for [relative, darcy] in [DarcyChoice::Face, DarcyChoice::Nodal].map(consolidation_flow) {
        println!("v_w - v_s = {relative:.6e}, Darcy / n = {darcy:.6e} m/s, apart {:.1e}", apart(relative, darcy));
        // Of this, -1.6e-4 is rho_w a_s; the rest the smoothing of v_s on its way to the mesh, of order L^2.
        assert!(apart(relative, darcy) < 1e-3);
    }
}

#[test]
fn flow_check_can_fail() {
    let [relative, darcy] = consolidation_flow(DarcyChoice::Face);
    // Reading v* as the Darcy flux itself is off by the porosity.
    assert!(apart(relative, POROSITY * darcy) > 0.5);
}

//! Guards the time-step limit: against an independent table, against runs just below and above it, and its refusal.

use crate::common::{CONDUCTIVITY, MODULUS, PORE_STIFFNESS, SURCHARGE, UNIT_WEIGHT, apart, figures, scene};
use mpm_core::drive::Run;
use mpm_core::run::{StartError, run};
use mpm_core::scene::{Integrator, Scene, StepChoice, Until};
use mpm_core::stability::{Medium, explicit_limit, stable_limit};

/// Column numbers of the table 12_stability.csv by name, and its rows.
fn table() -> (impl Fn(&str) -> usize, Vec<Vec<f64>>) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../reference-data/exact/12_stability.csv");
    let text = std::fs::read_to_string(path).expect("the table of limits");
    let names = text.lines().find_map(|line| line.strip_prefix("# columns: ")).expect("its column names");
    let names: Vec<String> = names.split(',').map(str::to_owned).collect();
    let number = |cell: &str| cell.parse().expect("a number");
    let rows = text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').map(number).collect());
    let column = move |name: &str| names.iter().position(|n| n == name).expect("a column of that name");
    (column, rows.collect())
}

/// The soil of Table 1 on a mesh without particles.
fn mesh(density: f64, cell: f64, flow_inertia: f64) -> Medium {
    Medium {
        modulus: MODULUS,
        density,
        pore_stiffness: PORE_STIFFNESS,
        mobility: CONDUCTIVITY / UNIT_WEIGHT,
        diffusivity: CONDUCTIVITY * PORE_STIFFNESS / UNIT_WEIGHT,
        flow_inertia,
        cell,
        shortest_transfer: 1.0,
        flip: 1.0,
    }
}

/// Largest relative departure from the table without and with inertia in Darcy's law, for media changed by `change`.
fn departure(change: fn(Medium) -> Medium) -> [f64; 2] {
    let (column, rows) = table();
    assert_eq!(rows.len(), 10);
    let mut worst = [0.0_f64; 2];
    for row in &rows {
        let at = |name: &str| row[column(name)];
        for (i, (inertia, name)) in [(0.0, "dt_exact_s"), (1000.0, "dt_uP_num_s")].into_iter().enumerate() {
            let limit = change(mesh(at("rho"), at("L_m"), inertia)).limit_column();
            worst[i] = worst[i].max(apart(limit, at(name)));
        }
    }
    worst
}

#[test]
fn the_limit_of_a_mesh_equals_the_table() {
    let worst = departure(|medium| medium);
    println!("{}", figures(&worst));
    assert!(worst.iter().all(|share| *share < 1e-6), "{}", figures(&worst));
}

/// Largest relative departure of the semi-implicit limit from the table, for media changed by `change`.
fn semi_implicit_departure(change: fn(Medium) -> Medium) -> f64 {
    let (column, rows) = table();
    let at = |row: &[f64], name: &str| row[column(name)];
    let limit = |row: &[f64]| change(mesh(at(row, "rho"), at(row, "L_m"), 0.0)).semi_implicit_column();
    rows.iter().map(|row| apart(limit(row), at(row, "dt_semi_formula_s"))).fold(0.0, f64::max)
}

#[test]
fn the_semi_implicit_limit_of_a_mesh_equals_the_table() {
    let worst = semi_implicit_departure(|medium| medium);
    println!("{worst:.1e}");
    assert!(worst < 1e-9, "{worst:.1e}");
    // Particles instead of a mesh.
    let worst = semi_implicit_departure(|medium| Medium { shortest_transfer: 0.0, ..medium });
    assert!(worst > 1e-3, "{worst:.1e}");
}

#[test]
fn table_check_can_fail() {
    // Particles instead of a mesh: one per cell.
    let worst = departure(|medium| Medium { shortest_transfer: 0.0, ..medium });
    println!("{}", figures(&worst));
    assert!(worst.iter().all(|share| *share > 1e-3));
}

#[test]
fn a_dry_mesh_is_bound_by_its_wave() {
    let dry = |cell, shortest_transfer| Medium {
        pore_stiffness: 0.0,
        mobility: 0.0,
        diffusivity: 0.0,
        shortest_transfer,
        ..mesh(1260.0, cell, 0.0)
    };
    for cell in [0.1, 0.02] {
        let wave = cell / (MODULUS / 1260.0_f64).sqrt();
        assert!(apart(dry(cell, 1.0).limit_column(), wave) < 1e-9);
        // One particle per cell: the shortest wave keeps its whole memory, c = 1 instead of 1/2.
        assert!(apart(dry(cell, 0.0).limit_column(), wave / 2.0_f64.sqrt()) < 1e-9);
    }
}

/// A run of a scene at a multiple of its limit, whatever becomes of it.
fn at(scene: &Scene, factor: f64) -> Run {
    let scene = scene
        .edited(|scene| {
            scene.step = StepChoice::Fixed(factor * explicit_limit(scene));
            scene.force = true;
        })
        .expect("a sound scene");
    run(&scene, &mut |_| {}).expect("a forced run")
}

/// Whether a consolidation to Tv = 0.05 came to its end with figures that can be true.
fn sane(run: &Run) -> bool {
    // The whole settlement, and U = sqrt(4 Tv/pi) from the series for small times.
    let (whole, exact) = (SURCHARGE / MODULUS, (4.0 * 0.05 / std::f64::consts::PI).sqrt());
    run.failure.is_none()
        && apart(run.samples[run.samples.len() - 1].state.settlement / whole, exact) < 0.02
        && run.samples.windows(2).all(|pair| pair[0].state.settlement <= pair[1].state.settlement)
        && run.samples.iter().all(|s| s.state.profile.iter().all(|row| row.pressure_pa.abs() < 2.0 * SURCHARGE))
}

fn consolidation(changes: &[&str]) -> Scene {
    scene(&[&["until.time_factor = 0.05", "-time_factors", "history = 20"], changes].concat())
}

#[test]
fn runs_hold_below_the_limit_and_fail_above() {
    for cell in ["cell = 0.1", "cell = 0.05"] {
        for per_cell in [1, 4, 9] {
            for dimension in ["column", "plane-strain"] {
                for darcy in ["face", "nodal"] {
                    for inertia in [true, false] {
                        let scene = consolidation(&[
                            cell,
                            &format!("particles_per_cell = {per_cell}"),
                            &format!("dimension = \"{dimension}\""),
                            "width = 0.4",
                            &format!("darcy = \"{darcy}\""),
                            &format!("darcy_inertia = {inertia}"),
                        ]);
                        let name = format!("{cell}, {per_cell} per cell, {dimension}, {darcy}, inertia {inertia}");
                        let below = at(&scene, 0.97);
                        // In plane strain the limit of the faces is that of a checkerboard on an endless mesh; on few
                        // cells between rollers it only appears at 1.03 to 1.15 times that.
                        let above = if dimension == "plane-strain" && darcy == "face" { 1.2 } else { 1.1 };
                        let failure = at(&scene, above).failure;
                        let settled = below.samples[below.samples.len() - 1].state.settlement * MODULUS / SURCHARGE;
                        println!("{name}: U {settled:.4}, above {:?}", failure.as_ref().map(|f| f.step));
                        assert!(sane(&below), "{name}: U {settled:.4} {:?}", below.failure);
                        assert!(failure.is_some(), "{name}: ran at {above} times the limit");
                    }
                }
            }
        }
    }
}

/// Whether 3000 steps at a multiple of a scene's own limit keep pressures and speeds in bounds.
fn bounded(scene: &Scene, factor: f64) -> bool {
    let step = factor * stable_limit(scene);
    let scene = scene
        .edited(|scene| {
            (scene.step, scene.force) = (StepChoice::Fixed(step), true);
            scene.stages[0].until = Until::Time(3000.0 * step);
            scene.observe_times = vec![3000.0 * step];
        })
        .expect("a sound scene");
    let run = run(&scene, &mut |_| {}).expect("a forced run");
    // Sudden drainage makes the skeleton swing: 1.2 q and 0.1 m/s are what it takes below its limit.
    let tame = |p: f64| p.abs() < 2.0 * SURCHARGE;
    run.failure.is_none()
        && run
            .samples
            .iter()
            .all(|s| s.state.max_speed < 0.5 && s.state.profile.iter().all(|row| tame(row.pressure_pa)))
}

fn semi_implicit(shape: &str, cell: &str, per_cell: usize, more: &[&str]) -> Scene {
    let common = [
        "integrator = \"semi-implicit\"",
        &format!("shape = \"{shape}\""),
        cell,
        &format!("particles_per_cell = {per_cell}"),
    ];
    consolidation(&[&common, more].concat())
}

#[test]
fn semi_implicit_columns_hold_below_their_limit_and_fail_above() {
    for shape in ["centre", "linear", "gimp"] {
        for cell in ["cell = 0.1", "cell = 0.02"] {
            for per_cell in [1, 4, 9] {
                let without = semi_implicit(shape, cell, per_cell, &["darcy_inertia = false"]);
                let held = [0.98, 1.03].map(|factor| bounded(&without, factor));
                assert_eq!(held, [true, false], "{shape}, {cell}, {per_cell} per cell");
                // At this conductivity rho_w a_s of the step before only raises the limit.
                let with = semi_implicit(shape, cell, per_cell, &[]);
                assert!(bounded(&with, 0.98), "{shape}, {cell}, {per_cell} per cell, with inertia");
                assert!(!bounded(&with, 1.25), "{shape}, {cell}, {per_cell} per cell, with inertia");
            }
        }
    }
}

#[test]
fn inertia_of_the_step_before_lowers_the_limit_of_soil_that_lets_its_water_through() {
    let limit = |conductivity: f64, inertia: bool, shape: &str| {
        let change = [&format!("hydraulic_conductivity = {conductivity:e}"), &format!("darcy_inertia = {inertia}")];
        stable_limit(&semi_implicit(shape, "cell = 0.01", 4, &change.map(String::as_str)))
    };
    for shape in ["centre", "linear", "gimp", "bspline2"] {
        assert_eq!(limit(5e-4, true, shape), limit(5e-4, false, shape), "{shape}");
        assert!(limit(1e-2, true, shape) < 0.2 * limit(1e-2, false, shape), "{shape}");
    }
    // The roots of the cubic, from an independent script: 2 particles per direction.
    let medium = Medium {
        flow_inertia: 1000.0,
        pore_stiffness: 2e9 / 0.3,
        mobility: 1e-2 / UNIT_WEIGHT,
        diffusivity: 1e-2 / UNIT_WEIGHT * 2e9 / 0.3,
        shortest_transfer: 0.25,
        ..mesh(1560.0, 0.1, 0.0)
    };
    let found = medium.lagged_inertia_column(1e-2);
    assert!(apart(found, 3.137_552_653_330_5e-4) < 1e-9, "{found:e}");
    assert_eq!(Medium { flow_inertia: 0.0, ..medium }.lagged_inertia_column(1e-2), 1e-2);
}

#[test]
fn one_particle_per_cell_holds_explicit_splines_to_the_free_end() {
    for conductivity in ["1.0e-5", "1.0e-9"] {
        for modulus in ["2.0e7", "2.0e9"] {
            let scene = consolidation(&[
                "shape = \"bspline2\"",
                "cell = 0.1",
                "particles_per_cell = 1",
                &format!("hydraulic_conductivity = {conductivity}"),
                &format!("bulk_modulus = {modulus}"),
            ]);
            assert!(bounded(&scene, 0.98) && !bounded(&scene, 1.1), "k = {conductivity}, K_w = {modulus}");
        }
    }
}

#[test]
fn shear_limits_semi_implicit_plane_strain() {
    for per_cell in [1, 4, 9] {
        let plane = ["dimension = \"plane-strain\"", "width = 0.4"];
        let centre = semi_implicit("centre", "cell = 0.1", per_cell, &plane);
        assert_eq!([0.98, 1.03].map(|factor| bounded(&centre, factor)), [true, false], "{per_cell} per cell");
        // The bounds for gradients at the particles are not sharp.
        for shape in ["linear", "gimp", "bspline2"] {
            let scene = semi_implicit(shape, "cell = 0.1", per_cell, &plane);
            assert!(bounded(&scene, 0.98) && !bounded(&scene, 2.8), "{shape}, {per_cell} per cell");
        }
    }
}

#[test]
fn splines_hold_below_their_limit() {
    for integrator in ["explicit", "semi-implicit"] {
        for cell in ["cell = 0.1", "cell = 0.02"] {
            for per_cell in [1, 4, 9] {
                for above in [0, 2] {
                    let mut scene = semi_implicit("bspline2", cell, per_cell, &[])
                        .edited(|scene| scene.empty_cells_above = above)
                        .expect("a sound scene");
                    if integrator == "explicit" {
                        scene = scene.edited(|scene| scene.integrator = Integrator::Explicit).expect("a sound scene");
                    }
                    let name = format!("{integrator}, {cell}, {per_cell} per cell, above {above}");
                    assert!(bounded(&scene, 0.98), "{name}");
                    assert!(!bounded(&scene, 10.0), "{name}");
                }
            }
        }
    }
}

#[test]
fn inertia_of_the_flow_helps_only_where_the_soil_at_a_drained_side_is_free() {
    let drained_right = |side: &str, inertia: bool| {
        consolidation(&[
            "cell = 0.1",
            "dimension = \"plane-strain\"",
            "width = 0.4",
            "start = \"unloaded\"",
            &format!("right = \"{side}\""),
            "drained = [\"right\"]",
            // The limit of the faces is that of a checkerboard of pressure, which moves no soil.
            "darcy = \"nodal\"",
            &format!("darcy_inertia = {inertia}"),
        ])
    };
    let limit = |side, inertia| explicit_limit(&drained_right(side, inertia));
    assert_eq!(limit("roller", true), limit("roller", false));
    assert_eq!(limit("free", false), limit("roller", false));
    assert!(limit("free", true) > 1.01 * limit("free", false), "{} {}", limit("free", true), limit("free", false));
    // Few cells on rollers hold a little above the lower limit, which is that of a wave anywhere; beside a free side
    // the higher one is sharp.
    for (side, too_much) in [("roller", 2.0), ("free", 1.1)] {
        let [below, above] = [0.97, too_much].map(|factor| at(&drained_right(side, true), factor).failure);
        assert!(below.is_none() && above.is_some(), "{side}: {below:?}, {above:?}");
    }
}

#[test]
fn sanity_check_can_fail() {
    let scene = consolidation(&["cell = 0.1"]);
    let mut run = at(&scene, 0.97);
    assert!(sane(&run));
    let last = run.samples.len() - 1;
    run.samples[last].state.settlement *= 1.03;
    assert!(!sane(&run));
    // A run above the limit that happens to come to its end is found out by its figures.
    assert!(!sane(&at(&scene, 1.01)));
}

#[test]
fn a_dry_bar_swings_below_the_limit_and_bursts_above() {
    for per_cell in [1, 4, 9] {
        let scene = scene(&[
            "-[water]",
            "-darcy",
            "-darcy_inertia",
            "start = \"unloaded\"",
            "cell = 0.1",
            &format!("particles_per_cell = {per_cell}"),
            "-drained",
            "until.time_factor -> until.time = 1.0",
            "-time_factors",
            "history = 200",
        ]);
        let swing = |factor| {
            let run = at(&scene, factor);
            let most = run.samples.iter().map(|s| s.state.settlement.abs()).fold(0.0, f64::max);
            (run.failure, most * MODULUS / SURCHARGE)
        };
        let ((held, below), (burst, above)) = (swing(0.97), swing(1.05));
        println!("{per_cell} per cell: {below:.3} q H/M below, {above:.3} above ({burst:?})");
        // A load put on at once makes the bar swing to twice its static settlement.
        assert!(held.is_none() && below < 2.1, "{per_cell} per cell: {below} {held:?}");
        // Particles that bounce off the base need not leave the mesh.
        assert!(burst.is_some() || above > 5.0, "{per_cell} per cell: {above}");
    }
}

#[test]
fn a_step_above_the_limit_is_refused() {
    let mut scene = consolidation(&["cell = 0.1"]);
    let limit = explicit_limit(&scene);
    scene = scene.edited(|scene| scene.step = StepChoice::Fixed(1.2 * limit)).expect("a sound scene");
    let error = run(&scene, &mut |_| {}).expect_err("a step above the limit");
    assert!(matches!(error, StartError::Step(_)));
    let message = error.to_string();
    assert!(
        message.contains(&format!("{limit:.6e} s")) && message.contains(&format!("{:.6e} s", 1.2 * limit)),
        "{message}"
    );
    // Just below it, it is not.
    scene = scene.edited(|scene| scene.step = StepChoice::Fixed(0.999 * limit)).expect("a sound scene");
    assert!(run(&scene, &mut |_| {}).is_ok());
}

#[test]
fn a_forced_run_fails_with_its_place_and_keeps_its_samples() {
    let run = at(&consolidation(&["cell = 0.1"]), 1.2);
    let failure = run.failure.as_ref().expect("an unstable run");
    println!("{failure}");
    assert_eq!(failure.step, run.steps);
    // The first steps are shorter, to end at the times of the history.
    let longest = run.steps as f64 * run.dt;
    assert!((0.5 * longest..longest).contains(&failure.time), "{failure}, {longest}");
    assert!(["particle", "cell", "column"].iter().any(|word| failure.place.contains(word)), "{failure}");
    // The start, and the times of the history before the failure.
    assert!(run.samples.len() > 1);
    assert!(run.samples.iter().all(|s| s.state.time <= failure.time && s.state.settlement.is_finite()));
    assert_eq!(run.stages.len(), 1);
}

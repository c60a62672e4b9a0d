//! Guards the time-step limit: against an independent table, against runs just below and above it, and its refusal.

mod common;

use common::{CONDUCTIVITY, MODULUS, PORE_STIFFNESS, SURCHARGE, UNIT_WEIGHT, apart, figures, scene};
use mpm_core::drive::Run;
use mpm_core::run::{StartError, run};
use mpm_core::scene::{Scene, StepChoice};
use mpm_core::stability::{Medium, explicit_limit};

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
    let mut scene = scene.clone();
    scene.step = StepChoice::Fixed(factor * explicit_limit(&scene));
    scene.force = true;
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
    scene.step = StepChoice::Fixed(1.2 * limit);
    let error = run(&scene, &mut |_| {}).expect_err("a step above the limit");
    assert!(matches!(error, StartError::Step(_)));
    let message = error.to_string();
    assert!(
        message.contains(&format!("{limit:.6e} s")) && message.contains(&format!("{:.6e} s", 1.2 * limit)),
        "{message}"
    );
    // Just below it, it is not.
    scene.step = StepChoice::Fixed(0.999 * limit);
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

//! Guards the explicit step over lanes: the bits of the plain step, whatever the vectors and the threads.

mod common;

use common::{apart, scene};
use mpm_core::hardware::{Hardware, Width};
use mpm_core::observe::{Ledger, Observation};
use mpm_core::run::model_on;
use mpm_core::scene::{Scene, SolidSide, Strength};
use mpm_core::stability::stable_limit;
use mpm_core::step::Model;

/// A model after some steps.
fn advanced(hardware: &Hardware, scene: &Scene, steps: u64) -> Box<dyn Model> {
    let mut model = model_on(hardware, scene).expect("a model");
    for stage in &scene.stages {
        model.enter_stage(stage, &[]).expect("a stage");
        let mut done = 0;
        model.advance(0.5 * stable_limit(scene), steps, &mut done).expect("steps");
        assert_eq!(done, steps);
    }
    model
}

fn seen(hardware: &Hardware, scene: &Scene, steps: u64) -> (Observation, Ledger) {
    let model = advanced(hardware, scene, steps);
    let pressure = model.pore_pressure();
    let state = model.observe();
    assert!((pressure[0] - state.mean_pressure).abs() <= 1e-12 * pressure[0].abs(), "{pressure:?}");
    (state, model.ledger())
}

/// Figures of a ledger that are added up over the steps.
fn booked(ledger: &Ledger) -> [f64; 10] {
    [
        ledger.water_in_kg,
        ledger.water_out_kg,
        ledger.impulse_n_s,
        ledger.external_work_j,
        ledger.gravity_work_j,
        ledger.flow_body_work_j,
        ledger.darcy_dissipation_j,
        ledger.damping_loss_j,
        ledger.water_particles_removed_kg,
        ledger.plastic_dissipation_j,
    ]
}

const WIDTHS: [Width; 4] = [Width::One, Width::Four, Width::Eight, Width::Widest];

fn wet(changes: &[&str]) -> Scene {
    let mut all = vec!["dimension = \"plane-strain\""];
    all.extend(changes);
    scene(&all)
}

/// Changes to a scene without water.
const DRY: [&str; 7] = [
    "-[water]",
    "-darcy",
    "-darcy_inertia",
    "start = \"unloaded\"",
    "drained -> damping = 10.0",
    "until.time_factor -> until.time = 1.0",
    "-time_factors",
];

/// A dry block of so many cells of 0.05 m that flies up through the mesh, cell by cell.
fn flying(cells: [usize; 2], shape: &str) -> Scene {
    let shape = format!("shape = \"{shape}\"");
    let more = ["cell = 0.05", "width = 0.1", "particles_per_cell = 9", "-[surcharge]", &shape];
    let mut scene = wet(&[&DRY[..], &more].concat());
    (scene.cells, scene.width, scene.height) = (cells, 0.05 * cells[0] as f64, 0.05 * cells[1] as f64);
    scene.headroom_cells = 8;
    scene.solid_sides[2] = SolidSide::Free;
    scene.gravity = Some(-100.0);
    scene
}

/// What soil that moves through cells needs is not done over lanes.
const PLAIN: &str = "darcy_inertia -> darcy_inertia = false\nlight_nodes = 0.0";

/// A saturated block of so many cells of 0.05 m under a load so heavy that water particles change their cells.
fn heavy(cells: [usize; 2]) -> Scene {
    let mut scene = wet(&["pressure = 2.0e7", "cell = 0.05", "particles_per_cell = 49", "width = 0.1", PLAIN]);
    (scene.cells, scene.width, scene.height) = (cells, 0.05 * cells[0] as f64, 0.05 * cells[1] as f64);
    scene
}

/// The same scene with soil that yields under hardly any load.
fn weak(mut scene: Scene, cohesion: f64) -> Scene {
    let tension_cutoff = Some(cohesion);
    scene.strength = Some(Strength { cohesion, friction_angle: 15.0, dilation_angle: 5.0, tension_cutoff });
    scene
}

/// Scenes small enough for one strip of cells, with the steps to take.
fn scenes() -> Vec<(&'static str, Scene, u64)> {
    let heavy = ["pressure = 1.5e6", "cell = 0.05", "particles_per_cell = 49", PLAIN];
    let weight = ["gravity = 9.81", "width = 0.3", "start = \"geostatic\"", "-[surcharge]"];
    let with = |first: &[&'static str], more: &[&'static str]| wet(&[first, more].concat());
    vec![
        ("consolidation", wet(&[]), 400),
        ("linear", wet(&["shape = \"linear\""]), 400),
        ("one per cell, load on particles", wet(&["particles_per_cell = 1", "on = \"particles\""]), 400),
        ("nine per cell, one cell wide", wet(&["particles_per_cell = 9", "width = 0.02"]), 200),
        ("PIC", wet(&["flip = 0.0"]), 200),
        ("Darcy without inertia", wet(&["darcy_inertia = false"]), 200),
        ("weight", wet(&weight), 400),
        ("dry, damped", with(&DRY, &[]), 400),
        ("dry, linear, weight", with(&DRY, &["shape = \"linear\"", "gravity = 9.81"]), 400),
        ("heavy load", with(&heavy, &[]), 3000),
        ("heavy load, linear", with(&heavy, &["shape = \"linear\""]), 1500),
        ("plastic", weak(wet(&[]), 5.0), 800),
        ("plastic, dry, linear, weight", weak(with(&DRY, &["shape = \"linear\"", "gravity = 9.81"]), 5.0), 400),
        ("plastic, heavy load", weak(with(&heavy, &[]), 50.0), 600),
        ("flying", flying([3, 6], "centre"), 700),
        ("flying, linear", flying([3, 6], "linear"), 700),
    ]
}

/// Scenes with sums in another order than by the plain step: columns, and functions over several cells or of both kinds.
fn others() -> Vec<(String, Scene, u64)> {
    let mut all = Vec::new();
    for shape in ["centre", "centroid", "linear", "b-bar"] {
        let shape = format!("shape = \"{shape}\"");
        for (plane, steps) in [(false, 400), (true, 200)] {
            for more in [&[][..], &["flip = 0.9", "particles_per_cell = 9"], &["on = \"plate\""]] {
                let mut changes = vec![shape.as_str()];
                changes.extend(if plane { &["dimension = \"plane-strain\"", "width = 0.06"][..] } else { &[] });
                changes.extend(more);
                all.push((format!("{changes:?}"), scene(&changes), steps));
            }
        }
    }
    all.push(("plastic column".to_owned(), weak(scene(&[]), 5.0), 800));
    all
}

#[test]
fn columns_and_all_functions_give_what_the_plain_step_gives() {
    for (name, scene, steps) in others() {
        let (state, ledger) = seen(&Hardware::plain(Width::Plain), &scene, steps);
        let mut first = None;
        for width in WIDTHS {
            let (own, booked_here) = seen(&Hardware::plain(width), &scene, steps);
            let numbers =
                |o: &Observation| [o.settlement, o.mean_pressure, o.base_pressure, o.soil_volume, o.max_speed];
            for (a, b) in numbers(&own).iter().zip(numbers(&state)) {
                assert!(apart(*a, b) < 1e-12, "{name}, {width:?}: {own:?} {state:?}");
            }
            for (a, b) in booked(&booked_here).iter().zip(booked(&ledger)) {
                assert!(apart(*a, b) < 1e-10 || (a - b).abs() < 1e-10, "{name}, {width:?}: {booked_here:?} {ledger:?}");
            }
            let seen = format!("{own:?} {booked_here:?}");
            assert_eq!(&seen, first.get_or_insert_with(|| seen.clone()), "{name}, {width:?}");
        }
    }
}

#[test]
fn lanes_give_the_bits_of_the_plain_step() {
    for (name, scene, steps) in scenes() {
        let (state, ledger) = seen(&Hardware::plain(Width::Plain), &scene, steps);
        let crossings = [state.solid_crossings, state.water_crossings];
        println!("{name}: crossings {crossings:?}, {:.1e} kg removed", ledger.water_particles_removed_kg);
        assert_eq!(name.starts_with("plastic"), ledger.plastic_dissipation_j > 0.0, "{name}");
        assert!(!name.starts_with("heavy") || ledger.water_particles_removed_kg > 0.0);
        assert!(!name.starts_with("flying") || crossings[0] > 100);
        let mut first = None;
        for width in WIDTHS {
            let (over_lanes, own) = seen(&Hardware::plain(width), &scene, steps);
            assert_eq!(format!("{over_lanes:?}"), format!("{state:?}"), "{name}, {width:?}");
            // Sums over the cells have another order than in the plain step, but the same for all widths.
            for (a, b) in booked(&own).iter().zip(booked(&ledger)) {
                assert!(apart(*a, b) < 1e-10 || (a - b).abs() < 1e-10, "{name}, {width:?}: {own:?} {ledger:?}");
            }
            assert_eq!(&own, first.get_or_insert(own), "{name}, {width:?}");
        }
    }
}

/// Where strips meet, results may be this far from those of the plain step, as shares of themselves.
const STRIPS: f64 = 1e-7;

#[test]
fn pages_say_where_the_plain_step_has_other_bits() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    for page in ["README.md", "mpm-core/src/step/dynamic.rs"] {
        let text = std::fs::read_to_string(format!("{root}/{page}")).expect("a page").replace("//! ", "");
        let words: Vec<&str> = text.split_whitespace().collect();
        let told = |words: &[&str]| words.contains(&format!("{STRIPS:e}").as_str()) && words.contains(&"strips");
        assert!(
            words.windows(40).any(|words| words.iter().any(|word| word.starts_with("plain")) && told(words)),
            "{page}"
        );
    }
}

#[test]
fn threads_and_lanes_do_not_change_bits() {
    let mut other_bits = 0;
    let scenes = [
        (flying([30, 40], "centre"), 450),
        (flying([200, 8], "linear"), 450),
        (heavy([30, 40]), 300),
        (weak(heavy([30, 40]), 50.0), 300),
    ];
    for (scene, steps) in scenes {
        let (state, ledger) = seen(&Hardware::default(), &scene, steps);
        println!("{:?}: {} and {} crossings", scene.cells, state.solid_crossings, state.water_crossings);
        assert!(state.solid_crossings > 0 || ledger.water_particles_removed_kg > 0.0);
        for threads in [2, 3] {
            let hardware = Hardware::threads(threads).expect("threads");
            assert_eq!(seen(&hardware, &scene, steps), (state.clone(), ledger), "{threads} threads");
        }
        assert_eq!(seen(&Hardware::plain(Width::One), &scene, steps), (state.clone(), ledger));
        // Nodes between two strips are added up in another order than by the plain step.
        let (plain, _) = seen(&Hardware::plain(Width::Plain), &scene, steps);
        assert!(apart(plain.settlement, state.settlement) < STRIPS, "{} {}", plain.settlement, state.settlement);
        assert!(apart(plain.mean_pressure, state.mean_pressure) < STRIPS);
        assert_eq!(plain.solid_crossings, state.solid_crossings);
        other_bits += usize::from(format!("{plain:?}") != format!("{state:?}"));
    }
    // If none had, the pages should say so.
    assert!(other_bits > 0);
}

#[test]
fn comparison_of_bits_can_fail() {
    let scene = wet(&[]);
    let (state, _) = seen(&Hardware::default(), &scene, 40);
    let mut other = scene.clone();
    other.flip *= 1.0 - 1e-15;
    let (changed, _) = seen(&Hardware::default(), &other, 40);
    assert_ne!(format!("{changed:?}"), format!("{state:?}"));
}

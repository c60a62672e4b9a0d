//! Guards the vectorised step: the same bits, whatever the width of SIMD and the number of threads.
//!
//! A program of its own: it alone needs the step in every width. All other tests take the width that is the default.

mod common;

use common::scene;
use mpm_core::drive::{Monitor, Run, Wish};
use mpm_core::hardware::{Hardware, Width};
use mpm_core::observe::{BalanceTerms, Observation};
use mpm_core::run::{model_on, run_monitored, run_on};
use mpm_core::scene::{DarcyChoice, DomainChoice, Integrator, Scene, ShapeChoice, SolidSide, Strength};
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

fn seen(hardware: &Hardware, scene: &Scene, steps: u64) -> (Observation, BalanceTerms) {
    let model = advanced(hardware, scene, steps);
    let pressure = model.pore_pressure();
    let (state, ledger) = model.observe();
    assert!((pressure[0] - state.mean_pressure).abs() <= 1e-12 * pressure[0].abs(), "{pressure:?}");
    (state, ledger)
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
    // No scene has gravity upwards.
    wet(&[&DRY[..], &more].concat()).altered_unchecked(|scene| {
        (scene.cells, scene.width, scene.height) = (cells, 0.05 * cells[0] as f64, 0.05 * cells[1] as f64);
        scene.empty_cells_above = 8;
        scene.solid_sides[2] = SolidSide::Free;
        scene.gravity = Some(-100.0);
    })
}

/// Without what soil that moves through cells needs.
const PLAIN: &str = "darcy_inertia -> darcy_inertia = false\nlight_nodes = 0.0";

/// A saturated block of so many cells of 0.05 m under a load so heavy that water particles change their cells.
fn heavy(cells: [usize; 2]) -> Scene {
    wet(&["pressure = 2.0e7", "cell = 0.05", "particles_per_cell = 49", "width = 0.1", PLAIN])
        .edited(|scene| {
            (scene.cells, scene.width, scene.height) = (cells, 0.05 * cells[0] as f64, 0.05 * cells[1] as f64)
        })
        .expect("a sound scene")
}

/// The same scene with soil that yields under hardly any load.
fn weak(scene: Scene, cohesion: f64) -> Scene {
    let strength = Strength {
        cohesion,
        friction_angle: 15.0,
        dilation_angle: 5.0,
        tension_cutoff: Some(cohesion),
        dilation_fades_over: None,
    };
    scene.altered_unchecked(|scene| scene.strength = Some(strength))
}

/// The same with a dilation that fades while it yields.
fn fading(scene: Scene, cohesion: f64) -> Scene {
    weak(scene, cohesion).altered_unchecked(|scene| {
        if let Some(strength) = &mut scene.strength {
            strength.dilation_fades_over = Some(1e-4);
        }
    })
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
        ("plastic, dilation fades", fading(wet(&[]), 5.0), 800),
        ("flying", flying([3, 6], "centre"), 700),
        ("flying, linear", flying([3, 6], "linear"), 700),
    ]
}

/// Columns, and all functions.
fn others() -> Vec<(String, Scene, u64)> {
    let mut all = Vec::new();
    for shape in ["centre", "centroid", "linear", "b-bar", "gimp", "bspline2"] {
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
    for shape in ["centre", "b-bar"] {
        let filtered = scene(&["dimension = \"plane-strain\"", "width = 0.06", &format!("shape = \"{shape}\"")]);
        let filtered = filtered.altered_unchecked(|scene| scene.null_space_strain = Some(1e-4));
        all.push((format!("plastic, null space, {shape}"), weak(filtered, 5.0), 400));
    }
    for (name, cells) in [("column", [1, 8]), ("block", [2, 8])] {
        for integrator in [Integrator::Explicit, Integrator::SemiImplicit] {
            let boxes = heavy(cells).altered_unchecked(|scene| {
                (scene.integrator, scene.particle_domain) = (integrator, DomainChoice::Contiguous);
            });
            all.push((format!("boxes, {name}, {integrator:?}"), boxes, 400));
        }
    }
    all.push(("plastic column".to_owned(), weak(scene(&[]), 5.0), 800));
    all
}

#[test]
fn every_width_gives_the_bits_of_one() {
    let named = scenes().into_iter().map(|(name, scene, steps)| (name.to_owned(), scene, steps));
    for (name, scene, steps) in named.chain(others()) {
        let (state, ledger) = seen(&Hardware::plain(Width::One), &scene, steps);
        let crossings = [state.solid_crossings, state.water_crossings];
        println!("{name}: crossings {crossings:?}, {:.1e} kg removed", ledger.water_particles_removed_kg);
        assert_eq!(name.starts_with("plastic"), ledger.plastic_dissipation_j > 0.0, "{name}");
        assert!(!name.starts_with("heavy") || ledger.water_particles_removed_kg > 0.0);
        assert!(!name.starts_with("flying") || crossings[0] > 100);
        for width in WIDTHS {
            let (wide, own) = seen(&Hardware::plain(width), &scene, steps);
            assert_eq!(format!("{wide:?} {own:?}"), format!("{state:?} {ledger:?}"), "{name}, {width:?}");
        }
    }
}

#[test]
fn threads_and_widths_do_not_change_bits() {
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
    }
}

#[test]
fn threads_do_not_change_bits_of_other_steps() {
    let still = |mut scene: Scene| {
        scene = scene
            .edited(|scene| scene.surcharge.iter_mut().for_each(|load| load.pressure = 1.0e4))
            .expect("a sound scene");
        scene
    };
    let solved = still(heavy([30, 40])).edited(|s| s.integrator = Integrator::SemiImplicit).expect("a sound scene");
    let nodal = still(heavy([30, 40])).edited(|s| s.darcy = DarcyChoice::Nodal).expect("a sound scene");
    let wide = still(heavy([30, 40])).edited(|s| s.shape = ShapeChoice::Bspline2).expect("a sound scene");
    for scene in [solved, nodal, wide] {
        let one = seen(&Hardware::default(), &scene, 20);
        let two = seen(&Hardware::threads(2).expect("threads"), &scene, 20);
        assert_eq!(two, one, "{:?} {:?} {:?}", scene.integrator, scene.darcy, scene.shape);
    }
}

/// Stops a run at its sixth look.
#[derive(Default)]
struct Sixth {
    looks: usize,
    state: Option<Vec<u8>>,
}

impl Monitor for Sixth {
    fn look(&mut self, _: f64) -> Wish {
        self.looks += 1;
        if self.looks == 6 { Wish::Stop } else { Wish::GoOn }
    }

    fn save(&mut self, state: Vec<u8>) {
        self.state = Some(state);
    }
}

#[test]
fn a_run_is_resumed_with_another_width_and_other_threads_to_the_same_bits() {
    let scene = wet(&["cell = 0.1", "until.time_factor = 0.01", "-time_factors", "history = 40"]);
    let text = |run: Run| format!("{:?}", Run { bytes: 0, ..run });
    let whole = run_on(&Hardware::default(), &scene, &mut |_| {}).expect("a run");
    let (mut state, mut pieces) = (None, 0);
    let last = loop {
        let mut sixth = Sixth::default();
        let threads = Hardware::threads(1 + pieces % 3).expect("threads");
        let hardware = Hardware { width: WIDTHS[pieces % WIDTHS.len()], ..threads };
        let run = run_monitored(&hardware, &scene, state.as_deref(), &mut sixth).expect("a run");
        pieces += 1;
        if !run.stopped {
            break run;
        }
        state = sixth.state;
    };
    assert!(pieces > WIDTHS.len(), "{pieces}");
    assert_eq!(text(last), text(whole));
}

#[test]
fn comparison_of_bits_can_fail() {
    let scene = wet(&[]);
    let (state, _) = seen(&Hardware::default(), &scene, 40);
    let other = scene.edited(|other| other.flip *= 1.0 - 1e-15).expect("a sound scene");
    let (changed, _) = seen(&Hardware::default(), &other, 40);
    assert_ne!(format!("{changed:?}"), format!("{state:?}"));
}

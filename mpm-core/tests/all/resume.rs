//! A run that is stopped and resumed elsewhere, again and again, ends with the same bits: every scene, every integrator and
//! shape.

use std::path::PathBuf;

use mpm_core::checkpoint::{sealed, unsealed};
use mpm_core::drive::{Monitor, Run, Wish};
use mpm_core::hardware::Hardware;
use mpm_core::run::{StartError, run_monitored, run_on};
use mpm_core::scene::{Flags, Integrator, Scene, Until};

/// Stops a run at every so many looks.
struct Stops {
    every: usize,
    looks: usize,
    state: Option<Vec<u8>>,
}

impl Monitor for Stops {
    fn look(&mut self, _: f64) -> Wish {
        self.looks += 1;
        if self.looks == self.every { Wish::Stop } else { Wish::GoOn }
    }

    fn save(&mut self, state: Vec<u8>) {
        self.state = Some(state);
    }
}

/// Runs a scene in pieces, each by a model of its own; and how many there were.
fn in_pieces(hardware: &Hardware, scene: &Scene, every: usize) -> (Run, usize) {
    let (mut state, mut pieces) = (None, 0);
    loop {
        let mut stops = Stops { every, looks: 0, state: None };
        let run = run_monitored(hardware, scene, state.as_deref(), &mut stops).expect("a run");
        pieces += 1;
        if !run.stopped {
            return (run, pieces);
        }
        state = stops.state;
        assert!(state.is_some() && pieces < 5000);
    }
}

fn scenes() -> Vec<PathBuf> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../reference-data/scenes");
    let files = std::fs::read_dir(folder).expect("scenes").map(|entry| entry.expect("an entry").path());
    let mut scenes: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    scenes.sort();
    scenes
}

/// The first part of a scene, so that a test can afford it.
fn shortened(scene: Scene) -> Scene {
    // As soon as the wave of the load is somewhat damped.
    let mut scene = scene
        .edited(|scene| {
            for stage in &mut scene.stages {
                if let Until::PorePressure { within, .. } = &mut stage.until {
                    *within = 0.5;
                }
            }
        })
        .expect("a sound scene");
    // A step of so many particles costs some 50 ns each.
    let mut dt = mpm_core::stability::choose_step(&scene).unwrap_or(f64::INFINITY);
    if scene.integrator == Integrator::Implicit {
        dt = 0.02 * scene.cell * (scene.mixture_density() / scene.oedometer_modulus()).sqrt(); // so that waves are resolved
    }
    if dt.is_finite() {
        let most =
            if scene.integrator == Integrator::Implicit { 3e3 } else { 3e5 } / scene.solid_particles() as f64 * dt;
        let last = scene.stages.len() - 1;
        if let Until::Time(end) = scene.stages[last].until {
            let end = end.min(most.max(40.0 * dt));
            scene = scene
                .edited(|scene| {
                    scene.stages[last].until = Until::Time(end);
                    scene.observe_times.retain(|time| *time < end);
                    scene.observe_times.push(end);
                })
                .expect("a sound scene");
        }
    }
    scene
}

/// Some twenty pieces, or as many as there are looks; none for a load that the shape cannot bear.
fn same(hardware: &Hardware, scene: &Scene, name: &str) -> Option<usize> {
    let mut goes_on = Stops { every: 0, looks: 0, state: None };
    let whole = match run_monitored(hardware, scene, None, &mut goes_on) {
        Err(StartError::Load(_)) => return None,
        run => run.expect("a run"),
    };
    let (pieced, pieces) = in_pieces(hardware, scene, (goes_on.looks / 20).max(1));
    the_same(&whole, &pieced, name);
    Some(pieces)
}

fn the_same(whole: &Run, pieced: &Run, name: &str) {
    // Written out with all digits and signs; what lists have in reserve is no result.
    let text = |run: &Run| format!("{:?}", Run { bytes: 0, ..run.clone() });
    let (a, b) = (text(whole), text(pieced));
    if a != b {
        let at = a.bytes().zip(b.bytes()).take_while(|(a, b)| a == b).count();
        let part = |text: &str| text[at.saturating_sub(200)..(at + 60).min(text.len())].to_owned();
        panic!("{name}:\n{}\n{}", part(&a), part(&b));
    }
}

#[test]
fn every_scene() {
    let mut ran = 0;
    for path in scenes() {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let scene = shortened(Scene::load(&path).expect("a scene"));
        if scene.may_fail() {
            continue; // the levees have a driver and checkpoints of their own
        }
        let clock = std::time::Instant::now();
        let pieces = same(&Hardware::default(), &scene, &name).expect("a load that it bears");
        println!("{name}: {pieces} pieces, {:.2} s", clock.elapsed().as_secs_f64());
        assert!(pieces > 1, "{name}");
        ran += 1;
    }
    assert!(ran >= 30);
}

#[test]
fn every_integrator_and_shape() {
    let mut ran = 0;
    // What other scenes have does not depend on the shape: `every_scene` runs them as they are.
    for name in ["terzaghi", "mandel", "dynamic-column", "terzaghi-large-strain"] {
        for integrator in ["explicit", "semi-implicit", "quasi-static", "implicit"] {
            for scheme in ["centre", "linear", "b-bar", "gimp", "bspline2"] {
                let (integrator, scheme) = (Some(integrator.to_owned()), Some(scheme.to_owned()));
                let flags = Flags { integrator: integrator.clone(), scheme: scheme.clone(), ..Flags::default() };
                let path = format!("{}/../reference-data/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
                let Ok(scene) = Scene::load_with(path.as_ref(), &flags) else { continue };
                let scene = shortened(scene);
                let name = format!("{name} {integrator:?} {scheme:?}");
                ran += usize::from(same(&Hardware::default(), &scene, &name).is_some());
            }
        }
    }
    println!("{ran} combinations");
    assert!(ran >= 45);
}

/// What a step keeps or maps beside its particles, in soil whose surface is followed.
#[test]
fn every_way_to_carry_velocities() {
    let dry = Scene::load(format!("{}/../reference-data/scenes/dry-bar.toml", env!("CARGO_MANIFEST_DIR")).as_ref());
    let dry = dry.expect("a sound scene");
    let mut ran = [0; 3];
    for shape in ["centre", "linear", "gimp", "bspline2"] {
        let ways = [("update", "musl"), ("transfer", "affine"), ("particle_domain", "contiguous")];
        for (way, (key, word)) in ways.into_iter().enumerate() {
            for darcy in ["face", "none"] {
                let base = if darcy == "face" { crate::common::scene(&["cell = 0.1"]) } else { dry.clone() };
                let changes = [("scheme.shape", shape.into()), (&*format!("scheme.{key}"), word.into())];
                let Ok(scene) = base.patched(&changes) else { continue };
                let name = format!("{shape} {word} {darcy}");
                same(&Hardware::default(), &shortened(scene), &name).expect("a load that it bears");
                ran[way] += 1;
            }
        }
    }
    // Boxes go with one of these shapes.
    assert!(ran[0] + ran[1] >= 12 && ran[2] == 2, "{ran:?}");
}

/// Models with steps of their own choice pause on a long way to the next time, and go on to that very time.
#[test]
fn a_pause_between_two_times() {
    let many_steps = crate::common::scene(&[
        "integrator = \"quasi-static\"",
        "cell = 0.1",
        "step = 3e-7",
        "-safety",
        "-flip",
        "-darcy_inertia",
        "until.time_factor = 0.01",
        "-time_factors",
        "history = 1",
    ]);
    let path = format!("{}/../reference-data/scenes/rising-front.toml", env!("CARGO_MANIFEST_DIR"));
    let mut long = Scene::load(path.as_ref()).expect("a scene");
    let end = 1e5;
    long = long
        .edited(|long| {
            long.stages[0].until = Until::Time(end);
            (long.observe_times, long.history) = (vec![end], 1);
        })
        .expect("a sound scene");
    for scene in [many_steps, long] {
        let mut goes_on = Stops { every: 0, looks: 0, state: None };
        let whole = run_monitored(&Hardware::default(), &scene, None, &mut goes_on).expect("a run");
        let times = whole.samples.len() - 1;
        assert!(goes_on.looks > times, "{}: {} looks at {times} times", scene.name, goes_on.looks);
        let (pieced, pieces) = in_pieces(&Hardware::default(), &scene, 1);
        assert!(pieces > times, "{}", scene.name);
        the_same(&whole, &pieced, &scene.name);
    }
}

#[test]
fn a_state_with_another_bit_ends_otherwise() {
    let scene = crate::common::scene(&["cell = 0.1", "until.time_factor = 0.01", "-time_factors", "history = 20"]);
    let hardware = Hardware::default();
    let whole = run_on(&hardware, &scene, &mut |_| {}).expect("a run");
    let mut stops = Stops { every: 12, looks: 0, state: None };
    run_monitored(&hardware, &scene, None, &mut stops).expect("a run");
    let state = stops.state.expect("a state");
    let of = state[8..40].try_into().expect("a hash");
    let mut inside = unsealed(&state, &of).expect("a whole state").to_vec();
    // The last bit of every number that may be a pressure, wherever it stands.
    let mut at = 0;
    while at + 8 <= inside.len() {
        let number = f64::from_le_bytes(inside[at..at + 8].try_into().expect("eight bytes"));
        let changed = (1e3..2e4).contains(&number);
        inside[at] ^= u8::from(changed);
        at += if changed { 8 } else { 1 };
    }
    let mut on = Stops { every: 0, looks: 0, state: None };
    let other = run_monitored(&hardware, &scene, Some(&sealed(&inside, &of)), &mut on).expect("a run");
    let end = |run: &Run| format!("{:?}", run.samples.last().map(|sample| &sample.state));
    assert_ne!(end(&whole), end(&other));
}

#[test]
fn a_state_of_another_scene_is_refused() {
    let scene = crate::common::scene(&["cell = 0.1", "until.time_factor = 0.01", "-time_factors", "history = 20"]);
    let mut stops = Stops { every: 3, looks: 0, state: None };
    let hardware = Hardware::default();
    run_monitored(&hardware, &scene, None, &mut stops).expect("a run");
    let state = stops.state.expect("a state");
    let other = scene.edited(|other| other.porosity += 1e-9).expect("a sound scene");
    let mut none = Stops { every: 0, looks: 0, state: None };
    let refused = run_monitored(&hardware, &other, Some(&state), &mut none);
    assert!(matches!(refused, Err(StartError::Checkpoint(_))));
    for at in (0..state.len()).step_by(101) {
        let mut damaged = state.clone();
        damaged[at] ^= 1;
        let refused = run_monitored(&hardware, &scene, Some(&damaged), &mut none);
        assert!(matches!(refused, Err(StartError::Checkpoint(_))), "byte {at}");
    }
}

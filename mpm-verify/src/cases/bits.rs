//! Runs give the same bits whatever the threads and the lanes, run again, and stopped and resumed elsewhere.

use mpm_core::drive::{Monitor, Run, Wish};
use mpm_core::failure::{Driver, Phase};
use mpm_core::hardware::{Hardware, Width};
use mpm_core::hash::{Digest, sha256};
use mpm_core::run::{run_monitored, run_on};
use mpm_core::scene::{Base, Dimension, LoadedStrip, Scene, ShapeChoice, Start, Surcharge, Until};
use mpm_core::stability::choose_step;

use super::{Error, Mutant, Outcome, Program, Unfit, whole};
use crate::experiment::refinement::RUNS;
use crate::nightly::work::GATES;

/// Threads, and vectors of any width.
pub const THREADS: Program = Program {
    name: "same-bits-threads",
    about: "a block in plane strain on 1, 2, 3 and 8 threads, with SIMD vectors of every width: numbers that differ",
    run: || threads(0.0),
    mutant: Some(Mutant { what: "a load larger by 1e-14 on three threads", run: || threads(1e-14) }),
};

/// Every path through the solver, run again.
pub const AGAIN: Program = Program {
    name: "same-bits-again",
    about: "every integrator and shape run twice, on two threads side by side: runs that differ",
    run: || again(0.0),
    mutant: Some(Mutant { what: "a porosity larger by 1e-14 the second time", run: || again(1e-14) }),
};

/// Every path, in pieces.
pub const RESUMED: Program = Program {
    name: "same-bits-resumed",
    about: "every integrator and shape stopped at every look and taken up by another model: runs that differ",
    run: || resumed(false),
    mutant: Some(Mutant { what: "the last look is not taken up", run: || resumed(true) }),
};

/// A levee, in pieces.
pub const LEVEE: Program = Program {
    name: "same-bits-levee",
    about: "a levee that slides, stopped and taken up by another driver: parts of its state that differ",
    run: || levee(false),
    mutant: Some(Mutant { what: "a look more", run: || levee(true) }),
};

/// Hash of all that a run says. What lists have in reserve is no result.
fn said(run: &Run) -> Digest {
    sha256(format!("{:?}", Run { bytes: 0, ..run.clone() }).as_bytes())
}

/// A block of some cells for some steps, under a load on its left part that pushes the soil down and aside.
fn block(cells: [usize; 2], steps: f64) -> Result<Scene, Error> {
    let mut scene = crate::scenes::terzaghi().edited(|scene| {
        (scene.dimension, scene.shape) = (Dimension::PlaneStrain, ShapeChoice::Centre);
        (scene.cells, scene.width, scene.height) = (cells, cells[0] as f64 * scene.cell, cells[1] as f64 * scene.cell);
    })?;
    let strip = LoadedStrip { from: 0.0, to: 0.3 * scene.width, taper: 0.2 * scene.width };
    scene = scene.edited(|scene| {
        scene.start = Start::Unloaded;
        scene.surcharge = scene.surcharge.map(|load| Surcharge { strip: Some(strip), ..load });
    })?;
    let dt = choose_step(&scene).unwrap_or(1e-6);
    let last = scene.stages.len() - 1;
    Ok(scene.edited(|scene| {
        scene.stages[last].until = Until::Time(steps * dt);
        scene.observe_times = vec![0.5 * steps * dt, steps * dt];
        (scene.history, scene.profiles) = (0, true);
    })?)
}

/// A low and closed block: its wave is soon in every strip, and none has all of the flow, as one would under
/// a drained surface. Only then does the order of a sum over strips show.
fn threads(off: f64) -> Result<Outcome, Error> {
    let scene = block([130, 32], 120.0)?.edited(|scene| {
        for stage in &mut scene.stages {
            stage.drained = [false; 4];
        }
    })?;
    let reference = said(&whole(run_on(&Hardware::plain(Width::One), &scene, &mut |_| {}))?);
    let mut different = Vec::new();
    for threads in [1, 2, 3, 8] {
        for width in [Width::Widest, Width::One, Width::Four, Width::Eight] {
            let own = scene.edited(|own| {
                if let (Some(load), 3) = (&mut own.surcharge, threads) {
                    load.pressure *= 1.0 + off;
                }
            })?;
            let hardware = Hardware { width, ..Hardware::threads(threads)? };
            let run = whole(run_on(&hardware, &own, &mut |_| {}))?;
            different.push(f64::from(said(&run) != reference));
        }
    }
    Ok(outcome("explicit", &different))
}

/// Every gate of the work: one of each path through the solver.
fn scenes() -> Result<Vec<Scene>, Error> {
    GATES.iter().map(|gate| quick(gate.scene()?)).collect()
}

/// A part of it, with some samples on the way.
fn quick(mut scene: Scene) -> Result<Scene, Error> {
    let last = scene.stages.len() - 1;
    if let (Until::Time(end), true) = (scene.stages[last].until, scene.observe_times.len() == 1) {
        let end = 0.1 * end;
        scene = scene.edited(|scene| {
            scene.stages[last].until = Until::Time(end);
            scene.observe_times = vec![0.3 * end, 0.7 * end, end];
        })?;
    }
    Ok(scene.edited(|scene| scene.profiles = true)?)
}

fn again(off: f64) -> Result<Outcome, Error> {
    let mut different = Vec::new();
    for scene in scenes()? {
        let changed = scene.edited(|s| s.porosity = scene.porosity * (1.0 + off))?;
        let both = std::thread::scope(|scope| {
            let one = scope.spawn(|| whole(run_on(&Hardware::default(), &scene, &mut |_| {})));
            let other = whole(run_on(&Hardware::default(), &changed, &mut |_| {}));
            let one = one.join().map_err(|_| Unfit("a run that panicked"))?;
            Ok::<_, Error>([said(&one?), said(&other?)])
        })?;
        different.push(f64::from(both[0] != both[1]));
    }
    Ok(outcome("all", &different))
}

/// Stops a run at its next look.
#[derive(Default)]
pub(super) struct Stop(Option<Vec<u8>>);

impl Monitor for Stop {
    fn look(&mut self, _: f64) -> Wish {
        Wish::Stop
    }

    fn save(&mut self, state: Vec<u8>) {
        self.0 = Some(state);
    }
}

/// A block on a base that weakens with slip and remembers the normal stress.
fn sliding() -> Result<Scene, Error> {
    let scene = crate::scenes::built_in("block-weakens")?
        .edited(|scene| scene.base = scene.base.map(|base| Base { memory: 0.02, ..base }))?;
    let end = 0.2;
    Ok(scene.edited(|scene| {
        scene.stages[0].until = Until::Time(end);
        (scene.observe_times, scene.history) = ([0.2, 0.4, 0.6, 0.8, 1.0].map(|share| share * end).to_vec(), 0);
    })?)
}

/// Comparison of a levee from where it begins to slide, and after it was taken up.
const LOOKS: usize = 6;

fn levee(goes_on: bool) -> Result<Outcome, Error> {
    let scene = super::reduced_strength::levee(&[
        ("hydraulic_conductivity = 4.5e-5", "hydraulic_conductivity = 9.0e-4"),
        ("until.time = 64800.0", "until.time = 6480.0"),
        ("slip_distance = 0.02", "slip_distance = 0.02\nmemory = 0.05"),
    ])?;
    let on = |driver: &mut Driver, looks: usize| (0..looks).try_for_each(|_| driver.advance(f64::INFINITY));
    let mut whole = Driver::new(&scene)?;
    while whole.phase != Phase::Failing {
        if whole.end.is_some() {
            return Err(Unfit("a levee that does not fail"));
        }
        on(&mut whole, 1)?;
    }
    let mut states = vec![whole.checkpoint()];
    on(&mut whole, LOOKS)?;
    states.push(whole.checkpoint());
    on(&mut whole, LOOKS)?;
    let mut different = Vec::new();
    for (number, state) in states.into_iter().enumerate() {
        let mut other = Driver::new(&scene)?;
        other.restore(&state)?;
        on(&mut other, (2 - number) * LOOKS + usize::from(goes_on))?;
        different.push(f64::from(other.checkpoint() != whole.checkpoint()));
    }
    Ok(outcome("staggered", &different))
}

fn resumed(loses: bool) -> Result<Outcome, Error> {
    let mut different = Vec::new();
    for scene in scenes()?.into_iter().chain([sliding()?]) {
        let one = whole(run_on(&Hardware::default(), &scene, &mut |_| {}))?;
        let (mut state, mut states) = (None, Vec::new());
        let mut last = loop {
            let mut stop = Stop::default();
            let run = run_monitored(&Hardware::default(), &scene, state.as_deref(), &mut stop)?;
            if !run.stopped {
                break run;
            }
            state = stop.0;
            states.extend(state.clone());
            if states.len() > 1000 {
                return Err(Unfit("a run that does not end"));
            }
        };
        if loses {
            last.samples.pop();
        }
        different.push(f64::from(said(&last) != said(&one)));
    }
    Ok(outcome("all", &different))
}

/// The share of runs that differ.
fn outcome(integrator: &str, different: &[f64]) -> Outcome {
    let share = different.iter().sum::<f64>() / different.len() as f64;
    Outcome {
        integrator: integrator.to_owned(),
        scheme: "all".to_owned(),
        errors: vec![(different.len() as f64, share)],
        required_error: 0.0,
        refined_by: RUNS,
        ..Outcome::default()
    }
}

//! Time: stages one after the other, steps that end exactly at the times to observe.

use serde::Serialize;

use crate::error::RunError;
use crate::observe::{Ledger, Observation, Places};
use crate::scene::{Clock, Integrator, Scene, Until};
use crate::stability::stable_limit;
use crate::step::{Fault, Model, Work};

/// The state at a time that was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Index of the stage.
    pub stage: usize,
    /// Time since the start of that stage, s.
    pub stage_time: f64,
    /// Steps done since the start of the run.
    pub step: u64,
    /// Whether the time is one of [`Scene::observe_times`].
    pub observed: bool,
    /// The state.
    pub state: Observation,
    /// Its balances.
    pub ledger: Ledger,
}

/// How a stage went.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageRecord {
    /// Its name.
    pub name: String,
    /// How long it lasted, s.
    pub duration_s: f64,
    /// Its steps.
    pub steps: u64,
}

/// A run, as far as it came.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Samples in the order of time.
    pub samples: Vec<Sample>,
    /// Stages that were entered.
    pub stages: Vec<StageRecord>,
    /// Largest time step that was asked for, s.
    pub dt: f64,
    /// Steps done.
    pub steps: u64,
    /// Work of the linear solver; nothing for an explicit run.
    pub work: Work,
    /// Solid particles.
    pub solid_particles: usize,
    /// Bytes held by particles and mesh.
    pub bytes: usize,
    /// Where the particles were at the end.
    pub places: Places,
    /// Why the run ended early, if it did.
    pub failure: Option<RunError>,
}

impl Run {
    /// Samples at the observed times of the last stage.
    pub fn observed(&self) -> impl Iterator<Item = &Sample> {
        self.samples.iter().filter(|s| s.observed)
    }
}

/// How often the end of a pore-pressure stage, or of one that ends by rest, is looked for, steps.
const STEPS_BETWEEN_LOOKS: u64 = 8;
/// So many looks in a row must find the soil at rest: a swing that turns is slow only for a moment.
const LOOKS_AT_REST: u32 = 25;
/// A run is unstable when this share of its energy comes from nowhere; sound runs stay below a hundredth. The other
/// sign is no fault: particles lose what the mesh cannot hold, all of a shock with one particle per cell.
const FROM_NOWHERE: f64 = 0.5;
/// Energy below this share of what the loads would store is round-off.
const ROUND_OFF: f64 = 1e-9;
/// Shortest history time as a share of the whole, for the logarithmic spacing.
const FIRST_HISTORY: f64 = 1e-4;

/// Runs a model through the stages of a scene with steps of at most `dt` (s), reporting progress in [0, 1].
pub fn drive(scene: &Scene, model: &mut dyn Model, dt: f64, progress: &mut dyn FnMut(f64)) -> Run {
    let mut run = Run {
        samples: Vec::new(),
        stages: Vec::new(),
        dt,
        steps: 0,
        work: Work::default(),
        solid_particles: model.solid_count(),
        bytes: model.bytes(),
        places: Places::default(),
        failure: None,
    };
    for (number, stage) in scene.stages.iter().enumerate() {
        let first_step = run.steps;
        let times = match stage.until {
            Until::Time(end) => times(scene, number + 1 == scene.stages.len(), end),
            Until::PorePressure { .. } | Until::Rest { .. } => Vec::new(),
        };
        let stops: Vec<f64> = times.iter().map(|(time, _)| *time).collect();
        // Water that seeps divides the time itself.
        let dt =
            if scene.integrator == Integrator::TwoClocks && stage.clock == Clock::Seepage { f64::INFINITY } else { dt };
        let entered = model.enter_stage(stage, &stops);
        run.bytes = run.bytes.max(model.bytes());
        let outcome = match stage.until {
            _ if entered.is_err() => entered.map(|()| 0.0).map_err(|fault| (0.0, fault)),
            Until::Time(_) => timed((scene, number), &times, model, dt, &mut run, progress),
            Until::PorePressure { within, everywhere, at_most } => {
                let target = scene.undrained_mean_pressure();
                let speed = ((scene.oedometer_modulus() + scene.pore_stiffness()) / scene.mixture_density()).sqrt();
                let goal = Goal { target, within, everywhere, at_most, period: 4.0 * scene.height / speed };
                until_pressure(number, &goal, model, dt, &mut run)
            }
            Until::Rest { speed, at_most } => until_rest(number, speed, at_most, model, dt, &mut run),
        };
        let (duration_s, fault) = match outcome {
            Ok(duration) => (duration, None),
            Err((duration, fault)) => (duration, Some(fault)),
        };
        run.work = model.work();
        run.stages.push(StageRecord { name: stage.name.clone(), duration_s, steps: run.steps - first_step });
        if let Some(fault) = fault {
            let time = run.stages.iter().map(|s| s.duration_s).sum();
            let limit = stable_limit(scene);
            let hint = if dt.is_finite() && dt > limit {
                format!("; the step {dt:.3e} s is above its limit {limit:.3e} s")
            } else {
                String::new()
            };
            run.failure = Some(RunError { step: run.steps, time, place: fault.place, what: fault.what + &hint });
            break;
        }
    }
    run.places = model.places();
    run
}

/// Times to stop at in a stage, with whether each is observed: those of the scene and its history in the last one.
fn times(scene: &Scene, last: bool, end: f64) -> Vec<(f64, bool)> {
    if !last {
        return vec![(end, false)];
    }
    let mut times: Vec<(f64, bool)> = scene.observe_times.iter().map(|t| (*t, true)).collect();
    let share = |i: usize| (i + 1) as f64 / scene.history as f64;
    times.extend((0..scene.history).map(|i| (end * FIRST_HISTORY.powf(1.0 - share(i)), false)));
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Where both lists have the same time, the observed one stays.
    times.dedup_by(|later, kept| {
        let same = later.0 - kept.0 <= 1e-9 * end;
        if same && later.1 {
            *kept = *later;
        }
        same
    });
    times
}

type Outcome = Result<f64, (f64, Fault)>;

fn timed(
    (scene, stage): (&Scene, usize),
    times: &[(f64, bool)],
    model: &mut dyn Model,
    dt: f64,
    run: &mut Run,
    progress: &mut dyn FnMut(f64),
) -> Outcome {
    let end = times[times.len() - 1].0;
    sample(stage, 0.0, false, model, run);
    let mut now = 0.0;
    for &(time, observed) in times {
        let span = time - now;
        // Equal steps that end exactly at the time; a hair above a whole number of steps is round-off.
        let steps = (span / dt - 1e-6).ceil().max(1.0) as u64;
        let step = span / steps as f64;
        let mut left = steps;
        while left > 0 {
            let some = left.min(1 << 14);
            let (mut done, before) = (0, model.time());
            let result = model.advance(step, some, &mut done);
            run.steps += done;
            let here = if dt.is_finite() {
                left -= done;
                time - left as f64 * step
            } else {
                left = 0;
                now + model.time() - before
            };
            result.map_err(|fault| (here, fault))?;
            progress(here / end);
        }
        now = time;
        sample(stage, time, observed, model, run);
        sane(scene, &run.samples[run.samples.len() - 1]).map_err(|fault| (now, fault))?;
    }
    Ok(end)
}

/// Stops a run whose state cannot be: not a number, turned inside out, or with energy from nowhere.
fn sane(scene: &Scene, sample: &Sample) -> Result<(), Fault> {
    let (state, l) = (&sample.state, &sample.ledger);
    let fault = |what| Err(Fault { place: "the whole column".to_owned(), what });
    if !(state.settlement.is_finite() && state.mean_pressure.is_finite()) {
        return fault(format!("settlement {} m, mean pore pressure {} Pa", state.settlement, state.mean_pressure));
    }
    if state.least_volume <= 0.0 {
        return fault(format!("a particle with a volume of {:.3e} m3", state.least_volume));
    }
    let stored = l.kinetic_j + l.strain_j + l.water_j;
    let booked = l.external_work_j.abs() + l.gravity_work_j.abs() + l.flow_body_work_j.abs();
    // What load and weight would store drained; round-off of a soil that nothing moves is far below.
    let stress = scene.surcharge.map_or(0.0, |s| s.pressure.abs())
        + scene.gravity.unwrap_or(0.0) * scene.mixture_density() * scene.height;
    let softest = scene.layers.iter().map(|layer| layer.elastic.oedometer_modulus());
    let modulus = softest.fold(scene.oedometer_modulus(), f64::min);
    let whole = stress * stress / modulus * scene.height * scene.width;
    if l.energy_closing_j > FROM_NOWHERE * (stored - l.energy_closing_j).abs().max(booked).max(ROUND_OFF * whole) {
        return fault(format!("{:.3e} J that no work explains, {stored:.3e} J in all", l.energy_closing_j));
    }
    Ok(())
}

struct Goal {
    target: f64,
    within: f64,
    everywhere: bool,
    at_most: f64,
    /// Period of the undrained wave, s: the goal must hold that long, or it was only passed through.
    period: f64,
}

fn until_pressure(stage: usize, goal: &Goal, model: &mut dyn Model, dt: f64, run: &mut Run) -> Outcome {
    sample(stage, 0.0, false, model, run);
    let (mut time, mut reached) = (0.0, f64::INFINITY);
    loop {
        let mut done = 0;
        let result = model.advance(dt, STEPS_BETWEEN_LOOKS, &mut done);
        run.steps += done;
        time += done as f64 * dt;
        result.map_err(|fault| (time, fault))?;
        let off = |p: f64| (p / goal.target - 1.0).abs();
        let [mean, low, high] = model.pore_pressure();
        let worst = if goal.everywhere { off(low).max(off(high)) } else { off(mean) };
        reached = if worst <= goal.within { time.min(reached) } else { f64::INFINITY };
        if time - reached >= goal.period {
            sample(stage, time, false, model, run);
            return Ok(time);
        }
        if time > goal.at_most || worst.is_nan() {
            let what = format!(
                "pore pressure {mean:.6e} Pa on average ({low:.3e} to {high:.3e}), expected {:.6e} Pa within {} after at most {:.3e} s; damping helps",
                goal.target, goal.within, goal.at_most
            );
            return Err((time, Fault { place: "the whole column".to_owned(), what }));
        }
    }
}

fn until_rest(stage: usize, speed: f64, at_most: f64, model: &mut dyn Model, dt: f64, run: &mut Run) -> Outcome {
    sample(stage, 0.0, false, model, run);
    let (mut time, mut looks) = (0.0, 0);
    while looks < LOOKS_AT_REST {
        let mut done = 0;
        let result = model.advance(dt, STEPS_BETWEEN_LOOKS, &mut done);
        run.steps += done;
        time += done as f64 * dt;
        result.map_err(|fault| (time, fault))?;
        let fastest = model.grid_speed();
        looks = if fastest <= speed { looks + 1 } else { 0 };
        if time > at_most || fastest.is_nan() {
            let what = format!(
                "a node moves at {fastest:.3e} m/s, expected at most {speed:.1e} m/s after at most {at_most:.3e} s; damping helps"
            );
            return Err((time, Fault { place: "the whole soil".to_owned(), what }));
        }
    }
    sample(stage, time, false, model, run);
    Ok(time)
}

fn sample(stage: usize, stage_time: f64, observed: bool, model: &dyn Model, run: &mut Run) {
    let (state, ledger) = (model.observe(), model.ledger());
    run.samples.push(Sample { stage, stage_time, step: run.steps, observed, state, ledger });
}

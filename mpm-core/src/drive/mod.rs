//! Time: stages one after the other, steps that end exactly at the times to observe; states from which a run resumes.

mod checkpoint;
mod monitor;

pub use monitor::{Alone, Monitor, Wish};

use serde::{Deserialize, Serialize};

use crate::error::RunError;
use crate::observe::{Balance, BalanceTerms, Observation, Places, Trust, balances};
use crate::order::sort_by_number;
use crate::scene::{Coupling, Integrator, Scene, Stage, Until};
use crate::stability::stable_limit;
use crate::step::{Fault, Model, Work};

/// The state at a time that was asked for.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Index of the stage.
    pub stage: usize,
    /// Time since the start of that stage, s.
    pub stage_time: f64,
    /// Steps done since the start of the run.
    pub step: u64,
    /// Whether the time is one of [`crate::scene::Fields::observe_times`].
    pub observed: bool,
    /// The state.
    pub state: Observation,
    /// Its balances.
    pub balance: BalanceTerms,
}

/// How a stage went.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StageRecord {
    /// Its name.
    pub name: String,
    /// How long it lasted, s.
    pub duration_s: f64,
    /// Its steps.
    pub steps: u64,
}

/// A run, as far as it came.
#[derive(Debug, Clone, Default, PartialEq)]
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
    /// Where the solid particles were at t = 0, m: x and y, in the order of [`Places::solid`].
    pub starts: Vec<[f64; 2]>,
    /// Where the particles were at the end.
    pub places: Places,
    /// Whether the balances closed; nothing before the first sample.
    pub trust: Option<Trust>,
    /// Why the run ended early, if it did.
    pub failure: Option<RunError>,
    /// Whether it was stopped on its way, because that was requested.
    pub stopped: bool,
}

impl Run {
    /// Samples at the observed times of the last stage.
    pub fn observed(&self) -> impl Iterator<Item = &Sample> {
        self.samples.iter().filter(|s| s.observed)
    }

    /// The run, if it did not fail.
    ///
    /// # Errors
    /// Why it ended early.
    pub fn whole(mut self) -> Result<Self, RunError> {
        self.failure.take().map_or(Ok(self), Err)
    }
}

/// How often the end of a pore-pressure stage, or of one that ends by rest, is checked for, steps.
const STEPS_BETWEEN_LOOKS: u64 = 8;
/// Steps between two checks of the balances, which also follow every sample: to read a state costs some twenty steps.
const STEPS_BETWEEN_BALANCES: u64 = 2048;
/// So many samples in a row have to find the soil at rest: an oscillation is slow at its turning points.
const LOOKS_AT_REST: u64 = 25;
/// A run is unstable when this share of its energy comes from nowhere; sound runs stay below a hundredth. The other
/// sign is no fault: particles lose what the mesh cannot hold, all of a shock with one particle per cell.
const FROM_NOWHERE: f64 = 0.5;
/// Energy below this share of what the loads would store is round-off.
const ROUND_OFF: f64 = 1e-9;
/// Particle steps between two requests to the monitor: some hundredths of a second.
const POINT_STEPS_AT_ONCE: usize = 1 << 22;
/// Shortest history time as a share of the whole, for the logarithmic spacing.
const FIRST_HISTORY: f64 = 1e-4;

/// Runs a model through the stages of a scene with steps of at most `dt` (s), reporting progress in [0, 1].
pub fn drive(scene: &Scene, model: &mut dyn Model, dt: f64, progress: &mut dyn FnMut(f64)) -> Run {
    Drive::new(scene, model, dt).go(&mut Alone(progress))
}

/// A run on its way through the stages of its scene.
pub struct Drive<'a> {
    scene: &'a Scene,
    model: &'a mut dyn Model,
    run: Run,
    at: At,
    /// Whether a balance residual beyond its bound ends the run.
    watched: bool,
}

/// Where in its stage a run is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct At {
    /// Number of the stage, and whether it was entered.
    stage: u64,
    entered: bool,
    /// Steps when it was.
    first_step: u64,
    /// Of a stage of a given length: number of the time that is next, the one before it (s), and the steps of `step` (s) left
    /// until then.
    next: u64,
    now: f64,
    left: u64,
    step: f64,
    /// Of a stage that waits for something: time in it, since when it is there (s), and samples that have found it so.
    time: f64,
    reached: f64,
    looks: u64,
}

/// Why a stage did not come to its end.
enum Halt {
    /// Something went wrong, at a time in the stage, s.
    Fault(f64, Fault),
    /// It was to stop.
    Wished,
}

impl<'a> Drive<'a> {
    /// A run at t = 0 with steps of at most `dt` (s).
    pub fn new(scene: &'a Scene, model: &'a mut dyn Model, dt: f64) -> Self {
        let run = Run {
            samples: Vec::new(),
            stages: Vec::new(),
            dt,
            steps: 0,
            work: Work::default(),
            solid_particles: model.solid_count(),
            bytes: model.bytes(),
            starts: model.places().solid.iter().map(|[x, y, _]| [*x, *y]).collect(),
            places: Places::default(),
            trust: None,
            failure: None,
            stopped: false,
        };
        Self { scene, model, run, at: At::default(), watched: true }
    }

    /// Goes on to the end, to a failure, or until it is to stop.
    pub fn go(mut self, monitor: &mut dyn Monitor) -> Run {
        if self.run.samples.is_empty() {
            monitor.observed(&*self.model, 0.0);
        }
        while let Some(stage) = self.scene.stages.get(self.at.stage as usize) {
            let last = self.at.stage as usize + 1 == self.scene.stages.len();
            let times = match stage.until {
                Until::Time(end) => times(self.scene, last, end),
                Until::PorePressure { .. } | Until::Rest { .. } => Vec::new(),
            };
            let outcome = self.enter(stage, &times).and_then(|()| self.through(stage, &times, monitor));
            self.run.work = self.model.work();
            let (duration_s, fault) = match outcome {
                Ok(duration) => (duration, None),
                Err(Halt::Fault(duration, fault)) => (duration, Some(fault)),
                Err(Halt::Wished) => {
                    self.run.stopped = true;
                    break;
                }
            };
            let steps = self.run.steps - self.at.first_step;
            self.run.stages.push(StageRecord { name: stage.name.clone(), duration_s, steps });
            if let Some(fault) = fault {
                self.fail(fault, self.length_of_steps(stage));
                break;
            }
            self.at = At { stage: self.at.stage + 1, ..At::default() };
        }
        self.run.places = self.model.places();
        if !self.run.stopped {
            monitor.ended(&*self.model);
        }
        if self.watched {
            let samples = self.run.samples.iter().map(|s| (s.step, &s.state, &s.balance));
            self.run.trust = Trust::of(self.scene, self.run.dt, samples);
        }
        self.run
    }

    /// The same without the net of balances: for fields that a scene has no words for, and its bounds do not know.
    pub fn unwatched(self) -> Self {
        Self { watched: false, ..self }
    }

    /// Checks the balances from time to time, the last time at the step `before`. What is not closed is kept, as
    /// the last sample.
    fn watch(&mut self, before: u64, time: f64) -> Result<(), Halt> {
        if before / STEPS_BETWEEN_BALANCES == self.run.steps / STEPS_BETWEEN_BALANCES {
            return Ok(());
        }
        let sample = self.seen(time, false);
        let closed = self.closed(&sample);
        if closed.is_err() {
            self.run.samples.push(sample);
        }
        closed
    }

    /// A run ends where a balance residual exceeds its bound; a forced run continues.
    fn closed(&self, sample: &Sample) -> Result<(), Halt> {
        if !self.watched || self.scene.force {
            return Ok(());
        }
        let Sample { step, state, balance, stage_time: time, .. } = sample;
        let open = balances(self.scene, self.run.dt, *step, state, balance);
        let Some(open) = open.iter().find(|balance| !balance.closes()) else { return Ok(()) };
        let Balance { name, gap, allowed, unit } = open;
        let what = format!(
            "residual {gap:.3e} {unit} exceeds its bound of {allowed:.3e} {unit}; the results from here on are not to be \
             trusted. A finer mesh, more particles or integrator = \"quasi-static\" may help; --force continues"
        );
        Err(Halt::Fault(*time, Fault { place: format!("the balance of {name}"), what }))
    }

    /// Steps of a stage, s; infinite where the model divides the time itself.
    fn length_of_steps(&self, stage: &Stage) -> f64 {
        let seeps = self.scene.integrator == Integrator::Staggered && stage.coupling == Coupling::Seepage;
        if seeps { f64::INFINITY } else { self.run.dt }
    }

    fn enter(&mut self, stage: &Stage, times: &[(f64, bool)]) -> Result<(), Halt> {
        if self.at.entered {
            return Ok(());
        }
        self.at.first_step = self.run.steps;
        let stops: Vec<f64> = times.iter().map(|(time, _)| *time).collect();
        let entered = self.model.enter_stage(stage, &stops);
        self.run.bytes = self.run.bytes.max(self.model.bytes());
        entered.map_err(|fault| Halt::Fault(0.0, fault))?;
        self.at.reached = f64::INFINITY;
        let sample = self.seen(0.0, false);
        // A run that solves for displacements begins before it is in equilibrium.
        let closed = if self.at.stage > 0 { self.closed(&sample) } else { Ok(()) };
        self.run.samples.push(sample);
        closed?;
        self.at.entered = true;
        Ok(())
    }

    fn through(&mut self, stage: &Stage, times: &[(f64, bool)], monitor: &mut dyn Monitor) -> Result<f64, Halt> {
        let (scene, dt) = (self.scene, self.length_of_steps(stage));
        match stage.until {
            Until::Time(_) => self.timed(times, dt, monitor),
            Until::PorePressure { within, everywhere, at_most } => {
                let target = scene.undrained_mean_pressure();
                let speed = ((scene.oedometer_modulus() + scene.pore_stiffness()) / scene.mixture_density()).sqrt();
                let goal = Goal { target, within, everywhere, at_most, period: 4.0 * scene.height / speed };
                self.until_pressure(&goal, dt, monitor)
            }
            Until::Rest { speed, at_most } => self.until_rest(speed, at_most, dt, monitor),
        }
    }

    fn fail(&mut self, fault: Fault, dt: f64) {
        let time = self.run.stages.iter().map(|s| s.duration_s).sum();
        let limit = stable_limit(self.scene);
        let hint = if dt.is_finite() && dt > limit {
            format!("; the step {dt:.3e} s is above its limit {limit:.3e} s")
        } else {
            String::new()
        };
        let step = self.run.steps;
        self.run.failure = Some(RunError { step, time, place: fault.place, what: fault.what + &hint });
    }

    /// Asks the monitor for requests, at a completed share of the stage.
    fn monitor(&mut self, share: f64, monitor: &mut dyn Monitor) -> Result<(), Halt> {
        match monitor.look(share) {
            Wish::GoOn => Ok(()),
            Wish::Save => {
                monitor.save(self.checkpoint());
                Ok(())
            }
            Wish::Stop => {
                monitor.save(self.checkpoint());
                Err(Halt::Wished)
            }
        }
    }

    fn timed(&mut self, times: &[(f64, bool)], dt: f64, monitor: &mut dyn Monitor) -> Result<f64, Halt> {
        let end = times[times.len() - 1].0;
        let some = steps_at_once(self.run.solid_particles);
        while let Some(&(time, observed)) = times.get(self.at.next as usize) {
            if self.at.left == 0 {
                let span = time - self.at.now;
                // Equal steps that end exactly at the time; slightly more than a whole number of steps is round-off.
                self.at.left = (span / dt - 1e-6).ceil().max(1.0) as u64;
                self.at.step = span / self.at.left as f64;
            }
            while self.at.left > 0 {
                let step = self.at.step;
                let (mut done, before, first) = (0, self.model.time(), self.run.steps);
                let result = self.model.advance(step, self.at.left.min(some), &mut done);
                self.run.steps += done;
                let here = if dt.is_finite() {
                    self.at.left -= done;
                    time - self.at.left as f64 * step
                } else {
                    self.at.step = self.model.left();
                    self.at.left = u64::from(self.at.step > 0.0);
                    self.at.now += self.model.time() - before;
                    self.at.now
                };
                result.map_err(|fault| Halt::Fault(here, fault))?;
                if self.at.left > 0 {
                    self.watch(first, here)?;
                    self.monitor(here / end, monitor)?;
                }
            }
            self.at.now = time;
            self.at.next += 1;
            self.sample(time, observed)?;
            if let (true, Some(sample)) = (observed, self.run.samples.last()) {
                monitor.observed(&*self.model, sample.state.time);
            }
            self.monitor(time / end, monitor)?;
        }
        Ok(end)
    }

    /// Some steps of a stage that waits for something.
    fn some_steps(&mut self, dt: f64) -> Result<(), Halt> {
        let (mut done, before) = (0, self.run.steps);
        let result = self.model.advance(dt, STEPS_BETWEEN_LOOKS, &mut done);
        self.run.steps += done;
        self.at.time += done as f64 * dt;
        result.map_err(|fault| Halt::Fault(self.at.time, fault))?;
        self.watch(before, self.at.time)
    }

    fn until_pressure(&mut self, goal: &Goal, dt: f64, monitor: &mut dyn Monitor) -> Result<f64, Halt> {
        loop {
            self.some_steps(dt)?;
            let time = self.at.time;
            let off = |p: f64| (p / goal.target - 1.0).abs();
            let [mean, low, high] = self.model.pore_pressure();
            let worst = if goal.everywhere { off(low).max(off(high)) } else { off(mean) };
            self.at.reached = if worst <= goal.within { time.min(self.at.reached) } else { f64::INFINITY };
            if time - self.at.reached >= goal.period {
                self.sample(time, false)?;
                return Ok(time);
            }
            if time > goal.at_most || worst.is_nan() {
                let what = format!(
                    "pore pressure {mean:.6e} Pa on average ({low:.3e} to {high:.3e}), expected {:.6e} Pa within {} after at most {:.3e} s; damping helps",
                    goal.target, goal.within, goal.at_most
                );
                return Err(Halt::Fault(time, Fault { place: "the whole column".to_owned(), what }));
            }
            self.monitor(0.0, monitor)?;
        }
    }

    fn until_rest(&mut self, speed: f64, at_most: f64, dt: f64, monitor: &mut dyn Monitor) -> Result<f64, Halt> {
        while self.at.looks < LOOKS_AT_REST {
            self.some_steps(dt)?;
            let (time, fastest) = (self.at.time, self.model.grid_speed());
            self.at.looks = if fastest <= speed { self.at.looks + 1 } else { 0 };
            if time > at_most || fastest.is_nan() {
                let what = format!(
                    "a node moves at {fastest:.3e} m/s, expected at most {speed:.1e} m/s after at most {at_most:.3e} s; damping helps"
                );
                return Err(Halt::Fault(time, Fault { place: "the whole soil".to_owned(), what }));
            }
            self.monitor(0.0, monitor)?;
        }
        self.sample(self.at.time, false)?;
        Ok(self.at.time)
    }

    /// Keeps the state, whether it can be or not.
    fn sample(&mut self, stage_time: f64, observed: bool) -> Result<(), Halt> {
        let sample = self.seen(stage_time, observed);
        let closed = self.closed(&sample);
        let first = self.run.samples.first().unwrap_or(&sample).balance;
        let sane = sane(self.scene, &first, &sample).map_err(|fault| Halt::Fault(stage_time, fault));
        self.run.samples.push(sample);
        closed.and(sane)
    }

    fn seen(&self, stage_time: f64, observed: bool) -> Sample {
        let (state, balance) = self.model.observe();
        Sample { stage: self.at.stage as usize, stage_time, step: self.run.steps, observed, state, balance }
    }
}

/// Times to stop at in a stage, with whether each is observed: those of the scene and its history in the last one.
fn times(scene: &Scene, last: bool, end: f64) -> Vec<(f64, bool)> {
    if !last {
        return vec![(end, false)];
    }
    let mut times: Vec<(f64, bool)> = scene.observe_times.iter().map(|t| (*t, true)).collect();
    let share = |i: usize| (i + 1) as f64 / scene.history as f64;
    times.extend((0..scene.history).map(|i| (end * FIRST_HISTORY.powf(1.0 - share(i)), false)));
    sort_by_number(&mut times, |(time, _)| *time);
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

/// Stops a run whose state cannot be: not a number, an inverted element, or energy that no work explains.
fn sane(scene: &Scene, first: &BalanceTerms, sample: &Sample) -> Result<(), Fault> {
    let (state, l) = (&sample.state, &sample.balance);
    let fault = |what| Err(Fault { place: "the whole column".to_owned(), what });
    if !(state.settlement.is_finite() && state.mean_pressure.is_finite()) {
        return fault(format!("settlement {} m, mean pore pressure {} Pa", state.settlement, state.mean_pressure));
    }
    if state.least_volume <= 0.0 {
        return fault(format!("a particle with a volume of {:.3e} m3", state.least_volume));
    }
    let [at_first, stored] = [first, l].map(|l| l.kinetic_j + l.strain_j + l.water_j);
    let booked = l.external_work_j.abs() + l.gravity_work_j.abs() + l.flow_body_work_j.abs() + at_first.abs();
    // What load and weight would store drained; round-off of a soil that nothing moves is far below.
    let stress = scene.largest_load() + scene.gravity.unwrap_or(0.0) * scene.mixture_density() * scene.height;
    let modulus = scene.each_soil().map(|soil| soil.elastic.oedometer_modulus()).fold(f64::INFINITY, f64::min);
    let whole = stress * stress / modulus * scene.height * scene.width;
    // What particles hold, less all work: the mapping, which takes energy, has no entry here.
    let gained = l.energy_residual_j - l.transfer_loss_j;
    if gained > FROM_NOWHERE * (stored - gained).abs().max(booked).max(ROUND_OFF * whole) {
        return fault(format!("{gained:.3e} J that no work explains, {stored:.3e} J in all"));
    }
    Ok(())
}

/// Steps of so many particles between two samples.
fn steps_at_once(particles: usize) -> u64 {
    (POINT_STEPS_AT_ONCE / particles.max(1)).clamp(1, 1 << 14) as u64
}

struct Goal {
    target: f64,
    within: f64,
    everywhere: bool,
    at_most: f64,
    /// Period of the undrained wave, s: the goal must hold that long, or it was only passed through.
    period: f64,
}

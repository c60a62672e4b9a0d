//! Soil that fails under water: gravity, the first water, hours of seepage, seconds of failure, and the final shape.
//!
//! Staggered, water seeps through soil at rest, then the soil is brought to rest under the pressures (`equilibrate`). If it
//! does not come to rest it fails: it moves without damping, with pressures that follow, until it rests again. The
//! other drivers run soil and water in the same steps all the time.

mod equilibrate;
mod events;
mod record;
mod scales;
mod strength;

pub use equilibrate::{Equilibrated, Outcome, Patience, equilibrate};
pub use events::{First, Moved, Which, towards};
pub use record::{Events, PathPoint, Row};
pub use scales::Scales;
pub use strength::{Bracket, Found, Search, Sliding, Trial, Trials, bracket};
use strength::{RANGE, go_back};

use serde::{Deserialize, Serialize};

use crate::checkpoint::{Archive, RestoreError, archive, restore, save, sealed, unsealed};
use crate::constitutive::Altered;
use crate::error::RunError;
use crate::hash::{Digest, sha256};
use crate::observe::Frame;
use crate::run::{StartError, failing};
use crate::scene::{Failure, Fields, Integrator, Reduction, Scene, StepChoice, Until};
use crate::stability::choose_step;
use crate::step::{Failing, Fault, Pace};
use crate::water::Pressures;

/// If soil fails within a longer time of seepage than the first, that is taken back and a share of it tried.
const SOONER: f64 = 0.25;
/// Periods of its first swing within which soil settles easily, and above which the next sample comes sooner.
const EASY: [f64; 2] = [1.1, 4.4];
/// Parts in which the first water comes.
const RAMP: u32 = 10;
/// Who can drive a run.
const DRIVERS: [Integrator; 3] = [Integrator::Staggered, Integrator::Coupled, Integrator::Explicit];

/// What is going on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Gravity and the first water come.
    #[default]
    Gravity,
    /// Water seeps, soil rests.
    Seepage,
    /// Soil comes to rest under new pressures.
    Relaxing,
    /// Soil moves.
    Failing,
    /// Soil and water run together.
    Together,
    /// It is over.
    Ended,
}

/// Why a run is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// It collapsed and came to rest.
    Collapsed,
    /// The time of the scene was over.
    TimeOver,
}

/// Steps of each kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Steps {
    /// Of the water.
    pub seepage: u64,
    /// Of soil that comes to rest.
    pub relaxing: u64,
    /// Of soil that moves with its water.
    pub moving: u64,
}

impl Steps {
    /// All of them.
    pub fn all(&self) -> u64 {
        self.seepage + self.relaxing + self.moving
    }
}

/// A run.
pub struct Driver<'a> {
    scene: &'a Scene,
    failure: Failure,
    model: Box<dyn Failing>,
    outline: Vec<[f64; 2]>,
    scales: Scales,
    first: First,
    /// Step of the soil, s.
    pub dt: f64,
    /// Time since the water began to seep, s.
    pub time: f64,
    /// What is going on.
    pub phase: Phase,
    /// Why it is over.
    pub end: Option<End>,
    /// Steps so far.
    pub steps: Steps,
    /// Events so far.
    pub events: Events,
    /// The history.
    pub rows: Vec<Row>,
    /// Stresses at the observed places.
    pub paths: Vec<PathPoint>,
    /// Next time of seepage, s.
    seepage: f64,
    /// Since when soil moves, and since when it has been slow, s.
    moves_since: f64,
    slow_since: f64,
    integrator: Integrator,
    /// Water when counting began, m3.
    began: f64,
}

impl std::fmt::Debug for Driver<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Driver").field("time", &self.time).field("phase", &self.phase).finish_non_exhaustive()
    }
}

impl<'a> Driver<'a> {
    /// A run before its first step.
    ///
    /// # Errors
    /// A step above the stability limit, particles outside the mesh, or a scene without a stage with `coupling = "full"`.
    pub fn new(scene: &'a Scene) -> Result<Self, StartError> {
        let Some(failure) = scene.failure.clone() else {
            return Err(StartError::Place(RunError {
                step: 0,
                time: 0.0,
                place: "the scene".into(),
                what: "no stage with coupling = \"full\"".into(),
            }));
        };
        let dt = choose_step(scene)?;
        let mut model = failing(scene)?;
        let fault = |f: Fault| StartError::Place(RunError { step: 0, time: 0.0, place: f.place, what: f.what });
        model.enter_stage(&scene.stages[0], &[]).map_err(fault)?;
        let outline = scene.outline_or_box();
        let scales = Scales::of(scene);
        let first = First::of(model.as_ref(), &outline, &failure.points, &scales);
        Ok(Self {
            scene,
            failure,
            model,
            outline,
            scales,
            first,
            dt,
            time: 0.0,
            phase: Phase::Gravity,
            end: None,
            steps: Steps::default(),
            events: Events::default(),
            rows: Vec::new(),
            paths: Vec::new(),
            seepage: scales.seepage()[1],
            moves_since: 0.0,
            slow_since: 0.0,
            integrator: scene.integrator,
            began: 0.0,
        })
    }

    /// For soil as it is, of which no more may move than E1 allows.
    fn patience(&self) -> Patience {
        let (slides, most) = ((Which::All, self.scales.elastic), self.scales.events()[0]);
        Patience { slides, most, ..Patience::of(&self.scales, self.dt).lightly_damped() }
    }

    /// Begins to count displacements and balances with the soil as it is.
    fn count_from_here(&mut self) {
        self.model.stop();
        self.model.count_from_here();
        self.first = First::of(self.model.as_ref(), &self.outline, &self.failure.points, &self.scales);
    }

    fn failed(&self, fault: Fault) -> RunError {
        RunError { step: self.steps.all(), time: self.time, place: fault.place, what: fault.what }
    }

    /// What the clock shows, h.
    pub fn hours(&self) -> f64 {
        (self.failure.starts_at + self.time) / 3600.0
    }

    /// Time at which the scene ends, s.
    pub fn ends_at(&self) -> f64 {
        match self.scene.stages[0].until {
            Until::Time(time) => time,
            Until::PorePressure { at_most, .. } | Until::Rest { at_most, .. } => at_most,
        }
    }

    /// Gravity and the first water, on a base that holds; then the base is left to its friction. Whether the soil stands.
    ///
    /// # Errors
    /// Where and what went wrong in a step, or soil that does not come to rest even on a base that holds it.
    pub fn load(&mut self) -> Result<Equilibrated, RunError> {
        let settled = self.bring_to_rest(1.0)?;
        if settled.at_rest() || self.failure.continue_if_unstable {
            self.begin(settled.at_rest());
        }
        Ok(settled)
    }

    /// The same with soil and base as strong as the lowest factor of safety that is looked for needs: a slope that does not stand has
    /// one, too. Whether even that stands.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_for_safety(&mut self) -> Result<Equilibrated, RunError> {
        let settled = self.bring_to_rest(RANGE[0])?;
        self.phase = Phase::Seepage;
        self.look();
        Ok(settled)
    }

    /// Brings the soil to rest with its strength divided by a factor. It is stiffened meanwhile: its shape under its weight is the
    /// one that was drawn.
    fn bring_to_rest(&mut self, factor: f64) -> Result<Equilibrated, RunError> {
        let patience = Patience::stiffened(&self.scales, self.dt);
        self.model.alter(&Altered { factor, by: Reduction::AsGiven, stiffness: self.scales.stiffening() });
        self.model.glue(true);
        self.count_from_here();
        for part in 0..=RAMP {
            self.model.feel(f64::from(part) / f64::from(RAMP));
            let settled = equilibrate(self.model.as_mut(), &self.first, &patience).map_err(|e| self.failed(e))?;
            self.steps.relaxing += settled.steps;
            if !settled.at_rest() && !self.failure.continue_if_unstable {
                let under = if part == 0 { "under its own weight" } else { "under its weight and the first water" };
                let what = format!("{under}, on a fixed base, the soil {}", settled.said());
                return Err(self.failed(Fault { place: "the slope".into(), what }));
            }
        }
        self.model.forget_slip();
        self.model.glue(false);
        self.count_from_here();
        // A toe may give way a little and hold: what does not stand slides.
        let settled = equilibrate(self.model.as_mut(), &self.first, &patience).map_err(|e| self.failed(e))?;
        self.steps.relaxing += settled.steps;
        self.model.alter(&Altered::NOTHING);
        self.model.forget_slip();
        self.count_from_here();
        let water = self.model.observe().0.water.map_or(0.0, |w| w.mobile_m3 - w.in_m3 + w.out_m3);
        self.began = water;
        Ok(settled)
    }

    fn first_water(&self) -> f64 {
        self.began
    }

    /// Starts the clock.
    fn begin(&mut self, at_rest: bool) {
        self.phase = match (self.integrator, at_rest) {
            (Integrator::Staggered, true) => Phase::Seepage,
            (Integrator::Staggered, false) => Phase::Failing,
            _ => Phase::Together,
        };
        if !at_rest {
            self.events.unsettled(self.hours());
        }
        self.look();
    }

    /// Goes on with another driver.
    pub fn drive_by(&mut self, integrator: Integrator, dt: f64) {
        self.integrator = integrator;
        self.dt = dt;
        if self.end.is_none() {
            self.phase = if integrator == Integrator::Staggered { Phase::Seepage } else { Phase::Together };
        }
        (self.moves_since, self.slow_since) = (self.time, self.time);
    }

    /// Advances by one sample: some time of seepage, or a moment of failure.
    ///
    /// # Errors
    /// Where and what went wrong, or soil that does not stand at the start; what was recorded so far stays.
    pub fn advance(&mut self, until: f64) -> Result<(), RunError> {
        match self.phase {
            Phase::Gravity => {
                let settled = self.load()?;
                if self.phase == Phase::Gravity {
                    let said = settled.said();
                    let what = format!(
                        "on its own base, under its weight and the first water, the soil is not stable: it {said}"
                    );
                    return Err(self.failed(Fault { place: "the slope".into(), what }));
                }
            }
            Phase::Ended => {}
            Phase::Seepage | Phase::Relaxing => self.seep(until)?,
            Phase::Failing | Phase::Together => self.run_soil(until)?,
        }
        Ok(())
    }

    /// Lets water seep until a time (s) while the soil is fixed: what a factor of safety at that time is asked of, whether or
    /// not the slope stands until then.
    ///
    /// # Errors
    /// Where and what went wrong.
    pub fn seep_only(&mut self, until: f64) -> Result<(), RunError> {
        if until <= self.time {
            return Ok(());
        }
        let mut done = 0;
        let outcome = self.model.seep(until - self.time, &mut done);
        self.steps.seepage += done;
        outcome.map_err(|e| self.failed(e))?;
        self.time = until;
        self.look();
        Ok(())
    }

    fn seep(&mut self, until: f64) -> Result<(), RunError> {
        // Time does not go back.
        let until = until.min(self.ends_at()).max(self.time);
        let left = until - self.time;
        let mut span = if self.seepage > 0.75 * left { left } else { self.seepage };
        let [shortest, soon, longest] = self.scales.seepage();
        let mut settled = self.seep_and_equilibrate(span, span > soon)?;
        while settled.is_none() {
            // It fails somewhere on the way: not so far at once.
            span = (SOONER * span).max(0.5 * soon);
            self.seepage = span;
            settled = self.seep_and_equilibrate(span, span > soon)?;
        }
        self.time = if span == left { until } else { self.time + span };
        let settled = settled.filter(Equilibrated::at_rest);
        if let Some(settled) = settled {
            self.model.stop();
            let periods = settled.steps as f64 * self.dt / self.scales.period;
            let factor = if periods <= EASY[0] {
                1.5
            } else if periods <= EASY[1] {
                1.0
            } else {
                0.5
            };
            self.seepage = (self.seepage * factor).clamp(shortest, longest);
            self.phase = Phase::Seepage;
        } else {
            self.phase = Phase::Failing;
            (self.moves_since, self.slow_since) = (self.time, self.time);
            self.events.unsettled(self.hours());
        }
        self.look();
        if self.time >= self.ends_at() && self.phase == Phase::Seepage {
            self.finish(End::TimeOver);
        }
        Ok(())
    }

    /// Some time of seepage (s), and the rest that the soil comes to. If it does not and that may be `undone`, the state is as it
    /// was, and there is nothing to tell.
    fn seep_and_equilibrate(&mut self, span: f64, undone: bool) -> Result<Option<Equilibrated>, RunError> {
        let before = undone.then(|| save(|archive| self.model.save_or_restore(archive)));
        self.phase = Phase::Seepage;
        let mut done = 0;
        let outcome = self.model.seep(span, &mut done);
        self.steps.seepage += done;
        outcome.map_err(|e| self.failed(e))?;
        self.phase = Phase::Relaxing;
        let patience = self.patience();
        let settled = equilibrate(self.model.as_mut(), &self.first, &patience).map_err(|e| self.failed(e))?;
        self.steps.relaxing += settled.steps;
        match before.filter(|_| !settled.at_rest()) {
            Some(before) => go_back(self.model.as_mut(), &before).map_err(|e| self.failed(e)).map(|()| None),
            None => Ok(Some(settled)),
        }
    }

    fn run_soil(&mut self, until: f64) -> Result<(), RunError> {
        let until = until.min(self.ends_at().max(self.time));
        let span = self.scales.look().min(until - self.time);
        let steps = ((span / self.dt).round() as u64).max(1);
        let pressures = if self.integrator == Integrator::Explicit { Pressures::Explicit } else { Pressures::Implicit };
        let pace = Pace { dt: self.dt, steps, damping: 0.0, pressures };
        let mut done = 0;
        let outcome = self.model.move_soil(&pace, &mut done);
        self.steps.moving += done;
        self.time += done as f64 * self.dt;
        outcome.map_err(|e| self.failed(e))?;
        let speed = self.model.grid_speed();
        if speed.is_nan() {
            let what = "a velocity that is not a number".to_owned();
            return Err(self.failed(Fault { place: "the whole soil".into(), what }));
        }
        let (slow, calm) = self.scales.rest();
        if speed > slow {
            self.slow_since = self.time;
        }
        self.look();
        let rests = self.time - self.slow_since >= calm;
        if rests && self.events.collapse_h.is_some() && !self.failure.continue_after_collapse {
            self.finish(End::Collapsed);
        } else if self.phase == Phase::Failing && (rests || self.time - self.moves_since > self.scales.longest()) {
            self.phase = Phase::Seepage;
            self.seepage = self.scales.seepage()[0];
            self.model.stop();
        }
        if self.time >= self.ends_at() && self.end.is_none() {
            self.finish(End::TimeOver);
        }
        Ok(())
    }

    fn finish(&mut self, end: End) {
        self.end = Some(end);
        self.phase = Phase::Ended;
        if let Some(row) = self.rows.last_mut() {
            row.phase = Phase::Ended;
        }
    }

    /// Records the state.
    fn look(&mut self) {
        let moved = self.first.moved(self.model.as_ref());
        let row = Row::of(self, &moved);
        self.events.note(&row, &moved, self.toe(), &self.scales, self.scene.cell);
        self.rows.push(row);
        record::paths(self.model.as_ref(), &self.first, self.hours(), &mut self.paths);
    }

    /// Where the toe was at the start, x in m, and its side.
    fn toe(&self) -> [f64; 2] {
        let side = towards(&self.outline);
        [self.outline.iter().map(|x| side * x[0]).fold(f64::NEG_INFINITY, f64::max) * side, side]
    }

    /// The free surface of the water (x, y), m, x increasing: above the middle of each column of cells of the soil.
    pub fn surface(&self) -> Vec<[f64; 2]> {
        let cell = self.scene.cell;
        let columns = (self.scene.width / cell).ceil() as usize;
        let middles = (0..columns).map(|column| (column as f64 + 0.5) * cell);
        middles.map(|x| [x, self.model.level(x)]).collect()
    }

    /// All there is to see.
    pub fn frame(&self) -> Frame {
        self.model.frame(self.failure.starts_at + self.time, self.steps.all())
    }

    /// Brackets the factor of safety of the state now; the run is left as it was.
    ///
    /// # Errors
    /// Where and what went wrong in a step.
    pub fn safety(&mut self, search: &Search, progress: &mut dyn FnMut(&Bracket, &Trial)) -> Result<Found, RunError> {
        let trials = Trials { outline: &self.outline, scales: self.scales, dt: self.dt };
        let found = bracket(self.model.as_mut(), &trials, search, progress);
        found.map_err(|e| self.failed(e))
    }

    /// The state, from which [`Self::restore`] resumes.
    pub fn checkpoint(&mut self) -> Vec<u8> {
        sealed(&save(|archive| self.save_or_restore(archive)), &self.fingerprint())
    }

    /// Restores a state of the same scene; the end of its stage, its integrator and its step may be others. It goes on by the
    /// driver it was saved with ([`Self::drive_by`] changes that).
    ///
    /// # Errors
    /// The bytes are not those of such a state. The run is then left as it was.
    pub fn restore(&mut self, checkpoint: &[u8]) -> Result<(), RestoreError> {
        let state = unsealed(checkpoint, &self.fingerprint())?;
        let before = save(|archive| self.save_or_restore(archive));
        let restored = restore(state, |archive| self.save_or_restore(archive));
        if restored.is_err() {
            // Bytes that are whole and of this scene fit, unless another version wrote them.
            restore(&before, |archive| self.save_or_restore(archive))?;
        }
        restored
    }

    /// Of all in the scene that a state depends on.
    fn fingerprint(&self) -> Digest {
        let mut scene = Fields::clone(self.scene);
        (scene.integrator, scene.step, scene.safety, scene.force) =
            (Integrator::Staggered, StepChoice::Auto, 1.0, false);
        (scene.observe_times, scene.history, scene.profiles) = (Vec::new(), 0, true);
        scene.left_out.clear();
        for stage in &mut scene.stages {
            stage.until = Until::Time(0.0);
        }
        if let Some(failure) = &mut scene.failure {
            (failure.continue_if_unstable, failure.continue_after_collapse) = (false, false);
        }
        sha256(format!("{scene:?}").as_bytes())
    }

    fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        self.first.save_or_restore(archive)?;
        self.model.save_or_restore(archive)?;
        archive.choice(&mut self.integrator, &DRIVERS)?;
        archive!(archive.value: self.dt, self.time, self.seepage, self.moves_since, self.slow_since, self.began);
        archive!(archive.value: self.phase, self.end, self.steps, self.events, self.rows, self.paths);
        // Tables leave the levels out, and so does serde.
        for row in &mut self.rows {
            archive.value(&mut row.levels)?;
        }
        Ok(())
    }
}

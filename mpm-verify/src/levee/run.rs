//! Follows a levee from its first moment to its end, with stops at fixed times, frames and checkpoints.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use mpm_core::failure::{Driver, End, Events, PathPoint, Row, Steps};
use mpm_core::scene::{Fields, Integrator};
use mpm_core::stability::choose_step;

use super::checkpoint::{Checkpoint, Notes};
use super::moments::{Album, fixed};
use super::plan::Plan;
use crate::checkpoint::CheckpointError;
use crate::error::Error;
use crate::frames::Shot;

/// What is asked and told while a run goes on.
pub struct Hooks<'a> {
    /// Called after every look at the soil.
    pub progress: &'a mut dyn FnMut(&Driver),
    /// Whether to stop here and keep the state.
    pub stop: &'a mut dyn FnMut(&Driver) -> bool,
    /// Folder of the checkpoint; `None` for no checkpoints.
    pub folder: Option<PathBuf>,
    /// Wall time between checkpoints.
    pub every: Duration,
    /// Called when one could not be written: the run goes on without it.
    pub trouble: &'a mut dyn FnMut(&CheckpointError),
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Ended {
    /// The levee collapsed and came to rest.
    Collapsed,
    /// The time was over.
    TimeOver,
    /// It was asked to stop; the state is kept.
    Stopped,
    /// Soil does not stand under its own weight and the first water: what moved.
    DoesNotStand(String),
    /// A step went wrong: where and what.
    Failed(String),
}

impl Ended {
    /// In one or two words.
    pub fn words(&self) -> &'static str {
        match self {
            Self::Collapsed => "collapsed",
            Self::TimeOver => "time-over",
            Self::Stopped => "stopped",
            Self::DoesNotStand(_) => "does-not-stand",
            Self::Failed(_) => "run-failed",
        }
    }

    /// What went wrong, if something did.
    pub fn trouble(&self) -> Option<&str> {
        match self {
            Self::DoesNotStand(what) | Self::Failed(what) => Some(what),
            Self::Collapsed | Self::TimeOver | Self::Stopped => None,
        }
    }
}

/// What a run came to.
#[derive(Debug, Clone)]
pub struct Followed {
    /// How it ended.
    pub ended: Ended,
    /// The history.
    pub rows: Vec<Row>,
    /// Stresses at the observed places.
    pub paths: Vec<PathPoint>,
    /// Events.
    pub events: Events,
    /// Steps.
    pub steps: Steps,
    /// Frames.
    pub shots: Vec<Shot>,
    /// Step of the soil, s.
    pub dt_s: f64,
    /// Particles of the soil, and of the water at the start.
    pub particles: [usize; 2],
    /// Dry mass at the start, kg.
    pub mass_kg: f64,
    /// CPU time, s.
    pub cpu_s: f64,
}

/// Follows a levee from its start, to its end or until `stop` says so, without a word and without checkpoints.
///
/// # Errors
/// As [`follow`].
pub fn follow_quietly(plan: &Plan, stop: &mut dyn FnMut(&Driver) -> bool) -> Result<Followed, Error> {
    let mut hooks = Hooks { progress: &mut |_| (), stop, folder: None, every: Duration::MAX, trouble: &mut |_| () };
    follow(plan, &mut hooks, None)
}

/// Follows a levee, from the start or from a checkpoint.
///
/// # Errors
/// It cannot start or go on. What goes wrong on the way is in [`Followed::ended`].
pub fn follow(plan: &Plan, hooks: &mut Hooks, resume: Option<Checkpoint>) -> Result<Followed, Error> {
    let mut run = Running::new(plan, resume)?;
    let ended = if run.driver.rows.is_empty() { run.load() } else { None };
    let ended = match ended {
        Some(ended) => ended,
        None => run.go_on(hooks)?,
    };
    let Running { driver, album, cpu_before_s, clock, particles, mass_kg, .. } = run;
    Ok(Followed {
        ended,
        events: driver.events,
        steps: driver.steps,
        dt_s: driver.dt,
        rows: driver.rows,
        paths: driver.paths,
        shots: album.shots,
        particles,
        mass_kg,
        cpu_s: cpu_before_s + clock.elapsed().as_secs_f64(),
    })
}

struct Running<'a> {
    plan: &'a Plan,
    driver: Driver<'a>,
    album: Album,
    /// Steps of the driver of the scene and of the staggered integrator before it, s.
    steps: [f64; 2],
    switched: bool,
    cpu_before_s: f64,
    clock: ThreadTime,
    particles: [usize; 2],
    mass_kg: f64,
}

impl<'a> Running<'a> {
    fn new(plan: &'a Plan, resume: Option<Checkpoint>) -> Result<Self, Error> {
        let clock = ThreadTime::now();
        let mut driver = Driver::new(&plan.scene)?;
        let frame = driver.frame();
        let staggered = Fields { integrator: Integrator::Staggered, ..Fields::clone(&plan.scene) };
        let steps = [driver.dt, choose_step(&staggered)?];
        let particles = [frame.solid.len(), frame.water.len()];
        let mass_kg = frame.solid.iter().map(|p| p.mass).sum();
        let (notes, album) = match &resume {
            Some(kept) => (kept.notes.clone(), kept.album.clone()),
            None => (Notes { switched: plan.from_h.is_none(), ..Notes::default() }, Album::default()),
        };
        if !notes.switched {
            driver.drive_by(Integrator::Staggered, steps[1]);
        }
        // Who drives is no part of the state: it is set before.
        if let Some(kept) = resume {
            driver.restore(&kept.state)?;
        }
        let Notes { cpu_s, switched, .. } = notes;
        Ok(Self { plan, driver, album, steps, switched, cpu_before_s: cpu_s, clock, particles, mass_kg })
    }

    /// Gravity and the first water.
    fn load(&mut self) -> Option<Ended> {
        match self.driver.load() {
            Err(error) => Some(Ended::Failed(format!("under its own weight and the first water: {error}"))),
            Ok(_) if !self.driver.rows.is_empty() => {
                self.look(&self.driver.events.clone(), true);
                None
            }
            Ok(settled) => {
                self.look(&self.driver.events.clone(), true);
                Some(Ended::DoesNotStand(format!(
                    "under its own weight and the first water the soil {}",
                    settled.said()
                )))
            }
        }
    }

    fn look(&mut self, before: &Events, at_fixed: bool) {
        if self.plan.frames {
            self.album.look(&self.driver, before, at_fixed);
        }
    }

    fn go_on(&mut self, hooks: &mut Hooks) -> Result<Ended, Error> {
        let stops = fixed(self.plan);
        let from = self.plan.from_h.map(|hours| self.plan.seconds(hours));
        let mut saved = Instant::now();
        loop {
            (hooks.progress)(&self.driver);
            if let Some(end) = self.driver.end {
                return Ok(if end == End::Collapsed { Ended::Collapsed } else { Ended::TimeOver });
            }
            // Steps of moving soil do not end on a time: half a step more or less is at it.
            let reached = |time: f64, driver: &Driver| driver.time >= time - 0.5 * driver.dt;
            if let Some(from) = from.filter(|from| !self.switched && reached(*from, &self.driver)) {
                debug_assert!(self.driver.time <= from + 1.0);
                self.driver.drive_by(self.plan.scene.integrator, self.steps[0]);
                self.switched = true;
            }
            let Some(next) = stops.iter().copied().find(|time| !reached(*time, &self.driver)) else {
                return Ok(Ended::TimeOver);
            };
            if let Some(folder) = hooks.folder.clone() {
                let stop = (hooks.stop)(&self.driver);
                if stop || saved.elapsed() >= hooks.every {
                    match self.save(&folder) {
                        Err(e) if stop => return Err(e.into()),
                        Err(e) => (hooks.trouble)(&e),
                        Ok(()) => {}
                    }
                    saved = Instant::now();
                }
                if stop {
                    return Ok(Ended::Stopped);
                }
            }
            let before = self.driver.events;
            if let Err(error) = self.driver.advance(next) {
                return Ok(Ended::Failed(error.to_string()));
            }
            let at_fixed = reached(next, &self.driver);
            self.look(&before, at_fixed);
        }
    }

    fn save(&mut self, folder: &Path) -> Result<(), CheckpointError> {
        let cpu_s = self.cpu_before_s + self.clock.elapsed().as_secs_f64();
        let notes = Notes { cpu_s, switched: self.switched, ..Notes::default() };
        let kept = Checkpoint { notes, album: self.album.clone(), state: self.driver.checkpoint() };
        kept.write(&self.plan.fingerprint(), folder)
    }
}

//! One time step. An integrator reads as its algorithm; the choices it is made of are types, fixed for a run.

mod body;
mod conditions;
mod domains;
mod explicit;
mod faces;
mod failing;
mod free_water;
pub mod kernel;
mod nodal;
mod pressure;
pub mod quasi_static;
mod staggered;
pub mod store;
mod surface;

pub use body::Body;
pub use conditions::{Condition, Damping, Friction, GivenForce, Joined, Lifted, Moved, RigidPlate, Supports};
pub use explicit::Explicit;
pub use failing::{Failing, Pace};
pub use staggered::Staggered;

use serde::{Deserialize, Serialize};

use crate::checkpoint::{Archive, RestoreError};
use crate::observe::{BalanceTerms, Observation, Places, SolidState, WaterParticle};
use crate::scene::Stage;

/// Something went wrong inside a step.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}: {what}")]
pub struct Fault {
    /// Particle or cell, with coordinates in m.
    pub place: String,
    /// What was found there.
    pub what: String,
}

/// What the integrators that solve systems have done so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Work {
    /// Steps that were accepted. The Krylov method has none: it counts its basis vectors.
    pub accepted: u64,
    /// Steps that were repeated with a smaller length.
    pub rejected: u64,
    /// Numeric factorisations of a sparse matrix.
    pub factorisations: u64,
    /// Solves with a factorised matrix.
    pub solves: u64,
}

/// A model that can be advanced and observed, whatever its dimension, shape, water and law.
pub trait Model: Send {
    /// Advances by `steps` steps of `dt` (s). A model with steps of its own choice is asked for one step to the next
    /// time of its stage and counts its own steps in `done`.
    ///
    /// # Errors
    /// Where and what went wrong; `done` counts the steps that were completed.
    fn advance(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault>;
    /// The model as one that soil may fail in, if it is one.
    fn failing(self: Box<Self>) -> Option<Box<dyn Failing>> {
        None
    }
    /// Drainage and damping from now on; `times` are those to stop at, s since the start of the stage.
    ///
    /// # Errors
    /// The stage cannot be computed.
    fn enter_stage(&mut self, stage: &Stage, times: &[f64]) -> Result<(), Fault>;
    /// What is left of the time that [`Self::advance`] was last asked for, s: a model with steps of its own choice may pause on
    /// the way, so that the run can be saved or stopped.
    fn left(&self) -> f64 {
        0.0
    }
    /// Time since the start of the run, s.
    fn time(&self) -> f64;
    /// Work of the linear solver so far; nothing for an explicit model.
    fn work(&self) -> Work {
        Work::default()
    }
    /// The state now, and the balances since the start.
    fn observe(&self) -> (Observation, BalanceTerms);
    /// Pore pressure averaged over the soil, and its smallest and largest cell value, Pa.
    fn pore_pressure(&self) -> [f64; 3];
    /// Largest speed of a node in the last step, m/s; of no use but to a model that can wait for rest.
    fn grid_speed(&self) -> f64 {
        f64::INFINITY
    }
    /// Bytes held by particles and mesh.
    fn bytes(&self) -> usize;
    /// Solid particles.
    fn solid_count(&self) -> usize;
    /// The particles of the solid layer, without displacement and strain, in no order; nothing from models that keep them to
    /// themselves.
    fn particles(&self) -> Vec<SolidState> {
        Vec::new()
    }
    /// The water particles, in no order; nothing from models that keep them to themselves.
    fn water_particles(&self) -> Vec<WaterParticle> {
        Vec::new()
    }
    /// Where the particles are; nothing from models that do not show them.
    fn places(&self) -> Places {
        Places::default()
    }
    /// Saves or restores all that the steps to come depend on; the model that is restored is one of the same scene.
    ///
    /// # Errors
    /// The bytes are not those of such a model, which may then be in pieces.
    fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError>;
    /// Stages of a step that can be done alone; none unless the step is made of stages.
    fn stages(&self) -> &'static [&'static str] {
        &[]
    }
    /// Does one of [`Self::stages`], to be timed: with `dt` = 0 it may be done again and again, because nothing moves.
    fn do_stage(&mut self, _stage: usize, _dt: f64) {}
}

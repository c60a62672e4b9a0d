//! One time step. An integrator reads as its algorithm; the choices it is made of are types, fixed for a run.

mod explicit;

pub use explicit::{Explicit, Parts};

use crate::observe::{Ledger, Observation};

/// Something went wrong inside a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Particle or cell, with coordinates in m.
    pub place: String,
    /// What was found there.
    pub what: String,
}

/// A model that can be advanced and looked at, whatever its dimension, shape, water and law.
pub trait Model: Send {
    /// Advances by `steps` steps of `dt` (s).
    ///
    /// # Errors
    /// Where and what went wrong; `done` counts the steps that were completed.
    fn advance(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault>;
    /// Drainage of the sides (left, right, bottom, top) and damping (1/s) from now on.
    fn enter_stage(&mut self, drained: [bool; 4], damping: f64);
    /// The state now.
    fn observe(&self) -> Observation;
    /// Balances since the start.
    fn ledger(&self) -> Ledger;
    /// Pore pressure averaged over the soil, and its smallest and largest cell value, Pa.
    fn pore_pressure(&self) -> [f64; 3];
    /// Bytes held by particles and mesh.
    fn bytes(&self) -> usize;
    /// Solid particles.
    fn solid_count(&self) -> usize;
}

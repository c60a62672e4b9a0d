//! What one asks of soil that water may make fail, beside what any model does.

use super::{Fault, Model};
use crate::constitutive::Altered;
use crate::observe::{Frame, SolidState};
use crate::water::Pressures;

/// How the soil is to move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    /// Length of a step, s.
    pub dt: f64,
    /// Steps.
    pub steps: u64,
    /// Mass-proportional damping, 1/s.
    pub damping: f64,
    /// What the pressures do meanwhile.
    pub pressures: Pressures,
}

/// Soil and water that can be advanced separately or together.
pub trait Failing: Model {
    /// Lets the soil move.
    ///
    /// # Errors
    /// Where and what went wrong; `done` counts the steps.
    fn move_soil(&mut self, pace: &Pace, done: &mut u64) -> Result<(), Fault>;
    /// Lets the water seep for some time (s) while the soil rests.
    ///
    /// # Errors
    /// As [`Self::move_soil`].
    fn seep(&mut self, span: f64, done: &mut u64) -> Result<(), Fault>;
    /// Lets the soil feel a share of the pressures, until they change.
    fn feel(&mut self, share: f64);
    /// Glues the soil to its base, or lets friction decide.
    fn glue(&mut self, glued: bool);
    /// Stops all soil.
    fn stop(&mut self);
    /// Begins to count displacement, strain and the balances.
    fn count_from_here(&mut self);
    /// Forgets the slip on the base.
    fn forget_slip(&mut self);
    /// Lets slip no longer weaken the base.
    fn freeze_slip(&mut self, frozen: bool);
    /// The strength of the soil is that of the scene divided by a factor, with a flow rule, and so is that of the base, c and
    /// tan(delta); the soil is so many times as stiff.
    fn alter(&mut self, by: &Altered);
    /// What is left of the forces on the nodes, as a share of them.
    fn unbalanced(&self) -> f64;
    /// Visits every particle of soil.
    fn each(&self, visit: &mut dyn FnMut(&SolidState));
    /// All there is to see, at a time (s) and a step.
    fn frame(&self, time_s: f64, step: u64) -> Frame;
    /// Height of the free surface above the base at x (m), m.
    fn level(&self, x: f64) -> f64;
    /// How far water has come in the lowest row of cells, x in m, towards +x (1) or towards -x (-1).
    fn front(&self, towards: f64) -> f64;
    /// How uneven pressures and motion are: mean |p_00 - p_10 - p_01 + p_11|/4 over blocks of full cells by mean |p|, and the
    /// share of the kinetic energy that is in hourglass modes (velocities of the corners of a cell that alternate).
    fn unevenness(&self) -> [f64; 2];
}

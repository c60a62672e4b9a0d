//! What acts on the nodes beside stress, load and weight: few scenes have more than supports. Each is a condition of its own, asked in
//! the order in which a run holds them, and records what it takes.

mod damping;
mod force;
mod friction;
mod joined;
mod lifted;
mod moved;
mod plate;
mod supports;

pub use damping::Damping;
pub use force::GivenForce;
pub use friction::Friction;
pub use joined::Joined;
pub use lifted::Lifted;
pub use moved::Moved;
pub use plate::RigidPlate;
pub use supports::Supports;

use std::fmt::Debug;

use super::Fault;
use super::store::Nodes;
use crate::checkpoint::{Archive, RestoreError};
use crate::observe::Totals;
use crate::particles::SolidPoint;
use crate::scene::SolidSide;

/// Is shown a particle and its shares of functions.
pub type Visit<'a, const D: usize> = dyn FnMut(&SolidPoint<D>, &[(usize, f64)]) + 'a;

/// The soil, as conditions see it.
pub trait Soil<const D: usize> {
    /// Time since the start of the run, s.
    fn time(&self) -> f64;
    /// Cells along each axis, and the edge of one, m.
    fn mesh(&self) -> ([usize; D], f64);
    /// Visits the solid particles: number, and the share of each function that one reaches.
    fn each_share(&self, visit: &mut Visit<D>);
    /// Visits the solid particles of a cell with their numbers.
    fn each_in(&self, cell: usize, visit: &mut dyn FnMut(u32, &SolidPoint<D>));
    /// Visits the soil, by cells or particles: dry mass (kg), and the functions that it reaches.
    fn each_cell(&self, visit: &mut dyn FnMut(f64, &mut dyn Iterator<Item = usize>));
    /// What a cell of the lowest row puts on the base: pore pressure there (Pa), and the share of its bottom that is under soil, if
    /// that is known.
    fn on_base(&self, cell: usize) -> (f64, Option<f64>);
}

/// Something that acts on the nodes.
pub trait Condition<const D: usize>: Debug + Send {
    /// All has been gathered, and nothing has moved yet.
    fn gathered(&mut self, _: &mut Nodes<D>, _: &dyn Soil<D>) {}
    /// Pore pressures have pushed the nodes beside.
    fn pushed(&mut self, _: &mut Nodes<D>) {}
    /// The nodes have their motion of a step dt (s), of those before this condition.
    ///
    /// # Errors
    /// Where and what went wrong.
    fn accelerated(&mut self, _: &mut Nodes<D>, _: &dyn Soil<D>, _: &mut Totals<D>, _: f64) -> Result<(), Fault> {
        Ok(())
    }
    /// All conditions have acted on the motion of a step dt (s).
    fn followed(&mut self, _: &mut Nodes<D>, _: &dyn Soil<D>, _: &mut Totals<D>, _: f64) {}
    /// Records what it did beside momenta and energies that are lost, in a step dt (s).
    fn book(&self, _: &Nodes<D>, _: &mut Totals<D>, _: f64) {}
    /// Adds up other sums of the nodes as it does their own.
    fn join(&self, _: &mut Nodes<D>) {}
    /// Holds other velocities of the nodes as it holds their own.
    fn hold(&self, _: &mut Nodes<D>) {}
    /// Holds the velocities of a step dt (s) that damping has yet to slow down.
    fn hold_ahead(&mut self, nodes: &mut Nodes<D>, _: f64) {
        self.hold(nodes);
    }
    /// Visits the nodes that it holds in this step, with the axis.
    fn each_held(&self, _: &mut dyn FnMut(usize, usize)) {}
    /// The nodes of a rigid plate, if that is what it is.
    fn plate(&self) -> &[u32] {
        &[]
    }
    /// What the soil has got from a plate since the start, N s, if that is what it is.
    fn pushed_by(&self) -> Option<[f64; 2]> {
        None
    }
    /// Holds the sides as a stage says, or else as the scene does: left, right, bottom, top.
    fn hold_sides(&mut self, _: Option<[SolidSide; 4]>) {}
    /// Damping from now on, 1/s.
    fn damp_by(&mut self, _: f64) {}
    /// Friction on the base, if that is what it is.
    fn friction(&mut self) -> Option<&mut Friction> {
        None
    }
    /// Saves or restores what steps to come depend on.
    ///
    /// # Errors
    /// The bytes are not those of such a condition.
    fn save_or_restore(&mut self, _: &mut Archive) -> Result<(), RestoreError> {
        Ok(())
    }
    /// Bytes held.
    fn bytes(&self) -> usize {
        0
    }
}

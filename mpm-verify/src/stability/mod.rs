//! Time-step limits, predicted and measured, and what each Darcy operator does to a point source of pressure.
//!
//! # Reading order
//! 1. [`growth`]: how much a perturbation grows per step of a run. [`bisection`]: the largest step at which it does not.
//! 2. [`assembled`]: the same step as a matrix, put together again from the equations: its growth is the theory where
//!    no formula of a plane wave holds.
//! 3. [`map`]: the limits of all schemes over meshes, particles, conductivities and bulk moduli, measured and in theory.
//! 4. [`mod@limits`]: a few settings over whole runs. [`point_source`]: the checkerboard that the nodal operator leaves.

mod around;
pub mod assembled;
pub mod bisection;
pub mod growth;
pub mod limits;
pub mod map;
pub mod point_source;

pub use limits::{Limit, limits};
pub use point_source::checkerboard;

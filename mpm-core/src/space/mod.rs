//! Function spaces of the implicit integrators: one-dimensional bases along an axis, and weights of particles.
//!
//! The first and the last knot stand on the boundary of the soil, wherever the lines of the mesh lie: conditions at
//! the boundary are then those of its first and last function, and no cell is cut.

mod axis;
mod deformation;
mod gauss;
mod shares;
mod splines;
mod stencil;
mod weights;

pub use axis::{Axis, Basis};
pub use deformation::{Stretch, active, strain_mode, stretch, tensor, turned};
pub use gauss::{gauss, gauss_points};
pub use shares::{Group, groups};
pub use splines::{Local, Splines};
pub use stencil::{MOST, Stencil};
pub use weights::{Fit, fit};

//! Conditions on the solid: nodes held by rollers, and the surcharge. Those on the water are in [`crate::water`].

mod supports;
mod surcharge;

pub use supports::Supports;
pub use surcharge::{Strip, SurfaceLoad};

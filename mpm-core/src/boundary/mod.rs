//! Conditions on the solid: nodes held by rollers, periodic sides, friction on the base, and the surcharge. Those on the
//! water are in [`crate::water`].

mod coulomb;
mod edges;
mod joined;
mod supports;
mod surcharge;

pub use coulomb::{Coulomb, Rubbed};
pub use edges::Edges;
pub use joined::Joined;
pub use supports::Supports;
pub use surcharge::{Strip, SurfaceLoad};

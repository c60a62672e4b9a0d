//! Conditions on the solid: nodes held by rollers, periodic sides, friction on the base, the surcharge, and given fields of
//! force. Those on the water are in [`crate::water`].

mod body_force;
mod coulomb;
mod edges;
mod filled;
mod given;
mod joined;
mod lifted;
mod plate;
mod supports;
mod surcharge;

pub use body_force::BodyForce;
pub use coulomb::{Coulomb, Rubbed};
pub use edges::Edges;
pub(crate) use filled::ROUND_OFF;
pub use filled::{Filled, Top, knows_volumes};
pub use given::{FirstField, FirstState, ForceField, Given};
pub use joined::Joined;
pub use lifted::Lifted;
pub use plate::Plate;
pub use supports::Supports;
pub use surcharge::{Strip, SurfaceLoad};

//! Conditions on the solid: nodes on rollers, periodic sides, friction on the base, the surcharge, and given fields of
//! force. Those on the water are in [`crate::water`].

mod filled;
mod given;
mod loads;
mod surcharge;

pub(crate) use filled::ROUND_OFF;
pub use filled::{Filled, Top, knows_volumes};
pub use given::{FirstField, FirstState, ForceField, Given};
pub use loads::{FaceLoads, LoadedPiece};
pub use surcharge::{Strip, SurfaceLoad};

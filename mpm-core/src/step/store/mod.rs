//! Particles and nodes as the kernel reads them: cells side by side in vectors ([`frame`]), a layer in blocks of one particle of
//! each ([`blocks`]), both in [`strip`]s of cells, whose size does not depend on the threads: nor do the bits.

mod ahead;
mod aligned;
pub mod blocks;
pub mod crossing;
pub mod frame;
pub mod nodes;
pub mod reached;
pub mod strip;

pub use ahead::ask_for;
pub use blocks::{Blocks, Movers, SolidLanes, WaterLanes};
pub use frame::Frame;
pub use nodes::{Motion, Nodes, StripSums};
pub use reached::Reached;
pub use strip::{SimdCells, Strip, StripVectors};

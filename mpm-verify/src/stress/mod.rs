//! Stress tests: where every scheme holds, degrades and breaks.
//!
//! # Reading order
//! 1. [`scheme`]: what is compared. [`case`]: what a case is, its points and its verdict. [`mod@matrix`]: all of it at once.
//! 2. Water that cannot leave and soil that keeps its volume: [`low_permeability`], [`stiff_water`], [`sudden_load`],
//!    [`incompressible`].
//! 3. Bodies that move through the mesh: [`crossing`], [`moving_consolidation`],
//!    [`loaded_surface`].
//! 4. What few points per cell leave free: [`hourglass`], [`patch`]. Fine meshes with many particles: [`too_fine`].
//! 5. Nodes with hardly any mass: [`small_nodes`]. Layers: [`contrast`].

pub mod case;
pub mod contrast;
pub mod crossing;
pub mod hourglass;
pub mod incompressible;
pub mod loaded_surface;
pub mod low_permeability;
pub mod matrix;
pub mod moving_consolidation;
pub mod patch;
pub mod scheme;
pub mod small_nodes;
pub mod stiff_water;
pub mod sudden_load;
pub mod too_fine;

pub use case::{Case, Point, Verdict};
pub use matrix::{CASES, Found, MatrixRow, matrix};
pub use scheme::Scheme;

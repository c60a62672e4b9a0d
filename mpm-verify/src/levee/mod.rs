//! A levee through which water seeps until it fails: the paper's section 4, from the scene to the page.
//!
//! # Reading order
//! 1. [`plan`]: which scene, by which driver, from when to when. [`variants`]: the scene with one input changed. [`strength`]: that of
//!    its soil.
//! 2. [`run`]: follows it. [`moments`]: when frames are taken. [`checkpoint`]: a state on disk, to go on from.
//! 3. [`tables`], [`summary`], [`limits`]: what it came to, and what it must keep to. [`claims`]: the paper's statements, judged by rules.
//! 4. [`safety`]: the factor of safety over time, beside [`equilibrium`] with the same water. [`sensitivity`]: all variants.
//! 5. [`convergence`]: what does not depend on the mesh, and what does. [`drivers`]: whoever drives, and what it costs.
//!    [`operators`]: the paper's Darcy operator beside the default, on the levee's own full cells.
//! 6. [`figures`], [`assumptions`], [`page`], [`written`]: what is left in a folder. [`ticker`]: what is said on the way.

pub mod assumptions;
pub mod checkpoint;
pub mod claims;
pub mod convergence;
pub mod drivers;
pub mod equilibrium;
pub mod figures;
pub mod limits;
pub mod moments;
pub mod operators;
pub mod page;
pub mod plan;
pub mod run;
pub mod safety;
pub mod sensitivity;
pub mod strength;
pub mod summary;
pub mod tables;
pub mod ticker;
pub mod variants;
pub mod written;

//! A levee through which water seeps until it fails: the paper's section 4, from the scene to the page.
//!
//! # Reading order
//! 1. [`plan`]: which scene, by which driver, from when to when. [`variants`]: the scene with one input changed. [`strength`]: that of
//!    its soil.
//! 2. [`run`]: follows it. [`moments`]: when frames are taken. [`checkpoint`]: a state on disk, to go on from.
//! 3. [`tables`], [`summary`], [`limits`]: its results, and the bounds that they must keep. [`claims`]: what the paper claims, judged by
//!    rules.
//! 4. [`safety`]: the factor of safety over time ([`crate::slope`]). [`sensitivity`]: all variants.
//!    [`ensemble`]: runs that should be equal, on several meshes. [`probability`]: of failure over time. [`validation`]: against paper and experiment.
//! 5. [`convergence`]: which results depend on the mesh. [`drivers`]: the time integrators side by side, with their costs.
//!    [`operators`]: the paper's Darcy operator beside the default, on the full cells of the levee. [`ranges`]: how far the headline
//!    numbers move with the mesh and the assumptions.
//! 6. [`figures`], [`story`], [`assumptions`], [`page`], [`written`]: the files of a run. [`ticker`]: its progress.

pub mod assumptions;
pub mod checkpoint;
pub mod claims;
pub mod convergence;
pub mod drivers;
pub mod ensemble;
pub mod figures;
pub mod limits;
pub mod moments;
pub mod operators;
pub mod page;
pub mod plan;
pub mod probability;
pub mod ranges;
pub mod run;
pub mod safety;
pub mod sensitivity;
pub mod story;
pub mod strength;
pub mod summary;
pub mod tables;
pub mod ticker;
pub mod validation;
pub mod variants;
pub mod written;

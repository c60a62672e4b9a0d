//! What accuracy costs: every integrator and every kind of shape functions on the paper's column, error against CPU time.
//!
//! # Reading order
//! 1. [`setting`]: one way to compute the column, and the command that runs it. [`plan`]: which ones, and what is left
//!    out and why.
//! 2. [`baseline`]: the finite-volume column that ratios refer to. [`peers`]: figures of other codes, measured elsewhere.
//! 3. [`measure`]: one setting, its error once and its time many times. [`store`]: what is done stays done.
//!    [`sweep`]: all settings in mixed order.
//! 4. [`row`]: what is kept of a setting. [`pareto`], [`cheapest`], [`growth`]: what follows from all of them.
//! 5. [`kernel`]: what one explicit step costs by size, threads and vectors, and what the machine would allow.
//! 6. [`report`]: answers, tables, pictures, pages.
//!
//! The scenes of the criterion benches in `benches/` stand in [`mpm_verify::cost`]; those benches are for people, and
//! print time per solid particle and step.

pub mod baseline;
pub mod cheapest;
pub mod growth;
pub mod kernel;
pub mod measure;
pub mod pareto;
pub mod peers;
pub mod plan;
pub mod report;
pub mod row;
pub mod setting;
pub mod store;
pub mod sweep;

pub use mpm_verify::cost::{block, paths};

//! Speed of `mpm-core`. The scenes that are timed stand in [`mpm_verify::cost`]; the benches in `benches/` are for
//! people, and print time per solid particle and step.

pub use mpm_verify::cost::{block, paths};

//! Mutation run: known faults are planted in a copy of the source, and the checks must find each of them.
//!
//! All faults stand in one copy, each behind a switch that is read from the environment, so that the copy is built once and
//! the source itself knows nothing of them. [`patches`]: the faults. [`copy`]: the copy. [`hunt`]: who finds what. [`detected`]: who
//! has found what before.

pub mod copy;
pub mod detected;
pub mod hunt;
pub mod patches;

/// Says which fault is on.
pub const SWITCH: &str = "MPM_MUTANT";

//! Verification of `mpm-core` against exact solutions.
//!
//! # Reading order
//! 1. [`scenes`]: the scene files that the program carries.
//! 2. [`exact`]: exact solutions, one per file.
//! 3. [`norms`], [`rates`]: the one definition of error; orders of convergence.
//! 4. [`study`]: refine, run, compare. [`manifest`]: under which conditions.

pub mod budget;
pub mod claims;
pub mod exact;
pub mod manifest;
pub mod norms;
pub mod progress;
pub mod rates;
pub mod scenes;
pub mod study;

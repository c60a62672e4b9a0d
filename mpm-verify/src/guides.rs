//! Chapters of the guide with Rust in them, so that their examples are compiled and run with the tests.

/// How to read results, by eye and by a program.
#[doc = include_str!("../docs/reports.md")]
pub mod reports {}

/// How to add a case, a constitutive law, an exact solution, an integrator.
#[doc = include_str!("../docs/extending.md")]
pub mod extending {}

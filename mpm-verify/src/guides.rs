//! The guides, so that their examples are compiled and run with the tests.

/// How soil answers to strain.
#[doc = include_str!("../docs/add-a-law.md")]
pub mod add_a_law {}

/// What runs are compared with.
#[doc = include_str!("../docs/add-an-exact-solution.md")]
pub mod add_an_exact_solution {}

/// Which file answers which question.
#[doc = include_str!("../docs/read-a-report.md")]
pub mod read_a_report {}

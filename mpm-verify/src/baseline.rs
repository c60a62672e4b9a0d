//! Accepted errors of the suite. The truth is checked by the suite itself; these say whether a change of the code has moved a
//! number. What a night measures beside them has its own file ([`crate::nightly::accepted`]).

pub mod suite;

/// Where the accepted numbers are kept, from the root of the source.
pub const FOLDER: &str = "reference-data/baselines";

//! One way to run and to judge anything: a scene with a patch, what is measured in its runs, the reference and the norm, what is
//! refined, and what that must show. The result is a record.
//!
//! # Reading order
//! 1. [`spec`]: an experiment as data, from a file. [`measure`]: what can be measured. `run`: from both to an outcome; `shared`:
//!    a scene that several look at is run once.
//! 2. `comparison`: numbers of a run beside exact ones, and the norm that makes one error of them.
//! 3. `refinement`: errors over a refined parameter, and the order that they show.
//! 4. `verdict`: the one rule that judges an outcome. [`accepted`]: its error beside the accepted one; [`number`]: what
//!    is accepted, and how far it may move.
//! 5. [`pool`]: several experiments at a time.

pub mod accepted;
pub(crate) mod comparison;
pub mod measure;
pub mod number;
pub mod pool;
pub(crate) mod refinement;
pub(crate) mod run;
pub(crate) mod shared;
pub mod spec;
pub(crate) mod verdict;

pub use refinement::{Refinement, RefinementRow, SampleRow, Sampled};
pub use verdict::{CaseRow, Judged, Named};

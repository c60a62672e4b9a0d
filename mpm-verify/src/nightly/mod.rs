//! The night: everything measured, held against what was accepted, and remembered.
//!
//! # Reading order
//! 1. [`collect`]: the numbers of the study, the stability map and the levee, each held to what
//!    [`accepted`](crate::experiment::accepted) has.
//! 2. [`work`]: what runs cost in counts that no machine's mood changes. [`compiled`]: those that a compiler does.
//!    [`calibration`]: what a time is a ratio to.
//! 3. [`moved`]: what is not where it was.
//! 4. [`history`]: every value at every entry, and since when. [`trends`]: pages of it.
//! 5. [`report`]: `summary.json`, a page fit for a job summary. [`tables`]: of its page. [`nights`]: the page of all of them.

pub mod calibration;
pub mod collect;
pub mod compiled;
pub mod history;
pub mod instructions;
pub mod moved;
pub mod nights;
pub mod report;
pub mod tables;
pub mod trends;
pub mod work;

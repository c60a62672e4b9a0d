//! The nightly run: numbers of all parts, compared with what was accepted, and recorded.
//!
//! # Reading order
//! 1. [`part`]: the parts, and what each must have measured. [`collect`]: the numbers of the study, the suite, the stability map and
//!    the levee, each compared with what [`accepted`](crate::experiment::accepted) has.
//! 2. [`work`]: what single runs cost in counts that no load on the machine changes. [`instructions`]: of the same runs.
//!    [`compiled`]: counts that depend on the compiler. [`calibration`]: what a time is a ratio to.
//! 3. [`moved`]: what is not where it was. [`thresholds`]: from the history, for what is not accepted.
//! 4. [`history`]: every value at every entry, and since when. [`trends`]: pages and a figure of it.
//! 5. [`report`]: `summary.json`, a page fit for a job summary. [`tables`]: of its page. [`nights`]: the page of all of them.

pub mod calibration;
pub mod collect;
pub mod compiled;
pub mod history;
pub mod instructions;
pub mod moved;
pub mod nights;
pub mod part;
pub mod report;
pub mod tables;
pub mod thresholds;
pub mod trends;
pub mod work;

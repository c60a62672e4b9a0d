//! The night: everything measured, held against what was accepted, and remembered.
//!
//! # Reading order
//! 1. [`measure`]: a number with its name, what it is held to, and which direction is better. [`collect`]: the numbers of the
//!    study, the suite, the stability map and the levee.
//! 2. [`work`]: what runs cost in counts that no machine's mood changes. [`compiled`]: those that a compiler does.
//!    [`calibration`]: what a time is a ratio to.
//! 3. [`accepted`]: the baselines, and how they are renewed. [`moved`]: what is not where it was.
//! 4. [`history`]: every value at every entry, and since when. [`trends`]: pages of it.
//! 5. [`report`]: `summary.json`, a page fit for a job summary. [`tables`]: of its page. [`nights`]: the page of all of them.

pub mod accepted;
pub mod calibration;
pub mod collect;
pub mod compiled;
pub mod history;
pub mod instructions;
pub mod measure;
pub mod moved;
pub mod nights;
pub mod report;
pub mod tables;
pub mod trends;
pub mod work;

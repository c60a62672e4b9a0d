//! Verification of `mpm-core` against exact solutions.
//!
//! # Reading order
//! 1. [`scenes`]: the scene files that the program carries.
//! 2. [`exact`]: exact solutions, one per file. [`literature`]: published laws where there are none.
//! 3. [`norms`], [`rates`]: the one definition of error; orders of convergence, and the one rule for them. [`verdict`]: its words.
//! 4. [`element`]: one law on prescribed paths. [`experiment`]: one way to run and judge anything, and what is accepted.
//!    [`cases`]: the verification suite.
//! 5. [`study`]: refine, run, compare. [`budget`]: which part of an error comes from what. [`claims`]: the paper's
//!    statements and their verdicts. [`sweeps`]: displaced particles, offsets of the mesh, errors in time.
//!    [`stability`]: time-step limits, predicted and measured. [`stress`]: where assumptions are pushed.
//! 6. [`slope`]: factors of safety. [`levee`]: the levee that seepage makes fail: its run, checkpoints, claims, sensitivity.
//! 7. [`page`]: one layout, one style and one navigation for all pages; the home page. [`report`]: tables, plots, what the pages say. [`frames`]: stored frames of a run, to make its pictures again. [`manifest`]:
//!    under which conditions; [`provenance`]: from which sources and commit.
//!    [`nightly`]: everything measured every night, compared and remembered.
//!    [`mutants`]: planted faults, and who finds them. [`metamorphic`]: random scenes, and relations that must hold between
//!    their runs.
//! 8. [`progress`], [`run_time`]: how far a run has come, and how long it will take. [`suggest`]: the nearest names.
//! 9. [`files`]: files that are whole or not there. [`checkpoint`], [`keeping`]: states to
//!    go on from. [`error`]: what can go wrong.

pub mod book;
pub mod budget;
pub mod cases;
pub mod checkpoint;
pub mod claims;
pub mod cost;
pub mod element;
pub mod error;
pub mod exact;
pub mod experiment;
pub mod files;
pub mod frames;
pub mod guides;
pub mod keeping;
pub mod levee;
pub mod literature;
pub mod manifest;
pub mod metamorphic;
pub mod mutants;
pub mod nightly;
pub mod norms;
pub mod page;
pub mod progress;
pub mod protocol;
pub mod provenance;
pub mod rates;
pub mod report;
pub mod run_time;
pub mod scenes;
pub mod slope;
mod sources;
pub mod stability;
pub mod stress;
pub mod study;
pub mod suggest;
pub mod sweeps;
pub mod unpanicked;
pub mod verdict;

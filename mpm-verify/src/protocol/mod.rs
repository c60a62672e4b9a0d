//! Bring your own solver: neutral cases that any code can run, and their scores.
//!
//! # Reading order
//! 1. [`case`]: a neutral case, made of one of the suite or of a file of `reference-data/protocol`. [`given`]: a scene without its
//!    method, and back. [`quantity`]: what is asked. [`equations`]: what is solved. [`units`]: units and scales.
//! 2. [`results`]: the table of a solver, with all that is wrong with it. [`score`]: errors, orders, verdict. [`mistakes`]: what a wrong
//!    result looks like.
//! 3. [`export`]: cases as files and pages. [`answer`]: the answers of this code, through the same interface.
//! 4. [`command`]: a foreign code under limits. [`code`]: its scores. [`board`]: the leaderboard.

pub mod answer;
pub mod board;
pub mod case;
pub mod code;
pub mod command;
pub mod equations;
pub mod export;
pub mod given;
pub mod mistakes;
pub mod quantity;
pub mod results;
pub mod score;
#[cfg(test)]
mod tests;
pub mod units;
pub mod values;

//! Accepted errors of the suite's cases. A case that still holds, but whose error has grown, has lost something; one whose error has
//! fallen computes something else than it did, and asks to be accepted as well.
//!
//! `verified`: the error is against an exact solution, so that the baseline is a measured distance from the truth.
//! `regression`: it is against this code itself or a scatter of published laws, and the baseline says only what was.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use mpm_core::scene::read_text;
use serde::{Deserialize, Serialize};

use super::FOLDER;
use crate::error::Error;

/// `reference-data/baselines/cases.csv`.
pub(crate) const ACCEPTED: &str = include_str!("../../../reference-data/baselines/cases.csv");
/// Errors may grow to this share of the accepted one, or fall to one over it: what other processors and compilers round
/// differently is far less.
pub const GROWTH: f64 = 1.02;
/// Absolute change of an error that is the round-off of linear solves.
const SOLVED: f64 = 1e-9;

/// What an error is measured against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The truth: an exact solution or law.
    Verified,
    /// This code itself, on a finer mesh or at another time, or a band of published laws.
    Regression,
}

/// A row of the baselines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Accepted {
    /// Name of the case.
    pub case: String,
    /// What the error is measured against.
    pub kind: Kind,
    /// Accepted error.
    pub error: f64,
    /// Its fitted order; for the record, the interval of the case judges it.
    pub order: Option<f64>,
    /// A change up to this is round-off, whatever its share.
    pub floor: f64,
}

/// Name of the file.
const NAME: &str = "cases.csv";
/// No such file is larger, bytes.
const LARGEST: u64 = 16 << 20;
/// The errors of a file, in place of those that were built in.
static READ: OnceLock<Vec<Accepted>> = OnceLock::new();

/// Holds all cases of this process against the errors in a folder; without one, against those of the source tree where there are any, or
/// else those that were built in, as `nightly` does. Returns the file, if there is one.
///
/// # Errors
/// A folder without such a file, or a file that is no such table.
pub fn hold_against(folder: Option<&Path>) -> Result<Option<PathBuf>, Error> {
    let path = folder.unwrap_or(Path::new(FOLDER)).join(NAME);
    if folder.is_none() && !path.exists() {
        return Ok(None);
    }
    let text = read_text(&path, LARGEST).map_err(Error::at(&path))?;
    let rows = parse(&text).map_err(Error::at(&path))?;
    READ.get_or_init(|| rows);
    Ok(Some(path))
}

fn parse(text: &str) -> Result<Vec<Accepted>, csv::Error> {
    csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes()).deserialize().collect()
}

/// The accepted errors of all cases.
///
/// # Panics
/// Never: a test reads the baselines that are built in.
pub fn baselines() -> Vec<Accepted> {
    READ.get().cloned().unwrap_or_else(|| parse(ACCEPTED).expect("the baselines hold"))
}

/// Absolute change of a case's error that is round-off, if it has a baseline.
pub fn floor_of(case: &str) -> Option<f64> {
    baselines().into_iter().find(|row| row.case == case).map(|row| row.floor)
}

/// First lines of the baselines.
pub const LABEL: &str = "\
# Accepted errors of the cases of the suite (`mpm-verify check`), which writes this file anew as accepted.csv.
# verified: against an exact solution. regression: against this code itself or a band of published laws.
case,kind,error,order,floor
";

/// Change of an error that is round-off. Runs whose steps follow from a tolerance are the same up to that: on a processor with shorter vectors the sums of the linear
/// solver have another order, and a step or a basis vector more may be taken. An error below what is left open is round-off
/// itself, and may be anything that the case allows.
pub fn floor(error: f64, required: f64, tolerance: f64) -> f64 {
    let solved = SOLVED.max(tolerance);
    if error <= SOLVED { required.max(solved) } else { solved }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_off_may_be_anything_that_is_allowed() {
        assert_eq!((floor(1e-3, 1e-2, 0.0), floor(1e-12, 1e-10, 0.0)), (SOLVED, SOLVED));
        assert_eq!((floor(1e-12, 1e-8, 0.0), floor(1e-3, 1e-2, 1e-7)), (1e-8, 1e-7));
    }
}

//! Accepted errors of the ladder's rungs. A rung that still holds, but whose error has grown, has lost something; one whose error has
//! fallen computes something else than it did, and asks to be accepted as well.
//!
//! `verified`: the error is against an exact solution, so that the baseline is a measured distance from the truth.
//! `regression`: it is against this code itself or a scatter of published laws, and the baseline says only what was.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use mpm_core::scene::read_text;
use serde::{Deserialize, Serialize};

use crate::cases::Climb;
use crate::error::Error;
use crate::nightly::accepted::FOLDER;

/// `reference-data/baselines/ladder.csv`.
const ACCEPTED: &str = include_str!("../../../reference-data/baselines/ladder.csv");
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
    /// Name of the rung.
    pub rung: String,
    /// What the error is measured against.
    pub kind: Kind,
    /// Accepted error.
    pub error: f64,
    /// Its fitted order; for the record, the interval of the rung judges it.
    pub order: Option<f64>,
    /// A change up to this is round-off, whatever its share.
    pub floor: f64,
}

/// Name of the file.
const NAME: &str = "ladder.csv";
/// No such file is larger, bytes.
const LARGEST: u64 = 16 << 20;
/// The errors of a file, in place of those that were built in.
static READ: OnceLock<Vec<Accepted>> = OnceLock::new();

/// Holds all rungs of this process against the errors in a folder; without one, against those of the source tree where there are any, or
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

/// The accepted errors.
///
/// # Panics
/// Never: a test reads the baselines that are built in.
fn baselines() -> Vec<Accepted> {
    READ.get().cloned().unwrap_or_else(|| parse(ACCEPTED).expect("the baselines hold"))
}

/// Absolute change of a rung's error that is round-off, if it has a baseline.
pub fn floor_of(rung: &str) -> Option<f64> {
    baselines().into_iter().find(|row| row.rung == rung).map(|row| row.floor)
}

/// Holds a rung's error against the accepted one: notes both, and lets the rung fall if its error has grown or fallen.
pub fn compare(climb: &mut Climb) {
    compare_with(&baselines(), climb);
}

fn compare_with(accepted: &[Accepted], climb: &mut Climb) {
    let Some(row) = accepted.iter().find(|row| row.rung == climb.step.rung) else { return };
    let error = climb.step.error;
    climb.step.baseline = Some(row.error);
    climb.step.change = Some(if error == row.error { 1.0 } else { error / row.error }).filter(|c| c.is_finite());
    let most = 100.0 * (GROWTH - 1.0);
    if error > GROWTH * row.error && error - row.error > row.floor {
        climb.fall(&format!("it was {:.3e} (baseline) and may grow by {most:.0} %", row.error));
    }
    if GROWTH * error < row.error && row.error - error > row.floor {
        let was = row.error;
        climb.fall(&format!(
            "it was {was:.3e} (baseline) and may fall by {most:.0} %; accept what it is now if you know why"
        ));
    }
}

/// First lines of the baselines.
const LABEL: &str = "\
# Accepted errors of the rungs of the ladder (`mpm-verify check`), which writes this file anew as accepted.csv.
# verified: against an exact solution. regression: against this code itself or a band of published laws.
rung,kind,error,order,floor
";

/// The baselines as they would be with these rungs, all others as they are: to be put in place of the old ones once a
/// change is accepted. Rungs that fell short of more than their baseline keep their old row.
pub fn accepted(climbs: &[Climb]) -> String {
    let known = baselines();
    let mut text = LABEL.to_owned();
    for rung in crate::cases::LADDER {
        let old = known.iter().find(|row| row.rung == rung.name);
        let new = climbs.iter().find(|climb| climb.step.rung == rung.name && climb.sound).map(|climb| row(climb, old));
        if let Some(row) = new.as_ref().or(old) {
            let kind = if row.kind == Kind::Verified { "verified" } else { "regression" };
            let order = row.order.map_or(String::new(), |order| format!("{order:.3}"));
            text.push_str(&format!("{},{kind},{:?},{order},{:?}\n", row.rung, row.error, row.floor));
        }
    }
    text
}

/// The row of a rung. A floor that someone has widened by hand stays.
fn row(climb: &Climb, old: Option<&Accepted>) -> Accepted {
    let step = &climb.step;
    let floor = floor(step.error, step.required_error, step.tolerance).max(old.map_or(0.0, |row| row.floor));
    Accepted { rung: step.rung.clone(), kind: step.baseline_kind, error: step.error, order: step.order, floor }
}

/// Runs whose steps follow from a tolerance are the same up to that: on a processor with shorter vectors the sums of the linear
/// solver have another order, and a step or a basis vector more may be taken. An error below what is left open is round-off
/// itself, and may be anything that the rung allows.
fn floor(error: f64, required: f64, tolerance: f64) -> f64 {
    let solved = SOLVED.max(tolerance);
    if error <= SOLVED { required.max(solved) } else { solved }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::LADDER;

    #[test]
    fn every_baseline_is_that_of_a_rung() {
        for row in baselines() {
            assert!(LADDER.iter().any(|rung| rung.name == row.rung), "{} is no rung", row.rung);
            assert!(row.error >= 0.0 && row.floor > 0.0, "{row:?}");
        }
    }

    #[test]
    fn an_error_that_has_moved_lets_its_rung_fall() {
        let rung = LADDER.iter().find(|rung| rung.name == "hydrostatic").expect("a rung");
        let climb = rung.climb().expect("runs that finish");
        assert!(climb.step.held(), "{}", climb.reason);
        let error = climb.step.error;
        let with = |accepted: f64, floor: f64| {
            let mut climb = climb.clone();
            let row =
                Accepted { rung: rung.name.to_owned(), kind: Kind::Verified, error: accepted, order: None, floor };
            compare_with(&[row], &mut climb);
            climb
        };
        assert!(with(error, 0.0).step.held() && with(1.01 * error, 0.0).step.held());
        assert!(with(error / 1.01, 0.0).step.held() && with(error / 2.0, error).step.held());
        assert!(with(1.5 * error, error).step.held());
        let fallen = with(1.03 * error, 0.0);
        assert!(!fallen.step.held() && fallen.reason.contains("(baseline) and may fall by 2 %"), "{}", fallen.reason);
        let grown = with(error / 1.03, 0.0);
        assert!(!grown.step.held() && grown.reason.contains("(baseline) and may grow by 2 %"), "{}", grown.reason);
        assert_eq!(grown.reason, grown.step.reason);
        assert!(grown.step.change.is_some_and(|change| (change - 1.03).abs() < 1e-9));
    }

    #[test]
    fn what_is_accepted_keeps_the_rows_of_rungs_that_were_not_run() {
        let text = accepted(&[]);
        assert_eq!(text, ACCEPTED, "put in place what `mpm-verify check` writes as accepted.csv");
    }

    #[test]
    fn round_off_may_be_anything_that_is_allowed() {
        assert_eq!((floor(1e-3, 1e-2, 0.0), floor(1e-12, 1e-10, 0.0)), (SOLVED, SOLVED));
        assert_eq!((floor(1e-12, 1e-8, 0.0), floor(1e-3, 1e-2, 1e-7)), (1e-8, 1e-7));
    }
}

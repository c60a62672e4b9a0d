//! Accepted errors of the study: regression values, against ourselves, not against truth.
//!
//! The truth is checked by the ladder. This says whether a change of the code has moved a number.

use serde::{Deserialize, Serialize};

use crate::study::{CaseResult, Variant};

/// `reference-data/baselines/errors.csv`.
const ACCEPTED: &str = include_str!("../../reference-data/baselines/errors.csv");
/// Errors may move by this much relative to themselves: other machines round their elementary functions differently.
const TOLERANCE: f64 = 1e-6;

/// A row of the baselines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Accepted {
    case: String,
    max_error_terzaghi: f64,
    max_error_compressible: f64,
}

/// An error beside its accepted value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    /// Case.
    pub case: String,
    /// `max_error_terzaghi` or `max_error_compressible`.
    pub norm: String,
    /// Accepted value.
    pub accepted: f64,
    /// Value now; NaN if the case was not run.
    pub found: f64,
    /// |found - accepted| / accepted.
    pub relative_change: f64,
}

impl Drift {
    /// Whether the value has not moved.
    pub fn held(&self) -> bool {
        self.relative_change <= TOLERANCE
    }
}

/// Compares results with every accepted value.
///
/// # Panics
/// Never: a test reads the baselines.
pub fn compare(results: &[CaseResult]) -> Vec<Drift> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(ACCEPTED.as_bytes());
    let mut drifts = Vec::new();
    for row in reader.deserialize::<Accepted>() {
        let row = row.expect("the baselines hold");
        let found = results.iter().find(|r| r.variant == Variant::Base && r.case == row.case);
        let mut note = |norm: &str, accepted: f64, value: fn(&CaseResult) -> f64| {
            let found = found.map_or(f64::NAN, value);
            let relative_change = ((found - accepted) / accepted).abs();
            drifts.push(Drift { case: row.case.clone(), norm: norm.to_owned(), accepted, found, relative_change });
        };
        note("max_error_terzaghi", row.max_error_terzaghi, |r| r.max_error_terzaghi);
        note("max_error_compressible", row.max_error_compressible, |r| r.max_error_compressible);
    }
    drifts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::result;

    #[test]
    fn a_moved_or_missing_error_is_a_drift() {
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(ACCEPTED.as_bytes());
        let rows: Vec<Accepted> = reader.deserialize().map(|row| row.expect("the baselines hold")).collect();
        assert!(!rows.is_empty());
        let mut results: Vec<CaseResult> = rows
            .iter()
            .map(|row| {
                let mut r = result(0.1, 1, "surface");
                r.case.clone_from(&row.case);
                (r.max_error_terzaghi, r.max_error_compressible) = (row.max_error_terzaghi, row.max_error_compressible);
                r
            })
            .collect();
        assert!(compare(&results).iter().all(Drift::held));
        results[0].max_error_terzaghi *= 1.0 + 1e-5;
        assert_eq!(compare(&results).iter().filter(|d| !d.held()).count(), 1);
        results.remove(0);
        assert_eq!(compare(&results).iter().filter(|d| !d.held()).count(), 2);
    }
}

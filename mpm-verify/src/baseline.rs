//! Accepted errors of the study: regression values, against ourselves, not against truth.
//!
//! The truth is checked by the ladder. This says whether a change of the code has moved a number. [`ladder`] does the
//! same for the ladder's own errors.

pub mod ladder;

use serde::{Deserialize, Serialize};

use crate::study::{CaseResult, Variant};

/// `reference-data/baselines/errors.csv`.
const ACCEPTED: &str = include_str!("../../reference-data/baselines/errors.csv");
/// Errors may move by this much relative to themselves: other machines round their elementary functions differently.
const TOLERANCE: f64 = 1e-6;

/// A row of the baselines. Below `floor` a change is round-off: a quasi-static error of 1e-7 is the difference of two
/// numbers that linear solves leave uncertain in the last digits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Accepted {
    case: String,
    max_error_terzaghi: f64,
    max_error_compressible: f64,
    floor: f64,
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
    /// Largest absolute change that is round-off.
    pub floor: f64,
}

impl Drift {
    /// Whether the value has not moved.
    pub fn held(&self) -> bool {
        self.relative_change <= TOLERANCE || (self.found - self.accepted).abs() <= self.floor
    }
}

/// Compares results with every accepted value.
///
/// # Panics
/// Never: a test reads the baselines.
pub fn compare(results: &[CaseResult]) -> Vec<Drift> {
    compare_with(ACCEPTED, results)
}

fn compare_with(accepted: &str, results: &[CaseResult]) -> Vec<Drift> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(accepted.as_bytes());
    let mut drifts = Vec::new();
    for row in reader.deserialize::<Accepted>() {
        let row = row.expect("the baselines hold");
        let found = results.iter().find(|r| r.variant == Variant::Base && r.case == row.case);
        let mut note = |norm: &str, accepted: f64, value: fn(&CaseResult) -> f64| {
            let found = found.map_or(f64::NAN, value);
            let relative_change = ((found - accepted) / accepted).abs();
            let (case, norm, floor) = (row.case.clone(), norm.to_owned(), row.floor);
            drifts.push(Drift { case, norm, accepted, found, relative_change, floor });
        };
        note("max_error_terzaghi", row.max_error_terzaghi, |r| r.max_error_terzaghi);
        note("max_error_compressible", row.max_error_compressible, |r| r.max_error_compressible);
    }
    drifts
}

/// First line of the baselines.
const LABEL: &str = "# regression: errors of the default study as accepted, against ourselves; the truth is checked by \
                     `mpm-verify check`";
/// Absolute change that is round-off where linear systems are solved.
const SOLVED: f64 = 1e-9;

/// The baselines as they would be with these results: to be put in place of the old ones once a change is accepted.
pub fn accepted(results: &[CaseResult]) -> String {
    let mut lines = vec![LABEL.to_owned(), "case,max_error_terzaghi,max_error_compressible,floor".to_owned()];
    for r in results.iter().filter(|r| r.variant == Variant::Base && r.failure.is_none()) {
        let floor = if r.integrator == "explicit" { 0.0 } else { SOLVED };
        lines.push(format!("{},{:?},{:?},{floor:?}", r.case, r.max_error_terzaghi, r.max_error_compressible));
    }
    lines.join("\n") + "\n"
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

    #[test]
    fn what_is_accepted_holds_and_only_round_off_of_solves_may_move() {
        let mut explicit = result(0.1, 1, "surface");
        explicit.max_error_compressible = 2.5e-7;
        let solved = "quasi-static-bspline2-surface-L0.1-ppc9";
        let mut implicit = CaseResult { integrator: "quasi-static".to_owned(), ..explicit.clone() };
        solved.clone_into(&mut implicit.case);
        explicit.max_error_terzaghi = 0.1;
        implicit.max_error_terzaghi = 0.1;
        let mut results = [explicit, implicit];
        let text = accepted(&results);
        assert!(text.starts_with("# regression") && compare_with(&text, &results).iter().all(Drift::held));
        for result in &mut results {
            result.max_error_compressible += 1e-10;
        }
        let drifted = compare_with(&text, &results);
        let moved: Vec<&str> = drifted.iter().filter(|d| !d.held()).map(|d| d.case.as_str()).collect();
        assert_eq!(moved, ["explicit-centre-surface-L0.1-ppc1"]);
        results[1].max_error_compressible += 1e-8;
        assert_eq!(compare_with(&text, &results).iter().filter(|d| !d.held()).count(), 2);
    }
}

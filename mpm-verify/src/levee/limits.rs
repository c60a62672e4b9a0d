//! What a run must keep to whatever happens in it: ledgers that close, stresses within the strength, fields without patterns.

use crate::report::numbers::short;

use super::run::Ended;
use super::summary::Summary;

/// A number of a run beside what it may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// What it is.
    pub name: &'static str,
    /// Largest over the run; none if it was not found.
    pub found: Option<f64>,
    /// What it may be at most.
    pub allowed: f64,
    /// Unit.
    pub unit: &'static str,
}

impl Limit {
    /// Whether it was found and is small enough.
    pub fn held(&self) -> bool {
        self.found.is_some_and(|found| found <= self.allowed)
    }

    /// In one line.
    pub fn said(&self) -> String {
        let found = self.found.map_or_else(|| "not found".to_owned(), |found| short(found, 3));
        format!("{}: {found}, at most {} {} expected", self.name, short(self.allowed, 2), self.unit)
    }
}

/// All limits of a run. The one on displacements is that of soil that water does not yet reach: it stands.
pub fn of(s: &Summary) -> [Limit; 7] {
    let limit = |name, found, allowed, unit| Limit { name, found, allowed, unit };
    [
        limit("dry mass: largest error", s.solid_mass_error, 1e-12, "share"),
        limit("ledger of the water: largest gap", s.water_ledger_error, 1e-12, "share"),
        limit("ledger of energies: largest gap", s.energy_error, 0.02, "share"),
        limit("stress outside the yield surface", s.yield_residual_max, 1e-9, "share"),
        limit("checkerboard index of the pore pressure", s.checkerboard_index_max, 0.01, "share"),
        limit("motion in hourglass modes", s.hourglass_ratio_max, 0.05, "share"),
        limit(
            "largest displacement before water is at the toe",
            s.max_displacement_before_failure_m,
            s.displacement_allowed_m,
            "m",
        ),
    ]
}

/// What is wrong with how a levee that must fail has ended. Half a run keeps to every limit.
pub fn unfinished(ended: &str, trouble: Option<&str>) -> Option<String> {
    let why = trouble.map_or_else(String::new, |why| format!(": {why}"));
    (ended != Ended::Collapsed.words()).then(|| format!("ended as {ended}, collapsed expected{why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_levee_that_does_not_collapse_is_told() {
        assert_eq!(unfinished(Ended::Collapsed.words(), None), None);
        assert!(unfinished(Ended::TimeOver.words(), None).is_some());
        let told = unfinished(Ended::Failed(String::new()).words(), Some("step 7")).expect("told");
        assert_eq!(told, "ended as run-failed, collapsed expected: step 7");
    }

    #[test]
    fn what_was_not_found_or_is_no_number_does_not_hold() {
        let limit = |found: Option<f64>| Limit { name: "gap", found, allowed: 0.02, unit: "share" };
        assert!(limit(Some(0.02)).held() && limit(Some(0.0)).held());
        for found in [None, Some(f64::NAN), Some(0.021), Some(f64::INFINITY)] {
            assert!(!limit(found).held(), "{found:?}");
        }
        assert_eq!(limit(Some(0.021)).said(), "gap: 0.0210, at most 0.020 share expected");
    }
}

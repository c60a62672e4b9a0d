//! The checks of every run: balances, stresses within the yield surface, fields without patterns.

use mpm_core::failure::Row;
use serde::{Deserialize, Serialize};

use crate::report::numbers::short;

use super::run::Ended;
use super::summary::Summary;

/// Balances of mass and of water: round-off of sums over the particles.
const ROUND_OFF: f64 = 1e-12;
/// Balance of energy, as a share of the works and losses booked.
const ENERGY: f64 = 0.02;

/// Whether the balances of a run close, as the summary of `solve` says it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trust {
    /// `closed`, or `not closed` from [`Self::since_s`] on.
    pub verdict: String,
    /// The balance that came nearest to its bound, or went furthest beyond it.
    pub ledger: String,
    /// Its largest gap, as a share of the mass, of the water, or of the works and losses booked.
    pub gap: f64,
    /// What was allowed.
    pub allowed: f64,
    /// Since when it does not close, s.
    pub since_s: Option<f64>,
}

impl Trust {
    /// That of the rows of a run with so much soil (kg) and water (m3).
    pub fn of(rows: &[Row], mass: f64, water: f64) -> Option<Self> {
        let share = |gap: f64, of: f64| if of > 0.0 { (gap / of).abs() } else { gap.abs() };
        let mut since = None;
        let mut worst: Option<(&str, f64, f64)> = None;
        for row in rows {
            let balances = [
                ("dry mass", share(row.solid_residual_kg, mass), ROUND_OFF),
                ("water", share(row.water_residual_m3, water), ROUND_OFF),
                ("energy", row.energy_error.abs(), ENERGY),
            ];
            for (ledger, gap, allowed) in balances {
                // A gap that is not a number does not close.
                if gap.is_nan() || gap > allowed {
                    since = since.or(Some(3600.0 * row.time_h));
                }
                if worst.is_none_or(|(_, most, of)| gap.is_nan() || gap / allowed > most / of) {
                    worst = Some((ledger, gap, allowed));
                }
            }
        }
        let verdict = if since.is_none() { "closed" } else { "not closed" };
        worst.map(|(ledger, gap, allowed)| Self {
            verdict: verdict.to_owned(),
            ledger: ledger.to_owned(),
            gap,
            allowed,
            since_s: since,
        })
    }

    /// What is wrong, if something is.
    pub fn trouble(&self) -> Option<String> {
        let Self { ledger, gap, allowed, since_s, .. } = self;
        since_s.map(|since| {
            format!(
                "the balance residual of {ledger}, {gap:.1e}, exceeds its bound {allowed:.0e} from {:.1} h on; the results after that \
                 are not to be trusted",
                since / 3600.0
            )
        })
    }
}

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
    pub fn passed(&self) -> bool {
        self.found.is_some_and(|found| found <= self.allowed)
    }

    /// In one line.
    pub fn said(&self) -> String {
        let found = self.found.map_or_else(|| "not measured".to_owned(), |found| short(found, 3));
        format!("{}: {found}, tolerance {} {}", self.name, short(self.allowed, 2), self.unit)
    }
}

/// All limits of a run. The one on displacements is that of soil that water does not yet reach: it stands.
pub fn of(s: &Summary) -> [Limit; 7] {
    let limit = |name, found, allowed, unit| Limit { name, found, allowed, unit };
    [
        limit("balance residual of dry mass", s.solid_mass_error, ROUND_OFF, "share"),
        limit("balance residual of water", s.water_ledger_error, ROUND_OFF, "share"),
        limit("balance residual of energy", s.energy_error, ENERGY, "share"),
        limit("largest violation of the yield function", s.yield_residual_max, 1e-9, "share"),
        limit("checkerboard index of the pore pressure", s.checkerboard_index_max, 0.01, "share"),
        limit("share of motion in hourglass modes", s.hourglass_ratio_max, 0.05, "share"),
        limit(
            "displacement before water reaches the toe",
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
    fn a_balance_that_does_not_close_is_named_since_when() {
        let row = |time_h, energy_error| Row { time_h, energy_error, ..Row::default() };
        let told = |errors: [f64; 3]| {
            let rows: Vec<Row> = errors.iter().enumerate().map(|(i, e)| row(f64::from(i as u32), *e)).collect();
            let trust = Trust::of(&rows, 1.0, 1.0).expect("rows");
            (trust.verdict.clone(), trust.ledger.clone(), trust.since_s, trust.trouble().is_some())
        };
        let closed = ("closed".to_owned(), "energy".to_owned(), None, false);
        assert_eq!(told([0.0, 0.01, 0.015]), closed);
        let open = |since| ("not closed".to_owned(), "energy".to_owned(), Some(since), true);
        assert_eq!(told([0.0, 0.03, 0.01]), open(3600.0));
        assert_eq!(told([0.0, 0.01, f64::NAN]), open(7200.0));
    }

    #[test]
    fn what_was_not_found_or_is_no_number_does_not_hold() {
        let limit = |found: Option<f64>| Limit { name: "gap", found, allowed: 0.02, unit: "share" };
        assert!(limit(Some(0.02)).passed() && limit(Some(0.0)).passed());
        for found in [None, Some(f64::NAN), Some(0.021), Some(f64::INFINITY)] {
            assert!(!limit(found).passed(), "{found:?}");
        }
        assert_eq!(limit(Some(0.021)).said(), "gap: 0.0210, tolerance 0.020 share");
    }
}

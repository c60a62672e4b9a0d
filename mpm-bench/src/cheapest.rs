//! The cheapest setting for a wanted error, per integrator.
//!
//! The error is that against compressible water, the physics of the scene. A setting only counts if every run that
//! differs from it in nothing but a shorter step or a tighter tolerance reaches the wanted error too: errors of cells
//! and of steps have opposite signs at times, and a setting where they happen to cancel is no advice.

use mpm_verify::report::numbers::exact;

use crate::baseline::{self, Kind};
use crate::row::Row;

/// The errors that users want, as shares of U.
pub const WANTED: [f64; 5] = [1e-2, 3e-3, 1e-3, 2e-4, 1e-4];

/// The cheapest setting of an integrator for a wanted error: a line of `cheapest.csv`.
#[derive(Debug, Clone, PartialEq)]
pub struct Cheapest<'a> {
    /// The wanted error.
    pub wanted: f64,
    /// The setting.
    pub row: &'a Row,
    /// The cheapest settings of the plain and of the graded baseline for the same error.
    pub baselines: [Option<&'a Row>; 2],
}

/// Columns of `cheapest.csv`. Others parse them: columns are only ever added at the end.
pub const COLUMNS: &str = "wanted_error,integrator,scheme,mesh_m,ppc,dt_or_tol,cpu_s,ratio_to_baseline,\
max_error_compressible,max_error_terzaghi,cpu_low_s,cpu_high_s,runs,steps,solves,peak_bytes,method,case,\
baseline_case,baseline_cpu_s,graded_case,graded_cpu_s,ratio_to_graded";

impl Cheapest<'_> {
    /// CPU time over that of the plain and of the graded baseline; NaN where it does not get there.
    pub fn ratios(&self) -> [f64; 2] {
        self.baselines.map(|baseline| baseline.map_or(f64::NAN, |b| self.row.cpu_s / b.cpu_s))
    }

    /// The fields of the CSV.
    pub fn fields(&self) -> Vec<String> {
        let r = self.row;
        let ([plain, graded], [to_plain, to_graded]) = (self.baselines, self.ratios());
        let name = |b: Option<&Row>| b.map_or_else(String::new, |b| b.case.clone());
        let cpu = |b: Option<&Row>| exact(b.map_or(f64::NAN, |b| b.cpu_s));
        vec![
            exact(self.wanted),
            r.integrator.clone(),
            r.scheme.clone(),
            exact(r.mesh_m),
            r.ppc.to_string(),
            exact(r.dt_or_tol),
            exact(r.cpu_s),
            exact(to_plain),
            exact(r.max_error_compressible),
            exact(r.max_error_terzaghi),
            exact(r.cpu_low_s),
            exact(r.cpu_high_s),
            r.runs.to_string(),
            r.steps.to_string(),
            r.solves.to_string(),
            r.peak_bytes.to_string(),
            r.method.clone(),
            r.case.clone(),
            name(plain),
            cpu(plain),
            name(graded),
            cpu(graded),
            exact(to_graded),
        ]
    }
}

/// The error that a setting is sure to reach: the largest of its own and of those with finer steps and all else equal.
/// Infinite if one of them failed.
pub fn sure_error(row: &Row, rows: &[Row]) -> f64 {
    let own = |r: &Row| {
        if r.failure.is_none() && r.max_error_compressible.is_finite() {
            r.max_error_compressible
        } else {
            f64::INFINITY
        }
    };
    let finer = rows.iter().filter(|r| r.dt_or_tol < row.dt_or_tol && r.same_but_time(row)).map(own);
    finer.fold(own(row), f64::max)
}

/// Whether a setting reaches an error, and goes on reaching it as its steps get finer.
fn reaches(row: &Row, rows: &[Row], wanted: f64) -> bool {
    row.max_error_compressible <= wanted && sure_error(row, rows) <= wanted
}

/// The cheapest of the settings that `which` takes for a wanted error.
///
/// Tolerances that lead to the same computation differ by the noise of their times alone: the loosest of them is named.
pub fn cheapest(rows: &[Row], wanted: f64, which: impl Fn(&Row) -> bool) -> Option<&Row> {
    let reached = || rows.iter().filter(|r| which(r) && r.cpu_s.is_finite() && reaches(r, rows, wanted));
    let least = reached().min_by(|a, b| a.cpu_s.total_cmp(&b.cpu_s))?;
    let work = |r: &Row| (r.steps, r.solves, r.max_error_compressible.to_bits());
    let same = reached().filter(|r| r.same_but_time(least) && work(r) == work(least));
    same.max_by(|a, b| a.dt_or_tol.total_cmp(&b.dt_or_tol))
}

/// The setting that is good for the smallest error, of those that `which` takes, and that error.
pub fn best(rows: &[Row], which: impl Fn(&Row) -> bool) -> Option<(&Row, f64)> {
    let mut sound: Vec<&Row> = rows.iter().filter(|r| which(r) && r.max_error_compressible.is_finite()).collect();
    sound.sort_by(|a, b| a.max_error_compressible.total_cmp(&b.max_error_compressible));
    let mut least: Option<(&Row, f64)> = None;
    for row in sound {
        // No later row can do better than its own error.
        if least.is_some_and(|(_, error)| error <= row.max_error_compressible) {
            break;
        }
        let error = sure_error(row, rows);
        if least.is_none_or(|(_, before)| error < before) {
            least = Some((row, error));
        }
    }
    least.filter(|(_, error)| error.is_finite())
}

/// For each wanted error one row per integrator that reaches it, the cheapest first.
pub fn table(rows: &[Row]) -> Vec<Cheapest<'_>> {
    let mut all = Vec::new();
    for wanted in WANTED {
        let of = |name: &str| cheapest(rows, wanted, |r| r.integrator == name);
        let baselines = Kind::ALL.map(|kind| cheapest(rows, wanted, |r| r.scheme == kind.scheme()));
        let mut own: Vec<&Row> =
            baseline::with_integrators().iter().filter(|n| !baseline::is(n)).filter_map(|n| of(n)).collect();
        own.sort_by(|a, b| a.cpu_s.total_cmp(&b.cpu_s));
        all.extend(own.into_iter().map(|row| Cheapest { wanted, row, baselines }));
    }
    all
}

/// Cost of a wanted error with an integrator and a kind of shape functions: a line of `cost.csv`.
#[derive(Debug, Clone, PartialEq)]
pub struct Cost<'a> {
    /// The wanted error.
    pub wanted: f64,
    /// The cheapest setting that reaches it, or the one that is sure to reach the smallest error.
    pub row: &'a Row,
    /// The error that this setting is sure to reach.
    pub error: f64,
}

/// Columns of `cost.csv`. Others parse them: columns are only ever added at the end.
pub const COST_COLUMNS: &str =
    "integrator,scheme,wanted_error,reached,error,cpu_s,mesh_m,ppc,dt_or_tol,steps,method,particles,case";

impl Cost<'_> {
    /// Whether the setting is sure to reach the wanted error.
    pub fn is_reached(&self) -> bool {
        self.error <= self.wanted
    }

    /// The fields of the CSV.
    pub fn fields(&self) -> Vec<String> {
        let r = self.row;
        let names = vec![r.integrator.clone(), r.scheme.clone()];
        let numbers = vec![exact(self.wanted), self.is_reached().to_string(), exact(self.error), exact(r.cpu_s)];
        let setting = vec![exact(r.mesh_m), r.ppc.to_string(), exact(r.dt_or_tol), r.steps.to_string()];
        [names, numbers, setting, vec![r.method.clone(), r.particles.to_string(), r.case.clone()]].concat()
    }
}

/// For each integrator with each kind of shape functions, in the order in which they were run, one line per wanted error.
pub fn costs(rows: &[Row]) -> Vec<Cost<'_>> {
    let mut pairs: Vec<(&str, &str)> = Vec::new();
    for row in rows {
        let pair = (row.integrator.as_str(), row.scheme.as_str());
        if !pairs.contains(&pair) {
            pairs.push(pair);
        }
    }
    let cost = |(integrator, scheme), wanted| {
        let own = move |r: &Row| (r.integrator.as_str(), r.scheme.as_str()) == (integrator, scheme);
        let (row, error) = match cheapest(rows, wanted, own) {
            Some(row) => (row, sure_error(row, rows)),
            None => best(rows, own)?,
        };
        Some(Cost { wanted, row, error })
    };
    pairs.into_iter().flat_map(|pair| WANTED.into_iter().filter_map(move |wanted| cost(pair, wanted))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::tests::row;

    #[test]
    fn the_cheapest_comes_first_with_its_ratio() {
        let rows = [
            row("explicit", 0.02, 1e-6, 2.5e-3, 0.5),
            row("quasi-static", 0.2, 1e-3, 2e-3, 3e-5),
            row("quasi-static", 0.1, 1e-3, 1e-5, 6e-5),
            Row { scheme: Kind::Plain.scheme().to_owned(), ..row("baseline", 0.1, 1e-2, 2e-3, 6e-5) },
        ];
        let table = table(&rows);
        let at = |wanted: f64| -> Vec<(f64, f64)> {
            table.iter().filter(|c| c.wanted == wanted).map(|c| (c.row.cpu_s, c.ratios()[0])).collect()
        };
        assert_eq!(at(3e-3), [(3e-5, 0.5), (0.5, 0.5 / 6e-5)]);
        let fine = at(2e-4);
        assert!(fine.len() == 1 && fine[0].0 == 6e-5 && fine[0].1.is_nan(), "the baseline does not get there");
    }

    #[test]
    fn errors_that_cancel_by_chance_do_not_count() {
        let rows = [
            row("quasi-static", 0.2, 1e-2, 1e-4, 1e-5),
            row("quasi-static", 0.2, 1e-3, 5e-4, 2e-5),
            row("quasi-static", 0.1, 1e-3, 1e-4, 4e-5),
        ];
        assert_eq!(cheapest(&rows, 2e-4, |_| true), Some(&rows[2]));
        assert_eq!(cheapest(&rows, 1e-3, |_| true), Some(&rows[0]));
        assert_eq!(best(&rows, |_| true), Some((&rows[2], 1e-4)));
    }

    #[test]
    fn of_tolerances_that_lead_to_the_same_computation_the_loosest_is_named() {
        let rows = [row("quasi-static", 0.2, 1e-2, 1e-4, 1.1e-5), row("quasi-static", 0.2, 1e-3, 1e-4, 1.0e-5)];
        assert_eq!(cheapest(&rows, 2e-4, |_| true), Some(&rows[0]));
    }

    #[test]
    fn a_cost_is_of_the_scheme_that_its_line_names() {
        let linear = Row { scheme: "linear".to_owned(), ..row("semi-implicit", 0.04, 1e-3, 8e-4, 1e-3) };
        let rows = [row("semi-implicit", 0.02, 1e-3, 5e-3, 2e-3), row("semi-implicit", 0.01, 1e-3, 2e-3, 9e-3), linear];
        let costs = costs(&rows);
        assert_eq!(costs.len(), 2 * WANTED.len(), "every cell of the table has numbers");
        assert!(costs.iter().all(|c| c.fields().len() == COST_COLUMNS.split(',').count()));
        let centre =
            |wanted: f64| costs.iter().find(|c| c.row.scheme == "centre" && c.wanted == wanted).expect("a cost");
        assert_eq!((centre(1e-2).row.cpu_s, centre(1e-2).is_reached()), (2e-3, true));
        assert_eq!((centre(1e-3).error, centre(1e-3).row.cpu_s, centre(1e-3).is_reached()), (2e-3, 9e-3, false));
    }

    #[test]
    fn a_failed_run_is_no_setting() {
        let mut failed = row("explicit", 0.1, 1e-6, f64::NAN, 1e-9);
        failed.failure = Some("blown up".to_owned());
        assert_eq!(cheapest(&[failed], 1.0, |_| true), None);
    }

    #[test]
    fn the_first_columns_are_the_contract_and_every_field_has_one() {
        let contract = "wanted_error,integrator,scheme,mesh_m,ppc,dt_or_tol,cpu_s,ratio_to_baseline";
        assert!(COLUMNS.starts_with(contract));
        let rows = [row("explicit", 0.02, 1e-6, 2.5e-3, 0.5)];
        assert_eq!(table(&rows)[0].fields().len(), COLUMNS.split(',').count());
    }
}

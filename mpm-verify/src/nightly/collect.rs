//! What the parts of a nightly run have found: their numbers, each with how far it may move and the page of its case, and the
//! checks that failed.
//!
//! An explicit run follows from its scene to the last bit but for the elementary functions of the system's library; where
//! systems are solved, or a path is chaotic (soil that slides), more may move without anyone having changed the program.

use super::part::Measured;
use crate::book::anchor;
use crate::levee::limits::Limit;
use crate::levee::summary::Summary as LeveeSummary;
use crate::report::orders;
use crate::stability::map;
use crate::stress::{MatrixRow, Verdict};
use crate::study::{CaseResult, Variant};
use crate::sweeps::Sweeps;

use crate::experiment::accepted::{self, LAST_DIGITS, ORDER, SOLVED};
use crate::experiment::number::{Label, Number, Tolerance};
use crate::experiment::verdict::CaseRow;

/// Limits of steps by bisection.
const BISECTED: Tolerance = Tolerance { relative: 1e-3, absolute: 1e-6 };
/// Values of stress tests, some of them noise.
const STRESS: Tolerance = Tolerance { relative: 0.05, absolute: 1e-9 };

/// Largest error of U relative to the exact solution with finite bulk modulus of the pore water.
pub const ERROR: &str = "max_error_compressible";

/// Page of the orders of convergence and the sweeps.
const CONVERGENCE: &str = "accuracy/convergence.html";

/// Errors, work and orders of the study, errors of its sweeps, and what accuracy costs in counts.
pub fn study(results: &[CaseResult], sweeps: &Sweeps) -> Measured {
    let (limits, failed_limits) = sweeps.limits();
    let finished = results.iter().filter(|r| r.failure.is_none()).count();
    let failed = results.iter().filter(|r| r.failure.is_some()).map(|r| format!("{} failed", r.case));
    let of_sweeps =
        (failed_limits > 0).then(|| format!("{failed_limits} of {limits} limits of the sweeps are exceeded"));
    Measured::of([(finished, "cases"), (limits, "limits of the sweeps")])
        .with(of_study(results, sweeps))
        .failed(failed.chain(of_sweeps))
}

fn of_study(results: &[CaseResult], sweeps: &Sweeps) -> Vec<Number> {
    let mut measures = Vec::new();
    for r in results.iter().filter(|r| r.variant == Variant::Base) {
        let explicit = r.integrator == "explicit";
        let tolerance = Tolerance {
            relative: LAST_DIGITS,
            absolute: if explicit { 0.0 } else { SOLVED.max(r.tolerance.unwrap_or(0.0)) },
        };
        let page = format!("accuracy/cases.html#{}", anchor(&r.case));
        let error = |quantity, value| Number::new(&r.case, quantity, Label::Verified, value, tolerance).at(&page);
        measures.push(error("max_error_terzaghi", r.max_error_terzaghi));
        measures.push(error(ERROR, r.max_error_compressible));
        let counted = Tolerance::relative(if explicit { 0.0 } else { 0.02 });
        let count =
            |quantity, value: u64| Number::new(&r.case, quantity, Label::Count, value as f64, counted).at(&page);
        measures.push(count("steps", r.steps));
        if !explicit {
            measures.push(count("solves", r.solves));
            measures.push(count("factorisations", r.factorisations));
        }
    }
    for group in orders::groups(results) {
        for (norm, fit) in group.fits {
            // Two meshes have an order, but nothing says how good it is.
            if let (Some(fit), true) = (fit.fit, norm.ends_with("compressible") && group.meshes.len() > 2) {
                let order = Number::new(&group.name, &format!("{norm}_order"), Label::Verified, fit.order, ORDER);
                measures.push(order.at(format!("{CONVERGENCE}#orders")));
            }
        }
    }
    measures.extend(swept(sweeps));
    measures.extend(costs(results));
    measures
}

/// Largest errors of the sweeps, per scheme and mesh.
fn swept(sweeps: &Sweeps) -> Vec<Number> {
    let mut measures: Vec<Number> = Vec::new();
    let mut add = |case: String, section: &str, value: f64| {
        let known = measures.iter_mut().find(|m| m.case == case);
        match known {
            // A NaN stays.
            Some(m) if value > m.value || value.is_nan() => m.value = value,
            Some(_) => {}
            None => {
                let tolerance = Tolerance { relative: LAST_DIGITS, absolute: SOLVED };
                let error = Number::new(&case, "largest_error", Label::Verified, value, tolerance);
                measures.push(error.at(format!("{CONVERGENCE}#{section}")));
            }
        }
    };
    for row in &sweeps.displaced {
        let name = format!("displaced-{}-{}-{}-L{}", row.kind, row.scheme, row.quadrature, row.mesh_m);
        add(name, "places", row.max_error_compressible);
    }
    for row in &sweeps.shifted {
        let name = format!("shifted-{}-{}-L{}", row.scheme, row.quadrature, row.mesh_m);
        add(name, "places", row.max_error_compressible);
    }
    for row in &sweeps.time {
        let of = row.tolerance.map(|t| format!("tolerance{t}")).or(row.step_share.map(|s| format!("share{s:.3}")));
        let name = format!("time-{}-L{}-{}", row.label().replace(' ', "-"), row.mesh_m, of.unwrap_or_default());
        add(name, "time", row.time_error);
    }
    measures
}

/// Errors that are asked for.
pub const WANTED: [f64; 4] = [1e-2, 3e-3, 1e-3, 2e-4];
/// What the names of cases begin with that hold the cost of a sweep.
pub const SPEED: &str = "speed-";

/// Name of the least work for an error of U.
pub fn cost_for(wanted: f64) -> String {
    format!("cost_for_{wanted:e}")
}

/// What the cheapest case of each family costs that is accurate enough, in point-steps, or solves times particles.
fn costs(results: &[CaseResult]) -> Vec<Number> {
    let mut families: Vec<String> = Vec::new();
    for r in results.iter().filter(|r| r.variant == Variant::Base && r.load == "surface") {
        let family = r.family();
        if !families.contains(&family) {
            families.push(family);
        }
    }
    let cost = |r: &CaseResult| {
        let work = if r.integrator == "quasi-static" { r.solves } else { r.steps };
        work as f64 * r.particles as f64
    };
    let cheapest = |family: &str, wanted: f64| {
        let good = results.iter().filter(|r| {
            r.variant == Variant::Base
                && r.load == "surface"
                && r.family() == family
                && r.max_error_compressible <= wanted
        });
        good.map(cost).fold(f64::INFINITY, f64::min)
    };
    let mut measures = Vec::new();
    for family in &families {
        for wanted in WANTED {
            let value = cheapest(family, wanted);
            if value.is_finite() {
                let (case, counted) = (format!("{SPEED}{family}"), Tolerance::relative(0.02));
                measures.push(Number::new(&case, &cost_for(wanted), Label::Count, value, counted).at("#speed"));
            }
        }
    }
    measures
}

/// First letters of the names of all numbers of stress tests.
pub const STRESS_TESTS: &str = "stress-";

/// Errors and orders of the cases of the suite, and those that failed.
pub fn suite(rows: &[CaseRow], failed: &[String]) -> Measured {
    let exceeded = rows.iter().filter(|row| !row.passed()).map(|row| format!("{}: {}", row.case, row.reason));
    let numbers = accepted::numbers(rows).into_iter();
    let numbers = numbers.map(|number| Number { page: format!("suite/{}/index.html", number.case), ..number });
    Measured::of([(rows.len(), "cases")]).with(numbers.collect()).failed(failed.iter().cloned().chain(exceeded))
}

/// Random scenes, relations that were checked, and those that failed.
pub fn metamorphic(scenes: usize, relations: usize, failed: Vec<String>) -> Measured {
    Measured::of([(scenes, "scenes"), (relations, "relations")]).failed(failed)
}

/// Verdicts and values of the stress tests, limits of steps over theory and of `auto` over what was measured.
pub fn stability(matrix: &[MatrixRow], summaries: &[map::Summary]) -> Measured {
    Measured::of([(matrix.len(), "schemes in stress tests"), (summaries.len(), "groups of time-step limits")])
        .with(of_stability(matrix, summaries))
}

fn of_stability(matrix: &[MatrixRow], summaries: &[map::Summary]) -> Vec<Number> {
    let page = |section: &str| format!("stability/index.html#{section}");
    let mut measures = Vec::new();
    for row in matrix {
        let case = format!("{STRESS_TESTS}{}-{}-{}", row.case, row.integrator, row.scheme).replace(' ', "-");
        let grade = match row.verdict {
            Verdict::Passed => 0.0,
            Verdict::Degraded => 1.0,
            Verdict::Stopped => 2.0,
            Verdict::Failed => 3.0,
        };
        let verdict = Number::new(&case, "verdict", Label::Regression, grade, Tolerance::relative(0.0));
        measures.push(verdict.at(page("matrix")));
        if let Some(value) = row.value.filter(|v| v.is_finite()) {
            measures.push(Number::new(&case, "value", Label::Regression, value, STRESS).at(page("matrix")));
        }
    }
    for s in summaries {
        let case = format!("limit-{}-{}-{}", s.scheme, s.dimension, s.darcy).replace(' ', "-");
        let four = [
            ("theory_low", s.ratio[0]),
            ("theory_high", s.ratio[1]),
            ("auto_low", s.auto[0]),
            ("auto_high", s.auto[1]),
        ];
        let limit = |(name, value)| Number::new(&case, name, Label::Regression, value, BISECTED).at(page("steps"));
        measures.extend(four.map(limit));
    }
    measures
}

/// Limits of the levee's run, and its numbers.
pub fn levee(limits: &[Limit], numbers: Vec<Number>) -> Measured {
    let failed = limits.iter().filter(|limit| !limit.passed()).map(Limit::said);
    Measured::of([(limits.len(), "limits")]).with(numbers).failed(failed)
}

/// Snapshot values of the levee. Its failure hangs on the last digit: what differs is by how much such runs differ from one
/// another where they are stopped for a look at other times.
pub fn of_levee(summary: &LeveeSummary) -> Vec<Number> {
    let rows: [(&str, Option<f64>, Tolerance); 11] = [
        ("front_at_toe_h", summary.front_at_toe_h, Tolerance::relative(1e-3)),
        ("first_outflow_h", summary.first_outflow_h, Tolerance::relative(1e-3)),
        ("raveling_h", summary.raveling_h, Tolerance::relative(0.03)),
        ("failure_start_h", summary.failure_start_h, Tolerance::relative(0.03)),
        ("end_h", summary.end_h, Tolerance::relative(0.03)),
        ("toe_m", summary.toe_x_m, Tolerance::relative(0.05)),
        ("crest_settlement_m", summary.crest_settlement_m, Tolerance::relative(0.5)),
        ("failure_at_m", summary.failure_at_m, Tolerance::relative(0.1)),
        ("energy_error", summary.energy_error, Tolerance { relative: 0.0, absolute: 0.01 }),
        ("water_ledger_error", summary.water_ledger_error, Tolerance { relative: 0.0, absolute: 1e-12 }),
        ("steps", Some(summary.steps as f64), Tolerance::relative(0.2)),
    ];
    rows.into_iter()
        .map(|(name, value, tolerance)| {
            let label = if name == "steps" { Label::Count } else { Label::Regression };
            Number::new("levee", name, label, value.unwrap_or(f64::NAN), tolerance).at("levee/index.html")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::result;

    #[test]
    fn the_cheapest_that_is_accurate_enough_is_told() {
        let with = |mesh: f64, error: f64, steps: u64, particles: usize| {
            let mut r = result(mesh, 4, "surface");
            (r.max_error_compressible, r.steps, r.particles) = (error, steps, particles);
            r
        };
        let results = [with(0.1, 5e-2, 10, 10), with(0.05, 5e-3, 20, 20), with(0.02, 2e-3, 40, 50)];
        let told: Vec<(String, f64)> = costs(&results).into_iter().map(|m| (m.quantity, m.value)).collect();
        assert_eq!(told, [("cost_for_1e-2".to_owned(), 400.0), ("cost_for_3e-3".to_owned(), 2000.0)]);
    }

    #[test]
    fn names_are_not_given_twice() {
        let results = [result(0.1, 4, "surface"), result(0.05, 4, "surface"), result(0.1, 1, "surface")];
        let measures = study(&results, &Sweeps::default()).numbers;
        for (place, one) in measures.iter().enumerate() {
            assert!(!measures[..place].iter().any(|m| m.is_of(&one.case, &one.quantity)), "{one:?}");
        }
    }
}

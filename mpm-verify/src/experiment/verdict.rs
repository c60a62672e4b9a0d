//! What a case found, and the one rule by which it is judged.

use mpm_core::scene::Scene;
use serde::{Deserialize, Serialize};

use super::comparison::Comparison;
use super::number::Label;
use super::refinement::{MESH, Parameter, RUNS, Refinement, RefinementRow, SampleRow, Sampled, spacings};
use crate::rates::{Convergence, Fit, Order, largest_of_last_two, round_off};
use crate::report::numbers::{brief, short};
use crate::verdict::State;

/// What a case is called.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Named {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows, against what.
    pub about: &'static str,
    /// The fault that its mutant has.
    pub mutant: Option<&'static str>,
}

/// What a case found, before it is judged.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outcome {
    pub integrator: String,
    pub scheme: String,
    /// Tolerance of the runs in time: their results are the same up to that.
    pub tolerance: f64,
    /// (refinement parameter, signed error), or a single entry where there is nothing to refine.
    pub errors: Vec<(f64, f64)>,
    /// Largest error allowed at the smallest parameter.
    pub required_error: f64,
    /// Order of theory, if the case converges.
    pub required_order: Option<f64>,
    /// Errors of at most so much are round-off, or what the tolerance of the runs in time leaves.
    pub floor: f64,
    /// Largest error allowed at every parameter, as a share of the parameter.
    pub required_everywhere: Option<f64>,
    /// What the refinement parameter is, with its unit.
    pub refined_by: Parameter,
    /// Further numbers of the finest run: quantity, value, unit (`-` if it has none). Reported, not judged.
    pub notes: Vec<(String, f64, String)>,
    /// The finest run at every sample time.
    pub samples: Vec<Sampled>,
    /// The finest run beside the reference, for the pictures of the case.
    pub comparisons: Vec<Comparison>,
    /// The scene of the finest run, where one shows what the case is about.
    pub scene: Option<Scene>,
    /// Refinements by anything else; judged as each of them says.
    pub refinements: Vec<Refinement>,
    /// What the errors are errors against, which is what their baseline is worth.
    pub kind: Label,
    /// What is said of an error beside its number; part of the reason.
    pub remarks: Vec<String>,
}

/// Refined by the mesh, against truth, without notes: what most cases leave as it is.
impl Default for Outcome {
    fn default() -> Self {
        Self {
            integrator: String::new(),
            scheme: String::new(),
            tolerance: 0.0,
            errors: Vec::new(),
            required_error: f64::NAN,
            required_order: None,
            floor: round_off(1.0),
            required_everywhere: None,
            refined_by: MESH,
            notes: Vec::new(),
            samples: Vec::new(),
            comparisons: Vec::new(),
            scene: None,
            refinements: Vec::new(),
            kind: Label::Verified,
            remarks: Vec::new(),
        }
    }
}

/// A judged case: a row of `cases.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseRow {
    /// Name of the case.
    pub case: String,
    /// Time integrator.
    pub integrator: String,
    /// Shape scheme and Darcy operator.
    pub scheme: String,
    /// Error on the finest mesh where the order is established; else the largest of the last two meshes.
    pub error: f64,
    /// Largest error allowed.
    pub required_error: f64,
    /// Fitted order of convergence.
    pub order: Option<f64>,
    /// Lower end of its 95 % interval.
    pub order_low: Option<f64>,
    /// Upper end.
    pub order_high: Option<f64>,
    /// Order of theory; empty where none is expected.
    pub required_order: String,
    /// Passed, not established (the errors are small enough, the order is open) or failed.
    pub verdict: State,
    /// CPU time of the case, s.
    pub cpu_s: f64,
    /// Why the verdict is what it is, with numbers.
    pub reason: String,
    /// Whether the errors fall as in an asymptotic range; nothing where there is no order.
    pub asymptotic: Option<bool>,
    /// Accepted error; nothing where none was accepted.
    pub baseline: Option<f64>,
    /// What the baseline is worth.
    pub baseline_kind: Label,
    /// Error over the accepted one.
    pub change: Option<f64>,
    /// Tolerance of the runs in time, by which the error may move without a change of the program.
    pub tolerance: f64,
    /// Verdict on the order.
    #[serde(default)]
    pub order_verdict: Order,
}

impl CaseRow {
    /// Whether the case did not fail: it passed, or its errors are small enough and its order is not established.
    pub fn passed(&self) -> bool {
        self.verdict != State::Failed
    }

    /// Whether its errors are small enough, but do not say that they fall with the order that they should.
    pub fn open(&self) -> bool {
        self.verdict == State::NotEstablished
    }
}

/// A case that was run: its row, and what its picture shows.
#[derive(Debug, Clone)]
pub struct Judged {
    /// The case.
    pub case: Named,
    /// Its row of `cases.csv`.
    pub row: CaseRow,
    /// Why the verdict is what it is, with numbers.
    pub reason: String,
    /// (refinement parameter, signed error).
    pub errors: Vec<(f64, f64)>,
    /// Largest error allowed at every parameter, as a share of the parameter.
    pub everywhere: Option<f64>,
    /// The order of the errors beside that of theory.
    pub convergence: Convergence,
    /// Order of theory.
    pub required_order: Option<f64>,
    /// Errors of at most so much are round-off.
    pub floor: f64,
    /// What the refinement parameter is, with its unit.
    pub refined_by: Parameter,
    /// Further numbers: quantity, value, unit.
    pub notes: Vec<(String, f64, String)>,
    /// The finest run at every sample time.
    pub samples: Vec<Sampled>,
    /// The finest run beside the reference.
    pub(crate) comparisons: Vec<Comparison>,
    /// The scene of the finest run.
    pub scene: Option<Scene>,
    /// Refinements by anything else.
    pub refinements: Vec<Refinement>,
    /// Whether the case's own rule holds, whatever its baseline says.
    pub sound: bool,
}

impl Judged {
    /// The rows of `samples.csv`.
    pub fn sample_rows(&self) -> impl Iterator<Item = SampleRow> {
        self.samples.iter().map(|s| SampleRow {
            case: self.row.case.clone(),
            quantity: s.quantity.clone(),
            time_s: s.time,
            time_factor: s.factor,
            computed: s.computed,
            exact: s.exact,
            error: s.error,
            unit: s.unit.clone(),
            counts: s.counts,
        })
    }

    /// All refinements, that of the case's own errors first.
    pub fn all_refinements(&self) -> Vec<Refinement> {
        let own = Refinement::new(self.refined_by, self.errors.clone(), "what the case compares with");
        let own = Refinement { required_order: self.required_order, floor: self.floor, ..own };
        std::iter::once(own).filter(|own| own.errors.len() > 1).chain(self.refinements.iter().cloned()).collect()
    }

    /// The rows of `refinements.csv`.
    pub fn refinement_rows(&self) -> Vec<RefinementRow> {
        let mut rows = Vec::new();
        for refinement in self.all_refinements() {
            let found = refinement.convergence();
            let (fit, ends) = (found.fit.as_ref(), found.fit.as_ref().and_then(Fit::interval));
            rows.extend(refinement.errors.iter().map(|(parameter, error)| RefinementRow {
                case: self.row.case.clone(),
                by: refinement.by.0.to_owned(),
                parameter: *parameter,
                unit: refinement.by.1.to_owned(),
                error: *error,
                order: fit.map(|f| f.order),
                order_low: ends.map(|[low, _]| low),
                order_high: ends.map(|[_, high]| high),
                asymptotic: fit.map(|f| f.asymptotic),
                required_order: found.theory_words(),
                against: refinement.against.clone(),
                order_verdict: found.order,
            }));
        }
        rows
    }

    /// Marks the case as failed for a reason that its own rule does not know.
    pub(crate) fn fail(&mut self, why: &str) {
        self.row.verdict = State::Failed;
        self.reason = format!("{}; {why}", self.reason);
        self.row.reason.clone_from(&self.reason);
    }
}

/// The one rule. The error is small enough: that of the finest mesh where the order is established, else the largest of the
/// last two. No established order is another one than that of theory. The same holds for all refinements.
pub(crate) fn judge(case: Named, outcome: Outcome, cpu_s: f64) -> Judged {
    let lengths = spacings(outcome.refined_by, &outcome.errors);
    let convergence = Convergence::new(&lengths, outcome.required_order, outcome.floor);
    let (error, required_error) = judged_error(&outcome, convergence.order);
    // A number that is not one must not pass.
    let too_large = |share: f64| outcome.errors.iter().find(|(h, e)| e.is_nan() || e.abs() > share * h).copied();
    let exceeded = outcome.required_everywhere.and_then(|share| Some((share, too_large(share)?)));
    let fallen: Vec<String> = outcome.refinements.iter().filter_map(Refinement::failed).collect();
    let open: Vec<String> = outcome.refinements.iter().filter_map(Refinement::open).collect();
    let holds =
        error <= required_error && convergence.order != Order::Failed && exceeded.is_none() && fallen.is_empty();
    let established = convergence.order != Order::NotEstablished && open.is_empty();
    let fit = convergence.fit.as_ref().filter(|_| convergence.order != Order::NotExpected);
    let ends = fit.and_then(Fit::interval);
    let mut row = CaseRow {
        case: case.name.to_owned(),
        integrator: outcome.integrator,
        scheme: outcome.scheme,
        error,
        required_error,
        order: fit.map(|f| f.order),
        order_low: ends.map(|[low, _]| low),
        order_high: ends.map(|[_, high]| high),
        required_order: convergence.theory_words(),
        verdict: match (holds, established) {
            (false, _) => State::Failed,
            (true, true) => State::Passed,
            (true, false) => State::NotEstablished,
        },
        cpu_s,
        reason: String::new(),
        asymptotic: fit.map(|f| f.asymptotic),
        baseline: None,
        baseline_kind: outcome.kind,
        change: None,
        tolerance: outcome.tolerance,
        order_verdict: convergence.order,
    };
    let own = reason(&row, &convergence, exceeded);
    row.reason = std::iter::once(own).chain(fallen).chain(open).chain(outcome.remarks).collect::<Vec<_>>().join("; ");
    Judged {
        reason: row.reason.clone(),
        case,
        row,
        errors: outcome.errors,
        everywhere: outcome.required_everywhere,
        convergence,
        required_order: outcome.required_order,
        floor: outcome.floor,
        refined_by: outcome.refined_by,
        notes: outcome.notes,
        samples: outcome.samples,
        comparisons: outcome.comparisons,
        scene: outcome.scene,
        refinements: outcome.refinements,
        sound: holds,
    }
}

/// The error that is judged and the largest that is allowed: on the finest mesh where the order is established, or where
/// nothing was refined; else on the one of the last two that is further off, with what is allowed there.
fn judged_error(outcome: &Outcome, order: Order) -> (f64, f64) {
    let lengths = spacings(outcome.refined_by, &outcome.errors);
    let finest = lengths.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or((f64::NAN, f64::NAN), |(h, e)| (*h, e.abs()));
    if matches!(order, Order::Passed | Order::Failed | Order::RoundOff) || outcome.refined_by == RUNS {
        return (finest.1, outcome.required_error);
    }
    let error = largest_of_last_two(&lengths);
    let coarser = lengths.iter().find(|(h, e)| e.abs() == error && *h > finest.0);
    let allowed = coarser.and_then(|(h, _)| Some(outcome.required_everywhere? * h));
    (error, allowed.map_or(outcome.required_error, |allowed| allowed.max(outcome.required_error)))
}

/// The verdict in numbers.
fn reason(row: &CaseRow, convergence: &Convergence, exceeded: Option<(f64, (f64, f64))>) -> String {
    if let Some((share, (parameter, error))) = exceeded {
        let [error, allowed] = [error.abs(), share * parameter].map(|x| short(x, 3));
        return format!("error {error} above {allowed} at {}", brief(parameter, 3));
    }
    let (found, most) = (short(row.error, 3), brief(row.required_error, 3));
    let error = match row.error <= row.required_error {
        true => format!("error {found}, at most {most}"),
        false if row.error.is_nan() => format!("the error is not a number; at most {most}"),
        false => format!("error {found} above {most}"),
    };
    match convergence.order {
        Order::NotExpected => error,
        Order::NotEstablished => format!("{error} on the last two meshes; {}", convergence.sentence()),
        _ => format!("{error}; {}", convergence.sentence()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(outcome: Outcome) -> Judged {
        let case = Named { name: "an example", about: "", mutant: None };
        judge(case, outcome, 0.0)
    }

    #[test]
    fn every_kind_of_check_can_fail() {
        let errors = vec![(0.2, 4e-2), (0.1, 1e-2), (0.05, 2.5e-3), (0.025, 6.25e-4)];
        let good = Outcome { errors, required_error: 1e-3, required_order: Some(2.0), ..Outcome::default() };
        let held = judged(good.clone());
        assert!(held.row.passed() && held.reason == "error 0.000625, at most 0.001; order 2.00 ± 0.00, theory 2");
        assert_eq!(held.row.verdict, State::Passed);
        let too_large = judged(Outcome { required_error: 5e-4, ..good.clone() });
        assert!(!too_large.row.passed() && too_large.reason.starts_with("error 0.000625 above 0.0005"));
        let wrong_order = judged(Outcome { required_order: Some(3.0), ..good.clone() });
        assert!(!wrong_order.row.passed() && wrong_order.reason.ends_with("order 2.00 ± 0.00, theory 3"));
        let everywhere = judged(Outcome { required_everywhere: Some(0.08), ..good.clone() });
        assert!(!everywhere.row.passed() && everywhere.reason == "error 0.0400 above 0.0160 at 0.2");
        let everywhere = judged(Outcome { required_everywhere: Some(0.21), ..good.clone() });
        assert!(everywhere.row.passed());
        let nothing = Outcome { errors: vec![(0.1, f64::NAN)], ..good.clone() };
        assert!(!judged(nothing.clone()).row.passed() && judged(nothing.clone()).reason.contains("not a number"));
        let flat = [8e-6, 4e-6, 2e-6, 1e-6].map(|step| (step, 1e-3)).to_vec();
        let flat = Refinement::new(crate::experiment::refinement::STEP, flat, "");
        let step = Refinement { required_order: Some(1.0), ..flat };
        let refined = judged(Outcome { refinements: vec![step], ..good.clone() });
        assert!(!refined.row.passed(), "{}", refined.reason);
        assert!(refined.reason.ends_with("refined by time step: order 0.00 ± 0.00, theory 1"));
        assert_eq!((refined.row.reason.as_str(), refined.refinement_rows().len()), (refined.reason.as_str(), 8));
        let not_a_number = judged(Outcome { required_order: None, ..nothing });
        assert!(!not_a_number.row.passed() && not_a_number.reason.starts_with("the error is not a number"));
    }

    #[test]
    fn an_order_that_is_not_established_is_neither_passed_nor_failed() {
        // `contrast-k` as it was: 5.7 +- 19 for "3 to 7" from three meshes.
        let errors = vec![(0.1, 3e-4), (0.05, 2e-7), (0.025, 1.1e-7)];
        let three = Outcome { errors, required_error: 1e-6, required_order: Some(4.0), ..Outcome::default() };
        let found = judged(three.clone());
        assert_eq!((found.row.verdict, found.row.passed(), found.row.open()), (State::NotEstablished, true, true));
        assert_eq!(found.row.error, 2e-7);
        assert!(found.reason.contains("order not established (5.71 from only 3 runs), theory 4"), "{}", found.reason);
        // The error that is judged is the larger one of the last two.
        let found = judged(Outcome { required_error: 1.5e-7, ..three });
        assert_eq!((found.row.verdict, found.row.error), (State::Failed, 2e-7));
        // Without an order at all as well: a mesh near a change of sign is luck.
        let errors = vec![(0.1, 0.0062), (0.05, 0.013), (0.025, 5.2e-5)];
        let exit = Outcome { errors, required_error: 0.0125, required_everywhere: Some(0.5), ..Outcome::default() };
        let found = judged(exit.clone());
        assert_eq!((found.row.error, found.row.required_error, found.row.verdict), (0.013, 0.025, State::Passed));
        assert!(!judged(Outcome { required_everywhere: None, ..exit }).row.passed());
        // A refinement whose order is open leaves the case open.
        let errors = vec![(4e-6, 4e-3), (2e-6, 2e-3), (1e-6, 1e-3)];
        let step = Refinement::new(crate::experiment::refinement::STEP, errors, "");
        let step = Refinement { required_order: Some(1.0), ..step };
        let one =
            Outcome { errors: vec![(0.1, 1e-3)], required_error: 2e-3, refinements: vec![step], ..Outcome::default() };
        let found = judged(one);
        assert!(
            found.row.open() && found.reason.contains("refined by time step: order not established"),
            "{}",
            found.reason
        );
    }
}

//! What a rung found, and the one rule by which it is judged.

use serde::{Deserialize, Serialize};

use super::Rung;
use crate::rates::{Fit, fit};
use crate::report::numbers::{brief, short};

/// What a rung found, before it is judged.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Outcome {
    pub integrator: String,
    pub scheme: String,
    /// (refinement parameter, signed error), or a single entry where there is nothing to refine.
    pub errors: Vec<(f64, f64)>,
    /// Largest error allowed at the smallest parameter.
    pub required_error: f64,
    /// Allowed interval of the fitted order, if the case converges.
    pub required_order: Option<[f64; 2]>,
    /// Largest error allowed at every parameter, as a share of the parameter.
    pub required_everywhere: Option<f64>,
    /// What the refinement parameter is, with its unit.
    pub refined_by: (&'static str, &'static str),
    /// Further numbers of the finest run: quantity, value, unit (`-` if it has none). Reported, not judged.
    pub notes: Vec<(String, f64, String)>,
}

/// Refined by the mesh, without notes: what most rungs leave as it is.
impl Default for Outcome {
    fn default() -> Self {
        Self {
            integrator: String::new(),
            scheme: String::new(),
            errors: Vec::new(),
            required_error: f64::NAN,
            required_order: None,
            required_everywhere: None,
            refined_by: ("mesh L", "m"),
            notes: Vec::new(),
        }
    }
}

/// A judged rung: a row of `ladder.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Name of the rung.
    pub rung: String,
    /// Time integrator.
    pub integrator: String,
    /// Shape scheme and Darcy operator.
    pub scheme: String,
    /// Error on the finest mesh.
    pub error: f64,
    /// Largest error allowed.
    pub required_error: f64,
    /// Fitted order of convergence.
    pub order: Option<f64>,
    /// Lower end of its 95 % interval.
    pub order_low: Option<f64>,
    /// Upper end.
    pub order_high: Option<f64>,
    /// What the order must be.
    pub required_order: String,
    /// `held` or `fell short`.
    pub verdict: String,
    /// CPU time of the rung, s.
    pub cpu_s: f64,
}

impl Step {
    /// Whether the rung holds.
    pub fn held(&self) -> bool {
        self.verdict == "held"
    }
}

/// A rung that was climbed: its row, and what its picture shows.
#[derive(Debug, Clone)]
pub struct Climb {
    /// The rung.
    pub rung: Rung,
    /// Its row of `ladder.csv`.
    pub step: Step,
    /// Why the verdict is what it is, with numbers.
    pub reason: String,
    /// (refinement parameter, signed error).
    pub errors: Vec<(f64, f64)>,
    /// Largest error allowed at every parameter, as a share of the parameter.
    pub everywhere: Option<f64>,
    /// The fitted order; `None` where there is none to fit or none is required.
    pub fit: Option<Fit>,
    /// What the refinement parameter is, with its unit.
    pub refined_by: (&'static str, &'static str),
    /// Further numbers: quantity, value, unit.
    pub notes: Vec<(String, f64, String)>,
}

/// The one rule: the finest error is small enough, and the order is in its interval.
pub(super) fn judge(rung: Rung, outcome: Outcome, cpu_s: f64) -> Climb {
    let finest = outcome.errors.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(f64::NAN, |(_, e)| e.abs());
    let fit: Option<Fit> = fit(&outcome.errors);
    let order_holds = match (outcome.required_order, &fit) {
        (None, _) => true,
        (Some([low, high]), Some(fit)) => (low..=high).contains(&fit.order),
        (Some(_), None) => false,
    };
    // A number that is not one must not pass.
    let too_large = |share: f64| outcome.errors.iter().find(|(h, e)| e.is_nan() || e.abs() > share * h).copied();
    let exceeded = outcome.required_everywhere.and_then(|share| Some((share, too_large(share)?)));
    let holds = finest <= outcome.required_error && order_holds && exceeded.is_none();
    let fit = fit.filter(|_| outcome.required_order.is_some());
    let step = Step {
        rung: rung.name.to_owned(),
        integrator: outcome.integrator,
        scheme: outcome.scheme,
        error: finest,
        required_error: outcome.required_error,
        order: fit.as_ref().map(|f| f.order),
        order_low: fit.as_ref().map(|f| f.order - f.half_width),
        order_high: fit.as_ref().map(|f| f.order + f.half_width),
        required_order: outcome.required_order.map_or(String::new(), |[low, high]| format!("{low} to {high}")),
        verdict: if holds { "held" } else { "fell short" }.to_owned(),
        cpu_s,
    };
    Climb {
        reason: reason(&step, order_holds, exceeded),
        rung,
        step,
        errors: outcome.errors,
        everywhere: outcome.required_everywhere,
        fit,
        refined_by: outcome.refined_by,
        notes: outcome.notes,
    }
}

/// The verdict in numbers.
fn reason(step: &Step, order_holds: bool, exceeded: Option<(f64, (f64, f64))>) -> String {
    if let Some((share, (parameter, error))) = exceeded {
        let [error, allowed] = [error.abs(), share * parameter].map(|x| short(x, 3));
        return format!("error {error} above {allowed} at {}", brief(parameter, 3));
    }
    let (error, required) = (short(step.error, 3), brief(step.required_error, 3));
    let error = match step.error <= step.required_error {
        true => format!("error {error}, at most {required}"),
        false if step.error.is_nan() => format!("the error is not a number; at most {required}"),
        false => format!("error {error} above {required}"),
    };
    match (step.order, order_holds) {
        _ if step.required_order.is_empty() => error,
        (Some(order), true) => format!("{error}; order {}, {}", short(order, 3), step.required_order),
        (Some(order), false) => format!("{error}; order {} outside of {}", short(order, 3), step.required_order),
        (None, _) => format!("{error}; no order can be fitted, {} required", step.required_order),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(outcome: Outcome) -> Climb {
        let rung = Rung { name: "made up", about: "", climb: || Err(String::new()), mutant: None };
        judge(rung, outcome, 0.0)
    }

    #[test]
    fn every_kind_of_check_can_fail() {
        let errors = vec![(0.1, 1e-2), (0.05, 2.5e-3), (0.025, 6.25e-4)];
        let good = Outcome { errors, required_error: 1e-3, required_order: Some([1.8, 2.2]), ..Outcome::default() };
        let held = judged(good.clone());
        assert!(held.step.held() && held.reason == "error 0.000625, at most 0.001; order 2.00, 1.8 to 2.2");
        let too_large = judged(Outcome { required_error: 5e-4, ..good.clone() });
        assert!(!too_large.step.held() && too_large.reason.starts_with("error 0.000625 above 0.0005"));
        let wrong_order = judged(Outcome { required_order: Some([2.8, 3.2]), ..good.clone() });
        assert!(!wrong_order.step.held() && wrong_order.reason.ends_with("order 2.00 outside of 2.8 to 3.2"));
        let everywhere = judged(Outcome { required_everywhere: Some(0.08), ..good.clone() });
        assert!(!everywhere.step.held() && everywhere.reason == "error 0.0100 above 0.00800 at 0.1");
        let everywhere = judged(Outcome { required_everywhere: Some(0.11), ..good.clone() });
        assert!(everywhere.step.held());
        let nothing = Outcome { errors: vec![(0.1, f64::NAN)], ..good };
        assert!(!judged(nothing.clone()).step.held() && judged(nothing.clone()).reason.contains("no order"));
        let not_a_number = judged(Outcome { required_order: None, ..nothing });
        assert!(!not_a_number.step.held() && not_a_number.reason.starts_with("the error is not a number"));
    }
}

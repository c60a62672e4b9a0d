//! What a case shows beside its one error: the values at every sample time, and what else was refined.

use serde::{Deserialize, Serialize};

use crate::rates::{Convergence, Order, largest_of_last_two, round_off};
use crate::verdict::State;

/// A refinement parameter: its name and its unit (`-` if it has none).
pub type Parameter = (&'static str, &'static str);

/// Refined by the edge of the cells.
pub const MESH: Parameter = ("mesh L", "m");
/// By the time step.
pub const STEP: Parameter = ("time step", "s");
/// By the tolerance of error-controlled time.
pub const TOLERANCE: Parameter = ("tolerance", "-");
/// By the number of particles. Its order is counted in their spacing, L/sqrt(N).
pub const PARTICLES: Parameter = ("particles per cell", "-");
/// Not refined: so many runs were compared.
pub const RUNS: Parameter = ("runs", "-");

/// A value of the finest run at a sample time, beside the exact one: a row of `samples.csv`.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    /// What it is: `U`, `p/p_0`, ...
    pub quantity: String,
    /// Its unit; `-` if it has none.
    pub unit: String,
    /// Time since the start of the stage, s.
    pub time: f64,
    /// The same as a time factor, where the case has one.
    pub factor: Option<f64>,
    /// What the run shows.
    pub computed: f64,
    /// What it should show.
    pub exact: f64,
    /// The error as the case counts it, signed.
    pub error: f64,
    /// Whether it counts: some cases look at late times only.
    pub counts: bool,
}

/// A refinement by something else than what the case's own errors are refined by.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// What was refined.
    pub by: Parameter,
    /// (parameter, signed error).
    pub errors: Vec<(f64, f64)>,
    /// What the error is measured against, and which order follows from that.
    pub against: String,
    /// Order of theory; `None` where none is expected.
    pub required_order: Option<f64>,
    /// Errors of at most so much are round-off.
    pub floor: f64,
    /// Largest error allowed at every parameter; `None` where that is not judged.
    pub required_error: Option<f64>,
    /// The same as a share of the parameter.
    pub required_share: Option<f64>,
    /// Largest error allowed at the smallest step or on the finest mesh.
    pub required_finest: Option<f64>,
}

impl Refinement {
    /// A refinement of which nothing is required.
    pub fn new(by: Parameter, errors: Vec<(f64, f64)>, against: impl Into<String>) -> Self {
        Self {
            by,
            errors,
            against: against.into(),
            required_order: None,
            floor: round_off(1.0),
            required_error: None,
            required_share: None,
            required_finest: None,
        }
    }

    /// The order that the errors show, beside that of theory.
    pub fn convergence(&self) -> Convergence {
        Convergence::new(&spacings(self.by, &self.errors), self.required_order, self.floor)
    }

    /// The verdict; `None` where nothing is required.
    pub fn state(&self) -> Option<State> {
        let required = [self.required_order, self.required_error, self.required_share, self.required_finest];
        required.iter().any(Option::is_some).then(|| match (self.failed(), self.open()) {
            (Some(_), _) => State::Failed,
            (None, Some(_)) => State::NotEstablished,
            (None, None) => State::Passed,
        })
    }

    /// What is said of an order that is not established; `None` where one is, or none is required.
    pub fn open(&self) -> Option<String> {
        let found = self.convergence();
        (found.order == Order::NotEstablished).then(|| format!("refined by {}: {}", self.by.0, found.sentence()))
    }

    /// The verdict in numbers if the refinement failed.
    pub fn failed(&self) -> Option<String> {
        let by = self.by.0;
        let most = |at: f64| {
            let share = self.required_share.map_or(f64::INFINITY, |share| share * at);
            share.min(self.required_error.unwrap_or(f64::INFINITY))
        };
        if let Some((at, error)) = self.errors.iter().find(|(at, error)| error.is_nan() || error.abs() > most(*at)) {
            return Some(format!("refined by {by}: error {:.2e} above {:.1e} at {at}", error.abs(), most(*at)));
        }
        let (found, lengths) = (self.convergence(), spacings(self.by, &self.errors));
        let finest = match found.order {
            Order::NotEstablished => largest_of_last_two(&lengths),
            _ => {
                let finest = lengths.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
                finest.map_or(f64::NAN, |(_, error)| error.abs())
            }
        };
        if let Some(most) = self.required_finest.filter(|most| finest.is_nan() || finest > *most) {
            return Some(format!("refined by {by}: finest error {finest:.2e} above {most:.1e}"));
        }
        (found.order == Order::Failed).then(|| format!("refined by {by}: {}", found.sentence()))
    }
}

/// What an order is fitted over: the parameter itself, or the spacing of so many particles in cells.
pub fn spacings(by: Parameter, errors: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let length = |x: f64| if by == PARTICLES { 1.0 / x.sqrt() } else { x };
    errors.iter().map(|(parameter, error)| (length(*parameter), *error)).collect()
}

/// A row of `refinements.csv`: one run of a refinement, beside the order of all of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RefinementRow {
    /// Name of the case.
    pub case: String,
    /// What was refined.
    pub by: String,
    /// Its value.
    pub parameter: f64,
    /// Its unit.
    pub unit: String,
    /// Signed error.
    pub error: f64,
    /// Fitted order.
    pub order: Option<f64>,
    /// Lower end of its 95 % interval; nothing for fewer than three runs.
    pub order_low: Option<f64>,
    /// Upper end.
    pub order_high: Option<f64>,
    /// Whether the range is asymptotic.
    pub asymptotic: Option<bool>,
    /// Order of theory; empty where none is expected.
    pub required_order: String,
    /// What the error is measured against.
    pub against: String,
    /// Verdict on the order.
    pub order_verdict: Order,
}

/// A row of `samples.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SampleRow {
    /// Name of the case.
    pub case: String,
    /// What was compared.
    pub quantity: String,
    /// Time since the start of the stage, s.
    pub time_s: f64,
    /// The same as a time factor.
    pub time_factor: Option<f64>,
    /// What the finest run shows.
    pub computed: f64,
    /// What it should show.
    pub exact: f64,
    /// The error as the case counts it, signed.
    pub error: f64,
    /// Unit of the values.
    pub unit: String,
    /// Whether the time counts for the error of the case.
    pub counts: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_refinement_can_fail() {
        let errors = vec![(8e-6, 8e-3), (4e-6, 4e-3), (2e-6, 2e-3), (1e-6, 1e-3)];
        let free = Refinement::new(STEP, errors, "");
        let good = Refinement { required_order: Some(1.0), required_error: Some(9e-3), ..free.clone() };
        assert_eq!((good.failed(), good.open()), (None, None));
        let steep = Refinement { required_order: Some(2.0), ..good.clone() };
        assert!(steep.failed().is_some_and(|why| why.ends_with("refined by time step: order 1.00 ± 0.00, theory 2")));
        let large = Refinement { required_error: Some(3e-3), ..good.clone() };
        assert!(large.failed().is_some_and(|why| why.contains("8.00e-3 above 3.0e-3 at 0.000008")));
        let share = Refinement { required_share: Some(500.0), ..good.clone() };
        assert!(share.failed().is_some_and(|why| why.contains("above 4.0e-3 at 0.000008")));
        assert_eq!((free.failed(), Refinement { required_share: Some(1001.0), ..free.clone() }.failed()), (None, None));
        let finest = Refinement { required_finest: Some(1.1e-3), ..free.clone() };
        assert_eq!(finest.failed(), None);
        let finest = Refinement { required_finest: Some(0.9e-3), ..free.clone() };
        assert!(finest.failed().is_some_and(|why| why.contains("finest error 1.00e-3 above 9.0e-4")));
        let few = Refinement { errors: good.errors[1..].to_vec(), required_finest: Some(1.1e-3), ..good.clone() };
        assert!(
            few.failed().is_some_and(|why| why.contains("finest error 2.00e-3 above")),
            "no order, so the last two"
        );
        let few = Refinement { required_finest: Some(2.1e-3), ..few };
        assert_eq!(few.failed(), None);
        assert!(few.open().is_some_and(|why| why.contains("order not established (1.00 from only 3 runs), theory 1")));
        let lost = Refinement { errors: vec![(4e-6, f64::NAN)], ..good.clone() };
        assert!(lost.failed().is_some());
        let nothing = Refinement { errors: Vec::new(), ..finest };
        assert!(nothing.failed().is_some_and(|why| why.contains("NaN")));
        let one = Refinement { errors: vec![(4e-6, 0.0)], required_error: None, ..good };
        assert!(one.open().is_some_and(|why| why.ends_with("order not established, theory 1")));
        assert_eq!((free.state(), one.state()), (None, Some(State::NotEstablished)), "nothing required, no verdict");
    }

    #[test]
    fn the_order_in_particles_is_that_in_their_spacing() {
        let errors = [1.0_f64, 4.0, 9.0, 16.0].map(|n| (n, 0.1 / n)).to_vec();
        let fit = Refinement::new(PARTICLES, errors, "").convergence().fit.expect("errors");
        assert!((fit.order - 2.0).abs() < 1e-9 && fit.asymptotic, "{fit:?}");
    }
}

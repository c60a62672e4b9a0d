//! Orders of convergence: fitted with a confidence interval, the one rule by which they are judged, and what a Richardson
//! extrapolation says.
//!
//! An order is *established* if the 95 % interval of [`LEAST_MESHES`] meshes or more is at most [`WIDEST`] to either side, and passes
//! if it then lies within [`FARTHEST`] of theory, on both sides. Errors at their floor are *round-off*. Elsewhere it is *not
//! established*, and the error alone decides. Three meshes leave one degree of freedom, for which Student's t is 12.7: whatever their
//! slope is, it says little.
//!
//! Sources: Roache, *Verification and Validation in Computational Science and Engineering*, 1998, chapter 5 (order,
//! Richardson value, grid convergence index); least squares and Student's t from any text on regression.

use serde::{Deserialize, Serialize};

use crate::verdict::State;

/// An order fitted through (mesh, error) pairs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// Slope of log(error) over log(mesh).
    pub order: f64,
    /// Half width of its 95 % confidence interval; infinite for fewer than three meshes.
    pub half_width: f64,
    /// Orders between neighbouring meshes, coarse to fine.
    pub pairwise: Vec<f64>,
    /// Whether the range is asymptotic: three meshes or more, an order surely above zero, every pairwise order within
    /// 0.3 of it, no change of sign.
    pub asymptotic: bool,
}

impl Fit {
    /// Both ends of the 95 % interval; `None` for fewer than three meshes.
    pub fn interval(&self) -> Option<[f64; 2]> {
        self.half_width.is_finite().then_some([self.order - self.half_width, self.order + self.half_width])
    }

    /// Whether the order is established.
    fn is_established(&self) -> bool {
        self.pairwise.len() + 1 >= LEAST_MESHES && self.half_width <= WIDEST
    }
}

/// Fewer meshes establish no order.
pub const LEAST_MESHES: usize = 4;
/// Largest half width of the 95 % interval of an order that is established.
pub const WIDEST: f64 = 0.3;
/// Largest distance of an established order from that of theory, on either side.
pub const FARTHEST: f64 = 0.5;
/// Orders of the schemes of other codes: any of these may be that of theory.
const WHOLE: [f64; 4] = [1.0, 2.0, 3.0, 4.0];

/// Largest error that is round-off: ten times the machine epsilon, for a condition number of what is solved and errors in shares of
/// what is measured.
pub fn round_off(condition: f64) -> f64 {
    10.0 * f64::EPSILON * condition
}

/// The order that theory gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Theory {
    /// None: errors that do not fall as a power of the mesh.
    None,
    /// A given order.
    Order(f64),
    /// A whole number from 1 to 4, which depends on a scheme that is not known here.
    Whole,
}

impl From<Option<f64>> for Theory {
    fn from(order: Option<f64>) -> Self {
        order.map_or(Self::None, Self::Order)
    }
}

impl Theory {
    /// The order of theory that is nearest to a fitted one.
    pub fn nearest(self, order: f64) -> Option<f64> {
        let off = |theory: &f64| (theory - order).abs();
        match self {
            Self::None => None,
            Self::Order(theory) => Some(theory),
            Self::Whole => WHOLE.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))),
        }
    }
}

/// Verdict on an order beside that of theory; its words are those of the columns `order_verdict`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Order {
    /// Theory gives none.
    #[default]
    #[serde(rename = "not expected")]
    NotExpected,
    /// Errors are as small as the arithmetic allows: nothing is left to fall.
    #[serde(rename = "round-off")]
    RoundOff,
    /// Too few meshes, or too much scatter. The error alone decides.
    #[serde(rename = "not established")]
    NotEstablished,
    /// Established, and that of theory.
    #[serde(rename = "passed")]
    Passed,
    /// Established, and another one.
    #[serde(rename = "failed")]
    Failed,
}

impl Order {
    /// The verdict in words.
    pub const fn word(self) -> &'static str {
        match self {
            Self::NotExpected => "not expected",
            Self::RoundOff => "round-off",
            Self::NotEstablished => "not established",
            Self::Passed => "passed",
            Self::Failed => "failed",
        }
    }
}

/// Errors on meshes beside the order of theory.
#[derive(Debug, Clone, PartialEq)]
pub struct Convergence {
    /// The fit over the errors above the floor; `None` where fewer than two are.
    pub fit: Option<Fit>,
    /// The order of theory.
    pub theory: Theory,
    /// The verdict.
    pub order: Order,
}

impl Convergence {
    /// Judges (mesh, signed error) pairs; errors of at most `floor` are round-off.
    pub fn new(points: &[(f64, f64)], theory: impl Into<Theory>, floor: f64) -> Self {
        let theory = theory.into();
        let above: Vec<(f64, f64)> =
            points.iter().copied().filter(|(_, error)| error.is_nan() || error.abs() > floor).collect();
        let fit = fit(&above);
        let off = |fit: &Fit| theory.nearest(fit.order).map(|theory| (fit.order - theory).abs());
        let order = match fit.as_ref().filter(|fit| fit.is_established()).and_then(off) {
            _ if theory == Theory::None => Order::NotExpected,
            Some(off) if off <= FARTHEST => Order::Passed,
            Some(_) => Order::Failed,
            None if points.len() >= 2 && above.len() < 2 && above.iter().all(|(_, error)| error.is_finite()) => {
                Order::RoundOff
            }
            None => Order::NotEstablished,
        };
        Self { fit, theory, order }
    }

    /// The state of the order; `None` where it says nothing.
    pub fn state(&self) -> Option<State> {
        match self.order {
            Order::NotExpected | Order::RoundOff => None,
            Order::NotEstablished => Some(State::NotEstablished),
            Order::Passed => Some(State::Passed),
            Order::Failed => Some(State::Failed),
        }
    }

    /// The fitted order with its 95 % interval, or of how few runs it is.
    pub fn fitted(&self) -> Option<String> {
        let fit = self.fit.as_ref()?;
        let meshes = fit.pairwise.len() + 1;
        let few = meshes < LEAST_MESHES;
        let [order, width] = [fit.order, fit.half_width].map(|x| format!("{x:.2}").replace("-0.00", "0.00"));
        Some(if few { format!("{order} from only {meshes} runs") } else { format!("{order} \u{b1} {width}") })
    }

    /// The order as a message and a table show it.
    pub fn words(&self) -> String {
        match self.order {
            Order::Passed | Order::Failed => self.fitted().unwrap_or_default(),
            Order::NotEstablished if self.fit.is_some() => {
                format!("{} ({})", self.order.word(), self.fitted().unwrap_or_default())
            }
            other => other.word().to_owned(),
        }
    }

    /// Part of a reason: `order 2.02 ± 0.02, theory 2`; empty where none is expected.
    pub fn sentence(&self) -> String {
        match self.order {
            Order::NotExpected => String::new(),
            _ => format!("order {}, theory {}", self.words(), self.theory_words()),
        }
    }

    /// The order of theory as a message and a table show it; empty for none.
    pub fn theory_words(&self) -> String {
        match self.theory {
            Theory::None => String::new(),
            Theory::Order(order) => order.to_string(),
            Theory::Whole => "1 to 4".to_owned(),
        }
    }
}

/// The largest error of the two finest meshes: what is judged where no order says how the finest came about. An error that
/// changes its sign passes through zero, and one mesh that happens to be near it proves nothing.
pub fn largest_of_last_two(points: &[(f64, f64)]) -> f64 {
    let mut points = points.to_vec();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let last = points.iter().take(2).map(|(_, error)| error.abs());
    if points.is_empty() { f64::NAN } else { crate::norms::largest(last) }
}

/// How far a pairwise order may be from the fitted one in an asymptotic range.
const SPREAD: f64 = 0.3;

/// Fits an order. `points` are (mesh, signed error), any order; the error's sign only matters for the flag.
///
/// Returns `None` for fewer than two meshes or an error that is zero or not finite.
pub fn fit(points: &[(f64, f64)]) -> Option<Fit> {
    let mut points = points.to_vec();
    points.sort_by(|a, b| b.0.total_cmp(&a.0));
    if points.len() < 2 || points.iter().any(|(h, e)| !(*h > 0.0 && e.is_finite() && *e != 0.0)) {
        return None;
    }
    let logs: Vec<(f64, f64)> = points.iter().map(|(h, e)| (h.ln(), e.abs().ln())).collect();
    let n = logs.len() as f64;
    let (mean_x, mean_y) = logs.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let sxx: f64 = logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    let sxy: f64 = logs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let order = sxy / sxx;
    let residual: f64 = logs.iter().map(|(x, y)| (y - mean_y - order * (x - mean_x)).powi(2)).sum();
    let half_width = match logs.len() {
        0..3 => f64::INFINITY,
        count => student_t(count - 2) * (residual / (n - 2.0) / sxx).sqrt(),
    };
    let pairwise: Vec<f64> = logs.windows(2).map(|w| (w[0].1 - w[1].1) / (w[0].0 - w[1].0)).collect();
    let one_sign = points.windows(2).all(|w| w[0].1.signum() == w[1].1.signum());
    // Two meshes have no scatter, and an order whose interval holds zero is a plateau.
    let certain = half_width.is_finite() && order > half_width;
    let asymptotic = certain && one_sign && pairwise.iter().all(|p| (p - order).abs() <= SPREAD);
    Some(Fit { order, half_width, pairwise, asymptotic })
}

/// Two-sided 95 % quantile of Student's t (Abramowitz & Stegun, table 26.10).
fn student_t(degrees: usize) -> f64 {
    const TABLE: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
    TABLE.get(degrees.wrapping_sub(1)).copied().unwrap_or(1.96)
}

/// What three meshes say about the value on an infinitely fine one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Richardson {
    /// Order observed from the three values alone.
    pub order: f64,
    /// Extrapolated value.
    pub value: f64,
    /// Grid convergence index of the finest mesh, relative, with Roache's factor 1.25 for three meshes.
    pub gci: f64,
}

/// Extrapolates from (mesh, value) pairs, coarse to fine, at any refinement ratios.
///
/// Returns `None` if the three values do not converge monotonically.
pub fn richardson(coarse: (f64, f64), middle: (f64, f64), fine: (f64, f64)) -> Option<Richardson> {
    let (e21, e32) = (middle.1 - fine.1, coarse.1 - middle.1);
    let (r21, r32) = (middle.0 / fine.0, coarse.0 / middle.0);
    if e21 * e32 <= 0.0 {
        return None;
    }
    // (h3^p - h2^p)/(h2^p - h1^p) = e32/e21, by bisection on p: the left side grows with p.
    let ratio = |p: f64| (r32.powf(p) - 1.0) / (1.0 - r21.powf(-p));
    let (mut low, mut high) = (1e-3, 12.0);
    let target = e32 / e21;
    if !(ratio(low)..=ratio(high)).contains(&target) {
        return None;
    }
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if ratio(middle) < target { low = middle } else { high = middle }
    }
    let order = low;
    let change = e21 / (r21.powf(order) - 1.0);
    Some(Richardson { order, value: fine.1 - change, gci: 1.25 * (change / fine.1).abs() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_power_law_is_recovered(order in 0.5f64..4.0, factor in 0.01f64..10.0) {
            let meshes = [0.1, 0.05, 0.02, 0.0125];
            let points = meshes.map(|h: f64| (h, factor * h.powf(order)));
            let fit = fit(&points).unwrap();
            prop_assert!((fit.order - order).abs() < 1e-9 && fit.half_width < 1e-6 && fit.asymptotic);
            let value = |h: f64| (h, 3.0 + factor * h.powf(order));
            let r = richardson(value(0.1), value(0.05), value(0.02)).unwrap();
            prop_assert!((r.order - order).abs() < 1e-6 && (r.value - 3.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_range_that_is_not_asymptotic_is_flagged() {
        assert!(!fit(&[(0.1, 1e-1), (0.05, 2.5e-2), (0.025, 2.4e-2)]).unwrap().asymptotic);
        assert!(!fit(&[(0.1, 1e-1), (0.05, -2.5e-2), (0.025, 6e-3)]).unwrap().asymptotic);
        assert!(!fit(&[(0.1, 1e-1), (0.05, 2.5e-2)]).unwrap().asymptotic);
        assert!(!fit(&[(0.1, 1.0e-2), (0.05, 0.98e-2), (0.025, 1.01e-2)]).unwrap().asymptotic);
        assert!(richardson((0.1, 1.0), (0.05, 2.0), (0.025, 1.0)).is_none());
    }

    /// Errors of the second order on meshes of half the cell each, off by shares.
    fn second<const N: usize>(scatter: [f64; N]) -> Vec<(f64, f64)> {
        let point = |(i, s): (i32, f64)| (0.1 / 2.0_f64.powi(i), (1.0 + s) * 1e-2 / 4.0_f64.powi(i));
        (0..).zip(scatter).map(point).collect()
    }

    #[test]
    fn an_established_order_passes_near_theory_on_both_sides() {
        let order = |points: &[(f64, f64)], theory: f64| Convergence::new(points, Some(theory), 0.0).order;
        let clean = second([0.0; 4]);
        for (theory, found) in
            [(2.0, Order::Passed), (1.51, Order::Passed), (1.49, Order::Failed), (2.51, Order::Failed)]
        {
            assert_eq!(order(&clean, theory), found, "{theory}");
        }
        assert_eq!(order(&clean[1..], 2.0), Order::NotEstablished, "three meshes");
        let wide = second([0.1, -0.1, 0.1, -0.25]);
        assert_eq!((order(&wide, 2.0), order(&wide, 9.0)), (Order::NotEstablished, Order::NotEstablished));
        let whole = |points: &[(f64, f64)]| Convergence::new(points, Theory::Whole, 0.0);
        let level = [0.1, 0.05, 0.025, 0.0125].map(|mesh| (mesh, 1e-3));
        assert_eq!((whole(&clean).order, whole(&level).order), (Order::Passed, Order::Failed));
        assert_eq!(whole(&level).words(), "0.00 \u{b1} 0.00");
    }

    /// The guide states the rule with the numbers of the program.
    #[test]
    fn the_guide_has_the_constants_of_the_rule() {
        let within = format!("within {FARTHEST} of");
        let [width, least] = [format!("at most ± {WIDEST}"), format!("at least {LEAST_MESHES}")];
        for guide in [include_str!("../docs/own-code.md"), include_str!("../docs/reports.md")] {
            for part in [&within, &width, &least] {
                assert!(guide.contains(part), "{part}");
            }
        }
        let whole = WHOLE.map(|order| order.to_string());
        assert!(include_str!("../docs/own-code.md").contains(&format!("of {} or {}", whole[..3].join(", "), whole[3])));
    }

    #[test]
    fn orders_that_say_nothing_are_neither_passed_nor_failed() {
        let judged = |errors: &[f64], theory: Theory, floor: f64| {
            let points: Vec<_> = (0..).zip(errors).map(|(i, error)| (0.1 / 2.0_f64.powi(i), *error)).collect();
            let found = Convergence::new(&points, theory, floor);
            (found.order, found.words())
        };
        // What the published leaderboard called passed: -1.83 +- 1.35 and 7.64 +- 16.09, and -10.2 from two meshes.
        let triaxial = [2.0e-15, -1.8e-14, -3.4e-14, 1.1e-13];
        assert_eq!(judged(&triaxial, Theory::Whole, round_off(480.0)), (Order::RoundOff, "round-off".to_owned()));
        let drains = judged(&[4.7e-4, 1.1e-5, 1.2e-8], Theory::Whole, 0.0);
        assert_eq!(drains, (Order::NotEstablished, "not established (7.63 from only 3 runs)".to_owned()));
        let series = judged(&[-2.6e-13, -2.9e-10], Theory::Whole, 0.0);
        assert_eq!(series, (Order::NotEstablished, "not established (-10.12 from only 2 runs)".to_owned()));
        // Particles do not change the error of the mesh: 8e-13 +- 6e-12.
        let constant = judged(&[1e-3, 1e-3 * (1.0 + 1e-12), 1e-3, 1e-3], Theory::None, 0.0);
        assert_eq!(constant, (Order::NotExpected, "not expected".to_owned()));
        // What falls to the floor is judged above it.
        let falls = [1e-2, 2.5e-3, 6.25e-4, 1.5625e-4, 0.0, 1e-17];
        assert_eq!(judged(&falls, Theory::Order(2.0), 1e-15).0, Order::Passed);
        assert_eq!(judged(&[f64::NAN, 1e-17], Theory::Order(2.0), 1e-15).0, Order::NotEstablished);
        assert_eq!(judged(&[1e-17], Theory::Order(2.0), 1e-15), (Order::NotEstablished, "not established".to_owned()));
    }

    #[test]
    fn one_mesh_near_a_change_of_sign_is_not_the_error() {
        // Height of a dam's exit point: 5.2e-5 m on the finest mesh is luck.
        assert_eq!(largest_of_last_two(&[(0.1, 0.0062), (0.05, -0.013), (0.025, 5.2e-5)]), 0.013);
        assert_eq!(largest_of_last_two(&[(0.1, -2e-3)]), 2e-3);
        assert!(largest_of_last_two(&[]).is_nan() && largest_of_last_two(&[(0.1, f64::NAN), (0.05, 1.0)]).is_nan());
    }

    #[test]
    fn the_confidence_interval_holds_the_scatter() {
        // Errors off a slope of 2 by 10 to 25 %; slope and interval from an independent regression program.
        let points = [(0.1, 1.1e-2), (0.05, 2.25e-3), (0.025, 6.875e-4), (0.0125, 1.40625e-4)];
        let fit = fit(&points).unwrap();
        assert!((fit.order - 2.057_901).abs() < 1e-6 && (fit.half_width - 0.352_32).abs() < 1e-4, "{fit:?}");
    }
}

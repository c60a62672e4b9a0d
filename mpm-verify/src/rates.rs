//! Orders of convergence: pairwise, fitted with a confidence interval, and what a Richardson extrapolation says.
//!
//! An order counts only where it is established: the 95 % interval of four meshes or more lies in the range that is
//! required. Three meshes leave one degree of freedom, for which Student's t is 12.7: whatever their slope is, it says little.
//!
//! Sources: Roache, *Verification and Validation in Computational Science and Engineering*, 1998, chapter 5 (order,
//! Richardson value, grid convergence index); least squares and Student's t from any text on regression.

use serde::{Deserialize, Serialize};

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

/// What the fitted order of some errors says about the order that they should have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// The 95 % interval of four meshes or more lies in the required range.
    Established,
    /// It lies outside of it as a whole: the errors have another order.
    Another,
    /// Neither: too few meshes, or too much scatter.
    NotEstablished,
}

/// Fewer meshes establish no order.
pub const LEAST_MESHES: usize = 4;

impl Fit {
    /// Both ends of the 95 % interval; `None` for fewer than three meshes.
    pub fn interval(&self) -> Option<[f64; 2]> {
        self.half_width.is_finite().then_some([self.order - self.half_width, self.order + self.half_width])
    }

    /// Whether these errors have an order in the range `low..=high`.
    pub fn shows(&self, [low, high]: [f64; 2]) -> Order {
        match self.interval().filter(|_| self.pairwise.len() + 1 >= LEAST_MESHES) {
            Some([from, to]) if low <= from && to <= high => Order::Established,
            Some([from, to]) if to < low || high < from => Order::Another,
            _ => Order::NotEstablished,
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

    #[test]
    fn an_order_is_established_by_the_interval_of_four_meshes() {
        let second = |scatter: [f64; 4]| {
            let point = |(i, s): (i32, f64)| (0.1 / 2.0_f64.powi(i), (1.0 + s) * 1e-2 / 4.0_f64.powi(i));
            (0..).zip(scatter).map(point).collect::<Vec<_>>()
        };
        let clean = second([0.0; 4]);
        assert_eq!(fit(&clean).unwrap().shows([1.8, 2.2]), Order::Established);
        assert_eq!(fit(&clean).unwrap().shows([2.8, 3.2]), Order::Another);
        assert_eq!(fit(&clean[1..]).unwrap().shows([1.8, 2.2]), Order::NotEstablished, "three meshes");
        let wide = fit(&second([0.1, -0.1, 0.1, -0.25])).unwrap();
        assert!((1.8..2.2).contains(&wide.order), "{wide:?}");
        assert_eq!((wide.shows([1.8, 2.2]), wide.shows([2.1, 9.0])), (Order::NotEstablished, Order::NotEstablished));
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

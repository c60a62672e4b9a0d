//! Integrals of functions that may be infinite at the ends.

use std::f64::consts::FRAC_PI_2;

/// Spacing of the nodes in the transformed variable: also what happens within 1e-7 of an end is resolved.
const SPACING: f64 = 1.0 / 64.0;
/// The last nodes are 1e-138 of the length from the ends: squares of distances do not vanish.
const LAST: f64 = 5.3;

/// Integral of `f` from `a` to `b`. `f` is given the distances (x - a, b - x): near an end they keep their digits, where
/// x itself has none left. Logarithms and powers above -0.9 at the ends lose nothing.
///
/// Tanh-sinh rule: x - a = (b - a)/(1 + exp(-pi sinh s)). Source: Takahasi & Mori 1974, Publ. RIMS 9(3),
/// doi:10.2977/prims/1195192451.
pub fn integral(f: impl Fn(f64, f64) -> f64, a: f64, b: f64) -> f64 {
    let length = b - a;
    if length == 0.0 {
        return 0.0;
    }
    let count = (LAST / SPACING) as i32;
    let node = |place: i32| {
        let s = f64::from(place) * SPACING;
        // Share of the interval on the near side of the node, and on the far one.
        let near = (-2.0 * FRAC_PI_2 * s.abs().sinh()).exp();
        let (small, large) = (near / (1.0 + near), 1.0 / (1.0 + near));
        let weight = 2.0 * FRAC_PI_2 * s.cosh() * small * large;
        let (left, right) = if s < 0.0 { (small, large) } else { (large, small) };
        weight * f(left * length, right * length)
    };
    // From the ends inwards: the smallest terms first.
    let pairs = (1..=count).rev().map(|place| node(place) + node(-place));
    SPACING * length * (pairs.sum::<f64>() + node(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_may_be_infinite() {
        let close = |value: f64, exact: f64| assert!((value / exact - 1.0).abs() < 1e-14, "{value} {exact}");
        close(integral(|x, _| x * x, 0.0, 3.0), 9.0);
        close(integral(|x, _| -x.ln(), 0.0, 1.0), 1.0);
        close(integral(|x, y| 1.0 / (x * y).sqrt(), -1.0, 4.0), std::f64::consts::PI);
        close(integral(|_, y| y.powf(-0.5) * y.ln(), 0.0, 1.0), -4.0);
    }
}

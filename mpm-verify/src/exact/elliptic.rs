//! The complete elliptic integral of the first kind.

use std::f64::consts::FRAC_PI_2;

/// K(m) with the parameter m = k^2, from the complement 1 - m > 0, which keeps its digits where m is nearly one. Also
/// for negative m.
///
/// `K = pi/(2 agm(1, sqrt(1 - m)))`. Source: Abramowitz & Stegun 1964, 17.6.3.
pub fn complete(complement: f64) -> f64 {
    let (mut a, mut b): (f64, f64) = (1.0, complement.sqrt());
    while (a - b).abs() > 1e-8 * a {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    // One more step squares what is left.
    FRAC_PI_2 / (0.5 * (a + b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_a_table() {
        // Abramowitz & Stegun, table 17.1; the lemniscate K(-1); K ~ ln(4/sqrt(1 - m)) near one.
        for (m, k) in
            [(0.0, FRAC_PI_2), (0.5, 1.854_074_677_301_372), (0.9, 2.578_092_113_348_173), (-1.0, 1.311_028_777_146_06)]
        {
            assert!((complete(1.0 - m) / k - 1.0).abs() < 1e-14, "{m}");
        }
        let tiny: f64 = 1e-200;
        assert!((complete(tiny) / (4.0 / tiny.sqrt()).ln() - 1.0).abs() < 1e-14);
    }
}

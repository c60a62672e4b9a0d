//! The zero of a function between two places where its signs differ.

/// Steps after which the bracket is as narrow as doubles allow, whatever the function.
const STEPS: usize = 200;

/// A zero of a continuous `f` between `low` and `high`, to round-off; `None` if the signs there do not differ or a value
/// is not a number.
///
/// Bisection, sped up by inverse quadratic interpolation where Chandrupatla's criterion trusts it: the bracket never
/// opens. Source: Chandrupatla 1997, Advances in Engineering Software 28(3), doi:10.1016/S0965-9978(96)00051-8.
pub fn root(f: impl Fn(f64) -> f64, low: f64, high: f64) -> Option<f64> {
    let (mut a, mut b) = (high, low);
    let (mut fa, mut fb) = (f(a), f(b));
    let (mut c, mut fc);
    let mut t = 0.5;
    if fa == 0.0 || fb == 0.0 {
        return Some(if fa == 0.0 { a } else { b });
    }
    if fa.is_nan() || fb.is_nan() || fa.signum() == fb.signum() {
        return None;
    }
    for _ in 0..STEPS {
        let x = a + t * (b - a);
        let fx = f(x);
        if fx.is_nan() {
            return None;
        }
        if fx.signum() == fa.signum() {
            (c, fc) = (a, fa);
        } else {
            (c, b, fc, fb) = (b, a, fb, fa);
        }
        (a, fa) = (x, fx);
        let (best, at_best) = if fa.abs() < fb.abs() { (a, fa) } else { (b, fb) };
        let narrowest = 2.0 * f64::EPSILON * best.abs() + f64::MIN_POSITIVE;
        let share = narrowest / (b - c).abs();
        if at_best == 0.0 || share > 0.5 || (b - a).abs() <= narrowest {
            return Some(best);
        }
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        let trusted = phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi;
        t = if trusted {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        t = t.clamp(share, 1.0 - share);
    }
    Some(a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_are_found_to_round_off() {
        let two = root(|x| x * x - 2.0, 0.0, 2.0).expect("a root");
        assert!((two - 2.0_f64.sqrt()).abs() < 1e-15, "{two}");
        // Flat on one side, steep on the other: false position would crawl.
        let steep = root(|x| x.powi(21) - 1e-21, 0.0, 10.0).expect("a root");
        assert!((steep - 0.1).abs() < 1e-15, "{steep}");
        assert_eq!(root(|x| x, 0.0, 1.0), Some(0.0));
    }

    #[test]
    fn there_is_no_root_without_a_change_of_sign() {
        assert_eq!(root(|x| x * x + 1.0, -1.0, 1.0), None);
        assert_eq!(root(|_| f64::NAN, -1.0, 1.0), None);
    }
}

//! The largest step at which nothing grows, by bisection.

/// A step that is stable and a longer one that is not, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bracket {
    /// Largest step seen to be stable, s; zero if none was.
    pub stable: f64,
    /// Smallest step seen to grow, s; infinite if none was.
    pub unstable: f64,
}

/// First distance from a guess, relative.
const FIRST: f64 = 0.01;
/// A guess may be off by this factor to either side: what is held to the dry skeleton may have a limit of its water's.
const FURTHEST: f64 = 1e9;

/// Narrows a bracket around the first limit near a `guess` (s) down to a relative `width`. `grows` says whether a step is
/// unstable. The guess only saves work: from there the search goes up and down in strides that double.
pub fn largest_stable(guess: f64, width: f64, mut grows: impl FnMut(f64) -> bool) -> Bracket {
    let mut bracket = Bracket { stable: 0.0, unstable: f64::INFINITY };
    let mut distance = FIRST;
    // Down to a step that holds; on the way, the ones that do not close the bracket from above.
    loop {
        let dt = guess * (-distance).exp();
        if !grows(dt) {
            bracket.stable = dt;
            break;
        }
        bracket.unstable = dt;
        distance *= 2.0;
        if distance > FURTHEST.ln() {
            return bracket;
        }
    }
    distance = FIRST;
    while bracket.unstable.is_infinite() {
        let dt = guess * distance.exp();
        if grows(dt) {
            bracket.unstable = dt;
        } else {
            bracket.stable = dt;
            distance *= 2.0;
        }
        if distance > FURTHEST.ln() {
            return bracket;
        }
    }
    while bracket.unstable > (1.0 + width) * bracket.stable {
        let middle = (bracket.stable * bracket.unstable).sqrt();
        if grows(middle) { bracket.unstable = middle } else { bracket.stable = middle }
    }
    bracket
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_found_from_any_guess() {
        for guess in [1e-3, 0.5, 0.995, 1.0, 1.005, 2.0, 1e3] {
            let mut runs = 0;
            let found = largest_stable(guess, 0.003, |dt| {
                runs += 1;
                dt > 1.0
            });
            assert!(found.stable <= 1.0 && found.unstable > 1.0, "{guess}: {found:?}");
            assert!(found.unstable <= 1.003 * found.stable && runs < 30, "{guess}: {found:?} after {runs}");
        }
    }

    #[test]
    fn what_always_or_never_grows_has_no_bracket() {
        assert_eq!(largest_stable(1.0, 0.01, |_| true).stable, 0.0);
        assert!(largest_stable(1.0, 0.01, |_| false).unstable.is_infinite());
    }
}

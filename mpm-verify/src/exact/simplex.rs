//! The minimum of a function of a few variables in a box, without derivatives.

/// Reflections after which a simplex is given up, per variable.
const STEPS: usize = 200;

/// A local minimum of `f` in the unit cube and its value, searched from `start` with a first simplex of edge `size`.
/// It ends when the values at its corners differ by less than `narrow`, relative. `f` may be infinite, but not at the
/// start.
///
/// Nelder & Mead 1965, The Computer Journal 7(4), doi:10.1093/comjnl/7.4.308; points outside the cube are put on its
/// faces.
pub fn minimum<const N: usize>(
    f: impl Fn([f64; N]) -> f64,
    start: [f64; N],
    size: f64,
    narrow: f64,
) -> ([f64; N], f64) {
    let value = |at: [f64; N]| (at, f(at));
    let mut simplex = vec![value(start)];
    for axis in 0..N {
        let mut corner = start;
        // Towards the middle, so that a start on a face keeps its volume.
        corner[axis] += if start[axis] > 0.5 { -size } else { size };
        simplex.push(value(corner));
    }
    for _ in 0..STEPS * N {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (best, worst) = (simplex[0], simplex[N]);
        if worst.1 - best.1 <= narrow * best.1.abs() {
            break;
        }
        let centre: [f64; N] =
            std::array::from_fn(|axis| simplex[..N].iter().map(|corner| corner.0[axis]).sum::<f64>() / N as f64);
        let moved = |share: f64| {
            value(std::array::from_fn(|axis| (centre[axis] + share * (centre[axis] - worst.0[axis])).clamp(0.0, 1.0)))
        };
        let reflected = moved(1.0);
        simplex[N] = if reflected.1 < best.1 {
            let further = moved(2.0);
            if further.1 < reflected.1 { further } else { reflected }
        } else if reflected.1 < simplex[N - 1].1 {
            reflected
        } else {
            let nearer = moved(if reflected.1 < worst.1 { 0.5 } else { -0.5 });
            if nearer.1 < worst.1.min(reflected.1) {
                nearer
            } else {
                for corner in &mut simplex[1..] {
                    *corner = value(std::array::from_fn(|axis| 0.5 * (corner.0[axis] + best.0[axis])));
                }
                continue;
            }
        };
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let valley = |[x, y]: [f64; 2]| (1.0 - 2.0 * x).powi(2) + 100.0 * (y - x * x).powi(2) + 1.0;
        let ([x, y], value) = minimum(valley, [0.9, 0.1], 0.1, 1e-10);
        assert!((x - 0.5).abs() < 1e-4 && (y - 0.25).abs() < 1e-4 && value - 1.0 < 1e-8, "{x} {y} {value}");
    }

    #[test]
    fn a_minimum_may_lie_on_a_face_and_beside_what_is_forbidden() {
        let beside = |[x, y, z]: [f64; 3]| {
            let bowl = 1.0 + (x + 0.3).powi(2) + (y - 0.4).powi(2) + (z - 1.5).powi(2);
            if y > 0.7 { f64::INFINITY } else { bowl }
        };
        let (place, _) = minimum(beside, [0.6, 0.6, 0.6], 0.2, 1e-10);
        for (found, wanted) in place.into_iter().zip([0.0, 0.4, 1.0]) {
            assert!((found - wanted).abs() < 1e-4, "{place:?}");
        }
    }
}

//! The Pareto front: settings that nothing beats in both error and cost.

/// Which of some (cost, error) pairs are on the front: no other is as cheap and as accurate, and better in one. Pairs
/// with a NaN never are.
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|i| !points[*i].0.is_nan() && !points[*i].1.is_nan()).collect();
    order.sort_by(|a, b| {
        let (a, b) = (points[*a], points[*b]);
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut on = vec![false; points.len()];
    let mut best: Option<(f64, f64)> = None;
    for i in order {
        // Equal in both is as good; equal in error alone is dearer.
        if best.is_none_or(|b| points[i].1 < b.1 || points[i] == b) {
            on[i] = true;
            best = Some(points[i]);
        }
    }
    on
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1.0, 1.0), (2.0, 0.5), (2.0, 0.7), (3.0, 0.5), (4.0, 0.1), (0.5, f64::NAN), (5.0, 0.2)];
        assert_eq!(front(&points), [true, true, false, false, true, false, false]);
        assert_eq!(front(&[(1.0, 1.0), (1.0, 1.0)]), [true, true]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn no_point_of_the_front_is_beaten_and_every_other_is() {
        let mut random = mpm_core::random::Random(1);
        let mut next = || (random.bits() >> 40) as f64;
        let points: Vec<(f64, f64)> = (0..300).map(|_| (next(), next())).collect();
        let beats = |a: &(f64, f64), b: &(f64, f64)| a != b && a.0 <= b.0 && a.1 <= b.1;
        for (point, on) in points.iter().zip(front(&points)) {
            assert_eq!(on, !points.iter().any(|other| beats(other, point)));
        }
    }
}

//! Particles as the pieces of soil that they stand for: squares at t = 0, drawn out as their neighbours move apart.

/// Soil that covers more than so many times its first area is torn, and its particle drawn as a square.
const TORN: f64 = 2.0;
/// Where all pieces are shorter than so many spacings, squares say the same.
const DRAWN_OUT: f64 = 1.5;

/// Corners of the piece of each particle, m, none where it is torn; particles stood `spacing` (m) apart, row by row, so many in each.
/// Nothing where there are no whole rows, or hardly a change of shape.
///
/// A corner is the mean of the four particles around it; beyond the last ones rows go on as they end, a spacing at most.
pub fn tiles(points: &[[f64; 3]], per_row: usize, spacing: f64) -> Vec<Option<[(f64, f64); 4]>> {
    if per_row < 2 || points.len() < 2 * per_row || !points.len().is_multiple_of(per_row) {
        return Vec::new();
    }
    let rows = points.len() / per_row;
    let at = |i: usize, j: usize| (points[j * per_row + i][0], points[j * per_row + i][1]);
    // Beyond an end at most a spacing further: what a long step there would go on to is not known.
    let further = |last: (f64, f64), before: (f64, f64)| {
        let (x, y) = (last.0 - before.0, last.1 - before.1);
        let part = (spacing / x.hypot(y)).min(1.0);
        (last.0 + part * x, last.1 + part * y)
    };
    let in_row = |i: isize, j: usize| match i {
        -1 => further(at(0, j), at(1, j)),
        i if i as usize == per_row => further(at(per_row - 1, j), at(per_row - 2, j)),
        i => at(i as usize, j),
    };
    let place = |i: isize, j: isize| match j {
        -1 => further(in_row(i, 0), in_row(i, 1)),
        j if j as usize == rows => further(in_row(i, rows - 1), in_row(i, rows - 2)),
        j => in_row(i, j as usize),
    };
    let corner = |i: isize, j: isize| {
        let around = [place(i - 1, j - 1), place(i, j - 1), place(i - 1, j), place(i, j)];
        around.iter().fold((0.0, 0.0), |sum, x| (sum.0 + 0.25 * x.0, sum.1 + 0.25 * x.1))
    };
    let tile = |k: usize| {
        let (i, j) = ((k % per_row) as isize, (k / per_row) as isize);
        [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]
    };
    let all: Vec<_> = (0..points.len()).map(tile).collect();
    let is_drawn_out = |tile: &[(f64, f64); 4]| {
        (0..4).any(|a| {
            let ((x, y), (u, v)) = (tile[a], tile[(a + 1) % 4]);
            (u - x).hypot(v - y) > DRAWN_OUT * spacing
        })
    };
    if !all.iter().any(is_drawn_out) {
        return Vec::new();
    }
    let is_whole = |tile: &[(f64, f64); 4]| area(tile) > 0.0 && area(tile) <= TORN * spacing * spacing;
    all.into_iter().map(|tile| Some(tile).filter(is_whole)).collect()
}

/// Area of a polygon, m2, negative if it is inside out.
fn area(corners: &[(f64, f64); 4]) -> f64 {
    let cross = |a: (f64, f64), b: (f64, f64)| a.0 * b.1 - b.0 * a.1;
    0.5 * (0..4).map(|k| cross(corners[k], corners[(k + 1) % 4])).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve particles in rows of four, 0.5 m apart, moved.
    fn moved(to: impl Fn(f64, f64) -> (f64, f64)) -> Vec<[f64; 3]> {
        let place = |k: usize| to(0.25 + 0.5 * (k % 4) as f64, 0.25 + 0.5 * (k / 4) as f64);
        (0..12).map(place).map(|(x, y)| [x, y, 0.0]).collect()
    }

    #[test]
    fn soil_that_is_drawn_out_keeps_its_area() {
        let all = tiles(&moved(|x, y| (2.0 * x + y, 0.5 * y)), 4, 0.5);
        assert_eq!(all.len(), 12);
        // Of the row in the middle, both ends of which are half as long as the soil is there.
        let [end, inside] = [4, 5].map(|k| area(&all[k].expect("whole")));
        assert!((inside - 0.25).abs() < 1e-12 && (end - 0.1875).abs() < 1e-12, "{inside} {end}");
    }

    #[test]
    fn squares_stay_and_torn_soil_is_left_out() {
        assert!(tiles(&moved(|x, y| (x + 0.1 * y, y)), 4, 0.5).is_empty());
        assert!(tiles(&moved(|x, y| (x, y))[..11], 4, 0.5).is_empty());
        let torn = tiles(&moved(|x, y| (if x > 1.0 { x + 5.0 } else { x }, y)), 4, 0.5);
        assert_eq!(torn.iter().filter(|tile| tile.is_none()).count(), 6);
    }
}

//! Particles as the pieces of soil that they stand for: squares at t = 0, whose corners move with the particles around them.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Corners of a piece of soil, m, anticlockwise.
pub type Tile = [(f64, f64); 4];

/// Soil that covers more than so many times its first area is torn, and its particle drawn as a square.
const TORN: f64 = 2.0;
/// Where no edge of a piece has moved by more than this share of the spacing, squares say the same.
const SQUARE: f64 = 0.02;

/// The piece of each particle, none where it is torn or shares its square with another. `starts` are the places (m) of the particles at
/// t = 0, each in a square of edge `spacing` (m) of its own, in the order of `points`. Nothing where they are not known, or where squares
/// say the same.
///
/// A corner is the mean of what the particles around it make of it, each by its own deformation gradient, from differences to those that
/// were its neighbours at t = 0, in whatever order they are listed. Beyond the last particle soil is not drawn out any further.
pub fn tiles(points: &[[f64; 3]], starts: &[[f64; 2]], spacing: f64) -> Vec<Option<Tile>> {
    let square = |k: usize| starts[k].map(|x| (x / spacing).floor() as i64);
    let mut known: HashMap<[i64; 2], Option<usize>> = HashMap::with_capacity(starts.len());
    for k in 0..starts.len() {
        match known.entry(square(k)) {
            Entry::Vacant(free) => _ = free.insert(Some(k)),
            Entry::Occupied(mut taken) => _ = taken.insert(None),
        }
    }
    let at = |square: [i64; 2]| known.get(&square).copied().flatten();
    let gradients: Vec<[[f64; 2]; 2]> = (0..starts.len())
        .map(|k| {
            [0, 1].map(|axis| {
                let beside = |way: i64| {
                    let mut square = square(k);
                    square[axis] += way;
                    at(square)
                };
                let slope = |a: usize, b: usize| {
                    let apart = starts[b][axis] - starts[a][axis];
                    [0, 1].map(|d| (points[b][d] - points[a][d]) / apart)
                };
                match (beside(-1), beside(1)) {
                    (Some(a), Some(b)) => at_most_one(slope(a, b)),
                    (Some(a), None) => at_most_one(slope(a, k)),
                    (None, Some(b)) => at_most_one(slope(k, b)),
                    (None, None) => [f64::from(u8::from(axis == 0)), f64::from(u8::from(axis == 1))],
                }
            })
        })
        .collect();
    let corner = |place: [i64; 2]| {
        let around = [[-1, -1], [0, -1], [-1, 0], [0, 0]].map(|[i, j]| at([place[0] + i, place[1] + j]));
        let seen = around.iter().flatten().map(|k| {
            let [x, y] = [0, 1].map(|d| place[d] as f64 * spacing - starts[*k][d]);
            let [along, up] = gradients[*k];
            [0, 1].map(|d| points[*k][d] + along[d] * x + up[d] * y)
        });
        let (sum, count) = seen.fold(([0.0; 2], 0.0), |(sum, n), x| ([sum[0] + x[0], sum[1] + x[1]], n + 1.0));
        (sum[0] / count, sum[1] / count)
    };
    let tile = |k: usize| {
        let [i, j] = square(k);
        at([i, j]).map(|_| [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(corner))
    };
    let all: Vec<Option<Tile>> = (0..starts.len()).map(tile).collect();
    let is_moved = |(k, tile): (usize, &Tile)| {
        let at = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        let off = |(corner, [x, y]): (&(f64, f64), [f64; 2])| {
            let [x, y] = [corner.0 - points[k][0] - x * spacing, corner.1 - points[k][1] - y * spacing];
            x.hypot(y) > SQUARE * spacing
        };
        tile.iter().zip(at).any(off)
    };
    if !all.iter().enumerate().any(|(k, tile)| tile.as_ref().is_some_and(|tile| is_moved((k, tile)))) {
        return Vec::new();
    }
    let is_whole = |tile: &Tile| area(tile) > 0.0 && area(tile) <= TORN * spacing * spacing;
    all.into_iter().map(|tile| tile.filter(is_whole)).collect()
}

/// A step from one particle to the next over what it was at t = 0, no longer than that: what a long step would go on to is not known, and
/// between four particles that are drawn out evenly it makes no difference.
fn at_most_one([x, y]: [f64; 2]) -> [f64; 2] {
    let part = x.hypot(y).max(1.0);
    [x / part, y / part]
}

/// Area of a piece, m2, negative if it is inverted.
fn area(corners: &Tile) -> f64 {
    let cross = |a: (f64, f64), b: (f64, f64)| a.0 * b.1 - b.0 * a.1;
    0.5 * (0..4).map(|k| cross(corners[k], corners[(k + 1) % 4])).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACING: f64 = 0.5;

    /// Pieces of twelve particles, three rows of four, moved, and listed column by column.
    fn moved(to: impl Fn(f64, f64) -> (f64, f64)) -> Vec<Option<Tile>> {
        let starts: Vec<[f64; 2]> = (0..12).map(|k| [k / 3, k % 3].map(|i| SPACING * (f64::from(i) + 0.5))).collect();
        let points: Vec<[f64; 3]> = starts.iter().map(|[x, y]| to(*x, *y)).map(|(x, y)| [x, y, 0.0]).collect();
        tiles(&points, &starts, SPACING)
    }

    #[test]
    fn soil_that_is_drawn_out_keeps_its_area() {
        let all = moved(|x, y| (2.0 * x + y, 0.5 * y));
        assert_eq!(all.len(), 12);
        // Of the row in the middle, both ends of which are half as long as the soil is there.
        let [end, inside] = [1, 4].map(|k| area(&all[k].expect("whole")));
        assert!((inside - 0.25).abs() < 1e-12 && (end - 0.1875).abs() < 1e-12, "{inside} {end}");
    }

    #[test]
    fn squares_stay_and_torn_soil_is_left_out() {
        assert!(moved(|x, y| (x + 0.01 * y, y)).is_empty());
        let torn = moved(|x, y| (if x > 1.0 { x + 5.0 } else { x }, y));
        assert_eq!(torn.iter().filter(|tile| tile.is_none()).count(), 6);
        // Two in one square: nobody knows which of them its corners go with.
        assert!(tiles(&[[0.1, 0.1, 0.0], [0.2, 0.2, 0.0]], &[[0.1, 0.1], [0.2, 0.2]], SPACING).is_empty());
    }
}

//! Simple polygons: area, centre, what lies inside, and what is wrong with one.

use super::crossing;
use crate::order::sort_by_number;

/// Why points are no outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Fewer than three points.
    TooFew(usize),
    /// A point, by its place in the list, left of or below what is allowed, or not finite.
    Outside(usize),
    /// Two edges cross or touch; each by the place of its first point.
    Crossing(usize, usize),
}

/// Area (m2) and first moments (m3) about a point (m), anticlockwise positive.
pub(super) fn moments(polygon: &[[f64; 2]], about: &[f64; 2]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (i, b) in polygon.iter().enumerate() {
        let a = polygon[(i + polygon.len() - 1) % polygon.len()];
        let (a, b) = ([a[0] - about[0], a[1] - about[1]], [b[0] - about[0], b[1] - about[1]]);
        let cross = a[0] * b[1] - b[0] * a[1];
        sums[0] += cross / 2.0;
        sums[1] += cross * (a[0] + b[0]) / 6.0;
        sums[2] += cross * (a[1] + b[1]) / 6.0;
    }
    sums
}

/// Area of a polygon (m), m2: positive if it runs anticlockwise.
pub fn area(polygon: &[[f64; 2]]) -> f64 {
    polygon.first().map_or(0.0, |first| moments(polygon, first)[0])
}

/// Centre of area of a polygon, m.
pub fn centroid(polygon: &[[f64; 2]]) -> [f64; 2] {
    let first = polygon.first().copied().unwrap_or_default();
    let [area, x, y] = moments(polygon, &first);
    [first[0] + x / area, first[1] + y / area]
}

/// Heights (m) at which the edges of a polygon pass a place x (m), in the order of the edges.
pub fn passes(polygon: &[[f64; 2]], x: f64) -> impl Iterator<Item = f64> {
    polygon.iter().enumerate().filter_map(move |(i, b)| {
        let a = &polygon[(i + polygon.len() - 1) % polygon.len()];
        let between = (a[0] > x) != (b[0] > x);
        between.then(|| a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]))
    })
}

/// Whether a point (m) lies inside a simple polygon (even-odd rule).
pub fn inside(polygon: &[[f64; 2]], point: &[f64; 2]) -> bool {
    passes(polygon, point[0]).filter(|y| *y > point[1]).count() % 2 == 1
}

/// Whether a point (m) lies inside a simple polygon or within a distance (m) of its edges.
pub fn near(polygon: &[[f64; 2]], point: &[f64; 2], reach: f64) -> bool {
    let to_edge = |i: usize| {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let (along, off) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
        let length = along[0] * along[0] + along[1] * along[1];
        let share = ((along[0] * off[0] + along[1] * off[1]) / length).clamp(0.0, 1.0);
        f64::hypot(off[0] - share * along[0], off[1] - share * along[1])
    };
    inside(polygon, point) || (0..polygon.len()).any(|i| to_edge(i) <= reach)
}

/// Depth of a point (m) below the outline straight above it, m; zero if there is none.
pub fn depth(polygon: &[[f64; 2]], point: &[f64; 2]) -> f64 {
    let above = passes(polygon, point[0]).filter(|y| *y > point[1]).fold(f64::INFINITY, f64::min);
    if above.is_finite() { above - point[1] } else { 0.0 }
}

/// Length (m) of a simple polygon along a side (left, right, bottom, top of a box of this `width`, m) between two places along
/// it (m): what lies on the side; of the top, what of the polygon the sky is above, however high.
pub fn length_along(polygon: &[[f64; 2]], side: usize, [low, high]: [f64; 2], width: f64) -> f64 {
    let axis = usize::from(side < 2);
    let place = if side == 1 { width } else { 0.0 };
    let on = |x: &[f64; 2]| side == 3 || (x[1 - axis] - place).abs() <= 1e-9 * width;
    let edges = polygon.iter().enumerate().map(|(i, a)| [a, &polygon[(i + 1) % polygon.len()]]);
    let ends =
        edges.filter(|edge| edge.iter().all(|x| on(x))).map(|[a, b]| [a[axis].min(b[axis]), a[axis].max(b[axis])]);
    let mut spans: Vec<[f64; 2]> = ends.map(|[a, b]| [a.max(low), b.min(high)]).filter(|[a, b]| a < b).collect();
    sort_by_number(&mut spans, |[low, _]| *low);
    let mut reached = low;
    let mut length = 0.0;
    for [a, b] in spans {
        length += (b - a.max(reached)).max(0.0);
        reached = reached.max(b);
    }
    length
}

/// Whether points (m) are the corners of a simple polygon with coordinates of at `least` so much, m.
///
/// # Errors
/// The first thing that is wrong.
pub fn check(points: &[[f64; 2]], least: f64) -> Result<(), Fault> {
    let count = points.len();
    if count < 3 {
        return Err(Fault::TooFew(count));
    }
    let within = |x: &[f64; 2]| x.iter().all(|x| x.is_finite() && *x >= least);
    if let Some(i) = points.iter().position(|x| !within(x)) {
        return Err(Fault::Outside(i));
    }
    let edge = |i: usize| [points[i], points[(i + 1) % count]];
    if let Some(i) = (0..count).find(|i| folds(&edge(*i), &edge((i + 1) % count))) {
        let j = (i + 1) % count;
        return Err(Fault::Crossing(i.min(j), i.max(j)));
    }
    match crossing::find(count, &edge) {
        Some((i, j)) => Err(Fault::Crossing(i.min(j), i.max(j))),
        None => Ok(()),
    }
}

/// Twice the area of the triangle a, b, c, m2.
pub(super) fn turn(a: &[f64; 2], b: &[f64; 2], c: &[f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether two edges that share a corner lie on each other, or one has no length.
pub fn folds([a, b]: &[[f64; 2]; 2], [c, d]: &[[f64; 2]; 2]) -> bool {
    let (shared, first, second) = if b == c { (b, a, d) } else { (a, b, c) };
    let along = |d: usize| (first[d] - shared[d]) * (second[d] - shared[d]);
    a == b || c == d || (turn(shared, first, second) == 0.0 && along(0) + along(1) > 0.0)
}

/// Whether two edges have a point in common.
pub fn touch([a, b]: &[[f64; 2]; 2], [c, d]: &[[f64; 2]; 2]) -> bool {
    let overlap = |k: usize| a[k].max(b[k]) >= c[k].min(d[k]) && c[k].max(d[k]) >= a[k].min(b[k]);
    let sides = |[a, b]: [&[f64; 2]; 2], c, d| turn(a, b, c) * turn(a, b, d) <= 0.0;
    overlap(0) && overlap(1) && sides([a, b], c, d) && sides([c, d], a, b)
}

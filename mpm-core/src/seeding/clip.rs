//! Cutting a polygon between two lines (Sutherland & Hodgman 1974, doi:10.1145/360767.360802).
//!
//! The polygon is the subject and the square the window, which is convex: a polygon that is not may come apart, its
//! pieces then joined by edges along the window that are walked both ways. They add nothing to area or moments.

/// The part of a polygon (m) with `low` <= x < `high` (m) along an axis; empty if there is none.
pub fn between(polygon: &[[f64; 2]], axis: usize, low: f64, high: f64) -> Vec<[f64; 2]> {
    let above = half(polygon, axis, |x| x - low, low);
    half(&above, axis, |x| high - x, high)
}

/// The part of a polygon whose distance from the line at `place` is positive.
fn half(polygon: &[[f64; 2]], axis: usize, distance: impl Fn(f64) -> f64, place: f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::with_capacity(polygon.len() + 4);
    for (i, b) in polygon.iter().enumerate() {
        let a = &polygon[(i + polygon.len() - 1) % polygon.len()];
        let (from, to) = (distance(a[axis]), distance(b[axis]));
        if (from < 0.0) != (to < 0.0) {
            let share = from / (from - to);
            let mut cut = [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
            cut[axis] = place; // on the line itself, so that neighbours share it without a gap
            kept.push(cut);
        }
        if to >= 0.0 {
            kept.push(*b);
        }
    }
    kept
}

//! Gauss-Legendre points.

/// Three points and weights on [0, 1]: exact to degree 5.
pub const GAUSS3: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Integral of a function over an interval, in `pieces` equal pieces of three points each.
pub fn gauss(from: f64, to: f64, pieces: usize, mut f: impl FnMut(f64) -> f64) -> f64 {
    let width = (to - from) / pieces as f64;
    let mut sum = 0.0;
    for piece in 0..pieces {
        let start = from + width * piece as f64;
        for (xi, weight) in GAUSS3 {
            sum += weight * width * f(start + xi * width);
        }
    }
    sum
}

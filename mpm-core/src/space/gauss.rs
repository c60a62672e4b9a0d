//! Gauss-Legendre points.

/// Points and weights on [0, 1]: exact to degree 5.
const THREE: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// The same to degree 7.
const FOUR: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_1),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_1),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Points and weights on [0, 1] that integrate products of two polynomials of a degree exactly, up to cubic ones.
pub fn gauss_points(degree: usize) -> &'static [(f64, f64)] {
    if degree <= 2 { &THREE } else { &FOUR }
}

/// Integral of a function over an interval, in `pieces` equal pieces of four points each.
pub fn gauss(from: f64, to: f64, pieces: usize, mut f: impl FnMut(f64) -> f64) -> f64 {
    let width = (to - from) / pieces as f64;
    let mut sum = 0.0;
    for piece in 0..pieces {
        let start = from + width * piece as f64;
        for (xi, weight) in FOUR {
            sum += weight * width * f(start + xi * width);
        }
    }
    sum
}

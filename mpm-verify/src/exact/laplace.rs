//! Numerical inversion of a Laplace transform: fixed Talbot (Abate & Valko 2004, *Int. J. Numer. Methods Eng.* 60, 979-993).

use std::f64::consts::PI;

use nalgebra::Complex;

/// Terms of the sum: with more, round-off grows.
const TERMS: usize = 24;

/// The functions at a time (s) whose transforms these are; what is smooth, to about 1e-8 of its size.
pub fn at<const N: usize>(time: f64, transforms: impl Fn(Complex<f64>) -> [Complex<f64>; N]) -> [f64; N] {
    let r = 2.0 * TERMS as f64 / (5.0 * time);
    let mut sums = [0.0; N];
    for k in 0..TERMS {
        let theta = k as f64 * PI / TERMS as f64;
        let (s, weight) = if k == 0 {
            (Complex::new(r, 0.0), Complex::new(0.5 * (r * time).exp(), 0.0))
        } else {
            let cot = 1.0 / theta.tan();
            let s = Complex::new(r * theta * cot, r * theta);
            let sigma = theta + (theta * cot - 1.0) * cot;
            (s, (s * time).exp() * Complex::new(1.0, sigma))
        };
        for (sum, value) in sums.iter_mut().zip(transforms(s)) {
            *sum += r / TERMS as f64 * (weight * value).re;
        }
    }
    sums
}

//! The one definition of error.
//!
//! U = S/(q H/M) at nine time factors; error = largest |U - U_exact|/U_exact over them, "late" the same for
//! Tv >= 0.1; profile error = RMS(p - p_exact)/p_0 at Tv = 0.1.

use mpm_core::observe::ProfileRow;

use crate::exact::terzaghi::Terzaghi;

/// Time factors at which errors are taken, Tv = c_v t/H^2 with c_v = k M/gamma_w.
pub const SAMPLE_TV: [f64; 9] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0];
/// From here on an error is "late".
pub const LATE_TV: f64 = 0.1;

/// Relative error U/U_exact - 1, signed.
pub fn relative(u: f64, exact: f64) -> f64 {
    u / exact - 1.0
}

/// Largest absolute value; NaN if one is.
pub fn largest(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |a: f64, e| if e.is_nan() || e.abs() > a { e.abs() } else { a })
}

/// The value of the largest size, with its sign; NaN if one is.
pub fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |a: f64, e| if e.is_nan() || e.abs() > a.abs() { e } else { a })
}

/// Root mean square of p - p_exact over the rows of a profile, over p_0. The exact solution is taken at the height
/// that the soil of each row had at t = 0, the coordinate of a small-strain solution.
pub fn profile_error(rows: &[ProfileRow], exact: &Terzaghi, time: f64) -> f64 {
    let squares: f64 = rows.iter().map(|r| (r.pressure_pa - exact.pressure(r.material_height_m, time)).powi(2)).sum();
    (squares / rows.len() as f64).sqrt() / exact.undrained
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_error_keeps_a_nan() {
        assert_eq!(largest([0.1, -0.3, 0.2].into_iter()), 0.3);
        assert!(largest([0.1, f64::NAN].into_iter()).is_nan());
        assert_eq!(worst([0.1, -0.3, 0.2].into_iter()), -0.3);
        assert!(worst([f64::NAN, 0.1].into_iter()).is_nan() && worst([0.1, f64::NAN].into_iter()).is_nan());
    }
}

//! How settings, times and errors read.

use mpm_verify::report::numbers::{percent, short};

use crate::baseline;
use crate::row::{MOVING, Row};

/// A time with two significant digits in the unit that suits it.
pub fn time(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "\u{2013}".to_owned();
    }
    let (factor, unit) = match seconds {
        s if s < 0.999e-3 => (1e6, "\u{b5}s"),
        s if s < 0.999 => (1e3, "ms"),
        _ => (1.0, "s"),
    };
    format!("{} {unit}", short(factor * seconds, 2))
}

/// A ratio: `0.41`, `3.2`, `12\u{202f}700`.
pub fn times(ratio: f64) -> String {
    if !(1e4..1e9).contains(&ratio) {
        return short(ratio, 2);
    }
    // Three digits and noughts, in groups of three.
    let scale = 10f64.powi(ratio.log10().floor() as i32 - 2);
    let digits = format!("{:.0}", (ratio / scale).round() * scale);
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().map(|g| std::str::from_utf8(g).unwrap_or("")).collect();
    groups.join("\u{a0}")
}

/// An error in percent with its sign: `0.3 %`.
pub fn share(error: f64) -> String {
    format!("{} %", percent(error))
}

/// A wanted error as a user says it: `0.02 %`.
pub fn wanted(error: f64) -> String {
    format!("{} %", short(100.0 * error, 1))
}

/// How a setting is fine in time: its step or its tolerance.
pub fn in_time(row: &Row) -> String {
    let value = format!("{:e}", row.dt_or_tol);
    match (row.integrator.as_str(), row.method.as_str()) {
        ("quasi-static", "krylov") => format!("tolerance {value}"),
        (name, _) if name.ends_with(MOVING) => format!("tolerance {value}"),
        ("quasi-static", method) => format!("tolerance {value}, {method}"),
        (name, _) if baseline::is(name) => format!("{} steps", row.steps),
        _ if row.case.contains("-step1/2") => format!("half the automatic step ({} s)", short(row.dt_or_tol, 2)),
        _ if row.case.contains("-step1/4") => {
            format!("a quarter of the automatic step ({} s)", short(row.dt_or_tol, 2))
        }
        _ => format!("automatic step ({} s)", short(row.dt_or_tol, 2)),
    }
}

/// A setting in words: `quasi-static, bspline2, L = 0.1 m, 9 particles per cell, tolerance 1e-3`.
pub fn setting(row: &Row) -> String {
    if baseline::is(&row.integrator) {
        return format!("{} cells, {} steps", row.particles, row.steps);
    }
    let particles = if row.ppc == 1 { "1 particle".to_owned() } else { format!("{} particles", row.ppc) };
    let plane = if row.dimension == "column" { "" } else { ", full width" };
    format!("{}, {}, L = {} m, {particles} per cell, {}{plane}", row.integrator, row.scheme, row.mesh_m, in_time(row))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(
            (time(3.314e-5).as_str(), time(0.042).as_str(), time(1.26).as_str()),
            ("33 \u{b5}s", "42 ms", "1.3 s")
        );
        assert_eq!((times(0.412).as_str(), times(12_741.0).as_str()), ("0.41", "12\u{a0}700"));
        assert_eq!((wanted(2e-4).as_str(), wanted(3e-3).as_str(), wanted(1e-2).as_str()), ("0.02 %", "0.3 %", "1 %"));
    }
}

//! How cost grows as the cells get smaller: exponents of 1/L, fitted and expected.
//!
//! Expected is the growth of the work that was counted. Explicit: particles times steps, where the stability limit
//! passes from that of waves, dt ~ L, to that of drainage, dt ~ L^2, so that the exponent in one dimension passes from
//! 2 to 3. Semi-implicit: one banded solve per step; water lets steps be longer on coarse meshes, and on fine ones dt ~ L,
//! so that the exponent comes down to 2. Quasi-static: banded solves, of which there are
//! hardly more on a finer mesh, so a little above 1. What does not grow, set-up and reading, makes the measured exponent
//! smaller on coarse meshes.

use mpm_verify::rates::{Fit, fit};

use crate::row::{MOVING, Row};

/// Coarsest mesh that is fitted, m: above, what does not grow weighs too much.
const COARSEST: f64 = 0.1;
/// Tolerance of the quasi-static line.
const TOLERANCE: f64 = 1e-4;

/// The growth of one integrator with one kind of shape functions.
#[derive(Debug, Clone, PartialEq)]
pub struct Growth {
    /// Time integrator.
    pub integrator: String,
    /// Shape functions.
    pub scheme: String,
    /// Particles per cell; 0 for the baseline.
    pub ppc: usize,
    /// Cell edges, m, coarse first, with CPU time, s.
    pub times: Vec<(f64, f64)>,
    /// Exponent of CPU time; its sign is that of growth.
    pub measured: Fit,
    /// Exponent of the counted work.
    pub counted: Fit,
    /// What is counted.
    pub work: &'static str,
    /// Exponent on a very fine mesh, from theory.
    pub limit: &'static str,
}

/// Columns of `growth.csv`.
pub const COLUMNS: &str = "integrator,scheme,ppc,mesh_from_m,mesh_to_m,meshes,cpu_exponent,cpu_half_width_95,\
work_exponent,work_half_width_95,work,limit_exponent";

/// The work of a row, what it is called, and the exponent it tends to.
fn work(row: &Row) -> (f64, &'static str, &'static str) {
    let (points, steps, cells) = (row.particles as f64, row.steps as f64, 1.0 / row.mesh_m);
    match row.integrator.as_str() {
        "explicit" => (points * steps, "particles x steps", "3"),
        "semi-implicit" => (cells * steps, "cells x steps", "2"),
        _ => (cells * row.solves as f64, "cells x solves", "1"),
    }
}

/// Whether a row is on the line of its integrator and shape functions that is fitted.
pub fn is_on_line(row: &Row) -> bool {
    let ppc = if row.integrator == "quasi-static" { 9 } else { 4 };
    let time = match row.integrator.as_str() {
        "quasi-static" => row.method == "krylov" && row.dt_or_tol == TOLERANCE,
        name => !name.ends_with(MOVING) && !row.case.contains("-step1/"),
    };
    row.ppc == ppc && time && row.dimension == "column" && row.failure.is_none()
}

/// The growth of every integrator with every kind of shape functions, at one number of particles per cell.
pub fn growths(rows: &[Row]) -> Vec<Growth> {
    let mut lines: Vec<(&str, &str, Vec<&Row>)> = Vec::new();
    for row in rows.iter().filter(|r| is_on_line(r) && r.mesh_m <= COARSEST * (1.0 + 1e-9)) {
        match lines.iter_mut().find(|(i, s, _)| *i == row.integrator && *s == row.scheme) {
            Some((_, _, line)) => line.push(row),
            None => lines.push((&row.integrator, &row.scheme, vec![row])),
        }
    }
    lines.iter().filter_map(|(_, _, line)| growth(line)).collect()
}

fn growth(line: &[&Row]) -> Option<Growth> {
    let mut line = line.to_vec();
    line.sort_by(|a, b| b.mesh_m.total_cmp(&a.mesh_m));
    let first = line.first()?;
    let exponent = |of: &dyn Fn(&Row) -> f64| {
        let points: Vec<(f64, f64)> = line.iter().map(|r| (1.0 / r.mesh_m, of(r))).collect();
        fit(&points)
    };
    let (_, what, limit) = work(first);
    Some(Growth {
        integrator: first.integrator.clone(),
        scheme: first.scheme.clone(),
        ppc: first.ppc,
        times: line.iter().map(|r| (r.mesh_m, r.cpu_s)).collect(),
        measured: exponent(&|r| r.cpu_s)?,
        counted: exponent(&|r| work(r).0)?,
        work: what,
        limit,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::tests::row;

    #[test]
    fn a_power_law_is_found_with_the_counted_one_beside_it() {
        let line = [0.1, 0.05, 0.02, 0.01].map(|mesh: f64| {
            let mut row = row("explicit", mesh, 1e-6, 1e-2, 3e-6 * mesh.powf(-2.8));
            (row.particles, row.steps) = ((2.0 / mesh) as usize, (1.0 / (mesh * mesh)).round() as u64);
            row
        });
        let found = growths(&line);
        assert_eq!(found.len(), 1);
        assert!((found[0].measured.order - 2.8).abs() < 1e-9, "{found:?}");
        assert!((found[0].counted.order - 3.0).abs() < 0.01 && found[0].measured.half_width < 1e-6);
    }

    #[test]
    fn coarse_meshes_other_steps_and_failed_runs_are_not_fitted() {
        let mut rows = vec![row("explicit", 0.5, 1e-6, 1e-2, 1.0), row("explicit", 0.1, 1e-6, 1e-2, 1.0)];
        rows[1].case += "-step1/2";
        let mut failed = row("explicit", 0.1, 1e-6, 1e-2, 1.0);
        failed.failure = Some(String::new());
        rows.push(failed);
        assert!(growths(&rows).is_empty());
    }
}

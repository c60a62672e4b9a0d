//! What a scene must show, from what Table 1's column shows.
//!
//! The largest error is that of the first sample time that counts, t_1: the consolidated zone is `H_d sqrt(T_1)` deep there,
//! and cells L resolve it with `r = L/(H_d sqrt(T_1))`. Table 1's column has errors `space r^power + time dt/t_1`, with the
//! numbers below measured on its rungs; any other column may have [`SIZE`] times as much: "errors of the same size".

use mpm_core::scene::{Integrator, Scene, ShapeChoice};

use super::applies::Solution;
use crate::cases::mandel;
use crate::norms::LATE_TV;

/// Errors of the same size: within this factor of those of Table 1's column.
pub const SIZE: f64 = 1.5;
/// The wave of sudden drainage has died when it has decayed by exp(-12): Table 1's has at Tv = 0.1.
const DIED: f64 = 12.0;
/// M/G of Table 1. The jump penalty of B-splines is measured in 1/G, so that its error in a column goes with M/G.
const MODULI: f64 = 3.5;

/// What a scheme must show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// Allowed interval of the order.
    order: [f64; 2],
    /// Error of the mesh over `r^power`.
    space: f64,
    /// Power of r that it goes with.
    power: i32,
    /// Error of the step over `dt/t_1`.
    time: f64,
    /// Errors below this are those of error-controlled time, which have no order in space.
    pub floor: f64,
    /// First time that counts, s.
    pub from: f64,
    /// t_1, s.
    first: f64,
    /// `L/r`, m.
    zone: f64,
}

impl Expected {
    /// Of the scheme of a scene whose coarsest cells are `coarse` (m).
    ///
    /// # Errors
    /// The scene is observed only before times count.
    pub fn of(scene: &Scene, solution: &Solution, coarse: f64) -> Result<Self, String> {
        let from = from(scene, solution);
        let times = scene.observe_times.iter().copied().filter(|time| *time > 0.0 && *time >= 0.999 * from);
        let first = times.fold(f64::INFINITY, f64::min);
        if first.is_infinite() {
            let expected =
                format!("a time from {from:.3e} s (Tv = {LATE_TV}) on, where semi-implicit runs are compared");
            return Err(format!("[observe]: expected {expected}, found none"));
        }
        let zone = solution.path() * solution.time_factor(first).min(LATE_TV).sqrt();
        // Cells as large as the consolidated zone are not in the asymptotic range.
        let fine = coarse <= 0.75 * zone;
        let second = if fine { [1.8, 2.2] } else { [1.7, 2.4] };
        // The error of B-splines changes its sign where cells are as large as that zone, which makes a fit steep.
        let more = if fine { [3.0, 7.0] } else { [3.0, 8.0] };
        let splines = scene.shape == ShapeChoice::Bspline2;
        let penalty = (scene.oedometer_modulus() / scene.elastic.shear_modulus() / MODULI).max(1.0);
        // Nine points in two dimensions integrate B-splines to their order, four do not.
        let well = scene.particles_per_cell >= 9;
        let (order, space, power, time) = match (scene.integrator, solution) {
            (Integrator::QuasiStatic, Solution::Block(_)) if splines => ([3.0, 6.0], 5.3e-4, 4, 0.0),
            (Integrator::QuasiStatic, Solution::Block(_)) => ([1.7, 2.3], 3.4e-2, 2, 0.0),
            (Integrator::QuasiStatic, Solution::Large(..)) if splines => ([2.0, 4.0], 4.1e-4, 2, 0.0),
            (Integrator::QuasiStatic, _) if splines && well => (more, 1.0e-5 * penalty, 5, 0.0),
            (Integrator::QuasiStatic, _) if splines => ([1.7, 2.6], 5.5e-3, 2, 0.0),
            (Integrator::QuasiStatic, Solution::Large(..)) => (second, 7.9e-2, 2, 0.0),
            (Integrator::QuasiStatic, _) => (second, 6.1e-2, 2, 0.0),
            (Integrator::SemiImplicit, _) if splines => (second, 8.8e-2, 2, 0.13),
            (Integrator::SemiImplicit, _) => (second, 5.1e-2, 2, 0.12),
            _ if splines => (second, 8.2e-2, 2, 0.14),
            _ => (second, 6.1e-2, 2, 0.14),
        };
        let floor = if scene.integrator == Integrator::QuasiStatic { 2.0 * scene.tolerance } else { 0.0 };
        Ok(Self { order, space, power, time, floor, from, first, zone })
    }

    /// Largest error allowed on cells `cell` (m) with a step (s) that may be infinite where the integrator chooses.
    pub fn error(&self, cell: f64, step: f64) -> f64 {
        let time = if step.is_finite() { self.time * step / self.first } else { 0.0 };
        (SIZE * (self.space * (cell / self.zone).powi(self.power) + time)).max(self.floor)
    }

    /// The order that these errors must show: none once they are at the floor.
    pub fn order_of(&self, errors: &[(f64, f64)]) -> Option<[f64; 2]> {
        let above = errors.iter().all(|(_, error)| error.is_nan() || error.abs() > self.floor);
        above.then_some(self.order)
    }
}

/// First time that counts, s. An implicit pressure damps the wave of sudden drainage, so that semi-implicit runs are compared
/// from Tv = 0.1 on, and once the exact wave has died as well if it does so within the observed times.
fn from(scene: &Scene, solution: &Solution) -> f64 {
    if let Solution::Block(exact) = solution {
        let counts = scene.observe_times.iter().copied().filter(|time| mandel::counts(exact, *time));
        return counts.fold(f64::INFINITY, f64::min);
    }
    if scene.integrator != Integrator::SemiImplicit {
        return 0.0;
    }
    let late = LATE_TV * scene.time_per_factor().unwrap_or(0.0);
    let Solution::Dynamic(exact, _) = solution else { return late };
    let died = DIED / exact.decay();
    let seen = scene.observe_times.iter().any(|time| *time >= died);
    if seen { late.max(died) } else { late }
}

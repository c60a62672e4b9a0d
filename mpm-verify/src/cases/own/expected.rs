//! What a scheme must show on any scene, from what Table 1's column shows.
//!
//! The largest error is that of the first sample time: the consolidated zone is `H_d sqrt(T)` deep there, and a mesh of
//! cells L resolves it with `r = L/(H_d sqrt(T_1))`. Table 1's column has the error `share r^power` on its finest mesh;
//! any other column may have [`SIZE`] times as much: "errors of the same size".

use mpm_core::scene::{Integrator, Scene, ShapeChoice};

use super::applies::Solution;
use crate::norms::LATE_TV;

/// Errors of the same size: within this factor of those of Table 1's column.
pub const SIZE: f64 = 2.0;

/// What a scheme must show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// Allowed interval of the order.
    pub order: [f64; 2],
    /// Error of Table 1's column over `r^power`.
    pub share: f64,
    /// Power of r that the error goes with at least.
    pub power: i32,
    /// Errors below this are those of time and of linear solves, which have no order in space.
    pub floor: f64,
    /// Compared from Tv = 0.1 on: before, an implicit pressure damps the wave of sudden drainage.
    pub late: bool,
}

impl Expected {
    /// Of the scheme of a scene.
    ///
    /// # Errors
    /// The scene is observed only before the scheme is compared.
    pub fn of(scene: &Scene, solution: &Solution) -> Result<Self, String> {
        let late = scene.integrator == Integrator::SemiImplicit;
        let from = LATE_TV * scene.time_per_factor().unwrap_or(0.0);
        if late && !scene.observe_times.iter().any(|time| *time >= 0.999 * from) {
            let expected = format!("a time from Tv = {LATE_TV} on, where semi-implicit runs are compared");
            return Err(format!("[observe]: expected {expected}, found none"));
        }
        let splines = scene.shape == ShapeChoice::Bspline2;
        let (order, share, power) = match (scene.integrator, solution) {
            (Integrator::QuasiStatic, Solution::Block(_)) if splines => ([2.5, 7.0], 1.0, 3),
            (Integrator::QuasiStatic, Solution::Large(..)) if splines => ([2.0, 4.0], 1.0, 2),
            (Integrator::QuasiStatic, _) if splines => ([2.5, 8.0], 1.0, 3),
            (Integrator::SemiImplicit, _) => ([1.7, 2.4], 1.0, 2),
            _ => ([1.7, 2.4], 1.0, 2),
        };
        let floor = if scene.integrator == Integrator::QuasiStatic { 20.0 * scene.tolerance } else { 0.0 };
        Ok(Self { order, share, power, floor, late })
    }

    /// Largest error allowed on cells of size `cell` (m).
    pub fn error(&self, solution: &Solution, scene: &Scene, cell: f64) -> f64 {
        let from = if self.late { LATE_TV * scene.time_per_factor().unwrap_or(0.0) } else { 0.0 };
        let counted = scene.observe_times.iter().copied().filter(|time| *time > 0.0 && *time >= 0.999 * from);
        let first = counted.map(|time| solution.time_factor(time)).fold(f64::INFINITY, f64::min);
        let resolution = cell / (solution.path() * first.min(LATE_TV).sqrt());
        (SIZE * self.share * resolution.powi(self.power)).max(self.floor)
    }

    /// The order that these errors must show: none once they are at the floor.
    pub fn order_of(&self, errors: &[(f64, f64)]) -> Option<[f64; 2]> {
        let above = errors.iter().filter(|(_, error)| error.is_nan() || error.abs() > self.floor).count();
        (above == errors.len()).then_some(self.order)
    }
}

//! The column on its mesh, exactly in time: what cells of a finite size do to Terzaghi's solution, and nothing else.
//!
//! Assumptions: as Terzaghi with compressible water, but one pressure per cell, a two-point flux between cell
//! centres and half a cell to the drained surface. Then `(1/M + 1/Q) dp/dt = -(k/gamma_w) A p` with A symmetric and
//! tridiagonal; its eigenvectors give p(t) to round-off. All particles of a cell share its strain, so the number of
//! particles does not matter.

use faer::{Mat, Side};
use mpm_core::scene::Scene;

/// A consolidating column of cells.
#[derive(Debug, Clone)]
pub struct SemiDiscrete {
    cell: f64,
    modulus: f64,
    load: f64,
    /// Decay rates, 1/s.
    rates: Vec<f64>,
    /// `shapes[mode][cell]` times the share of the mode at t = 0, Pa.
    shapes: Vec<Vec<f64>>,
}

impl SemiDiscrete {
    /// The column of a scene drained at its top; `None` if it is dry, unloaded, in layers or drained otherwise.
    pub fn new(scene: &Scene) -> Option<Self> {
        let (water, load) = (scene.water?, scene.surcharge?);
        let drained = scene.stages[scene.stages.len() - 1].drained;
        if drained != [false, false, false, true] || load.ramp_time > 0.0 || !scene.layers.is_empty() {
            return None;
        }
        let n = scene.cells[1];
        let storage = 1.0 / scene.oedometer_modulus() + 1.0 / scene.pore_stiffness();
        let conductance = water.mobility() / (storage * scene.cell * scene.cell);
        let matrix = Mat::from_fn(n, n, |i, j| match (i, j) {
            (i, j) if i == j => {
                let below = if i == 0 { 0.0 } else { 1.0 };
                let above = if i + 1 == n { 2.0 } else { 1.0 };
                conductance * (below + above)
            }
            (i, j) if i.abs_diff(j) == 1 => -conductance,
            _ => 0.0,
        });
        let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
        let (values, vectors) = (eigen.S(), eigen.U());
        let first = scene.undrained_pressure();
        let shapes = (0..n)
            .map(|mode| {
                let share: f64 = (0..n).map(|cell| first * vectors[(cell, mode)]).sum();
                (0..n).map(|cell| share * vectors[(cell, mode)]).collect()
            })
            .collect();
        let rates = (0..n).map(|mode| values[mode]).collect();
        Some(Self { cell: scene.cell, modulus: scene.oedometer_modulus(), load: load.pressure, rates, shapes })
    }

    /// Pore pressure of every cell from the base up at a time (s), Pa.
    pub fn pressures(&self, time: f64) -> Vec<f64> {
        let mut pressures = vec![0.0; self.rates.len()];
        for (rate, shape) in self.rates.iter().zip(&self.shapes) {
            let decay = (-rate * time).exp();
            for (pressure, s) in pressures.iter_mut().zip(shape) {
                *pressure += decay * s;
            }
        }
        pressures
    }

    /// Settlement of the surface from the unloaded state, m.
    pub fn settlement(&self, time: f64) -> f64 {
        self.pressures(time).iter().map(|p| self.cell * (self.load - p) / self.modulus).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::terzaghi::Terzaghi;
    use super::*;

    #[test]
    fn it_converges_to_terzaghi_at_second_order() {
        let scene = crate::scenes::terzaghi();
        let time = 0.1 * scene.time_per_factor().expect("wet");
        let exact = Terzaghi::compressible(&scene).expect("wet").settlement(time);
        let mut errors = Vec::new();
        for n in [10usize, 20, 40, 80] {
            let scene = scene.with_rows(n).expect("a sound scene");
            let on_mesh = SemiDiscrete::new(&scene).expect("wet");
            assert!((on_mesh.pressures(0.0)[n / 2] - scene.undrained_pressure()).abs() < 1e-8);
            errors.push((on_mesh.settlement(time) / exact - 1.0).abs());
        }
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 2.0).abs() < 0.05, "{order}");
        }
    }
}

//! Steps of SDIRK4(3): five equal diagonal entries 1/4, L-stable and stiffly accurate, of order 4 with an embedded
//! estimate of order 3 (Hairer & Wanner 1996, Solving ODEs II, eq. (IV.6.16)).
//!
//! The water balance is `d/dt content = -flow` under the constraint of equilibrium; a stage solves
//! `content_i + h gamma flow_i = content_n - h sum_j<i a_ij flow_j` with its forces in balance. An L-stable first
//! stage carries the sudden load at t = 0. The estimate is filtered by a solve, as its stiff part would be overrated.

use super::motion::STAGES;
use super::newton::{Stage, Workspace};
use super::soil::{HELD, Impulses, Soil};
use super::tangent::Stuck;
use crate::constitutive::Law;
use crate::real::array_of;

/// gamma.
pub(super) const GAMMA: f64 = 0.25;
/// a_ij below the diagonal; the last row is b.
const A: [[f64; STAGES]; STAGES] = [
    [GAMMA, 0.0, 0.0, 0.0, 0.0],
    [0.5, GAMMA, 0.0, 0.0, 0.0],
    [17.0 / 50.0, -1.0 / 25.0, GAMMA, 0.0, 0.0],
    [371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0, GAMMA, 0.0],
    [25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0, GAMMA],
];
const C: [f64; STAGES] = [0.25, 0.75, 11.0 / 20.0, 0.5, 1.0];
/// b minus the weights of order 3.
const E: [f64; STAGES] = [-3.0 / 16.0, -27.0 / 32.0, 25.0 / 32.0, 0.0, 0.25];

/// Integrals over a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct StepSums {
    /// Flow of pressure functions that are fixed at zero, and through drained faces, m3.
    pub outflow: f64,
    /// Water that wells put in, m3.
    pub put_in: f64,
    /// Friction in the pores, J.
    pub dissipation: f64,
    /// Work of gravity on the flow, J.
    pub body_work: f64,
    /// Work of the water outside on what it presses in, J.
    pub pressed_in: f64,
    /// What inertia has to do with.
    pub motion: Impulses,
}

/// Vectors of a step.
#[derive(Debug, Default)]
pub(super) struct Sdirk {
    flow: [Vec<f64>; STAGES],
    target: Vec<f64>,
    rhs: Vec<f64>,
    /// Estimated error of the unknowns.
    pub error: Vec<f64>,
    /// Unknowns at the end of the step.
    pub end: Vec<f64>,
}

impl Sdirk {
    pub fn new(functions: usize, unknowns: usize) -> Self {
        Self {
            flow: std::array::from_fn(|_| vec![0.0; functions]),
            target: vec![0.0; functions],
            rhs: vec![0.0; unknowns],
            error: vec![0.0; unknowns],
            end: vec![0.0; unknowns],
        }
    }

    /// One step of `h` (s) from unknowns `start` with a water content; `bear` puts the load at a share of the step on the soil. The
    /// result is in [`Self::end`], its error in [`Self::error`]. The factors must be those for `GAMMA h`.
    pub fn step<L: Law, const D: usize>(
        &mut self,
        soil: &mut Soil<L, D>,
        (start, content): (&[f64], &[f64]),
        h: f64,
        bear: impl Fn(&mut Soil<L, D>, f64),
        (work, tolerance): (&mut Workspace, f64),
    ) -> Result<StepSums, Stuck<D>> {
        let mut sums = StepSums::default();
        self.end.copy_from_slice(start);
        // Without water nothing flows: only the equilibrium at the end of the step is left, which the last stage is.
        let dry = soil.p.is_empty() && soil.motion.is_none();
        if soil.motion.is_some() {
            bear(soil, 0.0);
            soil.expand(start);
        }
        if let Some(motion) = &mut soil.motion {
            motion.start(&soil.u);
        }
        for i in if dry { STAGES - 1..STAGES } else { 0..STAGES } {
            self.target.copy_from_slice(content);
            for j in 0..i {
                for (target, flow) in self.target.iter_mut().zip(&self.flow[j]) {
                    *target -= h * A[i][j] * flow;
                }
            }
            bear(soil, C[i]);
            if let Some(motion) = &mut soil.motion {
                motion.begin(&array_of::<f64, STAGES, _>(|j| h * A[i][j])[..i], GAMMA * h);
            }
            let stage = Stage { a: GAMMA * h, target: &self.target, tolerance };
            soil.fulfil(&stage, &mut self.end, work)?;
            self.flow[i].copy_from_slice(&soil.values.flow);
            if let Some(motion) = &mut soil.motion {
                motion.done(i);
            }
            let weight = h * A[STAGES - 1][i];
            if soil.motion.is_some() {
                sums.motion.add(weight, &soil.impulses());
            }
            sums.outflow += weight * (soil.values.outflow - soil.held(&soil.values.flow));
            sums.put_in += weight * soil.wells.iter().map(|(.., rate)| (-rate).max(0.0)).sum::<f64>();
            sums.dissipation += weight * soil.values.dissipation;
            sums.body_work += weight * soil.values.body_work;
            sums.pressed_in += weight * (soil.values.pressed_in + soil.pressed_in(soil.values.flow.iter().copied()));
        }
        if !dry {
            self.estimate(soil, h)?;
        }
        Ok(sums)
    }

    /// `(S + gamma h H) error = h sum e_i flow_i`, at equilibrium.
    fn estimate<L: Law, const D: usize>(&mut self, soil: &mut Soil<L, D>, h: f64) -> Result<(), Stuck<D>> {
        self.rhs.fill(0.0);
        for (function, map) in soil.water_map.iter().enumerate() {
            if *map != HELD {
                let sum: f64 = (0..STAGES).map(|i| E[i] * self.flow[i][function]).sum();
                self.rhs[*map as usize] = soil.scales[1] * h * sum;
            }
        }
        if let Some(motion) = soil.motion.as_mut().filter(|motion| motion.resolves) {
            motion.note_errors(&E.map(|e| h * e));
            soil.unbalanced(&mut self.rhs);
        }
        soil.system.solve(&self.rhs, &mut self.error).map_err(Stuck::Unsolved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_fulfil_the_order_conditions() {
        for i in 0..STAGES {
            assert!((A[i].iter().sum::<f64>() - C[i]).abs() < 1e-14);
        }
        let b = A[STAGES - 1];
        let sum = |f: &dyn Fn(usize) -> f64, w: &[f64; STAGES]| (0..STAGES).map(|i| w[i] * f(i)).sum::<f64>();
        let ac = |i: usize| (0..STAGES).map(|j| A[i][j] * C[j]).sum::<f64>();
        let ac2 = |i: usize| (0..STAGES).map(|j| A[i][j] * C[j] * C[j]).sum::<f64>();
        let aac = |i: usize| (0..STAGES).map(|j| A[i][j] * ac(j)).sum::<f64>();
        let third: [(&dyn Fn(usize) -> f64, f64); 4] =
            [(&|_| 1.0, 1.0), (&|i| C[i], 0.5), (&|i| C[i].powi(2), 1.0 / 3.0), (&ac, 1.0 / 6.0)];
        let fourth: [(&dyn Fn(usize) -> f64, f64); 4] =
            [(&|i| C[i].powi(3), 0.25), (&|i| C[i] * ac(i), 0.125), (&ac2, 1.0 / 12.0), (&aac, 1.0 / 24.0)];
        for (condition, value) in third.into_iter().chain(fourth) {
            assert!((sum(condition, &b) - value).abs() < 1e-13);
        }
        for (condition, _) in third {
            assert!(sum(condition, &E).abs() < 1e-13);
        }
        assert!(sum(fourth[0].0, &E).abs() > 1e-3);
    }
}

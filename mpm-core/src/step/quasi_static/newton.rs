//! Equilibrium and water balance at the end of a stage: Newton's iteration with a line search.
//!
//! A linear scene is solved by one solve. At large strain, where the matrix leaves parts out, factors are kept as long as they reduce
//! the residual well. At small strain they are renewed in every iteration: with consistent tangents it converges quadratically.

use super::soil::{HELD, Soil};
use super::tangent::Stuck;
use crate::constitutive::Law;

/// Most iterations.
const ITERATIONS: usize = 30;
/// Shortest part of a correction that the line search tries.
const SHORTEST: f64 = 1.0 / 256.0;
/// Factors are renewed when an iteration leaves more than this share of the residual.
const SLOW: f64 = 0.3;
/// The same under a law that is not linear: what a corner of its surface changes no older factors know.
const SLOW_LAW: f64 = 0.01;
/// So many iterations may raise the residual under a law that is not linear: plastic flow begins in points that the last factors
/// took for elastic.
const RISING: usize = 10;

/// What a stage has to fulfil.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stage<'a> {
    /// gamma dt, s: weight of the flow beside the water content.
    pub a: f64,
    /// Water content plus a times flow per pressure function, m3.
    pub target: &'a [f64],
    /// Residual to reach, as a share of [`Workspace::reference`].
    pub tolerance: f64,
}

/// Vectors over the unknowns.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    residual: Vec<f64>,
    correction: Vec<f64>,
    trial: Vec<f64>,
    /// Residuals of the present stage, one per iteration, as shares of the reference.
    history: Vec<f64>,
    /// Size of forces that a residual is compared with, in scaled units.
    pub reference: f64,
}

impl Workspace {
    pub fn new(size: usize, reference: f64) -> Self {
        let zeros = || vec![0.0; size];
        let history = Vec::with_capacity(ITERATIONS + 2);
        Self { residual: zeros(), correction: zeros(), trial: zeros(), history, reference }
    }

    /// Iterations of the last stage that is not linear.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }
}

impl<L: Law, const D: usize> Soil<L, D> {
    /// Forces without the loads on the unknowns of the displacements at the last evaluation, scaled as the matrix.
    pub(super) fn forces(&self) -> Vec<f64> {
        let mut forces = vec![0.0; self.unknowns()];
        for (function, map) in self.soil_map.iter().enumerate() {
            for d in (0..D).filter(|d| map[*d] != HELD) {
                forces[map[d] as usize] += self.scales[0] * self.values.force[function * D + d];
            }
        }
        forces
    }

    /// Out-of-balance of a stage at the last evaluation, scaled as the matrix. Returns the largest, in which volumes of water count by
    /// the pressures that they make ([`Motion::lever`](super::motion::Motion::lever)).
    fn out_of_balance(&self, stage: &Stage, residual: &mut [f64]) -> f64 {
        let [length, pressure] = self.scales;
        let lever = self.motion.as_ref().map_or(1.0, |motion| motion.lever(stage.a));
        residual.fill(0.0);
        for (function, map) in self.soil_map.iter().enumerate() {
            for d in 0..D {
                if map[d] != HELD {
                    let at = function * D + d;
                    residual[map[d] as usize] += length * (self.values.force[at] - self.load[at]);
                }
            }
        }
        let forces = largest(residual);
        let mut volumes: f64 = 0.0;
        for (function, map) in self.water_map.iter().enumerate() {
            if *map != HELD {
                let v = &self.values;
                let off = pressure * (stage.target[function] - v.content[function] - stage.a * v.flow[function]);
                residual[*map as usize] = off;
                volumes = if off.is_nan() || volumes.is_nan() { f64::NAN } else { volumes.max(lever * off.abs()) };
            }
        }
        if volumes > forces || volumes.is_nan() { volumes } else { forces }
    }

    /// Whether a correction would move soil that is strained a little by more than its own extent: its matrix is all but singular,
    /// and what balances out there is no state of the soil.
    fn flung(&self, correction: &[f64]) -> bool {
        // Displacements are counted in cells.
        let extent = self.axes.iter().map(|axis| axis.cells()).max().unwrap_or(0) as f64;
        let mut moved = self.soil_map.iter().flatten().filter(|map| **map != HELD);
        self.small && moved.any(|map| correction[*map as usize].abs() > extent)
    }

    /// Moves `y` to where the stage is fulfilled, and evaluates there. The factors must be those for `stage.a`.
    pub fn fulfil(&mut self, stage: &Stage, y: &mut [f64], work: &mut Workspace) -> Result<(), Stuck<D>> {
        self.evaluate(y).map_err(Stuck::InsideOut)?;
        self.fulfil_from(stage, y, work)
    }

    /// The same from unknowns that have been evaluated.
    pub fn fulfil_from(&mut self, stage: &Stage, y: &mut [f64], work: &mut Workspace) -> Result<(), Stuck<D>> {
        let mut size = self.out_of_balance(stage, &mut work.residual) / work.reference;
        let round_off = self.motion.as_ref().map_or(0.0, |motion| self.scales[0] * motion.round_off(stage.a, &self.u));
        let tolerance = stage.tolerance.max(round_off / work.reference);
        work.history.clear();
        work.history.push(size);
        let (slow, rising) = match (self.law.are_linear(), self.small) {
            (true, _) => (SLOW, 0),
            (false, true) => (0.0, RISING),
            (false, false) => (SLOW_LAW, RISING),
        };
        for iteration in 0..ITERATIONS {
            if size <= tolerance && !self.linear() {
                return Ok(());
            }
            let solved = self.system.solve(&work.residual, &mut work.correction);
            if self.linear() {
                solved.map_err(Stuck::Unsolved)?;
                for (y, c) in y.iter_mut().zip(&work.correction) {
                    *y -= c;
                }
                return self.evaluate(y).map_err(Stuck::InsideOut);
            }
            // A law that has lost its stiffness on the way asks for a shorter step, not for another system.
            if solved.is_err() || self.flung(&work.correction) {
                return Err(Stuck::NotConverged(work.history.clone()));
            }
            let before = size;
            let mut part = 1.0;
            loop {
                for i in 0..y.len() {
                    work.trial[i] = y[i] - part * work.correction[i];
                }
                let evaluated = self.evaluate(&work.trial);
                if evaluated.is_ok() {
                    size = self.out_of_balance(stage, &mut work.residual) / work.reference;
                }
                if evaluated.is_ok() && (size < before || size <= tolerance || iteration < rising) {
                    break;
                }
                part *= 0.5;
                if part < SHORTEST {
                    work.history.push(size);
                    return Err(Stuck::NotConverged(work.history.clone()));
                }
            }
            y.copy_from_slice(&work.trial);
            work.history.push(size);
            if size > slow * before && size > tolerance {
                self.refresh(stage.a).map_err(|_| Stuck::NotConverged(work.history.clone()))?;
            }
        }
        Err(Stuck::NotConverged(work.history.clone()))
    }
}

/// Largest magnitude; NaN if there is one.
pub(super) fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, v| if v.is_nan() || m.is_nan() { f64::NAN } else { f64::max(m, v.abs()) })
}

//! Coulomb friction on the base: `|tau| <= adhesion + tan(angle) sigma_n`, with an angle that may fall with slip.
//!
//! The base holds its nodes up as a roller does; what that takes in a step is the normal impulse N dt. Along the base a
//! node that stood still stays so while the impulse that holds it is within the limit, as on a fixed base. A node that
//! slides is slowed by at most the limit, and stands still once that stops it: after Bardenhagen, Brackbill & Sulsky
//! (2000), doi:10.1016/S0045-7825(99)00338-2, with a rigid base for the second body.
//!
//! Slip belongs to the soil: its particles in the lowest row of cells carry it, with its sign, and a node has the mean
//! of theirs by mass. Swings about a place add nothing to it.

use super::Joined;
use crate::grid::Grid;
use crate::nodes::{NodeMotion, NodeSums};
use crate::particles::{Layer, SolidPoint};
use crate::scene::{Base, NormalStress};

/// What the base did in a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Rubbed {
    /// Impulse on the soil along the base, N s.
    pub impulse: f64,
    /// Energy lost, J.
    pub loss: f64,
}

/// A base with friction.
#[derive(Debug, Clone)]
pub struct Coulomb {
    base: Base,
    /// tan of the peak and the residual angle.
    peak: f64,
    residual: f64,
    /// Nodes that did not move along the base in the last step.
    stuck: Vec<bool>,
    /// Nodes that something else holds along the base.
    held: Vec<bool>,
    /// Slip of each particle by its number, m; empty if the base does not weaken.
    slip: Vec<f64>,
    /// Sums of the lowest row at its nodes: mass (kg), mass times slip (kg m), length of base (m), its load by the pore
    /// water (N); empty if nothing needs them.
    shares: Vec<[f64; 4]>,
    wet: bool,
}

impl Coulomb {
    /// A base under a mesh with so many particles. `held` are the nodes of the base that cannot slide.
    pub fn new<const D: usize>(
        base: Base,
        grid: &Grid<D>,
        particles: usize,
        held: impl Iterator<Item = usize>,
        wet: bool,
    ) -> Self {
        let count = grid.cells[0] + 1;
        let mut fixed = vec![false; count];
        held.filter(|node| *node < count).for_each(|node| fixed[node] = true);
        let wet = wet && base.normal_stress == NormalStress::Effective;
        let weakens = base.slip_distance.is_some();
        let shared = weakens || wet || base.adhesion > 0.0;
        Self {
            base,
            peak: base.peak_angle.to_radians().tan(),
            residual: base.residual_angle.to_radians().tan(),
            stuck: vec![false; count],
            held: fixed,
            slip: vec![0.0; if weakens { particles } else { 0 }],
            shares: vec![[0.0; 4]; if shared { count } else { 0 }],
            wet,
        }
    }

    /// tan of the friction angle after a slip (m).
    fn friction(&self, slip: f64) -> f64 {
        match self.base.slip_distance {
            Some(distance) => self.peak - (self.peak - self.residual) * (slip.abs() / distance).min(1.0),
            None => self.peak,
        }
    }

    /// Gathers what the nodes of the base need of the soil above; `pressure` is that of the pore water in a cell, Pa.
    pub fn gather<const D: usize, const S: usize>(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D, S>, D>,
        joined: &Joined<D>,
        pressure: impl Fn(usize) -> f64,
    ) {
        if self.shares.is_empty() {
            return;
        }
        self.shares.fill([0.0; 4]);
        for cell in 0..grid.cells[0] {
            let load = if self.wet && !solid.range(cell).is_empty() { pressure(cell) } else { 0.0 };
            for index in solid.range(cell) {
                let point = &solid.points[index];
                let right = point.x[0] * grid.inverse_size - cell as f64;
                let slip = self.slip.get(solid.ids[index] as usize).copied().unwrap_or(0.0);
                // A full cell has the length of its edge.
                let length = point.volume * grid.inverse_size;
                for (node, share) in [(cell, 1.0 - right), (cell + 1, right)] {
                    let sums = &mut self.shares[node];
                    sums[0] += share * point.mass;
                    sums[1] += share * point.mass * slip;
                    sums[2] += share * length;
                    sums[3] += share * length * load;
                }
            }
        }
        let count = self.shares.len();
        for [follower, leader] in joined.pairs().filter(|pair| pair.iter().all(|node| *node < count)) {
            let shares = std::mem::take(&mut self.shares[follower]);
            for (to, share) in self.shares[leader].iter_mut().zip(shares) {
                *to += share;
            }
        }
    }

    /// Slows the nodes of the base over a step `dt` (s), after [`Self::gather`] and before the normal support is applied.
    pub fn rub<const D: usize>(&mut self, nodes: &[NodeSums<D>], motion: &mut [NodeMotion<D>], dt: f64) -> Rubbed {
        let mut rubbed = Rubbed::default();
        for node in 0..self.stuck.len() {
            let (mass, m) = (nodes[node].mixture_mass, &mut motion[node]);
            if mass <= 0.0 || self.held[node] {
                self.stuck[node] = false;
                continue;
            }
            let [of, slip, length, load] = self.shares.get(node).copied().unwrap_or([1.0, 0.0, 0.0, 0.0]);
            // What the support above a base that does not pull has to take.
            let normal = (-mass * m.change[D - 1] - load * dt).max(0.0);
            let slip = if of > 0.0 { slip / of } else { 0.0 };
            let limit = self.friction(slip) * normal + self.base.adhesion * length * dt;
            if self.stuck[node] && mass * m.change[0].abs() <= limit {
                rubbed.impulse -= mass * m.change[0];
                (m.velocity[0], m.change[0], m.acceleration[0]) = (0.0, 0.0, 0.0);
                continue;
            }
            let stopping = -mass * m.velocity[0];
            let impulse = stopping.clamp(-limit, limit);
            let slower = impulse / mass;
            self.stuck[node] = impulse == stopping;
            m.velocity[0] = if self.stuck[node] { 0.0 } else { m.velocity[0] + slower };
            m.change[0] += slower;
            m.acceleration[0] += slower / dt;
            rubbed.impulse += impulse;
            rubbed.loss -= impulse * (m.velocity[0] - 0.5 * dt * m.acceleration[0]);
        }
        rubbed
    }

    /// Adds the slip of a step to the particles of the lowest row.
    pub fn slide<const D: usize, const S: usize>(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D, S>, D>,
        motion: &[NodeMotion<D>],
        dt: f64,
    ) {
        if self.slip.is_empty() {
            return;
        }
        for cell in 0..grid.cells[0] {
            let [left, right] = [cell, cell + 1].map(|node| motion[node].velocity[0]);
            for index in solid.range(cell) {
                let xi = solid.points[index].x[0] * grid.inverse_size - cell as f64;
                self.slip[solid.ids[index] as usize] += dt * (left + xi * (right - left));
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.slip.capacity() * size_of::<f64>() + self.shares.capacity() * size_of::<[f64; 4]>()
    }
}

//! A given force on the soil, gathered from its particles: `f_i = sum_p m_p b(x_p, t) N_i(x_p)`.

use std::fmt;

use super::ForceField;
use crate::nodes::{NodeMotion, NodeSums};
use crate::observe::Totals;

/// A given force, and what it is at the nodes in this step.
#[derive(Clone)]
pub struct BodyForce<const D: usize> {
    field: ForceField,
    /// Force on each node, N.
    nodes: Vec<[f64; D]>,
}

impl<const D: usize> BodyForce<D> {
    /// A force that no node feels yet.
    pub fn new(field: ForceField) -> Self {
        Self { field, nodes: Vec::new() }
    }

    /// Begins to gather at `count` nodes.
    pub fn clear(&mut self, count: usize) {
        self.nodes.clear();
        self.nodes.resize(count, [0.0; D]);
    }

    /// The force (N) on soil of a dry mass (kg) at a place (m) and time (s).
    pub fn on(&self, mass: f64, x: &[f64; D], time: f64) -> [f64; D] {
        let across = if D == 2 { x[0] } else { 0.0 };
        let b = (self.field)([across, x[D - 1]], time);
        std::array::from_fn(|d| mass * b[d + 2 - D])
    }

    /// Gives a node its share of a force (N).
    pub fn add(&mut self, node: usize, share: f64, force: &[f64; D]) {
        for d in 0..D {
            self.nodes[node][d] += share * force[d];
        }
    }

    /// Adds what was gathered to the sums of the nodes.
    pub fn push(&self, sums: &mut [NodeSums<D>]) {
        for (sum, force) in sums.iter_mut().zip(&self.nodes) {
            for d in 0..D {
                sum.force[d] += force[d];
            }
        }
    }

    /// Books impulse and work of a step with those of gravity; the work at the velocity `before` (s) the end of the step.
    pub fn book(&self, totals: &mut Totals<D>, motion: &[NodeMotion<D>], dt: f64, before: f64) {
        for (force, motion) in self.nodes.iter().zip(motion) {
            for d in 0..D {
                let impulse = dt * force[d];
                totals.gravity_impulse[d] += impulse;
                totals.gravity_work += impulse * (motion.velocity[d] - before * motion.acceleration[d]);
            }
        }
    }
}

impl<const D: usize> fmt::Debug for BodyForce<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BodyForce").field("nodes", &self.nodes.len()).finish_non_exhaustive()
    }
}

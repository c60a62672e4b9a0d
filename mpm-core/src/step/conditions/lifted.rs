//! Nodes too light for the step: their inertia is lifted to a least share of the particles around.
//!
//! The wave of a node that carries the share s of the mass of what it touches has `omega^2 = M/(rho L^2)/s` of its cell:
//! no step is stable for a surface that has just moved into a cell. With a quarter of the mass that touches it along each
//! axis (evenly spaced particles give a third to a half) a node has at most 5/4 of the frequency of the mesh. Velocities and
//! equilibrium do not change by it: only what an unbalanced force does to so light a node is slowed down, and the momentum
//! that it does not get is recorded.

use super::{Condition, Soil};
use crate::observe::Totals;
use crate::step::store::Nodes;
use crate::step::store::nodes::{MIXTURE_MASS, MOMENTUM, SOLID_MASS};

/// Least share of the mass that touches a node, along an axis with a surface.
const SHARE: f64 = 0.25;
/// Its share along an axis that is full of soil.
const FULL: f64 = 0.5;

/// Inertia that is lifted.
#[derive(Debug, Clone)]
pub struct Lifted<const D: usize> {
    /// Dry mass of the particles that reach each node, kg.
    touching: Vec<f64>,
    /// Nodes and the mass of the mixture (kg) that was added to them.
    added: Vec<(u32, f64)>,
    /// Least share of the mass that touches a node.
    share: f64,
    /// Gravity, m/s2: added inertia has no weight.
    gravity: [f64; D],
    /// FLIP share of the velocity update.
    flip: f64,
}

impl<const D: usize> Lifted<D> {
    /// For so many nodes. `level`: soil between supported sides, whose only surface is on top, so that a block is as a column.
    pub fn new(nodes: usize, level: bool, gravity: [f64; D], flip: f64) -> Self {
        let share = if level { SHARE * FULL.powi(D as i32 - 1) } else { SHARE.powi(D as i32) };
        Self { touching: vec![0.0; nodes], added: Vec::with_capacity(nodes), share, gravity, flip }
    }
}

impl<const D: usize> Condition<D> for Lifted<D> {
    fn gathered(&mut self, nodes: &mut Nodes<D>, soil: &dyn Soil<D>) {
        self.touching.fill(0.0);
        soil.each_cell(&mut |mass, functions| functions.for_each(|function| self.touching[function] += mass));
        for (node, touching) in self.touching.iter().enumerate().filter(|(_, touching)| **touching > 0.0) {
            let (solid, least) = (nodes.sum(SOLID_MASS, node), self.share * touching);
            if solid > 0.0 && solid < least {
                let more = (least / solid - 1.0) * nodes.mixture_mass(node);
                *nodes.sum_mut(MIXTURE_MASS, node) += more;
                for d in 0..D {
                    nodes.push(node, d, -more * self.gravity[d]);
                }
                self.added.push((node as u32, more));
            }
        }
    }

    /// Takes it back, and records the momentum that was left out.
    fn followed(&mut self, nodes: &mut Nodes<D>, _: &dyn Soil<D>, totals: &mut Totals<D>, dt: f64) {
        for (node, more) in self.added.drain(..) {
            let node = node as usize;
            *nodes.sum_mut(MIXTURE_MASS, node) -= more;
            for d in 0..D {
                let (motion, acceleration) = (&nodes.motion, nodes.motion.acceleration[d][node]);
                // A node that is fixed stops what came with its particles: added inertia came with none.
                let came = nodes.sum(MOMENTUM + d, node) / nodes.sum(SOLID_MASS, node);
                let stopped = motion.velocity[d][node] - came - dt * acceleration;
                totals.support_impulse[d] -= more * (1.0 - self.flip) * stopped;
                totals.cut_off_impulse[d] -= dt * more * acceleration;
                nodes.push(node, d, more * self.gravity[d]);
            }
        }
    }

    fn bytes(&self) -> usize {
        self.touching.capacity() * size_of::<f64>() + self.added.capacity() * size_of::<(u32, f64)>()
    }
}

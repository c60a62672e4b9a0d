//! Nodes too light for the step: their inertia is lifted to a least share of the particles around.
//!
//! The wave of a node that carries the share s of the mass of what it touches has `omega^2 = M/(rho L^2)/s` of its cell:
//! no step is stable for a surface that has just moved into a cell. With a quarter of the mass that touches it along each
//! axis (evenly spaced particles give a third to a half) a node has at most 5/4 of the frequency of the mesh. Velocities and
//! equilibrium do not change by it: only what an unbalanced force does to so light a node is slowed down, and the momentum
//! that it does not get is booked.

use crate::nodes::{NodeMotion, NodeSums};
use crate::observe::Totals;

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
}

impl<const D: usize> Lifted<D> {
    /// For so many nodes. `level`: soil between held sides, whose only surface is on top, so that a block is as a column.
    pub fn new(nodes: usize, level: bool) -> Self {
        let share = if level { SHARE * FULL.powi(D as i32 - 1) } else { SHARE.powi(D as i32) };
        Self { touching: vec![0.0; nodes], added: Vec::with_capacity(nodes), share }
    }

    /// Before the particles are gathered.
    pub fn clear(&mut self) {
        self.touching.fill(0.0);
        self.added.clear();
    }

    /// A particle of this dry mass (kg) reaches a node.
    #[inline(always)]
    pub fn touch(&mut self, node: usize, mass: f64) {
        self.touching[node] += mass;
    }

    /// Gives light nodes more inertia.
    pub fn lift(&mut self, nodes: &mut [NodeSums<D>]) {
        let share = self.share;
        for (number, (node, touching)) in nodes.iter_mut().zip(&self.touching).enumerate() {
            if node.solid_mass > 0.0 && node.solid_mass < share * touching {
                let more = (share * touching / node.solid_mass - 1.0) * node.mixture_mass;
                node.mixture_mass += more;
                self.added.push((number as u32, more));
            }
        }
    }

    /// Takes it back after a step under `motion`, and books the momentum that was left out.
    pub fn lower(&mut self, nodes: &mut [NodeSums<D>], motion: &[NodeMotion<D>], dt: f64, totals: &mut Totals<D>) {
        for (node, more) in self.added.drain(..) {
            nodes[node as usize].mixture_mass -= more;
            for d in 0..D {
                totals.cut_off_impulse[d] -= dt * more * motion[node as usize].acceleration[d];
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.touching.capacity() * size_of::<f64>() + self.added.capacity() * size_of::<(u32, f64)>()
    }
}

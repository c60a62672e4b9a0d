//! Two ways to carry velocities between particles and nodes that few scenes ask for.
//!
//! **Affine** (Nakamura, Matsumura & Mizutani 2023, doi:10.1016/j.cma.2022.115720; Jiang, Schroeder & Teran 2017,
//! doi:10.1016/j.jcp.2017.02.050): a particle gives a node its velocity at the place of the node, `v_p + L_p (x_i - x_p)`, L_p its
//! velocity gradient of the step before. Without it a node at an edge, whose particles are all on one side of it, gets the
//! velocity of these, and a body that only turns is strained there by as much as it turns.
//!
//! **Mapped back** (MUSL; Sulsky, Zhou & Schreyer 1995, doi:10.1016/0010-4655(94)00170-7): the soil is strained by velocities that the
//! particles, once they have theirs of the end of the step, give back to the nodes. A node with next to no mass may be
//! accelerated as it likes: what its particles get is `N_i f_i/m_i`, and finite. With velocities of the nodes (USL) the cell
//! of such a node is strained by `f_i/m_i`, and a step that is stable inside the soil is not at its edge.

use crate::boundary::Supports;
use crate::dimension::Gradient;
use crate::keep::Keeper;
use crate::nodes::{NodeMotion, NodeSums};

/// How velocities are carried, and what that keeps.
#[derive(Debug, Clone)]
pub struct Transfer<const D: usize> {
    /// Velocity gradient of each particle by its number, 1/s; `None` where velocities alone are carried.
    pub affine: Option<Vec<Gradient<D>>>,
    /// Velocities of the nodes that strain the soil, m/s; `None` where they are those of the nodes themselves.
    pub mapped: Option<Vec<NodeMotion<D>>>,
}

impl<const D: usize> Transfer<D> {
    /// For so many particles and nodes; `None` if there is nothing to do.
    pub fn new(affine: bool, mapped: bool, particles: usize, nodes: usize) -> Option<Box<Self>> {
        (affine || mapped).then(|| {
            Box::new(Self {
                affine: affine.then(|| vec![[[0.0; D]; D]; particles]),
                mapped: mapped.then(|| vec![NodeMotion::REST; nodes]),
            })
        })
    }

    /// Velocity of a particle at a place away from it (m), less its own, m/s.
    #[inline(always)]
    pub fn beyond(gradient: &Gradient<D>, away: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|i| (0..D).map(|j| gradient[i][j] * away[j]).sum())
    }

    /// Turns the momenta gathered in `mapped` (kg m/s) into velocities, held where the nodes are.
    pub fn settle(mapped: &mut [NodeMotion<D>], nodes: &[NodeSums<D>], supports: &Supports<D>) {
        for (motion, node) in mapped.iter_mut().zip(nodes) {
            let inverse = if node.solid_mass > 0.0 { 1.0 / node.solid_mass } else { 0.0 };
            motion.velocity = motion.velocity.map(|momentum| momentum * inverse);
        }
        supports.stop(mapped);
    }

    /// Writes or reads what steps to come depend on.
    pub fn keep(&mut self, keeper: &mut Keeper) {
        if let Some(affine) = &mut self.affine {
            keeper.entries(affine, |gradient, keeper| gradient.iter_mut().for_each(|row| keeper.f64s(row)));
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.affine.as_ref().map_or(0, |a| a.capacity() * size_of::<Gradient<D>>())
            + self.mapped.as_ref().map_or(0, |m| m.capacity() * size_of::<NodeMotion<D>>())
    }
}

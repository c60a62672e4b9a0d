//! A rigid plate on the soil.

use super::{Condition, Soil};
use crate::step::store::Nodes;
use crate::step::store::nodes::{MIXTURE_MASS, MOMENTUM, SOLID_MASS, force};

/// A rigid plate without friction on the top: its nodes have one vertical velocity.
///
/// Momentum and force of all its nodes are shared out by their masses, so that the equation of motion gives each the velocity of the
/// plate.
#[derive(Debug, Clone)]
pub struct RigidPlate(
    /// Its nodes.
    pub Vec<u32>,
);

impl<const D: usize> Condition<D> for RigidPlate {
    fn gathered(&mut self, nodes: &mut Nodes<D>, _: &dyn Soil<D>) {
        self.pushed(nodes);
    }

    fn plate(&self) -> &[u32] {
        &self.0
    }

    fn pushed(&mut self, nodes: &mut Nodes<D>) {
        let sum = |nodes: &Nodes<D>, q: usize| self.0.iter().map(|node| nodes.sum(q, *node as usize)).sum::<f64>();
        let [solid, mixture] = [SOLID_MASS, MIXTURE_MASS].map(|q| sum(nodes, q));
        if solid <= 0.0 {
            return;
        }
        for (q, of, whole) in [(MOMENTUM + D - 1, SOLID_MASS, solid), (force(D) + D - 1, MIXTURE_MASS, mixture)] {
            let total = sum(nodes, q);
            for node in self.0.iter().map(|node| *node as usize) {
                *nodes.sum_mut(q, node) = total * (nodes.sum(of, node) / whole);
            }
        }
    }
}

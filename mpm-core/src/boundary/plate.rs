//! A rigid plate without friction on the top: its nodes have one vertical velocity.

use crate::nodes::NodeSums;

/// The nodes, or coefficients, of the top row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plate {
    nodes: Vec<u32>,
}

impl Plate {
    /// The last row of a mesh with so many coefficients along each axis.
    pub fn new<const D: usize>(along: &[usize; D]) -> Self {
        let count: usize = along.iter().product();
        Self { nodes: (count - count / along[D - 1]..count).map(|node| node as u32).collect() }
    }

    /// Its nodes.
    pub fn nodes(&self) -> impl Iterator<Item = usize> {
        self.nodes.iter().map(|node| *node as usize)
    }

    /// Whether a node is one of it.
    pub fn holds(&self, node: usize) -> bool {
        self.nodes.first().is_some_and(|first| node >= *first as usize)
    }

    /// Mass of soil and water that moves with it, kg.
    pub fn mass<const D: usize>(&self, nodes: &[NodeSums<D>]) -> f64 {
        self.nodes().map(|node| nodes[node].mixture_mass).sum()
    }

    /// Shares vertical momentum and force over its nodes by mass, so that the equation of motion moves them alike:
    /// the rigid plate gives and takes no more than it has to, and neither momentum nor force is lost.
    pub fn level<const D: usize>(&self, nodes: &mut [NodeSums<D>]) {
        let (mut solid, mut momentum, mut force) = (0.0, 0.0, 0.0);
        for node in self.nodes() {
            solid += nodes[node].solid_mass;
            momentum += nodes[node].momentum[D - 1];
            force += nodes[node].force[D - 1];
        }
        let mixture = self.mass(nodes);
        if solid <= 0.0 {
            return;
        }
        for node in self.nodes() {
            let sums = &mut nodes[node];
            sums.momentum[D - 1] = momentum * (sums.solid_mass / solid);
            sums.force[D - 1] = force * (sums.mixture_mass / mixture);
        }
    }
}

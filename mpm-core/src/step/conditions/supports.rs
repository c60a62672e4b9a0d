//! Rollers and fixed sides.

use super::{Condition, Soil};
use crate::observe::Totals;
use crate::real::array_of;
use crate::scene::SolidSide;
use crate::step::Fault;
use crate::step::store::Nodes;

/// Rollers and fixed sides: velocity components of boundary nodes are zero.
#[derive(Debug, Clone)]
pub struct Supports<const D: usize> {
    nodes: [Vec<u32>; D],
    /// All nodes at a side, with the axis and the number of the side.
    edges: Vec<(u32, usize, usize)>,
    /// The supports of the scene: left, right, bottom, top.
    usual: [SolidSide; 4],
}

impl<const D: usize> Supports<D> {
    /// Holds nodes of a mesh with so many functions along each axis on its sides: left, right, bottom, top. `number` gives that of a
    /// function from its place.
    pub fn new(along: &[usize; D], sides: &[SolidSide; 4], number: impl Fn(&[usize; D]) -> usize) -> Self {
        let mut edges = Vec::new();
        for place in 0..along.iter().product() {
            let position: [usize; D] = array_of(|d| if d == 0 { place % along[0] } else { place / along[0] });
            let node = number(&position) as u32;
            for axis in 0..D {
                for upper in [false, true] {
                    let edge = if upper { along[axis] - 1 } else { 0 };
                    if position[axis] == edge {
                        edges.push((node, axis, 2 * (axis + 2 - D) + usize::from(upper)));
                    }
                }
            }
        }
        let mut held = Self { nodes: std::array::from_fn(|_| Vec::new()), edges, usual: *sides };
        held.hold_sides(None);
        held
    }

    /// The nodes fixed along an axis.
    pub fn along(&self, axis: usize) -> impl Iterator<Item = usize> {
        self.nodes[axis].iter().map(|node| *node as usize)
    }
}

impl<const D: usize> Condition<D> for Supports<D> {
    fn hold_sides(&mut self, own: Option<[SolidSide; 4]>) {
        self.nodes.iter_mut().for_each(Vec::clear);
        for &(node, axis, side) in &self.edges {
            let side = own.unwrap_or(self.usual)[side];
            for d in (0..D).filter(|d| side == SolidSide::Fixed || (side == SolidSide::Roller && *d == axis)) {
                if self.nodes[d].last() != Some(&node) {
                    self.nodes[d].push(node);
                }
            }
        }
    }

    fn each_held(&self, visit: &mut dyn FnMut(usize, usize)) {
        for d in 0..D {
            self.nodes[d].iter().for_each(|node| visit(*node as usize, d));
        }
    }

    fn hold(&self, nodes: &mut Nodes<D>) {
        for d in 0..D {
            for node in &self.nodes[d] {
                nodes.motion.velocity[d][*node as usize] = 0.0;
            }
        }
    }

    fn accelerated(
        &mut self,
        nodes: &mut Nodes<D>,
        _: &dyn Soil<D>,
        totals: &mut Totals<D>,
        _: f64,
    ) -> Result<(), Fault> {
        for d in 0..D {
            for node in self.nodes[d].iter().map(|node| *node as usize) {
                // What the particles would have received from this node.
                totals.support_impulse[d] -= nodes.mixture_mass(node) * nodes.motion.change[d][node];
                let motion = &mut nodes.motion;
                (motion.velocity[d][node], motion.change[d][node], motion.acceleration[d][node]) = (0.0, 0.0, 0.0);
            }
        }
        Ok(())
    }
}

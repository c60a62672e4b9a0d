//! Rollers and fixed sides: velocity components of boundary nodes set to zero.

use crate::grid::Grid;
use crate::nodes::{NodeMotion, NodeSums};
use crate::scene::SolidSide;

/// Nodes held in each direction.
#[derive(Debug, Clone)]
pub struct Supports<const D: usize> {
    along: [usize; D],
    held: [Vec<u32>; D],
}

impl<const D: usize> Supports<D> {
    /// The nodes on the sides of a mesh; sides in the order left, right, bottom, top.
    pub fn new(grid: &Grid<D>, sides: &[SolidSide; 4]) -> Self {
        Self::along(&grid.cells.map(|cells| cells + 1), sides)
    }

    /// The first and last of `along` coefficients in each direction, which are the values on the sides.
    pub fn along(along: &[usize; D], sides: &[SolidSide; 4]) -> Self {
        let mut held: [Vec<u32>; D] = std::array::from_fn(|_| Vec::new());
        for node in 0..along.iter().product() {
            let position = if D == 2 { vec![node % along[0], node / along[0]] } else { vec![node] };
            for axis in 0..D {
                for upper in [false, true] {
                    let edge = if upper { along[axis] - 1 } else { 0 };
                    let side = sides[2 * (axis + 2 - D) + usize::from(upper)];
                    if position[axis] != edge || side == SolidSide::Free {
                        continue;
                    }
                    for d in 0..D {
                        let holds = side == SolidSide::Fixed || d == axis;
                        if holds && held[d].last() != Some(&(node as u32)) {
                            held[d].push(node as u32);
                        }
                    }
                }
            }
        }
        Self { along: *along, held }
    }

    /// Nodes or coefficients in each direction.
    pub fn counts(&self) -> &[usize; D] {
        &self.along
    }

    /// Nodes held in a direction.
    pub fn held(&self, direction: usize) -> impl Iterator<Item = usize> {
        self.held[direction].iter().map(|node| *node as usize)
    }

    /// Takes the held components out of the inverse masses of the nodes (1/kg): no force moves them.
    pub fn hold(&self, inverse: &mut [[f64; D]]) {
        for d in 0..D {
            for &node in &self.held[d] {
                inverse[node as usize][d] = 0.0;
            }
        }
    }

    /// Stops the held components of velocities alone.
    pub fn stop(&self, motion: &mut [NodeMotion<D>]) {
        for d in 0..D {
            for &node in &self.held[d] {
                motion[node as usize].velocity[d] = 0.0;
            }
        }
    }

    /// Stops the held components. Returns the impulse of the supports on the soil in this step, N s.
    #[inline(always)]
    pub fn apply(&self, nodes: &[NodeSums<D>], motion: &mut [NodeMotion<D>]) -> [f64; D] {
        let mut impulse = [0.0; D];
        for d in 0..D {
            for &node in &self.held[d] {
                let m = &mut motion[node as usize];
                // What the particles would have received from this node.
                impulse[d] -= nodes[node as usize].mixture_mass * m.change[d];
                m.velocity[d] = 0.0;
                m.acceleration[d] = 0.0;
                m.change[d] = 0.0;
            }
        }
        impulse
    }
}

//! What acts on the nodes beside stress, load and weight: few scenes have more than supports. Each is a condition of its own, asked in
//! the order in which a run holds them, and books what it takes.

use std::fmt::Debug;

use super::Fault;
use super::store::Nodes;
use super::store::nodes::{MIXTURE_MASS, MOMENTUM, SOLID_MASS, force};
use crate::boundary::ForceField;
use crate::keep::Keeper;
use crate::observe::Totals;
use crate::particles::SolidPoint;
use crate::scene::SolidSide;

/// Something that acts on the nodes.
pub trait Condition<const D: usize>: Debug + Send {
    /// All has been gathered, and nothing has moved yet.
    fn gathered(&mut self, _: &mut Nodes<D>, _: &dyn Soil<D>) {}
    /// Holds other velocities of the nodes, as it holds their own.
    fn hold(&self, _: &mut Nodes<D>) {}
    /// Books what it did beside momenta and energies that are lost, in a step dt (s).
    fn book(&self, _: &Nodes<D>, _: &mut Totals<D>, _: f64) {}
    /// The nodes have their motion of a step dt (s), of those before this condition.
    ///
    /// # Errors
    /// Where and what went wrong.
    fn accelerated(&mut self, _: &mut Nodes<D>, _: &mut Totals<D>, _: f64) -> Result<(), Fault> {
        Ok(())
    }
    /// Writes or reads what steps to come depend on.
    fn keep(&mut self, _: &mut Keeper) {}
    /// Damping from now on, 1/s.
    fn damp_by(&mut self, _: f64) {}
}

/// Is shown a particle and its shares of functions.
pub type Visit<'a, const D: usize> = dyn FnMut(&SolidPoint<D, 4>, &[(usize, f64)]) + 'a;

/// The soil, as conditions see it.
pub trait Soil<const D: usize> {
    /// Time since the start of the run, s.
    fn time(&self) -> f64;
    /// Visits the solid particles: share of each function that it reaches in turn, by their numbers.
    fn each_share(&self, visit: &mut Visit<D>);
}

/// A given force on the soil, gathered from its particles: `f_i = sum_p m_p b(x_p, t) N_i(x_p)`.
#[derive(Clone)]
pub struct GivenForce<const D: usize> {
    field: ForceField,
    /// Force on each node, N.
    nodes: Vec<[f64; D]>,
}

impl<const D: usize> GivenForce<D> {
    /// From the acceleration it gives, m/s2, at a place (m) and time (s).
    pub fn new(field: ForceField) -> Self {
        Self { field, nodes: Vec::new() }
    }
}

impl<const D: usize> Debug for GivenForce<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GivenForce").field("nodes", &self.nodes.len()).finish_non_exhaustive()
    }
}

impl<const D: usize> Condition<D> for GivenForce<D> {
    fn gathered(&mut self, nodes: &mut Nodes<D>, soil: &dyn Soil<D>) {
        let Self { field, nodes: forces } = self;
        forces.clear();
        forces.resize(nodes.frame.count(), [0.0; D]);
        soil.each_share(&mut |point, shares| {
            let across = if D == 2 { point.x[0] } else { 0.0 };
            let b = field([across, point.x[D - 1]], soil.time());
            for (node, share) in shares {
                for d in 0..D {
                    forces[*node][d] += share * point.mass * b[d + 2 - D];
                }
            }
        });
        for (node, newton) in forces.iter().enumerate() {
            for d in 0..D {
                nodes.push(node, d, newton[d]);
            }
        }
    }

    fn book(&self, nodes: &Nodes<D>, totals: &mut Totals<D>, dt: f64) {
        for (node, newton) in self.nodes.iter().enumerate() {
            for d in 0..D {
                totals.gravity_impulse[d] += dt * newton[d];
                totals.gravity_work += dt * newton[d] * nodes.velocity_before(node, d, 0.5 * dt);
            }
        }
    }
}

/// Rollers and fixed sides: velocity components of boundary nodes are zero.
#[derive(Debug, Clone)]
pub struct Held<const D: usize> {
    nodes: [Vec<u32>; D],
}

impl<const D: usize> Held<D> {
    /// Holds nodes of a mesh with so many functions along each axis on its sides: left, right, bottom, top. `number` gives that of a
    /// function from its place.
    pub fn new(along: &[usize; D], sides: &[SolidSide; 4], number: impl Fn(&[usize; D]) -> usize) -> Self {
        let mut held: [Vec<u32>; D] = std::array::from_fn(|_| Vec::new());
        for place in 0..along.iter().product() {
            let position: [usize; D] =
                std::array::from_fn(|d| if d == 0 { place % along[0] } else { place / along[0] });
            let node = number(&position) as u32;
            for axis in 0..D {
                for upper in [false, true] {
                    let edge = if upper { along[axis] - 1 } else { 0 };
                    let side = sides[2 * (axis + 2 - D) + usize::from(upper)];
                    if position[axis] != edge || side == SolidSide::Free {
                        continue;
                    }
                    for d in 0..D {
                        let holds = side == SolidSide::Fixed || d == axis;
                        if holds && held[d].last() != Some(&node) {
                            held[d].push(node);
                        }
                    }
                }
            }
        }
        Self { nodes: held }
    }
}

impl<const D: usize> Condition<D> for Held<D> {
    fn hold(&self, nodes: &mut Nodes<D>) {
        for d in 0..D {
            for node in &self.nodes[d] {
                nodes.motion.velocity[d][*node as usize] = 0.0;
            }
        }
    }

    fn accelerated(&mut self, nodes: &mut Nodes<D>, totals: &mut Totals<D>, _: f64) -> Result<(), Fault> {
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

/// Mass-proportional damping, implicit in the velocity: v (1 + c dt) = v + a dt. After the supports: a held node has no speed to lose.
#[derive(Debug, Clone, Copy, Default)]
pub struct Damping {
    /// c, 1/s.
    rate: f64,
}

impl<const D: usize> Condition<D> for Damping {
    fn damp_by(&mut self, rate: f64) {
        self.rate = rate;
    }

    fn accelerated(&mut self, nodes: &mut Nodes<D>, totals: &mut Totals<D>, dt: f64) -> Result<(), Fault> {
        if self.rate <= 0.0 {
            return Ok(());
        }
        let keep = 1.0 / (1.0 + self.rate * dt);
        let Nodes { frame, sums, motion, .. } = nodes;
        for (number, strip) in sums.iter().enumerate() {
            for (i, mass) in strip.0[MIXTURE_MASS][..frame.strip].iter().enumerate() {
                let node = number * frame.strip + i;
                for d in 0..D {
                    let undamped = motion.velocity[d][node];
                    let velocity = keep * undamped;
                    motion.velocity[d][node] = velocity;
                    motion.acceleration[d][node] -= (undamped - velocity) / dt;
                    motion.change[d][node] -= undamped - velocity;
                    let lost = mass * (undamped - velocity);
                    totals.damping_loss += lost * velocity;
                    totals.damping_impulse[d] -= lost;
                }
            }
        }
        Ok(())
    }
}

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

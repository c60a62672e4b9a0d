//! Sums at the nodes (or functions) of the mesh, and how they move.

use super::frame::Frame;
use super::reached::Reached;

/// Most sums of a node: solid mass, mixture mass, momentum and force along each axis.
pub const SUMS: usize = 6;
/// Where the solid mass stands among them, kg.
pub const SOLID_MASS: usize = 0;
/// The mass of solid and water, kg: what the forces accelerate.
pub const MIXTURE_MASS: usize = 1;
/// The momentum of the solid along the first axis, kg m/s.
pub const MOMENTUM: usize = 2;

/// Sums of a node in D dimensions.
pub const fn sums(dimensions: usize) -> usize {
    2 + 2 * dimensions
}

/// Where the force on the mixture along the first axis stands among them, N.
pub const fn force(dimensions: usize) -> usize {
    2 + dimensions
}

/// What the cells of a strip give to the nodes from its first on, its tail beyond its end included.
#[derive(Debug, Clone)]
pub struct StripSums(pub [Vec<f64>; SUMS]);

/// Motion of the nodes, an array per component; a column leaves the second of each alone.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Velocity at the end of the step, m/s.
    pub velocity: [Vec<f64>; 2],
    /// What a particle adds to its (FLIP-weighted) velocity, m/s.
    pub change: [Vec<f64>; 2],
    /// Acceleration, m/s2.
    pub acceleration: [Vec<f64>; 2],
}

impl Motion {
    /// So many nodes at rest.
    pub fn at_rest(count: usize) -> Self {
        let rest = || [(); 2].map(|()| vec![0.0; count]);
        Self { velocity: rest(), change: rest(), acceleration: rest() }
    }
}

/// The nodes of a mesh.
#[derive(Debug, Clone)]
pub struct Nodes<const D: usize> {
    /// How they are numbered.
    pub frame: Frame<D>,
    /// Their sums, strip by strip.
    pub sums: Vec<StripSums>,
    /// Which of them the soil reaches: the others weigh nothing and rest.
    pub reached: Reached,
    /// Their motion.
    pub motion: Motion,
    /// Where in a step the work of loads is taken: 1/2 for the velocity of its middle, 1 for that of its end.
    pub work_at: f64,
    /// Followers and the node that each moves with, in this step.
    pub pairs: Vec<[u32; 2]>,
}

impl<const D: usize> Nodes<D> {
    /// Nodes at rest, without mass.
    pub fn new(frame: Frame<D>) -> Self {
        let (of_strip, all) = (frame.strip + frame.length() - frame.count(), frame.length());
        let sum = |q: usize| vec![0.0; if q < sums(D) { of_strip } else { 0 }];
        Self {
            sums: (0..frame.strips).map(|_| StripSums(std::array::from_fn(sum))).collect(),
            reached: Reached::all(&frame),
            motion: Motion::at_rest(all),
            work_at: 0.5,
            pairs: Vec::new(),
            frame,
        }
    }

    /// Gives each strip what the one below has for its nodes. Afterwards every node has all of its sums.
    pub fn merge(&mut self) {
        let (strip, tail) = (self.frame.strip, self.frame.tail());
        for k in 1..self.sums.len() {
            let (below, own) = self.sums.split_at_mut(k);
            for (from, into) in below[k - 1].0.iter().zip(&mut own[0].0).take(sums(D)) {
                for (sum, more) in into.iter_mut().zip(&from[strip..strip + tail]) {
                    *sum += more;
                }
            }
        }
    }

    /// One of the sums of a node.
    #[inline(always)]
    pub fn sum(&self, q: usize, node: usize) -> f64 {
        self.sums[node / self.frame.strip].0[q][node % self.frame.strip]
    }

    /// The same, to be changed.
    #[inline(always)]
    pub fn sum_mut(&mut self, q: usize, node: usize) -> &mut f64 {
        &mut self.sums[node / self.frame.strip].0[q][node % self.frame.strip]
    }

    /// Mass of solid and water at a node, kg.
    #[inline(always)]
    pub fn mixture_mass(&self, node: usize) -> f64 {
        self.sum(MIXTURE_MASS, node)
    }

    /// Adds a force (N) along an axis.
    #[inline(always)]
    pub fn push(&mut self, node: usize, axis: usize, newton: f64) {
        *self.sum_mut(force(D) + axis, node) += newton;
    }

    /// Velocity of a node along an axis that loads do work with in a step dt (s), m/s.
    #[inline(always)]
    pub fn working_velocity(&self, node: usize, axis: usize, dt: f64) -> f64 {
        self.motion.velocity[axis][node] - (1.0 - self.work_at) * dt * self.motion.acceleration[axis][node]
    }

    /// Visits the nodes that the soil reaches, in order, with one of their sums.
    #[inline(always)]
    pub fn each_reached(&self, q: usize, mut visit: impl FnMut(usize, f64)) {
        for (number, (strip, runs)) in self.sums.iter().zip(self.reached.runs()).enumerate() {
            let first = number * self.frame.strip;
            for run in runs {
                for (i, sum) in run.clone().zip(&strip.0[q][run.clone()]) {
                    visit(first + i, *sum);
                }
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let sums: usize = self.sums.iter().flat_map(|strip| &strip.0).map(Vec::capacity).sum();
        (sums + 6 * self.motion.velocity[0].capacity()) * size_of::<f64>() + self.reached.bytes()
    }
}

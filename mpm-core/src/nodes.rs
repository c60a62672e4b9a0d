//! What lives on the nodes of the mesh during one step.

use crate::keep::Keeper;

/// Sums gathered from the particles around a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeSums<const D: usize> {
    /// Mass of the solid layer, kg.
    pub solid_mass: f64,
    /// Mass of solid and water, kg: what the forces accelerate.
    pub mixture_mass: f64,
    /// Momentum of the solid layer, kg m/s.
    pub momentum: [f64; D],
    /// Sum of internal and external forces on the mixture, N.
    pub force: [f64; D],
}

impl<const D: usize> NodeSums<D> {
    /// Nothing gathered.
    pub const ZERO: Self = Self { solid_mass: 0.0, mixture_mass: 0.0, momentum: [0.0; D], force: [0.0; D] };
}

/// How a node of the soil moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeMotion<const D: usize> {
    /// Velocity at the end of the step, m/s.
    pub velocity: [f64; D],
    /// What a particle adds to its (FLIP-weighted) velocity, m/s.
    pub change: [f64; D],
    /// Acceleration, m/s2.
    pub acceleration: [f64; D],
}

impl<const D: usize> NodeMotion<D> {
    /// At rest.
    pub const REST: Self = Self { velocity: [0.0; D], change: [0.0; D], acceleration: [0.0; D] };

    /// Writes or reads the motion.
    pub fn keep(&mut self, keeper: &mut Keeper) {
        let Self { velocity, change, acceleration } = self;
        for part in [velocity, change, acceleration] {
            keeper.f64s(part);
        }
    }
}

//! Coulomb friction on the base: `|tau| <= adhesion + tan(angle) sigma_n`, with an angle that may fall with slip.
//!
//! The base holds its nodes up as a roller does; what that takes in a step is the normal impulse N dt. Along the base a
//! node that stood still stays so while the impulse that holds it is within the limit, as on a fixed base. A node that
//! slides is slowed by at most the limit, and stands still once that stops it: after Bardenhagen, Brackbill & Sulsky
//! (2000), doi:10.1016/S0045-7825(99)00338-2, with a rigid base for the second body.
//!
//! Friction that follows the normal stress at once feeds vibrations of an elastic body that slides on a rigid base, the
//! faster the finer the mesh (Adams 1995, doi:10.1115/1.2896013), until nodes chatter and hold far more than they should.
//! As in measured friction, the stress that counts therefore lags behind by a `memory`: Prakash & Clifton (1993);
//! Ranjith & Rice (2001), doi:10.1016/S0022-5096(00)00029-6, on why that makes the problem well posed.
//!
//! Slip and memory belong to the soil: its particles in the lowest row of cells carry them, slip with its sign, and a node has
//! the mean of theirs. Swings about a place add nothing to the slip.

use super::Joined;
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::nodes::{NodeMotion, NodeSums};
use crate::particles::{Layer, SolidPoint};
use crate::scene::{Base, NormalStress};

/// What the base did in a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Rubbed {
    /// Impulse on the soil along the base, N s.
    pub impulse: f64,
    /// Energy lost, J.
    pub loss: f64,
}

/// A base with friction.
#[derive(Debug, Clone)]
pub struct Coulomb {
    base: Base,
    /// tan of the peak and the residual angle.
    peak: f64,
    residual: f64,
    /// Shear strength without normal stress, Pa.
    adhesion: f64,
    /// Nodes that did not move along the base in the last step.
    stuck: Vec<bool>,
    /// Nodes that something else holds along the base.
    held: Vec<bool>,
    /// Slip of each particle by its number, m; empty if the base does not weaken.
    slip: Vec<f64>,
    /// Normal stress that each particle remembers, by its number, Pa; not a number before it is on the base. Empty
    /// without a memory.
    remembered: Vec<f64>,
    /// Sums of the lowest row at its nodes; empty if nothing needs them.
    shares: Vec<Shares>,
    /// Normal stress on the nodes of the base in this step, Pa.
    stress: Vec<f64>,
    wet: bool,
    /// Whether nothing slides, whatever its strength.
    glued: bool,
}

/// What a node of the base has of the soil above it.
#[derive(Debug, Clone, Copy, Default)]
struct Shares {
    /// Solid mass, kg.
    mass: f64,
    /// Mass times slip, kg m.
    slip: f64,
    /// Area of the base, m2.
    area: f64,
    /// Force of the pore water on it, N.
    water: f64,
    /// The part of the area with a memory, m2.
    known: f64,
    /// Force that is remembered on that part, N.
    remembered: f64,
}

impl Shares {
    fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.slip += other.slip;
        self.area += other.area;
        self.water += other.water;
        self.known += other.known;
        self.remembered += other.remembered;
    }
}

impl Coulomb {
    /// A base under a mesh with so many particles. `held` are the nodes of the base that cannot slide.
    pub fn new<const D: usize>(
        base: Base,
        grid: &Grid<D>,
        particles: usize,
        held: impl Iterator<Item = usize>,
        wet: bool,
    ) -> Self {
        let count = grid.cells[0] + 1;
        let mut fixed = vec![false; count];
        held.filter(|node| *node < count).for_each(|node| fixed[node] = true);
        let wet = wet && base.normal_stress == NormalStress::Effective;
        let weakens = base.slip_distance.is_some();
        let shared = weakens || wet || base.adhesion > 0.0 || base.memory > 0.0;
        Self {
            base,
            adhesion: base.adhesion,
            peak: base.peak_angle.to_radians().tan(),
            residual: base.residual_angle.to_radians().tan(),
            stuck: vec![false; count],
            held: fixed,
            slip: vec![0.0; if weakens { particles } else { 0 }],
            remembered: vec![f64::NAN; if base.memory > 0.0 { particles } else { 0 }],
            shares: vec![Shares::default(); if shared { count } else { 0 }],
            stress: vec![0.0; count],
            wet,
            glued: false,
        }
    }

    /// tan of the friction angle after a slip (m).
    fn friction(&self, slip: f64) -> f64 {
        match self.base.slip_distance {
            Some(distance) => self.peak - (self.peak - self.residual) * (slip.abs() / distance).min(1.0),
            None => self.peak,
        }
    }

    /// Gathers what the nodes of the base need of the soil above; `water` gives the pressure of the pore water of a cell on the
    /// base (Pa), and the share of its bottom that is under soil.
    pub fn gather<const D: usize, const S: usize>(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D, S>, D>,
        joined: &Joined<D>,
        water: impl Fn(usize) -> (f64, Option<f64>),
    ) {
        if self.shares.is_empty() {
            return;
        }
        self.shares.fill(Shares::default());
        for cell in 0..grid.cells[0] {
            if solid.range(cell).is_empty() {
                continue;
            }
            let (load, cover) = if self.wet { water(cell) } else { (0.0, None) };
            let volume: f64 = solid.points[solid.range(cell)].iter().map(|point| point.volume).sum();
            // A full cell has the area below it; where the bottom is known, soil of any height has its part of that.
            let per_volume = match cover {
                Some(cover) => cover * grid.size.powi(D as i32 - 1) / volume,
                None => grid.inverse_size,
            };
            for index in solid.range(cell) {
                let point = &solid.points[index];
                let right = point.x[0] * grid.inverse_size - cell as f64;
                let id = solid.ids[index] as usize;
                let slip = self.slip.get(id).copied().unwrap_or(0.0);
                let remembered = self.remembered.get(id).copied().filter(|stress| !stress.is_nan());
                let area = point.volume * per_volume;
                for (node, share) in [(cell, 1.0 - right), (cell + 1, right)] {
                    let sums = &mut self.shares[node];
                    sums.mass += share * point.mass;
                    sums.slip += share * point.mass * slip;
                    sums.area += share * area;
                    sums.water += share * area * load;
                    if let Some(stress) = remembered {
                        sums.known += share * area;
                        sums.remembered += share * area * stress;
                    }
                }
            }
        }
        let count = self.shares.len();
        for [follower, leader] in joined.pairs().filter(|pair| pair.iter().all(|node| *node < count)) {
            let from = std::mem::take(&mut self.shares[follower]);
            self.shares[leader].add(&from);
        }
    }

    /// Slows the nodes of the base over a step `dt` (s), after [`Self::gather`] and before the normal support is applied.
    pub fn rub<const D: usize>(&mut self, nodes: &[NodeSums<D>], motion: &mut [NodeMotion<D>], dt: f64) -> Rubbed {
        let mut rubbed = Rubbed::default();
        for node in 0..self.stuck.len() {
            let (mass, m) = (nodes[node].mixture_mass, &mut motion[node]);
            if mass <= 0.0 || self.held[node] {
                self.stuck[node] = false;
                continue;
            }
            let soil = self.shares.get(node).copied().unwrap_or_default();
            let slip = if soil.mass > 0.0 { soil.slip / soil.mass } else { 0.0 };
            // What the support has to take of the skeleton, now and by the memory of the soil.
            let now = -mass * m.change[D - 1] - soil.water * dt;
            let normal = if soil.known > 0.0 { soil.remembered * soil.area / soil.known * dt } else { now };
            self.stress[node] = if soil.area > 0.0 { now / (soil.area * dt) } else { 0.0 };
            let strength = self.friction(slip) * normal.max(0.0) + self.adhesion * soil.area * dt;
            let limit = if self.glued { f64::INFINITY } else { strength };
            // Soil that stands still has not slid before the first step either.
            let stood = self.stuck[node] || nodes[node].momentum[0] == 0.0;
            if stood && mass * m.change[0].abs() <= limit {
                rubbed.impulse -= mass * m.change[0];
                (m.velocity[0], m.change[0], m.acceleration[0]) = (0.0, 0.0, 0.0);
                self.stuck[node] = true;
                continue;
            }
            let stopping = -mass * m.velocity[0];
            let impulse = stopping.clamp(-limit, limit);
            let slower = impulse / mass;
            self.stuck[node] = impulse == stopping;
            m.velocity[0] = if self.stuck[node] { 0.0 } else { m.velocity[0] + slower };
            m.change[0] += slower;
            m.acceleration[0] += slower / dt;
            rubbed.impulse += impulse;
            rubbed.loss -= impulse * (m.velocity[0] - 0.5 * dt * m.acceleration[0]);
        }
        rubbed
    }

    /// Takes slip and normal stress of a step to the particles of the lowest row.
    pub fn slide<const D: usize, const S: usize>(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D, S>, D>,
        joined: &Joined<D>,
        motion: &[NodeMotion<D>],
        dt: f64,
    ) {
        if self.slip.is_empty() && self.remembered.is_empty() {
            return;
        }
        let count = self.stress.len();
        for [follower, leader] in joined.pairs().filter(|pair| pair.iter().all(|node| *node < count)) {
            self.stress[follower] = self.stress[leader];
        }
        let learns = 1.0 - (-dt / self.base.memory).exp();
        for cell in 0..grid.cells[0] {
            let [left, right] = [cell, cell + 1].map(|node| [motion[node].velocity[0], self.stress[node]]);
            for index in solid.range(cell) {
                let xi = solid.points[index].x[0] * grid.inverse_size - cell as f64;
                let [velocity, stress] = [0, 1].map(|i| left[i] + xi * (right[i] - left[i]));
                let id = solid.ids[index] as usize;
                if let Some(slip) = self.slip.get_mut(id) {
                    *slip += dt * velocity;
                }
                if let Some(old) = self.remembered.get_mut(id) {
                    *old = if old.is_nan() { stress } else { *old + learns * (stress - *old) };
                }
            }
        }
    }

    /// Nodes that did not slide in the last step.
    pub fn stuck(&self) -> impl Iterator<Item = usize> {
        self.stuck.iter().enumerate().filter(|(_, stuck)| **stuck).map(|(node, _)| node)
    }

    /// Lets nothing slide, or friction decide.
    pub fn glue(&mut self, glued: bool) {
        self.glued = glued;
    }

    /// Its strength is that of the scene divided by a factor.
    pub fn weaken(&mut self, factor: f64) {
        let tangent = |angle: f64| angle.to_radians().tan() / factor;
        (self.peak, self.residual) = (tangent(self.base.peak_angle), tangent(self.base.residual_angle));
        self.adhesion = self.base.adhesion / factor;
    }

    /// Forgets all slip.
    pub fn forget_slip(&mut self) {
        self.slip.fill(0.0);
    }

    /// Writes or reads the state.
    pub fn keep(&mut self, keeper: &mut Keeper) {
        keeper.entries(&mut self.stuck, |stuck, keeper| keeper.bool(stuck));
        keeper.all(&mut self.slip);
        keeper.all(&mut self.remembered);
        keeper.all(&mut self.stress);
        keeper.bool(&mut self.glued);
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        (self.slip.capacity() + self.remembered.capacity() + self.stress.capacity()) * size_of::<f64>()
            + self.shares.capacity() * size_of::<Shares>()
    }
}

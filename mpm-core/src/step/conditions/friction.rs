//! Friction friction on the base: `|tau| <= adhesion + tan(angle) sigma_n`, with an angle that may fall with slip.
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

use super::{Condition, Soil, Supports};
use crate::checkpoint::{Archive, RestoreError, archive};
use crate::observe::Totals;
use crate::particles::SolidPoint;
use crate::real::array_of;
use crate::scene::{Base, NormalStress};
use crate::step::Fault;
use crate::step::store::Nodes;
use crate::step::store::nodes::MOMENTUM;

/// A base with friction.
#[derive(Debug, Clone)]
pub struct Friction {
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
    /// The particles of the lowest row in this step.
    grains: Vec<Grain>,
    /// Normal stress on the nodes of the base in this step, Pa.
    stress: Vec<f64>,
    wet: bool,
    /// Whether nothing slides, whatever its strength.
    glued: bool,
    /// Whether slip no longer weakens it.
    frozen: bool,
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

/// A particle of the lowest row.
#[derive(Debug, Clone, Copy)]
struct Grain {
    /// Its cell, and its place there along the base.
    cell: usize,
    xi: f64,
    /// Its number.
    id: usize,
    /// Dry mass, kg.
    mass: f64,
    /// Volume, m3.
    volume: f64,
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

impl Friction {
    /// A base under a mesh with so many particles. `held` are the nodes of the base that cannot slide.
    pub fn new<const D: usize>(base: Base, cells: usize, particles: usize, held: &Supports<D>, wet: bool) -> Self {
        let count = cells + 1;
        let mut fixed = vec![false; count];
        held.along(0).filter(|node| *node < count).for_each(|node| fixed[node] = true);
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
            grains: Vec::with_capacity(if shared { particles } else { 0 }),
            stress: vec![0.0; count],
            wet,
            glued: false,
            frozen: false,
        }
    }

    /// tan of the friction angle after a slip (m).
    fn tangent(&self, slip: f64) -> f64 {
        match self.base.slip_distance {
            Some(distance) => self.peak - (self.peak - self.residual) * (slip.abs() / distance).min(1.0),
            None => self.peak,
        }
    }

    /// Gathers what the nodes of the base need of the soil above.
    fn gather<const D: usize>(&mut self, nodes: &Nodes<D>, soil: &dyn Soil<D>) {
        if self.shares.is_empty() {
            return;
        }
        self.shares.fill(Shares::default());
        let (cells, size) = soil.mesh();
        let Self { shares, grains, slip: slips, remembered: all_remembered, .. } = self;
        grains.clear();
        for cell in 0..cells[0] {
            let xi = |point: &SolidPoint<D>| point.x[0] / size - cell as f64;
            soil.each_in(cell, &mut |id, point| {
                grains.push(Grain { cell, xi: xi(point), id: id as usize, mass: point.mass, volume: point.volume });
            });
        }
        for grains in grains.chunk_by(|a, b| a.cell == b.cell) {
            let cell = grains[0].cell;
            let (load, cover) = if self.wet { soil.on_base(cell) } else { (0.0, None) };
            let volume = grains.iter().fold(0.0, |volume, grain| volume + grain.volume);
            // A full cell has the area below it; where the bottom is known, soil of any height has its part of that.
            let per_volume = match cover {
                Some(cover) => cover * size.powi(D as i32 - 1) / volume,
                None => 1.0 / size,
            };
            for &Grain { xi: right, id, mass, volume, .. } in grains {
                let slip = slips.get(id).copied().unwrap_or(0.0);
                let remembered = all_remembered.get(id).copied().filter(|stress| !stress.is_nan());
                let area = volume * per_volume;
                for (node, share) in [(cell, 1.0 - right), (cell + 1, right)] {
                    let sums = &mut shares[node];
                    sums.mass += share * mass;
                    sums.slip += share * mass * slip;
                    sums.area += share * area;
                    sums.water += share * area * load;
                    if let Some(stress) = remembered {
                        sums.known += share * area;
                        sums.remembered += share * area * stress;
                    }
                }
            }
        }
        for [follower, leader] in base_pairs(nodes, self.stuck.len()) {
            let from = std::mem::take(&mut self.shares[follower]);
            self.shares[leader].add(&from);
        }
    }

    /// Slows the nodes of the base over a step `dt` (s), after [`Self::gather`] and before the normal support is applied.
    fn rub<const D: usize>(&mut self, nodes: &mut Nodes<D>, totals: &mut Totals<D>, dt: f64) {
        for node in 0..self.stuck.len() {
            let mass = nodes.mixture_mass(node);
            if mass <= 0.0 || self.held[node] {
                self.stuck[node] = false;
                continue;
            }
            let at_rest = nodes.sum(MOMENTUM, node) == 0.0;
            let (velocity, change, acceleration) =
                (&mut nodes.motion.velocity, &mut nodes.motion.change, &mut nodes.motion.acceleration);
            let soil = self.shares.get(node).copied().unwrap_or_default();
            let slip = if soil.mass > 0.0 { soil.slip / soil.mass } else { 0.0 };
            // What the support has to take of the skeleton, now and by the memory of the soil.
            let now = -mass * change[D - 1][node] - soil.water * dt;
            let normal = if soil.known > 0.0 { soil.remembered * soil.area / soil.known * dt } else { now };
            self.stress[node] = if soil.area > 0.0 { now / (soil.area * dt) } else { 0.0 };
            let strength = self.tangent(slip) * normal.max(0.0) + self.adhesion * soil.area * dt;
            let limit = if self.glued { f64::INFINITY } else { strength };
            // Soil that stands still has not slid before the first step either.
            let stood = self.stuck[node] || at_rest;
            if stood && mass * change[0][node].abs() <= limit {
                totals.support_impulse[0] -= mass * change[0][node];
                (velocity[0][node], change[0][node], acceleration[0][node]) = (0.0, 0.0, 0.0);
                self.stuck[node] = true;
                continue;
            }
            let stopping = -mass * velocity[0][node];
            let impulse = stopping.clamp(-limit, limit);
            let slower = impulse / mass;
            self.stuck[node] = impulse == stopping;
            velocity[0][node] = if self.stuck[node] { 0.0 } else { velocity[0][node] + slower };
            change[0][node] += slower;
            acceleration[0][node] += slower / dt;
            totals.support_impulse[0] += impulse;
            totals.base_friction -= impulse * (velocity[0][node] - 0.5 * dt * acceleration[0][node]);
        }
    }

    /// Notes slip and stress at the particles of the lowest row.
    fn slide<const D: usize>(&mut self, nodes: &Nodes<D>, dt: f64) {
        if self.slip.is_empty() && self.remembered.is_empty() {
            return;
        }
        for [follower, leader] in base_pairs(nodes, self.stuck.len()) {
            self.stress[follower] = self.stress[leader];
        }
        let learns = 1.0 - (-dt / self.base.memory).exp();
        let Self { stress, slip: slips, remembered, frozen, grains, .. } = self;
        for &Grain { cell, xi, id, .. } in &*grains {
            let [left, right] = [cell, cell + 1].map(|node| [nodes.motion.velocity[0][node], stress[node]]);
            let [velocity, stress] = array_of::<_, 2, _>(|i| left[i] + xi * (right[i] - left[i]));
            if let Some(slip) = slips.get_mut(id).filter(|_| !*frozen) {
                *slip += dt * velocity;
            }
            if let Some(old) = remembered.get_mut(id) {
                *old = if old.is_nan() { stress } else { *old + learns * (stress - *old) };
            }
        }
    }

    /// Lets nothing slide, or friction decide.
    pub fn glue(&mut self, glued: bool) {
        self.glued = glued;
    }

    /// Leaves it as weak as its slip has made it, whatever slides from now on.
    pub fn freeze(&mut self, frozen: bool) {
        self.frozen = frozen;
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
}

/// Nodes of the base, so many of them, that follow others of it, with these.
fn base_pairs<const D: usize>(nodes: &Nodes<D>, count: usize) -> impl Iterator<Item = [usize; 2]> {
    let pairs = nodes.pairs.iter().map(|pair| pair.map(|node| node as usize));
    pairs.filter(move |pair| pair.iter().all(|node| *node < count))
}

impl<const D: usize> Condition<D> for Friction {
    /// Before the supports: it needs what they have to take.
    fn accelerated(
        &mut self,
        nodes: &mut Nodes<D>,
        soil: &dyn Soil<D>,
        totals: &mut Totals<D>,
        dt: f64,
    ) -> Result<(), Fault> {
        self.gather(nodes, soil);
        self.rub(nodes, totals, dt);
        Ok(())
    }

    fn followed(&mut self, nodes: &mut Nodes<D>, _: &dyn Soil<D>, _: &mut Totals<D>, dt: f64) {
        self.slide(nodes, dt);
    }

    fn each_held(&self, visit: &mut dyn FnMut(usize, usize)) {
        self.stuck.iter().enumerate().filter(|(_, stuck)| **stuck).for_each(|(node, _)| visit(node, 0));
    }

    fn friction(&mut self) -> Option<&mut Friction> {
        Some(self)
    }

    fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        archive!(archive.slice: self.stuck, self.stress);
        archive.slice(&mut self.slip)?;
        archive.slice(&mut self.remembered)?;
        archive.value(&mut self.glued)
    }

    fn bytes(&self) -> usize {
        (self.slip.capacity() + self.remembered.capacity() + self.stress.capacity()) * size_of::<f64>()
            + self.shares.capacity() * size_of::<Shares>()
            + self.grains.capacity() * size_of::<Grain>()
    }
}

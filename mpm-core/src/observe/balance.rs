//! Balances since the start of a run. A balance residual is what is left when all recorded parts are subtracted.

use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

use super::{CellValues, Flowed};
use crate::real::MAX_LANES;
use crate::step::store::Nodes;
use crate::step::store::nodes::{MIXTURE_MASS, MOMENTUM, SOLID_MASS};

/// Sums kept during the steps of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Totals<const D: usize> {
    /// Work of the surcharge, J.
    pub external_work: f64,
    /// Impulse of the surcharge, vertical, N s.
    pub load_impulse: f64,
    /// Impulse of rollers and fixed sides, N s.
    #[serde(with = "BigArray")]
    pub support_impulse: [f64; D],
    /// Impulse of gravity, N s.
    #[serde(with = "BigArray")]
    pub gravity_impulse: [f64; D],
    /// Impulse of damping, N s.
    #[serde(with = "BigArray")]
    pub damping_impulse: [f64; D],
    /// Impulse that nodes too light for the step did not get, N s.
    #[serde(with = "BigArray")]
    pub cut_off_impulse: [f64; D],
    /// Work of gravity on the mixture, J.
    pub gravity_work: f64,
    /// Work that what was out of balance at t = 0 beside the loads, stress and weight, does on the soil that lets go of it at once, J.
    pub released: f64,
    /// Momentum that forces have given to the nodes, N s; what water that leaves takes along is no part of it.
    #[serde(with = "BigArray")]
    pub momentum_gain: [f64; D],
    /// Kinetic energy that forces have given to the nodes, J: what is left of it is in the particles, the rest was lost when
    /// velocities went from particles to nodes.
    pub kinetic_gain: f64,
    /// Energy taken by damping, J.
    pub damping_loss: f64,
    /// Energy lost to friction in the pores, J.
    pub darcy_dissipation: f64,
    /// Energy lost to friction on the base, J.
    pub base_friction: f64,
    /// Work of rho_w (g - a_s) on the Darcy flux, J.
    pub flow_body_work: f64,
    /// Water that has left, m3.
    pub water_out: f64,
    /// Water that has entered, m3.
    pub water_in: f64,
    /// Plastic flow.
    pub flowed: Flowed,
    first: Stored<D>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Stored<const D: usize> {
    solid: f64,
    water: f64,
    kinetic: f64,
    strain: f64,
    pressure: f64,
    #[serde(with = "BigArray")]
    momentum: [f64; D],
    volume: f64,
}

impl<const D: usize> Stored<D> {
    const NONE: Self =
        Self { solid: 0.0, water: 0.0, kinetic: 0.0, strain: 0.0, pressure: 0.0, momentum: [0.0; D], volume: 0.0 };

    fn of(cells: &[CellValues<D>]) -> Self {
        let mut sum = Self::NONE;
        for cell in cells {
            let ratio = cell.mixture_ratio();
            sum.solid += cell.solid_mass;
            sum.water += cell.water_mass;
            sum.kinetic += ratio * cell.kinetic;
            sum.strain += cell.strain_energy;
            sum.pressure += cell.water_energy;
            sum.volume += cell.volume;
            for d in 0..D {
                sum.momentum[d] += ratio * cell.momentum[d];
            }
        }
        sum
    }
}

impl<const D: usize> Default for Totals<D> {
    fn default() -> Self {
        Self {
            external_work: 0.0,
            load_impulse: 0.0,
            support_impulse: [0.0; D],
            gravity_impulse: [0.0; D],
            damping_impulse: [0.0; D],
            cut_off_impulse: [0.0; D],
            gravity_work: 0.0,
            released: 0.0,
            momentum_gain: [0.0; D],
            kinetic_gain: 0.0,
            damping_loss: 0.0,
            darcy_dissipation: 0.0,
            flow_body_work: 0.0,
            base_friction: 0.0,
            water_out: 0.0,
            water_in: 0.0,
            flowed: Flowed::NOTHING,
            first: Stored::NONE,
        }
    }
}

/// The terms of the balances at one time. Vertical components where a vector is meant; energies from the start of the run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BalanceTerms {
    /// Dry mass, kg.
    pub solid_mass_kg: f64,
    /// Change of the dry mass since the start, kg.
    pub solid_residual_kg: f64,
    /// Water in the pores, kg.
    pub water_stored_kg: f64,
    /// Water that has entered, kg.
    pub water_in_kg: f64,
    /// Water that has left, kg.
    pub water_out_kg: f64,
    /// Stored - first stored - in + out, kg.
    pub water_residual_kg: f64,
    /// Vertical momentum of the mixture, N s.
    pub momentum_n_s: f64,
    /// Impulse of load, gravity, supports and damping, vertical, less what was cut off, N s.
    pub impulse_n_s: f64,
    /// Impulse that nodes too light for the step did not get, vertical, N s.
    pub cut_off_n_s: f64,
    /// Momentum given to the nodes - impulse, N s.
    pub momentum_residual_n_s: f64,
    /// Kinetic energy of the mixture, J.
    pub kinetic_j: f64,
    /// Strain energy of the skeleton, J.
    pub strain_j: f64,
    /// Energy of the compressed water, J.
    pub water_j: f64,
    /// Work of the surcharge, J.
    pub external_work_j: f64,
    /// Work of gravity on the mixture, J.
    pub gravity_work_j: f64,
    /// Work of what was out of balance at the start beside the loads, J; known in quasi-static runs.
    pub released_j: f64,
    /// Work of rho_w (g - a_s) on the Darcy flux, J.
    pub flow_body_work_j: f64,
    /// Energy lost to Darcy flow, J.
    pub darcy_dissipation_j: f64,
    /// Energy taken by damping, J.
    pub damping_loss_j: f64,
    /// Stored - first stored - work + losses, J; [`Self::transfer_loss_j`] is one of them.
    pub energy_residual_j: f64,
    /// Mass of water particles taken out because they had left the soil, kg. The water balance above is that of the
    /// flow through the faces; this says how much of the layer has followed it.
    pub water_particles_removed_kg: f64,
    /// Energy lost to friction on the base, J.
    pub base_friction_j: f64,
    /// Energy dissipated by plastic flow, J.
    pub plastic_dissipation_j: f64,
    /// How far any stress was outside the yield surface at most, as a share of the strength under no stress; nothing under
    /// an elastic law.
    pub yield_residual_max: Option<f64>,
    /// Work that fixed pore pressures have done on the soil, J.
    pub pressure_work_j: f64,
    /// Kinetic energy lost when velocities went from particles to nodes, J: what the mesh cannot represent, and what supports take.
    pub transfer_loss_j: f64,
    /// Vertical momentum that water took along when it left its soil, N s.
    pub momentum_carried_n_s: f64,
}

impl BalanceTerms {
    /// The same where water leaves with its particles.
    pub fn with_removed_as_outflow(self) -> Self {
        let removed = self.water_particles_removed_kg;
        Self { water_out_kg: removed, water_residual_kg: self.water_residual_kg + removed, ..self }
    }

    /// The same with the work (J) of pressures that are fixed.
    pub fn with_held_pressure(self, work: f64) -> Self {
        Self { pressure_work_j: work, energy_residual_j: self.energy_residual_j - work, ..self }
    }
}

impl<const D: usize> Totals<D> {
    /// Notes the state that the balances start from.
    pub fn start(&mut self, cells: &[CellValues<D>]) {
        self.first = Stored::of(cells);
    }

    /// Records what the nodes have gained in a step, in as many parts as the widest SIMD vector has lanes. A particle gets `flip dt a + (1 - flip) v`, with
    /// the velocity v of the end of the step: what supported nodes do not give is recorded too.
    pub fn book_motion(&mut self, nodes: &Nodes<D>, flip: f64, dt: f64) {
        // Sums as wide as the CPU has them: their parts are the same.
        pulp::Arch::new().dispatch(|| self.book_momentum(nodes, flip, dt));
    }

    #[inline(always)]
    fn book_momentum(&mut self, nodes: &Nodes<D>, flip: f64, dt: f64) {
        for d in 0..D {
            let (mut power, mut force) = ([0.0; MAX_LANES], [0.0; MAX_LANES]);
            each_part(nodes, d, |lane, mass, velocity, acceleration| {
                let middle = velocity - 0.5 * dt * acceleration;
                power[lane] += mass * acceleration * middle;
                force[lane] += mass * acceleration;
            });
            self.kinetic_gain += dt * power.iter().sum::<f64>();
            self.momentum_gain[d] += dt * force.iter().sum::<f64>();
            if flip < 1.0 {
                for (number, (strip, runs)) in nodes.sums.iter().zip(nodes.reached.runs()).enumerate() {
                    let sums = &strip.0;
                    let all = runs.iter().flat_map(Clone::clone);
                    for i in all.filter(|i| sums[SOLID_MASS][*i] > 0.0) {
                        let node = number * nodes.frame.strip + i;
                        let before = sums[MOMENTUM + d][i] / sums[SOLID_MASS][i];
                        let got = nodes.motion.change[d][node] - (1.0 - flip) * before;
                        self.momentum_gain[d] +=
                            sums[MIXTURE_MASS][i] * (got - dt * nodes.motion.acceleration[d][node]);
                    }
                }
            }
        }
    }

    /// Records a step under gravity (m/s2), in as many parts as the widest SIMD vector has lanes.
    pub fn book_weight(&mut self, nodes: &Nodes<D>, gravity: &[f64; D], dt: f64) {
        for d in (0..D).filter(|d| gravity[*d] != 0.0) {
            let (mut impulse, mut work) = ([0.0; MAX_LANES], [0.0; MAX_LANES]);
            let before = (1.0 - nodes.work_at) * dt;
            each_part(nodes, d, |lane, mass, velocity, acceleration| {
                let given = dt * mass * gravity[d];
                impulse[lane] += given;
                work[lane] += given * (velocity - before * acceleration);
            });
            self.gravity_impulse[d] += impulse.iter().sum::<f64>();
            self.gravity_work += work.iter().sum::<f64>();
        }
    }

    /// The balances now. `density` is that of the water, kg/m3; `removed` the mass of its lost particles, kg.
    pub fn balance_terms(&self, cells: &[CellValues<D>], density: f64, removed: f64) -> BalanceTerms {
        let (now, first, up) = (Stored::of(cells), &self.first, D - 1);
        let (water_in_kg, water_out_kg) = (density * self.water_in, density * self.water_out);
        let vectors = [self.support_impulse, self.gravity_impulse, self.damping_impulse, self.cut_off_impulse];
        let impulse_n_s = vectors.iter().fold(self.load_impulse, |sum, impulse| sum + impulse[up]);
        let stored = self.kinetic_gain + now.strain + now.pressure - first.strain - first.pressure;
        let work = self.external_work + self.gravity_work + self.flow_body_work;
        BalanceTerms {
            solid_mass_kg: now.solid,
            solid_residual_kg: now.solid - first.solid,
            water_stored_kg: now.water,
            water_in_kg,
            water_out_kg,
            water_residual_kg: now.water - first.water - water_in_kg + water_out_kg,
            momentum_n_s: now.momentum[up],
            impulse_n_s,
            cut_off_n_s: self.cut_off_impulse[up],
            momentum_residual_n_s: self.momentum_gain[up] - impulse_n_s,
            kinetic_j: now.kinetic,
            strain_j: now.strain,
            water_j: now.pressure,
            external_work_j: self.external_work,
            gravity_work_j: self.gravity_work,
            released_j: self.released,
            flow_body_work_j: self.flow_body_work,
            darcy_dissipation_j: self.darcy_dissipation,
            damping_loss_j: self.damping_loss,
            energy_residual_j: stored - work
                + self.darcy_dissipation
                + self.damping_loss
                + self.base_friction
                + self.flowed.dissipation,
            water_particles_removed_kg: removed,
            base_friction_j: self.base_friction,
            plastic_dissipation_j: self.flowed.dissipation,
            yield_residual_max: Some(self.flowed.residual).filter(|residual| *residual > f64::NEG_INFINITY),
            pressure_work_j: 0.0,
            transfer_loss_j: self.kinetic_gain + first.kinetic - now.kinetic,
            momentum_carried_n_s: self.momentum_gain[up] + first.momentum[up] - now.momentum[up],
        }
    }
}

/// Visits the nodes: part of the sum, mass of the mixture (kg), velocity (m/s) and acceleration (m/s2) along an axis.
#[inline(always)]
fn each_part<const D: usize>(nodes: &Nodes<D>, axis: usize, mut visit: impl FnMut(usize, f64, f64, f64)) {
    for (number, (strip, runs)) in nodes.sums.iter().zip(nodes.reached.runs()).enumerate() {
        for run in runs {
            let own = number * nodes.frame.strip + run.start..number * nodes.frame.strip + run.end;
            let (masses, _) = strip.0[MIXTURE_MASS][run.clone()].as_chunks::<MAX_LANES>();
            let (velocities, _) = nodes.motion.velocity[axis][own.clone()].as_chunks::<MAX_LANES>();
            let (accelerations, _) = nodes.motion.acceleration[axis][own].as_chunks::<MAX_LANES>();
            for ((mass, velocity), acceleration) in masses.iter().zip(velocities).zip(accelerations) {
                for lane in 0..MAX_LANES {
                    visit(lane, mass[lane], velocity[lane], acceleration[lane]);
                }
            }
        }
    }
}

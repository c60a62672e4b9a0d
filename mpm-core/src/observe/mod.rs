//! Results of a run: settlement, profiles, and the balances of mass, water, momentum and energy.

mod balance;
mod flowed;
mod frame;
mod trust;

pub use balance::{BalanceTerms, Totals};
pub use flowed::Flowed;
pub use frame::{CellState, Frame, SolidState, WaterParticle};
use serde::{Deserialize, Serialize};
pub use trust::{Balance, Trust, balances};

use crate::particles::{Layer, SolidPoint, WaterPoint};
use crate::real::array_of;

/// Where particles were seeded: rows of equal height from the base up, in the order of their numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Seed {
    /// Particles in a row.
    pub per_row: usize,
    /// Height of a row, m.
    pub spacing: f64,
    /// Height of each particle, m, where they do not stand in rows; else empty.
    pub heights: Vec<f64>,
}

impl Seed {
    /// Height of a solid particle at t = 0, m.
    pub fn height_of(&self, id: u32) -> f64 {
        if let Some(height) = self.heights.get(id as usize) {
            return *height;
        }
        ((id as usize / self.per_row) as f64 + 0.5) * self.spacing
    }
}

/// One row of a profile over the height.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ProfileRow {
    /// Height of the soil in this row of cells now, m.
    pub height_m: f64,
    /// Height of the same soil at t = 0, m: the coordinate of small-strain solutions.
    pub material_height_m: f64,
    /// Pore pressure, Pa.
    pub pressure_pa: f64,
    /// Vertical effective stress, Pa, tension positive.
    pub effective_stress_pa: f64,
}

/// The state at one time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// Time since the start of the run, s.
    pub time: f64,
    /// Settlement of the surface from the unloaded state, m.
    pub settlement: f64,
    /// Pore pressure averaged over the soil, Pa.
    pub mean_pressure: f64,
    /// Pore pressure in the lowest row of cells, Pa.
    pub base_pressure: f64,
    /// Largest speed of a solid particle, m/s.
    pub max_speed: f64,
    /// Centre of mass of the soil, m: x (zero in a column) and y.
    pub centre: [f64; 2],
    /// Where the soil ends, m: x beyond which lies one in 200 of its mass, and the height above which it does.
    pub reach: [f64; 2],
    /// Smallest volume of a particle of either layer, m3.
    pub least_volume: f64,
    /// Volume of all solid particles, m3: what their strains make of the soil, whatever they have moved by.
    pub soil_volume: f64,
    /// Difference of pore pressure between neighbouring cells that alternates in sign: mean |p_c - average of the
    /// face neighbours| over the soil, divided by the mean |p|; zero when dry.
    pub checkerboard: f64,
    /// Solid particles that have changed their cell so far.
    pub solid_crossings: u64,
    /// Water particles that have changed their cell so far.
    pub water_crossings: u64,
    /// Values per row of cells, from the base up.
    pub profile: Vec<ProfileRow>,
    /// Pore pressure at the middle of every cell with soil, in plane strain; in a column or a dry scene empty.
    pub field: Vec<FieldPoint>,
    /// Water with a free surface, if the scene has it.
    pub water: Option<WaterState>,
    /// What each plate that is moved does to the soil.
    pub plates: Vec<Push>,
}

/// What a plate that is moved does to the soil, per metre of thickness: x, y.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Push {
    /// What the soil has got from it since the start, N s.
    pub impulse: [f64; 2],
    /// Its force now (N), where that is known without looking at what was got before.
    pub force: Option<[f64; 2]>,
}

/// The pore pressure at a place.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct FieldPoint {
    /// Place at t = 0, m.
    pub x_m: f64,
    /// Height at t = 0, m.
    pub y_m: f64,
    /// Pore pressure, Pa.
    pub pressure_pa: f64,
    /// Share of the pores that mobile water fills.
    pub saturation: f64,
    /// Share of the cell that is soil.
    pub soil: f64,
}

/// Water with a free surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct WaterState {
    /// Mobile water in the cells, m3.
    pub mobile_m3: f64,
    /// Porosity that it can fill.
    pub mobile_porosity: f64,
    /// Water in the particles, m3.
    pub particles_m3: f64,
    /// Water that has entered, less what has left, but is in no particle yet, m3.
    pub pending_m3: f64,
    /// Most that may be pending, m3: half a particle for each cell where water has entered or left.
    pub pending_allowed_m3: f64,
    /// Water that feeds with a velocity were to bring since the start, m3.
    pub asked_m3: f64,
    /// Of the rain, what ran off soil that was full, m3.
    pub ran_off_m3: f64,
    /// Inflow in the last step, m3/s.
    pub inflow_m3_s: f64,
    /// Outflow in the last step, m3/s.
    pub outflow_m3_s: f64,
    /// Water that has entered since the start, m3.
    pub in_m3: f64,
    /// Water that has left since the start, m3.
    pub out_m3: f64,
    /// Largest x that water has reached, m.
    pub front_x_m: f64,
    /// Largest height of water, m.
    pub front_y_m: f64,
    /// Water particles.
    pub particles: u64,
    /// Of them made at feeds.
    pub spawned: u64,
    /// Taken away where water leaves.
    pub removed: u64,
    /// Root of the mean square of the surplus of particles in a cell, as a share of a full cell.
    pub packing_mean: f64,
    /// Largest surplus or lack.
    pub packing_max: f64,
    /// Steps in which some cell was left as it was.
    pub unsettled: u64,
}

/// Where the particles of both layers are in the plane, for pictures.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Places {
    /// Solid particles in the order of their numbers: x, y (m) and mean effective stress (Pa, tension positive).
    pub solid: Vec<[f64; 3]>,
    /// Water particles: x, y (m) and pore pressure (Pa).
    pub water: Vec<[f64; 3]>,
}

impl Places {
    /// Those of some particles; nothing in a column.
    pub(crate) fn of<'a, const D: usize>(
        solid: impl Iterator<Item = &'a SolidPoint<D>>,
        water: &[WaterPoint<D>],
    ) -> Self {
        if D == 1 {
            return Self::default();
        }
        let mean = |stress: &[f64; 4]| stress[..3].iter().sum::<f64>() / 3.0;
        Self {
            solid: solid.map(|p| [p.x[0], p.x[D - 1], mean(&p.stress)]).collect(),
            water: water.iter().map(|p| [p.x[0], p.x[D - 1], p.pressure]).collect(),
        }
    }
}

/// One cell of soil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellValues<const D: usize> {
    /// Row of the cell from the base up.
    pub row: usize,
    /// Middle of the cell, m: x (zero in a column) and y.
    pub middle: [f64; 2],
    /// Dry mass, kg.
    pub solid_mass: f64,
    /// Volume of soil, m3.
    pub volume: f64,
    /// Mass of pore water, kg.
    pub water_mass: f64,
    /// Pore pressure, Pa.
    pub pressure: f64,
    /// Volume average of the vertical effective stress, Pa.
    pub effective_stress: f64,
    /// Volume average of the height now, m.
    pub height: f64,
    /// Volume average of the height at t = 0, m.
    pub material_height: f64,
    /// Strain energy, J.
    pub strain_energy: f64,
    /// Energy of the compressed water, J.
    pub water_energy: f64,
    /// Kinetic energy of the solid, J.
    pub kinetic: f64,
    /// Momentum of the solid, N s.
    pub momentum: [f64; D],
}

impl<const D: usize> Default for CellValues<D> {
    fn default() -> Self {
        Self {
            row: 0,
            middle: [0.0; 2],
            solid_mass: 0.0,
            volume: 0.0,
            water_mass: 0.0,
            pressure: 0.0,
            effective_stress: 0.0,
            height: 0.0,
            material_height: 0.0,
            strain_energy: 0.0,
            water_energy: 0.0,
            kinetic: 0.0,
            momentum: [0.0; D],
        }
    }
}

impl<const D: usize> CellValues<D> {
    /// Adds a solid particle that stood at `first_height` (m) and stores `energy` (J/m3).
    pub fn add_solid(&mut self, point: &SolidPoint<D>, first_height: f64, energy: f64) {
        // Component order: xx, yy, ...; vertical, lateral in the columns of two.
        let vertical = point.stress[1];
        self.solid_mass += point.mass;
        self.volume += point.volume;
        self.effective_stress += point.volume * vertical;
        self.height += point.volume * point.x[D - 1];
        self.material_height += point.volume * first_height;
        self.strain_energy += point.volume * energy;
        for d in 0..D {
            self.kinetic += 0.5 * point.mass * point.v[d] * point.v[d];
            self.momentum[d] += point.mass * point.v[d];
        }
    }

    /// Turns volume sums into averages.
    pub fn finish(&mut self) {
        self.effective_stress /= self.volume;
        self.height /= self.volume;
        self.material_height /= self.volume;
    }

    /// Mixture mass over solid mass: in the u-p model the water moves with the solid.
    pub fn mixture_ratio(&self) -> f64 {
        1.0 + self.water_mass / self.solid_mass
    }
}

/// Reads the state of a run.
pub fn observe<const D: usize>(
    solid: &Layer<SolidPoint<D>, D>,
    water: Option<&Layer<WaterPoint<D>, D>>,
    cells: &[CellValues<D>],
    settlement: f64,
    time: f64,
) -> Observation {
    let profile = profile(cells);
    let volume: f64 = cells.iter().map(|c| c.volume).sum();
    let speed = |p: &SolidPoint<D>| p.v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let volumes = || solid.points.iter().map(|p| p.volume);
    let of_water = water.map_or(&[][..], |w| &w.points).iter().map(|p| p.volume);
    Observation {
        time,
        settlement,
        mean_pressure: cells.iter().map(|c| c.volume * c.pressure).sum::<f64>() / volume,
        base_pressure: profile.first().map_or(0.0, |row| row.pressure_pa),
        max_speed: solid.points.iter().map(speed).fold(0.0, f64::max),
        centre: centre(solid),
        reach: reach(&solid.points),
        least_volume: volumes().chain(of_water).fold(f64::INFINITY, f64::min),
        soil_volume: volumes().sum(),
        checkerboard: checkerboard(cells),
        solid_crossings: solid.crossings,
        water_crossings: water.map_or(0, |w| w.crossings),
        profile,
        field: Vec::new(),
        plates: Vec::new(),
        water: None,
    }
}

/// Centre of mass of a layer, m: x (zero in a column) and y.
fn centre<const D: usize>(solid: &Layer<SolidPoint<D>, D>) -> [f64; 2] {
    let mass: f64 = solid.points.iter().map(|p| p.mass).sum();
    let along = |d: usize| solid.points.iter().map(|p| p.mass * p.x[d]).sum::<f64>() / mass;
    [if D == 2 { along(0) } else { 0.0 }, along(D - 1)]
}

/// Share of the soil that may have flown ahead of where it ends.
const AHEAD: f64 = 0.005;

/// Where the soil ends: x (zero in a column) and y, m.
pub(crate) fn reach<const D: usize>(points: &[SolidPoint<D>]) -> [f64; 2] {
    let total: f64 = points.iter().map(|p| p.mass).sum();
    let mut list: Vec<(f64, f64)> = Vec::with_capacity(points.len());
    array_of(|axis| {
        if axis + D < 2 {
            return 0.0;
        }
        let d = axis + D - 2;
        list.clear();
        list.extend(points.iter().map(|p| (p.x[d], p.mass)));
        let farther = |a: &(f64, f64), b: &(f64, f64)| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1));
        // Only those that lie ahead need an order: about their share of the number, or more where they are light.
        let mut sorted = (points.len() as f64 * 2.0 * AHEAD) as usize;
        loop {
            let front =
                if sorted < list.len() { list.select_nth_unstable_by(sorted, farther).0 } else { &mut list[..] };
            front.sort_unstable_by(farther);
            let mut beyond = 0.0;
            let end = front.iter().find(|(_, mass)| {
                beyond += mass;
                beyond >= AHEAD * total
            });
            match end {
                Some((x, _)) => return *x,
                None if sorted >= points.len() => return 0.0,
                None => sorted = 2 * sorted + 64,
            }
        }
    })
}

/// Averages over rows of cells, weighted by volume.
pub(crate) fn profile<const D: usize>(cells: &[CellValues<D>]) -> Vec<ProfileRow> {
    let mut rows = Vec::new();
    for row in cells.chunk_by(|a, b| a.row == b.row) {
        let volume: f64 = row.iter().map(|c| c.volume).sum();
        let mean = |value: fn(&CellValues<D>) -> f64| row.iter().map(|c| c.volume * value(c)).sum::<f64>() / volume;
        rows.push(ProfileRow {
            height_m: mean(|c| c.height),
            material_height_m: mean(|c| c.material_height),
            pressure_pa: mean(|c| c.pressure),
            effective_stress_pa: mean(|c| c.effective_stress),
        });
    }
    rows
}

/// Share of the pore pressure that alternates from cell to cell, along rows of equal length.
///
/// For every 2 x 2 block of cells in a plane: |p_00 - p_10 - p_01 + p_11| / 4, averaged and divided by mean |p|.
pub(crate) fn checkerboard<const D: usize>(cells: &[CellValues<D>]) -> f64 {
    let mean: f64 = cells.iter().map(|c| c.pressure.abs()).sum::<f64>() / cells.len() as f64;
    if D == 1 || mean == 0.0 {
        return 0.0;
    }
    let rows: Vec<&[CellValues<D>]> = cells.chunk_by(|a, b| a.row == b.row).collect();
    let (mut sum, mut count) = (0.0, 0u32);
    for pair in rows.windows(2).filter(|pair| pair[0].len() == pair[1].len()) {
        for (low, high) in pair[0].windows(2).zip(pair[1].windows(2)) {
            sum += 0.25 * (low[0].pressure - low[1].pressure - high[0].pressure + high[1].pressure).abs();
            count += 1;
        }
    }
    if count == 0 { 0.0 } else { sum / f64::from(count) / mean }
}

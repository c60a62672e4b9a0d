//! Soil and water of a run, and what is read from them between steps.

use crate::boundary::{FaceLoads, Filled, SurfaceLoad};
use crate::checkpoint::{Archive, RestoreError};
use crate::constitutive::{Flow, Law, Materials, State};
use crate::grid::Grid;
use crate::observe::{BalanceTerms, CellValues, FieldPoint, Flowed, Observation, Seed, SolidState, Totals, observe};
use crate::particles::{Layer, SolidPoint};
use crate::scene::Surcharge;
use crate::water::AdvectedWater;
use crate::water::pores::{CellSoil, Pores};

/// Soil and water of a run.
#[derive(Debug, Clone)]
pub struct Body<const D: usize> {
    /// The mesh.
    pub grid: Grid<D>,
    /// Solid layer; its cells and counts alone while a step has the particles.
    pub solid: Layer<SolidPoint<D>, D>,
    /// Water in its pores, if there is any.
    pub water: Option<Pores<D>>,
    /// Materials of the skeleton.
    pub materials: Materials,
    /// Top surface.
    pub surface: SurfaceLoad<D>,
    /// How much of each cell is soil.
    pub filled: Filled<D>,
    /// Load on it.
    pub surcharge: Option<Surcharge>,
    /// Loads on other faces.
    pub loads: FaceLoads<D>,
    /// Gravity, m/s2, as a vector; `None` leaves the term out.
    pub gravity: Option<[f64; D]>,
    /// FLIP share of the velocity update.
    pub flip: f64,
    /// Soil less dense than this (dry, kg/m3) is a tension gap and carries no stress; 0 if it always does.
    pub apart: f64,
    /// Strain of the null-space filter, where it is on.
    pub null_space: Option<f64>,
    /// Whether particles are boxes that stretch.
    pub contiguous: bool,
    /// Cells that all particles together may cross in a stage without damping; `u64::MAX` for any number.
    pub most_crossings: u64,
    /// Width of a mesh that is periodic, m.
    pub period: Option<f64>,
    /// Where the particles were at t = 0.
    pub seed: Seed,
    /// Settlement at t = 0, m: that of the state the run starts from, counted from the unloaded one.
    pub first_settlement: f64,
}

impl<const D: usize> Body<D> {
    /// Saves or restores what changes during a run.
    pub(crate) fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        let Self { grid, solid, water, surface, filled, .. } = self;
        solid.save_or_restore(archive)?;
        filled.save_or_restore(archive)?;
        if let Some(water) = water {
            water.save_or_restore(archive, grid)?;
        }
        if archive.restores() {
            surface.find(solid);
        }
        Ok(())
    }

    /// The surcharge at a time (s), Pa.
    pub fn pressure_at(&self, time: f64) -> f64 {
        self.surcharge.map_or(0.0, |s| s.at(time))
    }

    /// Grains (m3) and volume (m3) of the particles of each cell with soil.
    fn cells(&self) -> impl Iterator<Item = (CellSoil, [usize; D])> {
        let of_cell = |(cell, position): (usize, [usize; D])| {
            let points = &self.solid.points[self.solid.range(cell)];
            let (mut grains, mut volume, mut first) = (0.0, 0.0, 0.0);
            for index in self.solid.range(cell) {
                let kind = self.materials.soils.kind_of(self.solid.ids[index]);
                grains += self.solid.points[index].mass * kind.grain_inverse;
                first += self.solid.points[index].mass * kind.dry_inverse;
                volume += self.solid.points[index].volume;
            }
            (!points.is_empty()).then_some((CellSoil { cell, grains, volume, first, filled: volume }, position))
        };
        self.grid.walk().filter_map(of_cell)
    }

    /// Pressure (Pa) and stored energy (J) of the water in a cell.
    fn water_in(&self, soil: &CellSoil, free: Option<&AdvectedWater<D>>) -> (f64, f64) {
        match (&self.water, free) {
            (Some(water), _) => water.cell_state(soil),
            (None, Some(free)) => (free.felt(soil.cell), 0.0),
            (None, None) => (0.0, 0.0),
        }
    }

    /// Mass of the water in a cell, kg.
    fn water_mass(&self, soil: &CellSoil, free: Option<&AdvectedWater<D>>) -> f64 {
        match (&self.water, free) {
            (Some(water), _) => water.cell_mass(soil),
            (None, Some(free)) => free.mass_in(soil.cell, soil.volume),
            (None, None) => 0.0,
        }
    }

    /// Every cell with soil: its place, soil and water, where that has a free surface from `free`.
    pub fn cell_values(&self, free: Option<&AdvectedWater<D>>) -> Vec<CellValues<D>> {
        let mut cells = Vec::new();
        for (mut soil, position) in self.cells() {
            let mut values = CellValues::default();
            for index in self.solid.range(soil.cell) {
                let (point, id) = (&self.solid.points[index], self.solid.ids[index]);
                let energy = self.materials.law(self.materials.of(id)).finite_energy(&point.stress);
                values.add_solid(point, self.seed.height_of(id), energy);
            }
            soil.filled = self.filled.counted(soil.cell, soil.volume);
            values.strain_energy *= soil.filled / soil.volume;
            (values.pressure, values.water_energy) = self.water_in(&soil, free);
            values.water_mass = self.water_mass(&soil, free);
            values.row = position[D - 1];
            let middle = |d: usize| (position[d] as f64 + 0.5) * self.grid.size;
            values.middle = [if D == 2 { middle(0) } else { 0.0 }, middle(D - 1)];
            values.finish();
            cells.push(values);
        }
        cells
    }

    /// Nothing dissipated yet, and how near the first stresses are to yield.
    pub fn flowed_at_first(&self, state: impl Fn(u32) -> State) -> Flowed {
        let mut flowed = Flowed::NOTHING;
        for (point, id) in self.solid.points.iter().zip(&self.solid.ids).filter(|_| self.materials.are_plastic()) {
            let residual = self.materials.law(self.materials.of(*id)).yield_residual(&point.stress, &state(*id));
            flowed.add(point.volume, &Flow { dissipation: 0.0, residual });
        }
        flowed
    }

    /// The state at a time (s), and the balances from the sums of the steps.
    pub fn observe(
        &self,
        time: f64,
        totals: &Totals<D>,
        free: Option<&AdvectedWater<D>>,
    ) -> (Observation, BalanceTerms) {
        let settlement = self.first_settlement + self.surface.settlement(&self.solid);
        let cells = self.cell_values(free);
        let layer = self.water.as_ref().map(|water| &water.layer);
        let mut state = observe(&self.solid, layer, &cells, settlement, time);
        if D == 2 && self.water.is_some() {
            let full = self.grid.size * self.grid.size;
            let point = |cell: &CellValues<D>| FieldPoint {
                x_m: cell.middle[0],
                y_m: cell.middle[1],
                pressure_pa: cell.pressure,
                saturation: 1.0,
                soil: cell.volume / (full * self.grid.thickness(cell.middle[0])),
            };
            state.field = cells.iter().map(point).collect();
        }
        (state, self.balance_terms(&cells, totals, free))
    }

    /// The particles of the solid layer.
    pub fn particles(&self, free: Option<&AdvectedWater<D>>) -> Vec<SolidState> {
        let two = |v: &[f64; D]| [if D == 2 { v[0] } else { 0.0 }, v[D - 1]];
        let mut states = Vec::with_capacity(self.solid.points.len());
        for (soil, _) in self.cells() {
            let wet = self.water.is_some() || free.is_some();
            let pore_pressure = if wet { self.water_in(&soil, free).0 } else { f64::NAN };
            states.extend(self.solid.range(soil.cell).map(|index| {
                let point = &self.solid.points[index];
                SolidState {
                    id: self.solid.ids[index],
                    x: two(&point.x),
                    velocity: two(&point.v),
                    stress: point.stress,
                    pore_pressure,
                    displacement: [f64::NAN; 2],
                    deviator_strain: f64::NAN,
                    volume: point.volume,
                    mass: point.mass,
                }
            }));
        }
        states
    }

    fn balance_terms(
        &self,
        cells: &[CellValues<D>],
        totals: &Totals<D>,
        free: Option<&AdvectedWater<D>>,
    ) -> BalanceTerms {
        let (density, removed) = self.water.as_ref().map_or((0.0, 0.0), |w| (w.flow.density, w.removed_mass));
        let density = free.map_or(density, AdvectedWater::density);
        let balance = totals.balance_terms(cells, density, removed);
        let balance = balance.with_held_pressure(free.map_or(0.0, |free| free.work));
        if self.water.as_ref().is_some_and(|w| w.partly_drained) { balance.with_removed_as_outflow() } else { balance }
    }
}

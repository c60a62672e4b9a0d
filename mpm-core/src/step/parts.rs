//! What a run is made of, and what is read from it between steps.

use super::Transfer;
use crate::boundary::{BodyForce, Filled, Plate, Supports, SurfaceLoad};
use crate::constitutive::{Flow, Law, Laws};
use crate::dimension::Kinematics;
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::observe::{CellValues, FieldPoint, Flowed, Ledger, Observation, Seed, SolidState, Totals, observe};
use crate::particles::{Layer, SolidPoint};
use crate::scene::Surcharge;
use crate::water::{Place, SoilCell, Water};

/// What a run is made of.
#[derive(Debug, Clone)]
pub struct Parts<L, W, const D: usize, const S: usize> {
    /// The mesh.
    pub grid: Grid<D>,
    /// Solid layer.
    pub solid: Layer<SolidPoint<D, S>, D>,
    /// Water layer, or [`crate::water::Dry`].
    pub water: W,
    /// Constitutive law of the skeleton, or those of its layers.
    pub law: L,
    /// Held sides.
    pub supports: Supports<D>,
    /// Top surface.
    pub surface: SurfaceLoad<D>,
    /// How much of each cell is soil.
    pub filled: Filled<D>,
    /// Load on it.
    pub surcharge: Option<Surcharge>,
    /// Gravity, m/s2, as a vector; `None` leaves the term out.
    pub gravity: Option<[f64; D]>,
    /// A given force on the soil; few runs have one.
    pub force: Option<Box<BodyForce<D>>>,
    /// A rigid plate on the top, which moves as one.
    pub plate: Option<Plate>,
    /// Velocities carried in a way that few scenes ask for.
    pub transfer: Option<Box<Transfer<D>>>,
    /// FLIP share of the velocity update.
    pub flip: f64,
    /// Soil less dense than this (dry, kg/m3) has come apart and carries no stress; 0 if it always does.
    pub apart: f64,
    /// Cells that all particles together may cross in a stage without damping; `u64::MAX` for any number.
    pub most_crossings: u64,
    /// Where the particles were at t = 0.
    pub seed: Seed,
    /// Settlement at t = 0, m: that of the state the run starts from, counted from the unloaded one.
    pub first_settlement: f64,
}

impl<L, W, const D: usize, const S: usize> Parts<L, W, D, S> {
    /// Writes or reads what changes during a run.
    pub fn keep<K: Kinematics<D, S>>(&mut self, keeper: &mut Keeper)
    where
        W: Water<K, D, S>,
    {
        let Self { grid, solid, water, surface, transfer, filled, .. } = self;
        solid.keep(keeper, &SolidPoint::NONE, SolidPoint::keep);
        filled.keep(keeper);
        water.keep(keeper, grid);
        if let Some(transfer) = transfer {
            transfer.keep(keeper);
        }
        if keeper.is_reading() {
            surface.find(solid);
            water.under_surface(filled);
        }
    }

    /// Finds the surface after particles have moved.
    #[inline(always)]
    pub fn follow_surface<K: Kinematics<D, S>>(&mut self)
    where
        W: Water<K, D, S>,
    {
        let Self { grid, solid, water, surface, filled, .. } = self;
        surface.follow(solid);
        if filled.is_known() {
            filled.follow_layer(grid, surface, solid);
            water.under_surface(filled);
        }
    }

    /// Every cell with soil: its place, soil and water.
    pub fn cell_values<K: Kinematics<D, S>>(&self) -> Vec<CellValues<D>>
    where
        L: Laws<S>,
        W: Water<K, D, S>,
    {
        let Parts { grid, solid, water, law, .. } = self;
        let mut cells = Vec::new();
        for (cell, position) in grid.walk() {
            let range = solid.range(cell);
            if range.is_empty() {
                continue;
            }
            let mut values = CellValues::default();
            let corners = grid.corners(&position);
            for index in range {
                let point = &solid.points[index];
                let id = solid.ids[index];
                let energy = law.law(law.mark_of(id)).finite_energy(&point.stress);
                values.add_solid(point, self.seed.height_of(id), energy);
            }
            let place = Place { cell, position, corners };
            let filled = self.filled.counted(cell, values.volume);
            values.strain_energy *= filled / values.volume;
            let soil = SoilCell { place, mass: values.solid_mass, volume: values.volume, filled, at: [0.5; D] };
            (values.pressure, values.water_energy) = water.cell_state(&soil);
            values.water_mass = water.cell_mass(&soil);
            values.row = position[D - 1];
            let middle = |d: usize| (position[d] as f64 + 0.5) * grid.size;
            values.middle = [if D == 2 { middle(0) } else { 0.0 }, middle(D - 1)];
            values.finish();
            cells.push(values);
        }
        cells
    }

    /// Nothing dissipated yet, and how near the first stresses are to yield.
    pub fn flowed_at_first(&self) -> Flowed
    where
        L: Laws<S>,
    {
        let mut flowed = Flowed::NOTHING;
        for (point, id) in self.solid.points.iter().zip(&self.solid.ids).filter(|_| L::One::PLASTIC) {
            let residual = self.law.law(self.law.mark_of(*id)).yield_residual(&point.stress);
            flowed.add(point.volume, &Flow { dissipation: 0.0, residual });
        }
        flowed
    }

    /// The state at a time (s).
    pub fn observe<K: Kinematics<D, S>>(&self, time: f64) -> Observation
    where
        L: Laws<S>,
        W: Water<K, D, S>,
    {
        let settlement = self.first_settlement + self.surface.settlement(&self.solid);
        let cells = self.cell_values::<K>();
        let mut state = observe(&self.solid, self.water.layer(), &cells, settlement, time);
        if D == 2 && W::WET {
            let full = self.grid.size * self.grid.size;
            let point = |cell: &CellValues<D>| FieldPoint {
                x_m: cell.middle[0],
                y_m: cell.middle[1],
                pressure_pa: cell.pressure,
                saturation: 1.0,
                soil: cell.volume / full,
            };
            state.field = cells.iter().map(point).collect();
        }
        state
    }

    /// The particles of the solid layer.
    pub fn particles<K: Kinematics<D, S>>(&self) -> Vec<SolidState>
    where
        W: Water<K, D, S>,
    {
        let Self { grid, solid, water, .. } = self;
        let two = |v: &[f64; D]| [if D == 2 { v[0] } else { 0.0 }, v[D - 1]];
        let mut states = Vec::with_capacity(solid.points.len());
        for (cell, position) in grid.walk() {
            let range = solid.range(cell);
            let points = &solid.points[range.clone()];
            let (mass, volume) = points.iter().fold((0.0, 0.0), |(m, v), p| (m + p.mass, v + p.volume));
            if points.is_empty() {
                continue;
            }
            let soil = SoilCell {
                place: Place { cell, position, corners: [0; 4] },
                mass,
                volume,
                filled: volume,
                at: [0.5; D],
            };
            let (pore_pressure, _) = water.cell_state(&soil);
            states.extend(range.zip(points).map(|(index, point)| SolidState {
                id: solid.ids[index],
                x: two(&point.x),
                velocity: two(&point.v),
                stress: K::in_space(&point.stress),
                pore_pressure,
                volume: point.volume,
                mass: point.mass,
                ..SolidState::default()
            }));
        }
        states
    }

    /// The balances from the sums of the steps.
    pub fn ledger<K: Kinematics<D, S>>(&self, totals: &Totals<D>) -> Ledger
    where
        L: Laws<S>,
        W: Water<K, D, S>,
    {
        let ledger = totals.ledger(&self.cell_values::<K>(), self.water.density(), self.water.removed_mass());
        let ledger = ledger.with_held_pressure(self.water.held_work());
        if self.water.leaves_as_particles() { ledger.with_removed_as_outflow() } else { ledger }
    }

    /// Pore pressure averaged over the soil, and its smallest and largest cell value, Pa.
    pub fn pore_pressure<K: Kinematics<D, S>>(&self) -> [f64; 3]
    where
        W: Water<K, D, S>,
    {
        let Parts { grid, solid, water, .. } = self;
        let (mut sum, mut volume, mut low, mut high) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
        for (cell, position) in grid.walk() {
            let range = solid.range(cell);
            if range.is_empty() {
                continue;
            }
            let (v, mass) = solid.points[range].iter().fold((0.0, 0.0), |(v, m), p| (v + p.volume, m + p.mass));
            let place = Place { cell, position, corners: [0; 4] };
            let soil = SoilCell { place, mass, volume: v, filled: v, at: [0.5; D] };
            let (pressure, _) = water.cell_state(&soil);
            sum += pressure * v;
            volume += v;
            low = low.min(pressure);
            high = high.max(pressure);
        }
        [sum / volume, low, high]
    }
}

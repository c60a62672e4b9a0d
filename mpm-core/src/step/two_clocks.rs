//! Two clocks: water that seeps for hours through soil at rest, and soil that moves within seconds under the pressures
//! this water has left.
//!
//! A stage runs by one of them. By the clock of the seepage the water takes implicit steps of its own length
//! ([`FreeSurface`]); by that of the soil the explicit step of Figure 1 runs with the pressures held.

use super::{Explicit, Fault, Model, Work};
use crate::constitutive::Law;
use crate::dimension::Kinematics;
use crate::grid::Grid;
use crate::observe::{FieldPoint, Ledger, Observation, Places, WaterState};
use crate::scene::{Clock, Feed, Stage};
use crate::shape::Shape;
use crate::water::Frozen;
use crate::water::free_surface::{FreeSurface, Kind, Medium, SoilMap, Surroundings, WaterLayer};

/// First step of a seepage stage as a share of its length.
const FIRST_STEP: f64 = 1e-4;

/// The water of a scene with two clocks.
#[derive(Debug)]
pub struct Wetting<const D: usize> {
    /// Water in the cells.
    pub water: FreeSurface<D>,
    /// Its particles.
    pub layer: WaterLayer<D>,
    /// Sides that are fed.
    pub feeds: [Option<Feed>; 4],
    /// Whether left and right are the same place.
    pub periodic: bool,
    /// Water per volume of soil that is there before any front comes, kg/m3.
    pub moisture: f64,
    /// Particles per cell along one direction.
    pub per_direction: usize,
    /// Density of the water, kg/m3.
    pub density: f64,
}

impl<const D: usize> Wetting<D> {
    /// What the soil feels of the water.
    pub fn frozen(&self) -> Frozen {
        let water = &self.water;
        let cells = water.content.len();
        let mut frozen = Frozen {
            pressure: (0..cells).map(|cell| water.mean_pressure(cell)).collect(),
            per_volume: vec![0.0; cells],
            middle: vec![0.5; cells],
            density: self.density,
            work: 0.0,
            volume: vec![0.0; cells],
        };
        for cell in 0..cells {
            if water.soil.is_soil(cell) {
                let soil = water.soil.share[cell] * water.medium.cell_volume;
                frozen.per_volume[cell] = self.density * water.content[cell] / soil + self.moisture;
                if water.kind[cell] == Kind::Standing {
                    frozen.middle[cell] = 0.5 * water.soil.share[cell] * water.wet_share(cell).clamp(0.0, 1.0);
                }
            }
        }
        frozen
    }

    fn around(&self, open: [bool; 4]) -> Surroundings {
        Surroundings { open, feeds: self.feeds, periodic: self.periodic }
    }
}

/// The model with two clocks. K: dimension, Sh: shape, L: law.
#[derive(Debug)]
pub struct TwoClocks<K, Sh, L, const D: usize, const S: usize> {
    soil: Explicit<K, Sh, L, Frozen, D, S>,
    wetting: Wetting<D>,
    clock: Clock,
    /// Whether the soil has moved since the water last looked at it.
    moved: bool,
    /// Length of the next seepage step, s.
    next: f64,
    work: Work,
}

impl<K, Sh, L, const D: usize, const S: usize> TwoClocks<K, Sh, L, D, S>
where
    K: Kinematics<D, S>,
    Sh: Shape,
    L: Law<S>,
{
    /// A run at t = 0.
    pub fn new(soil: Explicit<K, Sh, L, Frozen, D, S>, wetting: Wetting<D>) -> Self {
        Self { soil, wetting, clock: Clock::Seepage, moved: false, next: 0.0, work: Work::default() }
    }

    /// Takes the soil as it stands now. Water that it has left behind or squeezed out is booked as outflow.
    fn look_at_soil(&mut self, around: &Surroundings) -> Result<(), Fault> {
        let parts = self.soil.parts();
        let old = &self.wetting.water;
        let Medium { cell_volume, size, .. } = old.medium;
        let map = SoilMap::new(&parts.grid, &parts.solid, cell_volume / size, self.wetting.per_direction);
        let mut content = old.content.clone();
        let mut lost = 0.0;
        for (cell, content) in content.iter_mut().enumerate() {
            let pores = if map.is_soil(cell) { old.medium.porosity * map.share[cell] * cell_volume } else { 0.0 };
            lost += (*content - pores).max(0.0);
            *content = content.min(pores);
        }
        let (inflow, outflow, unsettled) = (old.inflow, old.outflow + lost, old.unsettled);
        let mut water = FreeSurface::new(&parts.grid, old.medium, map, around).map_err(|e| everywhere(&e))?;
        water.fill(&content);
        (water.inflow, water.outflow, water.unsettled) = (inflow, outflow, unsettled);
        self.wetting.water = water;
        self.soil.book_flow([0.0, lost], 0.0);
        Ok(())
    }

    fn seep(&mut self, span: f64, done: &mut u64) -> Result<(), Fault> {
        let (mut time, mut count) = (0.0, 0);
        let Wetting { water, layer, periodic, .. } = &mut self.wetting;
        let (first_in, first_out) = (water.inflow, water.outflow);
        let mut outcome = Ok(());
        while time < span {
            let left = span - time;
            // No sliver of a step before the end.
            let asked = if self.next > 0.75 * left { left } else { self.next };
            match water.step(asked) {
                Ok((step, next)) => {
                    // A step that was only cut to end at a time says nothing of the next.
                    self.next = if step < asked || asked >= self.next { next } else { self.next.max(next) };
                    layer.follow(&self.soil.parts().grid, water, step, *periodic);
                    time = if step >= left { span } else { time + step };
                    count += 1;
                }
                Err(e) => {
                    outcome = Err(everywhere(&e));
                    break;
                }
            }
        }
        let flowed = [water.inflow - first_in, water.outflow - first_out];
        self.work.accepted += count;
        *done += count;
        self.soil.book_flow(flowed, time);
        self.hold();
        outcome
    }

    /// Hands the water as it is to the soil.
    fn hold(&mut self) {
        let held = &mut self.soil.parts().water;
        *held = Frozen { work: held.work, ..self.wetting.frozen() };
    }

    fn water_state(&self, grid: &Grid<D>) -> WaterState {
        let Wetting { water, layer, .. } = &self.wetting;
        let mut front = [0.0; 2];
        for (cell, position) in grid.walk() {
            let wet = water.wet_share(cell).clamp(0.0, 1.0);
            if wet > 1e-6 {
                for d in 0..D {
                    let share = if water.kind[cell] == Kind::Full { 1.0 } else { wet };
                    front[d + 2 - D] = f64::max(front[d + 2 - D], (position[d] as f64 + share) * grid.size);
                }
            }
        }
        WaterState {
            mobile_m3: water.stored(),
            mobile_porosity: water.medium.porosity,
            particles_m3: layer.stored(),
            pending_m3: layer.pending(),
            inflow_m3_s: water.rates[0],
            outflow_m3_s: water.rates[1],
            in_m3: water.inflow,
            out_m3: water.outflow,
            front_x_m: front[0],
            front_y_m: front[1],
            particles: layer.points.len() as u64,
            spawned: layer.spawned,
            removed: layer.removed,
            packing_mean: layer.mean_packing(water),
            packing_max: layer.packing(water),
            unsettled: water.unsettled,
        }
    }
}

fn everywhere(what: &impl ToString) -> Fault {
    Fault { place: "the whole soil".to_owned(), what: what.to_string() }
}

impl<K, Sh, L, const D: usize, const S: usize> Model for TwoClocks<K, Sh, L, D, S>
where
    K: Kinematics<D, S>,
    Sh: Shape,
    L: Law<S>,
{
    fn advance(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault> {
        match self.clock {
            Clock::Seepage => self.seep(dt * steps as f64, done),
            Clock::Soil => {
                self.moved = true;
                self.soil.advance(dt, steps, done)
            }
        }
    }

    fn enter_stage(&mut self, stage: &Stage, times: &[f64]) -> Result<(), Fault> {
        self.clock = stage.clock;
        let around = self.wetting.around(stage.drained);
        if self.clock == Clock::Soil {
            self.hold();
            return self.soil.enter_stage(stage, times);
        }
        self.next = FIRST_STEP * times.first().copied().unwrap_or(1.0);
        if std::mem::take(&mut self.moved) {
            self.look_at_soil(&around)
        } else {
            let grid = &self.soil.parts().grid;
            self.wetting.water.surround(grid, &around);
            Ok(())
        }
    }

    fn time(&self) -> f64 {
        self.soil.time()
    }

    fn work(&self) -> Work {
        self.work
    }

    fn observe(&self) -> Observation {
        let mut state = self.soil.observe();
        let grid = self.soil.grid();
        let water = &self.wetting.water;
        state.field = grid
            .walk()
            .filter(|(cell, _)| water.soil.is_soil(*cell))
            .map(|(cell, position)| {
                let middle = position.map(|i| (i as f64 + 0.5) * grid.size);
                FieldPoint {
                    x_m: if D == 2 { middle[0] } else { 0.0 },
                    y_m: middle[D - 1],
                    pressure_pa: water.mean_pressure(cell),
                    saturation: water.wet_share(cell),
                    soil: water.soil.share[cell],
                }
            })
            .collect();
        state.water = Some(self.water_state(grid));
        state
    }

    fn ledger(&self) -> Ledger {
        self.soil.ledger()
    }

    fn pore_pressure(&self) -> [f64; 3] {
        self.soil.pore_pressure()
    }

    fn grid_speed(&self) -> f64 {
        self.soil.grid_speed()
    }

    fn bytes(&self) -> usize {
        self.soil.bytes() + self.wetting.water.bytes()
    }

    fn solid_count(&self) -> usize {
        self.soil.solid_count()
    }

    fn places(&self) -> Places {
        Places::of(self.soil.solid_points(), &self.wetting.layer.points)
    }
}

//! Staggered (multirate) coupling: water that seeps for hours through soil at rest, and soil that moves within seconds
//! under the pressures this water has left.
//!
//! A stage moves one of them. In seepage the water takes implicit steps of its own length
//! ([`FreeSurface`]); while the soil moves, the explicit step of Figure 1 runs under fixed pressures.

use super::explicit::Explicit;
use super::store::nodes::force;
use super::{Failing, Fault, Model, Pace, Work};
use crate::checkpoint::{Archive, RestoreError, archive};
use crate::constitutive::{Altered, Law, Material, Materials};
use crate::dimension::in_two;
use crate::grid::Grid;
use crate::observe::{
    BalanceTerms, CellState, FieldPoint, Frame, Observation, Places, SolidState, WaterParticle, WaterState,
};
use crate::order::sort_by_number;
use crate::real::array_of;
use crate::scene::{Coupling, Stage};
use crate::water::AdvectedWater;
use crate::water::free_surface::Kind;

/// First step of a seepage stage as a share of its length.
const FIRST_STEP: f64 = 1e-4;
/// Wet share from which on the last cell of a slope is wet.
const TOE_WET: f64 = 0.25;
/// Motion slower than this is none to speak of, in sqrt(g times the height of the mesh).
const STILL: f64 = 2e-3;
/// Cells times moves of particles between two requests to the monitor: some tenths of a second.
const CELL_MOVES_AT_ONCE: usize = 1 << 18;
/// More moves of particles at one state of the soil are not worth waiting for.
const MOST_MOVES: u64 = 1 << 20;
/// Soil that has moved less than this takes no water along, in cells.
const NEAR: f64 = 1e-3;

/// The staggered model.
pub struct Staggered<const D: usize> {
    soil: Explicit<D>,
    /// The materials of the scene.
    materials: Materials,
    coupling: Coupling,
    /// Length of the next seepage step, s.
    next: f64,
    /// What is left of the time that the water was to seep, s: it was asked for at once, and is done in parts.
    left: f64,
    /// Mobile water at t = 0, m3.
    first: f64,
    work: Work,
}

impl<const D: usize> Staggered<D> {
    /// A run at t = 0, of soil without water and that.
    pub fn new(soil: Explicit<D>, water: AdvectedWater<D>) -> Self {
        let (materials, first) = (soil.body().materials.clone(), water.stored());
        let soil = soil.with_free_water(water);
        Self { materials, soil, coupling: Coupling::Seepage, next: 0.0, left: 0.0, first, work: Work::default() }
    }

    fn water(&self) -> &AdvectedWater<D> {
        self.soil.advected().expect("given at the start")
    }

    fn water_mut(&mut self) -> &mut AdvectedWater<D> {
        self.soil.advected_mut().expect("given at the start")
    }

    /// Takes the water along to where the soil stands now.
    fn look_at_soil(&mut self) {
        if self.water().way(&self.soil.body().grid) > NEAR {
            self.soil.carry_water();
        }
        self.book();
    }

    /// Records the water that has flowed while the soil moved.
    fn book(&mut self) {
        let water = &self.water().water;
        let flowed = [water.inflow, water.outflow];
        let totals = self.soil.totals();
        [totals.water_in, totals.water_out] = flowed;
    }

    /// Whether the water particles are those of the water in the cells.
    fn balanced(&self) -> Result<(), Fault> {
        let what = self.water().unbalanced();
        what.map_or(Ok(()), |what| Err(Fault { place: "the water".to_owned(), what }))
    }

    /// Seeps for a time (s), at most until the particles have been moved so many times; what is left of the time then waits.
    fn seep_for(&mut self, span: f64, most: u64, done: &mut u64) -> Result<(), Fault> {
        let mut time = 0.0;
        let mut moves = 0;
        let (grid, start, mut next) = (self.soil.body().grid, self.soil.time(), self.next);
        let carried = self.water_mut();
        let (mut outcome, mut steps) = (Ok(()), 0);
        while time < span && moves < most {
            let left = span - time;
            // No sliver of a step before the end.
            let even = carried.even_for(start + time);
            let asked = if next > 0.75 * left { left } else { next }.min(even);
            carried.look_outside(&grid, start + time + 0.5 * asked);
            let AdvectedWater { water, layer, around, .. } = &mut *carried;
            match water.step(asked) {
                Ok((step, longer)) => {
                    // A step that was only cut to end at a time says nothing of the next.
                    next = if step < asked || asked >= next { longer } else { next.max(longer) };
                    moves += layer.follow(&grid, water, step, around.periodic);
                    time = if step >= left { span } else { time + step };
                    steps += 1;
                }
                Err(e) => {
                    outcome = Err(everywhere(&e));
                    break;
                }
            }
        }
        carried.returns(time);
        carried.show();
        (self.left, self.next) = (span - time, next);
        self.work.accepted += steps;
        *done += steps;
        self.soil.pass_time(time);
        self.book();
        outcome.and_then(|()| self.balanced())
    }

    fn water_state(&self, grid: &Grid<D>) -> WaterState {
        let AdvectedWater { water, layer, .. } = self.water();
        let rounding = layer.rounding();
        let mut front = [0.0; 2];
        for (cell, position) in grid.walk() {
            let wet = water.behind_front(cell);
            if wet > 1e-6 {
                for d in 0..D {
                    let share = if water.kind[cell] == Kind::Full { 1.0 } else { wet };
                    front[d + 2 - D] = f64::max(front[d + 2 - D], (position[d] as f64 + share) * grid.size);
                }
            }
        }
        WaterState {
            mobile_m3: self.water().stored(),
            mobile_porosity: water.medium.porosity,
            particles_m3: layer.stored(),
            pending_m3: layer.pending(),
            pending_allowed_m3: rounding.pending,
            asked_m3: water.asked,
            ran_off_m3: water.ran_off,
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

/// Deviator strain sqrt(2/3 e:e) of a strain xx, yy, zz, xy (tensor components).
fn deviator(strain: &[f64; 4]) -> f64 {
    let mean = strain[..3].iter().sum::<f64>() / 3.0;
    let sum: f64 = strain[..3].iter().map(|strain| (strain - mean).powi(2)).sum();
    (2.0 / 3.0 * (sum + 2.0 * strain[3] * strain[3])).sqrt()
}

fn everywhere(what: &impl ToString) -> Fault {
    Fault { place: "the whole soil".to_owned(), what: what.to_string() }
}

impl<const D: usize> Model for Staggered<D> {
    fn advance(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault> {
        match self.coupling {
            Coupling::Seepage => {
                let at_once = (CELL_MOVES_AT_ONCE / self.soil.body().grid.cell_count()).clamp(16, 4096);
                self.seep_for(dt * steps as f64, at_once as u64, done)
            }
            Coupling::Soil | Coupling::Full => self.soil.advance(dt, steps, done).and_then(|()| self.balanced()),
        }
    }

    fn enter_stage(&mut self, stage: &Stage, times: &[f64]) -> Result<(), Fault> {
        self.coupling = stage.coupling;
        if self.coupling == Coupling::Soil {
            self.water_mut().show();
            return self.soil.enter_stage(stage, times);
        }
        self.next = FIRST_STEP * times.first().copied().unwrap_or(1.0);
        self.look_at_soil();
        let grid = self.soil.body().grid;
        self.water_mut().open(&grid, stage.drained);
        Ok(())
    }

    fn particles(&self) -> Vec<SolidState> {
        self.soil.particles()
    }

    fn failing(self: Box<Self>) -> Option<Box<dyn Failing>> {
        Some(self)
    }

    fn left(&self) -> f64 {
        if self.coupling == Coupling::Seepage { self.left } else { 0.0 }
    }

    fn time(&self) -> f64 {
        self.soil.time()
    }

    fn work(&self) -> Work {
        self.work
    }

    /// Water is counted in the cells that carry it: the particles of soil clipped by an outline may lie in the next one.
    fn observe(&self) -> (Observation, BalanceTerms) {
        let (mut state, mut balance) = self.soil.observe();
        let grid = self.soil.body().grid;
        let water = &self.water().water;
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
        state.water = Some(self.water_state(&grid));
        let free = self.water();
        let moved = free.stored() - self.first - free.water.inflow + free.water.outflow;
        balance.water_residual_kg = free.density() * moved;
        (state, balance)
    }

    fn pore_pressure(&self) -> [f64; 3] {
        self.soil.pore_pressure()
    }

    fn grid_speed(&self) -> f64 {
        self.soil.grid_speed()
    }

    fn bytes(&self) -> usize {
        self.soil.bytes()
    }

    fn solid_count(&self) -> usize {
        self.soil.solid_count()
    }

    fn places(&self) -> Places {
        self.soil.places()
    }

    fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        let mut tracked = self.soil.is_tracked();
        archive.value(&mut tracked)?;
        if tracked && !self.soil.is_tracked() {
            self.soil.begin_track();
        }
        self.soil.save_or_restore(archive)?;
        archive.choice(&mut self.coupling, &[Coupling::Seepage, Coupling::Soil, Coupling::Full])?;
        archive!(archive.value: self.next, self.left, self.first, self.work);
        Ok(())
    }
}

impl<const D: usize> Failing for Staggered<D> {
    fn move_soil(&mut self, pace: &Pace, done: &mut u64) -> Result<(), Fault> {
        self.soil.damp_by(pace.damping);
        if self.water().pressures != pace.pressures {
            let water = self.water_mut();
            water.pressures = pace.pressures;
            water.show();
        }
        let outcome = self.soil.advance(pace.dt, pace.steps, done);
        self.book();
        outcome.and_then(|()| self.balanced())
    }

    fn seep(&mut self, span: f64, done: &mut u64) -> Result<(), Fault> {
        if self.next == 0.0 {
            self.next = FIRST_STEP * span;
        }
        self.look_at_soil();
        self.seep_for(span, MOST_MOVES, done)?;
        if self.left > 0.0 {
            let what = format!(
                "the water has not advanced by {span:.3e} s in {MOST_MOVES} moves of its particles: {:.3e} s are left",
                self.left
            );
            return Err(everywhere(&what));
        }
        Ok(())
    }

    fn feel(&mut self, share: f64) {
        self.water_mut().feel(share);
    }

    fn glue(&mut self, glued: bool) {
        if let Some(base) = self.soil.friction() {
            base.glue(glued);
        }
    }

    fn stop(&mut self) {
        self.soil.stop();
    }

    fn count_from_here(&mut self) {
        self.soil.begin_track();
        self.water_mut().work = 0.0;
        self.soil.begin_balances();
        self.book();
    }

    fn forget_slip(&mut self) {
        if let Some(base) = self.soil.friction() {
            base.forget_slip();
        }
    }

    fn freeze_slip(&mut self, frozen: bool) {
        if let Some(base) = self.soil.friction() {
            base.freeze(frozen);
        }
    }

    fn alter(&mut self, by: &Altered) {
        // The materials of the scene to their last bit: a run that is resumed has no others.
        let altered = |material: &Material| material.altered(by);
        let unaltered = *by == Altered::NOTHING;
        self.soil.change_materials(if unaltered { self.materials.clone() } else { self.materials.map(altered) });
        if let Some(base) = self.soil.friction() {
            base.weaken(by.factor);
        }
    }

    /// Accelerations are those of the last step, forces those gathered for the next: the same where soil comes to rest.
    fn unbalanced(&self) -> f64 {
        let (nodes, gravity) = (self.soil.nodes(), self.soil.body().gravity.unwrap_or([0.0; D]));
        let (mut left, mut whole) = (0.0, 0.0);
        for node in 0..nodes.frame.count() {
            let mass = nodes.mixture_mass(node);
            let size = |of: [f64; D]| of.iter().map(|x| x * x).sum::<f64>().sqrt();
            left += mass * size(array_of(|d| nodes.motion.acceleration[d][node]));
            whole += size(array_of(|d| nodes.sum(force(D) + d, node) + mass * gravity[d]));
        }
        if whole > 0.0 { left / whole } else { 0.0 }
    }

    fn each(&self, visit: &mut dyn FnMut(&SolidState)) {
        let (grid, water) = (&self.soil.body().grid, self.water());
        self.soil.each_particle(|id, point, from, strain| {
            visit(&SolidState {
                id,
                x: in_two(&point.x),
                displacement: in_two(&array_of::<f64, D, _>(|d| point.x[d] - from[d])),
                velocity: in_two(&point.v),
                stress: point.stress,
                pore_pressure: grid.cell_at(&point.x).map_or(0.0, |cell| water.felt(cell)),
                deviator_strain: deviator(&strain),
                volume: point.volume,
                mass: point.mass,
            });
        });
    }

    fn frame(&self, time_s: f64, step: u64) -> Frame {
        let (grid, water) = (&self.soil.body().grid, self.water());
        let mut solid = Vec::with_capacity(self.soil.solid_count());
        self.each(&mut |state| solid.push(*state));
        sort_by_number(&mut solid, |state| state.id.into());
        Frame {
            time_s,
            step,
            cells: [if D == 2 { grid.cells[0] } else { 1 }, grid.cells[D - 1]],
            size: grid.size,
            solid,
            water: water
                .layer
                .points
                .iter()
                .map(|p| WaterParticle {
                    x: in_two(&p.x),
                    velocity: in_two(&p.v),
                    pressure: p.pressure,
                    volume: p.volume,
                })
                .collect(),
            cell: (0..grid.cell_count())
                .map(|cell| CellState {
                    soil: water.water.soil.share[cell],
                    saturation: water.water.wet_share(cell).clamp(0.0, 1.0),
                    pressure: water.felt(cell),
                })
                .collect(),
        }
    }

    fn level(&self, x: f64) -> f64 {
        self.water().water.level(&self.soil.body().grid, x)
    }

    fn front(&self, towards: f64) -> f64 {
        let (grid, water) = (&self.soil.body().grid, &self.water().water);
        let right = towards > 0.0;
        let last_soil = (0..grid.cells[0]).rfind(|cell| water.soil.is_soil(*cell)).map_or(0, |cell| cell + 1);
        // Before any has come: the side opposite to the toe.
        let mut front: f64 = if right { 0.0 } else { last_soil as f64 * grid.size };
        for cell in 0..grid.cells[0] {
            let wet = water.behind_front(cell);
            if wet > 1e-6 {
                // The soil of a toe ends before its cell does.
                let soil = water.soil.cover[1][cell][1].max(water.soil.share[cell]);
                // The last cell lets out what would fill it: it is wet when a part of it is.
                let next =
                    if right { Some(cell + 1).filter(|cell| *cell < grid.cells[0]) } else { cell.checked_sub(1) };
                let last = next.is_none_or(|next| !water.soil.is_soil(next));
                let reached = soil * if last && wet >= TOE_WET { 1.0 } else { wet };
                front = if right {
                    front.max((cell as f64 + reached) * grid.size)
                } else {
                    front.min(((cell + 1) as f64 - reached) * grid.size)
                };
            }
        }
        front
    }

    fn unevenness(&self) -> [f64; 2] {
        let (grid, water) = (&self.soil.body().grid, &self.water().water);
        let full = |cell: usize| water.kind[cell] == Kind::Full;
        let (mut uneven, mut blocks, mut mean, mut cells) = (0.0, 0u32, 0.0, 0u32);
        let across = grid.cells[0];
        for (cell, position) in grid.walk().filter(|(cell, _)| full(*cell)) {
            mean += water.pressure[cell].abs();
            cells += 1;
            if position[0] + 1 < across && position[1] + 1 < grid.cells[1] {
                let block = [cell, cell + 1, cell + across, cell + across + 1];
                if block.iter().all(|cell| full(*cell)) {
                    let [a, b, c, d] = block.map(|cell| water.pressure[cell]);
                    uneven += 0.25 * (a - b - c + d).abs();
                    blocks += 1;
                }
            }
        }
        let checkerboard =
            if blocks > 0 && mean > 0.0 { uneven / f64::from(blocks) / (mean / f64::from(cells)) } else { 0.0 };
        let velocity = &self.soil.nodes().motion.velocity;
        let gravity = self.soil.body().gravity.map_or(0.0, |g| g.iter().map(|g| g * g).sum::<f64>().sqrt());
        let still = STILL * STILL * gravity * grid.cells[1] as f64 * grid.size;
        let (mut hourglass, mut whole) = (0.0, 0.0);
        for (cell, position) in grid.walk() {
            let soil = water.soil.share[cell];
            if soil > 0.0 {
                let corners = grid.corners_from(grid.first_corner(cell, &position));
                for velocity in velocity {
                    let [a, b, c, e] = corners.map(|node| velocity[node]);
                    hourglass += soil * (0.25 * (a - b - c + e)).powi(2);
                    whole += soil * 0.25 * (a * a + b * b + c * c + e * e);
                }
                whole += soil * still;
            }
        }
        [checkerboard, if whole > 0.0 { hourglass / whole } else { 0.0 }]
    }
}

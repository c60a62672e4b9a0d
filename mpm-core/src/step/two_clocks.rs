//! Two clocks: water that seeps for hours through soil at rest, and soil that moves within seconds under the pressures
//! this water has left.
//!
//! A stage runs by one of them. By the clock of the seepage the water takes implicit steps of its own length
//! ([`FreeSurface`]); by that of the soil the explicit step of Figure 1 runs with the pressures held.

use super::{Explicit, Failing, Fault, Model, Pace, Work};
use crate::constitutive::Law;
use crate::dimension::Kinematics;
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::observe::{
    CellState, FieldPoint, Frame, Ledger, Observation, Places, SolidState, WaterParticle, WaterState,
};
use crate::scene::{Clock, Stage};
use crate::shape::Shape;
use crate::step::track::Track;
use crate::water::Carried;
use crate::water::Water;
use crate::water::free_surface::Kind;

/// First step of a seepage stage as a share of its length.
const FIRST_STEP: f64 = 1e-4;
/// Wet share from which on the last cell of a slope is wet.
const TOE_WET: f64 = 0.25;
/// Motion slower than this is none to speak of, in sqrt(g times the height of the mesh).
const STILL: f64 = 2e-3;
/// Cells times moves of particles between two looks at whether the run is to be kept or stopped: some tenths of a second.
const CELL_MOVES_AT_ONCE: usize = 1 << 18;
/// More moves of particles at one state of the soil are not worth waiting for.
const MOST_MOVES: u64 = 1 << 20;
/// Soil that has moved less than this takes no water along, in cells.
const NEAR: f64 = 1e-3;

/// The model with two clocks. K: dimension, Sh: shape, L: law.
#[derive(Debug)]
pub struct TwoClocks<K, Sh, L, const D: usize, const S: usize> {
    soil: Explicit<K, Sh, L, Carried<D>, D, S>,
    /// The law of the scene.
    law: L,
    clock: Clock,
    /// Length of the next seepage step, s.
    next: f64,
    /// What is left of the time that the water was to seep, s: it was asked for at once, and is done in parts.
    left: f64,
    /// Mobile water at t = 0, m3.
    first: f64,
    work: Work,
}

impl<K, Sh, L, const D: usize, const S: usize> TwoClocks<K, Sh, L, D, S>
where
    K: Kinematics<D, S>,
    Sh: Shape,
    L: Law<S>,
{
    /// A run at t = 0.
    pub fn new(mut soil: Explicit<K, Sh, L, Carried<D>, D, S>) -> Self {
        let (law, first) = (soil.parts().law, soil.water().stored());
        Self { law, soil, clock: Clock::Seepage, next: 0.0, left: 0.0, first, work: Work::default() }
    }

    /// Takes the water along to where the soil stands now.
    fn look_at_soil(&mut self) {
        let parts = self.soil.parts();
        if parts.water.way(&parts.grid) > NEAR {
            parts.water.carry(&parts.grid, &parts.solid);
        }
        self.book();
    }

    /// Books what has flowed by the clock of the soil.
    fn book(&mut self) {
        let water = &self.soil.parts().water.water;
        let flowed = [water.inflow, water.outflow];
        let totals = self.soil.totals();
        [totals.water_in, totals.water_out] = flowed;
    }

    /// Whether the water particles are those of the water in the cells.
    fn balanced(&self) -> Result<(), Fault> {
        let what = self.soil.water().unbalanced();
        what.map_or(Ok(()), |what| Err(Fault { place: "the water".to_owned(), what }))
    }

    /// Seeps for a time (s), at most until the particles have been moved so many times; what is left of the time then waits.
    fn seep_for(&mut self, span: f64, most: u64, done: &mut u64) -> Result<(), Fault> {
        let mut time = 0.0;
        let mut moves = 0;
        let parts = self.soil.parts();
        let Carried { water, layer, around, .. } = &mut parts.water;
        let mut outcome = Ok(());
        while time < span && moves < most {
            let left = span - time;
            // No sliver of a step before the end.
            let asked = if self.next > 0.75 * left { left } else { self.next };
            match water.step(asked) {
                Ok((step, next)) => {
                    // A step that was only cut to end at a time says nothing of the next.
                    self.next = if step < asked || asked >= self.next { next } else { self.next.max(next) };
                    moves += layer.follow(&parts.grid, water, step, around.periodic);
                    time = if step >= left { span } else { time + step };
                    self.work.accepted += 1;
                    *done += 1;
                }
                Err(e) => {
                    outcome = Err(everywhere(&e));
                    break;
                }
            }
        }
        self.left = span - time;
        parts.water.returns(time);
        parts.water.show();
        self.soil.pass(time);
        self.book();
        outcome.and_then(|()| self.balanced())
    }

    fn water_state(&self, grid: &Grid<D>) -> WaterState {
        let Carried { water, layer, .. } = self.soil.water();
        let rounding = layer.rounding();
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
            mobile_m3: self.soil.water().stored(),
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
            Clock::Seepage => {
                let at_once = (CELL_MOVES_AT_ONCE / self.soil.grid().cell_count()).clamp(16, 4096);
                self.seep_for(dt * steps as f64, at_once as u64, done)
            }
            Clock::Soil | Clock::Both => self.soil.advance(dt, steps, done).and_then(|()| self.balanced()),
        }
    }

    fn enter_stage(&mut self, stage: &Stage, times: &[f64]) -> Result<(), Fault> {
        self.clock = stage.clock;
        if self.clock == Clock::Soil {
            self.soil.parts().water.show();
            return self.soil.enter_stage(stage, times);
        }
        self.next = FIRST_STEP * times.first().copied().unwrap_or(1.0);
        self.look_at_soil();
        let parts = self.soil.parts();
        parts.water.open(&parts.grid, stage.drained);
        Ok(())
    }

    fn left(&self) -> f64 {
        if self.clock == Clock::Seepage { self.left } else { 0.0 }
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
        let water = &self.soil.water().water;
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

    /// Water is counted in the cells that carry it: the particles of soil clipped by an outline may lie in the next one.
    fn ledger(&self) -> Ledger {
        let (water, ledger) = (self.soil.water(), self.soil.ledger());
        let moved = water.stored() - self.first - water.water.inflow + water.water.outflow;
        Ledger { water_closing_kg: Water::<K, D, S>::density(water) * moved, ..ledger }
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
        Places::of(self.soil.solid_points(), &self.soil.water().layer.points)
    }

    fn keep(&mut self, keeper: &mut Keeper) {
        let mut tracked = self.soil.track.is_some();
        keeper.bool(&mut tracked);
        if tracked && self.soil.track.is_none() {
            let solid = &self.soil.parts().solid;
            self.soil.track = Some(Box::new(Track::new(solid)));
        }
        if !tracked {
            self.soil.track = None;
        }
        self.soil.keep(keeper);
        let mut clock = self.clock as u32;
        keeper.u32(&mut clock);
        self.clock = [Clock::Seepage, Clock::Soil, Clock::Both][clock.min(2) as usize];
        keeper.f64(&mut self.next);
        keeper.f64(&mut self.left);
        keeper.f64(&mut self.first);
        self.work.keep(keeper);
    }
}

impl<K, Sh, L, const S: usize> Failing for TwoClocks<K, Sh, L, 2, S>
where
    K: Kinematics<2, S>,
    Sh: Shape,
    L: Law<S>,
{
    fn move_soil(&mut self, pace: &Pace, done: &mut u64) -> Result<(), Fault> {
        self.soil.damp_by(pace.damping);
        let parts = self.soil.parts();
        if parts.water.pressures != pace.pressures {
            parts.water.pressures = pace.pressures;
            parts.water.show();
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
                "the water has not come through {span:.3e} s in {MOST_MOVES} moves of its particles: {:.3e} s are left",
                self.left
            );
            return Err(everywhere(&what));
        }
        Ok(())
    }

    fn feel(&mut self, share: f64) {
        self.soil.parts().water.feel(share);
    }

    fn glue(&mut self, glued: bool) {
        if let Some(base) = self.soil.base() {
            base.glue(glued);
        }
    }

    fn stop(&mut self) {
        self.soil.stop();
    }

    fn count_from_here(&mut self) {
        let solid = &self.soil.parts().solid;
        self.soil.track = Some(Box::new(Track::new(solid)));
        self.soil.parts().water.work = 0.0;
        self.soil.begin_ledgers();
        self.book();
    }

    fn forget_slip(&mut self) {
        if let Some(base) = self.soil.base() {
            base.forget_slip();
        }
    }

    fn alter(&mut self, factor: f64, stiffness: f64) {
        let parts = self.soil.parts();
        // The law of the scene to its last bit: a run that is resumed has no other.
        let unaltered = factor == 1.0 && stiffness == 1.0;
        parts.law = if unaltered { self.law } else { self.law.altered(factor, stiffness) };
        if let Some(base) = self.soil.base() {
            base.weaken(factor);
        }
    }

    fn unbalanced(&self) -> f64 {
        let (nodes, motion) = self.soil.nodes();
        let (mut left, mut whole) = (0.0, 0.0);
        for (node, m) in nodes.iter().zip(motion) {
            let force = |a: [f64; 2]| (a[0] * a[0] + a[1] * a[1]).sqrt();
            left += node.mixture_mass * force(m.acceleration);
            whole += force(node.force);
        }
        if whole > 0.0 { left / whole } else { 0.0 }
    }

    fn each(&self, visit: &mut dyn FnMut(&SolidState)) {
        let (points, ids) = self.soil.solid_and_ids();
        let (grid, water) = (self.soil.grid(), self.soil.water());
        for (point, id) in points.iter().zip(ids) {
            let track = self.soil.track.as_deref();
            let from = track.map_or(point.x, |track| track.origin[*id as usize]);
            let mut stress = [0.0; 4];
            stress[..S.min(4)].copy_from_slice(&point.stress[..S.min(4)]);
            visit(&SolidState {
                id: *id,
                x: point.x,
                displacement: [point.x[0] - from[0], point.x[1] - from[1]],
                velocity: point.v,
                stress,
                pore_pressure: grid.cell_at(&point.x).map_or(0.0, |cell| water.felt(cell)),
                deviator_strain: track.map_or(0.0, |track| track.deviator(*id)),
                volume: point.volume,
                mass: point.mass,
            });
        }
    }

    fn frame(&self, time_s: f64, step: u64) -> Frame {
        let (grid, water) = (self.soil.grid(), self.soil.water());
        let mut solid = Vec::with_capacity(self.soil.solid_count());
        self.each(&mut |state| solid.push(*state));
        solid.sort_by_key(|state| state.id);
        Frame {
            time_s,
            step,
            cells: grid.cells,
            size: grid.size,
            solid,
            water: water
                .layer
                .points
                .iter()
                .map(|p| WaterParticle { x: p.x, velocity: p.v, pressure: p.pressure, volume: p.volume })
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
        self.soil.water().water.level(self.soil.grid(), x)
    }

    fn front(&self, towards: f64) -> f64 {
        let (grid, water) = (self.soil.grid(), &self.soil.water().water);
        let right = towards > 0.0;
        let last_soil = (0..grid.cells[0]).rfind(|cell| water.soil.is_soil(*cell)).map_or(0, |cell| cell + 1);
        // Before any has come: the side that the toe looks away from.
        let mut front: f64 = if right { 0.0 } else { last_soil as f64 * grid.size };
        for cell in 0..grid.cells[0] {
            let wet = water.wet_share(cell).clamp(0.0, 1.0);
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
        let (grid, water) = (self.soil.grid(), &self.soil.water().water);
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
        let (_, motion) = self.soil.nodes();
        let gravity = self.soil.gravity().map_or(0.0, |[x, y]| x.hypot(y));
        let still = STILL * STILL * gravity * grid.cells[1] as f64 * grid.size;
        let (mut hourglass, mut whole) = (0.0, 0.0);
        for (cell, position) in grid.walk() {
            let soil = water.soil.share[cell];
            if soil > 0.0 {
                let corners = grid.corners_from(grid.first_corner(cell, &position)).map(|node| motion[node].velocity);
                for d in 0..2 {
                    let [a, b, c, e] = corners.map(|v| v[d]);
                    hourglass += soil * (0.25 * (a - b - c + e)).powi(2);
                    whole += soil * 0.25 * (a * a + b * b + c * c + e * e);
                }
                whole += soil * still;
            }
        }
        [checkerboard, if whole > 0.0 { hourglass / whole } else { 0.0 }]
    }
}

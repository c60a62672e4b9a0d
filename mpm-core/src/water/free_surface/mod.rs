//! Water that wets dry soil and leaves it again: sharp fronts, a free surface, seepage faces, and feeds.
//!
//! The soil rests. Every cell has a content of water (m3), which changes by what flows through its faces and by nothing else, so that the
//! balance residual is round-off; `flow` finds the flow of a step, `edges` what meets the outside, `layer` lets the water
//! particles follow; `unsaturated` takes the place of the sharp front where a soil has a retention. A soil that is moist from the start has a part S_0 of its pores filled with water that stays: a front
//! has only n (1 - S_0) to fill.

mod advect;
mod edges;
mod flow;
mod layer;
mod moving;
mod soil;
mod unsaturated;

pub use advect::{Square, squares};
pub use edges::{Along, Edge, Outside, Rained};
pub use flow::{Kind, Link, Medium};
pub use layer::{Rounding, WaterLayer};
pub use moving::{Filling, MovingStep, Pressed, Squeeze};
pub use soil::{LEAST_OPEN, LEAST_SHARE, SoilMap};

use crate::checkpoint::{Archive, RestoreError, archive};
use crate::grid::Grid;
use crate::scene::{Course, FaceLoad, Feed};
use crate::soils::Soils;
use crate::sparse::Unsolved;
use crate::water::retention::Retention;
use flow::{Linear, Now, System, Terms};
use unsaturated::Unsaturated;

/// Largest change of the wet share of a cell that a step aims at, and the largest it may have.
const CHANGE: [f64; 2] = [0.1, 0.5];
/// Rounds after which the kinds of cells that still change are left as they are: what they hold too much or too little of the next step makes good.
const ROUNDS: usize = 40;
/// How often a cell may change its kind in one step.
const FLIPS: u8 = 6;
/// A cell with less of its pores wet than this does not cover the one below.
const FILM: f64 = 0.02;
/// What a front may fill a cell too much, of its pores: a tenth of the change that a step aims at. Cells that stay as good as full
/// would else cut every step to where they are.
const SPILL: f64 = 0.1 * CHANGE[0];
/// Round-off of a wet share.
const ROUND: f64 = 1e-10;

/// Water in a soil at rest.
#[derive(Debug)]
pub struct FreeSurface<const D: usize> {
    /// Constants.
    pub medium: Medium<D>,
    /// The soil.
    pub soil: SoilMap<D>,
    /// Which particle is of which soil.
    pub soils: Soils,
    /// Cells of soil, in order.
    pub cells: Vec<u32>,
    /// Mobile water in each cell, m3.
    pub content: Vec<f64>,
    /// Kind of each cell.
    pub kind: Vec<Kind>,
    /// Pressure at the centre of each cell, Pa; zero where there is no full water. That of a standing cell follows from its level
    /// and may be negative.
    pub pressure: Vec<f64>,
    /// Flow through each face along its axis in the last step, m3/s.
    pub flux: [Vec<f64>; D],
    /// Water that has entered, m3.
    pub inflow: f64,
    /// Water that has left, m3.
    pub outflow: f64,
    /// Water that feeds with a velocity were to bring, m3, and what of the rain ran off soil that was full.
    pub asked: f64,
    /// See [`Self::asked`].
    pub ran_off: f64,
    /// Inflow and outflow in the last step, m3/s.
    pub rates: [f64; 2],
    /// Steps of which some cells had to be left as they were.
    pub unsettled: u64,
    full: Vec<bool>,
    /// Which cells were full before the step that is tried.
    before: Vec<bool>,
    links: Vec<Link>,
    edges: Vec<Edge>,
    flows: Vec<Linear>,
    leaks: Vec<Linear>,
    /// What left through each edge in the last step, m3/s.
    left: Vec<f64>,
    /// What feeds with a velocity meet beyond what the map shows, per side and cell along it, in cells.
    beyond: Along,
    /// Faces that rain falls on.
    rained: Vec<Rained>,
    system: System,
    /// Room for a step of unsaturated soil.
    room: Option<Box<Unsaturated>>,
    /// Whether the systems are not those of the links.
    stale: bool,
    above: Vec<Neighbour>,
    below: Vec<Neighbour>,
    trial: Vec<f64>,
    wet: Vec<f64>,
    flips: Vec<u8>,
}

/// What lies above or below a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Neighbour {
    /// A cell of soil.
    Cell(u32),
    /// Water at rest.
    Pond,
    /// An impermeable side.
    Tight,
    /// Air.
    Air,
}

/// What surrounds the soil.
#[derive(Debug, Clone, PartialEq)]
pub struct Surroundings {
    /// Sides of the mesh that let water out: left, right, bottom, top.
    pub open: [bool; 4],
    /// Sides that are fed.
    pub feeds: [Option<Feed>; 4],
    /// Heads (m) that differ along the bottom and the top: by their place in m.
    pub heads: [Course; 4],
    /// Whether left and right are the same place.
    pub periodic: bool,
    /// Water at rest before faces of the soil.
    pub standing: Vec<Standing>,
}

/// No heads that differ along their side.
#[cfg(test)]
const NO_HEADS: [Course; 4] = [const { Course::Constant }; 4];

/// Water at rest before faces of the soil.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// Which faces.
    pub load: FaceLoad,
    /// Its level above the base now, m.
    pub level: f64,
    /// Sides of the mesh that are fixed: no water stands there unless it is said so.
    pub held: [bool; 4],
}

impl Standing {
    /// Whether it stands before a face towards a side of the mesh, or lies on it, with its middle at a place, m.
    pub fn is_before(&self, side: usize, on_mesh: bool, place: &[f64; 2]) -> bool {
        let FaceLoad { on, x, y, .. } = &self.load;
        let within = |range: &Option<[f64; 2]>, at: f64| range.is_none_or(|[low, high]| (low..=high).contains(&at));
        let looks = on.map_or(!(on_mesh && self.held[side]), |on| on as usize == side);
        looks && within(x, place[0]) && within(y, place[1])
    }
}

/// Why a step could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoFlow {
    /// A system could not be solved.
    #[error(transparent)]
    Unsolved(#[from] Unsolved),
    /// A step cannot be made shorter.
    #[error("a step of {0:.1e} s still changes the water of a cell too much")]
    TooShort(f64),
}

impl<const D: usize> FreeSurface<D> {
    /// Dry soil.
    ///
    /// # Errors
    /// Out of memory.
    pub fn new(
        grid: &Grid<D>,
        medium: Medium<D>,
        (soil, soils): (SoilMap<D>, Soils),
        around: &Surroundings,
    ) -> Result<Self, Unsolved> {
        let cells = grid.cell_count();
        let mut water = Self {
            medium,
            cells: Vec::with_capacity(cells),
            content: vec![0.0; cells],
            kind: vec![Kind::Void; cells],
            pressure: vec![0.0; cells],
            flux: std::array::from_fn(|axis| vec![0.0; grid.face_count(axis)]),
            inflow: 0.0,
            outflow: 0.0,
            asked: 0.0,
            ran_off: 0.0,
            rates: [0.0; 2],
            unsettled: 0,
            full: vec![false; cells],
            before: vec![false; cells],
            flows: Vec::new(),
            links: Vec::new(),
            edges: Vec::new(),
            leaks: Vec::new(),
            left: Vec::new(),
            beyond: Along::default(),
            rained: Vec::new(),
            system: System::new(cells, &[])?,
            room: None,
            stale: true,
            above: Vec::new(),
            below: Vec::new(),
            trial: vec![0.0; cells],
            wet: vec![0.0; cells],
            flips: vec![0; cells],
            soil,
            soils,
        };
        water.build(grid, around);
        Ok(water)
    }

    /// Finds the faces of the soil as it is in the map now.
    pub fn build(&mut self, grid: &Grid<D>, around: &Surroundings) {
        self.cells.clear();
        for cell in 0..self.kind.len() {
            if self.soil.is_soil(cell) {
                self.cells.push(cell as u32);
            } else {
                (self.kind[cell], self.pressure[cell], self.wet[cell]) = (Kind::Void, 0.0, 0.0);
                self.system.pressure[cell] = 0.0;
            }
        }
        self.links = links(grid, &self.soil, self.soils.largest_conductivity(), around.periodic);
        self.flows.clear();
        self.flows.resize(self.links.len(), Linear::default());
        self.stale = true;
        self.surround(grid, around);
    }

    /// Says what feeds with a velocity meet exactly, per side and cell along it, in cells: the map of the soil is of boxes.
    pub fn feed_exactly(&mut self, grid: &Grid<D>, around: &Surroundings, exact: Along) {
        self.beyond = Along::default();
        self.surround(grid, around);
        for side in 0..4 {
            if let (Some(Feed::Velocity { .. }), false) = (around.feeds[side], exact[side].is_empty()) {
                let mut found = vec![0.0; exact[side].len()];
                for edge in &self.edges {
                    if let (Outside::Inflow(_), true) = (edge.outside, edge.side(D) == side) {
                        found[edges::along_side(grid, edge)] += edge.open;
                    }
                }
                self.beyond[side] = edges::beyond(&found, &exact[side]);
            }
        }
        self.surround(grid, around);
    }

    /// Changes what surrounds the soil.
    pub fn surround(&mut self, grid: &Grid<D>, around: &Surroundings) {
        let face_area = self.medium.cell_volume / self.medium.size;
        let soil = (&self.soil, self.soils.largest_conductivity());
        (self.edges, self.rained) = edges::edges(grid, soil, &self.medium, around, face_area, &self.beyond);
        self.leaks.clear();
        self.leaks.resize(self.edges.len(), Linear::default());
        self.left.clear();
        self.left.resize(self.edges.len(), 0.0);
        if self.medium.retention.is_some() {
            // Moving soil needs it too, before any step of the water alone.
            let room = self.room.get_or_insert_with(|| Box::new(Unsaturated::new(self.content.len())));
            room.surround(&self.edges, &self.rained);
        }
        let cells = grid.cell_count();
        let mut beyond = vec![[Neighbour::Tight; 2]; cells];
        for edge in self.edges.iter().filter(|edge| edge.axis as usize == D - 1) {
            let side = &mut beyond[edge.cell as usize][usize::from(edge.upper)];
            let air = match edge.outside {
                Outside::Air => true,
                // Rain falls through air.
                Outside::Inflow(_) => edge.upper,
                Outside::Pond(_) => false,
            };
            if !air || *side == Neighbour::Tight {
                *side = if air { Neighbour::Air } else { Neighbour::Pond };
            }
        }
        let stride: usize = grid.cells[..D - 1].iter().product();
        for (cell, position) in grid.walk().filter(|(cell, _)| self.soil.is_soil(*cell)) {
            for upper in [false, true] {
                let at_side = if upper { position[D - 1] + 1 == grid.cells[D - 1] } else { position[D - 1] == 0 };
                let next = if upper { cell + stride } else { cell.wrapping_sub(stride) };
                if !at_side && self.soil.is_soil(next) {
                    beyond[cell][usize::from(upper)] = Neighbour::Cell(next as u32);
                }
            }
        }
        self.below.clear();
        self.below.extend(beyond.iter().map(|pair| pair[0]));
        self.above.clear();
        self.above.extend(beyond.iter().map(|pair| pair[1]));
    }

    /// Pores of a cell that mobile water can fill, m3.
    #[inline]
    pub fn pores(&self, cell: usize) -> f64 {
        self.soil.pores[cell]
    }

    /// Share of the mobile pores of a cell that is wet.
    #[inline]
    pub fn wet_share(&self, cell: usize) -> f64 {
        if self.soil.is_soil(cell) { self.content[cell] / self.pores(cell) } else { 0.0 }
    }

    /// Share of a cell that lies behind the front of the water, 0 to 1: of soil that holds water by suction what is full.
    pub fn behind_front(&self, cell: usize) -> f64 {
        match self.medium.retention {
            Some(_) => f64::from(u8::from(self.full[cell])),
            None => self.wet_share(cell).clamp(0.0, 1.0),
        }
    }

    /// Mean over the soil of a cell of the pressure where it is positive, Pa: what the soil feels. Of unsaturated soil S_e p.
    pub fn mean_pressure(&self, cell: usize) -> f64 {
        let (rise, share) = (self.medium.rise() * self.medium.size, self.soil.share[cell]);
        if let Some(law) = &self.medium.retention {
            return if share < LEAST_SHARE { 0.0 } else { self.medium.bishop(law, self.pressure[cell], share) };
        }
        match self.kind[cell] {
            Kind::Full | Kind::Standing if rise > 0.0 => {
                self.medium.wet_integral(self.pressure[cell] + 0.5 * rise, share) / share
            }
            Kind::Full => self.pressure[cell],
            _ => 0.0,
        }
    }

    /// Height at which the positive pressure of a cell acts, as a share of half the height of its soil.
    pub fn lower(&self, cell: usize) -> f64 {
        let (rise, share) = (self.medium.rise() * self.medium.size, self.soil.share[cell]);
        let bottom = self.pressure[cell] + 0.5 * rise;
        let plain = self.medium.retention.is_some() || rise == 0.0;
        if !self.kind[cell].unknown() || plain || bottom <= 0.0 || share <= 0.0 {
            return 1.0;
        }
        // First moment of a triangle, or of a trapezium, by its area.
        let height = if bottom <= rise * share {
            bottom / rise / 3.0
        } else {
            share * (bottom / 2.0 - rise * share / 3.0) / (bottom - rise * share / 2.0)
        };
        2.0 * height / share
    }

    /// Mobile water in all cells, m3.
    pub fn stored(&self) -> f64 {
        self.content.iter().sum()
    }

    /// Whether the cell above or below is full, or water at rest.
    fn is_full(&self, neighbour: Neighbour, full: &[bool]) -> bool {
        match neighbour {
            Neighbour::Cell(cell) => full[cell as usize],
            Neighbour::Pond => true,
            Neighbour::Tight | Neighbour::Air => false,
        }
    }

    /// Whether the level of a cell, if it is full, is at its own upper edge or above: water stands on something and nothing presses from above.
    fn stands(&self, cell: usize, full: &[bool]) -> bool {
        let on_tight = self.below[cell] == Neighbour::Tight;
        self.medium.rise() > 0.0
            && (on_tight || self.is_full(self.below[cell], full))
            && !self.is_full(self.above[cell], full)
    }

    fn classify(&mut self) {
        for i in 0..self.cells.len() {
            let cell = self.cells[i] as usize;
            self.kind[cell] = if self.full[cell] {
                Kind::Full
            } else if self.medium.retention.is_some() {
                Kind::Loose
            } else if self.stands(cell, &self.full) {
                Kind::Standing
            } else if self.medium.rise() > 0.0 && self.is_full(self.above[cell], &self.full) {
                Kind::Hanging
            } else {
                Kind::Loose
            };
        }
    }

    /// Gives cells the pressures (Pa) of unsaturated soil, and the water that goes with them.
    pub fn soak(&mut self, law: &Retention, pressure: &[f64]) {
        for cell in (0..pressure.len()).filter(|cell| self.soil.is_soil(*cell)) {
            let moist = self.medium.moist(law, pressure[cell], self.soil.share[cell]);
            (self.pressure[cell], self.content[cell]) = (pressure[cell], self.soil.pores[cell] * moist.wet);
        }
        self.note_full();
    }

    /// Fills cells (m3 of mobile water, no more than their pores) and takes the state as that of water at rest.
    pub fn fill(&mut self, content: &[f64]) {
        for cell in 0..content.len() {
            self.content[cell] = content[cell];
            self.full[cell] = self.soil.is_soil(cell) && content[cell] >= (1.0 - ROUND) * self.pores(cell);
        }
        self.classify();
        let rise = self.medium.rise() * self.medium.size;
        let ponds = self.under_ponds();
        // From the top down: each full cell carries the water above it.
        for cell in (0..self.kind.len()).rev() {
            self.pressure[cell] = match (self.kind[cell], self.above[cell]) {
                (Kind::Standing, _) => self.medium.standing_pressure(self.wet_share(cell), self.soil.share[cell]),
                (Kind::Full, Neighbour::Cell(above)) if self.kind[above as usize].unknown() => {
                    self.pressure[above as usize] + rise
                }
                (Kind::Full, _) => self.medium.standing_pressure(1.0, self.soil.share[cell]).max(ponds[cell]),
                _ => 0.0,
            };
        }
    }

    /// Pressure in the middle of each cell of the water at rest outside it, Pa; minus infinity where there is none.
    fn under_ponds(&self) -> Vec<f64> {
        let mut ponds = vec![f64::NEG_INFINITY; self.kind.len()];
        let half = 0.5 * self.medium.rise() * self.medium.size;
        for edge in &self.edges {
            if let Outside::Pond(pressure) = edge.outside {
                let above_middle = if edge.axis as usize == D - 1 && edge.upper { -1.0 } else { 1.0 };
                let in_middle = pressure - above_middle * half;
                ponds[edge.cell as usize] = ponds[edge.cell as usize].max(in_middle);
            }
        }
        ponds
    }

    /// Tries a step of `dt` (s): the largest change of a wet share, and the share of the step after which a front fills the
    /// first cell, 1 if none does. Nothing is kept but the trial.
    fn attempt(&mut self, dt: f64) -> Result<(f64, f64), Unsolved> {
        self.before.copy_from_slice(&self.full);
        let mut fills: f64 = 1.0;
        self.flips.fill(0);
        for cell in 0..self.wet.len() {
            self.wet[cell] = self.wet_share(cell).clamp(0.0, 1.0);
        }
        self.system.pressure.copy_from_slice(&self.pressure);
        for round in 0..ROUNDS {
            self.classify();
            for cell in 0..self.kind.len() {
                if !self.kind[cell].unknown() {
                    self.system.pressure[cell] = 0.0;
                }
            }
            self.assemble(dt);
            let Self { medium, links, flows, edges, leaks, kind, content, soil, system, .. } = self;
            system.solve(&Terms { medium, links, flows, edges, leaks, kind, soil, content, dt })?;
            self.contents(dt);
            if round == 0 {
                fills = self.first_filled();
            }
            let settled = self.compare(round) && !self.sucks();
            let mut moved: f64 = 0.0;
            for cell in 0..self.wet.len() {
                if self.soil.is_soil(cell) {
                    // The middle of the step.
                    let middle = 0.5 * (self.content[cell] + self.trial[cell].max(0.0)) / self.pores(cell);
                    moved = moved.max((middle.min(1.0) - self.wet[cell]).abs());
                    self.wet[cell] = middle.clamp(0.0, 1.0);
                }
            }
            if settled && (moved < 1e-6 || round > 12) {
                break;
            }
            self.unsettled += u64::from(round + 1 == ROUNDS);
        }
        let mut change: f64 = 0.0;
        for cell in 0..self.content.len() {
            if self.soil.is_soil(cell) {
                change = change.max((self.trial[cell] - self.content[cell]).abs() / self.pores(cell));
            }
        }
        Ok((change, fills))
    }

    /// Share of the trial step after which the first of the cells that a front fills is full.
    fn first_filled(&self) -> f64 {
        let mut share: f64 = 1.0;
        for cell in 0..self.kind.len() {
            if matches!(self.kind[cell], Kind::Hanging | Kind::Loose) {
                let (pores, start, end) = (self.pores(cell), self.content[cell], self.trial[cell]);
                if end > (1.0 + SPILL) * pores && start < pores {
                    share = share.min((pores - start) / (end - start));
                }
            }
        }
        share
    }

    fn assemble(&mut self, dt: f64) {
        if let (Some(law), Some(room)) = (self.medium.retention, &mut self.room) {
            let p = &self.system.pressure;
            for cell in (0..p.len()).filter(|cell| self.soil.is_soil(*cell)) {
                room.moist[cell] = self.medium.moist(&law, p[cell], self.soil.share[cell]);
            }
            for (flow, link) in self.flows.iter_mut().zip(&self.links) {
                let (a, b) = (link.low as usize, link.high as usize);
                let unknown = [self.kind[a].unknown(), self.kind[b].unknown()];
                *flow = self.medium.linear(&law, link, [p[a], p[b]], [&room.moist[a], &room.moist[b]], unknown);
            }
            for (i, (leak, edge)) in self.leaks.iter_mut().zip(&self.edges).enumerate() {
                let cell = edge.cell as usize;
                *leak = room.leak(&self.medium, &law, (i, edge), p[cell], self.kind[cell].unknown());
            }
            return;
        }
        let now = Now { kind: &self.kind, pressure: &self.system.pressure, wet: &self.wet };
        for (flow, link) in self.flows.iter_mut().zip(&self.links) {
            *flow = self.medium.through(link, now);
        }
        for i in 0..self.edges.len() {
            let edge = &self.edges[i];
            let cell = edge.cell as usize;
            let stands = self.stands(cell, &self.full);
            let start = self.wet_share(cell).clamp(0.0, 1.0);
            self.leaks[i] = self.medium.leak(edge, now, &self.soil, stands, start, dt);
        }
    }

    /// Contents at the end of the trial step, m3.
    fn contents(&mut self, dt: f64) {
        self.trial.copy_from_slice(&self.content);
        let p = &self.system.pressure;
        for (link, flow) in self.links.iter().zip(&self.flows) {
            let (a, b) = (link.low as usize, link.high as usize);
            let volume = dt * flow.at(p[a], p[b]);
            self.trial[a] -= volume;
            self.trial[b] += volume;
        }
        for (edge, leak) in self.edges.iter().zip(&self.leaks) {
            let cell = edge.cell as usize;
            self.trial[cell] -= dt * edge.lets_out(leak.at(p[cell], 0.0));
        }
    }

    /// Whether the pressures of the trial would draw water in from the air, which none lets in.
    fn sucks(&self) -> bool {
        let least = ROUND * self.medium.conductance * self.medium.unit_weight * self.medium.size;
        let mut leaks = self.edges.iter().zip(&self.leaks).filter(|(edge, _)| edge.outside == Outside::Air);
        leaks.any(|(edge, leak)| leak.at(self.system.pressure[edge.cell as usize], 0.0) < -least)
    }

    /// Finds the cells whose kind does not go with what came out. True if there are none.
    fn compare(&mut self, round: usize) -> bool {
        let slack = self.slack(&self.system.pressure);
        let mut settled = true;
        for cell in 0..self.kind.len() {
            let p = self.system.pressure[cell];
            let level = self.medium.standing_pressure(1.0, self.soil.share[cell]);
            let flip = match self.kind[cell] {
                Kind::Void => false,
                Kind::Full => p < self.least_pressure(cell, level, &self.trial) - slack,
                Kind::Standing => p > level + slack,
                Kind::Hanging | Kind::Loose => self.trial[cell] > self.pores(cell) * (1.0 + ROUND),
            };
            // A cell that goes to and fro ends as what it was before the step.
            let returns = self.flips[cell] < FLIPS || self.flips[cell] % 2 == 1;
            if flip && returns && round + 1 < ROUNDS {
                self.full[cell] = !self.full[cell];
                self.flips[cell] += 1;
                settled = false;
            }
        }
        settled
    }

    /// Round-off of pressures (Pa) beside the weight of a cell of water, Pa.
    fn slack(&self, pressures: &[f64]) -> f64 {
        let sizes = self.cells.iter().map(|cell| pressures[*cell as usize].abs());
        ROUND * sizes.fold(self.medium.rise() * self.medium.size, f64::max)
    }

    /// Least pressure at which a full cell stays so, Pa; `level` is that of water up to the top of its own soil.
    fn least_pressure(&self, cell: usize, level: f64, content: &[f64]) -> f64 {
        let covered = matches!(self.above[cell], Neighbour::Cell(above)
            if content[above as usize] > FILM * self.pores(above as usize));
        if self.stands(cell, &self.full) && !covered { level } else { 0.0 }
    }

    /// Makes the systems those of the links.
    fn renew(&mut self) -> Result<(), Unsolved> {
        if !std::mem::take(&mut self.stale) {
            return Ok(());
        }
        match &mut self.room {
            Some(room) => room.link(&self.links)?,
            None => self.system = System::new(self.content.len(), &self.links)?,
        }
        Ok(())
    }

    /// Makes a step of at most `dt` (s). Returns its length and the length to try next, s.
    ///
    /// # Errors
    /// The flow could not be found.
    pub fn step(&mut self, dt: f64) -> Result<(f64, f64), NoFlow> {
        self.renew()?;
        if let (Some(law), Some(mut room)) = (self.medium.retention, self.room.take()) {
            let made = self.step_unsaturated(&mut room, &law, dt);
            self.room = Some(room);
            return made;
        }
        // Water that falls passes half a cell at most.
        let fall = self.medium.fall(self.medium.rise());
        let (mut step, mut cut) = (dt.min(fall), false);
        loop {
            let (change, fills) = self.attempt(step)?;
            if change <= CHANGE[1] && cuts(fills) && !cut {
                // A step ends where a front goes over to the next cell; slightly later, so that it has passed.
                step *= fills * (1.0 + 1e-6);
                cut = true;
                self.full.copy_from_slice(&self.before);
                continue;
            }
            if change <= CHANGE[1] {
                self.accept(step);
                let factor = if change > 0.0 { (CHANGE[0] / change).clamp(0.3, 1.5) } else { 1.5 };
                return Ok((step, step * factor));
            }
            self.full.copy_from_slice(&self.before);
            step *= if change.is_finite() { (CHANGE[0] / change).clamp(0.1, 0.5) } else { 0.1 };
            if step < 1e-12 * dt.min(fall) {
                return Err(NoFlow::TooShort(step));
            }
        }
    }

    fn accept(&mut self, dt: f64) {
        std::mem::swap(&mut self.content, &mut self.trial);
        self.pressure.copy_from_slice(&self.system.pressure);
        for flux in &mut self.flux {
            flux.fill(0.0);
        }
        let p = &self.pressure;
        for (link, flow) in self.links.iter().zip(&self.flows) {
            self.flux[link.axis as usize][link.face as usize] = flow.at(p[link.low as usize], p[link.high as usize]);
        }
        for ((edge, leak), left) in self.edges.iter().zip(&self.leaks).zip(&mut self.left) {
            *left = edge.lets_out(leak.at(p[edge.cell as usize], 0.0));
        }
        self.count(dt);
    }

    /// Counts what has flowed in and out in a step of `dt` (s).
    fn count(&mut self, dt: f64) {
        for edge in &self.edges {
            if let Outside::Inflow(flow) = edge.outside {
                self.asked += dt * flow;
            }
        }
        // Rain that comes out where it falls has never been in.
        for rained in &self.rained {
            let (way_out, way_in) = (rained.way_out as usize, rained.way_in as usize);
            let off = self.left[way_out].min(-self.left[way_in]).max(0.0);
            self.left[way_out] -= off;
            self.left[way_in] += off;
            self.ran_off += dt * (off + rained.excess);
            self.asked += dt * rained.excess;
        }
        self.rates = [0.0; 2];
        for left in &self.left {
            self.rates[usize::from(*left > 0.0)] += left.abs();
        }
        self.inflow += dt * self.rates[0];
        self.outflow += dt * self.rates[1];
    }

    /// Edges with their flow out of the soil in the last step, m3/s.
    pub fn leaks(&self) -> impl Iterator<Item = (&Edge, f64)> {
        self.edges.iter().zip(self.left.iter().copied())
    }

    /// Height of the free surface at x (m), m: that of the highest water that stands in the column of cells there, between the
    /// columns on either side.
    pub fn level(&self, grid: &Grid<D>, x: f64) -> f64 {
        let at = x * grid.inverse_size - 0.5;
        let last = (grid.cells[0] - 1) as f64;
        let left = at.floor().clamp(0.0, last);
        let share = (at - left).clamp(0.0, 1.0);
        let [a, b] = [left, (left + 1.0).min(last)].map(|column| self.level_in(grid, column as usize));
        a + share * (b - a)
    }

    /// The same in a column of cells: from the pressure of the highest cell that has one.
    fn level_in(&self, grid: &Grid<D>, column: usize) -> f64 {
        let rise = self.medium.rise() * self.medium.size;
        if D == 1 || rise == 0.0 {
            return 0.0;
        }
        let mut level: f64 = 0.0;
        for row in 0..grid.cells[D - 1] {
            let cell = column + row * grid.cells[0];
            if self.kind[cell].unknown() && self.wet_share(cell) > 1e-6 {
                let above = self.pressure[cell] / rise + 0.5;
                level = level.max((row as f64 + above.max(0.0)) * grid.size);
            } else if row == 0 || level > 0.0 {
                break;
            }
        }
        level
    }

    /// Saves or restores the state.
    pub(crate) fn save_or_restore(
        &mut self,
        archive: &mut Archive,
        grid: &Grid<D>,
        around: &Surroundings,
    ) -> Result<(), RestoreError> {
        let soil = &mut self.soil;
        archive!(archive.slice: self.content, self.pressure, self.full, soil.share, soil.pores, soil.stays);
        archive.value(&mut soil.halves)?;
        for cover in &mut soil.cover {
            archive.slice(cover)?;
        }
        for flux in &mut self.flux {
            archive.slice(flux)?;
        }
        archive!(archive.value: self.inflow, self.outflow, self.asked, self.ran_off, self.rates, self.unsettled);
        if archive.restores() {
            self.build(grid, around);
            self.classify();
        }
        Ok(())
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let floats = self.content.capacity() + self.pressure.capacity() + self.trial.capacity() + self.wet.capacity();
        floats * size_of::<f64>()
            + self.links.capacity() * (size_of::<Link>() + size_of::<Linear>())
            + self.system.matrix.bytes()
            + self.system.factor.bytes()
            + self.room.as_ref().map_or(0, |room| room.bytes())
    }
}

/// Whether a front that fills a cell after a share of the step is worth a step of its own: one that is nearly there, at the
/// beginning or at the end, makes no error to speak of.
fn cuts(share: f64) -> bool {
    (0.05..0.95).contains(&share)
}

/// Faces between cells of soil, of which the best conduct as the `largest`.
fn links<const D: usize>(grid: &Grid<D>, soil: &SoilMap<D>, largest: f64, periodic: bool) -> Vec<Link> {
    let mut list = Vec::new();
    for (cell, position) in grid.walk() {
        let mut stride = 1;
        for axis in 0..D {
            let wraps = periodic && axis == 0 && D == 2 && position[0] == 0 && grid.cells[0] > 1;
            let low = match position[axis] {
                0 if wraps => Some(cell + grid.cells[0] - 1),
                0 => None,
                _ => Some(cell - stride),
            };
            if let Some(low) = low.filter(|low| soil.is_soil(*low) && soil.is_soil(cell)) {
                let face = grid.face(axis, &position);
                let [below, above] = soil.cover[axis][face];
                let below = if wraps {
                    let mut last = position;
                    last[axis] = grid.cells[axis];
                    soil.cover[axis][grid.face(axis, &last)][0]
                } else {
                    below
                };
                let open = below.min(above);
                if open > 0.0 {
                    let ratio = soil.halves.between(axis, low, cell) / largest;
                    list.push(Link {
                        low: low as u32,
                        high: cell as u32,
                        face: face as u32,
                        axis: axis as u8,
                        open,
                        ratio,
                    });
                }
            }
            stride *= grid.cells[axis];
        }
    }
    list
}

#[cfg(test)]
mod tests;

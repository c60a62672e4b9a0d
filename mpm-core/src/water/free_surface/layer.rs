//! Water particles that follow the flow: what enters becomes particles, what leaves takes them away, both recorded.
//!
//! The contents of the cells are the balance; every particle is one equal part of it. Particles move with the flow through the
//! faces of their cell, and are shifted a little from cells that hold more particles than water to those that hold fewer
//! (Fickian shifting; Lind et al. 2012, J. Comput. Phys. 231, 1499-1523), so that the layer neither clots nor tears.

use super::FreeSurface;
use super::flow::Kind;
use super::soil::{along, spread};
use crate::checkpoint::{Archive, RestoreError, archive};
use crate::dimension::shares;
use crate::grid::Grid;
use crate::particles::WaterPoint;
use crate::real::{array_of, map_of};

/// Share of a surplus that is shifted in a step; a quarter is the limit of stability in two dimensions.
const SHIFT: f64 = 0.2;
/// Longest shift in a step, in cells.
const LONGEST: f64 = 0.1;

/// With so many times the particles that fill the mesh no more come in. Flow that is followed step by step stays far below;
/// without it a step that lasts for ever would bring particles without end.
const CROWDED: f64 = 2.0;

/// The particles of the water.
#[derive(Debug, Clone)]
pub struct WaterLayer<const D: usize> {
    /// The particles, in the order in which they came.
    pub points: Vec<WaterPoint<D>>,
    /// Water of one particle, m3.
    pub volume: f64,
    /// Density of the water, kg/m3.
    density: f64,
    /// Particles that were there at the start.
    pub first: u64,
    /// Particles that have come in through feeds.
    pub spawned: u64,
    /// Particles that were taken away where water leaves the soil.
    pub removed: u64,
    /// Water that has come in (or gone, if negative) since the last particle was made, m3, per cell.
    pending: Vec<f64>,
    /// Water of the particles in each cell, m3.
    pub gathered: Vec<f64>,
    /// Edge of a particle's box, in cells.
    edge: f64,
    /// Places taken in turn by new particles.
    turn: u64,
    /// How often water was recorded: each time rounds.
    bookings: u64,
}

/// What the particles of a layer hold beside what the cells do.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Rounding {
    /// Most that may be pending, m3: half a particle in each cell where water has entered or left.
    pub pending: f64,
    /// Bookings so far.
    pub bookings: u64,
    /// Water of a particle, m3.
    pub particle: f64,
}

impl<const D: usize> WaterLayer<D> {
    /// Particles in the wet part of the cells of `water`: `per_direction` per cell in a full one.
    pub fn new(grid: &Grid<D>, water: &FreeSurface<D>, per_direction: usize, density: f64) -> Self {
        let per_cell = (per_direction as f64).powi(D as i32);
        let volume = water.medium.porosity * water.medium.cell_volume / per_cell;
        let mut layer = Self {
            points: Vec::new(),
            volume,
            density,
            first: 0,
            spawned: 0,
            removed: 0,
            pending: vec![0.0; grid.cell_count()],
            gathered: vec![0.0; grid.cell_count()],
            edge: 1.0 / per_direction as f64,
            turn: 0,
            bookings: 0,
        };
        let (mut left, mut last) = (0.0, 0);
        for (cell, position) in grid.walk() {
            // Whole particles; the rest goes on to the next cell.
            left += water.content[cell] / volume;
            let count = (left + 0.5).floor().max(0.0) as usize;
            left -= count as f64;
            last = if water.content[cell] > 0.0 { cell } else { last };
            let wet = (water.wet_share(cell) * water.soil.share[cell]).clamp(0.0, 1.0);
            for i in 0..count {
                let columns = if D == 2 { per_direction } else { 1 };
                let (column, row) = (i % columns, i / columns);
                let rows = count.div_ceil(columns);
                let mut x = map_of(&position, |p| p as f64 * grid.size);
                if D == 2 {
                    x[0] += (column as f64 + 0.5) / columns as f64 * grid.size;
                }
                x[D - 1] += (row as f64 + 0.5) / rows as f64 * wet * grid.size;
                layer.points.push(WaterPoint {
                    x,
                    v: [0.0; D],
                    mass: density * volume,
                    volume: volume / water.medium.porosity,
                    pressure: water.pressure[cell].max(0.0),
                });
            }
        }
        layer.pending[last] = left * volume;
        layer.first = layer.points.len() as u64;
        layer.gather(grid, false);
        layer
    }

    /// Saves or restores the state.
    pub(crate) fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        archive!(archive.value: self.points, self.first, self.spawned, self.removed, self.turn, self.bookings);
        archive!(archive.slice: self.pending, self.gathered);
        Ok(())
    }

    /// Water that has entered or left but is no particle yet, m3.
    pub fn pending(&self) -> f64 {
        self.pending.iter().sum()
    }

    /// What rounding to whole particles, and of sums, may come to.
    pub fn rounding(&self) -> Rounding {
        let cells = self.pending.iter().filter(|pending| **pending != 0.0).count();
        Rounding { pending: 0.5 * self.volume * cells as f64, bookings: self.bookings, particle: self.volume }
    }

    /// Water in the particles, m3.
    pub fn stored(&self) -> f64 {
        self.points.len() as f64 * self.volume
    }

    /// Largest surplus or lack of particles in a cell, as a share of a full cell's water.
    pub fn packing(&self, water: &FreeSurface<D>) -> f64 {
        let whole = water.medium.porosity * water.medium.cell_volume;
        let off = self.gathered.iter().zip(&water.content).map(|(g, w)| (g - w).abs() / whole);
        off.fold(0.0, f64::max)
    }

    /// Root of the mean square of that, over the cells that hold water.
    pub fn mean_packing(&self, water: &FreeSurface<D>) -> f64 {
        let whole = water.medium.porosity * water.medium.cell_volume;
        let (mut sum, mut count) = (0.0, 0.0);
        for (g, w) in self.gathered.iter().zip(&water.content) {
            if *w > 0.0 {
                sum += ((g - w) / whole).powi(2);
                count += 1.0;
            }
        }
        if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
    }

    /// Water of the particles in every cell, by the overlap of their boxes.
    fn gather(&mut self, grid: &Grid<D>, periodic: bool) {
        self.gathered.fill(0.0);
        let per_volume = self.volume / self.edge.powi(D as i32);
        let end = grid.cells[0] as f64;
        for point in &self.points {
            let ends: [[f64; 2]; D] = array_of(|d| {
                let middle = point.x[d] * grid.inverse_size;
                [middle - 0.5 * self.edge, middle + 0.5 * self.edge]
            });
            // What reaches over the seam of a periodic mesh is on its other side.
            let across = match ends[0] {
                [low, high] if periodic && D == 2 && low < 0.0 => [[0.0, high], [low + end, end]],
                [low, high] if periodic && D == 2 && high > end => [[low, end], [0.0, high - end]],
                whole => [whole, [0.0; 2]],
            };
            for part in across {
                let spans = std::array::from_fn(|d| {
                    let [low, high] = if d == 0 { part } else { ends[d] };
                    along(low, high, grid.cells[d])
                });
                spread(grid, &spans, |cell, _, overlap| self.gathered[cell] += per_volume * overlap);
            }
        }
    }

    /// Records a step of `dt` (s) that the water has made. Returns whether particles are due for it.
    pub fn book(&mut self, water: &FreeSurface<D>, dt: f64) -> bool {
        self.bookings += 1;
        let mut due = false;
        for (edge, out) in water.leaks() {
            let pending = &mut self.pending[edge.cell as usize];
            *pending -= dt * out;
            due |= pending.abs() >= 0.5 * self.volume;
        }
        due
    }

    /// Records water (m3) that has left cells whose soil has gone.
    pub fn book_lost(&mut self, grid: &Grid<D>, water: &FreeSurface<D>, lost: &[(usize, f64)]) {
        for (cell, lost) in lost {
            self.pending[*cell] -= lost;
        }
        if !lost.is_empty() {
            self.exchange(grid, water);
        }
    }

    /// Moves with the soil, whose nodes have moved by `swept` (m).
    pub fn ride(&mut self, grid: &Grid<D>, swept: &[[f64; D]], periodic: bool) {
        let top: [f64; D] = map_of(&grid.cells, |n| n as f64 * grid.size);
        for point in &mut self.points {
            let Some(cell) = grid.cell_at(&point.x) else { continue };
            let position = grid.cell_position(cell);
            let corners = grid.corners_from(grid.first_corner(cell, &position));
            let xi: [f64; D] = array_of(|d| point.x[d] * grid.inverse_size - position[d] as f64);
            let weight = shares(1.0, &xi);
            for d in 0..D {
                let moved: f64 = (0..Grid::<D>::CORNERS).map(|a| weight[a] * swept[corners[a]][d]).sum();
                point.x[d] += moved;
                if periodic && d == 0 {
                    point.x[d] = point.x[d].rem_euclid(top[d]);
                }
                point.x[d] = point.x[d].clamp(1e-9 * top[d], top[d] * (1.0 - 1e-9));
            }
        }
    }

    /// Follows a step of `dt` (s) that the water has made. Returns how many times the particles were moved for it.
    pub fn follow(&mut self, grid: &Grid<D>, water: &FreeSurface<D>, dt: f64, periodic: bool) -> u64 {
        // No particle may pass more than half a cell at a time.
        let area = water.medium.porosity * water.medium.cell_volume / grid.size;
        let fastest = water.flux.iter().flatten().fold(0.0, |m: f64, q| m.max(q.abs())) / area;
        let parts = (2.0 * fastest * dt * grid.inverse_size).ceil().clamp(1.0, 1000.0);
        for _ in 0..parts as usize {
            self.book(water, dt / parts);
            self.move_by(grid, water, dt / parts, periodic);
        }
        parts as u64
    }

    /// Moves with the flow for a time (s) in which no particle passes more than half a cell, and evens out what is pending.
    pub fn move_by(&mut self, grid: &Grid<D>, water: &FreeSurface<D>, dt: f64, periodic: bool) {
        self.exchange(grid, water);
        self.carry(grid, water, dt, periodic);
        self.gather(grid, periodic);
        self.shift(grid, water, periodic);
    }

    /// Particles for what came in, and none for what went out, whatever face it was: water enters and leaves through a side
    /// that is fed, as its level wants.
    fn exchange(&mut self, grid: &Grid<D>, water: &FreeSurface<D>) {
        let crowded = CROWDED * water.medium.porosity * water.medium.cell_volume * grid.cell_count() as f64;
        for (edge, out) in water.leaks() {
            let cell = edge.cell as usize;
            let (axis, outwards) = (edge.axis as usize, if edge.upper { 1.0 } else { -1.0 });
            // Where all is crowded, the water that comes in waits until there is room for its particles.
            while out <= 0.0 && self.pending[cell] >= 0.5 * self.volume && self.stored() < crowded {
                self.spawn(grid, water, cell, (axis, edge.upper));
            }
            if out >= 0.0 {
                let mut exit = map_of(&grid.cell_position(cell), |i| (i as f64 + 0.5) * grid.size);
                exit[axis] += 0.5 * outwards * grid.size;
                self.take(cell, &exit);
            }
        }
        for cell in 0..self.pending.len() {
            let middle = map_of(&grid.cell_position(cell), |i| (i as f64 + 0.5) * grid.size);
            self.take(cell, &middle);
            while self.pending[cell] >= 0.5 * self.volume && self.stored() < crowded {
                self.spawn(grid, water, cell, (D - 1, true));
            }
        }
    }

    /// Makes a particle behind a face of a cell.
    fn spawn(&mut self, grid: &Grid<D>, water: &FreeSurface<D>, cell: usize, (axis, upper): (usize, bool)) {
        self.pending[cell] -= self.volume;
        self.spawned += 1;
        self.turn += 1;
        let position = grid.cell_position(cell);
        let from_edge = 0.5 * self.edge;
        // The golden ratio spreads places evenly whatever their number.
        let spot = (self.turn as f64 * 0.618_033_988_749_894_9).fract();
        let wet = water.wet_share(cell).clamp(0.05, 1.0);
        let x = array_of(|d| {
            let inside = if d == axis {
                if upper { 1.0 - from_edge } else { from_edge }
            } else if d == D - 1 && water.kind[cell] == Kind::Standing {
                spot * wet
            } else {
                spot
            };
            (position[d] as f64 + inside) * grid.size
        });
        self.points.push(WaterPoint {
            x,
            v: [0.0; D],
            mass: self.density * self.volume,
            volume: self.volume / water.medium.porosity,
            pressure: water.pressure[cell].max(0.0),
        });
    }

    /// Takes the particles nearest to a place (m) for what has left a cell.
    fn take(&mut self, cell: usize, exit: &[f64; D]) {
        while self.pending[cell] <= -0.5 * self.volume {
            let distance = |p: &WaterPoint<D>| (0..D).map(|d| (p.x[d] - exit[d]).powi(2)).sum::<f64>();
            let all = self.points.iter().map(distance).enumerate();
            let Some((nearest, _)) = all.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            self.points.swap_remove(nearest);
            self.pending[cell] += self.volume;
            self.removed += 1;
        }
    }

    /// Velocity of the water (v* = q/n) at the two ends of a cell along an axis, m/s.
    fn ends(&self, grid: &Grid<D>, water: &FreeSurface<D>, (cell, axis): (usize, usize), periodic: bool) -> [f64; 2] {
        let position = grid.cell_position(cell);
        let area = water.medium.porosity * water.medium.cell_volume / grid.size;
        let vertical = axis == D - 1 && water.medium.rise() > 0.0;
        // The part of the face that the water takes: standing water the lower part of a side, falling water its share of the whole.
        let across = match water.kind[cell] {
            Kind::Standing if !vertical => water.wet_share(cell).clamp(0.2, 1.0),
            Kind::Loose if vertical => water.wet_share(cell).clamp(0.05, 1.0),
            _ => 1.0,
        };
        [false, true].map(|upper| {
            let mut at = position;
            at[axis] += usize::from(upper);
            let cover = water.soil.cover[axis][grid.face(axis, &at)][usize::from(!upper)].clamp(0.2, 1.0);
            // The seam of a periodic mesh is the lower face of its first cells.
            if periodic && axis == 0 && D == 2 && at[0] == grid.cells[0] {
                at[0] = 0;
            }
            water.flux[axis][grid.face(axis, &at)] / (area * cover * across)
        })
    }

    fn carry(&mut self, grid: &Grid<D>, water: &FreeSurface<D>, dt: f64, periodic: bool) {
        let mut through = vec![[[0.0; 2]; D]; grid.cell_count()];
        for cell in 0..grid.cell_count() {
            if water.content[cell] > 0.0 {
                for axis in 0..D {
                    through[cell][axis] = self.ends(grid, water, (cell, axis), periodic);
                }
            }
        }
        // Flow through the outline of the soil.
        let area = water.medium.porosity * water.medium.cell_volume / grid.size;
        for (edge, out) in water.leaks() {
            let outwards = if edge.upper { out } else { -out };
            let speed = &mut through[edge.cell as usize][edge.axis as usize][usize::from(edge.upper)];
            *speed += outwards / (area * edge.open.clamp(0.2, 1.0));
        }
        let top: [f64; D] = map_of(&grid.cells, |n| n as f64 * grid.size);
        for point in &mut self.points {
            let Some(cell) = grid.cell_at(&point.x) else { continue };
            let position = grid.cell_position(cell);
            for d in 0..D {
                let xi = point.x[d] * grid.inverse_size - position[d] as f64;
                let [low, high] = through[cell][d];
                point.v[d] = match water.kind[cell] {
                    Kind::Full => low + xi * (high - low),
                    // Behind a front all water moves with what presses it.
                    _ if low.abs() > high.abs() => low,
                    _ => high,
                };
            }
            point.pressure = water.pressure[cell].max(0.0);
            for d in 0..D {
                let moved = (dt * point.v[d]).clamp(-0.9 * grid.size, 0.9 * grid.size);
                point.x[d] += moved;
                if periodic && d == 0 {
                    point.x[d] = point.x[d].rem_euclid(top[d]);
                }
                point.x[d] = point.x[d].clamp(1e-9 * top[d], top[d] * (1.0 - 1e-9));
            }
        }
    }

    /// Moves particles down the slope of their surplus.
    fn shift(&mut self, grid: &Grid<D>, water: &FreeSurface<D>, periodic: bool) {
        let whole = water.medium.porosity * water.medium.cell_volume;
        let surplus = |cell: usize| (self.gathered[cell] - water.content[cell]) / whole;
        let mut slope = vec![[[0.0; 2]; D]; grid.cell_count()];
        for (cell, position) in grid.walk() {
            let mut stride = 1;
            for axis in 0..D {
                let over_seam = periodic && axis == 0 && D == 2 && position[0] == 0;
                if over_seam || position[axis] > 0 {
                    let low = if over_seam { cell + grid.cells[0] - 1 } else { cell - stride };
                    // Particles beyond the soil come back; none goes out there.
                    let both = water.soil.is_soil(cell) && water.soil.is_soil(low);
                    let (a, b) = (surplus(low), surplus(cell));
                    let down = if both || (a - b > 0.0) == water.soil.is_soil(cell) { a - b } else { 0.0 };
                    let moved = (SHIFT * down).clamp(-LONGEST, LONGEST);
                    slope[low][axis][1] = moved;
                    slope[cell][axis][0] = moved;
                }
                stride *= grid.cells[axis];
            }
        }
        for point in &mut self.points {
            let Some(cell) = grid.cell_at(&point.x) else { continue };
            let position = grid.cell_position(cell);
            for d in 0..D {
                let xi = point.x[d] * grid.inverse_size - position[d] as f64;
                let [low, high] = slope[cell][d];
                point.x[d] += grid.size * (low + xi * (high - low));
                let top = grid.cells[d] as f64 * grid.size;
                if periodic && d == 0 {
                    point.x[d] = point.x[d].rem_euclid(top);
                }
                point.x[d] = point.x[d].clamp(1e-9 * top, top * (1.0 - 1e-9));
            }
        }
    }
}

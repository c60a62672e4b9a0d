//! Water while its soil moves: pressures that resist a change of the pores.
//!
//! A full cell whose soil gains volume at the rate D(v) draws water in or loses pressure:
//!
//! ```text
//! D_c(v) + Q_c(p) + (pores/K_w) dp_c/dt = r_c,      D_c(v) = V_c sum_i G_i(x_c) . v_i
//! ```
//!
//! with Q the outflow of the cell and r what it takes from its surplus. By the implicit step v and p are those of its end,
//! `v = v* + dt m^-1 D^T (p - p_n)`: a symmetric positive definite system over the wet cells. The explicit one takes Q from the
//! start. A cell that would need suction to stay full lets air in: coarse soil holds none.

use std::ops::Range;

use super::flow::Kind;
use super::{FreeSurface, ROUND};
use crate::envelope::Envelope;
use crate::grid::Grid;
use crate::order::sort_by_number;
use crate::step::store::Motion;
use crate::water::Pushed;

/// Time in which a cell gives back what it holds too much, s: that in which water falls through half of it. Given back at once it
/// would press as if the soil had closed on it.
fn returns<const D: usize>(water: &FreeSurface<D>) -> f64 {
    water.medium.fall(water.medium.unit_weight)
}

/// The checkerboard on a block.
const ALTERNATE: [f64; 4] = [1.0, -1.0, -1.0, 1.0];
/// What no cell has for a number.
const NONE: u32 = u32::MAX;

/// Soil of a cell in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filling<const D: usize> {
    /// Volume of soil, m3.
    pub volume: f64,
    /// Its centroid, in cell coordinates: where its change of volume is measured.
    pub at: [f64; D],
    /// Where the pressure of the start of the step presses.
    pub pressed: [f64; D],
}

/// Room for the pressures of a step.
#[derive(Debug, Clone, Default)]
pub struct Squeeze<const D: usize> {
    /// Water that a cell holds beyond its pores, or lacks, m3: what was carried in does not fit to the last drop.
    pub surplus: Vec<f64>,
    /// Cells of soil by columns, which keeps the band narrow, and the nodes at their corners.
    order: Vec<u32>,
    nodes: Vec<[u32; 4]>,
    /// The nodes that these move with in this step.
    corners: Vec<[u32; 4]>,
    /// Their kinds, and whether these or the corners are others than those that what follows was found for.
    kinds: Vec<Kind>,
    changed: bool,
    /// Cells with an unknown pressure, and their places in `order`.
    unknown: Vec<u32>,
    place: Vec<u32>,
    /// Their places, [`NONE`] for others.
    number: Vec<u32>,
    /// V G_i of each at its corners, m2.
    weights: Vec<[[f64; D]; 4]>,
    /// Nodes at the corners of full cells, and where each has its part of `around`.
    touched: Vec<(u32, Range<u32>)>,
    start: Vec<u32>,
    /// Full cells around each of them, as unknowns, with their corners.
    around: Vec<(u32, u8)>,
    /// Blocks of two by two full cells.
    blocks: Vec<[u32; 4]>,
    first: Vec<usize>,
    matrix: Envelope,
    solution: Vec<f64>,
    /// Explicit pressures of the end of the step, Pa.
    next: Vec<f64>,
}

/// What pressures did in a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pressed {
    /// Work on the soil, J.
    pub work: f64,
}

/// V G_i at a place of the cell, at the corners, m2.
fn weights<const D: usize>(volume: f64, at: &[f64; D], inverse_size: f64) -> [[f64; D]; 4] {
    let factor = volume * inverse_size;
    let mut weights = [[0.0; D]; 4];
    if D == 1 {
        (weights[0][0], weights[1][0]) = (-factor, factor);
        return weights;
    }
    let [x, y] = [at[0], at[D - 1]];
    for (corner, weight) in weights.iter_mut().enumerate() {
        let (right, upper) = (corner & 1 == 1, corner & 2 == 2);
        let along_y = if upper { y } else { 1.0 - y };
        let along_x = if right { x } else { 1.0 - x };
        weight[0] = if right { factor } else { -factor } * along_y;
        weight[D - 1] = if upper { factor } else { -factor } * along_x;
    }
    weights
}

/// Rates at which the soil of a cell gains volume, m3/s: by some weights, each a time (s) before the end of the step.
#[inline]
fn openings<const D: usize, const N: usize>(
    by: [(&[[f64; D]; 4], f64); N],
    corners: &[u32; 4],
    motion: &Motion,
) -> [f64; N] {
    let mut rates = [0.0; N];
    for corner in 0..1 << D {
        let node = corners[corner] as usize;
        for d in 0..D {
            let (velocity, acceleration) = (motion.velocity[d][node], motion.acceleration[d][node]);
            for (rate, (weights, before)) in rates.iter_mut().zip(by) {
                *rate += weights[corner][d] * (velocity - before * acceleration);
            }
        }
    }
    rates
}

impl<const D: usize> Squeeze<D> {
    /// Takes note of the cells of soil.
    pub fn build(&mut self, grid: &Grid<D>, water: &FreeSurface<D>) {
        let count = grid.cell_count();
        self.surplus.resize(count, 0.0);
        self.changed = true;
        self.number.clear();
        self.number.resize(count, NONE);
        self.next.resize(count, 0.0);
        self.order.clear();
        self.order.extend((0..count as u32).filter(|cell| water.soil.is_soil(*cell as usize)));
        let across = grid.cells[0] as u32;
        if D == 2 {
            sort_by_number(&mut self.order, |cell| f64::from(cell % across) * count as f64 + f64::from(cell / across));
        }
        let node = |cell: u32, corner: u32| {
            let (row, up) = if D == 2 { (cell / across, (across + 1) * (corner >> 1)) } else { (0, 0) };
            cell + row + (corner & 1) + up
        };
        self.nodes.clear();
        self.nodes.extend(self.order.iter().map(|cell| [0, 1, 2, 3].map(|corner| node(*cell, corner))));
        self.corners.clone_from(&self.nodes);
        self.kinds.clear();
        self.kinds.resize(self.order.len(), Kind::Void);
    }

    /// Finds the nodes that move the corners of the cells in this step.
    fn find_corners(&mut self, pushed: &Pushed<D>) {
        for (corners, nodes) in self.corners.iter_mut().zip(&self.nodes) {
            for (corner, node) in corners.iter_mut().zip(nodes).take(1 << D) {
                let leader = pushed.leader[*node as usize];
                self.changed |= std::mem::replace(corner, leader) != leader;
            }
        }
    }

    /// Lets the pressures of a step act: on the velocities, if they are implicit, and on the water.
    ///
    /// # Errors
    /// A row of the system that is not positive.
    pub fn press(
        &mut self,
        water: &mut FreeSurface<D>,
        soil: &[Filling<D>],
        pushed: &Pushed<D>,
        motion: &mut Motion,
        step: &MovingStep,
    ) -> Result<Pressed, usize> {
        water.before_motion(step.dt);
        self.find_corners(pushed);
        for (kind, cell) in self.kinds.iter_mut().zip(&self.order) {
            let now = water.kind[*cell as usize];
            self.changed |= std::mem::replace(kind, now) != now;
        }
        if std::mem::take(&mut self.changed) {
            self.collect();
            self.find_blocks(water, pushed.grid.cells[0]);
            self.lay_out(water);
        }
        if step.implicit {
            self.weigh(soil, 1.0 / water.medium.size);
            self.assemble(water, pushed, motion, step);
            self.tie_blocks(water, step);
            let Self { matrix, solution, .. } = self;
            matrix.solve(solution)?;
            for (i, cell) in self.unknown.iter().enumerate() {
                let cell = *cell as usize;
                if water.kind[cell] == Kind::Full {
                    let rise = self.solution[i] - water.pressure[cell];
                    let corners = &self.corners[self.place[i] as usize];
                    for (weight, node) in self.weights[i].iter().zip(corners).take(1 << D) {
                        let node = *node as usize;
                        for d in 0..D {
                            let more = pushed.inverse[node][d] * weight[d] * rise;
                            motion.acceleration[d][node] += more;
                            motion.velocity[d][node] += step.dt * more;
                            motion.change[d][node] += step.dt * more;
                        }
                    }
                }
                water.system.pressure[cell] = self.solution[i];
            }
        }
        let mut pressed = Pressed::default();
        self.take_in(water, soil, motion, step, &mut pressed);
        water.accept(step.dt);
        if !step.implicit {
            for &cell in self.order.iter().filter(|cell| water.kind[**cell as usize] == Kind::Full) {
                water.pressure[cell as usize] = self.next[cell as usize];
            }
        }
        water.after_motion();
        Ok(pressed)
    }

    /// Work (J) that pressures which are fixed (Pa) do in a step.
    pub fn work_of(
        &mut self,
        pressure: &[f64],
        soil: &[Filling<D>],
        pushed: &Pushed<D>,
        motion: &Motion,
        dt: f64,
    ) -> f64 {
        self.find_corners(pushed);
        let mut power = 0.0;
        for (&cell, corners) in self.order.iter().zip(&self.corners) {
            let cell = cell as usize;
            if pressure[cell] != 0.0 && soil[cell].volume > 0.0 {
                let weights = weights(soil[cell].volume, &soil[cell].pressed, pushed.grid.inverse_size);
                power += pressure[cell] * openings([(&weights, 0.5 * dt)], corners, motion)[0];
            }
        }
        dt * power
    }

    /// Cells that are not full take what waits, and all others a little of it, for a time (s).
    pub fn give_back(&mut self, water: &mut FreeSurface<D>, time: f64) {
        let share = 1.0 - (-time / returns(water)).exp();
        for &cell in &self.order {
            let cell = cell as usize;
            let surplus = &mut self.surplus[cell];
            if *surplus == 0.0 {
                continue;
            }
            // A full cell passes it on in the next steps: what is beyond its pores enters the balance of a step.
            let most = if water.kind[cell] == Kind::Full { share * surplus.abs() } else { f64::INFINITY };
            let room = (-water.content[cell], (water.pores(cell) - water.content[cell]).max(0.0));
            let given = if water.kind[cell] == Kind::Full { *surplus } else { surplus.max(room.0).min(room.1) };
            // No clamp, which panics beside pores that are no number: a step of the soil reports them.
            let given = given.max(-most).min(most);
            water.content[cell] += given;
            *surplus -= given;
        }
    }

    /// Finds the unknowns and what surrounds the nodes.
    fn collect(&mut self) {
        let Self { order, corners, kinds, unknown, place, number, touched, start, around, .. } = self;
        for cell in unknown.iter() {
            number[*cell as usize] = NONE;
        }
        unknown.clear();
        place.clear();
        start.clear();
        for (at, cell) in order.iter().enumerate().filter(|(at, _)| kinds[*at].unknown()) {
            number[*cell as usize] = unknown.len() as u32;
            unknown.push(*cell);
            place.push(at as u32);
        }
        let (place, corners) = (&*place, &*corners);
        let full = || place.iter().enumerate().filter(|(_, at)| kinds[**at as usize] == Kind::Full);
        let nodes =
            || full().flat_map(|(i, at)| (0..1 << D).map(move |corner| (i, corner, corners[*at as usize][corner])));
        start.resize(nodes().map(|(.., node)| node as usize + 2).max().unwrap_or(1), 0);
        nodes().for_each(|(.., node)| start[node as usize + 1] += 1);
        touched.clear();
        let mut count = 0;
        for node in 0..start.len() - 1 {
            let own = start[node + 1];
            start[node] = count;
            if own > 0 {
                touched.push((node as u32, count..count + own));
                count += own;
            }
        }
        around.clear();
        around.resize(count as usize, (0, 0));
        for (i, corner, node) in nodes() {
            let next = &mut start[node as usize];
            around[*next as usize] = (i as u32, corner as u8);
            *next += 1;
        }
    }

    /// Finds where the rows of the matrix begin.
    fn lay_out(&mut self, water: &FreeSurface<D>) {
        let Self { unknown, number, touched, around, first, matrix, .. } = self;
        first.clear();
        first.extend(0..unknown.len());
        for (_, own) in touched {
            // By rising numbers: they come in the order of the unknowns.
            let own = &around[own.start as usize..own.end as usize];
            for (i, _) in own {
                first[*i as usize] = first[*i as usize].min(own[0].0 as usize);
            }
        }
        for link in &water.links {
            let (a, b) = (number[link.low as usize], number[link.high as usize]);
            if a != NONE && b != NONE {
                let (low, high) = (a.min(b) as usize, a.max(b) as usize);
                first[high] = first[high].min(low);
            }
        }
        matrix.clear(unknown.len(), |row| first[row]);
    }

    /// V G_i of the unknowns as their soil is now.
    fn weigh(&mut self, soil: &[Filling<D>], inverse_size: f64) {
        self.weights.clear();
        let of = |cell: &u32| weights(soil[*cell as usize].volume, &soil[*cell as usize].at, inverse_size);
        self.weights.extend(self.unknown.iter().map(of));
    }

    /// Blocks of two by two full cells exchange water where their pressures alternate: one pressure per cell beside bilinear
    /// velocities leaves checkerboards to chance in undrained soil (Q1-P0). As the local jumps of Kechkar & Silvester 1992,
    /// doi:10.1090/S0025-5718-1992-1106973-X, but on the change of the pressure in a step, and along the checkerboard alone, so
    /// that a change that is linear over the block costs nothing.
    fn find_blocks(&mut self, water: &FreeSurface<D>, across: usize) {
        self.blocks.clear();
        if D == 1 {
            return;
        }
        for (i, &cell) in self.unknown.iter().enumerate() {
            let cell = cell as usize;
            if (cell + 1).is_multiple_of(across) || cell + across + 1 >= self.number.len() {
                continue;
            }
            let cells = [cell, cell + 1, cell + across, cell + across + 1];
            if cells.iter().all(|cell| water.kind[*cell] == Kind::Full) {
                let [_, right, above, beyond] = cells.map(|cell| self.number[cell]);
                self.blocks.push([i as u32, right, above, beyond]);
            }
        }
    }

    /// The exchange of the blocks: to the matrix, and with the pressures of the start to the right-hand side.
    fn tie_blocks(&mut self, water: &FreeSurface<D>, step: &MovingStep) {
        let exchange = step.smoothing * water.medium.cell_volume / step.dt;
        for block in &self.blocks {
            let first: f64 =
                (0..4).map(|k| ALTERNATE[k] * water.pressure[self.unknown[block[k] as usize] as usize]).sum();
            for a in 0..4 {
                let i = block[a] as usize;
                self.solution[i] += exchange * ALTERNATE[a] * first;
                for b in 0..=a {
                    self.matrix.add(i, block[b] as usize, exchange * ALTERNATE[a] * ALTERNATE[b]);
                }
            }
        }
    }

    /// The water that they exchange in the step.
    fn exchange(&mut self, water: &mut FreeSurface<D>, step: &MovingStep) {
        let exchange = step.smoothing * water.medium.cell_volume;
        for block in &self.blocks {
            let rise = |k: usize| {
                let i = block[k] as usize;
                self.solution[i] - water.pressure[self.unknown[i] as usize]
            };
            let change: f64 = (0..4).map(|k| ALTERNATE[k] * rise(k)).sum();
            for k in 0..4 {
                water.trial[self.unknown[block[k] as usize] as usize] -= exchange * ALTERNATE[k] * change;
            }
        }
    }

    fn assemble(&mut self, water: &FreeSurface<D>, pushed: &Pushed<D>, motion: &Motion, step: &MovingStep) {
        let Self { unknown, number, weights, touched, around, matrix, solution, surplus, .. } = self;
        matrix.empty();
        solution.clear();
        solution.resize(unknown.len(), 0.0);
        for (node, own) in touched {
            let (node, of) = (*node as usize, &around[own.start as usize..own.end as usize]);
            let inverse = pushed.inverse[node];
            for (k, &(i, corner)) in of.iter().enumerate() {
                let own = weights[i as usize][corner as usize];
                let from_i = water.pressure[unknown[i as usize] as usize];
                for d in 0..D {
                    // The velocity that the pressure of the start has made.
                    solution[i as usize] -= own[d] * motion.velocity[d][node];
                }
                for &(j, other) in &of[..=k] {
                    let beside = weights[j as usize][other as usize];
                    let coupling: f64 = (0..D).map(|d| inverse[d] * own[d] * beside[d]).sum();
                    // A cell may meet itself twice at a node that others follow.
                    let twice = if i == j && corner != other { 2.0 } else { 1.0 };
                    matrix.add(i as usize, j as usize, step.dt * coupling * twice);
                    let from_j = water.pressure[unknown[j as usize] as usize];
                    solution[i as usize] += step.dt * coupling * from_j;
                    if i != j || corner != other {
                        solution[j as usize] += step.dt * coupling * from_i;
                    }
                }
            }
        }
        let returns = returns(water);
        for (i, &cell) in unknown.iter().enumerate() {
            let cell = cell as usize;
            let pores = water.pores(cell);
            if water.kind[cell] == Kind::Full {
                let storage = pores / (step.bulk_modulus * step.dt);
                matrix.add(i, i, storage);
                let over = water.content[cell] - pores * (1.0 + water.pressure[cell] / step.bulk_modulus);
                solution[i] += storage * water.pressure[cell] + (surplus[cell] + over) / returns;
            } else {
                let full_rise = water.medium.rise() * water.medium.size;
                let per_pressure = pores / (full_rise * water.soil.share[cell]) / step.dt;
                matrix.add(i, i, per_pressure);
                solution[i] += water.content[cell] / step.dt - per_pressure * 0.5 * full_rise;
            }
        }
        for (link, flow) in water.links.iter().zip(&water.flows) {
            let (a, b) = (number[link.low as usize], number[link.high as usize]);
            if a != NONE {
                matrix.add(a as usize, a as usize, flow.low);
                solution[a as usize] -= flow.fixed;
            }
            if b != NONE {
                matrix.add(b as usize, b as usize, flow.high);
                solution[b as usize] += flow.fixed;
            }
            if a != NONE && b != NONE {
                matrix.add(a as usize, b as usize, -flow.low);
            }
        }
        for (edge, leak) in water.edges.iter().zip(&water.leaks) {
            let i = number[edge.cell as usize];
            if i != NONE {
                matrix.add(i as usize, i as usize, leak.low);
                solution[i as usize] -= leak.fixed;
            }
        }
    }

    /// Pores follow the soil, contents the flow; explicit pressures follow both.
    fn take_in(
        &mut self,
        water: &mut FreeSurface<D>,
        soil: &[Filling<D>],
        motion: &Motion,
        step: &MovingStep,
        pressed: &mut Pressed,
    ) {
        water.contents(step.dt);
        if step.implicit {
            self.exchange(water, step);
        }
        let returns = returns(water);
        for (&cell, corners) in self.order.iter().zip(&self.corners) {
            let cell = cell as usize;
            let full = water.kind[cell] == Kind::Full;
            if water.content[cell] <= 0.0 && water.trial[cell] <= 0.0 && self.surplus[cell] == 0.0 {
                continue;
            }
            let (soil, inverse_size) = (&soil[cell], 1.0 / water.medium.size);
            let whole = weights(soil.volume, &soil.at, inverse_size);
            let pressed_at = weights(soil.volume, &soil.pressed, inverse_size);
            let half = 0.5 * step.dt;
            let by = [(&whole, 0.0), (&whole, half), (&pressed_at, half)];
            let [rate, middle, middle_pressed] = openings(by, corners, motion);
            let outflow = (water.content[cell] - water.trial[cell]) / step.dt;
            let returned = self.surplus[cell] / returns;
            if full && !step.implicit {
                let over = water.content[cell] - water.pores(cell) * (1.0 + water.pressure[cell] / step.bulk_modulus);
                let unbalanced = returned + over / returns - rate - outflow;
                self.next[cell] = water.pressure[cell] + unbalanced * step.dt * step.bulk_modulus / water.pores(cell);
            }
            // What the soil felt in this step: with explicit pressures that of its start.
            let rise = if full && step.implicit { water.system.pressure[cell] - water.pressure[cell] } else { 0.0 };
            pressed.work += step.dt * (water.mean_pressure(cell) * middle_pressed + rise * middle);
            water.soil.pores[cell] += step.dt * rate;
            water.trial[cell] += step.dt * returned;
            self.surplus[cell] -= step.dt * returned;
            if water.trial[cell] < 0.0 {
                self.surplus[cell] += water.trial[cell];
                water.trial[cell] = 0.0;
            }
        }
    }
}

/// A step of the soil, as its water sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingStep {
    /// Its length, s.
    pub dt: f64,
    /// Whether the pressures are those of its end.
    pub implicit: bool,
    /// Bulk modulus of the water K_w, Pa.
    pub bulk_modulus: f64,
    /// Water that blocks of full cells exchange where their pressures alternate, per volume and pressure, 1/Pa.
    pub smoothing: f64,
}

impl<const D: usize> FreeSurface<D> {
    /// Flows from the state at the start of a step.
    fn before_motion(&mut self, dt: f64) {
        self.classify();
        // Suction stays what it was while the soil moves: it is found anew where the water is carried along.
        let cells = if self.medium.retention.is_some() { 0 } else { self.cells.len() };
        for i in 0..cells {
            let cell = self.cells[i] as usize;
            self.wet[cell] = self.wet_share(cell).clamp(0.0, 1.0);
            self.pressure[cell] = match self.kind[cell] {
                Kind::Full => self.pressure[cell],
                Kind::Standing => self.medium.standing_pressure(self.wet[cell], self.soil.share[cell]),
                _ => 0.0,
            };
        }
        self.system.pressure.copy_from_slice(&self.pressure);
        self.assemble(dt);
    }

    /// Finds which cells are full from now on.
    fn after_motion(&mut self) {
        let slack = self.slack(&self.pressure);
        for i in 0..self.cells.len() {
            let cell = self.cells[i] as usize;
            let share = self.soil.share[cell];
            let least = match self.medium.retention {
                Some(_) => -self.medium.above_middle(share),
                None => self.least_pressure(cell, self.medium.standing_pressure(1.0, share), &self.content),
            };
            match self.kind[cell] {
                Kind::Full => {
                    if self.pressure[cell] < least - slack {
                        self.full[cell] = false;
                    }
                }
                _ => {
                    if self.content[cell] >= self.pores(cell) * (1.0 - ROUND) {
                        self.full[cell] = true;
                        self.pressure[cell] = self.pressure[cell].max(0.0);
                    }
                }
            }
        }
        self.classify();
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Medium, NO_HEADS, SoilMap, Surroundings};
    use super::*;
    use crate::dimension::{PRESSURE, internal_force};
    use crate::particles::{Layer, SolidPoint, even_positions};
    use crate::soils::Soils;
    use crate::water::retention::Retention;

    const H: f64 = 0.5;
    const N: f64 = 0.3;
    const CELLS: [usize; 2] = [4, 3];
    const KW: f64 = 2e8;

    /// Numbers between -1 and 1 that look like chance.
    fn chance(seed: usize) -> f64 {
        (((seed as f64 + 1.0) * 12.989_8).sin() * 43_758.545_3).fract()
    }

    /// A closed block that is full of water at rest.
    fn full(conductance: f64) -> (Grid<2>, FreeSurface<2>, Squeeze<2>, Vec<Filling<2>>) {
        let grid = Grid::new(CELLS, H);
        let volume = 0.25 * H * H;
        let at =
            |x: [f64; 2]| SolidPoint::<2> { x: x.map(|x| x * H), v: [0.0; 2], stress: [0.0; 4], mass: volume, volume };
        let solid = Layer::new(even_positions(CELLS, 2).map(at).collect(), &grid).unwrap();
        let weight = [0.0, -9810.0];
        let medium = Medium {
            conductance,
            size: H,
            cell_volume: H * H,
            weight,
            unit_weight: 9810.0,
            porosity: N,
            retention: None,
        };
        let soil = SoilMap::new(&grid, &solid, H, 2, &Soils::one(1.0 - N));
        let around =
            Surroundings { open: [false; 4], feeds: [None; 4], heads: NO_HEADS, periodic: false, standing: Vec::new() };
        let mut water = FreeSurface::new(&grid, medium, (soil, Soils::one(1.0 - N)), &around).unwrap();
        let content: Vec<f64> = (0..12).map(|cell| water.pores(cell)).collect();
        water.fill(&content);
        let mut squeeze = Squeeze::default();
        squeeze.build(&grid, &water);
        (grid, water, squeeze, vec![Filling { volume: H * H, at: [0.5; 2], pressed: [0.5; 2] }; 12])
    }

    #[test]
    fn pressures_push_as_they_work() {
        for case in 0..50 {
            let [a, b, c, p] = [0, 1, 2, 3].map(|i| chance(4 * case + i));
            let at = [0.5 + 0.5 * b, 0.5 + 0.5 * c];
            let soil = Filling { volume: 0.2 * (1.5 + a), at, pressed: at };
            let found = weights(soil.volume, &soil.at, 1.0 / H);
            // What the step makes of the stress -p 1 in the soil of a cell.
            let mean = PRESSURE.map(|s| s * p * soil.volume);
            let first = soil.at.map(|x| mean.map(|s| x * s));
            let force = crate::dimension::to_corners::<2, 2, _>(&internal_force::<2, f64>(&mean, &first, 1.0 / H));
            for corner in 0..4 {
                for d in 0..2 {
                    let (push, weight) = (-force[corner][d], p * found[corner][d]);
                    assert!((push - weight).abs() < 1e-15, "case {case}: {push} {weight}");
                }
            }
        }
    }

    /// Nodes with random velocities and masses; rollers hold some of them, and one follows another.
    fn nodes(grid: &Grid<2>) -> (Vec<[f64; 2]>, Vec<u32>, Motion) {
        let count = grid.node_count();
        let mut inverse: Vec<[f64; 2]> = (0..count).map(|i| [1e-3 * (1.5 + chance(i)); 2]).collect();
        let mut motion = Motion::at_rest(count);
        let mut leader: Vec<u32> = (0..count as u32).collect();
        for node in 0..count {
            let v = &mut motion.velocity;
            (0..2).for_each(|d| v[d][node] = 1e-3 * chance(100 + 2 * node + d));
            let (x, y) = (node % (CELLS[0] + 1), node / (CELLS[0] + 1));
            if x == 0 || x == CELLS[0] {
                (v[0][node], inverse[node][0]) = (0.0, 0.0);
            }
            if y == 0 {
                (v[1][node], inverse[node][1]) = (0.0, 0.0);
            }
        }
        leader[count - 1] = count as u32 - 2;
        (inverse, leader, motion)
    }

    #[test]
    fn implicit_pressures_do_the_work_that_the_nodes_get() {
        let (grid, mut water, mut squeeze, soil) = full(1e-9);
        let (inverse, leader, mut motion) = nodes(&grid);
        let pushed = Pushed { grid: &grid, inverse: &inverse, leader: &leader };
        let before = (motion.clone(), water.pressure.clone());
        let dt = 1e-3;
        // What blocks exchange is checked below.
        let step = MovingStep { dt, implicit: true, bulk_modulus: KW, smoothing: 0.0 };
        let pores: Vec<f64> = (0..12).map(|cell| water.pores(cell)).collect();
        squeeze.press(&mut water, &soil, &pushed, &mut motion, &step).unwrap();
        // Kinetic energy that nodes gained by the rise of the pressures, at the middle of the step.
        let mut gained = 0.0;
        for node in 0..grid.node_count() {
            for d in 0..2 {
                let now = motion.velocity[d][node];
                let change = now - before.0.velocity[d][node];
                if inverse[node][d] > 0.0 {
                    gained += change * (now - 0.5 * change) / inverse[node][d];
                } else {
                    assert_eq!(change, 0.0, "a node that is held");
                }
            }
        }
        let place = |cell: usize| squeeze.order.iter().position(|of| *of as usize == cell).expect("a cell of soil");
        let opened = |cell: usize, motion: &Motion| {
            let weights = weights(H * H, &soil[cell].at, 1.0 / H);
            openings([(&weights, 0.0)], &squeeze.corners[place(cell)], motion)[0]
        };
        let mut work = 0.0;
        for cell in 0..12 {
            let rise = water.pressure[cell] - before.1[cell];
            let mut halfway = Motion::at_rest(grid.node_count());
            for (d, half) in halfway.velocity.iter_mut().enumerate() {
                let both = motion.velocity[d].iter().zip(&before.0.velocity[d]);
                *half = both.map(|(a, b)| 0.5 * (a + b)).collect();
            }
            work += dt * rise * opened(cell, &halfway);
        }
        assert!(gained.abs() > 1e-6 && (work / gained - 1.0).abs() < 1e-10, "{work:e} {gained:e}");
        // Pores follow the motion of the end of the step, and pressures what is left: the balance of every cell closes.
        let mut worst: f64 = 0.0;
        for cell in 0..12 {
            let opened = dt * opened(cell, &motion);
            assert!((water.pores(cell) - pores[cell] - opened).abs() < 1e-16);
            let stored = water.content[cell] - pores[cell];
            let pressed = pores[cell] / KW * (water.pressure[cell] - before.1[cell]);
            // Water at rest was not yet compressed; that comes by and by.
            let lacks = pores[cell] * before.1[cell] / KW * dt / returns(&water);
            worst = worst.max((stored - opened - pressed - lacks).abs() / opened.abs().max(1e-12));
        }
        assert!(worst < 1e-8, "{worst:e}");
        assert!((water.stored() - pores.iter().sum::<f64>()).abs() < 1e-15);
    }

    #[test]
    fn unsaturated_water_flows_in_a_step_of_soil_before_any_of_the_water_alone() {
        let conductance = 1e-9;
        for implicit in [true, false] {
            let (grid, mut water, mut squeeze, soil) = full(conductance);
            let law = Retention::Gardner { alpha: 2.0 };
            water.medium.retention = Some(law);
            let around = Surroundings {
                open: [false; 4],
                feeds: [None; 4],
                heads: NO_HEADS,
                periodic: false,
                standing: Vec::new(),
            };
            water.surround(&grid, &around);
            // The same suction everywhere: nothing but gravity moves the water.
            water.soak(&law, &[-2000.0; 12]);
            let first = water.content.clone();
            let inverse = vec![[0.0; 2]; grid.node_count()];
            let leader: Vec<u32> = (0..grid.node_count() as u32).collect();
            let pushed = Pushed { grid: &grid, inverse: &inverse, leader: &leader };
            let step = MovingStep { dt: 1.0, implicit, bulk_modulus: KW, smoothing: 0.0 };
            let mut motion = Motion::at_rest(grid.node_count());
            squeeze.press(&mut water, &soil, &pushed, &mut motion, &step).unwrap();
            let falls = conductance * (-2.0 * 2000.0 / 9810.0_f64).exp() * 9810.0 * H;
            for (cell, first) in first.iter().enumerate() {
                let expected = [falls, 0.0, -falls][cell / CELLS[0]];
                let found = water.content[cell] - first;
                assert!((found - expected).abs() < 1e-8 * falls, "cell {cell}: {found:e}, expected {expected:e}");
            }
        }
    }

    #[test]
    fn soil_that_opens_draws_no_water_in_through_a_seepage_face() {
        for implicit in [true, false] {
            let (grid, mut water, mut squeeze, soil) = full(1e-9);
            let around = Surroundings {
                open: [true; 4],
                feeds: [None; 4],
                heads: NO_HEADS,
                periodic: false,
                standing: Vec::new(),
            };
            water.surround(&grid, &around);
            let inverse = vec![[0.0; 2]; grid.node_count()];
            let leader: Vec<u32> = (0..grid.node_count() as u32).collect();
            let pushed = Pushed { grid: &grid, inverse: &inverse, leader: &leader };
            let step = MovingStep { dt: 1e-3, implicit, bulk_modulus: KW, smoothing: 0.0 };
            let mut lowest: f64 = 0.0;
            for _ in 0..20 {
                // All nodes move apart.
                let mut motion = Motion::at_rest(grid.node_count());
                for node in 0..grid.node_count() {
                    let place = [node % (CELLS[0] + 1), node / (CELLS[0] + 1)];
                    (0..2).for_each(|d| motion.velocity[d][node] = 1e-2 * place[d] as f64);
                }
                squeeze.press(&mut water, &soil, &pushed, &mut motion, &step).unwrap();
                lowest = water.pressure.iter().fold(lowest, |low, p| low.min(*p));
                assert_eq!((water.inflow, water.rates[0]), (0.0, 0.0), "implicit: {implicit}");
            }
            assert!(lowest < 0.0, "suction was to be tried: {lowest} Pa");
        }
    }

    #[test]
    fn smoothing_moves_water_and_makes_none() {
        let (grid, mut water, mut squeeze, soil) = full(1e-14);
        // Soil that cannot move: nothing but the exchange acts on pressures.
        let inverse = vec![[0.0; 2]; grid.node_count()];
        let leader: Vec<u32> = (0..grid.node_count() as u32).collect();
        let pushed = Pushed { grid: &grid, inverse: &inverse, leader: &leader };
        let still = |smoothing: f64, water: &mut FreeSurface<2>, squeeze: &mut Squeeze<2>| {
            let mut motion = Motion::at_rest(grid.node_count());
            let step = MovingStep { dt: 1e-3, implicit: true, bulk_modulus: KW, smoothing };
            squeeze.press(water, &soil, &pushed, &mut motion, &step).unwrap();
        };
        // Pressures at rest stay, whatever they are: smoothing acts on their change.
        let first = water.pressure.clone();
        still(1e-6, &mut water, &mut squeeze);
        for (now, was) in water.pressure.iter().zip(&first) {
            assert!((now - was).abs() < 1e-5 * 9810.0, "{now} {was}");
        }
        // A checkerboard of surplus: its pressures are evened out, and all water is still there.
        let uneven = |smoothing: f64| {
            let (_, mut water, mut squeeze, _) = full(1e-14);
            for cell in 0..12 {
                let black = (cell % 4 + cell / 4) % 2 == 0;
                let surplus = 1e-6 * returns(&water);
                squeeze.surplus[cell] = if black { surplus } else { -surplus };
            }
            let all =
                |water: &FreeSurface<2>, squeeze: &Squeeze<2>| water.stored() + squeeze.surplus.iter().sum::<f64>();
            let first = (all(&water, &squeeze), water.pressure.clone());
            still(smoothing, &mut water, &mut squeeze);
            assert!((all(&water, &squeeze) - first.0).abs() < 1e-15, "{:e}", all(&water, &squeeze) - first.0);
            let rise: Vec<f64> = water.pressure.iter().zip(&first.1).map(|(a, b)| a - b).collect();
            rise.iter().map(|x| x.abs()).sum::<f64>() / 12.0
        };
        let (without, with) = (uneven(0.0), uneven(1e-8));
        assert!(without > 1.0 && with < 0.5 * without, "{without} {with}");
    }
}

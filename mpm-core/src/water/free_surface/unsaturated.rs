//! Flow where soil may be unsaturated: Richards' equation `d(n S)/dt + div q = 0`, `q = -k k_r/gamma_w (grad p - rho_w g)`, with p at the
//! centres of the cells, k_r of a face its mean over the pressures between two cells, and the content of a cell what has flowed into it.
//!
//! A step is the L-stable method of two stages, second order in time (Alexander 1977, doi:10.1137/0714068):
//!
//! ```text
//! W_1 = W_0 + a dt F(p_1),   W_2 = W_0 + (1 - a) dt F(p_1) + a dt F(p_2),   a = 1 - 1/sqrt(2),   W_i = pores S_e(p_i)
//! ```
//!
//! each of them by Newton's method. A cell that gets wetter takes its correction as one of its content where it is far from full: in dry
//! soil a pressure says little (as a switch of the primary variable does; Forsyth et al. 1995, doi:10.1016/0309-1708(95)00020-J).
//! What is left of a residual is in the content and so in the next step, and no water is made or lost.

use super::edges::{Edge, Outside, Rained};
use super::flow::{Linear, Medium, TIE};
use super::{FreeSurface, Link, NoFlow};
use crate::sparse::{Factor, Ordering, Signs, Sparse, Unsolved};
use crate::water::retention::{Moist, Retention};

/// a of the method.
const A: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// What a step may be off by, in shares of the pores of a cell: the difference from a first-order method.
const TOLERANCE: f64 = 1e-4;
/// Residual of a stage, in shares of the pores.
const RESIDUAL: f64 = 1e-10;
/// A content that differs by less from that of a known pressure says nothing new, in shares of the pores.
const KNOWN: f64 = 1e-7;
/// Iterations of a stage.
const ITERATIONS: usize = 30;
/// Saturation from which on a correction is one of the pressure.
const NEARLY_FULL: f64 = 0.9;
/// Steps that had to be cut to this share of what was asked are iterated with smaller corrections.
const SLOW: f64 = 1e-2;
/// How much an iteration may dry a cell, in shares of its pores.
const DRIES: f64 = 0.2;

/// Room for a step.
#[derive(Debug, Default)]
pub struct Unsaturated {
    /// The system of a stage: none before the first, and where the links have changed.
    system: Option<(Sparse, Factor)>,
    /// Residuals, m3/s, and corrections, Pa.
    residual: Vec<f64>,
    correction: Vec<f64>,
    pub(super) moist: Vec<Moist>,
    /// Content from which a stage starts, m3.
    base: Vec<f64>,
    /// Flow through links, and out through edges, in both stages, m3/s.
    through: [Vec<f64>; 2],
    out: [Vec<f64>; 2],
    /// Rain on each edge through which water may come out, m3/s.
    rain: Vec<f64>,
}

/// A flow and its derivatives by the pressures on both sides, m3/(s Pa).
#[derive(Debug, Clone, Copy, Default)]
struct Flow {
    flow: f64,
    low: f64,
    high: f64,
}

impl<const D: usize> Medium<D> {
    /// Height of the centre of a cell above the middle of its soil, as a pressure, Pa; `soil` is the share of it that is soil.
    #[inline]
    pub(super) fn above_middle(&self, soil: f64) -> f64 {
        0.5 * self.rise() * self.size * (1.0 - soil)
    }

    /// State of the pores of a cell.
    #[inline]
    pub fn moist(&self, law: &Retention, pressure: f64, soil: f64) -> Moist {
        law.at(pressure + self.above_middle(soil), self.unit_weight)
    }

    /// Pressure at the centre of a cell of which so much is wet, Pa.
    pub fn suction(&self, law: &Retention, wet: f64, soil: f64) -> f64 {
        law.pressure(wet, self.unit_weight) - self.above_middle(soil)
    }

    /// What the soil of a cell feels (Bishop's stress with chi = S_e): `S_e p`, Pa.
    pub fn bishop(&self, law: &Retention, pressure: f64, soil: f64) -> f64 {
        let pressure = pressure + self.above_middle(soil);
        law.at(pressure, self.unit_weight).wet * pressure
    }

    /// Mean of k_r over the pressures between two states (Simpson's rule), and its derivatives by both, 1/Pa: with it a flow without
    /// gravity is that of Kirchhoff's potential.
    fn mean(&self, law: &Retention, [a, b]: [&Moist; 2]) -> [f64; 3] {
        if a.pressure >= 0.0 && b.pressure >= 0.0 {
            return [1.0, 0.0, 0.0];
        }
        let middle = law.at(0.5 * (a.pressure + b.pressure), self.unit_weight);
        [
            (a.conducts + 4.0 * middle.conducts + b.conducts) / 6.0,
            (a.conducts_more + 2.0 * middle.conducts_more) / 6.0,
            (2.0 * middle.conducts_more + b.conducts_more) / 6.0,
        ]
    }

    /// Through a link, upwards along its axis.
    fn darcy(&self, law: &Retention, link: &Link, [low, high]: [f64; 2], moist: [&Moist; 2]) -> Flow {
        let t = self.conductance * link.ratio * link.open;
        let drive = low - high + self.weight[link.axis as usize] * self.size;
        let [mean, by_low, by_high] = self.mean(law, moist);
        Flow { flow: t * mean * drive, low: t * (mean + by_low * drive), high: -t * (mean - by_high * drive) }
    }

    /// Out through an edge of a cell, on which rain falls (m3/s) that does not enter where the soil takes no more.
    fn seeps(&self, law: &Retention, edge: &Edge, pressure: f64, moist: &Moist, rain: f64) -> Flow {
        let axis = edge.axis as usize;
        let t = self.conductance * edge.ratio * edge.open / edge.distance;
        let outwards = if edge.upper { 1.0 } else { -1.0 };
        let upright = axis == D - 1 && self.rise() > 0.0;
        // What gravity adds on the way out, and where along a side the outside lies above the centre.
        let along = outwards * self.weight[axis] * self.size * edge.distance;
        let above = if upright { 0.0 } else { self.rise() * self.size * (edge.from + 0.5 * edge.open - 0.5) };
        let (outside, seepage) = match edge.outside {
            Outside::Inflow(flow) => return Flow { flow: -flow, ..Flow::default() },
            Outside::Air => (above, true),
            // Its pressure is that at the bottom of a face to the side.
            Outside::Pond(pressure) if upright => (pressure, false),
            Outside::Pond(pressure) => (pressure - 0.5 * self.rise() * self.size, false),
        };
        let beyond = if seepage { Moist::FULL } else { law.at(outside, self.unit_weight) };
        let drive = pressure - outside + along;
        let [mean, more, _] = self.mean(law, [moist, &beyond]);
        let flow = rain + t * mean * drive;
        if seepage && flow <= 0.0 {
            return Flow::default();
        }
        Flow { flow, low: t * (mean + more * drive), high: 0.0 }
    }

    /// The same as flows that are linear in the pressures of cells whose pressure is an unknown of moving soil.
    pub(super) fn linear(
        &self,
        law: &Retention,
        link: &Link,
        pressure: [f64; 2],
        moist: [&Moist; 2],
        unknown: [bool; 2],
    ) -> Linear {
        let found = self.darcy(law, link, pressure, moist);
        let [low, high] = [if unknown[0] { found.low } else { 0.0 }, if unknown[1] { -found.high } else { 0.0 }];
        Linear { low, high, fixed: found.flow - low * pressure[0] + high * pressure[1] }
    }
}

impl Unsaturated {
    /// Room for so many cells.
    pub fn new(cells: usize) -> Self {
        let zeros = || vec![0.0; cells];
        let moist = vec![Moist::FULL; cells];
        Self { residual: zeros(), correction: zeros(), base: zeros(), moist, ..Self::default() }
    }

    /// Makes the system that of other links.
    ///
    /// # Errors
    /// Out of memory.
    pub(super) fn link(&mut self, links: &[Link]) -> Result<(), Unsolved> {
        let pairs = links.iter().map(|link| (link.low as usize, link.high as usize));
        let matrix = Sparse::general(self.moist.len(), pairs);
        let factor = Factor::new(&matrix, Signs::Unknown, Ordering::MinimumDegree)?;
        self.system = Some((matrix, factor));
        self.through = [vec![0.0; links.len()], vec![0.0; links.len()]];
        Ok(())
    }

    /// Takes note of where rain falls.
    pub(super) fn surround(&mut self, edges: &[Edge], rained: &[Rained]) {
        for out in &mut self.out {
            out.clear();
            out.resize(edges.len(), 0.0);
        }
        self.rain.clear();
        self.rain.resize(edges.len(), 0.0);
        for rained in rained {
            if let Outside::Inflow(flow) = edges[rained.way_in as usize].outside {
                self.rain[rained.way_out as usize] += flow;
            }
        }
    }

    /// The flow out through an edge of moving soil, linear in the pressure of its cell if that is an unknown.
    pub(super) fn leak<const D: usize>(
        &self,
        medium: &Medium<D>,
        law: &Retention,
        (number, edge): (usize, &Edge),
        pressure: f64,
        unknown: bool,
    ) -> Linear {
        let found = medium.seeps(law, edge, pressure, &self.moist[edge.cell as usize], self.rain[number]);
        let low = if unknown { found.low } else { 0.0 };
        Linear { low, high: 0.0, fixed: found.flow - low * pressure }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.system.as_ref().map_or(0, |(matrix, factor)| matrix.bytes() + factor.bytes())
    }
}

impl<const D: usize> FreeSurface<D> {
    /// Pressures of cells that are not full, from what they hold: soil that has moved has brought other water.
    pub(super) fn suctions(&mut self, law: &Retention) {
        for cell in 0..self.kind.len() {
            if self.soil.is_soil(cell) && !self.full[cell] {
                let (wet, soil) = (self.wet_share(cell).clamp(0.0, 1.0), self.soil.share[cell]);
                // Within round-off of what is known: all pressures up to the entry of air hold the same.
                if (self.medium.moist(law, self.pressure[cell], soil).wet - wet).abs() > KNOWN {
                    self.pressure[cell] = self.medium.suction(law, wet, soil);
                }
            }
        }
    }

    /// One stage, from `room.base`, over a time of `tau` (s); pressures in `system.pressure`. False if it was not found.
    fn stage(&mut self, room: &mut Unsaturated, law: &Retention, tau: f64, (stage, slow): (usize, bool)) -> bool {
        let cells = self.kind.len();
        let scale = self.medium.conductance;
        let p = &mut self.system.pressure;
        let Some((matrix, factor)) = &mut room.system else { return false };
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            for cell in 0..cells {
                if self.soil.is_soil(cell) {
                    room.moist[cell] = self.medium.moist(law, p[cell], self.soil.share[cell]);
                }
            }
            matrix.values.fill(0.0);
            for cell in 0..cells {
                if !self.soil.is_soil(cell) {
                    matrix.add(cell, cell, scale);
                    room.residual[cell] = 0.0;
                    continue;
                }
                let (moist, pores) = (&room.moist[cell], self.soil.pores[cell]);
                let tie = if moist.capacity == 0.0 { TIE * scale } else { 0.0 };
                room.residual[cell] =
                    (pores * moist.wet - room.base[cell]) / tau + tie * (p[cell] - self.pressure[cell]);
                matrix.add(cell, cell, pores * moist.capacity / tau + tie);
            }
            for (link, kept) in self.links.iter().zip(&mut room.through[stage]) {
                let (a, b) = (link.low as usize, link.high as usize);
                let found = self.medium.darcy(law, link, [p[a], p[b]], [&room.moist[a], &room.moist[b]]);
                *kept = found.flow;
                room.residual[a] += found.flow;
                room.residual[b] -= found.flow;
                matrix.add(a, a, found.low);
                matrix.add(a, b, found.high);
                matrix.add(b, b, -found.high);
                matrix.add(b, a, -found.low);
            }
            for (i, edge) in self.edges.iter().enumerate() {
                let cell = edge.cell as usize;
                let found = self.medium.seeps(law, edge, p[cell], &room.moist[cell], room.rain[i]);
                room.out[stage][i] = found.flow;
                room.residual[cell] += found.flow;
                matrix.add(cell, cell, found.low);
            }
            let mut worst: f64 = 0.0;
            for cell in 0..cells {
                if self.soil.is_soil(cell) {
                    worst = worst.max(room.residual[cell].abs() * tau / self.soil.pores[cell]);
                }
            }
            if worst <= RESIDUAL {
                return true;
            }
            // Newton's method gains or is lost.
            if !worst.is_finite() || worst > 1e3 * last.max(1.0) {
                return false;
            }
            last = last.min(worst);
            room.residual.iter_mut().for_each(|r| *r = -*r);
            let solved = factor.refresh(matrix);
            if solved.and_then(|()| factor.solve(matrix, &room.residual, &mut room.correction)).is_err() {
                return false;
            }
            for cell in 0..cells {
                if !self.soil.is_soil(cell) {
                    continue;
                }
                let (moist, change) = (&room.moist[cell], room.correction[cell]);
                let (wet, soil) = (moist.wet, self.soil.share[cell]);
                p[cell] = if change > 0.0 && wet < NEARLY_FULL && p[cell] < 0.0 {
                    let wetter = wet + moist.capacity * change;
                    let most = if slow { 0.5 * (1.0 + wet) } else { 1.0 };
                    self.medium.suction(law, wetter.min(most), soil)
                } else if slow && change < 0.0 {
                    // No further into dry soil than content says something: a full cell knows nothing of it.
                    let drier = f64::max(wet - DRIES, 0.3 * wet);
                    (p[cell] + change).max(self.medium.suction(law, drier, soil))
                } else {
                    p[cell] + change
                };
            }
        }
        false
    }

    /// Tries a step of `dt` (s): what it is off by, in shares of the pores; `None` if it was not found.
    fn try_unsaturated(&mut self, room: &mut Unsaturated, law: &Retention, dt: f64, slow: bool) -> Option<f64> {
        self.system.pressure.copy_from_slice(&self.pressure);
        room.base.copy_from_slice(&self.content);
        if !self.stage(room, law, A * dt, (0, slow)) {
            return None;
        }
        self.gain(&mut room.base, (1.0 - A) * dt, &room.through[0], &room.out[0]);
        if !self.stage(room, law, A * dt, (1, slow)) {
            return None;
        }
        // Weights (1 - a, a) beside (1/2, 1/2).
        room.residual.fill(0.0);
        self.gain(&mut room.residual, (0.5 - A) * dt, &room.through[0], &room.out[0]);
        self.gain(&mut room.residual, (A - 0.5) * dt, &room.through[1], &room.out[1]);
        let soil = (0..self.kind.len()).filter(|cell| self.soil.is_soil(*cell));
        Some(soil.fold(0.0, |most: f64, cell| most.max(room.residual[cell].abs() / self.pores(cell))))
    }

    /// Adds to contents (m3) what flows in a time, s.
    fn gain(&self, content: &mut [f64], time: f64, through: &[f64], out: &[f64]) {
        for (link, flow) in self.links.iter().zip(through) {
            content[link.low as usize] -= time * flow;
            content[link.high as usize] += time * flow;
        }
        for (edge, flow) in self.edges.iter().zip(out) {
            content[edge.cell as usize] -= time * flow;
        }
    }

    /// Makes a step of at most `dt` (s). Returns its length and the length to try next, s.
    pub(super) fn step_unsaturated(
        &mut self,
        room: &mut Unsaturated,
        law: &Retention,
        dt: f64,
    ) -> Result<(f64, f64), NoFlow> {
        self.suctions(law);
        let mut step = dt;
        loop {
            let off = self.try_unsaturated(room, law, step, step < SLOW * dt);
            let factor = off.map_or(0.25, |off| (0.8 * (TOLERANCE / off.max(1e-300)).sqrt()).clamp(0.2, 2.0));
            if off.is_some_and(|off| off <= 2.0 * TOLERANCE) {
                self.accept_unsaturated(room, step);
                return Ok((step, step * factor));
            }
            step *= factor.min(0.7);
            if step < 1e-12 * dt {
                return Err(NoFlow::TooShort(step));
            }
        }
    }

    fn accept_unsaturated(&mut self, room: &mut Unsaturated, dt: f64) {
        for flux in &mut self.flux {
            flux.fill(0.0);
        }
        let [first, second] = &mut room.through;
        for ((link, first), second) in self.links.iter().zip(first).zip(second) {
            *first = (1.0 - A) * *first + A * *second;
            self.flux[link.axis as usize][link.face as usize] = *first;
        }
        let [first, second] = &mut room.out;
        for (first, second) in first.iter_mut().zip(second) {
            *first = (1.0 - A) * *first + A * *second;
        }
        self.left.copy_from_slice(&room.out[0]);
        self.trial.copy_from_slice(&self.content);
        let mut content = std::mem::take(&mut self.trial);
        self.gain(&mut content, dt, &room.through[0], &room.out[0]);
        self.trial = std::mem::replace(&mut self.content, content);
        self.pressure.copy_from_slice(&self.system.pressure);
        self.note_full();
        self.count(dt);
    }

    /// Which cells are full.
    pub(super) fn note_full(&mut self) {
        for cell in 0..self.kind.len() {
            let soil = self.soil.is_soil(cell);
            self.full[cell] = soil && self.pressure[cell] + self.medium.above_middle(self.soil.share[cell]) >= 0.0;
        }
        self.classify();
    }
}

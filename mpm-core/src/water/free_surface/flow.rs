//! One implicit step of the flow: which cells are full, their pressures, and what goes through every face.
//!
//! Unknown is the pressure p at the centre of a cell. Below it stands at the bottom of the cell P = p + G h/2, with G the weight
//! of water along the vertical axis per volume (Pa/m) and h the edge of a cell, and in still water the level is P/G above the bottom.
//! So one law covers full and partly wet cells: a cell whose soil is a share phi of it holds the share
//! `S = P/(G h phi)` of its pores up to S = 1, and from there on p is free and the volume is not.
//!
//! | kind | where | content | pressure |
//! |---|---|---|---|
//! | full | | all pores | unknown, not below what its level needs |
//! | standing | water stands on a full cell or an impermeable base | S(p) | unknown |
//! | hanging | below a full cell: a front that comes down | follows from its inflow | 0; lets nothing through |
//! | loose | elsewhere | follows from its flow | 0; water falls at k |
//!
//! That is Darcy flow with p >= 0, S <= 1 and p (1 - S) = 0 (Alt 1979; Brezis, Kinderlehrer & Stampacchia 1978) with a level inside the
//! cells. Between cells of a row the flow is that of the wet part of their face: k/gamma_w times the integral of the
//! pressure difference over the height. In a rectangular dam these integrals fall linearly from face to face, so that the discharge is
//! Charny's, k (H1^2 - H2^2)/(2 l), on any mesh.

use super::edges::Edge;
use super::soil::SoilMap;
use crate::sparse::{Factor, Ordering, Signs, Sparse, Unsolved};
use crate::water::retention::Retention;

/// What a cell is in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// No soil.
    Void,
    /// Pores full.
    Full,
    /// Water with a level.
    Standing,
    /// Filled from above.
    Hanging,
    /// Neither: water that runs through, or is held by suction where the soil has a retention.
    Loose,
}

impl Kind {
    /// Whether the pressure is an unknown.
    pub fn unknown(self) -> bool {
        matches!(self, Self::Full | Self::Standing)
    }
}

/// A face between two cells of soil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// The cell on its lower side.
    pub low: u32,
    /// The cell on its upper side.
    pub high: u32,
    /// The face, numbered by [`crate::grid::Grid::face`].
    pub face: u32,
    /// Axis that the face is normal to.
    pub axis: u8,
    /// Share of the face that is soil on both sides.
    pub open: f64,
    /// Its conductivity over that of the medium.
    pub ratio: f64,
}

/// Constants of the flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium<const D: usize> {
    /// Flow per pressure drop through a whole face of the soil that conducts best, (k/gamma_w) A/h, m3/(s Pa).
    pub conductance: f64,
    /// Edge of a cell h, m.
    pub size: f64,
    /// Volume of a cell, m3.
    pub cell_volume: f64,
    /// Weight of water per volume, rho_w g, along each axis, Pa/m.
    pub weight: [f64; D],
    /// Unit weight of water gamma_w, N/m3: what a head is a pressure by where there is no gravity.
    pub unit_weight: f64,
    /// Porosity that the water can fill at t = 0, n (1 - S_0).
    pub porosity: f64,
    /// Retention of unsaturated soil; without it soil is full or empty (a sharp front).
    pub retention: Option<Retention>,
}

impl<const D: usize> Medium<D> {
    /// G: weight of water along the vertical axis, downwards, Pa/m.
    #[inline]
    pub fn rise(&self) -> f64 {
        (-self.weight[D - 1]).max(0.0)
    }

    /// Time in which water that falls under a `weight` (Pa/m) passes half a cell, s.
    #[inline]
    pub fn fall(&self, weight: f64) -> f64 {
        0.5 * self.cell_volume * self.porosity / (self.conductance * weight * self.size)
    }

    /// Wet part of a face of which `open` is soil: integral of the pressure over its height divided by h, Pa, for a
    /// pressure at the bottom (Pa).
    #[inline]
    pub fn wet_integral(&self, bottom: f64, open: f64) -> f64 {
        let g = self.rise() * self.size;
        if bottom <= 0.0 {
            0.0
        } else if bottom >= g * open {
            open * (bottom - 0.5 * g * open)
        } else {
            0.5 * bottom * bottom / g
        }
    }

    /// Share of a face that is wet.
    #[inline]
    pub fn wet_share(&self, bottom: f64, open: f64) -> f64 {
        let g = self.rise() * self.size;
        if g * open <= bottom { open } else { (bottom / g).max(0.0) }
    }

    /// The secant of [`Self::wet_integral`] between two pressures at the bottom, so that the flow is linear in them.
    #[inline]
    pub fn secant(&self, a: f64, b: f64, open: f64) -> f64 {
        let difference = a - b;
        if difference.abs() > 1e-9 * (a.abs() + b.abs()) {
            (self.wet_integral(a, open) - self.wet_integral(b, open)) / difference
        } else {
            self.wet_share(0.5 * (a + b), open)
        }
    }

    /// Pressure at the centre of a standing cell that holds a share `wet` of its pores, Pa; `soil` is phi.
    #[inline]
    pub fn standing_pressure(&self, wet: f64, soil: f64) -> f64 {
        self.rise() * self.size * (soil * wet - 0.5)
    }
}

/// A flow that is linear in the pressures of its two cells: `low p_low - high p_high + fixed`, m3/s.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Linear {
    /// Factor of the pressure on the lower side, m3/(s Pa).
    pub low: f64,
    /// Factor of the pressure on the upper side, m3/(s Pa).
    pub high: f64,
    /// What does not depend on them, m3/s.
    pub fixed: f64,
}

impl Linear {
    /// The flow at two pressures, m3/s.
    #[inline]
    pub fn at(&self, low: f64, high: f64) -> f64 {
        self.low * low - self.high * high + self.fixed
    }
}

/// State that a flow is made from: kinds, pressures (Pa) and wet shares of all cells.
#[derive(Debug, Clone, Copy)]
pub struct Now<'a> {
    /// Kind of each cell.
    pub kind: &'a [Kind],
    /// Pressure at the centre, Pa; zero where it is no unknown.
    pub pressure: &'a [f64],
    /// Share of the pores that is wet, in the middle of the step.
    pub wet: &'a [f64],
}

impl<const D: usize> Medium<D> {
    /// The flow through a link, upwards along its axis.
    pub fn through(&self, link: &Link, now: Now) -> Linear {
        let up = link.axis as usize == D - 1 && self.rise() > 0.0;
        if up { self.upwards(link, now) } else { self.sideways(link, now) }
    }

    /// Through a horizontal face.
    fn upwards(&self, link: &Link, now: Now) -> Linear {
        let (low, high) = (link.low as usize, link.high as usize);
        let t = self.conductance * link.ratio * link.open;
        let weight = self.rise() * self.size;
        match (now.kind[low].unknown(), now.kind[high].unknown()) {
            // Water above a full cell that draws it down falls, no faster than k.
            (true, true) if now.kind[high] == Kind::Standing && now.pressure[low] < 0.5 * weight => {
                Linear { fixed: -t * weight * now.wet[high], ..Linear::default() }
            }
            (true, true) => Linear { low: t, high: t, fixed: -t * weight },
            // A front that comes down stands S below its upper edge: the pressure falls to zero there.
            (false, true) => Linear { low: 0.0, high: t / (now.wet[low] + 0.5), fixed: -t * weight },
            // Water between two full cells: pressed up by the lower one, or falling.
            (true, false) => {
                let falls = weight * now.wet[high];
                if now.pressure[low] - weight > -falls {
                    Linear { low: t, high: 0.0, fixed: -t * weight }
                } else {
                    Linear { fixed: -t * falls, ..Linear::default() }
                }
            }
            (false, false) if now.kind[high] == Kind::Loose => {
                Linear { fixed: -t * weight * now.wet[high], ..Linear::default() }
            }
            (false, false) => Linear::default(),
        }
    }

    /// Through a vertical face, or any without gravity.
    fn sideways(&self, link: &Link, now: Now) -> Linear {
        let (low, high) = (link.low as usize, link.high as usize);
        let half = 0.5 * self.rise() * self.size;
        let drive = self.weight[link.axis as usize] * self.size;
        let t = self.conductance * link.ratio;
        let bottom = |cell: usize| now.pressure[cell] + half;
        let wet = |cell: usize| {
            if !now.kind[cell].unknown() {
                now.wet[cell] * link.open
            } else if half > 0.0 {
                self.wet_share(bottom(cell), link.open)
            } else {
                link.open
            }
        };
        let body = t * drive * 0.5 * (wet(low) + wet(high));
        match (now.kind[low].unknown(), now.kind[high].unknown()) {
            (true, true) => {
                let share = if half > 0.0 { self.secant(bottom(low), bottom(high), link.open) } else { link.open };
                Linear { low: t * share, high: t * share, fixed: body }
            }
            (true, false) => {
                let share = self.towards(bottom(low), now.wet[high], link.open);
                Linear { low: t * share, high: 0.0, fixed: t * share * half + body }
            }
            (false, true) => {
                let share = self.towards(bottom(high), now.wet[low], link.open);
                Linear { low: 0.0, high: t * share, fixed: -t * share * half + body }
            }
            (false, false) => {
                let upstream = if drive > 0.0 { low } else { high };
                Linear { fixed: t * drive * wet(upstream), ..Linear::default() }
            }
        }
    }

    /// Share of a face through which a cell with a pressure at its bottom (Pa) presses into one that is wet to a share:
    /// the front stands half a cell and that share away.
    fn towards(&self, bottom: f64, wet: f64, open: f64) -> f64 {
        let share = if self.rise() > 0.0 { self.secant(bottom, 0.0, open) } else { open };
        share / (wet + 0.5)
    }
}

/// The system of a step.
#[derive(Debug)]
pub struct System {
    /// Its matrix, over all cells; cells without an unknown have a one on the diagonal.
    pub matrix: Sparse,
    /// Its factors.
    pub factor: Factor,
    /// Its right-hand side.
    pub load: Vec<f64>,
    /// Its solution: pressures, Pa.
    pub pressure: Vec<f64>,
}

/// Share of the conductance that ties a full cell to its last pressure. Full cells that no path joins to the outside would have
/// any pressure; what it costs in volume the next step makes good.
pub(super) const TIE: f64 = 1e-9;

/// What a step is to be made of.
pub struct Terms<'a, const D: usize> {
    /// Constants.
    pub medium: &'a Medium<D>,
    /// Faces between cells of soil.
    pub links: &'a [Link],
    /// Their flows.
    pub flows: &'a [Linear],
    /// Faces to the outside.
    pub edges: &'a [Edge],
    /// Their flows out of the soil; [`Linear::high`] is not used.
    pub leaks: &'a [Linear],
    /// Kinds of the cells.
    pub kind: &'a [Kind],
    /// The soil.
    pub soil: &'a SoilMap<D>,
    /// Water in each cell at the start of the step, m3.
    pub content: &'a [f64],
    /// Length of the step, s.
    pub dt: f64,
}

impl System {
    /// A system over so many cells that are joined by links.
    ///
    /// # Errors
    /// Out of memory.
    pub fn new(cells: usize, links: &[Link]) -> Result<Self, Unsolved> {
        let matrix = Sparse::symmetric(cells, links.iter().map(|link| (link.low as usize, link.high as usize)));
        let factor = Factor::new(&matrix, Signs::Definite, Ordering::MinimumDegree)?;
        Ok(Self { matrix, factor, load: vec![0.0; cells], pressure: vec![0.0; cells] })
    }

    /// Pressures at the end of a step, in [`System::pressure`], which holds the last ones before; zero where there is no unknown.
    ///
    /// # Errors
    /// The system could not be solved.
    pub fn solve<const D: usize>(&mut self, terms: &Terms<D>) -> Result<(), Unsolved> {
        let Terms { medium, links, flows, edges, leaks, kind, soil, content, dt } = *terms;
        self.matrix.values.fill(0.0);
        self.load.fill(0.0);
        let scale = medium.conductance;
        for (link, flow) in links.iter().zip(flows) {
            let (a, b) = (link.low as usize, link.high as usize);
            if kind[a].unknown() {
                self.matrix.add(a, a, flow.low);
                self.load[a] -= flow.fixed;
            }
            if kind[b].unknown() {
                self.matrix.add(b, b, flow.high);
                self.load[b] += flow.fixed;
            }
            if kind[a].unknown() && kind[b].unknown() {
                self.matrix.add(a, b, -flow.low);
            }
        }
        for (edge, leak) in edges.iter().zip(leaks) {
            let cell = edge.cell as usize;
            if kind[cell].unknown() {
                self.matrix.add(cell, cell, leak.low);
                self.load[cell] -= leak.fixed;
            }
        }
        for cell in 0..kind.len() {
            let pores = soil.pores[cell];
            match kind[cell] {
                Kind::Full => {
                    self.matrix.add(cell, cell, TIE * scale);
                    self.load[cell] += (content[cell] - pores) / dt + TIE * scale * self.pressure[cell];
                }
                Kind::Standing => {
                    // dW/dt with W = pores S(p), S = (p/(G h) + 1/2)/phi
                    let per_pressure = pores / (medium.rise() * medium.size * soil.share[cell]) / dt;
                    self.matrix.add(cell, cell, per_pressure);
                    self.load[cell] += content[cell] / dt - per_pressure * 0.5 * medium.rise() * medium.size;
                }
                _ => self.matrix.add(cell, cell, scale),
            }
        }
        self.factor.refresh(&self.matrix)?;
        self.factor.solve(&self.matrix, &self.load, &mut self.pressure)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEDIUM: Medium<2> = Medium {
        conductance: 2.0,
        size: 0.5,
        cell_volume: 0.25,
        weight: [0.0, -10.0],
        unit_weight: 10.0,
        porosity: 0.3,
        retention: None,
    };

    #[test]
    fn the_wet_integral_is_that_of_a_triangle_or_a_trapezium() {
        // 0.2 m of water in a face of 0.5 m: G h^2/2 over h.
        assert!((MEDIUM.wet_integral(2.0, 1.0) - 0.5 * 10.0 * 0.2 * 0.2 / 0.5).abs() < 1e-15);
        assert!((MEDIUM.wet_integral(8.0, 1.0) - (8.0 - 2.5)).abs() < 1e-15);
        assert!((MEDIUM.wet_integral(8.0, 0.5) - 0.5 * (8.0 - 1.25)).abs() < 1e-15);
        assert_eq!(MEDIUM.wet_integral(-1.0, 1.0), 0.0);
        let (a, b) = (7.0, 3.0);
        let secant = MEDIUM.secant(a, b, 1.0);
        assert!((secant * (a - b) - MEDIUM.wet_integral(a, 1.0) + MEDIUM.wet_integral(b, 1.0)).abs() < 1e-14);
        assert!((MEDIUM.secant(3.0, 3.0, 1.0) - 0.6).abs() < 1e-9);
    }

    #[test]
    fn still_water_does_not_flow() {
        let link = |axis| Link { low: 0, high: 1, face: 0, axis, open: 1.0, ratio: 1.0 };
        let kind = [Kind::Full, Kind::Standing];
        // A level 0.3 m above the upper edge of the lower cell.
        let pressure = [10.0 * 0.55, MEDIUM.standing_pressure(0.6, 1.0)];
        let now = Now { kind: &kind, pressure: &pressure, wet: &[1.0, 0.6] };
        let flow = MEDIUM.through(&link(1), now).at(pressure[0], pressure[1]);
        assert!(flow.abs() < 1e-14, "{flow}");
        // Two cells side by side with the same level.
        let beside = [pressure[1]; 2];
        let now = Now { kind: &[Kind::Standing; 2], pressure: &beside, wet: &[0.6; 2] };
        assert!(MEDIUM.through(&link(0), now).at(beside[0], beside[1]).abs() < 1e-14);
    }
}

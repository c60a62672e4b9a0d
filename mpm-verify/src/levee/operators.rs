//! The paper's Darcy operator beside the default one, on the levee's own full cells: what each makes of a point source.
//!
//! The run moves water through the faces of cells. Here the same steady problem, `div q = s` with `q = -(k/gamma_w) grad H`
//! and the total head in Pa, `H = p + gamma_w y`, is solved twice on the full cells of a frame:
//!
//! | operator | energy of a head |
//! |---|---|
//! | face | `1/2 sum over faces of (H_a - H_b)^2` |
//! | nodal | `1/2 sum over nodes and axes of (sum V G H)^2 / sum V N`, the paper's Eq. (1) put into its Eq. (5): `B^T M^-1 B` |
//!
//! Assumptions: no inertia and no storage; soil that fills its cells; the head is known, from the frame, in the cells of
//! the rim: those beside the tank and those of which one of the eight neighbours is not full. So every node of an unknown cell
//! has all its cells, both operators reproduce a linear head, and what differs is the operator and not its edge. Nothing
//! flows through the base; along it the nodal velocity is free, as in the paper.
//!
//! Inside, the nodal energy of four cells around a node is `1/4 ((a - d)^2 + (b - c)^2)`: a cell is tied to its diagonal
//! neighbours alone. Only a tight wall ties the two colours to each other.

use mpm_core::observe::Frame;
use mpm_core::scene::Scene;
use mpm_core::sparse::{Factor, Ordering, Signs, Sparse};
use nalgebra::{Cholesky, DMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};

use super::run::Followed;
use crate::frames::Shot;

/// A cell with less soil, or pores with less water, is not full.
const FULL: f64 = 0.999;
/// What the source adds to the pressure of its own cell under the face operator, Pa.
pub const LIFT: f64 = 1000.0;
/// A mode is a checkerboard mode if the nodal operator resists it by less than this share of what the face operator does.
pub const WEAK: f64 = 0.1;
/// Modes of more cells are not counted: the work grows with the third power.
const MOST: usize = 400;
/// Into how many cells along each side those of the run are split, to see what a finer mesh does.
const SPLITS: [usize; 2] = [2, 4];

/// How Darcy's law couples cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operator {
    /// Two-point flux on faces, the default.
    Face,
    /// The paper's velocities at the nodes.
    Nodal,
}

/// Both, in the order of all pairs of numbers here.
pub const BOTH: [Operator; 2] = [Operator::Face, Operator::Nodal];

/// Full cells of a mesh, and those of them whose head is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Cells of the mesh along x and y.
    pub cells: [usize; 2],
    /// Which are full.
    pub full: Vec<bool>,
    /// Which have a given head.
    pub known: Vec<bool>,
    /// Whether water moves along tight walls, as in the paper; else their nodes are at rest.
    pub slips: bool,
    /// Number of each cell among the unknown ones.
    number: Vec<Option<usize>>,
    /// The unknown cells.
    unknown: Vec<usize>,
}

/// A sum over cells whose square times a weight is a part of the energy.
struct Bond {
    cells: Vec<(usize, f64)>,
    weight: f64,
}

impl Region {
    /// Full cells with a known head where a neighbour, also across a corner, is not full, and at the left side if it is fed.
    pub fn new(cells: [usize; 2], full: Vec<bool>, fed: bool) -> Self {
        let [across, up] = cells;
        let is_full = |i: usize, j: usize| full[j * across + i];
        let rim = |cell: usize| {
            let (i, j) = (cell % across, cell / across);
            let around = |k: usize, end: usize| k.saturating_sub(1)..(k + 2).min(end);
            fed && i == 0 || around(j, up).any(|b| around(i, across).any(|a| !is_full(a, b)))
        };
        let known: Vec<bool> = (0..across * up).map(|cell| full[cell] && rim(cell)).collect();
        let unknown: Vec<usize> = (0..across * up).filter(|cell| full[*cell] && !known[*cell]).collect();
        let mut number = vec![None; across * up];
        for (place, cell) in unknown.iter().enumerate() {
            number[*cell] = Some(place);
        }
        Self { cells, full, known, slips: true, number, unknown }
    }

    /// That of a frame, its left side fed.
    pub fn of(frame: &Frame) -> Self {
        Self::new(frame.cells, frame.cell.iter().map(|c| c.soil > FULL && c.saturation > FULL).collect(), true)
    }

    /// The same outline with every cell split into `n` by `n`.
    pub fn split(&self, n: usize, fed: bool) -> Self {
        let cells = self.cells.map(|k| n * k);
        let full = |cell: usize| self.full[cell / cells[0] / n * self.cells[0] + cell % cells[0] / n];
        Self::new(cells, (0..cells[0] * cells[1]).map(full).collect(), fed)
    }

    /// What a source in the innermost cell adds under both operators, Pa: [`LIFT`] there under the face operator.
    fn responses(&self) -> Option<(usize, [Vec<f64>; 2])> {
        let source = self.innermost()?;
        let nothing = vec![0.0; self.full.len()];
        let one = self.solve(Operator::Face, &nothing, Some((source, 1.0)))?[source];
        let response = |operator| self.solve(operator, &nothing, Some((source, LIFT / one)));
        Some((source, [response(Operator::Face)?, response(Operator::Nodal)?]))
    }

    /// How many modes the nodal operator hardly resists, and the least resistance of all.
    fn weak(&self) -> (Option<usize>, Option<f64>) {
        let all = self.resistances();
        let count = all.as_ref().map(|all| all.iter().filter(|r| **r < WEAK).count());
        (count, all.and_then(|all| all.first().copied()))
    }

    /// The full cells.
    pub fn all(&self) -> impl Iterator<Item = usize> {
        (0..self.full.len()).filter(|cell| self.full[*cell])
    }

    /// Cells without a given head.
    pub fn unknown(&self) -> usize {
        self.unknown.len()
    }

    /// Middle of a cell, in cells.
    pub fn middle(&self, cell: usize) -> [f64; 2] {
        [cell % self.cells[0], cell / self.cells[0]].map(|k| k as f64 + 0.5)
    }

    /// What an operator is made of.
    fn bonds(&self, operator: Operator) -> Vec<Bond> {
        let [across, up] = self.cells;
        let mut bonds = Vec::new();
        if operator == Operator::Face {
            for a in self.all() {
                let right = (a % across + 1 < across).then_some(a + 1);
                let above = (a / across + 1 < up).then_some(a + across);
                for b in [right, above].into_iter().flatten().filter(|b| self.full[*b]) {
                    bonds.push(Bond { cells: vec![(a, -1.0), (b, 1.0)], weight: 1.0 });
                }
            }
            return bonds;
        }
        for j in 0..=up {
            for i in 0..=across {
                let wall = [i == 0 || i == across, j == 0 || j == up];
                let corners: Vec<(usize, [f64; 2])> = (0..4)
                    .filter_map(|k| {
                        let (a, b) = ((i + (k & 1)).checked_sub(1)?, (j + (k >> 1)).checked_sub(1)?);
                        let there = a < across && b < up && self.full[b * across + a];
                        let side = |bit: usize| if bit == 1 { 0.5 } else { -0.5 };
                        there.then_some((b * across + a, [side(k & 1), side(k >> 1)]))
                    })
                    .collect();
                for axis in 0..2 {
                    // Nothing flows through a wall, and along it only if it slips there.
                    let held = wall[axis] || wall[1 - axis] && !self.slips;
                    if !held && !corners.is_empty() {
                        let cells = corners.iter().map(|(cell, side)| (*cell, side[axis])).collect();
                        // Lumped: a quarter of each cell.
                        bonds.push(Bond { cells, weight: 4.0 / corners.len() as f64 });
                    }
                }
            }
        }
        bonds
    }

    /// Outflow of every unknown cell per head at all cells, in units of k/gamma_w.
    fn outflow(&self, operator: Operator, head: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.unknown.len()];
        for bond in self.bonds(operator) {
            let sum: f64 = bond.cells.iter().map(|(cell, c)| c * head[*cell]).sum();
            for (cell, c) in &bond.cells {
                if let Some(place) = self.number[*cell] {
                    out[place] += bond.weight * c * sum;
                }
            }
        }
        out
    }

    /// Pairs of unknown cells that are coupled, with their coefficients; one triangle.
    fn entries(&self, operator: Operator) -> Vec<(usize, usize, f64)> {
        let mut entries = Vec::new();
        for bond in self.bonds(operator) {
            let own = |(cell, c): &(usize, f64)| Some((self.number[*cell]?, *c));
            let own: Vec<(usize, f64)> = bond.cells.iter().filter_map(own).collect();
            for (k, (a, ca)) in own.iter().enumerate() {
                entries.extend(own[..=k].iter().map(|(b, cb)| (*a, *b, bond.weight * ca * cb)));
            }
        }
        entries
    }

    /// The head in all full cells: as given in the known ones, with a source (m3/s per m, over k/gamma_w: Pa) in one
    /// cell. `None` where it is not determined.
    pub fn solve(&self, operator: Operator, given: &[f64], source: Option<(usize, f64)>) -> Option<Vec<f64>> {
        let entries = self.entries(operator);
        let mut matrix = Sparse::symmetric(self.unknown.len(), entries.iter().map(|(a, b, _)| (*a, *b)));
        for (a, b, value) in entries {
            matrix.add(a, b, value);
        }
        let mut head: Vec<f64> = given.to_vec();
        for cell in &self.unknown {
            head[*cell] = 0.0;
        }
        let mut right: Vec<f64> = self.outflow(operator, &head).iter().map(|out| -out).collect();
        if let Some((cell, strength)) = source {
            right[self.number[cell]?] += strength;
        }
        let mut found = vec![0.0; right.len()];
        let mut factor = Factor::new(&matrix, Signs::Definite, Ordering::MinimumDegree).ok()?;
        factor.refresh(&matrix).ok()?;
        factor.solve(&matrix, &right, &mut found).ok()?;
        for (cell, value) in self.unknown.iter().zip(found) {
            head[*cell] = value;
        }
        Some(head)
    }

    /// How strongly the nodal operator resists each mode, over what the face operator does, ascending: the eigenvalues
    /// of the pair. One for a smooth head, zero for one that nothing resists. `None` for too many cells.
    pub fn resistances(&self) -> Option<Vec<f64>> {
        let size = self.unknown.len();
        if size > MOST {
            return None;
        }
        let [face, nodal] = BOTH.map(|operator| {
            let mut matrix = DMatrix::<f64>::zeros(size, size);
            for (a, b, value) in self.entries(operator) {
                matrix[(a, b)] += value;
                if a != b {
                    matrix[(b, a)] += value;
                }
            }
            matrix
        });
        let lower = Cholesky::new(face)?.l();
        let half = lower.solve_lower_triangular(&nodal)?;
        let whole = lower.solve_lower_triangular(&half.transpose())?;
        let mut values: Vec<f64> = SymmetricEigen::new(whole).eigenvalues.iter().copied().collect();
        values.sort_by(f64::total_cmp);
        Some(values)
    }

    /// Checkerboard index of a pressure in the full cells: |p00 - p10 - p01 + p11|/4, mean over blocks of 2 x 2 full cells,
    /// over the mean |p|. As the run has it.
    pub fn index(&self, pressure: &[f64]) -> f64 {
        let [across, up] = self.cells;
        let (mut uneven, mut blocks, mut mean, mut cells) = (0.0, 0u32, 0.0, 0u32);
        for cell in self.all() {
            mean += pressure[cell].abs();
            cells += 1;
            if cell % across + 1 < across && cell / across + 1 < up {
                let block = [cell, cell + 1, cell + across, cell + across + 1];
                if block.iter().all(|cell| self.full[*cell]) {
                    let [a, b, c, d] = block.map(|cell| pressure[cell]);
                    uneven += 0.25 * (a - b - c + d).abs();
                    blocks += 1;
                }
            }
        }
        if blocks > 0 && mean > 0.0 { uneven / f64::from(blocks) / (mean / f64::from(cells)) } else { 0.0 }
    }

    /// The unknown cell furthest from the known ones and from walls, in steps over faces; the first of several.
    pub fn innermost(&self) -> Option<usize> {
        let far = |cell: &usize| {
            let [x, y] = self.middle(*cell);
            let known = self.all().filter(|c| self.known[*c]).map(|c| self.middle(c));
            let walls = [x, y, self.cells[0] as f64 - x, self.cells[1] as f64 - y].map(|d| (d + 0.5) as usize);
            known.map(|k| ((k[0] - x).abs() + (k[1] - y).abs()).round() as usize).chain(walls).min()
        };
        self.unknown.iter().copied().min_by_key(|cell| std::cmp::Reverse(far(cell)))
    }
}

/// What the two operators make of the same source. Pairs: face operator, nodal operator.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Numbers {
    /// When, h on the clock of the run.
    pub time_h: f64,
    /// Full cells.
    pub full_cells: usize,
    /// Those without a given head.
    pub unknown_cells: usize,
    /// Middle of the cell with the source, m.
    pub source_m: [f64; 2],
    /// Checkerboard index of the run's own pore pressure in these cells.
    pub index_of_the_run: f64,
    /// Of the steady pore pressure without a source.
    pub index_without_source: [f64; 2],
    /// Of the steady pore pressure with it.
    pub index_with_source: [f64; 2],
    /// Of what the source adds.
    pub index_of_response: [f64; 2],
    /// What the source adds at most, kPa.
    pub response_kpa: [f64; 2],
    /// Modes that the nodal operator resists by less than a tenth of what the face operator does.
    pub checkerboard_modes: Option<usize>,
    /// The least such resistance, as a share.
    pub least_resistance: Option<f64>,
    /// The same outline with cells of a half and a quarter of the size, with a source in the innermost of them.
    pub finer: Vec<Finer>,
}

/// The same outline with smaller cells. Pairs: face operator, nodal operator.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Finer {
    /// Edge of a cell, m.
    pub cell_m: f64,
    /// Cells without a given head.
    pub unknown_cells: usize,
    /// Checkerboard index of what a source adds.
    pub index_of_response: [f64; 2],
    /// As in [`Numbers`]; not counted on too many cells.
    pub checkerboard_modes: Option<usize>,
    /// As in [`Numbers`].
    pub least_resistance: Option<f64>,
}

/// The numbers with the two responses.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Numbers.
    pub numbers: Numbers,
    /// The cells.
    pub region: Region,
    /// Edge of a cell, m.
    pub size: f64,
    /// What the source adds to the pore pressure of every cell, Pa; zero where there is none.
    pub response: [Vec<f64>; 2],
}

/// The last frame before failure starts, or the last of all.
pub fn shot(run: &Followed) -> Option<&Shot> {
    let before = |shot: &&Shot| run.events.failure_h.is_none_or(|failure| shot.hours() < failure);
    run.shots.iter().rev().find(before)
}

/// Compares the operators on the last frame before failure; `None` without one, or without a cell inside.
pub fn of(scene: &Scene, run: &Followed) -> Option<Compared> {
    compare(shot(run)?, scene.water?.unit_weight)
}

/// Compares them on a frame; weight of water in N/m3.
pub fn compare(shot: &Shot, unit_weight: f64) -> Option<Compared> {
    let frame = &shot.frame;
    let region = Region::of(frame);
    let rise: Vec<f64> = (0..frame.cell.len()).map(|cell| unit_weight * frame.size * region.middle(cell)[1]).collect();
    let given: Vec<f64> = frame.cell.iter().zip(&rise).map(|(cell, rise)| cell.pressure + rise).collect();
    let (source, responses) = region.responses()?;
    let solved = |operator, response: &[f64]| {
        let head = region.solve(operator, &given, None)?;
        let steady: Vec<f64> = head.iter().zip(&rise).map(|(head, rise)| head - rise).collect();
        let lifted: Vec<f64> = steady.iter().zip(response).map(|(a, b)| a + b).collect();
        Some((steady, lifted))
    };
    let both = [solved(Operator::Face, &responses[0])?, solved(Operator::Nodal, &responses[1])?];
    let own: Vec<f64> = frame.cell.iter().map(|cell| cell.pressure).collect();
    let (checkerboard_modes, least_resistance) = region.weak();
    let finer = |n: usize| {
        let split = region.split(n, true);
        let (_, responses) = split.responses()?;
        let (checkerboard_modes, least_resistance) = split.weak();
        Some(Finer {
            cell_m: frame.size / n as f64,
            unknown_cells: split.unknown(),
            index_of_response: responses.each_ref().map(|response| split.index(response)),
            checkerboard_modes,
            least_resistance,
        })
    };
    let numbers = Numbers {
        time_h: shot.hours(),
        full_cells: region.all().count(),
        unknown_cells: region.unknown(),
        source_m: region.middle(source).map(|x| x * frame.size),
        index_of_the_run: region.index(&own),
        index_without_source: both.each_ref().map(|(steady, _)| region.index(steady)),
        index_with_source: both.each_ref().map(|(_, lifted)| region.index(lifted)),
        index_of_response: responses.each_ref().map(|response| region.index(response)),
        response_kpa: responses.each_ref().map(|response| 1e-3 * response.iter().copied().fold(0.0, f64::max)),
        checkerboard_modes,
        least_resistance,
        finer: SPLITS.into_iter().filter_map(finer).collect(),
    };
    Some(Compared { numbers, size: frame.size, region, response: responses })
}

#[cfg(test)]
mod tests;

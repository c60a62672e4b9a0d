//! Water goes where its soil goes: contents of the cells are carried with the boxes of the particles.
//!
//! Every piece of a box inside a cell has its part of the water of the cell, and goes with its particle. A box that has not
//! moved leaves everything as it is, so that fronts smear by motion alone and not by looking.

use super::soil::{LEAST_SHARE, along};
use super::{FreeSurface, Kind, SoilMap, Surroundings};
use crate::grid::Grid;
use crate::particles::{Layer, SolidPoint};

/// Share of its pores that a cell of full soil may lack and still count as full: gaps between boxes, not air.
const HOLE: f64 = 0.1;

/// The box of a particle when the soil was last looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square<const D: usize> {
    /// Its middle, m.
    pub x: [f64; D],
    /// Half its edge, in cells.
    pub half: f64,
}

/// The boxes of a layer by the numbers of its particles.
pub fn squares<const D: usize, const S: usize>(
    solid: &Layer<SolidPoint<D, S>, D>,
    cell_volume: f64,
    into: &mut Vec<Square<D>>,
) {
    into.resize(solid.points.len(), Square { x: [0.0; D], half: 0.0 });
    for (point, id) in solid.points.iter().zip(&solid.ids) {
        let half = 0.5 * (point.volume / cell_volume).powf(1.0 / D as f64);
        into[*id as usize] = Square { x: point.x, half };
    }
}

/// What is carried into a cell.
#[derive(Debug, Clone, Copy, Default)]
struct Load {
    water: f64,
    surplus: f64,
    /// Of the water, that from full cells, and its pressure times water.
    full: f64,
    pressure: f64,
}

impl<const D: usize> FreeSurface<D> {
    /// Carries water and `surplus` (m3) from where the boxes were to where they are now. Returns the water that no soil
    /// holds any more, m3: it has left.
    pub fn carry<const S: usize>(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D, S>, D>,
        boxes: &mut Vec<Square<D>>,
        surplus: &mut [f64],
        (around, per_direction): (&Surroundings, usize),
    ) -> f64 {
        let cell_volume = self.medium.cell_volume;
        let mut moved = Vec::new();
        squares(solid, cell_volume, &mut moved);
        if moved == *boxes {
            // Shares that are put together again would differ in their last bits.
            return 0.0;
        }
        let mut covered = vec![0.0; grid.cell_count()];
        for old in boxes.iter() {
            pieces(grid, old, |cell, _, volume| covered[cell] += volume);
        }
        let mut loads = vec![Load::default(); grid.cell_count()];
        for (point, id) in solid.points.iter().zip(&solid.ids) {
            let old = &boxes[*id as usize];
            let shift: [f64; D] = std::array::from_fn(|d| (point.x[d] - old.x[d]) * grid.inverse_size);
            pieces(grid, old, |cell, piece, volume| {
                if self.content[cell] == 0.0 && surplus[cell] == 0.0 {
                    return;
                }
                let share = volume / covered[cell];
                let full = self.kind[cell] == Kind::Full;
                let moved: [[f64; 2]; D] = std::array::from_fn(|d| piece[d].map(|x| x + shift[d]));
                lay_down(grid, &moved, |to, part| {
                    let water = part * share * self.content[cell];
                    loads[to].water += water;
                    loads[to].surplus += part * share * surplus[cell];
                    if full {
                        loads[to].full += water;
                        loads[to].pressure += water * self.pressure[cell];
                    }
                });
            });
        }
        self.soil = SoilMap::new(grid, solid, cell_volume / self.medium.size, per_direction, self.medium.bound);
        self.soil.close(grid);
        *boxes = moved;
        let mut lost = 0.0;
        for (cell, load) in loads.iter().enumerate() {
            if self.soil.share[cell] < LEAST_SHARE {
                lost += load.water + load.surplus;
                (self.content[cell], surplus[cell], self.full[cell], self.pressure[cell]) = (0.0, 0.0, false, 0.0);
                continue;
            }
            let pores = self.soil.pores[cell];
            let full = load.full >= 0.5 * load.water && load.water >= (1.0 - HOLE) * pores && load.full > 0.0;
            let all = load.water + load.surplus;
            // No clamp: pores of soil that has run away may be no number, which a step of the soil reports.
            self.content[cell] = if full { pores } else { all.max(0.0).min(pores) };
            surplus[cell] = all - self.content[cell];
            self.full[cell] = full;
            self.pressure[cell] = if full { load.pressure / load.full } else { 0.0 };
        }
        self.lay(grid, around);
        self.classify();
        for cell in 0..self.kind.len() {
            if self.kind[cell] == Kind::Standing {
                self.pressure[cell] = self.medium.standing_pressure(self.wet_share(cell), self.soil.share[cell]);
            }
        }
        self.outflow += lost;
        lost
    }
}

/// Visits the pieces of a box in the cells: cell, from where to where along each axis (in cells), and volume.
fn pieces<const D: usize>(grid: &Grid<D>, of: &Square<D>, mut visit: impl FnMut(usize, [[f64; 2]; D], f64)) {
    let low: [f64; D] = std::array::from_fn(|d| of.x[d] * grid.inverse_size - of.half);
    let high: [f64; D] = std::array::from_fn(|d| of.x[d] * grid.inverse_size + of.half);
    let spans: [_; D] = std::array::from_fn(|d| along(low[d], high[d], grid.cells[d]));
    super::soil::spread(grid, &spans, |cell, position, volume| {
        let piece = std::array::from_fn(|d| {
            let from = if position[d] == 0 { low[d] } else { low[d].max(position[d] as f64) };
            let last = position[d] + 1 == grid.cells[d];
            let to = if last { high[d] } else { high[d].min(position[d] as f64 + 1.0) };
            [from, to]
        });
        visit(cell, piece, volume);
    });
}

/// Visits the cells that a piece lies in, with its share in each.
fn lay_down<const D: usize>(grid: &Grid<D>, piece: &[[f64; 2]; D], mut visit: impl FnMut(usize, f64)) {
    let spans: [_; D] = std::array::from_fn(|d| along(piece[d][0], piece[d][1], grid.cells[d]));
    let whole: f64 = spans.iter().map(|(_, lengths)| lengths.iter().sum::<f64>()).product();
    super::soil::spread(grid, &spans, |cell, _, volume| visit(cell, volume / whole));
}

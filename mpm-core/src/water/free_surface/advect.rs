//! Water is advected with its soil: contents of the cells move with the boxes of the particles.
//!
//! Every piece of a box inside a cell has its part of the water of the cell, and goes with its particle. A box that has not
//! moved leaves everything as it is, so that fronts smear by motion alone.

use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

use super::soil::{LEAST_SHARE, along};
use super::{FreeSurface, Kind, SoilMap, Surroundings};
use crate::grid::Grid;
use crate::particles::{Layer, SolidPoint};
use crate::real::array_of;

/// Share of its pores that a cell of full soil may lack and still count as full: gaps between boxes, not air.
const HOLE: f64 = 0.1;

/// The box of a particle when the soil was last sampled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Square<const D: usize> {
    /// Its middle, m.
    #[serde(with = "BigArray")]
    pub x: [f64; D],
    /// Half its edge, in cells.
    pub half: f64,
}

/// The boxes of a layer by the numbers of its particles.
pub fn squares<const D: usize>(solid: &Layer<SolidPoint<D>, D>, cell_volume: f64, into: &mut Vec<Square<D>>) {
    into.resize(solid.points.len(), Square { x: [0.0; D], half: 0.0 });
    for (point, id) in solid.points.iter().zip(&solid.ids) {
        let half = 0.5 * (point.volume / cell_volume).powf(1.0 / D as f64);
        into[*id as usize] = Square { x: point.x, half };
    }
}

/// What is advected into a cell.
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
    /// holds any more, m3, with the cells it was in: it has left.
    pub fn carry(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D>, D>,
        boxes: &mut Vec<Square<D>>,
        surplus: &mut [f64],
        (around, per_direction): (&Surroundings, usize),
    ) -> Vec<(usize, f64)> {
        let cell_volume = self.medium.cell_volume;
        let mut moved = Vec::new();
        squares(solid, cell_volume, &mut moved);
        if moved == *boxes {
            // Shares that are put together again would differ in their last bits.
            return Vec::new();
        }
        let mut covered = vec![0.0; grid.cell_count()];
        for old in boxes.iter() {
            pieces(grid, old, |cell, _, volume| covered[cell] += volume);
        }
        let mut loads = vec![Load::default(); grid.cell_count()];
        for (point, id) in solid.points.iter().zip(&solid.ids) {
            let old = &boxes[*id as usize];
            let shift: [f64; D] = array_of(|d| (point.x[d] - old.x[d]) * grid.inverse_size);
            pieces(grid, old, |cell, piece, volume| {
                if self.content[cell] == 0.0 && surplus[cell] == 0.0 {
                    return;
                }
                let share = volume / covered[cell];
                let full = self.kind[cell] == Kind::Full;
                let moved: [[f64; 2]; D] = array_of(|d| piece[d].map(|x| x + shift[d]));
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
        self.soil = SoilMap::new(grid, solid, cell_volume / self.medium.size, per_direction, &self.soils);
        self.soil.close(grid);
        *boxes = moved;
        let mut lost = Vec::new();
        for (cell, load) in loads.iter().enumerate() {
            if self.soil.share[cell] < LEAST_SHARE {
                let all = load.water + load.surplus;
                if all != 0.0 {
                    lost.push((cell, all));
                }
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
        self.build(grid, around);
        self.classify();
        if let Some(law) = self.medium.retention {
            self.suctions(&law);
        }
        for cell in 0..self.kind.len() {
            if self.kind[cell] == Kind::Standing {
                self.pressure[cell] = self.medium.standing_pressure(self.wet_share(cell), self.soil.share[cell]);
            }
        }
        self.outflow += lost.iter().map(|(_, lost)| lost).sum::<f64>();
        lost
    }
}

/// Visits the pieces of a box in the cells: cell, from where to where along each axis (in cells), and volume.
fn pieces<const D: usize>(grid: &Grid<D>, of: &Square<D>, mut visit: impl FnMut(usize, [[f64; 2]; D], f64)) {
    let low: [f64; D] = array_of(|d| of.x[d] * grid.inverse_size - of.half);
    let high: [f64; D] = array_of(|d| of.x[d] * grid.inverse_size + of.half);
    let spans: [_; D] = std::array::from_fn(|d| along(low[d], high[d], grid.cells[d]));
    super::soil::spread(grid, &spans, |cell, position, volume| {
        let piece = array_of(|d| {
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

#[cfg(test)]
mod tests {
    use super::super::{Medium, NO_HEADS};
    use super::*;
    use crate::particles::even_positions;
    use crate::soils::Soils;

    const N: f64 = 0.3;
    const CLOSED: Surroundings =
        Surroundings { open: [false; 4], feeds: [None; 4], heads: NO_HEADS, periodic: false, standing: Vec::new() };

    /// A block of soil of unit cells in a larger mesh, and its water.
    struct Block {
        grid: Grid<2>,
        solid: Layer<SolidPoint<2>, 2>,
        water: FreeSurface<2>,
        boxes: Vec<Square<2>>,
        surplus: Vec<f64>,
        per_direction: usize,
        lost: f64,
    }

    impl Block {
        /// `cells` of soil from the cell `corner` on; `wet` says how much of the pores of a cell is full.
        fn new(cells: [usize; 2], corner: [f64; 2], per_direction: usize, wet: impl Fn([usize; 2]) -> f64) -> Self {
            let grid = Grid::new([20, 14], 1.0);
            let volume = 1.0 / (per_direction * per_direction) as f64;
            let at = |x: [f64; 2]| SolidPoint::<2> {
                x: [x[0] + corner[0], x[1] + corner[1]],
                v: [0.0; 2],
                stress: [0.0; 4],
                mass: volume,
                volume,
            };
            let solid = Layer::new(even_positions(cells, per_direction).map(at).collect(), &grid).unwrap();
            let soils = Soils::one(1.0 - N);
            let medium = Medium {
                conductance: 1e-8,
                size: 1.0,
                cell_volume: 1.0,
                weight: [0.0, -9810.0],
                unit_weight: 9810.0,
                porosity: N,
                retention: None,
            };
            let soil = SoilMap::new(&grid, &solid, 1.0, per_direction, &soils);
            let mut water = FreeSurface::new(&grid, medium, (soil, soils), &CLOSED).unwrap();
            let content: Vec<f64> = grid
                .walk()
                .map(|(cell, position)| wet(position) * if water.soil.is_soil(cell) { water.pores(cell) } else { 0.0 })
                .collect();
            water.fill(&content);
            let mut boxes = Vec::new();
            squares(&solid, 1.0, &mut boxes);
            let surplus = vec![0.0; grid.cell_count()];
            Self { grid, solid, water, boxes, surplus, per_direction, lost: 0.0 }
        }

        /// Moves all soil and takes the water along.
        fn go(&mut self, to: impl Fn([f64; 2]) -> [f64; 2]) {
            for point in &mut self.solid.points {
                point.x = to(point.x);
            }
            self.solid.sort(&self.grid).unwrap();
            let Self { grid, solid, water, boxes, surplus, per_direction, lost } = self;
            let gone = water.carry(grid, solid, boxes, surplus, (&CLOSED, *per_direction));
            *lost += gone.iter().map(|(_, gone)| gone).sum::<f64>();
        }

        /// In cells, waiting, and lost, m3.
        fn all(&self) -> f64 {
            self.water.stored() + self.surplus.iter().sum::<f64>() + self.lost
        }
    }

    #[test]
    fn no_drop_is_lost_on_the_way() {
        // A front, a level, and a corner without water; shifts, turns and stretches of the soil.
        let mut block = Block::new([7, 5], [4.0, 4.0], 3, |[x, y]| match (x, y) {
            (4..=7, 4..=5) => 1.0,
            (8, 4..=5) => 0.35,
            (4..=7, 6) => 0.6,
            _ => 0.0,
        });
        let first = block.all();
        for step in 0..120 {
            let phase = 0.1 * f64::from(step);
            let (sin, cos) = 0.02_f64.sin_cos();
            block.go(|[x, y]| {
                let [a, b] = [x - 9.0, y - 6.5];
                let spread = 1.0 + 2e-3 * phase.sin();
                [
                    9.0 + spread * (cos * a - sin * b) + 0.03 * phase.cos(),
                    6.5 + (sin * a + cos * b) + 0.02 * phase.sin(),
                ]
            });
            assert!((block.all() / first - 1.0).abs() < 1e-13, "step {step}: {:e}", block.all() / first - 1.0);
            assert_eq!(block.water.outflow.to_bits(), block.lost.to_bits());
            for (cell, content) in block.water.content.iter().enumerate() {
                let pores = block.water.pores(cell);
                assert!(*content >= 0.0 && *content <= pores * (1.0 + 1e-12), "step {step}, cell {cell}");
            }
        }
        // It has turned by 137 degrees and is still the same block.
        assert!(block.lost < 1e-3 * first, "{:e}", block.lost / first);
    }

    #[test]
    fn soil_that_stays_leaves_its_water_as_it_is() {
        let wet = |[x, y]: [usize; 2]| if x < 8 && y < 6 { 1.0 } else { 0.3 };
        let bits = |list: &[f64]| list.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        for (corner, per_direction) in [([4.0, 4.0], 2), ([4.25, 4.1], 3)] {
            let mut block = Block::new([7, 5], corner, per_direction, wet);
            let first = [&block.water.content, &block.water.pressure, &block.surplus].map(|list| bits(list));
            let (kind, soil) = (block.water.kind.clone(), block.water.soil.clone());
            for _ in 0..5 {
                block.go(|x| x);
            }
            let last = [&block.water.content, &block.water.pressure, &block.surplus].map(|list| bits(list));
            assert!(last == first && block.water.kind == kind && block.water.soil == soil, "{per_direction}");
            assert_eq!(block.lost, 0.0);
        }
        // Beside soil that moves, what stays has its water to round-off.
        let mut block = Block::new([7, 5], [4.25, 4.1], 3, wet);
        let first = block.water.content.clone();
        for _ in 0..5 {
            block.go(|[x, y]| if x > 10.0 { [x + 1e-3, y] } else { [x, y] });
        }
        for (cell, content) in first.iter().enumerate().filter(|(cell, _)| cell % 20 < 9) {
            let now = block.water.content[cell] + block.surplus[cell];
            assert!((now - content).abs() < 1e-14, "cell {cell}: {content} {now}");
        }
    }

    #[test]
    fn full_soil_stays_full_inside() {
        for turn in [0.0, 0.01] {
            let mut block = Block::new([7, 5], [3.0, 4.0], 3, |_| 1.0);
            let (sin, cos) = f64::sin_cos(turn);
            let mut centre = [6.5, 6.5];
            for step in 0..60 {
                let [x0, y0] = centre;
                block.go(|[x, y]| {
                    let [a, b] = [x - x0, y - y0];
                    [x0 + cos * a - sin * b + 0.06, y0 + sin * a + cos * b]
                });
                centre[0] += 0.06;
                let mostly = |cell: usize| block.water.soil.share[cell] > 0.999;
                for (cell, position) in block.grid.walk() {
                    let inside = position[0] > 0 && position[1] > 0 && mostly(cell);
                    let amid = inside && [cell - 1, cell + 1, cell - 20, cell + 20].into_iter().all(mostly);
                    if amid {
                        assert_eq!(block.water.kind[cell], Kind::Full, "turn {turn}, step {step}, {position:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_front_goes_with_its_soil() {
        // Wet on the left: the place where cells are half full. The front smears on its way, to both sides alike.
        let mut block = Block::new([8, 2], [2.0, 4.0], 2, |[x, _]| match x {
            0..6 => 1.0,
            6 => 0.5,
            _ => 0.0,
        });
        let front = |block: &Block| {
            let share = |x: usize| (block.water.content[4 * 20 + x] + block.surplus[4 * 20 + x]) / N;
            let last = (0..19).rev().find(|x| share(*x) >= 0.5).unwrap();
            last as f64 + 0.5 + (share(last) - 0.5) / (share(last) - share(last + 1))
        };
        let first = front(&block);
        let mut worst: f64 = 0.0;
        for step in 1..=70 {
            block.go(|[x, y]| [x + 0.1, y]);
            worst = worst.max((front(&block) - first - 0.1 * f64::from(step)).abs());
        }
        println!("{worst} cells");
        assert!(worst < 0.5, "{worst} cells");
    }
}

//! Where there is soil: the share of every cell that the boxes of its particles cover, and what they cover beside each face.
//!
//! Area overlap instead of counts, so that soil which moves through the mesh changes its shares without jumps.

use crate::grid::Grid;
use crate::particles::{Layer, SolidPoint};
use crate::soils::Soils;
use crate::water::Halves;

/// Less soil than this share of a cell holds no water.
pub const LEAST_SHARE: f64 = 1e-3;

/// Least share of a particle that is open to water, however dense it is.
pub const LEAST_OPEN: f64 = 0.02;

/// The soil as the water sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct SoilMap<const D: usize> {
    /// Share of each cell that is soil, 0 to 1.
    pub share: Vec<f64>,
    /// Pores of each cell that mobile water can fill, m3.
    pub pores: Vec<f64>,
    /// Water of each cell that stays where it is, m3.
    pub stays: Vec<f64>,
    /// How the soil conducts.
    pub halves: Halves<D>,
    /// For each axis and face the share that is soil just below it and just above it, 0 to 1.
    pub cover: [Vec<[f64; 2]>; D],
}

/// A box along one axis: first cell, and its length in that cell and the next two, in cells.
type Along = (usize, [f64; 3]);

impl<const D: usize> SoilMap<D> {
    /// The map of a layer; `face_area` is that of a whole face, m2, `per_direction` the particles per cell and direction.
    pub fn new(
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D>, D>,
        face_area: f64,
        per_direction: usize,
        soils: &Soils,
    ) -> Self {
        let cell_volume = face_area * grid.size;
        let mut map = Self {
            share: vec![0.0; grid.cell_count()],
            pores: vec![0.0; grid.cell_count()],
            stays: vec![0.0; grid.cell_count()],
            halves: Halves::of(grid, solid, cell_volume, soils),
            cover: std::array::from_fn(|axis| vec![[0.0; 2]; grid.face_count(axis)]),
        };
        // Half a particle beside a face: what lies there touches it.
        let strip = 0.5 / per_direction as f64;
        for (point, id) in solid.points.iter().zip(&solid.ids) {
            let kind = soils.kind_of(*id);
            let half = 0.5 * (point.volume / cell_volume).powf(1.0 / D as f64);
            let middle = point.x.map(|x| x * grid.inverse_size);
            let open = (1.0 - (kind.grain_inverse + kind.stays) * point.mass / point.volume).max(LEAST_OPEN);
            let stays = kind.stays * point.mass / point.volume;
            map.add(grid, &middle, half, strip, [open * cell_volume, stays * cell_volume]);
        }
        for (share, (pores, stays)) in map.share.iter_mut().zip(map.pores.iter_mut().zip(&mut map.stays)) {
            // Boxes that overlap fill no more than their cell.
            *pores /= share.max(1.0);
            *stays /= share.max(1.0);
            *share = share.min(1.0);
        }
        for cover in map.cover.iter_mut().flatten().flatten() {
            *cover = cover.min(1.0);
        }
        map
    }

    /// Adds a box around `middle`, of `half` its edge, all in cells; a whole cell of it has so large pores and so much water that
    /// stays, m3.
    fn add(&mut self, grid: &Grid<D>, middle: &[f64; D], half: f64, strip: f64, [pores, stays]: [f64; 2]) {
        let whole: [Along; D] = std::array::from_fn(|d| along(middle[d] - half, middle[d] + half, grid.cells[d]));
        spread(grid, &whole, |cell, _, volume| {
            self.share[cell] += volume;
            self.pores[cell] += pores * volume;
            self.stays[cell] += stays * volume;
        });
        for axis in 0..D {
            // A strip below and one above each face that the box may touch.
            let (low, high) = (middle[axis] - half, middle[axis] + half);
            let first = (low - strip).floor().max(0.0) as usize;
            let last = ((high + strip).ceil().max(0.0) as usize).min(grid.cells[axis]);
            for lattice in first..=last {
                let at = lattice as f64;
                for (side, (from, to)) in [(at - strip, at), (at, at + strip)].into_iter().enumerate() {
                    let length = (high.min(to) - low.max(from)).max(0.0) / strip;
                    if length == 0.0 {
                        continue;
                    }
                    let mut across = whole;
                    across[axis] = (0, [1.0, 0.0, 0.0]);
                    let cover = &mut self.cover[axis];
                    spread(grid, &across, |_, mut position, share| {
                        position[axis] = lattice;
                        cover[grid.face(axis, &position)][side] += length * share;
                    });
                }
            }
        }
    }

    /// Closes gaps amid soil: boxes that stay square while the soil shears leave some, and no air is there.
    pub fn close(&mut self, grid: &Grid<D>) {
        let mostly: Vec<bool> = self.share.iter().map(|share| *share >= 0.5).collect();
        for (cell, position) in grid.walk() {
            let mut stride = 1;
            let mut amid = mostly[cell];
            for d in 0..D {
                amid &= position[d] == 0 || mostly[cell - stride];
                amid &= position[d] + 1 == grid.cells[d] || mostly[cell + stride];
                stride *= grid.cells[d];
            }
            if !amid {
                continue;
            }
            self.share[cell] = 1.0;
            for axis in 0..D {
                let mut at = position;
                self.cover[axis][grid.face(axis, &at)][1] = 1.0;
                at[axis] += 1;
                self.cover[axis][grid.face(axis, &at)][0] = 1.0;
            }
        }
    }

    /// Whether a cell holds soil enough for water.
    #[inline]
    pub fn is_soil(&self, cell: usize) -> bool {
        self.share[cell] >= LEAST_SHARE
    }
}

/// Lengths of an interval (in cells) in the cells of an axis; what sticks out of the mesh stays in its outermost cell.
pub(super) fn along(low: f64, high: f64, cells: usize) -> Along {
    let first = (low.floor().max(0.0) as usize).min(cells - 1);
    let mut lengths = [0.0; 3];
    for (i, length) in lengths.iter_mut().enumerate() {
        let cell = first + i;
        if cell >= cells {
            break;
        }
        let from = if cell == 0 { f64::NEG_INFINITY } else { cell as f64 };
        let to = if cell + 1 == cells { f64::INFINITY } else { cell as f64 + 1.0 };
        *length = (high.min(to) - low.max(from)).max(0.0);
    }
    (first, lengths)
}

/// Visits the cells of a box: cell, lattice position, product of its lengths.
pub(super) fn spread<const D: usize>(
    grid: &Grid<D>,
    along: &[Along; D],
    mut visit: impl FnMut(usize, [usize; D], f64),
) {
    let rows = if D == 2 { 3 } else { 1 };
    for j in 0..rows {
        for i in 0..3 {
            let mut volume = along[0].1[i];
            let mut position = [along[0].0 + i; D];
            if D == 2 {
                volume *= along[D - 1].1[j];
                position[D - 1] = along[D - 1].0 + j;
            }
            if volume > 0.0 && (0..D).all(|d| position[d] < grid.cells[d]) {
                let cell = (0..D).rev().fold(0, |cell, d| cell * grid.cells[d] + position[d]);
                visit(cell, position, volume);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::even_positions;

    fn block(cells: [usize; 2], per_direction: usize, shift: [f64; 2]) -> Vec<SolidPoint<2>> {
        let volume = 1.0 / (per_direction * per_direction) as f64;
        even_positions(cells, per_direction)
            .map(|x| SolidPoint {
                x: [x[0] + shift[0], x[1] + shift[1]],
                v: [0.0; 2],
                stress: [0.0; 4],
                mass: 1.0,
                volume,
            })
            .collect()
    }

    #[test]
    fn a_block_on_the_mesh_fills_its_cells_and_faces() {
        let grid = Grid::new([4, 3], 1.0);
        let solid = Layer::new(block([2, 2], 2, [0.0; 2]), &grid).unwrap();
        let map = SoilMap::new(&grid, &solid, 1.0, 2, &Soils::one(0.0));
        for (cell, position) in grid.walk() {
            let inside = position[0] < 2 && position[1] < 2;
            assert!((map.share[cell] - f64::from(u8::from(inside))).abs() < 1e-12);
        }
        assert_eq!(map.cover[0][grid.face(0, &[1, 0])], [1.0, 1.0]);
        assert_eq!(map.cover[0][grid.face(0, &[2, 1])], [1.0, 0.0]);
        assert_eq!(map.cover[1][grid.face(1, &[0, 2])], [1.0, 0.0]);
    }

    #[test]
    fn a_block_that_moves_keeps_its_area() {
        let grid = Grid::new([5, 4], 1.0);
        for step in 0..20 {
            let shift = [0.1 * f64::from(step), 0.05 * f64::from(step)];
            let solid = Layer::new(block([2, 2], 3, shift), &grid).unwrap();
            let map = SoilMap::new(&grid, &solid, 1.0, 3, &Soils::one(0.0));
            assert!((map.share.iter().sum::<f64>() - 4.0).abs() < 1e-12, "{shift:?}");
        }
    }

    #[test]
    fn gaps_amid_soil_close_and_the_outline_stays() {
        let grid = Grid::new([7, 7], 1.0);
        // A particle is missing amid the block, one at its upper edge, and one at the lower edge of the mesh.
        let missing = [[3.25, 2.25], [3.25, 4.75], [2.25, 0.25]];
        let points: Vec<_> = block([5, 5], 2, [1.0, 0.0]).into_iter().filter(|p| !missing.contains(&p.x)).collect();
        let solid = Layer::new(points, &grid).unwrap();
        let mut map = SoilMap::new(&grid, &solid, 1.0, 2, &Soils::one(0.0));
        let open = map.clone();
        map.close(&grid);
        let (amid, edge, foot) = (3 + 2 * 7, 3 + 4 * 7, 2);
        assert_eq!([open.share[amid], open.share[edge], open.share[foot]], [0.75; 3]);
        // The mesh ends below the foot: it is amid soil too.
        assert_eq!([map.share[amid], map.share[edge], map.share[foot]], [1.0, 0.75, 1.0]);
        for axis in 0..2 {
            for (face, pair) in map.cover[axis].iter().enumerate() {
                let before = open.cover[axis][face];
                assert!(pair[0] >= before[0] && pair[1] >= before[1]);
            }
            let mut at = [3, 2];
            assert_eq!(map.cover[axis][grid.face(axis, &at)], [1.0, 1.0]);
            at[axis] += 1;
            assert_eq!(map.cover[axis][grid.face(axis, &at)], [1.0, 1.0]);
        }
        // The upper edge of the block is where it was, and no cell beside it became soil.
        assert_eq!(map.cover[1][grid.face(1, &[3, 5])], open.cover[1][grid.face(1, &[3, 5])]);
        for (cell, [x, y]) in grid.walk() {
            assert_eq!(map.is_soil(cell), (1..6).contains(&x) && y < 5);
            assert_eq!(map.pores[cell], open.pores[cell], "what is not there holds no water");
        }
        let once = map.clone();
        map.close(&grid);
        assert_eq!(map, once);
    }
}

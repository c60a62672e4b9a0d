//! Faces of the soil that touch no other soil: the sides of the domain and the free surface.

use serde::{Deserialize, Serialize};

use crate::checkpoint::{Archive, RestoreError};
use crate::grid::Grid;

/// A face between a cell of soil and nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExposedFace {
    /// The cell of soil.
    pub cell: u32,
    /// The face, numbered by [`Grid::face`].
    pub face: u32,
    /// Axis that the face is normal to.
    pub axis: u8,
    /// Whether the outside lies in the positive direction.
    pub upper: bool,
    /// Which side of the soil: left, right, bottom, top.
    pub side: u8,
    /// Its nodes; one dimension repeats the first.
    pub nodes: [u32; 2],
}

/// All exposed faces, rebuilt when the set of cells with soil changes.
#[derive(Debug, Clone, Default)]
pub struct Exposed {
    /// The faces in the order of their cells.
    pub faces: Vec<ExposedFace>,
}

impl ExposedFace {
    fn is_of<const D: usize>(&self, grid: &Grid<D>) -> bool {
        let Self { cell, face, axis, side, nodes, .. } = *self;
        (cell as usize) < grid.cell_count()
            && (axis as usize) < D
            && (face as usize) < grid.face_count(axis as usize)
            && side < 4
            && nodes.iter().all(|node| (*node as usize) < grid.node_count())
    }
}

impl Exposed {
    /// Saves or restores the faces.
    pub(crate) fn save_or_restore<const D: usize>(
        &mut self,
        archive: &mut Archive,
        grid: &Grid<D>,
    ) -> Result<(), RestoreError> {
        archive.value(&mut self.faces)?;
        if self.faces.iter().all(|face| face.is_of(grid)) { Ok(()) } else { Err(RestoreError) }
    }

    /// Finds the exposed faces of the cells for which `soil` holds; a mesh that is `periodic` has no left and right.
    pub fn rebuild<const D: usize>(&mut self, grid: &Grid<D>, periodic: bool, soil: impl Fn(usize) -> bool) {
        self.faces.clear();
        for (cell, position) in grid.walk() {
            if !soil(cell) {
                continue;
            }
            let corners = grid.corners(&position);
            let mut stride = 1;
            for axis in 0..D {
                for upper in [false, true] {
                    let at_side = if upper { position[axis] + 1 == grid.cells[axis] } else { position[axis] == 0 };
                    let next = match (upper, at_side && periodic && axis == 0) {
                        (true, false) => cell + stride,
                        (false, false) => cell.wrapping_sub(stride),
                        (true, true) => cell + 1 - grid.cells[0],
                        (false, true) => cell + grid.cells[0] - 1,
                    };
                    if (at_side && !(periodic && axis == 0)) || !soil(next) {
                        self.faces.push(Self::face(grid, cell, &position, &corners, axis, upper));
                    }
                }
                stride *= grid.cells[axis];
            }
        }
    }

    fn face<const D: usize>(
        grid: &Grid<D>,
        cell: usize,
        position: &[usize; D],
        corners: &[usize; 4],
        axis: usize,
        upper: bool,
    ) -> ExposedFace {
        let mut lattice = *position;
        lattice[axis] += usize::from(upper);
        // Corner numbers on the face: bit `axis` is `upper`, the other bit runs.
        let first = usize::from(upper) << axis;
        let second = if D == 2 { first | (1 << (1 - axis)) } else { first };
        // The last axis is the vertical one: sides 2 and 3.
        let side = 2 * (axis + 2 - D) + usize::from(upper);
        ExposedFace {
            cell: cell as u32,
            face: grid.face(axis, &lattice) as u32,
            axis: axis as u8,
            upper,
            side: side as u8,
            nodes: [corners[first] as u32, corners[second] as u32],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_shows_its_outline() {
        let grid = Grid::new([4, 3], 1.0);
        let mut exposed = Exposed::default();
        // Two rows of three cells in the lower left corner.
        exposed.rebuild(&grid, false, |cell| cell % 4 < 3 && cell / 4 < 2);
        let count = |side| exposed.faces.iter().filter(|f| f.side == side).count();
        assert_eq!([count(0), count(1), count(2), count(3)], [2, 2, 3, 3]);
        let column = Grid::new([5], 1.0);
        exposed.rebuild(&column, false, |cell| cell < 4);
        assert_eq!(exposed.faces.len(), 2);
        assert_eq!((exposed.faces[0].side, exposed.faces[0].nodes[0]), (2, 0));
        assert_eq!((exposed.faces[1].side, exposed.faces[1].nodes[0]), (3, 4));
    }
}

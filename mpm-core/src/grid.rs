//! The background mesh: square cells, their nodes and faces, and the index arithmetic between them.
//!
//! Cells and nodes are numbered row by row, x fastest. Faces normal to axis d lie on the node lattice along d and
//! on the cell lattice across it. In one dimension the only axis is vertical and faces coincide with nodes.

use crate::real::array_of;

/// A mesh of square cells in D dimensions; the last axis is vertical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid<const D: usize> {
    /// Number of cells along each axis.
    pub cells: [usize; D],
    /// Edge of a cell L, m.
    pub size: f64,
    /// 1/L, 1/m.
    pub inverse_size: f64,
    /// Distance of x = 0 from the axis that the section turns about, m; `None` in plane strain.
    pub axis: Option<f64>,
    /// Whether an outline cuts its cells.
    pub cut: bool,
}

impl<const D: usize> Grid<D> {
    /// Corners of a cell.
    pub const CORNERS: usize = 1 << D;

    /// A mesh with its first corner at the origin.
    pub fn new(cells: [usize; D], size: f64) -> Self {
        Self { cells, size, inverse_size: 1.0 / size, axis: None, cut: false }
    }

    /// Thickness at x (m): the distance from the axis, m; 1 m in plane strain, and a factor of 1 in a column.
    #[inline]
    pub fn thickness(&self, x: f64) -> f64 {
        self.axis.map_or(1.0, |axis| axis + x)
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.iter().product()
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.cells.iter().map(|n| n + 1).product()
    }

    /// Number of faces normal to an axis.
    pub fn face_count(&self, axis: usize) -> usize {
        (0..D).map(|d| self.cells[d] + usize::from(d == axis)).product()
    }

    /// Lattice position of a cell.
    #[inline]
    pub fn cell_position(&self, cell: usize) -> [usize; D] {
        let mut rest = cell;
        array_of(|d| {
            let i = rest % self.cells[d];
            rest /= self.cells[d];
            i
        })
    }

    /// Walks over all cells in order, without the divisions of [`Self::cell_position`].
    #[inline]
    pub fn walk(&self) -> Walk<D> {
        Walk { cells: self.cells, next: 0, position: [0; D] }
    }

    /// The cell that holds a point (m), or `None` outside the mesh (and for a NaN).
    #[inline]
    pub fn cell_at(&self, x: &[f64; D]) -> Option<usize> {
        let mut cell = 0;
        for d in (0..D).rev() {
            let i = (x[d] * self.inverse_size).floor();
            if !(i >= 0.0 && i < self.cells[d] as f64) {
                return None;
            }
            cell = cell * self.cells[d] + i as usize;
        }
        Some(cell)
    }

    /// Node at a lattice position.
    #[inline]
    pub fn node(&self, position: &[usize; D]) -> usize {
        (0..D).rev().fold(0, |node, d| node * (self.cells[d] + 1) + position[d])
    }

    /// First node of a cell, the one with the smallest coordinates.
    #[inline]
    pub fn first_corner(&self, cell: usize, position: &[usize; D]) -> usize {
        // A row has one node more than it has cells.
        if D == 1 { cell } else { cell + position[1] }
    }

    /// Corner nodes from the first: bit d of the corner number is its place along axis d. In one dimension the
    /// last two repeat the first.
    #[inline]
    pub fn corners_from(&self, first: usize) -> [usize; 4] {
        if D == 1 {
            [first, first + 1, first, first]
        } else {
            let row = self.cells[0] + 1;
            [first, first + 1, first + row, first + row + 1]
        }
    }

    /// Corner nodes of the cell at a lattice position, as in [`Self::corners_from`].
    #[inline]
    pub fn corners(&self, position: &[usize; D]) -> [usize; 4] {
        self.corners_from(self.node(position))
    }

    /// Face normal to `axis` at a lattice position: the lower face of the cell there.
    #[inline]
    pub fn face(&self, axis: usize, position: &[usize; D]) -> usize {
        (0..D).rev().fold(0, |face, d| face * (self.cells[d] + usize::from(d == axis)) + position[d])
    }
}

/// Cells in order with their lattice positions.
#[derive(Debug, Clone)]
pub struct Walk<const D: usize> {
    cells: [usize; D],
    next: usize,
    position: [usize; D],
}

impl<const D: usize> Iterator for Walk<D> {
    type Item = (usize, [usize; D]);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let (cell, position) = (self.next, self.position);
        if position[D - 1] == self.cells[D - 1] {
            return None;
        }
        self.next += 1;
        self.position[0] += 1;
        if D == 2 && self.position[0] == self.cells[0] {
            self.position[0] = 0;
            self.position[D - 1] += 1;
        }
        Some((cell, position))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbering_is_one_to_one() {
        let grid = Grid::new([3, 4], 0.5);
        for cell in 0..grid.cell_count() {
            let [i, j] = grid.cell_position(cell);
            let middle = [(i as f64 + 0.5) * 0.5, (j as f64 + 0.5) * 0.5];
            assert_eq!(grid.cell_at(&middle), Some(cell));
            assert_eq!(grid.corners(&[i, j])[3], grid.node(&[i + 1, j + 1]));
        }
        assert!(grid.walk().eq((0..12).map(|cell| (cell, grid.cell_position(cell)))));
        assert!(Grid::new([7], 1.0).walk().eq((0..7).map(|cell| (cell, [cell]))));
        for axis in 0..2 {
            let mut seen = vec![false; grid.face_count(axis)];
            for j in 0..4 + usize::from(axis == 1) {
                for i in 0..3 + usize::from(axis == 0) {
                    assert!(!std::mem::replace(&mut seen[grid.face(axis, &[i, j])], true));
                }
            }
            assert!(seen.iter().all(|s| *s));
        }
    }

    #[test]
    fn points_outside_have_no_cell() {
        let grid = Grid::new([2], 1.0);
        assert_eq!(grid.cell_at(&[-1e-12]), None);
        assert_eq!(grid.cell_at(&[2.0]), None);
        assert_eq!(grid.cell_at(&[f64::NAN]), None);
    }
}

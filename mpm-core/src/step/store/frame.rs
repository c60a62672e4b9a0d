//! How cells, nodes and faces are numbered so that SIMD lanes read and write whole vectors.
//!
//! Every row of cells gets empty cells at its end, and there are empty rows above: as many as there are functions more than cells. Then cell c reaches the functions
//! c, c + 1, ..., its lower faces are faces c, and cell c + 1, node c + 1 and face c + 1 stand beside them whatever the row. A
//! vector of cells may run over the end of a row without knowing it.

use crate::grid::Grid;
use crate::real::{MAX_LANES, array, array_of};

/// A strip has at least so many cells and rows: its first rows are added up apart.
const LEAST: [usize; 2] = [512, 4];
/// Strips of a mesh that is large enough for them: they can be shared out evenly among as many threads.
const STRIPS: usize = 16;
/// More cells than this make more strips.
const MOST: usize = 4096;

/// The numbering of a mesh.
#[derive(Debug, Clone, Copy)]
pub struct Frame<const D: usize> {
    /// Cells of the mesh along each axis.
    pub cells: [usize; D],
    /// From a number to that of its neighbour along each axis.
    pub stride: [usize; D],
    /// Functions that the particles of a cell reach along an axis.
    pub reach: usize,
    /// How many of those along an axis have a smaller number than the cell.
    pub before: usize,
    /// Cells of a strip: what one thread works on at a time. The same for any number of threads.
    pub strip: usize,
    /// Strips.
    pub strips: usize,
    /// 1/L, 1/m.
    pub inverse_size: f64,
    /// As [`Grid::axis`].
    pub axis: Option<f64>,
    /// The same in cells. Found once: a product with what stands in no `Some` may be one of denormal numbers, which take hundreds of cycles.
    pub axis_in_cells: Option<f64>,
    cut: bool,
}

impl<const D: usize> Frame<D> {
    /// The numbering of a grid whose cells reach so many functions along each axis, `before` of them behind the cell. Where the water
    /// is `periodic`, each row has a place of its own before its first cell and one behind the last.
    pub fn new(grid: &Grid<D>, reach: usize, before: usize, periodic: bool) -> Self {
        let row = if D == 1 { 1 } else { grid.cells[0] + (reach - 1).max(if periodic { 2 } else { 0 }) };
        let count = (if D == 1 { 1 } else { row }) * (grid.cells[D - 1] + reach - 1);
        let least = LEAST[0].max(LEAST[1] * row);
        let mut strips = 1;
        while count / (2 * strips) >= least && (strips < STRIPS || count / strips > MOST) {
            strips *= 2;
        }
        let strip = count.div_ceil(strips).next_multiple_of(MAX_LANES);
        let stride = array_of(|d| if d == 0 { 1 } else { row });
        let strips = count.div_ceil(strip);
        Self {
            cells: grid.cells,
            stride,
            reach,
            before,
            strip,
            strips,
            inverse_size: grid.inverse_size,
            axis: grid.axis,
            axis_in_cells: grid.axis.map(|axis| axis * grid.inverse_size),
            cut: grid.cut,
        }
    }

    /// Whether centroids of the soil in cells are found: about an axis, and of B-bar (`split`) where an outline cuts cells.
    pub fn finds_centroids(&self, split: bool) -> bool {
        self.axis.is_some() || (split && self.cut)
    }

    /// Numbers in use, those of empty cells included.
    pub fn count(&self) -> usize {
        self.strips * self.strip
    }

    /// Functions beyond its last cell that a strip reaches.
    pub fn tail(&self) -> usize {
        (self.reach - 1) * self.stride.iter().sum::<usize>()
    }

    /// Numbers before the first cell of its faces.
    pub fn pad(&self) -> usize {
        self.stride[D - 1]
    }

    /// From the lower face of a cell along an axis, and its first node, to its second node.
    pub fn beside(&self, axis: usize) -> usize {
        if D == 1 { 0 } else { self.stride[D - 1 - axis] }
    }

    /// As [`Grid::thickness`], at the face of a number normal to an axis.
    pub fn thickness(&self, axis: usize, face: usize) -> f64 {
        let column = || self.position(face)[0] as f64 + if axis == 0 { 0.0 } else { 0.5 };
        self.axis.map_or(1.0, |from| from + column() / self.inverse_size)
    }

    /// Length of an array with a number for each function (or node), those that only pad included.
    pub fn length(&self) -> usize {
        self.count() + self.tail().max(self.stride.iter().sum()) + MAX_LANES
    }

    /// Number of the cell (or node, or lower face) at a place on the lattice.
    #[inline]
    pub fn number(&self, position: &[usize; D]) -> usize {
        if D == 1 { position[0] } else { position[D - 1] * self.stride[D - 1] + position[0] }
    }

    /// Number of a function from its place, counted from those that reach into the first cell on.
    #[inline]
    pub fn function(&self, position: &[usize; D]) -> usize {
        self.number(&array!([0; D], d => position[d] + self.before))
    }

    /// From the number of a cell to that of function `a` of those it reaches.
    #[inline]
    pub fn offset(&self, a: usize) -> usize {
        a % self.reach + if D == 1 { 0 } else { a / self.reach * self.stride[D - 1] }
    }

    /// Number of the cell that holds a point (m); none outside the mesh (and for a NaN).
    pub fn at(&self, x: &[f64]) -> Option<usize> {
        let mut position = [0; D];
        for d in 0..D {
            let i = (x[d] * self.inverse_size).floor();
            if !(i >= 0.0 && i < self.cells[d] as f64) {
                return None;
            }
            position[d] = i as usize;
        }
        Some(self.number(&position))
    }

    /// Place of a number on the lattice.
    #[inline]
    pub fn position(&self, number: usize) -> [usize; D] {
        let mut position = [number; D];
        if D == 2 {
            position[0] = number % self.stride[D - 1];
            position[D - 1] = number / self.stride[D - 1];
        }
        position
    }

    /// From the number of a cell to that of a node at one of its corners.
    #[inline]
    pub fn offset_of_corner(&self, corner: usize) -> usize {
        (corner & 1) + if D == 1 { 0 } else { (corner >> 1) * self.stride[D - 1] }
    }

    /// The last cell and the first one of each row, where water goes over the seam of a periodic mesh.
    pub fn seam(&self) -> impl Iterator<Item = [usize; 2]> {
        let (rows, stride, across) = (if D == 1 { 0 } else { self.cells[D - 1] }, self.stride[D - 1], self.cells[0]);
        (0..rows).map(move |row| [row * stride + across - 1, row * stride])
    }

    /// Whether a place is a cell of the mesh, and not one that only pads.
    #[inline]
    pub fn is_cell(&self, position: &[usize; D]) -> bool {
        (0..D).all(|d| position[d] < self.cells[d])
    }
}

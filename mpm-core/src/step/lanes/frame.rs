//! How cells, nodes and faces are numbered so that lanes read and write whole vectors.
//!
//! Every row of cells gets one empty cell more, and there is one empty row more: then the first corner of cell c is
//! node c, its lower faces are faces c, and cell c + 1, node c + 1 and face c + 1 stand beside them whatever the row. A
//! vector of cells may run over the end of a row without knowing it.

use crate::grid::Grid;

pub use crate::real::MOST_LANES;

/// A strip has at least so many cells and rows: its first row is added up apart.
const LEAST: [usize; 2] = [512, 4];
/// Strips of a mesh that is large enough for them: they can be shared out evenly among as many threads.
const STRIPS: usize = 16;
/// More cells than this make more strips.
const MOST: usize = 4096;

/// The numbering of a mesh.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// Cells of the mesh along x and y.
    pub cells: [usize; 2],
    /// From a cell to the one above it.
    pub row: usize,
    /// Cells of a strip: what one thread works on at a time. The same for any number of threads.
    pub strip: usize,
    /// Strips.
    pub strips: usize,
    /// 1/L, 1/m.
    pub inverse_size: f64,
}

impl Frame {
    /// The numbering of a grid.
    pub fn new(grid: &Grid<2>) -> Self {
        let row = grid.cells[0] + 1;
        let count = row * (grid.cells[1] + 1);
        let least = LEAST[0].max(LEAST[1] * row);
        let mut strips = 1;
        while count / (2 * strips) >= least && (strips < STRIPS || count / strips > MOST) {
            strips *= 2;
        }
        let strip = count.div_ceil(strips).next_multiple_of(MOST_LANES);
        Self { cells: grid.cells, row, strip, strips: count.div_ceil(strip), inverse_size: grid.inverse_size }
    }

    /// Numbers in use, those of empty cells included.
    pub fn count(&self) -> usize {
        self.strips * self.strip
    }

    /// Number of a cell from its place on the lattice.
    pub fn number(&self, position: &[usize; 2]) -> usize {
        position[1] * self.row + position[0]
    }

    /// Number of the cell that holds a point (m); none outside the mesh (and for a NaN).
    pub fn at(&self, x: &[f64; 2]) -> Option<usize> {
        let mut position = [0; 2];
        for d in 0..2 {
            let i = (x[d] * self.inverse_size).floor();
            if !(i >= 0.0 && i < self.cells[d] as f64) {
                return None;
            }
            position[d] = i as usize;
        }
        Some(self.number(&position))
    }

    /// Place of a number on the lattice.
    pub fn position(&self, number: usize) -> [usize; 2] {
        [number % self.row, number / self.row]
    }
}

/// Motion of the nodes, an array per component.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Velocity at the end of the step, m/s.
    pub velocity: [Vec<f64>; 2],
    /// What a particle adds to its (FLIP-weighted) velocity, m/s.
    pub change: [Vec<f64>; 2],
    /// Acceleration, m/s2.
    pub acceleration: [Vec<f64>; 2],
}

impl Motion {
    /// Nodes at rest, some more than the frame has so that a cell of the last row finds its corners.
    pub fn new(frame: &Frame) -> Self {
        let rest = || [(); 2].map(|()| vec![0.0; frame.count() + frame.row + 1 + MOST_LANES]);
        Self { velocity: rest(), change: rest(), acceleration: rest() }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        6 * self.velocity[0].capacity() * size_of::<f64>()
    }
}

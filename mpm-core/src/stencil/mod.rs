//! Basis functions of any width around a particle: tensor products of one function per axis.
//!
//! Every basis here sums to one and reproduces linear fields, up to the sides of the mesh (the tests of each file).
//! The linear functions of the paper have a faster kernel of their own, `step/explicit.rs`.

mod bspline;
mod gimp;
mod linear;

pub use bspline::Bspline2;
pub use gimp::Gimp;

use crate::grid::Grid;

/// Most functions around a point along one axis.
pub const WIDEST: usize = 3;
/// Most functions around a point of the plane.
const MOST: usize = WIDEST * WIDEST;

/// The functions around a point along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Number of the first of them.
    pub first: usize,
    /// Their values; beyond [`Basis::WIDTH`] zero.
    pub value: [f64; WIDEST],
    /// Their derivatives, per length of a cell.
    pub slope: [f64; WIDEST],
}

/// A basis along one axis. Points are given by their cell and the coordinate `xi` in it, usually in [0, 1).
pub trait Basis: Copy + Send + Sync + 'static {
    /// Functions around a point.
    const WIDTH: usize;
    /// Functions along an axis are this many more than cells.
    const EXTRA: usize;
    /// Functions that the particles of one cell reach along an axis.
    const REACH: usize;
    /// How many of those have a smaller number than the cell.
    const BEFORE: usize;
    /// Whether gradients are those at the centre of the cell (the paper, section 2.2).
    const AT_CENTRE: bool = false;
    /// Whether what changes volumes is taken at the centre of the cell all the same (B-bar).
    const SPLIT: bool = false;
    /// Whether the functions are the linear ones: then a coefficient is the value at a node of the mesh.
    const NODAL: bool = false;

    /// Functions around a particle in a row of `cells` cells.
    fn around(&self, cell: usize, xi: f64, cells: usize) -> Line;

    /// Where a function of a row of `cells` cells stands, in cells: `sum_i N_i x_i = x`.
    fn stands_at(&self, function: usize, _cells: usize) -> f64 {
        function as f64
    }

    /// Functions at a point of the surface; `xi` may lie a little outside the cell that the surface belongs to.
    #[inline(always)]
    fn at_surface(&self, cell: usize, xi: f64, cells: usize) -> Line {
        self.around(cell, xi, cells)
    }

    /// Shares of the coefficients in the mean around a node of the mesh; over all nodes they sum to one.
    #[inline(always)]
    fn at_node(&self, node: usize, cells: usize) -> Line {
        let cell = node.min(cells - 1);
        self.at_surface(cell, (node - cell) as f64, cells)
    }
}

/// The functions around a point of a mesh, `count` of them: WIDTH^D.
#[derive(Debug, Clone, Copy)]
pub struct Stencil<const D: usize> {
    /// Numbers of the functions.
    pub node: [usize; MOST],
    /// Values N_i.
    pub value: [f64; MOST],
    /// Gradients G_i, 1/m.
    pub gradient: [[f64; D]; MOST],
    /// Place of the first function along each axis.
    first: [usize; D],
}

/// A basis on a mesh.
#[derive(Debug, Clone)]
pub struct Functions<B, const D: usize> {
    /// The basis along each axis.
    pub basis: B,
    /// Cells along each axis.
    cells: [usize; D],
    /// Functions along each axis.
    pub along: [usize; D],
    inverse_size: f64,
}

impl<B: Basis, const D: usize> Functions<B, D> {
    /// Functions around a point.
    pub const COUNT: usize = B::WIDTH.pow(D as u32);
    /// Functions that the particles of a cell reach.
    pub const REACHED: usize = B::REACH.pow(D as u32);

    /// The functions of a mesh.
    pub fn new(basis: B, grid: &Grid<D>) -> Self {
        let along = grid.cells.map(|cells| cells + B::EXTRA);
        Self { basis, cells: grid.cells, along, inverse_size: grid.inverse_size }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.along.iter().product()
    }

    /// Around a particle at `xi` of the cell at `position`.
    #[inline(always)]
    pub fn around(&self, position: &[usize; D], xi: &[f64; D]) -> Stencil<D> {
        let line = |d: usize, xi: f64| self.basis.around(position[d], xi, self.cells[d]);
        let lines: [Line; D] = std::array::from_fn(|d| line(d, xi[d]));
        if B::AT_CENTRE {
            // Section 2.2: G_i(x_p) is replaced by G_i(x_c); N_i stays.
            let centre = std::array::from_fn(|d| line(d, 0.5));
            Stencil { value: self.product(&lines).value, ..self.product(&centre) }
        } else {
            self.product(&lines)
        }
    }

    /// The same with gradients at the particle, wherever the basis takes them.
    #[inline(always)]
    pub fn at_particle(&self, position: &[usize; D], xi: &[f64; D]) -> Stencil<D> {
        self.product(&std::array::from_fn(|d| self.basis.around(position[d], xi[d], self.cells[d])))
    }

    /// From a place (m) to where function `a` of a stencil stands, m.
    #[inline(always)]
    pub fn away(&self, stencil: &Stencil<D>, a: usize, x: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|d| {
            let along = stencil.first[d] + if d == 0 { a % B::WIDTH } else { a / B::WIDTH };
            self.basis.stands_at(along, self.cells[d]) / self.inverse_size - x[d]
        })
    }

    /// At the centre of a cell, for bases whose functions are those of one cell.
    #[inline(always)]
    pub fn centre(&self, position: &[usize; D]) -> Stencil<D> {
        self.product(&std::array::from_fn(|d| self.basis.around(position[d], 0.5, self.cells[d])))
    }

    /// At a point of the surface above the cell at `position`.
    #[inline(always)]
    pub fn at_surface(&self, position: &[usize; D], xi: &[f64; D]) -> Stencil<D> {
        self.product(&std::array::from_fn(|d| self.basis.at_surface(position[d], xi[d], self.cells[d])))
    }

    /// Shares in the mean around a node of the mesh.
    #[inline(always)]
    pub fn at_node(&self, position: &[usize; D]) -> Stencil<D> {
        self.product(&std::array::from_fn(|d| self.basis.at_node(position[d], self.cells[d])))
    }

    #[inline(always)]
    fn product(&self, lines: &[Line; D]) -> Stencil<D> {
        let mut stencil =
            Stencil { node: [0; MOST], value: [0.0; MOST], gradient: [[0.0; D]; MOST], first: lines.map(|l| l.first) };
        // A function beyond the last one has the value zero: it may stand for any other.
        let place = |d: usize, k: usize| (lines[d].first + k).min(self.along[d] - 1);
        let x = &lines[0];
        if D == 1 {
            for i in 0..B::WIDTH {
                stencil.node[i] = place(0, i);
                stencil.value[i] = x.value[i];
                stencil.gradient[i][0] = x.slope[i] * self.inverse_size;
            }
            return stencil;
        }
        let y = &lines[D - 1];
        for j in 0..B::WIDTH {
            let row = place(D - 1, j) * self.along[0];
            for i in 0..B::WIDTH {
                let a = j * B::WIDTH + i;
                stencil.node[a] = row + place(0, i);
                stencil.value[a] = x.value[i] * y.value[j];
                stencil.gradient[a][0] = x.slope[i] * y.value[j] * self.inverse_size;
                stencil.gradient[a][D - 1] = x.value[i] * y.slope[j] * self.inverse_size;
            }
        }
        stencil
    }

    /// Place of function `a` of a stencil among those that the particles of the cell at `position` reach.
    #[inline(always)]
    pub fn reached(position: &[usize; D], stencil: &Stencil<D>, a: usize) -> usize {
        let along = |d: usize| stencil.first[d] + B::BEFORE - position[d];
        let x = along(0) + a % B::WIDTH;
        if D == 1 { x } else { x + (along(D - 1) + a / B::WIDTH) * B::REACH }
    }

    /// The function at a place among those that the particles of the cell at `position` reach; `None` outside the mesh.
    #[inline(always)]
    pub fn at_place(&self, position: &[usize; D], place: usize) -> Option<usize> {
        let offset = |d: usize| if d == 0 { place % B::REACH } else { place / B::REACH };
        let mut function = 0;
        for d in (0..D).rev() {
            let along = (position[d] + offset(d)).wrapping_sub(B::BEFORE);
            if along >= self.along[d] {
                return None;
            }
            function = function * self.along[d] + along;
        }
        Some(function)
    }
}

/// Partition of unity, linear completeness with the places where the functions stand, slopes by central differences.
#[cfg(test)]
fn check_line(basis: &impl Basis, stands_at: impl Fn(usize, usize) -> f64, kinks: &[f64]) {
    for cells in [1, 2, 3, 5] {
        for cell in 0..cells {
            for step in 0..40 {
                let xi = (f64::from(step) + 0.37) / 40.0;
                let line = basis.around(cell, xi, cells);
                let sum = |f: &dyn Fn(usize) -> f64| (0..WIDEST).map(f).sum::<f64>();
                let stands = |k: usize| stands_at(line.first + k, cells);
                let case = format!("cell {cell} of {cells}, xi = {xi}: {line:?}");
                assert!((sum(&|k| line.value[k]) - 1.0).abs() < 1e-14, "sum N, {case}");
                assert!(sum(&|k| line.slope[k]).abs() < 1e-14, "sum G, {case}");
                assert!((sum(&|k| line.value[k] * stands(k)) - (cell as f64 + xi)).abs() < 1e-13, "x, {case}");
                assert!((sum(&|k| line.slope[k] * stands(k)) - 1.0).abs() < 1e-13, "dx/dx, {case}");
                assert!(line.value.iter().all(|v| *v >= 0.0), "N >= 0, {case}");
                let h = 1e-6;
                if kinks.iter().any(|kink| (xi - kink).abs() < 2.0 * h) {
                    continue;
                }
                let (low, high) = (basis.around(cell, xi - h, cells), basis.around(cell, xi + h, cells));
                for k in 0..WIDEST {
                    let difference = (high.value[k] - low.value[k]) / (2.0 * h);
                    assert!((line.slope[k] - difference).abs() < 1e-8, "slope {k}, {case}");
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Centre, Linear};

    /// A function may be wrong in ways that its own file would not see: numbers, products, places.
    fn product<B: Basis>(basis: B) {
        let grid = Grid::new([3, 4], 0.5);
        let functions = Functions::new(basis, &grid);
        assert_eq!(functions.count(), (3 + B::EXTRA) * (4 + B::EXTRA));
        for (_, position) in grid.walk() {
            for xi in [[0.1, 0.3], [0.6, 0.9], [0.999, 0.001]] {
                let stencil = functions.around(&position, &xi);
                let count = Functions::<B, 2>::COUNT;
                assert!((stencil.value[..count].iter().sum::<f64>() - 1.0).abs() < 1e-14);
                for a in 0..count {
                    let place = Functions::<B, 2>::reached(&position, &stencil, a);
                    let counts = stencil.value[a] != 0.0 || stencil.gradient[a] != [0.0; 2];
                    assert!(!counts || functions.at_place(&position, place) == Some(stencil.node[a]));
                    if B::AT_CENTRE || !counts {
                        continue;
                    }
                    for d in 0..2 {
                        let h = 1e-6;
                        let moved = |by: f64| {
                            let mut xi = xi;
                            xi[d] += by;
                            functions.around(&position, &xi).value[a]
                        };
                        let difference = (moved(h) - moved(-h)) / (2.0 * h * grid.size);
                        assert!((stencil.gradient[a][d] - difference).abs() < 1e-7, "{position:?} {xi:?} {a} {d}");
                    }
                }
            }
        }
    }

    #[test]
    fn products_of_lines_are_functions_of_the_plane() {
        product(Centre);
        product(Linear);
        product(Gimp::new(2));
        product(Bspline2);
    }

    /// Every coefficient is shared out among the nodes, all of it.
    fn shared<B: Basis>(basis: B) {
        let grid = Grid::new([1, 4], 0.5);
        let functions = Functions::new(basis, &grid);
        let mut sum = vec![0.0; functions.count()];
        for j in 0..=4 {
            for i in 0..=1 {
                let stencil = functions.at_node(&[i, j]);
                for a in 0..Functions::<B, 2>::COUNT {
                    sum[stencil.node[a]] += stencil.value[a];
                }
            }
        }
        assert!(sum.iter().all(|s| *s == 1.0), "{sum:?}");
    }

    #[test]
    fn nodes_of_the_mesh_share_the_coefficients() {
        shared(Linear);
        shared(Gimp::new(2));
        shared(Bspline2);
    }

    #[test]
    #[should_panic(expected = "sum N")]
    fn line_check_can_fail() {
        #[derive(Clone, Copy)]
        struct Leaky;
        impl Basis for Leaky {
            const WIDTH: usize = 3;
            const EXTRA: usize = 2;
            const REACH: usize = 3;
            const BEFORE: usize = 0;
            fn around(&self, cell: usize, xi: f64, cells: usize) -> Line {
                let mut line = Bspline2.around(cell, xi, cells);
                line.value[1] -= 1e-12;
                line
            }
        }
        check_line(&Leaky, bspline::greville, &[]);
    }
}

//! The functions around a point, from the bases of the solver's kernel.

use mpm_core::step::kernel::Basis;

/// Where gradients are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gradients {
    /// At the particle.
    AtParticle,
    /// At the centre of the cell (section 2.2 of the paper).
    AtCentre,
    /// What changes volumes at the centre, the rest at the particle (B-bar).
    Split,
}

/// A function at a point.
#[derive(Debug, Clone, Copy)]
pub struct At<const D: usize> {
    /// Its number.
    pub function: usize,
    /// Its value.
    pub value: f64,
    /// Its gradient, 1/m.
    pub gradient: [f64; D],
}

/// Products of a basis along each axis of a mesh.
#[derive(Debug, Clone, Copy)]
pub struct Products<B, const D: usize> {
    basis: B,
    cells: [usize; D],
    inverse_size: f64,
    /// Functions along each axis.
    pub along: [usize; D],
}

impl<B: Basis, const D: usize> Products<B, D> {
    /// Of a mesh of so many cells of a size, 1/L in 1/m.
    pub fn new(basis: B, cells: [usize; D], inverse_size: f64) -> Self {
        Self { basis, cells, inverse_size, along: cells.map(|cells| cells + B::EXTRA) }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.along.iter().product()
    }

    /// Those that particles of a cell reach, at a place in it; for all places in the same order.
    pub fn around(&self, position: &[usize; D], xi: &[f64; D]) -> Vec<At<D>> {
        let lines: [_; D] = std::array::from_fn(|d| self.basis.at(position[d], self.cells[d], xi[d]));
        let mut all = Vec::new();
        for a in 0..B::REACH.pow(D as u32) {
            let reached: [usize; D] = std::array::from_fn(|d| if d == 0 { a % B::REACH } else { a / B::REACH });
            let place = |d: usize| (position[d] + reached[d]).checked_sub(B::BEFORE).filter(|i| *i < self.along[d]);
            let Some(function) = (0..D).rev().try_fold(0, |all, d| place(d).map(|i| all * self.along[d] + i)) else {
                continue;
            };
            let of =
                |d: usize, slope: bool| if slope { lines[d].slope[reached[d]] } else { lines[d].value[reached[d]] };
            let product = |along: Option<usize>| (0..D).map(|d| of(d, along == Some(d))).product::<f64>();
            let gradient = std::array::from_fn(|d| product(Some(d)) * self.inverse_size);
            all.push(At { function, value: product(None), gradient });
        }
        all
    }

    /// Share of a function in the mean around a node of the mesh: that of a linear function at the place where it stands.
    pub fn at_node(&self, function: usize, node: &[usize; D]) -> f64 {
        let along = |d: usize| if d == 0 { function % self.along[0] } else { function / self.along[0] };
        let off = |d: usize| (self.basis.stands_at(along(d), self.cells[d]) - node[d] as f64).abs();
        (0..D).map(|d| (1.0 - off(d)).max(0.0)).product()
    }
}

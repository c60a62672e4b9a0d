//! Linear functions, with gradients at the particle or at the centre of its cell.

use super::{Basis, Line};
use crate::shape::Shape;

impl<Sh: Shape> Basis for Sh {
    const WIDTH: usize = 2;
    const EXTRA: usize = 1;
    const REACH: usize = 2;
    const BEFORE: usize = 0;
    const AT_CENTRE: bool = Sh::AT_CENTRE;
    const SPLIT: bool = Sh::SPLIT;
    const NODAL: bool = true;

    #[inline(always)]
    fn around(&self, cell: usize, xi: f64, _: usize) -> Line {
        line(cell, xi)
    }
}

/// The two linear functions of a cell.
#[inline(always)]
pub(super) fn line(cell: usize, xi: f64) -> Line {
    Line { first: cell, value: [1.0 - xi, xi, 0.0], slope: [-1.0, 1.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use crate::shape::Linear;

    #[test]
    fn linear_functions_are_complete() {
        super::super::check_line(&Linear, |node, _| node as f64, &[]);
    }
}

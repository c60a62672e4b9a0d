//! Quadratic B-splines on open knots (0, 0, 0, 1, 2, ...): the first and last coefficients are the boundary values.
//!
//! Source: de Boor, *A Practical Guide to Splines*, 2001, chapter IX. In a cell of its own coordinate x the three
//! functions are `a (1-x)^2`, `b x^2` and what is left of one, with a, b = 1/2, or 1 at a repeated knot.

use super::{Basis, Line};

/// Quadratic B-splines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bspline2;

impl Basis for Bspline2 {
    const WIDTH: usize = 3;
    const EXTRA: usize = 2;
    const REACH: usize = 3;
    const BEFORE: usize = 0;

    #[inline(always)]
    fn around(&self, cell: usize, xi: f64, cells: usize) -> Line {
        let a = if cell == 0 { 1.0 } else { 0.5 };
        let b = if cell + 1 == cells { 1.0 } else { 0.5 };
        let left = 1.0 - xi;
        let (low, high) = (a * left * left, b * xi * xi);
        let (fall, rise) = (-2.0 * a * left, 2.0 * b * xi);
        Line { first: cell, value: [low, 1.0 - low - high, high], slope: [fall, -fall - rise, rise] }
    }

    fn stands_at(&self, function: usize, cells: usize) -> f64 {
        greville(function, cells)
    }

    /// Shares of the coefficients in the mean around a node: linear functions at the places where they stand (Greville).
    #[inline(always)]
    fn at_node(&self, node: usize, cells: usize) -> Line {
        let (first, value) = match node {
            0 => (0, [1.0, 0.5, 0.0]),
            _ if node == cells => (cells - 1, [0.0, 0.5, 1.0]),
            _ => (node, [0.5, 0.5, 0.0]),
        };
        Line { first, value, slope: [0.0; 3] }
    }
}

/// Where a coefficient stands (Greville): mean of the inner knots of its function, in cells.
pub(super) fn greville(function: usize, cells: usize) -> f64 {
    let knot = |i: usize| i.clamp(2, cells + 2) as f64 - 2.0;
    0.5 * (knot(function + 1) + knot(function + 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splines_are_complete() {
        super::super::check_line(&Bspline2, greville, &[]);
    }

    #[test]
    fn splines_are_smooth_across_knots() {
        let cells = 4;
        for cell in 0..cells - 1 {
            let (before, after) = (Bspline2.around(cell, 1.0, cells), Bspline2.around(cell + 1, 0.0, cells));
            assert!(before.value[0].abs() + after.value[2].abs() < 1e-15);
            for k in 0..2 {
                assert!((before.value[k + 1] - after.value[k]).abs() < 1e-15, "value at knot {}", cell + 1);
                assert!((before.slope[k + 1] - after.slope[k]).abs() < 1e-15, "slope at knot {}", cell + 1);
            }
        }
    }
}

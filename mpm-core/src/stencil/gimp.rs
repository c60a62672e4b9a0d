//! uGIMP: linear functions averaged over the particle's first size, `S_i = 1/(2 l) int N_i` from x - l to x + l.
//!
//! Source: Bardenhagen & Kober, *CMES* 5(6), 2004, 477-495. Where the particle sticks out of the mesh, the field is
//! continued linearly: a node outside stands for `2 f_0 - f_1`, so constant and linear fields stay exact.

use super::{Basis, Line, linear};

/// Linear functions averaged over particles of a fixed size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gimp {
    /// Half the size of a particle over that of a cell, l; at most one half.
    half: f64,
}

impl Gimp {
    /// For `per_direction` particles per cell and axis.
    pub fn new(per_direction: usize) -> Self {
        Self { half: 0.5 / per_direction as f64 }
    }
}

impl Basis for Gimp {
    const WIDTH: usize = 3;
    const EXTRA: usize = 1;
    const REACH: usize = 4;
    const BEFORE: usize = 1;
    // The functions at the nodes of the mesh are averages, but a coefficient is taken for the node's own value:
    // both are the same for linear fields.
    const NODAL: bool = true;

    #[inline(always)]
    fn around(&self, cell: usize, xi: f64, cells: usize) -> Line {
        let (low, high, per) = (xi - self.half, xi + self.half, 0.5 / self.half);
        // A particle is no longer than a cell: it has at most one node inside, and reaches a and c to both sides of it.
        let left = if low < 0.0 { -1.0 } else { 0.0 };
        let middle = left + 1.0;
        let (a, b, c) = (middle - low, (middle - high).max(0.0), (high - middle).max(0.0));
        let (first, last) = (0.5 * per * (a * a - b * b), 0.5 * per * c * c);
        let (fall, rise) = (-per * (a - b), per * c);
        // The middle one is what remains of constant fields.
        let (value, slope) = ([first, 1.0 - first - last, last], [fall, -fall - rise, rise]);
        if left < 0.0 && cell == 0 {
            // Node -1 is outside: 2 f_0 - f_1.
            let (v, s) = (value[0], slope[0]);
            Line {
                first: 0,
                value: [value[1] + 2.0 * v, value[2] - v, 0.0],
                slope: [slope[1] + 2.0 * s, slope[2] - s, 0.0],
            }
        } else if left == 0.0 && cell + 1 == cells {
            // Node `cells` + 1 is outside.
            let (v, s) = (value[2], slope[2]);
            Line {
                first: cell,
                value: [value[0] - v, value[1] + 2.0 * v, 0.0],
                slope: [slope[0] - s, slope[1] + 2.0 * s, 0.0],
            }
        } else {
            Line { first: if left < 0.0 { cell - 1 } else { cell }, value, slope }
        }
    }

    /// The load acts at a point, which has no size.
    #[inline(always)]
    fn at_surface(&self, cell: usize, xi: f64, _: usize) -> Line {
        linear::line(cell, xi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The hat function.
    fn hat(s: f64) -> f64 {
        (1.0 - s.abs()).max(0.0)
    }

    #[test]
    fn averaged_functions_are_complete() {
        for per_direction in 1..=4 {
            let gimp = Gimp::new(per_direction);
            super::super::check_line(&gimp, |node, _| node as f64, &[gimp.half, 1.0 - gimp.half]);
        }
    }

    #[test]
    fn an_average_is_that_of_the_linear_functions() {
        let gimp = Gimp::new(2);
        // Midpoint rule over the particle on both sides of the node 2.
        let (cell, xi, points) = (1, 0.9, 1000);
        let line = gimp.around(cell, xi, 4);
        for k in 0..3 {
            let node = (line.first + k) as f64;
            let mean: f64 = (0..points)
                .map(|i| hat(1.9 + gimp.half * ((2 * i + 1) as f64 / points as f64 - 1.0) - node))
                .sum::<f64>()
                / points as f64;
            assert!((line.value[k] - mean).abs() < 1e-6, "{k}: {} {mean}", line.value[k]);
        }
    }
}

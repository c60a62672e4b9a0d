//! A basis along one axis: B-splines or uGIMP on the lines of the mesh inside the soil.

use super::splines::{Local, MOST_ALONG, Splines};

/// Functions along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Basis {
    /// B-splines of a degree on open knots, the first and the last are the boundary values; degree 1 is linear, one per line.
    Splines {
        /// 1 to 3.
        degree: usize,
    },
    /// Linear, averaged over `2 half` around the point (Bardenhagen & Kober 2004, CMES 5, 477-496), m.
    Gimp {
        /// Half the size of a particle, m.
        half: f64,
    },
}

/// Lines that cut the soil along one axis, and the basis on them.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Boundary, inner mesh lines, boundary; m, ascending.
    pub knots: Vec<f64>,
    /// The functions.
    pub basis: Basis,
    /// Edge of a whole cell, m.
    pub size: f64,
    /// First inner line, m: the others follow at equal distances.
    origin: f64,
    /// Knots where slopes of B-splines may jump, ascending.
    breaks: Vec<usize>,
    /// The B-splines; for uGIMP the linear functions that it averages.
    splines: Splines,
}

impl Axis {
    /// Mesh lines at `offset + i size` within the soil from `low` to `high` (m).
    ///
    /// A boundary cell smaller than `least` of a whole one is merged with its neighbour.
    pub fn new(low: f64, high: f64, size: f64, offset: f64, least: f64, basis: Basis) -> Self {
        let first = ((low - offset) / size + 1e-9).floor() as i64 + 1;
        let last = ((high - offset) / size - 1e-9).ceil() as i64 - 1;
        let mut knots = vec![low];
        knots.extend((first..=last).map(|i| offset + i as f64 * size));
        knots.push(high);
        if knots.len() > 2 && knots[1] - knots[0] < least * size - 1e-9 * size {
            knots.remove(1);
        }
        let end = knots.len() - 1;
        if end > 1 && knots[end] - knots[end - 1] < least * size - 1e-9 * size {
            knots.remove(end - 1);
        }
        let origin = if knots.len() > 2 { knots[1] } else { high };
        let degree = if let Basis::Splines { degree } = basis { degree } else { 1 };
        let splines = Splines::new(&knots, degree, |_| 1);
        Self { knots, basis, size, origin, breaks: Vec::new(), splines }
    }

    /// The axis with B-splines that are only continuous at some of its knots (m), the interfaces of layers. Linear
    /// functions have no slope there anyway.
    pub fn broken_at(mut self, places: impl Iterator<Item = f64>) -> Self {
        if let Basis::Splines { degree: degree @ 2.. } = self.basis {
            let knot = |place: f64| self.knots.iter().position(|k| (k - place).abs() < 1e-6 * self.size);
            let inner = 1..self.knots.len() - 1;
            self.breaks = places.filter_map(knot).filter(|knot| inner.contains(knot)).collect();
            self.splines = Splines::new(&self.knots, degree, |knot| if self.is_break(knot) { degree } else { 1 });
        }
        self
    }

    /// Whether a knot is a break.
    pub fn is_break(&self, knot: usize) -> bool {
        self.breaks.contains(&knot)
    }

    /// The B-splines; for uGIMP the linear functions that it averages.
    pub fn splines(&self) -> &Splines {
        &self.splines
    }

    /// Cells.
    pub fn cells(&self) -> usize {
        self.knots.len() - 1
    }

    /// Functions.
    pub fn functions(&self) -> usize {
        self.splines.count()
    }

    /// Functions that do not vanish in one place, at most.
    pub fn support(&self) -> usize {
        match self.basis {
            Basis::Splines { degree } => degree + 1,
            Basis::Gimp { .. } => 3,
        }
    }

    /// Cell of a point; the first or last cell for a point outside.
    #[inline]
    pub fn cell(&self, x: f64) -> usize {
        let cell = ((x - self.origin) / self.size).floor() + 1.0;
        (cell.max(0.0) as usize).min(self.cells() - 1)
    }

    /// Length of a cell, m.
    pub fn length(&self, cell: usize) -> f64 {
        self.knots[cell + 1] - self.knots[cell]
    }

    /// Middle of a cell, m.
    pub fn middle(&self, cell: usize) -> f64 {
        0.5 * (self.knots[cell] + self.knots[cell + 1])
    }

    /// The functions at a point.
    pub fn at(&self, x: f64) -> Local {
        match self.basis {
            Basis::Splines { .. } => self.at_boundary(x),
            Basis::Gimp { half } => self.gimp(x, half),
        }
    }

    /// Values at a point of the boundary: without the averaging of uGIMP, which would reach beyond it.
    pub fn at_boundary(&self, x: f64) -> Local {
        self.splines.at(self.cell(x), x)
    }

    /// Mean of the linear functions from x - half to x + half. Beyond the boundary they go on straight, so that
    /// linear fields stay exact there too.
    fn gimp(&self, x: f64, half: f64) -> Local {
        // A support that ends on a line belongs to one side of it, whatever round-off says.
        let inner = half * (1.0 - 1e-9);
        let low = self.splines.at(self.cell(x - inner), x - half);
        let high = self.splines.at(self.cell(x + inner), x + half);
        let mut local = Local {
            first: low.first.min(self.functions().saturating_sub(3)),
            value: [0.0; MOST_ALONG],
            slope: [0.0; MOST_ALONG],
        };
        let shift = low.first - local.first;
        let width = 1.0 / (2.0 * half);
        if low.first == high.first {
            for i in 0..2 {
                local.value[shift + i] = 0.5 * (low.value[i] + high.value[i]);
                local.slope[shift + i] = low.slope[i];
            }
        } else {
            // The support crosses the line between two cells: trapezoid on either side.
            let line = self.knots[high.first];
            let (below, above) = ((line - (x - half)) * width, (x + half - line) * width);
            for i in 0..2 {
                let end = [0.0, 1.0][i];
                local.value[i] += 0.5 * below * (low.value[i] + end);
                local.value[1 + i] += 0.5 * above * (1.0 - end + high.value[i]);
                local.slope[i] += below * low.slope[i];
                local.slope[1 + i] += above * high.slope[i];
            }
        }
        local
    }
}

#[cfg(test)]
mod tests {
    use super::super::gauss;
    use super::*;

    fn axes() -> Vec<Axis> {
        let mut all = Vec::new();
        let splines = [1, 2, 3].map(|degree| Basis::Splines { degree });
        for basis in splines.into_iter().chain([Basis::Gimp { half: 0.05 }]) {
            for offset in [0.0, -0.03, -0.05, -0.099, 0.02] {
                for high in [1.0, 0.913, 0.3, 0.1] {
                    let axis = Axis::new(0.0, high, 0.1, offset, 0.5, basis);
                    let inner = axis.knots.clone();
                    let breaks = [inner[inner.len() / 3], inner[inner.len() / 2]];
                    all.push(axis.clone().broken_at(breaks.into_iter()));
                    all.push(axis);
                }
            }
        }
        all
    }

    #[test]
    fn functions_sum_to_one_and_hold_straight_lines() {
        for axis in axes() {
            let high = axis.knots[axis.cells()];
            for i in 0..=200 {
                let x = high * f64::from(i) / 200.0;
                let local = axis.at(x);
                let (mut one, mut zero, mut line, mut slope) = (0.0, 0.0, 0.0, 0.0);
                for a in 0..MOST_ALONG {
                    if local.value[a] == 0.0 && local.slope[a] == 0.0 {
                        continue;
                    }
                    let at = axis.splines().stands(local.first + a);
                    one += local.value[a];
                    zero += local.slope[a];
                    line += local.value[a] * at;
                    slope += local.slope[a] * at;
                }
                assert!((one - 1.0).abs() < 1e-13 && zero.abs() < 1e-10, "{axis:?} {x} {local:?}");
                assert!((line - x).abs() < 1e-13 && (slope - 1.0).abs() < 1e-12, "{axis:?} {x} {local:?}");
            }
        }
    }

    #[test]
    fn slopes_are_those_of_the_values() {
        for axis in axes() {
            let high = axis.knots[axis.cells()];
            let step = 1e-7;
            for i in 1..97 {
                let x = high * (f64::from(i) + 0.123) / 97.0;
                let (a, b, middle) = (axis.at(x - step), axis.at(x + step), axis.at(x));
                if a.first != b.first {
                    continue;
                }
                for f in 0..axis.support() {
                    let difference = (b.value[f] - a.value[f]) / (2.0 * step);
                    assert!((difference - middle.slope[f]).abs() < 1e-5, "{axis:?} {x} {f}");
                }
            }
        }
    }

    #[test]
    fn at_a_break_one_function_is_one_and_slopes_jump() {
        for degree in [2, 3] {
            let axis = Axis::new(0.0, 1.0, 0.1, 0.0, 0.5, Basis::Splines { degree });
            let axis = axis.broken_at([0.3, 0.7, 0.75].into_iter());
            assert_eq!(axis.functions(), 10 + degree + 2 * (degree - 1));
            for knot in [3, 7] {
                let at = |cell: usize| axis.splines().at(cell, axis.knots[knot]);
                let (below, above) = (at(knot - 1), at(knot));
                assert_eq!(below.first + degree, above.first);
                assert!((below.value[degree] - 1.0).abs() < 1e-14 && (above.value[0] - 1.0).abs() < 1e-14);
                assert!(below.slope[degree] > 10.0 && above.slope[0] < -10.0, "{below:?} {above:?}");
            }
            assert!((0..10).all(|cell| axis.splines().cell_with(axis.splines().first(cell)) == cell));
        }
    }

    #[test]
    fn the_highest_derivative_is_that_of_the_values() {
        for axis in axes().into_iter().filter(|axis| matches!(axis.basis, Basis::Splines { .. })) {
            let degree = axis.support() - 1;
            for cell in 0..axis.cells() {
                // Differences of order `degree` of a polynomial of that degree are exact.
                let step = axis.length(cell) / degree as f64;
                for (a, highest) in axis.splines().highest(cell).into_iter().take(degree + 1).enumerate() {
                    let at = |i: usize| axis.splines().at(cell, axis.knots[cell] + i as f64 * step).value[a];
                    let binomials: &[f64] = [&[-1.0, 1.0][..], &[1.0, -2.0, 1.0], &[-1.0, 3.0, -3.0, 1.0]][degree - 1];
                    let difference: f64 = binomials.iter().enumerate().map(|(i, b)| b * at(i)).sum();
                    let scale = step.powi(-(degree as i32));
                    assert!((difference * scale - highest).abs() < 1e-11 * scale, "{axis:?} {cell} {a}");
                }
            }
        }
    }

    #[test]
    fn integrals_are_those_of_the_values() {
        for axis in axes().into_iter().filter(|axis| matches!(axis.basis, Basis::Splines { .. })) {
            let mut sums = vec![0.0; axis.functions()];
            for cell in 0..axis.cells() {
                for a in 0..axis.support() {
                    let value = |x| axis.splines().at(cell, x).value[a];
                    sums[axis.splines().first(cell) + a] += gauss(axis.knots[cell], axis.knots[cell + 1], 1, value);
                }
            }
            for (function, sum) in sums.iter().enumerate() {
                assert!((sum - axis.splines().integral(function)).abs() < 1e-14, "{axis:?} {function}");
            }
        }
    }

    #[test]
    fn small_boundary_cells_are_merged() {
        let axis = Axis::new(0.0, 1.0, 0.1, -0.07, 0.5, Basis::Splines { degree: 1 });
        assert_eq!(axis.cells(), 10);
        assert!((axis.length(0) - 0.13).abs() < 1e-12 && (axis.length(9) - 0.07).abs() < 1e-12);
        for x in [0.0, 0.129, 0.131, 0.5, 0.92, 0.94, 1.0] {
            let cell = axis.cell(x);
            assert!(axis.knots[cell] <= x && x <= axis.knots[cell + 1], "{x} {cell}");
        }
        assert_eq!(Axis::new(0.0, 1.0, 0.1, 0.0, 0.5, Basis::Splines { degree: 2 }).functions(), 12);
    }
}

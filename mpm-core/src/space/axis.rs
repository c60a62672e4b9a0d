//! A basis along one axis: linear, uGIMP or quadratic B-splines on the lines of the mesh inside the soil.

/// Functions along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Basis {
    /// Linear, one per knot.
    Linear,
    /// Linear, averaged over `2 half` around the point (Bardenhagen & Kober 2004, CMES 5, 477-495), m.
    Gimp {
        /// Half the size of a particle, m.
        half: f64,
    },
    /// Quadratic B-splines on open knots: cells + 2 functions, the first and the last are the boundary values. One more
    /// for every break, where its value is that of one function.
    Spline2,
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
    /// Knots that B-splines have twice, ascending: slopes may jump there.
    breaks: Vec<usize>,
}

/// Up to three functions that do not vanish at a point, and their derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Local {
    /// Number of the first function.
    pub first: usize,
    /// Values.
    pub value: [f64; 3],
    /// Derivatives, 1/m.
    pub slope: [f64; 3],
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
        Self { knots, basis, size, origin, breaks: Vec::new() }
    }

    /// The axis with B-splines that are only continuous at some of its knots (m), the interfaces of layers. Linear
    /// functions have no slope there anyway.
    pub fn broken_at(mut self, places: impl Iterator<Item = f64>) -> Self {
        if self.basis == Basis::Spline2 {
            let knot = |place: f64| self.knots.iter().position(|k| (k - place).abs() < 1e-6 * self.size);
            let inner = 1..self.knots.len() - 1;
            self.breaks = places.filter_map(knot).filter(|knot| inner.contains(knot)).collect();
        }
        self
    }

    /// Whether a knot is a break.
    pub fn is_break(&self, knot: usize) -> bool {
        self.breaks.contains(&knot)
    }

    /// Breaks below the middle of a cell.
    pub fn breaks_below(&self, cell: usize) -> usize {
        self.breaks.iter().filter(|knot| **knot <= cell).count()
    }

    /// First function of a cell.
    pub fn first(&self, cell: usize) -> usize {
        cell + self.breaks_below(cell)
    }

    /// Knot with a number when breaks are counted twice; so also the cell with a first function.
    pub fn knot_of(&self, number: usize) -> usize {
        number - self.breaks.iter().enumerate().filter(|(i, knot)| number > **knot + i).count()
    }

    /// Cells.
    pub fn cells(&self) -> usize {
        self.knots.len() - 1
    }

    /// Functions.
    pub fn functions(&self) -> usize {
        match self.basis {
            Basis::Linear | Basis::Gimp { .. } => self.knots.len(),
            Basis::Spline2 => self.knots.len() + 1 + self.breaks.len(),
        }
    }

    /// Functions that do not vanish in one place, at most.
    pub fn support(&self) -> usize {
        match self.basis {
            Basis::Linear => 2,
            Basis::Gimp { .. } => 3,
            Basis::Spline2 => 3,
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
            Basis::Linear => self.linear(x),
            Basis::Gimp { half } => self.gimp(x, half),
            Basis::Spline2 => self.spline2(self.cell(x), x),
        }
    }

    /// Values at a point of the boundary: without the averaging of uGIMP, which would reach beyond it.
    pub fn at_boundary(&self, x: f64) -> Local {
        match self.basis {
            Basis::Gimp { .. } => self.linear(x),
            _ => self.at(x),
        }
    }

    fn linear(&self, x: f64) -> Local {
        self.linear_of(self.cell(x), x)
    }

    /// Linear functions of a cell, going on straight beyond it.
    fn linear_of(&self, cell: usize, x: f64) -> Local {
        let inverse = 1.0 / self.length(cell);
        let right = (x - self.knots[cell]) * inverse;
        Local { first: cell, value: [1.0 - right, right, 0.0], slope: [-inverse, inverse, 0.0] }
    }

    /// Mean of the linear functions from x - half to x + half. Beyond the boundary they go on straight, so that
    /// linear fields stay exact there too.
    fn gimp(&self, x: f64, half: f64) -> Local {
        // A support that ends on a line belongs to one side of it, whatever round-off says.
        let inner = half * (1.0 - 1e-9);
        let low = self.linear_of(self.cell(x - inner), x - half);
        let high = self.linear_of(self.cell(x + inner), x + half);
        let mut local =
            Local { first: low.first.min(self.functions().saturating_sub(3)), value: [0.0; 3], slope: [0.0; 3] };
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

    /// Quadratic B-splines of a cell (de Boor 1978, ch. X, with repeated knots at the ends).
    fn spline2(&self, cell: usize, x: f64) -> Local {
        let [before, left, right, after] = self.around(cell);
        let (down, up) = (1.0 / ((right - before) * (right - left)), 1.0 / ((after - left) * (right - left)));
        let (first, last) = ((right - x).powi(2) * down, (x - left).powi(2) * up);
        let (first_slope, last_slope) = (-2.0 * (right - x) * down, 2.0 * (x - left) * up);
        Local {
            first: self.first(cell),
            value: [first, 1.0 - first - last, last],
            slope: [first_slope, -first_slope - last_slope, last_slope],
        }
    }

    /// Second derivatives of the three B-splines of a cell, 1/m2.
    pub fn curvature(&self, cell: usize) -> [f64; 3] {
        let [before, left, right, after] = self.around(cell);
        let (first, last) = (2.0 / ((right - before) * (right - left)), 2.0 / ((after - left) * (right - left)));
        [first, -first - last, last]
    }

    fn around(&self, cell: usize) -> [f64; 4] {
        let k = &self.knots;
        let mut around = [k[cell.max(1) - 1], k[cell], k[cell + 1], k[(cell + 2).min(k.len() - 1)]];
        if self.is_break(cell) {
            around[0] = around[1];
        }
        if self.is_break(cell + 1) {
            around[3] = around[2];
        }
        around
    }

    /// Coefficients of a field `a + b x`: its values at the knots, or at the Greville points of the B-splines.
    pub fn greville(&self, function: usize) -> f64 {
        match self.basis {
            Basis::Linear | Basis::Gimp { .. } => self.knots[function],
            Basis::Spline2 => {
                let k = |number: usize| self.knots[self.knot_of(number)];
                0.5 * (k(function.max(1) - 1) + k(function.min(self.knots.len() + self.breaks.len() - 1)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes() -> Vec<Axis> {
        let mut all = Vec::new();
        for basis in [Basis::Linear, Basis::Gimp { half: 0.05 }, Basis::Spline2] {
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
                for a in 0..3 {
                    if local.value[a] == 0.0 && local.slope[a] == 0.0 {
                        continue;
                    }
                    let at = axis.greville(local.first + a);
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
                for f in 0..3 {
                    let difference = (b.value[f] - a.value[f]) / (2.0 * step);
                    assert!((difference - middle.slope[f]).abs() < 1e-5, "{axis:?} {x} {f}");
                }
            }
        }
    }

    #[test]
    fn at_a_break_one_function_is_one_and_slopes_jump() {
        let axis = Axis::new(0.0, 1.0, 0.1, 0.0, 0.5, Basis::Spline2).broken_at([0.3, 0.7, 0.75].into_iter());
        assert_eq!(axis.functions(), 14);
        for knot in [3, 7] {
            let (below, above) = (axis.spline2(knot - 1, axis.knots[knot]), axis.spline2(knot, axis.knots[knot]));
            assert_eq!(below.first + 2, above.first);
            assert!((below.value[2] - 1.0).abs() < 1e-14 && (above.value[0] - 1.0).abs() < 1e-14);
            assert!(below.slope[2] > 10.0 && above.slope[0] < -10.0, "{below:?} {above:?}");
        }
        assert!((0..10).all(|cell| axis.knot_of(axis.first(cell)) == cell));
    }

    #[test]
    fn small_boundary_cells_are_merged() {
        let axis = Axis::new(0.0, 1.0, 0.1, -0.07, 0.5, Basis::Linear);
        assert_eq!(axis.cells(), 10);
        assert!((axis.length(0) - 0.13).abs() < 1e-12 && (axis.length(9) - 0.07).abs() < 1e-12);
        for x in [0.0, 0.129, 0.131, 0.5, 0.92, 0.94, 1.0] {
            let cell = axis.cell(x);
            assert!(axis.knots[cell] <= x && x <= axis.knots[cell + 1], "{x} {cell}");
        }
        assert_eq!(Axis::new(0.0, 1.0, 0.1, 0.0, 0.5, Basis::Spline2).functions(), 12);
    }
}

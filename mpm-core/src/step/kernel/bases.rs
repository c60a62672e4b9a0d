//! Bases along one axis: B-splines of any degree, and linear functions averaged over particles (uGIMP). Every one sums to one and
//! reproduces linear fields up to the sides of the mesh.

use pulp::{Scalar, Simd};

use super::MOST_REACH;
use crate::real::{Lanes, Real};

/// The functions that the particles of a cell reach along one axis, at particles.
#[derive(Debug, Clone, Copy)]
pub struct Line<R> {
    /// Their values; beyond [`Basis::REACH`] none.
    pub value: [R; MOST_REACH],
    /// Their derivatives, per length of a cell.
    pub slope: [R; MOST_REACH],
}

/// A basis along one axis.
pub trait Basis: Copy + Send + Sync + 'static {
    /// Functions that the particles of a cell reach.
    const REACH: usize;
    /// How many of those have a smaller number than the cell.
    const BEFORE: usize;
    /// Functions along an axis are this many more than cells.
    const EXTRA: usize;
    /// What cells have of the sides of the mesh.
    type Edge<V: Simd>: Copy;

    /// For cells at a place in a row of so many.
    fn edge<V: Simd>(&self, position: Lanes<V>, cells: usize) -> Self::Edge<V>;
    /// The functions at a place in these cells.
    fn line<V: Simd>(&self, edge: &Self::Edge<V>, xi: Lanes<V>) -> Line<Lanes<V>>;
    /// The functions at a point of the surface, which may lie a little outside the cell it belongs to.
    #[inline(always)]
    fn at_surface<V: Simd>(&self, edge: &Self::Edge<V>, xi: Lanes<V>) -> Line<Lanes<V>> {
        self.line(edge, xi)
    }
    /// The functions at a place in one cell of a row of so many.
    fn at(&self, cell: usize, cells: usize, xi: f64) -> Line<f64> {
        let edge = self.edge(Lanes::splat(Scalar, cell as f64), cells);
        let line = self.line(&edge, Lanes::splat(Scalar, xi));
        Line { value: line.value.map(|value| value.lane(0)), slope: line.slope.map(|slope| slope.lane(0)) }
    }
    /// Where one of the functions stands in these cells: `sum_i N_i x_i = x`.
    fn stands<V: Simd>(&self, edge: &Self::Edge<V>, function: usize) -> Lanes<V>;
    /// Where a function of a row of cells stands, in cells.
    fn stands_at(&self, function: usize, cells: usize) -> f64;
}

/// B-splines of a degree on open knots: the first and the last coefficient are the values at the sides of the mesh.
///
/// Source: Piegl & Tiller, *The NURBS Book*, 2nd ed. 1997, algorithm A2.2, with the derivatives from its last step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bspline<const DEGREE: usize>;

/// Knots around cells, from `1 - DEGREE` to `DEGREE` of them away, and 1 over their distances.
#[derive(Debug, Clone, Copy)]
pub struct Knots<V: Simd> {
    at: [Lanes<V>; 2 * (MOST_REACH - 1)],
    inverse: [[Lanes<V>; MOST_REACH - 1]; MOST_REACH - 1],
}

impl<const DEGREE: usize> Bspline<DEGREE> {
    /// Knot of so many cells further, minus one.
    #[inline(always)]
    fn knot<V: Simd>(knots: &Knots<V>, after: usize, before: usize) -> Lanes<V> {
        knots.at[DEGREE - 1 + after - before]
    }
}

impl<const DEGREE: usize> Basis for Bspline<DEGREE> {
    const REACH: usize = DEGREE + 1;
    const BEFORE: usize = 0;
    const EXTRA: usize = DEGREE;
    type Edge<V: Simd> = Knots<V>;

    #[inline(always)]
    fn edge<V: Simd>(&self, position: Lanes<V>, cells: usize) -> Knots<V> {
        let none = position.like(0.0);
        // Cells that only pad the mesh are taken for its last ones.
        let position = position.lesser(none.like(cells as f64 - 1.0));
        let mut knots = Knots { at: [none; 2 * (MOST_REACH - 1)], inverse: [[none; MOST_REACH - 1]; MOST_REACH - 1] };
        for k in 0..2 * DEGREE {
            let along = position + none.like(k as f64 + 1.0 - DEGREE as f64);
            knots.at[k] = along.larger(none).lesser(none.like(cells as f64)) - position;
        }
        for j in 1..=DEGREE {
            for r in 0..j {
                let distance = Self::knot(&knots, r + 1, 0) - Self::knot(&knots, r + 1, j);
                knots.inverse[j - 1][r] = none.like(1.0) / distance;
            }
        }
        knots
    }

    #[inline(always)]
    fn line<V: Simd>(&self, knots: &Knots<V>, xi: Lanes<V>) -> Line<Lanes<V>> {
        let none = xi.like(0.0);
        let (mut value, mut slope) = ([none; MOST_REACH], [none; MOST_REACH]);
        value[0] = none.like(1.0);
        for j in 1..=DEGREE {
            let mut saved = none;
            for r in 0..j {
                let share = value[r] * knots.inverse[j - 1][r];
                value[r] = saved + (Self::knot(knots, r + 1, 0) - xi) * share;
                saved = (xi - Self::knot(knots, r + 1, j)) * share;
                if j == DEGREE {
                    slope[r] -= share * DEGREE as f64;
                    slope[r + 1] += share * DEGREE as f64;
                }
            }
            value[j] = saved;
        }
        Line { value, slope }
    }

    /// Mean of the inner knots of the function (Greville).
    #[inline(always)]
    fn stands<V: Simd>(&self, knots: &Knots<V>, function: usize) -> Lanes<V> {
        let mut sum = knots.at[function];
        for k in 1..DEGREE {
            sum += knots.at[function + k];
        }
        sum * (1.0 / DEGREE as f64)
    }

    fn stands_at(&self, function: usize, cells: usize) -> f64 {
        let knot = |i: usize| (i.max(DEGREE) - DEGREE).min(cells) as f64;
        (1..=DEGREE).map(|k| knot(function + k)).sum::<f64>() / DEGREE as f64
    }
}

/// uGIMP: linear functions averaged over the particle's first size, `S_i = 1/(2 l) int N_i` from x - l to x + l.
///
/// Source: Bardenhagen & Kober, *CMES* 5(6), 2004, 477-495. Where the particle sticks out of the mesh, the field is
/// continued linearly: a node outside stands for `2 f_0 - f_1`, so constant and linear fields stay exact.
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

/// Which cells are the first and the last of their row: 1, else 0.
#[derive(Debug, Clone, Copy)]
pub struct Ends<V: Simd> {
    first: Lanes<V>,
    last: Lanes<V>,
    /// Whether any is.
    is_outer: bool,
}

impl<V: Simd> Ends<V> {
    /// What three nodes have, from the first or the second of four on.
    #[inline(always)]
    fn spread(&self, is_left: V::m64s, [first, middle, last]: [Lanes<V>; 3]) -> [Lanes<V>; MOST_REACH] {
        let none = first.like(0.0);
        let mut of =
            [first.or(is_left, none), middle.or(is_left, first), last.or(is_left, middle), none.or(is_left, last)];
        if self.is_outer {
            fold(&mut of, [0, 1, 2], self.first);
            fold(&mut of, [3, 2, 1], self.last);
        }
        of
    }
}

/// Node `out` outside stands for twice the next one less the one after that.
#[inline(always)]
fn fold<V: Simd>(of: &mut [Lanes<V>; MOST_REACH], [out, next, after]: [usize; 3], share: Lanes<V>) {
    let outside = of[out] * share;
    of[next] += outside * 2.0;
    of[after] -= outside;
    of[out] -= outside;
}

impl Basis for Gimp {
    const REACH: usize = 4;
    const BEFORE: usize = 1;
    const EXTRA: usize = 1;
    type Edge<V: Simd> = Ends<V>;

    #[inline(always)]
    fn edge<V: Simd>(&self, position: Lanes<V>, cells: usize) -> Ends<V> {
        let (none, one) = (position.like(0.0), position.like(1.0));
        let end = cells as f64 - 1.0;
        let mut is_outer = false;
        for lane in 0..Lanes::<V>::COUNT {
            let at = position.lane(lane);
            is_outer |= at <= 0.0 || at >= end;
        }
        let first = one.or(position.equals(none), none);
        Ends { first, last: one.or(position.equals(none.like(end)), none), is_outer }
    }

    #[inline(always)]
    fn line<V: Simd>(&self, ends: &Ends<V>, xi: Lanes<V>) -> Line<Lanes<V>> {
        let (none, one) = (xi.like(0.0), xi.like(1.0));
        let (low, high, per) = (xi - none.like(self.half), xi + none.like(self.half), 0.5 / self.half);
        // A particle is no longer than a cell: it has at most one node inside, and reaches a and c to both sides of it.
        let is_left = low.below(none);
        let middle = none.or(is_left, one);
        let (a, b, c) = (middle - low, (middle - high).larger(none), (high - middle).larger(none));
        let (first, last) = ((a * a - b * b) * (0.5 * per), c * c * (0.5 * per));
        let (fall, rise) = ((b - a) * per, c * per);
        // The middle one is what remains of constant fields.
        let value = ends.spread(is_left, [first, one - first - last, last]);
        Line { value, slope: ends.spread(is_left, [fall, -fall - rise, rise]) }
    }

    /// The load acts at a point, which has no size.
    #[inline(always)]
    fn at_surface<V: Simd>(&self, _: &Ends<V>, xi: Lanes<V>) -> Line<Lanes<V>> {
        let (none, one) = (xi.like(0.0), xi.like(1.0));
        Line { value: [none, one - xi, xi, none], slope: [none, -one, one, none] }
    }

    #[inline(always)]
    fn stands<V: Simd>(&self, ends: &Ends<V>, function: usize) -> Lanes<V> {
        ends.first.like(function as f64 - 1.0)
    }

    fn stands_at(&self, function: usize, _: usize) -> f64 {
        function as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lone(number: f64) -> Lanes<Scalar> {
        Lanes::splat(Scalar, number)
    }

    /// Partition of unity, linear completeness with the places where the functions stand, slopes by central differences.
    fn check(basis: &impl Basis, kinks: &[f64]) {
        for cells in [1, 2, 3, 5] {
            for cell in 0..cells {
                let edge = basis.edge(lone(cell as f64), cells);
                for step in 0..40 {
                    let xi = (f64::from(step) + 0.37) / 40.0;
                    let line = |xi: f64| {
                        let line = basis.line(&edge, lone(xi));
                        [line.value, line.slope].map(|of| of.map(|number| number.lane(0)))
                    };
                    let [value, slope] = line(xi);
                    let sum = |f: &dyn Fn(usize) -> f64| (0..MOST_REACH).map(f).sum::<f64>();
                    let stands = |k: usize| {
                        if value[k] == 0.0 && slope[k] == 0.0 { 0.0 } else { basis.stands(&edge, k).lane(0) }
                    };
                    let case = format!("cell {cell} of {cells}, xi = {xi}: {value:?} {slope:?}");
                    assert!((sum(&|k| value[k]) - 1.0).abs() < 1e-14, "sum N, {case}");
                    assert!(sum(&|k| slope[k]).abs() < 1e-13, "sum G, {case}");
                    assert!((sum(&|k| value[k] * stands(k)) - xi).abs() < 1e-13, "x, {case}");
                    assert!((sum(&|k| slope[k] * stands(k)) - 1.0).abs() < 1e-13, "dx/dx, {case}");
                    assert!(value.iter().all(|v| *v >= 0.0), "N >= 0, {case}");
                    let h = 1e-6;
                    if kinks.iter().any(|kink| (xi - kink).abs() < 2.0 * h) {
                        continue;
                    }
                    let ([low, _], [high, _]) = (line(xi - h), line(xi + h));
                    for k in 0..MOST_REACH {
                        let difference = (high[k] - low[k]) / (2.0 * h);
                        assert!((slope[k] - difference).abs() < 1e-8, "slope {k}, {case}");
                    }
                    for k in (0..MOST_REACH).filter(|k| value[*k] != 0.0) {
                        let at = basis.stands_at(cell + k - usize::from(cell + k >= 1) * basis_before(basis), cells);
                        assert!((at - cell as f64 - stands(k)).abs() < 1e-13, "stands at {at}, {case}");
                    }
                }
            }
        }
    }

    fn basis_before<B: Basis>(_: &B) -> usize {
        B::BEFORE
    }

    #[test]
    fn splines_are_complete() {
        check(&Bspline::<1>, &[]);
        check(&Bspline::<2>, &[]);
        check(&Bspline::<3>, &[]);
    }

    #[test]
    fn averaged_functions_are_complete() {
        for per_direction in 1..=4 {
            let gimp = Gimp::new(per_direction);
            check(&gimp, &[gimp.half, 1.0 - gimp.half]);
        }
    }

    #[test]
    #[should_panic(expected = "sum N")]
    fn check_can_fail() {
        #[derive(Clone, Copy)]
        struct Leaky;
        impl Basis for Leaky {
            const REACH: usize = 3;
            const BEFORE: usize = 0;
            const EXTRA: usize = 2;
            type Edge<V: Simd> = Knots<V>;
            fn edge<V: Simd>(&self, position: Lanes<V>, cells: usize) -> Knots<V> {
                Bspline::<2>.edge(position, cells)
            }
            fn line<V: Simd>(&self, edge: &Knots<V>, xi: Lanes<V>) -> Line<Lanes<V>> {
                let mut line = Bspline::<2>.line(edge, xi);
                line.value[1] -= xi.like(1e-12);
                line
            }
            fn stands<V: Simd>(&self, edge: &Knots<V>, function: usize) -> Lanes<V> {
                Bspline::<2>.stands(edge, function)
            }
            fn stands_at(&self, function: usize, cells: usize) -> f64 {
                Bspline::<2>.stands_at(function, cells)
            }
        }
        check(&Leaky, &[]);
    }

    #[test]
    fn splines_are_smooth_across_knots() {
        for cell in 0..3 {
            let at = |cell: usize, xi: f64| Bspline::<3>.line(&Bspline::<3>.edge(lone(cell as f64), 4), lone(xi));
            let (before, after) = (at(cell, 1.0), at(cell + 1, 0.0));
            for k in 0..3 {
                assert!((before.value[k + 1] - after.value[k]).lane(0).abs() < 1e-15, "value at knot {}", cell + 1);
                assert!((before.slope[k + 1] - after.slope[k]).lane(0).abs() < 1e-15, "slope at knot {}", cell + 1);
            }
        }
    }

    #[test]
    fn an_average_is_that_of_the_linear_functions() {
        let gimp = Gimp::new(2);
        let hat = |s: f64| (1.0 - s.abs()).max(0.0);
        // Midpoint rule over the particle on both sides of the node 2.
        let (cell, xi, points) = (1, 0.9, 1000);
        let line = gimp.line(&gimp.edge(lone(f64::from(cell)), 4), lone(xi));
        for k in 0..4 {
            let node = f64::from(cell + k - 1);
            let mean: f64 = (0..points)
                .map(|i| hat(1.9 + gimp.half * (f64::from(2 * i + 1) / f64::from(points) - 1.0) - node))
                .sum::<f64>()
                / f64::from(points);
            assert!((line.value[k as usize].lane(0) - mean).abs() < 1e-6, "{k}: {mean}");
        }
    }
}

//! Bases along one axis: B-splines of any degree, and linear functions averaged over particles (uGIMP). Every one sums to one and
//! reproduces linear fields up to the sides of the mesh.

use pulp::{Scalar, Simd};

use super::MOST_REACH;
use crate::real::{Real, SimdReal};

/// The functions that particles reach along one axis.
#[derive(Debug, Clone, Copy)]
pub struct Line<R> {
    /// Their values, none beyond the last.
    pub value: [R; MOST_REACH],
    /// Their derivatives, per length of a cell.
    pub slope: [R; MOST_REACH],
}

/// A basis along one axis.
pub trait Basis: Copy + Send + Sync + 'static {
    /// Functions that the particles of a cell reach.
    const REACH: usize;
    /// Functions that one particle reaches.
    const SPAN: usize = Self::REACH;
    /// How many of those of the cell have a smaller number than it.
    const BEFORE: usize;
    /// Functions along an axis are this many more than cells.
    const EXTRA: usize;
    /// What cells have of the sides of the mesh.
    type Edge<V: Simd>: Copy;

    /// For cells at a place in a row of so many.
    fn edge<V: Simd>(&self, position: SimdReal<V>, cells: usize) -> Self::Edge<V>;
    /// The first of the [`Basis::SPAN`] functions that particles at a place in their cells reach, if it is the same in all lanes.
    #[inline(always)]
    fn first<V: Simd>(&self, _: SimdReal<V>) -> Option<usize> {
        Some(0)
    }
    /// The functions at a place in these cells: from the first that they all reach on, or all that these cells do. Those beyond a
    /// side of the mesh are still to be folded.
    fn line<V: Simd>(&self, edge: &Self::Edge<V>, xi: SimdReal<V>, first: Option<usize>) -> Line<SimdReal<V>>;
    /// Whether any of these cells has functions beyond a side of the mesh.
    #[inline(always)]
    fn reaches_out<V: Simd>(&self, _: &Self::Edge<V>) -> bool {
        false
    }
    /// `true` extends a field to the functions beyond the sides of the mesh; `false` folds: gives what those have got to the ones that
    /// they depend on.
    #[inline(always)]
    fn beyond<V: Simd>(&self, _: &Self::Edge<V>, _: &mut [SimdReal<V>; MOST_REACH], _: bool) {}
    /// The functions at a point of the surface, which may lie a little outside the cell it belongs to.
    #[inline(always)]
    fn at_surface<V: Simd>(&self, edge: &Self::Edge<V>, xi: SimdReal<V>) -> Line<SimdReal<V>> {
        self.line(edge, xi, None)
    }
    /// The functions at a place in one cell of a row of so many.
    fn at(&self, cell: usize, cells: usize, xi: f64) -> Line<f64> {
        let edge = self.edge(SimdReal::splat(Scalar, cell as f64), cells);
        let mut line = self.line(&edge, SimdReal::splat(Scalar, xi), None);
        self.beyond(&edge, &mut line.value, false);
        self.beyond(&edge, &mut line.slope, false);
        Line { value: line.value.map(|value| value.lane(0)), slope: line.slope.map(|slope| slope.lane(0)) }
    }
    /// Where one of the functions stands in these cells: `sum_i N_i x_i = x`.
    fn stands<V: Simd>(&self, edge: &Self::Edge<V>, function: usize) -> SimdReal<V>;
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
    at: [SimdReal<V>; 2 * (MOST_REACH - 1)],
    inverse: [[SimdReal<V>; MOST_REACH - 1]; MOST_REACH - 1],
}

impl<const DEGREE: usize> Bspline<DEGREE> {
    /// Knot of so many cells further, minus one.
    #[inline(always)]
    fn knot<V: Simd>(knots: &Knots<V>, after: usize, before: usize) -> SimdReal<V> {
        knots.at[DEGREE - 1 + after - before]
    }
}

impl<const DEGREE: usize> Basis for Bspline<DEGREE> {
    const REACH: usize = DEGREE + 1;
    const BEFORE: usize = 0;
    const EXTRA: usize = DEGREE;
    type Edge<V: Simd> = Knots<V>;

    #[inline(always)]
    fn edge<V: Simd>(&self, position: SimdReal<V>, cells: usize) -> Knots<V> {
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
    fn line<V: Simd>(&self, knots: &Knots<V>, xi: SimdReal<V>, _: Option<usize>) -> Line<SimdReal<V>> {
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
    fn stands<V: Simd>(&self, knots: &Knots<V>, function: usize) -> SimdReal<V> {
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
/// Source: Bardenhagen & Kober, *CMES* 5(6), 2004, 477-496. Where the particle sticks out of the mesh, the field is
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

/// Which cells are the first and the last of their row.
#[derive(Debug, Clone, Copy)]
pub struct Ends<V: Simd> {
    first: V::m64s,
    last: V::m64s,
    /// Whether any is.
    is_outer: bool,
    simd: V,
}

/// What three nodes have, from the one out there on: as three in order if those are the same in all lanes, else as four.
#[inline(always)]
fn spread<V: Simd>(
    first: Option<usize>,
    is_low: V::m64s,
    [out, near, far]: [SimdReal<V>; 3],
) -> [SimdReal<V>; MOST_REACH] {
    let none = out.like(0.0);
    match first {
        Some(_) => [out.or(is_low, far), near, far.or(is_low, out), none],
        None => [out.or(is_low, none), near.or(is_low, far), far.or(is_low, near), none.or(is_low, out)],
    }
}

impl Basis for Gimp {
    const REACH: usize = 4;
    const SPAN: usize = 3;
    const BEFORE: usize = 1;
    const EXTRA: usize = 1;
    type Edge<V: Simd> = Ends<V>;

    #[inline(always)]
    fn edge<V: Simd>(&self, position: SimdReal<V>, cells: usize) -> Ends<V> {
        let first = position.equals(position.like(0.0));
        let last = position.equals(position.like(cells as f64 - 1.0));
        let simd = position.simd;
        Ends { first, last, is_outer: !SimdReal::nowhere(simd, simd.or_m64s(first, last)), simd }
    }

    /// A particle is no longer than a cell. In the lower half of its cell it may reach over the lower node, in the upper half over
    /// the upper one; in the middle it reaches neither way, and may be taken for either.
    #[inline(always)]
    fn first<V: Simd>(&self, xi: SimdReal<V>) -> Option<usize> {
        let half = xi.like(0.5);
        if SimdReal::nowhere(xi.simd, half.below(xi)) {
            Some(0)
        } else if SimdReal::nowhere(xi.simd, xi.below(half)) {
            Some(1)
        } else {
            None
        }
    }

    #[inline(always)]
    fn line<V: Simd>(&self, _: &Ends<V>, xi: SimdReal<V>, first: Option<usize>) -> Line<SimdReal<V>> {
        let (none, one, per) = (xi.like(0.0), xi.like(1.0), 0.5 / self.half);
        let is_low = match first {
            Some(0) => none.below(one),
            Some(_) => one.below(none),
            None => xi.below(xi.like(0.5)),
        };
        // By the distance s to the nearer node, over which it reaches by a = l - s: S = a^2/4l at the node out there, s + a^2/4l at the
        // far one, and at the near one what remains of constant fields.
        let near = xi.or(is_low, one - xi);
        let over = (none.like(self.half) - near).larger(none);
        let (out, fall) = (over * over * (0.5 * per), over * per);
        let value = [out, one - near - out * 2.0, near + out];
        let sign = one.or(is_low, -one);
        let slope = [-fall * sign, (fall * 2.0 - one) * sign, (one - fall) * sign];
        Line { value: spread(first, is_low, value), slope: spread(first, is_low, slope) }
    }

    #[inline(always)]
    fn reaches_out<V: Simd>(&self, ends: &Ends<V>) -> bool {
        ends.is_outer
    }

    /// A node outside stands for twice the next one less the one after that.
    #[inline(always)]
    fn beyond<V: Simd>(&self, ends: &Ends<V>, of: &mut [SimdReal<V>; MOST_REACH], extends: bool) {
        let none = of[0].like(0.0);
        for ([out, next, after], side) in [([0, 1, 2], ends.first), ([3, 2, 1], ends.last)] {
            if extends {
                of[out] = (of[next] * 2.0 - of[after]).or(side, of[out]);
            } else {
                let outside = of[out].or(side, none);
                of[next] += outside * 2.0;
                of[after] -= outside;
                of[out] -= outside;
            }
        }
    }

    /// The load acts at a point, which has no size.
    #[inline(always)]
    fn at_surface<V: Simd>(&self, _: &Ends<V>, xi: SimdReal<V>) -> Line<SimdReal<V>> {
        let (none, one) = (xi.like(0.0), xi.like(1.0));
        Line { value: [none, one - xi, xi, none], slope: [none, -one, one, none] }
    }

    #[inline(always)]
    fn stands<V: Simd>(&self, ends: &Ends<V>, function: usize) -> SimdReal<V> {
        SimdReal::splat(ends.simd, function as f64 - 1.0)
    }

    fn stands_at(&self, function: usize, _: usize) -> f64 {
        function as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lone(number: f64) -> SimdReal<Scalar> {
        SimdReal::splat(Scalar, number)
    }

    /// Partition of unity, linear completeness with the places where the functions stand, slopes by central differences.
    fn check(basis: &impl Basis, kinks: &[f64]) {
        for cells in [1, 2, 3, 5] {
            for cell in 0..cells {
                let edge = basis.edge(lone(cell as f64), cells);
                for step in 0..40 {
                    let xi = (f64::from(step) + 0.37) / 40.0;
                    let line = |xi: f64| {
                        let line = basis.at(cell, cells, xi);
                        [line.value, line.slope]
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
            fn edge<V: Simd>(&self, position: SimdReal<V>, cells: usize) -> Knots<V> {
                Bspline::<2>.edge(position, cells)
            }
            fn line<V: Simd>(&self, edge: &Knots<V>, xi: SimdReal<V>, first: Option<usize>) -> Line<SimdReal<V>> {
                let mut line = Bspline::<2>.line(edge, xi, first);
                line.value[1] -= xi.like(1e-12);
                line
            }
            fn stands<V: Simd>(&self, edge: &Knots<V>, function: usize) -> SimdReal<V> {
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
            let at = |cell: usize, xi: f64| Bspline::<3>.at(cell, 4, xi);
            let (before, after) = (at(cell, 1.0), at(cell + 1, 0.0));
            for k in 0..3 {
                assert!((before.value[k + 1] - after.value[k]).abs() < 1e-15, "value at knot {}", cell + 1);
                assert!((before.slope[k + 1] - after.slope[k]).abs() < 1e-15, "slope at knot {}", cell + 1);
            }
        }
    }

    /// However many functions lanes take together, the bits of a particle are the same.
    #[test]
    fn a_particle_reaches_three_of_four() {
        for per_direction in 1..=4 {
            let gimp = Gimp::new(per_direction);
            let edge = gimp.edge(lone(1.0), 3);
            for xi in (-2..=42).map(|step| lone(f64::from(step) / 40.0)) {
                let all = gimp.line(&edge, xi, None);
                let firsts = if xi.lane(0) == 0.5 { vec![0, 1] } else { vec![gimp.first(xi).expect("one lane")] };
                for first in firsts {
                    let some = gimp.line(&edge, xi, Some(first));
                    for (some, all) in [(some.value, all.value), (some.slope, all.slope)] {
                        for k in 0..4 {
                            let own =
                                if (first..first + Gimp::SPAN).contains(&k) { some[k - first].lane(0) } else { 0.0 };
                            assert_eq!(own, all[k].lane(0), "{k} of {per_direction} at {:?}", xi.lane(0));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn an_average_is_that_of_the_linear_functions() {
        let gimp = Gimp::new(2);
        let hat = |s: f64| (1.0 - s.abs()).max(0.0);
        // Midpoint rule over the particle on both sides of the node 2.
        let (cell, xi, points) = (1, 0.9, 1000);
        let line = gimp.at(cell as usize, 4, xi);
        for k in 0..4 {
            let node = f64::from(cell + k - 1);
            let mean: f64 = (0..points)
                .map(|i| hat(1.9 + gimp.half * (f64::from(2 * i + 1) / f64::from(points) - 1.0) - node))
                .sum::<f64>()
                / f64::from(points);
            assert!((line.value[k as usize] - mean).abs() < 1e-6, "{k}: {mean}");
        }
    }
}

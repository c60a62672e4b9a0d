//! Weights of particles that integrate products of slopes exactly.
//!
//! Slopes of B-splines of degree p have p - 2 continuous derivatives, so products of two of them are splines of degree
//! 2 (p - 1) with as many. The weights are those nearest to the particles' volumes, `min sum (w - V)^2`, that integrate every
//! such spline on the cells exactly: the basis then keeps its order, also when particles have moved. A weight is never less
//! than a twentieth of its volume: those that would be are fixed there and the rest is fitted again. Where B-splines have a
//! break, products of slopes jump, and so do the functions that are integrated.

use super::Axis;
use super::splines::{Local, Splines};
use crate::sparse::{Factor, Ordering, Signs, Sparse};

/// Least weight as a share of the volume.
const LEAST: f64 = 0.05;
/// Rounds of holding small weights.
const ROUNDS: usize = 15;
/// Largest error of an integral, as a share of a cell's volume, for a fit that counts as exact.
const EXACT: f64 = 1e-9;

/// Fitted weights.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// One per point, m3.
    pub weights: Vec<f64>,
    /// Degree of the B-splines whose products of slopes are integrated exactly: 1 for what is linear in a cell and continuous,
    /// 0 for the particles' own volumes.
    pub degree: usize,
    /// Largest error of an integral as a share of a cell's volume.
    pub residual: f64,
}

/// Fits weights to points (m) with volumes (m3) in the cells of the axes, for B-splines of a degree; `thickness` (m^(3-D)) turns
/// lengths into volumes. Falls back to a lower degree where there are too few points.
pub fn fit<const D: usize>(
    axes: &[Axis; D],
    degree: usize,
    thickness: f64,
    points: &[[f64; D]],
    volumes: &[f64],
) -> Fit {
    for degree in (1..=degree).rev() {
        if let Some(fit) = Moments::new(axes, thickness, points, degree).fit(volumes)
            && fit.residual <= EXACT
        {
            return fit;
        }
    }
    let residual = Moments::new(axes, thickness, points, 1).residual(volumes);
    Fit { weights: volumes.to_vec(), degree: 0, residual }
}

/// Integrals of splines: what they should be, and the functions at the points.
struct Moments {
    target: Vec<f64>,
    /// That of the B-splines whose slopes are multiplied.
    degree: usize,
    /// Functions per point.
    support: usize,
    number: Vec<u32>,
    value: Vec<f64>,
    cell_volume: f64,
}

/// Products of slopes of B-splines of a degree. Those of linear functions are constant in a cell; weights for continuous linear
/// functions serve the loads as well.
fn products(axis: &Axis, degree: usize) -> Splines {
    let of = if degree == 1 { 1 } else { 2 * (degree - 1) };
    Splines::new(&axis.knots, of, |knot| if axis.is_break(knot) { of + 1 } else { degree })
}

impl Moments {
    fn new<const D: usize>(axes: &[Axis; D], thickness: f64, points: &[[f64; D]], degree: usize) -> Self {
        let splines: [Splines; D] = std::array::from_fn(|d| products(&axes[d], degree));
        let total: usize = splines.iter().map(Splines::count).product();
        let target = (0..total)
            .map(|index| {
                let mut rest = index;
                splines.iter().fold(thickness, |product, along| {
                    let i = rest % along.count();
                    rest /= along.count();
                    product * along.integral(i)
                })
            })
            .collect();
        let along = splines[0].support();
        let support = along.pow(D as u32);
        let (mut number, mut value) =
            (Vec::with_capacity(points.len() * support), Vec::with_capacity(points.len() * support));
        for x in points {
            let local: [Local; D] = std::array::from_fn(|d| splines[d].at(axes[d].cell(x[d]), x[d]));
            for function in 0..support {
                let (mut rest, mut index, mut stride, mut product) = (function, 0, 1, 1.0);
                for d in 0..D {
                    let i = rest % along;
                    rest /= along;
                    index += (local[d].first + i) * stride;
                    stride *= splines[d].count();
                    product *= local[d].value[i];
                }
                number.push(index as u32);
                value.push(product);
            }
        }
        let cell_volume = axes.iter().fold(thickness, |v, axis| v * axis.size);
        Self { target, degree, support, number, value, cell_volume }
    }

    /// What is missing of each integral.
    fn missing(&self, weights: &[f64]) -> Vec<f64> {
        let mut missing = self.target.clone();
        for (point, w) in weights.iter().enumerate() {
            for k in point * self.support..(point + 1) * self.support {
                missing[self.number[k] as usize] -= w * self.value[k];
            }
        }
        missing
    }

    fn residual(&self, weights: &[f64]) -> f64 {
        self.missing(weights).iter().fold(0.0, |m, r| f64::max(m, r.abs())) / self.cell_volume
    }

    /// Least change of the volumes by `w = V + A^T lambda`, `A A^T lambda = b - A V`. `None` with too few points.
    fn fit(&self, volumes: &[f64]) -> Option<Fit> {
        let degree = self.degree;
        let mut weights = volumes.to_vec();
        let residual = self.residual(&weights);
        if residual <= EXACT {
            return Some(Fit { weights, degree, residual });
        }
        let size = self.target.len();
        if volumes.len() < size {
            return None;
        }
        let mut gram = self.pattern(size);
        let mut factor = Factor::new(&gram, Signs::Definite, Ordering::MinimumDegree).ok()?;
        let (mut held, mut lambda) = (vec![false; volumes.len()], vec![0.0; size]);
        for _ in 0..ROUNDS {
            gram.values.fill(0.0);
            for point in (0..volumes.len()).filter(|p| !held[*p]) {
                self.add_to(&mut gram, point);
            }
            factor.refresh(&gram).ok()?;
            for (point, w) in weights.iter_mut().enumerate() {
                *w = if held[point] { LEAST * volumes[point] } else { volumes[point] };
            }
            factor.solve(&gram, &self.missing(&weights), &mut lambda).ok()?;
            let mut more = false;
            for point in (0..volumes.len()).filter(|p| !held[*p]) {
                for k in point * self.support..(point + 1) * self.support {
                    weights[point] += self.value[k] * lambda[self.number[k] as usize];
                }
            }
            for point in 0..volumes.len() {
                let small = !held[point] && weights[point] < LEAST * volumes[point];
                held[point] |= small;
                more |= small;
            }
            if !more {
                let residual = self.residual(&weights);
                return Some(Fit { weights, degree, residual });
            }
        }
        None
    }

    fn pattern(&self, size: usize) -> Sparse {
        let cliques = cliques(&self.number, self.support);
        Sparse::symmetric(
            size,
            cliques.flat_map(|c| c.iter().flat_map(move |a| c.iter().map(move |b| (*a as usize, *b as usize)))),
        )
    }

    fn add_to(&self, gram: &mut Sparse, point: usize) {
        let range = point * self.support..(point + 1) * self.support;
        for a in range.clone() {
            for b in range.start..=a {
                gram.add(self.number[a] as usize, self.number[b] as usize, self.value[a] * self.value[b]);
            }
        }
    }
}

/// Functions of the points one after the other, each set of functions once where points of a cell follow each other.
fn cliques(number: &[u32], support: usize) -> impl Iterator<Item = &[u32]> + Clone {
    let mut last: &[u32] = &[];
    number.chunks(support).filter(move |functions| {
        let new = last != *functions;
        last = functions;
        new
    })
}

#[cfg(test)]
mod tests {
    use super::super::{Basis, gauss};
    use super::*;

    fn points(cells: usize, per_cell: usize, shift: impl Fn(f64) -> f64) -> Vec<[f64; 1]> {
        let count = cells * per_cell;
        (0..count).map(|i| (i as f64 + 0.5) / count as f64).map(|x| [x + shift(x)]).collect()
    }

    #[test]
    fn moved_particles_integrate_products_of_slopes_exactly() {
        for (degree, per_cell) in [(2, 3), (3, 4)] {
            let count = 10 * per_cell;
            let spacing = 1.0 / count as f64;
            let moved = |x: f64| 0.5 * spacing * (std::f64::consts::TAU * x).sin() + 0.25 * spacing * (517.0 * x).sin();
            for offset in [0.0, -0.03, -0.05, -0.08] {
                let x = points(10, per_cell, moved);
                let volumes = vec![spacing; count];
                let tries = [0.5, 0.75, 1.0].map(|least| {
                    let axis = [Axis::new(0.0, 1.0, 0.1, offset, least, Basis::Splines { degree })];
                    (fit(&axis, degree, 1.0, &x, &volumes), axis)
                });
                let (fitted, axis) = tries.iter().find(|(fit, _)| fit.degree == degree).expect("a fit");
                let least = fitted.weights.iter().fold(1.0, |m, w| f64::min(m, w / spacing));
                assert!(least >= LEAST, "{least}");
                // The stiffness of the basis against Gauss points.
                let product = |x: f64, a: usize, b: usize| {
                    let local = axis[0].at(x);
                    let slope = |f: usize| f.checked_sub(local.first).and_then(|i| local.slope.get(i)).copied();
                    slope(a).unwrap_or(0.0) * slope(b).unwrap_or(0.0)
                };
                for a in 0..axis[0].functions() {
                    for b in a..(a + degree + 1).min(axis[0].functions()) {
                        let by_particles: f64 =
                            x.iter().zip(&fitted.weights).map(|(x, w)| w * product(x[0], a, b)).sum();
                        let of = |c: usize| gauss(axis[0].knots[c], axis[0].knots[c + 1], 1, |x| product(x, a, b));
                        let exact: f64 = (0..axis[0].cells()).map(of).sum();
                        assert!((by_particles - exact).abs() < 1e-7 * 13.0, "{offset} {a} {b} {by_particles} {exact}");
                    }
                }
            }
        }
    }

    #[test]
    fn too_few_particles_fall_back() {
        let axis = [Axis::new(0.0, 1.0, 0.1, 0.0, 0.5, Basis::Splines { degree: 2 })];
        assert_eq!(fit(&axis, 2, 1.0, &points(10, 2, |_| 0.0), &[0.05; 20]).degree, 1);
        assert_eq!(fit(&axis, 2, 1.0, &points(10, 1, |x| 0.01 * (9.0 * x).sin()), &[0.1; 10]).degree, 0);
    }
}

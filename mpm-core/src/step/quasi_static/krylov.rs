//! All times of a stage from one factorisation: shift-invert rational Krylov for linear scenes.
//!
//! With displacements eliminated a linear scene is `A dp/dt = -H p`, A and H symmetric, under a constant load. One
//! backward Euler step of length gamma maps `p` to `B p` with `B = (A + gamma H)^-1 A` (about the drained state). The
//! exact solution from the state before the load, whose water content is w_0, is a function of B:
//!
//! `p(t) = h(B) y_1`, `h(mu) = exp(-t (1/mu - 1)/gamma)/mu`, `y_1` the step from w_0,
//!
//! and because h(1) = 1 it is `y_1 - g(B) d`, `g(mu) = (1 - h(mu))/(1 - mu)`, with `d = y_1 - y_2` the difference of
//! two steps. A d is a difference of water contents, so the drained state is never needed. Lanczos in the inner
//! product of A makes a basis V of the Krylov space of d, where B is a small tridiagonal matrix T:
//! `y(t) = y_1 - |d| V g(T) e_1` (Moret & Novati 2004, BIT 44, 595-615; van den Eshof & Hochbruck 2006, SIAM J. Sci.
//! Comput. 27, 1438-1457). Each vector carries its displacements along.

use nalgebra::{DMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};

use super::march::work_of;
use super::newton::{Stage, Workspace};
use super::soil::{HELD, Soil};
use super::tangent::Stuck;
use crate::constitutive::Law;

/// Most basis vectors.
const MOST: usize = 60;
/// A direction that can change the state by no more than this share is round-off.
const BREAKDOWN: f64 = 1e-13;
/// How far `v^T A B w` may be from `w^T A B v`: round-off, which grows from vector to vector where steps hardly change them. With
/// more of it the last one is left out.
const SPOILT: f64 = 0.1;

/// The evolution of a linear scene under a constant load.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Krylov {
    /// y_1.
    first: Vec<f64>,
    /// The basis, |d| = `size`.
    basis: Vec<Vec<f64>>,
    size: f64,
    /// What y_1 and the vectors of the basis mean for the balances.
    of_first: Meaning,
    meanings: Vec<Meaning>,
    gamma: f64,
    ritz: Ritz,
    /// Weights of the basis at a time: of the state, and of its integral from the start of the stage.
    #[serde(skip)]
    weights: [Vec<f64>; 2],
    /// Change of the state by each of the last two basis vectors, at the time where it is largest: relative to the settlement, and
    /// of the pressure in the norm of A.
    pub estimate: f64,
}

/// What unknowns mean for the balances: linear functions of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Meaning {
    /// What leaves through drained faces, less the flow to functions whose pressure is fixed, m3/s; of an integral m3.
    pub passed: f64,
    /// Water content of those functions, m3.
    pub held: f64,
    /// Work of the load, J.
    pub work: f64,
}

impl Meaning {
    /// That of the fields of a soil, whose flow has been found.
    fn of<L: Law, const D: usize>(soil: &Soil<L, D>) -> Self {
        Self {
            passed: soil.values.outflow - soil.held(&soil.values.flow),
            held: soil.held_content(),
            work: work_of(&soil.load, &soil.u),
        }
    }

    fn add(&mut self, factor: f64, other: &Self) {
        self.passed += factor * other.passed;
        self.held += factor * other.held;
        self.work += factor * other.work;
    }
}

/// T and what depends on it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Ritz {
    values: Vec<f64>,
    /// The eigenvectors, one after the other.
    vectors: Vec<f64>,
}

impl Ritz {
    fn new(t: &[[f64; 2]]) -> Self {
        let size = t.len();
        let mut matrix = DMatrix::zeros(size, size);
        for (k, [diagonal, below]) in t.iter().enumerate() {
            matrix[(k, k)] = *diagonal;
            if k + 1 < size {
                (matrix[(k, k + 1)], matrix[(k + 1, k)]) = (*below, *below);
            }
        }
        let eigen = SymmetricEigen::new(matrix);
        // B lies between 0 and 1; round-off may not.
        let values = eigen.eigenvalues.iter().map(|mu| mu.clamp(1e-15, 1.0)).collect();
        Self { values, vectors: eigen.eigenvectors.as_slice().to_vec() }
    }

    /// Adds `f(T) e_1` at the end.
    fn apply(&self, f: impl Fn(f64) -> f64, to: &mut Vec<f64>) {
        let first = to.len();
        to.resize(first + self.values.len(), 0.0);
        for (mu, vector) in self.values.iter().zip(self.vectors.chunks_exact(self.values.len().max(1))) {
            add(&mut to[first..], f(*mu) * vector[0], vector);
        }
    }
}

/// `g(mu) = (1 - h(mu))/(1 - mu)` at a time, tau = t/gamma.
fn gap(mu: f64, tau: f64) -> f64 {
    let s = 1.0 - mu;
    if s < 1e-12 { tau - 1.0 } else { -f64::exp_m1(-tau * s / mu - f64::ln(mu)) / s }
}

/// `int_0^tau g dtau'`.
fn gap_integral(mu: f64, tau: f64) -> f64 {
    let s = 1.0 - mu;
    if s < 1e-5 { 0.5 * tau * tau - tau } else { (tau + f64::exp_m1(-tau * s / mu) / s) / s }
}

impl Krylov {
    /// Builds a basis that holds the state at all `times` (s since the start of the stage); `content` is the water
    /// content before the load, m3. [`Self::estimate`] says whether the goal was reached.
    pub fn new<L: Law, const D: usize>(
        soil: &mut Soil<L, D>,
        content: &[f64],
        times: &[f64],
        goal: &Goal,
        work: &mut Workspace,
    ) -> Result<Self, Stuck<D>> {
        let gamma = goal.pole;
        soil.refresh(gamma)?;
        let unknowns = soil.unknowns();
        let stage = |target| Stage { a: gamma, target, tolerance: 0.0 };
        let mut first = vec![0.0; unknowns];
        soil.fulfil(&stage(content), &mut first, work)?;
        let (after, of_first) = (soil.values.content.clone(), Meaning::of(soil));
        let mut second = first.clone();
        soil.fulfil_from(&stage(&after), &mut second, work)?;
        let mut of_direction = of_first;
        of_direction.add(-1.0, &Meaning::of(soil));
        let direction: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a - b).collect();
        // A d = content_1 - content_2, on the rows of the pressures.
        let mut product = vec![0.0; unknowns];
        for (function, map) in soil.water_map.iter().enumerate() {
            if *map != HELD {
                product[*map as usize] = soil.scales[1] * (after[function] - soil.values.content[function]);
            }
        }
        let (basis, meanings, ritz, weights) = (Vec::new(), Vec::new(), Ritz::default(), Default::default());
        let estimate = f64::INFINITY;
        let mut krylov = Self { first, basis, size: 0.0, of_first, meanings, gamma, ritz, weights, estimate };
        krylov.build(soil, (direction, product, of_direction), times, goal)?;
        Ok(krylov)
    }

    /// Whether it is one of a mesh with so many unknowns, and as large as it can be.
    pub fn fits(&self, unknowns: usize) -> bool {
        let (count, Ritz { values, vectors }) = (self.basis.len(), &self.ritz);
        let of = |length: usize| move |vector: &Vec<f64>| vector.len() == length;
        of(unknowns)(&self.first)
            && self.basis.iter().all(of(unknowns))
            && count <= MOST
            && [values.len(), self.meanings.len()] == [count; 2]
            && vectors.len() == count * count
    }

    /// Lanczos with full orthogonalisation, until the state at every time stands still.
    fn build<L: Law, const D: usize>(
        &mut self,
        soil: &mut Soil<L, D>,
        (mut direction, mut product, mut meaning): (Vec<f64>, Vec<f64>, Meaning),
        times: &[f64],
        goal: &Goal,
    ) -> Result<(), Stuck<D>> {
        let mut products: Vec<Vec<f64>> = Vec::new();
        let mut tridiagonal: Vec<[f64; 2]> = Vec::new();
        let mut settled: Vec<f64> = Vec::new();
        let mut rhs = vec![0.0; product.len()];
        // At one time after the other; and those of the basis before, with one vector less.
        let (mut now, mut before): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut changed = f64::INFINITY;
        let mut length = dot(&direction, &product).max(0.0).sqrt();
        self.size = length;
        let first_settled = goal.settlement(&self.first);
        // The first direction is d itself; later ones are steps B v of vectors of length 1, of which d has |d|.
        let least = BREAKDOWN * (self.size.max(goal.pressure_norm) / self.size);
        let mut spent = self.size <= BREAKDOWN * goal.pressure_norm;
        while !spent && self.basis.len() < MOST {
            for x in direction.iter_mut().chain(&mut product) {
                *x /= length;
            }
            self.meanings.push(Meaning::default());
            self.meanings[self.basis.len()].add(1.0 / length, &meaning);
            settled.push(goal.settlement(&direction));
            self.basis.push(direction.clone());
            products.push(product.clone());
            // B v: rows of the pressures alone, so that the displacements follow.
            rhs.iter_mut().zip(&product).for_each(|(rhs, x)| *rhs = -x);
            soil.system.solve(&rhs, &mut direction).map_err(Stuck::Unsolved)?;
            soil.expand(&direction);
            soil.flow_of_fields().map_err(Stuck::InsideOut)?;
            meaning = Meaning::of(soil);
            // A B v = A v - gamma H B v
            for (function, map) in soil.water_map.iter().enumerate() {
                if *map != HELD {
                    product[*map as usize] -= self.gamma * soil.scales[1] * soil.values.flow[function];
                }
            }
            let (mut diagonal, mut spoilt) = (0.0, 0.0_f64);
            for _ in 0..2 {
                for (k, v) in self.basis.iter().enumerate() {
                    let along = dot(v, &product);
                    spoilt = spoilt.max((along - dot(&products[k], &direction)).abs());
                    if k + 1 == self.basis.len() {
                        diagonal += along;
                    }
                    add(&mut direction, -along, v);
                    add(&mut product, -along, &products[k]);
                    meaning.add(-along, &self.meanings[k]);
                }
            }
            if spoilt > SPOILT {
                self.basis.pop();
                self.meanings.pop();
                break;
            }
            length = dot(&direction, &product).max(0.0).sqrt();
            spent = length <= least;
            tridiagonal.push([diagonal, length]);
            if self.basis.len() < 3 {
                continue;
            }
            self.ritz = Ritz::new(&tridiagonal);
            let count = self.basis.len();
            now.clear();
            times.iter().for_each(|t| self.ritz.apply(|mu| gap(mu, t / self.gamma), &mut now));
            let change = if before.is_empty() {
                f64::INFINITY
            } else {
                let change = |(now, before): (&[f64], &[f64])| {
                    let moved = |k: usize| self.size * (now[k] - before.get(k).copied().unwrap_or(0.0));
                    let settlement: f64 = (0..now.len()).map(|k| settled[k] * self.size * now[k]).sum();
                    let shift: f64 = (0..now.len()).map(|k| settled[k] * moved(k)).sum();
                    let norm: f64 = (0..now.len()).map(|k| moved(k).powi(2)).sum::<f64>().sqrt();
                    let whole = (goal.already + first_settled - settlement).abs();
                    (shift.abs() / whole).max(norm / goal.pressure_norm)
                };
                now.chunks_exact(count).zip(before.chunks_exact(count - 1)).map(change).fold(0.0, f64::max)
            };
            // One vector may happen to change little: two in a row must.
            self.estimate = change.max(changed);
            changed = change;
            if self.estimate <= goal.tolerance {
                break;
            }
            std::mem::swap(&mut now, &mut before);
        }
        if spent {
            self.estimate = 0.0; // the space holds the whole solution
        }
        if self.ritz.values.len() != self.basis.len() {
            self.ritz = Ritz::new(&tridiagonal);
        }
        Ok(())
    }

    /// Unknowns at a time since the start of the stage (s), what they mean for the balances, and what those mean that are integrated
    /// from the start of the stage to it.
    pub fn at(&mut self, time: f64, y: &mut [f64]) -> [Meaning; 2] {
        let tau = time / self.gamma;
        let [of_state, of_integral] = &mut self.weights;
        of_state.clear();
        self.ritz.apply(|mu| gap(mu, tau), of_state);
        of_integral.clear();
        self.ritz.apply(|mu| gap_integral(mu, tau), of_integral);
        y.copy_from_slice(&self.first);
        let (mut now, mut so_far) = (self.of_first, Meaning::default());
        so_far.add(time, &self.of_first);
        for (k, (v, meaning)) in self.basis.iter().zip(&self.meanings).enumerate() {
            add(y, -self.size * of_state[k], v);
            now.add(-self.size * of_state[k], meaning);
            so_far.add(-self.gamma * self.size * of_integral[k], meaning);
        }
        [now, so_far]
    }

    /// Friction in the pores until a time (s), J: `int p^T H p`.
    ///
    /// In Ritz vectors, orthonormal in A, `p = sum zeta_j exp(-lambda_j t) z_j` and `H = lambda_j A` on each.
    pub fn dissipation(&self, time: f64) -> f64 {
        let tau = time / self.gamma;
        let values = &self.ritz.values;
        let amount = |j: usize| {
            let (mu, s) = (values[j], 1.0 - values[j]);
            // d = (1 - B) y_1, and p(0) = y_1/mu
            let zeta = self.size * self.ritz.vectors[j * values.len()] / (mu * s);
            let part = -0.5 * zeta * zeta * f64::exp_m1(-2.0 * tau * s / mu);
            if s > 1e-9 { part } else { 0.0 }
        };
        (0..values.len()).map(amount).sum()
    }

    /// Basis vectors.
    pub fn vectors(&self) -> usize {
        self.basis.len()
    }
}

/// When a basis is good enough.
#[derive(Debug)]
pub(super) struct Goal {
    /// gamma, s.
    pub pole: f64,
    /// Largest relative change of settlement, and of the pressure in the norm of A.
    pub tolerance: f64,
    /// Weights of the unknowns in the settlement, m.
    pub weights: Vec<(u32, f64)>,
    /// Settlement before the stage, m.
    pub already: f64,
    /// Norm of the pressure that the load makes undrained, in scaled units.
    pub pressure_norm: f64,
}

impl Goal {
    fn settlement(&self, y: &[f64]) -> f64 {
        self.weights.iter().map(|(unknown, weight)| weight * y[*unknown as usize]).sum()
    }
}

/// With several sums side by side: one alone waits for each of its additions.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        (0..8).for_each(|lane| sums[lane] += a[lane] * b[lane]);
    }
    sums.iter().sum::<f64>() + rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum::<f64>()
}

fn add(to: &mut [f64], factor: f64, x: &[f64]) {
    for (to, x) in to.iter_mut().zip(x) {
        *to += factor * x;
    }
}

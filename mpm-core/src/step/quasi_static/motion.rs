//! Inertia of soil and water: what the implicit integrator has beside the quasi-static one.
//!
//! A stage that ends with displacements u has, with a = gamma dt and what the stages before it have given,
//!
//! ```text
//! v = (u - u~)/a,   v' = (v - v~)/a,   W' = (W - W~)/a
//! ```
//!
//! Every point of the soil is pushed by g - v' in place of g. W = J F^-1 w is the flux of the water relative to the soil; in the
//! full model (Biot 1956, doi:10.1121/1.1908239; Zienkiewicz et al. 1980, doi:10.1680/geot.1980.30.4.385) it has a balance of
//! momentum of its own, which holds no gradient of W, so that W is known point by point and no unknown:
//!
//! ```text
//! mixture:  rho (v' - g) + rho_w F W'/J = div sigma' - grad p
//! water:    K^-1 W = -(grad p - rho_w F^T (g - v')) - rho_w/(J n) C W',   C = F^T F
//! ```
//!
//! With W' from above the water flows as in Darcy's law, through the mobility `(1/k + rho_w/(n a))^-1` and with `rho_w/(J n a) C W~`
//! beside its weight. Products of the relative velocity with a rate of strain are left out.

use super::soil::PoreState;
use crate::real::array_of;
use crate::space::Stencil;

/// Stages of a step.
pub(super) const STAGES: usize = 5;

/// What the water in the pores is accelerated by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WaterInertia {
    /// Nothing: Darcy's law of a soil at rest.
    None,
    /// The acceleration of the soil (u-p).
    WithSoil,
    /// Its own acceleration (u-w).
    Own,
}

/// Rates at the end of a stage.
#[derive(Debug, Clone, Default)]
struct Rates<const D: usize> {
    /// Velocity of the functions, m/s, and acceleration, m/s2.
    velocity: Vec<[f64; D]>,
    acceleration: Vec<[f64; D]>,
    /// W' of the pore points, m/s2.
    flux: Vec<[f64; D]>,
}

/// Velocities and fluxes, of a step and of its stages.
#[derive(Debug, Clone)]
pub(super) struct Motion<const D: usize> {
    pub inertia: WaterInertia,
    /// Time in which a wave of the drained soil passes a cell, s, and stiffness of the pore water over that of the soil.
    pub passage: (f64, f64),
    /// Mass of a cell full of soil, kg.
    pub mass: f64,
    /// Whether errors of waves count.
    pub resolves: bool,
    /// Force of a jump of velocities: (function, function, N s/m), both triangles.
    pub viscosity: Vec<(u32, u32, f64)>,
    /// Damping force per mass and velocity, 1/s.
    pub damping: f64,
    /// a of the present stage, s; zero where nothing is accelerated, before the first step.
    pub a: f64,
    /// Velocity of the functions and flux W at the pore points at the start of the step, m/s.
    pub velocity: Vec<[f64; D]>,
    pub flux: Vec<[f64; D]>,
    /// Displacements at the start of the step, m.
    start: Vec<[f64; D]>,
    /// u~, u~ + a v~ (m) and W~ (m/s) of the stage.
    from: Vec<[f64; D]>,
    reach: Vec<[f64; D]>,
    flux_from: Vec<[f64; D]>,
    /// At the last evaluation.
    now: Rates<D>,
    /// Of the stages that are done.
    stages: [Rates<D>; STAGES],
    /// Errors of a step: accelerations of the functions (m/s2), fluxes of the pore points (m/s).
    pub errors: (Vec<[f64; D]>, Vec<[f64; D]>),
}

/// What moves at a point of the pore space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moving<const D: usize> {
    pub velocity: [f64; D],
    pub acceleration: [f64; D],
}

impl<const D: usize> Motion<D> {
    /// Soil at rest, of so many functions and pore points.
    pub fn new(
        (inertia, damping): (WaterInertia, f64),
        (passage, mass, resolves): ((f64, f64), f64, bool),
        viscosity: Vec<(u32, u32, f64)>,
        (functions, points): (usize, usize),
    ) -> Self {
        let zeros = |count: usize| vec![[0.0; D]; count];
        let points = if inertia == WaterInertia::Own { points } else { 0 };
        let rates = || Rates { velocity: zeros(functions), acceleration: zeros(functions), flux: zeros(points) };
        Self {
            inertia,
            passage,
            viscosity,
            mass,
            resolves,
            damping,
            a: 0.0,
            velocity: zeros(functions),
            flux: zeros(points),
            start: zeros(functions),
            from: zeros(functions),
            reach: zeros(functions),
            flux_from: zeros(points),
            now: rates(),
            stages: std::array::from_fn(|_| rates()),
            errors: (zeros(functions), zeros(points)),
        }
    }

    /// A step begins at displacements (m).
    pub fn start(&mut self, u: &[[f64; D]]) {
        self.start.copy_from_slice(u);
    }

    /// A stage begins: `dt` times the weights of those before it (s), and its own (s).
    pub fn begin(&mut self, before: &[f64], a: f64) {
        self.a = a;
        for f in 0..self.start.len() {
            for d in 0..D {
                let (mut u, mut v) = (self.start[f][d], self.velocity[f][d]);
                for (rates, weight) in self.stages.iter().zip(before) {
                    u += weight * rates.velocity[f][d];
                    v += weight * rates.acceleration[f][d];
                }
                (self.from[f][d], self.reach[f][d]) = (u, u + a * v);
            }
        }
        for (p, from) in self.flux_from.iter_mut().enumerate() {
            for d in 0..D {
                from[d] = self.flux[p][d];
                for (rates, weight) in self.stages.iter().zip(before) {
                    from[d] += weight * rates.flux[p][d];
                }
            }
        }
    }

    /// Velocities and accelerations of the functions that are displaced by `u` (m).
    pub fn evaluate(&mut self, u: &[[f64; D]]) {
        if self.a == 0.0 {
            return;
        }
        for f in 0..u.len() {
            for d in 0..D {
                self.now.velocity[f][d] = (u[f][d] - self.from[f][d]) / self.a;
                self.now.acceleration[f][d] = (u[f][d] - self.reach[f][d]) / (self.a * self.a);
            }
        }
    }

    /// How much more pressure a volume of water makes in a stage of a = gamma dt (s) than the soil alone would: it accelerates what is around it,
    /// or compresses.
    pub fn lever(&self, a: f64) -> f64 {
        let (passage, stiffness) = self.passage;
        (passage / a).powi(2).min(stiffness).max(1.0)
    }

    /// Force (N) that the last digits of displacements (m) make by acceleration in a stage of a = gamma dt (s): no iteration gets below.
    pub fn round_off(&self, a: f64, u: &[[f64; D]]) -> f64 {
        let largest = u.iter().flatten().fold(0.0, |most: f64, u| most.max(u.abs()));
        8.0 * f64::EPSILON * largest * self.mass / (a * a)
    }

    /// Velocity of a function at the last evaluation, m/s.
    pub fn velocity_of(&self, function: u32) -> [f64; D] {
        self.now.velocity[function as usize]
    }

    /// Adds the forces of viscosity (N) at the last evaluation. Returns what they take, W.
    pub fn resist(&self, force: &mut [f64]) -> f64 {
        let v = &self.now.velocity;
        let mut taken = 0.0;
        for &(a, b, value) in &self.viscosity {
            for d in 0..D {
                let along = value * v[b as usize][d];
                force[a as usize * D + d] += along;
                taken += v[a as usize][d] * along;
            }
        }
        taken
    }

    /// Velocity and acceleration at a point.
    pub fn at(&self, stencil: &Stencil<D>) -> Moving<D> {
        Moving { velocity: stencil.vector(&self.now.velocity), acceleration: stencil.vector(&self.now.acceleration) }
    }

    /// W~ of a pore point, m/s; `None` where the water has no acceleration of its own.
    pub fn flux_from(&self, point: usize) -> Option<[f64; D]> {
        (self.inertia == WaterInertia::Own && self.a > 0.0).then(|| self.flux_from[point])
    }

    /// Notes the flux W (m/s) of a pore point. Returns W', m/s2.
    pub fn flows(&mut self, point: usize, flux: &[f64; D]) -> [f64; D] {
        let rate = array_of(|d| (flux[d] - self.flux_from[point][d]) / self.a);
        self.now.flux[point] = rate;
        rate
    }

    /// A stage is done.
    pub fn done(&mut self, stage: usize) {
        self.stages[stage].clone_from(&self.now);
    }

    /// The step is accepted: its last stage is its end.
    pub fn accept(&mut self) {
        self.velocity.copy_from_slice(&self.now.velocity);
        for (p, flux) in self.flux.iter_mut().enumerate() {
            *flux = array_of(|d| self.flux_from[p][d] + self.a * self.now.flux[p][d]);
        }
    }

    /// Notes what an error of the rates, summed over the stages with `dt` times weights (s), accelerates as seen by the last stage, and the
    /// error of W itself.
    pub fn note_errors(&mut self, weights: &[f64; STAGES]) {
        let Self { stages, errors: (nodal, pore), a, .. } = self;
        nodal.fill([0.0; D]);
        pore.fill([0.0; D]);
        for (rates, weight) in stages.iter().zip(weights) {
            for (f, sum) in nodal.iter_mut().enumerate() {
                for d in 0..D {
                    sum[d] += weight * (rates.velocity[f][d] / (*a * *a) + rates.acceleration[f][d] / *a);
                }
            }
            for (sum, flux) in pore.iter_mut().zip(&rates.flux) {
                (0..D).for_each(|d| sum[d] += weight * flux[d]);
            }
        }
    }
}

/// C y/J, with C = F^T F and F = I + grad u.
pub(super) fn metric<const D: usize>(state: &PoreState<D>, small: bool, y: &[f64; D]) -> [f64; D] {
    if small {
        return *y;
    }
    let pushed = forward(state, small, y);
    let f = &state.gradient;
    array_of(|i| (pushed[i] + (0..D).map(|k| f[k][i] * pushed[k]).sum::<f64>()) / (1.0 + state.change))
}

/// F y.
pub(super) fn forward<const D: usize>(state: &PoreState<D>, small: bool, y: &[f64; D]) -> [f64; D] {
    let turn = if small { 0.0 } else { 1.0 };
    array_of(|i| y[i] + turn * (0..D).map(|k| state.gradient[i][k] * y[k]).sum::<f64>())
}

/// `(k^-1 + drag I)^-1` of a symmetric mobility k.
pub(super) fn dragged<const D: usize>(k: &[[f64; D]; D], drag: f64) -> [[f64; D]; D] {
    if D == 1 {
        return [[k[0][0] / (1.0 + drag * k[0][0]); D]; D];
    }
    // (I + drag k)^-1 k
    let [a, b, d] = [1.0 + drag * k[0][0], drag * k[0][1], 1.0 + drag * k[1][1]];
    let det = a * d - b * b;
    let inverse = [[d / det, -b / det], [-b / det, a / det]];
    array_of(|i| array_of(|j| (0..2).map(|l| inverse[i][l] * k[l][j]).sum()))
}

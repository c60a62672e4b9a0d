//! Darcy's law on the face of two cells: `q = -(k/gamma_w) [ (p_hi - p_lo)/L - rho_w (g - a_s) ]`.
//!
//! In one dimension it is the paper's Eq. (1) but for a cell that is not full of soil; in two it couples cells that share a face,
//! where the paper's nodal velocity couples only diagonal neighbours (`mpm-verify stability` measures what that does).
//!
//! Between cells of different conductivity the flux is that through two half cells in series: k is the harmonic mean
//! 2 k_1 k_2/(k_1 + k_2), and the pressure on the face is the one at which both halves carry the same.

use crate::real::Real;

/// A face between two cells of soil conducts fully, a drained surface lies half a cell from the centre.
pub(crate) const DRAINED_SURFACE: f64 = 2.0;
/// A cell less full than this drains as if it were this full: with its drained face half a cell away it then has
/// the same stability limit as a full cell inside, (1 + 2)/0.75 = 4. The water this miscounts shows in the balance.
pub(crate) const LEAST_FILLING: f64 = 0.75;
/// What flow may change the pressure of a cell by in a step, of it, beside waves that take most of the step: of those with
/// `(M + Q) K dt^2/rho` up to `4 - 2 FLOW` none grows.
pub(crate) const FLOW: f64 = 0.5;

/// Darcy's law on a face between two cells, and the water it moves.
#[derive(Debug, Clone, Copy, Default)]
pub struct FaceFlow {
    /// k/(gamma_w L): flux per pressure drop, m/(s Pa).
    pub conductance: f64,
    /// rho_w L: pressure drop per m/s2.
    pub weight: f64,
    /// 1 keeps `rho_w a_s` in Darcy's law, 0 leaves it out.
    pub inertia: f64,
    /// Area of a face, m2.
    pub area: f64,
    /// Volume of a cell full of soil, m3.
    pub cell_volume: f64,
    /// k/(gamma_w L^2), 1/(Pa s).
    pub diffusion: f64,
    /// K_w, Pa.
    pub bulk_modulus: f64,
    /// Volume of the grains per mass, m3/kg.
    pub grain_inverse: f64,
    /// rho_w, kg/m3.
    pub density: f64,
}

impl FaceFlow {
    /// Eq. (1) on a face that conducts, over the conductivity of the water: flux (m/s), the pressure that drives it and its part of
    /// weight and inertia (Pa), `drop` that of the pressures of the cells, Pa. `body` is [`Self::body`] over the distance (in
    /// cells, inverse) that the pressures drop along.
    #[inline(always)]
    pub fn through<R: Real>(&self, conducts: R, drop: R, body: R) -> [R; 3] {
        let head = drop + body;
        [conducts * head * self.conductance, head, body]
    }

    /// What weight and inertia push along a cell (Pa), of gravity and an acceleration of the soil along the axis, m/s2.
    #[inline(always)]
    pub fn body<R: Real>(&self, gravity: f64, acceleration: R) -> R {
        (acceleration.like(gravity) - acceleration * self.inertia) * self.weight
    }
}

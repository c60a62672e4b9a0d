//! Dilation that fades while the soil shears, at a constant strength in simple shear.
//!
//! Without dilation the planes of a soil do not say what strength a slip surface has: where its shear band has zero extension it is
//! that of Davis, `tan(phi*) = sin(phi) cos(psi)/(1 - sin(phi) sin(psi))`, and anything up to `tan(phi)` on its way there. A mesh
//! then selects a strength. Here the soil begins with an associated flow, psi = phi = phi*, and while its dilation fades,
//!
//! ```text
//! sin(psi) = sin(psi_0) + (sin(phi*) - sin(psi_0)) max(0, 1 - gamma/gamma_0)      gamma = eps_1 - eps_3, plastic
//! ```
//!
//! its planes open so that c* and phi* in simple shear stay what they are. With `u = cos(psi)`, `v = sin(psi)`:
//!
//! ```text
//! sin(phi) = tan(phi*)/(u + v tan(phi*))      2 c cos(phi) = 2 c* (1 - v sin(phi))/u
//! ```
//!
//! At the end they are those of the scene. The apex, `c/tan(phi)`, does not move. Davis 1968; Tschuchnigg, Schweiger & Sloan 2015,
//! doi:10.1016/j.compgeo.2015.06.003.

use crate::real::Real;
use crate::scene::{Reduction, Strength};

/// What the main planes are made of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Planes<R = f64> {
    /// sin(phi).
    pub sin: R,
    /// 2 c cos(phi), Pa.
    pub strength: R,
    /// sin(psi).
    pub dilation: R,
}

/// How the dilation of a soil fades.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fading {
    /// tan(phi*).
    tangent: f64,
    /// 2 c*, Pa.
    cohesion: f64,
    /// sin(psi) at the end, and what it is more at first.
    sine: [f64; 2],
    /// 1/gamma_0.
    rate: f64,
}

impl Fading {
    /// That of a soil, if its dilation fades.
    pub fn of(strength: &Strength) -> Option<Self> {
        let rate = 1.0 / strength.dilation_fades_over?;
        let davis = strength.reduced(1.0, Reduction::Davis);
        let (tangent, last) = (davis.friction_angle.to_radians().tan(), strength.dilation_angle.to_radians().sin());
        let more = davis.friction_angle.to_radians().sin() - last;
        Some(Self { tangent, cohesion: 2.0 * davis.cohesion, sine: [last, more], rate })
    }

    /// The planes after a plastic shear strain.
    #[inline(always)]
    pub fn planes<R: Real>(&self, slip: R) -> Planes<R> {
        let one = slip.like(1.0);
        let left = (one - slip * self.rate).larger(slip.like(0.0));
        let dilation = left * self.sine[1] + slip.like(self.sine[0]);
        let inverse = one / (one - dilation * dilation).root(); // 1/u
        let sin = slip.like(self.tangent) * inverse / (one + dilation * inverse * self.tangent);
        Planes { sin, strength: (one - dilation * sin) * inverse * self.cohesion, dilation }
    }
}

impl<R: Real> Planes<R> {
    /// f at the largest and smallest principal stress (Pa), Pa.
    #[inline(always)]
    pub fn over(&self, [high, low]: [R; 2]) -> R {
        high - low + (high + low) * self.sin - self.strength
    }
}

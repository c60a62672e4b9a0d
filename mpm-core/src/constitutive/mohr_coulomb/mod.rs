//! Isotropic elasticity inside a Mohr-Coulomb surface with a tension cut-off; perfectly plastic, unless its dilation fades
//! (`fading`).
//!
//! Tension positive, principal stresses s1 >= s2 >= s3:
//!
//! ```text
//! f   = (s1 - s3) + (s1 + s3) sin(phi) - 2 c cos(phi) <= 0        flow along g = (s1 - s3) + (s1 + s3) sin(psi)
//! f_t = s1 - sigma_t <= 0                                         flow along s1 (Rankine, associated)
//! ```
//!
//! A strain increment makes an elastic trial stress. Outside the surface it is brought back (fully implicit Euler): an
//! isotropic law keeps the principal directions, and between planes and a linear elasticity the return is exact, without
//! iteration. Sources: de Souza Neto, Peric and Owen, *Computational Methods for Plasticity*, 2008, chapter 8 (surface,
//! edges, apex, consistent tangent); Clausen, Damkilde and Andersen 2006, doi:10.1016/j.compstruc.2006.07.002, and 2007,
//! doi:10.1002/nme.1967 (linear planes, lines and points in principal stress).

mod fading;
mod principal;
mod returns;
mod surface;
mod tangent;
#[cfg(test)]
mod tests;

use nalgebra::SMatrix;
use pulp::Simd;

use super::linear_elastic::LinearElastic;
use super::{Altered, Flow, Law, State};
use crate::real::{Real, SimdReal};
use crate::scene::{Elastic, Strength};
use fading::Fading;
use principal::Ordered;
pub use returns::Region;
use surface::Surface;

/// Mohr-Coulomb, components xx, yy, zz, xy.
#[derive(Debug, Clone, Copy)]
pub struct MohrCoulomb {
    elastic: LinearElastic,
    /// At first.
    surface: Surface,
    strength: Strength,
    fading: Option<Fading>,
}

impl MohrCoulomb {
    /// The law of a soil. Where its dilation fades it remembers its plastic shear strain.
    pub fn new(elastic: &Elastic, strength: &Strength) -> Self {
        let surface = Surface::new(elastic, strength);
        Self { elastic: LinearElastic::new(elastic), surface, strength: *strength, fading: Fading::of(strength) }
    }

    /// The surface after some plastic shear strain.
    #[inline(always)]
    fn surface<R: Real>(&self, state: &State<R>) -> Surface<R> {
        match &self.fading {
            Some(fading) => self.surface.soil.within(&fading.planes(state[0])),
            None => self.surface.as_wide_as(state[0]),
        }
    }

    /// Largest and smallest principal stress, Pa.
    #[inline(always)]
    fn extremes<R: Real>(&[xx, yy, zz, xy]: &[R; 4]) -> [R; 2] {
        let (centre, half) = ((xx + yy) * 0.5, (xx - yy) * 0.5);
        let radius = (half * half + xy * xy).root();
        [(centre + radius).larger(zz), (centre - radius).smaller(zz)]
    }

    /// The part of the surface that a strain increment from a stress (Pa) ends on, of soil that has not flowed yet.
    pub fn region(&self, stress: &[f64; 4], strain: &[f64; 4]) -> Region {
        let mut trial = *stress;
        self.elastic.hooke(&mut trial, strain);
        self.surface.back(&Ordered::of(&trial).values).0
    }

    /// How far a stress is outside, see [`Law::yield_residual`].
    #[inline(always)]
    fn excess<R: Real>(&self, stress: &[R; 4], state: &State<R>) -> R {
        let [high, low] = Self::extremes(stress);
        let sheared = match &self.fading {
            Some(fading) => fading.planes(state[0]).over([high, low]),
            None => self.surface.as_wide_as(high).over(high, low),
        };
        self.surface.soil.exceeded(high, sheared)
    }

    /// Brings a trial stress back to the surface as it is before the step. Returns stress and state of the end.
    #[inline(always)]
    fn flow_back<R: Real>(&self, stress: &[R; 4], state: &State<R>) -> ([R; 4], State<R>, Flow<R>) {
        let (trial, surface) = (Ordered::of(stress), self.surface(state));
        let [s1, s2, s3, _] = surface.returned(&trial.values);
        let (found, mut after, soil) = ([s1, s2, s3], *state, &self.surface.soil);
        let stress = trial.with(&found);
        let dissipation = soil.dissipation(&trial.values, &found);
        if self.fading.is_some() {
            after[0] += soil.slipped(&trial.values, &found);
        }
        (stress, after, Flow { dissipation, residual: surface.excess(Self::extremes(&stress)) })
    }
}

impl Law for MohrCoulomb {
    fn has_state(&self) -> bool {
        self.fading.is_some()
    }

    #[inline(always)]
    fn update(&self, stress: &mut [f64; 4], strain: &[f64; 4], state: &mut State) -> Flow {
        self.elastic.hooke(stress, strain);
        let residual = self.excess(stress, state);
        if residual > 0.0 {
            let flow;
            (*stress, *state, flow) = self.flow_back(stress, state);
            return flow;
        }
        Flow { dissipation: 0.0, residual }
    }

    #[inline(always)]
    fn update_lanes<V: Simd>(
        &self,
        stress: &mut [SimdReal<V>; 4],
        strain: &[SimdReal<V>; 4],
        state: &mut State<SimdReal<V>>,
        there: V::m64s,
    ) -> Flow<SimdReal<V>> {
        self.elastic.hooke(stress, strain);
        let none = stress[0].like(0.0);
        let residual = self.excess(stress, state).or(there, none.like(f64::NEG_INFINITY));
        if SimdReal::nowhere(none.simd, none.below(residual)) {
            return Flow { dissipation: none, residual };
        }
        let (outside, (found, after, flow)) = (none.below(residual), self.flow_back(stress, state));
        for s in 0..4 {
            stress[s] = found[s].or(outside, stress[s]);
        }
        state[0] = after[0].or(outside, state[0]);
        Flow { dissipation: flow.dissipation.or(outside, none), residual: flow.residual.or(outside, residual) }
    }

    fn is_symmetric(&self) -> bool {
        self.fading.is_none() && self.surface.normal[0] == self.surface.along[0] // an associated flow rule
    }

    fn tangent(&self, stress: &[f64; 4], strain: &[f64; 4], state: &State) -> SMatrix<f64, 4, 4> {
        let mut trial = *stress;
        self.elastic.hooke(&mut trial, strain);
        let trial = Ordered::of(&trial);
        let surface = self.surface(state);
        let (region, found) = surface.back(&trial.values);
        match region {
            Region::Elastic => self.elastic.tangent(stress, strain, state),
            _ => trial.tangent(&found, &surface.tangent(region), surface.soil.shear),
        }
    }

    fn energy(&self, stress: &[f64; 4]) -> f64 {
        self.surface.energy(&Ordered::of(stress).values)
    }

    #[inline(always)]
    fn released_lanes<V: Simd>(&self, from: &[SimdReal<V>; 4], to: &[SimdReal<V>; 4]) -> SimdReal<V> {
        self.elastic.released(from, to)
    }

    fn yield_residual(&self, stress: &[f64; 4], state: &State) -> f64 {
        self.excess(stress, state)
    }

    fn altered(&self, by: &Altered) -> Self {
        Self::new(&self.surface.elastic(by.stiffness), &self.strength.reduced(by.factor, by.by))
    }
}

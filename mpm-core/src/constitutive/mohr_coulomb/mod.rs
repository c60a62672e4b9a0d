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
use crate::real::{MAX_LANES, Real, SimdReal};
use crate::scene::{Elastic, Strength};
use fading::Fading;
use principal::{Ordered, in_plane};
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
    fn surface(&self, state: &State) -> Surface {
        self.fading.map_or(self.surface, |fading| self.surface.with(&fading.planes(state[0])))
    }

    /// Largest and smallest principal stress, Pa.
    #[inline(always)]
    fn extremes<R: Real>(&[xx, yy, zz, xy]: &[R; 4]) -> [R; 2] {
        let (centre, half) = ((xx + yy) * 0.5, (xx - yy) * 0.5);
        let radius = (half * half + xy * xy).root();
        [(centre + radius).larger(zz), (centre - radius).smaller(zz)]
    }

    fn ordered(stress: &[f64; 4]) -> Ordered {
        in_plane(stress)
    }
}

/// Trial stresses of several particles, component by component, with dissipation and residual of each.
struct Packed {
    stress: [[f64; MAX_LANES]; 4],
    slip: [f64; MAX_LANES],
    flow: [[f64; MAX_LANES]; 2],
}

impl MohrCoulomb {
    /// The part of the surface that a strain increment from a stress (Pa) ends on, of soil that has not flowed yet.
    pub fn region(&self, stress: &[f64; 4], strain: &[f64; 4]) -> Region {
        let mut trial = *stress;
        self.elastic.hooke(&mut trial, strain);
        self.surface.back(&Self::ordered(&trial).values).0
    }

    /// How far a stress is outside, see [`Law::yield_residual`].
    #[inline(always)]
    fn excess<R: Real>(&self, stress: &[R; 4], state: &State<R>) -> R {
        let extremes = Self::extremes(stress);
        match &self.fading {
            Some(fading) => self.surface.exceeded(extremes, fading.planes(state[0]).over(extremes)),
            None => self.surface.excess(extremes),
        }
    }

    /// Brings a trial stress back to the surface as it is before the step.
    #[inline(never)]
    fn flow_back(&self, stress: &mut [f64; 4], state: &mut State) -> Flow {
        let trial = Self::ordered(stress);
        let surface = self.surface(state);
        let (_, found) = surface.back(&trial.values);
        *stress = trial.with(&found);
        let flow = Flow {
            dissipation: surface.dissipation(&trial.values, &found),
            residual: surface.excess(Self::extremes(stress)),
        };
        if self.fading.is_some() {
            state[0] += surface.slipped(&trial.values, &found);
        }
        flow
    }
}

impl MohrCoulomb {
    /// The same for the lanes whose residual is above zero. Not for every width anew: that is long to compile.
    #[inline(never)]
    fn flow_back_lanes(&self, packed: &mut Packed, lanes: usize) {
        for lane in 0..lanes.min(MAX_LANES) {
            if packed.flow[1][lane] > 0.0 {
                let mut of_one = std::array::from_fn(|s| packed.stress[s][lane]);
                let mut state = [packed.slip[lane]];
                let flow = self.flow_back(&mut of_one, &mut state);
                packed.slip[lane] = state[0];
                for s in 0..4 {
                    packed.stress[s][lane] = of_one[s];
                }
                (packed.flow[0][lane], packed.flow[1][lane]) = (flow.dissipation, flow.residual);
            }
        }
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
        if residual > 0.0 { self.flow_back(stress, state) } else { Flow { dissipation: 0.0, residual } }
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
        let mut packed = Packed { stress: [[0.0; MAX_LANES]; 4], slip: [0.0; MAX_LANES], flow: [[0.0; MAX_LANES]; 2] };
        for s in 0..4 {
            stress[s].store(&mut packed.stress[s]);
        }
        state[0].store(&mut packed.slip);
        residual.store(&mut packed.flow[1]);
        self.flow_back_lanes(&mut packed, V::F64_LANES);
        for s in 0..4 {
            stress[s] = SimdReal::load(none.simd, &packed.stress[s]);
        }
        state[0] = SimdReal::load(none.simd, &packed.slip);
        let [dissipation, residual] = &packed.flow;
        let dissipation = SimdReal::load(none.simd, dissipation);
        Flow { dissipation, residual: SimdReal::load(none.simd, residual) }
    }

    fn is_symmetric(&self) -> bool {
        self.fading.is_none() && self.surface.normal[0] == self.surface.along[0] // an associated flow rule
    }

    fn tangent(&self, stress: &[f64; 4], strain: &[f64; 4], state: &State) -> SMatrix<f64, 4, 4> {
        let mut trial = *stress;
        self.elastic.hooke(&mut trial, strain);
        let trial = Self::ordered(&trial);
        let surface = self.surface(state);
        let (region, found) = surface.back(&trial.values);
        match region {
            Region::Elastic => self.elastic.tangent(stress, strain, state),
            _ => trial.tangent(&found, &surface.tangent(region), surface.shear),
        }
    }

    fn energy(&self, stress: &[f64; 4]) -> f64 {
        self.surface.energy(&Self::ordered(stress).values)
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

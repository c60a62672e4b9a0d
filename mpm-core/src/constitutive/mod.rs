//! Constitutive laws of the skeleton, one per file. A law turns a strain increment into an effective stress.

#[cfg(test)]
#[macro_use]
mod checks;
mod linear_elastic;
mod material;
mod mohr_coulomb;

pub use linear_elastic::LinearElastic;
pub use material::{MOST_MATERIALS, Material, Materials, Part};
pub use mohr_coulomb::{MohrCoulomb, Region};
use nalgebra::SMatrix;
use pulp::Simd;

use crate::real::{Lanes, Real};

/// What an update of a plastic law did to a particle, or to several.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flow<R = f64> {
    /// Energy dissipated per volume, J/m3.
    pub dissipation: R,
    /// [`Law::yield_residual`] of the new stress; in lanes without a particle negative infinity.
    pub residual: R,
}

/// A law of stress and strain, components xx, yy, zz, xy; a column strains along y.
pub trait Law: Copy + Send + Sync + 'static {
    /// Adds the effect of a strain increment to a stress (Pa, tension positive).
    fn update(&self, stress: &mut [f64; 4], strain: &[f64; 4]);
    /// [`Self::update`] of several particles, one after the other unless the law knows better.
    #[inline(always)]
    fn update_lanes<V: Simd>(&self, stress: &mut [Lanes<V>; 4], strain: &[Lanes<V>; 4]) {
        for lane in 0..Lanes::<V>::COUNT {
            let mut of_one = stress.map(|s| s.lane(lane));
            self.update(&mut of_one, &strain.map(|e| e.lane(lane)));
            for s in 0..4 {
                stress[s].set_lane(lane, of_one[s]);
            }
        }
    }
    /// Whether the stress is a linear function of the strain: implicit steps then need no iteration.
    fn is_linear(&self) -> bool {
        false
    }
    /// [`Self::update`], and what it did; asked of plastic laws only.
    #[inline(always)]
    fn flow(&self, stress: &mut [f64; 4], strain: &[f64; 4]) -> Flow {
        self.update(stress, strain);
        Flow { dissipation: 0.0, residual: self.yield_residual(stress) }
    }
    /// [`Self::flow`] of several particles; lanes that are not `there` hold none.
    #[inline(always)]
    fn flow_lanes<V: Simd>(
        &self,
        stress: &mut [Lanes<V>; 4],
        strain: &[Lanes<V>; 4],
        there: V::m64s,
    ) -> Flow<Lanes<V>> {
        let none = stress[0].like(0.0);
        let here = none.like(1.0).or(there, none);
        let mut flow = Flow { dissipation: none, residual: none.like(f64::NEG_INFINITY) };
        for lane in (0..Lanes::<V>::COUNT).filter(|lane| here.lane(*lane) > 0.0) {
            let mut of_one = stress.map(|s| s.lane(lane));
            let own = self.flow(&mut of_one, &strain.map(|e| e.lane(lane)));
            for s in 0..4 {
                stress[s].set_lane(lane, of_one[s]);
            }
            flow.dissipation.set_lane(lane, own.dissipation);
            flow.residual.set_lane(lane, own.residual);
        }
        flow
    }
    /// The same law with its strength divided by a factor (c, tan phi and tan psi) and so many times its stiffness.
    /// The laws of soil that may fail know it; any other stays as it is.
    fn altered(&self, _factor: f64, _stiffness: f64) -> Self {
        *self
    }
    /// How far a stress is outside the yield surface, as a share of the strength under no stress, which the law states;
    /// negative inside, negative infinity if there is no surface.
    fn yield_residual(&self, _stress: &[f64; 4]) -> f64 {
        f64::NEG_INFINITY
    }
    /// Tangent stiffness at the end of a strain increment from a stress, Pa.
    fn tangent(&self, stress: &[f64; 4], strain: &[f64; 4]) -> SMatrix<f64, 4, 4>;
    /// Elastic energy stored per volume at a stress, J/m3, where the volume does not change.
    fn energy(&self, stress: &[f64; 4]) -> f64;
    /// Elastic change of volume at a stress, logarithmic, -.
    fn dilation(&self, _stress: &[f64; 4]) -> f64 {
        0.0
    }
    /// [`Self::energy`] per volume of now, where it has changed with the strain: Cauchy stress times logarithmic strain, summed
    /// up over volumes `exp(theta)` along a straight path, is `(theta - 1 + exp(-theta))/(theta^2/2)` times that of small strain.
    fn finite_energy(&self, stress: &[f64; 4]) -> f64 {
        let theta = self.dilation(stress);
        // The series to theta^4, without cancellation: exact to 1e-9 at 10 %, and to 3e-6 at 50 %.
        let factor = 1.0 - theta / 3.0 * (1.0 - theta / 4.0 * (1.0 - theta / 5.0 * (1.0 - theta / 6.0)));
        factor * self.energy(stress)
    }
}

//! Constitutive laws of the skeleton, one per file. A law turns a strain increment into an effective stress.

mod linear_elastic;

pub use linear_elastic::LinearElastic;
use nalgebra::SMatrix;
use pulp::Simd;

use crate::real::Lanes;

/// A law with S stress components.
pub trait Law<const S: usize>: Copy + Send + Sync + 'static {
    /// Adds the effect of a strain increment to a stress (Pa, tension positive).
    fn update(&self, stress: &mut [f64; S], strain: &[f64; S]);
    /// [`Self::update`] of several particles, one after the other unless the law knows better.
    #[inline(always)]
    fn update_lanes<V: Simd>(&self, stress: &mut [Lanes<V>; S], strain: &[Lanes<V>; S]) {
        for lane in 0..Lanes::<V>::COUNT {
            let mut of_one = stress.map(|s| s.lane(lane));
            self.update(&mut of_one, &strain.map(|e| e.lane(lane)));
            for s in 0..S {
                stress[s].set_lane(lane, of_one[s]);
            }
        }
    }
    /// Whether the stress is a linear function of the strain: implicit steps then need no iteration.
    const LINEAR: bool;
    /// Tangent stiffness at the end of a strain increment from a stress, Pa.
    fn tangent(&self, stress: &[f64; S], strain: &[f64; S]) -> SMatrix<f64, S, S>;
    /// Elastic energy stored per volume at a stress, J/m3.
    fn energy(&self, stress: &[f64; S]) -> f64;
}

//! Constitutive laws of the skeleton, one per file. A law turns a strain increment into an effective stress.

#[cfg(test)]
#[macro_use]
mod checks;
mod linear_elastic;
mod material;
mod modified_cam_clay;
mod mohr_coulomb;

pub use linear_elastic::LinearElastic;
pub use material::{MOST_MATERIALS, Material, Materials};
pub use modified_cam_clay::ModifiedCamClay;
pub use mohr_coulomb::{MohrCoulomb, Region};
use nalgebra::SMatrix;
use pulp::Simd;

use crate::real::{Real, SimdReal, map_of};
use crate::scene::Reduction;

/// What an update did to a particle, or to several.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flow<R = f64> {
    /// Energy dissipated per volume, J/m3.
    pub dissipation: R,
    /// [`Law::yield_residual`] of the new stress; negative infinity without a surface, and in lanes without a particle.
    pub residual: R,
}

impl<R: Real> Flow<R> {
    /// Of a law without a surface; of as many particles as `like` has numbers.
    #[inline(always)]
    pub fn none(like: R) -> Self {
        Self { dissipation: like.like(0.0), residual: like.like(f64::NEG_INFINITY) }
    }
}

/// What is changed of a soil to find its factor of safety.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Altered {
    /// The strength is divided by this.
    pub factor: f64,
    /// With this flow rule.
    pub by: Reduction,
    /// The soil is so many times as stiff.
    pub stiffness: f64,
}

impl Altered {
    /// The soil of the scene.
    pub const NOTHING: Self = Self { factor: 1.0, by: Reduction::AsGiven, stiffness: 1.0 };
}

/// State variables that a law may have.
pub const STATES: usize = 1;
/// What the soil of a particle remembers beside its stress; zero for laws without a memory.
pub type State<R = f64> = [R; STATES];

/// A law of stress and strain, components xx, yy, zz, xy; a column strains along y.
pub trait Law: Copy + Send + Sync + 'static {
    /// Whether the soil remembers more than its stress.
    fn has_state(&self) -> bool {
        false
    }
    /// What it remembers at t = 0 under a stress (Pa).
    fn first_state(&self, _stress: &[f64; 4]) -> State {
        [0.0; STATES]
    }
    /// Adds the effect of a strain increment to a stress (Pa, tension positive) and a state, and says what it did.
    fn update(&self, stress: &mut [f64; 4], strain: &[f64; 4], state: &mut State) -> Flow;
    /// [`Self::update`] of several particles, one after the other unless the law knows better; lanes that are not `there` hold none.
    #[inline(always)]
    fn update_lanes<V: Simd>(
        &self,
        stress: &mut [SimdReal<V>; 4],
        strain: &[SimdReal<V>; 4],
        state: &mut State<SimdReal<V>>,
        there: V::m64s,
    ) -> Flow<SimdReal<V>> {
        let none = stress[0].like(0.0);
        let here = none.like(1.0).or(there, none);
        let mut flow = Flow::none(none);
        for lane in (0..SimdReal::<V>::COUNT).filter(|lane| here.lane(*lane) > 0.0) {
            let (mut of_one, mut memory) = (map_of(stress, |s| s.lane(lane)), map_of(state, |s| s.lane(lane)));
            let own = self.update(&mut of_one, &map_of(strain, |e| e.lane(lane)), &mut memory);
            for s in 0..4 {
                stress[s].set_lane(lane, of_one[s]);
            }
            for s in 0..STATES {
                state[s].set_lane(lane, memory[s]);
            }
            flow.dissipation.set_lane(lane, own.dissipation);
            flow.residual.set_lane(lane, own.residual);
        }
        flow
    }
    /// Whether the stress is a linear function of the strain: implicit steps then need no iteration.
    fn is_linear(&self) -> bool {
        false
    }
    /// Whether the tangent is symmetric for every strain increment.
    fn is_symmetric(&self) -> bool {
        true
    }
    /// The same law with another strength and stiffness. The laws of soil that may fail know it; any other stays as it is.
    fn altered(&self, _by: &Altered) -> Self {
        *self
    }
    /// How far a stress is outside the yield surface, as a share of the strength under no stress, which the law states;
    /// negative inside, negative infinity if there is no surface.
    fn yield_residual(&self, _stress: &[f64; 4], _state: &State) -> f64 {
        f64::NEG_INFINITY
    }
    /// Consistent tangent at the end of a strain increment from a stress and a state, Pa.
    fn tangent(&self, stress: &[f64; 4], strain: &[f64; 4], state: &State) -> SMatrix<f64, 4, 4>;
    /// Elastic energy stored per volume at a stress, J/m3, where the volume does not change.
    fn energy(&self, stress: &[f64; 4]) -> f64;
    /// [`Self::energy`] at a stress less that at another, of so many particles at once, J/m3.
    #[inline(always)]
    fn released_lanes<V: Simd>(&self, from: &[SimdReal<V>; 4], to: &[SimdReal<V>; 4]) -> SimdReal<V> {
        let mut released = from[0].like(0.0);
        for lane in 0..SimdReal::<V>::COUNT {
            let (old, new) = (map_of(from, |s| s.lane(lane)), map_of(to, |s| s.lane(lane)));
            if old != new {
                released.set_lane(lane, self.energy(&old) - self.energy(&new));
            }
        }
        released
    }
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

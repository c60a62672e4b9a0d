//! The materials of a soil: which there are, and which particle is of which.

use pulp::{Simd, WithSimd};

use super::{Altered, Flow, Law, LinearElastic, ModifiedCamClay, MohrCoulomb, STATES, State};
use crate::real::{Real, SimdReal};
use crate::soils::Soils;

/// A material, one of those that are known.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::large_enum_variant, reason = "a scene has at most a few, read where they lie")]
pub enum Material {
    /// Isotropic linear elasticity.
    Elastic(LinearElastic),
    /// Elastic, perfectly plastic.
    MohrCoulomb(MohrCoulomb),
    /// Hardens and softens with its plastic change of volume.
    CamClay(ModifiedCamClay),
}

impl Material {
    /// Whether it dissipates.
    pub fn is_plastic(&self) -> bool {
        match self {
            Self::Elastic(_) => false,
            Self::MohrCoulomb(_) | Self::CamClay(_) => true,
        }
    }
}

/// Calls the same method of whatever the material is.
macro_rules! whichever {
    ($self:ident, $law:ident => $call:expr) => {
        match $self {
            Material::Elastic($law) => $call,
            Material::MohrCoulomb($law) => $call,
            Material::CamClay($law) => $call,
        }
    };
}

impl Law for Material {
    fn is_linear(&self) -> bool {
        whichever!(self, law => law.is_linear())
    }

    fn is_symmetric(&self) -> bool {
        whichever!(self, law => law.is_symmetric())
    }

    fn has_state(&self) -> bool {
        whichever!(self, law => law.has_state())
    }

    fn first_state(&self, stress: &[f64; 4]) -> State {
        whichever!(self, law => law.first_state(stress))
    }

    fn update(&self, stress: &mut [f64; 4], strain: &[f64; 4], state: &mut State) -> Flow {
        whichever!(self, law => law.update(stress, strain, state))
    }

    #[inline(always)]
    fn update_lanes<V: Simd>(
        &self,
        stress: &mut [SimdReal<V>; 4],
        strain: &[SimdReal<V>; 4],
        state: &mut State<SimdReal<V>>,
        there: V::m64s,
    ) -> Flow<SimdReal<V>> {
        whichever!(self, law => law.update_lanes(stress, strain, state, there))
    }

    fn altered(&self, by: &Altered) -> Self {
        match self {
            Self::Elastic(law) => Self::Elastic(law.altered(by)),
            Self::MohrCoulomb(law) => Self::MohrCoulomb(law.altered(by)),
            Self::CamClay(law) => Self::CamClay(*law),
        }
    }

    fn yield_residual(&self, stress: &[f64; 4], state: &State) -> f64 {
        whichever!(self, law => law.yield_residual(stress, state))
    }

    fn tangent(&self, stress: &[f64; 4], strain: &[f64; 4], state: &State) -> nalgebra::SMatrix<f64, 4, 4> {
        whichever!(self, law => law.tangent(stress, strain, state))
    }

    fn energy(&self, stress: &[f64; 4]) -> f64 {
        whichever!(self, law => law.energy(stress))
    }

    #[inline(always)]
    fn released_lanes<V: Simd>(&self, from: &[SimdReal<V>; 4], to: &[SimdReal<V>; 4]) -> SimdReal<V> {
        whichever!(self, law => law.released_lanes(from, to))
    }

    fn dilation(&self, stress: &[f64; 4]) -> f64 {
        whichever!(self, law => law.dilation(stress))
    }
}

/// Most materials of a scene.
pub const MOST_MATERIALS: usize = 32;

/// The materials of a scene, and which particle is of which.
#[derive(Debug, Clone)]
pub struct Materials<L = Material> {
    laws: Vec<L>,
    /// Which soil is where: the one with a number has the law with that number.
    pub soils: Soils,
}

impl<L: Law> Materials<L> {
    /// One for all particles, of grains that have a volume per mass, m3/kg.
    pub fn one(material: L, grain_inverse: f64) -> Self {
        Self { laws: vec![material], soils: Soils::one(grain_inverse) }
    }

    /// A law for each of the soils, as many.
    pub fn of_soils(laws: Vec<L>, soils: Soils) -> Self {
        Self { laws, soils }
    }

    /// Whether the stress of all is a linear function of the strain.
    pub fn are_linear(&self) -> bool {
        self.laws.iter().all(Law::is_linear)
    }

    /// Whether the tangents of all are symmetric.
    pub fn are_symmetric(&self) -> bool {
        self.laws.iter().all(Law::is_symmetric)
    }

    /// Whether any remembers more than its stress.
    pub fn have_state(&self) -> bool {
        self.laws.iter().any(Law::has_state)
    }

    /// Which material the particle with a number is of.
    #[inline(always)]
    pub fn of(&self, id: u32) -> u8 {
        self.soils.of_particle(id)
    }

    /// All of them.
    #[inline(always)]
    pub fn laws(&self) -> &[L] {
        &self.laws
    }

    /// One of them.
    #[inline(always)]
    pub fn law(&self, which: u8) -> &L {
        &self.laws[usize::from(which)]
    }
}

/// What [`Materials::update`] does.
struct Update<'a, V: Simd> {
    materials: &'a Materials,
    stress: [SimdReal<V>; 4],
    strain: [SimdReal<V>; 4],
    state: State<SimdReal<V>>,
    there: V::m64s,
    ids: &'a [u32],
}

impl<V: Simd> WithSimd for Update<'_, V> {
    type Output = ([SimdReal<V>; 4], State<SimdReal<V>>, Flow<SimdReal<V>>);

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) -> Self::Output {
        let Self { materials, mut stress, strain, mut state, there, ids } = self;
        let flow = if let [only] = &materials.laws[..] {
            only.update_lanes(&mut stress, &strain, &mut state, there)
        } else {
            materials.each(&mut stress, &strain, &mut state, there, ids)
        };
        (stress, state, flow)
    }
}

impl Materials {
    /// The only one, if it is elastic.
    pub fn elastic(&self) -> Option<&LinearElastic> {
        match &self.laws[..] {
            [Material::Elastic(law)] => Some(law),
            _ => None,
        }
    }

    /// Whether any dissipates.
    pub fn are_plastic(&self) -> bool {
        self.laws.iter().any(Material::is_plastic)
    }

    /// Elastic energy per volume (J/m3) of the particle with a number at a stress (Pa).
    pub fn energy(&self, id: u32, stress: &[f64; 4]) -> f64 {
        self.law(self.of(id)).energy(stress)
    }

    /// Each of them changed.
    pub fn map(&self, change: impl Fn(&Material) -> Material) -> Self {
        Self { laws: self.laws.iter().map(change).collect(), soils: self.soils.clone() }
    }

    /// Updates stresses (Pa) and states of a block of particles with their numbers; lanes that are not `there` hold none.
    #[inline(always)]
    pub fn update<V: Simd>(
        &self,
        stress: &mut [SimdReal<V>; 4],
        strain: &[SimdReal<V>; 4],
        state: &mut State<SimdReal<V>>,
        there: V::m64s,
        ids: &[u32],
    ) -> Flow<SimdReal<V>> {
        // A function of its own, one for all shapes.
        let update = Update { materials: self, stress: *stress, strain: *strain, state: *state, there, ids };
        let flow;
        (*stress, *state, flow) = stress[0].simd.vectorize(update);
        flow
    }

    /// The same where the particles of a block may be of several materials.
    #[inline(always)]
    fn each<V: Simd>(
        &self,
        stress: &mut [SimdReal<V>; 4],
        strain: &[SimdReal<V>; 4],
        state: &mut State<SimdReal<V>>,
        there: V::m64s,
        ids: &[u32],
    ) -> Flow<SimdReal<V>> {
        let none = stress[0].like(0.0);
        let mut which = none;
        let mut present = 0_u32;
        for (lane, id) in ids.iter().enumerate() {
            let material = self.of(*id);
            which.set_lane(lane, f64::from(material));
            present |= 1 << material;
        }
        let (old, memory) = (*stress, *state);
        let mut all = Flow::none(none);
        for material in (0..self.laws.len()).filter(|material| present & (1 << material) != 0) {
            let own = none.simd.and_m64s(there, which.equals(none.like(material as f64)));
            let (mut found, mut after) = (old, memory);
            let flow = self.laws[material].update_lanes(&mut found, strain, &mut after, own);
            for s in 0..4 {
                stress[s] = found[s].or(own, stress[s]);
            }
            for s in 0..STATES {
                state[s] = after[s].or(own, state[s]);
            }
            all.dissipation = flow.dissipation.or(own, all.dissipation);
            all.residual = flow.residual.or(own, all.residual);
        }
        all
    }
}

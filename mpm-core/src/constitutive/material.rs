//! The materials of a soil: which there are, and which particle is of which.

use pulp::{Simd, WithSimd};

use super::{Flow, Law, LinearElastic, ModifiedCamClay, MohrCoulomb, STATES, State};
use crate::real::{Lanes, Real};

/// A material, one of those that are known.
#[derive(Debug, Clone, Copy)]
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
        stress: &mut [Lanes<V>; 4],
        strain: &[Lanes<V>; 4],
        state: &mut State<Lanes<V>>,
        there: V::m64s,
    ) -> Flow<Lanes<V>> {
        whichever!(self, law => law.update_lanes(stress, strain, state, there))
    }

    fn altered(&self, factor: f64, stiffness: f64) -> Self {
        match self {
            Self::Elastic(law) => Self::Elastic(law.altered(factor, stiffness)),
            Self::MohrCoulomb(law) => Self::MohrCoulomb(law.altered(factor, stiffness)),
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

    fn dilation(&self, stress: &[f64; 4]) -> f64 {
        whichever!(self, law => law.dilation(stress))
    }
}

/// Most materials of a scene.
pub const MOST_MATERIALS: usize = 8;

/// A material of a scene and where it is.
#[derive(Debug, Clone, Copy)]
pub struct Part<L = Material> {
    /// The material.
    pub material: L,
    /// Its hydraulic conductivity over that of the scene's water.
    pub conductivity: f64,
    /// Its top above the base, m.
    pub top: f64,
    /// Number of the first particle above it, as they were seeded.
    pub end: u32,
}

/// The materials of a scene, and which particle is of which: particles are numbered from the base up, those of a material follow
/// each other.
#[derive(Debug, Clone, Copy)]
pub struct Materials<L = Material> {
    parts: [Part<L>; MOST_MATERIALS],
    count: usize,
}

impl<L: Law> Materials<L> {
    /// One for all particles.
    pub fn one(material: L) -> Self {
        let everywhere = Part { material, conductivity: 1.0, top: f64::INFINITY, end: u32::MAX };
        Self { parts: [everywhere; MOST_MATERIALS], count: 1 }
    }

    /// Several from the base up; `None` without any.
    pub fn several(list: &[Part<L>]) -> Option<Self> {
        // The last one goes on for ever: soil that swells stays in it.
        let last = Part { top: f64::INFINITY, end: u32::MAX, ..*list.last()? };
        let mut all = Self { parts: [last; MOST_MATERIALS], count: list.len().min(MOST_MATERIALS) };
        all.parts[..all.count - 1].copy_from_slice(&list[..all.count - 1]);
        Some(all)
    }

    /// Whether the stress of all is a linear function of the strain.
    pub fn are_linear(&self) -> bool {
        self.parts[..self.count].iter().all(|part| part.material.is_linear())
    }

    /// Whether the tangents of all are symmetric.
    pub fn are_symmetric(&self) -> bool {
        self.parts[..self.count].iter().all(|part| part.material.is_symmetric())
    }

    /// Whether any remembers more than its stress.
    pub fn have_state(&self) -> bool {
        self.parts[..self.count].iter().any(|part| part.material.has_state())
    }

    /// Whether there are several.
    pub fn are_layered(&self) -> bool {
        self.count > 1
    }

    /// Which material the particle with a number is of.
    #[inline(always)]
    pub fn of(&self, id: u32) -> u8 {
        self.parts[..self.count - 1].iter().filter(|part| id >= part.end).count() as u8
    }

    /// Which one is at a height above the base, m.
    pub fn at(&self, height: f64) -> u8 {
        self.parts[..self.count - 1].iter().filter(|part| height >= part.top).count() as u8
    }

    /// One of them.
    #[inline(always)]
    pub fn law(&self, which: u8) -> &L {
        &self.parts[usize::from(which)].material
    }

    /// Its hydraulic conductivity over that of the scene's water.
    #[inline(always)]
    pub fn conductivity(&self, which: u8) -> f64 {
        self.parts[usize::from(which)].conductivity
    }
}

/// What [`Materials::update`] does.
struct Update<'a, V: Simd> {
    materials: &'a Materials,
    stress: [Lanes<V>; 4],
    strain: [Lanes<V>; 4],
    state: State<Lanes<V>>,
    there: V::m64s,
    ids: &'a [u32],
}

impl<V: Simd> WithSimd for Update<'_, V> {
    type Output = ([Lanes<V>; 4], State<Lanes<V>>, Flow<Lanes<V>>);

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) -> Self::Output {
        let Self { materials, mut stress, strain, mut state, there, ids } = self;
        let flow = if materials.count == 1 {
            materials.parts[0].material.update_lanes(&mut stress, &strain, &mut state, there)
        } else {
            materials.each(&mut stress, &strain, &mut state, there, ids)
        };
        (stress, state, flow)
    }
}

impl Materials {
    /// The only one, if it is elastic.
    pub fn elastic(&self) -> Option<&LinearElastic> {
        match &self.parts[0].material {
            Material::Elastic(law) if self.count == 1 => Some(law),
            _ => None,
        }
    }

    /// Whether any dissipates.
    pub fn are_plastic(&self) -> bool {
        self.parts[..self.count].iter().any(|part| part.material.is_plastic())
    }

    /// Elastic energy per volume (J/m3) of the particle with a number at a stress (Pa).
    pub fn energy(&self, id: u32, stress: &[f64; 4]) -> f64 {
        self.law(self.of(id)).energy(stress)
    }

    /// Each of them changed.
    pub fn map(&self, change: impl Fn(&Material) -> Material) -> Self {
        Self { parts: self.parts.map(|part| Part { material: change(&part.material), ..part }), ..*self }
    }

    /// Updates stresses (Pa) and states of a block of particles with their numbers; lanes that are not `there` hold none.
    #[inline(always)]
    pub fn update<V: Simd>(
        &self,
        stress: &mut [Lanes<V>; 4],
        strain: &[Lanes<V>; 4],
        state: &mut State<Lanes<V>>,
        there: V::m64s,
        ids: &[u32],
    ) -> Flow<Lanes<V>> {
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
        stress: &mut [Lanes<V>; 4],
        strain: &[Lanes<V>; 4],
        state: &mut State<Lanes<V>>,
        there: V::m64s,
        ids: &[u32],
    ) -> Flow<Lanes<V>> {
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
        for material in (0..self.count).filter(|material| present & (1 << material) != 0) {
            let own = none.simd.and_m64s(there, which.equals(none.like(material as f64)));
            let (mut found, mut after) = (old, memory);
            let flow = self.parts[material].material.update_lanes(&mut found, strain, &mut after, own);
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

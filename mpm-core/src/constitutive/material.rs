//! The materials of a soil: which there are, and which particle is of which.

use pulp::Simd;

use super::{Flow, Law, Laws, LinearElastic, MohrCoulomb};
use crate::real::{Lanes, Real};

/// A material, one of those that are known.
#[derive(Debug, Clone, Copy)]
pub enum Material {
    /// Isotropic linear elasticity.
    Elastic(LinearElastic<4>),
    /// Elastic, perfectly plastic.
    MohrCoulomb(MohrCoulomb<4>),
}

impl Material {
    /// Whether it dissipates.
    pub fn is_plastic(&self) -> bool {
        match self {
            Self::Elastic(_) => false,
            Self::MohrCoulomb(_) => true,
        }
    }

    /// Updates stresses (Pa) of several particles by strain increments, and says what that did; lanes that are not `there` hold none.
    #[inline(always)]
    fn update<V: Simd>(&self, stress: &mut [Lanes<V>; 4], strain: &[Lanes<V>; 4], there: V::m64s) -> Flow<Lanes<V>> {
        match self {
            Self::Elastic(law) => {
                law.update_lanes(stress, strain);
                let none = stress[0].like(0.0);
                Flow { dissipation: none, residual: none.like(f64::NEG_INFINITY) }
            }
            Self::MohrCoulomb(law) => law.flow_lanes(stress, strain, there),
        }
    }
}

/// Calls the same method of whatever the material is.
macro_rules! whichever {
    ($self:ident, $law:ident => $call:expr) => {
        match $self {
            Material::Elastic($law) => $call,
            Material::MohrCoulomb($law) => $call,
        }
    };
}

impl Law<4> for Material {
    const LINEAR: bool = false;
    const PLASTIC: bool = true;

    fn update(&self, stress: &mut [f64; 4], strain: &[f64; 4]) {
        whichever!(self, law => law.update(stress, strain));
    }

    fn flow(&self, stress: &mut [f64; 4], strain: &[f64; 4]) -> Flow {
        whichever!(self, law => law.flow(stress, strain))
    }

    fn altered(&self, factor: f64, stiffness: f64) -> Self {
        match self {
            Self::Elastic(law) => Self::Elastic(law.altered(factor, stiffness)),
            Self::MohrCoulomb(law) => Self::MohrCoulomb(law.altered(factor, stiffness)),
        }
    }

    fn yield_residual(&self, stress: &[f64; 4]) -> f64 {
        whichever!(self, law => law.yield_residual(stress))
    }

    fn tangent(&self, stress: &[f64; 4], strain: &[f64; 4]) -> nalgebra::SMatrix<f64, 4, 4> {
        whichever!(self, law => law.tangent(stress, strain))
    }

    fn energy(&self, stress: &[f64; 4]) -> f64 {
        whichever!(self, law => law.energy(stress))
    }

    fn dilation(&self, stress: &[f64; 4]) -> f64 {
        whichever!(self, law => law.dilation(stress))
    }
}

/// Most materials of a scene.
pub const MOST: usize = 8;

/// The materials of a scene, and which particle is of which: particles are numbered from the base up, those of a material follow
/// each other.
#[derive(Debug, Clone, Copy)]
pub struct Materials {
    list: [Material; MOST],
    count: usize,
    /// Number of the first particle above those of each.
    ends: [u32; MOST],
}

impl Materials {
    /// One for all particles.
    pub fn one(material: Material) -> Self {
        Self { list: [material; MOST], count: 1, ends: [u32::MAX; MOST] }
    }

    /// Several, each with the number of the first particle above its own; `None` without any.
    pub fn several(list: &[(Material, u32)]) -> Option<Self> {
        let (last, _) = *list.last()?;
        let mut all = Self { list: [last; MOST], count: list.len(), ends: [u32::MAX; MOST] };
        for (i, (material, end)) in list.iter().enumerate().take(list.len() - 1) {
            (all.list[i], all.ends[i]) = (*material, *end);
        }
        Some(all)
    }

    /// Whether any dissipates.
    pub fn are_plastic(&self) -> bool {
        self.list[..self.count].iter().any(Material::is_plastic)
    }

    /// Which material the particle with a number is of.
    #[inline(always)]
    pub fn of(&self, id: u32) -> usize {
        self.ends[..self.count - 1].iter().filter(|end| id >= **end).count()
    }

    /// Elastic energy per volume (J/m3) of the particle with a number at a stress (Pa).
    pub fn energy(&self, id: u32, stress: &[f64; 4]) -> f64 {
        self.list[self.of(id)].energy(stress)
    }

    /// Each of them changed.
    pub fn map(&self, change: impl Fn(&Material) -> Material) -> Self {
        Self { list: self.list.each_ref().map(change), ..*self }
    }

    /// Updates the stresses (Pa) of a block of particles with their numbers; lanes that are not `there` hold none.
    #[inline(always)]
    pub fn update<V: Simd>(
        &self,
        stress: &mut [Lanes<V>; 4],
        strain: &[Lanes<V>; 4],
        there: V::m64s,
        ids: &[u32],
    ) -> Flow<Lanes<V>> {
        if self.count == 1 { self.list[0].update(stress, strain, there) } else { self.each(stress, strain, there, ids) }
    }

    /// The same where the particles of a block may be of several materials.
    #[inline(always)]
    fn each<V: Simd>(
        &self,
        stress: &mut [Lanes<V>; 4],
        strain: &[Lanes<V>; 4],
        there: V::m64s,
        ids: &[u32],
    ) -> Flow<Lanes<V>> {
        let none = stress[0].like(0.0);
        let mut which = none;
        let mut present = 0_u32;
        for (lane, id) in ids.iter().enumerate() {
            let material = self.of(*id);
            which.set_lane(lane, material as f64);
            present |= 1 << material;
        }
        let old = *stress;
        let mut all = Flow { dissipation: none, residual: none.like(f64::NEG_INFINITY) };
        for material in (0..self.count).filter(|material| present & (1 << material) != 0) {
            let own = none.simd.and_m64s(there, which.equals(none.like(material as f64)));
            let mut found = old;
            let flow = self.list[material].update(&mut found, strain, own);
            for s in 0..4 {
                stress[s] = found[s].or(own, stress[s]);
            }
            all.dissipation = flow.dissipation.or(own, all.dissipation);
            all.residual = flow.residual.or(own, all.residual);
        }
        all
    }
}

impl Laws<4> for Materials {
    type One = Material;
    type Mark = u8;
    const LAYERED: bool = true;

    #[inline(always)]
    fn mark_of(&self, id: u32) -> u8 {
        self.of(id) as u8
    }

    fn mark_at(&self, _: f64) -> u8 {
        0
    }

    #[inline(always)]
    fn law(&self, mark: u8) -> &Material {
        &self.list[usize::from(mark)]
    }

    fn conductivity(&self, _: u8) -> f64 {
        1.0
    }
}

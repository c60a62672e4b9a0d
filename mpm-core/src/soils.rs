//! Which particle is of which soil, and what of that is no law: conductivity, grains, the water that stays in its pores.

use std::sync::Arc;

use crate::scene::{Fields, Ground, Soil, Zones};

/// What a soil is to the water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kind {
    /// Its hydraulic conductivity over that of the scene's water: xx, yy, xy.
    pub conductivity: [f64; 3],
    /// What of its conductivity stays, and what goes with `n^3/(1 - n)^2`.
    pub by_porosity: [f64; 2],
    /// Volume of the grains per mass, m3/kg.
    pub grain_inverse: f64,
    /// Volume of the water that stays in its pores under a free surface, per dry mass, m3/kg.
    pub stays: f64,
    /// Biot's coefficient alpha, and what grains give per volume and pressure, 1/Pa: 1 and 0 where they do not compress.
    pub biot: [f64; 2],
    /// Volume per dry mass before any strain, m3/kg.
    pub dry_inverse: f64,
}

/// The soils of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Soils {
    kinds: Arc<[Kind]>,
    /// Where they are at t = 0.
    zones: Zones,
    /// Which one each particle is of, by its number; empty where there is only one.
    which: Arc<[u8]>,
}

impl Soils {
    /// One for all particles, that conducts as the water does and has grains of a volume per mass, m3/kg.
    pub fn one(grain_inverse: f64) -> Self {
        let (conductivity, biot) = ([1.0, 1.0, 0.0], [1.0, 0.0]);
        let by_porosity = [1.0, 0.0];
        let kinds = [Kind { conductivity, by_porosity, grain_inverse, stays: 0.0, biot, dry_inverse: 1.0 }];
        Self { kinds: Arc::new(kinds), zones: Zones::default(), which: Arc::default() }
    }

    /// Those of a scene, of particles at these places, m.
    pub fn of(scene: &Fields, places: impl Iterator<Item = [f64; 2]>) -> Self {
        let reference = scene.water.map_or(1.0, |water| water.hydraulic_conductivity);
        let saturation = scene.free_surface.as_ref().map_or(0.0, |free| free.saturation);
        let kind = |soil: &Soil| Kind {
            conductivity: match scene.water {
                Some(_) => {
                    let vertical = soil.hydraulic_conductivity / reference; // across the bedding
                    let (sin, cos) = soil.fabric.bedding_angle.to_radians().sin_cos();
                    let along = (soil.anisotropy - 1.0) * vertical;
                    // Of level bedding to the last bit.
                    let across = if sin == 0.0 { 0.0 } else { along * sin * cos };
                    [soil.anisotropy * vertical - along * sin * sin, vertical + along * sin * sin, across]
                }
                None => [1.0, 1.0, 0.0],
            },
            by_porosity: if soil.fabric.kozeny_carman { [0.0, 1.0 / kozeny_carman(soil.porosity)] } else { [1.0, 0.0] },
            grain_inverse: 1.0 / soil.grain_density,
            stays: saturation * soil.porosity / soil.dry_density(),
            biot: [soil.alpha(), soil.grain_storage()],
            dry_inverse: 1.0 / soil.dry_density(),
        };
        let Ground { soils, zones, .. } = scene.ground();
        let kinds: Arc<[Kind]> = soils.iter().map(kind).collect();
        let which = if kinds.len() > 1 { places.map(|place| zones.at(&place)).collect() } else { Arc::default() };
        Self { kinds, zones, which }
    }

    /// What the particle with a number is of.
    #[inline(always)]
    pub fn of_particle(&self, id: u32) -> u8 {
        // SimdReal without a particle have a number of none.
        self.which.get(id as usize).copied().unwrap_or(0)
    }

    /// Which one is at a place at t = 0, m.
    pub fn at(&self, place: &[f64; 2]) -> u8 {
        self.zones.at(place)
    }

    /// One of them.
    #[inline(always)]
    pub fn kind(&self, which: u8) -> &Kind {
        &self.kinds[usize::from(which)]
    }

    /// That of the particle with a number.
    #[inline(always)]
    pub fn kind_of(&self, id: u32) -> &Kind {
        self.kind(self.of_particle(id))
    }

    /// Whether there are several.
    pub fn are_several(&self) -> bool {
        self.kinds.len() > 1
    }

    /// Whether they conduct differently, or not the same along both axes, or not always the same.
    pub fn conduct_differently(&self) -> bool {
        self.kinds.iter().any(|kind| kind.conductivity != [1.0, 1.0, 0.0]) || self.go_with_porosity()
    }

    /// Whether the conductivity of any goes with its porosity.
    pub fn go_with_porosity(&self) -> bool {
        self.kinds.iter().any(|kind| kind.by_porosity[1] > 0.0)
    }

    /// Whether their grains weigh differently.
    pub fn weigh_differently(&self) -> bool {
        self.kinds.iter().any(|kind| kind.grain_inverse != self.kinds[0].grain_inverse)
    }

    /// Whether the grains of any compress.
    pub fn compress(&self) -> bool {
        self.kinds.iter().any(|kind| kind.biot != [1.0, 0.0])
    }

    /// Largest conductivity of any along any axis, over that of the scene's water.
    pub fn largest_conductivity(&self) -> f64 {
        self.kinds.iter().flat_map(|kind| [kind.conductivity[0], kind.conductivity[1]]).fold(0.0, f64::max)
    }
}

/// `n^3/(1 - n)^2` of a porosity n.
fn kozeny_carman(porosity: f64) -> f64 {
    porosity.powi(3) / (1.0 - porosity).powi(2)
}

/// Conductivity over that at first, of which a part stays and another goes with the porosity n now.
#[inline(always)]
pub fn at_porosity([stays, goes]: [f64; 2], porosity: f64) -> f64 {
    if goes == 0.0 { stays } else { stays + goes * kozeny_carman(porosity.max(0.0)) }
}

impl Kind {
    /// Its hydraulic conductivity along an axis of so many, over that of the scene's water.
    #[inline(always)]
    pub fn along(&self, axis: usize, dimensions: usize) -> f64 {
        self.conductivity[axis + 2 - dimensions]
    }
}

//! The soils of a scene and which is where: that of `[soil]`, horizontal layers in its place, and regions over both.

use std::borrow::Cow;

use std::ops::{Deref, DerefMut};

use serde::Serialize;

use super::{CamClay, Elastic, Fields, Start, Strength};
use crate::seeding::{self, inside};

/// What a part of the ground is made of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Soil {
    /// Elasticity of its skeleton.
    pub elastic: Elastic,
    /// Its strength, where its law is Mohr-Coulomb.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strength: Option<Strength>,
    /// Its hardening, where its law is modified Cam-Clay.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cam_clay: Option<CamClay>,
    /// Density of the grains, kg/m3.
    pub grain_density: f64,
    /// Porosity n.
    pub porosity: f64,
    /// Hydraulic conductivity k, m/s, the vertical one where there are two; that of no water is 0.
    pub hydraulic_conductivity: f64,
    /// Hydraulic conductivity along the bedding over that across it, which is k.
    #[serde(skip_serializing_if = "is_one")]
    pub anisotropy: f64,
    /// What else that depends on.
    #[serde(flatten)]
    pub fabric: Fabric,
    /// Lateral over vertical effective stress of a geostatic start; `None` for that of no lateral strain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k0: Option<f64>,
    /// Grains that compress; `None` for those that do not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub biot: Option<Biot>,
}

/// What hydraulic conductivity depends on beside its size along and across the bedding.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Fabric {
    /// Angle of the bedding to the horizontal, degrees, anticlockwise.
    #[serde(skip_serializing_if = "super::f64_is_zero")]
    pub bedding_angle: f64,
    /// Whether it goes with the porosity as `n^3/(1 - n)^2` (Kozeny 1927, Carman 1937); else it stays.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub kozeny_carman: bool,
}

/// Grains that compress, as Biot's theory has them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Biot {
    /// Share alpha of the pore pressure in the total stress, `sigma = sigma' - alpha p`: 1 - K/K_s.
    pub coefficient: f64,
    /// Bulk modulus K_s of the grains, Pa.
    pub grain_bulk_modulus: f64,
}

/// Keys that most soils do not have stay out of the record of a scene.
pub(super) fn is_one(number: &f64) -> bool {
    *number == 1.0
}

impl Soil {
    /// Density of the dry skeleton, (1 - n) rho_s, kg/m3.
    pub fn dry_density(&self) -> f64 {
        (1.0 - self.porosity) * self.grain_density
    }

    /// Biot's coefficient alpha: 1 for grains that do not compress.
    pub fn alpha(&self) -> f64 {
        self.biot.map_or(1.0, |biot| biot.coefficient)
    }

    /// What grains give per volume and pressure, (alpha - n)/K_s, 1/Pa.
    pub fn grain_storage(&self) -> f64 {
        self.biot.map_or(0.0, |biot| (biot.coefficient - self.porosity) / biot.grain_bulk_modulus)
    }

    /// Lateral effective stress of a geostatic start beside a vertical one, Pa, tension positive: as K0 says, or else that of no
    /// lateral strain, but no less than the active one that the soil bears, `K_a sigma_v - 2 c sqrt(K_a)`.
    pub fn lateral_stress(&self, vertical: f64) -> f64 {
        let at_rest = |k0: f64| k0 * vertical;
        match (self.k0, self.strength) {
            (Some(k0), _) => at_rest(k0),
            (None, strength) => {
                let elastic = at_rest(self.elastic.lame() / self.elastic.oedometer_modulus());
                let active = strength.map_or(elastic, |strength| {
                    let root = (45.0 - 0.5 * strength.friction_angle).to_radians().tan();
                    root * root * vertical + 2.0 * strength.cohesion * root
                });
                elastic.min(active)
            }
        }
    }
}

/// A layer of soil, from the top of the one below it to its own top.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SoilLayer {
    /// Top of the layer above the base, m.
    pub up_to: f64,
    /// What it is made of.
    #[serde(flatten)]
    pub soil: Soil,
}

impl Deref for SoilLayer {
    type Target = Soil;

    fn deref(&self) -> &Soil {
        &self.soil
    }
}

impl DerefMut for SoilLayer {
    fn deref_mut(&mut self) -> &mut Soil {
        &mut self.soil
    }
}

/// A part of the ground with a soil of its own.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Region {
    /// Its corners, m.
    pub polygon: Vec<[f64; 2]>,
    /// Its heights (m), if it goes all across.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<[f64; 2]>,
    /// What it is made of.
    #[serde(flatten)]
    pub soil: Soil,
}

/// All soils: of the layers, or else that of the scene, then of the regions; and which is where.
#[derive(Debug, Clone)]
pub struct Ground {
    /// The soils by their numbers.
    pub soils: Vec<Soil>,
    /// Edge of the square that a particle stands for, m: it is of the soil in its middle.
    spacing: f64,
    /// Which one is where.
    pub zones: Zones,
}

impl Ground {
    /// The soil at a place, m.
    pub fn at(&self, place: &[f64; 2]) -> &Soil {
        &self.soils[usize::from(self.zones.at(place))]
    }

    /// Soil along the vertical line at x (m) between two heights (m), as particles see it, from the lower one up: from where to
    /// where, and which.
    pub fn between(&self, x: f64, low: f64, high: f64) -> Vec<([f64; 2], Soil)> {
        // Rows of particles that it changes in have the soil of their middle.
        let edges = |y: f64| {
            let row = y / self.spacing;
            let on_edge = (row - row.round()).abs() < 1e-9;
            if on_edge { [y; 2] } else { [row.floor(), row.ceil()].map(|row| row * self.spacing) }
        };
        let changes = self.zones.changes(x).flat_map(edges);
        let mut ends: Vec<f64> = changes.filter(|y| *y > low && *y < high).chain([low, high]).collect();
        ends.sort_by(f64::total_cmp);
        let middle = |y: f64| ((y / self.spacing).floor() + 0.5) * self.spacing;
        let part = |ends: &[f64]| ([ends[0], ends[1]], *self.at(&[x, middle(0.5 * (ends[0] + ends[1]))]));
        ends.windows(2).filter(|ends| ends[1] > ends[0]).map(part).collect()
    }
}

/// Which soil is where at t = 0, by its number.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Zones {
    /// Tops of the layers but the last, from the base up, m.
    tops: Vec<f64>,
    /// Corners of the regions, m; the last one that a place is in has it.
    regions: Vec<Vec<[f64; 2]>>,
}

impl Zones {
    /// Number of the soil at a place, m.
    pub fn at(&self, place: &[f64; 2]) -> u8 {
        let first = self.tops.len() + 1;
        let region = self.regions.iter().rposition(|polygon| inside(polygon, place));
        region.map_or_else(|| self.tops.iter().filter(|top| place[1] >= **top).count(), |i| first + i) as u8
    }

    /// Heights at which the soil changes along a vertical line at x, m.
    fn changes(&self, x: f64) -> impl Iterator<Item = f64> {
        self.tops.iter().copied().chain(self.regions.iter().flat_map(move |polygon| seeding::passes(polygon, x)))
    }
}

impl Fields {
    /// The soil of `[soil]`.
    pub fn soil(&self) -> Soil {
        let Self { elastic, strength, cam_clay, grain_density, porosity, start_k0, biot, .. } = *self;
        let (hydraulic_conductivity, anisotropy, fabric) =
            self.water.map_or((0.0, 1.0, Fabric::default()), |w| (w.hydraulic_conductivity, w.anisotropy, w.fabric));
        let k0 = start_k0;
        Soil {
            elastic,
            strength,
            cam_clay,
            grain_density,
            porosity,
            hydraulic_conductivity,
            anisotropy,
            fabric,
            k0,
            biot,
        }
    }

    /// All soils, and which is where.
    pub fn ground(&self) -> Ground {
        let tops = self.layers.iter().map(|layer| layer.up_to).take(self.layers.len().saturating_sub(1)).collect();
        let zones = Zones { tops, regions: self.regions.iter().map(|region| region.polygon.clone()).collect() };
        Ground { soils: self.soils(), spacing: self.spacing(), zones }
    }

    /// All soils: of the layers, or else that of the scene, then of the regions.
    pub fn soils(&self) -> Vec<Soil> {
        self.each_soil().collect()
    }

    /// [`Self::soils`], one after the other.
    pub fn each_soil(&self) -> impl Iterator<Item = Soil> {
        let own = self.layers.is_empty().then(|| self.soil());
        let (layers, regions) = (self.layers.iter(), self.regions.iter());
        layers.map(|layer| layer.soil).chain(own).chain(regions.map(|region| region.soil))
    }

    /// Whether there is more than one soil.
    pub fn has_several_soils(&self) -> bool {
        self.layers.len() + self.regions.len() > 0
    }

    /// Layers from the base up, each with its thickness (m) and as a scene of its soil alone; the scene itself where
    /// there are none.
    pub fn by_layer(&self) -> Vec<(f64, Self)> {
        if self.layers.is_empty() {
            return vec![(self.height, self.clone())];
        }
        self.thicknesses().map(|(layer, thickness)| (thickness, self.with_soil_of(&layer.soil))).collect()
    }

    /// Every soil as a scene of it alone.
    pub fn by_soil(&self) -> Vec<Cow<'_, Self>> {
        if !self.has_several_soils() {
            return vec![Cow::Borrowed(self)];
        }
        self.soils().iter().map(|soil| Cow::Owned(self.with_soil_of(soil))).collect()
    }

    /// The scene with one soil all over.
    fn with_soil_of(&self, soil: &Soil) -> Self {
        let Soil { elastic, strength, cam_clay, grain_density, porosity, k0, biot, .. } = *soil;
        let (layers, regions) = (Vec::new(), Vec::new());
        let base = Self { layers, regions, elastic, strength, cam_clay, grain_density, porosity, ..self.clone() };
        let mut scene = Self { start_k0: k0, biot, ..base };
        if let Some(water) = &mut scene.water {
            water.hydraulic_conductivity = soil.hydraulic_conductivity;
            (water.anisotropy, water.fabric) = (soil.anisotropy, soil.fabric);
        }
        scene
    }

    /// Total vertical stress at a height (m) under surcharge and weight, Pa, compression positive.
    pub fn total_stress_at(&self, height: f64) -> f64 {
        let weight = self.gravity.unwrap_or(0.0);
        let weight = if self.has_several_soils() {
            let parts = self.ground().between(0.5 * self.width, height, self.height);
            weight * parts.iter().map(|([low, high], soil)| self.mixture_density_of(soil) * (high - low)).sum::<f64>()
        } else {
            weight * self.mixture_density() * (self.height - height)
        };
        self.surcharge.map_or(0.0, |s| s.pressure) + weight
    }

    /// Undrained pore pressure at a height (m), the share Q/(M + Q) of the total stress, Pa: each layer has its own.
    pub fn undrained_pressure_at(&self, height: f64) -> f64 {
        let soil = if self.has_several_soils() { *self.ground().at(&[0.5 * self.width, height]) } else { self.soil() };
        self.undrained_share_in(&soil) / soil.alpha() * self.total_stress_at(height)
    }

    /// Settlement of the state a run starts from, counted from the unloaded one, m: the sum over the layers of
    /// (s - p_0) h/M with the total stress s in their middle.
    pub fn first_settlement(&self) -> f64 {
        if self.start != Start::UndrainedEquilibrium {
            return 0.0;
        }
        let of = |soil: &Soil, base: f64, top: f64| {
            let carried = (1.0 - self.undrained_share_in(soil)) * self.total_stress_at(0.5 * (base + top));
            carried * (top - base) / soil.elastic.oedometer_modulus()
        };
        self.middle().iter().map(|([a, b], soil)| of(soil, *a, *b)).sum()
    }

    /// Water that the soil gives per volume and pressure under a constant load, alpha^2/M + 1/Q, averaged over the height,
    /// 1/Pa; 1/Q is n/K_w where grains do not compress.
    pub fn storage(&self) -> f64 {
        let of = |soil: &Soil| {
            soil.alpha().powi(2) * (1.0 / soil.elastic.oedometer_modulus() + 1.0 / self.pore_stiffness_of(soil))
        };
        self.middle().iter().map(|([low, high], soil)| (high - low) * of(soil)).sum::<f64>() / self.height
    }

    /// Soil along the middle of the scene, from the base up: from where to where, and which.
    pub(super) fn middle(&self) -> Vec<([f64; 2], Soil)> {
        self.ground().between(0.5 * self.width, 0.0, self.height)
    }

    /// Every layer with its thickness, m.
    pub(super) fn thicknesses(&self) -> impl Iterator<Item = (&SoilLayer, f64)> {
        let bases = std::iter::once(0.0).chain(self.layers.iter().map(|layer| layer.up_to));
        self.layers.iter().zip(bases).map(|(layer, base)| (layer, layer.up_to - base))
    }
}

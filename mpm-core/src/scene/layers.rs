//! Soil in horizontal layers: which one is where, and what differs from one to the next.

use serde::Serialize;

use super::{CamClay, Elastic, Fields, Start, Strength};

/// A layer of soil, from the top of the one below it to its own top.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SoilLayer {
    /// Top of the layer above the base, m.
    pub up_to: f64,
    /// Elasticity of its skeleton.
    pub elastic: Elastic,
    /// Its strength, where its law is Mohr-Coulomb.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strength: Option<Strength>,
    /// Its hardening, where its law is modified Cam-Clay.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cam_clay: Option<CamClay>,
    /// Hydraulic conductivity k, m/s; that of no water is 0.
    pub hydraulic_conductivity: f64,
}

impl Fields {
    /// The layer at a height above the base (m); `None` in a scene without layers. Above the last one it goes on.
    pub fn layer_at(&self, height: f64) -> Option<&SoilLayer> {
        self.layers.iter().find(|layer| height < layer.up_to).or(self.layers.last())
    }

    /// Layers from the base up, each with its thickness (m) and as a scene of its soil alone; the scene itself where
    /// there are none.
    pub fn by_layer(&self) -> Vec<(f64, Self)> {
        if self.layers.is_empty() {
            return vec![(self.height, self.clone())];
        }
        self.thicknesses().map(|(layer, thickness)| (thickness, self.with_soil_of(layer))).collect()
    }

    /// The scene with the soil of one layer all over.
    fn with_soil_of(&self, layer: &SoilLayer) -> Self {
        let SoilLayer { elastic, strength, cam_clay, .. } = *layer;
        let mut scene = Self { layers: Vec::new(), elastic, strength, cam_clay, ..self.clone() };
        if let Some(water) = &mut scene.water {
            water.hydraulic_conductivity = layer.hydraulic_conductivity;
        }
        scene
    }

    /// Elasticity at a height above the base, m.
    pub fn elastic_at(&self, height: f64) -> Elastic {
        self.layer_at(height).map_or(self.elastic, |layer| layer.elastic)
    }

    /// Total vertical stress at a height (m) under surcharge and weight, Pa, compression positive.
    pub fn total_stress_at(&self, height: f64) -> f64 {
        let weight = self.gravity.unwrap_or(0.0) * self.mixture_density() * (self.height - height);
        self.surcharge.map_or(0.0, |s| s.pressure) + weight
    }

    /// Undrained pore pressure at a height (m), the share Q/(M + Q) of the total stress, Pa: each layer has its own.
    pub fn undrained_pressure_at(&self, height: f64) -> f64 {
        self.undrained_share_in(&self.elastic_at(height)) * self.total_stress_at(height)
    }

    /// Settlement of the state a run starts from, counted from the unloaded one, m: the sum over the layers of
    /// (s - p_0) h/M with the total stress s in their middle.
    pub fn first_settlement(&self) -> f64 {
        if self.start != Start::UndrainedEquilibrium {
            return 0.0;
        }
        let of = |elastic: &Elastic, base: f64, top: f64| {
            let carried = (1.0 - self.undrained_share_in(elastic)) * self.total_stress_at(0.5 * (base + top));
            carried * (top - base) / elastic.oedometer_modulus()
        };
        if self.layers.is_empty() {
            return of(&self.elastic, 0.0, self.height);
        }
        self.thicknesses().map(|(layer, thickness)| of(&layer.elastic, layer.up_to - thickness, layer.up_to)).sum()
    }

    /// Water that the soil gives per volume and pressure under a constant load, 1/M + n/K_w, averaged over the height,
    /// 1/Pa.
    pub fn storage(&self) -> f64 {
        let of = |elastic: &Elastic| 1.0 / elastic.oedometer_modulus() + 1.0 / self.pore_stiffness();
        if self.layers.is_empty() {
            return of(&self.elastic);
        }
        let whole: f64 = self.thicknesses().map(|(layer, thickness)| thickness * of(&layer.elastic)).sum();
        whole / self.height
    }

    /// Every layer with its thickness, m.
    pub(super) fn thicknesses(&self) -> impl Iterator<Item = (&SoilLayer, f64)> {
        let bases = std::iter::once(0.0).chain(self.layers.iter().map(|layer| layer.up_to));
        self.layers.iter().zip(bases).map(|(layer, base)| (layer, layer.up_to - base))
    }
}

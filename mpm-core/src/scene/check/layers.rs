//! Soil in layers: their bounds, and what they do not go together with.

use std::ops::Range;

use toml::Spanned;

use super::super::raw::{RawLayer, RawScene};
use super::super::{Fields, Integrator, SoilLayer, StrainChoice};
use super::{Checked, Reader};
use crate::constitutive::MOST_MATERIALS;

/// How far from a face of a cell the top of a layer may be, as a share of a cell.
const ON_A_FACE: f64 = 1e-6;

impl Reader<'_> {
    /// The checked `[[layers]]`, of a scene that has all else.
    pub(super) fn layers(&self, raw: &RawScene, scene: &Fields) -> Checked<Vec<SoilLayer>> {
        let Some(list) = &raw.layers else { return Ok(Vec::new()) };
        let table = match list.get_ref().first() {
            Some(first) => first.span(),
            None => return self.refuse(&list.span(), "layers", "at least one [[layers]], or no such table", "none"),
        };
        if list.get_ref().len() > MOST_MATERIALS {
            let expected = format!("at most {MOST_MATERIALS} layers");
            return self.refuse(&table, "layers", &expected, list.get_ref().len());
        }
        self.steps_with_layers(raw, scene, &table)?;
        let mut layers: Vec<SoilLayer> = Vec::new();
        for layer in list.get_ref() {
            let below = layers.last().map_or(0.0, |layer| layer.up_to);
            layers.push(self.layer(layer.get_ref(), (raw, scene), below)?);
        }
        if let (Some(layer), Some(last)) = (layers.last_mut(), list.get_ref().last()) {
            if (layer.up_to - scene.height).abs() > ON_A_FACE * scene.cell {
                let expected = format!("{} m, the height, as the top of the last layer", scene.height);
                return self.refuse(&last.get_ref().up_to.span(), "layers.up_to", &expected, layer.up_to);
            }
            layer.up_to = scene.height;
        }
        Ok(layers)
    }

    /// One layer above a height (m).
    fn layer(&self, raw: &RawLayer, (whole, scene): (&RawScene, &Fields), below: f64) -> Checked<SoilLayer> {
        let expected = format!("{below} m < up_to <= {} m, from the layer below to the height", scene.height);
        let most = scene.height + ON_A_FACE * scene.cell;
        let up_to = self.within(&raw.up_to, "layers.up_to", &expected, |y| y > below && y <= most)?;
        let rows = up_to / scene.cell;
        if (rows - rows.round()).abs() > ON_A_FACE {
            let expected = format!("a whole number of cells of {} m: a layer ends at the face of a cell", scene.cell);
            let found = format!("{up_to} m ({rows} cells)");
            return self.refuse(&raw.up_to.span(), "layers.up_to", &expected, found);
        }
        let (mut elastic, strength, cam_clay) = match &raw.law {
            Some(law) => self.law("layers.law", law, whole, scene.height)?,
            None => (scene.elastic, scene.strength, scene.cam_clay),
        };
        let own = [("layers.youngs_modulus", &raw.youngs_modulus), ("layers.poisson_ratio", &raw.poisson_ratio)];
        for (key, value) in own {
            if let (Some(value), true) = (value, raw.law.is_some() || cam_clay.is_some()) {
                let expected = "that of its law, or the elasticity of [soil] where a layer has no law of its own";
                return self.refuse(&value.span(), key, expected, value.get_ref());
            }
        }
        if let Some(value) = &raw.youngs_modulus {
            elastic.youngs_modulus = self.positive(value, "layers.youngs_modulus", "Pa")?;
        }
        if let Some(value) = &raw.poisson_ratio {
            let bounds = |nu| nu > -1.0 && nu < 0.5;
            elastic.poisson_ratio = self.within(value, "layers.poisson_ratio", "-1 < nu < 0.5", bounds)?;
        }
        let hydraulic_conductivity = match (&raw.hydraulic_conductivity, &scene.water) {
            (Some(value), Some(_)) => self.positive(value, "layers.hydraulic_conductivity", "m/s")?,
            (Some(value), None) => {
                let expected = "[water] beside it: a dry scene conducts none";
                return self.refuse(&value.span(), "layers.hydraulic_conductivity", expected, value.get_ref());
            }
            (None, water) => water.map_or(0.0, |w| w.hydraulic_conductivity),
        };
        Ok(SoilLayer { up_to, elastic, strength, cam_clay, hydraulic_conductivity })
    }

    /// A mesh that goes along with its soil.
    fn steps_with_layers(&self, raw: &RawScene, scene: &Fields, table: &Range<usize>) -> Checked<()> {
        if scene.integrator == Integrator::QuasiStatic && scene.strain == StrainChoice::Large {
            let expected = "\"small\" beside [[layers]] and quasi-static: a mesh laid over moved soil cuts its layers";
            let span = raw.soil.get_ref().strain.as_ref().map_or(table.clone(), Spanned::span);
            return self.refuse(&span, "soil.strain", expected, "\"large\"");
        }
        Ok(())
    }
}

//! The soils of layers and regions: their bounds, and what they do not go together with.

use std::ops::Range;

use toml::Spanned;

use super::super::raw::{RawScene, RawZone};
use super::super::{Biot, Dimension, Elastic, Fabric, Fields, Region, Soil, SoilLayer, StrainChoice};
use super::{Checked, Reader};
use crate::constitutive::MOST_MATERIALS;
use crate::seeding;

/// How far from a face of a cell the top of a layer may be, as a share of a cell.
const ON_A_FACE: f64 = 1e-6;

/// Zones as they are listed, and where.
type Listed<'v> = (&'v [Spanned<RawZone>], Range<usize>);

impl Reader<'_> {
    /// The checked `[[layers]]`, of a scene that has all else.
    pub(super) fn layers(&self, raw: &RawScene, scene: &Fields) -> Checked<Vec<SoilLayer>> {
        let Some((list, table)) = self.zones("layers", &raw.layers)? else { return Ok(Vec::new()) };
        self.steps_with("layers", raw, scene, &table)?;
        let mut layers: Vec<SoilLayer> = Vec::new();
        for layer in list {
            let below = layers.last().map_or(0.0, |layer| layer.up_to);
            layers.push(self.layer(layer, (raw, scene), below)?);
        }
        if let (Some(layer), Some(last)) = (layers.last_mut(), list.last()) {
            if (layer.up_to - scene.height).abs() > ON_A_FACE * scene.cell {
                let expected = "the height of the soil (m) as the top of the last layer";
                return self
                    .refuse(&top_of(last), "layers.up_to", expected, layer.up_to)
                    .map_err(|fault| fault.with(format!("height {} m", scene.height)));
            }
            layer.up_to = scene.height;
        }
        Ok(layers)
    }

    /// The checked `[[regions]]`, of a scene that has all else.
    pub(super) fn regions(&self, raw: &RawScene, scene: &Fields) -> Checked<Vec<Region>> {
        let Some((list, table)) = self.zones("regions", &raw.regions)? else { return Ok(Vec::new()) };
        self.steps_with("regions", raw, scene, &table)?;
        let most = MOST_MATERIALS - scene.layers.len().max(1);
        if list.len() > most {
            return self.refuse(&table, "regions", &format!("at most {most} regions"), list.len());
        }
        list.iter().map(|region| self.region(region, raw, scene)).collect()
    }

    /// A list of soils that is there, and the place of its first.
    fn zones<'v>(&self, key: &str, list: &'v Option<Spanned<Vec<Spanned<RawZone>>>>) -> Checked<Option<Listed<'v>>> {
        let Some(list) = list else { return Ok(None) };
        let Some(first) = list.get_ref().first() else {
            let expected = format!("at least one [[{key}]], or no such table");
            return self.refuse(&list.span(), key, &expected, "none");
        };
        if list.get_ref().len() > MOST_MATERIALS {
            let expected = format!("at most {MOST_MATERIALS} {key}");
            return self.refuse(&first.span(), key, &expected, list.get_ref().len());
        }
        Ok(Some((list.get_ref(), first.span())))
    }

    /// One layer above a height (m).
    fn layer(&self, layer: &Spanned<RawZone>, (whole, scene): (&RawScene, &Fields), below: f64) -> Checked<SoilLayer> {
        let raw = layer.get_ref();
        if raw.polygon.is_some() || raw.levels.is_some() {
            let expected = "up_to alone: a polygon or two levels bound one of the [[regions]]";
            return self.refuse(&layer.span(), "layers", expected, "polygon or levels");
        }
        let Some(up_to) = &raw.up_to else {
            return self.refuse(&layer.span(), "up_to", "the key up_to", "none");
        };
        let expected = "the top of the layer below < up_to <= the height of the soil (m)";
        let most = scene.height + ON_A_FACE * scene.cell;
        let top = self
            .within(up_to, "layers.up_to", expected, |y| y > below && y <= most)
            .map_err(|fault| fault.with(format!("{below} m < up_to <= {} m", scene.height)))?;
        let rows = top / scene.cell;
        // The last one of an outline ends where that does.
        if (rows - rows.round()).abs() > ON_A_FACE && (scene.outline.is_none() || top < scene.height) {
            let expected = "a whole number of cells: a layer ends at the face of a cell";
            return self
                .refuse(&up_to.span(), "layers.up_to", expected, format!("{top} m ({rows} cells)"))
                .map_err(|fault| fault.with(format!("cell {} m", scene.cell)));
        }
        Ok(SoilLayer { up_to: top, soil: self.soil_of("layers", layer, (whole, scene))? })
    }

    /// One region.
    fn region(&self, region: &Spanned<RawZone>, whole: &RawScene, scene: &Fields) -> Checked<Region> {
        let (raw, span) = (region.get_ref(), region.span());
        let one = "exactly one of polygon or levels";
        let polygon = match (&raw.polygon, &raw.levels, &raw.up_to) {
            (Some(points), None, None) => {
                if scene.dimension == Dimension::Column {
                    let expected = "levels, in a column: a polygon is an area";
                    return self.refuse(&points.span(), "regions.polygon", expected, "\"column\"");
                }
                self.polygon(points, "regions.polygon", f64::NEG_INFINITY)?
            }
            (None, Some(levels), None) => {
                let [low, high] = *levels.get_ref();
                if !(low >= 0.0 && low < high && high <= scene.height) {
                    let expected = "two heights [low, high], 0 <= low < high <= the height of the soil (m)";
                    return self
                        .refuse(&levels.span(), "regions.levels", expected, format!("[{low}, {high}]"))
                        .map_err(|fault| fault.with(format!("height {} m", scene.height)));
                }
                // Beyond both sides, so that none of the soil is on its edge.
                let (left, right) = (-scene.width, 2.0 * scene.width);
                vec![[left, low], [right, low], [right, high], [left, high]]
            }
            (None, None, _) => return self.refuse(&span, "regions", one, "neither"),
            _ => return self.refuse(&span, "regions", one, "several"),
        };
        if !holds_particles(scene, &polygon) {
            return self.refuse(&span, "regions", "a region of the soil", "one without a particle in it");
        }
        let levels = raw.levels.as_ref().map(|levels| *levels.get_ref());
        Ok(Region { polygon, levels, soil: self.soil_of("regions", region, (whole, scene))? })
    }

    /// What one of them is made of: that of `[soil]` and `[water]` where it does not say.
    fn soil_of(&self, list: &str, zone: &Spanned<RawZone>, (whole, scene): (&RawScene, &Fields)) -> Checked<Soil> {
        let raw = zone.get_ref();
        let key = |name: &str| format!("{list}.{name}");
        let mut soil = scene.soil();
        if let Some(law) = &raw.law {
            (soil.elastic, soil.strength, soil.cam_clay) = self.law(&key("law"), law, whole, scene.height)?;
        }
        for (name, value) in [("youngs_modulus", &raw.youngs_modulus), ("poisson_ratio", &raw.poisson_ratio)] {
            if let (Some(value), true) = (value, raw.law.is_some() || soil.cam_clay.is_some()) {
                let expected = "that of its law, or the elasticity of [soil] where it has no law of its own";
                return self.refuse(&value.span(), &key(name), expected, value.get_ref());
            }
        }
        if let Some(value) = &raw.youngs_modulus {
            soil.elastic.youngs_modulus = self.positive(value, &key("youngs_modulus"), "Pa")?;
        }
        if let Some(value) = &raw.poisson_ratio {
            let bounds = |nu| nu > -1.0 && nu < 0.5;
            soil.elastic.poisson_ratio = self.within(value, &key("poisson_ratio"), "-1 < nu < 0.5", bounds)?;
        }
        if let Some(value) = &raw.porosity {
            soil.porosity = self.porosity(value, &key("porosity"))?;
        }
        if raw.grain_density.is_some() || raw.bulk_density.is_some() {
            let given = (raw.grain_density.as_ref(), raw.bulk_density.as_ref());
            soil.grain_density = self.grain_density(list, &zone.span(), given, soil.porosity, scene.water.as_ref())?;
        }
        let grains = (raw.biot_coefficient.as_ref(), raw.grain_bulk_modulus.as_ref());
        if grains.0.is_some() || grains.1.is_some() {
            soil.biot = self.biot(list, grains, &soil.elastic, soil.porosity)?;
        }
        let of_water =
            [("hydraulic_conductivity", "m/s", &raw.hydraulic_conductivity), ("anisotropy", "-", &raw.anisotropy)];
        for (i, (name, unit, value)) in of_water.into_iter().enumerate() {
            match (value, &scene.water) {
                (Some(value), Some(_)) => {
                    let number = self.positive(value, &key(name), unit)?;
                    *[&mut soil.hydraulic_conductivity, &mut soil.anisotropy][i] = number;
                }
                (Some(value), None) => {
                    let expected = "[water] with it: a dry scene has no flow";
                    return self.refuse(&value.span(), &key(name), expected, value.get_ref());
                }
                (None, _) => {}
            }
        }
        soil.fabric = self.fabric(list, &raw.bedding_angle, &raw.kozeny_carman, soil.fabric)?;
        if let Some(value) = &raw.start_k0 {
            soil.k0 = Some(self.within(value, &key("start_k0"), "a ratio of 0 or more (-)", |k| k >= 0.0)?);
        }
        Ok(soil)
    }

    /// What conductivity depends on, from what a table says of it.
    pub(super) fn fabric(
        &self,
        table: &str,
        angle: &Option<Spanned<f64>>,
        kozeny_carman: &Option<Spanned<bool>>,
        usual: Fabric,
    ) -> Checked<Fabric> {
        let (key, expected) = (format!("{table}.bedding_angle"), "-90 <= angle <= 90 (degrees)");
        let angle = angle.as_ref().map(|angle| self.within(angle, &key, expected, |angle| angle.abs() <= 90.0));
        let kozeny_carman = kozeny_carman.as_ref().map_or(usual.kozeny_carman, |is| *is.get_ref());
        Ok(Fabric { bedding_angle: angle.transpose()?.unwrap_or(usual.bedding_angle), kozeny_carman })
    }

    /// Grains that compress, from what a table says of them: `alpha = 1 - K/K_s`, unless it says both.
    pub(super) fn biot(
        &self,
        table: &str,
        (coefficient, modulus): (Option<&Spanned<f64>>, Option<&Spanned<f64>>),
        elastic: &Elastic,
        porosity: f64,
    ) -> Checked<Option<Biot>> {
        let bulk = elastic.lame() + 2.0 / 3.0 * elastic.shear_modulus();
        let key = |name: &str| format!("{table}.{name}");
        let alpha = |value: &Spanned<f64>| {
            let within = |alpha: f64| (porosity..=1.0).contains(&alpha);
            self.within(value, &key("biot_coefficient"), "n <= alpha <= 1 (-)", within)
                .map_err(|fault| fault.with(format!("n = {porosity}")))
        };
        let (coefficient, grain_bulk_modulus) = match (coefficient, modulus) {
            (None, None) => return Ok(None),
            (Some(value), None) => {
                let alpha = alpha(value)?;
                (alpha, bulk / (1.0 - alpha))
            }
            (given, Some(value)) => {
                let least = bulk / (1.0 - porosity);
                let expected = "K_s >= K/(1 - n), K of the skeleton (Pa)";
                let modulus = self
                    .within(value, &key("grain_bulk_modulus"), expected, |modulus| modulus >= least)
                    .map_err(|fault| fault.with(format!("K/(1 - n) = {least:.4e} Pa")))?;
                (given.map(alpha).transpose()?.unwrap_or(1.0 - bulk / modulus), modulus)
            }
        };
        Ok(Some(Biot { coefficient, grain_bulk_modulus }).filter(|biot| biot.coefficient < 1.0))
    }

    /// A mesh that goes along with its soil.
    fn steps_with(&self, list: &str, raw: &RawScene, scene: &Fields, table: &Range<usize>) -> Checked<()> {
        if scene.integrator.solves_displacements() && scene.strain == StrainChoice::Large {
            let expected = format!(
                "\"small\" with [[{list}]] where displacements are solved for: a new mesh over moved soil would cut its {list}"
            );
            let span = raw.soil.get_ref().strain.as_ref().map_or(table.clone(), Spanned::span);
            return self.refuse(&span, "soil.strain", &expected, "\"large\"");
        }
        Ok(())
    }
}

/// Where the top of a layer is said.
fn top_of(layer: &Spanned<RawZone>) -> Range<usize> {
    layer.get_ref().up_to.as_ref().map_or(layer.span(), Spanned::span)
}

/// Whether the middle of any square that a particle stands for is soil in a polygon, m.
fn holds_particles(scene: &Fields, polygon: &[[f64; 2]]) -> bool {
    let (outline, spacing) = (scene.outline_or_box(), scene.spacing());
    let [across, up] = [scene.width, scene.height].map(|length| (length / spacing).ceil() as usize);
    let middles = (0..up).flat_map(|row| (0..across).map(move |column| [column, row]));
    let mut middles = middles.map(|place| place.map(|i| (i as f64 + 0.5) * spacing));
    middles.any(|x| seeding::inside(polygon, &x) && seeding::inside(&outline, &x))
}

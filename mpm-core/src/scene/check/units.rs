//! Warnings about values that look as if they stood in another unit. The run goes on: nothing in a scene forbids such values,
//! and exact solutions are tested with them.

use toml::Spanned;

use super::super::raw::{RawLaw, RawScene, RawZone};
use super::{Reader, written};
use crate::error::Warning;

/// Units in which somebody may have written a value: from and below which size, the unit, and its factor to the SI unit.
type Slips = &'static [(f64, f64, &'static str, f64)];

/// Softer than any soil, Pa.
const MODULUS: Slips = &[(0.0, 1e3, "MPa", 1e6), (1e3, 1e5, "kPa", 1e3)];
/// Smaller than any load that matters, Pa.
const PRESSURE: Slips = &[(0.0, 1.0, "MPa", 1e6), (1.0, 200.0, "kPa", 1e3)];
/// Less than is given to soil so that it has an apex, Pa.
const COHESION: Slips = &[(0.0, 1.0, "MPa", 1e6), (1.0, 100.0, "kPa", 1e3)];
const DENSITY: Slips = &[(0.5, 6.0, "t/m3", 1e3), (6.0, 40.0, "kN/m3", 1e3 / 9.81)];
const CONDUCTIVITY: Slips = &[(1.0, f64::INFINITY, "m/day", 1.0 / 86_400.0)];
const ANGLE: Slips = &[(0.0, 1.6, "radians", 180.0 / std::f64::consts::PI)];
/// Water has 9 to 11 kN/m3 on the ground, and as much more in a centrifuge as its gravity says.
const UNIT_WEIGHT: Slips = &[(9.0, 11.0, "kN/m3", 1e3), (900.0, 1_100.0, "kg/m3, a density,", 9.81)];
const WATER: [f64; 2] = [9e3, 11e3];
const STANDARD_GRAVITY: f64 = 9.81;

impl Reader<'_> {
    /// All of them.
    pub(super) fn units(&self, raw: &RawScene) -> Vec<Warning> {
        let soil = raw.soil.get_ref();
        let mut list = Vec::new();
        let mut look = |value: Option<&Spanned<f64>>, key: &str, unit: &str, slips: Slips| {
            list.extend(value.and_then(|value| self.slip(value, key, unit, slips)));
        };
        of_law(soil.law.get_ref(), "soil.law", &mut look);
        look(soil.grain_density.as_ref(), "soil.grain_density", "kg/m3", DENSITY);
        look(soil.bulk_density.as_ref(), "soil.bulk_density", "kg/m3", DENSITY);
        look(soil.grain_bulk_modulus.as_ref(), "soil.grain_bulk_modulus", "Pa", MODULUS);
        for (key, zones) in [("layers", &raw.layers), ("regions", &raw.regions)] {
            zones.iter().flat_map(|list| list.get_ref()).for_each(|zone| of_zone(zone.get_ref(), key, &mut look));
        }
        if let Some(water) = raw.water.as_ref().map(Spanned::get_ref) {
            look(water.hydraulic_conductivity.as_ref(), "water.hydraulic_conductivity", "m/s", CONDUCTIVITY);
            look(Some(&water.bulk_modulus), "water.bulk_modulus", "Pa", MODULUS);
            look(water.density.as_ref(), "water.density", "kg/m3", DENSITY);
        }
        if let Some(base) = raw.base.as_ref().map(Spanned::get_ref) {
            look(base.friction_angle.as_ref(), "base.friction_angle", "degrees", ANGLE);
            look(base.peak_angle.as_ref(), "base.peak_angle", "degrees", ANGLE);
            look(base.residual_angle.as_ref(), "base.residual_angle", "degrees", ANGLE);
            look(base.adhesion.as_ref(), "base.adhesion", "Pa", COHESION);
        }
        look(raw.surcharge.as_ref().map(|load| &load.get_ref().pressure), "surcharge.pressure", "Pa", PRESSURE);
        for load in raw.loads.iter().flat_map(|list| list.get_ref()).map(Spanned::get_ref) {
            look(load.pressure.as_ref(), "loads.pressure", "Pa", PRESSURE);
            look(load.shear.as_ref(), "loads.shear", "Pa", PRESSURE);
        }
        list.extend(self.weight_of_one(raw));
        list
    }

    /// A value that is small or large enough to be one in another unit.
    fn slip(&self, value: &Spanned<f64>, key: &str, unit: &str, slips: Slips) -> Option<Warning> {
        let number = *value.get_ref();
        let meant = |(low, high, ..): &&(f64, f64, &str, f64)| number.abs() > *low && number.abs() < *high;
        let (_, _, other, factor) = slips.iter().find(meant)?;
        let what = format!(
            "{} {unit} looks like a value in another unit; if {other} is meant, write {}",
            written(number),
            short(number * factor)
        );
        Some(self.warning(&value.span(), key, what))
    }

    /// The unit weight of water.
    fn weight_of_one(&self, raw: &RawScene) -> Option<Warning> {
        let value = &raw.water.as_ref()?.get_ref().unit_weight;
        let gravity = raw.gravity.as_ref().map_or(STANDARD_GRAVITY, |gravity| *gravity.get_ref());
        let on_the_ground = *value.get_ref() * STANDARD_GRAVITY / gravity;
        if *value.get_ref() <= 0.0 {
            return None;
        }
        if [*value.get_ref(), on_the_ground].iter().any(|weight| (WATER[0]..=WATER[1]).contains(weight)) {
            return None;
        }
        self.slip(value, "water.unit_weight", "N/m3", UNIT_WEIGHT).or_else(|| {
            let what = format!("{} N/m3 is not the unit weight of water, 9.81e3 N/m3", written(*value.get_ref()));
            Some(self.warning(&value.span(), "water.unit_weight", what))
        })
    }
}

type Look<'a, 'v> = &'a mut dyn FnMut(Option<&'v Spanned<f64>>, &str, &str, Slips);

fn of_law<'v>(law: &'v RawLaw, key: &str, look: Look<'_, 'v>) {
    match law {
        RawLaw::LinearElastic(law) => {
            look(Some(&law.youngs_modulus), &format!("{key}.linear_elastic.youngs_modulus"), "Pa", MODULUS);
        }
        RawLaw::MohrCoulomb(law) => {
            let key = |name: &str| format!("{key}.mohr_coulomb.{name}");
            look(Some(&law.youngs_modulus), &key("youngs_modulus"), "Pa", MODULUS);
            look(Some(&law.cohesion), &key("cohesion"), "Pa", COHESION);
            look(Some(&law.friction_angle), &key("friction_angle"), "degrees", ANGLE);
        }
        RawLaw::ModifiedCamClay(law) => {
            let key = |name: &str| format!("{key}.modified_cam_clay.{name}");
            look(law.bulk_modulus.as_ref(), &key("bulk_modulus"), "Pa", MODULUS);
            look(law.preconsolidation.as_ref(), &key("preconsolidation"), "Pa", PRESSURE);
        }
    }
}

fn of_zone<'v>(zone: &'v RawZone, key: &str, look: Look<'_, 'v>) {
    if let Some(law) = &zone.law {
        of_law(law.get_ref(), &format!("{key}.law"), look);
    }
    let key = |name: &str| format!("{key}.{name}");
    look(zone.youngs_modulus.as_ref(), &key("youngs_modulus"), "Pa", MODULUS);
    look(zone.grain_density.as_ref(), &key("grain_density"), "kg/m3", DENSITY);
    look(zone.bulk_density.as_ref(), &key("bulk_density"), "kg/m3", DENSITY);
    look(zone.grain_bulk_modulus.as_ref(), &key("grain_bulk_modulus"), "Pa", MODULUS);
    look(zone.hydraulic_conductivity.as_ref(), &key("hydraulic_conductivity"), "m/s", CONDUCTIVITY);
}

/// A number to three digits, as one would type it.
fn short(number: f64) -> String {
    let rounded: f64 = format!("{number:.2e}").parse().unwrap_or(number);
    if (1e-3..1e4).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

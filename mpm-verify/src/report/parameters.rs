//! The parameters of a scene: symbols, values, units.

use mpm_core::scene::{Dimension, Feed, Scene, Soil, Strength, Until};

use super::numbers::{column, print};
use crate::page::table::{Cell, Table};

/// Rows of quantity, symbol, value and unit; what a scene has not is left out. A quantity that differs between the soils of a scene has one
/// value per layer from the base up, then one per region.
pub fn table(scene: &Scene) -> Table {
    let mut rows = Vec::new();
    let mut row = |quantity: &str, symbol: &str, value: String, unit: &str| {
        rows.push([quantity, symbol, &value, unit].map(Cell::new).to_vec());
    };
    let one = |value: f64| print(value, 4);
    row("height", "H", one(scene.height), "m");
    if scene.dimension != Dimension::Column {
        row("width", "B", one(scene.width), "m");
    }
    if scene.inner_radius > 0.0 {
        row("inner radius", "r₀", one(scene.inner_radius), "m");
    }
    let soils = scene.soils();
    let each = |of: &dyn Fn(&Soil) -> f64| {
        let values: Vec<f64> = soils.iter().map(of).collect();
        if values.windows(2).all(|pair| pair[0] == pair[1]) { one(values[0]) } else { column(&values, 2).join("; ") }
    };
    if soils.iter().all(|soil| soil.cam_clay.is_none()) {
        row("Young's modulus", "E", each(&|soil| 1e-6 * soil.elastic.youngs_modulus), "MPa");
        row("Poisson's ratio", "ν", each(&|soil| soil.elastic.poisson_ratio), "–");
    }
    if let Some(clay) = scene.cam_clay {
        row("slope of compression", "λ", one(clay.lambda), "–");
        row("slope of swelling", "κ", one(clay.kappa), "–");
        row("slope of the critical state", "M", one(clay.critical_slope), "–");
        row("preconsolidation pressure", "p_c", one(1e-3 * clay.preconsolidation), "kPa");
    }
    if soils.iter().any(|soil| soil.strength.is_some()) {
        let strength = |of: fn(&Strength) -> f64| each(&move |soil| soil.strength.as_ref().map_or(f64::NAN, of));
        row("cohesion", "c", strength(|s| 1e-3 * s.cohesion), "kPa");
        row("angle of friction", "φ", strength(|s| s.friction_angle), "°");
        row("angle of dilation", "ψ", strength(|s| s.dilation_angle), "°");
    }
    row("porosity", "n", each(&|soil| soil.porosity), "–");
    row("density of the grains", "ρ_s", each(&|soil| soil.grain_density), "kg/m³");
    if let Some(water) = scene.water {
        row("hydraulic conductivity", "k", each(&|soil| soil.hydraulic_conductivity), "m/s");
        if water.bulk_modulus.is_finite() {
            row("bulk modulus of the water", "K_w", one(1e-6 * water.bulk_modulus), "MPa");
        }
        row("unit weight of the water", "γ_w", one(1e-3 * water.unit_weight), "kN/m³");
        if let (Some(time), true, true) =
            (scene.time_per_factor(), scene.is_one_dimensional(), scene.layers.is_empty() && scene.is_elastic())
        {
            row("coefficient of consolidation, k M/γ_w", "c_v", one(scene.drainage_path().powi(2) / time), "m²/s");
            row("drainage path", "H_d", one(scene.drainage_path()), "m");
        }
    }
    if let Some(gravity) = scene.gravity {
        row("gravity", "g", one(gravity), "m/s²");
    }
    if let Some(angle) = scene.slope_angle {
        row("inclination of the base", "β", one(angle), "°");
    }
    if let Some(load) = scene.surcharge {
        row("load on the top", "q", one(1e-3 * load.pressure), "kPa");
        if load.ramp_time > 0.0 {
            row("time over which the load grows", "t_r", one(load.ramp_time), "s");
        }
    }
    for plate in &scene.plates {
        let end = scene.observe_times.last().copied().unwrap_or(0.0);
        row("displacement of the plate into the soil", "u", one(1e3 * plate.at(end)), "mm");
    }
    if let Some(base) = scene.base {
        row("friction of the base", "δ", one(base.peak_angle), "°");
    }
    if let Some(free) = &scene.free_surface {
        for feed in free.feeds.iter().flatten() {
            match feed {
                Feed::Head(head) => row("head of the water", "h", one(*head), "m"),
                Feed::Velocity { speed, .. } => row("inflow", "v", one(*speed), "m/s"),
            }
        }
        if free.saturation > 0.0 {
            row("degree of saturation at the start", "S₀", one(free.saturation), "–");
        }
    }
    row("cell", "L", one(scene.cell), "m");
    row("particles per cell", "", scene.particles_per_cell.to_string(), "–");
    if let Some(Until::Time(end)) = scene.stages.last().map(|stage| stage.until) {
        row("duration of the last stage", "t", one(end), "s");
    }
    Table::new("Parameters", &["quantity", "symbol", "value", "unit"], rows, "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_scene_has_its_parameters_with_units() {
        for (name, _) in crate::scenes::BUILT_IN {
            let table = table(&crate::scenes::built_in(name).expect("a scene"));
            for row in &table.rows {
                assert!(row.iter().all(|cell| !cell.text.contains("NaN")), "{name}: {:?}", row[0].text);
                assert!(!row[0].text.is_empty() && !row[2].text.is_empty() && !row[3].text.is_empty(), "{name}");
            }
        }
        let footing = table(&crate::scenes::load("footing", &Default::default()).expect("a scene"));
        let value = |symbol: &str| footing.rows.iter().find(|row| row[1].text == symbol).map(|row| row[2].text.clone());
        assert_eq!((value("E"), value("c"), value("k")), (Some("10".into()), Some("10".into()), None));
    }
}

//! Maps of a finished run in the plane: the soil, and the water in it.

use mpm_core::drive::Run;
use mpm_core::scene::{Dimension, Scene};

use super::numbers::brief;
use super::plots::field::{Field, Line, OUTLINE, SURFACE};

/// The maps of a run in plane strain: `map-soil` and, where there is water, `map-water`.
pub fn all(scene: &Scene, run: &Run) -> Vec<Field> {
    if scene.dimension == Dimension::Column {
        return Vec::new();
    }
    let time = run.samples.last().map_or(0.0, |s| s.state.time);
    let mut corners: Vec<(f64, f64)> = scene.outline_or_box().iter().map(|x| (x[0], x[1])).collect();
    corners.extend(corners.first().copied());
    let mut lines = vec![Line { label: "soil at t = 0".to_owned(), look: OUTLINE, points: corners }];
    let surface = surface(scene, run);
    if !surface.is_empty() {
        lines.push(Line { label: "water level".to_owned(), look: SURFACE, points: surface });
    }
    let kilo = |points: &[[f64; 3]], sign: f64| points.iter().map(|p| [p[0], p[1], sign * p[2] / 1e3]).collect();
    let places = &run.places;
    let field = run.samples.last().map_or(&[][..], |s| &s.state.field);
    let cells: Vec<[f64; 3]> = field.iter().map(|at| [at.x_m, at.y_m, at.pressure_pa]).collect();
    let unsaturated = is_unsaturated(scene);
    let (water, of_water, spacing) = if unsaturated {
        (
            &cells,
            "Every cell, coloured by the pressure of its pores that its soil feels: S_e p where it holds water by suction.",
            scene.cell,
        )
    } else if places.water.is_empty() {
        (&cells, "Every cell, coloured by its pore pressure.", scene.cell)
    } else {
        (&places.water, "Every water particle, coloured by its pore pressure.", scene.spacing())
    };
    let maps = [
        Field {
            name: "map-soil",
            title: format!("{}: soil at t = {} s", scene.name, brief(time, 4)),
            caption: "Every solid particle as the soil that it stands for, by its mean effective stress, compression positive."
                .to_owned(),
            quantity: "mean effective stress (kPa)".to_owned(),
            column: "mean_effective_stress_kpa",
            range: None,
            spacing: scene.spacing(),
            per_row: scene.outline.is_none().then(|| scene.cells[0] * scene.particles_per_direction()),
            points: kilo(&places.solid, -1.0),
            lines: lines.clone(),
        },
        Field {
            name: "map-water",
            title: format!("{}: water at t = {} s", scene.name, brief(time, 4)),
            caption: of_water.to_owned(),
            quantity: "pore pressure (kPa)".to_owned(),
            column: "pore_pressure_kpa",
            range: None,
            spacing,
            per_row: None,
            points: kilo(water, 1.0),
            lines: lines.clone(),
        },
        Field {
            name: "map-saturation",
            title: format!("{}: effective saturation at t = {} s", scene.name, brief(time, 4)),
            caption: "Every cell, coloured by the share of its mobile pores that holds water.".to_owned(),
            quantity: "effective saturation".to_owned(),
            column: "effective_saturation",
            range: None,
            spacing: scene.cell,
            per_row: None,
            points: field.iter().filter(|_| unsaturated).map(|at| [at.x_m, at.y_m, at.saturation]).collect(),
            lines,
        },
    ];
    maps.into_iter().filter(|map| !map.points.is_empty()).collect()
}

/// Whether soil holds water by suction.
fn is_unsaturated(scene: &Scene) -> bool {
    scene.free_surface.as_ref().is_some_and(|free| free.retention.is_some())
}

/// Level of the water that stands in each column of cells, m; nothing without a free surface or without gravity.
fn surface(scene: &Scene, run: &Run) -> Vec<(f64, f64)> {
    let Some(last) = run.samples.last().filter(|_| scene.free_surface.is_some() && scene.gravity.is_some()) else {
        return Vec::new();
    };
    let columns = scene.cells[0] + scene.empty_cells_beside;
    let mut levels = vec![0.0; columns];
    for point in last.state.field.iter().filter(|p| p.pressure_pa > 0.0) {
        let column = ((point.x_m / scene.cell) as usize).min(columns - 1);
        let above = match scene.water {
            // Where its pressure ends.
            Some(water) if is_unsaturated(scene) => point.pressure_pa / water.unit_weight,
            _ => ((point.saturation * point.soil).clamp(0.0, 1.0) - 0.5) * scene.cell,
        };
        levels[column] = f64::max(levels[column], point.y_m + above);
    }
    let places = levels.iter().enumerate().filter(|(_, level)| **level > 0.0);
    places.map(|(i, level)| ((i as f64 + 0.5) * scene.cell, *level)).collect()
}

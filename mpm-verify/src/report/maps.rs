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
    // Dry soil has no pore pressure to be shown.
    let wet = run.samples.last().filter(|_| scene.water.is_some());
    let field = wet.map_or(&[][..], |s| &s.state.field);
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
            starts: run.starts.clone(),
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
            starts: Vec::new(),
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
            starts: Vec::new(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plots::figure::Mark;
    use crate::report::tests::{INTEGRATORS, block};

    /// Polygons of a map: its pieces, and squares where it has none.
    fn pieces(map: &Field) -> Vec<Vec<(f64, f64)>> {
        let figure = crate::report::plots::field::figure(map);
        let half = 0.5 * map.spacing;
        let square = |x: f64, y: f64| {
            vec![(x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)]
        };
        let mut all = Vec::new();
        for series in &figure.panels[0].series {
            let points: Vec<(f64, f64)> = series.points.iter().map(|p| (p.x, p.y)).collect();
            match series.mark {
                Mark::Tiles => all.extend(points.chunks(4).map(<[_]>::to_vec)),
                Mark::Points => all.extend(points.iter().map(|(x, y)| square(*x, *y))),
                _ => {}
            }
        }
        all
    }

    /// Whatever integrator lists its particles in whatever order: the pieces of soil cover what the soil fills, and each place once.
    #[test]
    fn pieces_of_soil_cover_the_soil_and_do_not_overlap() {
        const SHAPES: [&str; 7] = ["centre", "centroid", "linear", "b-bar", "gimp", "bspline2", "bspline3"];
        let mut drawn = std::collections::BTreeMap::new();
        for integrator in INTEGRATORS {
            for (shape, outline) in SHAPES.into_iter().flat_map(|shape| [(shape, false), (shape, true)]) {
                let text = block(integrator, shape, outline);
                let Ok(scene) = Scene::parse(&text, "block.toml") else { continue };
                // Some functions are not for soil that moves as far as this.
                let Ok(run) = mpm_core::run::run(&scene, &mut |_| ()) else { continue };
                let run = run.whole().expect("its end");
                let map = all(&scene, &run).remove(0);
                let pieces = pieces(&map);
                assert_eq!(pieces.len(), run.solid_particles);
                let moved = run.starts.iter().zip(&run.places.solid).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
                let moved = moved.fold(0.0, f64::max) / map.spacing;
                *drawn.entry(integrator).or_insert(0.0_f64) = drawn.get(integrator).copied().unwrap_or(0.0).max(moved);
                let area: f64 = pieces
                    .iter()
                    .map(|p| mpm_core::seeding::area(&p.iter().map(|(x, y)| [*x, *y]).collect::<Vec<_>>()))
                    .sum();
                let whole = mpm_core::seeding::area(&scene.outline_or_box());
                assert!((area / whole - 1.0).abs() < 0.15, "{integrator} {shape} {outline}: {area} of {whole} m2");
                // Places on no edge of the mesh, away from where the soil may have moved to.
                let mut off = 0;
                let places = (0..400).map(|k| [(k % 20) as f64, (k / 20) as f64].map(|i| 0.0513 * i + 0.0117));
                let corners = scene.outline_or_box();
                let deep = |x: &[f64; 2]| {
                    [-1.0, 1.0].iter().all(|s| mpm_core::seeding::inside(&corners, &[x[0], x[1] + s * 0.13]))
                };
                let inner: Vec<_> = places.filter(deep).collect();
                for x in &inner {
                    let holds = |p: &&Vec<(f64, f64)>| {
                        mpm_core::seeding::inside(&p.iter().map(|(x, y)| [*x, *y]).collect::<Vec<_>>(), x)
                    };
                    off += usize::from(pieces.iter().filter(holds).count() != 1);
                }
                assert!(off * 50 <= inner.len(), "{integrator} {shape} {outline}: {off} of {} places", inner.len());
            }
        }
        assert_eq!(drawn.len(), INTEGRATORS.len(), "{drawn:?}");
        assert!(drawn.iter().filter(|(name, _)| **name != "staggered").all(|(_, moved)| *moved > 0.1), "{drawn:?}");
    }
}

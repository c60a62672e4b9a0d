//! The stability map: limits over the mesh with their theory, and how far apart measured, theory and `auto` are.

use mpm_core::scene::ShapeChoice;

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series, share_x, share_y};
use super::look::{self, Dash, GREY, Look, Marker};
use crate::report::numbers::power_of_ten;
use crate::stability::map::{AGREEMENT, INTEGRATORS, Row, SHAPES};
use crate::study::word;

/// Conductivities of the picture of limits, m/s.
const CONDUCTIVITIES: [f64; 4] = [1e-2, 1e-4, 1e-6, 1e-8];
/// Bulk moduli of the picture of `auto`, Pa.
const BULK_MODULI: [f64; 3] = [2e7, 2e9, 2e11];
/// Shapes of the pictures of columns: B-bar is the linear scheme there.
const IN_COLUMNS: [ShapeChoice; 4] =
    [ShapeChoice::Centre, ShapeChoice::Linear, ShapeChoice::Gimp, ShapeChoice::Bspline2];
/// Particles per cell and bulk modulus (Pa) of the picture of limits: those of the study, nearly.
const PPC: usize = 4;
const BULK_MODULUS: f64 = 2e9;

/// All pictures of the map.
pub fn figures(rows: &[Row]) -> Vec<Figure> {
    vec![limits(rows), ratios(rows), auto(rows)]
}

/// Rows of the column with the flow through faces and no inertia in Darcy's law: those that are there for all schemes.
fn usual(row: &&Row) -> bool {
    row.dimension == "column" && row.darcy == "face" && !row.darcy_inertia
}

/// Limits over the cell edge: theory as lines, measured as points.
pub fn limits(rows: &[Row]) -> Figure {
    let (ppc, conductivities) = (particles(rows), conductivities(rows));
    let panels = panels("stability-map", rows, &IN_COLUMNS, |panel, own| {
        for (place, k) in conductivities.iter().copied().enumerate() {
            let shown = |r: &&Row| r.ppc == ppc && r.k_w == BULK_MODULUS && r.k == k;
            let mut own: Vec<&Row> = own.iter().copied().filter(shown).collect();
            own.sort_by(|a, b| a.mesh_m.total_cmp(&b.mesh_m));
            let (theory, measured) = looks(place);
            let label = format!("k = {} m/s", power(k));
            panel.add(Series::line(format!("{label}, theory"), theory, own.iter().map(|r| (r.mesh_m, r.dt_theory_s))));
            let points = own.iter().map(|r| Point::new(r.mesh_m, r.dt_measured_s));
            panel.add(Series::new(format!("{label}, measured"), measured, Mark::Points, points));
        }
        panel.x = Axis::log("L (m)", "mesh_m").named(edges());
        panel.y = Axis::log("limit (s)", "dt_s");
    });
    Figure {
        name: "stability-map",
        title: "Largest stable step over the cell edge".to_owned(),
        caption: format!(
            "Columns with {ppc} particles per cell, K_w = 2·{} Pa, no inertia in Darcy's law. Lines: theory; points: \
             largest step at which a run does not grow, by bisection. Semi-implicit steps have no limit of the water's: \
             the less permeable the soil, the more the water stiffens it, but only where its pressure sees the strain.",
            power_of_ten(9)
        ),
        height: 210.0,
        panels: panels.0,
        missing: panels.1,
    }
}

/// Rows that are drawn alike: their name, which they are, their look.
type Kind = (&'static str, fn(&Row) -> bool, Look);

/// Measured over theory for every row.
pub fn ratios(rows: &[Row]) -> Figure {
    let (mut panels, missing) = panels("stability-map-ratio", rows, &SHAPES, |panel, _| {
        panel.x = Axis::log("k (m/s)", "k_m_s").named(powers());
        panel.y = Axis::linear("measured / theory", "ratio");
    });
    let kinds: [Kind; 3] = [
        ("column", |r| r.dimension == "column" && !r.darcy_inertia, Look::new(look::BLUE, Marker::Circle).radius(2.6)),
        (
            "column, inertia in Darcy's law",
            |r| r.dimension == "column" && r.darcy_inertia,
            Look::new(look::RED, Marker::Up).radius(2.6),
        ),
        ("plane strain", |r| r.dimension != "column", Look::new(look::GREEN, Marker::Square).radius(2.6)),
    ];
    for (panel, (integrator, shape)) in panels.iter_mut().zip(schemes(&SHAPES)) {
        for (place, (label, kind, look)) in kinds.into_iter().enumerate() {
            let own = rows.iter().filter(|r| r.integrator == integrator && r.shape == shape && kind(r));
            // Beside each other, so that none hides another.
            let aside = [0.75, 1.0, 1.33][place];
            let points = own.map(|r| Point::new(r.k * aside, r.ratio));
            panel.add(Series::new(label, look, Mark::Points, points));
        }
    }
    // The ranges found so far are those of panels without points.
    for panel in &mut panels {
        (panel.x.range, panel.y.range) = (None, None);
    }
    share_x(&mut panels);
    for panel in &mut panels {
        let range = panel.all_y().into_iter().filter(|r| r.is_finite()).map(|r| (r - 1.0).abs());
        let most = range.fold(1.5 * AGREEMENT, f64::max) * 1.1;
        panel.y.range = Some((1.0 - most, 1.0 + most));
        let ends = panel.x.range.map_or([1e-9, 1e-2], |(low, high)| [low, high]);
        for bound in [1.0 - AGREEMENT, 1.0 + AGREEMENT] {
            let line = ends.map(|x| (x, bound));
            panel.add(Series::line("tolerance: 2 %", Look::new(GREY, Marker::Dot).dash(Dash::Dashed), line).guide());
        }
    }
    Figure {
        name: "stability-map-ratio",
        title: "Measured limit over theory, all rows".to_owned(),
        caption:
            "Theory is that of a plane wave in columns of linear functions and uGIMP, and the spectral radius of the \
                  assembled step elsewhere. Markers are shifted a little in k so that none hides another."
                .to_owned(),
        height: 190.0,
        panels,
        missing,
    }
}

/// Measured over the limit of `auto`.
pub fn auto(rows: &[Row]) -> Figure {
    let ppc = particles(rows);
    let panels = panels("stability-map-auto", rows, &IN_COLUMNS, |panel, own| {
        for (place, modulus) in BULK_MODULI.into_iter().enumerate() {
            for (mesh, dash) in [(0.1, Dash::Solid), (0.01, Dash::Dashed)] {
                let mut own: Vec<&&Row> =
                    own.iter().filter(|r| r.ppc == ppc && r.k_w == modulus && r.mesh_m == mesh).collect();
                own.sort_by(|a, b| a.k.total_cmp(&b.k));
                let look = look::nth(place).dash(dash).radius(2.8);
                let label = format!("K_w = {} Pa, L = {mesh} m", twice(modulus));
                let points = own.iter().map(|r| Point::new(r.k, 1.0 / r.limit_ratio).open(mesh < 0.1));
                panel.add(Series::new(label, look, Mark::LinePoints, points));
            }
        }
        panel.x = Axis::log("k (m/s)", "k_m_s").named(powers());
        panel.y = Axis::log("measured / limit", "measured_over_limit");
    });
    Figure {
        name: "stability-map-auto",
        title: "Measured limit over the limit from which the automatic step is computed".to_owned(),
        caption: format!(
            "Columns with {ppc} particles per cell, no inertia in Darcy's law. One: the limit is sharp, and auto takes 0.9 \
             of it. Below one: only that share would keep auto safe."
        ),
        height: 190.0,
        panels: panels.0,
        missing: panels.1,
    }
}

/// Particles per cell of the pictures: a map that was thinned has only the ends of every range.
fn particles(rows: &[Row]) -> usize {
    let counts = || rows.iter().filter(usual).map(|r| r.ppc);
    if counts().any(|ppc| ppc == PPC) { PPC } else { counts().max().unwrap_or(PPC) }
}

/// Conductivities of the picture of limits, m/s.
fn conductivities(rows: &[Row]) -> Vec<f64> {
    let mut all: Vec<f64> = rows.iter().filter(usual).map(|r| r.k).collect();
    all.sort_by(|a, b| b.total_cmp(a));
    all.dedup();
    if all.len() > CONDUCTIVITIES.len() { CONDUCTIVITIES.to_vec() } else { all }
}

/// One panel per integrator and shape, integrators below each other, and what is missing. `fill` gets the usual rows.
fn panels(
    name: &str,
    rows: &[Row],
    shapes: &[ShapeChoice],
    fill: impl Fn(&mut Panel, &[&Row]),
) -> (Vec<Panel>, Vec<String>) {
    let (mut panels, mut missing) = (Vec::new(), Vec::new());
    for (place, (integrator, shape)) in schemes(shapes).enumerate() {
        let own: Vec<&Row> =
            rows.iter().filter(usual).filter(|r| r.integrator == integrator && r.shape == shape).collect();
        if own.is_empty() {
            missing.push(format!("{name}: no {integrator} {shape} row"));
        }
        let mut panel = Panel::new(&shape, Axis::log("", ""), Axis::log("", ""));
        fill(&mut panel, &own);
        panel.row = place / shapes.len();
        panel.y.label =
            if place % shapes.len() == 0 { format!("{integrator}: {}", panel.y.label) } else { String::new() };
        if panel.row == 0 {
            panel.x = panel.x.quiet();
        }
        panels.push(panel);
    }
    share_x(&mut panels);
    let (above, below) = panels.split_at_mut(shapes.len());
    share_y(above);
    share_y(below);
    (panels, missing)
}

fn schemes(shapes: &[ShapeChoice]) -> impl Iterator<Item = (String, String)> {
    let of = |integrator| shapes.iter().map(move |shape| (word(integrator), word(*shape)));
    INTEGRATORS.into_iter().flat_map(of)
}

/// Comparison of theory and of what is measured. Points that coincide are seen inside one another.
fn looks(place: usize) -> (Look, Look) {
    let look = look::nth(place);
    (look.width(1.4), look.radius(5.6 - 1.0 * place as f64))
}

/// Ticks at the cell edges of the study.
fn edges() -> Vec<(f64, String)> {
    crate::stability::map::MESHES.map(|mesh| (mesh, format!("{mesh}"))).to_vec()
}

/// Ticks at some of the conductivities, few enough for five panels side by side.
fn powers() -> Vec<(f64, String)> {
    [1e-8, 1e-5, 1e-2].map(|k| (k, power(k))).to_vec()
}

fn power(value: f64) -> String {
    power_of_ten(value.log10().round() as i32)
}

/// `2·10⁹`.
fn twice(value: f64) -> String {
    format!("2·{}", power(0.5 * value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::map::{Extent, Setting, settings};

    fn made_up(setting: &Setting) -> Row {
        let limit = setting.mesh * setting.mesh / setting.conductivity;
        Row {
            scheme: format!("{}-{}", word(setting.integrator), word(setting.shape)),
            darcy: word(setting.darcy),
            mesh_m: setting.mesh,
            ppc: setting.ppc,
            k: setting.conductivity,
            k_w: setting.bulk_modulus,
            dt_measured_s: limit,
            dt_theory_s: limit,
            ratio: 1.0,
            integrator: word(setting.integrator),
            shape: word(setting.shape),
            dimension: word(setting.dimension),
            darcy_inertia: setting.inertia,
            theory: "plane wave".to_owned(),
            dt_grows_s: limit,
            growth_below: 1.0,
            growth_above: 1.01,
            dt_auto_s: 0.9 * limit,
            auto_ratio: 0.9,
            auto_growth: 1.0,
            auto_unstable: false,
            dt_limit_s: limit,
            limit_ratio: 1.0,
            gap: String::new(),
        }
    }

    #[test]
    fn ratios_lie_inside_their_frames() {
        let rows: Vec<Row> = settings(Extent::Thin).iter().map(made_up).collect();
        for panel in ratios(&rows).panels {
            let inside = |place: f64| (0.0..=1.0).contains(&place);
            assert!(panel.all_x().iter().all(|x| inside(panel.x.place(*x))), "{}", panel.title);
            assert!(panel.all_y().iter().all(|y| inside(panel.y.place(*y))), "{}", panel.title);
        }
    }

    #[test]
    fn every_scheme_has_its_panel() {
        let rows: Vec<Row> = settings(Extent::Whole).iter().map(made_up).collect();
        let figures = figures(&rows);
        for (figure, panels) in figures.iter().zip([8, 10, 8]) {
            assert_eq!((figure.panels.len(), figure.missing.len()), (panels, 0), "{}", figure.name);
            assert!(figure.panels.iter().all(|panel| !panel.is_empty()), "{}", figure.name);
        }
        // A thinned map fills them as well.
        let thin: Vec<Row> = settings(Extent::Thin).iter().map(made_up).collect();
        for figure in super::figures(&thin) {
            assert!(figure.panels.iter().all(|panel| !panel.is_empty()), "{}", figure.name);
        }
        // A scheme without rows is named.
        let rows: Vec<Row> = rows.into_iter().filter(|r| r.shape != "gimp").collect();
        assert_eq!(limits(&rows).missing.len(), 2);
    }
}

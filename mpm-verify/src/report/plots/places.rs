//! What displaced particles and an offset of the mesh do to the error.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series, share_y};
use super::look::{BLACK, BLUE, Dash, GREEN, Look, Marker, ORANGE, RED};
use crate::sweeps::places::Displacement;
use crate::sweeps::{MESHES, REQUIRED, Sweeps};

/// Scheme, quadrature, how it reads, and its look.
const LINES: [(&str, &str, &str, Look); 4] = [
    ("bspline2", "fitted", "bspline2, fitted weights", Look::new(BLUE, Marker::Circle)),
    ("bspline2", "volumes", "bspline2, particle volumes", Look::new(RED, Marker::Square)),
    ("linear", "volumes", "linear", Look::new(GREEN, Marker::Up)),
    ("gimp", "volumes", "gimp", Look::new(ORANGE, Marker::Down)),
];

/// Largest error, the name of its axis.
const ERROR: &str = "max |U/U_exact \u{2212} 1|";
/// Where "both" stands on the axis of random displacements, in spacings.
const BOTH: f64 = 0.3;

/// The look of a mesh: the finer one dashed.
fn on_mesh(look: Look, mesh: f64) -> Look {
    if mesh == MESHES[0] { look } else { look.dash(Dash::Dashed).radius(3.0) }
}

/// The required error as a line between two places.
fn limit(panel: &mut Panel, from: f64, to: f64) {
    let look = Look::new(BLACK, Marker::Dot).dash(Dash::Dotted).width(1.4);
    panel.add(Series::line("required at L = 0.1 m (fitted weights)", look, [(from, REQUIRED), (to, REQUIRED)]));
}

/// Largest error over the seeds of each amplitude; NaN, and so no point, if one run failed.
fn worst(rows: &[&Displacement], of: fn(&Displacement) -> f64) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    for row in rows {
        let (x, y) = (of(row), row.max_error_compressible);
        match points.last_mut() {
            Some(last) if last.x == x => last.y = if y.is_nan() { y } else { last.y.max(y) },
            _ => points.push(Point::new(x, y)),
        }
    }
    points
}

/// Smooth displacements, and random ones with the worst of their seeds.
pub fn displaced(sweeps: &Sweeps) -> Figure {
    let smooth = Axis::linear("amplitude (particle spacings)", "displacement_spacings").range(-0.02, 0.52);
    let ticks = [0.0, 0.1, 0.2].map(|x| (x, x.to_string())).to_vec();
    let ticks = [ticks, vec![(BOTH, "both".to_owned())]].concat();
    let random = Axis::linear("half width (particle spacings)", "displacement_spacings").range(-0.02, BOTH + 0.02);
    let mut panels = vec![
        Panel::new("smooth displacement", smooth, Axis::log(ERROR, "max_error")),
        Panel::new("random displacement, worst of 5 seeds", random.named(ticks), Axis::log(ERROR, "max_error")),
    ];
    for mesh in MESHES {
        for (scheme, quadrature, words, look) in LINES {
            let own = |kind: &str| -> Vec<&Displacement> {
                let own = |r: &&Displacement| {
                    (r.scheme.as_str(), r.quadrature.as_str(), r.mesh_m) == (scheme, quadrature, mesh) && r.kind == kind
                };
                sweeps.displaced.iter().filter(own).collect()
            };
            let (label, look) = (format!("{words}, L = {mesh} m"), on_mesh(look, mesh));
            panels[0].add(Series::new(&label, look, Mark::LinePoints, worst(&own("smooth"), |r| r.smooth)));
            let even = own("smooth").into_iter().filter(|r| r.smooth == 0.0).collect::<Vec<_>>();
            let random = [worst(&even, |_| 0.0), worst(&own("jitter"), |r| r.jitter)].concat();
            panels[1].add(Series::new(&label, look, Mark::LinePoints, random));
            panels[1].add(Series::new(&label, look, Mark::Points, worst(&own("both"), |_| BOTH)).unlisted());
        }
    }
    if !sweeps.displaced.is_empty() {
        limit(&mut panels[0], 0.0, 0.5);
        limit(&mut panels[1], 0.0, BOTH);
    }
    let missing = lost("displaced", sweeps.displaced.iter().filter(|r| r.failure.is_some()).count());
    share_y(&mut panels);
    Figure {
        name: "displaced",
        title: "Largest error relative to the exact solution with finite K_w with displaced particles".to_owned(),
        caption: "Quasi-static, 9 particles per cell. Both: the largest smooth and the largest random displacement \
                  together. Fitted weights integrate what the splines need whatever the places of the particles; \
                  particle volumes do not."
            .to_owned(),
        height: 400.0,
        panels,
        missing,
    }
}

/// Offsets of the mesh below the soil.
pub fn shifted(sweeps: &Sweeps) -> Figure {
    let x = Axis::linear("start of the mesh below the soil (cells)", "shift_cells").range(-0.02, 1.02);
    let mut panel = Panel::new("bspline2, fitted weights", x, Axis::log(ERROR, "max_error"));
    for mesh in MESHES {
        let own = sweeps.shifted.iter().filter(|r| r.mesh_m == mesh);
        let points: Vec<Point> = own.map(|r| Point::new(r.shift, r.max_error_compressible)).collect();
        let look = if mesh == MESHES[0] { LINES[0].3 } else { LINES[1].3 };
        panel.add(Series::new(format!("L = {mesh} m"), look, Mark::LinePoints, points));
    }
    if !sweeps.shifted.is_empty() {
        limit(&mut panel, 0.0, 1.0);
    }
    let missing = lost("grid-shift", sweeps.shifted.iter().filter(|r| r.failure.is_some()).count());
    Figure {
        name: "grid-shift",
        title: "Largest error relative to the exact solution with finite K_w with the mesh shifted".to_owned(),
        caption:
            "Quasi-static, 9 particles per cell. Both ends of the column then lie inside cells; 0.01 and 0.99 leave \
                  slivers of soil in the first or the last cell."
                .to_owned(),
        height: 340.0,
        panels: vec![panel],
        missing,
    }
}

/// Failed runs in words, if there are some.
fn lost(name: &str, count: usize) -> Vec<String> {
    if count > 0 { vec![format!("{name}: {count} failed runs have no point")] } else { Vec::new() }
}

//! Errors against what they cost: steps, and factorisations.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series, share_y};
use super::look::{BLACK, BLUE, GREEN, GREY, Look, Marker, ORANGE, PURPLE, RED};
use crate::sweeps::Sweeps;
use crate::sweeps::time::TimeError;

/// The mesh on which all integrators were run, m.
const MESH: f64 = 0.05;

/// Error in time alone, and the whole one, against accepted steps.
pub fn steps(sweeps: &Sweeps) -> Figure {
    let axis = || Axis::log("accepted steps", "accepted_steps");
    let mut figure = figure("error-against-steps", sweeps, axis, |r| r.accepted_steps);
    figure.title = format!("Error against steps, L = {MESH} m, 9 particles per cell");
    figure.caption = format!(
        "Each point is a run with another tolerance or time step. The Krylov method has no steps: its basis vectors \
         are counted. {WHAT}"
    );
    figure
}

/// The same against factorisations of a matrix; explicit runs have none and are not shown.
pub fn factorisations(sweeps: &Sweeps) -> Figure {
    let axis = || Axis::log("factorisations", "factorisations");
    let mut figure = figure("error-against-factorisations", sweeps, axis, |r| r.factorisations);
    figure.title = format!("Error against factorisations, L = {MESH} m, 9 particles per cell");
    figure.caption = format!("Explicit runs factor no matrix and are not shown. {WHAT}");
    figure
}

/// What the panels show.
const WHAT: &str = "Left: against the same mesh without error in time. Right: against the exact solution with \
                    compressible water, where cells of finite size, and in explicit and semi-implicit runs inertia and \
                    large strain, set a floor. A semi-implicit error in time has the other sign than that of the cells: \
                    their sum may grow as the step gets shorter. An error of zero has no place.";

/// Comparison of the methods, the same in both pictures.
const LOOKS: [(&str, Look); 6] = [
    ("quasi-static krylov", Look::new(BLUE, Marker::Circle)),
    ("quasi-static sdirk", Look::new(RED, Marker::Square)),
    ("semi-implicit centre", Look::new(GREEN, Marker::Up)),
    ("semi-implicit bspline2", Look::new(PURPLE, Marker::Diamond)),
    ("explicit centre", Look::new(ORANGE, Marker::Down)),
    ("explicit bspline2", Look::new(BLACK, Marker::Star)),
];

fn look_of(label: &str) -> Look {
    LOOKS.iter().find(|(name, _)| *name == label).map_or(Look::new(GREY, Marker::Dot), |(_, look)| *look)
}

fn figure(name: &'static str, sweeps: &Sweeps, axis: impl Fn() -> Axis, count: fn(&TimeError) -> u64) -> Figure {
    let label = "max |U/U_ref \u{2212} 1|";
    let mut panels = vec![
        Panel::new("error in time alone", axis(), Axis::log(label, "error")),
        Panel::new("whole error", axis(), Axis::log(label, "error")),
    ];
    let failed = sweeps.time.iter().filter(|r| r.mesh_m == MESH && r.failure.is_some()).count();
    let own = || sweeps.time.iter().filter(|r| r.mesh_m == MESH && count(r) > 0);
    let mut labels: Vec<String> = Vec::new();
    for row in own() {
        if !labels.contains(&row.label()) {
            labels.push(row.label());
        }
    }
    for label in labels {
        let line = |error: fn(&TimeError) -> f64| {
            let rows = own().filter(|r| r.label() == label);
            let points = rows.filter(|r| r.failure.is_none()).map(|r| Point::new(count(r) as f64, error(r)));
            Series::new(label.clone(), look_of(&label), Mark::LinePoints, points)
        };
        panels[0].add(line(|r| r.time_error));
        panels[1].add(line(|r| r.max_error_compressible));
    }
    let mut missing = Vec::new();
    if panels[0].is_empty() {
        missing.push(format!("{name}: no sweep over time steps"));
    }
    if failed > 0 {
        missing.push(format!("{name}: {failed} failed runs have no point"));
    }
    share_y(&mut panels);
    Figure { name, title: String::new(), caption: String::new(), height: 380.0, panels, missing }
}

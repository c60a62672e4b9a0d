//! Where the work of the load goes.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{BLACK, BLUE, Dash, GREEN, Look, Marker, ORANGE, PURPLE, RED};
use crate::report::numbers::percent;
use crate::report::select::{Cases, stands_in};
use crate::study::HistoryPoint;

/// The energies of one picture: name, look, value in J.
type Part = (&'static str, Look, fn(&HistoryPoint) -> f64);

const LARGE: [Part; 3] = [
    ("work of the load", Look::new(BLACK, Marker::Circle).width(2.0), |h| h.external_work_j),
    ("strain energy of the soil", Look::new(BLUE, Marker::Square).dash(Dash::Dashed), |h| h.strain_j),
    ("dissipated by Darcy flow", Look::new(GREEN, Marker::Up).dash(Dash::DashDot), |h| h.darcy_dissipation_j),
];

const SMALL: [Part; 4] = [
    ("energy of the compressed water", Look::new(PURPLE, Marker::Diamond).dash(Dash::Dashed), |h| h.water_j),
    ("kinetic energy", Look::new(ORANGE, Marker::Down).dash(Dash::DashDot), |h| h.kinetic_j),
    ("inertia's work on the flow", Look::new(BLUE, Marker::Square).dash(Dash::Dotted), |h| h.flow_body_work_j),
    ("balance residual", Look::new(RED, Marker::Circle).radius(2.8), |h| h.energy_residual_j),
];

/// Energies over time; those too small to see beside the others in a panel of their own.
pub fn figure(cases: &Cases) -> Figure {
    let case = cases.paper("surface").or_else(|| cases.paper("particles"));
    let history = case.map_or(&[][..], |c| c.history.as_slice());
    let time = || Axis::log("time factor Tv", "tv");
    let mut large = Panel::new("large parts", time(), Axis::linear("energy (J)", "energy_j"));
    let mut small = Panel::new("small parts, absolute values", time(), Axis::log("energy (J)", "energy_j"));
    for (name, look, value) in LARGE {
        large.add(Series::line(name, look, history.iter().map(|h| (h.tv, value(h)))));
    }
    for (name, look, value) in SMALL {
        let mark = if name == "balance residual" { Mark::LinePoints } else { Mark::Line };
        let points = history.iter().map(|h| Point::new(h.tv, value(h).abs()).open(value(h) < 0.0));
        small.add(Series::new(name, look, mark, points));
    }
    let end = history.last();
    let work = end.map_or(f64::NAN, |h| h.external_work_j);
    let closing = end.map_or(f64::NAN, |h| h.energy_residual_j.abs() / work);
    let largest = history.iter().map(|h| h.energy_residual_j.abs() / work).fold(0.0, f64::max);
    let name =
        case.map_or(String::new(), |c| format!(", L = {} m, {} per cell, traction on the {}", c.mesh_m, c.ppc, c.load));
    Figure {
        name: "energy",
        title: format!("Energy over time{name}"),
        caption: format!(
            "For a column 1 m thick. The balance residual, the work of the load less all other parts (filled if positive), \
             is {} % of the final work at the end and {} % at most.{}",
            percent(closing),
            percent(largest),
            case.map_or(String::new(), stands_in)
        ),
        height: 370.0,
        panels: vec![large, small],
        missing: if history.is_empty() { vec!["energy: no history".to_owned()] } else { Vec::new() },
    }
}

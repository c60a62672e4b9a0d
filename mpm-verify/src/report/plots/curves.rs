//! Curves of a case over time that no requirement asks about: what schemes beside the case's own keep and lose.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{BLACK, BLUE, Dash, GREEN, Look, Marker, ORANGE, PURPLE, RED};
use crate::experiment::Judged;

/// Cases with curves, and the names of their pictures.
const NAMES: [(&str, &str); 3] =
    [("spin", "spin-curves"), ("spin-gimp", "spin-gimp-curves"), ("bar-energy", "bar-energy-curves")];

/// How the curves of a panel differ.
const LOOKS: [(plotters::style::RGBColor, Marker, Dash); 6] = [
    (BLUE, Marker::Circle, Dash::Solid),
    (RED, Marker::Up, Dash::Dashed),
    (GREEN, Marker::Square, Dash::DashDot),
    (PURPLE, Marker::Diamond, Dash::Dotted),
    (ORANGE, Marker::Down, Dash::Dashed),
    (BLACK, Marker::Circle, Dash::Dotted),
];

/// A panel for every quantity, a curve for every scheme: samples named `quantity, scheme` that do not count. `None` if there
/// are none.
pub fn figure(judged: &Judged) -> Option<Figure> {
    let parted = judged.samples.iter().filter(|s| !s.counts).filter_map(|s| Some((s.quantity.split_once(", ")?, s)));
    let mut panels: Vec<(&str, Vec<&str>, Panel)> = Vec::new();
    for ((quantity, scheme), sample) in parted {
        if !panels.iter().any(|(known, ..)| *known == quantity) {
            let label = format!("{quantity}, of the first");
            let y = Axis::linear(&label, "share");
            panels.push((quantity, Vec::new(), Panel::new(quantity, Axis::linear("time (s)", "time_s"), y)));
        }
        let (_, schemes, panel) = panels.iter_mut().find(|(known, ..)| *known == quantity)?;
        if schemes.contains(&scheme) {
            continue;
        }
        let (colour, marker, dash) = LOOKS[schemes.len() % LOOKS.len()];
        schemes.push(scheme);
        let own = judged.samples.iter().filter(|s| !s.counts && s.quantity == sample.quantity);
        let points = own.map(|s| Point::new(s.time, s.computed));
        panel.add(Series::new(scheme, Look::new(colour, marker).dash(dash).radius(3.2), Mark::LinePoints, points));
    }
    if panels.is_empty() {
        return None;
    }
    Some(Figure {
        name: NAMES.iter().find(|(case, _)| *case == judged.case.name)?.1,
        title: format!("{}: what every scheme keeps", judged.case.name),
        caption: format!("{}. Shown, not required.", judged.case.about),
        height: 300.0,
        panels: panels.into_iter().map(|(.., panel)| panel).collect(),
        missing: Vec::new(),
    })
}

//! A stress test: what was measured over what makes it harder, a panel per integrator, a curve per scheme.

use mpm_core::scene::{DarcyChoice, DomainChoice, Integrator, ShapeChoice, TransferChoice, UpdateChoice};

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{BLACK, BLUE, Dash, GREEN, GREY, Look, Marker, ORANGE, PURPLE, RED};
use crate::report::numbers::brief;
use crate::stress::{Case, Found, Scheme};

/// Values that are drawn, in bounds: what is better or worse stands at the edge.
const RANGE: [f64; 2] = [1e-5, 1e2];
/// Room beyond the data, as a factor.
const ROOM: f64 = 2.0;
/// Integrators in the order of the panels.
const PANELS: [(Integrator, &str); 3] = [
    (Integrator::Explicit, "explicit"),
    (Integrator::SemiImplicit, "semi-implicit"),
    (Integrator::QuasiStatic, "quasi-static"),
];

/// The picture of a case. A run that the program stopped, or that is out of reach, is a star at the upper edge.
pub fn figure(case: &Case, found: &[&Found]) -> Figure {
    let measured = || found.iter().flat_map(|f| &f.points).filter_map(|p| p.found.as_ref().ok().copied());
    let bounds = [case.holds, case.breaks];
    let inside = |value: f64| value.clamp(RANGE[0].min(case.holds / 10.0), RANGE[1].max(10.0 * case.breaks));
    let all = || measured().filter(|v| v.is_finite()).map(inside).chain(bounds);
    let (low, high) = (all().fold(f64::INFINITY, f64::min) / ROOM, all().fold(0.0, f64::max) * ROOM);
    let at = || found.iter().flat_map(|f| &f.points).map(|p| p.at);
    let from_zero = at().any(|at| at == 0.0);
    let (first, last) = (at().next().unwrap_or(0.0), at().next_back().unwrap_or(1.0));
    let (least, most) = (at().fold(f64::INFINITY, f64::min), at().fold(0.0, f64::max));
    let spare = if from_zero { 0.05 * most } else { (most / least).powf(0.05) };
    let ends = if from_zero { [-spare, most + spare] } else { [least / spare, most * spare] };
    let ends = if first > last { [ends[1], ends[0]] } else { ends };
    let mut panels = Vec::new();
    for (integrator, title) in PANELS {
        let own = found.iter().filter(|f| f.scheme.integrator == integrator);
        let x =
            if from_zero { Axis::linear(case.parameter, case.column) } else { Axis::log(case.parameter, case.column) };
        let y = Axis::log(if panels.is_empty() { "value" } else { "" }, "value").range(low, high);
        let mut panel = Panel::new(title, x.range(ends[0], ends[1]), y);
        for found in own {
            let name = found.scheme.name();
            let look = look(&found.scheme);
            let value = |v: f64| if v.is_finite() { inside(v) } else { high };
            let points = found.points.iter().filter_map(|p| Some(Point::new(p.at, value(*p.found.as_ref().ok()?))));
            panel.add(Series::new(&name, look, Mark::LinePoints, points));
            let stopped = found.points.iter().filter(|p| p.found.is_err()).map(|p| Point::new(p.at, high / 1.3));
            let star = Look { marker: Marker::Star, ..look };
            panel.add(Series::new(format!("{name}: stopped"), star, Mark::Points, stopped).unlisted());
        }
        if panel.series.is_empty() {
            continue;
        }
        for (bound, what, dash) in
            [(case.holds, "passed up to", Dash::Dashed), (case.breaks, "failed from", Dash::Solid)]
        {
            let line = Series::line(format!("{what} {}", brief(bound, 2)), bound_look(dash), ends.map(|x| (x, bound)));
            panel.add(line.guide());
        }
        panels.push(panel);
    }
    Figure {
        name: case.name,
        title: format!("{}: {}", case.name, case.measures),
        caption: format!(
            "{}. {} Dashed: up to this value a scheme passes; solid: from this value on it fails. Stars: the program stopped with a \
             reason, or the run would take too long.",
            case.about, case.why
        ),
        height: 190.0,
        panels,
        missing: Vec::new(),
    }
}

fn bound_look(dash: Dash) -> Look {
    Look::new(GREY, Marker::Dot).dash(dash).width(1.2)
}

/// Shape functions by colour and marker, options by dash.
fn look(scheme: &Scheme) -> Look {
    let (colour, marker) = match scheme.shape {
        ShapeChoice::Centre => (BLUE, Marker::Circle),
        ShapeChoice::Centroid => (BLACK, Marker::Right),
        ShapeChoice::Linear => (RED, Marker::Square),
        ShapeChoice::BBar => (ORANGE, Marker::Down),
        ShapeChoice::Gimp => (GREEN, Marker::Up),
        ShapeChoice::Bspline2 => (PURPLE, Marker::Diamond),
        ShapeChoice::Bspline3 => (GREY, Marker::Diamond),
    };
    let dash = match (scheme.darcy, scheme.transfer, scheme.update, scheme.domain) {
        (DarcyChoice::Nodal, ..) => Dash::Dotted,
        (_, TransferChoice::Affine, ..) | (.., DomainChoice::Contiguous) => Dash::DashDot,
        (.., UpdateChoice::Musl, _) => Dash::Dashed,
        _ => Dash::Solid,
    };
    Look::new(colour, marker).dash(dash).radius(2.8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stress::{CASES, Point as At};

    #[test]
    fn stopped_runs_and_values_beyond_the_axis_are_seen() {
        let case = &CASES[0];
        let points = vec![
            At { at: 1e-2, found: Ok(1e-3) },
            At { at: 1e-5, found: Ok(f64::INFINITY) },
            At { at: 1e-12, found: Err(crate::error::Error::Unfit("stopped")) },
        ];
        let judged = case.judge(&points);
        let found = Found { case: 0, scheme: case.schemes[0], points, judged };
        let figure = figure(case, &[&found]);
        assert_eq!(figure.panels.len(), 1);
        let panel = &figure.panels[0];
        assert_eq!([panel.series[0].points.len(), panel.series[1].points.len()], [2, 1]);
        let (low, high) = panel.y.range.expect("a range");
        assert!(panel.series.iter().flat_map(|s| &s.points).all(|p| (low..=high).contains(&p.y)));
        let (first, last) = panel.x.range.expect("a range");
        assert!(first > last, "harder to the right");
    }
}

//! The picture of a case: its error over what was refined, the tolerance, the slope that was fitted.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{BLACK, BLUE, Dash, GREY, Look, Marker, RED};
use crate::experiment::Judged;
use crate::rates::Order;
use crate::report::numbers::{brief, short};

/// How far the vertical axis reaches beyond the data, and the triangle stands below the line, as a factor.
const ROOM: f64 = 1.6;

/// The picture; a case with a single run shows it against the error allowed.
pub fn figure(judged: &Judged) -> Figure {
    let (quantity, unit) = judged.refined_by;
    let label = if unit == "-" { quantity.to_owned() } else { format!("{quantity} ({unit})") };
    let mut panel = Panel::new("", Axis::log(&label, ""), Axis::log("|error|", ""));
    let points = judged.errors.iter().map(|(h, e)| Point::new(*h, e.abs()).open(*e < 0.0));
    let mark = if judged.errors.len() > 1 { Mark::LinePoints } else { Mark::Points };
    panel.add(Series::new("measured", Look::new(BLUE, Marker::Circle).radius(5.0), mark, points));
    across(&mut panel);
    let everywhere = judged.errors.iter().filter_map(|(h, _)| Some(judged.everywhere? * h)).collect();
    let (mut low, mut high) = extent(&[panel.all_y(), vec![judged.row.required_error], everywhere].concat());
    if let Some((corners, words)) = slope(judged) {
        low = low.min(corners[0].1);
        panel.add(Series::line("fitted slope", Look::new(GREY, Marker::Dot).width(1.2), corners).guide());
        // Beside the middle of the upright side.
        let (foot, top) = (corners[1], corners[2]);
        panel.add(word(1.02 * foot.0, (foot.1 * top.1).sqrt(), words));
    }
    // A whole decade at least, so that there are ticks to read.
    let spare = (10.0 * low / high).max(1.0).sqrt();
    (low, high) = (low / spare / ROOM, high * spare * ROOM);
    panel.y.range = Some((low, high));
    if judged.errors.len() == 1 {
        let error = judged.row.error;
        // An error without a place is named in the middle of the axis.
        let y = if panel.y.takes(error) { error } else { (low * high).sqrt() };
        panel.add(word(1.03 * judged.errors[0].0, y, ratio(error, judged.row.required_error)));
    }
    let (left, right) = panel.x.range.unwrap_or((0.1, 1.0));
    if let Some(share) = judged.everywhere {
        let look = Look::new(BLACK, Marker::Dot).dash(Dash::Dotted).width(1.8);
        let line = [left, right].map(|h| (h, share * h));
        panel.add(
            Series::line(format!("tolerance on every mesh, {} times {quantity}", brief(share, 3)), look, line).guide(),
        );
    }
    let allowed = [left, right].map(|h| (h, judged.row.required_error));
    let look = Look::new(RED, Marker::Dot).dash(Dash::Dashed).width(1.8);
    let name =
        if judged.errors.len() == 1 { "tolerance".to_owned() } else { format!("tolerance at the smallest {quantity}") };
    panel.add(Series::line(name, look, allowed).guide());
    Figure {
        name: judged.case.name,
        title: match judged.errors.len() {
            1 => format!("{}: error and tolerance", judged.case.name),
            _ => format!("{}: error over the {quantity}", judged.case.name),
        },
        caption: caption(judged),
        height: 250.0,
        panels: vec![panel],
        missing: Vec::new(),
    }
}

/// What the refinement parameter is called in a file: `mesh_m` of "mesh L" in m. Words of one letter are symbols.
pub fn column((quantity, unit): (&str, &str)) -> String {
    let words = quantity.split_whitespace().filter(|word| word.chars().count() > 1);
    let unit = if unit == "-" { String::new() } else { unit.replace('/', " per ") };
    let words = words.map(str::to_lowercase).chain(unit.split_whitespace().map(str::to_owned));
    words.collect::<Vec<_>>().join("_").replace(|c: char| !c.is_ascii_alphanumeric(), "_")
}

/// The smallest and the largest of the values that have a place on a logarithmic axis.
fn extent(values: &[f64]) -> (f64, f64) {
    let placed = values.iter().copied().filter(|v| v.is_finite() && *v > 0.0);
    placed.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)))
}

/// The refinement parameters as ticks, and room beside them.
fn across(panel: &mut Panel) {
    let mut places = panel.all_x();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let (fine, coarse) = extent(&places);
    if !fine.is_finite() {
        return;
    }
    let room = (coarse / fine).powf(0.12).max(1.15);
    panel.x.range = Some(if fine < coarse { (fine / room, coarse * room) } else { (fine / 2.0, fine * 2.0) });
    panel.x.named = Some(places.iter().map(|h| (*h, brief(*h, 3))).collect());
}

/// A single error as a share of the tolerance.
fn ratio(error: f64, allowed: f64) -> String {
    match error {
        0.0 => "zero, below this axis".to_owned(),
        e if e.is_nan() => "not a number".to_owned(),
        e => format!("{} of the tolerance", short(e / allowed, 2)),
    }
}

/// A triangle of the fitted slope below the middle of the line (left, foot, top, left), and the order in words.
fn slope(judged: &Judged) -> Option<([(f64, f64); 4], String)> {
    let fit = judged.convergence.fit.as_ref().filter(|_| judged.convergence.order != Order::NotExpected)?;
    let mut points: Vec<(f64, f64)> = judged.errors.iter().map(|(h, e)| (*h, e.abs())).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (fine, coarse) = (points.first()?.0, points.last()?.0);
    let (left, right) = (fine * (coarse / fine).powf(0.3), fine * (coarse / fine).powf(0.7));
    let line = |h: f64| (h / left).powf(fit.order);
    // The line between the points, at both ends of the triangle and at the points between.
    let at = |h: f64| {
        let next = points.iter().position(|p| p.0 >= h)?.max(1);
        let ((h0, e0), (h1, e1)) = (points[next - 1], points[next]);
        Some((h, e0 * (e1 / e0).powf((h / h0).ln() / (h1 / h0).ln())))
    };
    let between = points.iter().copied().filter(|p| (left..right).contains(&p.0));
    let seen = between.chain([at(left)?, at(right)?]);
    let start = seen.map(|(h, e)| e / line(h)).fold(f64::INFINITY, f64::min) / ROOM;
    let top = start * line(right);
    let words = format!("order {}", judged.convergence.words());
    Some(([(left, start), (right, start), (right, top), (left, start)], words))
}

/// A text that begins at a place.
fn word(x: f64, y: f64, text: String) -> Series {
    Series::new("", Look::new(BLACK, Marker::Dot), Mark::Text, [Point::new(x, y).note(text)]).unlisted().guide()
}

fn caption(judged: &Judged) -> String {
    let open = if judged.errors.iter().any(|(_, e)| *e < 0.0) {
        " Open markers: the computed value is too small."
    } else {
        ""
    };
    format!("{}, {}.{open}", judged.row.integrator, judged.row.scheme)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_carry_their_unit() {
        assert_eq!(column(("mesh L", "m")), "mesh_m");
        assert_eq!(column(("time step", "s")), "time_step_s");
        assert_eq!(column(("particles per cell", "-")), "particles_per_cell");
        assert_eq!(column(("speed", "m/s")), "speed_m_per_s");
    }
}

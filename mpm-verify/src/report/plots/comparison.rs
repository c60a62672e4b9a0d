//! A finest run beside its reference: over time, over the height, or as fields, and their difference.

use super::axis::Axis;
use super::field::Field;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{self, BLACK, BLUE, Dash, Look, Marker, RED};
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::{Judged, Sampled};
use crate::report::numbers::brief;

/// Profiles that are shown at most.
const PROFILES: usize = 5;
/// Fewer points are marked one by one.
const FEW: usize = 60;

/// Panels, and what is seen in them.
struct Drawn {
    what: String,
    caption: &'static str,
    panels: Vec<Panel>,
}

/// Computed and exact curves, and their difference; `None` where a case has no numbers at places or times.
pub fn curves(judged: &Judged) -> Option<Figure> {
    let Drawn { what, caption, panels } = match judged.comparisons.iter().find(|comparison| is_profile(comparison)) {
        Some(profile) => profiles(profile),
        None => over_time(judged)?,
    };
    (!panels.is_empty()).then(|| Figure {
        name: "curves",
        title: format!("{}: {what}", judged.case.name),
        caption: caption.to_owned(),
        height: 290.0,
        panels,
        missing: Vec::new(),
    })
}

/// The field of the last time that counts: computed, exact, and their difference.
pub fn fields(judged: &Judged) -> Vec<Field> {
    let planar = |c: &&Comparison| !is_profile(c) && c.rows.iter().any(|row| row.places.len() > 1);
    let Some(comparison) = judged.comparisons.iter().find(planar) else { return Vec::new() };
    let Some(row) = comparison.rows.iter().rev().find(|row| row.counts && row.places.len() > 1) else {
        return Vec::new();
    };
    let count = row.places.len() as f64;
    let extent = |axis: usize| {
        let all = || row.places.iter().map(|place| place[axis]);
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    // Places are in the middle of what they stand for: one less than there are lies between the first and the last.
    let spacing = (extent(0) * extent(1)).sqrt() / (count.sqrt() - 1.0);
    let range = |values: &[f64]| {
        (values.iter().copied().fold(f64::INFINITY, f64::min), values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    };
    let exact = range(&row.exact);
    let differences: Vec<f64> = row.computed.iter().zip(&row.exact).map(|(a, b)| a - b).collect();
    let field = |name: &'static str, what: &str, values: &[f64], range: Option<(f64, f64)>| Field {
        name,
        title: format!("{}: {}, {what}, at t = {} s", judged.case.name, comparison.quantity, brief(row.time, 4)),
        caption: format!("{what}: {}.", comparison.quantity),
        quantity: comparison.quantity.clone(),
        column: "value",
        range,
        spacing,
        starts: Vec::new(),
        points: row.places.iter().zip(values).map(|(place, value)| [place[0], place[1], *value]).collect(),
        lines: Vec::new(),
    };
    // Differences that are round-off of what is compared have no colours.
    let least = 1e-12 * f64::max(exact.0.abs(), exact.1.abs());
    let off = Some((-least, least)).filter(|_| differences.iter().all(|d| d.abs() <= least));
    let same = Some(exact);
    vec![
        field("field-computed", "computed", &row.computed, same),
        field("field-exact", "exact", &row.exact, same),
        field("field-difference", "computed less exact", &differences, off),
    ]
}

/// Whether all places of a row lie on an axis.
fn is_along(row: &Compared, axis: usize) -> bool {
    row.places.len() > 1 && row.places.iter().all(|place| place[axis] == 0.0)
}

fn is_profile(comparison: &Comparison) -> bool {
    comparison.rows.iter().any(|row| is_along(row, 0) || is_along(row, 1))
}

/// Whether the places lie along the base.
fn is_level(comparison: &Comparison) -> bool {
    comparison.rows.iter().filter(|row| row.places.len() > 1).all(|row| is_along(row, 1))
}

/// What is shown over time: the comparisons with one number at a time, else the samples that the case gives.
fn samples(judged: &Judged) -> Vec<Sampled> {
    let counting = judged.samples.iter().any(|s| s.counts);
    judged.samples.iter().filter(|s| s.counts == counting).cloned().collect()
}

/// Fewest times that make a curve of errors.
const TIMES: usize = 3;

/// Numbers over time with their errors. Of a field only the place that is furthest off is known: values at places that change make no curve.
fn over_time(judged: &Judged) -> Option<Drawn> {
    let (samples, moves) =
        (samples(judged), judged.comparisons.iter().flat_map(|c| &c.rows).any(|row| row.exact.len() > 1));
    let factor = samples.iter().all(|s| s.factor.is_some_and(|factor| factor > 0.0));
    let time = || match factor {
        true => Axis::log("time factor Tv", "time_factor"),
        false => Axis::linear("time (s)", "time_s"),
    };
    let place = |s: &Sampled| if factor { s.factor.unwrap_or(f64::NAN) } else { s.time };
    let mut quantities: Vec<&str> = Vec::new();
    samples.iter().for_each(|s| {
        if !quantities.contains(&s.quantity.as_str()) {
            quantities.push(&s.quantity);
        }
    });
    let label = quantities
        .first()
        .map_or(String::new(), |q| if quantities.len() > 1 { "value".to_owned() } else { (*q).to_owned() });
    let unit = samples.first().map_or("", |s| if s.unit == "-" { "" } else { &s.unit });
    let named = if unit.is_empty() { label } else { format!("{label} ({unit})") };
    let mut values = Panel::new("", time(), Axis::linear(&named, "value"));
    let mut errors = Panel::new("", time(), Axis::linear("error", "error"));
    for (nth, quantity) in quantities.iter().take(6).enumerate() {
        let own: Vec<&Sampled> = samples.iter().filter(|s| s.quantity == *quantity).collect();
        let mark = if own.len() < FEW { Mark::Points } else { Mark::Line };
        let (name, one) = (quantity.to_string(), quantities.len() == 1);
        let colour = if one { Look::new(BLUE, Marker::Circle) } else { look::nth(nth) };
        let computed = if one { "computed".to_owned() } else { format!("{name}, computed") };
        let exact =
            if one { Look::new(RED, Marker::Dot).dash(Dash::Dashed) } else { look::nth(nth).dash(Dash::Dashed) };
        values.add(Series::line(
            if one { "exact".to_owned() } else { format!("{name}, exact") },
            exact,
            own.iter().map(|s| (place(s), s.exact)),
        ));
        values.add(Series::new(
            computed,
            colour.radius(3.6),
            mark,
            own.iter().map(|s| Point::new(place(s), s.computed)),
        ));
        errors.add(
            Series::new(
                if one { "error".to_owned() } else { name },
                colour.radius(3.2),
                Mark::LinePoints,
                own.iter().map(|s| Point::new(place(s), s.error)),
            )
            .unlisted(),
        );
    }
    let mut times: Vec<f64> = samples.iter().map(place).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let over = if factor { "the time factor" } else { "time" };
    if moves {
        return (times.len() >= TIMES).then(|| Drawn {
            what: format!("error over {over}"),
            caption: "Error of the finest run where it is furthest off, as the case counts it.",
            panels: vec![errors],
        });
    }
    (times.len() > 1 && !values.is_empty()).then(|| Drawn {
        what: format!("{named} over {over}, computed and exact"),
        caption: "Markers: the finest run; dashed: the exact solution. Right: the error as the case counts it.",
        panels: vec![values, errors],
    })
}

/// Values over the height, or along a line on the base.
fn profiles(comparison: &Comparison) -> Drawn {
    let rows: Vec<&Compared> = comparison.rows.iter().filter(|row| row.places.len() > 1).collect();
    let every = rows.len().div_ceil(PROFILES).max(1);
    let level = is_level(comparison);
    let at = |value: f64, place: &[f64; 2]| if level { (place[0], value) } else { (value, place[1]) };
    let panel = |label: &str, column: &'static str| {
        let value = Axis::linear(label, column);
        let [x, y] =
            if level { [Axis::linear("x (m)", "x_m"), value] } else { [value, Axis::linear("height (m)", "height_m")] };
        Panel::new("", x, y)
    };
    let unit = if comparison.unit == "-" { String::new() } else { format!(" ({})", comparison.unit) };
    let mut values = panel(&format!("{}{unit}", comparison.quantity), "value");
    let mut errors = panel(&format!("computed less exact{unit}"), "difference");
    for (nth, row) in rows.iter().rev().step_by(every).enumerate() {
        let label = match row.factor {
            Some(factor) => format!("Tv = {}", brief(factor, 3)),
            None => format!("t = {} s", brief(row.time, 3)),
        };
        let exact = row.exact.iter().zip(&row.places).map(|(value, place)| at(*value, place));
        let line = if rows.len() == 1 { Look::new(BLACK, Marker::Dot) } else { look::nth(nth) };
        values.add(Series::line(format!("exact, {label}"), line.dash(Dash::Solid).width(1.3), exact).unlisted());
        let point = |(value, place): (f64, &[f64; 2])| {
            let (x, y) = at(value, place);
            Point::new(x, y)
        };
        let computed = row.computed.iter().copied().zip(&row.places).map(point);
        values.add(Series::new(label.clone(), look::nth(nth).radius(2.8), Mark::Points, computed));
        let off = row.computed.iter().zip(&row.exact).map(|(a, b)| a - b).zip(&row.places).map(point);
        errors.add(Series::new(label, look::nth(nth).radius(2.4), Mark::LinePoints, off).unlisted());
    }
    let along = if level { "along the base" } else { "over the height" };
    Drawn {
        what: format!("{}{unit} {along}, computed and exact", comparison.quantity),
        caption: "Markers: the finest run; lines of the same colour: the exact solution. Right: computed less exact.",
        panels: vec![values, errors],
    }
}

//! The factor of safety over time: what runs with reduced strength found, beside two closed forms.

use std::path::Path;

use super::{Event, label, said};
use crate::report::numbers::exact;
use crate::report::plots::axis::Axis;
use crate::report::plots::canvas::text_width;
use crate::report::plots::draw::TEXT;
use crate::report::plots::figure::{Figure, Mark, Panel, Point, Series};
use crate::report::plots::look::{BLUE, Dash, GREEN, GREY, Look, Marker, PALE, PURPLE, RED};
use crate::report::plots::write_drawn;
use crate::report::{ReportError, tables};

/// Between which factors the slope fails at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bracket {
    /// Time on the reader's clock, h.
    pub time_h: f64,
    /// Largest factor by which the strength was divided and the slope stood; NaN if none was tried.
    pub low: f64,
    /// Smallest factor with which it failed; NaN if none was tried.
    pub high: f64,
}

/// The factor of safety over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Safety {
    /// Computed with Davis' strength, at some times.
    pub brackets: Vec<Bracket>,
    /// The same with associated flow.
    pub associated: Vec<Bracket>,
    /// Of the infinite slope: time in h and factor.
    pub infinite_slope: Vec<(f64, f64)>,
    /// By Bishop's method of slices: time in h and factor.
    pub bishop: Vec<(f64, f64)>,
    /// By Spencer's: time in h and factor.
    pub spencer: Vec<(f64, f64)>,
    /// The same with Davis' reduced strength.
    pub spencer_davis: Vec<(f64, f64)>,
    /// Why the slope fails before its factor is 1, if it does.
    pub why: String,
}

/// Width (an estimate, for the names of events alone) and height of the frame, px.
const WIDTH: f64 = 800.0;
const HEIGHT: f64 = 380.0;
const COMPUTED: Look = Look::new(BLUE, Marker::Circle).width(1.8).radius(4.5);
const UPPER: Look = Look::new(BLUE, Marker::Square).width(1.2).radius(3.0);
const BAND: Look = Look::new(PALE, Marker::Dot);
const ONE: Look = Look::new(GREY, Marker::Dot).width(1.4);
const ACROSS: Look = Look::new(GREY, Marker::Dot).width(1.1).dash(Dash::Dashed);

/// The picture.
pub fn figure(safety: &Safety, events: &[Event]) -> Figure {
    let mut panel = Panel::new("", Axis::linear("time (h)", "time_h"), Axis::linear("factor of safety", "fs"));
    let line = |name: &str, colour, dash, points: &[(f64, f64)]| {
        Series::line(name, Look::new(colour, Marker::Dot).width(2.0).dash(dash), points.iter().copied())
    };
    panel.add(line("infinite slope", GREEN, Dash::Dashed, &safety.infinite_slope));
    panel.add(line("Bishop", RED, Dash::DashDot, &safety.bishop));
    panel.add(line("Spencer", PURPLE, Dash::Dotted, &safety.spencer));
    panel.add(line("Spencer, strength reduced after Davis", PURPLE, Dash::Dashed, &safety.spencer_davis));
    let both = |b: &&Bracket| b.low.is_finite() && b.high.is_finite();
    // From Davis' strength to the full one: where the factor may be.
    let middle = |b: &Bracket| Point::new(b.time_h, 0.5 * (b.low + b.high));
    let upper: Vec<Point> = safety.associated.iter().filter(both).map(middle).collect();
    if !upper.is_empty() {
        let lower = safety.brackets.iter().filter(both).map(middle);
        panel.add(Series::new(
            "from Davis' to the full strength",
            BAND,
            Mark::Area,
            lower.chain(upper.iter().rev().cloned()),
        ));
        panel.add(Series::new("computed, associated flow", UPPER, Mark::LinePoints, upper));
    }
    let ranges = safety.brackets.iter().filter(both).map(|b| Point::new(b.time_h, b.high).from(b.low));
    panel.add(Series::new("stands below, fails above", COMPUTED, Mark::Range, ranges));
    let middles = safety.brackets.iter().filter(both).map(|b| Point::new(b.time_h, 0.5 * (b.low + b.high)));
    panel.add(Series::new("computed, Davis' strength", COMPUTED.radius(3.5), Mark::LinePoints, middles));
    // One end only: the factor is above, or below.
    let above = safety.brackets.iter().filter(|b| b.high.is_nan()).map(|b| Point::new(b.time_h, b.low).open(true));
    let up = Look { marker: Marker::Up, ..COMPUTED };
    panel.add(Series::new("stood at every factor tried", up, Mark::Points, above));
    let below = safety.brackets.iter().filter(|b| b.low.is_nan()).map(|b| Point::new(b.time_h, b.high).open(true));
    let down = Look { marker: Marker::Down, ..COMPUTED };
    panel.add(Series::new("failed at every factor tried", down, Mark::Points, below));
    let times = panel.all_x();
    panel.x.fit(times.into_iter().chain(events.iter().map(|e| e.time_s / 3600.0)));
    let factors = panel.all_y();
    panel.y.fit(factors.into_iter().chain([1.0]));
    let ((left, right), (low, high)) = (panel.x.range.unwrap_or((0.0, 1.0)), panel.y.range.unwrap_or((0.0, 1.0)));
    panel.series.insert(0, Series::line("", ONE, [(left, 1.0), (right, 1.0)]).unlisted().guide());
    let unit = (WIDTH / (right - left), HEIGHT / (high - low));
    for event in events {
        let x = event.time_s / 3600.0;
        panel.series.insert(0, Series::line("", ACROSS, [(x, low), (x, high)]).unlisted().guide());
    }
    for (place, event) in events.iter().enumerate() {
        // Each lower than the one before: events may be close.
        let x = event.time_s / 3600.0 + (0.5 * text_width(&event.name, TEXT) + 7.0) / unit.0;
        label(&mut panel, (x, high - (14.0 + 18.0 * place as f64) / unit.1), event.name.clone(), unit);
    }
    let tail = if events.is_empty() { String::new() } else { format!(" {}.", said(events)) };
    let why = if safety.why.is_empty() { String::new() } else { format!(" {}", safety.why) };
    Figure {
        name: "levee-safety",
        title: "Factor of safety over time".to_owned(),
        caption: format!(
            "The strength is divided by a factor: bars reach from the largest with which the slope stood to the \
             smallest with which it failed. Lines: closed forms with the same water.{tail}{why}"
        ),
        height: HEIGHT,
        panels: vec![panel],
        missing: if safety.brackets.is_empty() {
            vec!["Factor of safety: none computed.".to_owned()]
        } else {
            Vec::new()
        },
    }
}

/// Writes it with its numbers. Returns the text of the SVG.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(safety: &Safety, events: &[Event], folder: &Path) -> Result<String, ReportError> {
    let figure = figure(safety, events);
    let row = |what: &str, time: f64, low: f64, high: f64| {
        [vec![what.to_owned()], [time, low, high].map(exact).to_vec()].concat()
    };
    let computed = safety.brackets.iter().map(|b| row("computed", b.time_h, b.low, b.high));
    let brackets =
        computed.chain(safety.associated.iter().map(|b| row("computed, associated", b.time_h, b.low, b.high)));
    let infinite = safety.infinite_slope.iter().map(|(t, fs)| row("infinite slope", *t, *fs, *fs));
    let bishop = safety.bishop.iter().map(|(t, fs)| row("Bishop", *t, *fs, *fs));
    let spencer = safety.spencer.iter().map(|(t, fs)| row("Spencer", *t, *fs, *fs));
    let davis = safety.spencer_davis.iter().map(|(t, fs)| row("Spencer, Davis", *t, *fs, *fs));
    let path = folder.join(format!("{}.csv", figure.name));
    let all = brackets.chain(infinite).chain(bishop).chain(spencer).chain(davis);
    tables::table(&path, "method,time_h,fs_low,fs_high", all)?;
    write_drawn(&figure, folder)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{events, folder};
    use super::*;

    fn safety() -> Safety {
        let bracket = |time_h: f64, low: f64, high: f64| Bracket { time_h, low, high };
        let line = |start: f64, slope: f64| {
            (0..=30).map(|k| 6.0 + 0.1 * f64::from(k)).map(move |t| (t, start - slope * (t - 6.0)))
        };
        Safety {
            brackets: vec![
                bracket(6.0, 1.5, f64::NAN),
                bracket(7.0, 1.20, 1.25),
                bracket(8.0, 1.05, 1.10),
                bracket(8.5, 1.00, 1.025),
                bracket(9.0, f64::NAN, 0.95),
            ],
            associated: vec![bracket(7.0, 1.30, 1.32), bracket(8.5, 1.08, 1.10)],
            infinite_slope: line(1.25, 0.13).collect(),
            bishop: line(1.45, 0.15).collect(),
            spencer: line(1.5, 0.15).collect(),
            spencer_davis: line(1.3, 0.15).collect(),
            why: String::new(),
        }
    }

    #[test]
    fn brackets_stand_beside_closed_forms() {
        let (folder, _own) = folder();
        let svg = write(&safety(), &events(), &folder).expect("a picture");
        for part in ["Bishop", "infinite slope", "stood at every factor tried", "failed at every factor tried", "E3"] {
            assert!(svg.contains(part), "{part}");
        }
        let table = std::fs::read_to_string(folder.join("levee-safety.csv")).expect("a table");
        assert!(table.contains("computed,7.0,1.2,1.25\n") && table.contains("computed,6.0,1.5,NaN\n"));
        assert_eq!(figure(&Safety::default(), &[]).missing.len(), 1);
    }
}

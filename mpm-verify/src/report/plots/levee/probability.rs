//! The probability of failure over time, beside the runs that it was checked by.

use std::path::Path;

use super::{Event, label, said};
use crate::report::numbers::exact;
use crate::report::plots::axis::Axis;
use crate::report::plots::canvas::text_width;
use crate::report::plots::draw::TEXT;
use crate::report::plots::figure::{Figure, Mark, Panel, Point, Series};
use crate::report::plots::look::{BLUE, Dash, GREY, Look, Marker, PALE, RED};
use crate::report::plots::write_drawn;
use crate::report::{ReportError, tables};

/// Probabilities over time, all at the same times (h).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// With the critical factor of safety at its median.
    pub middle: Vec<(f64, f64)>,
    /// At the lower end of its range.
    pub low: Vec<(f64, f64)>,
    /// At the upper end.
    pub high: Vec<(f64, f64)>,
    /// Whole runs: time of failure, and the share that had failed.
    pub runs: Vec<(f64, f64)>,
    /// Samples.
    pub samples: usize,
}

/// Width (an estimate, for the names of events alone) and height of the frame, px.
const WIDTH: f64 = 800.0;
const HEIGHT: f64 = 340.0;

/// The picture; `events` are drawn across it.
pub fn figure(curve: &Curve, events: &[Event]) -> Figure {
    let mut panel =
        Panel::new("", Axis::linear("time (h)", "time_h"), Axis::linear("probability of failure (%)", "share"));
    let point = |(time, share): &(f64, f64)| Point::new(*time, 100.0 * share);
    let band = curve.low.iter().chain(curve.high.iter().rev()).map(point);
    panel.add(Series::new("critical factor of four of five runs", Look::new(PALE, Marker::Dot), Mark::Area, band));
    let middle = curve.middle.iter().map(|(time, share)| (*time, 100.0 * share));
    panel.add(Series::line("by the factor of safety", Look::new(BLUE, Marker::Dot).width(2.0), middle));
    panel.add(Series::new(
        "whole runs",
        Look::new(RED, Marker::Circle).radius(4.0),
        Mark::Points,
        curve.runs.iter().map(point),
    ));
    let times = panel.all_x();
    panel.x.fit(times.into_iter().chain(events.iter().map(|e| e.time_s / 3600.0)));
    panel.y.fit([0.0, 100.0].into_iter());
    let ((left, right), (low, high)) = (panel.x.range.unwrap_or((0.0, 1.0)), panel.y.range.unwrap_or((0.0, 100.0)));
    let unit = (WIDTH / (right - left), HEIGHT / (high - low));
    let across = Look::new(GREY, Marker::Dot).width(1.1).dash(Dash::Dashed);
    for (place, event) in events.iter().enumerate() {
        let x = event.time_s / 3600.0;
        panel.series.insert(0, Series::line("", across, [(x, low), (x, high)]).unlisted().guide());
        let beside = x + (0.5 * text_width(&event.name, TEXT) + 7.0) / unit.0;
        label(&mut panel, (beside, low + (14.0 + 18.0 * place as f64) / unit.1), event.name.clone(), unit);
    }
    let tail = if events.is_empty() { String::new() } else { format!(" {}.", said(events)) };
    Figure {
        name: "levee-probability",
        title: "Probability that the slope has failed".to_owned(),
        caption: format!(
            "Share of {} samples of strength, conductivity and moisture that have failed (E1).{tail}",
            curve.samples
        ),
        height: HEIGHT,
        panels: vec![panel],
        missing: Vec::new(),
    }
}

/// Writes it with its numbers. Returns the text of the SVG.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(curve: &Curve, events: &[Event], folder: &Path) -> Result<String, ReportError> {
    let figure = figure(curve, events);
    let parts = [("median", &curve.middle), ("late", &curve.low), ("early", &curve.high), ("run", &curve.runs)];
    let rows = parts.into_iter().flat_map(|(what, points)| {
        points.iter().map(move |(time, share)| vec![what.to_owned(), exact(*time), exact(*share)])
    });
    tables::table(&folder.join(format!("{}.csv", figure.name)), "what,time_h,share", rows)?;
    write_drawn(&figure, folder)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{events, folder};
    use super::*;

    #[test]
    fn runs_stand_beside_the_curve() {
        let rising =
            |shift: f64| (0..=10).map(|k| (f64::from(k), (f64::from(k) / 10.0 + shift).clamp(0.0, 1.0))).collect();
        let curve =
            Curve { middle: rising(0.0), low: rising(-0.1), high: rising(0.1), runs: vec![(5.0, 0.5)], samples: 100 };
        let (folder, _own) = folder();
        let svg = write(&curve, &events(), &folder).expect("a picture");
        for part in ["whole runs", "by the factor of safety", "E3"] {
            assert!(svg.contains(part), "{part}");
        }
        let table = std::fs::read_to_string(folder.join("levee-probability.csv")).expect("a table");
        assert!(table.contains("median,5.0,0.5\n") && table.contains("run,5.0,0.5\n"), "{table}");
    }
}

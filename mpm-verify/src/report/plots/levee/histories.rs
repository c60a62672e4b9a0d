//! What happened over time: tracks below each other, with the events as lines across, in hours and, around the
//! failure, in seconds.

use std::path::Path;

use super::{Event, bare, clock, label, said};
use crate::report::numbers::exact;
use crate::report::plots::axis::Axis;
use crate::report::plots::canvas::text_width;
use crate::report::plots::draw::TEXT;
use crate::report::plots::figure::{Figure, Panel, Series};
use crate::report::plots::look::{self, Dash, GREY, Look, Marker};
use crate::report::plots::write_drawn;
use crate::report::{ReportError, tables};

/// Heights of a track and of a line of names of events, px.
const HEIGHTS: (f64, f64) = (104.0, 17.0);
/// Widths of both frames, px: an estimate, for the names of events alone.
const WIDTHS: [f64; 2] = [400.0, 300.0];
const SHARES: [f64; 2] = [0.56, 0.44];
/// Points of a drawn line: about one per px.
const MOST: usize = 800;
const ACROSS: Look = Look::new(GREY, Marker::Dot).width(1.1).dash(Dash::Dashed);

/// Values over time that stand in one panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Quantity and unit; it stands along a side of 104 px, so 16 letters at most: `outflow (m³)`.
    pub label: String,
    /// Whether the axis is logarithmic.
    pub log: bool,
    /// The lines of the panel.
    pub lines: Vec<Trace>,
    /// What they should stay below.
    pub limit: Option<f64>,
}

/// Values of one thing over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Its name in legend and table.
    pub name: String,
    /// Time on the reader's clock, s, and value in the unit of the track.
    pub points: Vec<(f64, f64)>,
}

/// The part of time that is shown in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zoom {
    /// Its zero, s on the reader's clock.
    pub start_s: f64,
    /// How far it reaches before that, s.
    pub before_s: f64,
    /// How far after it, s.
    pub after_s: f64,
}

/// Which picture: the name of its files and its title.
pub type Named = (&'static str, &'static str);

/// The picture; without the panels in seconds where there is no zoom.
pub fn figure((name, title): Named, tracks: &[Track], events: &[Event], zoom: Option<Zoom>) -> Figure {
    let times = tracks.iter().flat_map(|t| t.lines.iter().flat_map(|l| l.points.iter().map(|p| p.0)));
    let (first, last) =
        times.filter(|t| t.is_finite()).fold((f64::INFINITY, 0.0_f64), |(a, b), t| (a.min(t), b.max(t)));
    let first = if first.is_finite() { first } else { 0.0 };
    let room = 0.02 * (last - first).max(60.0);
    let hours = Span { zero: 0.0, unit: 3600.0, ends: (first - room, last + room), label: "time (h)".to_owned() };
    let seconds = zoom.map(|z| Span {
        zero: z.start_s,
        unit: 1.0,
        ends: (z.start_s - z.before_s, z.start_s + z.after_s),
        label: format!("time after {} (s)", clock(z.start_s)),
    });
    let mut panels: Vec<Panel> = Vec::new();
    let spans: Vec<Span> = [Some(hours), seconds].into_iter().flatten().collect();
    let width = |column: usize| if zoom.is_some() { WIDTHS[column] } else { WIDTHS[0] + WIDTHS[1] };
    let places: Vec<Vec<Name>> = spans.iter().enumerate().map(|(k, span)| places(events, span, width(k))).collect();
    let lines = places.iter().flatten().map(|name| name.line + 1).max().unwrap_or(0);
    for (column, span) in spans.iter().enumerate() {
        let share = if zoom.is_some() { SHARES[column] } else { 1.0 };
        panels.push(Panel { share, ..names(&places[column], span, lines, width(column)) });
        let mut listed = 0;
        for (row, track) in tracks.iter().enumerate() {
            let mut panel = Panel { share, row: row + 1, ..filled(track, listed, events, span) };
            listed += if track.lines.len() > 1 { track.lines.len() } else { 0 };
            if row + 1 < tracks.len() {
                panel.x = panel.x.quiet();
            }
            if column > 0 {
                panel.y.label.clear();
            }
            panels.push(panel);
        }
    }
    Figure {
        name,
        title: title.to_owned(),
        caption: format!(
            "{}.{}",
            said(events),
            if tracks.iter().any(|t| t.limit.is_some()) { " Dotted: what a curve should stay below." } else { "" }
        ),
        height: HEIGHTS.0,
        panels,
        missing: Vec::new(),
    }
}

/// Writes it with all values and all events. Returns the text of the SVG.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(
    named: Named,
    tracks: &[Track],
    events: &[Event],
    zoom: Option<Zoom>,
    folder: &Path,
) -> Result<String, ReportError> {
    let figure = figure(named, tracks, events, zoom);
    let row = |quantity: &str, name: &str, time: f64, value: f64| {
        vec![quantity.to_owned(), name.to_owned(), exact(time), exact(value)]
    };
    let values = tracks.iter().flat_map(|track| {
        let line = |line: &Trace| line.points.iter().map(|p| row(&track.label, &line.name, p.0, p.1)).collect();
        track.lines.iter().flat_map(move |l| -> Vec<Vec<String>> { line(l) })
    });
    let events = events.iter().map(|e| row("event", &format!("{}: {}", e.name, e.words), e.time_s, f64::NAN));
    let path = folder.join(format!("{}.csv", figure.name));
    tables::table(&path, "quantity,series,time_s,value", values.chain(events).collect::<Vec<_>>())?;
    write_drawn(&figure, folder)
}

/// A part of time and how it is written.
struct Span {
    /// What is zero on the axis, s.
    zero: f64,
    /// Its unit, s.
    unit: f64,
    /// Its ends, s.
    ends: (f64, f64),
    label: String,
}

impl Span {
    fn at(&self, time_s: f64) -> f64 {
        (time_s - self.zero) / self.unit
    }

    fn holds(&self, time_s: f64) -> bool {
        (self.ends.0..=self.ends.1).contains(&time_s)
    }

    fn axis(&self) -> Axis {
        Axis::linear(&self.label, "time").range(self.at(self.ends.0), self.at(self.ends.1))
    }

    /// The points within, with one beyond either end so that lines reach the frame; few enough to draw.
    fn points(&self, all: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let first = all.partition_point(|p| p.0 < self.ends.0).saturating_sub(1);
        let last = (all.partition_point(|p| p.0 <= self.ends.1) + 1).min(all.len());
        thinned(&all[first.min(last)..last]).into_iter().map(|(time, value)| (self.at(time), value)).collect()
    }
}

/// At most [`MOST`] points that keep every peak: the smallest and the largest of each part.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if points.len() <= MOST {
        return points.to_vec();
    }
    let parts = points.chunks(points.len().div_ceil(MOST / 2));
    let kept = parts.flat_map(|part| {
        let by = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let ends = [part.iter().min_by(by), part.iter().max_by(by)].map(|p| p.copied().unwrap_or((f64::NAN, f64::NAN)));
        if ends[0].0 <= ends[1].0 { ends } else { [ends[1], ends[0]] }
    });
    kept.collect()
}

/// The panel of a track; `listed` lines stand in the legend before its own, which look like none of those.
fn filled(track: &Track, listed: usize, events: &[Event], span: &Span) -> Panel {
    let y = if track.log { Axis::log(&track.label, "value") } else { Axis::linear(&track.label, "value") };
    let mut panel = Panel::new("", span.axis(), y);
    let several = track.lines.len() > 1;
    for (place, line) in track.lines.iter().enumerate() {
        let look = if several { distinct(listed + place) } else { look::nth(0) };
        let series = Series::line(line.name.clone(), look, span.points(&line.points));
        panel.add(if several { series } else { series.unlisted() });
    }
    if let Some(limit) = track.limit {
        let ends = [span.ends.0, span.ends.1].map(|time| (span.at(time), limit));
        panel.add(Series::line("", Look::new(look::BLACK, Marker::Dot).dash(Dash::Dotted), ends).unlisted());
    }
    let values = panel.all_y();
    panel.y.fit(values.into_iter());
    if track.log {
        panel.y.range = panel.y.range.map(a_decade);
    }
    let (low, high) = panel.y.range.unwrap_or((0.0, 1.0));
    for event in events.iter().filter(|e| span.holds(e.time_s)) {
        let x = span.at(event.time_s);
        panel.add(Series::line("", ACROSS, [(x, low), (x, high)]).unlisted().guide());
    }
    panel
}

/// Colour and dash that no other line of the legend has, up to 24.
fn distinct(place: usize) -> Look {
    let dashes = [Dash::Solid, Dash::Dashed, Dash::DashDot, Dash::Dotted];
    look::nth(place % 6).dash(dashes[(place + place / 12) % 4])
}

/// At least a decade, so that there are ticks to read.
fn a_decade((low, high): (f64, f64)) -> (f64, f64) {
    let spare = (12.0 * low / high).max(1.0).sqrt();
    (low / spare, high * spare)
}

/// The name of an event: places along the axis of its line and of its middle, and its line of text.
struct Name<'a> {
    text: &'a str,
    at: f64,
    middle: f64,
    line: usize,
}

/// The names of events, each above its line, in as many lines of text as they need not to overlap.
fn places<'a>(events: &'a [Event], span: &Span, width: f64) -> Vec<Name<'a>> {
    let (left, right) = (span.at(span.ends.0), span.at(span.ends.1));
    let unit = width / (right - left);
    let mut shown: Vec<&Event> = events.iter().filter(|e| span.holds(e.time_s)).collect();
    shown.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    // Where the last name of each line of text ends.
    let mut ends: Vec<f64> = Vec::new();
    let place = |event: &'a Event| {
        let half = (0.5 * text_width(&event.name, TEXT) + 5.0) / unit;
        let at = span.at(event.time_s);
        let middle = at.clamp(left + half, (right - half).max(left + half));
        let line = ends.iter().position(|end| *end <= middle - half).unwrap_or(ends.len());
        if line == ends.len() {
            ends.push(0.0);
        }
        ends[line] = middle + half;
        Name { text: &event.name, at, middle, line }
    };
    shown.into_iter().map(place).collect()
}

/// A panel of names, `lines` lines of text high.
fn names(names: &[Name], span: &Span, lines: usize, width: f64) -> Panel {
    let height = HEIGHTS.1 * lines as f64;
    if names.is_empty() {
        return Panel { height: Some(height), ..Panel::blank() };
    }
    let axis = span.axis().quiet();
    let unit = (width / (span.at(span.ends.1) - span.at(span.ends.0)), HEIGHTS.1);
    let mut panel = Panel { height: Some(height), ..Panel::new("", axis, bare(0.0, lines as f64)) };
    for name in names {
        panel.add(Series::line("", ACROSS, [(name.at, 0.0), (name.at, name.line as f64 + 0.5)]).unlisted());
    }
    for name in names {
        label(&mut panel, (name.middle, name.line as f64 + 0.5), name.text, unit);
    }
    panel
}

#[cfg(test)]
mod tests {
    use super::super::tests::{events, folder};
    use super::*;
    use crate::frames::made_up::FAILURE_S;

    fn trace(name: &str, of: impl Fn(f64) -> f64) -> Trace {
        let seepage = (0..160).map(|k| 21_600.0 + 60.0 * f64::from(k)).filter(|t| *t < FAILURE_S);
        let slide = (0..=600).map(|k| FAILURE_S + 0.1 * f64::from(k));
        let later = (1..20).map(|k| FAILURE_S + 60.0 * f64::from(k));
        Trace { name: name.to_owned(), points: seepage.chain(slide).chain(later).map(|t| (t, of(t))).collect() }
    }

    fn track(label: &str, log: bool, lines: Vec<Trace>) -> Track {
        Track { label: label.to_owned(), log, lines, limit: None }
    }

    /// What a run that fails may leave.
    fn tracks() -> Vec<Track> {
        let after = |t: f64| (t - FAILURE_S).max(0.0);
        let slid = move |t: f64| 1.0 - (-after(t) / 8.0).exp();
        let kinetic = move |t: f64| 1e-7 + 40.0 * after(t) * (-after(t) / 4.0).exp();
        vec![
            track("toe (m)", false, vec![trace("toe", move |t| 9.0 + 1.7 * slid(t))]),
            track("crest (m)", false, vec![trace("crest", move |t| 3.0 - 0.2 * slid(t))]),
            track("front (m)", false, vec![trace("front", |t| (6.3 + 2.7 * (t - 21_600.0) / 9_576.0).min(9.0))]),
            track("outflow (m³)", false, vec![trace("outflow", |t| 3e-5 * (t - 27_000.0).max(0.0))]),
            track(
                "energy (J)",
                true,
                vec![trace("kinetic energy", kinetic), trace("work of weight", move |t| 1.0 + 9e3 * slid(t))],
            ),
            Track {
                limit: Some(1e-6),
                ..track("residual (kPa)", true, vec![trace("residual", |t| 1e-9 * (2.0 + (t * 0.7).sin()))])
            },
            track("FS", false, vec![trace("factor of safety", move |t| 1.10 - (t - 21_600.0) / 9_576.0 * 0.11)]),
        ]
    }

    #[test]
    fn tracks_stand_below_each_other_with_events_across() {
        let (folder, _own) = folder();
        let zoom = Zoom { start_s: FAILURE_S, before_s: 5.0, after_s: 40.0 };
        let named = ("levee-histories", "What happened over time");
        let svg = write(named, &tracks(), &events(), Some(zoom), &folder).expect("a picture");
        for part in ["front at toe", "E1", "time (h)", "time after 8 h 39 min 36 s (s)", "kinetic energy"] {
            assert!(svg.contains(part), "{part}");
        }
        let figure = figure(named, &tracks(), &events(), None);
        assert!(figure.panels.iter().all(|p| p.share == 1.0) && figure.panels.len() == 8);
        let table = std::fs::read_to_string(folder.join("levee-histories.csv")).expect("a table");
        assert!(table.contains("event,E1: the toe fails,31046.0,NaN"));
        assert!(table.contains("outflow (m³),outflow,21600.0,0.0"));
    }

    #[test]
    fn no_two_lines_of_a_legend_look_alike() {
        let looks: Vec<Look> = (0..24).map(distinct).collect();
        let alike = |a: &Look, b: &Look| a.colour == b.colour && a.dash == b.dash;
        assert!((0..24).all(|k| looks[k + 1..].iter().all(|other| !alike(&looks[k], other))));
    }

    #[test]
    fn names_that_would_overlap_stand_in_lines_of_their_own() {
        let span = Span { zero: 0.0, unit: 3600.0, ends: (21_600.0, 32_400.0), label: String::new() };
        let lines = |events: &[Event]| places(events, &span, 400.0).iter().map(|n| n.line).collect::<Vec<_>>();
        assert_eq!(lines(&events()[..2]), [0, 0]);
        assert_eq!(lines(&events()), [0, 0, 1, 2]);
    }

    #[test]
    fn thinning_keeps_peaks_and_order() {
        let many: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k), if k == 51_234 { 9.0 } else { 0.0 })).collect();
        let few = thinned(&many);
        assert!(few.len() <= MOST && few.contains(&(51_234.0, 9.0)));
        assert!(few.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }
}

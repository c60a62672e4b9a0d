//! What matters how much: bars from the result with the usual inputs to those with one input changed.

use std::path::Path;

use super::label;
use crate::report::numbers::{brief, exact};
use crate::report::plots::axis::Axis;
use crate::report::plots::canvas::text_width;
use crate::report::plots::draw::{TEXT, WIDTH};
use crate::report::plots::figure::{Figure, Mark, Panel, Point, Series};
use crate::report::plots::look::{BLACK, BLUE, Dash, GREY, Look, Marker, ORANGE};
use crate::report::plots::write_drawn;
use crate::report::{ReportError, tables};

/// What a run came to; nothing where it did not fail.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Outcome {
    /// When failure starts, h.
    pub failure_h: Option<f64>,
    /// When rapid failure starts, h.
    pub rapid_h: Option<f64>,
    /// Where the toe ends, m.
    pub toe_m: Option<f64>,
    /// How far the crest settles, m.
    pub crest_m: Option<f64>,
}

/// A run with one input changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// The changed value with its unit: `4.5 kPa`.
    pub label: String,
    /// What it came to.
    pub outcome: Outcome,
}

/// An input and what came of changing it.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// What was changed: `cohesion`.
    pub what: String,
    /// With a smaller value.
    pub low: Option<Variant>,
    /// With a larger one.
    pub high: Option<Variant>,
}

/// A quantity: title and unit, name in the table, value.
type Part = (&'static str, &'static str, fn(&Outcome) -> Option<f64>);

const PARTS: [Part; 4] = [
    ("failure starts (h)", "failure_h", |o| o.failure_h),
    ("rapid failure starts (h)", "rapid_h", |o| o.rapid_h),
    ("toe at the end (m)", "toe_m", |o| o.toe_m),
    ("settlement of the crest (m)", "crest_m", |o| o.crest_m),
];

const LOW: Look = Look::new(BLUE, Marker::Right).width(11.0).radius(5.0);
const HIGH: Look = Look::new(ORANGE, Marker::Right).width(11.0).radius(5.0);
const BASE: Look = Look::new(BLACK, Marker::Dot).width(1.4);
/// Height of an input, px, and how far its two bars are from its middle.
const ROW: (f64, f64) = (36.0, 0.2);
/// What a variant is called that did not fail.
const NEVER: &str = "no failure";

/// The picture: inputs from top to bottom by their effect on when failure starts.
pub fn figure(base: &Outcome, rows: &[Varied]) -> Figure {
    let rows = sorted(base, rows);
    let widest = widest(&rows);
    // Frames are equally wide; only the left ones have names of inputs beside them.
    let (beside, gap) = (44.0, 14.0);
    let frame = 0.5 * (WIDTH - 24.0 - gap - widest - 2.0 * beside);
    let mut panels = Vec::new();
    for (place, part) in PARTS.iter().enumerate() {
        let mut panel = Panel { row: place / 2, ..panel(base, &rows, part, frame) };
        panel.share = frame + beside;
        if place % 2 == 0 {
            panel.share += widest;
        } else {
            panel.y.named = Some(Vec::new());
        }
        panels.push(panel);
    }
    let never = rows.iter().flat_map(|r| variants(r)).any(|(_, v)| PARTS.iter().any(|p| (p.2)(&v.outcome).is_none()));
    Figure {
        name: "levee-sensitivity",
        title: "What changes the result, and by how much".to_owned(),
        caption: format!(
            "One input is changed at a time; the changed value stands at the end of its bar, the upright line is the \
             result with the usual inputs. Inputs are in the order of their effect on when failure starts.{}",
            if never { " Open arrows: the levee did not fail within the run." } else { "" }
        ),
        height: ROW.0 * rows.len().max(1) as f64,
        panels,
        missing: if rows.is_empty() { vec!["Sensitivity: nothing was changed.".to_owned()] } else { Vec::new() },
    }
}

/// Width of the longest name of an input, px.
fn widest<T: std::borrow::Borrow<Varied>>(rows: &[T]) -> f64 {
    rows.iter().map(|row| text_width(&row.borrow().what, TEXT)).fold(0.0, f64::max)
}

/// Writes it with its numbers; an empty cell is a run that did not fail. Returns the text of the SVG.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(base: &Outcome, rows: &[Varied], folder: &Path) -> Result<String, ReportError> {
    let figure = figure(base, rows);
    let row = |what: &str, setting: &str, value: &str, outcome: &Outcome| {
        let cells = PARTS.iter().map(|p| (p.2)(outcome).map_or_else(String::new, exact));
        [what, setting, value].into_iter().map(str::to_owned).chain(cells).collect::<Vec<_>>()
    };
    let changed = rows.iter().flat_map(|r| {
        variants(r).into_iter().map(move |(side, v)| row(&r.what, ["low", "high"][side], &v.label, &v.outcome))
    });
    let all = std::iter::once(row("", "base", "", base)).chain(changed);
    let path = folder.join(format!("{}.csv", figure.name));
    let columns: Vec<&str> = PARTS.iter().map(|p| p.1).collect();
    tables::table(&path, &format!("changed,setting,value,{}", columns.join(",")), all)?;
    write_drawn(&figure, folder)
}

/// Both variants of an input, with 0 for low and 1 for high.
fn variants(row: &Varied) -> Vec<(usize, &Variant)> {
    let low = row.low.iter().map(|v| (0, v));
    low.chain(row.high.iter().map(|v| (1, v))).collect()
}

fn sorted<'a>(base: &Outcome, rows: &'a [Varied]) -> Vec<&'a Varied> {
    let value = PARTS[0].2;
    let effect = |row: &Varied| {
        let far = variants(row).into_iter().map(|(_, v)| match (value(&v.outcome), value(base)) {
            (Some(a), Some(b)) => (a - b).abs(),
            (None, None) => 0.0,
            _ => f64::INFINITY,
        });
        far.fold(0.0, f64::max)
    };
    let mut rows: Vec<&Varied> = rows.iter().collect();
    rows.sort_by(|a, b| effect(b).total_cmp(&effect(a)));
    rows
}

/// One quantity; its frame is `width` px wide.
fn panel(base: &Outcome, rows: &[&Varied], (title, column, value): &Part, width: f64) -> Panel {
    let count = rows.len() as f64;
    let height = |place: usize| count - 1.0 - place as f64;
    let mark = |side: usize| [("smaller of two values", LOW, ROW.1), ("larger of two values", HIGH, -ROW.1)][side];
    let outcomes = || rows.iter().flat_map(|r| variants(r)).map(|(_, v)| value(&v.outcome)).chain([value(base)]);
    let (low, high) = outcomes()
        .flatten()
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let (low, high) = if low > high { (0.0, 1.0) } else { (low, high.max(low + 1e-3 * low.abs().max(1e-3))) };
    // Room for the longest text on either side, and for what is said of those that did not fail, right of the usual.
    let all = || rows.iter().flat_map(|r| variants(r)).map(|(_, v)| v);
    let is_left = |v: &&Variant| value(&v.outcome).zip(value(base)).is_some_and(|(end, usual)| end < usual);
    let widest = |texts: &mut dyn Iterator<Item = String>| texts.map(|t| text_width(&t, TEXT)).fold(0.0, f64::max);
    let before = 14.0 + widest(&mut all().filter(is_left).map(|v| v.label.clone()));
    let mut beyond = 14.0 + widest(&mut all().filter(|v| !is_left(v)).map(|v| v.label.clone()));
    let stood = widest(&mut all().filter(|v| value(&v.outcome).is_none()).map(never));
    if stood > 0.0 {
        let share = value(base).map_or(1.0, |usual| (high - usual) / (high - low)).min(0.9);
        beyond = (beyond + 24.0).max((stood + 44.0 - share * (width - before)) / (1.0 - share));
    }
    let bars = (width - before - beyond).max(0.15 * width) / (high - low);
    let (left, right) = (low - before / bars, high + beyond / bars);
    // Where the texts leave less than that to the bars, all is drawn smaller.
    let unit = width / (right - left);
    let y = Axis::linear("", "").range(-0.5, count - 0.5);
    let named = rows.iter().enumerate().map(|(place, r)| (height(place), r.what.clone())).collect();
    let usual = value(base).map_or_else(|| NEVER.to_owned(), |v| brief(v, 3));
    let mut x = Axis::linear(title, column).range(left, right);
    // What stands beyond the bars is room for their texts, and there are no times or lengths below zero.
    if low >= 0.0 && x.title() == *title {
        x.named = Some(x.ticks().into_iter().filter(|(value, _)| *value >= 0.0).collect());
    }
    let mut panel = Panel::new(&format!("usual: {usual}"), x, y.named(named));
    for (place, row) in rows.iter().enumerate() {
        for (side, variant) in variants(row) {
            let (name, look, up) = mark(side);
            let y = height(place) + up;
            let half = 0.5 * text_width(&variant.label, TEXT) + 6.0;
            match (value(&variant.outcome), value(base)) {
                (Some(end), start) => {
                    let start = start.unwrap_or(end);
                    panel.add(Series::line(name, look, [(start, y), (end, y)]));
                    let outward = if end < start { -half } else { half };
                    label(&mut panel, (end + outward / unit, y), variant.label.clone(), (unit, ROW.0));
                }
                (None, start) => {
                    let edge = right - 10.0 / unit;
                    if let Some(start) = start {
                        let thin = look.width(1.4).dash(Dash::Dotted);
                        panel.add(Series::line("", thin, [(start, y), (edge, y)]).unlisted().guide());
                    }
                    panel.add(Series::new("", look, Mark::Points, [Point::new(edge, y).open(true)]).unlisted());
                    let text = never(variant);
                    let back = 0.5 * text_width(&text, TEXT) + 14.0;
                    label(&mut panel, (edge - back / unit, y), text, (unit, ROW.0));
                }
            }
        }
        if place > 0 {
            let between = height(place) + 0.5;
            let look = Look::new(GREY, Marker::Dot).width(0.5);
            panel.add(Series::line("", look, [(left, between), (right, between)]).unlisted().guide());
        }
    }
    if let Some(usual) = value(base) {
        panel.add(Series::line("usual inputs", BASE, [(usual, -0.5), (usual, count - 0.5)]).guide());
    }
    panel
}

/// What is said of a variant that did not fail.
fn never(variant: &Variant) -> String {
    format!("{}: {NEVER}", variant.label)
}

#[cfg(test)]
mod tests {
    use super::super::tests::folder;
    use super::*;

    const USUAL: Outcome =
        Outcome { failure_h: Some(8.40), rapid_h: Some(8.66), toe_m: Some(10.9), crest_m: Some(0.20) };

    fn variant(label: &str, failure_h: f64, toe_m: f64, crest_m: f64) -> Option<Variant> {
        let outcome = Outcome {
            failure_h: Some(failure_h),
            rapid_h: Some(failure_h + 0.3),
            toe_m: Some(toe_m),
            crest_m: Some(crest_m),
        };
        Some(Variant { label: label.to_owned(), outcome })
    }

    fn rows() -> Vec<Varied> {
        let row = |what: &str, low, high| Varied { what: what.to_owned(), low, high };
        let stood = Outcome { toe_m: Some(9.0), crest_m: Some(0.01), ..Outcome::default() };
        vec![
            row("edge of a cell", variant("0.2 m", 9.8, 11.3, 0.25), variant("0.8 m", 8.1, 10.6, 0.15)),
            row(
                "cohesion",
                variant("0.25 kPa", 7.1, 11.6, 0.3),
                Some(Variant { label: "1 kPa".into(), outcome: stood }),
            ),
            row("friction of the base", variant("6.5°", 7.9, 11.9, 0.33), variant("12°", 9.4, 10.0, 0.1)),
            row("moisture at the start", variant("0", 12.7, 10.8, 0.2), variant("0.7", 8.1, 10.9, 0.2)),
            row("level of the tank", variant("2.2 m", 8.9, 10.8, 0.19), None),
            row("particles per cell", variant("4", 8.3, 10.9, 0.21), variant("16", 8.35, 10.95, 0.2)),
        ]
    }

    #[test]
    fn bars_are_in_the_order_of_their_effect_and_one_that_stood_is_said() {
        let (folder, _own) = folder();
        let svg = write(&USUAL, &rows(), &folder).expect("a picture");
        for part in ["1 kPa: no failure", "moisture at the start", "usual: 8.4", "larger of two values"] {
            assert!(svg.contains(part), "{part}");
        }
        let order: Vec<String> = sorted(&USUAL, &rows()).iter().map(|r| r.what.clone()).collect();
        assert_eq!(order[..3], ["cohesion", "moisture at the start", "edge of a cell"]);
        let table = std::fs::read_to_string(folder.join("levee-sensitivity.csv")).expect("a table");
        assert!(table.contains("cohesion,high,1 kPa,,,9.0,0.01\n") && table.contains(",base,,8.4,8.66,10.9,0.2\n"));
        assert_eq!(table.lines().count(), 1 + 1 + 11);
    }

    #[test]
    fn texts_stand_beside_their_bars() {
        let mut rows = rows();
        let long = rows.iter_mut().flat_map(|row| [&mut row.low, &mut row.high]).flatten();
        long.for_each(|v| v.label += " from the eighth to the ninth hour");
        for panel in figure(&USUAL, &rows).panels {
            let (left, right) = panel.x.range.expect("a range");
            let frame = panel.share
                - 44.0
                - if panel.y.named.as_ref().is_some_and(Vec::is_empty) { 0.0 } else { widest(&rows) };
            let bars: Vec<_> = panel.series.iter().filter(|s| s.label.ends_with("of two values")).collect();
            for text in panel.series.iter().filter(|s| s.mark == Mark::Middle).flat_map(|s| &s.points) {
                let half = 0.5 * text_width(&text.note, TEXT) * (right - left) / frame;
                for bar in bars.iter().filter(|bar| bar.points[0].y == text.y) {
                    let (low, high) = bar.points.iter().fold((right, left), |(a, b), p| (a.min(p.x), b.max(p.x)));
                    assert!(text.x + half <= low || text.x - half >= high, "{}: {}", panel.x.label, text.note);
                }
            }
        }
    }

    #[test]
    fn nothing_changed_or_a_levee_that_stands_is_no_panic() {
        assert_eq!(figure(&USUAL, &[]).missing.len(), 1);
        let figure = figure(&Outcome::default(), &rows());
        assert!(figure.panels[0].title.ends_with("no failure"));
    }
}

//! Trend pages: every error, order and cost over the entries of the history, and the commit that moved it.

use std::fmt::Write as _;
use std::path::Path;

use super::collect::ERROR;
use super::compiled;
use super::history::{ENTRY, History};
use super::tables;
use super::work::TIME;
use crate::experiment::accepted::SOLVED;
use crate::experiment::number::Better;
use crate::page::{Block, Link, Page, Section, escaped};
use crate::report::numbers::short;
use crate::report::plots::axis::Axis;
use crate::report::plots::figure::{Figure, Mark, Panel, Point, Series};
use crate::report::plots::look;
use crate::report::{ReportError, unwritable};

/// Width and height of a line, in its own units.
const SIZE: [f64; 2] = [160.0, 28.0];

/// A page: file, title, and which quantities it shows.
type Shown = (&'static str, &'static str, fn(&str) -> bool);

/// All pages.
const PAGES: [Shown; 3] = [
    ("errors", "Errors", |q| !is_order(q) && !is_cost(q)),
    ("orders", "Orders of convergence", is_order),
    ("cost", "Cost", is_cost),
];

/// Links to them from the folder of a night.
pub fn links() -> [Link; 3] {
    PAGES.map(|(name, title, _)| Link::new(format!("{title} over the nights"), format!("../trends/{name}.html")))
}

fn is_order(quantity: &str) -> bool {
    quantity == "order" || quantity.ends_with("_order")
}

fn is_cost(quantity: &str) -> bool {
    let counts = ["steps", "point_steps", "factorisations", "solves", "rejected", "peak_bytes", TIME];
    counts.contains(&quantity) || quantity.starts_with("cost_for") || compiled::counted(quantity).is_some()
}

/// A number over the entries.
#[derive(Debug, Clone, PartialEq)]
pub struct Trend {
    /// Of what.
    pub case: String,
    /// Which number.
    pub quantity: String,
    /// First value.
    pub first: String,
    /// Value now.
    pub now: String,
    /// Last change, in words and in share; empty if there was none.
    pub change: String,
    /// Date of the entry of the last change; empty if there was none.
    pub moved_at: String,
    /// Its commit.
    pub commit: String,
    /// `good`, `bad` or nothing.
    pub mark: String,
    /// Points of the line.
    pub line: String,
    /// Where it changed: places of marks.
    pub marks: Vec<[String; 2]>,
    last: usize,
}

/// Writes `errors.html`, `orders.html`, `cost.html` and a CSV beside each.
///
/// # Errors
/// A file that cannot be written.
pub fn write(history: &History, folder: &Path) -> Result<(), ReportError> {
    for (name, title, shows) in PAGES {
        let mut trends: Vec<Trend> = history
            .numbers()
            .into_iter()
            .filter(|(case, quantity)| (*case, *quantity) != ENTRY && shows(quantity))
            .filter_map(|(case, quantity)| trend(history, case, quantity))
            .collect();
        // What moved last comes first.
        trends.sort_by(|a, b| b.last.cmp(&a.last).then_with(|| (&a.case, &a.quantity).cmp(&(&b.case, &b.quantity))));
        table(history, &trends, &folder.join(format!("{name}.csv")))?;
        let (moved, still): (Vec<Trend>, Vec<Trend>) = trends.into_iter().partition(|t| !t.moved_at.is_empty());
        let entry = |entry: Option<&String>| entry.cloned().unwrap_or_default();
        let (first, last) = (entry(history.entries.first()), entry(history.entries.last()));
        let lead =
            format!("{} runs, {first} to {last}. A dot marks a run that moved the number.", history.entries.len());
        let others = PAGES.iter().filter(|(other, ..)| *other != name);
        let links = others.map(|(other, title, _)| Link::new(*title, format!("{other}.html"))).collect();
        let off: Vec<String> = red(history).into_iter().map(|(entry, count)| format!("{entry}: {count}")).collect();
        Page::new(format!("{title} over the nights"))
            .lead(lead)
            .below("Nightly runs", "../index.html")
            .section(Section::new("moved", "Numbers that moved, the latest first").with(rows(&moved)))
            .section(Section::new("off", "Runs with numbers outside their tolerance").list(off))
            .section(
                Section::new("still", "Numbers that never moved").with(rows(&still)).files([format!("{name}.csv")]),
            )
            .beside(links)
            .write(&folder.join(format!("{name}.html")))?;
    }
    Ok(())
}

/// Numbers with their lines, as a table that can be filtered.
fn rows(trends: &[Trend]) -> Block {
    if trends.is_empty() {
        return Block::Text("None.".to_owned());
    }
    let [width, height] = SIZE;
    let mut html = "<div class=\"table filter\"><div class=\"box long\" role=\"group\" tabindex=\"0\" aria-label=\"Table of trends, \
                    scrollable\"><table><caption class=\"hidden\"><span>Trends</span></caption><thead><tr>"
        .to_owned();
    for head in ["case", "quantity", "last change", "over the runs", "first", "now", "by the run"] {
        html += &format!("<th scope=\"col\">{head}</th>");
    }
    html += "</tr></thead><tbody>\n";
    for t in trends {
        let marks: String = t.marks.iter().map(|[x, y]| format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"2.6\"/>")).collect();
        let svg = format!(
            "<svg class=\"trend\" role=\"img\" aria-label=\"{} {} over the runs\" width=\"{width}\" height=\"{height}\">\
             <polyline points=\"{}\"/>{marks}</svg>",
            escaped(&t.case),
            escaped(&t.quantity),
            t.line
        );
        let when =
            if t.moved_at.is_empty() { String::new() } else { format!("{}<small>{}</small>", t.moved_at, t.commit) };
        html += &format!(
            "<tr><th scope=\"row\">{}</th><td>{}</td><td class=\"{}\">{}</td><td>{svg}</td><td>{}</td><td>{}</td><td>{when}</td></tr>\n",
            escaped(&t.case),
            escaped(&t.quantity),
            if t.mark.is_empty() { "plain" } else { &t.mark },
            escaped(&t.change),
            t.first,
            t.now
        );
    }
    Block::Html(html + "</tbody></table></div></div>")
}

/// Entries at which numbers were off, the last ones first.
fn red(history: &History) -> Vec<(String, String)> {
    let off = history.steps(ENTRY.0, ENTRY.1).iter().rev().filter(|(_, moved)| *moved > 0.0).take(12);
    off.map(|(entry, moved)| (history.entries[*entry].clone(), format!("{moved:.0}"))).collect()
}

/// Every change of the numbers of a page.
fn table(history: &History, trends: &[Trend], path: &Path) -> Result<(), ReportError> {
    let mut writer = csv::Writer::from_path(path).map_err(|e| unwritable(path, e))?;
    writer.write_record(["case", "quantity", "entry", "value"]).map_err(|e| unwritable(path, e))?;
    for t in trends {
        for (entry, value) in history.steps(&t.case, &t.quantity) {
            let value = if value.is_nan() { String::new() } else { format!("{value:?}") };
            let row = [&t.case, &t.quantity, &history.entries[*entry], &value];
            writer.write_record(row).map_err(|e| unwritable(path, e))?;
        }
    }
    writer.flush().map_err(|e| unwritable(path, e))
}

fn trend(history: &History, case: &str, quantity: &str) -> Option<Trend> {
    let steps = history.steps(case, quantity);
    let (first, last) = (steps.first()?, steps.last()?);
    let shown = |value: f64| match value {
        v if v.is_nan() => "–".to_owned(),
        v if v.fract() == 0.0 && v.abs() < 1e15 => format!("{v:.0}"),
        v => short(v, 4),
    };
    let (mut change, mut moved_at, mut commit, mut mark) = (String::new(), String::new(), String::new(), "");
    if let [.., (_, was), (entry, is)] = steps {
        let direction = Better::of(quantity).direction(*was, *is);
        let word = direction.word();
        mark = direction.mark();
        change = if was.is_finite() && is.is_finite() && *was != 0.0 {
            format!("{word}, {:+.2} %", 100.0 * (is / was - 1.0))
        } else {
            word.to_owned()
        };
        let (date, of) = history.entries[*entry].split_once(' ').unwrap_or_default();
        moved_at = tables::date(date);
        of.clone_into(&mut commit);
    }
    let (line, marks) = line(steps, history.entries.len());
    Some(Trend {
        case: case.to_owned(),
        quantity: quantity.to_owned(),
        first: shown(first.1),
        now: shown(last.1),
        change,
        moved_at,
        commit,
        mark: mark.to_owned(),
        line,
        marks,
        last: last.0,
    })
}

/// File name of the figure of the nights.
pub const OVER_NIGHTS: &str = "over-nights";

/// Kinds of numbers whose mean change is drawn: label, which quantities, smallest value that counts.
type Kind = (&'static str, fn(&str) -> bool, f64);

/// Errors of exact solutions, above the round-off of linear solves.
const ERRORS: [Kind; 3] = [
    ("accuracy study", |q| q == ERROR, SOLVED),
    ("sweeps", |q| q == "largest_error", SOLVED),
    ("verification suite", |q| q == "error", SOLVED),
];

/// Costs.
const COSTS: [Kind; 3] = [
    ("instructions", |q| compiled::counted(q) == Some(compiled::INSTRUCTIONS), 0.0),
    ("allocations", |q| compiled::counted(q) == Some(compiled::ALLOCATIONS), 0.0),
    ("CPU time", |q| q == TIME, 0.0),
];

/// Errors and costs over the nights, as mean changes since the first night; nothing with fewer than two nights.
pub fn figure(history: &History) -> Option<Figure> {
    let nights = history.entries.len();
    if nights < 2 {
        return None;
    }
    let dates: Vec<&str> = history.entries.iter().map(|entry| entry.get(5..10).unwrap_or_default()).collect();
    let every = nights.div_ceil(6);
    let ticks: Vec<_> = (0..nights).step_by(every).map(|night| (night as f64 + 1.0, dates[night].to_owned())).collect();
    let mut panels = Vec::new();
    for (title, kinds, looks) in [("Errors", ERRORS, [0, 1, 2]), ("Cost", COSTS, [3, 4, 5])] {
        let x = Axis::linear("night", "night").range(0.7, nights as f64 + 0.3).named(ticks.clone());
        let mut panel = Panel::new(title, x, Axis::linear("change since the first night (%)", "change_percent"));
        for (kind, place) in kinds.iter().copied().zip(looks) {
            let points =
                (0..nights).filter_map(|night| Some(Point::new(night as f64 + 1.0, change(history, kind, night)?)));
            // Lines that coincide are seen inside one another.
            let inside = (place % kinds.len()) as f64;
            let look = look::nth(place).radius(6.5 - 1.8 * inside).width(3.2 - inside);
            panel.add(Series::new(kind.0, look, Mark::LinePoints, points));
        }
        // Numbers that do not move lie on one line, not in their round-off.
        let (low, high) = panel.all_y().into_iter().fold((-1.0_f64, 1.0_f64), |(l, h), y| (l.min(y), h.max(y)));
        panel.y.range = Some((1.1 * low, 1.1 * high));
        if !panel.is_empty() {
            panels.push(panel);
        }
    }
    let caption = "Geometric mean over all numbers of a kind, each as a ratio to its first night. CPU time follows the load of the machine.";
    (!panels.is_empty()).then(|| Figure {
        name: OVER_NIGHTS,
        title: format!("Errors and costs of {nights} nights"),
        caption: caption.to_owned(),
        height: 240.0,
        panels,
        missing: Vec::new(),
    })
}

/// Mean change of the numbers of a kind at a night since the first night of each, in per cent.
fn change(history: &History, (_, is, least): Kind, night: usize) -> Option<f64> {
    let own = history.numbers().into_iter().filter(|(_, quantity)| is(quantity));
    let ratios = own.filter_map(|(case, quantity)| {
        let steps = history.steps(case, quantity);
        let first = steps.first()?.1;
        let now = steps.iter().rev().find(|(entry, _)| *entry <= night)?.1;
        (first > least && now > 0.0).then(|| (now / first).ln())
    });
    let logarithms: Vec<f64> = ratios.collect();
    let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
    (!logarithms.is_empty()).then(|| 100.0 * mean.exp_m1())
}

/// The steps of a number as points of a line, and the places where it changed.
fn line(steps: &[(usize, f64)], entries: usize) -> (String, Vec<[String; 2]>) {
    let finite = || steps.iter().map(|(_, v)| *v).filter(|v| v.is_finite());
    let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let [width, height] = SIZE;
    let x = |entry: usize| 3.0 + (width - 6.0) * entry as f64 / (entries.max(2) - 1) as f64;
    let y = |value: f64| {
        let share = if high > low { (value - low) / (high - low) } else { 0.5 };
        height - 4.0 - (height - 8.0) * share
    };
    let (mut points, mut marks) = (String::new(), Vec::new());
    for (at, (entry, value)) in steps.iter().enumerate().filter(|(_, (_, value))| value.is_finite()) {
        let until = steps.get(at + 1).map_or(entries.saturating_sub(1), |next| next.0);
        let _ = write!(points, "{:.1},{:.1} {:.1},{:.1} ", x(*entry), y(*value), x(until), y(*value));
        if at > 0 {
            marks.push([format!("{:.1}", x(*entry)), format!("{:.1}", y(*value))]);
        }
    }
    (points.trim_end().to_owned(), marks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::number::{Label, Number, Tolerance};

    #[test]
    fn the_commit_that_moved_a_number_is_named() {
        let mut history = History::default();
        for (number, value) in [1.0, 1.0, 3.0, 3.0].into_iter().enumerate() {
            let tolerance = Tolerance::relative(0.0);
            let m = |case: &str, quantity: &str, value| Number::new(case, quantity, Label::Verified, value, tolerance);
            let all = [m("a", "error", value), m("b", "error", 5.0), m("b", "order", 2.0), m("b", "solves", value)];
            history.note(&format!("2026-01-0{} commit{number}", number + 1), &all);
        }
        let folder = tempfile::tempdir().expect("a folder");
        write(&history, folder.path()).expect("written");
        let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a file");
        let errors = text("errors.html");
        assert!(errors.contains("2026-01-03<small>commit2</small>") && errors.contains("worse, +200.00 %"));
        assert!(text("errors.csv").contains("a,error,2026-01-03 commit2,3.0"));
        assert!(!text("orders.html").contains("commit2") && text("cost.html").contains("solves"));
        let (points, marks) = line(history.steps("a", "error"), 4);
        assert_eq!(points, "3.0,24.0 105.7,24.0 105.7,4.0 157.0,4.0");
        assert_eq!(marks, [["105.7".to_owned(), "4.0".to_owned()]]);
    }
}

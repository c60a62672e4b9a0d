//! A figure as a page shows it: a drawing whose series are groups, and the values of its points for a pointer that is held over them.

use serde_json::{Value, json};

use super::svg;
use crate::report::plots;
use crate::report::plots::axis::{Axis, Scale};
use crate::report::plots::canvas::DrawError;
use crate::report::plots::figure::{Figure, Mark, Panel, Series};

/// Most points of a series that are offered to the pointer.
const POINTS: usize = 160;
/// Most series of a panel that are.
const SERIES: usize = 40;

/// A figure, drawn for a page.
#[derive(Debug, Clone)]
pub struct Picture {
    /// The drawing.
    pub svg: String,
    /// Values of its points, as JSON.
    pub points: String,
}

impl Picture {
    /// Draws a figure.
    ///
    /// # Errors
    /// What the drawing backend says.
    pub fn of(figure: &Figure) -> Result<Self, DrawError> {
        let (svg, frames) = svg::inline(figure, &plots::marked_svg(figure)?);
        let panels = frames.iter().filter_map(|(number, frame)| Some((figure.panels.get(*number)?, frame)));
        let panels: Vec<Value> = panels.map(|(panel, frame)| values(panel, frame)).collect();
        // No text may end the element that holds it.
        Ok(Self { svg, points: Value::from(panels).to_string().replace("</", "<\\/") })
    }
}

/// What is seen in a figure, for those who cannot see it: its title and the first sentence of its caption.
pub fn alternative(figure: &Figure) -> String {
    let end = figure
        .caption
        .match_indices(['.', ';'])
        .map(|(at, _)| at)
        .find(|at| figure.caption[at + 1..].chars().next().is_none_or(char::is_whitespace));
    let first = end.map_or(figure.caption.as_str(), |end| &figure.caption[..end]);
    if first.is_empty() { figure.title.clone() } else { format!("{}. {first}.", figure.title) }
}

fn values(panel: &Panel, frame: &[f64; 4]) -> Value {
    let panel = panel.clone().fitted();
    let known = panel.series.iter().filter(|s| {
        s.is_data && !s.label.is_empty() && !matches!(s.mark, Mark::Text | Mark::Middle | Mark::Area | Mark::Arrows)
    });
    let series: Vec<Value> = known.take(SERIES).map(|series| of_series(series, &panel)).collect();
    json!({ "f": frame, "x": of_axis(&panel.x), "y": of_axis(&panel.y), "s": series })
}

fn of_axis(axis: &Axis) -> Value {
    let (start, end) = axis.range.unwrap_or((0.0, 1.0));
    let named: Vec<Value> = axis.named.iter().flatten().map(|(place, text)| json!([digits(*place), text])).collect();
    json!({ "a": digits(start), "b": digits(end), "l": axis.scale == Scale::Log, "n": axis.label, "t": named })
}

fn of_series(series: &Series, panel: &Panel) -> Value {
    let seen: Vec<_> = series.points.iter().filter(|p| panel.x.takes(p.x) && panel.y.takes(p.y)).collect();
    let every = seen.len().div_ceil(POINTS).max(1);
    let last = seen.len().saturating_sub(1);
    let some = seen.iter().enumerate().filter(|(k, _)| k % every == 0 || *k == last);
    let points: Vec<Value> = some.flat_map(|(_, p)| [digits(p.x), digits(p.y)]).collect();
    let stacked = matches!(series.mark, Mark::Bars | Mark::Range);
    let from: Vec<Value> = if stacked { seen.iter().map(|p| digits(p.from)).collect() } else { Vec::new() };
    json!({ "n": series.label, "p": points, "o": from })
}

/// A number with five significant digits.
fn digits(value: f64) -> Value {
    let rounded: f64 = format!("{value:.4e}").parse().unwrap_or(value);
    if rounded.fract() == 0.0 && rounded.abs() < 1e9 { json!(rounded as i64) } else { json!(rounded) }
}

//! The legend: below the panels, in rows.

use plotters::prelude::DrawingBackend;

use super::canvas::{Canvas, Drawn, LEFT, Rect, text_width};
use super::draw::{self, TEXT, WIDTH};
use super::figure::{Figure, Mark, Series};
use super::look::{BLACK, Look};

/// One line of a legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    label: String,
    look: Look,
    mark: Mark,
    open: bool,
}

impl Entry {
    /// Its name.
    pub fn label(&self) -> &str {
        &self.label
    }
}

/// Length of the sample of a line, px.
const SAMPLE: f64 = 30.0;
const ROW: f64 = 20.0;
const GAP: f64 = 20.0;

/// The entries of a picture, each label once: series of which something lies within the axes.
pub fn entries(figure: &Figure) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    let drawn = |s: &Series| !matches!(s.mark, Mark::Arrows | Mark::Text | Mark::Middle);
    let listed = |s: &&Series| s.in_legend && !s.label.is_empty() && drawn(s);
    let seen = figure.panels.iter().flat_map(|p| p.series.iter().filter(listed).filter(|s| p.shows(s)));
    for series in seen {
        if let Some(known) = entries.iter_mut().find(|e| e.label == series.label) {
            known.look.radius = known.look.radius.max(series.look.radius);
            continue;
        }
        // A series of open markers only is shown by an open one.
        let open = series.points.iter().all(|p| p.open);
        entries.push(Entry { label: series.label.clone(), look: series.look, mark: series.mark, open });
    }
    entries
}

fn width(entry: &Entry) -> f64 {
    SAMPLE + 6.0 + text_width(&entry.label, TEXT) + GAP
}

/// Entries in rows that fit the picture.
fn rows(entries: &[Entry]) -> Vec<Vec<&Entry>> {
    let mut rows: Vec<Vec<&Entry>> = Vec::new();
    let mut filled = f64::INFINITY;
    for entry in entries {
        if filled + width(entry) > WIDTH - 30.0 {
            rows.push(Vec::new());
            filled = 0.0;
        }
        filled += width(entry);
        if let Some(row) = rows.last_mut() {
            row.push(entry);
        }
    }
    rows
}

/// Height of a legend, px.
pub fn height(entries: &[Entry]) -> f64 {
    ROW * rows(entries).len() as f64 + 6.0
}

/// Draws a legend whose upper edge is at `top`, px.
///
/// # Errors
/// What the backend says.
pub fn draw<DB: DrawingBackend>(canvas: &Canvas<DB>, entries: &[Entry], top: f64) -> Drawn {
    let mut y = top + 0.5 * ROW + 3.0;
    canvas.mark("legend")?;
    for row in rows(entries) {
        let length: f64 = row.iter().map(|e| width(e)).sum::<f64>() - GAP;
        let mut x = 0.5 * (WIDTH - length);
        for entry in row {
            let (middle, end) = ((x + 0.5 * SAMPLE, y), (x + SAMPLE, y));
            canvas.mark(&format!("entry {}", entry.label))?;
            if matches!(entry.mark, Mark::Line | Mark::LinePoints) {
                canvas.line(&[(x, y), end], entry.look)?;
            }
            match entry.mark {
                Mark::Points | Mark::LinePoints => canvas.marker(middle, entry.look, entry.open)?,
                Mark::Bars => {
                    canvas.bar(Rect { left: x + 6.0, top: y - 7.0, right: end.0, bottom: y + 7.0 }, entry.look)?;
                }
                Mark::Area => {
                    let (top, bottom) = (y - 6.0, y + 6.0);
                    canvas
                        .area(&[(x + 4.0, top), (end.0, top), (end.0, bottom), (x + 4.0, bottom)], entry.look.colour)?;
                }
                Mark::Range => draw::range(canvas, (middle.0, y - 7.0), y + 7.0, entry.look)?,
                _ => {}
            }
            canvas.text(&entry.label, (end.0 + 6.0, y), TEXT, BLACK, LEFT, false)?;
            canvas.mark("end")?;
            x += width(entry);
        }
        y += ROW;
    }
    Ok(())
}

//! Pictures of a levee through which water seeps until its slope fails. They take plain data and know nothing of how
//! it was computed.
//!
//! # Reading order
//! 1. [`Site`]: what all pictures share. [`map`]: soil, water, outline and colour bar of one frame.
//! 2. Of frames: [`initial`] (the paper's Fig. 6), [`changes`] (Fig. 7), [`points`] (Fig. 8).
//! 3. Of histories: [`paths`] (Fig. 9), [`histories`]; of other tables: [`safety`], [`tornado`]; of
//!    two ways to solve the same problem: [`operators`].
//!
//! Every room has a `figure` and a `write`, which returns the text of the SVG and leaves SVG, PNG and CSV in a folder; [`changes`],
//! with thousands of particles in a picture, leaves PNG and CSV.

pub mod changes;
pub mod failing;
pub mod histories;
pub mod initial;
pub mod map;
pub mod operators;
pub mod paths;
pub mod points;
pub mod probability;
pub mod safety;
pub mod tornado;

use super::axis::Axis;
use super::canvas::text_width;
use super::draw::TEXT;
use super::figure::{Mark, Panel, Point, Series};
use super::look::{BLACK, Look, Marker, WHITE};

/// What stays the same in all pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Site {
    /// Corners of the soil at the start, m.
    pub outline: Vec<[f64; 2]>,
    /// Level of the water that stands against x = 0, m above the base.
    pub tank_m: f64,
}

impl Site {
    /// The outline as a closed line, m.
    pub(crate) fn closed(&self) -> impl Iterator<Item = (f64, f64)> {
        self.outline.iter().chain(self.outline.first()).map(|x| (x[0], x[1]))
    }

    /// Height of the crest, m.
    fn height(&self) -> f64 {
        self.outline.iter().map(|x| x[1]).fold(0.0, f64::max)
    }

    /// Place of the toe, m.
    fn toe(&self) -> f64 {
        self.outline.iter().map(|x| x[0]).fold(0.0, f64::max)
    }

    /// Where the crest ends and the slope begins, m.
    fn shoulder(&self) -> f64 {
        let high = self.height();
        self.outline.iter().filter(|x| x[1] == high).map(|x| x[0]).fold(0.0, f64::max)
    }
}

/// Something that happened, for a line across histories.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Short name, for the line: `E1`.
    pub name: String,
    /// What it is, for the caption: `the toe fails`.
    pub words: String,
    /// When, s on the reader's clock.
    pub time_s: f64,
}

/// A time for readers: `8 h 39 min 36 s`, with tenths of a second where they matter.
pub fn clock(time_s: f64) -> String {
    let tenths = (10.0 * time_s).round() as i64;
    let (hours, minutes, rest) = (tenths / 36_000, tenths / 600 % 60, tenths % 600);
    let seconds = if rest % 10 == 0 { (rest / 10).to_string() } else { format!("{}.{}", rest / 10, rest % 10) };
    format!("{hours} h {minutes:02} min {seconds} s")
}

/// What events are, for a caption.
fn said(events: &[Event]) -> String {
    let words = events.iter().map(|e| format!("{}: {}, {}", e.name, e.words, clock(e.time_s)));
    words.collect::<Vec<_>>().join("; ")
}

/// An axis without ticks and name.
fn bare(start: f64, end: f64) -> Axis {
    Axis::linear("", "").range(start, end).named(Vec::new())
}

/// A text with its middle at a place, on white so that no line runs through it. `unit` is the length of one unit of
/// both axes, px.
fn label(panel: &mut Panel, (x, y): (f64, f64), text: impl Into<String>, unit: (f64, f64)) {
    let text = text.into();
    let (half, high) = ((0.5 * text_width(&text, TEXT) + 2.0) / unit.0, 0.55 * TEXT / unit.1);
    let corners = [(x - half, y - high), (x + half, y - high), (x + half, y + high), (x - half, y + high)];
    let paper = Series::new("", Look::new(WHITE, Marker::Dot), Mark::Area, corners.map(|(x, y)| Point::new(x, y)));
    panel.add(paper.unlisted().guide());
    let word = Series::new("", Look::new(BLACK, Marker::Dot), Mark::Middle, [Point::new(x, y).note(text)]);
    panel.add(word.unlisted().guide());
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::frames::made_up::{self, FAILURE_S};

    /// The made-up levee's.
    pub fn site() -> Site {
        Site { outline: made_up::OUTLINE.to_vec(), tank_m: 2.3 }
    }

    /// Where pictures of tests go: kept where the variable says, to be looked at.
    pub fn folder() -> (PathBuf, tempfile::TempDir) {
        let own = tempfile::tempdir().expect("a folder");
        (std::env::var_os("MPM_KEEP_PICTURES").map_or(own.path().to_owned(), Into::into), own)
    }

    /// Three of them within three minutes.
    pub fn events() -> Vec<Event> {
        let event = |name: &str, words: &str, time_s: f64| Event { name: name.into(), words: words.into(), time_s };
        vec![
            event("front at toe", "water reaches the toe", 29_000.0),
            event("E1", "the toe fails", FAILURE_S - 130.0),
            event("E2", "failure starts", FAILURE_S),
            event("E3", "rapid failure", FAILURE_S + 3.1),
        ]
    }

    #[test]
    fn times_read_well() {
        assert_eq!(clock(31_176.0), "8 h 39 min 36 s");
        assert_eq!(clock(31_176.26), "8 h 39 min 36.3 s");
        assert_eq!(clock(21_599.99), "6 h 00 min 0 s");
    }

    #[test]
    fn a_site_is_measured_from_its_outline() {
        let site = site();
        assert_eq!((site.height(), site.toe(), site.shoulder(), site.closed().count()), (3.0, 9.0, 3.0, 5));
    }
}

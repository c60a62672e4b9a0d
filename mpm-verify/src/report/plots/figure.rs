//! What a picture is made of: panels side by side, each with two axes and some series. Drawn by [`super::draw`] and
//! written as numbers by [`super::write`].

use super::axis::Axis;
use super::canvas::Rect;
use super::look::Look;

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// File name without ending.
    pub name: &'static str,
    /// What stands above it.
    pub title: String,
    /// What the reader should see, and what is left out.
    pub caption: String,
    /// Height of the panels, px of a picture that is 900 px wide.
    pub height: f64,
    /// Panels from left to right, row by row from the top.
    pub panels: Vec<Panel>,
    /// Data that should be in the picture and are not.
    pub missing: Vec<String>,
}

/// A pair of axes with series.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// What stands above it; also its name in the CSV.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// What is drawn, from back to front.
    pub series: Vec<Series>,
    /// Share of the width, compared with the other panels.
    pub share: f64,
    /// Whether one unit is equally long on both axes.
    pub equal: bool,
    /// Row it stands in, 0 at the top.
    pub row: usize,
    /// Height of its frame, px; that of the picture if not given.
    pub height: Option<f64>,
    /// Whether it only keeps its place free.
    pub blank: bool,
}

impl Figure {
    /// Whether so many panels stand side by side that a narrow screen shows one after the other.
    pub fn is_wide(&self) -> bool {
        self.panels.iter().any(|panel| self.panels.iter().filter(|other| other.row == panel.row).count() > 2)
    }
}

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line through them.
    Line,
    /// Markers.
    Points,
    /// Both.
    LinePoints,
    /// Bars from `from` to `y`.
    Bars,
    /// Arrows down from `from` to `y`.
    Arrows,
    /// Upright bars with ends from `from` to `y`: where a value may be.
    Range,
    /// The polygon between them, filled.
    Area,
    /// The same for every four of them.
    Tiles,
    /// The points' notes and nothing else, from the point on.
    Text,
    /// The same with their middle at the point.
    Middle,
}

/// Points that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend and the CSV.
    pub label: String,
    /// How it looks.
    pub look: Look,
    /// How points are drawn.
    pub mark: Mark,
    /// The points.
    pub points: Vec<Point>,
    /// Whether it stands in the legend.
    pub in_legend: bool,
    /// Whether it is data: kept in the CSV, and fitted by the axes.
    pub is_data: bool,
}

/// A point.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Place on the horizontal axis.
    pub x: f64,
    /// Place on the vertical axis.
    pub y: f64,
    /// Where its bar or arrow begins.
    pub from: f64,
    /// Whether its marker is open.
    pub open: bool,
    /// Text beside it.
    pub note: String,
}

impl Point {
    /// A point with a filled marker.
    pub fn new(x: f64, y: f64) -> Self {
        Self { x, y, from: 0.0, open: false, note: String::new() }
    }

    /// With an open marker if so.
    pub fn open(self, open: bool) -> Self {
        Self { open, ..self }
    }

    /// With the beginning of its bar or arrow.
    pub fn from(self, from: f64) -> Self {
        Self { from, ..self }
    }

    /// With a text.
    pub fn note(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }
}

impl Series {
    /// Data that stand in the legend.
    pub fn new(label: impl Into<String>, look: Look, mark: Mark, points: impl IntoIterator<Item = Point>) -> Self {
        let points = points.into_iter().collect();
        Self { label: label.into(), look, mark, points, in_legend: true, is_data: true }
    }

    /// A line through (x, y) pairs.
    pub fn line(label: impl Into<String>, look: Look, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::new(label, look, Mark::Line, points.into_iter().map(|(x, y)| Point::new(x, y)))
    }

    /// Not in the legend.
    pub fn unlisted(self) -> Self {
        Self { in_legend: false, ..self }
    }

    /// A guide for the eye: not in the CSV, and no axis makes room for it.
    pub fn guide(self) -> Self {
        Self { is_data: false, ..self }
    }
}

/// Length of a line or bar, as a share of an axis, below which it is no more than a dot.
const LEAST_LENGTH: f64 = 2e-3;

impl Panel {
    /// A panel without series.
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        Self {
            title: title.to_owned(),
            x,
            y,
            series: Vec::new(),
            share: 1.0,
            equal: false,
            row: 0,
            height: None,
            blank: false,
        }
    }

    /// A place kept free.
    pub fn blank() -> Self {
        Self { blank: true, ..Self::new("", Axis::linear("", ""), Axis::linear("", "")) }
    }

    /// With one more series, unless it has no points.
    pub fn with(mut self, series: Series) -> Self {
        self.add(series);
        self
    }

    /// Adds a series, unless it has no points.
    pub fn add(&mut self, series: Series) {
        if !series.points.is_empty() {
            self.series.push(series);
        }
    }

    /// Whether there is nothing to see.
    pub fn is_empty(&self) -> bool {
        let seen = |p: &Point| self.x.takes(p.x) && self.y.takes(p.y);
        !self.series.iter().any(|s| s.is_data && s.points.iter().any(seen))
    }

    /// All places of its data on one axis.
    fn places(&self, of: fn(&Series, &Point) -> [f64; 2]) -> Vec<f64> {
        self.series.iter().filter(|s| s.is_data).flat_map(|s| s.points.iter().flat_map(move |p| of(s, p))).collect()
    }

    /// Places on the horizontal axis.
    pub fn all_x(&self) -> Vec<f64> {
        self.places(|_, p| [p.x; 2])
    }

    /// Places on the vertical axis, with the beginnings of bars and arrows.
    pub fn all_y(&self) -> Vec<f64> {
        self.places(
            |s, p| if matches!(s.mark, Mark::Bars | Mark::Arrows | Mark::Range) { [p.from, p.y] } else { [p.y; 2] },
        )
    }

    /// With ranges found for the axes that have none.
    pub fn fitted(self) -> Self {
        let [x, y] = self.fitted_axes();
        Self { x, y, ..self }
    }

    fn fitted_axes(&self) -> [Axis; 2] {
        let (mut x, mut y) = (self.x.clone(), self.y.clone());
        x.fit(self.all_x().into_iter());
        y.fit(self.all_y().into_iter());
        [x, y]
    }

    /// Whether some point of a series, or some part of its line, can be seen within the axes. Filled areas count as seen.
    pub fn shows(&self, series: &Series) -> bool {
        let [x, y] = self.fitted_axes();
        let place = |p: &Point| (x.takes(p.x) && y.takes(p.y)).then(|| (x.place(p.x), y.place(p.y)));
        let frame = Rect { left: 0.0, top: 0.0, right: 1.0, bottom: 1.0 };
        let is_within = |(x, y): (f64, f64)| (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y);
        let within = |pair: &[Point]| {
            let (a, b) = place(&pair[0]).zip(place(&pair[1])).and_then(|(a, b)| frame.clip(a, b))?;
            Some((b.0 - a.0).hypot(b.1 - a.1))
        };
        let lengths = || series.points.windows(2).filter_map(within);
        match series.mark {
            Mark::Line => lengths().sum::<f64>() > LEAST_LENGTH,
            Mark::LinePoints => lengths().next().is_some() || series.points.iter().filter_map(place).any(is_within),
            Mark::Points => series.points.iter().filter_map(place).any(is_within),
            // A bar of no height is not drawn.
            Mark::Bars | Mark::Range | Mark::Arrows => {
                series.points.iter().any(|p| y.takes(p.y) && (y.place(p.y) - y.place(p.from)).abs() > LEAST_LENGTH)
            }
            _ => !series.points.is_empty(),
        }
    }
}

/// Gives all panels the same horizontal range.
pub fn share_x(panels: &mut [Panel]) {
    let all: Vec<f64> = panels.iter().flat_map(Panel::all_x).collect();
    for panel in panels {
        panel.x.fit(all.iter().copied());
    }
}

/// Gives all panels the same vertical range, so that they can be compared by eye.
pub fn share_y(panels: &mut [Panel]) {
    let all: Vec<f64> = panels.iter().flat_map(Panel::all_y).collect();
    for panel in panels {
        panel.y.fit(all.iter().copied());
    }
}

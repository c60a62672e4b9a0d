//! Colours, dashes and markers. Every series differs from its neighbours in two of them, so that pictures can be read
//! in black and white and by colour-blind readers (palette after Okabe and Ito, 2008).

use plotters::style::RGBColor;

/// Black.
pub const BLACK: RGBColor = RGBColor(0, 0, 0);
/// For frames and text that stands back.
pub const GREY: RGBColor = RGBColor(110, 110, 110);
/// For grid lines.
pub const PALE: RGBColor = RGBColor(222, 222, 222);
/// White.
pub const WHITE: RGBColor = RGBColor(255, 255, 255);
/// Blue.
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
/// Vermilion.
pub const RED: RGBColor = RGBColor(213, 94, 0);
/// Bluish green.
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
/// Reddish purple.
pub const PURPLE: RGBColor = RGBColor(190, 90, 150);
/// Orange.
pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
/// Sky blue.
pub const SKY: RGBColor = RGBColor(86, 180, 233);

/// For soil that carries no colour of its own.
pub const SAND: RGBColor = RGBColor(221, 200, 158);
/// For standing water.
pub const POOL: RGBColor = RGBColor(198, 224, 243);

/// How a line is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// Not at all.
    Solid,
    /// Into dashes.
    Dashed,
    /// Into dots.
    Dotted,
    /// Into dashes and dots.
    DashDot,
}

impl Dash {
    /// Lengths of drawn and left-out parts, px.
    pub fn pattern(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[7.0, 4.0],
            Self::Dotted => &[1.5, 3.0],
            Self::DashDot => &[8.0, 3.0, 1.5, 3.0],
        }
    }
}

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Marker {
    Circle,
    Square,
    Up,
    Diamond,
    Down,
    Star,
    Dot,
    Right,
    /// A square without an edge, for clouds of thousands.
    Box,
}

/// How the inside of a bar is drawn over its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Hatch {
    None,
    Rising,
    Falling,
    Crossed,
    Level,
    Upright,
    Grid,
}

/// How a series looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Colour of lines, points and bars.
    pub colour: RGBColor,
    /// Width of lines, px.
    pub width: f64,
    /// How lines are broken.
    pub dash: Dash,
    /// Shape of points.
    pub marker: Marker,
    /// Radius of points, px.
    pub radius: f64,
    /// Pattern of bars.
    pub hatch: Hatch,
}

impl Look {
    /// A look of one colour and one marker.
    pub const fn new(colour: RGBColor, marker: Marker) -> Self {
        Self { colour, width: 1.6, dash: Dash::Solid, marker, radius: 4.0, hatch: Hatch::None }
    }

    /// With another dash.
    pub const fn dash(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }

    /// With another width of lines, px.
    pub const fn width(self, width: f64) -> Self {
        Self { width, ..self }
    }

    /// With another radius of points, px.
    pub const fn radius(self, radius: f64) -> Self {
        Self { radius, ..self }
    }

    /// With another pattern of bars.
    pub const fn hatch(self, hatch: Hatch) -> Self {
        Self { hatch, ..self }
    }
}

/// Comparison for series that stand side by side (meshes, time factors, particles per cell).
const ROW: [Look; 6] = [
    Look::new(BLUE, Marker::Circle),
    Look::new(RED, Marker::Square),
    Look::new(GREEN, Marker::Up),
    Look::new(PURPLE, Marker::Diamond),
    Look::new(ORANGE, Marker::Down),
    Look::new(BLACK, Marker::Star),
];

/// The look of the series at a place in a row; dashed from the second round on.
pub fn nth(place: usize) -> Look {
    let look = ROW[place % ROW.len()];
    if place < ROW.len() { look } else { look.dash(Dash::Dashed) }
}

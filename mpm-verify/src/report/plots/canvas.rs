//! Lines, markers, bars and text on any backend, in px of a picture 900 px wide.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::look::{Hatch, Look, Marker};

/// Why a picture could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum DrawError {
    /// The font that the program carries.
    #[error("the font of the program cannot be read")]
    Font,
    /// What a backend says.
    #[error("{0}")]
    Backend(String),
}

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for DrawError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self::Backend(error.to_string())
    }
}

/// What comes of drawing.
pub type Drawn = Result<(), DrawError>;

/// A place, px from the left and from the top.
pub type Spot = (f64, f64);

/// A rectangle, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Right edge.
    pub right: f64,
    /// Lower edge.
    pub bottom: f64,
}

impl Rect {
    /// The part of a segment inside, by Liang and Barsky's algorithm.
    pub fn clip(&self, a: Spot, b: Spot) -> Option<(Spot, Spot)> {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        let sides = [(-dx, a.0 - self.left), (dx, self.right - a.0), (-dy, a.1 - self.top), (dy, self.bottom - a.1)];
        for (rate, distance) in sides {
            if rate == 0.0 {
                if distance < 0.0 {
                    return None;
                }
            } else if rate < 0.0 {
                enter = enter.max(distance / rate);
            } else {
                leave = leave.min(distance / rate);
            }
        }
        let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
        (enter < leave).then(|| (at(enter), at(leave)))
    }
}

/// How a backend takes the size of text and where it puts it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lettering {
    /// What the backend calls the size of letters of 1 px.
    pub size: f64,
    /// How far text must be moved down to stand with the middle of its letters at its place, in sizes.
    pub drop: f64,
    /// Whether marks are drawn between series, as texts that [`crate::page::svg`] turns into groups.
    pub marks: bool,
}

/// The SVG backend divides sizes by 1.24 and centres on the small letters.
pub const SVG_LETTERS: Lettering = Lettering { size: 1.24, drop: 0.06, marks: false };
/// The bitmap backend takes the height of a line, 1.164 in DejaVu Sans, and places text too high.
pub const BITMAP_LETTERS: Lettering = Lettering { size: 1.164, drop: 0.22, marks: false };

/// Width of a text at a size, px.
pub fn text_width(text: &str, size: f64) -> f64 {
    // Whoever measures first does so in the font that is drawn.
    super::ready();
    let font = FontDesc::from((FontFamily::SansSerif, 100.0 * BITMAP_LETTERS.size));
    f64::from(font.box_size(text).map_or(0, |(width, _)| width)) * size / 100.0
}

/// A drawing area with a scale.
pub struct Canvas<'a, DB: DrawingBackend> {
    area: &'a DrawingArea<DB, Shift>,
    scale: f64,
    letters: Lettering,
}

impl<'a, DB: DrawingBackend> Canvas<'a, DB> {
    /// Draws on `area` with `scale` of its pixels to one px.
    pub fn new(area: &'a DrawingArea<DB, Shift>, scale: f64, letters: Lettering) -> Self {
        Self { area, scale, letters }
    }

    /// Whether marks are drawn.
    pub fn takes_marks(&self) -> bool {
        self.letters.marks
    }

    /// A mark for the page that the drawing becomes part of; nothing where none are drawn.
    pub fn mark(&self, words: &str) -> Drawn {
        if !self.letters.marks {
            return Ok(());
        }
        let style = TextStyle::from(FontDesc::new(FontFamily::SansSerif, 10.0, FontStyle::Normal));
        Ok(self.area.draw_text(&format!("{MARK}{words}"), &style, (0, 0))?)
    }

    /// The frame of a panel, for [`Canvas::mark`].
    pub fn mark_panel(&self, number: usize, frame: Rect) -> Drawn {
        let [left, top, right, bottom] =
            [frame.left, frame.top, frame.right, frame.bottom].map(|edge| (edge * self.scale).round());
        self.mark(&format!("panel {number} {left} {top} {right} {bottom}"))
    }

    /// Filled markers without notes as one path, for [`Canvas::mark`]: thousands of elements would be slow to show.
    pub fn mark_cloud(&self, spots: &[Spot], look: Look) -> Drawn {
        let (cap, width) = match look.marker {
            Marker::Dot | Marker::Circle => ("round", 2.0 * look.radius),
            Marker::Square => ("square", 1.9 * look.radius),
            _ => ("square", 2.0 * look.radius),
        };
        let mut path = String::with_capacity(12 * spots.len());
        for spot in spots {
            let (x, y) = self.at(*spot);
            path += &format!("M{x} {y}h0");
        }
        let RGBColor(r, g, b) = look.colour;
        let width = (width * self.scale).round().max(1.0);
        let pen = format!("stroke=\"#{r:02X}{g:02X}{b:02X}\" stroke-width=\"{width}\" stroke-linecap=\"{cap}\"");
        self.mark(&format!("path <path {pen} d=\"{path}\"/>"))
    }

    /// The pixel of a place.
    pub fn at(&self, spot: Spot) -> (i32, i32) {
        ((spot.0 * self.scale).round() as i32, (spot.1 * self.scale).round() as i32)
    }

    fn pen(&self, colour: RGBColor, width: f64) -> ShapeStyle {
        colour.stroke_width((width * self.scale).round().max(1.0) as u32)
    }

    /// A line through some spots, broken as the look says.
    pub fn line(&self, spots: &[Spot], look: Look) -> Drawn {
        let pen = self.pen(look.colour, look.width);
        let draw = |spots: &[Spot]| {
            let path: Vec<_> = spots.iter().map(|s| self.at(*s)).collect();
            Ok(self.area.draw(&PathElement::new(path, pen))?)
        };
        match look.dash.pattern() {
            [] if spots.len() > 1 => draw(spots),
            [] => Ok(()),
            pattern => broken(spots, pattern).iter().try_for_each(|part| draw(part)),
        }
    }

    /// A filled or open polygon or circle.
    pub fn marker(&self, spot: Spot, look: Look, open: bool) -> Drawn {
        let (r, fill) = (look.radius, if open { WHITE } else { look.colour });
        let pen = self.pen(look.colour, (0.35 * r).min(1.3));
        let polygon = |corners: &[Spot]| {
            let path: Vec<_> = corners.iter().map(|c| self.at((spot.0 + r * c.0, spot.1 + r * c.1))).collect();
            let closed: Vec<_> = path.iter().chain(&path[..1]).copied().collect();
            self.area.draw(&Polygon::new(path, fill.filled()))?;
            Ok(self.area.draw(&PathElement::new(closed, pen))?)
        };
        match look.marker {
            Marker::Circle | Marker::Dot => {
                let radius = (r * self.scale).round().max(1.0) as i32;
                let circle = |style: ShapeStyle| Ok(self.area.draw(&Circle::new(self.at(spot), radius, style))?);
                if look.marker == Marker::Circle || !open {
                    circle(fill.filled())?;
                }
                if open { circle(pen) } else { Ok(()) }
            }
            Marker::Square => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            Marker::Up => polygon(&[(0.0, -1.15), (1.05, 0.8), (-1.05, 0.8)]),
            Marker::Down => polygon(&[(0.0, 1.15), (1.05, -0.8), (-1.05, -0.8)]),
            Marker::Diamond => polygon(&[(0.0, -1.25), (1.1, 0.0), (0.0, 1.25), (-1.1, 0.0)]),
            Marker::Right => polygon(&[(1.15, 0.0), (-0.8, 1.05), (-0.8, -1.05)]),
            Marker::Star => polygon(&star()),
            Marker::Box => {
                let corners = [self.at((spot.0 - r, spot.1 - r)), self.at((spot.0 + r, spot.1 + r))];
                Ok(self.area.draw(&Rectangle::new(corners, look.colour.filled()))?)
            }
        }
    }

    /// A filled polygon.
    pub fn area(&self, corners: &[Spot], colour: RGBColor) -> Drawn {
        let path: Vec<_> = corners.iter().map(|c| self.at(*c)).collect();
        Ok(self.area.draw(&Polygon::new(path, colour.filled()))?)
    }

    /// Filled polygons side by side, for [`Canvas::mark`] as one path with a fine edge, without which seams would be seen.
    pub fn tiles(&self, tiles: &[Vec<Spot>], colour: RGBColor) -> Drawn {
        if !self.takes_marks() {
            let edge = Look::new(colour, Marker::Dot).width(1.0);
            return tiles.iter().try_for_each(|corners| {
                self.area(corners, colour)?;
                self.line(&corners.iter().chain(corners.first()).copied().collect::<Vec<_>>(), edge)
            });
        }
        if tiles.is_empty() {
            return Ok(());
        }
        let mut path = String::with_capacity(40 * tiles.len());
        for corners in tiles {
            for (number, corner) in corners.iter().enumerate() {
                let (x, y) = self.at(*corner);
                path += &format!("{}{x} {y}", if number == 0 { 'M' } else { 'L' });
            }
            path.push('z');
        }
        let RGBColor(r, g, b) = colour;
        let pen = format!(
            "fill=\"#{r:02X}{g:02X}{b:02X}\" stroke=\"#{r:02X}{g:02X}{b:02X}\" stroke-width=\"{}\"",
            self.scale
        );
        self.mark(&format!("path <path {pen} stroke-linejoin=\"round\" d=\"{path}\"/>"))
    }

    /// A bar with its pattern and a thin edge; a flat bar without them, or its colour would not be seen.
    pub fn bar(&self, bar: Rect, look: Look) -> Drawn {
        let corners = [self.at((bar.left, bar.top)), self.at((bar.right, bar.bottom))];
        self.area.draw(&Rectangle::new(corners, look.colour.filled()))?;
        let thin = Look { colour: WHITE, width: 1.0, ..Look::new(WHITE, Marker::Dot) };
        let hatch = if bar.bottom - bar.top < 3.0 { Hatch::None } else { look.hatch };
        for (a, b) in hatch_lines(bar, hatch) {
            if let Some((a, b)) = bar.clip(a, b) {
                self.line(&[a, b], thin)?;
            }
        }
        if bar.bottom - bar.top < 3.0 {
            return Ok(());
        }
        let edge = [
            (bar.left, bar.top),
            (bar.right, bar.top),
            (bar.right, bar.bottom),
            (bar.left, bar.bottom),
            (bar.left, bar.top),
        ];
        self.line(&edge, Look::new(super::look::BLACK, Marker::Dot).width(0.6))
    }

    /// A text. `rising` turns it by a quarter, to be read from the right.
    pub fn text(&self, text: &str, spot: Spot, size: f64, colour: RGBColor, hold: Pos, rising: bool) -> Drawn {
        let turn = if rising { FontTransform::Rotate270 } else { FontTransform::None };
        let (letters, drop) = (self.letters.size * size * self.scale, self.letters.drop * size);
        let font = FontDesc::new(FontFamily::SansSerif, letters, FontStyle::Normal).transform(turn);
        let style = TextStyle::from(font).color(&colour).pos(hold);
        let spot = if rising { (spot.0 + drop, spot.1) } else { (spot.0, spot.1 + drop) };
        Ok(self.area.draw_text(text, &style, self.at(spot))?)
    }
}

/// How a text begins that is a mark and no text of the drawing.
pub const MARK: &str = "@@";

/// Text held at the middle of its left edge.
pub const LEFT: Pos = Pos { h_pos: HPos::Left, v_pos: VPos::Center };
/// Text held at its middle.
pub const MIDDLE: Pos = Pos { h_pos: HPos::Center, v_pos: VPos::Center };
/// Text held at the middle of its right edge.
pub const RIGHT: Pos = Pos { h_pos: HPos::Right, v_pos: VPos::Center };

/// Corners of a six-pointed star of radius 1.25.
fn star() -> Vec<Spot> {
    let corner = |k: i32| {
        let (angle, radius) = (f64::from(k) * std::f64::consts::PI / 6.0, if k % 2 == 0 { 1.3 } else { 0.6 });
        (radius * angle.sin(), -radius * angle.cos())
    };
    (0..12).map(corner).collect()
}

/// The drawn parts of a broken line.
fn broken(spots: &[Spot], pattern: &[f64]) -> Vec<Vec<Spot>> {
    let mut parts = Vec::new();
    let (mut part, mut turn, mut left) = (spots.first().map_or_else(Vec::new, |s| vec![*s]), 0, pattern[0]);
    for pair in spots.windows(2) {
        let (mut a, b) = (pair[0], pair[1]);
        loop {
            let length = (b.0 - a.0).hypot(b.1 - a.1);
            if length <= left {
                left -= length;
                part.push(b);
                break;
            }
            a = (a.0 + left / length * (b.0 - a.0), a.1 + left / length * (b.1 - a.1));
            part.push(a);
            if turn % 2 == 0 {
                parts.push(std::mem::take(&mut part));
            }
            turn += 1;
            part = vec![a];
            left = pattern[turn % pattern.len()];
        }
    }
    if turn % 2 == 0 && part.len() > 1 {
        parts.push(part);
    }
    parts
}

/// Lines of a pattern that cover a bar, before clipping.
fn hatch_lines(bar: Rect, hatch: Hatch) -> Vec<(Spot, Spot)> {
    let (width, height) = (bar.right - bar.left, bar.bottom - bar.top);
    let row = |gap: f64, length: f64| (1..).map(move |k| f64::from(k) * gap).take_while(move |d| *d < length);
    let level = || row(5.0, height).map(|d| ((bar.left, bar.bottom - d), (bar.right, bar.bottom - d)));
    let upright = || row(5.0, width).map(|d| ((bar.left + d, bar.top), (bar.left + d, bar.bottom)));
    let rising = || row(7.0, width + height).map(|d| ((bar.left, bar.top + d), (bar.left + d, bar.top)));
    let falling = || row(7.0, width + height).map(|d| ((bar.right, bar.top + d), (bar.right - d, bar.top)));
    match hatch {
        Hatch::None => Vec::new(),
        Hatch::Level => level().collect(),
        Hatch::Upright => upright().collect(),
        Hatch::Grid => level().chain(upright()).collect(),
        Hatch::Rising => rising().collect(),
        Hatch::Falling => falling().collect(),
        Hatch::Crossed => rising().chain(falling()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_cut_at_the_frame() {
        let frame = Rect { left: 0.0, top: 0.0, right: 10.0, bottom: 10.0 };
        assert_eq!(frame.clip((-5.0, 5.0), (15.0, 5.0)), Some(((0.0, 5.0), (10.0, 5.0))));
        assert_eq!(frame.clip((2.0, 2.0), (3.0, 3.0)), Some(((2.0, 2.0), (3.0, 3.0))));
        assert_eq!(frame.clip((-5.0, 20.0), (15.0, 20.0)), None);
    }

    #[test]
    fn a_broken_line_has_the_lengths_of_its_pattern() {
        let parts = broken(&[(0.0, 0.0), (10.0, 0.0), (25.0, 0.0)], &[7.0, 4.0]);
        let ends: Vec<(f64, f64)> = parts.iter().map(|p| (p[0].0, p[p.len() - 1].0)).collect();
        assert_eq!(ends, [(0.0, 7.0), (11.0, 18.0), (22.0, 25.0)]);
    }
}

//! A map in the plane: particles coloured by a quantity, a colour bar, lines such as an outline or a free surface.

use std::path::Path;

use plotters::style::RGBColor;

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{BLACK, BLUE, Dash, Look, Marker, RED};
use super::tiles::tiles;
use super::{colours, draw, write_drawn};
use crate::report::numbers::{brief, exact};
use crate::report::quantity::{CLIPPED, robust};
use crate::report::{ReportError, tables};

/// Colours told apart.
const SHADES: usize = 32;
/// Shares of the width of map and colour bar.
const SHARES: [f64; 2] = [0.86, 0.14];
/// Heights that the map may have, px.
const HEIGHTS: (f64, f64) = (130.0, 560.0);
/// What stands left of the map's frame and between the panels, px: an estimate, for its height alone.
const BESIDE: f64 = 80.0;

/// The outline of a body.
pub const OUTLINE: Look = Look::new(BLACK, Marker::Dot).width(1.4);
/// A computed free surface.
pub const SURFACE: Look = Look::new(BLUE, Marker::Dot).width(2.4);
/// An exact one.
pub const EXACT: Look = Look::new(RED, Marker::Dot).width(2.0).dash(Dash::Dashed);

/// What is to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// File name without ending.
    pub name: &'static str,
    /// What stands above it.
    pub title: String,
    /// What the reader should see.
    pub caption: String,
    /// Quantity and unit, for readers: `pore pressure (kPa)`.
    pub quantity: String,
    /// The same as a column of the CSV: `pore_pressure_kpa`.
    pub column: &'static str,
    /// Values at the ends of the colour bar; if not given, the 0.5th and the 99.5th percentile of the values.
    pub range: Option<(f64, f64)>,
    /// Distance of neighbouring particles, m: how large they are drawn.
    pub spacing: f64,
    /// Where the particles were at t = 0, m, in the order of `points`; empty where that is not known.
    pub starts: Vec<[f64; 2]>,
    /// Particles: x (m), y (m), value. One whose value is not a number is left out of the picture.
    pub points: Vec<[f64; 3]>,
    /// Lines over them.
    pub lines: Vec<Line>,
}

/// A line over the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Name in the legend.
    pub label: String,
    /// How it looks.
    pub look: Look,
    /// Its points, x and y in m.
    pub points: Vec<(f64, f64)>,
}

/// The picture.
pub fn figure(field: &Field) -> Figure {
    let values = || field.points.iter().map(|p| p[2]);
    let robust = || range(robust(values()).into_iter().flat_map(|(a, b)| [a, b]));
    let (low, high) = told_apart(field.range.unwrap_or_else(robust));
    let (least, most) = values().filter(|v| v.is_finite()).fold((high, low), |(a, b), v| (a.min(v), b.max(v)));
    let places = || field.lines.iter().flat_map(|line| line.points.iter().copied());
    let half = 0.5 * field.spacing;
    let along = |of: fn((f64, f64)) -> f64| {
        let particles = field.points.iter().map(move |p| of((p[0], p[1]))).flat_map(|x| [x - half, x + half]);
        let (start, end) = range(particles.chain(places().map(of)));
        let room = 0.02 * (end - start);
        (start - room, end + room)
    };
    let (x, y) = (along(|p| p.0), along(|p| p.1));
    let width = (draw::WIDTH - 24.0) * SHARES[0] - BESIDE;
    let height = (width * (y.1 - y.0) / (x.1 - x.0)).clamp(HEIGHTS.0, HEIGHTS.1);
    let unit = (width / (x.1 - x.0)).min(height / (y.1 - y.0));
    // A square marker is 0.9 of its radius high on either side; a little more, so that neighbours touch.
    let look = Look::new(BLACK, Marker::Square).radius((half * unit / 0.86).max(0.8));
    let (across, up) = (Axis::linear("x (m)", "x_m").range(x.0, x.1), Axis::linear("y (m)", "y_m").range(y.0, y.1));
    let mut map = Panel { share: SHARES[0], equal: true, ..Panel::new("", across, up) };
    let tiles = tiles(&field.points, &field.starts, field.spacing);
    let is_tile = |k: usize| tiles.get(k).is_some_and(Option::is_some);
    let numbered = || field.points.iter().enumerate();
    let squares: Vec<_> = numbered().filter(|(k, _)| !is_tile(*k)).map(|(_, point)| *point).collect();
    cloud(&mut map, &squares, (low, high), look);
    for (number, colour) in shades() {
        let own = |(k, p): &(usize, &[f64; 3])| is_tile(*k) && shade(p[2], (low, high)) == Some(number);
        let corners = numbered().filter(own).flat_map(|(k, _)| tiles[k]).flatten().map(|(x, y)| Point::new(x, y));
        map.add(Series::new("", Look::new(colour, Marker::Dot), Mark::Tiles, corners).unlisted());
    }
    for line in &field.lines {
        map.add(Series::line(line.label.clone(), line.look, line.points.iter().copied()));
    }
    Figure {
        name: field.name,
        title: field.title.clone(),
        caption: if least < low || most > high {
            format!("{} {CLIPPED}.", field.caption)
        } else {
            field.caption.clone()
        },
        height,
        panels: vec![map, bar(field, [least, low, high, most], height)],
        missing: Vec::new(),
    }
}

/// Writes a map as SVG and PNG, its particles as `<name>.csv` and its lines as `<name>_lines.csv`. Returns the SVG's text.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(field: &Field, folder: &Path) -> Result<String, ReportError> {
    let figure = figure(field);
    let text = write_drawn(&figure, folder)?;
    let path = |ending: &str| folder.join(format!("{}{ending}", field.name));
    let header = format!("x_m,y_m,{}", field.column);
    tables::table(&path(".csv"), &header, field.points.iter().map(|p| p.map(exact).to_vec()))?;
    let lines = field
        .lines
        .iter()
        .flat_map(|line| line.points.iter().map(|(x, y)| vec![line.label.clone(), exact(*x), exact(*y)]));
    tables::table(&path("_lines.csv"), "line,x_m,y_m", lines)?;
    Ok(text)
}

/// Adds particles (x, y in m, value) in the colours of their values, a series per shade; those whose value is not a
/// number are left out. The look's colour does not matter.
pub fn cloud(map: &mut Panel, particles: &[[f64; 3]], range: (f64, f64), look: Look) {
    for (number, colour) in shades() {
        let own = |p: &&[f64; 3]| shade(p[2], range) == Some(number);
        let points = particles.iter().filter(own).map(|p| Point::new(p[0], p[1]));
        let look = Look { colour, ..look };
        map.add(Series::new("", look, Mark::Points, points).unlisted());
    }
}

/// Number of the shade of a value; none if it is not a number.
fn shade(value: f64, (low, high): (f64, f64)) -> Option<usize> {
    let along = ((value - low) / (high - low)).clamp(0.0, 1.0) * SHADES as f64;
    value.is_finite().then_some(along.min(SHADES as f64 - 1.0) as usize)
}

/// All shades with their numbers.
fn shades() -> impl Iterator<Item = (usize, RGBColor)> {
    (0..SHADES).map(|number| (number, colours::at(middle(number))))
}

/// Middle of a shade between 0 and 1.
fn middle(number: usize) -> f64 {
    (number as f64 + 0.5) / SHADES as f64
}

/// The colour bar: a thick line per shade. Of the four numbers, in their order, those in the middle are its ends, and those beyond them the
/// values that it has no shades for, said at the end where it is clipped.
fn bar(field: &Field, [least, low, high, most]: [f64; 4], height: f64) -> Panel {
    let below = if least < low { format!("down to {}", brief(least, 3)) } else { String::new() };
    let above = if most > high { format!("up to {}", brief(most, 3)) } else { String::new() };
    let none = Axis::linear(&below, "").range(0.0, 1.0).named(Vec::new());
    let scale = Axis::linear(&field.quantity, field.column).range(low, high);
    let mut bar = Panel { share: SHARES[1], ..Panel::new(&above, none, scale) };
    for number in 0..SHADES {
        let value = low + middle(number) * (high - low);
        let look = Look::new(colours::at(middle(number)), Marker::Dot).width(height / SHADES as f64 + 0.5);
        bar.add(Series::line("", look, [(0.0, value), (1.0, value)]).unlisted());
    }
    bar
}

/// Smallest and largest of the values that are numbers; 0 and 1 where there are none.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let wide =
        values.filter(|v| v.is_finite()).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if wide.0 > wide.1 { (0.0, 1.0) } else { wide }
}

/// Smallest span of a colour scale, as a share of the larger of its ends.
const SPAN: f64 = 1e-3;

/// A range with room for [`SPAN`]: values that differ less are one shade, as what they differ by may be round-off.
fn told_apart((low, high): (f64, f64)) -> (f64, f64) {
    let (middle, least) = (0.5 * (low + high), SPAN * low.abs().max(high.abs()));
    let half = if least > 0.0 { 0.5 * least } else { 0.5 };
    if high - low < 2.0 * half { (middle - half, middle + half) } else { (low, high) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::dam::Dam;

    /// The water of a dam as particles, with its outline and free surface.
    fn dam() -> Field {
        let dam = Dam::new(1.0, 0.2, 1.5).expect("a dam");
        let surface: Vec<(f64, f64)> = (0..=30).map(|k| f64::from(k) * 0.05).map(|x| (x, dam.surface(x))).collect();
        let spot = |k: usize| [0.025 + 0.05 * (k % 30) as f64, 0.025 + 0.05 * (k / 30) as f64];
        // Hydrostatic below the free surface, nothing above.
        let point = |[x, y]: [f64; 2]| [x, y, (9.81 * (dam.dupuit(x) - y)).max(0.0)];
        let mut points: Vec<[f64; 3]> = (0..600).map(|k| point(spot(k))).collect();
        points[0][2] = f64::NAN;
        let corners = vec![(0.0, 0.0), (1.5, 0.0), (1.5, 1.0), (0.0, 1.0), (0.0, 0.0)];
        let line = |label: &str, look, points| Line { label: label.to_owned(), look, points };
        Field {
            name: "dam",
            title: "Pore pressure in a dam, hydrostatic below Dupuit's parabola".to_owned(),
            caption: String::new(),
            quantity: "pore pressure (kPa)".to_owned(),
            column: "pore_pressure_kpa",
            range: None,
            spacing: 0.05,
            starts: Vec::new(),
            points,
            lines: vec![line("outline", OUTLINE, corners), line("free surface, exact", EXACT, surface)],
        }
    }

    #[test]
    fn a_map_is_drawn_with_its_bar_its_lines_and_its_numbers() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = std::env::var_os("MPM_KEEP_PICTURES").map_or(folder.path().to_owned(), Into::into);
        let svg = write(&dam(), &folder).expect("a map");
        for part in ["pore pressure (kPa)", "free surface, exact", "outline", "x (m)", "y (m)"] {
            assert!(svg.contains(part), "{part}");
        }
        // Both ends of the colour map are used, by particles and by the bar.
        for number in [0, SHADES - 1] {
            let colour = colours::at(middle(number));
            let code = format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2);
            assert!(svg.matches(&code).count() > 2, "{code}");
        }
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect(name);
        assert!(read("dam.csv").starts_with("x_m,y_m,pore_pressure_kpa\n0.025,0.025,NaN\n"));
        assert_eq!((read("dam.csv").lines().count(), read("dam_lines.csv").lines().count()), (601, 1 + 5 + 31));
        assert!(folder.join("dam.png").exists());
    }

    #[test]
    fn one_particle_does_not_set_the_scale() {
        let mut odd = dam();
        let bar = |field: &Field| figure(field).panels[1].y.range.expect("a range").1;
        let usual = bar(&odd);
        odd.points[7][2] = 1e6;
        assert!(bar(&odd) < 1.02 * usual && figure(&odd).caption.contains("99.5th percentile"));
        assert_eq!(
            (figure(&odd).panels[1].title.as_str(), figure(&dam()).panels[1].title.as_str()),
            ("up to 1e6", "up to 9.33")
        );
    }

    #[test]
    fn a_field_of_one_value_or_none_has_a_range() {
        assert_eq!(told_apart(range([2.0, 2.0, f64::NAN].into_iter())), (1.999, 2.001));
        assert_eq!((told_apart((0.0, 0.0)), told_apart((-1.0, 3.0))), ((-0.5, 0.5), (-1.0, 3.0)));
        assert_eq!(range(std::iter::empty()), (0.0, 1.0));
        // Round-off has no colours, and the ticks no more digits than tell them apart.
        let mut even = dam();
        even.points.iter_mut().enumerate().for_each(|(k, p)| p[2] = 5.0 / 6.0 + 1e-16 * (k % 7) as f64);
        let bar = &figure(&even).panels[1];
        assert!(bar.y.ticks().iter().all(|(_, text)| text.len() <= 6), "{:?}", bar.y.ticks());
        let bare = Field { points: Vec::new(), lines: Vec::new(), ..dam() };
        assert_eq!(figure(&bare).panels.len(), 2);
    }
}

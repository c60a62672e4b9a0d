//! The pictures of the report, one per file, and what they are made of.
//!
//! # Reading order
//! 1. [`figure`]: panels and series as data. [`axis`], [`look`]: their ranges, ticks, colours and markers.
//! 2. [`draw`], [`legend`], [`canvas`]: from a figure to any backend.
//! 3. The pictures: [`at_a_glance`], [`time_step`], [`mesh`], [`isochrones`], [`consolidation`], [`error_against_time`], [`error_against_mesh`],
//!    [`error_budget`], [`energy`], [`crossings`]; of all integrators [`schemes`], [`spline_profiles`], [`places`],
//!    [`steps`]; of a case of the suite [`case`].
//!    [`stability_map`]: largest stable steps, measured and in theory; [`stress_test`]: where schemes hold and break.
//! 4. [`field`]: a map of particles coloured by a quantity, with lines over it; [`colours`] for it. [`levee`]: the
//!    pictures of a levee that fails.

pub mod at_a_glance;
pub mod axis;
pub mod canvas;
pub mod case;
pub mod colours;
pub mod comparison;
pub mod consolidation;
pub mod crossings;
pub mod curves;
pub mod draw;
pub mod energy;
pub mod error_against_mesh;
pub mod error_against_time;
pub mod error_budget;
pub mod field;
pub mod figure;
pub mod isochrones;
pub mod legend;
pub mod levee;
pub mod look;
pub mod mesh;
pub mod places;
pub mod schemes;
pub mod spline_profiles;
pub mod stability_map;
pub mod steps;
pub mod stress_test;
mod tiles;
pub mod time_step;

use std::path::Path;
use std::sync::OnceLock;

use plotters::prelude::{BitMapBackend, DrawingBackend, IntoDrawingArea, SVGBackend};
use plotters::style::{FontStyle, WHITE, register_font};

use self::canvas::{BITMAP_LETTERS, Canvas, DrawError, Drawn, Lettering, SVG_LETTERS};
use self::figure::Figure;
use crate::report::select::{Cases, Reference};
use crate::report::{ReportError, Study, save, tables, unwritable};

/// The font of all pictures: no font of the machine is asked for.
const FONT: &[u8] = include_bytes!("../../../assets/DejaVuSans-subset.ttf");
/// Pixels of the SVG's grid to one px: its coordinates are whole numbers.
const SVG_SCALE: u32 = 4;
/// Pixels of the PNG to one px.
const PNG_SCALE: u32 = 2;
/// Finer pixels that one pixel of the PNG is averaged from, per direction.
const SMOOTH: u32 = 2;

/// Names of all pictures, in the order of the page.
pub const NAMES: [&str; 21] = [
    at_a_glance::NAME,
    "max-error-against-mesh-terzaghi",
    "max-error-against-mesh-compressible",
    "profile-error-against-mesh",
    "error-of-all-schemes",
    "profile-error-of-all-schemes",
    "isochrones-bspline2",
    "displaced",
    "grid-shift",
    "error-against-steps",
    "error-against-factorisations",
    time_step::NAME,
    "mesh",
    "isochrones",
    "consolidation",
    "error-against-time-particles",
    "error-against-time-surface",
    "crossings",
    "error-budget",
    "error-budget-late",
    "energy",
];

/// All pictures of a study.
pub fn figures(study: &Study) -> Vec<Figure> {
    let cases = Cases::of(&study.results);
    vec![
        at_a_glance::figure(&study.results),
        error_against_mesh::largest("max-error-against-mesh-terzaghi", &cases, Reference::Terzaghi),
        error_against_mesh::largest("max-error-against-mesh-compressible", &cases, Reference::Compressible),
        error_against_mesh::profile(&cases),
        schemes::largest(&study.results),
        schemes::profile(&study.results),
        spline_profiles::figure(&Cases::of_family(&study.results, "quasi-static-bspline2")),
        places::displaced(&study.sweeps),
        places::shifted(&study.sweeps),
        steps::steps(&study.sweeps),
        steps::factorisations(&study.sweeps),
        time_step::figure(),
        mesh::figure(),
        isochrones::figure(&cases),
        consolidation::figure(&cases),
        error_against_time::figure("error-against-time-particles", &cases, "particles"),
        error_against_time::figure("error-against-time-surface", &cases, "surface"),
        crossings::figure(&cases),
        error_budget::figure("error-budget", study, &cases, 0.01),
        error_budget::figure("error-budget-late", study, &cases, 0.1),
        energy::figure(&cases),
    ]
}

/// Registers the font, once.
pub(crate) fn ready() -> bool {
    static DONE: OnceLock<bool> = OnceLock::new();
    *DONE.get_or_init(|| register_font("sans-serif", FontStyle::Normal, FONT).is_ok())
}

/// Writes a picture as SVG and PNG and its numbers as CSV into a folder. Returns the text of the SVG.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(figure: &Figure, folder: &Path) -> Result<String, ReportError> {
    let text = write_drawn(figure, folder)?;
    numbers(figure, &folder.join(format!("{}.csv", figure.name)))?;
    Ok(text)
}

/// Writes a picture as SVG and PNG: its numbers are the caller's. Returns the text of the SVG.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write_drawn(figure: &Figure, folder: &Path) -> Result<String, ReportError> {
    let text = write_svg(figure, folder)?;
    write_bitmap(figure, folder)?;
    Ok(text)
}

/// Writes a picture as PNG alone, as of thousands of particles: its numbers are the caller's.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write_bitmap(figure: &Figure, folder: &Path) -> Result<(), ReportError> {
    let path = folder.join(format!("{}.png", figure.name));
    write_png(figure, &path).map_err(|cause| ReportError::Draw { path, cause })
}

/// Writes a picture as SVG alone: its numbers are the caller's. Returns its text.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write_svg(figure: &Figure, folder: &Path) -> Result<String, ReportError> {
    let path = folder.join(format!("{}.svg", figure.name));
    let text = svg_text(figure).map_err(|cause| ReportError::Draw { path: path.clone(), cause })?;
    save(&path, &text)?;
    Ok(text)
}

/// Writes a picture as SVG and its numbers as CSV.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write_svg_and_numbers(figure: &Figure, folder: &Path) -> Result<(), ReportError> {
    write_svg(figure, folder)?;
    numbers(figure, &folder.join(format!("{}.csv", figure.name)))
}

/// Draws a picture on any backend, `scale` of its pixels to one px.
fn draw_on<DB: DrawingBackend>(figure: &Figure, backend: DB, scale: u32, letters: Lettering) -> Drawn {
    if !ready() {
        return Err(DrawError::Font);
    }
    let area = backend.into_drawing_area();
    area.fill(&WHITE)?;
    draw::figure(figure, &Canvas::new(&area, f64::from(scale), letters))?;
    Ok(area.present()?)
}

/// Width and height of a picture in pixels, `scale` of them to one px.
fn size(figure: &Figure, scale: u32) -> (u32, u32) {
    (draw::WIDTH as u32 * scale, draw::height(figure).ceil() as u32 * scale)
}

/// The text of a picture's SVG.
///
/// # Errors
/// What the backend says.
pub fn svg_text(figure: &Figure) -> Result<String, DrawError> {
    svg_with(figure, SVG_LETTERS)
}

/// The same with marks between its series, for [`crate::page::svg`].
///
/// # Errors
/// What the backend says.
pub fn marked_svg(figure: &Figure) -> Result<String, DrawError> {
    #[cfg(test)]
    assert_eq!(unseen(figure)?, Vec::<String>::new(), "{}: in the legend, and nowhere to be seen", figure.name);
    svg_with(figure, Lettering { marks: true, ..SVG_LETTERS })
}

fn svg_with(figure: &Figure, letters: Lettering) -> Result<String, DrawError> {
    let (width, height) = size(figure, 1);
    let (wide, high) = size(figure, SVG_SCALE);
    let mut text = String::new();
    draw_on(figure, SVGBackend::with_string(&mut text, (wide, high)), SVG_SCALE, letters)?;
    // Shown at its own size; the grid of whole numbers is finer.
    let head = format!("<svg width=\"{wide}\" height=\"{high}\"");
    Ok(text.replacen(&head, &format!("<svg width=\"{width}\" height=\"{height}\""), 1))
}

fn write_png(figure: &Figure, path: &Path) -> Drawn {
    let fine = size(figure, PNG_SCALE * SMOOTH);
    let mut pixels = vec![0; 3 * (fine.0 * fine.1) as usize];
    draw_on(figure, BitMapBackend::with_buffer(&mut pixels, fine), PNG_SCALE * SMOOTH, BITMAP_LETTERS)?;
    let coarse = (fine.0 / SMOOTH, fine.1 / SMOOTH);
    let mut image = BitMapBackend::new(path, coarse);
    image.blit_bitmap((0, 0), coarse, &averaged(&pixels, coarse)).map_err(|e| DrawError::Backend(e.to_string()))?;
    image.present().map_err(|e| DrawError::Backend(e.to_string()))
}

/// An RGB image of `size`, each pixel the mean of `SMOOTH` x `SMOOTH` finer ones.
fn averaged(fine: &[u8], size: (u32, u32)) -> Vec<u8> {
    // Most of the time of a page in the dev profile was spent here: two by two are written out.
    const { assert!(SMOOTH == 2) };
    let line = 3 * size.0 as usize;
    let mut coarse = vec![0; line * size.1 as usize];
    for (i, mean) in coarse.iter_mut().enumerate() {
        let (y, k) = (i / line, i % line);
        let at = 4 * y * line + 6 * (k / 3) + k % 3;
        let four = [fine[at], fine[at + 3], fine[at + 2 * line], fine[at + 2 * line + 3]].map(u32::from);
        *mean = ((four[0] + four[1] + four[2] + four[3]) / 4) as u8;
    }
    coarse
}

/// Writes the numbers of a picture: panel, series, one column per axis, and notes where there are some.
fn numbers(figure: &Figure, path: &Path) -> Result<(), ReportError> {
    let first = figure.panels.first().ok_or_else(|| unwritable(path, std::io::Error::other("no panels")))?;
    let data = || figure.panels.iter().flat_map(|p| p.series.iter().filter(|s| s.is_data).map(move |s| (p, s)));
    let notes = data().any(|(_, s)| s.points.iter().any(|p| !p.note.is_empty()));
    let header = format!("panel,series,{},{}{}", first.x.column, first.y.column, if notes { ",note" } else { "" });
    let rows = data().flat_map(|(panel, series)| {
        series.points.iter().map(move |p| {
            let mut row =
                vec![panel.title.clone(), series.label.clone(), panel.x.number(p.x), panel.y.number(p.y - p.from)];
            if notes {
                row.push(p.note.clone());
            }
            row
        })
    });
    tables::table(path, &header, rows)
}

/// Labels of the legend whose series leave no mark on the picture: it is drawn with and without each of them, and compared.
#[cfg(test)]
fn unseen(figure: &Figure) -> Result<Vec<String>, DrawError> {
    // The ranges stay when a series goes.
    let panels = figure.panels.iter().map(|panel| panel.clone().fitted()).collect();
    let figure = Figure { panels, ..figure.clone() };
    let entries = legend::entries(&figure);
    let (wide, high) = size(&figure, 1);
    let above_legend = 3 * wide as usize * (f64::from(high) - legend::height(&entries) - 16.0) as usize;
    let pixels = |figure: &Figure| {
        let mut pixels = vec![0; 3 * (wide * high) as usize];
        draw_on(figure, BitMapBackend::with_buffer(&mut pixels, (wide, high)), 1, BITMAP_LETTERS)?;
        pixels.truncate(above_legend);
        Ok::<_, DrawError>(pixels)
    };
    let whole = pixels(&figure)?;
    let mut unseen = Vec::new();
    for label in entries.iter().map(legend::Entry::label) {
        let mut without = figure.clone();
        let mut colour = WHITE;
        for series in without.panels.iter_mut().flat_map(|panel| &mut panel.series).filter(|s| s.label == label) {
            colour = series.look.colour;
            series.points.clear();
        }
        // Half of what tells the colour from the paper: edges that are drawn twice are a little darker.
        let contrast = [colour.0, colour.1, colour.2].map(|part| 255 - part).into_iter().max().unwrap_or(0);
        let differ = pixels(&without)?.iter().zip(&whole).filter(|(a, b)| a.abs_diff(**b) > contrast / 2).count();
        if differ < 12 {
            unseen.push(label.to_owned());
        }
    }
    Ok(unseen)
}

#[cfg(test)]
mod tests {
    use super::axis::Axis;
    use super::figure::{Mark, Panel, Point, Series};
    use super::look::{BLUE, Look, Marker, PALE, RED};
    use super::*;

    fn corners_of_paper() -> [Point; 4] {
        [(0.0, 0.1), (1.0, 0.1), (1.0, 0.9), (0.0, 0.9)].map(|(x, y)| Point::new(x, y))
    }

    #[test]
    fn an_entry_of_the_legend_that_nobody_sees_is_found() {
        let panel = || Panel::new("", Axis::linear("x", "x").range(0.0, 1.0), Axis::linear("y", "y").range(0.0, 1.0));
        let line = |label: &str, y: f64| Series::line(label, Look::new(RED, Marker::Dot), [(0.0, y), (1.0, y)]);
        let corners = [(0.1, 0.1), (0.9, 0.1), (0.9, 0.9), (0.1, 0.9)].map(|(x, y)| Point::new(x, y));
        let band = Series::new("band", Look::new(PALE, Marker::Dot), Mark::Area, corners);
        let dot = Series::new("dot", Look::new(BLUE, Marker::Circle).radius(3.0), Mark::Points, [Point::new(0.5, 0.5)]);
        let figure = |panel: Panel| Figure {
            name: "figure",
            title: String::new(),
            caption: String::new(),
            height: 200.0,
            panels: vec![panel],
            missing: Vec::new(),
        };
        let shown = |panel: Panel| unseen(&figure(panel)).expect("a picture");
        // A band that is added last hides nothing.
        assert_eq!(shown(panel().with(line("line", 0.5)).with(dot.clone()).with(band)), Vec::<String>::new());
        // Paper under a text hides the line below it.
        let paper = Series::new("", Look::new(WHITE, Marker::Dot), Mark::Area, corners_of_paper()).unlisted().guide();
        assert_eq!(shown(panel().with(line("line", 0.5)).with(dot.clone()).with(paper)), ["line", "dot"]);
        // A line that lies outside, or is too short to be seen beside a marker, is not in the legend.
        assert_eq!(shown(panel().with(dot.clone()).with(line("outside", 2.0))), Vec::<String>::new());
        let short = Series::line("short", Look::new(RED, Marker::Dot), [(0.5, 0.5), (0.5005, 0.5)]);
        assert_eq!(shown(panel().with(short).with(dot.clone())), Vec::<String>::new());
        let cover = Series { label: "cover".to_owned(), ..dot.clone() };
        assert_eq!(shown(panel().with(dot).with(cover)), ["dot", "cover"]);
        // What has no name has no entry.
        let entries = legend::entries(&figure(panel().with(line("line", 0.5)).with(line("", 0.2))));
        assert_eq!(entries.iter().map(legend::Entry::label).collect::<Vec<_>>(), ["line"]);
    }

    /// Points that stand on one another are one marker in the file.
    #[test]
    fn a_marker_on_the_same_one_is_not_drawn_again() {
        let star = |points: &[(f64, f64)]| {
            let points = points.iter().map(|(x, y)| Point::new(*x, *y));
            let stars = Series::new("star", Look::new(RED, Marker::Star).radius(4.0), Mark::Points, points);
            let axis = |name: &'static str| Axis::linear(name, name).range(0.0, 1.0);
            let panels = vec![Panel::new("", axis("x"), axis("y")).with(stars)];
            let (name, title, caption, missing) = ("stars", String::new(), String::new(), Vec::new());
            svg_text(&Figure { name, title, caption, height: 200.0, panels, missing }).expect("a picture")
        };
        let (near, far) = ((0.5, 0.5), (0.25, 0.5));
        assert_eq!(star(&[near, near, far, far]), star(&[near, far]));
        assert_ne!(star(&[near, far, near]), star(&[near, far]));
    }

    #[test]
    fn a_pixel_is_the_mean_of_the_four_finer_ones_channel_by_channel() {
        // Two pixels: all of the left one's green stands in one corner, the right one is blue in its lower half.
        let fine = [[[0, 0, 0], [0, 40, 0], [0, 0, 0], [0, 0, 0]], [[0, 0, 0], [0, 0, 0], [0, 0, 200], [8, 0, 200]]];
        assert_eq!(averaged(fine.as_flattened().as_flattened(), (2, 1)), [0, 10, 0, 2, 0, 100]);
    }
}

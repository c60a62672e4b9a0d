//! The model before anything moves (the paper's Fig. 6): both layers, cells, wall, base, water in the tank, measures.

use std::path::Path;

use mpm_core::observe::Frame;

use super::Site;
use crate::report::ReportError;
use crate::report::numbers::brief;
use crate::report::plots;
use crate::report::plots::axis::Axis;
use crate::report::plots::draw::WIDTH;
use crate::report::plots::field::OUTLINE;
use crate::report::plots::figure::{Figure, Mark, Panel, Point, Series};
use crate::report::plots::look::{BLACK, BLUE, GREY, Look, Marker, PALE, POOL, RED};

/// What stands beside the frame, px: an estimate, for its height alone.
const BESIDE: f64 = 66.0;
/// Width of the tank as drawn, m.
const TANK: f64 = 1.4;
const SOLID: Look = Look::new(RED, Marker::Dot);
const WATER: Look = Look::new(BLUE, Marker::Circle);
const MEASURE: Look = Look::new(BLACK, Marker::Dot).width(0.9);

/// The picture.
pub fn figure(site: &Site, frame: &Frame) -> Figure {
    let (high, toe, shoulder) = (site.height(), site.toe(), site.shoulder());
    let (x, y) = ((-TANK - 0.1, toe + 1.25), (-0.45, high + 0.75));
    let unit = (WIDTH - 24.0 - BESIDE) / (x.1 - x.0);
    let axes = (Axis::linear("x (m)", "x_m").range(x.0, x.1), Axis::linear("y (m)", "y_m").range(y.0, y.1));
    let mut panel = Panel { equal: true, ..Panel::new("", axes.0, axes.1) };
    tank(&mut panel, site);
    cells(&mut panel, frame);
    layers(&mut panel, frame, unit);
    panel.add(Series::line("soil", OUTLINE, site.closed()).unlisted().guide());
    edges(&mut panel, x, site);
    across(&mut panel, (0.0, shoulder), high + 0.42);
    across(&mut panel, (shoulder, toe), high + 0.42);
    upright(&mut panel, toe + 0.45, high);
    upright(&mut panel, -TANK + 0.25, site.tank_m);
    let run = (toe - shoulder) / high;
    words(&mut panel, (0.5 * (shoulder + toe) + 0.5, 0.5 * high + 0.22), format!("1 : {}", brief(run, 3)));
    Figure {
        name: "levee-model",
        title: "Levee, background mesh and particles at the start (the paper's Fig. 6)".to_owned(),
        caption: format!(
            "{} solid particles (dots) and {} water particles (rings); cells of {} m where there is soil. Water stands \
             {} m high against the wall, which lets it through; the base lets none through.",
            frame.solid.len(),
            frame.water.len(),
            brief(frame.size, 3),
            brief(site.tank_m, 3)
        ),
        height: unit * (y.1 - y.0),
        panels: vec![panel],
        missing: Vec::new(),
    }
}

/// Writes it with the places of all particles. Returns the text of the SVG.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(site: &Site, frame: &Frame, folder: &Path) -> Result<String, ReportError> {
    plots::write(&figure(site, frame), folder)
}

fn tank(panel: &mut Panel, site: &Site) {
    let corners = [(-TANK, 0.0), (0.0, 0.0), (0.0, site.tank_m), (-TANK, site.tank_m)];
    let points = corners.map(|(x, y)| Point::new(x, y));
    panel.add(Series::new("water in the tank", Look::new(POOL, Marker::Dot), Mark::Area, points).guide());
    let level = [(-TANK, site.tank_m), (0.0, site.tank_m)];
    panel.add(Series::line("", Look::new(BLUE, Marker::Dot).width(1.8), level).unlisted().guide());
    let sign = Point::new(-0.45, site.tank_m + 0.085).open(true);
    panel.add(Series::new("", Look::new(BLUE, Marker::Down).radius(5.0), Mark::Points, [sign]).unlisted().guide());
}

/// Edges of the cells that hold soil.
fn cells(panel: &mut Panel, frame: &Frame) {
    let look = Look::new(PALE, Marker::Dot).width(0.8);
    let [columns, _] = frame.cells;
    let held = frame.cell.iter().enumerate().filter(|(_, c)| c.soil > 0.0);
    for (place, (number, _)) in held.enumerate() {
        let [x, y] = [number % columns, number / columns].map(|k| k as f64 * frame.size);
        let (right, top) = (x + frame.size, y + frame.size);
        let edge = Series::line("edge of a cell", look, [(x, y), (right, y), (right, top), (x, top), (x, y)]).guide();
        panel.add(if place == 0 { edge } else { edge.unlisted() });
    }
}

fn layers(panel: &mut Panel, frame: &Frame, unit: f64) {
    let spacing = unit * frame.solid.first().map_or(0.0, |p| p.volume.max(0.0).sqrt());
    let (dot, ring) = ((0.17 * spacing).clamp(0.7, 3.0), (0.36 * spacing).clamp(1.2, 5.0));
    let rings = frame.water.iter().map(|p| Point::new(p.x[0], p.x[1]).open(true));
    panel.add(Series::new("water particle", WATER.radius(ring), Mark::Points, rings));
    let dots = frame.solid.iter().map(|p| Point::new(p.x[0], p.x[1]));
    panel.add(Series::new("solid particle", SOLID.radius(dot), Mark::Points, dots));
}

/// Wall and base, hatched outside.
fn edges(panel: &mut Panel, (left, right): (f64, f64), site: &Site) {
    let thick = Look::new(BLACK, Marker::Dot).width(2.6);
    panel.add(Series::line("", thick, [(left, 0.0), (right, 0.0)]).unlisted().guide());
    let wall = Look::new(GREY, Marker::Dot).width(3.4);
    panel.add(Series::line("wall, lets water through", wall, [(0.0, 0.0), (0.0, site.height())]).guide());
    let strokes = (0..).map(|k| left + 0.05 + 0.15 * f64::from(k)).take_while(|x| *x < right);
    for x in strokes {
        panel.add(Series::line("", MEASURE, [(x, -0.01), (x - 0.1, -0.13)]).unlisted().guide());
    }
    words(panel, (0.5 * site.toe(), -0.28), "base, lets no water through".to_owned());
}

/// A measure of a length along x at a height.
fn across(panel: &mut Panel, (start, end): (f64, f64), y: f64) {
    for line in [[(start, y), (end, y)], [(start, y - 0.1), (start, y + 0.1)], [(end, y - 0.1), (end, y + 0.1)]] {
        panel.add(Series::line("", MEASURE, line).unlisted().guide());
    }
    words(panel, (0.5 * (start + end), y + 0.16), format!("{} m", brief(end - start, 3)));
}

/// A measure of a height above the base.
fn upright(panel: &mut Panel, x: f64, high: f64) {
    for line in [[(x, 0.0), (x, high)], [(x - 0.1, high), (x + 0.1, high)]] {
        panel.add(Series::line("", MEASURE, line).unlisted().guide());
    }
    words(panel, (x + 0.38, 0.5 * high), format!("{} m", brief(high, 3)));
}

fn words(panel: &mut Panel, (x, y): (f64, f64), text: String) {
    let look = Look::new(BLACK, Marker::Dot);
    panel.add(Series::new("", look, Mark::Middle, [Point::new(x, y).note(text)]).unlisted().guide());
}

#[cfg(test)]
mod tests {
    use super::super::tests::{folder, site};
    use super::*;
    use crate::frames::made_up;

    #[test]
    fn the_model_is_drawn_with_its_measures() {
        let (folder, _own) = folder();
        let frame = &made_up::shots(1, 0)[0].frame;
        let svg = write(&site(), frame, &folder).expect("a picture");
        for part in ["3 m", "6 m", "2.3 m", "1 : 2", "water in the tank", "solid particle"] {
            assert!(svg.contains(part), "{part}");
        }
        let table = std::fs::read_to_string(folder.join("levee-model.csv")).expect("a table");
        assert_eq!(table.lines().count(), 1 + frame.solid.len() + frame.water.len());
    }
}

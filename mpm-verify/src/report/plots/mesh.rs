//! The background mesh with both layers of particles (the paper's Fig. 4a).

use mpm_core::particles::even_positions;

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{BLACK, BLUE, GREY, Look, Marker, RED};
use crate::report::select::PAPER;

/// Cells of the paper's column, across and up.
const CELLS: [usize; 2] = [5, 50];
/// Rows of cells in the detail.
const DETAIL: usize = 5;

const EDGE: Look = Look::new(GREY, Marker::Dot).width(0.7);
const SOLID: Look = Look::new(RED, Marker::Dot);
const WATER: Look = Look::new(BLUE, Marker::Dot);
const ROLLER: Look = Look::new(BLACK, Marker::Circle).radius(3.0);

/// The column as a whole, and its top.
pub fn figure() -> Figure {
    let (width, height) = (CELLS[0] as f64 * PAPER.0, CELLS[1] as f64 * PAPER.0);
    let low = height - DETAIL as f64 * PAPER.0;
    Figure {
        name: "mesh",
        title: "Column, background mesh and particles (the paper's Fig. 4a)".to_owned(),
        caption: format!(
            "The paper's column, 1 m high and 0.1 m wide, with cells of {} m and {} particles of each layer per cell. \
             Solid (dots) and water (rings) start at the same places. Water leaves through the top only; rollers hold \
             the sides and the base. The load of 10 kPa acts on the top row of particles (the paper) or on the true \
             surface above it. The study solves the same column in one dimension unless the table of cases says \
             plane-strain.",
            PAPER.0, PAPER.1
        ),
        height: 520.0,
        panels: vec![whole(width, height), detail(width, height, low)],
        missing: Vec::new(),
    }
}

/// Height and sideways place in m.
fn axes(x: (f64, f64), y: (f64, f64)) -> (Axis, Axis) {
    (Axis::linear("x (m)", "x_m").range(x.0, x.1), Axis::linear("height (m)", "height_m").range(y.0, y.1))
}

fn whole(width: f64, height: f64) -> Panel {
    let (x, y) = axes((-0.04, width + 0.24), (-0.04, height + 0.09));
    let x = x.named(vec![(0.0, "0".to_owned()), (width, width.to_string())]);
    let mut panel = Panel { share: 0.36, equal: true, ..Panel::new("whole column", x, y) };
    edges(&mut panel, width, 0.0, height);
    layers(&mut panel, 0.0, [0.8, 1.7]);
    let tips = [0.1, 0.3, 0.5, 0.7, 0.9].map(|s| Point::new(s * width, height).from(height + 0.06));
    panel.add(arrows(tips.to_vec(), 2.6));
    let sides = (0..=20).map(|k| f64::from(k) * height / 20.0).flat_map(|y| [(-0.012, y), (width + 0.012, y)]);
    let base = (0..=2).map(|k| (f64::from(k) * width / 2.0, -0.014));
    panel.add(rollers(sides.chain(base), 2.2));
    let beside = width + 0.04;
    panel.add(words(&[
        (beside, height + 0.045, "load q"),
        (beside, height, "drained, p = 0"),
        (beside, 0.5 * height, "rollers,"),
        (beside, 0.5 * height - 0.04, "undrained"),
        (beside, 0.02, "rollers,"),
        (beside, -0.02, "undrained"),
    ]));
    panel
}

fn detail(width: f64, height: f64, low: f64) -> Panel {
    let (x, y) = axes((-0.012, width + 0.012), (low - 0.004, height + 0.03));
    let mut panel = Panel { share: 0.64, equal: true, ..Panel::new("top five rows of cells", x, y) };
    edges(&mut panel, width, low, height);
    layers(&mut panel, low, [2.4, 5.0]);
    let tips = |from: usize, end: f64| {
        let across = (from..from + CELLS[0]).map(|k| (k as f64 + 0.5) * 0.5 * PAPER.0);
        across.map(|x| Point::new(x, end).from(height + 0.016)).collect()
    };
    panel.add(arrows(tips(0, height - 0.25 * PAPER.0 + 0.0015), 4.0));
    panel.add(arrows(tips(CELLS[0], height), 4.0));
    panel.add(words(&[
        (0.0, height + 0.0245, "traction on boundary"),
        (0.0, height + 0.0195, "particles (paper)"),
        (0.5 * width + 0.003, height + 0.0245, "traction on the"),
        (0.5 * width + 0.003, height + 0.0195, "free surface"),
    ]));
    let sides = (0..=DETAIL).map(|k| low + k as f64 * PAPER.0).flat_map(|y| [(-0.003, y), (width + 0.003, y)]);
    panel.add(rollers(sides, 4.0));
    panel
}

/// Arrows with heads of a radius, px.
fn arrows(tips: Vec<Point>, head: f64) -> Series {
    let look = Look::new(BLACK, Marker::Dot).width(1.3).radius(head);
    Series::new("load", look, Mark::Arrows, tips).unlisted().guide()
}

/// Rollers at some places, of a radius, px.
fn rollers(places: impl Iterator<Item = (f64, f64)>, radius: f64) -> Series {
    let points = places.map(|(x, y)| Point::new(x, y).open(true));
    Series::new("roller", ROLLER.radius(radius), Mark::Points, points).guide()
}

/// Texts that begin at a place.
fn words(texts: &[(f64, f64, &str)]) -> Series {
    let points = texts.iter().map(|(x, y, text)| Point::new(*x, *y).note(*text));
    Series::new("", Look::new(BLACK, Marker::Dot), Mark::Text, points).unlisted().guide()
}

/// Edges of cells between two heights.
fn edges(panel: &mut Panel, width: f64, low: f64, high: f64) {
    let rows = ((high - low) / PAPER.0).round() as usize;
    let level = (0..=rows).map(|k| low + k as f64 * PAPER.0).map(|y| [(0.0, y), (width, y)]);
    let upright = (0..=CELLS[0]).map(|k| k as f64 * PAPER.0).map(|x| [(x, low), (x, high)]);
    for (place, ends) in level.chain(upright).enumerate() {
        let edge = Series::line("edge of a cell", EDGE, ends).guide();
        panel.add(if place == 0 { edge } else { edge.unlisted() });
    }
}

/// Both layers above a height, drawn with radii of the dot and the ring, px.
fn layers(panel: &mut Panel, low: f64, radii: [f64; 2]) {
    let at = |[x, y]: [f64; 2]| Point::new(x * PAPER.0, y * PAPER.0);
    let spots: Vec<Point> = even_positions(CELLS, 2).map(at).filter(|p| p.y > low).collect();
    let rings = spots.iter().cloned().map(|p| p.open(true));
    panel.add(Series::new("water particle", WATER.radius(radii[1]), Mark::Points, rings));
    panel.add(Series::new("solid particle", SOLID.radius(radii[0]), Mark::Points, spots));
}

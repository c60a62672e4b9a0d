//! A frame on a map: soil in one colour or in those of a quantity, water, its level, the outline at the start.

use mpm_core::observe::Frame;

use super::{Site, bare};
use crate::frames::Shot;
use crate::report::plots::axis::Axis;
use crate::report::plots::colours;
use crate::report::plots::draw::WIDTH;
use crate::report::plots::field::{OUTLINE, SURFACE, cloud};
use crate::report::plots::figure::{Mark, Panel, Point, Series};
use crate::report::plots::look::{BLACK, BLUE, Look, Marker, SAND};
use crate::report::quantity::Quantity;

/// Room around the soil, m.
const ROOM: f64 = 0.25;
/// What stands beside a map's frame, px: an estimate, for its height alone.
const BESIDE: f64 = 72.0;
/// Steps of a colour bar.
const STEPS: usize = 128;

/// Part of the plane that maps show, m: the same for all frames of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    x: (f64, f64),
    y: (f64, f64),
}

impl Window {
    /// What holds the outline and all frames.
    pub fn of<'a>(site: &Site, shots: impl IntoIterator<Item = &'a Shot>) -> Self {
        let places = shots.into_iter().flat_map(|shot| shot.frame.solid.iter().map(|p| p.x));
        let all = places.chain(site.outline.iter().copied()).filter(|x| x.iter().all(|v| v.is_finite()));
        let (low, high) = all.fold(([0.0_f64; 2], [0.0_f64; 2]), |(low, high), x| {
            ([0, 1].map(|a| low[a].min(x[a])), [0, 1].map(|a| high[a].max(x[a])))
        });
        Self { x: (low[0] - ROOM, high[0] + ROOM), y: (low[1] - ROOM, high[1] + ROOM) }
    }

    /// Its left, lower, right and upper end, m.
    pub fn ends(&self) -> [f64; 4] {
        [self.x.0, self.y.0, self.x.1, self.y.1]
    }

    /// Height of a map among `columns` side by side, px.
    pub fn height(&self, columns: usize) -> f64 {
        (self.y.1 - self.y.0) * self.unit(columns)
    }

    /// Length of 1 m among `columns` maps side by side, px.
    pub fn unit(&self, columns: usize) -> f64 {
        let whole = (WIDTH - 24.0 - 14.0 * (columns as f64 - 1.0)) / columns as f64;
        (whole - BESIDE) / (self.x.1 - self.x.0)
    }

    /// An empty map.
    pub fn panel(&self, title: &str) -> Panel {
        let x = Axis::linear("x (m)", "x_m").range(self.x.0, self.x.1);
        let y = Axis::linear("y (m)", "y_m").range(self.y.0, self.y.1);
        Panel { equal: true, ..Panel::new(title, x, y) }
    }
}

/// Edge of a solid particle, m: of the middle one of all, so that squares touch. Zero without particles.
pub fn edge(frame: Option<&Frame>) -> f64 {
    let mut volumes: Vec<f64> = frame.iter().flat_map(|f| &f.solid).map(|p| p.volume).collect();
    volumes.sort_by(f64::total_cmp);
    volumes.get(volumes.len() / 2).copied().unwrap_or(0.0).max(0.0).sqrt()
}

/// Radius of a box that covers a particle, px; a little more, or seams would be seen.
fn radius(frame: &Frame, unit: f64) -> f64 {
    0.5 * edge(Some(frame)) * unit + 0.35
}

/// Soil in one colour, water particles on it. `unit` is the length of 1 m, px.
pub fn layers(panel: &mut Panel, frame: &Frame, unit: f64) {
    let radius = radius(frame, unit);
    let soil = Look::new(SAND, Marker::Box).radius(radius);
    let water = Look::new(BLUE, Marker::Dot).radius((0.45 * radius).max(0.6));
    let at = |x: [f64; 2]| Point::new(x[0], x[1]);
    panel.add(Series::new("soil", soil, Mark::Points, frame.solid.iter().map(|p| at(p.x))));
    panel.add(Series::new("water particle", water, Mark::Points, frame.water.iter().map(|p| at(p.x))));
}

/// Soil in the colours of a quantity. `unit` is the length of 1 m, px.
pub fn coloured(panel: &mut Panel, frame: &Frame, quantity: Quantity, range: (f64, f64), unit: f64) {
    let look = Look::new(BLACK, Marker::Box).radius(radius(frame, unit));
    let points: Vec<[f64; 3]> = frame.solid.iter().map(|p| [p.x[0], p.x[1], (quantity.of)(p)]).collect();
    cloud(panel, &points, range, look);
}

/// The outline at the start.
pub fn outline(panel: &mut Panel, site: &Site) {
    panel.add(Series::line("soil at the start", OUTLINE, site.closed()));
}

/// The level of the water.
pub fn water_level(panel: &mut Panel, frame: &Frame) {
    panel.add(Series::line("water level", SURFACE, level(frame)));
}

/// Level of the water in each column of cells that has some, m: the top of its highest wet cell, or the part of it
/// that is wet.
pub fn level(frame: &Frame) -> Vec<(f64, f64)> {
    let [columns, rows] = frame.cells;
    let top = |i: usize| {
        let wet = |j: usize| frame.cell.get(j * columns + i).map_or(0.0, |c| (c.saturation * c.soil).clamp(0.0, 1.0));
        let highest = (0..rows).rev().find(|j| wet(*j) > 0.01)?;
        Some(((i as f64 + 0.5) * frame.size, (highest as f64 + wet(highest)) * frame.size))
    };
    (0..columns).filter_map(top).collect()
}

/// The colour bar of a quantity, to stand in a row of its own.
pub fn bar(quantity: Quantity, range: (f64, f64), row: usize) -> Panel {
    scale(quantity.label, quantity.column, range, row)
}

/// A colour bar with its words, to stand in a row of its own.
pub fn scale(label: &str, column: &'static str, (low, high): (f64, f64), row: usize) -> Panel {
    let axis = Axis::linear("", column).range(low, high);
    let mut bar = Panel { row, height: Some(13.0), ..Panel::new(label, axis, bare(0.0, 1.0)) };
    for number in 0..STEPS {
        let at = |k: usize| k as f64 / STEPS as f64;
        // Each reaches under the next, or seams would be seen.
        let [start, end] = [number, (number + 2).min(STEPS)].map(|k| low + at(k) * (high - low));
        let look = Look::new(colours::at(at(number) + 0.5 / STEPS as f64), Marker::Dot);
        let corners = [(start, 0.0), (end, 0.0), (end, 1.0), (start, 1.0)].map(|(x, y)| Point::new(x, y));
        bar.add(Series::new("", look, Mark::Area, corners).unlisted());
    }
    bar
}

#[cfg(test)]
mod tests {
    use super::super::tests::site;
    use super::*;
    use crate::frames::made_up;

    #[test]
    fn a_window_holds_what_has_slid() {
        let shots = made_up::shots(1, 3);
        let window = Window::of(&site(), &shots);
        let far = shots[3].frame.solid.iter().map(|p| p.x[0]).fold(0.0, f64::max);
        assert!(far > 9.5 && window.x.1 > far && window.x.0 < 0.0);
        assert!(window.height(2) < 0.5 * window.height(1));
    }

    #[test]
    fn the_level_falls_from_the_tank_to_the_front() {
        let frame = &made_up::shots(2, 0)[1].frame;
        let level = level(frame);
        assert!((level[0].1 - 2.3).abs() < 0.2 && level.last().is_some_and(|l| l.0 > 8.0 && l.1 < 0.3), "{level:?}");
        assert!(level.windows(2).all(|pair| pair[1].1 <= pair[0].1 + 1e-12));
    }
}

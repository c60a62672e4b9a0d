//! Effective stress paths of points (the paper's Fig. 9) and the line on which soil fails.

use std::path::Path;

use super::clock;
use crate::levee::strength::Strength;
use crate::report::numbers::{brief, exact};
use crate::report::plots::axis::Axis;
use crate::report::plots::figure::{Figure, Mark, Panel, Point, Series, share_x, share_y};
use crate::report::plots::look::{self, BLACK, Dash, GREY, Look, Marker};
use crate::report::plots::write_drawn;
use crate::report::{ReportError, tables};

/// Panels side by side.
const COLUMNS: usize = 3;
const START: Look = Look::new(BLACK, Marker::Circle).radius(4.5);
const FAILURE: Look = Look::new(BLACK, Marker::Star).radius(5.5);
const LINE: Look = Look::new(BLACK, Marker::Dot).width(2.0).dash(Dash::Dashed);

/// The path of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct StressPath {
    /// Its name: `S1`.
    pub name: String,
    /// Time on the reader's clock, s, and effective stress xx, yy, zz, xy, Pa, tension positive.
    pub points: Vec<(f64, [f64; 4])>,
}

/// Mean stress s' = -(xx + yy)/2 and shear stress t, the radius of the circle, in the plane, kPa.
pub fn invariants([xx, yy, _, xy]: [f64; 4]) -> (f64, f64) {
    (-0.5e-3 * (xx + yy), 1e-3 * (0.5 * (xx - yy)).hypot(xy))
}

/// All paths in one panel.
pub fn figure(paths: &[StressPath], strength: Strength, failure_s: Option<f64>) -> Figure {
    let mut panel = empty("");
    for (place, path) in paths.iter().enumerate() {
        line(&mut panel, path, look::nth(place));
    }
    for path in paths {
        marks(&mut panel, path, failure_s);
    }
    let panels = finished(vec![panel], strength);
    let title = "Effective stress paths".to_owned();
    Figure {
        name: "levee-paths",
        title,
        caption: caption(strength, failure_s),
        height: 420.0,
        panels,
        missing: missing(paths),
    }
}

/// A panel for each path, all with the same axes: where they lie over each other in [`figure`].
pub fn each(paths: &[StressPath], strength: Strength, failure_s: Option<f64>) -> Figure {
    let last = paths.len().saturating_sub(1) / COLUMNS;
    let mut panels: Vec<Panel> = Vec::new();
    for (place, path) in paths.iter().enumerate() {
        let mut panel = Panel { row: place / COLUMNS, ..empty(&path.name) };
        if place + COLUMNS < paths.len() {
            panel.x.label.clear();
        }
        if place % COLUMNS > 0 {
            panel.y.label.clear();
        }
        line(&mut panel, path, look::nth(0));
        marks(&mut panel, path, failure_s);
        for series in &mut panel.series {
            series.in_legend &= series.label != path.name;
        }
        panels.push(panel);
    }
    let mut panels = finished(panels, strength);
    let spare = (COLUMNS - paths.len() % COLUMNS) % COLUMNS;
    panels.extend((0..spare).map(|_| Panel { row: last, ..Panel::blank() }));
    let title = "Effective stress path of every point".to_owned();
    Figure {
        name: "levee-paths-each",
        title,
        caption: caption(strength, failure_s),
        height: 190.0,
        panels,
        missing: missing(paths),
    }
}

/// Writes both with their numbers. Returns the texts of the SVGs, that of all paths in one panel first.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(
    paths: &[StressPath],
    strength: Strength,
    failure_s: Option<f64>,
    folder: &Path,
) -> Result<[String; 2], ReportError> {
    let figures = [figure(paths, strength, failure_s), each(paths, strength, failure_s)];
    let rows = paths.iter().flat_map(|path| {
        path.points.iter().map(|(time, stress)| {
            let (s, t) = invariants(*stress);
            [vec![path.name.clone()], [*time, s, t].map(exact).to_vec()].concat()
        })
    });
    let rows: Vec<Vec<String>> = rows.collect();
    for figure in &figures {
        tables::table(&folder.join(format!("{}.csv", figure.name)), "point,time_s,s_kpa,t_kpa", rows.clone())?;
    }
    Ok([write_drawn(&figures[0], folder)?, write_drawn(&figures[1], folder)?])
}

fn empty(title: &str) -> Panel {
    Panel::new(title, Axis::linear("mean stress s' (kPa)", "s_kpa"), Axis::linear("shear stress t (kPa)", "t_kpa"))
}

fn line(panel: &mut Panel, path: &StressPath, look: Look) {
    panel.add(Series::line(path.name.clone(), look, path.points.iter().map(|(_, stress)| invariants(*stress))));
}

/// Where a path starts, with its name, and where it is at failure.
fn marks(panel: &mut Panel, path: &StressPath, failure_s: Option<f64>) {
    let mark = |(_, stress): &(f64, [f64; 4])| {
        let (s, t) = invariants(*stress);
        Point::new(s, t)
    };
    let named = |point: Point| point.open(true).note(path.name.clone());
    panel.add(Series::new("start", START, Mark::Points, path.points.first().map(mark).map(named)));
    let at_failure = failure_s.and_then(|time| path.points.iter().rev().find(|(t, _)| *t <= time));
    panel.add(Series::new("at failure", FAILURE, Mark::Points, at_failure.map(mark)));
}

/// Panels with the same axes from zero on, and the line of failure.
fn finished(mut panels: Vec<Panel>, strength: Strength) -> Vec<Panel> {
    let highest = |all: Vec<f64>| all.into_iter().filter(|v| v.is_finite()).fold(1e-3, f64::max);
    let right = 1.06 * panels.iter().map(|p| highest(p.all_x())).fold(0.0, f64::max);
    let left = panels.iter().flat_map(Panel::all_x).filter(|s| s.is_finite()).fold(0.0, f64::min);
    let top = (1.12 * panels.iter().map(|p| highest(p.all_y())).fold(0.0, f64::max)).max(0.7 * strength.limit(right));
    let label = "failure, t = c cos \u{3c6} + s' sin \u{3c6}";
    for panel in &mut panels {
        panel.x.range = Some((left - 0.02 * right, right));
        panel.y.range = Some((0.0, top));
        let ends = [left - 0.02 * right, right].map(|s| (s, strength.limit(s)));
        panel.add(Series::line(label, LINE, ends).guide());
        panel.add(
            Series::line("", Look::new(GREY, Marker::Dot).width(0.8), [(0.0, 0.0), (0.0, top)]).unlisted().guide(),
        );
    }
    share_x(&mut panels);
    share_y(&mut panels);
    panels
}

fn caption(strength: Strength, failure_s: Option<f64>) -> String {
    let at = failure_s.map_or("No failure.".to_owned(), |time| format!("Stars: at failure, {}.", clock(time)));
    format!(
        "Mean s' and radius t of the circle of effective stress in the plane, compression positive. Rings: start. {at} \
         The line of failure is that of c = {} kPa and an angle of friction of {} degrees.",
        brief(strength.cohesion_kpa, 3),
        brief(strength.friction_deg, 3)
    )
}

fn missing(paths: &[StressPath]) -> Vec<String> {
    let none = paths.iter().filter(|p| p.points.is_empty());
    none.map(|p| format!("Stress paths: nothing was recorded at {}.", p.name)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::folder;
    use super::*;
    use crate::frames::made_up::FAILURE_S;

    const STRENGTH: Strength = Strength { cohesion_kpa: 0.5, friction_deg: 30.0 };

    /// Unloads along s' until the line is near, and follows it down.
    fn path(number: usize) -> StressPath {
        let first = 8.0 + 4.5 * number as f64;
        let stress = |k: i32| {
            let share = f64::from(k) / 200.0;
            let s = first * (1.0 - 0.8 * share);
            let t =
                (0.32 * first + 0.15 * first * share).min(0.97 * STRENGTH.limit(s)) + 0.1 * (f64::from(k) * 0.9).sin();
            let time = 21_600.0 + (FAILURE_S - 21_600.0) * 1.1 * share;
            (time, [1e3 * (-s + 0.8 * t), 1e3 * (-s - 0.8 * t), -0.6e3 * s, 0.6e3 * t])
        };
        StressPath { name: format!("S{}", number + 1), points: (0..=200).map(stress).collect() }
    }

    #[test]
    fn stresses_become_s_and_t() {
        let (s, t) = invariants([-1e3, -3e3, -9e9, 1e3]);
        assert!((s - 2.0).abs() < 1e-12 && (t - 2.0_f64.sqrt()).abs() < 1e-12);
        assert!((STRENGTH.limit(10.0) - 5.433_012_7).abs() < 1e-6);
    }

    #[test]
    fn every_path_is_drawn_with_its_start_and_failure() {
        let (folder, _own) = folder();
        let mut paths: Vec<StressPath> = (0..7).map(path).collect();
        let [all, each] = write(&paths, STRENGTH, Some(FAILURE_S), &folder).expect("pictures");
        for part in ["S7", "at failure", "start", "shear stress t (kPa)", "mean stress s"] {
            assert!(all.contains(part) && each.contains(part), "{part}");
        }
        let table = std::fs::read_to_string(folder.join("levee-paths.csv")).expect("a table");
        assert_eq!(table.lines().count(), 1 + 7 * 201);
        paths[1].points.clear();
        let bare = figure(&paths, STRENGTH, None);
        assert_eq!(bare.missing, ["Stress paths: nothing was recorded at S2."]);
        assert!(bare.caption.contains("No failure."));
    }
}

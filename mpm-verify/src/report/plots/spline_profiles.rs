//! Pore pressure over height from quasi-static quadratic B-splines on the coarsest mesh, and how far it is off.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look;
use crate::report::select::{Cases, Exact, same_time};
use crate::study::CaseResult;

/// Time factors shown.
const TIMES: [f64; 6] = [0.01, 0.05, 0.1, 0.2, 0.5, 1.0];
/// The mesh shown, m, and particles per cell.
const SHOWN: (f64, usize) = (0.1, 9);

/// Computed points on the exact lines, and their difference.
pub fn figure(cases: &Cases) -> Figure {
    let name = "isochrones-bspline2";
    let height = || Axis::linear("height (m)", "height_m").range(-0.03, 1.03);
    let x = Axis::linear("pore pressure p/p₀", "p_over_p0").range(-0.02, 1.08);
    let mut whole = Panel::new("pore pressure", x, height());
    let mut gap = Panel::new("error of the pore pressure", Axis::log("|p \u{2212} p_exact|/p₀", "p_over_p0"), height());
    let mut missing = Vec::new();
    match cases.get("surface", SHOWN.0, SHOWN.1) {
        Some(case) => fill(&mut whole, &mut gap, case),
        None => missing.push(format!("{name}: no quasi-static bspline2 run with L = {} m", SHOWN.0)),
    }
    Figure {
        name,
        title: format!("Pore pressure from ten quadratic cells (quasi-static bspline2, L = {} m)", SHOWN.0),
        caption: "Points: computed, one per cell. Lines of the same colour: exact, finite bulk modulus of the pore water. Early on \
                  the drained layer is as thin as a cell: pressures are then off by more than U, \
                  which is an integral over them."
            .to_owned(),
        height: 400.0,
        panels: vec![whole, gap],
        missing,
    }
}

fn fill(whole: &mut Panel, gap: &mut Panel, case: &CaseResult) {
    let exact = Exact::of(case).map(|e| e.compressible);
    for (place, tv) in TIMES.into_iter().enumerate() {
        let Some(profile) = case.profiles.iter().find(|p| same_time(p.tv, tv)) else { continue };
        let look = look::nth(place).radius(3.0).width(1.3);
        let time = case.degrees.iter().find(|d| same_time(d.tv, tv)).map_or(f64::NAN, |d| d.time_s);
        let undrained = exact.map_or(1.0, |e| e.undrained);
        if let Some(exact) = exact {
            let heights = (0..=100).map(|k| f64::from(k) / 100.0 * exact.height);
            let line = heights.map(|y| (exact.pressure(y, time) / undrained, y));
            whole.add(Series::line(format!("exact, Tv = {tv}"), look, line).unlisted());
        }
        let points = profile.rows.iter().map(|r| Point::new(r.pressure_pa / undrained, r.height_m).open(true));
        whole.add(Series::new(format!("Tv = {tv}"), look, Mark::Points, points));
        let off =
            profile.rows.iter().map(|r| Point::new((r.pressure_pa - r.compressible_pa).abs() / undrained, r.height_m));
        gap.add(Series::new(format!("Tv = {tv}"), look, Mark::LinePoints, off).unlisted());
    }
}

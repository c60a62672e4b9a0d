//! Degree of consolidation over time (the paper's Fig. 4c), and how far it is from Terzaghi's.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{BLACK, BLUE, Dash, GREEN, Look, Marker, RED};
use crate::report::select::{Cases, Exact, LOADS, stands_in};
use crate::study::{CaseResult, Degree};

/// First time factor of the picture.
const FIRST: f64 = 1e-3;

/// U with the axis downwards, as settlement is drawn, and U - U_Terzaghi.
pub fn figure(cases: &Cases) -> Figure {
    let time = || Axis::log("time factor Tv", "tv").range(FIRST, 1.3);
    let down = Axis::linear("degree of consolidation U", "u").range(1.0, 0.0);
    let mut whole = Panel::new("degree of consolidation", time(), down);
    let mut gap = Panel::new("difference from Terzaghi", time(), Axis::linear("U \u{2212} U of Terzaghi", "u"));
    let (mut missing, mut stand_in) = (Vec::new(), String::new());
    let shown: Vec<&CaseResult> = LOADS.iter().filter_map(|(load, _)| cases.paper(load)).collect();
    let looks = [Look::new(RED, Marker::Circle), Look::new(BLUE, Marker::Square)];
    let computed: Vec<_> =
        LOADS.into_iter().zip(looks).map(|((l, words), look)| (cases.paper(l), words, look)).collect();
    // Lines first, so that the exact ones lie on them and the markers on top.
    for (case, words, look) in &computed {
        match case {
            Some(case) => {
                stand_in = stands_in(case);
                history(&mut whole, &mut gap, case, look.width(0.9), words);
            }
            None => missing.push(format!("consolidation: no run with the {words}")),
        }
    }
    if let Some(case) = shown.first() {
        references(&mut whole, &mut gap, case);
    }
    for (case, words, look) in &computed {
        let degrees = case.map_or(&[][..], |c| c.degrees.as_slice());
        let samples = |y: fn(&Degree) -> f64| {
            let points = degrees.iter().map(|d| Point::new(d.tv, y(d)).open(true));
            Series::new(format!("computed, {words}"), *look, Mark::Points, points)
        };
        whole.add(samples(|d| d.u));
        gap.add(samples(|d| d.u - d.u_terzaghi));
    }
    let setting = shown.first().map_or(String::new(), |c| format!(", L = {} m, {} per cell", c.mesh_m, c.ppc));
    Figure {
        name: "consolidation",
        title: format!("Consolidation curve{setting} (the paper's Fig. 4c)"),
        caption: format!(
            "Thin lines: computed history, jagged where the wave that opening the drain makes has not died out; \
             markers: the nine sample times at which errors are taken. With compressible \
             water (dashed) the share (q \u{2212} p₀)/q of the settlement is there at once, so that U starts above \
             Terzaghi's.{stand_in}"
        ),
        height: 360.0,
        panels: vec![whole, gap],
        missing,
    }
}

/// Time factor and U of both exact solutions, Terzaghi's first: dense where the column is the built-in one, else at the sample times.
pub(super) fn exact(case: &CaseResult) -> Vec<[f64; 3]> {
    match (Exact::of(case), case.degrees.first()) {
        (Some(exact), Some(first)) => {
            let unit = first.time_s / first.tv;
            let times = (0..=160).map(|k| FIRST * (1.0 / FIRST).powf(f64::from(k) / 160.0));
            let at = |tv: f64| {
                let (t, c) = (exact.terzaghi, exact.compressible);
                [tv, t.relative_settlement(tv * unit), c.relative_settlement(tv * unit)]
            };
            times.map(at).collect()
        }
        _ => case.degrees.iter().map(|d| [d.tv, d.u_terzaghi, d.u_compressible]).collect(),
    }
}

fn references(whole: &mut Panel, gap: &mut Panel, case: &CaseResult) {
    let rows = exact(case);
    let (solid, dashed) = (Look::new(BLACK, Marker::Dot), Look::new(GREEN, Marker::Dot).dash(Dash::Dashed).width(2.2));
    let (terzaghi, compressible) = ("Terzaghi, incompressible water", "exact, finite K_w");
    whole.add(Series::line(terzaghi, solid, rows.iter().map(|r| (r[0], r[1]))));
    whole.add(Series::line(compressible, dashed, rows.iter().map(|r| (r[0], r[2]))));
    gap.add(Series::line(terzaghi, solid, rows.iter().map(|r| (r[0], 0.0))));
    gap.add(Series::line(compressible, dashed, rows.iter().map(|r| (r[0], r[2] - r[1]))));
}

/// The computed history, and its difference from Terzaghi's solution where that is known at any time.
fn history(whole: &mut Panel, gap: &mut Panel, case: &CaseResult, look: Look, words: &str) {
    let history = case.history.iter().filter(|h| h.tv >= FIRST);
    let label = format!("computed history, {words}");
    whole.add(Series::line(label.clone(), look, history.clone().map(|h| (h.tv, h.u))).unlisted());
    if let Some(exact) = Exact::of(case) {
        let rows = history.map(|h| (h.tv, h.u - exact.terzaghi.relative_settlement(h.time_s)));
        gap.add(Series::line(label, look, rows).unlisted());
    }
}

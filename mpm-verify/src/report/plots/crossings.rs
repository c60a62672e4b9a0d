//! Errors on the finest mesh over the number of particles, with the number of cell crossings at each point: evidence on
//! the paper's explanation by crossings.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series, share_y};
use super::look::{BLUE, Dash, Look, Marker, RED};
use crate::report::select::{Cases, LOADS, Reference};

/// The mesh on which the paper saw more particles raise the error, m.
const FINE: f64 = 0.01;

/// Largest errors against both exact solutions, one panel per load.
pub fn figure(cases: &Cases) -> Figure {
    let near = |mesh: &f64| (mesh / FINE).ln().abs();
    let mesh = cases.meshes().into_iter().min_by(|a, b| near(a).total_cmp(&near(b)));
    let particles = cases.particles();
    let (least, most) =
        (particles.first().map_or(1.0, |n| *n as f64 / 2.5), particles.last().map_or(2.0, |n| *n as f64 * 2.5));
    let mut missing = Vec::new();
    let mut panels = Vec::new();
    for (load, words) in LOADS {
        let ticks = cases.particles().into_iter().map(|n| (n as f64, n.to_string())).collect();
        let x = Axis::log("particles per cell", "ppc").range(least, most).named(ticks);
        let mut panel = Panel::new(words, x, Axis::log("max |U/U_exact \u{2212} 1| (%)", "max_error_percent"));
        let looks = [Look::new(RED, Marker::Circle), Look::new(BLUE, Marker::Square).dash(Dash::Dashed)];
        for (reference, look) in Reference::BOTH.into_iter().zip(looks) {
            let own = cases.particles().into_iter().filter_map(|ppc| cases.get(load, mesh?, ppc));
            let points = own.map(|r| {
                let error = 100.0 * reference.largest_signed(r, 0.0);
                Point::new(r.ppc as f64, error.abs()).open(error > 0.0).note(note(reference, r.cell_crossings))
            });
            panel.add(Series::new(
                format!("relative to {}", reference.words()),
                look.radius(5.0),
                Mark::LinePoints,
                points,
            ));
        }
        if panel.is_empty() {
            missing.push(format!("crossings: no run with the {words}"));
        }
        panels.push(panel);
    }
    share_y(&mut panels);
    let title = mesh.map_or_else(|| "no meshes".to_owned(), |m| format!("L = {m} m"));
    Figure {
        name: "crossings",
        title: format!("Does crossing of cells explain the error? {title}"),
        caption:
            "Written at the errors relative to Terzaghi: how often a particle of either layer changed its cell in that \
                  run. Filled: settled too little at the worst time; open: too much."
                .to_owned(),
        height: 350.0,
        panels,
        missing,
    }
}

/// The number of crossings, once per run: at the error relative to Terzaghi.
fn note(reference: Reference, count: u64) -> String {
    match (reference, count) {
        (Reference::Compressible, _) => String::new(),
        (Reference::Terzaghi, 1) => "1 crossing".to_owned(),
        (Reference::Terzaghi, _) => format!("{count} crossings"),
    }
}

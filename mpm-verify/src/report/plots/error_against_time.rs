//! The error of U over time, one line per mesh.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series, share_y};
use super::look;
use crate::norms::LATE_TV;
use crate::report::select::{Cases, LOADS, Reference};

/// |U/U_exact - 1| relative to Terzaghi (left) and relative to the exact solution with finite K_w (right).
pub fn figure(name: &'static str, cases: &Cases, load: &str) -> Figure {
    let words = LOADS.iter().find(|(l, _)| *l == load).map_or(load, |(_, w)| w);
    let ppc = cases.usual_particles().unwrap_or(0);
    let mut panels = Vec::new();
    for reference in Reference::BOTH {
        let time = Axis::log("time factor Tv", "tv").range(0.008, 1.25);
        let error = Axis::log("|U/U_exact \u{2212} 1| (%)", "error_percent");
        let mut panel = Panel::new(&format!("relative to {}", reference.words()), time, error);
        for (place, mesh) in cases.meshes().into_iter().enumerate() {
            let Some(case) = cases.get(load, mesh, ppc) else { continue };
            let points = case.degrees.iter().map(|d| {
                let error = 100.0 * reference.signed(d);
                Point::new(d.tv, error.abs()).open(error > 0.0)
            });
            panel.add(Series::new(format!("L = {mesh} m"), look::nth(place), Mark::LinePoints, points));
        }
        panels.push(panel);
    }
    let empty = panels.iter().all(Panel::is_empty);
    share_y(&mut panels);
    Figure {
        name,
        title: format!("Error of U over time, {words}, {ppc} particles per cell"),
        caption: format!(
            "Filled: the computed column has settled too little; open: too much. The paper calls errors negligible \
             from Tv = {LATE_TV} on."
        ),
        height: 370.0,
        panels,
        missing: if empty { vec![format!("{name}: no run with the {words}")] } else { Vec::new() },
    }
}

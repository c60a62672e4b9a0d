//! Errors over the cell edge, one line per number of particles: the key pictures.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series, share_y};
use super::look::{self, BLACK, Dash, GREY, Look, Marker};
use crate::report::select::{Cases, LOADS, Reference, compressibility};
use crate::study::CaseResult;

/// Largest error over the nine sample times.
pub fn largest(name: &'static str, cases: &Cases, reference: Reference) -> Figure {
    let error = move |r: &CaseResult| reference.largest_signed(r, 0.0);
    let axis = Axis::log("max |U/U_exact \u{2212} 1| (%)", "max_error_percent");
    let mut figure = over_mesh(name, cases, axis, error);
    figure.title = format!("Largest error of U relative to {}", reference.words());
    figure.caption =
        "Filled markers: the settlement is too small at the time of the largest error; open: too large.".to_owned();
    if reference == Reference::Terzaghi {
        floor(&mut figure, cases);
    }
    figure
}

/// File name of the figure of a nightly run.
pub const NIGHTLY: &str = "error-against-mesh";

/// Largest errors of a nightly run as points over the accepted curves, relative to the exact solution with finite K_w.
pub fn over_accepted(cases: &Cases, accepted: impl Fn(&CaseResult) -> Option<f64>) -> Figure {
    let mut figure = largest(NIGHTLY, cases, Reference::Compressible);
    for (panel, (load, _)) in figure.panels.iter_mut().zip(LOADS) {
        for series in panel.series.iter_mut().filter(|series| series.is_data) {
            series.mark = Mark::Points;
        }
        for ppc in cases.particles() {
            let own = cases.meshes().into_iter().filter_map(|mesh| cases.get(load, mesh, ppc));
            let curve: Vec<_> = own.filter_map(|r| Some((r.mesh_m, 100.0 * accepted(r)?))).collect();
            if !curve.is_empty() {
                panel.series.insert(0, Series::line("accepted", Look::new(GREY, Marker::Dot).width(1.0), curve));
            }
        }
        panel.y.range = None;
    }
    share_y(&mut figure.panels);
    figure.title = "Largest error of U against the mesh, tonight (points) and accepted (lines)".to_owned();
    figure.caption.insert_str(0, "Relative to the exact solution with finite K_w. ");
    figure
}

/// RMS error of the pore pressure at Tv = 0.1 relative to the exact solution with finite K_w.
pub fn profile(cases: &Cases) -> Figure {
    let axis = Axis::log("RMS(p \u{2212} p_exact)/p₀ (%)", "profile_error_percent");
    let mut figure = over_mesh("profile-error-against-mesh", cases, axis, |r| -r.profile_error_compressible);
    figure.title =
        "Error of the pore pressure profile at Tv = 0.1 relative to the exact solution with finite K_w".to_owned();
    figure.caption =
        "Root mean square over the cells, as a share of the undrained pore pressure p₀. On fine meshes it \
                      tends to the effects that the exact solution neglects, large strain and inertia."
            .to_owned();
    figure
}

fn over_mesh(name: &'static str, cases: &Cases, axis: Axis, error: impl Fn(&CaseResult) -> f64) -> Figure {
    let mut missing = Vec::new();
    let mut panels = Vec::new();
    for (load, words) in LOADS {
        let mut panel = Panel::new(words, Axis::log("cell edge L (m)", "mesh_m"), axis.clone());
        for (place, ppc) in cases.particles().into_iter().enumerate() {
            let own = cases.meshes().into_iter().filter_map(|mesh| cases.get(load, mesh, ppc));
            let points = own.map(|r| {
                let error = 100.0 * error(r);
                Point::new(r.mesh_m, error.abs()).open(error > 0.0)
            });
            let label = if ppc == 1 { "1 particle per cell".to_owned() } else { format!("{ppc} particles per cell") };
            panel.add(Series::new(label, look_of(place), Mark::LinePoints, points));
        }
        if panel.is_empty() {
            missing.push(format!("{name}: no run with the {words}"));
        }
        panels.push(panel);
    }
    share_y(&mut panels);
    for panel in &mut panels {
        slopes(panel, &[(1, Dash::Dotted), (2, Dash::DashDot)]);
    }
    Figure { name, title: String::new(), caption: String::new(), height: 390.0, panels, missing }
}

/// The look of a number of particles per cell at a place in a row: lines that coincide are seen inside one another.
pub(super) fn look_of(place: usize) -> Look {
    let inside = place.min(2) as f64;
    look::nth(place).radius(6.5 - 1.3 * inside).width(3.2 - inside)
}

/// Lines of some slopes from a little above the data on the coarsest mesh.
pub fn slopes(panel: &mut Panel, slopes: &[(i32, Dash)]) {
    let meshes = panel.all_x();
    let top = panel.all_y().into_iter().filter(|e| e.is_finite()).fold(0.0, f64::max);
    let (fine, coarse) = meshes.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), h| (a.min(*h), b.max(*h)));
    if panel.is_empty() || fine >= coarse {
        return;
    }
    for (slope, dash) in slopes {
        let line = [coarse, fine].map(|h| (h, 1.2 * top * (h / coarse).powi(*slope)));
        panel.add(Series::line(format!("slope {slope}"), Look::new(GREY, Marker::Dot).dash(*dash), line).guide());
    }
}

/// The error that is left on the finest mesh if nothing but the water's compressibility differs from Terzaghi.
fn floor(figure: &mut Figure, cases: &Cases) {
    for panel in &mut figure.panels {
        let meshes = panel.all_x();
        let (Some(case), Some(coarse), Some(fine)) =
            (cases.0.first(), meshes.iter().copied().reduce(f64::max), meshes.iter().copied().reduce(f64::min))
        else {
            continue;
        };
        let look = Look::new(BLACK, Marker::Dot).dash(Dash::Dashed).width(1.2);
        let line = [coarse, fine].map(|h| (h, 100.0 * compressibility(case)));
        panel.add(Series::line("difference of the exact solutions", look, line));
    }
    figure.caption.push_str(
        " The dashed line is the difference of the exact solutions with finite and with infinite K_w: errors relative to Terzaghi \
         tend to it on fine meshes. Below it two errors of opposite sign cancel.",
    );
}

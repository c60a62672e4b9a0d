//! Errors over the cell edge of every integrator and every kind of shape functions.

use super::axis::Axis;
use super::error_against_mesh::slopes;
use super::figure::{Figure, Mark, Panel, Point, Series, share_x, share_y};
use super::look::{self, BLUE, GREEN, Look, Marker, PURPLE, RED};
use crate::report::select::{INTEGRATORS, of_schemes};
use crate::study::CaseResult;

/// Comparison of the shape functions, the same in every picture that compares them.
pub const LOOKS: [(&str, Look); 4] = [
    ("centre", Look::new(BLUE, Marker::Circle)),
    ("linear", Look::new(RED, Marker::Square)),
    ("gimp", Look::new(GREEN, Marker::Up)),
    ("bspline2", Look::new(PURPLE, Marker::Diamond)),
];

/// The look of some shape functions.
pub fn look_of(scheme: &str) -> Look {
    LOOKS.iter().find(|(name, _)| *name == scheme).map_or_else(|| look::nth(4), |(_, look)| *look)
}

/// Largest error relative to the exact solution with finite K_w.
pub fn largest(results: &[CaseResult]) -> Figure {
    let mut figure = figure("error-of-all-schemes", results, |r| r.max_error_compressible);
    figure.title = "Largest error of U relative to the exact solution with finite K_w, every scheme".to_owned();
    figure
}

/// Error of the pressure profile at Tv = 0.1 relative to the exact solution with finite K_w.
pub fn profile(results: &[CaseResult]) -> Figure {
    let mut figure = figure("profile-error-of-all-schemes", results, |r| r.profile_error_compressible);
    figure.title =
        "Error of the pore pressure profile at Tv = 0.1 relative to the exact solution with finite K_w, every scheme"
            .to_owned();
    figure
}

/// One panel per integrator, one line per kind of shape functions.
fn figure(name: &'static str, results: &[CaseResult], error: fn(&CaseResult) -> f64) -> Figure {
    let schemes = of_schemes(results);
    let mut missing = Vec::new();
    let mut panels = Vec::new();
    let profile = name.starts_with("profile");
    let label = if profile { "RMS(p \u{2212} p_exact)/p₀" } else { "max |U/U_exact \u{2212} 1|" };
    let column = if profile { "profile_error" } else { "max_error" };
    for integrator in INTEGRATORS {
        let ppc = schemes.iter().find(|r| r.integrator == integrator).map_or(4, |r| r.ppc);
        let title = format!("{integrator}, {ppc} per cell");
        let mut panel = Panel::new(&title, Axis::log("cell edge L (m)", "mesh_m"), Axis::log(label, column));
        for (place, (scheme, look)) in LOOKS.into_iter().enumerate() {
            // Lines that coincide are seen inside one another.
            let look = look.radius(6.5 - 1.2 * place as f64).width(3.6 - 0.8 * place as f64);
            let own = schemes.iter().filter(|r| r.integrator == integrator && r.scheme == scheme);
            let points = own.map(|r| Point::new(r.mesh_m, error(r)));
            panel.add(Series::new(scheme, look, Mark::LinePoints, points));
        }
        if panel.is_empty() {
            missing.push(format!("{name}: no {integrator} run"));
        }
        panels.push(panel);
    }
    share_x(&mut panels);
    share_y(&mut panels);
    for panel in &mut panels {
        slopes(panel, &[(2, look::Dash::DashDot), (4, look::Dash::Dotted)]);
    }
    Figure {
        name,
        title: String::new(),
        caption:
            "Traction on the free surface. Explicit and semi-implicit runs carry inertia and large strain, which the exact \
                  solution leaves out: they level off. Quasi-static runs are at small strain, as the exact solution is."
                .to_owned(),
        height: 400.0,
        panels,
        missing,
    }
}

//! The study at a glance: consolidation, pore pressure and largest errors of the paper's scheme and of this program's beside the exact
//! solution.

use super::axis::Axis;
use super::error_against_mesh::look_of;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{BLACK, Dash, Look, Marker};
use super::{consolidation, isochrones};
use crate::report::select::{Cases, PAPER, Reference, same_time};
use crate::study::CaseResult;

/// File name of the figure without ending.
pub const NAME: &str = "at-a-glance";

/// Time factors of the pressure profiles.
const TIMES: [f64; 4] = [0.05, 0.2, 0.5, 1.0];
/// Numbers of particles per cell, as the paper varies them.
const PARTICLES: [usize; 3] = [1, 4, 9];
/// Most points of one profile.
const MOST: usize = 12;

/// A scheme of the picture.
struct Scheme {
    name: &'static str,
    /// Integrator and shape functions.
    family: &'static str,
    load: &'static str,
    about: &'static str,
    /// Mesh (m) and particles per cell of the curves.
    shown: (f64, usize),
    dash: Dash,
}

const SCHEMES: [Scheme; 2] = [
    Scheme {
        name: "the paper's scheme",
        family: "explicit-centre",
        load: "particles",
        about: "explicit, values at the cell centre, traction on the boundary particles, half a particle spacing below the surface",
        shown: PAPER,
        dash: Dash::Solid,
    },
    Scheme {
        name: "ours",
        family: "quasi-static-bspline2",
        load: "surface",
        about: "quasi-static, quadratic B-splines, traction on the free surface",
        shown: (0.1, 9),
        dash: Dash::Dashed,
    },
];

impl Scheme {
    /// Points of the scheme with a number of particles per cell.
    fn series(&self, ppc: usize, mark: Mark, points: impl IntoIterator<Item = Point>) -> Series {
        let place = PARTICLES.iter().position(|known| *known == ppc).unwrap_or(PARTICLES.len());
        Series::new(format!("{}, {ppc} per cell", self.name), look_of(place).dash(self.dash), mark, points)
    }
}

/// U over Tv, pressure over height, largest error over mesh.
pub fn figure(results: &[CaseResult]) -> Figure {
    let ticks = [0.01, 0.1, 1.0].map(|tv| (tv, tv.to_string())).to_vec();
    let time = Axis::log("time factor Tv", "x").range(7e-3, 1.4).named(ticks);
    let mut degree = Panel::new("degree of consolidation", time, Axis::linear("U", "y").range(1.0, 0.0));
    let pressure = Axis::linear("pore pressure over load, p/q", "x").range(0.0, 1.1);
    let mut pressure = Panel::new("pore pressure at Tv = 0.05, 0.2, 0.5, 1", pressure, Axis::linear("height (m)", "y"));
    let error = Axis::log("max |U/U_exact \u{2212} 1|", "y");
    let mut errors = Panel::new("largest error of U", Axis::log("cell edge L (m)", "x"), error);
    let (mut missing, mut settings) = (Vec::new(), Vec::new());
    for scheme in &SCHEMES {
        let cases = Cases::of_family(results, scheme.family);
        let Some(case) = cases.nearest(scheme.load, scheme.shown) else {
            missing.push(format!("{NAME}: no run of {} with traction on {}", scheme.family, scheme.load));
            continue;
        };
        settings.push(format!(" Curves of {} with L = {} m: {}.", scheme.name, case.mesh_m, scheme.about));
        curves(&mut degree, &mut pressure, scheme, case);
        for ppc in PARTICLES {
            let own = cases.meshes().into_iter().filter_map(|mesh| cases.get(scheme.load, mesh, ppc));
            let points = own.map(|r| Point::new(r.mesh_m, r.max_error_compressible));
            errors.add(scheme.series(ppc, Mark::LinePoints, points));
        }
    }
    Figure {
        name: NAME,
        title: "The study at a glance: one-dimensional consolidation".to_owned(),
        caption: format!(
            "Lines: the exact solution with finite bulk modulus of the pore water. Markers: computed.{}",
            settings.concat()
        ),
        height: 300.0,
        panels: vec![degree, pressure, errors],
        missing,
    }
}

/// A run beside the exact solution, which is drawn once.
fn curves(degree: &mut Panel, pressure: &mut Panel, scheme: &Scheme, case: &CaseResult) {
    let exact = Look::new(BLACK, Marker::Dot).width(1.3);
    let first = degree.series.is_empty();
    if first {
        let line = consolidation::exact(case).into_iter().map(|[tv, _, u]| (tv, u));
        degree.add(Series::line("exact", exact, line));
    }
    let points = case.degrees.iter().map(|d| Point::new(d.tv, d.u).open(first));
    degree.add(scheme.series(case.ppc, Mark::Points, points).unlisted());
    let load = isochrones::load(case);
    for profile in TIMES.iter().filter_map(|tv| case.profiles.iter().find(|p| same_time(p.tv, *tv))) {
        if first {
            let line = isochrones::exact(profile, case, Reference::Compressible);
            pressure.add(Series::line("exact", exact, line));
        }
        let points = isochrones::computed(profile, load, MOST).map(|p| p.open(first));
        pressure.add(scheme.series(case.ppc, Mark::Points, points).unlisted());
    }
}

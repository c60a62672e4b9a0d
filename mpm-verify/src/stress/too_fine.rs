//! Finer and finer, with more and more particles: the paper found larger errors at L = 0.01 m with 9 particles per cell
//! than with 4, and blamed particles that cross cells. Here on to L = 0.0025 m and 25 per cell.

use mpm_core::scene::{Dimension, Integrator, Scene, ShapeChoice, Start, Until};
use mpm_core::stability::stable_limit;

use super::case::{Case, Point};
use super::low_permeability::error;
use super::scheme::Scheme;
use crate::error::Error::{self, Unfit};

/// The case.
pub const CASE: Case = Case {
    name: "too-fine",
    about: "Table 1's column on cells of 0.02 to 0.0025 m with 4 to 25 particles each: error beside the exact solution",
    why: "Errors fall down to L = 0.0025 m with 25 particles per cell, where hardly any particle crosses a cell: the \
          opposite trend at L = 0.01 m is that of comparing compressible water with Terzaghi's series, not of \
          crossings. Explicit runs are looked at as far as their steps reach; semi-implicit errors are of the first \
          hundreds of their steps.",
    parameter: "L (m)",
    column: "mesh_m",
    dimension: Dimension::Column,
    measures: "error, share of final settlement and of p_0",
    holds: 0.01,
    breaks: 0.2,
    schemes: &FINE,
    run: |scheme| MESHES.iter().map(|(cell, ppc)| Point { at: *cell, found: on(scheme, *cell, *ppc) }).collect(),
};

/// The paper's scheme, and one of each kind beside it: the others differ from these by less than their errors.
const FINE: [Scheme; 7] = [
    Scheme::new(Integrator::Explicit, ShapeChoice::Centre),
    Scheme::new(Integrator::Explicit, ShapeChoice::Linear),
    Scheme::new(Integrator::Explicit, ShapeChoice::Bspline2),
    Scheme::new(Integrator::SemiImplicit, ShapeChoice::Centre),
    Scheme::new(Integrator::SemiImplicit, ShapeChoice::Bspline2),
    Scheme::new(Integrator::QuasiStatic, ShapeChoice::Centre),
    Scheme::new(Integrator::QuasiStatic, ShapeChoice::Bspline2),
];

/// Cell edge (m) and particles per cell.
const MESHES: [(f64, usize); 4] = [(0.02, 9), (0.01, 9), (0.005, 16), (0.0025, 25)];
/// Steps times particles after which a run ends.
const MOST_WORK: f64 = 2.5e8;

fn on(scheme: &Scheme, cell: f64, ppc: usize) -> Result<f64, Error> {
    let mut scene: Scene = scheme.on(&crate::scenes::terzaghi())?;
    scene = scene.edited(|scene| {
        (scene.cell, scene.cells[1], scene.particles_per_cell) = (cell, (scene.height / cell).round() as usize, ppc);
        (scene.history, scene.start, scene.tolerance) = (0, Start::UndrainedEquilibrium, 1e-6);
    })?;
    let per_factor = scene.time_per_factor().ok_or(Unfit("dry"))?;
    let steps = MOST_WORK / (scene.cells[1] * scene.particles_per_direction()) as f64;
    let reach = (steps * scene.safety * stable_limit(&scene)).min(per_factor);
    let times = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0].map(|f| f * per_factor);
    // What a step of first order in time does in its first hundred steps is no matter of the mesh.
    let early = 100.0 * scene.safety * stable_limit(&scene);
    let early = if early.is_finite() { early } else { 0.0 };
    let times: Vec<f64> = times.into_iter().filter(|t| (early..=1.001 * reach).contains(t)).collect();
    let Some(end) = times.last().copied() else {
        let steps = per_factor / 1e3 / (scene.safety * stable_limit(&scene));
        return Err(Error::Found(format!("{steps:.0e} steps for T = 0.001")));
    };
    error(&scene.edited(|scene| (scene.observe_times, scene.stages[0].until) = (times, Until::Time(end)))?)
}

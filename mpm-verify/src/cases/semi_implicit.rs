//! Table 1's column with an implicit pore pressure: its error at the step it chooses, and its order.

use mpm_core::scene::{Fields, Integrator, Scene, ShapeChoice, StepChoice};
use mpm_core::stability::stable_limit;

use super::degree::Degree;
use super::terzaghi::{FIRST_ORDER, HALVINGS, PARTICLE_COUNTS};
use super::{Error, FASTER, Mutant, Outcome, Program, Unfit, faster, integrator, scheme, sound, terzaghi};
use crate::exact::dynamic::DynamicColumn;
use crate::exact::terzaghi::Terzaghi;
use crate::experiment::refinement::{MESH, Refinement};
use crate::norms::LATE_TV;

/// The study's default scene, L = 0.02, at 0.9 of its limit.
pub const AT_ITS_LIMIT: Program = Program {
    name: "semi-implicit",
    about: "consolidation with implicit pressure at 0.9 of its limit, from Tv = 0.01",
    run: || at_its_limit(sound),
    mutant: Some(Mutant { what: FASTER, run: || at_its_limit(faster) }),
};

/// The order of the default shape.
pub const CENTRE: Program = Program {
    name: "semi-implicit-order",
    about: "the same from Tv = 0.1, steps that fall with L^2: order 2",
    run: || order(ShapeChoice::Centre, 5e-5, sound),
    mutant: Some(Mutant { what: FASTER, run: || order(ShapeChoice::Centre, 5e-5, faster) }),
};

/// The order of quadratic B-splines.
pub const SPLINES: Program = Program {
    name: "semi-implicit-bspline2",
    about: "the same with quadratic B-splines",
    run: || order(ShapeChoice::Bspline2, 3e-4, sound),
    mutant: Some(Mutant { what: FASTER, run: || order(ShapeChoice::Bspline2, 3e-4, faster) }),
};

fn semi_implicit(scene: Scene, shape: ShapeChoice) -> Result<Scene, Error> {
    Ok(scene.edited(|scene| (scene.integrator, scene.shape, scene.history) = (Integrator::SemiImplicit, shape, 0))?)
}

fn at_its_limit(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut scene = semi_implicit(crate::scenes::terzaghi(), ShapeChoice::Centre)?;
    let exact = Terzaghi::compressible(&scene).ok_or(Unfit("the scene is dry"))?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::relative(&scene, &settlement);
    scene = scene.edited(fault)?;
    // Meshes of which each takes its own limit.
    let (meshes, _) = degree.refine(&scene, &[12, 18, 25, 36])?;
    let (errors, samples) = degree.refine(&scene, &[50])?;
    let meshes = [meshes, errors.clone()].concat();
    Ok(Outcome {
        integrator: integrator(&scene),
        scheme: scheme(&scene),
        errors,
        samples,
        refinements: vec![Refinement::new(
            MESH,
            meshes,
            "the series with compressible water at 0.9 of the limit of each mesh: errors of step and mesh, of opposite sign, \
             and inertia; no order is expected of their sum",
        )],
        // Less than the 2.7e-3 of the explicit scheme on this mesh: the errors of step and mesh have opposite signs.
        required_error: 2e-3,
        required_order: None,
        ..Outcome::default()
    })
}

/// With steps that fall with L^2 backward Euler, of first order in the step, and the mesh, of second order, show one
/// order together. Before Tv = 0.1 the wave that sudden drainage makes counts as well, which an implicit pressure damps.
fn order(shape: ShapeChoice, required_error: f64, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut base = semi_implicit(terzaghi::lightly_loaded()?, shape)?;
    let exact = DynamicColumn::new(&base).ok_or(Unfit("the scene is dry"))?;
    let late = LATE_TV * base.time_per_factor().ok_or(Unfit("the scene is dry"))?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::relative(&base, &settlement).from(late);
    base = base.edited(fault)?;
    let coarse = base.with_rows(20)?;
    let first = 0.9 * stable_limit(&coarse);
    let on = |rows| {
        let step = |scene: &mut Fields| scene.step = StepChoice::Fixed(first * (scene.cell / coarse.cell).powi(2));
        base.with_rows(rows)?.edited(step)
    };
    let scenes = [20, 28, 40, 56, 80].into_iter().map(on).collect::<Result<Vec<_>, _>>()?;
    let (errors, samples) = degree.on_meshes(scenes.into_iter())?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error,
        required_order: Some([1.8, 2.2]),
        samples,
        refinements: vec![
            degree.in_time(&coarse, first, HALVINGS, FIRST_ORDER)?,
            degree.in_particles(&coarse, &PARTICLE_COUNTS, PARTICLES_LEAVE)?,
        ],
        ..Outcome::default()
    })
}

/// Largest error with any number of particles on twenty rows of cells.
const PARTICLES_LEAVE: f64 = 0.01;

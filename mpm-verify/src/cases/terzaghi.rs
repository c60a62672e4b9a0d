//! Table 1's column from undrained equilibrium, load on the surface, against the column with inertia.
//!
//! The run is dynamic and of finite strain, so it is compared with its own model: the exact u-p column, under a
//! hundredth of the load. What is left is the scheme alone. (The study compares with Terzaghi's assumptions.)

use mpm_core::scene::{DarcyChoice, Fields, Scene, ShapeChoice, Surcharge};
use mpm_core::stability::stable_limit;

use super::degree::Degree;
use super::{Error, FASTER, Mutant, Outcome, Program, Unfit, faster, integrator, scheme, sound};
use crate::exact::dynamic::DynamicColumn;

/// The paper's scheme with the default operator.
pub const SURFACE: Program = Program {
    name: "terzaghi",
    about: "consolidation of Table 1's column: U, order 2",
    run: || outcome(sound, sound),
    mutant: Some(Mutant { what: FASTER, run: || outcome(sound, faster) }),
};

/// The standard linear scheme.
pub const LINEAR: Program = Program {
    name: "terzaghi-linear",
    about: "the same with the standard linear scheme",
    run: || outcome(linear, sound),
    mutant: Some(Mutant { what: FASTER, run: || outcome(linear, faster) }),
};

/// The paper's Darcy operator.
pub const NODAL: Program = Program {
    name: "terzaghi-nodal",
    about: "the same with the paper's nodal Darcy velocity",
    run: || outcome(nodal, sound),
    mutant: Some(Mutant { what: FASTER, run: || outcome(nodal, faster) }),
};

/// uGIMP.
pub const GIMP: Program = Program {
    name: "terzaghi-gimp",
    about: "the same with uGIMP",
    run: || gimp(sound),
    mutant: Some(Mutant { what: FASTER, run: || gimp(faster) }),
};

/// Quadratic B-splines.
pub const SPLINES: Program = Program {
    name: "terzaghi-bspline2",
    about: "the same with quadratic B-splines",
    run: || splines(sound),
    mutant: Some(Mutant { what: FASTER, run: || splines(faster) }),
};

fn linear(scene: &mut Fields) {
    scene.shape = ShapeChoice::Linear;
}

fn nodal(scene: &mut Fields) {
    scene.darcy = DarcyChoice::Nodal;
}

fn outcome(change: fn(&mut Fields), fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    // Cells of this size alone, exactly in time, make 9.8e-4 at L = 0.0125.
    refined(&[20, 28, 40, 80], 1.5e-3, [1.8, 2.2], change, fault)
}

fn gimp(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    refined(&[14, 20, 28, 40], 5e-3, [1.8, 2.4], |scene| scene.shape = ShapeChoice::Gimp, fault)
}

fn splines(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    refined(&[20, 28, 40, 56], 7e-3, [1.8, 2.4], |scene| scene.shape = ShapeChoice::Bspline2, fault)
}

/// Errors of U on meshes of `rows` cells, with what is required of the finest and of the order.
fn refined(
    rows: &[usize],
    required_error: f64,
    order: [f64; 2],
    change: fn(&mut Fields),
    fault: fn(&mut Fields),
) -> Result<Outcome, Error> {
    let mut base = lightly_loaded()?;
    base = base.edited(change)?;
    let exact = DynamicColumn::new(&base).ok_or(Unfit("the scene is dry"))?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::relative(&base, &settlement);
    base = base.edited(fault)?;
    let (errors, samples) = degree.refine(&base, rows)?;
    let coarse = base.with_rows(COARSE)?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error,
        required_order: Some(order),
        samples,
        refinements: vec![
            degree.in_time(&coarse, 0.9 * stable_limit(&coarse), HALVINGS, FIRST_ORDER)?,
            degree.in_particles(&coarse, &PARTICLE_COUNTS, PARTICLES_LEAVE)?,
        ],
        ..Outcome::default()
    })
}

/// Rows of the mesh on which steps and particles are refined: what they change does not need a fine one.
const COARSE: usize = 10;
/// Differences between runs of half the step.
pub(super) const HALVINGS: u32 = 4;
/// The explicit step takes stress and pressure of its start: an error of first order in the step.
pub(super) const FIRST_ORDER: Option<[f64; 2]> = Some([0.9, 1.1]);
/// Particles per cell in two dimensions; a column has the square root.
pub(super) const PARTICLE_COUNTS: [usize; 4] = [1, 4, 9, 16];
/// Largest error with any of them on ten rows of cells, which leave 0.070 (centre values) and 0.092 (B-splines) themselves.
const PARTICLES_LEAVE: f64 = 0.1;

/// The column under a hundredth of its load: strains too small to matter.
pub(super) fn lightly_loaded() -> Result<Scene, Error> {
    Ok(crate::scenes::terzaghi().edited(|base| {
        base.history = 0;
        base.surcharge = base.surcharge.map(|s| Surcharge { pressure: 0.01 * s.pressure, ..s });
    })?)
}

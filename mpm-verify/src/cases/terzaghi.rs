//! Table 1's column from undrained equilibrium, load on the surface, against the column with inertia.
//!
//! The run is dynamic and of finite strain, so it is compared with its own model: the exact u-p column, under a
//! hundredth of the load. What is left is the scheme alone. (The study compares with Terzaghi's assumptions.)

use mpm_core::scene::{DarcyChoice, Scene, ShapeChoice, Surcharge};

use super::{FASTER, Mutant, Outcome, Rung, faster, integrator, refine, scheme, sound};
use crate::exact::dynamic::DynamicColumn;
use crate::norms::relative;

/// The paper's scheme with the default operator.
pub const SURFACE: Rung = Rung {
    name: "terzaghi",
    about: "consolidation of Table 1's column: U, order 2",
    climb: || climb(sound, sound),
    mutant: Some(Mutant { what: FASTER, climb: || climb(sound, faster) }),
};

/// The standard linear scheme.
pub const LINEAR: Rung = Rung {
    name: "terzaghi-linear",
    about: "the same with the standard linear scheme",
    climb: || climb(linear, sound),
    mutant: Some(Mutant { what: FASTER, climb: || climb(linear, faster) }),
};

/// The paper's Darcy operator.
pub const NODAL: Rung = Rung {
    name: "terzaghi-nodal",
    about: "the same with the paper's nodal Darcy velocity",
    climb: || climb(nodal, sound),
    mutant: Some(Mutant { what: FASTER, climb: || climb(nodal, faster) }),
};

/// uGIMP.
pub const GIMP: Rung = Rung {
    name: "terzaghi-gimp",
    about: "the same with uGIMP",
    climb: || gimp(sound),
    mutant: Some(Mutant { what: FASTER, climb: || gimp(faster) }),
};

/// Quadratic B-splines.
pub const SPLINES: Rung = Rung {
    name: "terzaghi-bspline2",
    about: "the same with quadratic B-splines",
    climb: || splines(sound),
    mutant: Some(Mutant { what: FASTER, climb: || splines(faster) }),
};

fn linear(scene: &mut Scene) {
    scene.shape = ShapeChoice::Linear;
}

fn nodal(scene: &mut Scene) {
    scene.darcy = DarcyChoice::Nodal;
}

fn climb(change: fn(&mut Scene), fault: fn(&mut Scene)) -> Result<Outcome, String> {
    // Cells of this size alone, exactly in time, make 9.8e-4 at L = 0.0125.
    refined(&[20, 40, 80], 1.5e-3, [1.8, 2.2], change, fault)
}

fn gimp(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    refined(&[10, 20, 40], 5e-3, [1.8, 2.4], |scene| scene.shape = ShapeChoice::Gimp, fault)
}

fn splines(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    refined(&[10, 20, 40], 7e-3, [1.8, 2.4], |scene| scene.shape = ShapeChoice::Bspline2, fault)
}

/// Errors of U on meshes of `rows` cells, with what is required of the finest and of the order.
fn refined(
    rows: &[usize],
    required_error: f64,
    order: [f64; 2],
    change: fn(&mut Scene),
    fault: fn(&mut Scene),
) -> Result<Outcome, String> {
    let mut base = lightly_loaded();
    change(&mut base);
    let exact = DynamicColumn::new(&base).ok_or("the scene is dry")?;
    fault(&mut base);
    let errors = refine(&base, rows, |s| relative(s.state.settlement, exact.settlement(s.stage_time)))?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error,
        required_order: Some(order),
        ..Outcome::default()
    })
}

/// The column under a hundredth of its load: strains too small to matter.
pub(super) fn lightly_loaded() -> Scene {
    let mut base = crate::scenes::terzaghi();
    base.history = 0;
    base.surcharge = base.surcharge.map(|s| Surcharge { pressure: 0.01 * s.pressure, ..s });
    base
}

//! Table 1's column from undrained equilibrium, load on the surface, against the column with inertia.
//!
//! The run is dynamic and of finite strain, so it is compared with its own model: the exact u-p column, under a
//! hundredth of the load. What is left is the scheme alone. (The study compares with Terzaghi's assumptions.)

use mpm_core::scene::{DarcyChoice, Scene, ShapeChoice, Surcharge};

use super::{Outcome, Rung, refine, scheme};
use crate::exact::dynamic::DynamicColumn;
use crate::norms::relative;

/// The paper's scheme with the default operator.
pub const SURFACE: Rung =
    Rung { name: "terzaghi", about: "consolidation of Table 1's column: U, order 2", climb: || climb(|_| {}) };

/// The standard linear scheme.
pub const LINEAR: Rung = Rung {
    name: "terzaghi-linear",
    about: "the same with the standard linear scheme",
    climb: || climb(|scene| scene.shape = ShapeChoice::Linear),
};

/// The paper's Darcy operator.
pub const NODAL: Rung = Rung {
    name: "terzaghi-nodal",
    about: "the same with the paper's nodal Darcy velocity",
    climb: || climb(|scene| scene.darcy = DarcyChoice::Nodal),
};

fn climb(change: fn(&mut Scene)) -> Result<Outcome, String> {
    let mut base = crate::scenes::terzaghi();
    base.history = 0;
    base.surcharge = base.surcharge.map(|s| Surcharge { pressure: 0.01 * s.pressure, ..s });
    change(&mut base);
    let exact = DynamicColumn::new(&base).ok_or("the scene is dry")?;
    let errors = refine(&base, &[20, 40, 80], |s| relative(s.state.settlement, exact.settlement(s.stage_time)))?;
    // Cells of this size alone, exactly in time, make 9.8e-4 at L = 0.0125.
    Ok(Outcome { scheme: scheme(&base), errors, required_error: 1.5e-3, required_order: Some([1.8, 2.2]) })
}

//! Consolidation under the own weight, from the undrained state of it, against its series.

use mpm_core::drive::Sample;
use mpm_core::scene::{Integrator, Scene, ShapeChoice, StepChoice, TimeMethod, Until};

use super::{FASTER, Mutant, Outcome, Rung, faster, integrator, refine, scheme, slower, sound};
use crate::exact::self_weight::SelfWeight;
use crate::norms::{LATE_TV, relative};

/// The paper's scheme.
pub const EXPLICIT: Rung = Rung {
    name: "self-weight",
    about: "consolidation under the own weight, the paper's scheme: settlement, order 2",
    climb: || climb(explicit, LATE_TV, 5e-4, [1.7, 2.3], sound),
    mutant: Some(Mutant { what: FASTER, climb: || climb(explicit, LATE_TV, 5e-4, [1.7, 2.3], faster) }),
};

/// Implicit pressure.
pub const SEMI_IMPLICIT: Rung = Rung {
    name: "self-weight-semi-implicit",
    about: "the same with implicit pressure",
    climb: || climb(semi_implicit, 0.01, 3e-4, [1.7, 2.3], sound),
    mutant: Some(Mutant { what: FASTER, climb: || climb(semi_implicit, 0.01, 3e-4, [1.7, 2.3], faster) }),
};

/// Without inertia.
pub const QUASI_STATIC: Rung = Rung {
    name: "self-weight-quasi-static",
    about: "the same without inertia, B-splines",
    climb: || climb(quasi_static, 0.01, 2e-6, [1.9, 5.0], sound),
    mutant: Some(Mutant { what: FASTER, climb: || climb(quasi_static, 0.01, 2e-6, [1.9, 5.0], faster) }),
};

fn explicit(_: &mut Scene) {}

fn semi_implicit(scene: &mut Scene) {
    scene.integrator = Integrator::SemiImplicit;
}

fn quasi_static(scene: &mut Scene) {
    (scene.integrator, scene.shape, scene.method) = (Integrator::QuasiStatic, ShapeChoice::Bspline2, TimeMethod::Auto);
    (scene.step, scene.tolerance, scene.particles_per_cell) = (StepChoice::Auto, 1e-7, 9);
}

/// How much slower than in the scene file water drains.
const SLOW: f64 = 20.0;

/// Errors of the settlement from the time factor `from` on.
fn climb(
    change: fn(&mut Scene),
    from: f64,
    required_error: f64,
    order: [f64; 2],
    fault: fn(&mut Scene),
) -> Result<Outcome, String> {
    let mut base =
        crate::scenes::built_in("self-weight-consolidation").ok_or("no such scene")?.map_err(|e| e.to_string())?;
    base.history = 0;
    change(&mut base);
    // Strains of the weight itself, and what inertia does to a consolidation of this speed, would stand in the way of the order.
    base.gravity = base.gravity.map(|g| 0.01 * g);
    slower(&mut base, SLOW);
    let end = *base.observe_times.last().ok_or("no time to look at")? * SLOW;
    base.observe_times.iter_mut().for_each(|t| *t *= SLOW);
    base.stages[0].until = Until::Time(end);
    let exact = SelfWeight::new(&base).ok_or("not a column under its own weight")?;
    fault(&mut base);
    let error = |s: &Sample| match exact.time_factor(s.stage_time) >= 0.99 * from {
        true => relative(s.state.settlement, exact.settlement(s.stage_time)),
        false => 0.0,
    };
    let errors = refine(&base, &[10, 20, 40], error)?;
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    Ok(Outcome { integrator, scheme, errors, required_error, required_order: Some(order), ..Outcome::default() })
}

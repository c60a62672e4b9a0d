//! Mandel's problem with the integrators that carry inertia: the plate is a constraint on a row of nodes there.
//!
//! The run starts from the exact state at T = 0.02: the jump at t = 0 would send waves through soil that has no damping,
//! and the exact solution has none. A hundredth of the scene's load keeps strains from mattering.

use std::sync::Arc;

use mpm_core::boundary::{FirstField, FirstState, Given};
use mpm_core::drive::Sample;
use mpm_core::scene::{Integrator, Scene, ShapeChoice, StepChoice, StrainChoice, Surcharge, Until};

use super::{FASTER, Mutant, Outcome, Rung, faster, finished_given, integrator, scheme, slower, sound};
use crate::exact::mandel::Mandel;
use crate::norms::largest;

/// Implicit pressure.
pub const SEMI_IMPLICIT: Rung = Rung {
    name: "mandel-semi-implicit",
    about: "Mandel's problem with inertia, implicit pressure, rigid plate: p from T = 0.1 to 1",
    climb: || semi_implicit(sound),
    mutant: Some(Mutant { what: FASTER, climb: || semi_implicit(faster) }),
};

/// The paper's scheme.
pub const EXPLICIT: Rung = Rung {
    name: "mandel-explicit",
    about: "the same with the paper's explicit step",
    climb: || explicit(sound),
    mutant: Some(Mutant { what: FASTER, climb: || explicit(faster) }),
};

/// Where the run starts, T = c t/a^2.
const START: f64 = 0.02;
/// Times looked at.
const TIMES: [f64; 5] = [0.1, 0.2, 0.3, 0.5, 1.0];

fn semi_implicit(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    climb(Integrator::SemiImplicit, 8.0, &[6, 12, 24], 5e-4, fault)
}

fn explicit(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    climb(Integrator::Explicit, 4.0, &[4, 8, 16], 1e-3, fault)
}

/// With a conductivity lower by `slow`: what inertia does to a consolidation falls with its speed.
fn climb(
    integrate: Integrator,
    slow: f64,
    sides: &[usize],
    required_error: f64,
    fault: fn(&mut Scene),
) -> Result<Outcome, String> {
    let mut base = crate::scenes::built_in("mandel").ok_or("no such scene")?.map_err(|e| e.to_string())?;
    base.surcharge = base.surcharge.map(|s| Surcharge { pressure: 0.01 * s.pressure, ..s });
    (base.integrator, base.shape, base.strain) = (integrate, ShapeChoice::Centre, StrainChoice::Large);
    (base.step, base.particles_per_cell, base.history) = (StepChoice::Auto, 4, 0);
    slower(&mut base, slow);
    let exact = Mandel::new(&base).ok_or("not Mandel's problem")?;
    let per_factor = 1.0 / exact.time_factor(1.0);
    let start = START * per_factor;
    base.observe_times = TIMES.map(|t| t * per_factor - start).to_vec();
    base.stages[0].until = Until::Time(per_factor - start);
    let given = Given { start: Some(state(&exact, start)), ..Given::default() };
    let error = |s: &Sample| {
        let off = |x: f64, p: f64| (p - exact.pressure(x, s.stage_time + start)) / exact.undrained;
        largest(s.state.field.iter().map(|f| off(f.x_m, f.pressure_pa)))
    };
    fault(&mut base);
    let on = |side: &usize| {
        let cell = base.width / *side as f64;
        let scene = Scene { cell, cells: [*side; 2], ..base.clone() };
        Ok((cell, largest(finished_given(&scene, &given)?.observed().map(error))))
    };
    let errors = sides.iter().map(on).collect::<Result<_, String>>()?;
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    Ok(Outcome { integrator, scheme, errors, required_error, required_order: Some([1.7, 2.3]), ..Outcome::default() })
}

/// The exact state at a time (s), with the velocities of its displacements.
fn state(exact: &Mandel, time: f64) -> FirstField {
    let (exact, dt) = (exact.clone(), 1e-4 * time);
    Arc::new(move |[x, y]| {
        let p = exact.pressure(x, time);
        // Total stress: nothing sideways; across, there is no strain.
        let (xx, yy) = (p, exact.vertical_stress(x, time) + p);
        let rate = |u: &dyn Fn(f64) -> f64| (u(time + dt) - u(time - dt)) / (2.0 * dt);
        let plate = rate(&|t| exact.displacement_y(t));
        FirstState {
            velocity: [rate(&|t| exact.displacement_x(x, t)), plate * y / exact.half_height],
            stress: [xx, yy, exact.poisson * (xx + yy), 0.0],
            pressure: p,
        }
    })
}

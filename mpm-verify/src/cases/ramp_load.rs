//! A load that grows over Tc = 0.2, from an unloaded column, against Olson's series with compressible water.

use mpm_core::scene::{Fields, Integrator, ShapeChoice, Start, StepChoice, Surcharge, TimeMethod};
use mpm_core::stability::stable_limit;

use super::degree::Degree;
use super::terzaghi::{FIRST_ORDER, HALVINGS, PARTICLE_COUNTS};
use super::{Error, Mutant, Outcome, Program, Unfit, integrator, scheme, sound};
use crate::exact::terzaghi::Terzaghi;

/// The case.
pub const CASE: Program = Program {
    name: "ramp-load",
    about: "a load that grows linearly, from rest",
    run: || outcome(sound),
    mutant: Some(Mutant { what: "load 5 % too slow", run: || outcome(slower) }),
};

/// Without inertia, by steps.
pub const QUASI_STATIC: Program = Program {
    name: "ramp-load-quasi-static",
    about: "the same without inertia, B-splines and error-controlled steps: the load of every stage of a step",
    run: || without_inertia(sound),
    mutant: Some(Mutant { what: "load 5 % too slow", run: || without_inertia(slower) }),
};

fn slower(scene: &mut Fields) {
    scene.surcharge = scene.surcharge.map(|s| Surcharge { ramp_time: 1.05 * s.ramp_time, ..s });
}

fn outcome(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut base = crate::scenes::terzaghi().edited(|base| (base.history, base.start) = (0, Start::Unloaded))?;
    let ramp_time = 0.2 * base.time_per_factor().ok_or(Unfit("the scene is dry"))?;
    base = base.edited(|base| base.surcharge = base.surcharge.map(|s| Surcharge { ramp_time, ..s }))?;
    let exact = Terzaghi::compressible(&base).ok_or(Unfit("the scene is dry"))?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::relative(&base, &settlement).absolute();
    base = base.edited(fault)?;
    let (errors, samples) = degree.refine(&base, &[14, 20, 28, 40])?;
    let coarse = base.with_rows(10)?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1.0e-3,
        // The series leaves out inertia and finite strain, which stay on fine meshes: no order is expected.
        required_order: None,
        samples,
        refinements: vec![
            degree.in_time(&coarse, 0.9 * stable_limit(&coarse), HALVINGS, FIRST_ORDER)?,
            degree.in_particles(&coarse, &PARTICLE_COUNTS, 4e-3)?,
        ],
        ..Outcome::default()
    })
}

/// The ramp ends at a sample time, so that no step goes over its end.
fn without_inertia(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut base = crate::scenes::built_in("terzaghi-quasi-static")?;
    base = base.edited(|base| {
        (base.history, base.start, base.method) = (0, Start::Unloaded, TimeMethod::Sdirk);
        (base.integrator, base.shape, base.tolerance) = (Integrator::QuasiStatic, ShapeChoice::Bspline2, 1e-7);
    })?;
    let ramp_time = 0.2 * base.time_per_factor().ok_or(Unfit("the scene is dry"))?;
    base = base.edited(|base| base.surcharge = base.surcharge.map(|s| Surcharge { ramp_time, ..s }))?;
    let exact = Terzaghi::compressible(&base).ok_or(Unfit("the scene is dry"))?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::relative(&base, &settlement).absolute();
    base = base.edited(fault)?;
    let (errors, samples) = degree.refine(&base, &[8, 10, 14, 20])?;
    let coarse = base.with_rows(10)?;
    let stepped = coarse.edited(|s| s.step = StepChoice::Auto)?;
    // SDIRK4(3): four, or what is left of that while the settlement goes with the time to the power of 3/2.
    let in_time = degree.in_time(&stepped, 0.05 * ramp_time, 4, Some([3.0, 6.0]))?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1e-5,
        required_order: None,
        samples,
        refinements: vec![
            in_time,
            degree.in_tolerance(&coarse, &[1e-3, 1e-4, 1e-5, 1e-6], 1.0)?,
            degree.in_particles(&coarse, &PARTICLE_COUNTS[1..], 1e-3)?,
        ],
        ..Outcome::default()
    })
}

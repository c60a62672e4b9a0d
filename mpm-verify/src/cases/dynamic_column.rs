//! The column with inertia under a fast ramp, against the exact u-p model with the same Darcy law.

use mpm_core::scene::{Fields, Start, Surcharge, Until};
use mpm_core::stability::stable_limit;

use super::degree::Degree;
use super::terzaghi::{FIRST_ORDER, HALVINGS, PARTICLE_COUNTS};
use super::{Error, Mutant, Outcome, Program, Unfit, integrator, scheme, sound};
use crate::exact::dynamic::DynamicColumn;

/// Darcy's law with `rho_w a_s`.
pub const WITH_INERTIA: Program = Program {
    name: "dynamic-up",
    about: "waves and consolidation, u-p model",
    run: || outcome(sound, sound),
    mutant: Some(Mutant { what: "no inertia in Darcy's law", run: || outcome(sound, without) }),
};

/// Darcy's law without inertia.
pub const WITHOUT_INERTIA: Program = Program {
    name: "dynamic-upq",
    about: "the same without inertia in Darcy's law",
    run: || outcome(without, sound),
    mutant: Some(Mutant { what: "inertia in Darcy's law", run: || outcome(without, |s| s.darcy_inertia = true) }),
};

fn without(scene: &mut Fields) {
    scene.darcy_inertia = false;
}

fn outcome(change: fn(&mut Fields), fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut base = crate::scenes::terzaghi().edited(|base| {
        (base.history, base.start) = (0, Start::Unloaded);
        base.surcharge = base.surcharge.map(|s| Surcharge { ramp_time: 5e-4, ..s });
    })?;
    let end = 0.2 * base.time_per_factor().ok_or(Unfit("the scene is dry"))?;
    base = base.edited(|base| {
        base.stages[0].until = Until::Time(end);
        base.observe_times = (1..=40).map(|i| end * f64::from(i) / 40.0).collect();
    })?;
    base = base.edited(change)?;
    let exact = DynamicColumn::new(&base).ok_or(Unfit("the scene is dry"))?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::relative(&base, &settlement).absolute();
    base = base.edited(fault)?;
    let (errors, samples) = degree.refine(&base, &[20, 28, 40, 56, 80])?;
    let coarse = base.with_rows(10)?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        // With the other Darcy law the errors end at 2.4e-4 and 2.9e-4: less than that tells the two apart.
        required_error: 2.0e-4,
        required_order: Some([1.8, 2.2]),
        samples,
        refinements: vec![
            degree.in_time(&coarse, 0.9 * stable_limit(&coarse), HALVINGS, FIRST_ORDER)?,
            degree.in_particles(&coarse, &PARTICLE_COUNTS, 0.02)?,
        ],
        ..Outcome::default()
    })
}

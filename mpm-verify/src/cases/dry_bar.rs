//! A dry bar under a step load: its top moves at q/(rho c) until the wave comes back (d'Alembert).

use mpm_core::scene::{Fields, Start, Until};
use mpm_core::stability::stable_limit;

use super::degree::Degree;
use super::{Error, Mutant, Outcome, Program, integrator, scheme, sound};
use super::{HALVINGS, PARTICLE_COUNTS};

/// The case.
pub const CASE: Program = Program {
    name: "dry-bar",
    about: "elastic wave in a bar without water",
    run: || outcome(sound),
    mutant: Some(Mutant { what: "skeleton 5 % too stiff", run: || outcome(stiffer) }),
};

fn stiffer(scene: &mut Fields) {
    scene.elastic.youngs_modulus *= 1.05;
}

fn outcome(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut base = crate::scenes::terzaghi().edited(|base| {
        (base.water, base.start, base.history) = (None, Start::Unloaded, 0);
        base.stages[0].drained = [false; 4];
    })?;
    let speed = (base.oedometer_modulus() / base.mixture_density()).sqrt();
    let there_and_back = 2.0 * base.height / speed;
    base = base.edited(|base| {
        base.stages[0].until = Until::Time(there_and_back);
        base.observe_times = [0.25, 0.5, 0.75, 1.0].map(|share| share * there_and_back).to_vec();
    })?;
    // u = q t/(rho c) up to 2 H/c: there twice the static settlement.
    let whole = 1.0e4 * base.height / base.oedometer_modulus();
    let settlement = |time| 2.0 * whole * time / there_and_back;
    let degree = Degree::relative(&base, &settlement).from(there_and_back);
    base = base.edited(fault)?;
    let (errors, samples) = degree.refine(&base, &[40, 56, 80, 112, 160])?;
    let coarse = base.with_rows(40)?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1.0e-2,
        // A scheme of second order spreads a jump over t^(1/3) L^(2/3): two thirds.
        required_order: Some([0.5, 1.5]),
        samples,
        refinements: vec![
            // The front of the wave is a jump: no order in the step is expected of it.
            degree.in_time(&coarse, 0.9 * stable_limit(&coarse), HALVINGS, None)?,
            degree.in_particles(&coarse, &PARTICLE_COUNTS, 0.025)?,
        ],
        ..Outcome::default()
    })
}

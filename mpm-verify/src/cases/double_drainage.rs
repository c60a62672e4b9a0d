//! Both ends drained, against compressible water.
//!
//! The conductivity is a hundredth of Table 1's. With Table 1's own the upper half would have to fall as the lower
//! one shrinks, and its inertia delays the settlement by 30 % at Tv = 0.01: physics that the series leaves out.

use mpm_core::scene::Fields;
use mpm_core::stability::stable_limit;

use super::degree::Degree;
use super::terzaghi::{FIRST_ORDER, PARTICLE_COUNTS};
use super::{Error, Mutant, Outcome, Program, Unfit, integrator, scheme, sound};
use crate::exact::terzaghi::Terzaghi;

/// The case.
pub const CASE: Program = Program {
    name: "double-drainage",
    about: "consolidation with both ends drained, slow soil",
    run: || outcome(sound),
    mutant: Some(Mutant { what: "base not drained", run: || outcome(closed) }),
};

fn closed(scene: &mut Fields) {
    scene.stages[0].drained = [false, false, false, true];
}

fn outcome(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut base = crate::scenes::terzaghi().edited(|base| {
        base.history = 0;
        base.stages[0].drained = [false, false, true, true];
    })?;
    let fast = base.time_per_factor().ok_or(Unfit("the scene is dry"))?;
    base = base.edited(|base| {
        if let Some(water) = &mut base.water {
            water.hydraulic_conductivity *= 0.01;
        }
    })?;
    // The nine time factors belong to the drainage path of half the height.
    let slow = 100.0 * fast;
    base = base.edited(|base| {
        base.observe_times = crate::norms::SAMPLE_TV.map(|tv| tv * slow).to_vec();
        base.stages[0].until = mpm_core::scene::Until::Time(slow);
    })?;
    let exact = Terzaghi::compressible(&base).ok_or(Unfit("the scene is dry"))?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::relative(&base, &settlement);
    base = base.edited(fault)?;
    let (errors, samples) = degree.refine(&base, &[24, 28, 34, 40, 48])?;
    let coarse = base.with_rows(10)?;
    // Half the drainage path on the same mesh: four times the spatial error of the single-drainage case.
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 2.0e-2,
        required_order: Some([1.7, 2.2]),
        samples,
        refinements: vec![
            degree.in_time(&coarse, 0.9 * stable_limit(&coarse), 4, FIRST_ORDER)?,
            degree.in_particles(&coarse, &PARTICLE_COUNTS[..3], 0.3)?,
        ],
        ..Outcome::default()
    })
}

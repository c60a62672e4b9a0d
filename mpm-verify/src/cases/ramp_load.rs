//! A load that grows over Tc = 0.2, from an unloaded column, against Olson's series with compressible water.

use mpm_core::drive::Sample;
use mpm_core::scene::{Scene, Start, Surcharge};

use super::{Mutant, Outcome, Rung, integrator, refine, scheme, sound};
use crate::exact::terzaghi::Terzaghi;

/// The rung.
pub const RUNG: Rung = Rung {
    name: "ramp-load",
    about: "a load that grows linearly, from rest",
    climb: || climb(sound),
    mutant: Some(Mutant { what: "load 5 % too slow", climb: || climb(slower) }),
};

fn slower(scene: &mut Scene) {
    scene.surcharge = scene.surcharge.map(|s| Surcharge { ramp_time: 1.05 * s.ramp_time, ..s });
}

fn climb(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    let mut base = crate::scenes::terzaghi();
    (base.history, base.start) = (0, Start::Unloaded);
    let ramp_time = 0.2 * base.time_per_factor().ok_or("the scene is dry")?;
    base.surcharge = base.surcharge.map(|s| Surcharge { ramp_time, ..s });
    let exact = Terzaghi::compressible(&base).ok_or("the scene is dry")?;
    let whole = exact.load * exact.height / exact.modulus;
    // U itself, not relative to its exact value: the first settlements of a ramp are nearly zero.
    let error = |s: &Sample| (s.state.settlement - exact.settlement(s.stage_time)) / whole;
    fault(&mut base);
    let errors = refine(&base, &[20, 40], error)?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1.0e-3,
        required_order: None,
        ..Outcome::default()
    })
}

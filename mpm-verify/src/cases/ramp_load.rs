//! A load that grows over Tc = 0.2, from an unloaded column, against Olson's series with compressible water.

use mpm_core::drive::Sample;
use mpm_core::scene::{Start, Surcharge};

use super::{Outcome, Rung, integrator, refine, scheme};
use crate::exact::terzaghi::Terzaghi;

/// The rung.
pub const RUNG: Rung = Rung { name: "ramp-load", about: "a load that grows linearly, from rest", climb };

fn climb() -> Result<Outcome, String> {
    let mut base = crate::scenes::terzaghi();
    (base.history, base.start) = (0, Start::Unloaded);
    let ramp_time = 0.2 * base.time_per_factor().ok_or("the scene is dry")?;
    base.surcharge = base.surcharge.map(|s| Surcharge { ramp_time, ..s });
    let exact = Terzaghi::compressible(&base).ok_or("the scene is dry")?;
    let whole = exact.load * exact.height / exact.modulus;
    // U itself, not relative to its exact value: the first settlements of a ramp are nearly zero.
    let error = |s: &Sample| (s.state.settlement - exact.settlement(s.stage_time)) / whole;
    let errors = refine(&base, &[20, 40], error)?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1.0e-3,
        required_order: None,
    })
}

//! A load that grows over Tc = 0.2, from an unloaded column, against Olson's series with compressible water.

use mpm_core::scene::{Start, Surcharge};

use super::{Outcome, Rung, finished, scheme, with_rows};
use crate::exact::terzaghi::Terzaghi;
use crate::norms::largest;

/// The rung.
pub const RUNG: Rung = Rung { name: "ramp-load", about: "a load that grows linearly, from rest", climb };

fn climb() -> Result<Outcome, String> {
    let mut base = crate::scenes::terzaghi();
    (base.history, base.start) = (0, Start::Unloaded);
    let ramp_time = 0.2 * base.time_per_factor().ok_or("the scene is dry")?;
    base.surcharge = base.surcharge.map(|s| Surcharge { ramp_time, ..s });
    let mut errors = Vec::new();
    for rows in [20, 40] {
        let scene = with_rows(base.clone(), rows);
        let exact = Terzaghi::compressible(&scene).ok_or("the scene is dry")?;
        let run = finished(&scene)?;
        let whole = exact.load * exact.height / exact.modulus;
        // U itself, not relative to its exact value: the first settlements of a ramp are nearly zero.
        let error = |s: &mpm_core::drive::Sample| s.state.settlement / whole - exact.relative_settlement(s.stage_time);
        errors.push((scene.cell, largest(run.observed().map(error))));
    }
    Ok(Outcome { scheme: scheme(&base), errors, required_error: 1.0e-3, required_order: None })
}

//! The balance of the water of fronts and of a dam, in cells and in particles.

use super::{Error, Mutant, Outcome, Program, finished};
use crate::norms::largest;

/// The case.
pub const BALANCE: Program = Program {
    name: "front-water-balance",
    about: "no water is made or lost, in cells or in particles, at 4 and 9 per cell",
    run: || balance(0.0),
    mutant: Some(Mutant { what: "one water particle lost", run: || balance(1.0) }),
};

/// What is left of the water's balance, as a share of what came in: `lost` particles are taken away on the way.
fn balance(lost: f64) -> Result<Outcome, Error> {
    let mut offs = Vec::new();
    for (name, per_cell) in [("wetting-front", 4), ("infiltration", 9), ("rising-front", 4), ("dam", 9)] {
        let scene = crate::scenes::built_in(name)?.edited(|scene| scene.particles_per_cell = per_cell)?;
        for sample in finished(&scene)?.samples {
            let Some(water) = sample.state.water.filter(|w| w.in_m3 > 0.0) else { continue };
            let cells = water.mobile_m3 - water.in_m3 + water.out_m3;
            let one = water.particles_m3 / water.particles.max(1) as f64;
            let layer = water.particles_m3 - lost * one + water.pending_m3 - water.in_m3 + water.out_m3;
            let count = water.spawned as f64 - water.removed as f64 - water.particles as f64;
            let residual = sample.balance.water_residual_kg / 1000.0;
            offs.extend([cells, layer, count * one, residual].map(|off| off / water.in_m3));
        }
    }
    Ok(Outcome {
        integrator: "staggered".to_owned(),
        scheme: "free surface".to_owned(),
        errors: vec![(0.05, largest(offs.into_iter()))],
        required_error: 1e-12,
        ..Outcome::default()
    })
}

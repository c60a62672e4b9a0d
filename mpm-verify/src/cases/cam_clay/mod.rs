//! Modified Cam-Clay: element tests against closed forms, and the consolidation of a soft layer.

mod consolidation;
mod oedometer;
mod triaxial;

pub use consolidation::RUNG as SOFT_LAYER;
pub use oedometer::{BY_PARTICLES, RUNG as OEDOMETER};
pub use triaxial::{DRAINED, UNDRAINED};

use mpm_core::scene::CamClay;

use crate::exact::cam_clay::SOIL;

/// What the element tests must reach at their shortest step.
const REQUIRED: f64 = 1e-4;

/// A soil whose M is off.
fn flatter(soil: CamClay) -> CamClay {
    CamClay { critical_slope: 0.99 * soil.critical_slope, ..soil }
}

/// The fault of the element tests.
const FLATTER: &str = "M one percent too small";

/// Nothing planted.
fn own(soil: CamClay) -> CamClay {
    soil
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUNGS: [crate::cases::Rung; 5] = [DRAINED, UNDRAINED, OEDOMETER, BY_PARTICLES, SOFT_LAYER];

    #[test]
    fn every_rung_holds_and_every_mutant_falls_short() {
        for rung in RUNGS {
            let step = rung.climb().expect(rung.name).step;
            println!("{}: {:.1e}, order {:?}", step.rung, step.error, step.order);
            assert!(step.held(), "{step:?}");
            let climb = rung.climb_mutant().expect("a mutant").expect(rung.name);
            assert_eq!(climb.step.verdict, "failed", "{}: {}", rung.name, climb.reason);
        }
    }
}

//! Modified Cam-Clay: element tests against closed forms.

mod oedometer;
mod triaxial;

pub use oedometer::CASE as OEDOMETER;
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

    const CASES: [crate::cases::Program; 3] = [DRAINED, UNDRAINED, OEDOMETER];

    #[test]
    fn every_case_holds_and_every_mutant_falls_short() {
        for case in CASES {
            let step = case.judged().expect(case.name).row;
            println!("{}: {:.1e}, order {:?}", step.case, step.error, step.order);
            assert!(step.passed(), "{step:?}");
            let judged = case.mutant_judged().expect("a mutant").expect(case.name);
            assert_eq!(judged.row.verdict, "failed", "{}: {}", case.name, judged.reason);
        }
    }
}

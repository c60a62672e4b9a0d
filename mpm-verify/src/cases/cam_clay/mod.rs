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

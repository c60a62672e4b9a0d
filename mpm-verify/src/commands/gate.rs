//! `gate`: one run of a work gate, whose instructions another program counts.

use mpm_verify::error::Error;
use mpm_verify::nightly::{instructions, work};

use super::Failure;

/// Runs a gate, or nothing.
pub fn run(name: &str) -> Result<(), Failure> {
    if name == instructions::NOTHING {
        return Ok(());
    }
    let unknown =
        || Error::unknown(("the name of a work gate", "words"), name, work::GATES.iter().map(|gate| gate.name));
    let gate = work::named(name).ok_or_else(unknown).map_err(Failure::bad_input)?;
    gate.run().map(drop).map_err(Failure::run_failed)
}

//! `gate`: one run of a work gate, whose instructions another program counts.

use mpm_verify::nightly::{instructions, work};

use super::Failure;

/// Runs a gate, or nothing.
pub fn run(name: &str) -> Result<(), Failure> {
    if name == instructions::NOTHING {
        return Ok(());
    }
    let gate = work::named(name).ok_or_else(|| {
        let known: Vec<&str> = work::GATES.iter().map(|gate| gate.name).collect();
        Failure::BadInput(format!("gate: expected one of {}, found {name}", known.join(", ")))
    })?;
    gate.run().map(drop).map_err(Failure::run_failed)
}

//! Drained compression in plane strain: the lateral stress is held, the soil yields at the shortening of the table.

use mpm_core::scene::Strength;

use super::super::{Error, Mutant, Outcome, Program};
use super::compression::Compression;
use super::{CELL_PRESSURE, STRENGTH};

/// The case.
pub const CASE: Program = Program {
    name: "mc-plane-strain",
    about: "Mohr-Coulomb soil compressed in plane strain: stresses and strains",
    run: || COMPRESSION.outcome(&STRENGTH),
    mutant: Some(Mutant { what: "flow along the surface", run: mutant }),
};

const COMPRESSION: Compression = Compression {
    table: include_str!("../../../../reference-data/exact/10_mc_plane_strain.csv"),
    free: [1.0, 0.0, 0.0, 0.0],
    held: [-CELL_PRESSURE, 0.0, 0.0, 0.0],
};

/// Flow along the surface, where the table has none of the volume.
fn mutant() -> Result<Outcome, Error> {
    COMPRESSION.outcome(&Strength { dilation_angle: STRENGTH.friction_angle, ..STRENGTH })
}

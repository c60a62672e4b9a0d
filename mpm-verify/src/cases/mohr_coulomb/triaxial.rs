//! Drained triaxial compression: both lateral stresses are held, the soil yields on the edge s1 = s2.
//!
//! On the edge the two lateral strains are alike by symmetry only: the flow rule leaves their difference open.

use mpm_core::scene::Strength;

use super::super::{Error, Mutant, Outcome, Program};
use super::compression::Compression;
use super::{CELL_PRESSURE, STRENGTH};

/// The case.
pub const CASE: Program = Program {
    name: "mc-triaxial",
    about: "Mohr-Coulomb soil in a triaxial cell: stresses and strains",
    run: || COMPRESSION.outcome(&STRENGTH),
    mutant: Some(Mutant { what: "flow along the surface", run: mutant }),
};

const COMPRESSION: Compression = Compression {
    table: include_str!("../../../../reference-data/exact/10_mc_triaxial.csv"),
    free: [1.0, 0.0, 1.0, 0.0],
    held: [-CELL_PRESSURE, 0.0, -CELL_PRESSURE, 0.0],
};

/// Flow along the surface, where the table has none of the volume.
fn mutant() -> Result<Outcome, Error> {
    COMPRESSION.outcome(&Strength { dilation_angle: STRENGTH.friction_angle, ..STRENGTH })
}

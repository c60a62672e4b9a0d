//! Drained triaxial compression: both lateral stresses are held, the soil yields on the edge s1 = s2.
//!
//! On the edge the two lateral strains are alike by symmetry only: the flow rule leaves their difference open.

use mpm_core::scene::Strength;

use super::super::{Mutant, Outcome, Rung};
use super::{CELL_PRESSURE, STRENGTH, law, outcome};
use crate::element::Element;
use crate::exact::oracle::Table;

/// The rung.
pub const RUNG: Rung = Rung {
    name: "mc-triaxial",
    about: "Mohr-Coulomb soil in a triaxial cell: stresses and strains",
    climb: || compression(&STRENGTH),
    mutant: Some(Mutant { what: "flow along the surface", climb: mutant }),
};

/// Flow along the surface, where the table has none of the volume.
fn mutant() -> Result<Outcome, String> {
    compression(&Strength { dilation_angle: STRENGTH.friction_angle, ..STRENGTH })
}

/// Largest difference over all rows: stresses as a share of the largest stress, strains of the largest strain.
fn compression(strength: &Strength) -> Result<Outcome, String> {
    let table = Table::parse(include_str!("../../../../reference-data/exact/10_mc_triaxial.csv"));
    let rows = table.rows(["eps_yy", "eps_xx", "sxx_Pa", "syy_Pa", "szz_Pa"]);
    let last = rows.last().ok_or("an empty table")?;
    let cell = [-CELL_PRESSURE, 0.0, -CELL_PRESSURE, 0.0];
    let mut element = Element::new(law(strength), [-CELL_PRESSURE, -CELL_PRESSURE, -CELL_PRESSURE, 0.0]);
    let (mut worst, mut before) = (0.0_f64, 0.0);
    for [along, aside, xx, yy, zz] in &rows {
        element.step(&[0.0, along - before, 0.0, 0.0], &[[1.0, 0.0, 1.0, 0.0]], &cell)?;
        before = *along;
        for (found, expected) in element.stress.iter().zip([xx, yy, zz]) {
            worst = worst.max((found - expected).abs() / last[3].abs());
        }
        worst = worst.max((element.strain[0] - aside).abs() / last[0].abs());
    }
    Ok(outcome("element test", vec![(1.0 / rows.len() as f64, worst)], 1e-9, None))
}

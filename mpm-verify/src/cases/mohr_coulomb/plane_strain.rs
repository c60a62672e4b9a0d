//! Drained compression in plane strain: the lateral stress is held, the soil yields at the shortening of the table.

use mpm_core::scene::Strength;

use super::super::evidence::Sampled;
use super::super::{Mutant, Outcome, Rung};
use super::{CELL_PRESSURE, STRENGTH, at_row, in_parts, law, outcome};
use crate::element::Element;
use crate::exact::oracle::Table;
use crate::norms::largest;

/// The rung.
pub const RUNG: Rung = Rung {
    name: "mc-plane-strain",
    about: "Mohr-Coulomb soil compressed in plane strain: stresses and strains",
    climb: || compression(&STRENGTH),
    mutant: Some(Mutant { what: "flow along the surface", climb: mutant }),
};

/// Round-off and the digits of the table.
const EXACT: f64 = 1e-9;

/// Flow along the surface, where the table has none of the volume.
fn mutant() -> Result<Outcome, String> {
    compression(&Strength { dilation_angle: STRENGTH.friction_angle, ..STRENGTH })
}

/// All rows: stresses as shares of the largest stress, strains of the largest strain.
fn compression(strength: &Strength) -> Result<Outcome, String> {
    let table = Table::parse(include_str!("../../../../reference-data/exact/10_mc_plane_strain.csv"));
    let rows = table.rows(["eps_yy", "eps_xx", "sxx_Pa", "syy_Pa", "szz_Pa"]);
    let samples = path(strength, &rows, 1)?;
    let finer =
        in_parts(rows.len(), |parts| Ok(largest(path(strength, &rows, parts)?.iter().map(|s| s.error))), EXACT)?;
    let error = largest(samples.iter().map(|s| s.error));
    let found = outcome("element test", vec![(1.0 / rows.len() as f64, error)], EXACT, None);
    Ok(Outcome { samples, refinements: vec![finer], ..found })
}

/// Stresses and the lateral strain at all rows, from row to row in so many steps.
fn path(strength: &Strength, rows: &[[f64; 5]], parts: u32) -> Result<Vec<Sampled>, String> {
    let last = rows.last().ok_or("an empty table")?;
    let (most, farthest) = (last[3].abs(), last[0].abs());
    let cell = [-CELL_PRESSURE, 0.0, 0.0, 0.0];
    let mut element = Element::new(law(strength), [-CELL_PRESSURE, -CELL_PRESSURE, -CELL_PRESSURE, 0.0]);
    let (mut samples, mut before) = (Vec::new(), 0.0);
    for [along, aside, xx, yy, zz] in rows {
        let driven = [0.0, (along - before) / f64::from(parts), 0.0, 0.0];
        before = *along;
        for _ in 0..parts {
            element.step(&driven, &[[1.0, 0.0, 0.0, 0.0]], &cell)?;
        }
        let names = ["sigma_xx over the largest", "sigma_yy over the largest", "sigma_zz over the largest"];
        for ((name, found), expected) in names.iter().zip(element.stress).zip([xx, yy, zz]) {
            samples.push(at_row(name, along / last[0], [found, *expected], most));
        }
        let across = [element.strain[0], *aside];
        samples.push(at_row("lateral strain over the shortening", along / last[0], across, farthest));
    }
    Ok(samples)
}

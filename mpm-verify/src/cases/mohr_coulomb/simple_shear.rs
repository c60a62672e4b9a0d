//! Simple shear under a constant normal stress. From K_0 the principal axes turn while the soil yields, so that the fully
//! implicit return is of first order in the step; from an isotropic stress they do not, and it is exact.

use mpm_core::scene::Strength;

use super::super::{Error, Mutant, Outcome, Program, Unfit};
use super::{CELL_PRESSURE, STRENGTH, at_row, exact_on_paths, law, outcome};
use crate::element::Element;
use crate::exact::oracle::Table;
use crate::experiment::refinement::Sampled;
use crate::norms::largest;

/// From the stress of K_0 = nu/(1 - nu).
pub const FROM_K0: Program = Program {
    name: "mc-simple-shear",
    about: "Mohr-Coulomb soil in simple shear from K_0: shear stress, order 1 in the step",
    run: || from_k0(&STRENGTH),
    mutant: Some(Mutant { what: "angle of friction one degree too small", run: mutant }),
};

/// From an isotropic stress.
pub const ISOTROPIC: Program = Program {
    name: "mc-simple-shear-iso",
    about: "the same from an isotropic stress: exact",
    run: || isotropic(&STRENGTH),
    mutant: Some(Mutant { what: "angle of friction one degree too small", run: isotropic_mutant }),
};

const K0: &str = include_str!("../../../../reference-data/exact/10_mc_simple_shear_K0.csv");

/// A friction angle that is one degree off.
fn mutant() -> Result<Outcome, Error> {
    from_k0(&Strength { friction_angle: 29.0, ..STRENGTH })
}

/// The same.
fn isotropic_mutant() -> Result<Outcome, Error> {
    isotropic(&Strength { friction_angle: 29.0, ..STRENGTH })
}

fn from_k0(strength: &Strength) -> Result<Outcome, Error> {
    let rows = rows(K0);
    let mut errors = Vec::new();
    let mut samples = Vec::new();
    for parts in [1, 2, 4, 8] {
        samples = shear(&rows, strength, parts)?;
        let steps = (rows.len() - 1) as f64 * f64::from(parts);
        errors.push((1.0 / steps, largest(samples.iter().map(|s| s.error))));
    }
    Ok(Outcome { samples, ..outcome("element test", errors, 2e-4, Some([0.95, 1.05])) })
}

fn isotropic(strength: &Strength) -> Result<Outcome, Error> {
    let rows = rows(include_str!("../../../../reference-data/exact/10_mc_simple_shear_iso.csv"));
    exact_on_paths(rows.len() - 1, |parts| shear(&rows, strength, parts))
}

/// Shear strain, shear stress and the two normal stresses along the path.
fn rows(table: &str) -> Vec<[f64; 4]> {
    Table::parse(table).rows(["gamma", "tau_Pa", "sxx_Pa", "szz_Pa"])
}

/// The shear stress at the rows of a table, as a share of its largest; from row to row in so many steps.
fn shear(rows: &[[f64; 4]], strength: &Strength, parts: u32) -> Result<Vec<Sampled>, Error> {
    let ends = (rows.first().ok_or(Unfit("an empty table"))?, rows.last().ok_or(Unfit("an empty table"))?);
    let ([_, _, xx, zz], [farthest, most, ..]) = ends;
    let mut element = Element::new(law(strength), [*xx, -CELL_PRESSURE, *zz, 0.0]);
    let (mut samples, mut before) = (Vec::new(), 0.0);
    for [gamma, tau, ..] in rows {
        let driven = [0.0, 0.0, 0.0, (gamma - before) / f64::from(parts)];
        before = *gamma;
        for _ in 0..parts {
            element.step(&driven, &[[0.0, 1.0, 0.0, 0.0]], &[0.0, -CELL_PRESSURE, 0.0, 0.0])?;
        }
        let stress = [element.stress[3], *tau];
        samples.push(at_row("shear stress over the largest", gamma / farthest, stress, *most));
    }
    Ok(samples)
}

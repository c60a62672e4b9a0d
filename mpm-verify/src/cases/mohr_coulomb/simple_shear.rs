//! Simple shear under a constant normal stress. From K_0 the principal axes turn while the soil yields, so that the fully
//! implicit return is of first order in the step; from an isotropic stress they do not, and it is exact.

use mpm_core::scene::Strength;

use super::super::{Mutant, Outcome, Rung};
use super::{CELL_PRESSURE, STRENGTH, law, outcome};
use crate::element::Element;
use crate::exact::oracle::Table;

/// From the stress of K_0 = nu/(1 - nu).
pub const FROM_K0: Rung = Rung {
    name: "mc-simple-shear",
    about: "Mohr-Coulomb soil in simple shear from K_0: shear stress, order 1 in the step",
    climb: || from_k0(&STRENGTH),
    mutant: Some(Mutant { what: "angle of friction one degree too small", climb: mutant }),
};

/// From an isotropic stress.
pub const ISOTROPIC: Rung = Rung {
    name: "mc-simple-shear-iso",
    about: "the same from an isotropic stress: exact",
    climb: || isotropic(&STRENGTH),
    mutant: Some(Mutant { what: "angle of friction one degree too small", climb: isotropic_mutant }),
};

const K0: &str = include_str!("../../../../reference-data/exact/10_mc_simple_shear_K0.csv");

/// A friction angle that is one degree off.
fn mutant() -> Result<Outcome, String> {
    from_k0(&Strength { friction_angle: 29.0, ..STRENGTH })
}

/// The same.
fn isotropic_mutant() -> Result<Outcome, String> {
    isotropic(&Strength { friction_angle: 29.0, ..STRENGTH })
}

fn from_k0(strength: &Strength) -> Result<Outcome, String> {
    let errors = [1, 2, 4, 8].into_iter().map(|parts| shear(K0, strength, parts)).collect::<Result<_, _>>()?;
    Ok(outcome("element test", errors, 2e-4, Some([0.95, 1.05])))
}

fn isotropic(strength: &Strength) -> Result<Outcome, String> {
    let table = include_str!("../../../../reference-data/exact/10_mc_simple_shear_iso.csv");
    Ok(outcome("element test", vec![shear(table, strength, 1)?], 1e-9, None))
}

/// One step as a share of the path, and the largest difference of the shear stress at the rows of a table, as a share of
/// its largest; from row to row in so many steps.
fn shear(table: &str, strength: &Strength, parts: u32) -> Result<(f64, f64), String> {
    let rows = Table::parse(table).rows(["gamma", "tau_Pa", "sxx_Pa", "szz_Pa"]);
    let ([_, _, xx, zz], [_, most, ..]) = (rows.first().ok_or("an empty table")?, rows.last().ok_or("an empty table")?);
    let mut element = Element::new(law(strength), [*xx, -CELL_PRESSURE, *zz, 0.0]);
    let (mut worst, mut before) = (0.0_f64, 0.0);
    for [gamma, tau, ..] in &rows {
        let driven = [0.0, 0.0, 0.0, (gamma - before) / f64::from(parts)];
        before = *gamma;
        for _ in 0..parts {
            element.step(&driven, &[[0.0, 1.0, 0.0, 0.0]], &[0.0, -CELL_PRESSURE, 0.0, 0.0])?;
        }
        worst = worst.max((element.stress[3] - tau).abs() / most);
    }
    Ok((1.0 / ((rows.len() - 1) as f64 * f64::from(parts)), worst))
}

//! Returns of random trial stresses, against the tables: stress and region.
//!
//! The tables hold full tensors. The law is isotropic, so that each enters along its principal axes, in turn with every
//! one of them out of the plane, and comes back turned to the axes of the table.

use mpm_core::constitutive::Law;
use mpm_core::scene::Strength;
use nalgebra::{Matrix3, SymmetricEigen};

use super::super::{Error, Mutant, Outcome, Program};
use super::{STRENGTH, law, outcome};
use crate::exact::oracle::Table;
use crate::norms::largest;

/// psi = phi.
pub const ASSOCIATED: Program = Program {
    name: "mc-return-associated",
    about: "Mohr-Coulomb returns with psi = phi: stress and region",
    run: || returns(include_str!("../../../../reference-data/exact/10_mc_return_associated.csv"), &ALONG),
    mutant: Some(Mutant { what: "angles of friction and dilation one degree too large", run: mutant }),
};

/// psi = 0.
pub const NOT_ASSOCIATED: Program = Program {
    name: "mc-return-nonassociated",
    about: "the same with psi = 0",
    run: || returns(include_str!("../../../../reference-data/exact/10_mc_return_nonassociated.csv"), &STRENGTH),
    mutant: Some(Mutant { what: "flow along the surface", run: swapped_mutant }),
};

const ALONG: Strength = Strength { dilation_angle: STRENGTH.friction_angle, ..STRENGTH };

/// A friction angle that is one degree off.
fn mutant() -> Result<Outcome, Error> {
    let strength = Strength { friction_angle: 31.0, dilation_angle: 31.0, ..STRENGTH };
    returns(include_str!("../../../../reference-data/exact/10_mc_return_associated.csv"), &strength)
}

/// The flow rule of the other table.
fn swapped_mutant() -> Result<Outcome, Error> {
    returns(include_str!("../../../../reference-data/exact/10_mc_return_nonassociated.csv"), &ALONG)
}

/// Largest difference of any component over all rows, as a share of the row's largest trial stress; 1 where the region is
/// another one.
fn returns(table: &str, strength: &Strength) -> Result<Outcome, Error> {
    let law = law(strength);
    let parts = ["xx", "yy", "zz", "xy", "yz", "zx"];
    let names: [String; 13] = std::array::from_fn(|i| match i {
        0..6 => format!("tr_{}", parts[i]),
        6..12 => format!("ret_{}", parts[i - 6]),
        _ => "region".to_owned(),
    });
    let mut offs = Vec::new();
    for row in Table::parse(table).rows(std::array::from_fn::<&str, 13, _>(|i| &names[i])) {
        let [trial, expected] = [&row[..6], &row[6..12]].map(tensor);
        let principal = SymmetricEigen::new(trial);
        let scale = trial.amax();
        for out in 0..3 {
            let [a, b] = [(out + 1) % 3, (out + 2) % 3];
            let s = &principal.eigenvalues;
            let mut stress = [s[a], s[b], s[out], 0.0];
            if f64::from(law.region(&stress, &[0.0; 4]) as u32) != row[12] {
                offs.push(1.0);
            }
            law.update(&mut stress, &[0.0; 4], &mut [0.0]);
            let back = [(a, stress[0]), (b, stress[1]), (out, stress[2])];
            let found: Matrix3<f64> = back
                .iter()
                .map(|(axis, value)| {
                    let direction = principal.eigenvectors.column(*axis);
                    direction * direction.transpose() * *value
                })
                .sum();
            offs.extend((found - expected).iter().map(|off| off / scale));
        }
    }
    Ok(outcome("return mapping", vec![(1.0, largest(offs.into_iter()))], 1e-9, None))
}

/// A tensor from xx, yy, zz, xy, yz, zx.
fn tensor(s: &[f64]) -> Matrix3<f64> {
    Matrix3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2])
}

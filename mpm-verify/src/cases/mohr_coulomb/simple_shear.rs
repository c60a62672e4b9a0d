//! Simple shear under a constant normal stress. From K_0 the principal axes turn while the soil yields, so that the fully
//! implicit return is of first order in the step; from an isotropic stress they do not, and it is exact.

use mpm_core::constitutive::MohrCoulomb;
use mpm_core::scene::{Elastic, Reduction, Strength};

use super::super::{Error, Mutant, Outcome, Program, Unfit};
use super::{CELL_PRESSURE, ELASTIC, STRENGTH, at_row, exact_on_paths, law, outcome};
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

/// From K_0 while the dilation fades.
pub const FADING: Program = Program {
    name: "mc-simple-shear-fading",
    about: "Mohr-Coulomb soil in simple shear whose dilation fades: Davis' strength all the way, volume by the integral of the dilation",
    run: || fading(0.0),
    mutant: Some(Mutant { what: "a final dilation of one degree", run: || fading(1.0) }),
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
    Ok(Outcome { samples, ..outcome("element test", errors, 2e-4, Some(1.0)) })
}

fn isotropic(strength: &Strength) -> Result<Outcome, Error> {
    let rows = rows(include_str!("../../../../reference-data/exact/10_mc_simple_shear_iso.csv"));
    exact_on_paths(rows.len() - 1, |parts| shear(&rows, strength, parts))
}

/// Plastic shear strain over which the dilation fades.
const FADES_OVER: f64 = 0.1;

/// A soil whose dilation fades to an angle (degrees), sheared twice as far as that takes. It is stiff, so that elastic strains count
/// for nothing: the shear stress is `c* + sigma tan(phi*)` wherever it yields, and `tan(psi)` of all shear strain is gained in height.
fn fading(last: f64) -> Result<Outcome, Error> {
    const STIFF: f64 = 100.0;
    let strength = Strength { dilation_fades_over: Some(FADES_OVER), ..STRENGTH };
    let (tangent, first) = (strength.friction_angle.to_radians().sin(), strength.reduced(1.0, Reduction::Davis));
    let tau = first.cohesion + CELL_PRESSURE * tangent;
    let end = 2.0 * FADES_OVER;
    let run = |steps: u32| -> Result<Vec<Sampled>, Error> {
        let stiff = Elastic { youngs_modulus: STIFF * ELASTIC.youngs_modulus, ..ELASTIC };
        let law = MohrCoulomb::new(&stiff, &Strength { dilation_angle: last, ..strength });
        let k0 = ELASTIC.poisson_ratio / (1.0 - ELASTIC.poisson_ratio) * CELL_PRESSURE;
        let mut element = Element::new(law, [-k0, -CELL_PRESSURE, -k0, 0.0]);
        let mut samples = Vec::new();
        for step in 1..=steps {
            let driven = [0.0, 0.0, 0.0, end / f64::from(steps)];
            element.step(&driven, &[[0.0, 1.0, 0.0, 0.0]], &[0.0, -CELL_PRESSURE, 0.0, 0.0])?;
            if (4 * step).is_multiple_of(steps) {
                let share = f64::from(step) / f64::from(steps);
                let own = [element.stress[3], tau];
                samples.push(at_row("shear stress over that of Davis", share, own, tau));
                let own = [element.strain[1], gained(tangent.atan().sin(), end * share)];
                samples.push(at_row("gain of height over the fading strain", share, own, FADES_OVER));
            }
        }
        Ok(samples)
    };
    let mut errors = Vec::new();
    let mut samples = Vec::new();
    for steps in [200, 400, 800, 1600] {
        samples = run(steps)?;
        errors.push((1.0 / f64::from(steps), largest(samples.iter().map(|s| s.error))));
    }
    Ok(Outcome { samples, ..outcome("element test", errors, 1e-3, Some(1.0)) })
}

/// Gain of height per height of soil in simple shear whose sine of dilation falls from `sine` to 0 while its plastic strain
/// `eps_1 - eps_3 = gamma/cos(psi)` grows to [`FADES_OVER`], after a shear strain gamma: `d eps = sin(psi) d(eps_1 - eps_3)`.
fn gained(sine: f64, shear: f64) -> f64 {
    // d gamma = cos(psi) d slip, sin(psi) = sine (1 - slip/fades): gamma = fades/sine (P(sine) - P(sin(psi))), P the primitive of cos.
    let primitive = |s: f64| 0.5 * (s * (1.0 - s * s).sqrt() + s.asin());
    let whole = FADES_OVER / sine * primitive(sine);
    let (mut low, mut high) = (0.0, sine);
    if shear >= whole {
        high = 0.0;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let gone = FADES_OVER / sine * (primitive(sine) - primitive(middle));
        if gone > shear { low = middle } else { high = middle }
    }
    0.5 * FADES_OVER / sine * (sine * sine - high * high)
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

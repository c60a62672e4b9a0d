//! Consolidation to final strains of 20 and 30 %, against converged numbers for Cauchy stress and constant
//! conductivity.

use mpm_core::scene::{Fields, Scene, ShapeChoice, Surcharge};

use super::degree::Degree;
use super::terzaghi::PARTICLE_COUNTS;
use super::{Error, FASTER, Mutant, Outcome, Program, Unfit, asked, faster, integrator, scheme, sound};
use crate::exact::large_strain::LargeStrain;

/// Quadratic B-splines.
pub const SPLINES: Program = Program {
    name: "large-strain",
    about: "consolidation to 20 % strain, B-splines: settlement, order 2 or more",
    run: || splines(sound),
    mutant: Some(Mutant { what: FASTER, run: || splines(faster) }),
};

/// Linear functions.
pub const LINEAR: Program = Program {
    name: "large-strain-linear",
    about: "the same with the standard linear scheme",
    run: || linear(sound),
    mutant: Some(Mutant { what: FASTER, run: || linear(faster) }),
};

/// 30 %.
pub const SPLINES_30: Program = Program {
    name: "large-strain-30",
    about: "consolidation to 30 % strain, B-splines without inertia: settlement, order 2 or more",
    run: || splines_30(sound),
    mutant: Some(Mutant { what: FASTER, run: || splines_30(faster) }),
};

fn splines(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    outcome(0.8, ShapeChoice::Bspline2, 5e-5, [2.0, 4.0], fault)
}

fn linear(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    outcome(0.8, ShapeChoice::Linear, 6e-3, [1.7, 2.2], fault)
}

fn splines_30(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    outcome(0.7, ShapeChoice::Bspline2, 1e-4, [2.0, 4.0], fault)
}

/// The column whose length ends as a share of its first.
pub(super) fn column(left: f64) -> Result<Scene, Error> {
    let base = crate::scenes::built_in("terzaghi-large-strain")?;
    let pressure = -base.oedometer_modulus() * f64::ln(left);
    Ok(base.edited(|base| {
        base.surcharge = base.surcharge.map(|s| Surcharge { pressure, ..s });
        base.history = 0;
    })?)
}

fn outcome(
    left: f64,
    shape: ShapeChoice,
    required_error: f64,
    order: [f64; 2],
    fault: fn(&mut Fields),
) -> Result<Outcome, Error> {
    let mut base = column(left)?.edited(|base| base.shape = shape)?;
    let exact = LargeStrain::new(&base).ok_or(Unfit("not the column of the table"))?;
    // Between the rows of the table there is no number.
    let settlement = |time| exact.settlement(time).unwrap_or(f64::NAN);
    let degree = Degree::relative(&base, &settlement);
    base = base.edited(fault)?;
    let (errors, samples) = degree.refine(&base, &[10, 14, 20, 28, 40])?;
    let coarse = base.with_rows(10)?;
    let counts = if shape == ShapeChoice::Bspline2 { &PARTICLE_COUNTS[1..] } else { &PARTICLE_COUNTS };
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        tolerance: asked(&base),
        errors,
        required_error,
        required_order: Some(order),
        samples,
        refinements: vec![
            degree.in_tolerance(&coarse, &[1e-3, 1e-4, 1e-5, 1e-6], 1.0)?,
            degree.in_particles(&coarse, counts, 0.08)?,
        ],
        ..Outcome::default()
    })
}

//! Consolidation to a final strain of 20 %, against converged numbers for Cauchy stress and constant conductivity.

use mpm_core::drive::Sample;
use mpm_core::scene::{Scene, ShapeChoice};

use super::{FASTER, Mutant, Outcome, Rung, faster, integrator, refine, scheme, sound};
use crate::exact::large_strain::LargeStrain;
use crate::norms::relative;

/// Quadratic B-splines.
pub const SPLINES: Rung = Rung {
    name: "large-strain",
    about: "consolidation to 20 % strain, B-splines: settlement, order 2 or more",
    climb: || splines(sound),
    mutant: Some(Mutant { what: FASTER, climb: || splines(faster) }),
};

/// Linear functions.
pub const LINEAR: Rung = Rung {
    name: "large-strain-linear",
    about: "the same with the standard linear scheme",
    climb: || linear(sound),
    mutant: Some(Mutant { what: FASTER, climb: || linear(faster) }),
};

fn splines(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    climb(ShapeChoice::Bspline2, 5e-5, [2.0, 4.0], fault)
}

fn linear(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    climb(ShapeChoice::Linear, 6e-3, [1.7, 2.2], fault)
}

fn climb(shape: ShapeChoice, required_error: f64, order: [f64; 2], fault: fn(&mut Scene)) -> Result<Outcome, String> {
    let mut base =
        crate::scenes::built_in("terzaghi-large-strain").ok_or("no such scene")?.map_err(|e| e.to_string())?;
    (base.shape, base.history) = (shape, 0);
    let exact = LargeStrain::new(&base).ok_or("not the column of the table")?;
    let error = |s: &Sample| {
        exact.settlement(s.stage_time).map_or(f64::NAN, |settlement| relative(s.state.settlement, settlement))
    };
    fault(&mut base);
    let errors = refine(&base, &[10, 20, 40], error)?;
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    Ok(Outcome { integrator, scheme, errors, required_error, required_order: Some(order), ..Outcome::default() })
}

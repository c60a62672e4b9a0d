//! The Mohr-Coulomb law: its returns, element tests.

mod compression;

mod plane_strain;
mod returns;
mod simple_shear;
mod triaxial;

pub use plane_strain::CASE as PLANE_STRAIN;
pub use returns::{ASSOCIATED, NOT_ASSOCIATED};
pub use simple_shear::{FADING, FROM_K0, ISOTROPIC};
pub use triaxial::CASE as TRIAXIAL;

use mpm_core::constitutive::MohrCoulomb;
use mpm_core::scene::{Elastic, Strength};

use super::Outcome;
use crate::error::Error;
use crate::experiment::refinement::{Refinement, Sampled};
use crate::norms::largest;

/// The soil of all tables of family 10.
const ELASTIC: Elastic = Elastic { youngs_modulus: 2.0e7, poisson_ratio: 0.3 };
const STRENGTH: Strength = Strength {
    cohesion: 500.0,
    friction_angle: 30.0,
    dilation_angle: 0.0,
    tension_cutoff: None,
    dilation_fades_over: None,
};
/// Round-off and the digits of the tables.
const EXACT: f64 = 1e-9;
/// Isotropic pressure that the element tests start from, Pa.
const CELL_PRESSURE: f64 = 1.0e4;

fn law(strength: &Strength) -> MohrCoulomb {
    MohrCoulomb::new(&ELASTIC, strength)
}

/// An element test has no mesh and no particles: what can be refined is the path.
const PATH: crate::experiment::refinement::Parameter = ("step, share of the path", "-");

/// A value of an element test at a row of its table, over a `scale` (Pa or -); the time is the share of the path.
fn at_row(quantity: &str, share: f64, [computed, exact]: [f64; 2], scale: f64) -> Sampled {
    Sampled {
        quantity: format!("{quantity}; the time is the share of the path"),
        unit: "-".to_owned(),
        time: share,
        factor: None,
        computed: computed / scale,
        exact: exact / scale,
        error: (computed - exact) / scale,
        counts: true,
    }
}

/// What an element test found whose law is exact however it gets from row to row of its table; `path` takes so many steps
/// between `rows` rows.
fn exact_on_paths(rows: usize, path: impl Fn(u32) -> Result<Vec<Sampled>, Error>) -> Result<Outcome, Error> {
    let samples = path(1)?;
    let step = |parts: u32| 1.0 / (rows as f64 * f64::from(parts));
    let error = |parts: u32| Ok((step(parts), largest(path(parts)?.iter().map(|s| s.error))));
    let errors = [1, 2, 4, 8].into_iter().map(error).collect::<Result<Vec<_>, Error>>()?;
    let found = outcome("element test", errors[..1].to_vec(), EXACT, None);
    let against = "the table, each of its rows reached in 1, 2, 4 and 8 steps: exact in every one";
    let finer = Refinement { required_error: Some(EXACT), ..Refinement::new(PATH, errors, against) };
    Ok(Outcome { samples, refinements: vec![finer], ..found })
}

/// What a check without particles found.
fn outcome(what: &str, errors: Vec<(f64, f64)>, required_error: f64, required_order: Option<f64>) -> Outcome {
    Outcome {
        integrator: what.to_owned(),
        scheme: "mohr-coulomb".to_owned(),
        errors,
        required_error,
        required_order,
        refined_by: PATH,
        ..Outcome::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASES: [crate::cases::Program; 6] = [ASSOCIATED, NOT_ASSOCIATED, PLANE_STRAIN, TRIAXIAL, FROM_K0, ISOTROPIC];

    #[test]
    fn every_mutant_falls_short() {
        for case in CASES {
            let judged = case.mutant_judged().expect("a mutant").expect(case.name);
            assert_eq!(judged.row.verdict, crate::verdict::State::Failed, "{}: {}", case.name, judged.reason);
        }
    }

    #[test]
    fn every_case_holds() {
        for case in CASES {
            let step = case.judged().expect(case.name).row;
            println!("{}: {:.1e}, order {:?}", step.case, step.error, step.order);
            assert!(step.passed(), "{step:?}");
        }
    }
}

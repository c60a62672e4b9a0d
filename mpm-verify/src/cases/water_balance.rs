//! The water of a block that consolidates: what it holds and what is booked as gone make up what it held at first.
//!
//! What a cell holds follows from its porosity, its volume and its pressure; what has gone is added up over the drained faces and
//! the steps. Neither knows of the other.

use mpm_core::drive::Run;
use mpm_core::scene::{Dimension, Integrator, Scene, Until};

use super::{Error, Mutant, Outcome, Program, Unfit, finished, largest};
use crate::experiment::refinement::RUNS;

/// The case.
pub const CASE: Program = Program {
    name: "water-balance",
    about: "a block that consolidates, explicit and with implicit pressure: water that is not accounted for",
    run: || outcome(0.0),
    mutant: Some(Mutant { what: "a thousandth of the outflow not booked", run: || outcome(1e-3) }),
};

const WAYS: [(Dimension, Integrator); 3] = [
    (Dimension::Column, Integrator::Explicit),
    (Dimension::PlaneStrain, Integrator::Explicit),
    (Dimension::PlaneStrain, Integrator::SemiImplicit),
];

/// Table 1's column up to Tv = 0.5.
fn block((dimension, integrator): (Dimension, Integrator)) -> Result<Scene, Error> {
    let mut scene = crate::scenes::terzaghi()
        .with_rows(20)?
        .edited(|scene| (scene.dimension, scene.integrator, scene.history) = (dimension, integrator, 0))?;
    if dimension == Dimension::PlaneStrain {
        scene = scene.edited(|scene| (scene.cells[0], scene.width) = (2, 2.0 * scene.cell))?;
    }
    let end = 0.5 * scene.time_per_factor().ok_or(Unfit("the scene is dry"))?;
    Ok(scene.edited(|scene| {
        scene.stages[0].until = Until::Time(end);
        scene.observe_times = vec![0.1 * end, 0.4 * end, end];
    })?)
}

/// What does not close at each look, as a share of what has gone; `lost` of that is not booked.
fn gaps(run: &Run, lost: f64) -> Vec<f64> {
    let gap = |out: f64, closing: f64| (closing - lost * out) / out;
    run.observed().map(|s| gap(s.balance.water_out_kg, s.balance.water_residual_kg)).collect()
}

fn outcome(lost: f64) -> Result<Outcome, Error> {
    let mut all = Vec::new();
    for way in WAYS {
        all.extend(gaps(&finished(&block(way)?)?, lost));
    }
    Ok(Outcome {
        integrator: "explicit, semi-implicit".to_owned(),
        scheme: "centre".to_owned(),
        errors: vec![(WAYS.len() as f64, largest(all.into_iter()))],
        // Water leaves with the density that it has without pressure: q/K_w = 4.5e-6 of it is not seen, of 10 kPa.
        required_error: 1e-5,
        refined_by: RUNS,
        ..Outcome::default()
    })
}

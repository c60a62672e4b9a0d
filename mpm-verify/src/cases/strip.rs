//! A strip load on an undrained block: equal-order pressures would oscillate without the jump penalty.
//!
//! Compared with a run on 45 cells per side, whose cells have the middles of the coarse ones among theirs. The error is the RMS over the block, as a share of the load.

use mpm_core::observe::FieldPoint;
use mpm_core::scene::Scene;

use super::{Error, Lacks, Mutant, Outcome, Program, asked, finished, integrator, scheme};
use crate::experiment::number::Label;

/// The case.
pub const CASE: Program = Program {
    name: "strip",
    about: "undrained block under a strip load, B-splines: no oscillation of the pressure",
    run: || outcome(None),
    mutant: Some(Mutant { what: "no jump penalty", run: || outcome(Some(0.0)) }),
};

const FINE: usize = 45;
const SIDES: [usize; 3] = [5, 9, 15];

fn outcome(penalty: Option<f64>) -> Result<Outcome, Error> {
    let base = crate::scenes::built_in("strip")?;
    let load = base.surcharge.ok_or(Lacks("load"))?.pressure;
    let fine = field(&base, FINE)?;
    let mut errors = Vec::new();
    for side in SIDES {
        let scene = base.edited(|s| s.jump_penalty = penalty.or(base.jump_penalty))?;
        let coarse = field(&scene, side)?;
        let ratio = FINE / side;
        let place = |i: usize| ratio * i + ratio / 2;
        let square = |(number, point): (usize, &FieldPoint)| {
            let there = fine[place(number / side) * FINE + place(number % side)];
            ((point.pressure_pa - there.pressure_pa) / load).powi(2)
        };
        let sum: f64 = coarse.iter().enumerate().map(square).sum();
        errors.push((base.width / side as f64, (sum / coarse.len() as f64).sqrt()));
    }
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    let kind = Label::Regression;
    Ok(Outcome {
        integrator,
        scheme,
        tolerance: asked(&base),
        errors,
        required_error: 1e-3,
        kind,
        scene: Some(base),
        ..Outcome::default()
    })
}

/// Pressures at the middles of the cells, row by row.
fn field(base: &Scene, side: usize) -> Result<Vec<FieldPoint>, Error> {
    let scene = base.edited(|s| {
        s.cell = base.width / side as f64;
        s.cells = [side; 2];
    })?;
    let run = finished(&scene)?;
    Ok(run.samples.last().ok_or(Lacks("sample"))?.state.field.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_the_penalty_it_falls_short() {
        let finest = |outcome: Outcome| outcome.errors[2].1;
        let with = finest(outcome(None).expect("a run"));
        let without = finest(outcome(Some(0.0)).expect("a run"));
        assert!(with <= 1e-3 && without > 5e-3, "{with:.1e} {without:.1e}");
    }
}

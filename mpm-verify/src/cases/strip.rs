//! A strip load on an undrained block: equal-order pressures would oscillate without the jump penalty.
//!
//! Compared with a run on 45 cells per side, whose cells have the middles of the coarse ones among theirs, and with the exact
//! sum of cosines. The error is the RMS over the block, as a share of the load.

use mpm_core::observe::FieldPoint;
use mpm_core::scene::{Fields, Scene, ShapeChoice};

use super::{Error, Lacks, Mutant, Outcome, Program, asked, finished, integrator, scheme};
use crate::baseline::suite::Kind;
use crate::exact::strip::StripLoad;

/// The case.
pub const CASE: Program = Program {
    name: "strip",
    about: "undrained block under a strip load, B-splines: no oscillation of the pressure",
    run: || outcome(None),
    mutant: Some(Mutant { what: "no jump penalty", run: || outcome(Some(0.0)) }),
};

/// Against the sum.
pub const SUM: Program = Program {
    name: "strip-sum",
    about: "the same against the sum of cosines: pore pressure, order 2 or more",
    run: || against_sum(&QUADRATIC, 1.0),
    mutant: Some(Mutant { what: "load 2 % too large", run: || against_sum(&QUADRATIC, 1.02) }),
};

/// Against the sum, cubic B-splines.
pub const CUBIC: Program = Program {
    name: "strip-sum-cubic",
    about: "the same with cubic B-splines, order 3 or more: the load has kinks",
    run: || against_sum(&CUBIC_SPLINES, 1.0),
    mutant: Some(Mutant { what: "load 2 % too large", run: || against_sum(&CUBIC_SPLINES, 1.02) }),
};

/// What is compared with the sum.
struct Judged {
    with: fn(&mut Fields),
    /// Cells along each side.
    sides: &'static [usize],
    order: [f64; 2],
}

const QUADRATIC: Judged = Judged { with: |_| (), sides: &[10, 14, 20, 28, 40], order: [2.0, 3.2] };

/// With the penalty of every such scene, and the particles that integrate products of slopes. The kinks of the load stand on lines
/// of each mesh: how far they are from them would else be in the error.
const CUBIC_SPLINES: Judged = Judged {
    with: |scene| {
        (scene.shape, scene.particles_per_cell, scene.jump_penalty) = (ShapeChoice::Bspline3, 16, None);
    },
    sides: &[10, 20, 30, 40],
    order: [3.0, 4.5],
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
    let kind = Kind::Regression;
    Ok(Outcome {
        integrator,
        scheme,
        tolerance: asked(&base),
        errors,
        required_error: 1e-3,
        kind,
        ..Outcome::default()
    })
}

/// The load is wrong by a factor.
fn against_sum(judged: &Judged, factor: f64) -> Result<Outcome, Error> {
    let mut base = crate::scenes::built_in("strip")?;
    let load = base.surcharge.ok_or(Lacks("load"))?.pressure;
    base = base.edited(judged.with)?;
    let exact = StripLoad::new(&base).ok_or(Lacks("strip"))?;
    base = base.edited(|base| {
        if let Some(surcharge) = &mut base.surcharge {
            surcharge.pressure *= factor;
        }
    })?;
    let mut errors = Vec::new();
    for &side in judged.sides {
        let field = field(&base, side)?;
        let square = |p: &FieldPoint| ((p.pressure_pa - exact.pressure(p.x_m, p.y_m)) / load).powi(2);
        let mean = field.iter().map(square).sum::<f64>() / field.len() as f64;
        errors.push((base.width / side as f64, mean.sqrt()));
    }
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    Ok(Outcome {
        integrator,
        scheme,
        errors,
        required_error: 1e-4,
        required_order: Some(judged.order),
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

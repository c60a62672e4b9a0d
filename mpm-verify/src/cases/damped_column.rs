//! A closed column that settles against a strong damping, with implicit pressure: what the pressures of the end of a step do to
//! the velocities is slowed by the damping as well.
//!
//! A step of backward Euler kind is of first order; it is far longer than damping takes to stop a particle.

use mpm_core::drive::Sample;
use mpm_core::scene::{Fields, Integrator, Scene, Start, StepChoice, Surcharge, Until};

use super::{Error, Lacks, Mutant, Outcome, Program, finished, integrator, scheme, sound};
use crate::exact::damped_column::DampedColumn;
use crate::experiment::comparison::{Compared, Comparison, in_time};

/// The case.
pub const CASE: Program = Program {
    name: "damped-column",
    about: "a closed column that settles against damping, implicit pressure: settlement, order 1 in the step",
    run: || outcome(sound),
    mutant: Some(Mutant { what: "damping 2 % too strong", run: || outcome(stronger) }),
};

/// Damping as a multiple of the lowest frequency of the closed column.
const STRONG: f64 = 50.0;
const ROWS: [usize; 5] = [10, 14, 20, 28, 40];
/// Step on 20 rows as a share of the time in which the slowest wave falls; on others with the mesh.
const SHARE: f64 = 1.0 / 640.0;

fn stronger(scene: &mut Fields) {
    scene.stages[0].damping *= 1.02;
}

/// Table 1's column, closed, from rest under a hundredth of its load.
fn column() -> Result<(Scene, DampedColumn), Error> {
    let mut base = crate::scenes::terzaghi().edited(|base| {
        (base.history, base.start, base.integrator) = (0, Start::Unloaded, Integrator::SemiImplicit);
        base.surcharge = base.surcharge.map(|s| Surcharge { pressure: 0.01 * s.pressure, ramp_time: 0.0, ..s });
        base.stages[0].drained = [false; 4];
        if let Some(water) = &mut base.water {
            // Nothing flows within a second, from the top down either.
            water.hydraulic_conductivity = 1e-15;
        }
    })?;
    let exact = DampedColumn::new(&base).ok_or(Lacks("load"))?;
    base = base.edited(|base| base.stages[0].damping = STRONG * exact.frequency)?;
    let exact = DampedColumn::new(&base).ok_or(Lacks("load"))?;
    let times = [0.2, 0.5, 1.0, 2.0].map(|share| share * exact.slowness());
    base = base.edited(|base| (base.observe_times, base.stages[0].until) = (times.to_vec(), Until::Time(times[3])))?;
    Ok((base, exact))
}

fn outcome(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let (mut base, exact) = column()?;
    base = base.edited(fault)?;
    let looks_at = |scene: &Scene| {
        let look = |s: &Sample| {
            Compared::one(s.stage_time, s.state.settlement / exact.whole, exact.settlement(s.stage_time) / exact.whole)
        };
        Ok::<_, Error>(Comparison::worst(
            "settlement over the last one",
            finished(scene)?.observed().map(look).collect(),
        ))
    };
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for rows in ROWS {
        let scene = base.with_rows(rows)?;
        let step = StepChoice::Fixed(SHARE * exact.slowness() * 20.0 / rows as f64);
        let looks = looks_at(&scene.edited(|s| s.step = step)?)?;
        errors.push((base.height / rows as f64, looks.error()));
        samples = looks.samples();
    }
    let coarse = base.with_rows(ROWS[2])?;
    let stepped = |step| looks_at(&coarse.edited(|s| s.step = StepChoice::Fixed(step))?);
    let first = 0.025 * exact.slowness();
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1e-3,
        // Of the mesh L^2, of the step L.
        required_order: Some([0.8, 2.2]),
        samples,
        refinements: vec![in_time(stepped, coarse.cell, first, 4, Some([0.8, 1.2]))?],
        ..Outcome::default()
    })
}

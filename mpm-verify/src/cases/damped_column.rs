//! A closed column that settles against a strong damping, with implicit pressure: what the pressures of the end of a step do to
//! the velocities is slowed by the damping as well.
//!
//! A step of backward Euler kind is of first order; it is far longer than damping takes to stop a particle.

use mpm_core::drive::Sample;
use mpm_core::scene::{Integrator, Scene, Start, StepChoice, Surcharge, Until};
use mpm_core::stability::stable_limit;

use super::evidence::{MESH, Refinement, STEP};
use super::looks::{Look, Looks};
use super::{Mutant, Outcome, Rung, finished, integrator, scheme, sound, with_rows};
use crate::exact::damped_column::DampedColumn;

/// The rung.
pub const RUNG: Rung = Rung {
    name: "damped-column",
    about: "a closed column that settles against damping, implicit pressure: settlement, order 1 in the step",
    climb: || climb(sound),
    mutant: Some(Mutant { what: "damping 2 % too strong", climb: || climb(stronger) }),
};

/// Damping as a multiple of the lowest frequency of the closed column.
const STRONG: f64 = 50.0;
const ROWS: [usize; 3] = [10, 20, 40];
const HALVINGS: i32 = 5;

fn stronger(scene: &mut Scene) {
    scene.stages[0].damping *= 1.02;
}

/// Table 1's column, closed, from rest under a hundredth of its load.
fn column() -> Result<(Scene, DampedColumn), String> {
    let mut base = crate::scenes::terzaghi();
    (base.history, base.start, base.integrator) = (0, Start::Unloaded, Integrator::SemiImplicit);
    base.surcharge = base.surcharge.map(|s| Surcharge { pressure: 0.01 * s.pressure, ramp_time: 0.0, ..s });
    base.stages[0].drained = [false; 4];
    if let Some(water) = &mut base.water {
        // Nothing flows within a second, from the top down either.
        water.hydraulic_conductivity = 1e-15;
    }
    let exact = DampedColumn::new(&base).ok_or("no load")?;
    base.stages[0].damping = STRONG * exact.frequency;
    let exact = DampedColumn::new(&base).ok_or("no load")?;
    let times = [0.2, 0.5, 1.0, 2.0].map(|share| share * exact.slowness());
    (base.observe_times, base.stages[0].until) = (times.to_vec(), Until::Time(times[3]));
    Ok((base, exact))
}

fn climb(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    let (mut base, exact) = column()?;
    fault(&mut base);
    let looks = |scene: &Scene| {
        let look = |s: &Sample| {
            Look::one(s.stage_time, s.state.settlement / exact.whole, exact.settlement(s.stage_time) / exact.whole)
        };
        Ok::<_, String>(Looks::worst("settlement over the last one", finished(scene)?.observed().map(look).collect()))
    };
    let on = |rows: usize, halvings: i32| {
        let scene = with_rows(base.clone(), rows);
        // No longer than the shortest of the times.
        let first = (0.5 * stable_limit(&scene)).min(0.05 * exact.slowness());
        Scene { step: StepChoice::Fixed(first / 2.0_f64.powi(halvings)), ..scene }
    };
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for halvings in 0..=HALVINGS {
        let scene = on(ROWS[1], halvings);
        let StepChoice::Fixed(step) = scene.step else { continue };
        let looks = looks(&scene)?;
        errors.push((step, looks.error()));
        samples = looks.samples();
    }
    let meshes = ROWS.map(|rows| Ok((base.height / rows as f64, looks(&on(rows, HALVINGS))?.error())));
    let meshes = meshes.into_iter().collect::<Result<_, String>>()?;
    let against = "the sum of waves, at the same share of the stable step on every mesh";
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1e-3,
        required_order: Some([0.8, 1.3]),
        refined_by: STEP,
        samples,
        refinements: vec![Refinement { required_error: Some(3e-3), ..Refinement::new(MESH, meshes, against) }],
        ..Outcome::default()
    })
}

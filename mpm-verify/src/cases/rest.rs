//! Soil under gravity stays at rest over 100 000 steps: a dry and a saturated column, an infinite slope below its friction
//! angle, and an elastic slope that was damped to rest before.

use mpm_core::drive::Sample;
use mpm_core::scene::{Base, Fields, Until};
use mpm_core::stability::choose_step;

use super::{Error, Lacks, Mutant, Outcome, Program, sound};
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::refinement::{PARTICLES, Refinement, Sampled};
use crate::experiment::shared::shared;
use crate::norms::largest;

/// Nothing moves.
pub const SPEED: Program = Program {
    name: "rest-speed",
    about: "columns and slopes under gravity at rest for 1e5 steps: largest speed of a particle, m/s",
    run: || outcome(STEPS, SPEEDS, 1e-8, sound),
    mutant: Some(Mutant { what: STEEPER, run: || outcome(FEW, SPEEDS, 1e-8, steeper) }),
};

/// No energy comes or goes.
pub const ENERGY: Program = Program {
    name: "rest-energy",
    about: "the same: change of the residual of the energy balance, of the energy stored",
    run: || outcome(STEPS, ENERGIES, 1e-10, sound),
    mutant: Some(Mutant { what: STEEPER, run: || outcome(FEW, ENERGIES, 1e-10, steeper) }),
};

const STEPS: u32 = 100_000;
const SCENES: [&str; 4] = ["self-weight", "hydrostatic", "infinite-slope", "slope-at-rest"];

const SPEEDS: Watched = ("largest speed", "m/s", speed);
const ENERGIES: Watched = ("change of the closing error over the energy stored", "-", energy);
const COUNTS: [usize; 3] = [1, 4, 9];

fn speed(_: &Sample, last: &Sample) -> f64 {
    last.state.max_speed
}

fn energy(first: &Sample, last: &Sample) -> f64 {
    let stored = last.balance.strain_j + last.balance.water_j;
    ((last.balance.energy_residual_j - first.balance.energy_residual_j) / stored).abs()
}

/// The largest `figure` of all scenes, and that of fewer steps with other numbers of particles.
fn outcome(steps: u32, watched: Watched, required_error: f64, spoil: fn(&mut Fields)) -> Result<Outcome, Error> {
    let (worst, samples) = followed(steps, watched, spoil)?;
    let with = |count: &usize| {
        let counted = |scene: &mut Fields| {
            spoil(scene);
            scene.particles_per_cell = *count;
        };
        Ok((*count as f64, followed(FEW, watched, counted)?.0))
    };
    let counted = COUNTS.iter().map(with).collect::<Result<_, Error>>()?;
    let counted = Refinement::new(PARTICLES, counted, format!("nothing moves, over {FEW} steps"));
    Ok(Outcome {
        integrator: "explicit".to_owned(),
        scheme: "centre and linear".to_owned(),
        errors: vec![(0.5, worst)],
        required_error,
        required_order: None,
        samples,
        refinements: vec![Refinement { required_error: Some(required_error), ..counted }],
        ..Outcome::default()
    })
}

/// What is looked at and its unit, from the first and another sample of the last stage.
type Watched = (&'static str, &'static str, fn(&Sample, &Sample) -> f64);

/// The largest figure at the end of so many steps of the last stage of all scenes, and all of its times.
fn followed(
    steps: u32,
    (what, unit, figure): Watched,
    spoil: impl Fn(&mut Fields),
) -> Result<(f64, Vec<Sampled>), Error> {
    let (mut ends, mut samples) = (Vec::new(), Vec::new());
    for name in SCENES {
        let mut scene = crate::scenes::built_in(name)?;
        scene = scene.edited(&spoil)?;
        let end = f64::from(steps) * choose_step(&scene)?;
        let stage = scene.stages.len() - 1;
        scene = scene.edited(|scene| {
            scene.stages[stage].until = Until::Time(end);
            (scene.observe_times, scene.history) = ([0.25, 0.5, 0.75, 1.0].map(|share| share * end).to_vec(), 0);
        })?;
        let run = shared(&scene)?;
        let first = run.samples.iter().find(|s| s.stage == stage).ok_or(Lacks("sample"))?;
        let look = |s: &Sample| Compared::one(s.stage_time, figure(first, s), 0.0);
        let looks =
            Comparison { unit, ..Comparison::worst(format!("{what}, {name}"), run.observed().map(look).collect()) };
        ends.push(looks.rows.last().map_or(f64::NAN, |row| row.computed[0]));
        samples.extend(looks.samples());
    }
    Ok((largest(ends.into_iter()), samples))
}

/// A fault that both checks find within a few steps.
const STEEPER: &str = "friction one degree below the slope";
const FEW: u32 = 1000;

/// Plants it.
fn steeper(scene: &mut Fields) {
    let angle = scene.slope_angle.unwrap_or(0.0) - 1.0;
    scene.base = scene.base.map(|b| Base { peak_angle: angle, residual_angle: angle, ..b });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soil_rests_and_a_slope_above_its_friction_does_not() {
        for (figure, required) in [(SPEEDS, 1e-8), (ENERGIES, 1e-10)] {
            let sound = outcome(2 * FEW, figure, required, sound).expect("runs that finish");
            assert!(sound.errors[0].1 <= required, "{sound:?}");
        }
        for case in [SPEED, ENERGY] {
            let spoilt = case.mutant_judged().expect("a mutant").expect("runs that finish");
            assert!(!spoilt.row.passed(), "{}", spoilt.reason);
        }
    }
}

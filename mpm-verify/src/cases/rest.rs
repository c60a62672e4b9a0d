//! Soil under gravity stays at rest over 100 000 steps: a dry and a saturated column, an infinite slope below its friction
//! angle, and an elastic slope that was damped to rest before.

use mpm_core::drive::Sample;
use mpm_core::scene::{Base, Scene, Until};
use mpm_core::stability::choose_step;

use super::{Mutant, Outcome, Rung, finished, integrator, sound};

/// Nothing moves.
pub const SPEED: Rung = Rung {
    name: "rest-speed",
    about: "columns and slopes under gravity at rest for 1e5 steps: largest speed of a particle, m/s",
    climb: || climb(STEPS, speed, 1e-8, sound),
    mutant: Some(Mutant { what: STEEPER, climb: || climb(FEW, speed, 1e-8, steeper) }),
};

/// No energy comes or goes.
pub const ENERGY: Rung = Rung {
    name: "rest-energy",
    about: "the same: change of the energy ledger's closing error, of the energy stored",
    climb: || climb(STEPS, energy, 1e-10, sound),
    mutant: Some(Mutant { what: STEEPER, climb: || climb(FEW, energy, 1e-10, steeper) }),
};

const STEPS: u32 = 100_000;
const SCENES: [&str; 4] = ["self-weight", "hydrostatic", "infinite-slope", "slope-at-rest"];

fn speed(_: &Sample, last: &Sample) -> f64 {
    last.state.max_speed
}

fn energy(first: &Sample, last: &Sample) -> f64 {
    let stored = last.ledger.strain_j + last.ledger.water_j;
    ((last.ledger.energy_closing_j - first.ledger.energy_closing_j) / stored).abs()
}

/// The largest `figure` of all scenes, from the first and the last sample of their last stage of so many steps.
fn climb(
    steps: u32,
    figure: fn(&Sample, &Sample) -> f64,
    required_error: f64,
    spoil: fn(&mut Scene),
) -> Result<Outcome, String> {
    let mut worst: f64 = 0.0;
    let mut name = String::new();
    for scene in SCENES {
        let mut scene = crate::scenes::built_in(scene).ok_or("no such scene")?.map_err(|e| e.to_string())?;
        spoil(&mut scene);
        let end = f64::from(steps) * choose_step(&scene).map_err(|e| e.to_string())?;
        let stage = scene.stages.len() - 1;
        scene.stages[stage].until = Until::Time(end);
        (scene.observe_times, scene.history) = (vec![end], 0);
        let run = finished(&scene)?;
        let first = run.samples.iter().find(|s| s.stage == stage).ok_or("no sample")?;
        worst = worst.max(figure(first, run.samples.last().ok_or("no sample")?));
        name = integrator(&scene);
    }
    let scheme = "centre and linear".to_owned();
    Ok(Outcome {
        integrator: name,
        scheme,
        errors: vec![(0.5, worst)],
        required_error,
        required_order: None,
        ..Outcome::default()
    })
}

/// A fault that both checks find within a few steps.
const STEEPER: &str = "friction one degree below the slope";
const FEW: u32 = 1000;

/// Plants it.
fn steeper(scene: &mut Scene) {
    let angle = scene.slope_angle.unwrap_or(0.0) - 1.0;
    scene.base = scene.base.map(|b| Base { peak_angle: angle, residual_angle: angle, ..b });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soil_rests_and_a_slope_above_its_friction_does_not() {
        for (figure, required) in [(speed as fn(&Sample, &Sample) -> f64, 1e-8), (energy, 1e-10)] {
            let sound = climb(2 * FEW, figure, required, sound).expect("runs that finish");
            assert!(sound.errors[0].1 <= required, "{sound:?}");
        }
        for rung in [SPEED, ENERGY] {
            let spoilt = rung.climb_mutant().expect("a mutant").expect("runs that finish");
            assert!(!spoilt.step.held(), "{}", spoilt.reason);
        }
    }
}

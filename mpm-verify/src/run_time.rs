//! Estimates how long a run will take before it starts.

use std::time::{Duration, Instant};

use mpm_core::hardware::Hardware;
use mpm_core::run::model_on;
use mpm_core::scene::{Integrator, Scene, Stage, Until};
use mpm_core::stability::choose_step;

/// A run that takes longer than this announces it before it starts, s.
pub const LONG: f64 = 3600.0;
/// Time for which steps are measured.
const TIMED: Duration = Duration::from_millis(100);
/// Upper bound of the time of a step per particle and per cell, s: a run that takes less than [`LONG`] at this cost is not timed.
const MOST_EXPENSIVE: f64 = 2e-6;

/// The estimate of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Number of steps; the largest possible number if a stage ends by a criterion.
    pub steps: f64,
    /// Length of a step, s.
    pub step_s: f64,
    /// Wall-clock time, s.
    pub wall_s: f64,
}

/// Longest simulated time of a stage, s.
pub fn longest(stage: &Stage) -> f64 {
    match stage.until {
        Until::Time(time) => time,
        Until::PorePressure { at_most, .. } | Until::Rest { at_most, .. } => at_most,
    }
}

/// Estimates a run from steps that are timed on this machine; `None` for a run that is certainly short, or whose integrator chooses
/// its own steps.
pub fn estimate(scene: &Scene, hardware: &Hardware) -> Option<Estimate> {
    let in_steps = matches!(scene.integrator, Integrator::Explicit | Integrator::SemiImplicit | Integrator::Coupled);
    let step_s = choose_step(scene).ok().filter(|step| in_steps && step.is_finite() && *step > 0.0)?;
    let time: f64 = scene.stages.iter().map(longest).sum();
    let steps = time / step_s;
    let cells = scene.cells.map(|count| count as f64);
    let most = steps * MOST_EXPENSIVE * (1.0 + scene.solid_particles() as f64 + cells[0] * cells[1]);
    if most <= LONG {
        return None;
    }
    Some(Estimate { steps, step_s, wall_s: steps * cost(scene, hardware, step_s)? })
}

/// Time of a step, s, measured on the first steps of the run, which are then discarded.
fn cost(scene: &Scene, hardware: &Hardware, step_s: f64) -> Option<f64> {
    let mut model = model_on(hardware, scene).ok()?;
    let stage = scene.stages.first()?;
    model.enter_stage(stage, &[1e6 * step_s]).ok()?;
    let mut count = 1;
    loop {
        let (clock, mut done) = (Instant::now(), 0);
        model.advance(step_s, count, &mut done).ok()?;
        let took = clock.elapsed();
        if took >= TIMED {
            return Some(took.as_secs_f64() / count as f64);
        }
        count *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_s_column_is_short_and_the_same_for_a_day_is_long() {
        let mut scene = crate::scenes::terzaghi();
        assert_eq!(estimate(&scene, &Hardware::default()), None);
        scene = scene.edited(|scene| scene.stages[0].until = Until::Time(86_400.0)).expect("a sound scene");
        let long = estimate(&scene, &Hardware::default()).expect("an estimate");
        assert!(long.wall_s > LONG && (long.steps * long.step_s - 86_400.0).abs() < 1.0, "{long:?}");
        // From 1 ns to 1 us for a particle.
        let each = long.wall_s / long.steps / scene.solid_particles() as f64;
        assert!((1e-9..1e-6).contains(&each), "{each:.1e} s");
        let other = scene.edited(|s| s.integrator = Integrator::QuasiStatic).expect("a sound scene");
        assert_eq!(estimate(&other, &Hardware::default()), None);
    }
}

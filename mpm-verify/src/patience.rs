//! How long a run in steps will take, before it starts.

use std::time::{Duration, Instant};

use mpm_core::hardware::Hardware;
use mpm_core::run::model_on;
use mpm_core::scene::{Integrator, Scene, Until};
use mpm_core::stability::choose_step;

/// A run that takes longer says so before it starts, s.
pub const LONG: f64 = 3600.0;
/// Steps are timed for so long.
const TIMED: Duration = Duration::from_millis(100);
/// No step costs more per particle and per cell, s: what takes less than [`LONG`] at this price is not timed.
const DEAREST: f64 = 2e-6;

/// What a run in steps will take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Steps; as many as there may be, if a stage ends by itself.
    pub steps: f64,
    /// Length of a step, s.
    pub step_s: f64,
    /// Time on the clock of the machine, s.
    pub wall_s: f64,
}

/// An estimate from steps that are timed here; `None` for a run that is short at any price, or whose integrator divides the time itself.
pub fn estimate(scene: &Scene, hardware: &Hardware) -> Option<Estimate> {
    let in_steps = matches!(scene.integrator, Integrator::Explicit | Integrator::SemiImplicit | Integrator::Coupled);
    let step_s = choose_step(scene).ok().filter(|step| in_steps && step.is_finite() && *step > 0.0)?;
    let time: f64 = scene
        .stages
        .iter()
        .map(|stage| match stage.until {
            Until::Time(time) => time,
            Until::PorePressure { at_most, .. } | Until::Rest { at_most, .. } => at_most,
        })
        .sum();
    let steps = time / step_s;
    let cells = scene.cells.map(|count| count as f64);
    let most = steps * DEAREST * (1.0 + scene.solid_particles() as f64 + cells[0] * cells[1]);
    if most <= LONG {
        return None;
    }
    Some(Estimate { steps, step_s, wall_s: steps * cost(scene, hardware, step_s)? })
}

/// Time of a step, s: of the run's own first steps, which are then forgotten.
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

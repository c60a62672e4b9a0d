//! Which stage of a vectorised step takes how much of it.
//!
//! Stages are done in the order of a step, with a step of no time so that nothing moves: each finds the caches as the one
//! before it left them.

use std::time::Instant;

use mpm_core::step::Model;
use mpm_verify::report::numbers::exact;
use serde::{Deserialize, Serialize};

use super::sizes::{Effort, spread};

/// The stage that is no part of a usual step: it follows a change of cells.
const APART: &str = "particles to mesh alone";
/// Rounds over all stages, per sample of a size.
const ROUNDS: usize = 5;

/// Columns of `kernel_stages.csv`.
pub const COLUMNS: &str = "points,stage,in_step,ns_per_point,share";

/// What a stage takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Solid particles.
    pub points: usize,
    /// The stage, as the model names it.
    pub stage: String,
    /// Whether every step has it.
    pub in_step: bool,
    /// Median time on the clock per point, ns.
    pub ns: f64,
    /// Its share of all stages that every step has.
    pub share: f64,
}

impl Share {
    /// The fields of `kernel_stages.csv`.
    pub fn fields(&self) -> Vec<String> {
        vec![self.points.to_string(), self.stage.clone(), self.in_step.to_string(), exact(self.ns), exact(self.share)]
    }
}

/// Times the stages of a model.
pub fn profile(model: &mut dyn Model, effort: Effort) -> Vec<Share> {
    let (points, stages) = (model.solid_count(), model.stages());
    let rounds = ROUNDS.max(effort.point_steps / points);
    let clock = clock();
    let mut times = vec![Vec::with_capacity(rounds); stages.len()];
    for _ in 0..rounds {
        for (stage, times) in times.iter_mut().enumerate().filter(|(s, _)| stages[*s] != APART) {
            let start = Instant::now();
            model.do_stage(stage, 0.0);
            times.push(start.elapsed().as_secs_f64());
        }
    }
    if let Some(apart) = stages.iter().position(|name| *name == APART) {
        for _ in 0..ROUNDS.max(rounds / 4) {
            let start = Instant::now();
            model.do_stage(apart, 0.0);
            times[apart].push(start.elapsed().as_secs_f64());
        }
    }
    let per_point = 1e9 / points as f64;
    let ns: Vec<f64> = times.iter().map(|times| (spread(times)[0] - clock).max(0.0) * per_point).collect();
    let whole: f64 = stages.iter().zip(&ns).filter(|(name, _)| **name != APART).map(|(_, ns)| ns).sum();
    let share = |(name, ns): (&&str, &f64)| Share {
        points,
        stage: (*name).to_owned(),
        in_step: *name != APART,
        ns: *ns,
        share: ns / whole,
    };
    stages.iter().zip(&ns).map(share).collect()
}

/// What looking at the clock takes, s.
fn clock() -> f64 {
    let looks: Vec<f64> = (0..101)
        .map(|_| {
            let start = Instant::now();
            start.elapsed().as_secs_f64()
        })
        .collect();
    spread(&looks)[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::run::model;

    #[test]
    fn the_stages_of_a_step_add_up_and_nothing_moves() {
        let scene = crate::block([5, 50]).expect("a sound scene");
        let mut model = model(&scene).expect("a model");
        model.enter_stage(&scene.stages[0], &[]).expect("a stage");
        let before = model.observe().0;
        let shares = profile(model.as_mut(), Effort { point_steps: 20_000, warm_up: 0, samples: 1 });
        assert_eq!(shares.iter().filter(|s| !s.in_step).count(), 1, "the stage apart has another name");
        let whole: f64 = shares.iter().filter(|s| s.in_step).map(|s| s.share).sum();
        assert!((whole - 1.0).abs() < 1e-12, "{whole}");
        let longest = shares.iter().filter(|s| s.in_step).max_by(|a, b| a.ns.total_cmp(&b.ns)).expect("stages");
        assert!(longest.stage.contains("mesh to particles"), "{shares:?}");
        assert!(shares.iter().all(|s| s.fields().len() == COLUMNS.split(',').count()));
        assert_eq!(model.observe().0.settlement.to_bits(), before.settlement.to_bits());
    }
}

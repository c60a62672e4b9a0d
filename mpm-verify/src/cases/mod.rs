//! The verification ladder: one case per file, each with its scene, its exact solution, its norm, what it must show.

mod double_drainage;
mod dry_bar;
mod dynamic_column;
mod hydrostatic;
mod large_strain;
mod mandel;
mod quasi_static;
mod ramp_load;
mod semi_implicit;
mod strip;
mod terzaghi;
mod undrained;

use cpu_time::ThreadTime;
use mpm_core::drive::Sample;
use mpm_core::run::run;
use mpm_core::scene::Scene;
use serde::{Deserialize, Serialize};

use crate::norms::largest;
use crate::rates::{Fit, fit};
use crate::study::word;

/// One rung of the ladder.
#[derive(Clone, Copy)]
pub struct Rung {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows, against what.
    pub about: &'static str,
    /// Runs it.
    climb: fn() -> Result<Outcome, String>,
}

/// All rungs, the simplest first.
pub const LADDER: [Rung; 27] = [
    hydrostatic::RUNG,
    undrained::RUNG,
    dry_bar::RUNG,
    dynamic_column::WITH_INERTIA,
    dynamic_column::WITHOUT_INERTIA,
    terzaghi::SURFACE,
    terzaghi::LINEAR,
    terzaghi::NODAL,
    terzaghi::GIMP,
    terzaghi::SPLINES,
    semi_implicit::AT_ITS_LIMIT,
    semi_implicit::CENTRE,
    semi_implicit::SPLINES,
    double_drainage::RUNG,
    ramp_load::RUNG,
    quasi_static::SPLINES,
    quasi_static::COARSE,
    quasi_static::CENTRE,
    quasi_static::PROFILE,
    quasi_static::STEPS,
    quasi_static::DISPLACED,
    quasi_static::SHIFTED,
    large_strain::SPLINES,
    large_strain::LINEAR,
    mandel::SPLINES,
    mandel::CENTRE,
    strip::RUNG,
];

/// What a rung found, before it is judged.
#[derive(Debug, Clone, PartialEq)]
struct Outcome {
    integrator: String,
    scheme: String,
    /// (mesh in m, signed error), or a single entry where there is nothing to refine.
    errors: Vec<(f64, f64)>,
    /// Largest error allowed on the finest mesh.
    required_error: f64,
    /// Allowed interval of the fitted order, if the case converges.
    required_order: Option<[f64; 2]>,
}

/// A judged rung: a row of `ladder.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Name of the rung.
    pub rung: String,
    /// Time integrator.
    pub integrator: String,
    /// Shape scheme and Darcy operator.
    pub scheme: String,
    /// Error on the finest mesh.
    pub error: f64,
    /// Largest error allowed.
    pub required_error: f64,
    /// Fitted order of convergence.
    pub order: Option<f64>,
    /// Lower end of its 95 % interval.
    pub order_low: Option<f64>,
    /// Upper end.
    pub order_high: Option<f64>,
    /// What the order must be.
    pub required_order: String,
    /// `held` or `fell short`.
    pub verdict: String,
    /// CPU time of the rung, s.
    pub cpu_s: f64,
}

impl Step {
    /// Whether the rung holds.
    pub fn held(&self) -> bool {
        self.verdict == "held"
    }
}

impl Rung {
    /// Runs and judges the rung.
    ///
    /// # Errors
    /// A run of it could not be finished.
    pub fn climb(&self) -> Result<Step, String> {
        let clock = ThreadTime::now();
        let outcome = (self.climb)().map_err(|e| format!("{}: {e}", self.name))?;
        Ok(judge(self.name, &outcome, clock.elapsed().as_secs_f64()))
    }
}

/// The one rule: the finest error is small enough, and the order is in its interval.
fn judge(name: &str, outcome: &Outcome, cpu_s: f64) -> Step {
    let finest = outcome.errors.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(f64::NAN, |(_, e)| e.abs());
    let fit: Option<Fit> = fit(&outcome.errors);
    let order_holds = match (outcome.required_order, &fit) {
        (None, _) => true,
        (Some([low, high]), Some(fit)) => (low..=high).contains(&fit.order),
        (Some(_), None) => false,
    };
    let holds = finest <= outcome.required_error && order_holds;
    let fit = fit.filter(|_| outcome.required_order.is_some());
    Step {
        rung: name.to_owned(),
        integrator: outcome.integrator.clone(),
        scheme: outcome.scheme.clone(),
        error: finest,
        required_error: outcome.required_error,
        order: fit.as_ref().map(|f| f.order),
        order_low: fit.as_ref().map(|f| f.order - f.half_width),
        order_high: fit.as_ref().map(|f| f.order + f.half_width),
        required_order: outcome.required_order.map_or(String::new(), |[low, high]| format!("{low} to {high}")),
        verdict: if holds { "held" } else { "fell short" }.to_owned(),
        cpu_s,
    }
}

/// `centre/face` and the like.
fn scheme(scene: &Scene) -> String {
    let shape = word(scene.shape);
    if scene.water.is_some() { format!("{shape}/{}", word(scene.darcy)) } else { shape }
}

/// `explicit` and the like.
fn integrator(scene: &Scene) -> String {
    word(scene.integrator)
}

/// The scene on a mesh of `rows` cells over its height.
fn with_rows(mut scene: Scene, rows: usize) -> Scene {
    scene.cell = scene.height / rows as f64;
    scene.cells[1] = rows;
    scene
}

/// Runs a scene on several meshes: (mesh in m, largest error over the observed samples).
fn refine(base: &Scene, rows: &[usize], error: impl Fn(&Sample) -> f64) -> Result<Vec<(f64, f64)>, String> {
    let on = |rows: &usize| {
        let scene = with_rows(base.clone(), *rows);
        Ok((scene.cell, largest(finished(&scene)?.observed().map(&error))))
    };
    rows.iter().map(on).collect()
}

/// Runs a scene to its end.
fn finished(scene: &Scene) -> Result<mpm_core::drive::Run, String> {
    let run = run(scene, &mut |_| {}).map_err(|e| e.to_string())?;
    match &run.failure {
        Some(failure) => Err(failure.to_string()),
        None => Ok(run),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_check_can_fail() {
        let errors = vec![(0.1, 1e-2), (0.05, 2.5e-3), (0.025, 6.25e-4)];
        let good = Outcome {
            integrator: String::new(),
            scheme: String::new(),
            errors,
            required_error: 1e-3,
            required_order: Some([1.8, 2.2]),
        };
        assert!(judge("good", &good, 0.0).held());
        let too_large = Outcome { required_error: 5e-4, ..good.clone() };
        assert!(!judge("error", &too_large, 0.0).held());
        let wrong_order = Outcome { required_order: Some([2.8, 3.2]), ..good.clone() };
        assert!(!judge("order", &wrong_order, 0.0).held());
        let not_a_number = Outcome { errors: vec![(0.1, f64::NAN)], required_order: None, ..good };
        assert!(!judge("nan", &not_a_number, 0.0).held());
    }

    #[test]
    fn names_are_unique() {
        let mut names: Vec<&str> = LADDER.iter().map(|rung| rung.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), LADDER.len());
    }
}

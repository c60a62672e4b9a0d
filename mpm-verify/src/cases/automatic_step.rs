//! The step that `step = "auto"` takes, against the limits of waves that have a closed form.
//!
//! Where nothing flows, the shortest wave of a column that its particles give back by the share `S` of its accelerations has
//! `dt = L sqrt(rho/((2 - S) K))`, with K = M in dry soil, M + K_w/n in closed soil; FLIP with S = 1/4 for two particles along an
//! edge, 0 for one, and 8/27 for three. The step is the safety factor times that.

use mpm_core::scene::{Scene, ShapeChoice, StepChoice, Until};

use super::{Error, Mutant, Outcome, Program, finished};
use crate::experiment::refinement::RUNS;
use crate::norms::largest;

/// The case.
pub const CASE: Program = Program {
    name: "automatic-step",
    about: "the automatic explicit step of dry and of closed columns over the limit of the shortest wave times its safety",
    run: || outcome(1.0),
    mutant: Some(Mutant { what: "soil 1 % stiffer", run: || outcome(1.01) }),
};

/// Particles per cell, and S of the shortest wave: the mean of (1 - 2 xi)^2 over the places xi of the particles along an edge.
const SHARES: [(usize, f64); 3] = [(1, 0.0), (4, 1.0 / 4.0), (9, 8.0 / 27.0)];
const SAFETIES: [f64; 2] = [0.9, 0.45];

/// Runs of a few steps; the soil is stiffer than the limit knows by a factor.
fn outcome(factor: f64) -> Result<Outcome, Error> {
    let built_in = |name| crate::scenes::built_in(name);
    let dry: Scene = built_in("dry-bar")?;
    let closed = crate::scenes::terzaghi().edited(|closed| {
        for stage in &mut closed.stages {
            stage.drained = [false; 4];
        }
        if let Some(water) = &mut closed.water {
            water.hydraulic_conductivity = 1e-15;
        }
    })?;
    let mut off = Vec::new();
    for base in [dry, closed] {
        for (particles_per_cell, share) in SHARES {
            for safety in SAFETIES {
                let mut scene = base
                    .edited(|s| {
                        s.particles_per_cell = particles_per_cell;
                        s.safety = safety;
                    })?
                    .edited(|scene| {
                        (scene.shape, scene.step, scene.flip, scene.history) =
                            (ShapeChoice::Linear, StepChoice::Auto, 1.0, 0)
                    })?;
                let stiffness = factor * scene.oedometer_modulus() + scene.pore_stiffness();
                let limit = scene.cell * (scene.mixture_density() / ((2.0 - share) * stiffness)).sqrt();
                let last = scene.stages.len() - 1;
                let end = 20.0 * safety * limit;
                scene = scene.edited(|scene| {
                    scene.stages[last].until = Until::Time(end);
                    scene.observe_times = vec![end];
                })?;
                let run = finished(&scene)?;
                off.push(run.dt / (safety * limit) - 1.0);
            }
        }
    }
    Ok(Outcome {
        integrator: "explicit".to_owned(),
        scheme: "linear".to_owned(),
        errors: vec![(off.len() as f64, largest(off.into_iter()))],
        required_error: 1e-5,
        refined_by: RUNS,
        ..Outcome::default()
    })
}

//! Limits of a few settings over whole runs of the study's column: what `stability.csv` has always shown.

use mpm_core::run::run;
use mpm_core::scene::{DarcyChoice, Dimension, Scene, StepChoice, Until};
use mpm_core::stability::{Medium, explicit_limit};
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::study::word;

/// Steps of a run that decides whether a step is stable: enough for round-off to grow to order one at 1 % above.
const STEPS: u32 = 20_000;

/// One row of `stability.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// One dimension or plane strain.
    pub dimension: String,
    /// Darcy operator.
    pub darcy: String,
    /// Whether Darcy's law keeps `rho_w a_s`.
    pub darcy_inertia: bool,
    /// Cell edge L, m.
    pub mesh_m: f64,
    /// Particles per cell.
    pub ppc: usize,
    /// Limit of the same scheme on a mesh without particles (S = 1), s; one dimension only.
    pub mesh_only_s: Option<f64>,
    /// Limit used by `auto`, s.
    pub predicted_s: f64,
    /// Largest step that stayed bounded, s.
    pub measured_s: f64,
    /// measured / predicted.
    pub ratio: f64,
}

/// Settings whose limits are measured.
fn settings() -> Result<Vec<Scene>, Error> {
    let mut scenes = Vec::new();
    for (dimension, meshes) in [(Dimension::Column, [0.1, 0.05, 0.02]), (Dimension::PlaneStrain, [0.1, 0.1, 0.05])] {
        for darcy_inertia in [true, false] {
            for darcy in [DarcyChoice::Face, DarcyChoice::Nodal] {
                // The operators agree in one dimension; plane strain repeats a mesh with more particles.
                if dimension == Dimension::Column && darcy == DarcyChoice::Nodal {
                    continue;
                }
                for (i, mesh) in meshes.into_iter().enumerate() {
                    let counts: &[usize] = match (dimension, i) {
                        (Dimension::Column, _) => &[1, 4, 9],
                        (_, 0) => &[1],
                        _ => &[4],
                    };
                    for &ppc in counts {
                        scenes.push(crate::scenes::terzaghi().edited(|scene| {
                            (scene.dimension, scene.darcy, scene.darcy_inertia) = (dimension, darcy, darcy_inertia);
                            (scene.cell, scene.width, scene.particles_per_cell) = (mesh, 4.0 * mesh, ppc);
                        })?);
                    }
                }
            }
        }
    }
    Ok(scenes)
}

/// Whether a step (s) stays bounded for [`STEPS`] steps.
fn bounded(scene: &Scene, dt: f64) -> Result<bool, Error> {
    let end = f64::from(STEPS) * dt;
    let scene = scene.edited(|scene| {
        (scene.step, scene.force, scene.history, scene.observe_times) = (StepChoice::Fixed(dt), true, 0, vec![end]);
        if let Some(last) = scene.stages.last_mut() {
            last.until = Until::Time(end);
        }
    })?;
    let whole = scene.surcharge.map_or(0.0, |s| s.pressure) * scene.height / scene.oedometer_modulus();
    Ok(run(&scene, &mut |_| {}).is_ok_and(|run| {
        let sane = |s: &mpm_core::drive::Sample| s.state.settlement.abs() < 2.0 * whole && s.state.max_speed < 10.0;
        run.failure.is_none() && run.samples.last().is_some_and(sane)
    }))
}

/// Predicts and measures the limits of all settings.
///
/// # Errors
/// A scene that the checker refuses.
pub fn limits() -> Result<Vec<Limit>, Error> {
    settings()?.iter().map(limit).collect()
}

fn limit(scene: &Scene) -> Result<Limit, Error> {
    let predicted_s = explicit_limit(scene);
    let (mut low, mut high) = (0.5, 1.5);
    for _ in 0..9 {
        let middle = 0.5 * (low + high);
        if bounded(scene, middle * predicted_s)? { low = middle } else { high = middle }
    }
    let mesh_only = Medium { shortest_transfer: 1.0, flip: 1.0, ..Medium::of(scene) }.limit_column();
    Ok(Limit {
        dimension: word(scene.dimension),
        darcy: word(scene.darcy),
        darcy_inertia: scene.darcy_inertia,
        mesh_m: scene.cell,
        ppc: scene.particles_per_cell,
        mesh_only_s: (scene.dimension == Dimension::Column).then_some(mesh_only),
        predicted_s,
        measured_s: low * predicted_s,
        ratio: low,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_measurement_tells_stable_from_unstable() {
        let scene = &settings().expect("sound scenes")[0];
        let predicted = explicit_limit(scene);
        assert_eq!([0.9, 1.2].map(|factor| bounded(scene, factor * predicted).ok()), [Some(true), Some(false)]);
    }
}

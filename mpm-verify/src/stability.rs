//! Time-step limits, predicted and measured, and what each Darcy operator does to a point source of pressure.

use mpm_core::boundary::{Supports, SurfaceLoad};
use mpm_core::constitutive::LinearElastic;
use mpm_core::dimension::PlaneStrain;
use mpm_core::grid::Grid;
use mpm_core::observe::Seed;
use mpm_core::particles::{Layer, SolidPoint, WaterPoint, even_positions};
use mpm_core::run::run;
use mpm_core::scene::{Clock, DarcyChoice, Dimension, Elastic, LoadOn, Scene, SolidSide, Stage, StepChoice, Until};
use mpm_core::shape::Centre;
use mpm_core::stability::{Medium, explicit_limit};
use mpm_core::step::{Explicit, Model, Parts};
use mpm_core::water::{DarcyOperator, Face, Nodal, Saturated};
use serde::{Deserialize, Serialize};

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
fn settings() -> Vec<Scene> {
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
                        (Dimension::PlaneStrain, 0) => &[1],
                        (Dimension::PlaneStrain, _) => &[4],
                    };
                    for &ppc in counts {
                        let mut scene = crate::scenes::terzaghi();
                        (scene.dimension, scene.darcy, scene.darcy_inertia) = (dimension, darcy, darcy_inertia);
                        (scene.cell, scene.width, scene.particles_per_cell) = (mesh, 4.0 * mesh, ppc);
                        let across = if dimension == Dimension::Column { 1 } else { 4 };
                        scene.cells = [across, (scene.height / mesh).round() as usize];
                        scenes.push(scene);
                    }
                }
            }
        }
    }
    scenes
}

/// Whether a step (s) stays bounded for [`STEPS`] steps.
fn bounded(scene: &Scene, dt: f64) -> bool {
    let mut scene = scene.clone();
    (scene.step, scene.force, scene.history) = (StepChoice::Fixed(dt), true, 0);
    let end = f64::from(STEPS) * dt;
    scene.observe_times = vec![end];
    if let Some(last) = scene.stages.last_mut() {
        last.until = Until::Time(end);
    }
    let whole = scene.surcharge.map_or(0.0, |s| s.pressure) * scene.height / scene.oedometer_modulus();
    run(&scene, &mut |_| {}).is_ok_and(|run| {
        let sane = |s: &mpm_core::drive::Sample| s.state.settlement.abs() < 2.0 * whole && s.state.max_speed < 10.0;
        run.failure.is_none() && run.samples.last().is_some_and(sane)
    })
}

/// Predicts and measures the limits of all settings.
pub fn limits() -> Vec<Limit> {
    settings().iter().map(limit).collect()
}

fn limit(scene: &Scene) -> Limit {
    let predicted_s = explicit_limit(scene);
    let (mut low, mut high) = (0.5, 1.5);
    for _ in 0..9 {
        let middle = 0.5 * (low + high);
        if bounded(scene, middle * predicted_s) { low = middle } else { high = middle }
    }
    let mesh_only = Medium { shortest_transfer: 1.0, flip: 1.0, ..Medium::of(scene) }.limit_column();
    Limit {
        dimension: word(scene.dimension),
        darcy: word(scene.darcy),
        darcy_inertia: scene.darcy_inertia,
        mesh_m: scene.cell,
        ppc: scene.particles_per_cell,
        mesh_only_s: (scene.dimension == Dimension::Column).then_some(mesh_only),
        predicted_s,
        measured_s: low * predicted_s,
        ratio: low,
    }
}

/// Share of the pore pressure that alternates from cell to cell after a point source in a stiff block has spread
/// over a few cells: zero for smooth pressure. First the face operator's, then the nodal one's.
pub fn checkerboard() -> [f64; 2] {
    [point_source::<Face<2>>(), point_source::<Nodal<2>>()]
}

/// Cells along each side of the block.
const BLOCK: usize = 17;
/// Cells over which the pressure spreads.
const SPREAD: f64 = 3.0;

fn point_source<O: DarcyOperator<2> + 'static>() -> f64 {
    let scene = crate::scenes::terzaghi();
    let Some(properties) = scene.water else { return f64::NAN };
    let grid = Grid::new([BLOCK, BLOCK], 0.02);
    let volume = grid.size * grid.size;
    let places: Vec<[f64; 2]> = even_positions([BLOCK, BLOCK], 1).map(|x| x.map(|x| x * grid.size)).collect();
    let solid =
        |x: &[f64; 2]| SolidPoint { x: *x, v: [0.0; 2], stress: [0.0; 4], mass: scene.dry_density() * volume, volume };
    let middle = 0.5 * BLOCK as f64 * grid.size;
    let water = |x: &[f64; 2]| WaterPoint {
        x: *x,
        v: [0.0; 2],
        mass: scene.porosity * properties.density * volume,
        volume,
        pressure: if x.iter().all(|x| (x - middle).abs() < 0.5 * grid.size) { 1.0e4 } else { 0.0 },
    };
    let layers =
        (Layer::new(places.iter().map(solid).collect(), &grid), Layer::new(places.iter().map(water).collect(), &grid));
    let (Ok(solid), Ok(water)) = layers else { return f64::NAN };
    // A skeleton so stiff that only the water moves.
    let stiff = Elastic { youngs_modulus: 2.0e12, poisson_ratio: 0.3 };
    let operator = O::new(&grid, &properties, grid.size, false);
    let diffusivity = properties.mobility() * scene.pore_stiffness();
    let spread = (SPREAD * grid.size).powi(2) / (2.0 * diffusivity);
    let dt = 0.1 * volume / diffusivity;
    let mut model = Explicit::<PlaneStrain, Centre, _, _, 2, 4>::new(Parts {
        supports: Supports::new(&grid, &[SolidSide::Roller; 4]),
        water: Saturated::new(water, &grid, properties, scene.grain_density, operator),
        law: LinearElastic::plane_strain(&stiff),
        surface: SurfaceLoad::new(Vec::new(), 0.0, LoadOn::Surface),
        surcharge: None,
        gravity: None,
        force: None,
        plate: None,
        flip: 0.0,
        apart: 0.0,
        seed: Seed { per_row: BLOCK, spacing: grid.size, heights: Vec::new() },
        first_settlement: 0.0,
        grid,
        solid,
    });
    let closed = Stage {
        name: "spread".to_owned(),
        drained: [false; 4],
        damping: 0.0,
        clock: Clock::Soil,
        until: Until::Time(spread),
    };
    let steps = (spread / dt).ceil() as u64;
    match model.enter_stage(&closed, &[]).and_then(|()| model.advance(dt, steps, &mut 0)) {
        Ok(()) => model.observe().checkerboard,
        Err(_) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nodal_operator_leaves_a_checkerboard_and_the_face_operator_none() {
        let [face, nodal] = checkerboard();
        assert!(face < 0.02, "face {face}");
        assert!(nodal > 5.0 * face && nodal > 0.05, "nodal {nodal}, face {face}");
    }

    #[test]
    fn the_measurement_tells_stable_from_unstable() {
        let scene = &settings()[0];
        let predicted = explicit_limit(scene);
        assert!(bounded(scene, 0.9 * predicted) && !bounded(scene, 1.2 * predicted));
    }
}

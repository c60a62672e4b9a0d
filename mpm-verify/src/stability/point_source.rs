//! What each Darcy operator does to a point source of pressure.

use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given};
use mpm_core::hardware::Hardware;
use mpm_core::run::model_given;
use mpm_core::scene::{Coupling, DarcyChoice, Dimension, ShapeChoice, SolidSide, Stage, Start, Until};

/// Share of the pore pressure that alternates from cell to cell after a point source in a stiff block has spread
/// over a few cells: zero for smooth pressure. First the face operator's, then the nodal one's.
pub fn checkerboard() -> [f64; 2] {
    [DarcyChoice::Face, DarcyChoice::Nodal].map(point_source)
}

/// Cells along each side of the block.
const BLOCK: usize = 17;
/// Cells over which the pressure spreads.
const SPREAD: f64 = 3.0;

fn point_source(darcy: DarcyChoice) -> f64 {
    let block = crate::scenes::terzaghi().edited(|scene| {
        (scene.dimension, scene.cells, scene.cell) = (Dimension::PlaneStrain, [BLOCK, BLOCK], 0.02);
        (scene.width, scene.height) = (BLOCK as f64 * scene.cell, BLOCK as f64 * scene.cell);
        (scene.shape, scene.darcy, scene.darcy_inertia) = (ShapeChoice::Centre, darcy, false);
        (scene.particles_per_cell, scene.flip) = (1, 0.0);
        (scene.start, scene.surcharge, scene.gravity) = (Start::Unloaded, None, None);
        scene.solid_sides = [SolidSide::Roller; 4];
        // A skeleton so stiff that only the water moves.
        scene.elastic.youngs_modulus = 2.0e12;
    });
    let Ok(scene) = block else { return f64::NAN };
    let Some(properties) = scene.water else { return f64::NAN };
    let (size, middle) = (scene.cell, 0.5 * scene.width);
    let source = move |x: [f64; 2]| FirstState {
        pressure: if x.iter().all(|x| (x - middle).abs() < 0.5 * size) { 1.0e4 } else { 0.0 },
        ..FirstState::default()
    };
    let diffusivity = properties.mobility() * scene.pore_stiffness();
    let spread = (SPREAD * size).powi(2) / (2.0 * diffusivity);
    let dt = 0.1 * size * size / diffusivity;
    let given = Given { start: Some(Arc::new(source)), ..Given::default() };
    let Ok(mut model) = model_given(&Hardware::default(), &scene, &given) else { return f64::NAN };
    let closed = Stage {
        name: "spread".to_owned(),
        drained: [false; 4],
        solid_sides: None,
        damping: 0.0,
        coupling: Coupling::Soil,
        until: Until::Time(spread),
    };
    let steps = (spread / dt).ceil() as u64;
    match model.enter_stage(&closed, &[]).and_then(|()| model.advance(dt, steps, &mut 0)) {
        Ok(()) => model.observe().0.checkerboard,
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
}

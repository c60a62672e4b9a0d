//! What each Darcy operator does to a point source of pressure.

use mpm_core::boundary::{Supports, SurfaceLoad};
use mpm_core::constitutive::LinearElastic;
use mpm_core::dimension::PlaneStrain;
use mpm_core::grid::Grid;
use mpm_core::observe::Seed;
use mpm_core::particles::{Layer, SolidPoint, WaterPoint, even_positions};
use mpm_core::scene::{Clock, Elastic, LoadOn, SolidSide, Stage, Until};
use mpm_core::shape::Centre;
use mpm_core::step::{Explicit, Model, Parts};
use mpm_core::water::{DarcyOperator, Face, Nodal, Saturated};

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
        filled: Default::default(),
        surcharge: None,
        gravity: None,
        force: None,
        plate: None,
        transfer: None,
        flip: 0.0,
        apart: 0.0,
        most_crossings: u64::MAX,
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
}

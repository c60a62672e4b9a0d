//! Runs from states that scenes have no words for, and soil whose particles stand in another order.

use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given, Strip, SurfaceLoad};
use mpm_core::constitutive::{LinearElastic, Material, Materials};
use mpm_core::grid::Grid;
use mpm_core::hardware::Hardware;
use mpm_core::observe::Seed;
use mpm_core::particles::{Layer, SolidPoint, WaterPoint, even_positions};
use mpm_core::run::model_given;
use mpm_core::scene::{LoadOn, Scene};
use mpm_core::step::{Body, Model};
use mpm_core::water::pores::Pores;

/// The model of a scene that starts from vertical effective stresses and pore pressures (Pa) by the height (m).
pub fn started(scene: &Scene, first: fn(&Scene, f64) -> (f64, f64)) -> Box<dyn Model> {
    let lateral = scene.elastic.lame() / scene.oedometer_modulus();
    let of = scene.clone();
    let start = move |x: [f64; 2]| {
        let (vertical, pressure) = first(&of, x[1]);
        let stress = [lateral * vertical, vertical, lateral * vertical, 0.0];
        FirstState { stress, pressure, ..FirstState::default() }
    };
    let given = Given { start: Some(Arc::new(start)), ..Given::default() };
    model_given(&Hardware::default(), scene, &given).expect("inside the mesh")
}

/// Unloaded, saturated soil whose particles stand in an order; empty for that of seeding.
pub fn in_order<const D: usize>(scene: &Scene, order: &[usize]) -> Body<D> {
    let cells: [usize; D] = std::array::from_fn(|d| scene.cells[d + 2 - D]);
    let per_direction = scene.particles_per_direction();
    let properties = scene.water.expect("a saturated scene");
    let area = if D == 1 { scene.width } else { scene.cell };
    let volume = area * scene.cell / (per_direction as f64).powi(D as i32);
    let grid = Grid::new(cells, scene.cell);
    let seeded: Vec<[f64; D]> = even_positions(cells, per_direction).map(|x| x.map(|x| x * scene.cell)).collect();
    let order: Vec<usize> = if order.is_empty() { (0..seeded.len()).collect() } else { order.to_vec() };
    assert_eq!(order.len(), seeded.len());
    let (mass, of_water) = (scene.dry_density() * volume, scene.porosity * properties.density * volume);
    let solid = order.iter().map(|&i| SolidPoint { x: seeded[i], v: [0.0; D], stress: [0.0; 4], mass, volume });
    let water = order.iter().map(|&i| WaterPoint { x: seeded[i], v: [0.0; D], mass: of_water, volume, pressure: 0.0 });
    let water = Layer::new(water.collect(), &grid).expect("inside");
    let spacing = scene.cell / per_direction as f64;
    let top = seeded.len() - seeded.len() / (cells[D - 1] * per_direction);
    // In the order of their numbers, which are places in the vector.
    let strips = (0..order.len()).filter(|&id| order[id] >= top).map(|id| Strip {
        id: id as u32,
        offset: 0.5 * spacing,
        volume,
        area: volume / spacing,
        loaded: volume / spacing,
    });
    let on = scene.surcharge.map_or(LoadOn::Surface, |load| load.on);
    let solid = Layer::new(solid.collect(), &grid).expect("inside");
    Body {
        water: Some(Pores::new(scene, (water, &solid), &grid, &properties, (area, false, false))),
        solid,
        grid,
        materials: Materials::one(Material::Elastic(LinearElastic::new(&scene.elastic)), 1.0 / scene.grain_density),
        surface: SurfaceLoad::new(strips.collect(), scene.height, on),
        filled: Default::default(),
        surcharge: scene.surcharge,
        loads: Default::default(),
        gravity: scene.gravity_vector().map(|g| std::array::from_fn(|d| g[d + 2 - D])),
        flip: scene.flip,
        apart: 0.0,
        null_space: None,
        contiguous: false,
        most_crossings: u64::MAX,
        period: None,
        seed: Seed { per_row: seeded.len() - top, spacing, heights: Vec::new() },
        first_settlement: 0.0,
    }
}

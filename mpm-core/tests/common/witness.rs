//! Models built by hand, and a look at their particles after every step.

use std::sync::{Arc, Mutex};

use mpm_core::boundary::{Strip, Supports, SurfaceLoad};
use mpm_core::dimension::Kinematics;
use mpm_core::grid::Grid;
use mpm_core::keep::Keeper;
use mpm_core::nodes::NodeMotion;
use mpm_core::observe::Seed;
use mpm_core::particles::{Layer, SolidPoint, WaterPoint, even_positions};
use mpm_core::scene::{LoadOn, Scene};
use mpm_core::shape::Shape;
use mpm_core::step::Parts;
use mpm_core::water::{DarcyOperator, FlowRates, Place, Saturated, SoilCell, StressSums, Water};

/// The particles after the last step, in the order of their cells.
#[derive(Debug)]
pub struct Seen<const D: usize, const S: usize> {
    /// Solid layer.
    pub solid: Vec<SolidPoint<D, S>>,
    /// Water layer; empty when dry.
    pub water: Vec<WaterPoint<D>>,
    /// Crossings of solid particles.
    pub crossings: u64,
}

/// Particles shared between a model and its test.
pub type Shared<const D: usize, const S: usize> = Arc<Mutex<Seen<D, S>>>;

/// Water that notes all particles at the end of every step, and otherwise does what the water in it does.
#[derive(Debug)]
pub struct Witness<W, const D: usize, const S: usize> {
    inner: W,
    seen: Shared<D, S>,
}

impl<W, const D: usize, const S: usize> Witness<W, D, S> {
    /// A witness, and what it sees.
    pub fn new(inner: W) -> (Self, Shared<D, S>) {
        let seen = Arc::new(Mutex::new(Seen { solid: Vec::new(), water: Vec::new(), crossings: 0 }));
        (Self { inner, seen: Arc::clone(&seen) }, seen)
    }
}

impl<K, W, const D: usize, const S: usize> Water<K, D, S> for Witness<W, D, S>
where
    K: Kinematics<D, S>,
    W: Water<K, D, S>,
{
    const WET: bool = W::WET;

    fn clear(&mut self) {
        self.inner.clear();
    }

    fn cell_to_grid<Sh: Shape>(
        &mut self,
        grid: &Grid<D>,
        soil: &SoilCell<D>,
        solid: &[f64; 4],
        stress: &mut StressSums<D, S>,
    ) -> [f64; 4] {
        self.inner.cell_to_grid::<Sh>(grid, soil, solid, stress)
    }

    fn flow(&mut self, grid: &Grid<D>, motion: &[NodeMotion<D>], gravity: &[f64; D]) -> FlowRates {
        self.inner.flow(grid, motion, gravity)
    }

    fn cell_to_points<Sh: Shape>(&mut self, grid: &Grid<D>, place: &Place<D>, velocity: &[[f64; D]; 4], dt: f64) {
        self.inner.cell_to_points::<Sh>(grid, place, velocity, dt);
    }

    fn settle(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D, S>, D>) -> Result<(), (String, String)> {
        self.inner.settle(grid, solid)?;
        let mut seen = self.seen.lock().expect("one thread");
        seen.solid.clone_from(&solid.points);
        seen.crossings = solid.crossings;
        if let Some(water) = self.inner.layer() {
            seen.water.clone_from(&water.points);
        }
        Ok(())
    }

    fn set_drained(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D, S>, D>, drained: [bool; 4]) {
        self.inner.set_drained(grid, solid, drained);
    }

    fn layer(&self) -> Option<&Layer<WaterPoint<D>, D>> {
        self.inner.layer()
    }

    fn cell_state(&self, soil: &SoilCell<D>) -> (f64, f64) {
        self.inner.cell_state(soil)
    }

    fn cell_mass(&self, soil: &SoilCell<D>) -> f64 {
        self.inner.cell_mass(soil)
    }

    fn density(&self) -> f64 {
        self.inner.density()
    }

    fn keep(&mut self, keeper: &mut Keeper, grid: &Grid<D>) {
        self.inner.keep(keeper, grid);
    }

    fn bytes(&self) -> usize {
        self.inner.bytes()
    }
}

/// What a model built by hand may do differently from its scene.
#[derive(Debug, Clone)]
pub struct Differently {
    /// Gravity during the run, m/s2; the first state has that of the scene.
    pub gravity: Option<f64>,
    /// Places of the seeded particles in the vectors of both layers; empty for the order of seeding.
    pub order: Vec<usize>,
}

/// The parts of a saturated scene, with a witness. `first` is the vertical effective stress and the pore pressure
/// (Pa) at a height (m).
pub fn saturated<O: DarcyOperator<D>, L, const D: usize, const S: usize>(
    scene: &Scene,
    law: L,
    first: fn(&Scene, f64) -> (f64, f64),
    differently: &Differently,
) -> (Parts<L, Witness<Saturated<O, D>, D, S>, D, S>, Shared<D, S>) {
    let cells: [usize; D] = std::array::from_fn(|d| scene.cells[d + 2 - D]);
    let per_direction = scene.particles_per_direction();
    let properties = scene.water.expect("a saturated scene");
    let area = if D == 1 { scene.width } else { scene.cell };
    let volume = area * scene.cell / (per_direction as f64).powi(D as i32);
    let grid = Grid::new(cells, scene.cell);
    let seeded: Vec<[f64; D]> = even_positions(cells, per_direction).map(|x| x.map(|x| x * scene.cell)).collect();
    let order = if differently.order.is_empty() { (0..seeded.len()).collect() } else { differently.order.clone() };
    assert_eq!(order.len(), seeded.len());
    let lateral = scene.elastic.lame() / scene.oedometer_modulus();
    let solid = order
        .iter()
        .map(|&i| {
            let (vertical, _) = first(scene, seeded[i][D - 1]);
            // Column: vertical, lateral. Plane strain: xx, yy, zz, xy.
            let stress = |s| if s == D - 1 { vertical } else { lateral * vertical };
            SolidPoint {
                x: seeded[i],
                v: [0.0; D],
                stress: std::array::from_fn(|s| if s == 3 { 0.0 } else { stress(s) }),
                mass: scene.dry_density() * volume,
                volume,
            }
        })
        .collect();
    let water = order
        .iter()
        .map(|&i| WaterPoint {
            x: seeded[i],
            v: [0.0; D],
            mass: scene.porosity * properties.density * volume,
            volume,
            pressure: first(scene, seeded[i][D - 1]).1,
        })
        .collect();
    let water = Layer::new(water, &grid).expect("inside");
    let operator = O::new(&grid, &properties, area, scene.darcy_inertia);
    let (water, seen) = Witness::new(Saturated::new(water, &grid, properties, scene.grain_density, operator));
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
    let surface =
        SurfaceLoad::new(strips.collect(), scene.height, scene.surcharge.map_or(LoadOn::Surface, |load| load.on));
    let parts = Parts {
        filled: Default::default(),
        supports: Supports::new(&grid, &scene.solid_sides),
        solid: Layer::new(solid, &grid).expect("inside"),
        grid,
        water,
        law,
        surface,
        surcharge: scene.surcharge,
        gravity: differently.gravity.map(|g| std::array::from_fn(|d| if d == D - 1 { -g } else { 0.0 })),
        force: None,
        plate: None,
        transfer: None,
        flip: scene.flip,
        apart: 0.0,
        most_crossings: u64::MAX,
        seed: Seed { per_row: seeded.len() - top, spacing, heights: Vec::new() },
        first_settlement: 0.0,
    };
    (parts, seen)
}

//! The one switchboard: the words of a scene become concrete types. Nothing else matches on them.

use crate::boundary::{FaceLoads, Filled, Given, Strip, SurfaceLoad};
use crate::checkpoint::RestoreError;
use crate::constitutive::{LinearElastic, Material, Materials, ModifiedCamClay, MohrCoulomb};
use crate::dimension::in_two;
use crate::drive::{Alone, Drive, Monitor, Run};
use crate::error::RunError;
use crate::grid::Grid;
use crate::hardware::{Hardware, Width};
use crate::observe::Seed;
use crate::order::sort_by_number;
use crate::particles::{Layer, SolidPoint, WaterPoint, displace, even_positions};
use crate::real::array_of;
use crate::scene::{
    Bearing, DarcyChoice, Dimension, DomainChoice, Ground, Integrator, LoadOn, Scene, SeedingChoice, ShapeChoice, Soil,
    Start, TransferChoice, UnfitLoad, UpdateChoice, WaterProperties,
};
use crate::seeding::{self, Part};
use crate::soils::Soils;
use crate::stability::{StepTooLarge, choose_step};
use crate::step::kernel::{self, Bspline, Kernel, Over, Vectorised};
use crate::step::quasi_static::{QuasiStatic, Seeding};
use crate::step::store::Frame;
use crate::step::{
    Body, Condition, Damping, Explicit, Failing, Friction, GivenForce, Joined, Lifted, Model, Moved, RigidPlate,
    Staggered, Supports,
};
use crate::water::AdvectedWater;
use crate::water::pores::Pores;
use pulp::{Arch, Scalar, Simd};

/// Why a scene could not be run.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The time step is above the stability limit.
    #[error(transparent)]
    Step(#[from] StepTooLarge),
    /// No run gives a useful answer to the load.
    #[error(transparent)]
    Load(#[from] UnfitLoad),
    /// The particles could not be placed.
    #[error(transparent)]
    Place(#[from] RunError),
    /// The checkpoint to resume from is none of this scene.
    #[error(transparent)]
    Checkpoint(#[from] RestoreError),
    /// Its soil may fail, which stages alone do not follow.
    #[error(
        "stages.coupling: expected \"seepage\" or \"soil\" in a scene that is solved stage by stage, found \"full\""
    )]
    MayFail,
}

/// Runs a scene to its end, or to where it fails: [`Run::failure`] then says why.
///
/// # Errors
/// A step above the stability limit, a load that the scheme does not bear, particles outside the mesh, or soil that may fail,
/// which has a driver of its own ([`crate::failure::Driver`]): nothing was run.
pub fn run(scene: &Scene, progress: &mut dyn FnMut(f64)) -> Result<Run, StartError> {
    run_on(&Hardware::default(), scene, progress)
}

/// [`run`] on given hardware.
///
/// # Errors
/// As [`run`].
pub fn run_on(hardware: &Hardware, scene: &Scene, progress: &mut dyn FnMut(f64)) -> Result<Run, StartError> {
    run_monitored(hardware, scene, None, &mut Alone(progress))
}

/// [`run_on`] with a monitor, from a checkpoint if there is one.
///
/// # Errors
/// As [`run`]; a checkpoint that is not one of this scene.
pub fn run_monitored(
    hardware: &Hardware,
    scene: &Scene,
    checkpoint: Option<&[u8]>,
    monitor: &mut dyn Monitor,
) -> Result<Run, StartError> {
    if scene.may_fail() {
        return Err(StartError::MayFail);
    }
    scene.bears_its_load()?;
    let dt = choose_step(scene)?;
    let mut model = model_on(hardware, scene)?;
    let mut drive = Drive::new(scene, model.as_mut(), dt);
    if let Some(checkpoint) = checkpoint {
        drive.restore(checkpoint)?;
    }
    Ok(drive.go(monitor))
}

/// [`run`] with fields that scenes have no words for. The step is that of the scene.
///
/// # Errors
/// As [`run`], and as [`model_given`].
pub fn run_given(scene: &Scene, given: &Given, progress: &mut dyn FnMut(f64)) -> Result<Run, StartError> {
    scene.bears_its_load()?;
    let dt = choose_step(scene)?;
    let mut model = model_given(&Hardware::default(), scene, given)?;
    let run = Drive::new(scene, model.as_mut(), dt);
    let run = if given.is_nothing() { run } else { run.unwatched() };
    Ok(run.go(&mut Alone(progress)))
}

/// The model of a scene at t = 0, its first stage not yet entered.
///
/// # Errors
/// Particles outside the mesh.
pub fn model(scene: &Scene) -> Result<Box<dyn Model>, RunError> {
    model_on(&Hardware::default(), scene)
}

/// [`model`] on given hardware.
///
/// # Errors
/// As [`model`].
pub fn model_on(hardware: &Hardware, scene: &Scene) -> Result<Box<dyn Model>, RunError> {
    model_given(hardware, scene, &Given::default())
}

/// [`model_on`] with fields that scenes have no words for.
///
/// # Errors
/// Particles outside the mesh; fields for an integrator that takes none.
pub fn model_given(hardware: &Hardware, scene: &Scene, given: &Given) -> Result<Box<dyn Model>, RunError> {
    let explicit = matches!(scene.integrator, Integrator::Explicit | Integrator::SemiImplicit);
    if !given.is_nothing() && (!explicit || scene.free_surface.is_some()) {
        return Err(refused("given fields are for the explicit and the semi-implicit integrator"));
    }
    if scene.outline.is_some() && given.moved != [0.0; 2] {
        return Err(refused("soil with an outline cannot be moved"));
    }
    if scene.integrator.solves_displacements() {
        return implicit(scene);
    }
    match scene.dimension {
        Dimension::Column => Seeded::new(scene, given, [scene.cells[1]], scene.width)?.model(hardware, scene),
        _ => Seeded::new(scene, given, scene.cells, scene.cell)?.model(hardware, scene),
    }
}

/// The model of a scene whose soil may fail, at t = 0.
///
/// # Errors
/// Particles outside the mesh.
pub fn failing(scene: &Scene) -> Result<Box<dyn Failing>, RunError> {
    let seed = Seeded::new(scene, &Given::default(), scene.cells, scene.cell)?;
    let model = seed.model(&Hardware::default(), scene)?;
    model.failing().ok_or_else(|| refused("only soil under water with a free surface may fail"))
}

/// The materials of a scene, whose particles stand at these places at t = 0, m.
fn materials(scene: &Scene, places: impl Iterator<Item = [f64; 2]>) -> Materials {
    let law = |soil: &Soil| match (&soil.strength, &soil.cam_clay) {
        (Some(strength), _) => Material::MohrCoulomb(MohrCoulomb::new(&soil.elastic, strength)),
        (None, Some(clay)) => Material::CamClay(ModifiedCamClay::new(clay)),
        (None, None) => Material::Elastic(LinearElastic::new(&soil.elastic)),
    };
    Materials::of_soils(scene.soils().iter().map(law).collect(), Soils::of(scene, places))
}

/// The model of a scene that solves for displacements.
fn implicit(scene: &Scene) -> Result<Box<dyn Model>, RunError> {
    Ok(match scene.dimension {
        Dimension::Column => implicit_in(scene, [scene.cells[1]], scene.width),
        _ => implicit_in(scene, scene.cells, 1.0),
    })
}

/// That model: one layer of particles and a mesh that is built over them.
fn implicit_in<const D: usize>(scene: &Scene, soil_cells: [usize; D], thickness: f64) -> Box<dyn Model> {
    let spacing = scene.cell / scene.particles_per_direction() as f64;
    let volume = thickness * spacing.powi(D as i32);
    let lengths: [f64; D] = array_of(|d| if d == D - 1 { scene.height } else { scene.width });
    let mut places: Vec<([f64; D], bool)> =
        positions(scene, &Given::default(), soil_cells).map(|x| (x, x[D - 1] > scene.height - spacing)).collect();
    if let Some(displaced) = scene.displaced {
        displace(places.iter_mut().map(|(x, _)| x), &lengths, spacing, &displaced);
    }
    // Points of a cell follow each other, so that the matrix is gathered cell by cell.
    let cell = |x: &[f64; D]| x.map(|x| (x / scene.cell + scene.shift).floor());
    let columns = soil_cells[0] as f64 + 3.0;
    sort_by_number(&mut places, |(x, _)| cell(x)[D - 1] * columns + cell(x)[0]);
    let ground = scene.ground();
    let point = |(x, _): &([f64; D], bool)| {
        let volume = volume * scene.thickness(x[0]);
        let (stress, _) = first_state(scene, &ground, &in_two(x));
        SolidPoint { x: *x, v: [0.0; D], stress, mass: ground.at(&in_two(x)).dry_density() * volume, volume }
    };
    let law = materials(scene, places.iter().map(|(x, _)| in_two(x)));
    Box::new(QuasiStatic::<Material, D>::new(
        scene,
        Seeding {
            points: places.iter().map(point).collect(),
            law,
            top: places.iter().enumerate().filter(|(_, (_, top))| *top).map(|(i, _)| i).collect(),
            thickness,
            first_pressure: |scene, place| first_state(scene, &scene.ground(), &place).1,
            first_settlement: scene.first_settlement(),
        },
    ))
}

/// The kernel of a scene, vectorised as the CPU allows; unit tests have the plain width alone, the others a test program.
fn kernel<const D: usize>(width: Width, scene: &Scene) -> Result<Box<dyn Kernel<D>>, RunError> {
    match (width, Arch::new()) {
        #[cfg(all(not(test), any(target_arch = "x86", target_arch = "x86_64")))]
        (Width::Widest | Width::Eight, Arch::V4(simd)) => kernel_over(simd, scene),
        #[cfg(all(not(test), any(target_arch = "x86", target_arch = "x86_64")))]
        (Width::Widest | Width::Four, Arch::V3(simd)) => kernel_over(simd, scene),
        #[cfg(all(not(test), any(target_arch = "x86", target_arch = "x86_64")))]
        (Width::Four, Arch::V4(simd)) => kernel_over(*simd, scene),
        #[cfg(all(not(test), target_arch = "aarch64"))]
        (Width::Widest, Arch::Neon(simd)) => kernel_over(simd, scene),
        _ => kernel_over(Scalar, scene),
    }
}

/// The same of a SIMD width.
fn kernel_over<V: Simd, const D: usize>(simd: V, scene: &Scene) -> Result<Box<dyn Kernel<D>>, RunError> {
    Ok(match scene.shape {
        ShapeChoice::Centre => Box::new(Vectorised { simd, functions: kernel::CENTRE }),
        // A full column has its centroid at the centre; scenes with others are refused.
        ShapeChoice::Centroid if scene.integrator == Integrator::SemiImplicit => {
            Box::new(Vectorised { simd, functions: kernel::CENTRE })
        }
        ShapeChoice::Centroid => Box::new(Vectorised { simd, functions: kernel::CENTROID }),
        ShapeChoice::Linear => Box::new(Vectorised { simd, functions: kernel::LINEAR }),
        ShapeChoice::BBar => Box::new(Vectorised { simd, functions: kernel::B_BAR }),
        ShapeChoice::Gimp => {
            Box::new(Vectorised { simd, functions: Over(kernel::Gimp::new(scene.particles_per_direction())) })
        }
        ShapeChoice::Bspline2 => Box::new(Vectorised { simd, functions: Over(Bspline::<2>) }),
        ShapeChoice::Bspline3 => return Err(refused("cubic B-splines are for quasi-static runs")),
    })
}

/// Mesh and solid particles of a scene.
struct Seeded<const D: usize> {
    grid: Grid<D>,
    solid: Layer<SolidPoint<D>, D>,
    face_area: f64,
    particle_volume: f64,
    seed: Seed,
    given: Given,
    materials: Materials,
}

impl<const D: usize> Seeded<D> {
    fn new(scene: &Scene, given: &Given, soil_cells: [usize; D], face_area: f64) -> Result<Self, RunError> {
        let mut cells = soil_cells;
        cells[D - 1] += scene.empty_cells_above;
        if D == 2 {
            cells[0] += scene.empty_cells_beside;
        }
        let grid = Grid { axis: scene.axis(), cut: scene.outline.is_some(), ..Grid::new(cells, scene.cell) };
        let per_direction = scene.particles_per_direction();
        let particle_volume = face_area * scene.cell / (per_direction as f64).powi(D as i32);
        let ground = scene.ground();
        let point = |x: [f64; D], area: f64| {
            let volume = area * grid.thickness(x[0]);
            let (mut stress, _) = first_state(scene, &ground, &in_two(&x));
            let mut v = first_velocity(scene);
            if let Some(start) = &given.start {
                let state = start(in_two(&x));
                stress = state.stress;
                v = array_of(|d| state.velocity[d + 2 - D]);
            }
            SolidPoint { x, v, stress, mass: ground.at(&in_two(&x)).dry_density() * volume, volume }
        };
        let (points, seed): (Vec<SolidPoint<D>>, _) = match outline_parts(scene) {
            Some(parts) => {
                let x = |part: &Part| array_of(|d| part.centroid[d]);
                let points = parts.iter().map(|part| point(x(part), part.area)).collect();
                let heights = parts.iter().map(|part| part.centroid[1]).collect();
                (points, Seed { per_row: 0, spacing: scene.spacing(), heights })
            }
            None => {
                let points = positions(scene, given, soil_cells).map(|x| point(x, particle_volume)).collect();
                let per_row = soil_cells[..D - 1].iter().product::<usize>() * per_direction.pow(D as u32 - 1);
                (points, Seed { per_row, spacing: scene.spacing(), heights: Vec::new() })
            }
        };
        let materials = materials(scene, points.iter().map(|point| in_two(&point.x)));
        let solid = Layer::new(points, &grid).map_err(|e| outside("solid", e.index, &e.x))?;
        Ok(Self { grid, solid, face_area, particle_volume, seed, given: given.clone(), materials })
    }

    /// Whether soil may fill cells in part.
    fn moves(&self, scene: &Scene) -> bool {
        scene.moves_through_cells() || self.given.moved != [0.0; 2]
    }

    /// How much of each cell is soil, where that is known.
    fn filled(&self, scene: &Scene) -> Filled<D> {
        if self.given.moved == [0.0; 2] {
            Filled::of(scene, &self.grid, self.face_area * scene.cell)
        } else {
            Filled::default() // the soil does not stand on the base of the mesh
        }
    }

    /// The particles of its water: one beside each of the soil.
    fn drops(&self, scene: &Scene, properties: &WaterProperties) -> Result<Layer<WaterPoint<D>, D>, RunError> {
        let ground = scene.ground();
        let mut places = vec![([0.0; D], 0.0); self.solid.points.len()];
        for (point, id) in self.solid.points.iter().zip(&self.solid.ids) {
            places[*id as usize] = (point.x, point.volume);
        }
        let drop = |(x, volume): ([f64; D], f64)| {
            let (mut v, mut pressure) = (first_velocity(scene), first_state(scene, &ground, &in_two(&x)).1);
            if let Some(start) = &self.given.start {
                let state = start(in_two(&x));
                (v, pressure) = (array_of(|d| state.velocity[d + 2 - D]), state.pressure);
            }
            let mass = ground.at(&in_two(&x)).porosity * properties.density * volume;
            WaterPoint { x, v, mass, volume, pressure }
        };
        let points = places.into_iter().map(drop).collect();
        Layer::new(points, &self.grid).map_err(|e| outside("water", e.index, &e.x))
    }

    /// The model of them.
    fn model(self, hardware: &Hardware, scene: &Scene) -> Result<Box<dyn Model>, RunError> {
        let kernel = kernel(hardware.width, scene)?;
        let scheme = kernel.scheme();
        let frame = Frame::new(&self.grid, scheme.reach, scheme.before, scene.has_periodic_pores());
        let along = self.grid.cells.map(|cells| cells + scheme.extra);
        let mut conditions: Vec<Box<dyn Condition<D>>> = Vec::new();
        if let Some(field) = self.given.force.clone() {
            conditions.push(Box::new(GivenForce::new(field)));
        }
        if scene.surcharge.is_some_and(|load| load.on == LoadOn::Plate) {
            let count: usize = along.iter().product();
            let top = (count - count / along[D - 1]..count).map(|node| {
                let place = array_of(|d| if D == 1 { node } else { [node % along[0], node / along[0]][d] });
                frame.function(&place) as u32
            });
            conditions.push(Box::new(RigidPlate(top.collect())));
        }
        let held = |sides| Supports::new(&along, &sides, |place| frame.function(place));
        // Light nodes follow others that are fixed in all their directions.
        let ever = held(scene.supports().fold(scene.solid_sides, |a, b| array_of(|i| a[i].max(b[i]))));
        let lightest = scene.soils().iter().map(Soil::dry_density).fold(f64::INFINITY, f64::min);
        let full_mass = lightest * self.face_area * scene.cell;
        if scene.periodic || scene.light_nodes > 0.0 {
            let joined = Joined::new(&frame, &along, &ever, scene.periodic, scene.light_nodes * full_mass);
            conditions.push(Box::new(joined));
        }
        let solves = scene.integrator == Integrator::SemiImplicit && scene.water.is_some();
        // An outline that cuts cells has nodes as light as a surface that has moved into one.
        if scene.lends_inertia() || (solves && (self.moves(scene) || scene.outline.is_some())) {
            let level = !solves || self.filled(scene).is_known() || scene.outline.is_some();
            let gravity = scene.body_force().map_or([0.0; D], |g| array_of(|d| g[d + 2 - D]));
            conditions.push(Box::new(Lifted::new(frame.count(), level, gravity, scene.flip)));
        }
        if let Some(base) = scene.base {
            let particles = self.solid.points.len();
            conditions.push(Box::new(Friction::new(base, self.grid.cells[0], particles, &ever, scene.water.is_some())));
        }
        conditions.push(Box::new(held(scene.solid_sides)));
        for plate in &scene.plates {
            conditions.push(Box::new(Moved::new(plate, &along, scene, |place| frame.function(place))));
        }
        conditions.push(Box::new(Damping::default()));
        let free = match scene.water.filter(|_| scene.free_surface.is_some()) {
            Some(water) => {
                let carried =
                    AdvectedWater::new(scene, water, &self.grid, (&self.solid, &self.materials.soils), self.face_area);
                Some(carried.map_err(|e| refused(&format!("the water: {e}")))?)
            }
            None => None,
        };
        let body = self.body(scene)?;
        let transfer = (scene.transfer == TransferChoice::Affine, scene.update == UpdateChoice::Musl);
        let run = Explicit::new((kernel, hardware.pool.clone()), body, conditions, transfer);
        let nodal = scene.water.is_some() && scene.darcy == DarcyChoice::Nodal;
        Ok(match free {
            Some(water) => Box::new(Staggered::new(run, water)),
            None if solves => Box::new(run.with_solved_pressures()),
            None if nodal => Box::new(run.with_nodal_flow()),
            None => Box::new(run),
        })
    }

    /// Soil and water at t = 0.
    fn body(self, scene: &Scene) -> Result<Body<D>, RunError> {
        let filled = self.filled(scene);
        let spacing = self.seed.spacing;
        let per_row = self.seed.per_row;
        let first = (scene.cells[1] * scene.particles_per_direction() - 1) * per_row;
        let area = self.particle_volume / spacing;
        // A part of the top may carry the load: a strip has the share at the middle of its particle.
        let share = |i: usize| {
            let x = (i as f64 + 0.5) * spacing;
            scene.surcharge.and_then(|s| s.strip).map_or(1.0, |strip| strip.share(x))
        };
        let strip = |i: usize| {
            let thickness = self.grid.thickness((i as f64 + 0.5) * spacing);
            Strip {
                id: (first + i) as u32,
                offset: 0.5 * spacing,
                volume: self.particle_volume * thickness,
                area: area * thickness,
                loaded: area * thickness * share(i),
            }
        };
        let on = scene.surcharge.map_or(LoadOn::Surface, |s| s.on);
        let strips = match (&scene.outline, outline_parts(scene)) {
            // The crest of an outline is followed, and carries no load.
            (Some(outline), Some(parts)) => {
                let below = |(i, area): (usize, f64)| {
                    let Part { centroid, area: volume } = parts[i];
                    let thickness = self.grid.thickness(centroid[0]);
                    let (volume, area) = (volume * thickness, area * thickness);
                    Strip { id: i as u32, offset: scene.height - centroid[1], volume, area, loaded: 0.0 }
                };
                seeding::below_crest(outline, &parts, spacing).into_iter().map(below).collect()
            }
            _ => (0..per_row).map(strip).collect(),
        };
        let surface = SurfaceLoad::new(strips, scene.height, on);
        let loads = FaceLoads::of(scene, &self.solid, scene.width);
        // A column has the last component, which is the vertical one.
        let gravity = scene.body_force().map(|g| array_of(|d| g[d + 2 - D]));
        let particles = self.solid.points.len() as u64;
        let water = match scene.water.filter(|_| scene.free_surface.is_none()) {
            Some(properties) => {
                let layer = self.drops(scene, &properties)?;
                let (area, moves, leaves) = (self.face_area, self.moves(scene), scene.empty_cells_beside > 0);
                Some(Pores::new(scene, (layer, &self.solid), &self.grid, &properties, (area, moves, leaves)))
            }
            None => None,
        };
        Ok(Body {
            grid: self.grid,
            solid: self.solid,
            water,
            materials: self.materials,
            surface,
            filled,
            surcharge: scene.surcharge.filter(|_| scene.outline.is_none()),
            loads,
            gravity,
            flip: scene.flip,
            apart: scene.separation.map_or(0.0, |strain| scene.dry_density() / (1.0 + strain)),
            null_space: scene.null_space_strain,
            contiguous: scene.particle_domain == DomainChoice::Contiguous,
            most_crossings: scene.most_crossings().saturating_mul(particles),
            period: scene.periodic.then(|| scene.cells[0] as f64 * scene.cell),
            seed: self.seed,
            first_settlement: scene.first_settlement(),
        })
    }
}

/// Positions of the particles of either layer, m.
fn positions<const D: usize>(scene: &Scene, given: &Given, soil_cells: [usize; D]) -> impl Iterator<Item = [f64; D]> {
    let (cell, moved) = (scene.cell, given.moved);
    even_positions(soil_cells, scene.particles_per_direction())
        .map(move |x| array_of(|d| x[d] * cell + moved[d + 2 - D]))
}

/// Effective stress xx, yy, zz, xy (tension positive) and pore pressure at a place at t = 0, Pa.
fn first_state(scene: &Scene, ground: &Ground, place: &[f64; 2]) -> ([f64; 4], f64) {
    let (vertical, mut pressure) = match (scene.start, &scene.outline) {
        (Start::Unloaded | Start::Given, _) => (0.0, 0.0),
        (Start::UndrainedEquilibrium, _) => {
            let pressure = scene.undrained_pressure_at(place[1]);
            (ground.at(place).alpha() * pressure - scene.total_stress_at(place[1]), pressure)
        }
        (Start::Geostatic, outline) => {
            let at = |y: f64| {
                let depth =
                    outline.as_ref().map_or(scene.height - y, |outline| seeding::depth(outline, &[place[0], y]));
                state_at_depth(scene, ground, &[place[0], y], depth.max(0.0))
            };
            // The mean over a particle, in which stresses bend where the water table passes it.
            let (table, half) = (scene.water_above(place), 0.5 * scene.spacing());
            if table.abs() < half {
                let share = 0.5 * (table + half) / half;
                let [low, high] = [table - half, table + half].map(|up| at(place[1] + 0.5 * up));
                (share * low.0 + (1.0 - share) * high.0, share * low.1 + (1.0 - share) * high.1)
            } else {
                at(place[1])
            }
        }
    };
    let lateral = ground.at(place).lateral_stress(vertical);
    let mut stress = [lateral, vertical, lateral, first_shear(scene, vertical - pressure)];
    if let Some(initial) = &scene.initial {
        let [of_water, of_soil @ ..] = initial.at(place);
        pressure += of_water;
        (0..4).for_each(|i| stress[i] += of_soil[i]);
    }
    (stress, pressure)
}

/// Those of a geostatic start, the stress normal to a base that may be tilted, at a place and its depth (m) below the surface.
fn state_at_depth(scene: &Scene, ground: &Ground, place: &[f64; 2], depth: f64) -> (f64, f64) {
    let g = scene.gravity_vector().map_or(0.0, |[_, y]| -y);
    let density = scene.water.map_or(0.0, |w| w.density);
    let wet = scene.water_above(place).clamp(0.0, depth);
    let moist = scene.free_surface.as_ref().map_or(0.0, |free| free.saturation);
    // What stands on the surface presses on soil and water alike.
    let surface = [place[0], place[1] + depth];
    let standing =
        scene.loads.iter().filter(|load| load.bearing == Bearing::Reservoir && load.course.at(0.0, 0.0) > surface[1]);
    let standing = standing.filter_map(|load| load.of_water(&surface, 0.0, density * g)).fold(0.0, f64::max);
    let mut weight = 0.0;
    let alpha = ground.at(place).alpha();
    for ([low, high], soil) in ground.between(place[0], place[1], place[1] + depth) {
        let full = (place[1] + wet - low).clamp(0.0, high - low);
        let (pores, wet) = (density * soil.porosity, scene.soaked(place[0], [low, high]).unwrap_or(full));
        weight += (soil.dry_density() + moist * pores) * (high - low) + (1.0 - moist) * pores * wet;
    }
    let pressure = scene.first_felt(place).unwrap_or(density * g * wet);
    // The total stress has alpha of the pressure.
    (-(g * weight + standing - alpha * (pressure + standing)), pressure + standing)
}

/// Shear stress (Pa) on planes along a tilted base beside a total normal stress on them, of an infinite slope:
/// `rho g sin(angle) d` beside `-rho g cos(angle) d`.
fn first_shear(scene: &Scene, normal: f64) -> f64 {
    scene.slope_angle.map_or(0.0, |angle| -normal * angle.to_radians().tan())
}

/// Velocity at t = 0, m/s; none in a column, which the scene's check sees to.
fn first_velocity<const D: usize>(scene: &Scene) -> [f64; D] {
    let velocity = scene.start_velocity.unwrap_or([0.0; 2]);
    array_of(|d| velocity[d + 2 - D])
}

/// What the particles of an outline stand for; `None` for a column.
pub fn outline_parts(scene: &Scene) -> Option<Vec<Part>> {
    let outline = scene.outline.as_ref()?;
    Some(match scene.seeding {
        SeedingChoice::Clipped => seeding::parts(outline, scene.spacing()),
        SeedingChoice::Whole => seeding::whole(outline, scene.spacing()),
    })
}

fn refused(what: &str) -> RunError {
    RunError { step: 0, time: 0.0, place: "the scene".into(), what: what.into() }
}

fn outside<const D: usize>(layer: &str, index: usize, x: &[f64; D]) -> RunError {
    RunError {
        step: 0,
        time: 0.0,
        place: format!("{layer} particle {index} at {x:?} m"),
        what: "outside the mesh".into(),
    }
}

//! A disc that turns by half a turn while a ring of it is sheared to gamma = 1 and back, moved by a body force: large
//! rotation and stretch of the solid, for every kind of shape function.
//!
//! The error is that of the place of the particles half-way, where the shear is largest: RMS over the disc, over the
//! way that the shear alone has moved the ring at most. The linear functions are left out: soil that crosses cells with
//! a free edge makes them so noisy that finer meshes do worse (see `stability`).

use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given};
use mpm_core::hardware::Hardware;
use mpm_core::run::model_given;
use mpm_core::scene::{Dimension, Scene, SeedingChoice, ShapeChoice, SolidSide, TransferChoice};
use mpm_core::stability::stable_limit;

use super::{Error, Mutant, Outcome, Program, integrator, scheme};
use super::{FIRST_ORDER, PARTICLE_COUNTS};
use crate::exact::vortex::Vortex;
use crate::experiment::comparison::{Compared, Comparison, Norm, in_time};
use crate::experiment::refinement::{PARTICLES, Refinement, Sampled};

/// Quadratic B-splines.
pub const SPLINES: Program = Program {
    name: "vortex",
    about: "a disc sheared and turned by a body force, B-splines: places of the particles, order 2",
    run: || outcome(ShapeChoice::Bspline2, 2e-2, 2.0, 1.0),
    mutant: Some(Mutant { what: NO_FORCE, run: || outcome(ShapeChoice::Bspline2, 2e-2, 2.0, 0.0) }),
};

/// uGIMP, whose particles keep their first shape: its order falls on fine meshes.
pub const GIMP: Program = Program {
    name: "vortex-gimp",
    about: "the same with uGIMP",
    run: || outcome(ShapeChoice::Gimp, 5e-2, 2.0, 1.0),
    mutant: Some(Mutant { what: NO_FORCE, run: || outcome(ShapeChoice::Gimp, 5e-2, 2.0, 0.0) }),
};

const NO_FORCE: &str = "no body force";
/// Cells over the radius of the disc.
const MESHES: [usize; 4] = [10, 14, 20, 28];
/// Cells over the radius where steps are refined: what steps change does not need the ring to be resolved.
const STEPPED: usize = 5;
/// Comparison at the disc on the way.
const LOOKS: u32 = 4;
/// Step as a share of the stable one: the spin of a step turns the stress to first order in it.
const SHARE: f64 = 0.25;

/// The disc of radius 1 m in the middle of a square of 2.4 m.
fn motion(scene: &Scene) -> Vortex {
    Vortex {
        middle: [1.2; 2],
        ring: [0.5, 0.4],
        shear: 0.37,
        spin: std::f64::consts::PI,
        duration: 0.5,
        modulus: scene.elastic.shear_modulus(),
        density: scene.dry_density(),
    }
}

/// Soil without water on a mesh of `cells` over the radius.
fn disc(cells: usize, shape: ShapeChoice) -> Scene {
    let scene = crate::scenes::built_in("dry-bar").expect("the built-in scene");
    let corner = |i: i32| {
        let (sin, cos) = (f64::from(i) / 128.0 * 2.0 * std::f64::consts::PI).sin_cos();
        [1.2 + cos, 1.2 + sin]
    };
    // An outline under functions that reach beyond a cell, and a mesh wider than it: no file has that.
    scene.altered_unchecked(|scene| {
        scene.outline = Some((0..128).map(corner).collect());
        (scene.seeding, scene.solid_sides) = (SeedingChoice::Clipped, [SolidSide::Free; 4]);
        (scene.dimension, scene.shape) = (Dimension::PlaneStrain, shape);
        (scene.cell, scene.particles_per_cell, scene.empty_cells_above) = (1.0 / cells as f64, 9, 0);
        (scene.width, scene.height) = (2.4, 2.4);
        scene.cells = [(2.4 * cells as f64).round() as usize; 2];
        (scene.surcharge, scene.gravity, scene.stages[0].damping) = (None, None, 0.0);
        scene.transfer = TransferChoice::Affine;
        scene.elastic.youngs_modulus = 1e6;
        scene.grain_density = 1000.0 / (1.0 - scene.porosity);
    })
}

fn outcome(shape: ShapeChoice, required_error: f64, order: f64, force: f64) -> Result<Outcome, Error> {
    let base = disc(MESHES[0], shape);
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for cells in MESHES {
        let scene = disc(cells, shape);
        let found = followed(&scene, steps(&scene), force)?;
        errors.push((scene.cell, found.error()));
        samples = found.off;
    }
    let nine = errors.first().map_or(f64::NAN, |(_, error)| *error);
    let half = 0.5 * motion(&base).duration;
    let stepped = disc(STEPPED, shape);
    let step = |dt: f64| Ok(followed(&stepped, (half / dt).round(), force)?.places);
    let with = |count: &usize| {
        let scene = base.clone().altered_unchecked(|s| s.particles_per_cell = *count);
        Ok::<_, Error>((*count as f64, followed(&scene, steps(&scene), force)?.error()))
    };
    let counted = PARTICLE_COUNTS[1..].iter().map(with).collect::<Result<_, _>>()?;
    let against = format!("the exact places, L = {} m: the error of the mesh stays, no order is expected", base.cell);
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error,
        required_order: Some(order),
        samples,
        refinements: vec![
            in_time(step, stepped.cell, half / steps(&stepped), 4, FIRST_ORDER)?,
            // Four per cell are too few for a disc cut out of the mesh. More than the nine of the case must not do
            // worse.
            Refinement { required_finest: Some(nine), ..Refinement::new(PARTICLES, counted, against) },
        ],
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

/// Steps to half of the motion, a multiple of the looks.
fn steps(scene: &Scene) -> f64 {
    let looks = f64::from(LOOKS);
    looks * (0.5 * motion(scene).duration / (SHARE * stable_limit(scene)) / looks).ceil()
}

/// What is found of the particles of a run.
struct Followed {
    /// RMS of how far they are off at the looks, over the way that the shear moves the ring.
    off: Vec<Sampled>,
    /// Their places at the end, in the same unit, with a weight that makes an RMS of coordinates one of particles.
    places: Comparison,
}

impl Followed {
    /// At the end.
    fn error(&self) -> f64 {
        self.off.last().map_or(f64::NAN, |s| s.error)
    }
}

/// Follows the disc in so many steps to half of the motion; the force is a share of the right one.
fn followed(scene: &Scene, steps: f64, share: f64) -> Result<Followed, Error> {
    let exact = motion(scene);
    let half = 0.5 * exact.duration;
    let dt = half / steps;
    // Velocities are those of half a step before.
    let first = move |x: [f64; 2]| FirstState { velocity: exact.point(x, -0.5 * dt).velocity, ..FirstState::default() };
    let push = move |x: [f64; 2], t: f64| exact.body_force(x, t).map(|b| share * b);
    let given = Given { force: Some(Arc::new(push)), start: Some(Arc::new(first)), ..Given::default() };
    let mut model = model_given(&Hardware::default(), scene, &given)?;
    let mut starts: Vec<_> = model.particles().iter().map(|p| (p.id, p.x)).collect();
    starts.sort_by_key(|(id, _)| *id);
    model.enter_stage(&scene.stages[0], &[half])?;
    let way = exact.shear * exact.ring[0];
    let (mut off, mut computed, mut expected) = (Vec::new(), Vec::new(), Vec::new());
    for look in 1..=LOOKS {
        model.advance(dt, (steps / f64::from(LOOKS)).round() as u64, &mut 0)?;
        let time = half * f64::from(look) / f64::from(LOOKS);
        let mut particles = model.particles();
        particles.sort_by_key(|p| p.id);
        let (mut squares, mut mass) = (0.0, 0.0);
        (computed, expected) = (Vec::new(), Vec::new());
        for p in &particles {
            let there = exact.point(starts[p.id as usize].1, time);
            squares += p.mass * ((p.x[0] - there.x[0]).powi(2) + (p.x[1] - there.x[1]).powi(2));
            mass += p.mass;
            computed.extend(p.x.map(|x| 2.0_f64.sqrt() * x / way));
            expected.extend(there.x.map(|x| 2.0_f64.sqrt() * x / way));
        }
        let error = (squares / mass).sqrt() / way;
        off.push(Sampled {
            quantity: "RMS of the places' errors over the way of the ring".to_owned(),
            unit: "-".to_owned(),
            time,
            factor: None,
            computed: error,
            exact: 0.0,
            error,
            counts: look == LOOKS,
        });
    }
    let last = Compared { time: half, factor: None, computed, exact: expected, counts: true, places: Vec::new() };
    Ok(Followed { off, places: Comparison { over_places: Norm::Rms, ..Comparison::worst("places", vec![last]) } })
}

//! A free elastic square that turns once through the mesh: its angular momentum, under every way to carry velocities.
//!
//! It is stiff enough to turn nearly as a rigid body, and no force acts on it. Particles with affine velocities keep
//! the angular momentum to a part in 1e4 and better; with velocities alone a node at an edge has that of particles on
//! one side of it, FLIP loses some percent of the spin in a turn and PIC all of it. The error is the change of the
//! angular momentum.

use std::f64::consts::TAU;
use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given};
use mpm_core::hardware::Hardware;
use mpm_core::observe::SolidState;
use mpm_core::run::model_given;
use mpm_core::scene::{Dimension, Elastic, Scene, ShapeChoice, SolidSide, TransferChoice};
use mpm_core::stability::stable_limit;
use mpm_core::step::Model;

use super::PARTICLE_COUNTS;
use super::{Error, Lacks, Mutant, Outcome, Program, integrator, scheme};
use crate::experiment::comparison::{Compared, Comparison, in_particles, in_time};
use crate::experiment::refinement::Sampled;

/// Quadratic B-splines.
pub const SPLINES: Program = Program {
    name: "spin",
    about: "a free square turns once, affine velocities, B-splines: change of the angular momentum",
    run: || outcome(ShapeChoice::Bspline2, TransferChoice::Affine),
    mutant: Some(Mutant { what: PLAIN, run: || outcome(ShapeChoice::Bspline2, TransferChoice::Plain) }),
};

/// uGIMP.
pub const GIMP: Program = Program {
    name: "spin-gimp",
    about: "the same with uGIMP",
    run: || outcome(ShapeChoice::Gimp, TransferChoice::Affine),
    mutant: Some(Mutant { what: PLAIN, run: || outcome(ShapeChoice::Gimp, TransferChoice::Plain) }),
};

const PLAIN: &str = "velocities that are not affine";
/// Speed of a side's middle over that of shear waves.
const SLOW: f64 = 0.05;
/// Middle of the square of 1 m in a mesh of 1.6 m, m.
const MIDDLE: f64 = 0.8;
/// Comparison at the square during a turn.
const LOOKS: u32 = 16;
/// Step as a share of the stable one.
const SHARE: f64 = 0.4;

/// What carries velocities beside the case's own choice, for the curves: name, affine or not, share of FLIP.
const OTHERS: [(&str, TransferChoice, f64); 4] = [
    ("FLIP", TransferChoice::Plain, 1.0),
    ("PIC", TransferChoice::Plain, 0.0),
    ("affine FLIP", TransferChoice::Affine, 1.0),
    ("affine PIC", TransferChoice::Affine, 0.0),
];

fn square(cells: usize, shape: ShapeChoice, transfer: TransferChoice, flip: f64) -> Result<Scene, Error> {
    // An outline under functions that reach beyond a cell, and a mesh wider than it: no file has that.
    let scene = crate::scenes::built_in("dry-bar")?.altered_unchecked(|scene| {
        scene.outline = Some([[0.3, 0.3], [1.3, 0.3], [1.3, 1.3], [0.3, 1.3]].to_vec());
        (scene.dimension, scene.shape, scene.solid_sides) = (Dimension::PlaneStrain, shape, [SolidSide::Free; 4]);
        (scene.cell, scene.particles_per_cell, scene.empty_cells_above) = (1.0 / cells as f64, 4, 0);
        (scene.width, scene.height) = (2.0 * MIDDLE, 2.0 * MIDDLE);
        scene.cells = [(2.0 * MIDDLE * cells as f64).round() as usize; 2];
        (scene.surcharge, scene.gravity, scene.stages[0].damping) = (None, None, 0.0);
        (scene.transfer, scene.flip) = (transfer, flip);
    });
    Ok(scene)
}

fn outcome(shape: ShapeChoice, transfer: TransferChoice) -> Result<Outcome, Error> {
    let mut notes = Vec::new();
    let mut samples = Vec::new();
    for (name, transfer, flip) in OTHERS {
        let history = turn(&square(10, shape, transfer, flip)?, SHARE)?;
        let last = history.last().ok_or(Lacks("look"))?;
        notes.push((format!("{name}, 10 cells: angular momentum after a turn, of the first"), last[1], "-".to_owned()));
        notes.push((format!("{name}, 10 cells: energy after a turn, of the first"), last[2], "-".to_owned()));
        for (quantity, at) in [("angular momentum", 1), ("energy", 2)] {
            samples.extend(history.iter().map(|look| Sampled {
                quantity: format!("{quantity}, {name}"),
                unit: "-".to_owned(),
                time: look[0],
                factor: None,
                computed: look[at],
                exact: 1.0,
                error: look[at] - 1.0,
                counts: false,
            }));
        }
    }
    let momentum = |scene: &Scene, share: f64| {
        let looks = turn(scene, share)?.iter().map(|look| Compared::one(look[0], look[1], 1.0)).collect();
        Ok::<_, Error>(Comparison::worst("angular momentum of the first", looks))
    };
    let mut errors = Vec::new();
    for cells in [5, 10, 13, 15] {
        let scene = square(cells, shape, transfer, 1.0)?;
        let history = momentum(&scene, SHARE)?;
        errors.push((scene.cell, history.error()));
        // The curves above are those of ten cells.
        samples.retain(|sample: &Sampled| !sample.counts);
        samples.extend(history.samples());
    }
    let base = square(10, shape, transfer, 1.0)?;
    let coarse = square(5, shape, transfer, 1.0)?;
    let limit = stable_limit(&coarse);
    let step = |dt: f64| momentum(&coarse, dt / limit);
    let with = |count| momentum(&base.clone().altered_unchecked(|s| s.particles_per_cell = count), SHARE);
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 2e-4,
        notes,
        samples,
        refinements: vec![
            in_time(step, coarse.cell, SHARE * limit, 2, None)?,
            in_particles(with, base.cell, &PARTICLE_COUNTS[1..3], 1e-3)?,
        ],
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

/// A square of one's own that turns.
pub(crate) struct Body {
    /// Its side, m.
    pub side: f64,
    /// Its density, kg/m3.
    pub density: f64,
    /// Its angular velocity, 1/s.
    pub rate: f64,
    /// What it is made of.
    pub soil: Elastic,
}

impl Body {
    /// Where material points, given by their first places from the middle (m), are at some times (s), time by time. Splines, affine velocities.
    pub fn places(&self, cells: usize, times: &[f64], points: &[[f64; 2]]) -> Result<Vec<[f64; 2]>, Error> {
        let (side, middle) = (self.side, MIDDLE * self.side);
        let scene = square(cells, ShapeChoice::Bspline2, TransferChoice::Affine, 1.0)?.altered_unchecked(|scene| {
            let grown = |corner: [f64; 2]| corner.map(|x| x * side);
            scene.outline = scene.outline.take().map(|corners| corners.into_iter().map(grown).collect());
            (scene.cell, scene.width, scene.height) = (side * scene.cell, side * scene.width, side * scene.height);
            (scene.elastic, scene.grain_density) = (self.soil, self.density / (1.0 - scene.porosity));
        });
        let mut model = turning(&scene, middle, self.rate)?;
        // Particles may be sorted on the way.
        let by_number = |model: &dyn Model| {
            let mut all: Vec<(u32, [f64; 2])> = model.particles().iter().map(|p| (p.id, p.x)).collect();
            all.sort_by_key(|(id, _)| *id);
            all.into_iter().map(|(_, x)| x).collect::<Vec<_>>()
        };
        let first = by_number(&*model);
        let limit = SHARE * stable_limit(&scene);
        model.enter_stage(&scene.stages[0], times)?;
        let (mut now, mut found) = (0.0, Vec::new());
        for time in times {
            let steps = ((time - now) / limit).ceil();
            model.advance((time - now) / steps, steps as u64, &mut 0)?;
            now = *time;
            let reached = by_number(&*model);
            for point in points {
                let off = |x: &[f64; 2]| (x[0] - middle - point[0]).hypot(x[1] - middle - point[1]);
                let least = first.iter().map(off).fold(f64::INFINITY, f64::min);
                // Those around it, as near as each other: it is in their middle.
                let near = |i: &usize| off(&first[*i]) < least + 1e-6 * side;
                let near: Vec<usize> = (0..first.len()).filter(near).collect();
                found.push([0, 1].map(|axis| {
                    let sum: f64 = near.iter().map(|i| reached[*i][axis]).sum();
                    sum / near.len() as f64 - middle
                }));
            }
        }
        Ok(found)
    }
}

/// A square at t = 0 that turns about a middle (m) at a rate (1/s).
fn turning(scene: &Scene, middle: f64, rate: f64) -> Result<Box<dyn Model>, Error> {
    let first = move |[x, y]: [f64; 2]| FirstState {
        velocity: [rate * (middle - y), rate * (x - middle)],
        ..FirstState::default()
    };
    let given = Given { start: Some(Arc::new(first)), ..Given::default() };
    Ok(model_given(&Hardware::default(), scene, &given)?)
}

/// Time (s), angular momentum and energy over their first values during a turn, in steps that are a share of the stable
/// one.
fn turn(scene: &Scene, share: f64) -> Result<Vec<[f64; 3]>, Error> {
    let rate = 2.0 * SLOW * (scene.elastic.shear_modulus() / scene.dry_density()).sqrt();
    let mut model = turning(scene, MIDDLE, rate)?;
    let end = TAU / rate;
    let each = (end / f64::from(LOOKS) / (share * stable_limit(scene))).ceil();
    let dt = end / f64::from(LOOKS) / each;
    model.enter_stage(&scene.stages[0], &[end])?;
    let moment = |p: &SolidState| p.mass * ((p.x[0] - MIDDLE) * p.velocity[1] - (p.x[1] - MIDDLE) * p.velocity[0]);
    let mut looks = Vec::new();
    for look in 0..=LOOKS {
        if look > 0 {
            model.advance(dt, each as u64, &mut 0)?;
        }
        let ledger = model.observe().1;
        let momentum: f64 = model.particles().iter().map(moment).sum();
        looks.push([f64::from(look) * each * dt, momentum, ledger.kinetic_j + ledger.strain_j]);
    }
    let [_, momentum, energy] = looks[0];
    Ok(looks.iter().map(|l| [l[0], l[1] / momentum, l[2] / energy]).collect())
}

//! A saturated column under gravity stays at rest, in plane strain and with both Darcy operators.
//!
//! This decides the sign in the paper's Eq. (2): as printed, still water would flow at 2 k.

use mpm_core::drive::Sample;
use mpm_core::scene::{DarcyChoice, Dimension, Scene, Start, Until};

use super::{Error, Mutant, Outcome, Program, finished, integrator, scheme};
use crate::experiment::comparison::{Compared, Comparison, in_particles};
use crate::experiment::refinement::{MESH, Refinement};
use crate::norms::largest;
use crate::study::word;

/// The case.
pub const CASE: Program = Program {
    name: "hydrostatic",
    about: "still water stays still (sign of Eq. 2)",
    run: || outcome(Start::Geostatic),
    mutant: Some(Mutant { what: "no water pressure at the start", run: || outcome(Start::Unloaded) }),
};

fn outcome(start: Start) -> Result<Outcome, Error> {
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for darcy in [DarcyChoice::Face, DarcyChoice::Nodal] {
        let looks = speeds(&column(start, darcy, 20, 4)?)?;
        errors.push(looks.error());
        samples.extend(looks.samples());
    }
    let on = |rows: &usize| {
        let scene = column(start, DarcyChoice::Face, *rows, 4)?;
        Ok((scene.cell, speeds(&scene)?.error()))
    };
    let meshes = [5, 10, 20, 40].iter().map(on).collect::<Result<_, Error>>()?;
    let meshed = Refinement::new(MESH, meshes, "water at rest, with the face operator: exact on every mesh");
    let with = |count| speeds(&column(start, DarcyChoice::Face, 20, count)?);
    let face = column(start, DarcyChoice::Face, 20, 4)?;
    Ok(Outcome {
        integrator: integrator(&face),
        scheme: format!("{} and nodal", scheme(&face)),
        errors: vec![(face.cell, largest(errors.into_iter()))],
        required_error: ROUND_OFF,
        required_order: None,
        samples,
        refinements: vec![
            Refinement { required_error: Some(ROUND_OFF), ..meshed },
            in_particles(with, face.cell, &[1, 4, 9, 16], ROUND_OFF)?,
        ],
        ..Outcome::default()
    })
}

const ROUND_OFF: f64 = 1e-9;
/// End of a run, s.
const END: f64 = 1e-2;

/// A block two cells wide.
fn column(start: Start, darcy: DarcyChoice, rows: usize, particles_per_cell: usize) -> Result<Scene, Error> {
    Ok(crate::scenes::terzaghi().with_rows(rows)?.edited(|scene| {
        (scene.dimension, scene.cells, scene.particles_per_cell) =
            (Dimension::PlaneStrain, [2, rows], particles_per_cell);
        scene.width = 2.0 * scene.cell;
        (scene.gravity, scene.start, scene.surcharge, scene.darcy) = (Some(GRAVITY), start, None, darcy);
        scene.stages[0].until = Until::Time(END);
        (scene.observe_times, scene.history) = ([0.25, 0.5, 0.75, 1.0].map(|share| share * END).to_vec(), 0);
    })?)
}

const GRAVITY: f64 = 9.81;

/// The largest speed of all particles over that of free fall for as long as the run.
fn speeds(scene: &Scene) -> Result<Comparison, Error> {
    let run = finished(scene)?;
    let look = |s: &Sample| Compared::one(s.stage_time, s.state.max_speed / (GRAVITY * END), 0.0);
    let what = format!("largest speed over that of free fall, {}", word(scene.darcy));
    Ok(Comparison::worst(what, run.observed().map(look).collect()))
}

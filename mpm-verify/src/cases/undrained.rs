//! Undrained compression: load on a closed, damped column; p -> q (K_w/n)/(M + K_w/n) = 9963.4 Pa.
//!
//! This decides the sign in the paper's Eq. (5): as printed, compressing the skeleton would lower the pressure.

use mpm_core::drive::Sample;
use mpm_core::scene::{Fields, Scene, Start, Until};

use super::{Error, Lacks, Mutant, Outcome, Program, Unfit, finished, integrator, scheme, sound};
use crate::experiment::comparison::{Compared, Comparison, in_particles};
use crate::experiment::refinement::{MESH, Refinement};

/// The case.
pub const CASE: Program = Program {
    name: "undrained",
    about: "pore pressure of a closed column under load (sign of Eq. 5)",
    run: || outcome(sound),
    mutant: Some(Mutant { what: "water 1 % too stiff", run: || outcome(stiffer) }),
};

fn stiffer(scene: &mut Fields) {
    if let Some(water) = &mut scene.water {
        water.bulk_modulus *= 1.01;
    }
}

fn outcome(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut scene = crate::scenes::terzaghi().with_rows(20)?.edited(|scene| {
        scene.start = Start::Unloaded;
        scene.stages[0].drained = [false; 4];
    })?;
    // Critical damping of the first undrained mode, 2 omega = pi c_u/H, kills the wave within milliseconds. What it
    // leaves uneven flows off inside the column, and only in the time of a consolidation: three times Tv = 1.
    let speed = ((scene.oedometer_modulus() + scene.pore_stiffness()) / scene.mixture_density()).sqrt();
    scene = scene.edited(|scene| scene.stages[0].damping = std::f64::consts::PI * speed / scene.height)?;
    let end = 3.0 * crate::scenes::terzaghi().time_per_factor().ok_or(Unfit("the scene is dry"))?;
    scene = scene.edited(|scene| {
        scene.stages[0].until = Until::Time(end);
        (scene.observe_times, scene.history) = ([0.25, 0.5, 0.75, 1.0].map(|share| share * end).to_vec(), 0);
    })?;
    let expected = scene.undrained_pressure();
    scene = scene.edited(fault)?;
    let looks = pressures(&scene, expected)?;
    // Scenes of their own damping: that of the first wave does not depend on the mesh.
    let on = |rows: &usize| {
        let scene = scene.with_rows(*rows)?;
        Ok((scene.cell, pressures(&scene, expected)?.error()))
    };
    let meshes = [5, 10, 20].iter().map(on).collect::<Result<_, Error>>()?;
    let against = "the exact pressure: uniform, and the same on every mesh";
    let with = |particles_per_cell| pressures(&scene.edited(|s| s.particles_per_cell = particles_per_cell)?, expected);
    Ok(Outcome {
        integrator: integrator(&scene),
        scheme: scheme(&scene),
        errors: vec![(scene.cell, looks.error().abs())],
        required_error: LINEAR,
        required_order: None,
        samples: looks.samples(),
        refinements: vec![
            Refinement { required_error: Some(LINEAR), ..Refinement::new(MESH, meshes, against) },
            in_particles(with, scene.cell, &[1, 4, 9], LINEAR)?,
        ],
        ..Outcome::default()
    })
}

/// The analysis is linear; strains of q/(M + Q) = 1.4e-6 change volumes by as much.
const LINEAR: f64 = 1e-5;

/// Pressures of all cells over the undrained one; the end counts.
fn pressures(scene: &Scene, expected: f64) -> Result<Comparison, Error> {
    let run = finished(scene)?;
    let last = run.samples.last().ok_or(Lacks("sample"))?.stage_time;
    let look = |s: &Sample| {
        let computed: Vec<f64> = s.state.profile.iter().map(|row| row.pressure_pa / expected).collect();
        let exact = vec![1.0; computed.len()];
        Compared { time: s.stage_time, factor: None, computed, exact, counts: s.stage_time == last, places: Vec::new() }
    };
    Ok(Comparison::worst("p over the undrained pressure", run.observed().map(look).collect()))
}

//! An oedometer made of particles: dry soil that yields along the edge s1 = s2 under a load that grows slowly.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{Dimension, Fields, Scene, ShapeChoice};

use super::super::{Error, Lacks, Mutant, Outcome, Program, Unfit, finished, integrator, scheme};
use crate::exact::oedometer::Oedometer;
use crate::experiment::comparison::{Compared, Comparison, in_particles};
use crate::experiment::refinement::{MESH, Refinement};
use crate::norms::largest;

/// The case.
pub const CASE: Program = Program {
    name: "mc-oedometer",
    about: "Mohr-Coulomb soil compressed beyond yield by particles, one and two dimensions: settlement",
    run: || settles(|_| {}),
    mutant: Some(Mutant { what: "angle of friction one degree too large", run: mutant }),
};

/// A friction angle that is one degree off.
fn mutant() -> Result<Outcome, Error> {
    settles(|scene| {
        if let Some(strength) = &mut scene.strength {
            strength.friction_angle += 1.0;
        }
    })
}

/// The settlement at rest of columns and blocks. Strains of q/M = 5e-4 change volumes by as much.
fn settles(change: impl Fn(&mut Fields)) -> Result<Outcome, Error> {
    let base = crate::scenes::oedometer();
    let looks_at = |mut scene: Scene| {
        let exact = Oedometer::new(&scene).ok_or(Unfit("soil without strength"))?;
        scene = scene.edited(&change)?;
        looks(&finished(&scene)?, &scene, &exact)
    };
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for dimension in [Dimension::Column, Dimension::PlaneStrain] {
        for shape in [ShapeChoice::Centre, ShapeChoice::Bspline2] {
            let looks = looks_at(base.edited(|s| (s.dimension, s.shape) = (dimension, shape))?)?;
            errors.push(looks.error());
            samples = looks.samples();
        }
    }
    let meshed = |rows: &usize| {
        let scene = base.with_rows(*rows)?;
        Ok((scene.cell, looks_at(scene)?.error()))
    };
    let meshes = [5, 10, 20, 40].iter().map(meshed).collect::<Result<_, Error>>()?;
    let against = "the exact solution, a column of centre values: a uniform strain has no error of the mesh";
    let with = |particles_per_cell| looks_at(base.edited(|s| s.particles_per_cell = particles_per_cell)?);
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: format!("{} and bspline2", scheme(&base)),
        errors: vec![(base.cell, largest(errors.into_iter()))],
        required_error: 1e-3,
        required_order: None,
        samples,
        refinements: vec![
            Refinement { required_error: Some(1e-3), ..Refinement::new(MESH, meshes, against) },
            in_particles(with, base.cell, &[1, 4, 9, 16], 1e-3)?,
        ],
        ..Outcome::default()
    })
}

/// The settlement over the last one, under the load of the time; the end, at rest, counts.
fn looks(run: &Run, scene: &Scene, exact: &Oedometer) -> Result<Comparison, Error> {
    let load = scene.surcharge.ok_or(Lacks("load"))?;
    let last = run.samples.last().ok_or(Lacks("sample"))?;
    let whole = scene.height * exact.strain(load.pressure);
    let look = |s: &Sample| {
        let expected = scene.height * exact.strain(load.at(s.stage_time));
        let counts = s.stage_time == last.stage_time;
        Compared { counts, ..Compared::one(s.stage_time, s.state.settlement / whole, expected / whole) }
    };
    Ok(Comparison::worst("settlement over the last one", run.observed().chain([last]).map(look).collect()))
}

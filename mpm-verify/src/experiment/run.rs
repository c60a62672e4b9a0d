//! Runs an experiment on its meshes, and refines what else it asks for.

use std::cell::Cell;

use mpm_core::boundary::Given;
use mpm_core::drive::Run;
use mpm_core::observe::balances;
use mpm_core::run::{StartError, run, run_given};
use mpm_core::scene::{Integrator, Scene, StepChoice};

use super::comparison::{Comparison, in_particles, in_time, in_tolerance};
use super::refinement::{MESH, Refinement, STEP};
use super::shared::shared;
use super::spec::{Measure, Spec};
use super::verdict::Outcome;
use crate::cases::own::OwnScene;
use crate::error::Error::{self, Lacks};
use crate::norms::worst;
use crate::study::word;
use toml::Table;

/// Runs a case, with its fault or without.
///
/// # Errors
/// A scene that is refused, a run that could not be finished.
pub(crate) fn outcome(spec: &Spec, with_fault: bool) -> Result<Outcome, Error> {
    let bases = spec.bases()?;
    let base = bases.first().ok_or(Lacks("scene"))?;
    let fault = if with_fault { Some(spec.mutant.as_ref().ok_or(Lacks("mutant"))?) } else { None };
    let planted = |scene: &Scene| fault.map_or_else(|| Ok(scene.clone()), |fault| fault.planted(scene));
    if spec.as_own_scene {
        let rows: Vec<usize> = spec.meshes.iter().map(|rows| *rows as usize).collect();
        return OwnScene::new(base, &rows)?.outcome(&planted);
    }
    let measure = spec.measure.as_ref().ok_or(Lacks("measure"))?;
    // The reference is that of the sound scene.
    let measured = |measure: &Measure, scene: &Scene| {
        let mut found = measure.of_scene(scene)?(&*shared(&planted(scene)?)?)?;
        if let Some(fault) = fault {
            found.rows.iter_mut().flat_map(|row| &mut row.computed).for_each(|number| *number *= fault.reading);
        }
        Ok::<_, Error>(found)
    };
    let compared = |scene: &Scene| measured(measure, scene);
    let on_mesh = |measure: &Measure, bases: &[Scene], cells: f64| {
        let scenes: Vec<Scene> = bases.iter().map(|base| spec.on(base, cells)).collect::<Result<_, _>>()?;
        let found = scenes.iter().map(|scene| measured(measure, scene)).collect::<Result<Vec<_>, Error>>()?;
        Ok::<_, Error>((scenes[0].cell, worst(found.iter().map(Comparison::error)), found, scenes))
    };
    let (mut errors, mut finest, mut shown) = (Vec::new(), Vec::new(), None);
    for cells in &spec.meshes {
        let (cell, error, found, scenes) = on_mesh(measure, &bases, *cells)?;
        errors.push((cell, error));
        (finest, shown) = (found, scenes.into_iter().next());
    }
    let mut refined_by = MESH;
    if let (true, Some(steps)) = (spec.by_steps, &spec.steps) {
        let scene = spec.on(base, steps.cells)?;
        let first = steps.first(&planted(&scene)?);
        for halvings in 0..=steps.halvings as i32 {
            let step = first / 2.0_f64.powi(halvings);
            finest = vec![compared(&scene.edited(|scene| scene.step = StepChoice::Fixed(step))?)?];
            errors.push((step, finest[0].error()));
        }
        (refined_by, shown) = (STEP, Some(scene));
    }
    let mut refinements = refinements(spec, &planted, &compared)?;
    for also in &spec.also {
        let (bases, measure) = (spec.bases_with(&also.patch)?, also.measure.as_ref().unwrap_or(measure));
        let on = |cells: &f64| on_mesh(measure, &bases, *cells).map(|(cell, error, ..)| (cell, error));
        let errors = also.meshes.iter().map(on).collect::<Result<_, Error>>()?;
        refinements.push(Refinement {
            required_error: also.at_most,
            required_finest: also.finest,
            required_order: also.order,
            ..Refinement::new(MESH, errors, also.against.clone())
        });
    }
    if spec.finest_alone {
        let all = std::mem::take(&mut errors);
        errors.extend(all.last());
        refinements.push(Refinement::new(MESH, all, "the reference, on every mesh; no order is expected"));
    }
    Ok(Outcome {
        integrator: integrator(base),
        scheme: scheme(base),
        tolerance: asked(base),
        errors,
        required_error: spec.error,
        required_order: spec.order,
        required_everywhere: spec.everywhere,
        refined_by,
        samples: finest.iter().flat_map(Comparison::samples).collect(),
        comparisons: finest,
        scene: shown,
        refinements,
        kind: spec.kind,
        ..Outcome::default()
    })
}

fn refinements(
    spec: &Spec,
    planted: &dyn Fn(&Scene) -> Result<Scene, Error>,
    compared: &dyn Fn(&Scene) -> Result<Comparison, Error>,
) -> Result<Vec<Refinement>, Error> {
    let on = |patch: &Table, cells: f64| {
        let bases = spec.bases_with(patch)?;
        spec.on(bases.first().ok_or(Lacks("scene"))?, cells)
    };
    let mut refinements = Vec::new();
    if let Some(steps) = spec.steps.as_ref().filter(|_| !spec.by_steps) {
        let scene = on(&steps.patch, steps.cells)?;
        let run = |step| compared(&scene.edited(|scene| scene.step = StepChoice::Fixed(step))?);
        let refinement = in_time(run, scene.cell, steps.first(&planted(&scene)?), steps.halvings, steps.order)?;
        refinements.push(Refinement { required_error: steps.at_most, ..refinement });
    }
    if let Some(tolerances) = &spec.tolerances {
        let scene = on(&tolerances.patch, tolerances.cells)?;
        let run = |tolerance| compared(&scene.edited(|scene| scene.tolerance = tolerance)?);
        refinements.push(in_tolerance(run, scene.cell, &tolerances.values, tolerances.times)?);
    }
    if let Some(particles) = &spec.particles {
        let mut scene = on(&Table::new(), particles.cells)?;
        if let (true, Some(steps)) = (spec.by_steps, &spec.steps) {
            // In the first step that is refined.
            let first = steps.first(&planted(&scene)?);
            scene = scene.edited(|scene| scene.step = StepChoice::Fixed(first))?;
        }
        let run = |count| compared(&scene.edited(|scene| scene.particles_per_cell = count)?);
        refinements.push(in_particles(run, scene.cell, &particles.counts, particles.at_most)?);
    }
    Ok(refinements)
}

/// `centre/face` and the like.
pub(crate) fn scheme(scene: &Scene) -> String {
    let shape = word(scene.shape);
    if scene.water.is_some() { format!("{shape}/{}", word(scene.darcy)) } else { shape }
}

/// `explicit` and the like.
pub(crate) fn integrator(scene: &Scene) -> String {
    word(scene.integrator)
}

/// What a quasi-static scene asks of its steps in time, by which its results may move; zero where steps are what they are.
pub(crate) fn asked(scene: &Scene) -> f64 {
    if scene.integrator == Integrator::QuasiStatic { scene.tolerance } else { 0.0 }
}

thread_local! {
    /// The largest gap of momentum in the runs of a case, over what may be; nothing before one with inertia.
    pub(crate) static MOMENTUM: Cell<Option<f64>> = const { Cell::new(None) };
}

/// Notes the momentum that is missing in a run. Fields without words in a scene are not known to the bounds.
pub(crate) fn note_momentum(scene: &Scene, run: &Run) {
    if run.trust.is_none() {
        return;
    }
    for sample in &run.samples {
        let all = balances(scene, run.dt, sample.step, &sample.state, &sample.balance);
        for balance in all.iter().filter(|balance| balance.name == "momentum" && balance.gap != 0.0) {
            let missing = balance.gap.abs() / balance.allowed;
            let larger = |known: f64| if missing <= known { known } else { missing };
            MOMENTUM.set(Some(MOMENTUM.get().map_or(missing, larger)));
        }
    }
}

/// Runs a scene to its end.
pub(crate) fn finished(scene: &Scene) -> Result<Run, Error> {
    let run = whole(run(scene, &mut |_| {}))?;
    note_momentum(scene, &run);
    Ok(run)
}

/// The same with fields that scenes have no words for.
pub(crate) fn finished_given(scene: &Scene, given: &Given) -> Result<Run, Error> {
    whole(run_given(scene, given, &mut |_| {}))
}

/// A run that has come to its end.
pub(crate) fn whole(run: Result<Run, StartError>) -> Result<Run, Error> {
    Ok(run?.whole()?)
}

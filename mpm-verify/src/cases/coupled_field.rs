//! A made-up field of soil and pore water in a closed square, moved by a body force, against its closed form: u-p model
//! in plane strain with inertia, storage, coupling and drainage of the same size.

use std::sync::Arc;

use mpm_core::boundary::Given;
use mpm_core::drive::{Run, Sample};
use mpm_core::observe::FieldPoint;
use mpm_core::scene::{Integrator, Scene, ShapeChoice, SolidSide, StepChoice, StrainChoice, Until};

use super::{Error, Mutant, Outcome, Program, Unfit, finished_given, integrator, scheme};
use super::{FIRST_ORDER, PARTICLE_COUNTS};
use crate::exact::coupled_field::CoupledField;
use crate::experiment::comparison::{Compared, Comparison, Norm, in_particles, in_time};
use crate::experiment::refinement::STEP as BY_STEP;

/// The paper's scheme.
pub const EXPLICIT: Program = Program {
    name: "coupled-field",
    about: "manufactured u-p field in a closed square, the paper's scheme: pressure, order 2",
    run: || refined(Integrator::Explicit, ShapeChoice::Centre, 1.0),
    mutant: Some(Mutant { what: NO_FORCE, run: || refined(Integrator::Explicit, ShapeChoice::Centre, 0.0) }),
};

/// Gradients at the particle.
pub const LINEAR: Program = Program {
    name: "coupled-field-linear",
    about: "the same with the standard linear scheme",
    run: || refined(Integrator::Explicit, ShapeChoice::Linear, 1.0),
    mutant: Some(Mutant { what: NO_FORCE, run: || refined(Integrator::Explicit, ShapeChoice::Linear, 0.0) }),
};

/// Implicit pressure.
pub const SEMI_IMPLICIT: Program = Program {
    name: "coupled-field-implicit",
    about: "the same with implicit pressure, steps that fall with L^2: order 2",
    run: || refined(Integrator::SemiImplicit, ShapeChoice::Centre, 1.0),
    mutant: Some(Mutant { what: NO_FORCE, run: || refined(Integrator::SemiImplicit, ShapeChoice::Centre, 0.0) }),
};

/// Implicit pressure, steps alone.
pub const STEPS: Program = Program {
    name: "coupled-field-steps",
    about: "the same on one mesh, against its solution in small steps: order 1 in the step",
    run: || steps(1.0),
    mutant: Some(Mutant { what: NO_FORCE, run: || steps(0.0) }),
};

const NO_FORCE: &str = "no body force";
/// Cells per side.
const SIDES: [usize; 4] = [8, 12, 16, 24];
/// Amplitude of the displacement, m: strains of 3e-6.
const AMPLITUDE: f64 = 1e-6;
/// Swings per second, rad/s.
const FREQUENCY: f64 = 300.0;
/// Steps over the square of the cell, s/m2: first-order errors in time then fall like those in space.
const STEP: f64 = 1.2e-2;
const EXPLICIT_STEP: f64 = 2e-3;

/// The closed square; water that seeps a hundredth as fast as in Table 1 drains in about a swing.
fn square() -> Result<Scene, Error> {
    let mut scene = crate::scenes::built_in("mandel")?;
    scene = scene.edited(|scene| {
        super::slower(scene, 100.0);
        (scene.surcharge, scene.solid_sides, scene.strain) = (None, [SolidSide::Roller; 4], StrainChoice::Large);
        (scene.particles_per_cell, scene.history) = (4, 0);
    })?;
    let period = std::f64::consts::TAU / FREQUENCY;
    Ok(scene.edited(|scene| {
        scene.observe_times = [0.25, 0.5, 0.75, 1.0].map(|share| share * period).to_vec();
        (scene.stages[0].drained, scene.stages[0].until) = ([false; 4], Until::Time(period));
    })?)
}

/// The run of a mesh with `side` cells, its step s; the force is a share of the right one.
fn run(mut scene: Scene, side: usize, dt: f64, share: f64) -> Result<(CoupledField, Run), Error> {
    scene = scene.edited(|scene| {
        (scene.cell, scene.cells, scene.step) = (scene.width / side as f64, [side; 2], StepChoice::Fixed(dt));
    })?;
    let exact = CoupledField::new(&scene, AMPLITUDE, FREQUENCY).ok_or(Unfit("not a square of saturated soil"))?;
    let given = Given {
        force: Some(Arc::new(move |x, t| exact.body_force(x, t).map(|b| share * b))),
        start: Some(Arc::new(move |x| exact.start(x, dt))),
        ..Given::default()
    };
    Ok((exact, finished_given(&scene, &given)?))
}

/// Pressures over their largest in every cell; the error is their RMS, at the worst time.
fn looks(run: &Run, exact: &CoupledField) -> Comparison {
    let look = |s: &Sample| {
        let of = |pressure: &dyn Fn(&FieldPoint) -> f64| {
            s.state.field.iter().map(|point| pressure(point) / exact.largest_pressure()).collect()
        };
        Compared {
            time: s.stage_time,
            factor: None,
            computed: of(&|point| point.pressure_pa),
            exact: of(&|point| exact.pressure([point.x_m, point.y_m], s.stage_time)),
            counts: true,
            places: Vec::new(),
        }
    };
    Comparison { over_places: Norm::Rms, ..Comparison::worst("p over its largest", run.observed().map(look).collect()) }
}

fn refined(integrate: Integrator, shape: ShapeChoice, share: f64) -> Result<Outcome, Error> {
    let base = square()?.edited(|base| (base.integrator, base.shape) = (integrate, shape))?;
    let factor = if integrate == Integrator::SemiImplicit { STEP } else { EXPLICIT_STEP };
    let with = |scene: &Scene, side: usize, dt: f64| {
        let (exact, run) = run(scene.clone(), side, dt, share)?;
        Ok::<_, Error>(looks(&run, &exact))
    };
    let step = |cell: f64| factor * cell * cell;
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for side in SIDES {
        let cell = base.width / side as f64;
        let found = with(&base, side, step(cell))?;
        errors.push((cell, found.error()));
        samples = found.samples();
    }
    let coarse = base.width / SIDES[0] as f64;
    let counted = |count| with(&base.edited(|s| s.particles_per_cell = count)?, SIDES[0], step(coarse));
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 5e-3,
        // The paper's scheme comes to 2 from below: 1.59 and 1.73 between these meshes, with the smallest errors of
        // all.
        required_order: Some(2.0),
        samples,
        refinements: vec![
            in_time(|dt| with(&base, SIDES[0], dt), coarse, 0.25 * step(coarse), 4, FIRST_ORDER)?,
            in_particles(counted, coarse, &PARTICLE_COUNTS[1..], 5e-2)?,
        ],
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

/// Differences from the run with a step 64 times smaller than the largest, on the same mesh. Without the force there is
/// nothing of the field left to differ, and the errors are those against the closed form.
fn steps(share: f64) -> Result<Outcome, Error> {
    const SIDE: usize = 12;
    let base =
        square()?.edited(|base| (base.integrator, base.shape) = (Integrator::SemiImplicit, ShapeChoice::Centre))?;
    let largest = STEP / 64.0;
    let found = |dt: f64, share: f64| {
        let (exact, run) = run(base.clone(), SIDE, dt, share)?;
        Ok::<_, Error>(looks(&run, &exact))
    };
    let finest = found(largest / 64.0, 1.0)?;
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for halvings in 0..4 {
        let dt = largest / 2.0_f64.powi(halvings);
        let mut own = found(dt, share)?;
        for (look, fine) in own.rows.iter_mut().zip(&finest.rows) {
            look.exact.clone_from(&fine.computed);
        }
        errors.push((dt, own.error()));
        samples = own.samples();
    }
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1e-2,
        required_order: Some(1.0),
        refined_by: BY_STEP,
        samples,
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

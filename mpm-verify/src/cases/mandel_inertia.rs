//! Mandel's problem with the integrators that carry inertia: the plate is a constraint on a row of nodes there.
//!
//! The run starts from the exact state at T = 0.02: the jump at t = 0 would send waves through soil that has no
//! damping, and the exact solution has none. A hundredth of the scene's load keeps strains from mattering.

use std::sync::Arc;

use mpm_core::boundary::{FirstField, FirstState, Given};
use mpm_core::drive::Run;
use mpm_core::scene::{Fields, Integrator, Scene, ShapeChoice, StepChoice, StrainChoice, Surcharge, Until};
use mpm_core::stability::stable_limit;

use super::{
    Error, FASTER, Lacks, Mutant, Outcome, Program, Unfit, faster, finished_given, integrator, scheme, slower, sound,
};
use super::{FIRST_ORDER, HALVINGS, PARTICLE_COUNTS};
use crate::exact::mandel::Mandel;
use crate::experiment::comparison::{Comparison, in_particles, in_time};
use crate::experiment::measure::mandel;
use crate::experiment::refinement::Refinement;

/// Implicit pressure.
pub const SEMI_IMPLICIT: Program = Program {
    name: "mandel-semi-implicit",
    about: "Mandel's problem with inertia, implicit pressure, rigid plate: p from T = 0.1 to 0.5",
    run: || semi_implicit(sound),
    mutant: Some(Mutant { what: FASTER, run: || semi_implicit(faster) }),
};

/// The paper's scheme.
pub const EXPLICIT: Program = Program {
    name: "mandel-explicit",
    about: "the same with the paper's explicit step",
    run: || explicit(sound),
    mutant: Some(Mutant { what: FASTER, run: || explicit(faster) }),
};

/// Where the run starts, T = c t/a^2.
const START: f64 = 0.02;
/// Times looked at.
const TIMES: [f64; 4] = [0.1, 0.2, 0.3, 0.5];

/// A way to run the block.
pub(super) struct Way {
    pub integrate: Integrator,
    /// Conductivity is lower by this: what inertia does to a consolidation falls with its speed.
    pub slow: f64,
    pub sides: [usize; 4],
    /// Step as a share of the stable one.
    safety: f64,
    /// The same two for a refinement of the step, whose error must stand above what is left of the first waves: these
    /// fall with the mesh, and the error of the step grows with the speed of the consolidation.
    stepped: (f64, usize),
    /// First step of it as a share of the stable one.
    share: f64,
}

impl Way {
    /// Refines the step of what is looked at in the block at times T.
    pub fn in_time(
        &self,
        times: &[f64],
        fault: fn(&mut Fields),
        looks: impl Fn(&Run, &Block) -> Result<Comparison, Error>,
    ) -> Result<Refinement, Error> {
        let (slow, side) = self.stepped;
        let mut block = Block::new(&Self { slow, ..*self }, times)?;
        block.scene = block.scene.edited(fault)?;
        let scene = block.scene.with_rows(side)?;
        let step = |dt| looks(&block.run(&scene.edited(|s| s.step = StepChoice::Fixed(dt))?)?, &block);
        in_time(step, scene.cell, self.share * stable_limit(&scene), HALVINGS, FIRST_ORDER)
    }
}

/// Implicit pressure.
pub(super) const IMPLICIT_PRESSURE: Way = Way {
    integrate: Integrator::SemiImplicit,
    slow: 8.0,
    sides: [6, 10, 14, 20],
    safety: 0.9,
    stepped: (1.0, 12),
    share: 0.1,
};
/// The paper's step.
pub(super) const PAPER: Way = Way {
    integrate: Integrator::Explicit,
    slow: 4.0,
    sides: [4, 8, 12, 16],
    safety: 0.9,
    stepped: (1.0, 8),
    share: 0.9,
};

/// The block with the exact state at T = START.
pub(super) struct Block {
    pub scene: Scene,
    pub exact: Mandel,
    /// Time of the exact solution at which the run starts, s.
    pub start: f64,
    given: Given,
}

impl Block {
    /// Observed at times T, the last of them its end.
    pub fn new(way: &Way, times: &[f64]) -> Result<Self, Error> {
        let mut scene = crate::scenes::built_in("mandel")?.edited(|scene| {
            scene.surcharge = scene.surcharge.map(|s| Surcharge { pressure: 0.01 * s.pressure, ..s });
            (scene.integrator, scene.shape, scene.strain) = (way.integrate, ShapeChoice::Centre, StrainChoice::Large);
            (scene.step, scene.particles_per_cell, scene.history) = (StepChoice::Auto, 4, 0);
            scene.safety = way.safety;
            slower(scene, way.slow);
        })?;
        let exact = Mandel::new(&scene).ok_or(Unfit("not Mandel's problem"))?;
        let one = 1.0 / exact.time_factor(1.0);
        let start = START * one;
        let looks: Vec<f64> = times.iter().map(|t| t * one - start).collect();
        let end = *looks.last().ok_or(Lacks("time to look at"))?;
        scene = scene.edited(|scene| (scene.observe_times, scene.stages[0].until) = (looks, Until::Time(end)))?;
        let given = Given { start: Some(state(&exact, start)), ..Given::default() };
        Ok(Self { scene, exact, start, given })
    }

    /// Runs a scene of the block.
    pub fn run(&self, scene: &Scene) -> Result<Run, Error> {
        finished_given(scene, &self.given)
    }
}

fn semi_implicit(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    outcome(&IMPLICIT_PRESSURE, 5e-4, fault)
}

fn explicit(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    outcome(&PAPER, 1e-3, fault)
}

fn outcome(way: &Way, required_error: f64, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut block = Block::new(way, &TIMES)?;
    block.scene = block.scene.edited(fault)?;
    let looks = |scene: &Scene| Ok::<_, Error>(mandel::looks(&block.run(scene)?, &block.exact, block.start));
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for side in way.sides {
        let scene = block.scene.with_rows(side)?;
        let found = looks(&scene)?;
        errors.push((scene.cell, found.error()));
        samples = found.samples();
    }
    let coarse = block.scene.with_rows(way.sides[0])?;
    let with = |count| looks(&coarse.edited(|s| s.particles_per_cell = count)?);
    let (integrator, scheme) = (integrator(&block.scene), scheme(&block.scene));
    Ok(Outcome {
        integrator,
        scheme,
        errors,
        required_error,
        required_order: Some(2.0),
        samples,
        refinements: vec![
            way.in_time(&TIMES[..3], fault, |run, block| Ok(mandel::looks(run, &block.exact, block.start)))?,
            in_particles(with, coarse.cell, &PARTICLE_COUNTS[1..], 2e-2)?,
        ],
        scene: Some(block.scene.clone()),
        ..Outcome::default()
    })
}

/// The exact state at a time (s), with the velocities of its displacements.
fn state(exact: &Mandel, time: f64) -> FirstField {
    let (exact, dt) = (exact.clone(), 1e-4 * time);
    Arc::new(move |[x, y]| {
        let p = exact.pressure(x, time);
        // Total stress: nothing sideways; across, there is no strain.
        let (xx, yy) = (p, exact.vertical_stress(x, time) + p);
        let rate = |u: &dyn Fn(f64) -> f64| (u(time + dt) - u(time - dt)) / (2.0 * dt);
        let plate = rate(&|t| exact.displacement_y(t));
        FirstState {
            velocity: [rate(&|t| exact.displacement_x(x, t)), plate * y / exact.half_height],
            stress: [xx, yy, exact.poisson * (xx + yy), 0.0],
            pressure: p,
        }
    })
}

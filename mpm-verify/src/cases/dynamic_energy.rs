//! The energy of the column with inertia: what the load does is kinetic energy, strain, compressed water, and what the
//! flow through the pores and damping have taken.
//!
//! A step of the explicit kind takes stress and pressure of its start. Over a step of the strain de the soil then does
//! the work `s de`, and stores `s de + M de^2/2`; the same of the water with K_w/n; its velocity changes by `a dt`,
//! which is worth `v a dt - a^2 dt^2/2` with the velocity v at its end. Per time these are `dt M e'^2/2` and `dt rho
//! a^2/2` with opposite signs, which cancel in a wave and leave FLIP's own loss (`bar-energy`), `(1 - S) dt rho a^2`:
//! all are of first order in the step, and so is the load of the step's start where the load grows. An implicit
//! pressure takes the water's part at the end of the step: another sign, the same order.

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::BalanceTerms;
use mpm_core::scene::{Fields, Integrator, Scene, Start, StepChoice, Surcharge, Until};
use mpm_core::stability::stable_limit;

use super::{Error, Mutant, Outcome, Program, Unfit, finished, integrator, scheme, sound};
use super::{FIRST_ORDER, PARTICLE_COUNTS};
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::refinement::{MESH, PARTICLES, Refinement, STEP};

/// The paper's step.
pub const EXPLICIT: Program = Program {
    name: "dynamic-energy",
    about: "energy balance of the column with inertia and damping: what no work explains, order 1 in the step",
    run: || outcome(&PAPER, sound),
    mutant: Some(Mutant { what: LOSSY, run: || outcome(&PAPER, lossy) }),
};

/// Implicit pressure.
pub const SEMI_IMPLICIT: Program = Program {
    name: "dynamic-energy-semi-implicit",
    about: "the same with implicit pressure",
    run: || outcome(&IMPLICIT_PRESSURE, sound),
    mutant: Some(Mutant { what: LOSSY, run: || outcome(&IMPLICIT_PRESSURE, lossy) }),
};

const LOSSY: &str = "a thousandth of PIC, whose loss is not booked";

fn lossy(scene: &mut Fields) {
    scene.flip = 0.999;
}

/// A way to run the column.
struct Way {
    integrate: Integrator,
    /// First step as a share of the stable one on the mesh of `ROWS[0]`, and how often it is halved.
    share: f64,
    halvings: i32,
    /// Time over which the load grows, s.
    ramp: f64,
    /// Largest gap in the first step with any number of particles.
    most: f64,
    required_error: f64,
}

/// From larger steps on the order comes to 1 from below.
const PAPER: Way =
    Way { integrate: Integrator::Explicit, share: 0.225, halvings: 4, ramp: 5e-4, most: 2e-2, required_error: 1e-4 };
/// Backward Euler takes from waves shorter than a step all that they have: under the fast ramp steps down to 1e-5 s
/// show no order. The slow one makes hardly a wave.
const IMPLICIT_PRESSURE: Way = Way {
    integrate: Integrator::SemiImplicit,
    share: 0.225,
    halvings: 6,
    ramp: 2e-2,
    most: 5e-2,
    required_error: 5e-4,
};

const ROWS: [usize; 3] = [10, 20, 40];
/// 1/s.
const DAMPING: f64 = 100.0;
const LOOKS: u32 = 40;

/// Table 1's column from rest under a hundredth of its load, which grows linearly at first: strains too small to
/// matter.
fn column(way: &Way) -> Result<Scene, Error> {
    let base = crate::scenes::terzaghi().edited(|base| {
        (base.history, base.start, base.integrator) = (0, Start::Unloaded, way.integrate);
        base.surcharge = base.surcharge.map(|s| Surcharge { ramp_time: way.ramp, pressure: 0.01 * s.pressure, ..s });
    })?;
    let end = 0.2 * base.time_per_factor().ok_or(Unfit("the scene is dry"))?;
    Ok(base.edited(|base| {
        base.stages[0].until = Until::Time(end);
        base.stages[0].damping = DAMPING;
        base.observe_times = (1..=LOOKS).map(|i| end * f64::from(i) / f64::from(LOOKS)).collect();
    })?)
}

/// What is stored and booked as lost, over the work of the load so far: all of it.
fn looks(run: &Run) -> Comparison {
    let explained = |l: &BalanceTerms| l.external_work_j + l.flow_body_work_j + l.energy_residual_j;
    let look = |s: &Sample| {
        let work = s.balance.external_work_j + s.balance.flow_body_work_j;
        Compared::one(s.stage_time, explained(&s.balance) / work, 1.0)
    };
    Comparison::worst("energy stored and lost over the work", run.observed().map(look).collect())
}

/// Shares of the work at the end of a run.
fn shares(run: &Run) -> Vec<(String, f64, String)> {
    let Some(last) = run.samples.last().map(|s| &s.balance) else { return Vec::new() };
    let parts = [
        ("kinetic energy", last.kinetic_j),
        ("strain energy", last.strain_j),
        ("energy of the compressed water", last.water_j),
        ("taken by flow through the pores", last.darcy_dissipation_j),
        ("taken by damping", last.damping_loss_j),
    ];
    parts.map(|(what, energy)| (format!("{what}, of the work"), energy / last.external_work_j, "-".to_owned())).to_vec()
}

fn outcome(way: &Way, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut base = column(way)?;
    base = base.edited(fault)?;
    let on = |rows: usize, halvings: i32| {
        let scene = base.with_rows(rows)?;
        let step = way.share * stable_limit(&scene) / 2.0_f64.powi(halvings);
        Ok::<_, Error>(scene.edited(|s| s.step = StepChoice::Fixed(step))?)
    };
    let (mut errors, mut samples, mut notes) = (Vec::new(), Vec::new(), Vec::new());
    for halvings in 0..=way.halvings {
        let scene = on(ROWS[0], halvings)?;
        let StepChoice::Fixed(step) = scene.step else { continue };
        let run = finished(&scene)?;
        let found = looks(&run);
        errors.push((step, found.error()));
        (samples, notes) = (found.samples(), shares(&run));
    }
    let meshes = ROWS.map(|rows| {
        let scene = on(rows, 0)?;
        Ok((scene.cell, looks(&finished(&scene)?).error()))
    });
    let meshes = meshes.into_iter().collect::<Result<_, Error>>()?;
    let with = |count: &usize| {
        Ok((*count as f64, looks(&finished(&on(ROWS[0], 0)?.edited(|s| s.particles_per_cell = *count)?)?).error()))
    };
    let counted = PARTICLE_COUNTS.iter().map(with).collect::<Result<_, Error>>()?;
    let [meshes, counted] = [
        Refinement::new(MESH, meshes, "the work, at the same share of the stable step on every mesh"),
        // FLIP's loss goes with 1 - S, which falls with the particles.
        Refinement {
            required_error: Some(way.most),
            ..Refinement::new(PARTICLES, counted, "the work, in the first step")
        },
    ];
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: way.required_error,
        required_order: FIRST_ORDER,
        refined_by: STEP,
        samples,
        notes,
        refinements: vec![meshes, counted],
        ..Outcome::default()
    })
}

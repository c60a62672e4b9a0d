//! A dry bar on a fixed base that swings in its first mode: its period, its energy under FLIP, and what PIC takes from
//! it.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given};
use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{Fields, Scene, ShapeChoice, StepChoice, TransferChoice, Until};
use mpm_core::stability::{choose_step, shortest_transfer};

use super::{Error, Lacks, Mutant, Outcome, Program, finished_given, integrator, scheme};
use super::{FIRST_ORDER, HALVINGS, PARTICLE_COUNTS};
use crate::experiment::comparison::{Compared, Comparison, in_particles, in_time};
use crate::experiment::refinement::{PARTICLES, Refinement, STEP, Sampled};

/// Displacement of the top over five swings.
pub const PERIOD: Program = Program {
    name: "bar-period",
    about: "a bar in its first mode: displacement of the top over five swings, order 2",
    run: || period(1.0),
    mutant: Some(Mutant { what: "skeleton 5 % too stiff", run: || period(1.05) }),
};

/// Energy under FLIP.
pub const ENERGY: Program = Program {
    name: "bar-energy",
    about: "the same over 50 swings with FLIP: rate at which the energy is lost, (1 - S) w^2 dt",
    run: || energy(1.0),
    mutant: Some(Mutant { what: "a thousandth of PIC", run: || energy(0.999) }),
};

/// Energy under PIC.
pub const PIC: Program = Program {
    name: "bar-pic",
    about: "the same with PIC: rate at which the energy is lost, (1 - S)/dt",
    run: || pic(0.0),
    mutant: Some(Mutant { what: "a tenth of FLIP", run: || pic(0.1) }),
};

/// Swings over which energy is kept, and looks at each.
const SWINGS: u32 = 50;
const EACH: u32 = 16;
/// What carries velocities, for the curves: name, affine or not, share of FLIP.
const KEPT: [(&str, TransferChoice, f64); 4] = [
    ("FLIP", TransferChoice::Plain, 1.0),
    ("99 % FLIP", TransferChoice::Plain, 0.99),
    ("PIC", TransferChoice::Plain, 0.0),
    ("affine FLIP", TransferChoice::Affine, 1.0),
];
/// Largest speed, m/s: strains of 1e-5.
const SPEED: f64 = 1e-3;

/// The bar, and its angular frequency, rad/s.
fn bar() -> Result<(Scene, f64), Error> {
    let scene = crate::scenes::built_in("dry-bar")?
        .edited(|scene| (scene.surcharge, scene.history, scene.stages[0].damping) = (None, 0, 0.0))?;
    let frequency = FRAC_PI_2 / scene.height * (scene.oedometer_modulus() / scene.mixture_density()).sqrt();
    Ok((scene, frequency))
}

/// Comparison at a number of swings, so many times each.
fn look(scene: &mut Fields, frequency: f64, swings: u32, each: u32) {
    let end = f64::from(swings) * 2.0 * PI / frequency;
    scene.observe_times = (1..=swings * each).map(|i| end * f64::from(i) / f64::from(swings * each)).collect();
    scene.stages[0].until = Until::Time(end);
}

/// Upward velocities of the first mode, of half a step before.
fn mode(height: f64, frequency: f64, dt: f64) -> Given {
    let speed = SPEED * (0.5 * frequency * dt).cos();
    let at = move |[_, y]: [f64; 2]| FirstState {
        velocity: [0.0, speed * (FRAC_PI_2 * y / height).sin()],
        ..FirstState::default()
    };
    Given { start: Some(Arc::new(at)), ..Given::default() }
}

/// The largest allowed step of which whole numbers lie between the looks, s: a shorter one before each would not be a
/// step of theory.
fn step(scene: &Scene) -> Result<f64, Error> {
    match scene.step {
        StepChoice::Fixed(step) => Ok(step),
        StepChoice::Auto | StepChoice::Paper => {
            let between = scene.observe_times.first().copied().ok_or(Lacks("time to look at"))?;
            Ok(between / (between / choose_step(scene)?).ceil())
        }
    }
}

/// Runs the bar in these steps from its first mode.
fn swings(scene: &Scene, frequency: f64) -> Result<Run, Error> {
    let dt = step(scene)?;
    finished_given(&scene.edited(|s| s.step = StepChoice::Fixed(dt))?, &mode(scene.height, frequency, dt))
}

fn period(stiffer: f64) -> Result<Outcome, Error> {
    let (mut base, frequency) = bar()?;
    base = base.edited(|base| {
        look(base, frequency, 5, 8);
        base.elastic.youngs_modulus *= stiffer;
    })?;
    let looks = |scene: &Scene| {
        let run = swings(scene, frequency)?;
        let exact = |t: f64| -(frequency * t).sin();
        let look =
            |s: &Sample| Compared::one(s.stage_time, s.state.settlement * frequency / SPEED, exact(s.stage_time));
        Ok::<_, Error>(Comparison::worst("settlement over the amplitude", run.observed().map(look).collect()))
    };
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for rows in [10, 14, 20, 28, 40] {
        let scene = base.with_rows(rows)?;
        let found = looks(&scene)?;
        errors.push((scene.cell, found.error()));
        samples = found.samples();
    }
    let coarse = base.with_rows(10)?;
    let stepped = |dt| looks(&coarse.edited(|s| s.step = StepChoice::Fixed(dt))?);
    let with = |count| looks(&coarse.edited(|s| s.particles_per_cell = count)?);
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1e-2,
        required_order: Some(2.0),
        samples,
        refinements: vec![
            // What FLIP takes, (1 - S) w^2 dt, is of first order in the step, the period of second.
            in_time(stepped, coarse.cell, step(&coarse)?, HALVINGS, Some(1.0))?,
            in_particles(with, coarse.cell, &PARTICLE_COUNTS, 0.2)?,
        ],
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

/// Stored and moving energy at the looks, J, with the first at t = 0.
fn energies(scene: &Scene, frequency: f64) -> Result<Vec<f64>, Error> {
    let run = swings(scene, frequency)?;
    Ok(run.samples.iter().map(|s| s.balance.kinetic_j + s.balance.strain_j).collect())
}

/// Sums of the energies over every swing. Velocities are half a step ahead of the stresses, so that the energy itself
/// swings twice a period, and its means do not.
fn by_swing(scene: &Scene, frequency: f64) -> Result<Vec<f64>, Error> {
    Ok(energies(scene, frequency)?[1..].chunks(EACH as usize).map(|swing| swing.iter().sum()).collect())
}

/// Particles keep the whole change of velocity of a node, whose own velocity then changes by the share S of it (see
/// [`pic`]): soil is strained by `(1 - S) dt a` more than it moves, which is a viscosity. The mode loses energy at the
/// rate `(1 - S) w^2 dt`, a share of 1e-5 to 1e-4 in a swing.
fn energy(flip: f64) -> Result<Outcome, Error> {
    let (mut base, frequency) = bar()?;
    base = base.edited(|base| {
        look(base, frequency, SWINGS, EACH);
        base.flip = flip;
    })?;
    let mut notes = Vec::new();
    let mut kept = Vec::new();
    let theory = |scene: &Scene| Ok::<_, Error>((1.0 - transfer(scene)) * frequency * frequency * step(scene)?);
    let rate =
        |swings: &[f64]| (swings[0] / swings[swings.len() - 1]).ln() * frequency / (2.0 * PI * f64::from(SWINGS - 1));
    let mut lost = |shape: ShapeChoice, rows: usize| {
        let scene = base.with_rows(rows)?.edited(|s| s.shape = shape)?;
        let swings = by_swing(&scene, frequency)?;
        let in_a_swing = 1.0 - (-rate(&swings) * 2.0 * PI / frequency).exp();
        notes.push((format!("{}, {rows} cells, loses in a swing", scheme(&scene)), in_a_swing, "-".to_owned()));
        let theory = theory(&scene)?;
        if shape == ShapeChoice::Centre {
            kept = swings
                .iter()
                .enumerate()
                .map(|(swing, energy)| left(swing, energy / swings[0], frequency, theory))
                .collect();
        }
        Ok::<_, Error>((scene.cell, rate(&swings) / theory - 1.0))
    };
    let errors =
        [10, 14, 20, 28, 40].map(|rows| lost(ShapeChoice::Centre, rows)).into_iter().collect::<Result<_, _>>()?;
    for shape in [ShapeChoice::Linear, ShapeChoice::Gimp, ShapeChoice::Bspline2] {
        lost(shape, 20)?;
    }
    let mut samples: Vec<Sampled> = kept;
    let coarse = base.with_rows(10)?;
    let stepped = |halvings: i32| {
        let dt = step(&coarse)? / 2.0_f64.powi(halvings);
        Ok((dt, rate(&by_swing(&coarse.edited(|s| s.step = StepChoice::Fixed(dt))?, frequency)?) / frequency))
    };
    let in_time = (0..HALVINGS as i32).map(stepped).collect::<Result<_, Error>>()?;
    let against = "a bar that loses no energy: the rate over w, (1 - S) w dt, L = 0.1 m";
    let in_time = Refinement { required_order: FIRST_ORDER, ..Refinement::new(STEP, in_time, against) };
    let with = |count: &usize| {
        let scene = coarse.edited(|s| s.particles_per_cell = *count)?;
        Ok((*count as f64, rate(&by_swing(&scene, frequency)?) / theory(&scene)? - 1.0))
    };
    let counted = PARTICLE_COUNTS.iter().map(with).collect::<Result<_, Error>>()?;
    let against = "the rate of theory, L = 0.1 m: S knows the particles, no order is expected";
    let counted = Refinement { required_error: Some(5e-3), ..Refinement::new(PARTICLES, counted, against) };
    for (name, transfer, flip) in KEPT {
        let scene = base.with_rows(20)?.edited(|s| {
            s.transfer = transfer;
            s.flip = flip;
        })?;
        let swings = by_swing(&scene, frequency)?;
        samples.extend(swings.iter().enumerate().map(|(swing, energy)| Sampled {
            quantity: format!("energy, {name}"),
            unit: "-".to_owned(),
            time: (swing as f64 + 0.5) * 2.0 * PI / frequency,
            factor: None,
            computed: energy / swings[0],
            exact: 1.0,
            error: energy / swings[0] - 1.0,
            counts: false,
        }));
    }
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1e-3,
        // Theory leaves out what is smaller by (w dt)^2.
        required_order: Some(2.0),
        notes,
        samples,
        refinements: vec![in_time, counted],
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

/// The energy that theory leaves of that of the first swing, beside what is left.
fn left(swing: usize, computed: f64, frequency: f64, rate: f64) -> Sampled {
    let time = 2.0 * PI / frequency * swing as f64;
    Sampled {
        quantity: "energy of a swing over that of the first".to_owned(),
        unit: "-".to_owned(),
        time,
        factor: None,
        computed,
        exact: (-rate * time).exp(),
        error: computed - (-rate * time).exp(),
        counts: true,
    }
}

/// S of the first mode.
fn transfer(scene: &Scene) -> f64 {
    let theta = FRAC_PI_2 * scene.cell / scene.height;
    1.0 - (1.0 - shortest_transfer(scene.particles_per_direction())) * (0.5 * theta).sin().powi(2)
}

/// A node gets the mean velocity around it: of a wave with the angle theta from node to node the share `S = 1 - (1 -
/// S_0) sin^2(theta/2)` is left (`mpm_core::stability`), so that the mode loses energy at the rate (1 - S)/dt.
fn pic(flip: f64) -> Result<Outcome, Error> {
    let (mut base, frequency) = bar()?;
    base = base.edited(|base| {
        look(base, frequency, 1, 2);
        base.flip = 0.0;
    })?;
    // Error of the rate after a whole swing, and the energies at the same phase before it.
    let on = |scene: &Scene| {
        let dt = step(scene)?;
        let energies = energies(&scene.edited(|s| s.flip = flip)?, frequency)?;
        let theory = (1.0 - transfer(scene)) / dt;
        let shares = scene.observe_times.iter().zip(&energies[1..]);
        let looks = shares.map(|(t, energy)| Compared::one(*t, energy / energies[0], (-theory * t).exp())).collect();
        let measured = (energies[0] / energies[2]).ln() / scene.observe_times[1];
        Ok::<_, Error>((measured / theory - 1.0, Comparison::worst("energy of the first", looks)))
    };
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for rows in [10, 14, 20, 28, 40] {
        let scene = base.with_rows(rows)?;
        let (error, looks) = on(&scene)?;
        errors.push((scene.cell, error));
        samples = looks.samples();
    }
    let fine = base.with_rows(40)?;
    let stepped = |halvings: i32| {
        let dt = step(&fine)? / 2.0_f64.powi(halvings);
        Ok((dt, on(&fine.edited(|s| s.step = StepChoice::Fixed(dt))?)?.0))
    };
    let in_time = (0..3).map(stepped).collect::<Result<_, Error>>()?;
    let with = |count: &usize| Ok((*count as f64, on(&fine.edited(|s| s.particles_per_cell = *count)?)?.0));
    let counted = PARTICLE_COUNTS.iter().map(with).collect::<Result<_, Error>>()?;
    let against = "the rate of theory, L = 0.025 m";
    let bounded = |by, errors| Refinement { required_error: Some(1e-3), ..Refinement::new(by, errors, against) };
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 5e-4,
        required_order: Some(2.0),
        samples,
        refinements: vec![bounded(STEP, in_time), bounded(PARTICLES, counted)],
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

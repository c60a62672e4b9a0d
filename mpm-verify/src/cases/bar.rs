//! A dry bar on a fixed base that swings in its first mode: its period, its energy under FLIP, and what PIC takes from it.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given};
use mpm_core::drive::Sample;
use mpm_core::scene::{Scene, ShapeChoice, TransferChoice, Until};
use mpm_core::stability::{choose_step, shortest_transfer};

use super::evidence::Sampled;
use super::{Mutant, Outcome, Rung, finished_given, integrator, scheme, with_rows};
use crate::norms::largest;

/// Displacement of the top over five swings.
pub const PERIOD: Rung = Rung {
    name: "bar-period",
    about: "a bar in its first mode: displacement of the top over five swings, order 2",
    climb: || period(1.0),
    mutant: Some(Mutant { what: "skeleton 5 % too stiff", climb: || period(1.05) }),
};

/// Energy under FLIP.
pub const ENERGY: Rung = Rung {
    name: "bar-energy",
    about: "the same over 50 swings with FLIP: rate at which the energy is lost, (1 - S) w^2 dt",
    climb: || energy(1.0),
    mutant: Some(Mutant { what: "a thousandth of PIC", climb: || energy(0.999) }),
};

/// Energy under PIC.
pub const PIC: Rung = Rung {
    name: "bar-pic",
    about: "the same with PIC: rate at which the energy is lost, (1 - S)/dt",
    climb: || pic(0.0),
    mutant: Some(Mutant { what: "a tenth of FLIP", climb: || pic(0.1) }),
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
fn bar() -> Result<(Scene, f64), String> {
    let mut scene = crate::scenes::built_in("dry-bar").ok_or("no such scene")?.map_err(|e| e.to_string())?;
    (scene.surcharge, scene.history, scene.stages[0].damping) = (None, 0, 0.0);
    let frequency = FRAC_PI_2 / scene.height * (scene.oedometer_modulus() / scene.mixture_density()).sqrt();
    Ok((scene, frequency))
}

/// Looks at a number of swings, so many times each.
fn look(scene: &mut Scene, frequency: f64, swings: u32, each: u32) {
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

fn step(scene: &Scene) -> Result<f64, String> {
    choose_step(scene).map_err(|e| e.to_string())
}

fn period(stiffer: f64) -> Result<Outcome, String> {
    let (mut base, frequency) = bar()?;
    look(&mut base, frequency, 5, 8);
    base.elastic.youngs_modulus *= stiffer;
    let on = |rows: &usize| {
        let scene = with_rows(base.clone(), *rows);
        let run = finished_given(&scene, &mode(scene.height, frequency, step(&scene)?))?;
        let exact = |t: f64| -SPEED / frequency * (frequency * t).sin();
        let off = |s: &Sample| (s.state.settlement - exact(s.stage_time)) * frequency / SPEED;
        Ok((scene.cell, largest(run.observed().map(off))))
    };
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors: [10, 20, 40].iter().map(on).collect::<Result<_, String>>()?,
        required_error: 1e-2,
        required_order: Some([1.8, 2.2]),
        ..Outcome::default()
    })
}

/// Stored and moving energy at the looks, J, with the first at t = 0.
fn energies(scene: &Scene, frequency: f64) -> Result<Vec<f64>, String> {
    let run = finished_given(scene, &mode(scene.height, frequency, step(scene)?))?;
    Ok(run.samples.iter().map(|s| s.ledger.kinetic_j + s.ledger.strain_j).collect())
}

/// Sums of the energies over every swing. Velocities are half a step ahead of the stresses, so that the energy itself swings
/// twice a period, and its means do not.
fn by_swing(scene: &Scene, frequency: f64) -> Result<Vec<f64>, String> {
    Ok(energies(scene, frequency)?[1..].chunks(EACH as usize).map(|swing| swing.iter().sum()).collect())
}

/// Particles keep the whole change of velocity of a node, whose own velocity then changes by the share S of it (see [`pic`]):
/// soil is strained by `(1 - S) dt a` more than it moves, which is a viscosity. The mode loses energy at the rate
/// `(1 - S) w^2 dt`, a share of 1e-5 to 1e-4 in a swing.
fn energy(flip: f64) -> Result<Outcome, String> {
    let (mut base, frequency) = bar()?;
    look(&mut base, frequency, SWINGS, EACH);
    base.flip = flip;
    let mut notes = Vec::new();
    let mut lost = |shape: ShapeChoice, rows: usize| {
        let scene = Scene { shape, ..with_rows(base.clone(), rows) };
        let swings = by_swing(&scene, frequency)?;
        let (first, last) = (swings[0], swings[swings.len() - 1]);
        let time = f64::from(SWINGS - 1) * 2.0 * PI / frequency;
        notes.push((
            format!("{}, {rows} cells, loses in a swing", scheme(&scene)),
            1.0 - (last / first).powf(1.0 / f64::from(SWINGS - 1)),
            "-".to_owned(),
        ));
        let theory = (1.0 - transfer(&scene)) * frequency * frequency * step(&scene)?;
        Ok::<_, String>((scene.cell, (first / last).ln() / time / theory - 1.0))
    };
    let errors = [10, 20, 40].map(|rows| lost(ShapeChoice::Centre, rows)).into_iter().collect::<Result<_, _>>()?;
    for shape in [ShapeChoice::Linear, ShapeChoice::Gimp, ShapeChoice::Bspline2] {
        lost(shape, 20)?;
    }
    let mut samples = Vec::new();
    for (name, transfer, flip) in KEPT {
        let scene = Scene { transfer, flip, ..with_rows(base.clone(), 20) };
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
        required_error: 5e-2,
        notes,
        samples,
        ..Outcome::default()
    })
}

/// S of the first mode.
fn transfer(scene: &Scene) -> f64 {
    let theta = FRAC_PI_2 * scene.cell / scene.height;
    1.0 - (1.0 - shortest_transfer(scene.particles_per_direction())) * (0.5 * theta).sin().powi(2)
}

/// A node gets the mean velocity around it: of a wave with the angle theta from node to node the share
/// `S = 1 - (1 - S_0) sin^2(theta/2)` is left (`mpm_core::stability`), so that the mode loses energy at the rate (1 - S)/dt.
fn pic(flip: f64) -> Result<Outcome, String> {
    let (mut base, frequency) = bar()?;
    look(&mut base, frequency, 1, 1);
    base.flip = 0.0;
    let on = |rows: &usize| {
        let scene = with_rows(base.clone(), *rows);
        let dt = step(&scene)?;
        let energies = energies(&Scene { flip, ..scene.clone() }, frequency)?;
        let measured = (energies[0] / energies[1]).ln() / scene.observe_times[0];
        Ok((scene.cell, measured * dt / (1.0 - transfer(&scene)) - 1.0))
    };
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors: [10, 20, 40].iter().map(on).collect::<Result<_, String>>()?,
        required_error: 2e-2,
        ..Outcome::default()
    })
}

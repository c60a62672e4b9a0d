//! Given starts, and stages that drain and hold other sides than those before.

use std::f64::consts::PI;

use mpm_core::scene::{Fields, Integrator, Scene, ShapeChoice, Side};

use super::features::{explicit, quasi_static, softer};
use super::setup::{Measured, Setup, case, refined};
use super::{FASTER, Program, Unfit, faster, sound};
use crate::norms::largest;

/// Second order: the square of a cell over the height, on the finest mesh.
const TRIANGLE: Setup = Setup {
    scene: "triangular-start",
    change: centre,
    mesh: refined,
    measure: by_modes,
    cells: &[10.0, 14.0, 20.0],
    required: 2.5e-3,
    order: None,
};
const STAGES: Setup = Setup { scene: "drainage-in-stages", ..TRIANGLE };
const RELEASED: Setup = Setup {
    scene: "released-side",
    change: sound,
    mesh: refined,
    measure: released,
    cells: &[4.0],
    required: 1e-9,
    order: None,
};

/// All of them.
pub const CASES: [Program; 8] = [
    case!(
        "given-start",
        "a column from a pressure that is linear over its height: quasi-static, B-splines",
        FASTER,
        faster,
        Setup {
            change: quasi_static,
            cells: &[10.0, 14.0, 20.0, 28.0],
            required: 1e-5,
            order: Some([3.0, 5.0]),
            ..TRIANGLE
        }
    ),
    case!(
        "given-start-centre",
        "the same with values at the centre and flow through faces: order 2",
        FASTER,
        faster,
        Setup { cells: &[10.0, 14.0, 20.0, 28.0], order: Some([1.7, 2.3]), ..TRIANGLE }
    ),
    case!(
        "given-start-semi-implicit",
        "the same semi-implicit",
        FASTER,
        faster,
        Setup { change: semi_implicit, ..TRIANGLE }
    ),
    case!("given-start-explicit", "the same explicit", FASTER, faster, Setup { change: explicit, ..TRIANGLE }),
    case!(
        "drainage-in-stages",
        "a column that drains at its top, at both ends, and is shut in: quasi-static, B-splines",
        TIGHT,
        tight,
        Setup { change: quasi_static, required: 1e-5, order: None, ..STAGES }
    ),
    case!("drainage-in-stages-explicit", "the same explicit", TIGHT, tight, Setup { change: explicit, ..STAGES }),
    case!("released-side", "a block under a horizontal stress loses a wall", "E 5 % too low", softer, RELEASED),
    case!(
        "released-side-explicit",
        "the same explicit and damped",
        HELD,
        wall_stays,
        Setup { change: damped_release, required: 1e-3, ..RELEASED }
    ),
];

const TIGHT: &str = "the base drains in no stage";
const HELD: &str = "the wall stays";

fn tight(scene: &mut Fields) {
    scene.stages.iter_mut().for_each(|stage| stage.drained[Side::Bottom as usize] = false);
}

fn wall_stays(scene: &mut Fields) {
    scene.stages.iter_mut().for_each(|stage| stage.solid_sides = None);
}

fn centre(scene: &mut Fields) {
    (scene.shape, scene.darcy_inertia) = (ShapeChoice::Centre, false);
}

fn semi_implicit(scene: &mut Fields) {
    explicit(scene);
    scene.integrator = Integrator::SemiImplicit;
}

fn damped_release(scene: &mut Fields) {
    explicit(scene);
    scene.stages.iter_mut().for_each(|stage| stage.damping = 200.0);
}

/// Points over the height, and modes, of a pressure.
const POINTS: u32 = 4000;
const MODES: u32 = 300;

/// Settlement over that of all pressure, at all samples: of a column that starts from a pressure and is under a constant total stress.
/// In every stage the pressure is a sum of the modes of its drained ends.
fn by_modes(scene: &Scene) -> Measured {
    let (initial, water) = (scene.initial.clone().ok_or(Unfit("no given state"))?, scene.water.ok_or(Unfit("dry"))?);
    let (height, modulus, stages) = (scene.height, scene.oedometer_modulus(), scene.stages.clone());
    let coefficient = water.mobility() / scene.storage() / (height * height);
    let mean = |p: &[f64]| p.iter().sum::<f64>() / p.len() as f64;
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(POINTS);
    // p after a time, from p before it.
    let after = move |p: &[f64], drained: [bool; 4], time: f64| {
        let mut now = vec![0.0; p.len()];
        for k in 0..MODES {
            let k = f64::from(k);
            let (number, shift) = match (drained[Side::Bottom as usize], drained[Side::Top as usize]) {
                (false, true) => (k + 0.5, 0.0),
                (true, true) => (k + 1.0, 0.5),
                (false, false) => (k, 0.0),
                (true, false) => (k + 0.5, 0.5),
            };
            let mode: Vec<f64> = (0..POINTS).map(|i| (PI * (number * at(i) - shift)).cos()).collect();
            let share = if number == 0.0 { 1.0 } else { 2.0 };
            let amount = share * mode.iter().zip(p).map(|(m, p)| m * p).sum::<f64>() / p.len() as f64;
            let decay = (-coefficient * time * (PI * number).powi(2)).exp();
            now.iter_mut().zip(&mode).for_each(|(now, m)| *now += amount * decay * m);
        }
        now
    };
    Ok(Box::new(move |run| {
        let mut p: Vec<f64> = (0..POINTS).map(|i| initial.at(&[0.0, height * at(i)])[0]).collect();
        let whole = mean(&p);
        let mut off = Vec::new();
        for (number, stage) in stages.iter().enumerate() {
            let mut now = Vec::new();
            for sample in run.samples.iter().filter(|s| s.stage == number && s.stage_time > 0.0) {
                now = after(&p, stage.drained, sample.stage_time);
                off.push(sample.state.settlement * modulus / (whole * height) - (1.0 - mean(&now) / whole));
            }
            p = now;
        }
        largest(off.into_iter())
    }))
}

/// How thin a block gets whose wall is taken away against `nu (1 + nu)/E s H`, or where its particles move how wide against
/// `(1 - nu^2)/E s W`: nothing else presses it. Before, nothing moves.
fn released(scene: &Scene) -> Measured {
    let stress = -scene.initial.as_ref().ok_or(Unfit("no given state"))?.at(&[0.0, 0.0])[1];
    let (e, nu) = (scene.elastic.youngs_modulus, scene.elastic.poisson_ratio);
    let thinner = stress * nu * (1.0 + nu) / e * scene.height;
    let (wider, first) = (stress * (1.0 - nu * nu) / e, scene.width - 0.5 * scene.spacing());
    let moves = scene.integrator != Integrator::QuasiStatic;
    Ok(Box::new(move |run| {
        let before = run.samples.iter().filter(|s| s.stage == 0).map(|s| s.state.settlement / thinner);
        let last = run.observed().last().map_or(f64::NAN, |s| s.state.settlement / thinner);
        let reached = largest(run.places.solid.iter().map(|place| place[0]));
        let last = if moves { (reached / first - 1.0) / wider } else { last };
        largest(before.chain([last - 1.0]))
    }))
}

#[cfg(test)]
mod tests {
    use super::super::setup::hold_and_find_their_faults;
    use super::*;

    #[test]
    fn all_hold_and_find_their_faults() {
        hold_and_find_their_faults(&CASES);
    }
}

//! The pattern that reduced integration does not feel, provoked: velocities that alternate from node to node.
//!
//! A cell whose gradients are taken at its centre has no strain in it, so nothing turns the motion back and it drifts
//! through the soil for ever. Integrated at the Gauss points a square cell of bilinear functions resists each hourglass
//! with the stiffness `(M + G)/3` per its mass (Flanagan & Belytschko 1981, Int. J. Numer. Methods Eng. 17), four cells at a
//! node: `omega^2 = 4 (M + G)/(3 rho L^2)`; the mode swings then with an amplitude V/omega.

use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given};
use mpm_core::hardware::Hardware;
use mpm_core::observe::SolidState;
use mpm_core::run::model_given;
use mpm_core::scene::{Dimension, Scene, SolidSide};
use mpm_core::stability::stable_limit;

use super::case::{Case, Point};
use super::scheme::{DRY, Scheme};
use crate::error::Error;

/// The case.
pub const CASE: Case = Case {
    name: "hourglass",
    about: "a dry block of 6 by 6 cells starts with the velocities of its hourglass mode: how far the mode goes over how far \
            a fully integrated cell lets it go, the largest so far",
    why: "Gradients at the centre of a cell do not see the mode. B-bar takes the mean of the change of volume only, \
          and resists it by shear: the usual shape in plane strain.",
    parameter: "time (swings)",
    column: "swings",
    dimension: Dimension::PlaneStrain,
    measures: "displacement in the mode, over V/omega",
    holds: 3.0,
    breaks: 30.0,
    schemes: &DRY,
    run: |scheme| drift(scheme, 1.0),
};

const SIDE: usize = 6;
const EDGE: f64 = 0.1;
/// Times at which the largest displacement so far is noted, in swings of a fully integrated cell.
const SWINGS: [f64; 6] = [0.25, 1.0, 3.0, 10.0, 30.0, 100.0];
/// V/omega over the edge of a cell.
const SMALL: f64 = 1e-5;

fn drift(scheme: &Scheme, share: f64) -> Vec<Point> {
    Point::along(&SWINGS, |points| follow(scheme, share, points))
}

/// A zigzag of period two cells: 1 at even nodes, -1 at odd ones.
fn zigzag(x: f64) -> f64 {
    let place = (x / EDGE).rem_euclid(2.0);
    1.0 - 2.0 * (1.0 - (place - 1.0).abs())
}

fn mode(x: [f64; 2]) -> f64 {
    zigzag(x[0]) * zigzag(x[1])
}

fn follow(scheme: &Scheme, share: f64, points: &mut Vec<Point>) -> Result<(), Error> {
    let scene = crate::scenes::built_in("dry-bar")?.edited(|scene| {
        scene.dimension = Dimension::PlaneStrain;
        (scene.cell, scene.cells) = (EDGE, [SIDE; 2]);
        (scene.width, scene.height) = (EDGE * SIDE as f64, EDGE * SIDE as f64);
        scene.solid_sides = [SolidSide::Free; 4];
        (scene.surcharge, scene.gravity, scene.history) = (None, None, 0);
        scene.stages[0].damping = 0.0;
    })?;
    let scene: Scene = scheme.on(&scene)?;
    let stiffness = scene.oedometer_modulus() + scene.elastic.shear_modulus();
    let omega = (4.0 * stiffness / (3.0 * scene.dry_density())).sqrt() / EDGE;
    let speed = SMALL * EDGE * omega;
    let first = move |x: [f64; 2]| FirstState { velocity: [share * speed * mode(x), 0.0], ..FirstState::default() };
    let given = Given { start: Some(Arc::new(first)), ..Given::default() };
    let mut model = model_given(&Hardware::default(), &scene, &given)?;
    model.enter_stage(&scene.stages[0], &[f64::MAX])?;
    let mut start: Vec<SolidState> = model.particles();
    start.sort_by_key(|p| p.id);
    let weight: f64 = start.iter().map(|p| p.mass * mode(p.x).powi(2)).sum();
    let pause = std::f64::consts::TAU / omega / 8.0;
    let each = (pause / (scene.safety * stable_limit(&scene))).ceil();
    let dt = pause / each;
    let (mut worst, mut looks) = (0.0_f64, 0.0);
    for swings in SWINGS {
        while looks < 8.0 * swings {
            model.advance(dt, each as u64, &mut 0)?;
            looks += 1.0;
            let off = |p: &SolidState| {
                let before = &start[p.id as usize];
                p.mass * mode(before.x) * (p.x[0] - before.x[0])
            };
            let along = model.particles().iter().map(off).sum::<f64>() / weight * omega / speed;
            worst = if along.is_nan() { f64::NAN } else { worst.max(along.abs()) };
        }
        points.push(Point { at: swings, found: Ok(worst) });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::case::Verdict;
    use super::*;
    use mpm_core::scene::{Integrator, ShapeChoice};

    #[test]
    fn reduced_integration_drifts_and_b_bar_does_not() {
        let verdict = |shape: ShapeChoice| CASE.judge(&drift(&Scheme::new(Integrator::Explicit, shape), 1.0)).verdict;
        assert_eq!([ShapeChoice::Centre, ShapeChoice::BBar].map(verdict), [Verdict::Failed, Verdict::Passed]);
    }
}

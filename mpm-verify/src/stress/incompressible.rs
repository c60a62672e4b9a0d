//! A swing that changes no volume, in soil that is more and more incompressible: schemes that lock swing too fast.
//!
//! `u = (d psi/dy, -d psi/dx)`, psi = sin(pi x/W) sin(pi y/W), between smooth walls: a free vibration of shear alone, of the
//! frequency `omega^2 = 2 (pi/W)^2 G/rho` whatever Poisson's ratio is. With s = sin^2(k L/2), k = pi/W, the centre of a cell
//! sees `8 s (1 - s)/L^2` of `2 k^2`, and particles give back `(1 - 3 s/4)^2` of an acceleration (two per direction): omega is
//! 0.6 % too low on 24 cells.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given};
use mpm_core::hardware::Hardware;
use mpm_core::observe::SolidState;
use mpm_core::run::model_given;
use mpm_core::scene::{Dimension, Elastic, Scene, SolidSide, WaterProperties};
use mpm_core::stability::stable_limit;

use super::case::{Case, Point};
use super::scheme::{MOVING, Scheme};
use crate::error::Error::{self, Unfit};

/// The case.
pub const CASE: Case = Case {
    name: "incompressible",
    about: "a divergence-free vibration of saturated, undrained soil with a drained Poisson's ratio up to 0.4999, 24 cells \
            along a side: its frequency over three swings beside the exact one",
    why: "A drained skeleton that keeps its volume has the same trouble without any water: full integration locks \
          (linear, gimp), reduced integration, B-bar and B-splines do not. Remedy: b-bar, which also resists \
          hourglasses.",
    parameter: "0.5 - nu",
    column: "half_less_nu",
    dimension: Dimension::PlaneStrain,
    measures: "|omega/omega_exact - 1|",
    holds: 0.01,
    breaks: 0.2,
    schemes: &MOVING,
    run: |scheme| LESS.iter().map(|less| Point { at: *less, found: error(scheme, 0.5 - less, 1.0) }).collect(),
};

/// What Poisson's ratio lacks to a half.
const LESS: [f64; 5] = [0.2, 0.05, 0.01, 1e-3, 1e-4];
const SIDE: usize = 24;
/// Swings that are timed.
const SWINGS: f64 = 3.0;
/// Largest speed over that of shear waves: strains of 1e-5.
const SLOW: f64 = 1e-5;

fn square(scheme: &Scheme, poisson_ratio: f64) -> Result<Scene, Error> {
    let mut scene = crate::scenes::terzaghi();
    // The shear modulus is the same in all.
    let shear = scene.elastic.shear_modulus();
    scene = scene.edited(|scene| {
        scene.elastic = Elastic { youngs_modulus: 2.0 * (1.0 + poisson_ratio) * shear, poisson_ratio };
        scene.water = scene.water.map(|w| WaterProperties { hydraulic_conductivity: 1e-12, ..w });
        scene.solid_sides = [SolidSide::Roller; 4];
        (scene.dimension, scene.start, scene.surcharge, scene.history) =
            (Dimension::PlaneStrain, mpm_core::scene::Start::Unloaded, None, 0);
        (scene.width, scene.height) = (1.0, 1.0);
        (scene.cell, scene.cells) = (1.0 / SIDE as f64, [SIDE; 2]);
        scene.stages[0].drained = [false; 4];
    })?;
    scheme.on(&scene)
}

/// Change of the frequency, with the exact one taken `factor` times.
///
/// # Errors
/// A run that could not be finished, or does not swing.
fn error(scheme: &Scheme, poisson_ratio: f64, factor: f64) -> Result<f64, Error> {
    let scene = square(scheme, poisson_ratio)?;
    let wave = PI / scene.width;
    let speed = (scene.elastic.shear_modulus() / scene.mixture_density()).sqrt();
    let omega = factor * wave * 2.0_f64.sqrt() * speed;
    let shape = move |[x, y]: [f64; 2]| {
        let [(sx, cx), (sy, cy)] = [x, y].map(|x| (wave * x).sin_cos());
        [sx * cy, -cx * sy]
    };
    let first = move |x: [f64; 2]| FirstState { velocity: shape(x).map(|v| SLOW * speed * v), ..FirstState::default() };
    let given = Given { start: Some(Arc::new(first)), ..Given::default() };
    let mut model = model_given(&Hardware::default(), &scene, &given)?;
    model.enter_stage(&scene.stages[0], &[f64::MAX])?;
    let amplitude = |points: &[SolidState]| -> f64 {
        points.iter().map(|p| p.mass * (p.velocity[0] * shape(p.x)[0] + p.velocity[1] * shape(p.x)[1])).sum()
    };
    let looks = 40.0;
    let each = (TAU / omega / looks / (scene.safety * stable_limit(&scene))).ceil();
    let dt = TAU / omega / looks / each;
    let mut before = (0.0, amplitude(&model.particles()));
    let first = before.1;
    // The velocity goes through zero at odd quarters of a period; the last one tells the frequency best.
    let mut crossings: Vec<f64> = Vec::new();
    for look in 1..=(SWINGS * looks) as u64 {
        model.advance(dt, each as u64, &mut 0)?;
        let now = (look as f64 * each * dt, amplitude(&model.particles()) / first);
        if now.1 * before.1 < 0.0 {
            crossings.push(before.0 + (now.0 - before.0) * before.1 / (before.1 - now.1));
        }
        before = now;
        if now.1.is_nan() || now.1.abs() > 10.0 {
            return Err(Error::Found(format!("swing {:.1} times larger", now.1)));
        }
    }
    let (Some(last), count) = (crossings.last(), crossings.len() as f64) else {
        return Err(Unfit("does not swing"));
    };
    Ok(((count - 0.5) * PI / last / omega - 1.0).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::scene::{Integrator, ShapeChoice};

    #[test]
    fn a_wrong_frequency_is_seen() {
        let scheme = Scheme::new(Integrator::SemiImplicit, ShapeChoice::Centre);
        let right = error(&scheme, 0.3, 1.0).expect("a run");
        let wrong = error(&scheme, 0.3, 1.05).expect("a run");
        assert!(right < 0.01 && wrong > 0.03, "{right} {wrong}");
    }
}

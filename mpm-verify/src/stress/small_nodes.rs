//! Nodes with hardly any mass: an edge particle a hair beyond a face of the mesh, and one particle alone.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given};
use mpm_core::hardware::Hardware;
use mpm_core::observe::SolidState;
use mpm_core::run::model_given;
use mpm_core::scene::{Dimension, Scene, SolidSide};
use mpm_core::stability::stable_limit;

use super::case::{Case, Point};
use super::scheme::{DRY, Scheme};
use crate::error::Error::{self, Lacks, Unfit};

/// A bar that ends beside a face.
pub const EDGE: Case = Case {
    name: "edge-node",
    about: "a free elastic bar of 20 cells swings in its first mode; its last particles stand by less and less beyond a face, \
            so that the outermost node has down to 1e-12 of a particle's mass: energy after ten swings, and frequency",
    why: "A node with the share s of a particle swings 1/sqrt(s) times as fast as a full one: no step is short \
          enough. Nodes below a quarter of one particle follow a heavier neighbour (momentum is kept); uGIMP and \
          B-splines have gradients that vanish with their values. What is left is the energy that FLIP loses in ten \
          swings, and the kick of particles that swing across the face (1e-6).",
    parameter: "mass of the node, of a particle's",
    column: "mass_ratio",
    dimension: Dimension::Column,
    measures: "largest change of energy or frequency, share",
    holds: 0.1,
    breaks: 1.0,
    schemes: &DRY,
    run: |scheme| RATIOS.iter().map(|ratio| Point { at: *ratio, found: swing(scheme, *ratio, 0.0) }).collect(),
};

/// One particle.
pub const ALONE: Case = Case {
    name: "lone-particle",
    about: "one particle alone flies diagonally through up to 50 cells, stretched as it is: momentum and energy",
    why: "Its corner nodes may have any share of it. Light ones follow the heaviest, so that it flies as a whole.",
    parameter: "cells crossed",
    column: "cells",
    dimension: Dimension::PlaneStrain,
    measures: "largest change of momentum or gain of energy, share",
    holds: 1e-9,
    breaks: 0.2,
    schemes: &DRY,
    run: alone,
};

const RATIOS: [f64; 7] = [0.25, 1e-1, 1e-2, 1e-3, 1e-6, 1e-9, 1e-12];
const ROWS: usize = 20;
const SWINGS: f64 = 10.0;
/// Largest strain of the swing.
const STRAIN: f64 = 1e-6;

fn dry() -> Result<Scene, Error> {
    Ok(crate::scenes::built_in("dry-bar")?.edited(|scene| {
        scene.solid_sides[2..].fill(SolidSide::Free);
        (scene.surcharge, scene.gravity, scene.history) = (None, None, 0);
        scene.stages[0].damping = 0.0;
    })?)
}

/// The bar; its last particle gives this share of its mass to the node beyond, and loses `lost` of its energy by damping (1/s).
fn swing(scheme: &Scheme, ratio: f64, damping: f64) -> Result<f64, Error> {
    let scene = dry()?.edited(|scene| {
        (scene.cell, scene.cells) = (scene.height / ROWS as f64, [1, ROWS]);
        scene.empty_cells_above = 3;
        scene.stages[0].damping = damping;
    })?;
    let scene = scheme.on(&scene)?;
    // The last particle of the uppermost cell stands half a spacing below the top, and then `ratio` of a cell above it.
    let moved = scene.cell * (0.5 / scene.particles_per_direction() as f64 + ratio);
    let wave = PI / scene.height;
    let speed = (scene.oedometer_modulus() / scene.dry_density()).sqrt();
    let start = move |[_, y]: [f64; 2]| FirstState {
        velocity: [0.0, STRAIN * speed * (wave * (y - moved)).cos()],
        ..FirstState::default()
    };
    let given = Given { start: Some(Arc::new(start)), moved: [0.0, moved], ..Given::default() };
    let mut model = model_given(&Hardware::default(), &scene, &given)?;
    model.enter_stage(&scene.stages[0], &[f64::MAX])?;
    let energy = |model: &dyn mpm_core::step::Model| {
        let ledger = model.observe().1;
        ledger.kinetic_j + ledger.strain_j
    };
    let first = energy(model.as_ref());
    let amplitude = |points: &[SolidState]| -> f64 {
        points.iter().map(|p| p.mass * p.velocity[1] * (wave * (p.x[1] - moved)).cos()).sum()
    };
    let (looks, omega) = (40.0, wave * speed);
    let pause = TAU / omega / looks;
    let each = (pause / (scene.safety * stable_limit(&scene))).ceil();
    let dt = pause / each;
    let (mut worst, mut before, mut crossings) = (0.0_f64, (0.0, amplitude(&model.particles())), Vec::new());
    for look in 1..=(SWINGS * looks) as u64 {
        model.advance(dt, each as u64, &mut 0)?;
        let now = (look as f64 * pause, amplitude(&model.particles()));
        if now.1 * before.1 < 0.0 {
            crossings.push(before.0 + (now.0 - before.0) * before.1 / (before.1 - now.1));
        }
        before = now;
        let change = (energy(model.as_ref()) / first - 1.0).abs();
        worst = if change.is_nan() { f64::NAN } else { worst.max(change) };
        if worst.is_nan() || worst > 1e3 {
            return Ok(worst);
        }
    }
    let last = crossings.last().ok_or(Unfit("does not swing"))?;
    let frequency = (crossings.len() as f64 - 0.5) * PI / last / omega;
    Ok(worst.max((frequency - 1.0).abs()))
}

const CELLS: [f64; 3] = [1.0, 10.0, 50.0];

fn alone(scheme: &Scheme) -> Vec<Point> {
    Point::along(&CELLS, |points| fly(scheme, points))
}

fn fly(scheme: &Scheme, points: &mut Vec<Point>) -> Result<(), Error> {
    let edge = 0.1;
    // Room at the side, which no scene with functions as wide as some of these has.
    let scene = dry()?.altered_unchecked(|scene| {
        (scene.dimension, scene.solid_sides) = (Dimension::PlaneStrain, [SolidSide::Free; 4]);
        (scene.cell, scene.cells, scene.width, scene.height) = (edge, [1, 1], edge, edge);
        (scene.empty_cells_beside, scene.empty_cells_above) = (53, 43);
        scheme.put_on(scene);
        scene.particles_per_cell = 1;
        scene.light_nodes = scene.usual_light_nodes();
    });
    let wave = (scene.oedometer_modulus() / scene.dry_density()).sqrt();
    let velocity = [0.05 * wave, 0.04 * wave];
    let stress = 1e-6 * scene.oedometer_modulus();
    let start = move |_: [f64; 2]| FirstState { velocity, stress: [stress, stress, stress, 0.0], pressure: 0.0 };
    let moved = [0.6 * edge, 0.3 * edge];
    let given = Given { start: Some(Arc::new(start)), moved, ..Given::default() };
    let mut model = model_given(&Hardware::default(), &scene, &given)?;
    model.enter_stage(&scene.stages[0], &[f64::MAX])?;
    let pause = edge / velocity[0] / 3.3;
    let each = (pause / (scene.safety * stable_limit(&scene))).ceil();
    let dt = pause / each;
    let (mut worst, mut crossed) = (0.0_f64, 0.0);
    let first = model.observe().1;
    let energy = first.kinetic_j + first.strain_j;
    for cells in CELLS {
        while crossed < cells {
            model.advance(dt, each as u64, &mut 0)?;
            crossed += 1.0 / 3.3;
            let particle = model.particles().first().copied().ok_or(Lacks("particle"))?;
            let ledger = model.observe().1;
            let gain = (ledger.kinetic_j + ledger.strain_j) / energy - 1.0;
            let change = |d: usize| (particle.velocity[d] / velocity[d] - 1.0).abs();
            for off in [change(0), change(1), gain] {
                worst = if off.is_nan() { f64::NAN } else { worst.max(off) };
            }
        }
        points.push(Point { at: cells, found: Ok(worst) });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::case::Verdict;
    use super::*;
    use mpm_core::scene::{Integrator, ShapeChoice};

    #[test]
    fn lost_energy_is_seen_and_light_nodes_lose_little() {
        let scheme = Scheme::new(Integrator::Explicit, ShapeChoice::Centre);
        let sound = swing(&scheme, 1e-3, 0.0).expect("a run");
        let damped = swing(&scheme, 1e-3, 20.0).expect("a run");
        assert!(sound <= EDGE.holds && damped > 2.0 * EDGE.holds, "{sound} {damped}");
        assert_eq!(ALONE.judge(&alone(&scheme)).verdict, Verdict::Passed);
    }

    #[test]
    fn a_lone_particle_flies_with_wide_functions() {
        for scheme in DRY.iter().filter(|scheme| scheme.shape.is_wide()) {
            let found = ALONE.judge(&alone(scheme));
            assert_eq!(found.verdict, Verdict::Passed, "{scheme:?}: {}", found.reason);
        }
    }
}

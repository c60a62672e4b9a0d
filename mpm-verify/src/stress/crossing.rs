//! A stressed body that flies through a thousand cells and should not notice: the noise of its stress.
//!
//! A force per mass `-grad T/rho` that flies along balances a stress `T = S sin(pi X/h)` (a bar) or `T = S sin(pi X/w) sin(pi Y/h)`
//! on the diagonal (a block), free at all ends: nothing accelerates and no strain changes. Whatever the stress does is made
//! by particles that cross from cell to cell.

use std::f64::consts::PI;
use std::sync::Arc;

use mpm_core::boundary::{FirstState, ForceField, Given};
use mpm_core::hardware::Hardware;
use mpm_core::observe::SolidState;
use mpm_core::run::model_given;
use mpm_core::scene::{Dimension, Scene, SolidSide, Start};
use mpm_core::stability::stable_limit;

use super::case::{Case, Point};
use super::scheme::{DRY, Scheme};
use crate::error::Error;

/// One dimension.
pub const COLUMN: Case = Case {
    name: "crossing-column",
    about: "a stressed elastic bar of 20 cells that a force holds in balance flies through 1000 cells: RMS of its stress \
            beside the exact one, the largest so far",
    why: "A gradient that jumps at a face kicks every particle that crosses it, and nothing damps what that stirs in \
          dry elastic soil: the noise of linear functions grows without bound (a tenth of the stress after 100 \
          cells, six tenths after 300), and a run is stopped before. Functions with continuous gradients keep it \
          below a tenth for 1000 cells in one dimension. Affine velocities and MUSL do not help here.",
    parameter: "cells crossed",
    column: "cells",
    dimension: Dimension::Column,
    measures: "RMS of sigma - sigma_exact, share of the largest stress",
    holds: 0.1,
    breaks: 1.0,
    schemes: &DRY,
    run: |scheme| fly(scheme, Dimension::Column, 1.0),
};

/// Two.
pub const BLOCK: Case = Case {
    name: "crossing-block",
    about: "the same with a block of 8 by 8 cells in plane strain, which crosses 1000 cells to the right and 100 up",
    dimension: Dimension::PlaneStrain,
    run: |scheme| fly(scheme, Dimension::PlaneStrain, 1.0),
    ..COLUMN
};

/// Cells crossed at which the noise so far is noted.
const CELLS: [f64; 7] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];
/// Speed of flight over that of waves.
const SPEED: f64 = 0.1;
/// Largest stress over the oedometer modulus.
const STRAIN: f64 = 1e-6;
/// Comparison per cell; not a divisor of what particles do in a cell.
const LOOKS: f64 = 3.3;
const EDGE: f64 = 0.05;
/// Cells of a bar and of a side of the block; room for the last cells, too.
const BAR: usize = 20;
const SIDE: usize = 8;
const ROOM: [usize; 2] = [1000 + 3, 100 + 3];

fn body(scheme: &Scheme, dimension: Dimension) -> Result<Scene, Error> {
    let scene = crate::scenes::built_in("dry-bar")?;
    let bar = dimension == Dimension::Column;
    // Room at the side, which no scene with functions as wide as some of these has.
    Ok(scene.altered_unchecked(|scene| {
        scene.dimension = dimension;
        (scene.cell, scene.cells) = (EDGE, if bar { [1, BAR] } else { [SIDE; 2] });
        (scene.width, scene.height) = (EDGE * scene.cells[0] as f64, EDGE * scene.cells[1] as f64);
        (scene.empty_cells_beside, scene.empty_cells_above) = if bar { (0, ROOM[0]) } else { (ROOM[0], ROOM[1]) };
        scene.solid_sides = [SolidSide::Free; 4];
        (scene.surcharge, scene.gravity, scene.start, scene.history) = (None, None, Start::Unloaded, 0);
        scene.stages[0].damping = 0.0;
        scheme.put_on(scene);
    }))
}

/// Velocity of flight, m/s.
fn flight(scene: &Scene) -> [f64; 2] {
    let speed = SPEED * (scene.oedometer_modulus() / scene.dry_density()).sqrt();
    if scene.dimension == Dimension::Column { [0.0, speed] } else { [speed, 0.1 * speed] }
}

/// Points of a flight under `share` of the force that balances it.
fn fly(scheme: &Scheme, dimension: Dimension, share: f64) -> Vec<Point> {
    let flight = |points: &mut Vec<Point>| noise(&body(scheme, dimension)?, share, points);
    Point::along(&CELLS, flight)
}

fn noise(scene: &Scene, share: f64, points: &mut Vec<Point>) -> Result<(), Error> {
    let velocity = flight(scene);
    // It starts off its cells, so that no particle stands on a face.
    let moved = [0.37 * EDGE, 0.41 * EDGE];
    let bar = scene.dimension == Dimension::Column;
    let moved = if bar { [0.0, moved[1]] } else { moved };
    let largest = STRAIN * scene.oedometer_modulus();
    let wave = [PI / scene.width, PI / scene.height];
    // Sines and cosines of the place in the body at a time; a bar has no x.
    let phases = move |x: [f64; 2], t: f64| {
        let place = |d: usize| (wave[d] * (x[d] - moved[d] - velocity[d] * t)).sin_cos();
        [if bar { (1.0, 0.0) } else { place(0) }, place(1)]
    };
    let tension = move |x: [f64; 2], t: f64| {
        let [(sx, _), (sy, _)] = phases(x, t);
        largest * sx * sy
    };
    let density = scene.dry_density();
    let force: ForceField = Arc::new(move |x, t| {
        let [(sx, cx), (sy, cy)] = phases(x, t);
        [-share * largest * wave[0] * cx * sy / density, -share * largest * wave[1] * sx * cy / density]
    });
    let first = move |x: [f64; 2]| FirstState {
        velocity,
        stress: [tension(x, 0.0), tension(x, 0.0), tension(x, 0.0), 0.0],
        pressure: 0.0,
    };
    let given = Given { start: Some(Arc::new(first)), force: Some(force), moved };
    let mut model = model_given(&Hardware::default(), scene, &given)?;
    model.enter_stage(&scene.stages[0], &[f64::MAX])?;
    let fast = if bar { velocity[1] } else { velocity[0] };
    let pause = EDGE / fast / LOOKS;
    let each = (pause / (scene.safety * stable_limit(scene))).ceil();
    let dt = pause / each;
    let (mut worst, mut crossed) = (0.0_f64, 0.0);
    for cells in CELLS {
        while crossed < cells {
            model.advance(dt, each as u64, &mut 0)?;
            crossed += 1.0 / LOOKS;
            let time = model.time();
            let off = |p: &SolidState| {
                let exact = tension(p.x, time);
                let across = if bar { 0.0 } else { p.stress[0] - exact };
                p.volume * (across.powi(2) + (p.stress[1] - exact).powi(2)) / if bar { 1.0 } else { 2.0 }
            };
            let particles = model.particles();
            let volume: f64 = particles.iter().map(|p| p.volume).sum();
            let rms = (particles.iter().map(off).sum::<f64>() / volume).sqrt() / largest;
            worst = if rms.is_nan() { f64::NAN } else { worst.max(rms) };
        }
        points.push(Point { at: cells, found: Ok(worst) });
        // Beyond any use: there is no need to see it grow on.
        if worst.is_nan() || worst > 10.0 {
            break;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::scene::{Integrator, ShapeChoice};

    #[test]
    fn a_force_that_does_not_balance_is_seen() {
        let scheme = Scheme::new(Integrator::Explicit, ShapeChoice::Bspline2);
        let noise = |share: f64| {
            let points = fly(&scheme, Dimension::Column, share);
            points.iter().take(3).map(|p| *p.found.as_ref().expect("a flight")).fold(0.0, f64::max)
        };
        let (right, wrong) = (noise(1.0), noise(0.7));
        assert!(right < 0.2 * COLUMN.holds && wrong > COLUMN.holds, "{right} {wrong}");
    }

    #[test]
    fn linear_functions_are_stopped_before_the_noise_is_as_large_as_the_stress() {
        let points = fly(&Scheme::new(Integrator::Explicit, ShapeChoice::Centre), Dimension::Column, 1.0);
        let stopped = points.last().expect("points").found.as_ref().expect_err("a reason").to_string();
        assert!(stopped.contains("have crossed 100 cells each"), "{stopped}");
        let until = points.iter().filter_map(|p| p.found.as_ref().ok());
        assert!(until.fold(0.0, |worst: f64, v| worst.max(*v)) < COLUMN.breaks);
    }
}

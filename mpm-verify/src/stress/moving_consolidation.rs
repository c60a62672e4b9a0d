//! The same consolidation at rest, beside its cells, and flying: what the mesh makes of it (Galilean invariance).
//!
//! A free column of saturated soil, drained at both ends and without load: water under pressure `p = P sin(pi Y/H)` beside a
//! skeleton in the same tension, so that the total stress is nothing. The pressure decays as `exp(-c (pi/H)^2 t)`, c =
//! (k/gamma_w)/(1/M + n/K_w), and the column shortens towards its middle. Drained ends are those of the cells that hold
//! soil: beside the mesh they are up to a cell from the soil's own.

use std::f64::consts::PI;
use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given};
use mpm_core::drive::Sample;
use mpm_core::run::run_given;
use mpm_core::scene::{Dimension, SolidSide, Start, Until};

use super::case::{Case, Point};
use super::scheme::{MOVING, Scheme};
use crate::error::Error::{self, Unfit};
use crate::norms::largest;

/// At rest, beside its cells.
pub const SHIFTED: Case = Case {
    name: "shifted-consolidation",
    about: "a free column of 20 cells, drained at both ends, consolidates from a sine of pressure; its ends stand on the mesh \
            or inside of cells",
    why: "The drained end lies on a face of the mesh, up to a cell from that of the soil: first order in L; of \
          contiguous particles with implicit pressures where the soil ends. Light nodes at the ends are what broke explicit and semi-implicit steps before they followed a neighbour, or \
          were lent inertia, in steps of sqrt(3/4).",
    parameter: "shift (cells)",
    column: "shift_cells",
    dimension: Dimension::Column,
    measures: "largest |mean p - exact|, share of the first",
    holds: 0.01,
    breaks: 0.2,
    schemes: &MOVING,
    run: |scheme| SHIFTS.iter().map(|shift| Point { at: *shift, found: error(scheme, *shift, 0.0) }).collect(),
};

/// Flying.
pub const MOVING_CASE: Case = Case {
    name: "moving-consolidation",
    about: "the same column flies through up to 1000 cells while it consolidates",
    parameter: "cells crossed",
    column: "cells",
    run: |scheme| CELLS.iter().map(|cells| Point { at: *cells, found: error(scheme, 0.0, *cells) }).collect(),
    ..SHIFTED
};

const SHIFTS: [f64; 7] = [0.0, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9];
const CELLS: [f64; 6] = [0.1, 1.0, 10.0, 30.0, 100.0, 1000.0];
const ROWS: usize = 20;
/// First pressure in the middle over the oedometer modulus.
const STRAIN: f64 = 1e-5;
/// Ends at this share of the decay time, 1/(c (pi/H)^2).
const DECAYS: f64 = 1.0;

fn error(scheme: &Scheme, shift: f64, cells: f64) -> Result<f64, Error> {
    error_with(scheme, (shift, cells), ROWS, 1.0)
}

/// The same on so many rows of cells, beside a decay that is `faster` by a factor.
fn error_with(scheme: &Scheme, (shift, cells): (f64, f64), rows: usize, faster: f64) -> Result<f64, Error> {
    let mut scene = crate::scenes::terzaghi().edited(|scene| {
        (scene.cell, scene.cells) = (scene.height / rows as f64, [1, rows]);
        scene.empty_cells_above = cells.ceil() as usize + 3;
        scene.solid_sides[2] = SolidSide::Free;
        (scene.surcharge, scene.start, scene.history) = (None, Start::Unloaded, 0);
    })?;
    let water = scene.water.ok_or(Unfit("dry"))?;
    let storage = 1.0 / scene.oedometer_modulus() + 1.0 / scene.pore_stiffness();
    let wave = PI / scene.height;
    let rate = water.mobility() / storage * wave * wave;
    let end = DECAYS / rate;
    scene = scene.edited(|scene| {
        scene.stages[0].drained = [false, false, true, true];
        scene.stages[0].until = Until::Time(end);
        scene.observe_times = (1..=10).map(|i| end * f64::from(i) / 10.0).collect();
    })?;
    let scene = scheme.on(&scene)?;
    let (moved, speed) = (shift * scene.cell, cells * scene.cell / end);
    let most = STRAIN * scene.oedometer_modulus();
    let start = move |[_, y]: [f64; 2]| {
        let p = most * (wave * (y - moved)).sin();
        FirstState { velocity: [0.0, speed], stress: [p, p, p, 0.0], pressure: p }
    };
    let given = Given { start: Some(Arc::new(start)), moved: [0.0, moved], ..Given::default() };
    let run = run_given(&scene, &given, &mut |_| {})?.whole()?;
    let first = 2.0 / PI * most;
    let off = |s: &Sample| s.state.mean_pressure / first - (-faster * rate * s.stage_time).exp();
    Ok(largest(run.observed().map(off)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::scene::{Integrator, ShapeChoice};

    #[test]
    fn a_flight_changes_little_and_another_decay_much() {
        let scheme = Scheme::new(Integrator::SemiImplicit, ShapeChoice::Centre);
        let [rest, flight] = [0.0, 10.0].map(|cells| error(&scheme, 0.3, cells).expect("a run"));
        assert!(rest < 0.05 && flight < 0.05, "{rest} {flight}");
        let wrong = error_with(&scheme, (0.0, 0.0), ROWS, 1.2).expect("a run");
        assert!(wrong > 0.05, "{wrong}");
    }

    #[test]
    fn boxes_find_the_end_of_the_soil() {
        let scheme = Scheme::new(Integrator::SemiImplicit, ShapeChoice::Centre);
        let beside = [scheme, scheme.contiguous()].map(|scheme| error(&scheme, 0.3, 0.0).expect("a run"));
        assert!(beside[0] > 0.03 && beside[1] < 0.006, "{beside:?}");
    }
}

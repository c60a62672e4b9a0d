//! The patch test: a velocity that is linear in the place must strain all soil alike, however its particles stand.
//!
//! What controls hourglasses must not stiffen this. One step of an affine field `v = A x` from rest gives `dt` times the
//! stress of the strain rate sym(A) in every particle.

use std::sync::Arc;

use mpm_core::boundary::{FirstState, Given};
use mpm_core::hardware::Hardware;
use mpm_core::run::model_given;
use mpm_core::scene::{Dimension, Elastic, SolidSide};
use mpm_core::stability::stable_limit;

use super::case::{Case, Point};
use super::scheme::{DRY, Scheme};
use crate::error::Error;

/// The case.
pub const CASE: Case = Case {
    name: "patch",
    about: "one step of an affine velocity on a block that stands beside its cells: stress in every particle away from the \
            edge beside that of the uniform strain, Poisson's ratio up to 0.4999",
    why: "A lumped mass of quadratic B-splines does not give a linear velocity back where particles stand beside \
          their cells: an error of the transfer, not of the stiffness. B-bar passes as exactly as linear functions.",
    parameter: "0.5 - nu",
    column: "half_less_nu",
    dimension: Dimension::PlaneStrain,
    measures: "largest |sigma - sigma_exact|, share of the largest component",
    holds: 1e-9,
    breaks: 0.2,
    schemes: &DRY,
    run: |scheme| LESS.iter().map(|less| Point { at: *less, found: error(scheme, 0.5 - less, 0.0) }).collect(),
};

const LESS: [f64; 5] = [0.5, 0.2, 0.01, 1e-3, 1e-4];
const SIDE: usize = 8;
const EDGE: f64 = 0.1;
/// Velocity gradient, 1/s: xx, xy, yx, yy.
const GRADIENT: [[f64; 2]; 2] = [[1.0, 0.3], [-0.7, -0.4]];

/// Largest error of the stress, with a velocity that is `curved` (1/s per cell) in place of linear.
fn error(scheme: &Scheme, poisson_ratio: f64, curved: f64) -> Result<f64, Error> {
    let scene = crate::scenes::built_in("dry-bar")?.altered_unchecked(|scene| {
        // Room at the side, which no scene with functions as wide as some of these has.
        scene.dimension = Dimension::PlaneStrain;
        (scene.cell, scene.cells) = (EDGE, [SIDE; 2]);
        (scene.width, scene.height) = (EDGE * SIDE as f64, EDGE * SIDE as f64);
        (scene.empty_cells_beside, scene.empty_cells_above) = (2, 2);
        scene.elastic = Elastic { poisson_ratio, ..scene.elastic };
        scene.solid_sides = [SolidSide::Free; 4];
        (scene.surcharge, scene.gravity, scene.history) = (None, None, 0);
        scene.stages[0].damping = 0.0;
        scheme.put_on(scene);
    });
    // So small a step that strains of the step are linear to the accuracy asked for.
    let dt = 1e-7 * stable_limit(&scene);
    let first = move |[x, y]: [f64; 2]| {
        let [[xx, xy], [yx, yy]] = GRADIENT;
        let bend = curved / EDGE * x * x;
        FirstState { velocity: [xx * x + xy * y + bend, yx * x + yy * y], ..FirstState::default() }
    };
    let moved = [0.3 * EDGE, 0.45 * EDGE];
    let given = Given { start: Some(Arc::new(first)), moved, ..Given::default() };
    let mut model = model_given(&Hardware::default(), &scene, &given)?;
    model.enter_stage(&scene.stages[0], &[f64::MAX])?;
    model.advance(dt, 1, &mut 0)?;
    let [[xx, xy], [yx, yy]] = GRADIENT;
    let (lame, shear) = (scene.elastic.lame(), scene.elastic.shear_modulus());
    let mean = lame * (xx + yy);
    let exact = [mean + 2.0 * shear * xx, mean + 2.0 * shear * yy, mean, shear * (xy + yx)];
    let most = exact.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
    // Nodes at the edge have soil on one side only: their velocity is not that of their place.
    let inner = |x: &[f64; 2]| (0..2).all(|d| (2.1..SIDE as f64 - 2.1).contains(&((x[d] - moved[d]) / EDGE)));
    let mut worst = 0.0_f64;
    for p in model.particles().iter().filter(|p| inner(&p.x)) {
        for (s, e) in p.stress.iter().zip(exact) {
            let off = (s / dt - e).abs() / most;
            worst = if off.is_nan() { f64::NAN } else { worst.max(off) };
        }
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::scene::{Integrator, ShapeChoice};

    /// Nodes too light to move alone are at the edge, whatever the functions reach.
    #[test]
    fn averaged_functions_pass() {
        let off = error(&Scheme::new(Integrator::Explicit, ShapeChoice::Gimp), 0.3, 0.0).expect("a step");
        assert!(off <= CASE.holds, "{off}");
    }

    #[test]
    fn b_bar_passes_and_a_curved_field_does_not() {
        for less in LESS {
            let off = |curved: f64| {
                error(&Scheme::new(Integrator::Explicit, ShapeChoice::BBar), 0.5 - less, curved).expect("a step")
            };
            assert!(off(0.0) <= CASE.holds && off(0.1) > 100.0 * CASE.holds, "{} {}", off(0.0), off(0.1));
        }
    }
}

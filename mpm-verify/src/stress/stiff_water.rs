//! Water from soft to nearly incompressible: the column of Table 1, K_w from 2e7 to 2e11 Pa.

use mpm_core::scene::{Dimension, WaterProperties};

use super::case::{Case, Point};
use super::low_permeability::{error, observed};
use super::scheme::STANDING;

/// The case.
pub const CASE: Case = Case {
    name: "stiff-water",
    about: "the same column with k = 5e-4 m/s, K_w from 2e7 to 2e11 Pa, 20 cells",
    why: "The explicit step shrinks with K_w, the error does not grow. Soft water carries less of the load and \
          swings longer; where it carries less than its share of the weight rho_w a_s must stay out of Darcy's law.",
    parameter: "K_w (Pa)",
    column: "k_w_pa",
    dimension: Dimension::Column,
    measures: "error, share of final settlement and of p_0",
    holds: 0.01,
    breaks: 0.2,
    schemes: &STANDING,
    run: |scheme| {
        let column = |modulus: f64| {
            let scene = crate::scenes::terzaghi()
                .edited(|scene| scene.water = scene.water.map(|w| WaterProperties { bulk_modulus: modulus, ..w }))?;
            observed(scheme, scene, ROWS, MOST_STEPS)
        };
        BULK_MODULI
            .iter()
            .map(|modulus| Point { at: *modulus, found: column(*modulus).and_then(|scene| error(&scene)) })
            .collect()
    },
};

const BULK_MODULI: [f64; 5] = [2e7, 2e8, 2e9, 2e10, 2e11];
/// Cells over the height.
const ROWS: usize = 20;
/// Enough for T = 0.1 with the stiffest water: its explicit step is some 3e-8 s.
const MOST_STEPS: f64 = 3e6;

//! A load that pushes the surface of a saturated column down through its cells.
//!
//! Large-strain consolidation: Cauchy stress q everywhere at the end, so that the column is `H (1 - exp(-q/M))` shorter.
//! At Tv = 3 the water still carries 5e-4 of the load.

use mpm_core::run::run;
use mpm_core::scene::{Dimension, StepChoice, Surcharge, Until};

use super::case::{Case, Point};
use super::scheme::{MOVING, Scheme};
use crate::error::Error::{self, Unfit};

/// The surface comes down.
pub const CASE: Case = Case {
    name: "loaded-surface",
    about: "a column of 20 cells of porosity 0.6 consolidates under a load that pushes its surface down through as many cells",
    why: "A cell that the surface has left in part holds less soil than it has room for, and one that particles have crossed into \
          holds as much as ever: the particles of a cell share the soil that is in it, which follows from where the surface is. \
          Functions that reach over several cells do not know it and are refused. The step counts on the pores that the load \
          leaves, where the water is stiffer.",
    parameter: "final settlement (cells)",
    column: "settled_cells",
    dimension: Dimension::Column,
    measures: "|settlement - exact| at Tv = 3, share of the exact",
    holds: 0.03,
    breaks: 0.2,
    schemes: &MOVING,
    run: |scheme| CELLS.iter().map(|cells| Point { at: *cells, found: error(scheme, *cells, 1.0) }).collect(),
};

const CELLS: [f64; 7] = [0.1, 0.3, 0.5, 0.7, 1.0, 2.0, 4.0];
const ROWS: usize = 20;
/// End of a run.
const TV: f64 = 3.0;

/// Error of a column that settles so many `cells`, under `share` of the load that does it.
fn error(scheme: &Scheme, cells: f64, share: f64) -> Result<f64, Error> {
    let mut scene = crate::scenes::terzaghi().edited(|scene| {
        (scene.cell, scene.cells) = (scene.height / ROWS as f64, [1, ROWS]);
        (scene.porosity, scene.step, scene.history) = (0.6, StepChoice::Auto, 0);
    })?;
    let settled = cells * scene.cell;
    let pressure = -scene.oedometer_modulus() * f64::ln_1p(-settled / scene.height);
    scene = scene.edited(|scene| {
        scene.surcharge = scene.surcharge.map(|load| Surcharge { pressure: share * pressure, ..load })
    })?;
    let end = TV * scene.time_per_factor().ok_or(Unfit("dry"))?;
    scene = scene.edited(|scene| {
        scene.stages[0].until = Until::Time(end);
        scene.observe_times = vec![end];
    })?;
    let run = run(&scheme.on(&scene)?, &mut |_| {})?.whole()?;
    let last = run.samples.last().ok_or(Unfit("nothing was observed"))?;
    Ok((last.state.settlement / settled - 1.0).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::scene::{Integrator, ShapeChoice};

    #[test]
    fn linear_functions_follow_the_surface_and_a_lighter_load_is_seen() {
        let scheme = Scheme::new(Integrator::SemiImplicit, ShapeChoice::Centre);
        let [right, lighter] = [1.0, 0.9].map(|share| error(&scheme, 2.0, share).expect("a run"));
        assert!(right < 0.01 && lighter > 2.0 * CASE.holds, "{right} {lighter}");
    }

    #[test]
    fn wide_functions_are_refused_where_they_do_not_see_the_surface() {
        let scheme = Scheme::new(Integrator::SemiImplicit, ShapeChoice::Bspline2);
        assert!(error(&scheme, 0.09, 1.0).expect("a run") < CASE.holds);
        let refused = error(&scheme, 0.6, 1.0).expect_err("a refusal").to_string();
        assert!(refused.starts_with("scheme.shape: expected") && refused.contains("0.60 cells"), "{refused}");
    }
}

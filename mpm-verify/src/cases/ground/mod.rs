//! Ground of several soils, at rest under what engineers meet: seepage along, across and through layers, zones and slopes;
//! consolidation of layers and of columns that end within a cell; a strip of load; rain; slopes of several soils.

mod consolidation;
mod flow;
mod free;
mod slopes;
mod strip;

use mpm_core::drive::Run;
use mpm_core::scene::{Fields, Scene};

use super::{Error, Mutant, Outcome, Rung, asked, finished, integrator, scheme, sound};
use crate::scenes::built_in;

/// What tells the error of a run.
type Measured = Result<Box<dyn Fn(&Run) -> f64>, Error>;

/// A scene on several meshes, how each run is measured against the exact solution, and what that must show.
struct Case {
    /// Name of the built-in scene.
    scene: &'static str,
    /// What is another than in its file, on a mesh of so many cells over the height.
    change: fn(&mut Fields, f64),
    /// What the error of a run is, from the scene as it should be.
    measure: fn(&Scene) -> Measured,
    /// Cells over the height: not a whole number where the mesh ends above the soil.
    cells: &'static [f64],
    required: f64,
    order: Option<[f64; 2]>,
}

/// A case of the verification suite with its planted fault.
macro_rules! case {
    ($name:literal, $about:literal, $what:expr, $fault:expr, $case:expr) => {
        Rung {
            name: $name,
            about: $about,
            climb: || climb(&$case, sound),
            mutant: Some(Mutant { what: $what, climb: || climb(&$case, $fault) }),
        }
    };
}
use case;

/// All of them.
pub const CASES: [Rung; 21] = {
    let [a, b, c, d, e, f] = flow::CASES;
    let [g, h, i, j, k, l] = consolidation::CASES;
    let [m, n, o, p, q] = free::CASES;
    let [r, s] = strip::CASES;
    let [t, u] = slopes::CASES;
    [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u]
};

/// The file as it is.
fn plain(_: &mut Fields, _: f64) {}

fn climb(case: &Case, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let base = built_in(case.scene)?;
    let mut outcome = Outcome { required_error: case.required, required_order: case.order, ..Outcome::default() };
    for &cells in case.cells {
        // An outline is changed with its cells.
        let scene = if base.outline.is_some() { base.clone() } else { base.with_cell(base.height / cells)? };
        let scene = scene.edited(|scene| (case.change)(scene, cells))?;
        let error = (case.measure)(&scene)?;
        let scene = scene.edited(fault)?;
        (outcome.integrator, outcome.scheme) = (integrator(&scene), scheme(&scene));
        outcome.tolerance = asked(&scene);
        outcome.errors.push((scene.cell, error(&finished(&scene)?)));
    }
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_ones_hold_and_their_mutants_fall_short() {
        for case in CASES.iter().filter(|case| !case.name.starts_with("slope-")) {
            let climb = case.climb().expect("runs that finish");
            assert!(climb.step.held(), "{}: {}", case.name, climb.reason);
            let spoilt = case.climb_mutant().expect("a mutant").expect("runs that finish");
            assert!(!spoilt.step.held(), "{}: {}", case.name, spoilt.reason);
        }
    }
}

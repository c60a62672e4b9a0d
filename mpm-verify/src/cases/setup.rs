//! Cases by data: a built-in scene, what is changed of it, the meshes that it runs on, how a run is held against the exact solution, and
//! what that must show.

use mpm_core::drive::Run;
use mpm_core::scene::{Fields, Scene};

use super::{Error, Outcome, asked, finished, integrator, scheme};
use crate::scenes::built_in;

/// What tells the error of a run.
pub(super) type Measured = Result<Box<dyn Fn(&Run) -> f64>, Error>;

/// A scene, how it is measured, and what that must show.
pub(super) struct Setup {
    /// Name of the built-in scene.
    pub scene: &'static str,
    /// What is another than in its file.
    pub change: fn(&mut Fields),
    /// The scene on a mesh of so many cells over the height.
    pub mesh: fn(&Scene, f64) -> Result<Scene, Error>,
    /// What the error of a run is, from the scene as it should be.
    pub measure: fn(&Scene) -> Measured,
    /// Cells over the height: not a whole number where the mesh ends above the soil.
    pub cells: &'static [f64],
    pub required: f64,
    pub order: Option<[f64; 2]>,
}

/// A case of the verification suite with its planted fault.
macro_rules! case {
    ($name:literal, $about:literal, $what:expr, $fault:expr, $case:expr) => {
        $crate::cases::Program {
            name: $name,
            about: $about,
            run: || $crate::cases::setup::run(&$case, $crate::cases::sound),
            mutant: Some($crate::cases::Mutant { what: $what, run: || $crate::cases::setup::run(&$case, $fault) }),
        }
    };
}
pub(super) use case;

/// The soil as it is on another mesh.
pub(super) fn refined(scene: &Scene, cells: f64) -> Result<Scene, Error> {
    Ok(scene.with_cell(scene.height / cells)?)
}

/// Runs a case on its meshes with a fault, or none.
pub(super) fn run(case: &Setup, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let base = built_in(case.scene)?.edited(case.change)?;
    let mut outcome = Outcome { required_error: case.required, required_order: case.order, ..Outcome::default() };
    for &cells in case.cells {
        let scene = (case.mesh)(&base, cells)?;
        let error = (case.measure)(&scene)?;
        let scene = scene.edited(fault)?;
        (outcome.integrator, outcome.scheme) = (integrator(&scene), scheme(&scene));
        outcome.tolerance = asked(&scene);
        outcome.errors.push((scene.cell, error(&finished(&scene)?)));
    }
    Ok(outcome)
}

/// That cases hold, and that each finds its fault.
#[cfg(test)]
pub(super) fn hold_and_find_their_faults<'a>(cases: impl IntoIterator<Item = &'a super::Program>) {
    for case in cases {
        let sound = case.judged().expect("runs that finish");
        assert!(sound.row.passed(), "{}: {}", case.name, sound.reason);
        let spoilt = case.mutant_judged().expect("a mutant").expect("runs that finish");
        assert!(!spoilt.row.passed(), "{}: {}", case.name, spoilt.reason);
    }
}

//! Sweeps beside the study: particles off their even places, a mesh that starts elsewhere, and errors in time alone.
//!
//! Quasi-static at small strain with [`PARTICLES`] particles per cell, against compressible water.
//!
//! # Reading order
//! 1. [`places`]: displaced particles and offsets of the mesh. 2. [`time`]: error against steps and factorisations.

pub mod places;
pub mod time;

use mpm_core::scene::{Integrator, LoadOn, Scene, ShapeChoice, Surcharge};
use serde::{Deserialize, Serialize};

use self::places::{Displacement, Shift};
use self::time::TimeError;
use crate::error::Error;
use crate::study::plan::{remesh, set_family};
use crate::study::{Case, CaseResult, Family, Runner, Task, Variant};

/// Cell edges of the sweeps, m.
pub const MESHES: [f64; 2] = [0.10, 0.05];
/// Particles per cell in plane strain, 3 per direction.
pub const PARTICLES: usize = 9;
/// Error in time that leaves errors in space alone, relative.
pub const TOLERANCE: f64 = 1e-7;
/// What `bspline2` with fitted weights must reach at L = 0.10 m, wherever particles and mesh stand.
pub const REQUIRED: f64 = 1e-4;

/// All rows of all sweeps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Sweeps {
    /// Displaced particles: `displaced.csv`.
    pub displaced: Vec<Displacement>,
    /// Offsets of the mesh: `grid_shift.csv`.
    pub shifted: Vec<Shift>,
    /// Errors in time: `time_error.csv`.
    pub time: Vec<TimeError>,
    /// CPU time of all runs, s; a quick run that is repeated for its time counts once.
    pub cpu_s: f64,
}

impl Sweeps {
    /// Runs all sweeps on the column of a scene. Runs that fail are rows without errors.
    ///
    /// # Errors
    /// No threads.
    pub fn run(base: &Scene, runner: &mut Runner) -> Result<Self, Error> {
        let mut cpu_s = 0.0;
        let time = time::sweep(base, runner, &mut cpu_s)?;
        let displaced = places::displaced(base, runner, &mut cpu_s)?;
        let shifted = places::shifted(base, runner, &mut cpu_s)?;
        Ok(Self { displaced, shifted, time, cpu_s })
    }

    /// Rows that must hold a limit, and those of them that fail.
    pub fn limits(&self) -> (usize, usize) {
        let held = self.displaced.iter().map(|r| r.held).chain(self.shifted.iter().map(|r| r.held)).flatten();
        held.fold((0, 0), |(all, fallen), held| (all + 1, fallen + usize::from(!held)))
    }

    /// Number of runs.
    pub fn count(&self) -> usize {
        self.displaced.len() + self.shifted.len() + self.time.len()
    }
}

/// The column of a scene for a sweep, loaded on its true surface; no history, because only errors are kept.
fn column(base: &Scene, integrator: Integrator, shape: ShapeChoice, mesh: f64) -> Result<Scene, Error> {
    let scene = remesh(base, mesh, PARTICLES)?;
    Ok(scene.edited(|scene| {
        set_family(scene, &Family::whole(integrator, shape), TOLERANCE);
        scene.surcharge = scene.surcharge.map(|s| Surcharge { on: LoadOn::Surface, ..s });
        scene.history = 0;
    })?)
}

/// Runs scenes, several times where the time is to be told, and keeps their order; `kind` and number are the names. `None` where
/// there is no scene, or it was not run.
fn run_all(
    scenes: &[Result<Scene, Error>],
    (kind, again): (&str, bool),
    runner: &mut Runner,
) -> Result<Vec<Option<CaseResult>>, Error> {
    let task = |(number, scene): (usize, &Result<Scene, Error>)| {
        let (key, scene) = (format!("{kind}-{number:03}"), scene.as_ref().ok()?.clone());
        Some(Task { case: Case { name: key.clone(), variant: Variant::Base, scene }, key, again })
    };
    let tasks: Vec<Task> = scenes.iter().enumerate().filter_map(task).collect();
    let mut results = runner.run(&tasks)?.into_iter();
    Ok(scenes.iter().map(|scene| scene.as_ref().ok().and_then(|_| results.next().flatten())).collect())
}

/// What a row keeps of a run: largest error, late one, that of the profile, and why there are none.
fn errors(scene: &Result<Scene, Error>, result: Option<&CaseResult>) -> (f64, f64, f64, Option<String>) {
    let none = |why: String| (f64::NAN, f64::NAN, f64::NAN, Some(why));
    match (scene, result) {
        (Err(why), _) => none(why.to_string()),
        (_, None) => none("not run".to_owned()),
        (_, Some(r)) => {
            (r.max_error_compressible, r.late_error_compressible, r.profile_error_compressible, r.failure.clone())
        }
    }
}

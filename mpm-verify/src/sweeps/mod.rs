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
    pub fn run(base: &Scene, runner: &mut Runner) -> Result<Self, String> {
        let mut cpu_s = 0.0;
        let time = time::sweep(base, runner, &mut cpu_s)?;
        let displaced = places::displaced(base, runner, &mut cpu_s)?;
        let shifted = places::shifted(base, runner, &mut cpu_s)?;
        Ok(Self { displaced, shifted, time, cpu_s })
    }

    /// Rows that must hold a limit, and those of them that fall short.
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
fn column(base: &Scene, integrator: Integrator, shape: ShapeChoice, mesh: f64) -> Result<Scene, String> {
    let mut scene = remesh(base, mesh, PARTICLES)?;
    scene = scene.edited(|scene| {
        set_family(scene, &Family::whole(integrator, shape), TOLERANCE);
        scene.surcharge = scene.surcharge.map(|s| Surcharge { on: LoadOn::Surface, ..s });
        scene.history = 0;
    })?;
    Ok(scene)
}

/// Runs scenes, several times where the time is to be told, and keeps their order; `kind` and number are the names.
fn run_all(
    scenes: &[Result<Scene, String>],
    (kind, again): (&str, bool),
    runner: &mut Runner,
) -> Result<Vec<Result<CaseResult, String>>, String> {
    let task = |(number, scene): (usize, &Result<Scene, String>)| {
        let key = format!("{kind}-{number:03}");
        let scene = scene.clone()?;
        Ok(Task { case: Case { name: key.clone(), variant: Variant::Base, scene }, key, again })
    };
    let tasks: Vec<Result<Task, String>> = scenes.iter().enumerate().map(task).collect();
    let ready: Vec<Task> = tasks.iter().flatten().cloned().collect();
    let mut results = runner.run(&ready)?.into_iter();
    let missing = || "not run".to_owned();
    Ok(tasks.into_iter().map(|task| task.and_then(|_| results.next().flatten().ok_or_else(missing))).collect())
}

/// What a row keeps of a run: largest error, late one, that of the profile, and why there are none.
fn errors(result: &Result<CaseResult, String>) -> (f64, f64, f64, Option<String>) {
    match result {
        Ok(r) => (r.max_error_compressible, r.late_error_compressible, r.profile_error_compressible, r.failure.clone()),
        Err(why) => (f64::NAN, f64::NAN, f64::NAN, Some(why.clone())),
    }
}

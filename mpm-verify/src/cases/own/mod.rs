//! A scene of one's own against the exact solution that applies to it: refined in space, judged as Table 1's column is.
//!
//! # Reading order
//! 1. [`applies`]: which exact solution, or why none. 2. `expected`: what a scheme must show. 3. This file: refine, run,
//!    compare.

pub mod applies;
mod expected;

use cpu_time::ThreadTime;
use mpm_core::scene::{Dimension, Integrator, LoadOn, Scene, ShapeChoice, StepChoice, StrainChoice, Surcharge};
use mpm_core::stability::choose_step;

use self::applies::Solution;
use self::expected::Expected;
use super::degree::Degree;
use super::evidence::Refinement;
use super::looks::in_particles;
use super::verdict::{Climb, Outcome, judge};
use super::{Rung, finished, integrator, mandel, scheme, with_rows};
use crate::exact::mandel::Mandel;

/// Small-strain solutions are met by runs of finite strain only if strains are small: q/M of the load they are run under.
const LIGHT: f64 = 1e-6;
/// Tolerance of error-controlled time where space is refined.
const TOLERANCE: f64 = 1e-8;
/// Tolerances of the refinement in time.
const TOLERANCES: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];
/// Halved steps of the same.
const HALVINGS: u32 = 2;
/// Fewer meshes have no confidence interval.
const LEAST_MESHES: usize = 3;

/// A scene, the exact solution that applies to it, and the meshes it is run on.
#[derive(Debug, Clone)]
pub struct OwnScene {
    /// The scene as it is run: lightly loaded where strains are finite.
    scene: Scene,
    /// Exact solution of that scene.
    solution: Solution,
    /// Rows of cells over the height, coarse to fine.
    rows: Vec<usize>,
    /// What it must show on them.
    expected: Expected,
    /// What was changed of the scene, for the user.
    changed: Vec<String>,
}

impl OwnScene {
    /// The scene on meshes of `rows` cells over its height; without them its own L, L/2 and L/4.
    ///
    /// # Errors
    /// No exact solution applies, or a mesh does not fit: message for the user.
    pub fn new(scene: &Scene, rows: &[usize]) -> Result<Self, String> {
        let (light, mut changed) = lightly_loaded(scene);
        let solution = applies::solution(&light, scene)?;
        let rows = meshes(scene, rows)?;
        let mut scene = light;
        if scene.integrator == Integrator::QuasiStatic && scene.tolerance > TOLERANCE {
            scene.tolerance = if scene.strain == StrainChoice::Small { TOLERANCE } else { 1e-2 * scene.tolerance };
            changed.push(format!("tolerance {:.0e}: the error of time must not hide that of space", scene.tolerance));
        }
        scene.history = 0;
        let expected = Expected::of(&scene, &solution, scene.height / rows[0] as f64)?;
        Ok(Self { scene, solution, rows, expected, changed })
    }

    /// What is compared, in words.
    pub fn about(&self) -> String {
        let rows: Vec<String> = self.rows.iter().map(ToString::to_string).collect();
        let changes = self.changed.iter().map(|change| format!("; {change}"));
        format!("{} on {} rows of cells{}", self.solution.words(), rows.join(", "), changes.collect::<String>())
    }

    /// Runs and judges the scene.
    ///
    /// # Errors
    /// A run could not be finished.
    pub fn climb(&self) -> Result<Climb, String> {
        let clock = ThreadTime::now();
        let outcome = self.outcome(super::sound).map_err(|e| format!("{}: {e}", self.scene.name))?;
        let rung = Rung { name: "scene", about: "a scene of one's own", climb: || Err(String::new()), mutant: None };
        let mut climb = judge(rung, outcome, clock.elapsed().as_secs_f64());
        climb.step.rung.clone_from(&self.scene.name);
        Ok(climb)
    }

    /// Runs the scene, with a fault planted behind the exact solution's back.
    pub(super) fn outcome(&self, fault: fn(&mut Scene)) -> Result<Outcome, String> {
        let scenes = self.on_meshes(fault)?;
        let (fine, step) = scenes.last().map_or((f64::NAN, f64::NAN), |scene| (scene.cell, given(scene)));
        let coarse = scenes[0].clone();
        let (errors, samples, refinements) = match &self.solution {
            Solution::Block(exact) => {
                let (errors, samples) = mandel::refined(&scenes, exact)?;
                (errors, samples, vec![self.block_in_particles(&coarse, exact)?])
            }
            solution => {
                let exact = |time| solution.settlement(time);
                let degree = Degree::relative(&self.scene, &exact);
                let degree = degree.from(self.expected.from);
                let degree = if solution.ramps() { degree.absolute() } else { degree };
                let (errors, samples) = degree.on_meshes(scenes.into_iter())?;
                (errors, samples, self.on_the_coarsest(&coarse, &degree)?)
            }
        };
        let allowed = self.expected.error(fine, step);
        let required_order = self.expected.order_of(&errors);
        let unjudged = ("no order is required: errors reach what error-controlled time leaves", self.expected.floor);
        let notes = required_order.is_none().then_some(unjudged);
        Ok(Outcome {
            integrator: integrator(&self.scene),
            scheme: scheme(&self.scene),
            required_error: allowed,
            required_order,
            notes: notes.map(|(what, value)| (what.to_owned(), value, "-".to_owned())).into_iter().collect(),
            errors,
            samples,
            refinements,
            ..Outcome::default()
        })
    }

    /// The coarsest mesh in smaller steps, or under smaller tolerances, and with other numbers of particles.
    fn on_the_coarsest(&self, coarse: &Scene, degree: &Degree) -> Result<Vec<Refinement>, String> {
        let in_time = match coarse.step {
            StepChoice::Fixed(step) => degree.in_time(coarse, step, HALVINGS, None)?,
            _ => degree.in_tolerance(coarse, &TOLERANCES, 1.0)?,
        };
        let most = self.expected.error(coarse.cell, given(coarse));
        Ok(vec![in_time, degree.in_particles(coarse, counts(coarse), most)?])
    }

    /// The same of Mandel's block, whose pressures are compared.
    fn block_in_particles(&self, coarse: &Scene, exact: &Mandel) -> Result<Refinement, String> {
        let with = |particles_per_cell| {
            let scene = Scene { particles_per_cell, ..coarse.clone() };
            let mut looks = mandel::looks(&finished(&scene)?, exact, 0.0);
            for look in &mut looks.rows {
                look.counts = mandel::counts(exact, look.time);
            }
            Ok(looks)
        };
        in_particles(with, coarse.cell, counts(coarse), self.expected.error(coarse.cell, f64::INFINITY))
    }

    /// The scene on its meshes. Steps fall with L^2 from what the coarsest takes: a scheme of first order in the step then
    /// shows its order in space, and no step is above its limit, which falls no faster.
    fn on_meshes(&self, fault: fn(&mut Scene)) -> Result<Vec<Scene>, String> {
        let mut scenes: Vec<Scene> = self.rows.iter().map(|rows| on(&self.scene, *rows)).collect();
        let coarse = scenes[0].cell;
        let first = choose_step(&scenes[0]).map_err(|e| e.to_string())?;
        for scene in &mut scenes {
            if first.is_finite() {
                scene.step = StepChoice::Fixed(first * (scene.cell / coarse).powi(2));
            }
            fault(scene);
        }
        Ok(scenes)
    }
}

/// The scene on a mesh of `rows` cells over its height, and as many over its width as fit.
fn on(scene: &Scene, rows: usize) -> Scene {
    let mut scene = with_rows(scene.clone(), rows);
    if scene.dimension == Dimension::PlaneStrain {
        scene.cells[0] = (scene.width / scene.cell).round() as usize;
    }
    scene
}

/// Numbers of particles per cell that a scheme should not mind: one is too few for B-splines, and what errors of the fourth
/// order in L are asked for needs as many as integrate them.
fn counts(scene: &Scene) -> &'static [usize] {
    match (scene.shape, scene.integrator) {
        (ShapeChoice::Bspline2, Integrator::QuasiStatic) if scene.particles_per_cell >= 9 => &[9, 16],
        (ShapeChoice::Bspline2, _) => &[4, 9, 16],
        _ => &[1, 4, 9],
    }
}

/// The step that a scene is given, s; infinite where its integrator chooses.
fn given(scene: &Scene) -> f64 {
    match scene.step {
        StepChoice::Fixed(step) => step,
        StepChoice::Auto | StepChoice::Paper => f64::INFINITY,
    }
}

/// The scene under so little load that strains of finite size do not show, and what that changed.
fn lightly_loaded(scene: &Scene) -> (Scene, Vec<String>) {
    let mut light = scene.clone();
    let Some(load) = scene.surcharge else { return (light, Vec::new()) };
    let ratio = load.pressure / scene.oedometer_modulus();
    let linear = scene.strain == StrainChoice::Small || load.on == LoadOn::Plate;
    if linear || ratio <= LIGHT || ratio > applies::SMALL {
        return (light, Vec::new());
    }
    let pressure = LIGHT * scene.oedometer_modulus();
    light.surcharge = Some(Surcharge { pressure, ..load });
    let why = format!("load {pressure:.3} Pa, q/M = {LIGHT:.0e}: the exact solution is that of small strains");
    (light, vec![why])
}

/// Rows of cells to run.
fn meshes(scene: &Scene, asked: &[usize]) -> Result<Vec<usize>, String> {
    let own = scene.cells[1];
    let rows = if asked.is_empty() { vec![own, 2 * own, 4 * own] } else { asked.to_vec() };
    let words = rows.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
    if rows.len() < LEAST_MESHES || rows[0] < 2 || rows.windows(2).any(|pair| pair[0] >= pair[1]) {
        let expected = "three numbers of rows or more, each larger than the one before, from 2 on";
        return Err(format!("--rows: expected {expected}, found {words}"));
    }
    if scene.dimension == Dimension::PlaneStrain {
        for rows in &rows {
            let across = scene.width / scene.height * *rows as f64;
            if (across - across.round()).abs() > 1e-9 * across {
                let expected = format!("square cells that divide the width {} m as well", scene.width);
                return Err(format!("--rows: expected {expected}, found {rows} rows over {} m", scene.height));
            }
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests;

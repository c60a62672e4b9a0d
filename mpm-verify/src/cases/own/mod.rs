//! A scene of one's own against the exact solution that applies to it: under its own load, refined in space, settlement and pressure
//! at every sample time.
//!
//! An error passes if it is below 1 % and falls on refinement as an error of the mesh does, or if it is below 0.3 %: an error of 1 %
//! that stays is none of the mesh. An order that is established must be that of theory, as everywhere.
//!
//! # Reading order
//! 1. [`applies`]: which exact solution, or why none. 2. `columns`: what it says of a column. 3. [`compared`]: a run beside it. 4. This file:
//!    refine, run, judge.

pub mod applies;
mod columns;
pub mod compared;

use cpu_time::ThreadTime;
use mpm_core::scene::{Dimension, Fields, Integrator, Scene, StepChoice, StrainChoice, Until};
use mpm_core::stability::choose_step;

use self::applies::Solution;
use super::{Error, asked, infinite_slope, integrator, scheme};
use crate::experiment::comparison::Comparison;
use crate::experiment::refinement::{PARTICLES, Refinement, STEP, TOLERANCE};
use crate::experiment::shared::shared;
use crate::experiment::verdict::{Judged, Named, Outcome, judge};
use crate::norms::worst;
use crate::rates::round_off;

/// Largest error where it falls on refinement: 1 % cannot pass.
const FALLING: f64 = 9.9e-3;
/// Largest error that need not fall.
const STAYING: f64 = 3e-3;
/// Tolerance of error-controlled time where space is refined.
const TIGHT: f64 = 1e-8;
/// Tolerances of the refinement in time.
const TOLERANCES: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];
/// Largest error over the tolerance, which is that of the estimate of one step.
const OVER_TOLERANCE: f64 = 10.0;
/// Halved steps of the same.
const HALVINGS: i32 = 2;
/// Fewer meshes say nothing of an order.
const LEAST_MESHES: usize = 3;

/// A scene with a fault in it.
pub(crate) type Fault<'a> = &'a dyn Fn(&Scene) -> Result<Scene, Error>;

/// Nothing planted.
fn sound(scene: &Scene) -> Result<Scene, Error> {
    Ok(scene.clone())
}

/// A scene, the exact solution that applies to it, and the meshes it is run on.
#[derive(Debug, Clone)]
pub struct OwnScene {
    /// The scene as it is run.
    scene: Scene,
    /// Exact solution of that scene.
    solution: Solution,
    /// Rows of cells over the height, coarse to fine.
    rows: Vec<usize>,
    /// What was changed of the scene, for the user.
    changed: Vec<String>,
}

impl OwnScene {
    /// The scene on meshes of `rows` cells over its height; without them on four, its own and finer ones.
    ///
    /// # Errors
    /// No exact solution applies, or a mesh does not fit: message for the user.
    pub fn new(scene: &Scene, rows: &[usize]) -> Result<Self, Error> {
        let (mut scene, mut changed) = (scene.clone(), Vec::new());
        let end = scene.stages.last().map(|stage| stage.until);
        if let (true, Some(Until::Time(end)), 1) = (scene.observe_times.is_empty(), end, scene.stages.len()) {
            scene = scene
                .edited(|scene| scene.observe_times = [0.2, 0.4, 0.6, 0.8, 1.0].map(|share| share * end).to_vec())?;
            changed.push("times at each fifth of its end".to_owned());
        }
        let solution = applies::solution(&scene)?;
        let rows = meshes(&scene, rows)?;
        if scene.integrator.solves_displacements() && scene.tolerance > TIGHT {
            scene = scene.edited(|scene| {
                scene.tolerance = if scene.strain == StrainChoice::Small { TIGHT } else { 1e-2 * scene.tolerance }
            })?;
            changed.push(format!("tolerance {:.0e}: the error of time must not hide that of space", scene.tolerance));
        }
        scene = scene.edited(|scene| scene.history = 0)?;
        Ok(Self { scene, solution, rows, changed })
    }

    /// What is compared, in words.
    pub fn about(&self) -> String {
        let rows: Vec<String> = self.rows.iter().map(ToString::to_string).collect();
        let changes = self.changed.iter().map(|change| format!("; {change}"));
        format!("{} on {} rows of cells{}", self.solution.words(), rows.join(", "), changes.collect::<String>())
    }

    /// The scene on its meshes, as it is run.
    ///
    /// # Errors
    /// A step above the limit.
    pub fn runs(&self) -> Result<Vec<Scene>, Error> {
        self.on_meshes(&sound)
    }

    /// What the scene carries beside the exact solution, one sentence each.
    pub fn beside(&self) -> Vec<String> {
        self.solution.beside(&self.scene)
    }

    /// Runs and judges the scene.
    ///
    /// # Errors
    /// A run could not be finished.
    pub fn judged(&self) -> Result<Judged, Error> {
        let clock = ThreadTime::now();
        let outcome = self.outcome(&sound).map_err(|e| e.of(&self.scene.name))?;
        let case = Named { name: "scene", about: "a scene of the user", mutant: None };
        let mut judged = judge(case, outcome, clock.elapsed().as_secs_f64());
        judged.row.case.clone_from(&self.scene.name);
        Ok(judged)
    }

    /// Runs the scene, with a fault planted behind the exact solution's back.
    pub(crate) fn outcome(&self, fault: Fault<'_>) -> Result<Outcome, Error> {
        if let Solution::Slope(depth, seepage) = self.solution {
            return self.slope((depth, seepage), fault);
        }
        let scenes = self.on_meshes(fault)?;
        let (mut errors, mut finest) = (Vec::new(), Vec::new());
        for scene in &scenes {
            finest = self.seen(scene)?;
            errors.push((scene.cell, error(&finest)));
        }
        let coarse = errors[0].1.abs();
        let name = |looks: &Comparison| format!("{}, largest error on the finest mesh", looks.quantity);
        Ok(Outcome {
            integrator: integrator(&self.scene),
            tolerance: asked(&self.scene),
            scheme: scheme(&self.scene),
            required_error: self.allowed(&errors),
            required_order: self.order(),
            floor: self.floor(scenes.last().map_or(1, |scene| scene.cells[1])),
            notes: finest.iter().map(|looks| (name(looks), looks.error(), "-".to_owned())).collect(),
            samples: finest.iter().flat_map(Comparison::samples).collect(),
            refinements: self.on_the_coarsest(&scenes[0], coarse)?,
            errors,
            ..Outcome::default()
        })
    }

    /// The factor of safety of a slope.
    fn slope(&self, plane: (f64, crate::exact::infinite_slope::Seepage), fault: Fault<'_>) -> Result<Outcome, Error> {
        let found = |rows: &usize| {
            let (share, _) = infinite_slope::own(&self.scene, plane, *rows, fault)?;
            Ok((self.scene.height / *rows as f64, share - 1.0))
        };
        Ok(Outcome {
            integrator: integrator(&self.scene),
            tolerance: asked(&self.scene),
            scheme: scheme(&self.scene),
            errors: self.rows.iter().map(found).collect::<Result<_, Error>>()?,
            required_error: FALLING,
            ..Outcome::default()
        })
    }

    /// What a run of a scene shows beside the exact solution, in shares of it.
    fn seen(&self, scene: &Scene) -> Result<Vec<Comparison>, Error> {
        // The exact solution is that of the scene as it is: a fault must not move it, nor the mesh that the fault may have made unfit.
        let own = self.scene.clone().altered_unchecked(|own| (own.cell, own.cells) = (scene.cell, scene.cells));
        self.solution.compared(&own, &*shared(scene)?)
    }

    /// Largest error allowed, beside what the solution itself is known to.
    fn allowed(&self, errors: &[(f64, f64)]) -> f64 {
        let known = if let Solution::Wet(column) = &self.solution { column.uncertainty() } else { 0.0 };
        let ends = errors.first().zip(errors.last());
        // At first order or faster, with half as much for scatter.
        let falls = ends.is_some_and(|(coarse, fine)| fine.1.abs() <= 1.5 * coarse.1.abs() * fine.0 / coarse.0);
        known + if falls { FALLING } else { STAYING }
    }

    /// The order of theory.
    fn order(&self) -> Option<f64> {
        let splines = self.scene.integrator.solves_displacements() && self.scene.shape.spline_degree().is_some();
        match self.solution {
            // The front is a jump, the block goes with the time step.
            Solution::Front(_) | Solution::Mound(_) | Solution::Dam(_) | Solution::Sliding(_) => Some(1.0),
            // A wave with kinks has the order of its kinks. Splines come to theirs on finer meshes than a scene brings, from 4.5 above or, at
            // large strain, from 2.7: the suite has meshes of its own for that.
            Solution::Dry(_) => None,
            Solution::Wet(_) | Solution::Block(_) if splines => None,
            _ => Some(2.0),
        }
    }

    /// Errors of at most so much are what error-controlled time leaves, or round-off on so many rows of cells.
    fn floor(&self, rows: usize) -> f64 {
        let time = if self.scene.integrator.solves_displacements() { 10.0 * self.scene.tolerance } else { 0.0 };
        time.max(round_off((rows * rows) as f64))
    }

    /// The coarsest mesh in smaller steps, or under smaller tolerances, and with other numbers of particles.
    fn on_the_coarsest(&self, coarse: &Scene, left: f64) -> Result<Vec<Refinement>, Error> {
        let mut refinements = Vec::new();
        let apart =
            |these: &[Comparison], those: &[Comparison]| worst(these.iter().zip(those).map(|(a, b)| a.difference(b)));
        let same = format!("L = {} m: the error of the mesh drops out", coarse.cell);
        if let StepChoice::Fixed(step) = coarse.step {
            let stepped = |halvings: i32| {
                let step = step / 2.0_f64.powi(halvings);
                Ok::<_, Error>((step, self.seen(&coarse.edited(|s| s.step = StepChoice::Fixed(step))?)?))
            };
            let runs = (0..=HALVINGS).map(stepped).collect::<Result<Vec<_>, _>>()?;
            let errors = runs.windows(2).map(|pair| (pair[0].0, apart(&pair[0].1, &pair[1].1))).collect();
            refinements.push(Refinement::new(STEP, errors, format!("the same run at half the step, {same}")));
        } else if self.scene.integrator.solves_displacements() && self.scene.water.is_some() {
            let at = |tolerance| self.seen(&coarse.edited(|s| s.tolerance = tolerance)?);
            // Waves are followed in steps that go with the fourth root of the tolerance: the last ones are dear, and the check is the same.
            let tolerances =
                if self.scene.integrator == Integrator::Implicit { &TOLERANCES[..2] } else { &TOLERANCES[..] };
            let finest = at(0.01 * tolerances[tolerances.len() - 1])?;
            let off = |tolerance: &f64| Ok((*tolerance, apart(&at(*tolerance)?, &finest)));
            let errors = tolerances.iter().map(off).collect::<Result<_, Error>>()?;
            let against = format!("the same run under a hundredth of the smallest tolerance, {same}");
            let share =
                Refinement { required_share: Some(OVER_TOLERANCE), ..Refinement::new(TOLERANCE, errors, against) };
            refinements.push(share);
        }
        let with = |count: &usize| {
            let looks = self.seen(&coarse.edited(|s| s.particles_per_cell = *count)?)?;
            Ok((*count as f64, error(&looks)))
        };
        let errors = counts(coarse).iter().map(with).collect::<Result<_, Error>>()?;
        let against =
            format!("the exact solution, L = {} m: the error of the mesh stays, no order is expected", coarse.cell);
        // The mesh leaves its error whatever the particles are.
        let most = (2.0 * left).max(FALLING);
        refinements.push(Refinement { required_error: Some(most), ..Refinement::new(PARTICLES, errors, against) });
        Ok(refinements)
    }

    /// The scene on its meshes. Steps fall with L^2 from what the coarsest takes, so that a scheme of first order in the step
    /// shows its order in space, and no step is above the limit of its mesh.
    fn on_meshes(&self, fault: Fault<'_>) -> Result<Vec<Scene>, Error> {
        let scenes = self.rows.iter().map(|rows| self.scene.with_rows(*rows));
        let mut scenes: Vec<Scene> = scenes.collect::<Result<_, _>>()?;
        let coarse = scenes[0].cell;
        let first = choose_step(&scenes[0])?;
        let given = matches!(self.scene.integrator, Integrator::Explicit | Integrator::SemiImplicit);
        for scene in &mut scenes {
            if first.is_finite() && given {
                let own = Fields { step: StepChoice::Auto, ..Fields::clone(scene) };
                let own = choose_step(&own)?;
                let step = (first * (scene.cell / coarse).powi(2)).min(own);
                *scene = scene.edited(|scene| scene.step = StepChoice::Fixed(step))?;
            }
            *scene = fault(scene)?;
        }
        Ok(scenes)
    }
}

/// The worst error of all that is looked at.
fn error(looks: &[Comparison]) -> f64 {
    if looks.is_empty() { f64::NAN } else { worst(looks.iter().map(Comparison::error)) }
}

/// Numbers of particles per cell that a scheme should not mind: one is too few for B-splines, and what errors of the fourth
/// order in L are asked for needs as many as integrate them.
fn counts(scene: &Scene) -> &'static [usize] {
    match (scene.shape.spline_degree(), scene.integrator.solves_displacements()) {
        (None, _) => &[1, 4, 9],
        // Products of the slopes of cubic B-splines are splines of degree 4.
        (Some(3), true) if scene.particles_per_cell >= 16 => &[16, 25],
        (Some(2), true) if scene.particles_per_cell >= 9 => &[9, 16],
        _ => &[4, 9, 16],
    }
}

/// Rows of cells to run: those asked for, or four meshes, each 1.4 times as fine as the one before; in plane strain
/// multiples, which divide the width as well.
fn meshes(scene: &Scene, asked: &[usize]) -> Result<Vec<usize>, Error> {
    let own = scene.cells[1];
    let finer = |half: i32| (own as f64 * 2.0_f64.powf(0.5 * f64::from(half))).round() as usize;
    let plane = scene.dimension == Dimension::PlaneStrain && !scene.periodic;
    let usual: Vec<usize> = if plane { (1..=4).map(|i| i * own).collect() } else { (0..4).map(finer).collect() };
    let rows = if asked.is_empty() { usual } else { asked.to_vec() };
    let words = rows.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
    let least = if asked.is_empty() { 1 } else { 2 };
    if rows.len() < LEAST_MESHES || rows[0] < least || rows.windows(2).any(|pair| pair[0] >= pair[1]) {
        let expected = "three numbers of rows or more, each larger than the one before, from 2 on";
        return Err(Error::refused("--rows", expected, words));
    }
    for rows in &rows {
        let cell = scene.height / *rows as f64;
        let across = if scene.dimension == Dimension::Column { 1 } else { (scene.width / cell).round() as usize };
        let fits = Fields { cell, cells: [across, *rows], ..Fields::clone(scene) }.fits_in_memory();
        fits.map_err(|[expected, found]| Error::refused("--rows", expected, format!("{rows} rows: {found}")))?;
    }
    if plane {
        for rows in &rows {
            let across = scene.width / scene.height * *rows as f64;
            if (across - across.round()).abs() > 1e-9 * across {
                let expected = format!("square cells that divide the width {} m as well", scene.width);
                return Err(Error::refused("--rows", expected, format!("{rows} rows over {} m", scene.height)));
            }
        }
    }
    for layer in &scene.layers {
        for rows in rows.iter().filter(|_| !asked.is_empty()) {
            let edge = layer.up_to / scene.height * *rows as f64;
            if (edge - edge.round()).abs() > 1e-9 * edge {
                let expected = format!("cells that end at the layer's top, {} m", layer.up_to);
                return Err(Error::refused("--rows", expected, format!("{rows} rows over {} m", scene.height)));
            }
        }
    }
    // Layers need whole cells: multiples of the scene's own.
    Ok(if asked.is_empty() && !scene.layers.is_empty() { (1..=4).map(|i| i * own).collect() } else { rows })
}

#[cfg(test)]
mod tests;

//! Which cases a study runs: integrator x shape functions x mesh x particles per cell x load.

use mpm_core::scene::{
    DarcyChoice, Dimension, Fields, Integrator, LoadOn, Scene, ShapeChoice, StepChoice, StrainChoice, Surcharge,
};
use mpm_core::stability::choose_step;

use super::{Variant, word};
use crate::error::Error;

/// What to run.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The scene that every case changes.
    pub base: Scene,
    /// Integrators with shape functions, and how much of the rest each of them runs.
    pub families: Vec<Family>,
    /// Cell edges L, m.
    pub meshes: Vec<f64>,
    /// Particles per cell.
    pub particles_per_cell: Vec<usize>,
    /// What carries the load.
    pub loads: Vec<LoadOn>,
    /// Largest error in time of quasi-static runs, relative.
    pub tolerance: f64,
    /// Whether to run the further cases that the error budget needs: half the step, a hundredth of the load.
    pub budget: bool,
    /// Threads.
    pub jobs: usize,
}

/// The meshes of the study, m.
pub const MESHES: [f64; 6] = [0.10, 0.05, 0.025, 0.02, 0.0125, 0.01];

/// All integrators.
pub const INTEGRATORS: [Integrator; 3] = [Integrator::Explicit, Integrator::SemiImplicit, Integrator::QuasiStatic];

/// All shape functions.
pub const SHAPES: [ShapeChoice; 4] =
    [ShapeChoice::Centre, ShapeChoice::Linear, ShapeChoice::Gimp, ShapeChoice::Bspline2];

/// Largest error in time of quasi-static runs: below what cells of any size leave, but for the finest `bspline2`.
pub const TOLERANCE: f64 = 1e-5;

/// The number of particles per cell of a family of which one line is run.
const USUAL_PARTICLES: usize = 4;

/// An integrator with shape functions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Family {
    /// How time is integrated.
    pub integrator: Integrator,
    /// Shape functions.
    pub shape: ShapeChoice,
    /// How much of the plan it runs.
    pub extent: Extent,
}

/// How much of meshes, particles and loads is run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Extent {
    /// Everything.
    Whole,
    /// Load on the surface, 4 particles per cell, meshes from this cell edge (m) up.
    Line(f64),
}

impl Family {
    /// A family that runs everything.
    pub fn whole(integrator: Integrator, shape: ShapeChoice) -> Self {
        Self { integrator, shape, extent: Extent::Whole }
    }

    /// The families of some integrators (all without one) and shapes. Shapes that are asked for run everything; without
    /// one, the paper's explicit scheme and its semi-implicit twin and all that is quasi-static do, the others a line:
    /// explicit runs on fine meshes cost seconds each.
    pub fn of(integrators: Option<&[Integrator]>, shapes: Option<&[ShapeChoice]>) -> Vec<Self> {
        let extent = |integrator, shape| match (integrator, shape) {
            _ if shapes.is_some() => Extent::Whole,
            (Integrator::QuasiStatic | Integrator::Implicit, _) | (_, ShapeChoice::Centre) => Extent::Whole,
            (Integrator::Explicit, _) => Extent::Line(0.02),
            (Integrator::SemiImplicit | Integrator::Staggered | Integrator::Coupled, _) => Extent::Line(0.0),
        };
        let mut families = Vec::new();
        for &integrator in integrators.unwrap_or(&INTEGRATORS) {
            for &shape in shapes.unwrap_or(&SHAPES) {
                families.push(Self { integrator, shape, extent: extent(integrator, shape) });
            }
        }
        families
    }

    /// Whether it can be run with a number of particles under a load: B-splines need 4 per cell, because one is fewer points
    /// than unknowns; only beside a load on the surface do explicit and semi-implicit steps not notice.
    fn takes(&self, ppc: usize, load: LoadOn) -> bool {
        let unnoticed = self.integrator != Integrator::QuasiStatic && load == LoadOn::Surface;
        ppc >= 4 || self.shape.spline_degree().is_none() || unnoticed
    }
}

/// A case to run.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its name.
    pub name: String,
    /// How it differs from the study's own setting.
    pub variant: Variant,
    /// Its scene.
    pub scene: Scene,
}

/// The paper's own setting: L = 0.02 m, 4 particles per cell, explicit, traction on boundary particles.
pub const PAPERS: &str = "explicit-centre-particles-L0.02-ppc4";

/// Name of a case.
pub fn case_name(family: &Family, load: LoadOn, mesh: f64, ppc: usize) -> String {
    format!("{}-{}-{}-L{mesh}-ppc{ppc}", word(family.integrator), word(family.shape), word(load))
}

impl Plan {
    /// All cases: the paper's own setting if it is among them, then the most expensive first.
    ///
    /// # Errors
    /// A mesh that does not divide the column, or no square number of particles: message for the user.
    pub fn cases(&self) -> Result<Vec<Case>, Error> {
        let mut cases = Vec::new();
        for family in &self.families {
            for &mesh in &self.meshes {
                for &ppc in &self.particles_per_cell {
                    for &load in &self.loads {
                        if family.takes(ppc, load) && self.runs(family, mesh, ppc, load) {
                            self.case(family, mesh, ppc, load, &mut cases)?;
                        }
                    }
                }
            }
        }
        let papers = |case: &Case| case.variant == Variant::Base && case.name == PAPERS;
        cases.sort_by(|a, b| papers(b).cmp(&papers(a)).then_with(|| work(&b.scene).total_cmp(&work(&a.scene))));
        Ok(cases)
    }

    /// What a reader would miss: cases that were asked for and cannot be run.
    pub fn left_out(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for family in &self.families {
            for &ppc in self.particles_per_cell.iter().filter(|_| family.extent == Extent::Whole) {
                let left: Vec<String> = self.loads.iter().filter(|l| !family.takes(ppc, **l)).map(word).collect();
                if left.is_empty() {
                    continue;
                }
                let under = if left.len() < self.loads.len() {
                    format!(" under a load on the {}", left[0])
                } else {
                    String::new()
                };
                notes.push(format!(
                    "{} {} is not run with {ppc} particle per cell{under}: fewer points than unknowns.",
                    word(family.integrator),
                    word(family.shape),
                ));
            }
        }
        notes
    }

    fn runs(&self, family: &Family, mesh: f64, ppc: usize, load: LoadOn) -> bool {
        let Extent::Line(least) = family.extent else { return true };
        let usual = self.particles_per_cell.iter().min_by_key(|n| n.abs_diff(USUAL_PARTICLES));
        let surface = if self.loads.contains(&LoadOn::Surface) { Some(&LoadOn::Surface) } else { self.loads.first() };
        usual == Some(&ppc) && surface == Some(&load) && mesh >= least * (1.0 - 1e-9)
    }

    /// Adds a case, and the further runs that its budget needs.
    fn case(&self, family: &Family, mesh: f64, ppc: usize, load: LoadOn, cases: &mut Vec<Case>) -> Result<(), Error> {
        let name = case_name(family, load, mesh, ppc);
        let scene = remesh(&self.base, mesh, ppc)?.edited(|scene| {
            scene.surcharge = scene.surcharge.map(|s| Surcharge { on: load, ..s });
            set_family(scene, family, self.tolerance);
            scene.name.clone_from(&name);
        })?;
        let explicit = family.integrator == Integrator::Explicit && family.extent == Extent::Whole;
        if self.budget && explicit && load == LoadOn::Surface {
            let step = 0.5 * choose_step(&scene)?;
            let half = scene.edited(|half| half.step = StepChoice::Fixed(step))?;
            cases.push(Case { name: name.clone(), variant: Variant::HalfStep, scene: half });
            let small = scene.edited(|small| {
                small.surcharge = small.surcharge.map(|s| Surcharge { pressure: 0.01 * s.pressure, ..s })
            })?;
            cases.push(Case { name: name.clone(), variant: Variant::SmallLoad, scene: small });
        }
        cases.push(Case { name, variant: Variant::Base, scene });
        Ok(())
    }
}

/// Gives a scene an integrator and shape functions. Quasi-static scenes are computed at small strain, which is what
/// their exact solutions assume; they choose their own steps and have one Darcy operator.
pub fn set_family(scene: &mut Fields, family: &Family, tolerance: f64) {
    (scene.integrator, scene.shape) = (family.integrator, family.shape);
    if family.integrator.solves_displacements() {
        (scene.strain, scene.tolerance) = (StrainChoice::Small, tolerance);
        (scene.step, scene.darcy) = (StepChoice::Auto, DarcyChoice::Face);
    }
}

/// Predicted work of a scene, in explicit point-steps and some for the cells.
pub fn work(scene: &Scene) -> f64 {
    let (points, cells) = (scene.solid_particles() as f64, (scene.cells[0] * scene.cells[1]) as f64);
    let steps = scene.observe_times.last().copied().unwrap_or(0.0) / choose_step(scene).unwrap_or(f64::INFINITY);
    match scene.integrator {
        Integrator::Explicit => steps * (points + 2.0 * cells),
        // Each step fills, factors and solves a banded system.
        Integrator::SemiImplicit => steps * (2.0 * points + 20.0 * cells),
        // As many steps as a front has cells to pass.
        Integrator::Staggered | Integrator::Coupled => 100.0 * cells * (scene.cells[0] + scene.cells[1]) as f64,
        // A factorisation, a dozen solves, and a look at every particle at each time to observe.
        Integrator::QuasiStatic => 100.0 * (points + 20.0 * cells),
        Integrator::Implicit => 1000.0 * (points + 20.0 * cells),
    }
}

/// The scene on another mesh.
///
/// # Errors
/// A mesh that does not divide the column, or no square number of particles: message for the user.
pub fn remesh(base: &Scene, mesh: f64, ppc: usize) -> Result<Scene, Error> {
    let count = |length: f64, name: &str| {
        let n = (length / mesh).round();
        if n >= 1.0 && (n * mesh - length).abs() <= 1e-9 * length {
            Ok(n as usize)
        } else {
            Err(Error::refused("mesh", format!("a cell that divides the {name} of {length} m"), format!("{mesh} m")))
        }
    };
    let across = if base.dimension == Dimension::Column { 1 } else { count(base.width, "width")? };
    let cells = [across, count(base.height, "height")?];
    let root = (ppc as f64).sqrt().round() as usize;
    if root * root != ppc || ppc == 0 {
        return Err(Error::refused("ppc", "a square number of particles per cell", ppc));
    }
    Fields { cell: mesh, cells, particles_per_cell: ppc, ..Fields::clone(base) }
        .fits_in_memory()
        .map_err(|[expected, found]| Error::refused("mesh", expected, format!("{mesh} m: {found}")))?;
    Ok(base.with_cell(mesh)?.patched(&[("mesh.particles_per_cell", ppc.into())])?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(families: Vec<Family>) -> Plan {
        Plan {
            base: crate::scenes::terzaghi(),
            families,
            meshes: MESHES.to_vec(),
            particles_per_cell: vec![1, 4, 9],
            loads: vec![LoadOn::Particles, LoadOn::Surface],
            tolerance: TOLERANCE,
            budget: true,
            jobs: 1,
        }
    }

    fn count(cases: &[Case], start: &str) -> usize {
        cases.iter().filter(|c| c.name.starts_with(start)).count()
    }

    #[test]
    fn the_usual_plan_runs_the_papers_scheme_whole_and_dear_ones_along_a_line() {
        let plan = plan(Family::of(None, None));
        let cases = plan.cases().expect("a plan");
        assert_eq!(count(&cases, "explicit-centre-"), 36 + 36);
        assert_eq!(count(&cases, "explicit-gimp-surface-L0.02-ppc4"), 1);
        assert_eq!((count(&cases, "explicit-gimp"), count(&cases, "semi-implicit-gimp")), (4, 6));
        assert_eq!((count(&cases, "semi-implicit-centre"), count(&cases, "quasi-static-linear")), (36, 36));
        assert_eq!(count(&cases, "quasi-static-bspline2"), 24, "not with one particle per cell");
        let notes = plan.left_out();
        assert!(notes.len() == 1 && notes[0].contains("quasi-static bspline2"), "{notes:?}");
        let small = |c: &Case| (c.scene.strain == StrainChoice::Small) == c.name.starts_with("quasi-static");
        assert!(cases.iter().all(small));
        assert_eq!((cases[0].name.as_str(), cases[0].variant), (PAPERS, Variant::Base), "the first result comes soon");
        assert!(cases[1..].windows(2).all(|pair| work(&pair[0].scene) >= work(&pair[1].scene)));
    }

    #[test]
    fn shapes_that_are_asked_for_run_everything() {
        let plan = plan(Family::of(Some(&[Integrator::Explicit]), Some(&[ShapeChoice::Gimp])));
        assert_eq!(plan.cases().expect("a plan").len(), 36 + 36);
        assert!(plan.left_out().is_empty());
    }
}

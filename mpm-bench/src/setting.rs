//! One way to compute the column: which solver, how fine, with which step or tolerance.

use mpm_core::scene::{
    Dimension, Fields, Integrator, LoadOn, Scene, ShapeChoice, StepChoice, StrainChoice, Surcharge, TimeMethod,
};
use mpm_core::stability::choose_step;
use mpm_verify::error::Error;
use mpm_verify::study::plan::{remesh, set_family};
use mpm_verify::study::{Family, word};

use crate::baseline::{self, FiniteVolumes, Kind, Soil};

/// A setting that can be run.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Its name, e.g. `quasi-static-bspline2-L0.1-ppc9-tol1e-3`; no two settings share one.
    pub case: String,
    /// What is run.
    pub solver: Solver,
}

/// What computes the column.
#[derive(Debug, Clone, PartialEq)]
pub enum Solver {
    /// Material points: a checked scene.
    Points(Box<Scene>),
    /// The baseline.
    Volumes(FiniteVolumes, Soil),
}

/// How fine a run is in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Time {
    /// The automatic step divided by this number.
    Step(u32),
    /// A tolerance (relative) for a method with steps of its own choice.
    Tolerance(f64, TimeMethod),
}

/// Where a run is in the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// How time is integrated.
    pub integrator: Integrator,
    /// Shape functions.
    pub shape: ShapeChoice,
    /// Cell edge L, m.
    pub mesh: f64,
    /// Particles per cell.
    pub ppc: usize,
    /// Steps.
    pub time: Time,
    /// One dimension or the full width.
    pub dimension: Dimension,
    /// Whether the mesh moves with the soil: large strain of integrators that solve for displacements.
    pub moves: bool,
}

impl Setting {
    /// A run with material points, load on the surface, observed at the nine sample times alone.
    ///
    /// # Errors
    /// A mesh that does not divide the column, no square number of particles, a step that cannot be chosen.
    pub fn points(base: &Scene, choice: &Choice) -> Result<Self, Error> {
        let Choice { integrator, shape, mesh, ppc, time, dimension, moves } = *choice;
        let base = base.edited(|s| s.dimension = dimension)?;
        let mut case = format!("{}-{}-L{mesh}-ppc{ppc}", word(integrator), word(shape));
        let family = |scene: &mut Fields, tolerance| set_family(scene, &Family::whole(integrator, shape), tolerance);
        let mut scene = remesh(&base, mesh, ppc)?.edited(|scene| {
            scene.surcharge = scene.surcharge.map(|s| Surcharge { on: LoadOn::Surface, ..s });
            // What is timed is the solution, not the reading of a curve.
            scene.history = 0;
            match time {
                Time::Step(_) => family(scene, scene.tolerance),
                Time::Tolerance(tolerance, method) => {
                    family(scene, tolerance);
                    scene.method = method;
                }
            }
            if moves {
                scene.strain = StrainChoice::Large;
            }
        })?;
        match time {
            Time::Step(parts) => {
                if parts > 1 {
                    let whole = choose_step(&scene).map_err(|e| Error::from(e).of(&case))?;
                    scene = scene.edited(|scene| scene.step = StepChoice::Fixed(whole / f64::from(parts)))?;
                    case += &format!("-step1/{parts}");
                }
            }
            Time::Tolerance(tolerance, method) => {
                case += &format!("-tol{tolerance:e}");
                if method == TimeMethod::Sdirk {
                    case += "-sdirk";
                }
            }
        }
        if moves {
            case += "-moving";
        }
        if dimension == Dimension::PlaneStrain {
            case += "-plane-strain";
        }
        // Names of scenes have no slash.
        scene = scene.edited(|scene| scene.name = case.replace('/', " of "))?;
        Ok(Self { case, solver: Solver::Points(Box::new(scene)) })
    }

    /// A run of the baseline.
    pub fn volumes(soil: Soil, volumes: FiniteVolumes) -> Self {
        let graded = if volumes.kind == Kind::Graded { "-graded" } else { "" };
        let case = format!("{}{graded}-cells{}-steps{}", baseline::NAME, volumes.cells, volumes.steps);
        Self { case, solver: Solver::Volumes(volumes, soil) }
    }
}

/// The command that runs a setting of material points by itself; `None` where the command line has no word for it.
///
/// `method` and `step` are those of its row; a step is only given where it is not the automatic one.
pub fn command(row: &crate::row::Row) -> Option<String> {
    if baseline::is(&row.integrator) || row.method == "sdirk" || row.case.ends_with("-moving") {
        return None;
    }
    let mut text = format!(
        "cargo run --release -- study --integrator {} --scheme {} --mesh {} --ppc {} --load surface",
        row.integrator, row.scheme, row.mesh_m, row.ppc
    );
    if row.integrator == "quasi-static" {
        text += &format!(" --tolerance {:e}", row.dt_or_tol);
    } else if row.case.contains("-step1/") {
        text += &format!(" --dt {:e}", row.dt_or_tol);
    }
    if row.dimension == "plane-strain" {
        text += " --width full";
    }
    Some(text + " --no-budget --no-sweeps --no-cost --out reports/setting")
}

//! Which settings are run, and which are not, with the reason.

use std::collections::HashSet;

use mpm_core::scene::{Dimension, Integrator, Scene, ShapeChoice, TimeMethod};
use mpm_verify::error::Error;
use mpm_verify::study::{INTEGRATORS, SHAPES};

use crate::baseline::{FiniteVolumes, Kind, Soil};
use crate::setting::{Choice, Setting, Time};

/// What to run.
#[derive(Debug)]
pub struct Plan {
    /// Every setting once.
    pub settings: Vec<Setting>,
    /// Times that each is come back to.
    pub visits: usize,
    /// What a reader might look for and not find, with the reason.
    pub left_out: Vec<String>,
}

/// How much is varied.
#[derive(Debug, Clone, Copy)]
struct Extent {
    /// Cell edges, m; all divide 1 m, and are short decimals so that a command line can say them.
    meshes: &'static [f64],
    /// Particles per cell.
    particles: &'static [usize],
    /// Tolerances of quasi-static runs.
    tolerances: &'static [f64],
    /// Parts of the automatic step: explicit, semi-implicit.
    parts: [&'static [u32]; 2],
    /// Finest mesh of explicit runs with `centre` or `linear`, and with wide shape functions, m.
    explicit_down_to: [f64; 2],
    /// Meshes of the runs over the full width, m.
    plane: &'static [f64],
    /// Cells of the baseline.
    cells: &'static [usize],
    /// Steps of the baseline in each hundredth of the time (plain), to each sample time (graded).
    steps: &'static [usize],
    /// Visits.
    visits: usize,
}

const WHOLE: Extent = Extent {
    meshes: &[0.5, 0.25, 0.2, 0.125, 0.1, 0.05, 0.04, 0.025, 0.02, 0.0125, 0.01],
    particles: &[1, 4, 9],
    tolerances: &[1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6],
    parts: [&[1, 2], &[1, 2, 4]],
    explicit_down_to: [0.01, 0.02],
    plane: &[0.1, 0.05, 0.025],
    cells: &[5, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 80, 100, 150, 200],
    steps: &[1, 2, 3, 4, 5, 6, 8, 10, 15, 20, 30, 50, 100],
    visits: 3,
};

const QUICK: Extent = Extent {
    meshes: &[0.25, 0.2, 0.125, 0.1, 0.05, 0.025, 0.02],
    particles: &[4, 9],
    tolerances: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5],
    parts: [&[1], &[1, 2]],
    explicit_down_to: [0.02, 0.05],
    plane: &[0.1],
    cells: &[10, 20, 30, 50, 80, 100, 200],
    steps: &[2, 4, 6, 10, 20, 50],
    visits: 1,
};

/// Finest mesh (m) and smallest tolerance of runs whose mesh moves with the soil: the strain that the series leaves out is 2e-4 of U.
const MOVING_DOWN_TO: f64 = 0.04;
const MOVING_TOLERANCE: f64 = 1e-4;

/// Finest mesh on which an explicit run with half its step is worth its time, m.
const HALF_STEP_DOWN_TO: f64 = 0.02;

impl Plan {
    /// The whole sweep, or one that takes less than a minute.
    ///
    /// # Errors
    /// A base scene that is not the column of the study.
    pub fn new(base: &Scene, quick: bool) -> Result<Self, Error> {
        let extent = if quick { QUICK } else { WHOLE };
        let soil = Soil::of(base).ok_or(Error::Unfit("expected a column drained at the top under a step load"))?;
        let mut settings = Vec::new();
        for choice in choices(&extent) {
            settings.push(Setting::points(base, &choice)?);
        }
        for kind in Kind::ALL {
            for &cells in extent.cells {
                let volumes = |steps: &usize| FiniteVolumes { kind, cells, steps: steps * kind.unit() };
                settings.extend(extent.steps.iter().map(volumes).map(|v| Setting::volumes(soil, v)));
            }
        }
        let names: HashSet<&String> = settings.iter().map(|s| &s.case).collect();
        debug_assert_eq!(names.len(), settings.len(), "two settings share a name");
        Ok(Self { settings, visits: extent.visits, left_out: left_out(&extent, quick) })
    }
}

impl Plan {
    /// Keeps the settings whose name contains a text.
    ///
    /// # Errors
    /// There is none.
    pub fn only(&mut self, text: &str) -> Result<(), Error> {
        let example = self.settings.first().map_or_else(String::new, |s| s.case.clone());
        self.settings.retain(|s| s.case.contains(text));
        if self.settings.is_empty() {
            let expected = format!("part of the name of a setting, such as {example}");
            return Err(Error::refused("--only", expected, text));
        }
        self.left_out.insert(0, format!("Every setting whose name does not contain `{text}` (`--only`)."));
        Ok(())
    }
}

fn choices(extent: &Extent) -> Vec<Choice> {
    let mut choices = Vec::new();
    for integrator in INTEGRATORS {
        for shape in SHAPES {
            for &mesh in extent.meshes {
                for &ppc in extent.particles {
                    let at = |time| Choice {
                        integrator,
                        shape,
                        mesh,
                        ppc,
                        time,
                        dimension: Dimension::Column,
                        moves: false,
                    };
                    choices.extend(times(extent, integrator).into_iter().map(at).filter(|c| is_run(extent, c)));
                }
            }
        }
    }
    let full = |&mesh: &f64| Choice {
        integrator: Integrator::Explicit,
        shape: ShapeChoice::Centre,
        mesh,
        ppc: 4,
        time: Time::Step(1),
        dimension: Dimension::PlaneStrain,
        moves: false,
    };
    choices.extend(extent.plane.iter().map(full));
    let (shape, dimension) = (ShapeChoice::Bspline2, Dimension::Column);
    for integrator in [Integrator::QuasiStatic, Integrator::Implicit] {
        for &mesh in extent.meshes.iter().filter(|mesh| **mesh >= MOVING_DOWN_TO) {
            let at = |time| Choice { integrator, shape, mesh, ppc: 4, time, dimension, moves: true };
            let tolerances = extent.tolerances.iter().filter(|tolerance| **tolerance >= MOVING_TOLERANCE);
            choices.extend(tolerances.map(|tolerance| at(Time::Tolerance(*tolerance, TimeMethod::Auto))));
        }
    }
    choices
}

fn times(extent: &Extent, integrator: Integrator) -> Vec<Time> {
    let steps = |parts: &[u32]| parts.iter().map(|n| Time::Step(*n)).collect();
    match integrator {
        Integrator::Explicit => steps(extent.parts[0]),
        Integrator::SemiImplicit => steps(extent.parts[1]),
        // The staggered integrator solves seepage with a free surface: a column that consolidates has none.
        // The implicit one is run with a mesh that moves.
        Integrator::Staggered | Integrator::Coupled | Integrator::Implicit => Vec::new(),
        Integrator::QuasiStatic => {
            let methods = [TimeMethod::Auto, TimeMethod::Sdirk];
            methods.iter().flat_map(|m| extent.tolerances.iter().map(|t| Time::Tolerance(*t, *m))).collect()
        }
    }
}

/// Whether a setting is worth its time; [`left_out`] says why not.
fn is_run(extent: &Extent, choice: &Choice) -> bool {
    let wide = choice.shape.is_wide();
    let no_finer = |than: f64| choice.mesh >= than * (1.0 - 1e-9);
    match (choice.integrator, choice.time) {
        (Integrator::Explicit, Time::Step(parts)) => {
            let [narrow_to, wide_to] = extent.explicit_down_to;
            let half = parts == 1 || choice.ppc == 4 && no_finer(HALF_STEP_DOWN_TO);
            no_finer(if wide { wide_to } else { narrow_to }) && half
        }
        // Fewer points than unknowns.
        (Integrator::QuasiStatic, _) if choice.shape.spline_degree().is_some() => choice.ppc >= 4,
        _ => true,
    }
}

fn left_out(extent: &Extent, quick: bool) -> Vec<String> {
    let [narrow_to, wide_to] = extent.explicit_down_to;
    let mut notes = vec![
        format!(
            "Explicit runs finer than L = {narrow_to} m (`centre`, `linear`) and {wide_to} m (`gimp`, `bspline2`): they take \
             seconds to minutes each, and coarser semi-implicit and quasi-static runs are as accurate at a fraction \
             of that."
        ),
        format!(
            "Explicit runs with half the automatic step, but for 4 particles per cell and L of {HALF_STEP_DOWN_TO} m and \
             more: at twice the cost they change the error by less than the cells do."
        ),
        "Quasi-static `bspline2` with 1 particle per cell: fewer points than unknowns.".to_owned(),
        "Load on the particles: its error is of first order in L, and more than ten times that of the load on the \
         surface at the same cost (`mpm-verify study`)."
            .to_owned(),
        format!(
            "Runs whose mesh moves with the soil (large strain, quasi-static and implicit) below L = {MOVING_DOWN_TO} m or a tolerance of \
             {MOVING_TOLERANCE:e}: the series is one of small strain, which this load makes 2e-4 of U."
        ),
        "The paper's own step of 1e-7 s: 3 to 110 times the steps of the automatic one for the same error.".to_owned(),
        "Semi-implicit and quasi-static runs over the full width: their column gives the same numbers for less. The \
         explicit ones that were run show what a second dimension costs."
            .to_owned(),
        "More than one thread: no setting here has enough particles to gain by it.".to_owned(),
    ];
    if quick {
        notes.push(
            "A quick sweep: fewer meshes, particles, tolerances and steps than without `--quick`, each visited once."
                .to_owned(),
        );
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_integrator_runs_every_scheme_under_its_own_name() {
        for quick in [false, true] {
            let plan = Plan::new(&mpm_verify::scenes::terzaghi(), quick).expect("a plan");
            let names: HashSet<&str> = plan.settings.iter().map(|s| s.case.as_str()).collect();
            assert_eq!(names.len(), plan.settings.len());
            for integrator in INTEGRATORS {
                for shape in SHAPES {
                    let start = format!("{}-{}-", mpm_verify::study::word(integrator), mpm_verify::study::word(shape));
                    assert!(names.iter().any(|n| n.starts_with(&start)), "{start}");
                }
            }
            assert!(names.iter().any(|n| n.starts_with("baseline-")) && names.iter().any(|n| n.ends_with("-strain")));
            assert!(!plan.left_out.is_empty());
        }
    }

    #[test]
    fn what_is_left_out_is_not_run() {
        let plan = Plan::new(&mpm_verify::scenes::terzaghi(), false).expect("a plan");
        let count = |what: &str| plan.settings.iter().filter(|s| s.case.starts_with(what)).count();
        assert_eq!((count("explicit-gimp-L0.0125"), count("quasi-static-bspline2-L0.1-ppc1")), (0, 0));
        assert_eq!(count("explicit-centre-L0.01-"), 3);
        assert_eq!(count("explicit-centre-L0.025-ppc4"), 3, "whole step, half step, full width");
    }
}

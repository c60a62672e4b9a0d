//! The summary: every scheme in every case.

use serde::{Deserialize, Serialize};

use super::case::{Case, Judged, Point, Verdict};
use super::scheme::Scheme;
use super::{
    contrast, crossing, hourglass, incompressible, loaded_surface, low_permeability, moving_consolidation, patch,
    small_nodes, stiff_water, sudden_load, too_fine,
};
use crate::error::Error;
use crate::experiment::pool;
use crate::progress::Progress;
use crate::study::word;

/// All cases, in the order of the page.
pub const CASES: [Case; 16] = [
    low_permeability::CASE,
    stiff_water::CASE,
    sudden_load::CASE,
    incompressible::CASE,
    crossing::COLUMN,
    crossing::BLOCK,
    moving_consolidation::SHIFTED,
    moving_consolidation::MOVING_CASE,
    loaded_surface::CASE,
    hourglass::CASE,
    patch::CASE,
    too_fine::CASE,
    small_nodes::EDGE,
    small_nodes::ALONE,
    contrast::CONDUCTIVITY,
    contrast::STIFFNESS,
];

/// A scheme in a case.
#[derive(Debug)]
pub struct Found {
    /// Place of the case in the list that was run.
    pub case: usize,
    /// The scheme.
    pub scheme: Scheme,
    /// What it did at every parameter.
    pub points: Vec<Point>,
    /// What to make of that.
    pub judged: Judged,
}

/// A row of `matrix.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MatrixRow {
    /// Name of the case.
    pub case: String,
    /// Shape functions and options.
    pub scheme: String,
    /// Time integrator.
    pub integrator: String,
    /// How the scheme bears the case.
    pub verdict: Verdict,
    /// The largest value; where it breaks, the value there, or nothing if the run stopped.
    pub value: Option<f64>,
    /// Value up to which it holds.
    pub threshold: f64,
    /// Value beyond which it breaks.
    pub breaks_above: f64,
    /// What the value is.
    pub measures: String,
    /// What makes the case harder.
    pub parameter: String,
    /// Its value where the verdict was made.
    pub at: f64,
    /// Why the run stopped, if it did.
    pub reason: String,
    /// Whether a scene gets the scheme where it says nothing else.
    pub default: bool,
}

/// A row of `stress_tests.csv`: one parameter of one scheme in one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointRow {
    /// Name of the case.
    pub case: String,
    /// Shape functions and options.
    pub scheme: String,
    /// Time integrator.
    pub integrator: String,
    /// What makes the case harder.
    pub parameter: String,
    /// Its value.
    pub at: f64,
    /// What was measured, if anything could be.
    pub value: Option<f64>,
    /// Why not.
    pub reason: String,
}

impl Found {
    /// As a row of the matrix.
    pub fn row(&self, cases: &[Case]) -> MatrixRow {
        let case = &cases[self.case];
        MatrixRow {
            case: case.name.to_owned(),
            scheme: self.scheme.name(),
            integrator: word(self.scheme.integrator),
            verdict: self.judged.verdict,
            value: self.judged.value,
            threshold: case.holds,
            breaks_above: case.breaks,
            measures: case.measures.to_owned(),
            parameter: case.parameter.to_owned(),
            at: self.judged.at,
            reason: self.judged.reason.clone(),
            default: self.scheme.is_default(case.dimension),
        }
    }

    /// All its points.
    pub fn point_rows(&self, cases: &[Case]) -> Vec<PointRow> {
        let case = &cases[self.case];
        let row = |point: &Point| PointRow {
            case: case.name.to_owned(),
            scheme: self.scheme.name(),
            integrator: word(self.scheme.integrator),
            parameter: case.parameter.to_owned(),
            at: point.at,
            value: point.found.as_ref().ok().copied(),
            reason: point.found.as_ref().err().map_or_else(String::new, Error::to_string),
        };
        self.points.iter().map(row).collect()
    }
}

/// Runs every scheme that is `asked` in every case on so many threads (0 for all); in the order of cases and schemes.
pub fn matrix(cases: &[Case], asked: impl Fn(&Case, &Scheme) -> bool, jobs: usize, progress: &Progress) -> Vec<Found> {
    let all = cases.iter().enumerate().flat_map(|(i, case)| case.schemes.iter().map(move |scheme| (i, *scheme)));
    let tasks: Vec<(usize, Scheme)> = all.filter(|(i, scheme)| asked(&cases[*i], scheme)).collect();
    let mut done = 0;
    let results = pool::each(
        jobs,
        &tasks,
        |_, (case, scheme)| (cases[*case].run)(scheme),
        |_, _| {
            done += 1;
            progress.set((1_000_000 * done / tasks.len()) as u64);
        },
    );
    let find = |((case, scheme), result): (&(usize, Scheme), Result<Vec<Point>, Error>)| {
        let (points, judged) = match result {
            Ok(points) => {
                let judged = cases[*case].judge(&points);
                (points, judged)
            }
            Err(panic) => {
                let reason = panic.to_string();
                (Vec::new(), Judged { verdict: Verdict::Failed, value: None, at: f64::NAN, reason })
            }
        };
        Found { case: *case, scheme: *scheme, points, judged }
    };
    tasks.iter().zip(results).map(find).collect()
}

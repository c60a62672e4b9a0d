//! Errors in time alone, and what they cost in steps, factorisations and solves.
//!
//! | integrator | steps | reference in time |
//! |---|---|---|
//! | quasi-static | from a tolerance | the run with tolerance 1e-10 on the same mesh |
//! | explicit, semi-implicit | shares of the stability limit | extrapolated from the two shortest steps, order one |

use mpm_core::scene::{Integrator, Scene, ShapeChoice, StepChoice, TimeMethod};
use mpm_core::stability::stable_limit;
use serde::{Deserialize, Serialize};

use super::{MESHES, PARTICLES, column, errors, run_all};
use crate::error::Error;
use crate::norms::{largest, relative};
use crate::study::{CaseResult, Runner, or_nan, word};

/// Tolerances, loose first.
pub const TOLERANCES: [f64; 7] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
/// Tolerance of the reference.
const EXACT: f64 = 1e-10;
/// Steps as shares of the stability limit, long first, each half of the one before.
pub const SHARES: [f64; 3] = [0.9, 0.45, 0.225];
/// The mesh of the runs with given steps, m.
const GIVEN_MESH: f64 = 0.05;
/// Methods with steps of their own choice.
const METHODS: [TimeMethod; 2] = [TimeMethod::Krylov, TimeMethod::Sdirk];
/// Schemes with given steps.
const GIVEN: [(Integrator, ShapeChoice); 4] = [
    (Integrator::Explicit, ShapeChoice::Centre),
    (Integrator::Explicit, ShapeChoice::Bspline2),
    (Integrator::SemiImplicit, ShapeChoice::Centre),
    (Integrator::SemiImplicit, ShapeChoice::Bspline2),
];

/// A row of `time_error.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimeError {
    /// Integrator.
    pub integrator: String,
    /// Shape functions.
    pub scheme: String,
    /// `krylov` or `sdirk`; empty for given steps.
    pub method: String,
    /// Cell edge, m.
    pub mesh_m: f64,
    /// Particles per cell.
    pub ppc: usize,
    /// Tolerance asked for, if steps follow from one.
    pub tolerance: Option<f64>,
    /// Step as a share of the stability limit, if given.
    pub step_share: Option<f64>,
    /// Steps that were kept; of the Krylov method basis vectors.
    pub accepted_steps: u64,
    /// Steps that were repeated.
    pub rejected_steps: u64,
    /// Factorisations.
    pub factorisations: u64,
    /// Solves.
    pub solves: u64,
    /// CPU time, s.
    pub cpu_s: f64,
    /// Largest |U/U_ref - 1|, U_ref without error in time on the same mesh.
    #[serde(deserialize_with = "or_nan")]
    pub time_error: f64,
    /// Largest error against compressible water.
    #[serde(deserialize_with = "or_nan")]
    pub max_error_compressible: f64,
    /// Why the run failed, if it did.
    pub failure: Option<String>,
}

impl TimeError {
    /// Integrator with its method, or its shape functions: how a line of a picture is called.
    pub fn label(&self) -> String {
        let which = if self.method.is_empty() { &self.scheme } else { &self.method };
        format!("{} {which}", self.integrator)
    }
}

/// Runs all tolerances and steps.
///
/// # Errors
/// No threads.
pub fn sweep(base: &Scene, runner: &mut Runner, cpu_s: &mut f64) -> Result<Vec<TimeError>, Error> {
    let mut rows = chosen_steps(base, runner, cpu_s)?;
    rows.extend(given_steps(base, runner, cpu_s)?);
    Ok(rows)
}

/// The sample values of U; empty for a run that failed.
fn degrees(result: Option<&CaseResult>) -> Vec<f64> {
    match result {
        Some(r) if r.failure.is_none() => r.degrees.iter().map(|d| d.u).collect(),
        _ => Vec::new(),
    }
}

/// Largest |u/reference - 1|; NaN where one is missing.
fn largest_difference(u: &[f64], reference: &[f64]) -> f64 {
    if u.is_empty() || u.len() != reference.len() {
        return f64::NAN;
    }
    largest(u.iter().zip(reference).map(|(u, r)| relative(*u, *r)))
}

fn row(scene: &Result<Scene, Error>, run: Option<&CaseResult>, reference: &[f64]) -> Option<TimeError> {
    let (max, _, _, failure) = errors(scene, run);
    let scene = scene.as_ref().ok()?;
    let own_steps = scene.integrator == Integrator::QuasiStatic;
    let count = |of: fn(&CaseResult) -> u64| run.map_or(0, of);
    Some(TimeError {
        integrator: word(scene.integrator),
        scheme: word(scene.shape),
        method: if own_steps { word(scene.method) } else { String::new() },
        mesh_m: scene.cell,
        ppc: PARTICLES,
        tolerance: own_steps.then_some(scene.tolerance),
        step_share: match scene.step {
            StepChoice::Fixed(step) => Some(step / stable_limit(scene)),
            _ => None,
        },
        accepted_steps: count(|r| r.accepted_steps),
        rejected_steps: count(|r| r.rejected_steps),
        factorisations: count(|r| r.factorisations),
        solves: count(|r| r.solves),
        cpu_s: run.map_or(f64::NAN, |r| r.cpu_s),
        time_error: largest_difference(&degrees(run), reference),
        max_error_compressible: max,
        failure,
    })
}

/// Quasi-static runs over tolerances.
fn chosen_steps(base: &Scene, runner: &mut Runner, cpu_s: &mut f64) -> Result<Vec<TimeError>, Error> {
    let scene = |mesh: f64, method: TimeMethod, tolerance: f64| {
        Ok(column(base, Integrator::QuasiStatic, ShapeChoice::Bspline2, mesh)?
            .edited(|scene| (scene.method, scene.tolerance) = (method, tolerance))?)
    };
    let mut rows = Vec::new();
    for mesh in MESHES {
        let mut scenes = vec![scene(mesh, TimeMethod::Krylov, EXACT)];
        for method in METHODS {
            scenes.extend(TOLERANCES.map(|tolerance| scene(mesh, method, tolerance)));
        }
        let results = run_all(&scenes, (&format!("tolerance-L{mesh}"), true), runner)?;
        *cpu_s += results.iter().flatten().map(|r| r.cpu_s).sum::<f64>();
        let reference = degrees(results[0].as_ref());
        rows.extend(
            scenes.iter().zip(&results).skip(1).filter_map(|(scene, result)| row(scene, result.as_ref(), &reference)),
        );
    }
    Ok(rows)
}

/// Explicit and semi-implicit runs over steps.
fn given_steps(base: &Scene, runner: &mut Runner, cpu_s: &mut f64) -> Result<Vec<TimeError>, Error> {
    let scene = |(integrator, shape): (Integrator, ShapeChoice), share: f64| {
        Ok(column(base, integrator, shape, GIVEN_MESH)?
            .edited(|scene| scene.step = StepChoice::Fixed(share * stable_limit(scene)))?)
    };
    let scenes: Vec<Result<Scene, Error>> =
        GIVEN.iter().flat_map(|family| SHARES.map(|share| scene(*family, share))).collect();
    let results = run_all(&scenes, ("step", true), runner)?;
    *cpu_s += results.iter().flatten().map(|r| r.cpu_s).sum::<f64>();
    let mut rows = Vec::new();
    for (scenes, results) in scenes.chunks(SHARES.len()).zip(results.chunks(SHARES.len())) {
        let [long, short] = [1, 2].map(|place| degrees(results[place].as_ref()));
        let reference: Vec<f64> = long.iter().zip(&short).map(|(long, short)| 2.0 * short - long).collect();
        rows.extend(scenes.iter().zip(results).filter_map(|(scene, result)| row(scene, result.as_ref(), &reference)));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use mpm_core::scene::Until;

    use crate::progress::Progress;

    use super::*;

    #[test]
    fn halving_the_step_halves_the_error_in_time() {
        // The first fiftieth is enough to see it.
        let shorter = crate::scenes::terzaghi().edited(|base| {
            base.observe_times.truncate(2);
            base.stages[0].until = Until::Time(base.observe_times[1]);
        });
        let base = shorter.expect("a sound scene");
        let rows = given_steps(&base, &mut Runner::whole(1, &Progress::new("", true)), &mut 0.0).expect("threads");
        let explicit: Vec<&TimeError> =
            rows.iter().filter(|r| (r.integrator.as_str(), r.scheme.as_str()) == ("explicit", "centre")).collect();
        assert_eq!(explicit.len(), SHARES.len());
        for (row, share) in explicit.iter().zip(SHARES) {
            assert!((row.step_share.expect("a share") / share - 1.0).abs() < 1e-12 && row.failure.is_none());
            assert_eq!((row.tolerance, row.factorisations), (None, 0));
        }
        let halved = explicit[1].time_error / explicit[2].time_error;
        assert!((halved - 2.0).abs() < 1e-6, "the reference is the extrapolation of these two: {halved}");
        let all = explicit[0].time_error / explicit[1].time_error;
        assert!((1.5..3.0).contains(&all), "{all}");
    }

    #[test]
    fn a_missing_reference_is_no_error_of_zero() {
        assert!(largest_difference(&[1.0], &[]).is_nan() && largest_difference(&[], &[]).is_nan());
        assert_eq!(largest_difference(&[1.1], &[1.0]), relative(1.1, 1.0));
    }
}

//! The accuracy study: integrator x shape functions x mesh x particles per cell x load, each run compared with the
//! exact solutions of its own model.
//!
//! # Reading order
//! 1. [`plan`]: which cases. 2. This file: run one and compare. 3. [`result`]: what is kept of a case. 4. [`runner`]: run many,
//!    or a share of them. [`store`]: those that are done.

pub mod plan;
pub mod result;
pub mod runner;
pub mod store;

use std::sync::atomic::{AtomicBool, Ordering};

use cpu_time::ThreadTime;
use mpm_core::drive::{Monitor, Run, Sample, Wish};
use mpm_core::hardware::Hardware;
use mpm_core::observe::{BalanceTerms, ProfileRow};
use mpm_core::run::{StartError, run, run_monitored};
use mpm_core::scene::{Integrator, Scene, ShapeChoice};
use mpm_core::stability::{choose_step, stable_limit};
use serde::Serialize;

pub use plan::{Case, Extent, Family, INTEGRATORS, MESHES, Plan, SHAPES, TOLERANCE, case_name};
pub use result::{
    CaseResult, Degree, HistoryPoint, PAPER_FAMILY, Profile, ProfilePoint, Variant, or_nan, shown_family,
};
pub use runner::{Listed, Runner, Share, Task};
pub use store::Store;

use crate::error::Error::{self, Unfit};
use crate::exact::dynamic::DynamicColumn;
use crate::exact::semidiscrete::SemiDiscrete;
use crate::exact::terzaghi::Terzaghi;
use crate::norms::{LATE_TV, SAMPLE_TV, largest, profile_error, relative};
use crate::progress::Progress;

/// A word as it stands in scene files and tables.
pub fn word(value: impl Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

impl Plan {
    /// Runs all cases in parallel. Results in the order of integrator, shape, mesh (coarse first), particles, load,
    /// variant.
    ///
    /// # Errors
    /// A step above the stability limit, a load that a scheme does not bear, or a mesh that does not fit, before anything is run.
    pub fn run(&self, progress: &Progress) -> Result<Vec<CaseResult>, Error> {
        self.run_by(&mut Runner::whole(self.jobs, progress))
    }

    /// The same by a runner, which may leave cases out.
    ///
    /// # Errors
    /// As [`Plan::run`].
    pub fn run_by(&self, runner: &mut Runner) -> Result<Vec<CaseResult>, Error> {
        let mut results: Vec<CaseResult> = runner.run(&self.tasks()?)?.into_iter().flatten().collect();
        let place = |r: &CaseResult| {
            let family = |f: &Family| word(f.integrator) == r.integrator && word(f.shape) == r.scheme;
            self.families.iter().position(family)
        };
        let order = |r: &CaseResult| (r.ppc, r.load.clone(), r.variant as u8);
        results.sort_by(|a, b| {
            let meshes = b.mesh_m.total_cmp(&a.mesh_m);
            place(a).cmp(&place(b)).then(meshes).then_with(|| order(a).cmp(&order(b)))
        });
        Ok(results)
    }

    /// All cases as tasks, the longest first.
    ///
    /// # Errors
    /// As [`Plan::run`].
    pub fn tasks(&self) -> Result<Vec<Task>, Error> {
        let cases = self.cases()?;
        for case in &cases {
            case.scene.bears_its_load().map_err(|e| Error::from(e).of(&case.name))?;
            choose_step(&case.scene).map_err(|e| Error::from(e).of(&case.name))?;
            comparable(case)?;
        }
        let key = |case: &Case| match case.variant {
            Variant::Base => case.name.clone(),
            variant => format!("{}-{}", case.name, word(variant)),
        };
        Ok(cases.into_iter().map(|case| Task { key: key(&case), case, again: true }).collect())
    }
}

/// A case that takes less than this is run again for its time, s.
const QUICK: f64 = 2e-2;
/// Times at most that a quick case is run.
const REPETITIONS: usize = 20;
/// CPU time that repetitions may take, s.
const PATIENCE: f64 = 0.02;

impl Case {
    /// Runs the case, a quick one at most some times for its time, and compares it with the exact solutions. A case that
    /// cannot be started is one that failed; `None` for one that was stopped.
    ///
    /// # Errors
    /// A step above the stability limit, or a scene without water or load.
    fn watched(&self, at_most: usize, watched: &mut Watched) -> Result<Option<CaseResult>, Error> {
        let ran = timed(&self.scene, at_most, watched).map_err(|e| Error::from(e).of(&self.name))?;
        let Some((run, cpu_s)) = ran else { return Ok(None) };
        self.compare(&run, cpu_s).map(Some)
    }

    /// Compares a run of the case that took some CPU time (s) with the exact solutions.
    ///
    /// # Errors
    /// A scene without water or load.
    pub fn compare(&self, run: &Run, cpu_s: f64) -> Result<CaseResult, Error> {
        compare(self, run, cpu_s)
    }
}

/// Tells how far a run has come, and stops it.
struct Watched<'a> {
    told: &'a mut dyn FnMut(f64),
    stop: &'a AtomicBool,
}

impl Monitor for Watched<'_> {
    fn look(&mut self, share: f64) -> Wish {
        (self.told)(share);
        if self.stop.load(Ordering::Relaxed) { Wish::Stop } else { Wish::GoOn }
    }

    /// A case of a study is done or not.
    fn save(&mut self, _: Vec<u8>) {}
}

/// Runs a scene and takes its CPU time, s: of a quick one the median of at most some runs. `None` if it was stopped.
///
/// # Errors
/// A step above the stability limit.
fn timed(scene: &Scene, at_most: usize, watched: &mut Watched) -> Result<Option<(Run, f64)>, StartError> {
    let clock = ThreadTime::now();
    let first = match run_monitored(&Hardware::default(), scene, None, watched) {
        Err(StartError::Place(failure)) => return Ok(Some((nothing(scene, failure), clock.elapsed().as_secs_f64()))),
        other => other?,
    };
    if first.stopped {
        return Ok(None);
    }
    let mut times = vec![clock.elapsed().as_secs_f64()];
    while times[0] < QUICK && times.len() < at_most && times.iter().sum::<f64>() < PATIENCE {
        let clock = ThreadTime::now();
        run(scene, &mut |_| {})?;
        times.push(clock.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(Some((first, times[times.len() / 2])))
}

/// A run that ended before its first step.
fn nothing(scene: &Scene, failure: mpm_core::error::RunError) -> Run {
    Run { dt: f64::NAN, solid_particles: scene.solid_particles(), failure: Some(failure), ..Run::default() }
}

/// Terzaghi's solutions of a case, with incompressible and with compressible water.
fn comparable(case: &Case) -> Result<[Terzaghi; 2], Error> {
    let missing = || Unfit("the study needs water, a surcharge on the whole top, tight roller sides").of(&case.name);
    let incompressible = Terzaghi::incompressible(&case.scene).ok_or_else(missing)?;
    Ok([incompressible, Terzaghi::compressible(&case.scene).ok_or_else(missing)?])
}

/// Compares a finished run with the exact solutions of its scene.
fn compare(case: &Case, run: &Run, cpu_s: f64) -> Result<CaseResult, Error> {
    let scene = &case.scene;
    let [terzaghi, compressible] = comparable(case)?;
    // Solutions of a model with inertia, and of cells with one pressure each: only for runs of that model.
    let own_steps = scene.integrator == Integrator::QuasiStatic;
    let dynamic = if own_steps { None } else { DynamicColumn::new(scene) };
    let cellwise = matches!(scene.shape, ShapeChoice::Centre | ShapeChoice::Linear);
    let mesh = if cellwise { SemiDiscrete::new(scene) } else { None };
    let whole = terzaghi.load * scene.height / terzaghi.modulus;
    let degree = |time: f64, settlement: f64| Degree {
        tv: terzaghi.time_factor(time),
        time_s: time,
        u: settlement / whole,
        u_terzaghi: terzaghi.relative_settlement(time),
        u_compressible: compressible.relative_settlement(time),
        u_dynamic: dynamic.as_ref().map_or(f64::NAN, |d| d.settlement(time) / whole),
        u_mesh: mesh.as_ref().map_or(f64::NAN, |m| m.settlement(time) / whole),
    };
    let last = scene.stages.len() - 1;
    let sampled: Vec<&Sample> = run.observed().collect();
    let degrees: Vec<Degree> = sampled.iter().map(|s| degree(s.stage_time, s.state.settlement)).collect();
    // The further runs of the budget are only asked for U.
    let kept = if case.variant == Variant::Base { sampled.as_slice() } else { &[] };
    let profiles: Vec<Profile> =
        kept.iter().map(|s| profile(&s.state.profile, s.stage_time, &terzaghi, &compressible)).collect();
    let at_late = sampled.iter().find(|s| (terzaghi.time_factor(s.stage_time) / LATE_TV - 1.0).abs() < 1e-6);
    let profile_error_to =
        |exact: &Terzaghi| at_late.map_or(f64::NAN, |s| profile_error(&s.state.profile, exact, s.stage_time));
    let late = |d: &&Degree| d.tv >= LATE_TV * (1.0 - 1e-6);
    // A run that stopped early has no error: NaN, never the best of what is left.
    let whole_run =
        run.failure.is_none() && SAMPLE_TV.iter().all(|tv| degrees.iter().any(|d| (d.tv / tv - 1.0).abs() < 1e-6));
    let only_whole = |error: f64| if whole_run { error } else { f64::NAN };
    let end = run.samples.last();
    let in_history = |s: &&Sample| case.variant == Variant::Base && s.stage == last && s.stage_time > 0.0;
    let history = run.samples.iter().filter(in_history);
    let limit = stable_limit(scene);
    let steps = if own_steps { run.work.accepted } else { run.steps };
    Ok(CaseResult {
        particles: run.solid_particles,
        dt_s: step_length(scene, run),
        steps,
        max_error_terzaghi: only_whole(largest(degrees.iter().map(|d| relative(d.u, d.u_terzaghi)))),
        late_error_terzaghi: only_whole(largest(degrees.iter().filter(late).map(|d| relative(d.u, d.u_terzaghi)))),
        max_error_compressible: only_whole(largest(degrees.iter().map(|d| relative(d.u, d.u_compressible)))),
        late_error_compressible: only_whole(largest(
            degrees.iter().filter(late).map(|d| relative(d.u, d.u_compressible)),
        )),
        profile_error_compressible: profile_error_to(&compressible),
        profile_error_terzaghi: profile_error_to(&terzaghi),
        settlement_final_m: end.map_or(f64::NAN, |s| s.state.settlement),
        cell_crossings: end.map_or(0, |s| s.state.solid_crossings + s.state.water_crossings),
        cpu_s,
        ns_per_point_step: cpu_s * 1e9 / (steps.max(1) as f64 * run.solid_particles as f64),
        limit_s: Some(limit).filter(|l| l.is_finite()).unwrap_or(f64::NAN),
        forced: scene.force && run.dt > limit,
        bytes_per_point: run.bytes / run.solid_particles,
        failure: run.failure.as_ref().map(ToString::to_string),
        accepted_steps: steps,
        rejected_steps: run.work.rejected,
        factorisations: run.work.factorisations,
        solves: run.work.solves,
        tolerance: own_steps.then_some(scene.tolerance),
        degrees,
        profiles,
        history: history.map(|s| point(s.stage_time, s.state.settlement / whole, &terzaghi, &s.balance)).collect(),
        ..CaseResult::of(case)
    })
}

/// The step that was asked for, s; the average one of an integrator that chooses, NaN if it made none.
fn step_length(scene: &Scene, run: &Run) -> f64 {
    if run.dt.is_finite() {
        return run.dt;
    }
    let end = scene.observe_times.last().copied().unwrap_or(f64::NAN);
    if run.work.accepted > 0 { end / run.work.accepted as f64 } else { f64::NAN }
}

fn profile(rows: &[ProfileRow], time: f64, terzaghi: &Terzaghi, compressible: &Terzaghi) -> Profile {
    let point = |row: &ProfileRow| ProfilePoint {
        height_m: row.material_height_m,
        pressure_pa: row.pressure_pa,
        terzaghi_pa: terzaghi.pressure(row.material_height_m, time),
        compressible_pa: compressible.pressure(row.material_height_m, time),
    };
    Profile { tv: terzaghi.time_factor(time), rows: rows.iter().map(point).collect() }
}

fn point(time_s: f64, u: f64, terzaghi: &Terzaghi, ledger: &BalanceTerms) -> HistoryPoint {
    HistoryPoint {
        time_s,
        tv: terzaghi.time_factor(time_s),
        u,
        kinetic_j: ledger.kinetic_j,
        strain_j: ledger.strain_j,
        water_j: ledger.water_j,
        external_work_j: ledger.external_work_j,
        darcy_dissipation_j: ledger.darcy_dissipation_j,
        flow_body_work_j: ledger.flow_body_work_j,
        energy_residual_j: ledger.energy_residual_j,
        water_residual_kg: ledger.water_residual_kg,
        water_out_kg: ledger.water_out_kg,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use mpm_core::scene::{LoadOn, StepChoice};

    use super::*;

    /// A result without a run behind it: no error at all.
    pub(crate) fn result(mesh: f64, ppc: usize, load: &str) -> CaseResult {
        let degree = |tv: f64| {
            let u = crate::exact::terzaghi::degree(tv);
            Degree { tv, time_s: tv, u, u_terzaghi: u, u_compressible: u, u_dynamic: u, u_mesh: u }
        };
        CaseResult {
            case: format!("explicit-centre-{load}-L{mesh}-ppc{ppc}"),
            variant: Variant::Base,
            integrator: "explicit".to_owned(),
            scheme: "centre".to_owned(),
            load: load.to_owned(),
            mesh_m: mesh,
            ppc,
            particles: 100,
            dt_s: 1e-6,
            steps: 1000,
            max_error_terzaghi: 0.0,
            late_error_terzaghi: 0.0,
            max_error_compressible: 0.0,
            late_error_compressible: 0.0,
            profile_error_compressible: 0.0,
            profile_error_terzaghi: 0.0,
            settlement_final_m: 3.7e-4,
            cell_crossings: 0,
            cpu_s: 0.1,
            ns_per_point_step: 10.0,
            limit_s: 1.1e-6,
            forced: false,
            bytes_per_point: 200,
            dimension: "column".to_owned(),
            scene_hash: String::new(),
            failure: None,
            accepted_steps: 1000,
            rejected_steps: 0,
            factorisations: 0,
            solves: 0,
            tolerance: None,
            strain: "large".to_owned(),
            degrees: SAMPLE_TV.map(degree).to_vec(),
            profiles: Vec::new(),
            history: Vec::new(),
        }
    }

    fn plan(mesh: f64, force_step: Option<f64>) -> Plan {
        let mut base = crate::scenes::terzaghi();
        if let Some(step) = force_step {
            base = base
                .edited(|base| {
                    base.step = StepChoice::Fixed(step);
                    base.force = true;
                })
                .expect("a sound scene");
        }
        Plan {
            base,
            families: vec![Family::whole(Integrator::Explicit, ShapeChoice::Centre)],
            meshes: vec![mesh],
            particles_per_cell: vec![1, 4],
            loads: vec![LoadOn::Surface, LoadOn::Particles],
            tolerance: TOLERANCE,
            budget: false,
            jobs: 2,
        }
    }

    #[test]
    fn results_do_not_depend_on_the_number_of_threads() {
        let quiet = Progress::new("", true);
        let run = |jobs| {
            let mut results = Plan { jobs, ..plan(0.1, None) }.run(&quiet).expect("a study");
            for result in &mut results {
                (result.cpu_s, result.ns_per_point_step) = (0.0, 0.0);
            }
            results
        };
        assert_eq!(run(1), run(2));
    }

    #[test]
    fn a_run_that_blows_up_has_no_error_and_says_why() {
        let results = plan(0.1, Some(3e-5)).run(&Progress::new("", true)).expect("a study");
        for result in results {
            assert!(result.forced && result.failure.is_some() && result.max_error_terzaghi.is_nan(), "{result:?}");
        }
    }

    #[test]
    fn a_mesh_that_does_not_fit_is_refused() {
        let error = plan(0.3, None).run(&Progress::new("", true)).unwrap_err().to_string();
        assert!(error.contains("0.3 m"), "{error}");
    }
}

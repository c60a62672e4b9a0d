//! The accuracy study: mesh x particles per cell x load, each run compared with both exact solutions.

use std::sync::atomic::{AtomicU64, Ordering};

use cpu_time::ThreadTime;
use mpm_core::drive::{Run, Sample};
use mpm_core::observe::{Ledger, ProfileRow};
use mpm_core::run::{StartError, run};
use mpm_core::scene::{Dimension, LoadOn, Scene, ShapeChoice, StepChoice};
use mpm_core::stability::{choose_step, stable_limit};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::exact::dynamic::DynamicColumn;
use crate::exact::semidiscrete::SemiDiscrete;
use crate::exact::terzaghi::Terzaghi;
use crate::manifest::scene_hash;
use crate::norms::{LATE_TV, SAMPLE_TV, largest, profile_error, relative};
use crate::progress::Progress;

/// What to run.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The scene that every case changes.
    pub base: Scene,
    /// Cell edges L, m.
    pub meshes: Vec<f64>,
    /// Particles per cell.
    pub particles_per_cell: Vec<usize>,
    /// What carries the load.
    pub loads: Vec<LoadOn>,
    /// Whether to run the further cases that the error budget needs: half the step, a hundredth of the load.
    pub budget: bool,
    /// Threads.
    pub jobs: usize,
}

/// The meshes of the study, m.
pub const MESHES: [f64; 6] = [0.10, 0.05, 0.025, 0.02, 0.0125, 0.01];

/// How a case differs from the study's own setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// The case itself.
    Base,
    /// Half the time step.
    HalfStep,
    /// A hundredth of the load: strains a hundred times smaller.
    SmallLoad,
}

/// JSON has no NaN and writes null: reads it back.
pub(crate) fn or_nan<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

/// U at one sample time, with what it is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Degree {
    /// Tv = c_v t/H^2.
    pub tv: f64,
    /// Time since drainage began, s.
    pub time_s: f64,
    /// Computed U = S/(q H/M).
    #[serde(deserialize_with = "or_nan")]
    pub u: f64,
    /// Terzaghi's series, incompressible water.
    #[serde(deserialize_with = "or_nan")]
    pub u_terzaghi: f64,
    /// The same with compressible water.
    #[serde(deserialize_with = "or_nan")]
    pub u_compressible: f64,
    /// Compressible water and inertia (u-p model); NaN where no such solution is at hand.
    #[serde(deserialize_with = "or_nan")]
    pub u_dynamic: f64,
    /// Compressible water on the mesh of the case, exact in time; NaN where not at hand.
    #[serde(deserialize_with = "or_nan")]
    pub u_mesh: f64,
}

/// A profile of pore pressure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Time factor.
    pub tv: f64,
    /// Rows from the base up.
    pub rows: Vec<ProfilePoint>,
}

/// A point of a profile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProfilePoint {
    /// Height at t = 0, m.
    pub height_m: f64,
    /// Computed pore pressure, Pa.
    #[serde(deserialize_with = "or_nan")]
    pub pressure_pa: f64,
    /// Terzaghi's, Pa.
    pub terzaghi_pa: f64,
    /// Compressible water, Pa.
    pub compressible_pa: f64,
}

/// A point of the history of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HistoryPoint {
    /// Time since drainage began, s.
    pub time_s: f64,
    /// Time factor.
    pub tv: f64,
    /// U.
    #[serde(deserialize_with = "or_nan")]
    pub u: f64,
    /// Kinetic energy, J.
    #[serde(deserialize_with = "or_nan")]
    pub kinetic_j: f64,
    /// Strain energy, J.
    #[serde(deserialize_with = "or_nan")]
    pub strain_j: f64,
    /// Energy of the compressed water, J.
    #[serde(deserialize_with = "or_nan")]
    pub water_j: f64,
    /// Work of the load, J.
    #[serde(deserialize_with = "or_nan")]
    pub external_work_j: f64,
    /// Energy lost to Darcy flow, J.
    #[serde(deserialize_with = "or_nan")]
    pub darcy_dissipation_j: f64,
    /// Work of rho_w (g - a_s) on the flow, J.
    #[serde(deserialize_with = "or_nan")]
    pub flow_body_work_j: f64,
    /// What is left over, J.
    #[serde(deserialize_with = "or_nan")]
    pub energy_closing_j: f64,
    /// Water balance left over, kg.
    #[serde(deserialize_with = "or_nan")]
    pub water_closing_kg: f64,
    /// Water that has left, kg.
    #[serde(deserialize_with = "or_nan")]
    pub water_out_kg: f64,
}

/// One case, run and compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseResult {
    /// Name, e.g. `explicit-centre-surface-L0.02-ppc4`.
    pub case: String,
    /// How it differs from the study's own setting.
    pub variant: Variant,
    /// Time integrator.
    pub integrator: String,
    /// Shape scheme.
    pub scheme: String,
    /// What carries the load.
    pub load: String,
    /// Cell edge L, m.
    pub mesh_m: f64,
    /// Particles per cell.
    pub ppc: usize,
    /// Solid particles in the run.
    pub particles: usize,
    /// Time step asked for, s.
    pub dt_s: f64,
    /// Steps done.
    pub steps: u64,
    /// Largest error against Terzaghi.
    #[serde(deserialize_with = "or_nan")]
    pub max_error_terzaghi: f64,
    /// The same for Tv >= 0.1.
    #[serde(deserialize_with = "or_nan")]
    pub late_error_terzaghi: f64,
    /// Largest error against compressible water.
    #[serde(deserialize_with = "or_nan")]
    pub max_error_compressible: f64,
    /// The same for Tv >= 0.1.
    #[serde(deserialize_with = "or_nan")]
    pub late_error_compressible: f64,
    /// RMS(p - p_exact)/p_0 at Tv = 0.1, compressible water.
    #[serde(deserialize_with = "or_nan")]
    pub profile_error_compressible: f64,
    /// The same against Terzaghi.
    #[serde(deserialize_with = "or_nan")]
    pub profile_error_terzaghi: f64,
    /// Settlement at the end, m.
    #[serde(deserialize_with = "or_nan")]
    pub settlement_final_m: f64,
    /// Times a solid or water particle changed its cell.
    pub cell_crossings: u64,
    /// CPU time of the run, s.
    pub cpu_s: f64,
    /// CPU time per solid particle and step, ns.
    pub ns_per_point_step: f64,
    /// Stability limit, s.
    pub limit_s: f64,
    /// Whether a step above the limit was forced.
    pub forced: bool,
    /// Bytes per solid particle.
    pub bytes_per_point: usize,
    /// One dimension or plane strain.
    pub dimension: String,
    /// Hash of the scene.
    pub scene_hash: String,
    /// Why the run ended early, if it did.
    pub failure: Option<String>,
    /// U at the sample times.
    pub degrees: Vec<Degree>,
    /// Profiles at the sample times.
    pub profiles: Vec<Profile>,
    /// History of the drainage.
    pub history: Vec<HistoryPoint>,
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

/// A word as it stands in scene files and tables.
pub fn word(value: impl Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Name of a case.
pub fn case_name(scheme: ShapeChoice, load: LoadOn, mesh: f64, ppc: usize) -> String {
    format!("explicit-{}-{}-L{mesh}-ppc{ppc}", word(scheme), word(load))
}

impl Plan {
    /// All cases, the most expensive first.
    ///
    /// # Errors
    /// A mesh that does not divide the column, or no square number of particles: message for the user.
    pub fn cases(&self) -> Result<Vec<Case>, String> {
        let mut cases = Vec::new();
        for &mesh in &self.meshes {
            for &ppc in &self.particles_per_cell {
                for &load in &self.loads {
                    let mut scene = remesh(&self.base, mesh, ppc)?;
                    scene.surcharge = scene.surcharge.map(|s| mpm_core::scene::Surcharge { on: load, ..s });
                    let name = case_name(scene.shape, load, mesh, ppc);
                    scene.name.clone_from(&name);
                    if self.budget && load == LoadOn::Surface {
                        let mut half = scene.clone();
                        half.step = StepChoice::Fixed(0.5 * choose_step(&scene).map_err(|e| e.to_string())?);
                        cases.push(Case { name: name.clone(), variant: Variant::HalfStep, scene: half });
                        let mut small = scene.clone();
                        small.surcharge =
                            small.surcharge.map(|s| mpm_core::scene::Surcharge { pressure: 0.01 * s.pressure, ..s });
                        cases.push(Case { name: name.clone(), variant: Variant::SmallLoad, scene: small });
                    }
                    cases.push(Case { name, variant: Variant::Base, scene });
                }
            }
        }
        cases.sort_by(|a, b| work(&b.scene).total_cmp(&work(&a.scene)));
        Ok(cases)
    }

    /// Runs all cases in parallel. Results in the order of mesh (coarse first), particles, load, variant.
    ///
    /// # Errors
    /// A step above the stability limit or a mesh that does not fit, before anything is run.
    pub fn run(&self, progress: &Progress) -> Result<Vec<CaseResult>, String> {
        let cases = self.cases()?;
        for case in &cases {
            choose_step(&case.scene).map_err(|e| format!("{}: {e}", case.name))?;
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.jobs).build().map_err(|e| e.to_string())?;
        let total: f64 = cases.iter().map(|c| work(&c.scene)).sum();
        let done = AtomicU64::new(0);
        let mut results: Vec<CaseResult> = pool.install(|| {
            // One case at a time per thread, in the given order: the long ones first.
            cases
                .par_iter()
                .with_max_len(1)
                .map(|case| {
                    let own = work(&case.scene);
                    let mut before = 0.0;
                    let result = case.run(&mut |share| {
                        let more = ((share - before) * own / total * 1e6) as u64;
                        if more > 0 {
                            before = share;
                            progress.set(done.fetch_add(more, Ordering::Relaxed) + more);
                        }
                    });
                    if let Ok(result) = &result {
                        progress.line(&result.line());
                    }
                    result
                })
                .collect::<Result<_, _>>()
        })?;
        let order = |r: &CaseResult| (r.ppc, r.load.clone(), r.variant as u8);
        results.sort_by(|a, b| b.mesh_m.total_cmp(&a.mesh_m).then_with(|| order(a).cmp(&order(b))));
        Ok(results)
    }
}

/// Predicted work of a scene, in point-steps and some for the cells.
fn work(scene: &Scene) -> f64 {
    let step = choose_step(scene).unwrap_or(f64::INFINITY);
    let cells = (scene.cells[0] * scene.cells[1]) as f64;
    scene.observe_times.last().copied().unwrap_or(0.0) / step * (scene.solid_particles() as f64 + 2.0 * cells)
}

/// The scene on another mesh.
fn remesh(base: &Scene, mesh: f64, ppc: usize) -> Result<Scene, String> {
    let count = |length: f64, name: &str| {
        let n = (length / mesh).round();
        if n >= 1.0 && (n * mesh - length).abs() <= 1e-9 * length {
            Ok(n as usize)
        } else {
            Err(format!("mesh: expected a cell that divides the {name} of {length} m, found {mesh} m"))
        }
    };
    let mut scene = base.clone();
    scene.cell = mesh;
    let across = if base.dimension == Dimension::Column { 1 } else { count(base.width, "width")? };
    scene.cells = [across, count(base.height, "height")?];
    let root = (ppc as f64).sqrt().round() as usize;
    if root * root != ppc || ppc == 0 {
        return Err(format!("ppc: expected a square number of particles per cell, found {ppc}"));
    }
    scene.particles_per_cell = ppc;
    Ok(scene)
}

impl Case {
    /// Runs the case and compares it with the exact solutions.
    ///
    /// # Errors
    /// The scene cannot be started.
    pub fn run(&self, progress: &mut dyn FnMut(f64)) -> Result<CaseResult, String> {
        let clock = ThreadTime::now();
        let run = run(&self.scene, progress).map_err(|e: StartError| format!("{}: {e}", self.name))?;
        let cpu_s = clock.elapsed().as_secs_f64();
        compare(self, &run, cpu_s)
    }
}

/// Compares a finished run with the exact solutions of its scene.
fn compare(case: &Case, run: &Run, cpu_s: f64) -> Result<CaseResult, String> {
    let scene = &case.scene;
    let missing = || format!("{}: the study needs water, a surcharge on the whole top, tight roller sides", case.name);
    let terzaghi = Terzaghi::incompressible(scene).ok_or_else(missing)?;
    let compressible = Terzaghi::compressible(scene).ok_or_else(missing)?;
    let dynamic = DynamicColumn::new(scene);
    let mesh = SemiDiscrete::new(scene);
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
    Ok(CaseResult {
        case: case.name.clone(),
        variant: case.variant,
        integrator: "explicit".to_owned(),
        scheme: word(scene.shape),
        load: word(scene.surcharge.map(|s| s.on)),
        mesh_m: scene.cell,
        ppc: scene.particles_per_cell,
        particles: run.solid_particles,
        dt_s: run.dt,
        steps: run.steps,
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
        ns_per_point_step: cpu_s * 1e9 / (run.steps.max(1) as f64 * run.solid_particles as f64),
        limit_s: stable_limit(scene),
        forced: scene.force && run.dt > stable_limit(scene),
        bytes_per_point: run.bytes / run.solid_particles,
        dimension: word(scene.dimension),
        scene_hash: scene_hash(scene),
        failure: run.failure.as_ref().map(ToString::to_string),
        degrees,
        profiles,
        history: history.map(|s| point(s.stage_time, s.state.settlement / whole, &terzaghi, &s.ledger)).collect(),
    })
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

fn point(time_s: f64, u: f64, terzaghi: &Terzaghi, ledger: &Ledger) -> HistoryPoint {
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
        energy_closing_j: ledger.energy_closing_j,
        water_closing_kg: ledger.water_closing_kg,
        water_out_kg: ledger.water_out_kg,
    }
}

impl CaseResult {
    /// One line for the terminal.
    fn line(&self) -> String {
        let variant = if self.variant == Variant::Base { String::new() } else { format!(" ({})", word(self.variant)) };
        let end = self.failure.as_ref().map_or(String::new(), |f| format!("  FAILED: {f}"));
        format!(
            "{}{variant}: {} steps, error {:.3e} (Terzaghi) {:.3e} (compressible), {:.2} s{end}",
            self.case, self.steps, self.max_error_terzaghi, self.max_error_compressible, self.cpu_s
        )
    }
}

#[cfg(test)]
pub(crate) mod tests {
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
            degrees: SAMPLE_TV.map(degree).to_vec(),
            profiles: Vec::new(),
            history: Vec::new(),
        }
    }

    fn plan(mesh: f64, force_step: Option<f64>) -> Plan {
        let mut base = crate::scenes::terzaghi();
        if let Some(step) = force_step {
            base.step = StepChoice::Fixed(step);
            base.force = true;
        }
        let loads = vec![LoadOn::Surface, LoadOn::Particles];
        Plan { base, meshes: vec![mesh], particles_per_cell: vec![1, 4], loads, budget: false, jobs: 2 }
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
        let error = plan(0.3, None).run(&Progress::new("", true)).unwrap_err();
        assert!(error.contains("0.3 m"), "{error}");
    }
}

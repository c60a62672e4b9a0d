//! `study`, the main job.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use mpm_core::scene::{DarcyChoice, Dimension, Integrator, LoadOn, Scene, ShapeChoice, StepChoice};
use mpm_verify::budget::budgets;
use mpm_verify::claims::{judge, judge_others};
use mpm_verify::cost::measure;
use mpm_verify::manifest::Manifest;
use mpm_verify::progress::Progress;
use mpm_verify::report::{self, Study};
use mpm_verify::study::{CaseResult, Family, INTEGRATORS, MESHES, Plan, TOLERANCE, Variant};
use mpm_verify::sweeps::Sweeps;

use super::{Failure, jobs, print_json, say, writable};
use crate::Common;

/// What the study varies.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Scene file to start from; the paper's Table 1 without one
    #[arg(long, value_name = "SCENE.toml")]
    scene: Option<PathBuf>,
    /// Cell edges L in m
    #[arg(long, value_delimiter = ',', value_name = "L,L", default_values_t = MESHES)]
    mesh: Vec<f64>,
    /// Particles per cell
    #[arg(long, value_delimiter = ',', value_name = "N,N", default_values_t = [1, 4, 9])]
    ppc: Vec<usize>,
    /// What carries the load
    #[arg(long, value_delimiter = ',', value_enum, default_values_t = [Load::Particles, Load::Surface])]
    load: Vec<Load>,
    /// Integrators; all without it, the scene's own with --scene, explicit with --dt
    #[arg(long, value_delimiter = ',', value_enum, value_name = "NAME,NAME")]
    integrator: Vec<Clock>,
    /// Shape functions; all without it, but then only centre and quasi-static run every mesh, particle count and load
    #[arg(long, value_delimiter = ',', value_enum, value_name = "NAME,NAME")]
    scheme: Vec<Scheme>,
    /// Largest error in time of quasi-static runs, relative
    #[arg(long, value_parser = tolerance, default_value_t = TOLERANCE, value_name = "T")]
    tolerance: f64,
    /// Darcy operator of explicit and semi-implicit runs
    #[arg(long, value_enum)]
    darcy: Option<Darcy>,
    /// `column` solves one dimension; `full` the paper's column in plane strain
    #[arg(long, value_enum, default_value_t = Width::Column)]
    width: Width,
    /// Time step of explicit and semi-implicit runs: `auto`, `paper` (1e-7 s) or seconds
    #[arg(long, value_parser = step, value_name = "STEP")]
    dt: Option<StepChoice>,
    /// Run steps above the stability limit all the same
    #[arg(long)]
    force: bool,
    /// Leave out the further runs of the error budget
    #[arg(long)]
    no_budget: bool,
    /// Leave out the sweeps over displaced particles, mesh offsets and time steps
    #[arg(long)]
    no_sweeps: bool,
    /// Leave out the timing of steps along several paths
    #[arg(long)]
    no_cost: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Load {
    Particles,
    Surface,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Clock {
    Explicit,
    SemiImplicit,
    QuasiStatic,
}

impl From<Clock> for Integrator {
    fn from(clock: Clock) -> Self {
        match clock {
            Clock::Explicit => Self::Explicit,
            Clock::SemiImplicit => Self::SemiImplicit,
            Clock::QuasiStatic => Self::QuasiStatic,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Scheme {
    Centre,
    Linear,
    Gimp,
    Bspline2,
}

impl From<Scheme> for ShapeChoice {
    fn from(scheme: Scheme) -> Self {
        match scheme {
            Scheme::Centre => Self::Centre,
            Scheme::Linear => Self::Linear,
            Scheme::Gimp => Self::Gimp,
            Scheme::Bspline2 => Self::Bspline2,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Darcy {
    Face,
    Nodal,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Width {
    Column,
    Full,
}

fn step(text: &str) -> Result<StepChoice, String> {
    match text {
        "auto" => Ok(StepChoice::Auto),
        "paper" => Ok(StepChoice::Paper),
        other => match other.parse::<f64>() {
            Ok(dt) if dt.is_finite() && dt > 0.0 => Ok(StepChoice::Fixed(dt)),
            _ => Err("expected auto, paper or a step above 0 s".to_owned()),
        },
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(tolerance) if (1e-10..=0.1).contains(&tolerance) => Ok(tolerance),
        _ => Err("expected 1e-10 <= tolerance <= 0.1 (-)".to_owned()),
    }
}

/// Reads a scene file.
fn load_scene(path: &Path) -> Result<Scene, Failure> {
    Scene::load(path).map_err(|e| Failure::BadInput(e.to_string()))
}

impl Options {
    /// The full study of the paper.
    pub fn paper() -> Self {
        Self {
            scene: None,
            mesh: MESHES.to_vec(),
            ppc: vec![1, 4, 9],
            load: vec![Load::Particles, Load::Surface],
            integrator: Vec::new(),
            scheme: Vec::new(),
            tolerance: TOLERANCE,
            darcy: None,
            width: Width::Column,
            dt: None,
            force: false,
            no_budget: false,
            no_sweeps: false,
            no_cost: false,
        }
    }

    fn plan(&self, common: &Common) -> Result<Plan, Failure> {
        let mut base = match &self.scene {
            Some(path) => load_scene(path)?,
            None => mpm_verify::scenes::terzaghi(),
        };
        if let Width::Full = self.width {
            base.dimension = Dimension::PlaneStrain;
        }
        if let Some(darcy) = self.darcy {
            base.darcy = match darcy {
                Darcy::Face => DarcyChoice::Face,
                Darcy::Nodal => DarcyChoice::Nodal,
            };
        }
        base.step = self.dt.unwrap_or(base.step);
        base.force = self.force;
        let loads = self.load.iter().map(|load| match load {
            Load::Particles => LoadOn::Particles,
            Load::Surface => LoadOn::Surface,
        });
        Ok(Plan {
            families: self.families(&base),
            base,
            meshes: self.mesh.clone(),
            particles_per_cell: self.ppc.clone(),
            loads: loads.collect(),
            tolerance: self.tolerance,
            budget: !self.no_budget && self.load.iter().any(|l| matches!(l, Load::Surface)),
            jobs: jobs(common.jobs),
        })
    }
}

impl Options {
    /// Integrators and shape functions. A scene brings its own; a given step is about the paper's explicit scheme.
    fn families(&self, base: &Scene) -> Vec<Family> {
        let (own, given) = (self.scene.is_some(), self.dt.is_some());
        let integrators: Vec<Integrator> = match self.integrator.as_slice() {
            [] if own => vec![base.integrator],
            [] if given => vec![Integrator::Explicit],
            [] => INTEGRATORS.to_vec(),
            asked => asked.iter().map(|clock| (*clock).into()).collect(),
        };
        let shapes: Vec<ShapeChoice> = match self.scheme.as_slice() {
            [] if own || given => vec![base.shape],
            asked => asked.iter().map(|scheme| (*scheme).into()).collect(),
        };
        Family::of(Some(&integrators), Some(shapes.as_slice()).filter(|s| !s.is_empty()))
    }
}

/// Runs the study and writes its report.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let folder = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/accuracy"));
    let study = compute(options, common, &folder)?;
    let write = |e: report::ReportError| Failure::RunFailed(e.to_string());
    report::write(&study, &folder).map_err(write)?;
    if common.json {
        print_json(&study.results.iter().filter(|r| r.variant == Variant::Base).collect::<Vec<_>>());
    } else {
        summary(&study, &folder, common.quiet);
    }
    match study.results.iter().find_map(|r| r.failure.as_ref().map(|f| format!("{}: {f}", r.case))) {
        Some(failure) => Err(Failure::RunFailed(failure)),
        None => Ok(()),
    }
}

/// Runs the study; checks the folder before the first step.
pub fn compute(options: &Options, common: &Common, folder: &Path) -> Result<Study, Failure> {
    let plan = options.plan(common)?;
    writable(folder)?;
    let progress = Progress::new("accuracy study", common.quiet);
    let start = std::time::Instant::now();
    let results = plan.run(&progress).map_err(Failure::BadInput)?;
    progress.finish();
    let wall = start.elapsed().as_secs_f64();
    let cpu: f64 = results.iter().map(|r| r.cpu_s).sum();
    let mut notes = vec![format!("{} runs, {cpu:.1} s of CPU time, {wall:.1} s on the clock.", results.len())];
    for integrator in ["explicit", "semi-implicit", "quasi-static"] {
        let own: Vec<f64> = results.iter().filter(|r| r.integrator == integrator).map(|r| r.cpu_s).collect();
        if !own.is_empty() {
            notes.push(format!("{integrator}: {} runs, {:.3} s of CPU time.", own.len(), own.iter().sum::<f64>()));
        }
    }
    let forced = results.iter().filter(|r| r.forced).count();
    if forced > 0 {
        notes.push(format!("{forced} runs were forced above their stability limit."));
    }
    notes.extend(plan.left_out());
    let quasi_static = plan.families.iter().any(|f| f.integrator == Integrator::QuasiStatic);
    let sweeps = if options.no_sweeps || !quasi_static { Sweeps::default() } else { swept(&plan, common, &mut notes) };
    let (budgets, claims, other_claims) = (budgets(&results), judge(&results), judge_others(&results));
    let costs = if options.no_cost { Vec::new() } else { measure() };
    let manifest = Manifest::new(&plan.base, plan.jobs);
    Ok(Study { manifest, results, budgets, claims, other_claims, sweeps, costs, notes })
}

/// Runs the sweeps and notes their time.
fn swept(plan: &Plan, common: &Common, notes: &mut Vec<String>) -> Sweeps {
    let start = std::time::Instant::now();
    let progress = Progress::new("sweeps", common.quiet);
    let sweeps = Sweeps::run(&plan.base, plan.jobs, &progress);
    progress.finish();
    let (count, wall) = (sweeps.count(), start.elapsed().as_secs_f64());
    notes.push(format!("Sweeps: {count} runs, {:.1} s of CPU time, {wall:.1} s on the clock.", sweeps.cpu_s));
    sweeps
}

fn summary(study: &Study, folder: &Path, quiet: bool) {
    say(quiet, &format!("{:<42} {:>9} {:>12} {:>12}", "case", "steps", "Terzaghi", "compressible"));
    let base = |r: &&CaseResult| r.variant == Variant::Base;
    for r in study.results.iter().filter(base) {
        let errors = format!("{:>12.3e} {:>12.3e}", r.max_error_terzaghi, r.max_error_compressible);
        say(quiet, &format!("{:<42} {:>9} {errors}", r.case, r.steps));
    }
    for claim in &study.claims {
        say(quiet, &format!("{:<28} {}: {}", claim.id, claim.verdict.words(), claim.evidence));
    }
    for note in &study.notes {
        say(quiet, note);
    }
    let index = folder.parent().unwrap_or(folder).join("index.html");
    say(quiet, &format!("report: {}", index.display()));
}

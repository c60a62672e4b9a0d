//! `study`: the accuracy study of the paper's column, which also runs without a command.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use mpm_core::hardware::Hardware;
use mpm_core::scene::{DarcyChoice, Dimension, Fields, Flags, Integrator, LoadOn, Scene, ShapeChoice, StepChoice};
use mpm_verify::budget::budgets;
use mpm_verify::checkpoint::BUILD;
use mpm_verify::claims::{judge, judge_others};
use mpm_verify::cost::measure;
use mpm_verify::error::Error::{self, Unfit};
use mpm_verify::files::Folder;
use mpm_verify::manifest::Manifest;
use mpm_verify::page::verdict::Counts;
use mpm_verify::progress::Progress;
use mpm_verify::report::{self, Study};
use mpm_verify::study::{
    CaseResult, Family, INTEGRATORS, Listed, MESHES, Plan, Runner, Share, Store, TOLERANCE, Variant,
};
use mpm_verify::sweeps::Sweeps;
use serde::{Deserialize, Serialize};

use super::terminal::{print_json, say};
use super::{Failure, again_with, interrupts, warn_if_long, write_json};
use crate::Common;

/// What the study varies.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct Options {
    /// Scene (name or file) of the column [default: the paper's Table 1]
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Cell edges L, m
    #[arg(long, value_delimiter = ',', value_name = "L,L", default_values_t = MESHES)]
    mesh: Vec<f64>,
    /// Particles per cell
    #[arg(long, value_delimiter = ',', value_name = "N,N", default_values_t = [1, 4, 9])]
    ppc: Vec<usize>,
    /// Traction on boundary particles or on the free surface
    #[arg(long, value_delimiter = ',', value_enum, default_values_t = [Load::Particles, Load::Surface])]
    load: Vec<Load>,
    /// Integrators [default: all; with --scene its own, with --dt explicit]
    #[arg(long, value_delimiter = ',', value_enum, value_name = "WORD,WORD")]
    integrator: Vec<Clock>,
    /// Shape functions [default: all, the expensive ones on some settings only]
    #[arg(long, value_delimiter = ',', value_enum, value_name = "WORD,WORD")]
    scheme: Vec<Scheme>,
    /// Continue a study that was stopped
    #[arg(long)]
    #[serde(skip)]
    resume: bool,
    /// Largest relative error in time of quasi-static runs [default: 1e-5]
    #[arg(long, value_parser = tolerance, default_value_t = TOLERANCE, value_name = "T", hide = true)]
    tolerance: f64,
    /// Darcy operator of explicit and semi-implicit runs: face or nodal
    #[arg(long, value_enum, hide = true)]
    darcy: Option<Darcy>,
    /// column: one dimension; full: the paper's column in plane strain
    #[arg(long, value_enum, default_value_t = Width::Column, hide = true)]
    width: Width,
    /// Time step of explicit and semi-implicit runs, s; or auto or paper
    #[arg(long, value_parser = step, value_name = "STEP", hide = true)]
    #[serde(skip)]
    dt: Option<StepChoice>,
    /// Allow time steps above the stability limit
    #[arg(long, hide = true)]
    force: bool,
    /// Leave out the additional runs of the error budget
    #[arg(long, hide = true)]
    no_budget: bool,
    /// Leave out the sweeps over positions, mesh offsets and tolerances
    #[arg(long, hide = true)]
    no_sweeps: bool,
    /// Leave out the timing of single steps
    #[arg(long, hide = true)]
    no_cost: bool,
    /// Leave out times, date and machine: reports of the same build are equal
    #[arg(long, hide = true)]
    pub no_times: bool,
    /// Only list the cases
    #[arg(long, hide = true)]
    #[serde(skip)]
    list_cases: bool,
    /// Run every N-th case from the I-th on, for `mpm-verify merge`
    #[arg(long, value_name = "I/N", value_parser = share, hide = true)]
    #[serde(skip)]
    shard: Option<Share>,
    /// Text of the scene, where its file is not at hand.
    #[arg(skip)]
    #[serde(skip)]
    text: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Load {
    Particles,
    Surface,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Darcy {
    Face,
    Nodal,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Width {
    Column,
    Full,
}

fn step(text: &str) -> Result<StepChoice, Error> {
    match text {
        "auto" => Ok(StepChoice::Auto),
        "paper" => Ok(StepChoice::Paper),
        other => match other.parse::<f64>() {
            Ok(dt) if dt.is_finite() && dt > 0.0 => Ok(StepChoice::Fixed(dt)),
            _ => Err(Unfit("expected auto, paper or a step above 0 s")),
        },
    }
}

pub fn share(text: &str) -> Result<Share, Error> {
    let numbers = text.split_once('/').and_then(|(which, of)| Some((which.parse().ok()?, of.parse().ok()?)));
    match numbers {
        Some((which, of)) if (1..=of).contains(&which) && of <= 1_000_000 => Ok(Share::Part { which, of }),
        _ => Err(Unfit("expected I/N with 1 <= I <= N <= 1000000, as in 3/8")),
    }
}

fn tolerance(text: &str) -> Result<f64, Error> {
    match text.parse::<f64>() {
        Ok(tolerance) if (1e-10..=0.1).contains(&tolerance) => Ok(tolerance),
        _ => Err(Unfit("expected 1e-10 <= tolerance <= 0.1 (-)")),
    }
}

/// The base of a study with one change from the command line.
fn changed(base: &Scene, edit: impl FnOnce(&mut Fields)) -> Result<Scene, Failure> {
    base.edited(edit).map_err(Failure::bad_input)
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
            no_times: false,
            resume: false,
            list_cases: false,
            shard: None,
            text: None,
        }
    }

    /// The options of a recipe.
    pub fn of(recipe: &Recipe) -> Result<Self, Failure> {
        let dt = recipe.step.as_deref().map(step).transpose().map_err(Failure::bad_input)?;
        Ok(Self { dt, text: recipe.scene.clone(), ..recipe.options.clone() })
    }

    fn plan(&self, jobs: usize) -> Result<Plan, Failure> {
        let mut base = match (&self.text, &self.scene) {
            (Some(text), path) => {
                // A scene of the user's own, wherever its file is now.
                let name = path.as_ref().map_or("scene".into(), |path| path.to_string_lossy());
                Scene::parse(text, &name).map_err(Failure::bad_input)?
            }
            (None, Some(path)) => {
                mpm_verify::scenes::load(&path.to_string_lossy(), &Flags::default()).map_err(Failure::bad_input)?
            }
            (None, None) => mpm_verify::scenes::terzaghi(),
        };
        if let Width::Full = self.width {
            base = changed(&base, |base| base.dimension = Dimension::PlaneStrain)?;
        }
        if let Some(darcy) = self.darcy {
            let operator = match darcy {
                Darcy::Face => DarcyChoice::Face,
                Darcy::Nodal => DarcyChoice::Nodal,
            };
            base = changed(&base, |base| base.darcy = operator)?;
        }
        if let Some(step) = self.dt {
            base = changed(&base, |base| base.step = step)?;
        }
        let base = if self.force { base.forced() } else { base };
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
            jobs,
        })
    }
}

impl Options {
    /// Integrators and shape functions. A scene has its own; a given step applies to the paper's explicit scheme.
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

/// Runs the study and writes its report; or lists its cases, or runs a share of them.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    if options.list_cases {
        return list(options, common);
    }
    let names: &[&str] = if options.shard.is_some() { &[SHARD] } else { &NAMES };
    if options.shard.is_none() {
        super::home_is_free(&common.folder(FOLDER))?;
    }
    if let Some(scene) = &options.scene {
        common.load(&scene.to_string_lossy(), &Flags::default())?;
    }
    let jobs = common.jobs();
    let scenes = |options: &Options| {
        Some(options.plan(jobs).ok()?.cases().ok()?.into_iter().map(|case| case.scene).collect::<Vec<_>>())
    };
    let other = |word: &str| {
        let integrator = vec![Clock::from_str(word, false).ok()?];
        scenes(&Options { integrator, ..options.clone() })
    };
    let own = scenes(options).unwrap_or_default();
    warn_if_long(common, ("accuracy study", "--integrator", jobs), &own, &Hardware::default(), &other);
    let study = common.publish(FOLDER, names, |folder| {
        let progress = Progress::new("accuracy study", common.quiet);
        let mut runner = Runner {
            store: Some(open(options, folder.path())?),
            stop: interrupts(),
            share: options.shard.unwrap_or(Share::All),
            times: !options.no_times,
            ..Runner::whole(jobs, &progress)
        };
        progress.expect(listed(options)?.iter().map(|one| one.work).sum());
        if options.shard.is_some() {
            return shard(options, common, &mut runner, folder).map(|()| None);
        }
        let study = complete(options, common, &mut runner, &|| again_with("--resume"))?;
        write(&study, folder)?;
        // The report holds all of it.
        runner.store.iter().for_each(Store::remove);
        Ok(Some(study))
    })?;
    study.map_or(Ok(()), |study| told(&study, common))
}

/// Writes the report of a study, and publishes it before the page that shows it.
pub fn write(study: &Study, folder: &Folder) -> Result<(), Failure> {
    report::write(study, folder.stage()).map_err(Failure::run_failed)?;
    folder.publish().map_err(Failure::run_failed)?;
    Ok(())
}

/// Prints the results of a study.
pub fn told(study: &Study, common: &Common) -> Result<(), Failure> {
    if common.json {
        print_json(&study.results.iter().filter(|r| r.variant == Variant::Base).collect::<Vec<_>>());
    } else {
        summary(study, common);
        common.page(&common.folder(FOLDER).join("index.html"));
    }
    match study.results.iter().find_map(|r| r.failure.as_ref().map(|f| format!("{}: {f}", r.case))) {
        Some(failure) => Err(Failure::RunFailed(failure)),
        None => Ok(()),
    }
}

/// Folder of the study, below `reports`.
pub const FOLDER: &str = "accuracy";

/// Results of a study that other programs read by name.
pub const NAMES: [&str; 4] = ["errors.csv", "manifest.json", "report.md", "study.json"];

/// Folder of the finished cases, in that of the study.
pub const CASES: &str = "cases";

/// The finished cases of a folder, which are used only if the study is resumed.
fn open(options: &Options, folder: &Path) -> Result<Store, Failure> {
    let cases = folder.join(CASES);
    let store = Store::open(&[&cases]).map_err(|e| Failure::BadInput(format!("{}: {e}", cases.display())))?;
    Ok(if options.resume { store } else { store.anew() })
}

/// All cases with their predicted work; none is run.
fn listed(options: &Options) -> Result<Vec<Listed>, Failure> {
    let silent = Progress::new("", true);
    let mut runner = Runner { lists: true, ..Runner::whole(1, &silent) };
    ran(options, &mut runner)?;
    Ok(runner.listed)
}

/// Prints the cases.
fn list(options: &Options, common: &Common) -> Result<(), Failure> {
    let listed = listed(options)?;
    if common.json {
        print_json(&listed);
    } else {
        listed.iter().for_each(|one| say(&one.case));
    }
    Ok(())
}

/// Runs a share of the cases, and writes `shard.json` when it is done.
fn shard(options: &Options, common: &Common, runner: &mut Runner, folder: &Folder) -> Result<(), Failure> {
    let start = std::time::Instant::now();
    let (results, _) = ran(options, runner)?;
    let (Share::Part { which, of }, listed) = (runner.share, &runner.listed) else { return Ok(()) };
    let own: Vec<&str> = listed.iter().skip(which - 1).step_by(of).map(|one| one.case.as_str()).collect();
    let missing: Vec<&str> = own.iter().filter(|own| runner.missing.iter().any(|m| m == *own)).copied().collect();
    whole(&missing, own.len(), runner, &|| again_with("--resume"))?;
    let failed: Vec<String> = results.iter().filter(|r| r.failure.is_some()).map(|r| r.case.clone()).collect();
    let done = Shard {
        shard: which,
        of,
        cases: own.len(),
        taken_over: runner.taken_over,
        failed,
        wall_s: start.elapsed().as_secs_f64(),
        recipe: Recipe::new(options)?,
    };
    write_json(&folder.stage().join(SHARD), &done)?;
    common.json(&done);
    common.say(&format!("share {which} of {of}: {} of {} cases done", own.len(), listed.len()));
    common.say(&format!("share: {}", folder.path().display()));
    Ok(())
}

/// File that marks a share as done.
pub const SHARD: &str = "shard.json";

/// A finished share.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Shard {
    /// Number of the share, from 1.
    pub shard: usize,
    /// Shares.
    pub of: usize,
    /// Its cases.
    pub cases: usize,
    /// Those that were taken from an earlier run.
    pub taken_over: usize,
    /// Its cases that failed.
    pub failed: Vec<String>,
    /// Wall-clock time, s.
    pub wall_s: f64,
    /// What the study varies.
    pub recipe: Recipe,
}

/// All that a study depends on; shares of equal recipes can be merged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// The program.
    pub build: String,
    /// What is varied.
    pub options: Options,
    /// `--dt` in words.
    pub step: Option<String>,
    /// Text of the scene, if it is one of the user's own.
    pub scene: Option<String>,
}

impl Recipe {
    fn new(options: &Options) -> Result<Self, Failure> {
        let read = |path: &PathBuf| mpm_verify::scenes::text(&path.to_string_lossy()).map_err(Failure::bad_input);
        Ok(Self {
            build: BUILD.to_owned(),
            // The name of its file alone: it may stand elsewhere on another machine.
            options: Options {
                scene: options.scene.as_ref().and_then(|path| path.file_name()).map(PathBuf::from),
                ..options.clone()
            },
            step: options.dt.map(|step| match step {
                StepChoice::Auto => "auto".to_owned(),
                StepChoice::Paper => "paper".to_owned(),
                StepChoice::Fixed(step) => format!("{step:?}"),
            }),
            scene: options.scene.as_ref().map(read).transpose()?,
        })
    }
}

/// Runs every case or takes it from an earlier run, and assembles the study.
///
/// # Errors
/// Cases that are missing, with the command `on` that continues.
pub fn complete(
    options: &Options,
    common: &Common,
    runner: &mut Runner,
    on: &dyn Fn() -> String,
) -> Result<Study, Failure> {
    let start = std::time::Instant::now();
    let (results, sweeps) = ran(options, runner)?;
    runner.progress.finish();
    let missing: Vec<&str> = runner.missing.iter().map(String::as_str).collect();
    whole(&missing, runner.listed.len(), runner, on)?;
    let plan = options.plan(common.jobs())?;
    let times = !options.no_times;
    let wall = start.elapsed().as_secs_f64();
    let mut notes = vec![told_of(&results, times, wall)];
    if runner.taken_over > 0 && times {
        notes.push(format!("{} cases were taken from an earlier run.", runner.taken_over));
    }
    if times {
        for integrator in ["explicit", "semi-implicit", "quasi-static"] {
            let own: Vec<f64> = results.iter().filter(|r| r.integrator == integrator).map(|r| r.cpu_s).collect();
            if !own.is_empty() {
                notes.push(format!("{integrator}: {} runs, {:.3} s of CPU time.", own.len(), own.iter().sum::<f64>()));
            }
        }
    }
    let forced = results.iter().filter(|r| r.forced).count();
    if forced > 0 {
        notes.push(format!("{forced} runs used a time step above the stability limit (--force)."));
    }
    notes.extend(plan.left_out());
    if sweeps.count() > 0 {
        let cpu = if times { format!(", {:.1} s of CPU time", sweeps.cpu_s) } else { String::new() };
        notes.push(format!("Sweeps: {} runs{cpu}.", sweeps.count()));
    }
    let (budgets, claims, other_claims) = (budgets(&results), judge(&results), judge_others(&results));
    let costs = if options.no_cost || !times { Vec::new() } else { measure().map_err(Failure::run_failed)? };
    let manifest = Manifest::new(&plan.base, plan.jobs);
    let manifest = if times { manifest } else { manifest.without_times("study --no-times") };
    Ok(Study { manifest, results, budgets, claims, other_claims, sweeps, costs, notes })
}

fn told_of(results: &[CaseResult], times: bool, wall: f64) -> String {
    if !times {
        return format!("{} runs; times are left out.", results.len());
    }
    let cpu: f64 = results.iter().map(|r| r.cpu_s).sum();
    format!("{} runs, {cpu:.1} s of CPU time, {wall:.1} s of wall-clock time.", results.len())
}

/// Runs the cases of the study and of its sweeps by a runner.
fn ran(options: &Options, runner: &mut Runner) -> Result<(Vec<CaseResult>, Sweeps), Failure> {
    let plan = options.plan(runner.jobs)?;
    let results = plan.run_by(runner).map_err(Failure::bad_input)?;
    let quasi_static = plan.families.iter().any(|f| f.integrator == Integrator::QuasiStatic);
    let sweeps = if options.no_sweeps || !quasi_static {
        Sweeps::default()
    } else {
        Sweeps::run(&plan.base, runner).map_err(Failure::bad_input)?
    };
    Ok((results, sweeps))
}

/// Largest number of names in a message.
const LISTED: usize = 12;

/// Fails if cases are missing; warns of results that could not be stored.
fn whole(missing: &[&str], all: usize, runner: &Runner, on: &dyn Fn() -> String) -> Result<(), Failure> {
    if missing.is_empty() {
        for unkept in &runner.unkept {
            eprintln!("could not be stored for --resume: {unkept}");
        }
        return Ok(());
    }
    let more = missing.len().saturating_sub(LISTED);
    let names = missing.iter().take(LISTED).copied().collect::<Vec<_>>().join(", ");
    let names = if more > 0 { format!("{names} and {more} more") } else { names };
    let lost = if runner.unkept.is_empty() {
        String::new()
    } else {
        format!("; {} could not be stored: {}", runner.unkept.len(), runner.unkept[0])
    };
    Err(Failure::RunFailed(format!(
        "{} of {all} cases are done{lost}; missing: {names}; to continue: {}",
        all - missing.len(),
        on()
    )))
}

fn summary(study: &Study, common: &Common) {
    common.say(&format!("{:<42} {:>9} {:>12} {:>12}", "case", "steps", "Terzaghi", "compressible"));
    for r in study.results.iter().filter(|r| r.variant == Variant::Base) {
        let errors = format!("{:>12.3e} {:>12.3e}", r.max_error_terzaghi, r.max_error_compressible);
        common.say(&format!("{:<42} {:>9} {errors}", r.case, r.steps));
    }
    for claim in &study.claims {
        common.say(&format!("{:<28} {}: {}", claim.id, claim.verdict.words(), claim.evidence));
    }
    for note in &study.notes {
        common.say(note);
    }
    let stopped = study.results.iter().filter(|r| r.failure.is_some()).count();
    let runs = Counts::Runs { complete: study.results.len() - stopped, stopped };
    let claims = Counts::of_claims(study.claims.iter().map(|claim| claim.verdict));
    common.say(&format!("runs: {}; claims: {}", runs.words(), claims.words()));
}

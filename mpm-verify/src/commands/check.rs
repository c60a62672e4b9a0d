//! `check`: the verification suite, its mutants, and a scene of one's own.

use std::path::{Path, PathBuf};

use clap::Args;
use mpm_core::hardware::Hardware;
use mpm_core::scene::{Flags, INTEGRATORS, SHAPES, Scene};
use mpm_verify::baseline;
use mpm_verify::cases::own::OwnScene;
use mpm_verify::cases::{Case, CaseRow, Judged, SUITE, accepted};
use mpm_verify::error::Error;
use mpm_verify::files::Folder;
use mpm_verify::manifest::Manifest;
use mpm_verify::report;
use mpm_verify::unpanicked::unpanicked;
use rayon::prelude::*;
use serde::Serialize;

use super::{Failure, inside, into_folder, jobs, print_json, say, warn_if_long, write_csv};
use crate::Common;

/// What to check.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Cases to run; all without a name
    cases: Vec<String>,
    /// Run the mutants instead: the same checks with a planted fault; exit code 1 when one is not caught
    #[arg(long)]
    mutants: bool,
    /// Check this scene instead, refined in space, against the exact solution that applies to it
    #[arg(long, value_name = "SCENE.toml", conflicts_with_all = ["cases", "mutants"])]
    scene: Option<PathBuf>,
    /// Rows of cells over the height, three or more (four establish an order); without it the scene's own cells and three finer meshes
    #[arg(long, value_delimiter = ',', value_name = "N,N,N", requires = "scene")]
    rows: Vec<usize>,
    /// Folder of the accepted errors, if it is not reference-data/baselines; without either those that were built in
    #[arg(long, value_name = "DIR", conflicts_with = "scene")]
    baselines: Option<PathBuf>,
    #[arg(long, value_name = "WORD", requires = "scene", help = super::words("time.integrator", &INTEGRATORS))]
    integrator: Option<String>,
    #[arg(long, value_name = "WORD", requires = "scene", help = super::words("scheme.shape", &SHAPES))]
    scheme: Option<String>,
}

/// Results that others ask for by name.
const NAMES: [&str; 3] = ["index.html", "cases.csv", "manifest.json"];

/// Runs the named cases, or all; with `mutants` those with a fault planted; with a scene that one.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    if let Some(path) = &options.scene {
        return own(path, options, common);
    }
    let file = baseline::suite::hold_against(options.baselines.as_deref()).map_err(Failure::bad_input)?;
    let file = file.map_or_else(|| "built in".to_owned(), |file| file.display().to_string());
    say(common.quiet || common.json, &format!("accepted errors: {file}"));
    let folder = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/suite"));
    if options.mutants {
        let (rows, failed) =
            into_folder(&folder, &["mutants.csv"], |folder| catch(&options.cases, common, folder.stage()))?;
        unfinished(&failed)?;
        let missed: Vec<&str> = rows.iter().filter(|row| !row.caught).map(|row| row.case).collect();
        return if missed.is_empty() {
            Ok(())
        } else {
            Err(Failure::CheckFailed(format!("not caught: {}", missed.join(", "))))
        };
    }
    let SuiteRun { steps, failed } =
        into_folder(&folder, &NAMES, |folder| judged(&options.cases, common, folder.stage()))?;
    if common.json {
        print_json(&steps);
    }
    unfinished(&failed)?;
    let named = |which: fn(&CaseRow) -> bool| {
        let names: Vec<&str> = steps.iter().filter(|s| which(s)).map(|s| s.case.as_str()).collect();
        names.join(", ")
    };
    let (open, failed) = (named(CaseRow::open), named(|step| !step.passed()));
    if !open.is_empty() {
        say(common.quiet || common.json, &format!("order not established: {open}"));
    }
    if failed.is_empty() { Ok(()) } else { Err(Failure::CheckFailed(format!("failed: {failed}"))) }
}

/// Checks a scene of the user's own and writes the files of the suite with its one row.
fn own(path: &Path, options: &Options, common: &Common) -> Result<(), Failure> {
    let flags = Flags { integrator: options.integrator.clone(), scheme: options.scheme.clone(), ..Flags::default() };
    let scene = Scene::load_with(path, &flags).map_err(Failure::bad_input)?;
    // What is wrong with a flag is said of the flag, all else of the file.
    let refused = |e: Error| match e.to_string() {
        flag if flag.starts_with("--") => Failure::BadInput(flag),
        _ => Failure::bad_input(e.of(path.display())),
    };
    let own = OwnScene::new(&scene, &options.rows).map_err(refused)?;
    let other = |word: &str| {
        let flags = Flags { integrator: Some(word.to_owned()), ..flags.clone() };
        OwnScene::new(&Scene::load_with(path, &flags).ok()?, &options.rows).ok()?.runs().ok()
    };
    let runs = own.runs().map_err(refused)?;
    warn_if_long(common, (&scene.name, "--integrator", 1), &runs, &Hardware::default(), &other);
    let folder = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/check-scene"));
    let steps = into_folder(&folder, &NAMES, |folder| measured(&own, &scene, common, folder))?;
    if common.json {
        print_json(&steps);
    }
    match steps.iter().find(|step| !step.passed()) {
        Some(step) => Err(Failure::CheckFailed(format!("{}: failed: {}", step.case, step.reason))),
        None => Ok(()),
    }
}

/// Checks it and writes what was found.
fn measured(own: &OwnScene, scene: &Scene, common: &Common, folder: &Folder) -> Result<Vec<CaseRow>, Failure> {
    let quiet = common.quiet || common.json;
    say(quiet, &format!("{}: {}", scene.name, own.about()));
    for what in own.beside() {
        say(quiet, &format!("  {what}"));
    }
    let judged = own.judged().map_err(Failure::run_failed)?;
    say(quiet, &header());
    say(quiet, &line(&judged.row));
    say(quiet, &judged.reason);
    for (what, value, _) in &judged.notes {
        say(quiet, &format!("{what}: {value:.1e}"));
    }
    write(&[judged], scene, common, folder.stage())
}

/// The cases that were run, and why others could not be finished.
pub struct SuiteRun {
    /// What was found.
    pub steps: Vec<CaseRow>,
    /// Messages of the cases that failed.
    pub failed: Vec<String>,
}

/// Runs the suite and writes its tables, a picture of every case and `index.html`; `accepted.csv` holds the baselines
/// as they would be with these errors.
pub fn judged(names: &[String], common: &Common, folder: &Path) -> Result<SuiteRun, Failure> {
    let cases = chosen(names)?;
    inside(folder)?;
    let quiet = common.quiet || common.json;
    say(quiet, &header());
    let (judged, failed) = each(&cases, common, |case| {
        let judged = case.judged()?;
        say(quiet, &line(&judged.row));
        Ok(judged)
    })?;
    let steps = write(&judged, &mpm_verify::scenes::terzaghi(), common, folder)?;
    let (path, rows) = (folder.join("accepted.csv"), accepted(&judged));
    std::fs::write(&path, rows).map_err(|e| Failure::RunFailed(format!("{}: {e}", path.display())))?;
    let without: Vec<&str> = steps.iter().filter(|s| s.baseline.is_none()).map(|s| s.case.as_str()).collect();
    if !without.is_empty() {
        say(quiet, &format!("without a baseline: {}", without.join(", ")));
    }
    Ok(SuiteRun { steps, failed })
}

/// Writes `cases.csv`, `samples.csv`, `refinements.csv` and the page with its pictures.
fn write(judged: &[Judged], scene: &Scene, common: &Common, folder: &Path) -> Result<Vec<CaseRow>, Failure> {
    let steps: Vec<CaseRow> = judged.iter().map(|judged| judged.row.clone()).collect();
    write_csv(&folder.join("cases.csv"), &steps)?;
    let manifest = Manifest::new(scene, jobs(common.jobs));
    report::suite::write(judged, &manifest, folder).map_err(Failure::run_failed)?;
    Ok(steps)
}

/// A row of `mutants.csv`.
#[derive(Debug, Serialize)]
struct Caught {
    case: &'static str,
    mutant: &'static str,
    error: f64,
    required_error: f64,
    caught: bool,
}

impl Caught {
    fn new(judged: &Judged, mutant: &'static str) -> Self {
        let CaseRow { error, required_error, .. } = judged.row;
        Self { case: judged.case.name, mutant, error, required_error, caught: !judged.row.passed() }
    }
}

/// Runs mutants and writes `mutants.csv`; each must fall short.
fn catch(names: &[String], common: &Common, folder: &Path) -> Result<(Vec<Caught>, Vec<String>), Failure> {
    let cases = chosen(names)?;
    let without: Vec<&str> = cases.iter().filter(|case| case.mutant.is_none()).map(|case| case.name).collect();
    if !(names.is_empty() || without.is_empty()) {
        return Err(Failure::BadInput(format!("check: expected cases with a mutant, found {}", without.join(", "))));
    }
    let quiet = common.quiet || common.json;
    say(quiet, &format!("{:<29} {:>10} {:>10}  {:<44} caught", "case", "error", "required", "mutant"));
    let cases: Vec<&Case> = cases.into_iter().filter(|case| case.mutant.is_some()).collect();
    let (rows, failed) = each(&cases, common, |case| {
        let what = case.mutant.map_or("", |mutant| mutant.what);
        let judged = case.mutant_judged().unwrap_or_else(|| Err(Error::Lacks("mutant").of(case.name)))?;
        let row = Caught::new(&judged, what);
        let caught = if row.caught { "yes" } else { "no" };
        say(
            quiet,
            &format!("{:<29} {:>10.2e} {:>10.1e}  {what:<44} {caught}", row.case, row.error, row.required_error),
        );
        Ok(row)
    })?;
    write_csv(&folder.join("mutants.csv"), &rows)?;
    if common.json {
        print_json(&rows);
    }
    Ok((rows, failed))
}

/// The named cases, or all.
fn chosen(names: &[String]) -> Result<Vec<&'static Case>, Failure> {
    let known = || SUITE.iter().map(|case| case.name).collect::<Vec<_>>().join(", ");
    if let Some(name) = names.iter().find(|name| SUITE.iter().all(|case| case.name != name.as_str())) {
        return Err(Failure::BadInput(format!("check: expected one of {}, found {name}", known())));
    }
    let chosen = |case: &&Case| names.is_empty() || names.iter().any(|name| name == case.name);
    Ok(SUITE.iter().filter(chosen).collect())
}

/// Does something with every case, several at a time; the results in the order of the suite, and the messages of the cases that
/// could not be finished: one that fails takes no other down.
fn each<T: Send>(
    cases: &[&Case],
    common: &Common,
    work: impl Fn(&Case) -> Result<T, Error> + Sync,
) -> Result<(Vec<T>, Vec<String>), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs(common.jobs)).build().map_err(Failure::bad_input)?;
    // The last cases take longest: started first, they leave no thread idle at the end.
    let from_the_last = cases.iter().enumerate().rev().par_bridge();
    let one = |case: &Case| unpanicked(|| work(case)).map_err(|e| e.of(case.name)).flatten();
    let mut results: Vec<(usize, Result<T, Error>)> =
        pool.install(|| from_the_last.map(|(i, case)| (i, one(case))).collect());
    results.sort_by_key(|(i, _)| *i);
    let (mut done, mut failed) = (Vec::new(), Vec::new());
    for (_, result) in results {
        match result {
            Ok(value) => done.push(value),
            Err(error) => failed.push(error.to_string()),
        }
    }
    Ok((done, failed))
}

/// Runs that could not be finished, once all others are written.
pub fn unfinished(failed: &[String]) -> Result<(), Failure> {
    if failed.is_empty() { Ok(()) } else { Err(Failure::RunFailed(failed.join("; "))) }
}

fn header() -> String {
    format!("{:<29} {:>10} {:>10}  {:<26} verdict", "case", "error", "required", "order")
}

fn line(step: &CaseRow) -> String {
    let order = match (step.order, step.order_high) {
        (Some(order), Some(high)) => {
            format!("{order:.2} +- {:.2} ({})", high - order, step.required_order)
        }
        (Some(order), None) => format!("{order:.2} ({})", step.required_order),
        _ => String::new(),
    };
    format!("{:<29} {:>10.2e} {:>10.1e}  {order:<26} {}", step.case, step.error, step.required_error, step.verdict)
}

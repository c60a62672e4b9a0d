//! `check`: the verification suite, its mutants, and a scene of one's own.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use clap::Args;
use mpm_core::hardware::Hardware;
use mpm_core::scene::{Flags, INTEGRATORS, SHAPES, Scene};
use mpm_verify::cases::own::OwnScene;
use mpm_verify::cases::suite::{COST_NAME, write_costs};
use mpm_verify::cases::{Case, suite};
use mpm_verify::error::Error;
use mpm_verify::experiment::accepted::{self, Renewed};
use mpm_verify::experiment::number::Number;
use mpm_verify::experiment::{CaseRow, Judged, pool};
use mpm_verify::files::Folder;
use mpm_verify::manifest::Manifest;
use mpm_verify::mutants::hunt::Verdict;
use mpm_verify::progress::{Progress, time};
use mpm_verify::provenance;
use mpm_verify::report;
use serde::Serialize;

use super::{Failure, chosen, make_folder, warn_if_long, words, write_csv};
use crate::Common;

/// What to check.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Test cases to run; all without a name
    #[arg(value_name = "CASE")]
    cases: Vec<String>,
    /// Run only the cases that take no more than a second
    #[arg(long, conflicts_with_all = ["cases", "scene"])]
    quick: bool,
    /// Run every check with a planted fault instead, which it must catch
    #[arg(long)]
    mutants: bool,
    /// Check a scene (name or file) on refined meshes against the exact solution that applies
    #[arg(long, value_name = "SCENE", conflicts_with_all = ["cases", "mutants"], help_heading = "Own scene")]
    scene: Option<String>,
    /// Rows of cells over the height, three or more; four establish an order
    #[arg(long, value_delimiter = ',', value_name = "N,N,N", requires = "scene", help_heading = "Own scene")]
    rows: Vec<usize>,
    /// In place of the scene's time.integrator
    #[arg(long, value_name = "WORD", requires = "scene", value_parser = words(&INTEGRATORS), help_heading = "Own scene")]
    integrator: Option<String>,
    /// In place of the scene's scheme.shape
    #[arg(long, value_name = "WORD", requires = "scene", value_parser = words(&SHAPES), help_heading = "Own scene")]
    scheme: Option<String>,
    /// Accept the errors of the cases that hold, for this reason
    #[arg(long, value_name = "WHY", conflicts_with_all = ["scene", "mutants"])]
    accept: Option<String>,
    /// Folder of the accepted errors [default: reference-data/baselines]
    #[arg(long, value_name = "DIR", conflicts_with = "scene", hide = true)]
    baselines: Option<PathBuf>,
    /// Write what each case costs, for the order of later runs
    #[arg(long, conflicts_with_all = ["scene", "mutants"], hide = true)]
    record_cost: bool,
    /// Write only the verdicts to FILE, each as it is known
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scene", "mutants", "accept"], hide = true)]
    verdicts: Option<PathBuf>,
    /// End with the first case that fails
    #[arg(long, requires = "verdicts", hide = true)]
    until_failed: bool,
}

/// Results that other programs read by name.
const NAMES: [&str; 3] = ["index.html", "cases.csv", "manifest.json"];
/// Folder of the suite, below `reports`.
const FOLDER: &str = "suite";

/// Runs the chosen cases, or all; with `--mutants` those with a planted fault; with `--scene` that scene.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    if let Some(scene) = &options.scene {
        return own(scene, options, common);
    }
    let (known, file) = accepted::read(options.baselines.as_deref()).map_err(Failure::bad_input)?;
    accepted::hold_against(&known);
    let named = file.as_ref().map_or_else(|| "built in".to_owned(), |file| file.display().to_string());
    common.say(&format!("accepted errors: {named}"));
    let target = |why| Ok((why, accepted::target(why, provenance::commit(), file.as_deref())?));
    let accept = options.accept.as_deref().map(target).transpose().map_err(Failure::bad_input::<Error>)?;
    if let Some(file) = &options.verdicts {
        return verdicts(options, file, common);
    }
    let mut cases = cases(&options.cases)?;
    cases.retain(|case| !options.quick || case.is_quick());
    if options.mutants {
        if !options.cases.is_empty()
            && let Some(case) = cases.iter().find(|case| case.mutant.is_none())
        {
            return Err(Failure::BadInput(format!("--mutants: expected cases with a mutant, found {}", case.name)));
        }
        cases.retain(|case| case.mutant.is_some());
        let rows = common.publish(FOLDER, &["mutants.csv"], |folder| catch(&cases, common, folder.stage()))?;
        return rows.end("mutants not caught", |row| row.caught, |row| row.case);
    }
    let clock = Instant::now();
    let folder = common.folder(FOLDER);
    let ran = common.publish(FOLDER, &NAMES, |folder| judged(&cases, common, folder.stage()))?;
    common.json(&ran.rows);
    if options.record_cost {
        let file =
            file.as_ref().ok_or_else(|| Failure::BadInput("--record-cost: expected --baselines DIR".to_owned()))?;
        write_costs(&ran.rows, &file.with_file_name(COST_NAME)).map_err(Failure::run_failed)?;
    }
    let accepts = accept.is_some();
    if let Some((why, file)) = accept {
        let manifest = Manifest::new(&mpm_verify::scenes::terzaghi(), common.jobs());
        let since = (manifest.date.as_str(), manifest.commit.as_str());
        let Renewed { rows, new, .. } = accepted::renewed(&known, &ran.holds, since, why, |_| false);
        accepted::write(&rows, file).map_err(Failure::run_failed)?;
        common.say(&format!("{new} new or changed numbers accepted: {}", file.display()));
    }
    // What has just been accepted is none that has moved.
    let fine = |row: &CaseRow| row.passed() || (accepts && ran.holds.iter().any(|n| n.is_of(&row.case, "error")));
    let open = ran.rows.iter().filter(|row| row.open()).count();
    let passed = ran.rows.iter().filter(|row| fine(row)).count() - open;
    let all = ran.rows.len() + ran.failed.len();
    for row in ran.rows.iter().filter(|row| !fine(row)) {
        common.say(&format!("failed: {}: {}", row.case, row.reason));
    }
    let counts = format!("{passed} passed, {} failed, {open} not established of {all}", all - passed - open);
    common.say(&format!("{counts} ({})", time(clock.elapsed().as_secs_f64())));
    common.page(&folder.join("index.html"));
    ran.end("failed", fine, |row| &row.case)
}

/// Checks a scene of the user's own, and writes the files of the suite with its one row.
fn own(source: &str, options: &Options, common: &Common) -> Result<(), Failure> {
    let flags = Flags { integrator: options.integrator.clone(), scheme: options.scheme.clone(), ..Flags::default() };
    let scene = common.load(source, &flags)?;
    // An error in a flag is reported with the flag, all others with the file.
    let refused = |e: Error| match e.to_string() {
        flag if flag.starts_with("--") => Failure::BadInput(flag),
        _ => Failure::bad_input(e.of(source)),
    };
    let own = OwnScene::new(&scene, &options.rows).map_err(refused)?;
    let other = |word: &str| {
        let flags = Flags { integrator: Some(word.to_owned()), ..flags.clone() };
        OwnScene::new(&mpm_verify::scenes::load(source, &flags).ok()?, &options.rows).ok()?.runs().ok()
    };
    let runs = own.runs().map_err(refused)?;
    warn_if_long(common, (&scene.name, "--integrator", 1), &runs, &Hardware::default(), &other);
    let name = "check-scene";
    let rows = common.publish(name, &NAMES, |folder| measured(&own, &scene, common, folder))?;
    common.json(&rows);
    common.page(&common.folder(name).join("index.html"));
    match rows.iter().find(|row| !row.passed()) {
        Some(row) => Err(Failure::CheckFailed(format!("{}: failed: {}", row.case, row.reason))),
        None => Ok(()),
    }
}

/// Checks it and writes the results.
fn measured(own: &OwnScene, scene: &Scene, common: &Common, folder: &Folder) -> Result<Vec<CaseRow>, Failure> {
    common.say(&format!("{}: {}", scene.name, own.about()));
    for what in own.beside() {
        common.say(&format!("  {what}"));
    }
    let judged = own.judged().map_err(Failure::run_failed)?;
    common.say(&header());
    common.say(&line(&judged));
    common.say(&judged.reason);
    for (what, value, _) in &judged.notes {
        common.say(&format!("{what}: {value:.1e}"));
    }
    write(&[judged], scene, common, folder.stage())
}

/// Results of cases, and the errors of those that could not be finished.
pub struct Ran<T> {
    /// Results, in the order of the suite.
    pub rows: Vec<T>,
    /// Errors of the cases without a result.
    pub failed: Vec<String>,
    /// Numbers of the cases whose own rule holds, whatever was accepted.
    holds: Vec<Number>,
}

impl<T> Ran<T> {
    /// How the command ends: cases without a result come before failed ones.
    fn end<'a, N: Display>(
        &'a self,
        verdict: &str,
        good: impl Fn(&T) -> bool,
        name: impl Fn(&'a T) -> N,
    ) -> Result<(), Failure> {
        if !self.failed.is_empty() {
            return Err(Failure::RunFailed(self.failed.join("; ")));
        }
        let bad: Vec<String> = self.rows.iter().filter(|row| !good(row)).map(|row| name(row).to_string()).collect();
        if bad.is_empty() { Ok(()) } else { Err(Failure::CheckFailed(format!("{verdict}: {}", bad.join(", ")))) }
    }
}

/// Runs cases and writes their tables, a picture of each and `index.html`.
pub fn judged(cases: &[&Case], common: &Common, folder: &Path) -> Result<Ran<CaseRow>, Failure> {
    make_folder(folder)?;
    common.say(&header());
    let Ran { rows: judged, failed, .. } = each(cases, common, |case, print| {
        let judged = case.judged()?;
        print(&line(&judged));
        Ok(judged)
    })?;
    let rows = write(&judged, &mpm_verify::scenes::terzaghi(), common, folder)?;
    let holds: Vec<CaseRow> = judged.iter().filter(|judged| judged.sound).map(|judged| judged.row.clone()).collect();
    let without: Vec<&str> = rows.iter().filter(|row| row.baseline.is_none()).map(|row| row.case.as_str()).collect();
    if !without.is_empty() {
        common.say(&format!("without a baseline: {}", without.join(", ")));
    }
    Ok(Ran { rows, failed, holds: accepted::numbers(&holds) })
}

/// Writes `cases.csv`, `samples.csv`, `refinements.csv` and the page with its pictures.
fn write(judged: &[Judged], scene: &Scene, common: &Common, folder: &Path) -> Result<Vec<CaseRow>, Failure> {
    let rows: Vec<CaseRow> = judged.iter().map(|judged| judged.row.clone()).collect();
    write_csv(&folder.join("cases.csv"), &rows)?;
    let manifest = Manifest::new(scene, common.jobs());
    report::suite::write(judged, &manifest, folder).map_err(Failure::run_failed)?;
    Ok(rows)
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

/// Runs the cases with a planted fault, each of which must fail, and writes `mutants.csv`.
fn catch(cases: &[&Case], common: &Common, folder: &Path) -> Result<Ran<Caught>, Failure> {
    common.say(&format!("{:<29} {:>10} {:>10}  {:<44} verdict", "case", "error", "required", "mutant"));
    let ran = each(cases, common, |case, print| {
        let mutant = case.mutant.unwrap_or_default();
        let judged = case.mutant_judged().unwrap_or_else(|| Err(Error::Lacks("mutant").of(case.name)))?;
        let CaseRow { error, required_error, .. } = judged.row;
        let row = Caught { case: judged.case.name, mutant, error, required_error, caught: !judged.row.passed() };
        let verdict = if row.caught { "caught" } else { "not caught" };
        print(&format!("{:<29} {error:>10.2e} {required_error:>10.1e}  {mutant:<44} {verdict}", row.case));
        Ok(row)
    })?;
    write_csv(&folder.join("mutants.csv"), &ran.rows)?;
    common.json(&ran.rows);
    let caught = ran.rows.iter().filter(|row| row.caught).count();
    common.say(&format!("{caught} of {} mutants caught", ran.rows.len()));
    Ok(ran)
}

/// The chosen cases, or all.
fn cases(names: &[String]) -> Result<Vec<&'static Case>, Failure> {
    chosen(("the name of a test case", "cases"), names, suite(), |case| case.name)
}

/// Writes the verdicts of the cases, each as it is known.
fn verdicts(options: &Options, file: &Path, common: &Common) -> Result<(), Failure> {
    let mut cases = cases(&options.cases)?;
    cases.sort_by_key(|case| options.cases.iter().position(|name| name == case.name));
    let mut writer = csv::Writer::from_path(file).map_err(Failure::unwritable(file))?;
    let (stop, mut failed) = (AtomicBool::new(false), Vec::new());
    let work = |_: usize, case: &&Case| (!stop.load(Ordering::Relaxed)).then(|| case.judged());
    let done = |number: usize, result: &Result<Option<Result<Judged, Error>>, Error>| {
        let (passed, reason) = match result {
            Ok(None) => return,
            Ok(Some(Ok(judged))) => (judged.row.passed(), judged.reason.clone()),
            Ok(Some(Err(error))) | Err(error) => (false, error.to_string()),
        };
        let case = cases[number].name.to_owned();
        if !passed {
            stop.store(options.until_failed, Ordering::Relaxed);
            failed.push(case.clone());
        }
        // A table that cannot be written has no verdict, which its reader sees.
        let _ = writer.serialize(Verdict { case, passed, reason }).and_then(|()| Ok(writer.flush()?));
    };
    pool::each(common.jobs(), &cases, work, done);
    if failed.is_empty() { Ok(()) } else { Err(Failure::CheckFailed(format!("failed: {}", failed.join(", ")))) }
}

/// Runs every case, several at a time: the quick ones first, which see most, then the longest. An error in one case stops no other.
fn each<T: Send>(
    cases: &[&Case],
    common: &Common,
    work: impl Fn(&Case, &dyn Fn(&str)) -> Result<T, Error> + Sync,
) -> Result<Ran<T>, Failure> {
    let mut ordered: Vec<(usize, &Case)> = cases.iter().copied().enumerate().collect();
    let place = |case: &Case| if case.is_quick() { case.cost() } else { 1e9 - case.cost() };
    ordered.sort_by(|a, b| place(a.1).total_cmp(&place(b.1)));
    let progress = Progress::new("check", common.silent());
    progress.expect(ordered.iter().map(|(_, case)| case.cost()).sum());
    let print = |line: &str| progress.print(|| common.say(line));
    let done = |number: usize, _: &Result<_, Error>| progress.add(ordered[number].1.cost());
    let results = pool::each(common.jobs(), &ordered, |_, (_, case)| work(case, &print), done);
    progress.finish();
    let mut results: Vec<_> = ordered.iter().zip(results).collect();
    results.sort_by_key(|((number, _), _)| *number);
    let mut ran = Ran { rows: Vec::new(), failed: Vec::new(), holds: Vec::new() };
    for ((_, case), result) in results {
        match result.flatten() {
            Ok(row) => ran.rows.push(row),
            Err(error) => ran.failed.push(error.of(case.name).to_string()),
        }
    }
    Ok(ran)
}

fn header() -> String {
    format!("{:<29} {:>10} {:>10}  {:<43} verdict", "case", "error", "required", "order")
}

fn line(judged: &Judged) -> String {
    let row = &judged.row;
    let theory = if row.required_order.is_empty() { String::new() } else { format!(", theory {}", row.required_order) };
    let order = format!("{}{theory}", judged.convergence.words());
    format!("{:<29} {:>10.2e} {:>10.1e}  {order:<43} {}", row.case, row.error, row.required_error, row.verdict.word())
}

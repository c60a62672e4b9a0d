//! `check`: the verification ladder, and its mutants.

use std::path::{Path, PathBuf};

use mpm_verify::cases::{Climb, LADDER, Rung, Step};
use mpm_verify::manifest::Manifest;
use mpm_verify::report;
use rayon::prelude::*;
use serde::Serialize;

use super::{Failure, jobs, print_json, say, writable, write_csv};
use crate::Common;

/// Runs the named rungs, or all; with `mutants` those with a fault planted.
pub fn run(names: &[String], mutants: bool, common: &Common) -> Result<(), Failure> {
    let folder = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/ladder"));
    if mutants {
        return catch(names, common, &folder);
    }
    let steps = climb(names, common, &folder)?;
    if common.json {
        print_json(&steps);
    }
    let fallen: Vec<&str> = steps.iter().filter(|s| !s.held()).map(|s| s.rung.as_str()).collect();
    if fallen.is_empty() { Ok(()) } else { Err(Failure::FellShort(format!("fell short: {}", fallen.join(", ")))) }
}

/// Climbs the ladder and writes `ladder.csv`, a picture of every rung and `index.html`.
pub fn climb(names: &[String], common: &Common, folder: &Path) -> Result<Vec<Step>, Failure> {
    let rungs = chosen(names)?;
    writable(folder)?;
    let quiet = common.quiet || common.json;
    say(quiet, &format!("{:<22} {:>10} {:>10}  {:<26} verdict", "rung", "error", "required", "order"));
    let (climbs, failed) = each(&rungs, common, |rung| {
        let climb = rung.climb()?;
        say(quiet, &line(&climb.step));
        Ok(climb)
    })?;
    let steps: Vec<Step> = climbs.iter().map(|climb| climb.step.clone()).collect();
    write_csv(&folder.join("ladder.csv"), &steps)?;
    let manifest = Manifest::new(&mpm_verify::scenes::terzaghi(), jobs(common.jobs));
    report::ladder::write(&climbs, &manifest, folder).map_err(|e| Failure::RunFailed(e.to_string()))?;
    unfinished(&failed)?;
    Ok(steps)
}

/// A row of `mutants.csv`.
#[derive(Debug, Serialize)]
struct Caught {
    rung: &'static str,
    mutant: &'static str,
    error: f64,
    required_error: f64,
    caught: bool,
}

impl Caught {
    fn new(climb: &Climb, mutant: &'static str) -> Self {
        let Step { error, required_error, .. } = climb.step;
        Self { rung: climb.rung.name, mutant, error, required_error, caught: !climb.step.held() }
    }
}

/// Runs mutants and writes `mutants.csv`; each must fall short.
fn catch(names: &[String], common: &Common, folder: &Path) -> Result<(), Failure> {
    let rungs = chosen(names)?;
    let without: Vec<&str> = rungs.iter().filter(|rung| rung.mutant.is_none()).map(|rung| rung.name).collect();
    if !(names.is_empty() || without.is_empty()) {
        return Err(Failure::BadInput(format!("check: expected cases with a mutant, found {}", without.join(", "))));
    }
    writable(folder)?;
    let quiet = common.quiet || common.json;
    say(quiet, &format!("{:<22} {:>10} {:>10}  {:<44} caught", "rung", "error", "required", "mutant"));
    let rungs: Vec<&Rung> = rungs.into_iter().filter(|rung| rung.mutant.is_some()).collect();
    let (rows, failed) = each(&rungs, common, |rung| {
        let what = rung.mutant.map_or("", |mutant| mutant.what);
        let climb = rung.climb_mutant().unwrap_or_else(|| Err(format!("{}: no mutant", rung.name)))?;
        let row = Caught::new(&climb, what);
        let caught = if row.caught { "yes" } else { "no" };
        say(
            quiet,
            &format!("{:<22} {:>10.2e} {:>10.1e}  {what:<44} {caught}", row.rung, row.error, row.required_error),
        );
        Ok(row)
    })?;
    write_csv(&folder.join("mutants.csv"), &rows)?;
    if common.json {
        print_json(&rows);
    }
    unfinished(&failed)?;
    let missed: Vec<&str> = rows.iter().filter(|row| !row.caught).map(|row| row.rung).collect();
    if missed.is_empty() { Ok(()) } else { Err(Failure::FellShort(format!("not caught: {}", missed.join(", ")))) }
}

/// The named rungs, or all.
fn chosen(names: &[String]) -> Result<Vec<&'static Rung>, Failure> {
    let known = || LADDER.iter().map(|rung| rung.name).collect::<Vec<_>>().join(", ");
    if let Some(name) = names.iter().find(|name| LADDER.iter().all(|rung| rung.name != name.as_str())) {
        return Err(Failure::BadInput(format!("check: expected one of {}, found {name}", known())));
    }
    let chosen = |rung: &&Rung| names.is_empty() || names.iter().any(|name| name == rung.name);
    Ok(LADDER.iter().filter(chosen).collect())
}

/// Does something with every rung, several at a time; the results in the order of the ladder, and the messages of the rungs that
/// could not be finished: one that fails takes no other down.
fn each<T: Send>(
    rungs: &[&Rung],
    common: &Common,
    work: impl Fn(&Rung) -> Result<T, String> + Sync,
) -> Result<(Vec<T>, Vec<String>), Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(jobs(common.jobs))
        .build()
        .map_err(|e| Failure::BadInput(e.to_string()))?;
    let results: Vec<Result<T, String>> =
        pool.install(|| rungs.par_iter().with_max_len(1).map(|rung| work(rung)).collect());
    let (mut done, mut failed) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Ok(value) => done.push(value),
            Err(message) => failed.push(message),
        }
    }
    Ok((done, failed))
}

/// Runs that could not be finished, once all others are written.
fn unfinished(failed: &[String]) -> Result<(), Failure> {
    if failed.is_empty() { Ok(()) } else { Err(Failure::RunFailed(failed.join("; "))) }
}

fn line(step: &Step) -> String {
    let order = match (step.order, step.order_high) {
        (Some(order), Some(high)) => {
            format!("{order:.2} +- {:.2} ({})", high - order, step.required_order)
        }
        _ => String::new(),
    };
    format!("{:<22} {:>10.2e} {:>10.1e}  {order:<26} {}", step.rung, step.error, step.required_error, step.verdict)
}

//! Which check detects which fault: the cases that detected it before, then the suite with the quick cases first, and the counts of
//! work.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::SWITCH;
use super::detected::Detected;
use super::patches::Mutant;
use crate::cases::{Case, suite};
use crate::error::Error;
use crate::experiment::pool;
use crate::nightly::report::Night;

/// A run of checks is stopped after this and so many times their CPU time.
const PATIENCE: (Duration, f64) = (Duration::from_secs(60), 4.0);
/// CPU time of the counts of work, s.
const COUNTING: f64 = 20.0;
/// First letters of the names of all counts of work.
const WORK: &str = "work";
/// Checks that a row names before it only counts.
const NAMED: usize = 4;

/// A row of `mutants.csv`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Name of the fault.
    pub mutant: String,
    /// Whether a check detected it.
    pub caught: bool,
    /// Which.
    pub by: String,
    /// What is wrong, in words.
    pub what: String,
    /// Time until then, s.
    pub wall_s: f64,
}

/// A line of the table that `check --verdicts` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Name of the case.
    pub case: String,
    /// Whether it passed, or its order is not established.
    pub passed: bool,
    /// Why, with numbers.
    pub reason: String,
}

/// A check that detected a fault: its name, and what it did if it did not fail.
type Found = (String, &'static str);

/// The program with the faults in it.
#[derive(Debug)]
pub struct Spoilt {
    program: PathBuf,
    folder: PathBuf,
    /// Whether every check is asked, in place of the first that detects the fault.
    all: bool,
}

/// Builds the copy.
///
/// # Errors
/// The compiler's last words.
pub fn build(copy: &Path) -> Result<PathBuf, Error> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let target = copy.join("target");
    let output = Command::new(cargo)
        .args(["build", "--profile", "mutants", "-p", "mpm-verify", "--target-dir"])
        .arg(&target)
        .current_dir(copy)
        .output()
        .map_err(Error::at("cargo"))?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        let last: Vec<&str> = text.lines().rev().take(40).collect();
        return Err(Error::Found(last.into_iter().rev().collect::<Vec<_>>().join("\n")));
    }
    Ok(target.join("mutants").join(format!("mpm-verify{}", std::env::consts::EXE_SUFFIX)))
}

impl Spoilt {
    /// The built program, which writes into a folder.
    pub fn new(program: PathBuf, folder: PathBuf, all: bool) -> Self {
        Self { program, folder, all }
    }

    /// Looks for faults, `jobs` at a time. `tell` gets each row as it comes. Checks that detected something must pass in
    /// the unmutated program: those that are `known` are run in it first, the others in the end. What they detect is noted in `known`.
    ///
    /// # Errors
    /// The program could not be run; checks that fail in the unmutated program.
    pub fn find(
        &self,
        mutants: &[(u32, &Mutant)],
        jobs: usize,
        known: &mut Vec<Detected>,
        tell: &(dyn Fn(&Row) + Sync),
    ) -> Result<Vec<Row>, Error> {
        let before = |mutant: &Mutant| known.iter().find(|row| row.fault == mutant.name).map_or(&[][..], |row| &row.by);
        let first: BTreeSet<String> =
            mutants.iter().filter_map(|(_, mutant)| before(mutant).first().cloned()).collect();
        self.require_sound(&first, jobs)?;
        let work = |_: usize, (number, mutant): &(u32, &Mutant)| {
            let clock = Instant::now();
            let found = self.found(*number, before(mutant))?;
            let row = row(mutant, &found, clock.elapsed().as_secs_f64());
            tell(&row);
            Ok::<_, Error>((row, found))
        };
        let all = pool::each(jobs, mutants, work, |_, _| ());
        let all: Vec<(Row, Vec<Found>)> = all.into_iter().map(Result::flatten).collect::<Result<_, _>>()?;
        let named: BTreeSet<String> = all.iter().flat_map(|(_, found)| found).map(|(name, _)| name.clone()).collect();
        self.require_sound(&named.difference(&first).cloned().collect(), jobs)?;
        for (row, found) in &all {
            Detected::note(known, &row.mutant, self.all, found.iter().map(|(name, _)| name.clone()).collect());
        }
        Ok(all.into_iter().map(|(row, _)| row).collect())
    }

    /// The checks that detect a fault: the first one, or all.
    fn found(&self, number: u32, before: &[String]) -> Result<Vec<Found>, Error> {
        let known = |case: &&Case| before.iter().any(|name| name == case.name);
        let mut cases: Vec<&Case> = suite().iter().collect();
        cases.sort_by(|a, b| {
            (!known(a), a.cost()).partial_cmp(&(!known(b), b.cost())).unwrap_or(std::cmp::Ordering::Equal)
        });
        let quick = cases.iter().filter(|case| known(case) || case.is_quick()).count();
        // Where only counts have moved before, they come first.
        let counts_first = before.first().is_some_and(|name| name.starts_with(WORK));
        let (first, last) = if counts_first { cases.split_at(0) } else { cases.split_at(quick) };
        let mut found = self.cases(number, first)?;
        if self.all || found.is_empty() {
            found.extend(self.counts(number)?);
        }
        if self.all || found.is_empty() {
            found.extend(self.cases(number, last)?);
        }
        Ok(found)
    }

    /// Checks that fail in the unmutated program are an error.
    fn require_sound(&self, checks: &BTreeSet<String>, jobs: usize) -> Result<(), Error> {
        let cases: Vec<&Case> = suite().iter().filter(|case| checks.contains(case.name)).collect();
        let all = Self { program: self.program.clone(), folder: self.folder.clone(), all: true };
        let one = |_: usize, case: &&Case| all.cases(0, &[case]);
        let failed = pool::each(jobs, &cases, one, |_, _| ()).into_iter().map(Result::flatten);
        let mut failed = failed.collect::<Result<Vec<_>, _>>()?.concat();
        if checks.iter().any(|name| name.starts_with(WORK)) {
            failed.extend(self.counts(0)?);
        }
        if failed.is_empty() {
            return Ok(());
        }
        let names: Vec<String> = failed.into_iter().map(|(name, how)| name + how).collect();
        Err(Error::Found(format!("the unmutated program fails {}", names.join(", "))))
    }

    /// Runs cases in their order, one at a time. Returns those that failed.
    fn cases(&self, number: u32, cases: &[&Case]) -> Result<Vec<Found>, Error> {
        let mut found = Vec::new();
        let mut rest = cases;
        // A run that stops the program or does not end is that of the first case without a verdict; the cases behind it are run anew.
        while !rest.is_empty() && (self.all || found.is_empty()) {
            let table = self.folder.join(format!("verdicts-{number}-{}.csv", rest[0].name));
            let mut arguments = vec!["check".to_owned(), "--verdicts".to_owned(), table.display().to_string()];
            arguments.extend((!self.all).then(|| "--until-failed".to_owned()));
            arguments.extend(rest.iter().map(|case| case.name.to_owned()));
            let cost: f64 = rest.iter().map(|case| case.cost()).sum();
            let ended = self.run(number, &arguments, cost)?;
            let verdicts: Vec<Verdict> = csv::Reader::from_path(&table)
                .map(|mut rows| rows.deserialize().flatten().collect())
                .unwrap_or_default();
            let _ = fs::remove_file(&table);
            found.extend(verdicts.iter().filter(|row| !row.passed).map(|row| (row.case.clone(), "")));
            if ended.is_some_and(|status| status.code().is_some_and(|code| code < 2)) {
                break;
            }
            rest = &rest[verdicts.len().min(rest.len())..];
            if let Some((stopped, behind)) = rest.split_first() {
                found.push((stopped.name.to_owned(), if ended.is_none() { " (timeout)" } else { " (stopped)" }));
                rest = behind;
            }
        }
        Ok(found)
    }

    /// Counts work. Returns the gates whose counts moved.
    fn counts(&self, number: u32) -> Result<Vec<Found>, Error> {
        let out = self.folder.join(format!("work-{number}"));
        let _ = fs::remove_dir_all(&out);
        let mut arguments = ["nightly", "--only", WORK, "--no-instructions", "--out"].map(str::to_owned).to_vec();
        arguments.push(out.display().to_string());
        let ended = self.run(number, &arguments, COUNTING)?;
        let night = fs::read_dir(&out).into_iter().flatten().flatten().find_map(|entry| {
            let text = fs::read(entry.path().join("summary.json")).ok()?;
            serde_json::from_slice::<Night>(&text).ok()
        });
        let _ = fs::remove_dir_all(&out);
        let Some(night) = night else {
            return Ok(vec![(WORK.to_owned(), if ended.is_none() { " (timeout)" } else { " (stopped)" })]);
        };
        let mut moved: BTreeMap<String, &str> = night.moved.into_iter().map(|moved| (moved.case, "")).collect();
        if !night.fell.is_empty() {
            moved.insert(WORK.to_owned(), "");
        }
        Ok(moved.into_iter().collect())
    }

    /// Runs the program with a fault. Returns how it ended; nothing if it had to be stopped.
    fn run(&self, number: u32, arguments: &[String], cost: f64) -> Result<Option<ExitStatus>, Error> {
        let failed = Error::at::<std::io::Error>(&self.program);
        let mut child = Command::new(&self.program)
            .args(arguments)
            .args(["--quiet", "--jobs", "1"])
            .env(SWITCH, number.to_string())
            // The accepted numbers are those that the copy was built with.
            .current_dir(&self.folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(&failed)?;
        let (start, patience) = (Instant::now(), PATIENCE.0 + Duration::from_secs_f64(PATIENCE.1 * cost));
        loop {
            if let Some(status) = child.try_wait().map_err(&failed)? {
                return Ok(Some(status));
            }
            if start.elapsed() > patience {
                child.kill().map_err(&failed)?;
                child.wait().map_err(&failed)?;
                return Ok(None);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// What is reported of a fault.
fn row(mutant: &Mutant, found: &[Found], wall_s: f64) -> Row {
    let mut by = found.iter().take(NAMED).map(|(name, how)| format!("{name}{how}")).collect::<Vec<_>>().join(", ");
    if found.len() > NAMED {
        by += &format!(" and {} more", found.len() - NAMED);
    }
    Row { mutant: mutant.name.to_owned(), caught: !found.is_empty(), by, what: mutant.what.clone(), wall_s }
}

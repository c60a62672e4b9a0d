//! Which check finds which fault: the suite, quick cases first, and the counts of work.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::SWITCH;
use super::patches::Mutant;
use crate::cases::suite;
use crate::error::Error;
use crate::experiment::CaseRow;
use crate::nightly::report::Night;

/// Cases that take longer than this come second, s.
const QUICK: f64 = 2.0;
/// A run that takes so many times as long as the sound one, and this long at least, will not end.
const PATIENCE: (u32, Duration) = (5, Duration::from_secs(60));
/// Checks that a row names before it only counts.
const NAMED: usize = 4;

/// A row of `mutants.csv`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the fault.
    pub mutant: String,
    /// Whether a check found it.
    pub caught: bool,
    /// Which.
    pub by: String,
    /// What is wrong, in words.
    pub what: String,
}

/// The program with the faults in it, and what it says without one.
#[derive(Debug)]
pub struct Spoilt {
    program: PathBuf,
    folder: PathBuf,
    jobs: usize,
    quick: Vec<String>,
    slow: Vec<String>,
    patience: [Duration; 3],
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

/// How a run of the program ended.
enum Ended {
    With(ExitStatus, String),
    Never,
}

impl Spoilt {
    /// Runs every check without a fault: all must hold, or what they find is worth nothing.
    ///
    /// # Errors
    /// Checks that do not hold.
    pub fn new(program: PathBuf, folder: PathBuf, jobs: usize, tell: &dyn Fn(&str)) -> Result<Self, Error> {
        let all: Vec<String> = suite().iter().map(|case| case.name.to_owned()).collect();
        let hour = Duration::from_secs(3600);
        let mut spoilt = Self { program, folder, jobs, quick: all, slow: Vec::new(), patience: [hour; 3] };
        let (steps, found) = spoilt.judged(0, &spoilt.quick, hour)?;
        if !found.is_empty() {
            return Err(Error::Found(found.join(", ")).of("without a fault"));
        }
        let (quick, slow): (Vec<&CaseRow>, Vec<&CaseRow>) = steps.iter().partition(|step| step.cpu_s <= QUICK);
        let names = |steps: &[&CaseRow]| steps.iter().map(|step| step.case.clone()).collect::<Vec<_>>();
        let time = |steps: &[&CaseRow]| Duration::from_secs_f64(steps.iter().map(|step| step.cpu_s).sum());
        let patient = |time: Duration| (time * PATIENCE.0).max(PATIENCE.1);
        tell(&format!("{} quick cases and {} others hold without a fault", quick.len(), slow.len()));
        (spoilt.quick, spoilt.slow) = (names(&quick), names(&slow));
        let clock = Instant::now();
        let moved = spoilt.count(0, hour)?;
        if !moved.is_empty() {
            return Err(Error::Found(moved.join(", ")).of("without a fault"));
        }
        spoilt.patience = [patient(time(&quick)), patient(time(&slow)), patient(clock.elapsed())];
        Ok(spoilt)
    }

    /// Comparison for a fault by its number.
    ///
    /// # Errors
    /// The program could not be run.
    pub fn find(&self, number: u32, mutant: &Mutant) -> Result<Row, Error> {
        let mut found = self.judged(number, &self.quick, self.patience[0])?.1;
        found.extend(self.count(number, self.patience[2])?);
        if found.is_empty() {
            found = self.judged(number, &self.slow, self.patience[1])?.1;
        }
        let more = found.len().saturating_sub(NAMED);
        let mut by = found.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", ");
        if more > 0 {
            by += &format!(" and {more} more");
        }
        Ok(Row { mutant: mutant.name.to_owned(), caught: !found.is_empty(), by, what: mutant.what.clone() })
    }

    /// Runs cases with a fault. Returns those that were finished, and the names of those that did not hold.
    fn judged(&self, number: u32, cases: &[String], patience: Duration) -> Result<(Vec<CaseRow>, Vec<String>), Error> {
        let out = self.folder.join(format!("suite-{number}"));
        let mut arguments = vec!["check".to_owned()];
        arguments.extend(cases.iter().cloned());
        let Ended::With(status, said) = self.run(number, &arguments, &out, patience)? else {
            return Ok((Vec::new(), vec!["a check that does not end".to_owned()]));
        };
        let path = out.join("cases.csv");
        let steps: Vec<CaseRow> = match csv::Reader::from_path(&path) {
            Ok(mut reader) => reader.deserialize().filter_map(Result::ok).collect(),
            Err(_) => return Ok((Vec::new(), vec![format!("a check that ends with {status}")])),
        };
        let _ = fs::remove_dir_all(&out);
        let mut found: Vec<String> = steps.iter().filter(|s| !s.passed()).map(|s| s.case.clone()).collect();
        let stopped = cases.iter().filter(|case| steps.iter().all(|step| step.case != **case));
        found.extend(stopped.map(|case| format!("{case} (stopped)")));
        if found.is_empty() && !status.success() {
            found.push(format!("check: {}", said.lines().last().unwrap_or("no word")));
        }
        Ok((steps, found))
    }

    /// Counts work with a fault. Returns the gates whose counts moved.
    fn count(&self, number: u32, patience: Duration) -> Result<Vec<String>, Error> {
        let out = self.folder.join(format!("work-{number}"));
        let arguments = ["nightly", "--only", "work", "--no-instructions"].map(str::to_owned);
        let Ended::With(status, _) = self.run(number, &arguments, &out, patience)? else {
            return Ok(vec!["work that does not end".to_owned()]);
        };
        let night = fs::read_dir(&out).into_iter().flatten().flatten().find_map(|entry| {
            let text = fs::read(entry.path().join("summary.json")).ok()?;
            serde_json::from_slice::<Night>(&text).ok()
        });
        let _ = fs::remove_dir_all(&out);
        let Some(night) = night else { return Ok(vec![format!("work that ends with {status}")]) };
        let mut by_case: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for moved in &night.moved {
            by_case.entry(&moved.case).or_default().push(&moved.quantity);
        }
        let mut found: Vec<String> = by_case.iter().map(|(case, q)| format!("{case} ({})", q.join(" "))).collect();
        found.extend(night.fell.clone());
        Ok(found)
    }

    fn run(&self, number: u32, arguments: &[String], out: &Path, patience: Duration) -> Result<Ended, Error> {
        let _ = fs::remove_dir_all(out);
        let failed = Error::at::<std::io::Error>(&self.program);
        let mut errors = tempfile()?;
        let mut child = Command::new(&self.program)
            .args(arguments)
            .args(["--quiet", "--jobs", &self.jobs.to_string(), "--out"])
            .arg(out)
            .env(SWITCH, number.to_string())
            // The accepted numbers are those that the copy was built with.
            .current_dir(&self.folder)
            .stdout(Stdio::null())
            .stderr(errors.try_clone().map_err(&failed)?)
            .spawn()
            .map_err(&failed)?;
        let start = Instant::now();
        loop {
            if let Some(status) = child.try_wait().map_err(&failed)? {
                let mut said = String::new();
                errors.rewind().and_then(|()| errors.read_to_string(&mut said)).map_err(&failed)?;
                return Ok(Ended::With(status, said));
            }
            if start.elapsed() > patience {
                child.kill().map_err(&failed)?;
                child.wait().map_err(&failed)?;
                let _ = fs::remove_dir_all(out);
                return Ok(Ended::Never);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// A file without a name, for what a program says.
fn tempfile() -> Result<fs::File, Error> {
    let path = std::env::temp_dir().join(format!("mpm-verify-{}-said", std::process::id()));
    let file = fs::OpenOptions::new().create(true).truncate(true).read(true).write(true).open(&path);
    file.map_err(Error::at(path))
}

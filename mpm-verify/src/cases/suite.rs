//! The verification suite: all cases of the files of `reference-data/cases`, in their order.

use std::collections::HashMap;
use std::path::Path;
use std::sync::LazyLock;

use cpu_time::ThreadTime;

use super::{PROGRAMS, Program};
use crate::error::Error::{self, Lacks};
use crate::experiment::run::{self, MOMENTUM};
use crate::experiment::spec::{Problem, Spec};
use crate::experiment::verdict::{Judged, Named, Outcome, judge};
use crate::experiment::{CaseRow, accepted};
use crate::files;

/// Names and texts of the files.
const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/cases.rs"));

/// CPU times of the cases, s, as `check --record-cost` wrote them.
const COST: &str = include_str!("../../../reference-data/baselines/cost.csv");
/// Name of that file, beside the accepted values.
pub const COST_NAME: &str = "cost.csv";
/// CPU time of a case without a row, s; shorter times have none.
const SHORT: f64 = 0.05;
/// Largest CPU time of a quick case, s.
const QUICK: f64 = 1.0;

/// The CPU times by the names of the cases.
static COSTS: LazyLock<HashMap<&str, f64>> = LazyLock::new(|| {
    let rows = COST.lines().filter_map(|line| line.split_once(','));
    rows.filter_map(|(case, cpu_s)| Some((case, cpu_s.parse().ok()?))).collect()
});

/// Writes the CPU times of the cases that were run, those of the others as they were, s with two digits.
///
/// # Errors
/// What the system says.
pub fn write_costs(rows: &[CaseRow], path: &Path) -> Result<(), Error> {
    let mut text = "case,cpu_s\n".to_owned();
    for case in suite() {
        let cost = rows.iter().find(|row| row.case == case.name).map_or(case.cost(), |row| row.cpu_s);
        if cost > SHORT {
            // Rounded before its digits are counted: 0.996 is 1.0.
            let cost: f64 = format!("{cost:.1e}").parse().unwrap_or(cost);
            let digits = (1.0 - cost.log10().floor()).max(0.0) as usize;
            text += &format!("{},{cost:.digits$}\n", case.name);
        }
    }
    files::write(path, text.as_bytes()).map_err(Error::at(path))
}

/// A case of the suite.
#[derive(Debug)]
pub struct Case {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows, against what.
    pub about: &'static str,
    /// The fault that its mutant has.
    pub mutant: Option<&'static str>,
    /// The problem that it solves: its place among [`problems`].
    pub problem: usize,
    way: Way,
}

/// What runs a case.
#[derive(Debug)]
enum Way {
    Data(&'static Spec),
    Program(Program),
}

/// Problems and cases, read once.
static ALL: LazyLock<(Vec<Problem>, Vec<Case>)> = LazyLock::new(|| match read() {
    Ok(all) => all,
    // A test reads them.
    Err(error) => panic!("reference-data/cases: {error}"),
});

fn read() -> Result<(Vec<Problem>, Vec<Case>), Error> {
    let (mut problems, mut cases) = (Vec::new(), Vec::new());
    for (file, text) in FILES {
        let (problem, specs) = Problem::parse(text, &format!("{file}.toml"))?;
        for spec in specs {
            cases.push(Case::new(spec, problems.len())?);
        }
        problems.push(problem);
    }
    Ok((problems, cases))
}

/// All cases, in the order of their files.
///
/// # Panics
/// Never: a test reads the files that are built in.
pub fn suite() -> &'static [Case] {
    &ALL.1
}

/// All problems, in the order of their files.
///
/// # Panics
/// As [`suite`].
pub fn problems() -> &'static [Problem] {
    &ALL.0
}

impl Case {
    fn new(spec: Spec, problem: usize) -> Result<Self, Error> {
        if !spec.program {
            // They last as long as the program.
            let spec: &'static Spec = Box::leak(Box::new(spec));
            let mutant = spec.mutant.as_ref().map(|fault| fault.what.as_str());
            return Ok(Self { name: &spec.name, about: &spec.about, mutant, problem, way: Way::Data(spec) });
        }
        let program = PROGRAMS.iter().find(|program| program.name == spec.name);
        let program = *program.ok_or_else(|| Lacks("function that runs it").of(&spec.name))?;
        let mutant = program.mutant.map(|mutant| mutant.what);
        Ok(Self { name: program.name, about: program.about, mutant, problem, way: Way::Program(program) })
    }

    /// The case as it is written, if no function runs it.
    pub fn spec(&self) -> Option<&'static Spec> {
        if let Way::Data(spec) = self.way { Some(spec) } else { None }
    }

    /// CPU time of the case, s.
    pub fn cost(&self) -> f64 {
        COSTS.get(self.name).copied().unwrap_or(SHORT)
    }

    /// Whether `check --quick` runs it.
    pub fn is_quick(&self) -> bool {
        self.cost() <= QUICK
    }

    fn named(&self) -> Named {
        Named { name: self.name, about: self.about, mutant: self.mutant }
    }

    /// Runs and judges the case, and compares its error with the accepted one.
    ///
    /// # Errors
    /// A run of it could not be finished.
    pub fn judged(&self) -> Result<Judged, Error> {
        let mut judged = judged(self.named(), || match &self.way {
            Way::Data(spec) => run::outcome(spec, false),
            Way::Program(program) => (program.run)(),
        })?;
        accepted::compare(&mut judged);
        Ok(judged)
    }

    /// Runs and judges its mutant; `None` if it has none. The accepted error is left out: the check itself must find the fault.
    ///
    /// # Errors
    /// A run of it could not be finished: a fault must be found by the check, not by a run that stops.
    pub fn mutant_judged(&self) -> Option<Result<Judged, Error>> {
        self.mutant?;
        Some(judged(self.named(), || match &self.way {
            Way::Data(spec) => run::outcome(spec, true),
            Way::Program(program) => program.mutant.map_or(Err(Lacks("mutant")), |mutant| (mutant.run)()),
        }))
    }
}

/// Runs and judges.
pub(super) fn judged(named: Named, run: impl FnOnce() -> Result<Outcome, Error>) -> Result<Judged, Error> {
    let clock = ThreadTime::now();
    MOMENTUM.set(None);
    let mut outcome = run().map_err(|e| e.of(named.name))?;
    let momentum = MOMENTUM.take();
    if let Some(missing) = momentum {
        outcome.notes.push(("residual of the momentum balance over its bound".to_owned(), missing, "-".to_owned()));
    }
    let mut judged = judge(named, outcome, clock.elapsed().as_secs_f64());
    if let Some(missing) = momentum.filter(|missing| missing.is_nan() || *missing > 1.0) {
        judged.sound = false;
        judged.fail(&format!("the residual of the momentum balance is {missing:.3e} times its bound"));
    }
    Ok(judged)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::pool;

    #[test]
    fn every_file_can_be_read_and_names_are_unique() {
        let (problems, cases) = read().expect("the built-in cases");
        let mut names: Vec<&str> = cases.iter().map(|case| case.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!((names.len(), problems.len()), (cases.len(), FILES.len()));
        assert!(PROGRAMS.iter().all(|program| names.contains(&program.name)), "a function that no case names");
        // A page of a case says what its exact solution assumes and where it is from.
        for problem in &problems {
            assert!(!problem.assumptions.is_empty() && !problem.sources.is_empty(), "{}", problem.title);
        }
    }

    #[test]
    fn costs_are_those_of_cases_and_are_read_as_they_are_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(COST_NAME);
        write_costs(&[], &path).expect("written");
        assert_eq!(std::fs::read_to_string(&path).expect("a table"), COST);
        assert!(COSTS.len() > 50 && suite().iter().filter(|case| case.is_quick()).count() > 100);
    }

    #[test]
    fn the_scenes_of_all_cases_are_written_as_files_that_can_be_read() {
        for spec in suite().iter().filter_map(Case::spec) {
            let text = spec.written().expect(&spec.name);
            let scene = mpm_core::scene::Scene::parse(&text, &spec.name);
            assert!(
                scene.is_ok(),
                "{}: {}\n{text}",
                spec.name,
                scene.err().map_or_else(String::new, |e| e.to_string())
            );
        }
    }

    /// Cost of a case that is run with the tests, s. `check` runs all cases, `check --mutants` all their faults.
    const LEAST: f64 = 0.1;

    #[test]
    fn the_quickest_cases_of_the_files_pass_and_find_their_faults() {
        let quick: Vec<&Case> = suite()
            .iter()
            .filter(|case| case.spec().is_some() && COSTS.get(case.name).is_some_and(|s| *s <= LEAST))
            .collect();
        assert!(quick.len() >= 10, "{}", quick.len());
        let run = |_: usize, case: &&Case| {
            let judged = case.judged().expect("runs that finish");
            assert!(judged.row.passed(), "{}: {}", case.name, judged.reason);
            let spoilt = case.mutant_judged().expect("a mutant").expect("runs that finish");
            assert!(!spoilt.row.passed(), "{}: {}", case.name, spoilt.reason);
        };
        for (case, result) in quick.iter().zip(pool::each(0, &quick, run, |_, _| {})) {
            result.unwrap_or_else(|error| panic!("{}: {error}", case.name));
        }
    }
}

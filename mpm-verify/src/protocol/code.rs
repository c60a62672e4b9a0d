//! The scores of one code: of results that lie in a folder, or of a command that is run for each case and refinement.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::case::Case;
use super::command::{self, Limits};
use super::export;
use super::results::{self, About, Cost, Said};
use super::score::{Score, Verdict, score};
use crate::error::Error::{self, Found};

/// Name of the file of scores.
pub const SCORES: &str = "scores.json";

/// The scores of one code.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Code {
    /// Its name.
    pub name: String,
    /// What it says of itself.
    #[serde(flatten)]
    pub about: About,
    /// When it was scored, UTC.
    #[serde(default)]
    pub date: String,
    /// The command that was run; empty for results that lay there.
    #[serde(default)]
    pub command: String,
    /// The scores, in the order of the cases.
    pub scores: Vec<Score>,
}

impl Code {
    /// Reads the scores of a folder.
    ///
    /// # Errors
    /// No such file, or one of another form.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        let path = if folder.is_dir() { folder.join(SCORES) } else { folder.to_owned() };
        let text = fs::read_to_string(&path).map_err(Error::at(&path))?;
        serde_json::from_str(&text).map_err(|why| Found(why.to_string()).of(path.display()))
    }

    /// Takes what a code says of itself, the first time that it says something.
    fn hear(&mut self, said: &Said) {
        if self.about == About::default() {
            self.about = said.about.clone();
        }
    }

    /// Adds a score; one of the same case and seed gives way.
    pub fn add(&mut self, score: Score) {
        self.scores.retain(|own| (own.case.as_str(), own.seed) != (score.case.as_str(), score.seed));
        self.scores.push(score);
    }

    /// Scores with a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.scores.iter().filter(|score| score.verdict == verdict).count()
    }

    /// All verdicts in a sentence.
    pub fn sentence(&self) -> String {
        let part = |verdict: Verdict| format!("{} {}", self.count(verdict), verdict.word());
        let all = [Verdict::Passes, Verdict::FirstOrder, Verdict::Wrong, Verdict::NotRun].map(part);
        format!("{} cases: {}", self.scores.len(), all.join(", "))
    }
}

/// Scores results that lie in a folder, one folder of a case's name for each.
pub fn lying(folder: &Path, name: &str, cases: &[Case], told: &dyn Fn(&Score)) -> Code {
    let mut code = Code { name: name.to_owned(), ..Code::default() };
    for case in cases {
        let own = folder.join(&case.name);
        let score = if own.is_dir() {
            let (said, fault) = heard(case, &own);
            code.hear(&said);
            let below = case.refinements.iter().map(|refinement| own.join(refinement.to_string()));
            let costs: Vec<Cost> = below.filter_map(|folder| kept(&folder)).collect();
            let mut score = score(case, &results::read(&own, case), &said, &costs);
            score.faults.extend(fault);
            score
        } else {
            Score::not_run(case, format!("no folder {}", case.name))
        };
        told(&score);
        code.add(score);
    }
    code
}

/// What is said beside the results of a case, and beside those of its refinements.
fn heard(case: &Case, folder: &Path) -> (Said, Option<String>) {
    let (mut said, mut fault) = results::said(folder);
    for refinement in &case.refinements {
        let (other, wrong) = results::said(&folder.join(refinement.to_string()));
        fault = fault.or(wrong);
        if said.code.is_empty() {
            said = Said { runs: said.runs, ..other.clone() };
        }
        said.runs.extend(other.runs);
    }
    (said, fault)
}

/// Runs a command for each case, and for each refinement where it has a place for one, in folders below `out`, and scores what comes of it.
///
/// # Errors
/// A folder that cannot be written, or no shell.
pub fn running(
    (template, limits): (&str, &Limits),
    name: &str,
    cases: &[Case],
    out: &Path,
    stop: &dyn Fn() -> bool,
    told: &dyn Fn(&Score),
) -> Result<Code, Error> {
    let mut code = Code { name: name.to_owned(), command: template.to_owned(), ..Code::default() };
    let questions = out.join("cases");
    make(&questions)?;
    export::write(cases, &questions).map_err(|e| Found(e.to_string()))?;
    for case in cases {
        let folder = out.join("answers").join(&case.name);
        make(&folder)?;
        let question = questions.join(&case.name).join(export::CASE);
        let each = template.contains("{refinement}");
        let refinements = if each { &case.refinements[..] } else { &case.refinements[case.refinements.len() - 1..] };
        let (mut costs, mut troubles, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        for refinement in refinements {
            let own = if each { folder.join(refinement.to_string()) } else { folder.clone() };
            make(&own)?;
            let ended = command::run(
                &command::filled(template, &question, &own, *refinement),
                &own,
                limits,
                *refinement,
                stop,
            )?;
            notes.extend(ended.note);
            match ended.failed {
                // What a command has left that did not end well does not count.
                Some(why) => {
                    let _ = fs::remove_file(own.join(results::RESULTS));
                    troubles.push(if each { format!("refinement {refinement}: {why}") } else { why });
                }
                None => costs.push(keep(ended.cost, &own)?),
            }
            if stop() {
                break;
            }
        }
        let (said, fault) = heard(case, &folder);
        code.hear(&said);
        let measured: &[Cost] = if each { &costs } else { &[] };
        let mut score = score(case, &results::read(&folder, case), &said, measured);
        if !each {
            // One command for all refinements: what it took is that of the finest, unless it says more.
            if let (Some(level), Some(cost)) =
                (score.levels.last_mut().filter(|level| level.cpu_s.is_none()), costs.first())
            {
                (level.cpu_s, level.wall_s, level.peak_mib) = (cost.cpu_s, cost.wall_s, cost.peak_mib);
            }
        }
        if score.verdict == Verdict::NotRun && !troubles.is_empty() {
            score.reason = troubles.remove(0);
            // What a command has not written is no further news where it has failed.
            if costs.is_empty() {
                score.faults.clear();
                troubles.clear();
            }
        }
        score.flags.extend(notes);
        score.faults.splice(0..0, troubles);
        score.faults.extend(fault);
        told(&score);
        code.add(score);
        if stop() {
            break;
        }
    }
    Ok(code)
}

/// Name of what was measured of a command, beside its results.
const COST: &str = "cost.json";

/// Keeps what was measured, so that results can be scored again.
fn keep(cost: Cost, folder: &Path) -> Result<Cost, Error> {
    let text = serde_json::to_string_pretty(&cost).map_err(|why| Found(why.to_string()))?;
    fs::write(folder.join(COST), text + "\n").map_err(Error::at(folder))?;
    Ok(cost)
}

/// What was measured of a command that has left a folder.
fn kept(folder: &Path) -> Option<Cost> {
    serde_json::from_str(&fs::read_to_string(folder.join(COST)).ok()?).ok()
}

fn make(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(Error::at(folder))
}

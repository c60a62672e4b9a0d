//! The claims of the paper on its levee (section 4) and the observations of the experiment, judged by rules from the numbers of a run.

use std::path::Path;

use mpm_core::failure::{Events, PathPoint, Row};
use serde::{Deserialize, Serialize};

use super::run::Ended;
use super::strength::Strength;
pub use crate::claims::Verdict;
use crate::frames::Shot;
use crate::report::numbers::short;
use crate::report::{ReportError, tables};

mod rules;

/// A claim with its verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Name: `failure-time`.
    pub claim: String,
    /// What the paper or the experiment says.
    pub paper: String,
    /// What the run has, with units.
    pub value: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The rule it follows.
    pub rule: String,
}

/// What claims are judged on.
#[derive(Debug, Clone, Copy)]
pub struct Evidence<'a> {
    /// How the run ended.
    pub ended: &'a Ended,
    /// Its history.
    pub rows: &'a [Row],
    /// Stresses at the observed places.
    pub paths: &'a [PathPoint],
    /// Its events.
    pub events: &'a Events,
    /// Its frames.
    pub shots: &'a [Shot],
    /// Strength of the soil; `None` where it has none.
    pub strength: Option<Strength>,
    /// Place of the toe at the start, m.
    pub toe_m: f64,
}

/// Value and whether it follows the rule; `None` where the run has no numbers for it.
type Judged = Option<(String, bool)>;

/// Name, what is said, the rule in words, the rule.
type Rule = (&'static str, &'static str, &'static str, fn(&Evidence) -> Judged);

/// Judges all claims.
pub fn judge(evidence: &Evidence) -> Vec<Claim> {
    let claim = |(name, paper, words, rule): &Rule| {
        let (value, verdict) = match rule(evidence) {
            Some((value, true)) => (value, Verdict::Reproduced),
            Some((value, false)) => (value, Verdict::NotReproduced),
            None => (why_not(evidence), Verdict::NotComparable),
        };
        Claim { claim: (*name).to_owned(), paper: (*paper).to_owned(), value, verdict, rule: (*words).to_owned() }
    };
    rules::RULES.iter().map(claim).collect()
}

fn why_not(evidence: &Evidence) -> String {
    match (evidence.ended, evidence.events.failure_h) {
        (Ended::DoesNotStand(_), _) => "the levee does not stand before any water seeps".to_owned(),
        (_, None) => {
            let end =
                evidence.rows.last().map_or_else(|| "the start".to_owned(), |r| format!("{} h", short(r.time_h, 3)));
            format!("no failure up to {end}")
        }
        _ => "the run has no numbers for it".to_owned(),
    }
}

/// Writes `claims.csv`.
///
/// # Errors
/// A file that cannot be written.
pub fn write(claims: &[Claim], folder: &Path) -> Result<(), ReportError> {
    let row =
        |c: &Claim| [c.claim.as_str(), &c.paper, &c.value, c.verdict.words(), &c.rule].map(str::to_owned).to_vec();
    tables::table(&folder.join("claims.csv"), "claim,paper,value,verdict,rule", claims.iter().map(row))
}

#[cfg(test)]
mod tests;

//! The paper's statements on accuracy (section 3), one by one: evidence and verdict.
//!
//! A verdict follows from numbers by a stated rule. The words of each claim stand in
//! `reference-data/paper/claims.toml`; the rules are the functions of this file and nothing else.

use serde::{Deserialize, Serialize};

use crate::study::{CaseResult, Variant};

/// What became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The numbers show what the paper says.
    Reproduced,
    /// They show it, but not for the reason that the paper gives.
    ReproducedForAnotherReason,
    /// They do not show it.
    NotReproduced,
    /// The runs at hand cannot tell.
    CannotBeTested,
}

impl Verdict {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::ReproducedForAnotherReason => "reproduced for another reason",
            Self::NotReproduced => "not reproduced",
            Self::CannotBeTested => "cannot be tested",
        }
    }
}

/// A claim with its evidence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Name, as in `claims.toml`.
    pub id: String,
    /// What the paper says, in short.
    pub said: String,
    /// The rule that the verdict follows.
    pub rule: String,
    /// What was computed, with its numbers.
    pub evidence: String,
    /// The verdict.
    pub verdict: Verdict,
    /// File name (without ending) of the plot that shows it.
    pub picture: String,
}

/// Judges every claim on the results of a study.
pub fn judge(_results: &[CaseResult]) -> Vec<Claim> {
    let _ = Variant::Base;
    Vec::new()
}

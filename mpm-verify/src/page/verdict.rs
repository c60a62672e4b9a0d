//! The verdict at the top of a page, and the counts of verdicts that the home page lists.

use serde::{Deserialize, Serialize};

use crate::claims;
pub use crate::verdict::State;

/// Most words of the sentence of a verdict.
pub const WORDS: usize = 25;

/// A badge, which is the word of its state, and one sentence of at most [`WORDS`] words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Verdict {
    /// The state.
    pub state: State,
    /// The sentence.
    pub sentence: String,
}

impl Verdict {
    /// A verdict with its sentence.
    pub fn new(state: State, sentence: impl Into<String>) -> Self {
        Self { state, sentence: sentence.into() }
    }
}

/// Verdicts of one kind, counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Counts {
    /// Whether runs came to their end.
    Runs {
        /// Runs that came to their end.
        complete: usize,
        /// Runs that stopped before their end.
        stopped: usize,
    },
    /// Results beside the truth.
    Checks(Checks),
    /// Claims of others.
    Claims {
        /// Claims that are reproduced.
        reproduced: usize,
        /// Claims that are not reproduced.
        not_reproduced: usize,
        /// Claims that cannot be tested.
        not_comparable: usize,
    },
    /// Nights beside what is accepted.
    Nights {
        /// Nights that moved nothing.
        unchanged: usize,
        /// Nights that moved something, none of it for the worse.
        moved: usize,
        /// Nights that got worse, or had a check that failed.
        #[serde(default)]
        worse: usize,
        /// Nights that moved nothing and were not run whole.
        #[serde(default)]
        in_part: usize,
    },
}

/// Results beside the truth, counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Checks {
    /// Results that passed.
    pub passed: usize,
    /// Results that are worse than required where a scheme need not hold.
    pub degraded: usize,
    /// Runs that stopped with a reason in place of a wrong result.
    pub stopped: usize,
    /// Results that are not established.
    pub not_established: usize,
    /// Results that failed.
    pub failed: usize,
}

/// Kinds of counts, in the order of the home page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Runs.
    Runs,
    /// Results beside the truth.
    Checks,
    /// Claims of others.
    Claims,
    /// Nights.
    Nights,
}

impl Kind {
    /// Name of the kind on the home page.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Runs => "Runs",
            Self::Checks => "Checks against exact or published results",
            Self::Claims => "Claims of the paper and the experiment",
            Self::Nights => "Nightly runs",
        }
    }
}

impl Counts {
    /// Claims with these verdicts; one that is reproduced for another reason than its author gives is reproduced.
    pub fn of_claims(verdicts: impl IntoIterator<Item = claims::Verdict>) -> Self {
        use claims::Verdict::{NotComparable, NotReproduced, Reproduced, ReproducedForAnotherReason};
        let (mut reproduced, mut not_reproduced, mut not_comparable) = (0, 0, 0);
        for verdict in verdicts {
            *match verdict {
                Reproduced | ReproducedForAnotherReason => &mut reproduced,
                NotReproduced => &mut not_reproduced,
                NotComparable => &mut not_comparable,
            } += 1;
        }
        Self::Claims { reproduced, not_reproduced, not_comparable }
    }

    /// Kind of the counts.
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Runs { .. } => Kind::Runs,
            Self::Checks(_) => Kind::Checks,
            Self::Claims { .. } => Kind::Claims,
            Self::Nights { .. } => Kind::Nights,
        }
    }

    /// Each count with its word.
    fn parts(&self) -> Vec<(usize, &'static str)> {
        match *self {
            Self::Runs { complete, stopped } => vec![(complete, "complete"), (stopped, "stopped")],
            Self::Checks(Checks { passed, degraded, stopped, not_established, failed }) => vec![
                (passed, "passed"),
                (degraded, "degraded"),
                (stopped, "stopped with a reason"),
                (not_established, "not established"),
                (failed, "failed"),
            ],
            Self::Claims { reproduced, not_reproduced, not_comparable } => {
                vec![(reproduced, "reproduced"), (not_reproduced, "not reproduced"), (not_comparable, "not comparable")]
            }
            Self::Nights { unchanged, moved, worse, in_part } => vec![
                (unchanged, "unchanged"),
                (moved, "moved otherwise"),
                (worse, "worse or failed"),
                (in_part, "in part"),
            ],
        }
    }

    /// Counts in words: `6 reproduced, 2 not reproduced`.
    pub fn words(&self) -> String {
        let parts: Vec<String> =
            self.parts().iter().filter(|(n, _)| *n > 0).map(|(n, word)| format!("{n} {word}")).collect();
        if parts.is_empty() { "none".to_owned() } else { parts.join(", ") }
    }

    /// Sum of the counts.
    pub fn total(&self) -> usize {
        self.parts().iter().map(|(n, _)| n).sum()
    }

    /// The state that follows from the counts: the worst of all.
    pub fn state(&self) -> State {
        match *self {
            Self::Runs { stopped: 1.., .. } => State::Stopped,
            Self::Runs { .. } => State::Complete,
            Self::Checks(Checks { failed: 1.., .. }) => State::Failed,
            Self::Checks(Checks { degraded: 1.., .. }) => State::Degraded,
            // Most of a suite may pass with an order that is not established, and a scheme may refuse what it cannot do.
            Self::Checks(Checks { passed: 0, .. }) => State::NotEstablished,
            Self::Checks(_) => State::Passed,
            Self::Claims { reproduced, .. } => State::Claims { reproduced, total: self.total() },
            Self::Nights { worse: 1.., .. } => State::Worse,
            Self::Nights { moved: 1.., .. } => State::Moved,
            Self::Nights { in_part: 1.., .. } => State::NotEstablished,
            Self::Nights { .. } => State::Unchanged,
        }
    }

    /// Sum with other counts of the same kind; `None` for one of another kind.
    pub fn with(&self, other: &Self) -> Option<Self> {
        Some(match (*self, *other) {
            (Self::Runs { complete: a, stopped: b }, Self::Runs { complete, stopped }) => {
                Self::Runs { complete: a + complete, stopped: b + stopped }
            }
            (Self::Checks(a), Self::Checks(b)) => Self::Checks(Checks {
                passed: a.passed + b.passed,
                degraded: a.degraded + b.degraded,
                stopped: a.stopped + b.stopped,
                not_established: a.not_established + b.not_established,
                failed: a.failed + b.failed,
            }),
            (
                Self::Claims { reproduced: a, not_reproduced: b, not_comparable: c },
                Self::Claims { reproduced, not_reproduced, not_comparable },
            ) => Self::Claims {
                reproduced: a + reproduced,
                not_reproduced: b + not_reproduced,
                not_comparable: c + not_comparable,
            },
            (
                Self::Nights { unchanged: a, moved: b, worse: c, in_part: d },
                Self::Nights { unchanged, moved, worse, in_part },
            ) => Self::Nights { unchanged: a + unchanged, moved: b + moved, worse: c + worse, in_part: d + in_part },
            _ => return None,
        })
    }
}

/// Verdicts of one kind in a report, counted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Stored")]
pub struct Tally {
    /// Subject of the counts: `Verification suite`.
    pub label: String,
    /// The counts.
    pub counts: Counts,
}

impl Tally {
    /// Counts with what they are of.
    pub fn new(label: &str, counts: Counts) -> Self {
        Self { label: label.to_owned(), counts }
    }
}

/// A tally as it is stored; before the counts had kinds of their own there were three numbers.
#[derive(Deserialize)]
struct Stored {
    label: String,
    counts: Option<Counts>,
    #[serde(default)]
    passed: usize,
    #[serde(default)]
    failed: usize,
    #[serde(default)]
    not_established: usize,
    #[serde(default)]
    claims: bool,
}

impl From<Stored> for Tally {
    fn from(Stored { label, counts, passed, failed, not_established, claims }: Stored) -> Self {
        let earlier = match claims {
            true => Counts::Claims { reproduced: passed, not_reproduced: failed, not_comparable: not_established },
            false => Counts::Checks(Checks { passed, failed, not_established, ..Checks::default() }),
        };
        Self { label, counts: counts.unwrap_or(earlier) }
    }
}

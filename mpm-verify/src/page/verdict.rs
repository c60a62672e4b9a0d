//! The verdict at the top of a page, and the counts of verdicts that the home page lists.

use serde::{Deserialize, Serialize};

/// The three states of anything that is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// Everything required is met.
    #[serde(rename = "passed")]
    Passed,
    /// A requirement is not met, or a run failed.
    #[serde(rename = "failed")]
    Failed,
    /// The results at hand do not suffice to tell.
    #[serde(rename = "not established")]
    NotEstablished,
}

impl State {
    /// In words.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::NotEstablished => "not established",
        }
    }

    /// The class of its badge.
    pub const fn mark(self) -> &'static str {
        match self {
            Self::Passed => "good",
            Self::Failed => "bad",
            Self::NotEstablished => "warn",
        }
    }

    /// `Passed` or `Failed`.
    pub const fn of(passed: bool) -> Self {
        if passed { Self::Passed } else { Self::Failed }
    }
}

/// Most words of the sentence of a verdict.
pub const WORDS: usize = 25;

/// A badge and one sentence of at most [`WORDS`] words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Verdict {
    /// The state.
    pub state: State,
    /// Text of the badge.
    pub word: String,
    /// The sentence.
    pub sentence: String,
}

impl Verdict {
    /// A verdict whose badge is the word of its state.
    pub fn new(state: State, sentence: impl Into<String>) -> Self {
        Self { state, word: state.word().to_owned(), sentence: sentence.into() }
    }

    /// With another text of the badge: `6 of 8 reproduced`.
    pub fn saying(self, word: impl Into<String>) -> Self {
        Self { word: word.into(), ..self }
    }
}

/// Verdicts of one kind, counted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Of what: `Verification suite`.
    pub label: String,
    /// How many passed (claims: are reproduced).
    pub passed: usize,
    /// How many failed (claims: are not reproduced).
    pub failed: usize,
    /// How many are not established (claims: not comparable; stress tests: degraded or stopped).
    pub not_established: usize,
    /// How many there are.
    pub total: usize,
    /// The counts in the words of their kind: `6 reproduced, 2 not reproduced`.
    pub said: String,
    /// Whether they are claims of the paper, which are reproduced or not, rather than checks, which pass or fail.
    #[serde(default)]
    pub claims: bool,
}

impl Tally {
    /// Counts in the usual words.
    pub fn new(label: &str, passed: usize, failed: usize, not_established: usize) -> Self {
        Self::in_words(label, [(passed, "passed"), (failed, "failed"), (not_established, "not established")])
    }

    /// Counts of passed, failed and not established, each with its word.
    pub fn in_words(label: &str, counts: [(usize, &str); 3]) -> Self {
        let parts: Vec<String> = counts.iter().filter(|(n, _)| *n > 0).map(|(n, word)| format!("{n} {word}")).collect();
        let [passed, failed, not_established] = counts.map(|(n, _)| n);
        let total = passed + failed + not_established;
        let said = if parts.is_empty() { "none".to_owned() } else { parts.join(", ") };
        let claims = counts[0].1 == "reproduced";
        Self { label: label.to_owned(), passed, failed, not_established, total, said, claims }
    }

    /// Claims, counted.
    pub fn of_claims(label: &str, reproduced: usize, not_reproduced: usize, not_comparable: usize) -> Self {
        let counts =
            [(reproduced, "reproduced"), (not_reproduced, "not reproduced"), (not_comparable, "not comparable")];
        Self::in_words(label, counts)
    }

    /// With other words for the counts.
    pub fn saying(self, said: impl Into<String>) -> Self {
        Self { said: said.into(), ..self }
    }

    /// Text of its badge: the word of its state, or how many claims are reproduced.
    pub fn word(&self) -> String {
        match self.claims {
            true => format!("{} of {} reproduced", self.passed, self.total),
            false => self.state().word().to_owned(),
        }
    }

    /// The state that follows from the counts. A claim that is not reproduced is no failure of this program.
    pub fn state(&self) -> State {
        match self {
            Self { claims: true, passed, total, .. } if passed < total => State::NotEstablished,
            Self { failed: 1.., .. } => State::Failed,
            Self { passed: 0, .. } => State::NotEstablished,
            _ => State::Passed,
        }
    }
}

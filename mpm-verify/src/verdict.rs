//! The words of verdicts. Four things are told apart: a run is complete, a result is correct, a night has moved nothing, claims are
//! reproduced. The colour of each follows from the state.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// The state of anything that is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// A run has come to its end. This says nothing of whether its result is correct.
    Complete,
    /// A run ended before that.
    Stopped,
    /// A result agrees with the truth as it should.
    Passed,
    /// A result is worse than required where more is not expected to hold: a default scheme outside of what it bears.
    Degraded,
    /// The results at hand do not suffice to tell.
    #[serde(rename = "not established", alias = "order not established")]
    NotEstablished,
    /// A result does not agree with the truth.
    Failed,
    /// Nothing that is measured every night has moved.
    Unchanged,
    /// Something has, for the worse, or is gone.
    Worse,
    /// Something has, not for the worse.
    Moved,
    /// Claims of others, of which so many are reproduced. One that is not is no failure of this program.
    Claims {
        /// Claims that are reproduced.
        reproduced: usize,
        /// Number of claims, of each verdict.
        total: usize,
    },
}

impl State {
    /// The state in words.
    pub fn word(self) -> Cow<'static, str> {
        Cow::Borrowed(match self {
            Self::Complete => "complete",
            Self::Stopped => "stopped",
            Self::Passed => "passed",
            Self::Degraded => "degraded",
            Self::NotEstablished => "not established",
            Self::Failed => "failed",
            Self::Unchanged => "unchanged",
            Self::Worse | Self::Moved => "moved",
            Self::Claims { reproduced, total } => return Cow::Owned(format!("{reproduced} of {total} reproduced")),
        })
    }

    /// The class of its badge, which is its colour: green, amber, red, or none for what is only complete.
    pub fn mark(self) -> &'static str {
        match self {
            Self::Complete => "",
            Self::Passed | Self::Unchanged => "good",
            Self::Claims { reproduced: n @ 1.., total } if n == total => "good",
            Self::Degraded | Self::NotEstablished | Self::Moved | Self::Claims { .. } => "warn",
            Self::Stopped | Self::Failed | Self::Worse => "bad",
        }
    }

    /// `Passed` or `Failed`.
    pub const fn of(passed: bool) -> Self {
        if passed { Self::Passed } else { Self::Failed }
    }
}

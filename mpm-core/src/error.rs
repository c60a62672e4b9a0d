//! What can go wrong, with the numbers that a reader needs to correct it.

use std::path::PathBuf;

/// A scene that cannot be run as written. Exit code 2.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.lines().join("\n"))]
pub struct SceneError {
    /// Path of the scene file as the user gave it; empty for a flag.
    pub file: String,
    /// Line of the offending key or value, counted from 1; 0 for a flag.
    pub line: usize,
    /// Dotted name of the key, e.g. `soil.poisson_ratio`, or the flag that stands in its place, e.g. `--tolerance`.
    pub key: String,
    /// The rule of what is accepted, with its unit: the same for every scene. [`Notes::here`] has what it comes to in this one.
    pub expected: String,
    /// What stands there.
    pub found: String,
    /// What else there is to say.
    pub notes: Option<Box<Notes>>,
}

/// What is said beside a fault of a scene.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Notes {
    /// Values of this scene that its rule names, e.g. "lambda = 0.1".
    pub here: Option<String>,
    /// The name that was probably meant.
    pub suggestion: Option<String>,
    /// Further faults of the same file.
    pub more: Vec<SceneError>,
    /// Values that look as if they stood in another unit, and names of an earlier version.
    pub warnings: Vec<Warning>,
}

impl SceneError {
    /// A fault without notes.
    pub(crate) fn new(
        (file, line): (String, usize),
        key: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self { file, line, key: key.into(), expected: expected.into(), found: found.into(), notes: None }
    }

    /// The notes, to be written.
    pub(crate) fn notes_mut(&mut self) -> &mut Notes {
        self.notes.get_or_insert_default()
    }

    /// The error with the values that its rule has in the scene.
    pub(crate) fn with(mut self, here: impl Into<String>) -> Self {
        self.notes_mut().here = Some(here.into());
        self
    }

    /// This fault and the further ones, each by itself.
    pub(crate) fn apart(mut self) -> Vec<Self> {
        let more = self.notes.as_mut().map_or_else(Vec::new, |notes| std::mem::take(&mut notes.more));
        std::iter::once(self).chain(more).collect()
    }

    /// Warnings, the fault, what was probably meant, and the further faults.
    fn lines(&self) -> Vec<String> {
        let place = if self.line == 0 { String::new() } else { format!("{}:{}: ", self.file, self.line) };
        let here =
            self.notes.iter().find_map(|notes| Some(format!(", here {}", notes.here.as_ref()?))).unwrap_or_default();
        let fault = format!("{place}{}: expected {}{here}, found {}", self.key, self.expected, self.found);
        let Some(notes) = &self.notes else { return vec![fault] };
        let mut lines: Vec<String> = notes.warnings.iter().map(ToString::to_string).collect();
        lines.push(fault);
        lines.extend(notes.suggestion.iter().map(|name| format!("    did you mean `{name}`?")));
        lines.extend(notes.more.iter().flat_map(Self::lines));
        lines
    }
}

/// Something in a scene file that is accepted, but that its author should see.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// Path of the scene file as the user gave it; empty for a flag.
    pub file: String,
    /// Line of the key or value, counted from 1; 0 for a flag.
    pub line: usize,
    /// Dotted name of the key, or the flag that stands in its place.
    pub key: String,
    /// What is noticed, as half a sentence.
    pub what: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.line > 0 {
            write!(f, "{}:{}: ", self.file, self.line)?;
        }
        write!(f, "warning: {}: {}", self.key, self.what)
    }
}

/// Where a run went wrong. Exit code 3; what was computed before is kept by the caller.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("run failed at step {step}, t = {time:.6e} s, {place}: {what}")]
pub struct RunError {
    /// Number of steps completed before the failure.
    pub step: u64,
    /// Simulated time, s, from the start of the run.
    pub time: f64,
    /// Particle or cell, with coordinates in m.
    pub place: String,
    /// What was found there.
    pub what: String,
}

/// A scene file that could not be turned into a run.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file could not be read.
    #[error("{}: expected a readable scene file, found: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file was read and refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

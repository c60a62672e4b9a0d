//! What can go wrong, with the numbers a reader needs to mend it.

use std::path::PathBuf;

/// A scene that cannot be run as written. Exit code 2.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}{key}: expected {expected}, found {found}", self.place())]
pub struct SceneError {
    /// Path of the scene file as the user gave it; empty for a flag.
    pub file: String,
    /// Line of the offending key or value, counted from 1; 0 for a flag.
    pub line: usize,
    /// Dotted name of the key, e.g. `soil.poisson_ratio`, or the flag that stands in its place, e.g. `--tolerance`.
    pub key: String,
    /// What would have been accepted, with its unit.
    pub expected: String,
    /// What stands there.
    pub found: String,
}

impl SceneError {
    /// `file:line: `, or nothing for a flag.
    fn place(&self) -> String {
        if self.line == 0 { String::new() } else { format!("{}:{}: ", self.file, self.line) }
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

//! What can go wrong between reading a scene and judging its results, each with its cause.

use std::io;
use std::path::{Path, PathBuf};

use mpm_core::checkpoint::RestoreError;
use mpm_core::error::{LoadError, RunError, SceneError};
use mpm_core::run::StartError;
use mpm_core::scene::UnfitLoad;
use mpm_core::stability::StepTooLarge;
use mpm_core::step::Fault;

use crate::checkpoint::CheckpointError;
use crate::exact::limit_equilibrium;
use crate::suggest::{listed, nearest};

/// Why something could not be run, read or judged.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene that cannot be run as written or edited.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A scene file that cannot be read, or is refused.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A scene that cannot be started.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A step above the stability limit.
    #[error(transparent)]
    Step(#[from] StepTooLarge),
    /// A load that the scheme cannot carry.
    #[error(transparent)]
    Burden(#[from] UnfitLoad),
    /// A run that failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Steps taken without a driver that failed.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// A state that cannot be restored.
    #[error(transparent)]
    Restore(#[from] RestoreError),
    /// A checkpoint that cannot be read or written, or belongs to another run.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// A slip circle without a factor of safety.
    #[error(transparent)]
    Circle(#[from] limit_equilibrium::Refused),
    /// The system starts no threads.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A file or a program that the system refuses, or a file with unexpected content.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// A row that does not fit the columns of its table.
    #[error("{file}:{}: expected {columns}, found: {source}", source.position().map_or(0, csv::Position::line))]
    Row {
        /// The file.
        file: String,
        /// Its columns.
        columns: &'static str,
        /// What is wrong.
        source: csv::Error,
    },
    /// An input that is refused.
    #[error("{key}: expected {expected}, found {found}")]
    Refused {
        /// Key of a scene, flag, or place in a file.
        key: String,
        /// What would have been accepted, with its unit.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A name that does not exist.
    #[error("expected {what}, found {found}; did you mean {}? All names: mpm-verify list {kind}", listed(nearest))]
    Unknown {
        /// What was expected.
        what: &'static str,
        /// What `mpm-verify list` calls them.
        kind: &'static str,
        /// What was given.
        found: String,
        /// Existing names like it.
        nearest: Vec<String>,
    },
    /// Something that is needed is missing.
    #[error("no {0}")]
    Lacks(&'static str),
    /// A scene or a result that cannot be used here.
    #[error("{0}")]
    Unfit(&'static str),
    /// The same, with numbers.
    #[error("{0}")]
    Found(String),
    /// An error in the program itself.
    #[error("the program panicked: {0}")]
    Panicked(String),
    /// An error with the name of the case, scene or file that it belongs to.
    #[error("{name}: {source}")]
    Of {
        /// Name of the case, scene or file.
        name: String,
        /// The error.
        source: Box<Error>,
    },
}

impl Error {
    /// Puts the name of a case, scene or file before the error.
    pub fn of(self, name: impl ToString) -> Self {
        Self::Of { name: name.to_string(), source: Box::new(self) }
    }

    /// The error of the system for a file.
    pub fn at<E: Into<io::Error>>(path: impl AsRef<Path>) -> impl Fn(E) -> Self {
        move |source| Self::File { path: path.as_ref().to_owned(), source: source.into() }
    }

    /// An input that is refused: what was expected, what was found.
    pub fn refused(key: impl ToString, expected: impl ToString, found: impl ToString) -> Self {
        Self::Refused { key: key.to_string(), expected: expected.to_string(), found: found.to_string() }
    }

    /// A name that does not exist, with the nearest of the existing names.
    pub fn unknown<'a>(
        (what, kind): (&'static str, &'static str),
        found: &str,
        names: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let nearest = nearest(found, names).into_iter().map(str::to_owned).collect();
        Self::Unknown { what, kind, found: found.to_owned(), nearest }
    }
}

//! What can go wrong between a scene and what is said of it, each with its cause.

use std::io;
use std::path::{Path, PathBuf};

use mpm_core::checkpoint::RestoreError;
use mpm_core::error::{LoadError, RunError, SceneError};
use mpm_core::run::StartError;
use mpm_core::scene::UnfitLoad;
use mpm_core::stability::StepTooLarge;
use mpm_core::step::Fault;

use crate::checkpoint::CheckpointError;
use crate::exact::slip_circle;

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
    /// A load that the scheme does not bear.
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
    /// A file of a state that cannot be read or written, or is not of this run.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// A slip circle without a factor of safety.
    #[error(transparent)]
    Circle(#[from] slip_circle::Refused),
    /// The system gives no threads.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A file, or a program, that the system refuses, or whose content is not what it should be.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A row that is none of its table.
    #[error("{file}:{}: expected {columns}, found: {source}", source.position().map_or(0, csv::Position::line))]
    Row {
        /// The file.
        file: String,
        /// Its columns.
        columns: &'static str,
        /// What is wrong.
        source: csv::Error,
    },
    /// An input that is not what it has to be.
    #[error("{key}: expected {expected}, found {found}")]
    Refused {
        /// Key of a scene, flag, or place in a file.
        key: String,
        /// What would have been accepted, with its unit.
        expected: String,
        /// What is there.
        found: String,
    },
    /// Something is missing that is needed.
    #[error("no {0}")]
    Lacks(&'static str),
    /// A scene, or what its run came to, that is of no use here.
    #[error("{0}")]
    Unfit(&'static str),
    /// The same, with the numbers that were found.
    #[error("{0}")]
    Found(String),
    /// A fault of the program.
    #[error("the program panicked: {0}")]
    Panicked(String),
    /// One of these, and of what.
    #[error("{name}: {source}")]
    Of {
        /// Name of a case, a scene or a file.
        name: String,
        /// What went wrong with it.
        source: Box<Error>,
    },
}

impl Error {
    /// The error with the name of what it is of before it.
    pub fn of(self, name: impl ToString) -> Self {
        Self::Of { name: name.to_string(), source: Box::new(self) }
    }

    /// What the system says of a file.
    pub fn at<E: Into<io::Error>>(path: impl AsRef<Path>) -> impl Fn(E) -> Self {
        move |source| Self::File { path: path.as_ref().to_owned(), source: source.into() }
    }

    /// An input that is not what it has to be.
    pub fn refused(key: impl ToString, expected: impl ToString, found: impl ToString) -> Self {
        Self::Refused { key: key.to_string(), expected: expected.to_string(), found: found.to_string() }
    }
}

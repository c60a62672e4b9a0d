//! One command per file.

pub mod check;
pub mod levee;
pub mod list;
pub mod nightly;
pub mod report;
pub mod solve;
pub mod stability;
pub mod study;

use std::fs;
use std::io::Write;
use std::path::Path;

use serde::Serialize;

/// Why a command did not succeed. The exit codes are 1, 2 and 3.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A check fell short of what it must show.
    #[error("{0}")]
    FellShort(String),
    /// Bad input or usage; nothing was run.
    #[error("{0}")]
    BadInput(String),
    /// A run failed; what was computed is kept.
    #[error("{0}")]
    RunFailed(String),
}

/// Makes a folder and proves that it can be written to, before anything is run.
fn writable(folder: &Path) -> Result<(), Failure> {
    let refused = |e: std::io::Error| {
        Failure::BadInput(format!("--out: expected a folder that can be written to, found {}: {e}", folder.display()))
    };
    fs::create_dir_all(folder).map_err(refused)?;
    let probe = folder.join(".mpm-verify-probe");
    fs::write(&probe, b"").map_err(refused)?;
    fs::remove_file(&probe).map_err(refused)
}

/// Writes rows as CSV with a header.
fn write_csv<T: Serialize>(path: &Path, rows: &[T]) -> Result<(), Failure> {
    let lost = |e: String| Failure::RunFailed(format!("{}: {e}", path.display()));
    let mut writer = csv::Writer::from_path(path).map_err(|e| lost(e.to_string()))?;
    for row in rows {
        writer.serialize(row).map_err(|e| lost(e.to_string()))?;
    }
    writer.flush().map_err(|e| lost(e.to_string()))
}

/// Writes a value as JSON.
fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|e| Failure::RunFailed(e.to_string()))?;
    fs::write(path, text + "\n").map_err(|e| Failure::RunFailed(format!("{}: {e}", path.display())))
}

/// Prints a line unless quiet. A closed pipe is no error.
fn say(quiet: bool, line: &str) {
    if !quiet {
        let _ = writeln!(std::io::stdout(), "{line}");
    }
}

/// Prints a value as JSON on standard output.
fn print_json<T: Serialize>(value: &T) {
    if let Ok(text) = serde_json::to_string_pretty(value) {
        let _ = writeln!(std::io::stdout(), "{text}");
    }
}

/// Threads to use.
fn jobs(asked: usize) -> usize {
    if asked > 0 { asked } else { std::thread::available_parallelism().map_or(1, usize::from) }
}

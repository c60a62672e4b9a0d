//! One command per file.

pub mod check;
pub mod gate;
pub mod levee;
pub mod list;
pub mod merge;
pub mod mutants;
pub mod nightly;
pub mod report;
pub mod solve;
pub mod stability;
pub mod study;

use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use mpm_verify::files::Folder;
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

/// Takes a folder for this process before anything is run, lets `work` write into its stage, and publishes what it wrote if it
/// succeeds. What could not be written whole is not published.
fn into_folder<T>(path: &Path, work: impl FnOnce(&Folder) -> Result<T, Failure>) -> Result<T, Failure> {
    let folder = Folder::take(path).map_err(|e| Failure::BadInput(format!("--out: {e}")))?;
    let result = work(&folder)?;
    folder.publish().map_err(|e| Failure::RunFailed(e.to_string()))?;
    Ok(result)
}

/// Makes a folder inside one that is taken.
fn inside(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|e| Failure::RunFailed(format!("{}: {e}", folder.display())))
}

/// Set by the first Ctrl-C; a second one ends at once.
fn interrupts() -> Arc<AtomicBool> {
    let stopped = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stopped);
    let set = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(3);
        }
        eprintln!("stopping at the next look; once more to stop at once");
    });
    // Without a handler Ctrl-C ends the run, as it does everywhere: what was kept so far remains.
    drop(set);
    stopped
}

/// The command as it was given, with a flag more.
fn again_with(flag: &str) -> String {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != flag).collect();
    format!("mpm-verify {} {flag}", arguments.join(" "))
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

/// Parses a time.
fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("expected 0 to 1e6 s".to_owned()),
    }
}

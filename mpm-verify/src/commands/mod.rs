//! One command per file.

pub mod check;
pub mod gallery;
pub mod gate;
pub mod levee;
pub mod list;
pub mod merge;
pub mod metamorphic;
pub mod mutants;
pub mod nightly;
pub mod report;
pub mod solve;
pub mod stability;
pub mod study;

use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use mpm_core::hardware::Hardware;
use mpm_core::scene::Scene;
use mpm_verify::error::Error::{self, Unfit};
use mpm_verify::files::{Folder, FolderError};
use mpm_verify::page::site;
use mpm_verify::patience::{Estimate, LONG, estimate};
use mpm_verify::progress::time;
use serde::Serialize;

use crate::Common;

/// Why a command did not succeed. The exit codes are 1, 2 and 3.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A check fell short of what it must show.
    #[error("{0}")]
    CheckFailed(String),
    /// Bad input or usage; nothing was run.
    #[error("{0}")]
    BadInput(String),
    /// A run failed; what was computed is kept.
    #[error("{0}")]
    RunFailed(String),
}

impl Failure {
    fn bad_input(error: impl ToString) -> Self {
        Self::BadInput(error.to_string())
    }

    fn run_failed(error: impl ToString) -> Self {
        Self::RunFailed(error.to_string())
    }
}

/// Takes a folder for this process before anything is run, with room for results of some names, lets `work` write into its stage, and
/// publishes what it wrote if it succeeds. What could not be written whole is not published.
fn into_folder<T>(path: &Path, names: &[&str], work: impl FnOnce(&Folder) -> Result<T, Failure>) -> Result<T, Failure> {
    let bad = |e: FolderError| Failure::BadInput(format!("--out: {e}"));
    let folder = Folder::take(path).map_err(bad)?;
    folder.has_room_for(names).map_err(bad)?;
    let result = work(&folder)?;
    folder.publish().map_err(Failure::run_failed)?;
    refresh_home(path)?;
    Ok(result)
}

/// Whether the home page above a report may be written, before anything is run.
fn home_is_free(report: &Path) -> Result<(), Failure> {
    site::is_free(&site::home(report)).map_err(|e| Failure::BadInput(format!("--out: {e}")))
}

/// Lists a report that was written into a folder on the home page. A page of someone else in its place stays as it is.
fn refresh_home(report: &Path) -> Result<(), Failure> {
    let home = site::home(report);
    if !report.join(site::RECORD).is_file() || site::is_free(&home).is_err() {
        return Ok(());
    }
    site::refresh(&home).map_err(Failure::run_failed).map(drop)
}

/// Makes a folder inside one that is taken.
fn inside(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|e| Failure::RunFailed(format!("{}: {e}", folder.display())))
}

/// Under `nohup` a hang-up ends no run: it is held back from all threads, if this is called before there are others. Only Linux
/// tells what a program was started with.
pub fn hold_back_hang_up() {
    #[cfg(unix)]
    {
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let ignored =
            status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
        if ignored.is_some_and(|mask| mask & 1 == 1) {
            // If that fails the run ends as if Ctrl-C were pressed, and can be taken up again.
            let _ = nix::sys::signal::SigSet::from(nix::sys::signal::Signal::SIGHUP).thread_block();
        }
    }
}

/// Set by the first Ctrl-C, request to terminate or hang-up; a second one ends at once.
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

/// Integrators that may be quicker than an explicit one, in the order of how much of its model they keep.
const QUICKER: [&str; 4] = ["semi-implicit", "two-clocks", "coupled", "quasi-static"];

/// Says of runs, some of them at once, that will take more than an hour that they do, and `flag` with which integrator they would
/// not. `other` are the same runs with another integrator, if it fits them.
fn warn_if_long(
    common: &Common,
    (name, flag, at_once): (&str, &str, usize),
    scenes: &[Scene],
    hardware: &Hardware,
    other: &dyn Fn(&str) -> Option<Vec<Scene>>,
) {
    if common.quiet {
        return;
    }
    let all = |scenes: &[Scene]| scenes.iter().filter_map(|scene| estimate(scene, hardware)).collect::<Vec<_>>();
    let wall = |estimates: &[Estimate]| estimates.iter().map(|e| e.wall_s).sum::<f64>() / at_once.max(1) as f64;
    let own = all(scenes);
    let Some(longest) = own.iter().max_by(|a, b| a.steps.total_cmp(&b.steps)).filter(|_| wall(&own) > LONG) else {
        return;
    };
    let what = format!(
        "{name}: this will take about {}: up to {:.1e} steps of {:.1e} s, timed here at {:.1e} s each",
        time(wall(&own)),
        longest.steps,
        longest.step_s,
        longest.wall_s / longest.steps
    );
    let quicker = QUICKER.iter().find_map(|word| {
        let estimates = all(&other(word)?);
        let wall = wall(&estimates);
        (wall <= LONG).then(|| match estimates.is_empty() {
            true => format!("; {flag} {word} would take less than an hour"),
            false => format!("; {flag} {word} would take about {}", time(wall)),
        })
    });
    eprintln!("{what}{}", quicker.unwrap_or_else(|| "; no other integrator is quicker for it".to_owned()));
}

/// What a flag stands in for, with its words.
fn words<T>(key: &str, words: &[(&str, T)]) -> String {
    let names: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
    let (last, others) = names.split_last().map_or(("", &[][..]), |(last, others)| (*last, others));
    format!("In place of the scene's {key}: {} or {last}", others.join(", "))
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
    let text = serde_json::to_string_pretty(value).map_err(Failure::run_failed)?;
    fs::write(path, text + "\n").map_err(|e| Failure::RunFailed(format!("{}: {e}", path.display())))
}

/// Why standard output did not take all that was printed.
static LOST: OnceLock<std::io::Error> = OnceLock::new();

/// Prints a line unless quiet.
fn say(quiet: bool, line: &str) {
    if quiet {
        return;
    }
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{line}").and_then(|()| out.flush()) {
        // Who reads no further wants no more.
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => drop(LOST.set(e)),
        _ => {}
    }
}

/// Prints a value as JSON on standard output.
fn print_json<T: Serialize>(value: &T) {
    match serde_json::to_string_pretty(value) {
        Ok(text) => say(false, &text),
        Err(e) => drop(LOST.set(e.into())),
    }
}

/// Whether all that was printed has arrived.
pub fn all_printed() -> Result<(), Failure> {
    LOST.get().map_or(Ok(()), |e| Err(Failure::RunFailed(format!("standard output: {e}"))))
}

/// Threads to use.
fn jobs(asked: u16) -> usize {
    if asked > 0 { asked.into() } else { std::thread::available_parallelism().map_or(1, usize::from) }
}

/// Parses a time.
fn seconds(text: &str) -> Result<f64, Error> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err(Unfit("expected 0 to 1e6 s")),
    }
}

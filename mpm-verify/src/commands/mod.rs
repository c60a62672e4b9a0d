//! One command per file, and what commands have in common: failures, folders, scenes, JSON.

pub mod cases;
pub mod check;
pub mod gallery;
pub mod gate;
pub mod help;
pub mod leaderboard;
pub mod levee;
pub mod list;
pub mod merge;
pub mod metamorphic;
pub mod mutants;
pub mod nightly;
pub mod prove;
pub mod publish;
mod quantities;
pub mod report;
pub mod score;
pub mod slope;
pub mod solve;
pub mod stability;
pub mod study;
pub mod terminal;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::builder::{PossibleValue, PossibleValuesParser};
use mpm_core::hardware::Hardware;
use mpm_core::scene::{Flags, Scene};
use mpm_verify::book;
use mpm_verify::error::Error::{self, Unfit};
use mpm_verify::files::{Folder, FolderError};
use mpm_verify::page::site;
use mpm_verify::progress::time;
use mpm_verify::provenance;
use mpm_verify::run_time::{Estimate, LONG, estimate};
use serde::Serialize;

use crate::Common;

/// Why a command did not succeed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A check failed: exit code 1.
    #[error("{0}")]
    CheckFailed(String),
    /// Bad input or usage, nothing was run: exit code 2.
    #[error("{0}")]
    BadInput(String),
    /// A run failed or was stopped, and what was computed is kept: exit code 3.
    #[error("{0}")]
    RunFailed(String),
}

impl Failure {
    fn bad_input<E: ToString>(error: E) -> Self {
        Self::BadInput(error.to_string())
    }

    fn run_failed(error: impl ToString) -> Self {
        Self::RunFailed(error.to_string())
    }

    /// A file or folder that cannot be written.
    fn unwritable<E: ToString>(path: &Path) -> impl Fn(E) -> Self {
        move |e| Self::RunFailed(format!("{}: {}", path.display(), e.to_string()))
    }

    /// Exit code of the program.
    pub fn code(&self) -> u8 {
        match self {
            Self::CheckFailed(_) => 1,
            Self::BadInput(_) => 2,
            Self::RunFailed(_) => 3,
        }
    }
}

impl Common {
    /// Folder for the results: that of `--out`, or one below `reports`.
    fn folder(&self, name: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| Path::new("reports").join(name))
    }

    /// Number of threads.
    fn jobs(&self) -> usize {
        match self.jobs {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            jobs => jobs.into(),
        }
    }

    /// Whether nothing is printed beside errors and JSON.
    fn silent(&self) -> bool {
        self.quiet || self.json
    }

    /// Prints a line with its verdict in colour.
    fn say(&self, line: &str) {
        if !self.silent() {
            terminal::say(&terminal::coloured(line));
        }
    }

    /// Prints the result as JSON if that is asked for.
    fn json<T: Serialize>(&self, result: &T) {
        if self.json {
            terminal::print_json(result);
        }
    }

    /// The last line of a command: the page that it wrote.
    fn page(&self, page: &Path) {
        self.say(&format!("page: {}", page.display()));
    }

    /// Loads a scene, a file or the name of a built-in one, and prints its notices.
    fn load(&self, source: &str, flags: &Flags) -> Result<Scene, Failure> {
        let scene = mpm_verify::scenes::load(source, flags).map_err(Failure::bad_input)?;
        self.notices(&scene, flags);
        Ok(scene)
    }

    /// Prints the notices of a scene to standard error: the only place where they are printed.
    fn notices(&self, scene: &Scene, flags: &Flags) {
        if !self.quiet {
            scene.warnings().iter().for_each(|warning| eprintln!("{warning}"));
        }
        if let (Some(integrator), false, false) = (&flags.integrator, scene.left_out.is_empty(), self.quiet) {
            eprintln!("--integrator {integrator}: left out {}", scene.left_out.join(", "));
        }
    }

    /// Takes the folder for the results, lets `work` write into its stage, and publishes what was written if it succeeds. Results
    /// of the given `names` must have room there, which is checked before anything is run.
    fn publish<T>(
        &self,
        name: &str,
        names: &[&str],
        work: impl FnOnce(&Folder) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let refused = |e: FolderError| Failure::BadInput(format!("--out: {e}"));
        let folder = Folder::take(&self.folder(name)).map_err(refused)?;
        folder.has_room_for(names).map_err(refused)?;
        // Which commit the program is: asked now, because the sources may change while it runs.
        provenance::commit();
        let result = work(&folder)?;
        folder.publish().map_err(Failure::run_failed)?;
        refresh_home(folder.path())?;
        Ok(result)
    }
}

/// Checks before anything is run whether the home page above a report may be written.
fn home_is_free(report: &Path) -> Result<(), Failure> {
    site::is_free(&site::home(report)).map_err(|e| Failure::BadInput(format!("--out: {e}")))
}

/// Lists a report on the home page, and writes the guide beside it. A page in its place that this program did not write stays as it is.
fn refresh_home(report: &Path) -> Result<(), Failure> {
    let home = site::home(report);
    if !report.join(site::RECORD).is_file() || site::is_free(&home).is_err() {
        return Ok(());
    }
    if home.file_name().is_some_and(|name| name == "reports") {
        book::write(&home).map_err(Failure::run_failed)?;
    }
    site::refresh(&home).map_err(Failure::run_failed).map(drop)
}

/// Makes a folder.
fn make_folder(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(Failure::unwritable(folder))
}

/// Writes a file.
fn write_file(path: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
    fs::write(path, content).map_err(Failure::unwritable(path))
}

/// A run under `nohup` ignores a hang-up: the signal is blocked for all threads that start after this call. Only Linux tells which
/// signals a program was started to ignore.
pub fn ignore_hang_up_under_nohup() {
    #[cfg(unix)]
    {
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let ignored =
            status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
        if ignored.is_some_and(|mask| mask & 1 == 1) {
            // If that fails the run ends as after Ctrl-C, and can be resumed.
            let _ = nix::sys::signal::SigSet::from(nix::sys::signal::Signal::SIGHUP).thread_block();
        }
    }
}

/// Set by the first Ctrl-C, request to terminate or hang-up; a second one ends the program at once.
fn interrupts() -> Arc<AtomicBool> {
    let stopped = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stopped);
    let set = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(3);
        }
        eprintln!("stopping after the current step; press Ctrl-C again to stop at once");
    });
    // Without a handler Ctrl-C ends the program as usual; the last checkpoint remains.
    drop(set);
    stopped
}

/// Integrators that may be faster than the explicit one, those that change the model least first.
const FASTER: [&str; 4] = ["semi-implicit", "staggered", "coupled", "quasi-static"];

/// Announces runs, `at_once` of them in parallel, that will take more than an hour, and the value of `flag` that avoids it. `other` are
/// the same runs with another integrator, if the scene allows it.
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
        "{name}: this will take about {}: up to {:.1e} steps of {:.1e} s, measured here at {:.1e} s each",
        time(wall(&own)),
        longest.steps,
        longest.step_s,
        longest.wall_s / longest.steps
    );
    let faster = FASTER.iter().find_map(|word| {
        let estimates = all(&other(word)?);
        let wall = wall(&estimates);
        (wall <= LONG).then(|| match estimates.is_empty() {
            true => format!("; {flag} {word} would take less than an hour"),
            false => format!("; {flag} {word} would take about {}", time(wall)),
        })
    });
    eprintln!("{what}{}", faster.unwrap_or_else(|| "; no other integrator is faster".to_owned()));
}

/// Words of an option, of which the nearest is offered in place of a misspelt one.
fn words<T>(words: &[(&'static str, T)]) -> PossibleValuesParser {
    let value = |word: &'static str| match word {
        // The old word is read for one version; the scene reader prints a notice.
        "staggered" => PossibleValue::new(word).alias("two-clocks"),
        word => PossibleValue::new(word),
    };
    PossibleValuesParser::new(words.iter().map(|(word, _)| value(word)))
}

/// Names that a user has chosen, or all; a name that does not exist is refused with the nearest ones.
fn chosen<'a, T>(
    (what, kind): (&'static str, &'static str),
    names: &[String],
    all: &'a [T],
    name: impl Fn(&T) -> &str + Copy,
) -> Result<Vec<&'a T>, Failure> {
    if let Some(wrong) = names.iter().find(|wrong| all.iter().all(|one| name(one) != wrong.as_str())) {
        return Err(Failure::bad_input(Error::unknown((what, kind), wrong, all.iter().map(name))));
    }
    Ok(all.iter().filter(|one| names.is_empty() || names.iter().any(|asked| asked == name(one))).collect())
}

/// The command as it was given, with one more flag.
fn again_with(flag: &str) -> String {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != flag).collect();
    format!("mpm-verify {} {flag}", arguments.join(" "))
}

/// Writes rows as CSV with a header.
fn write_csv<T: Serialize>(path: &Path, rows: &[T]) -> Result<(), Failure> {
    let mut writer = csv::Writer::from_path(path).map_err(Failure::unwritable(path))?;
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(Failure::unwritable(path))?;
    writer.flush().map_err(Failure::unwritable(path))
}

/// Writes a value as JSON.
fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), Failure> {
    write_file(path, serde_json::to_string_pretty(value).map_err(Failure::run_failed)? + "\n")
}

/// Parses a time, s.
fn seconds(text: &str) -> Result<f64, Error> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err(Unfit("expected a time from 0 to 1e6 s")),
    }
}

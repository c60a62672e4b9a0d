//! `prove`: what has to hold before a change lands, in one command.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use clap::Args;
use mpm_verify::files::{Folder, FolderError};
use mpm_verify::manifest::Manifest;
use mpm_verify::progress::time;
use serde::{Deserialize, Serialize};

use super::{Failure, write_csv, write_json};
use crate::Common;

/// One part of the proof.
struct Part {
    name: &'static str,
    by: By,
    arguments: &'static [&'static str],
}

/// What runs a part of the proof.
#[derive(Clone, Copy, PartialEq)]
enum By {
    Cargo,
    This,
    /// Cargo in a new clone of the commit, where nothing is built.
    Clone,
}

/// The part that fails where there is no browser; among the other tests that one says that it is skipped.
const BROWSER: &str = "browser";
/// All parts, those that fail soonest first.
const PARTS: [Part; 12] = [
    Part { name: "format", by: By::Cargo, arguments: &["fmt", "--all", "--check"] },
    Part {
        name: "lints",
        by: By::Cargo,
        arguments: &["clippy", "--locked", "--workspace", "--all-targets", "--", "-D", "warnings"],
    },
    Part { name: "suite", by: By::This, arguments: &["check", "--quick"] },
    Part { name: "study", by: By::This, arguments: &["study"] },
    Part { name: "levee", by: By::This, arguments: &["levee"] },
    Part { name: "tests", by: By::Cargo, arguments: &["test", "--locked", "--workspace"] },
    Part { name: "documentation", by: By::Cargo, arguments: &["doc", "--locked", "--workspace", "--no-deps"] },
    Part {
        name: BROWSER,
        by: By::Cargo,
        arguments: &["test", "--locked", "--workspace", "--test", "all", "--", "pages::"],
    },
    Part { name: "nightly", by: By::This, arguments: &["nightly"] },
    Part { name: "mutants", by: By::This, arguments: &["mutants"] },
    Part { name: "clone-study", by: By::Clone, arguments: &["run", "--release"] },
    Part { name: "clone-tests", by: By::Clone, arguments: &["test", "--workspace"] },
];
/// How many of them are run where none is named.
const DAILY: usize = 7;

/// Text of the help, from the list of the parts.
pub fn about() -> String {
    format!("What has to hold before a change lands: {}", names(&PARTS[..DAILY]))
}

fn names(parts: &[Part]) -> String {
    parts.iter().map(|part| part.name).collect::<Vec<_>>().join(", ")
}

/// Name of the file with the output of a part.
fn log_of(part: &str) -> String {
    format!("{part}.txt")
}

/// Lines of a failed part that are shown at once: its log is there when all parts have run.
const LAST_WORDS: usize = 20;

/// Which parts.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Parts to run; without a name all but those of --all
    #[arg(value_name = "PART", value_parser = clap::builder::PossibleValuesParser::new(PARTS.map(|part| part.name)))]
    parts: Vec<String>,
    /// Also the parts that are not run every time
    #[arg(long, conflicts_with = "parts", help = format!("Also {}", names(&PARTS[DAILY..])))]
    all: bool,
}

/// A row of `prove.csv`.
#[derive(Debug, Serialize, Deserialize)]
struct Row {
    part: String,
    command: String,
    wall_s: f64,
    passed: bool,
}

impl Part {
    /// Runs the part from the root of the source, with all that it says in a file.
    fn run(&self, folder: &Path) -> Result<Row, Failure> {
        let log = folder.join(log_of(self.name));
        let file = File::create(&log).map_err(Failure::unwritable(&log))?;
        let errors = file.try_clone().map_err(Failure::unwritable(&log))?;
        let mut command = match self.by {
            By::This => Command::new(std::env::current_exe().map_err(Failure::run_failed)?),
            By::Cargo | By::Clone => Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())),
        };
        // Apart from the reports: pages find their home by the names of folders.
        let clone = Path::new("target").join(self.name);
        if self.by == By::Clone {
            let _ = std::fs::remove_dir_all(&clone);
            let cloned = Command::new("git").args(["clone", "--quiet", "."]).arg(&clone).status();
            if !cloned.is_ok_and(|status| status.success()) {
                return Err(Failure::run_failed(format!("git clone . {} failed", clone.display())));
            }
            command.current_dir(&clone).env_remove("CARGO_TARGET_DIR");
        }
        let clock = Instant::now();
        let status = command
            .args(self.arguments)
            .args(if self.by == By::This { &["--quiet"][..] } else { &[] })
            .env("RUSTDOCFLAGS", "-D warnings")
            .env("MPM_BROWSER_TEST", if self.name == BROWSER { "required" } else { "" })
            .stdin(Stdio::null())
            .stdout(file)
            .stderr(errors)
            .status()
            .map_err(Failure::run_failed)?;
        let wall_s = (clock.elapsed().as_secs_f64() * 10.0).round() / 10.0;
        if self.by == By::Clone {
            std::fs::remove_dir_all(&clone).map_err(Failure::unwritable(&clone))?;
        }
        let program = if self.by == By::This { "mpm-verify" } else { "cargo" };
        let command = format!("{program} {}", self.arguments.join(" "));
        Ok(Row { part: self.name.to_owned(), command, wall_s, passed: status.success() })
    }

    /// The last lines of the part's log in a folder.
    fn last_words(&self, folder: &Path) -> String {
        let said = std::fs::read_to_string(folder.join(log_of(self.name))).unwrap_or_default();
        let lines: Vec<_> = said.lines().collect();
        lines[lines.len().saturating_sub(LAST_WORDS)..].join("\n")
    }
}

/// What an earlier proof of the same sources found.
fn earlier(folder: &Path, sources: &str) -> Vec<Row> {
    let manifest = std::fs::read_to_string(folder.join("manifest.json")).ok();
    let manifest: Option<Manifest> = manifest.and_then(|text| serde_json::from_str(&text).ok());
    let rows = csv::Reader::from_path(folder.join("prove.csv"))
        .ok()
        .filter(|_| manifest.is_some_and(|m| m.sources == sources));
    rows.into_iter().flat_map(csv::Reader::into_deserialize).filter_map(Result::ok).collect()
}

/// Runs all parts, whatever becomes of the others. The row of a part in `prove.csv` and its output are written when the part ends, so
/// that a proof that is stopped keeps them.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    if !Path::new("mpm-core/Cargo.toml").is_file() {
        return Err(Failure::BadInput("prove: expected to be run in the root of the source".to_owned()));
    }
    let manifest = Manifest::new(&mpm_verify::scenes::terzaghi(), common.jobs());
    let refused = |e: FolderError| Failure::BadInput(format!("--out: {e}"));
    let folder = Folder::take(&common.folder("prove")).map_err(refused)?;
    folder.has_room_for(&["prove.csv", "manifest.json"]).map_err(refused)?;
    let mut rows = earlier(folder.path(), &manifest.sources);
    for (number, part) in PARTS.iter().enumerate() {
        let is_named = options.parts.iter().any(|name| name == part.name);
        if !is_named && !options.all && (!options.parts.is_empty() || number >= DAILY) {
            continue;
        }
        let row = part.run(folder.stage())?;
        let verdict = if row.passed { "passed" } else { "failed" };
        common.say(&format!("{:<14} {:>8}  {verdict}: {}", row.part, time(row.wall_s), row.command));
        if !row.passed {
            common.say(&part.last_words(folder.stage()));
        }
        rows.retain(|earlier| earlier.part != row.part);
        rows.push(row);
        rows.sort_by_key(|row| PARTS.iter().position(|part| part.name == row.part));
        write_csv(&folder.stage().join("prove.csv"), &rows)?;
        write_json(&folder.stage().join("manifest.json"), &manifest)?;
        let stays = |file: &Path| rows.iter().any(|row| file == Path::new(&log_of(&row.part)));
        folder.publish_beside("proof", &stays).map_err(Failure::run_failed)?;
    }
    common.json(&rows);
    for part in PARTS.iter().filter(|part| rows.iter().all(|row| row.part != part.name)) {
        common.say(&format!("not run: {} (prove {0})", part.name));
    }
    let failed: Vec<&str> = rows.iter().filter(|row| !row.passed).map(|row| row.part.as_str()).collect();
    match failed[..] {
        [] => Ok(()),
        _ => Err(Failure::CheckFailed(format!(
            "failed: {} (what they said: {}/PART.txt)",
            failed.join(", "),
            common.folder("prove").display()
        ))),
    }
}

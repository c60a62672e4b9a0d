//! `prove`: what has to hold before a change lands, in one command.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use clap::Args;
use mpm_verify::manifest::Manifest;
use mpm_verify::progress::time;
use serde::Serialize;

use super::{Failure, write_csv, write_json};
use crate::Common;

/// One part of the proof: a command of cargo, or one of this program.
struct Part {
    name: &'static str,
    arguments: &'static [&'static str],
    by: By,
}

enum By {
    Cargo,
    This,
}

/// All parts, those that fail soonest first.
const PARTS: [Part; 7] = [
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
];

/// What the parts leave out, and who runs it.
const LEFT: [&str; 2] = [
    "nightly: the whole verification suite, stability, random scenes, counts of work, all accepted numbers",
    "weekly: planted faults, random inputs, other processors",
];

/// Which parts.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Parts to run; all without a name
    #[arg(value_name = "PART", value_parser = clap::builder::PossibleValuesParser::new(PARTS.map(|part| part.name)))]
    parts: Vec<String>,
}

/// A row of `prove.csv`.
#[derive(Debug, Serialize)]
struct Row {
    part: &'static str,
    command: String,
    wall_s: f64,
    passed: bool,
}

impl Part {
    /// Runs it from the root of the source, with all that it says in a file.
    fn run(&self, folder: &Path) -> Result<Row, Failure> {
        let log = folder.join(format!("{}.txt", self.name));
        let file = File::create(&log).map_err(Failure::unwritable(&log))?;
        let errors = file.try_clone().map_err(Failure::unwritable(&log))?;
        let mut command = match self.by {
            By::Cargo => Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())),
            By::This => Command::new(std::env::current_exe().map_err(Failure::run_failed)?),
        };
        if let By::This = self.by {
            command.arg("--quiet").arg("--out").arg(folder.join(self.name));
        }
        let clock = Instant::now();
        let status = command
            .args(self.arguments)
            .env("RUSTDOCFLAGS", "-D warnings")
            .stdin(Stdio::null())
            .stdout(file)
            .stderr(errors)
            .status()
            .map_err(Failure::run_failed)?;
        let program = if let By::Cargo = self.by { "cargo" } else { "mpm-verify" };
        let command = format!("{program} {}", self.arguments.join(" "));
        let wall_s = (clock.elapsed().as_secs_f64() * 10.0).round() / 10.0;
        Ok(Row { part: self.name, command, wall_s, passed: status.success() })
    }
}

/// Runs all parts, whatever becomes of the others, and writes `prove.csv` and what each has said.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    if !Path::new("mpm-core/Cargo.toml").is_file() {
        return Err(Failure::BadInput("prove: expected to be run in the root of the source".to_owned()));
    }
    let rows = common.publish("prove", &["prove.csv", "manifest.json"], |folder| {
        let mut rows = Vec::new();
        for part in &PARTS {
            if options.parts.is_empty() || options.parts.iter().any(|name| name == part.name) {
                let row = part.run(folder.stage())?;
                let verdict = if row.passed { "passed" } else { "failed" };
                common.say(&format!("{:<14} {:>8}  {verdict}: {}", row.part, time(row.wall_s), row.command));
                rows.push(row);
            }
        }
        write_csv(&folder.stage().join("prove.csv"), &rows)?;
        let manifest = Manifest::new(&mpm_verify::scenes::terzaghi(), common.jobs());
        write_json(&folder.stage().join("manifest.json"), &manifest)?;
        Ok(rows)
    })?;
    common.json(&rows);
    common.say(&format!("in all {}", time(rows.iter().map(|row| row.wall_s).sum())));
    LEFT.iter().for_each(|left| common.say(&format!("left to {left}")));
    let failed: Vec<&str> = rows.iter().filter(|row| !row.passed).map(|row| row.part).collect();
    match failed[..] {
        [] => Ok(()),
        _ => Err(Failure::CheckFailed(format!(
            "failed: {} (what they said: {}/PART.txt)",
            failed.join(", "),
            common.folder("prove").display()
        ))),
    }
}

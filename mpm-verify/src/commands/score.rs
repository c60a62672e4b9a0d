//! `score`: how good the answers of other codes to neutral cases are.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use mpm_verify::manifest::Manifest;
use mpm_verify::protocol::board::{file_name, write_code};
use mpm_verify::protocol::case::{Case, chosen};
use mpm_verify::protocol::code::{Code, SCORES, lying, running};
use mpm_verify::protocol::command::Limits;
use mpm_verify::protocol::score::{Score, Verdict};

use super::{Failure, interrupts, make_folder, write_json};
use crate::Common;

/// What to score.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Folders of results, each with a folder for every case that was answered
    #[arg(value_name = "DIR", required_unless_present = "run", conflicts_with = "run")]
    folders: Vec<PathBuf>,
    /// Run this shell command for each case: {case}, {out} and {refinement} are replaced
    #[arg(long, value_name = "COMMAND")]
    run: Option<String>,
    /// Name of the code; that of the folder where there is none
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Some cases, by name, in place of all
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    only: Vec<String>,
    /// Hidden parameters are those that `cases export --seed` has drawn
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Longest time of a command, s
    #[arg(long, value_name = "S", default_value_t = 600.0)]
    time_limit: f64,
    /// Most memory of a command and all that it starts, MiB
    #[arg(long, value_name = "MIB", default_value_t = 8192.0)]
    memory_limit: f64,
    /// Most that a command may write, MiB
    #[arg(long, value_name = "MIB", default_value_t = 1024.0)]
    output_limit: f64,
}

/// Scores all codes.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let cases = chosen(&options.only, options.seed).map_err(Failure::bad_input)?;
    let positive = [options.time_limit, options.memory_limit, options.output_limit];
    if positive.iter().any(|limit| !(*limit > 0.0 && *limit < 1e9)) {
        return Err(Failure::BadInput(format!("limits: expected numbers above 0 and below 1e9, found {positive:?}")));
    }
    if let Some(missing) = options.folders.iter().find(|folder| !folder.is_dir()) {
        return Err(Failure::BadInput(format!("{}: expected a folder of results, found none", missing.display())));
    }
    // Each of several codes has a folder of its own.
    let several = options.folders.len() > 1;
    if several && options.name.is_some() {
        return Err(Failure::BadInput("--name: expected one folder of results, found several".to_owned()));
    }
    let stopped = interrupts();
    let mut codes = Vec::new();
    if let Some(template) = &options.run {
        if !template.contains("{case}") || !template.contains("{out}") {
            return Err(Failure::BadInput(format!("--run: expected {{case}} and {{out}} in it, found `{template}`")));
        }
        let name = options.name.clone().unwrap_or_else(|| "code".to_owned());
        codes.push(scored(&name, options, common, &cases, Answers::Of(template, &stopped))?);
    }
    for folder in &options.folders {
        let own =
            std::path::absolute(folder).ok().and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
        let name = options.name.clone().or(own).unwrap_or_else(|| "code".to_owned());
        let own = common.out.as_ref().filter(|_| several).map(|out| out.join(file_name(&name)));
        let common = Common { out: own.or_else(|| common.out.clone()), ..common.clone() };
        codes.push(scored(&name, options, &common, &cases, Answers::In(folder))?);
    }
    if stopped.load(Ordering::Relaxed) {
        return Err(Failure::RunFailed("stopped: what was scored until then is kept".to_owned()));
    }
    common.json(&codes);
    let wrong: Vec<String> = codes
        .iter()
        .filter(|code| code.count(Verdict::Wrong) > 0)
        .map(|code| format!("{}: {}", code.name, code.sentence()))
        .collect();
    let idle = codes.iter().find(|code| code.count(Verdict::NotRun) == code.scores.len());
    match (wrong.is_empty(), idle) {
        (true, None) => Ok(()),
        (true, Some(code)) => Err(Failure::CheckFailed(format!("{}: no case was answered", code.name))),
        (false, _) => Err(Failure::CheckFailed(wrong.join("; "))),
    }
}

/// Where the answers of a code are.
#[derive(Clone, Copy)]
enum Answers<'a> {
    /// In a folder.
    In(&'a Path),
    /// Those of a command, until it is to stop.
    Of(&'a str, &'a AtomicBool),
}

/// Scores one code into a folder of its own.
fn scored(
    name: &str,
    options: &Options,
    common: &Common,
    cases: &[Case],
    answers: Answers<'_>,
) -> Result<Code, Failure> {
    let place = format!("scores/{}", file_name(name));
    let told = |score: &Score| {
        common.say(&format!("{:<28} {:<22} {}", score.case, score.verdict.word(), score.reason));
        score
            .flags
            .iter()
            .chain(score.faults.iter().filter(|fault| !score.reason.contains(*fault)))
            .for_each(|more| common.say(&format!("{:<28} {more}", "")));
    };
    let code = common.publish(&place, &["index.html", SCORES], |folder| {
        let mut code = match answers {
            Answers::Of(template, stopped) => {
                let limits = Limits {
                    time: Duration::from_secs_f64(options.time_limit),
                    memory_mib: options.memory_limit,
                    output_mib: options.output_limit,
                };
                let stop = || stopped.load(Ordering::Relaxed);
                let work = std::path::absolute(folder.stage()).map_err(Failure::run_failed)?;
                make_folder(&work)?;
                running((template, &limits), name, cases, &work, &stop, &told).map_err(Failure::run_failed)?
            }
            Answers::In(folder) => lying(folder, name, cases, &told),
        };
        if let Some(scene) = cases.iter().find_map(Case::scene) {
            code.date = Manifest::new(scene, 1).date;
        }
        write_json(&folder.stage().join(SCORES), &code)?;
        write_code(&code, cases, folder.stage()).map_err(Failure::run_failed)?;
        Ok(code)
    })?;
    common.say(&format!("{name}: {}", code.sentence()));
    common.page(&common.folder(&place).join("index.html"));
    Ok(code)
}

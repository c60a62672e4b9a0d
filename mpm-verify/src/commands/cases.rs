//! `cases`: neutral cases for other codes, and the answers of this one.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use mpm_verify::protocol::{answer, case, export};

use super::{Failure, make_folder};
use crate::Common;

/// What to do with neutral cases.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// export: write each case as case.json and a page, without its answer. answer: answer one
    #[arg(value_enum)]
    action: Action,
    /// export: folder for the cases. answer: case.json of a case, and folder for the answer
    #[arg(value_name = "PATH", required = true, num_args = 1..=2)]
    paths: Vec<PathBuf>,
    /// export: some cases, by name, in place of all
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    only: Vec<String>,
    /// export: draw hidden parameters from this number; 0 keeps the published ones
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// answer: one refinement, in place of all
    #[arg(long, value_name = "N")]
    refinement: Option<f64>,
}

// Without docs: help would be two screens long.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Action {
    Export,
    Answer,
}

/// Writes cases or an answer.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let refused = |expected: &str| {
        let found: Vec<String> = options.paths.iter().map(|path| path.display().to_string()).collect();
        Err(Failure::BadInput(format!("cases: expected {expected}, found {}", found.join(" "))))
    };
    match (options.action, &options.paths[..]) {
        (Action::Export, [folder]) => {
            let cases = case::chosen(&options.only, options.seed).map_err(Failure::bad_input)?;
            make_folder(folder)?;
            export::write(&cases, folder).map_err(Failure::run_failed)?;
            common.json(&cases.iter().map(|case| &case.name).collect::<Vec<_>>());
            common.say(&format!("{} cases", cases.len()));
            common.page(&folder.join("index.html"));
            Ok(())
        }
        (Action::Answer, [case, folder]) => {
            let question = answer::Question::read(case).map_err(Failure::bad_input)?;
            make_folder(folder)?;
            question.answer(folder, options.refinement).map_err(Failure::run_failed)?;
            common.say(&format!("{}: {}", question.name(), folder.join("results.csv").display()));
            Ok(())
        }
        (Action::Export, _) => refused("one folder"),
        (Action::Answer, _) => refused("a case.json and a folder"),
    }
}

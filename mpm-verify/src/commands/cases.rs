//! `cases`: neutral cases for other codes, and the answers of this one.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use mpm_verify::protocol::{answer, case, export};

use super::{Failure, make_folder};
use crate::Common;

/// What to do with neutral cases.
#[derive(Debug, Clone, Args)]
pub struct Options {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Clone, Subcommand)]
enum Action {
    /// Write each case as case.json and a page, without its answer
    Export {
        /// Folder for the cases
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Some cases, by name, in place of all
        #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
        only: Vec<String>,
        /// Draw hidden parameters from this number; 0 keeps the published ones
        #[arg(long, value_name = "N", default_value_t = 0)]
        seed: u64,
    },
    /// Answer a case with this program, as any other code would
    Answer {
        /// The case.json of the case
        #[arg(value_name = "CASE.json")]
        case: PathBuf,
        /// Folder for results.csv and run.json
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// One refinement, in place of all
        #[arg(long, value_name = "N")]
        refinement: Option<f64>,
    },
}

/// Writes cases or an answer.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    match &options.action {
        Action::Export { folder, only, seed } => {
            let cases = case::chosen(only, *seed).map_err(Failure::bad_input)?;
            make_folder(folder)?;
            export::write(&cases, folder).map_err(Failure::run_failed)?;
            common.json(&cases.iter().map(|case| &case.name).collect::<Vec<_>>());
            common.say(&format!("{} cases", cases.len()));
            common.page(&folder.join("index.html"));
        }
        Action::Answer { case, folder, refinement } => {
            let question = answer::Question::read(case).map_err(Failure::bad_input)?;
            make_folder(folder)?;
            question.answer(folder, *refinement).map_err(Failure::run_failed)?;
            common.say(&format!("{}: {}", question.name(), folder.join("results.csv").display()));
        }
    }
    Ok(())
}

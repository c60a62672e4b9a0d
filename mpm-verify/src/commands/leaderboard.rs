//! `leaderboard`: one page of the scores of several codes.

use std::path::PathBuf;

use clap::Args;
use mpm_verify::protocol::board::{BOARD, judge, merged, write};
use mpm_verify::protocol::case::chosen;
use mpm_verify::protocol::code::Code;
use mpm_verify::protocol::score::Verdict;

use super::Failure;
use crate::Common;

/// Which scores.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Folders or files of scores; scores of codes of one name are put together
    #[arg(value_name = "SCORES", required = true)]
    scores: Vec<PathBuf>,
}

/// Writes the leaderboard.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let read = options.scores.iter().map(|path| Code::read(path)).collect::<Result<_, _>>();
    let mut codes = merged(read.map_err(Failure::bad_input)?);
    let mut seeds: Vec<u64> = codes.iter().flat_map(|code| &code.scores).map(|score| score.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let &[seed] = &seeds[..] else {
        return Err(Failure::BadInput(format!("expected scores of one seed, found those of {seeds:?}")));
    };
    let cases = chosen(&[], seed).map_err(Failure::run_failed)?;
    judge(&mut codes, &cases);
    common.publish("leaderboard", &["index.html", BOARD], |folder| {
        write(&codes, &cases, folder.stage()).map_err(Failure::run_failed)
    })?;
    common.json(&codes);
    for code in &codes {
        common.say(&format!("{:<24} {}", code.name, code.sentence()));
    }
    let answered = codes.iter().filter(|code| code.count(Verdict::NotRun) < code.scores.len()).count();
    common.say(&format!("{answered} codes"));
    common.page(&common.folder("leaderboard").join("index.html"));
    Ok(())
}

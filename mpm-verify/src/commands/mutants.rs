//! `mutants`: known faults are planted in a copy of the source, and the checks must catch each.

use std::path::PathBuf;

use clap::Args;
use mpm_core::random::Random;
use mpm_verify::mutants::copy::plant;
use mpm_verify::mutants::detected::{Detected, FILE};
use mpm_verify::mutants::hunt::{Row, Spoilt, build};
use mpm_verify::mutants::patches::{Mutant, mutants};
use mpm_verify::study::Share;

use super::study::share;
use super::terminal::say;
use super::{Failure, chosen, make_folder, write_csv};
use crate::Common;

/// Which faults.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Faults to plant; all without a name
    #[arg(value_name = "FAULT")]
    mutants: Vec<String>,
    /// Only list the faults
    #[arg(long)]
    list: bool,
    /// Plant every N-th of them in a random order, from the I-th on
    #[arg(long, value_name = "I/N", value_parser = share)]
    share: Option<Share>,
    /// Seed of the random order
    #[arg(long, value_name = "N", default_value_t = 0, requires = "share")]
    seed: u64,
    /// Run every check on each fault, in place of the first that detects it: hours
    #[arg(long)]
    all: bool,
    /// Note in reference-data/baselines/detected.csv which checks detected them: later searches ask these first
    #[arg(long)]
    record: bool,
    /// Root of the source [default: .]
    #[arg(long, value_name = "DIR", default_value = ".", hide = true)]
    source: PathBuf,
    /// Folder where the copy is built [default: target/with-faults]
    #[arg(long, value_name = "DIR", default_value = "target/with-faults", hide = true)]
    scratch: PathBuf,
}

/// Plants the faults, runs the checks on each, and writes `mutants.csv`.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let all = mutants().map_err(Failure::bad_input)?;
    let numbered: Vec<(u32, &Mutant)> = (1..).zip(&all).collect();
    let mut chosen = chosen(("the name of a fault", "faults"), &options.mutants, &numbered, |(_, mutant)| mutant.name)?;
    if let Some(share) = options.share {
        let mut random = Random(options.seed);
        chosen.sort_by_cached_key(|_| random.bits());
        let mut number = 0..;
        chosen.retain(|_| number.next().is_some_and(|number| share.has(number)));
    }
    let chosen: Vec<(u32, &Mutant)> = chosen.into_iter().copied().collect();
    if options.list {
        chosen.iter().for_each(|(_, mutant)| say(&format!("{:<26} {}", mutant.name, mutant.what)));
        return Ok(());
    }
    if !options.source.join("mpm-core/Cargo.toml").is_file() {
        let found = options.source.display();
        return Err(Failure::BadInput(format!("--source: expected the root of the source, found {found}")));
    }
    let rows = common.publish("mutants", &["mutants.csv"], |folder| {
        make_folder(&options.scratch)?;
        let scratch = options.scratch.canonicalize().map_err(Failure::run_failed)?;
        let written = plant(&options.source, &scratch, &all).map_err(Failure::bad_input)?;
        common.say(&format!("{} faults in a copy ({written} files changed); building it ...", all.len()));
        let program = build(&scratch).map_err(Failure::run_failed)?;
        let mut known = Detected::read(&options.source).map_err(Failure::bad_input)?;
        let told = |row: &Row| {
            let verdict = if row.caught { "caught by" } else { "not caught" };
            common.say(&format!("{:<26} {verdict} {} ({:.0} s)", row.mutant, row.by, row.wall_s));
        };
        let spoilt = Spoilt::new(program, scratch, options.all);
        let rows = spoilt.find(&chosen, common.jobs(), &mut known, &told).map_err(Failure::run_failed)?;
        if options.record && Detected::write(&known, &options.source).map_err(Failure::run_failed)? {
            common.say(&format!("written: {}", options.source.join(FILE).display()));
        }
        write_csv(&folder.stage().join("mutants.csv"), &rows)?;
        Ok(rows)
    })?;
    common.json(&rows);
    let missed: Vec<&str> = rows.iter().filter(|row| !row.caught).map(|row| row.mutant.as_str()).collect();
    common.say(&format!("{} of {} faults caught", rows.len() - missed.len(), rows.len()));
    common.say(&format!("table: {}", common.folder("mutants").join("mutants.csv").display()));
    if missed.is_empty() { Ok(()) } else { Err(Failure::CheckFailed(format!("not caught: {}", missed.join(", ")))) }
}

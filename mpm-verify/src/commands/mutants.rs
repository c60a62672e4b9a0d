//! `mutants`: known faults are planted in a copy of the source, and the checks must find each.

use std::fs;
use std::path::PathBuf;

use clap::Args;
use mpm_verify::mutants::copy::plant;
use mpm_verify::mutants::hunt::{Row, Spoilt, build};
use mpm_verify::mutants::table::{MUTANTS, Mutant};

use super::{Failure, into_folder, jobs, print_json, say, write_csv};
use crate::Common;

/// Which faults.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Faults; all without a name
    mutants: Vec<String>,
    /// Root of the source
    #[arg(long, value_name = "DIR", default_value = ".")]
    source: PathBuf,
    /// Where the copy is built
    #[arg(long, value_name = "DIR", default_value = "target/with-faults")]
    scratch: PathBuf,
    /// Only list them
    #[arg(long)]
    list: bool,
}

/// Plants the faults, looks for each, and writes `mutants.csv`.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let chosen = chosen(&options.mutants)?;
    if options.list {
        for (_, mutant) in &chosen {
            say(false, &format!("{:<26} {}", mutant.name, mutant.what));
        }
        return Ok(());
    }
    if !options.source.join("mpm-core/Cargo.toml").is_file() {
        let found = options.source.display();
        return Err(Failure::BadInput(format!("--source: expected the root of the source, found {found}")));
    }
    let quiet = common.quiet || common.json;
    let path = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/mutants"));
    let rows = into_folder(&path, &["mutants.csv"], |folder| {
        fs::create_dir_all(&options.scratch)
            .map_err(|e| Failure::RunFailed(format!("{}: {e}", options.scratch.display())))?;
        let scratch = options.scratch.canonicalize().map_err(Failure::run_failed)?;
        let written = plant(&options.source, &scratch, MUTANTS).map_err(Failure::bad_input)?;
        say(quiet, &format!("{} faults in a copy, {written} files of it new; building it ...", MUTANTS.len()));
        let program = build(&scratch).map_err(Failure::run_failed)?;
        let spoilt =
            Spoilt::new(program, scratch, jobs(common.jobs), &|text| say(quiet, text)).map_err(Failure::run_failed)?;
        let mut rows: Vec<Row> = Vec::new();
        for (number, mutant) in &chosen {
            let row = spoilt.find(*number, mutant).map_err(Failure::run_failed)?;
            let word = if row.caught { "caught by" } else { "NOT CAUGHT" };
            say(quiet, &format!("{:<26} {word} {}", row.mutant, row.by));
            rows.push(row);
        }
        write_csv(&folder.stage().join("mutants.csv"), &rows)?;
        Ok(rows)
    })?;
    if common.json {
        print_json(&rows);
    }
    let missed: Vec<&str> = rows.iter().filter(|row| !row.caught).map(|row| row.mutant.as_str()).collect();
    say(
        quiet,
        &format!(
            "{} of {} faults caught: {}",
            rows.len() - missed.len(),
            rows.len(),
            path.join("mutants.csv").display()
        ),
    );
    if missed.is_empty() { Ok(()) } else { Err(Failure::CheckFailed(format!("not caught: {}", missed.join(", ")))) }
}

/// The named faults with their numbers, or all.
fn chosen(names: &[String]) -> Result<Vec<(u32, &'static Mutant)>, Failure> {
    if let Some(name) = names.iter().find(|name| MUTANTS.iter().all(|mutant| mutant.name != name.as_str())) {
        let known: Vec<&str> = MUTANTS.iter().map(|mutant| mutant.name).collect();
        return Err(Failure::BadInput(format!("mutants: expected one of {}, found {name}", known.join(", "))));
    }
    let wanted = |(_, mutant): &(u32, &Mutant)| names.is_empty() || names.iter().any(|name| name == mutant.name);
    Ok((1..).zip(MUTANTS).filter(wanted).collect())
}

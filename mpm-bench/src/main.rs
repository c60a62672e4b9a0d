//! The command line: `mpm-bench` sweeps the settings and writes the report.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use mpm_bench::cheapest;
use mpm_bench::kernel::kept::{copy, kept_or_measured};
use mpm_bench::peers::{Peer, peers};
use mpm_bench::plan::Plan;
use mpm_bench::report::Findings;
use mpm_bench::report::answers::answers;
use mpm_bench::store::Store;
use mpm_bench::sweep::{SweepError, build, sweep};
use mpm_core::scene::Scene;
use mpm_verify::files::Folder;
use mpm_verify::manifest::Manifest;
use mpm_verify::page::site;
use mpm_verify::progress::Progress;

/// Error against CPU time of every integrator and scheme, and the cheapest setting for a given error.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100, after_help = EXAMPLES)]
struct Cli {
    /// Fewer settings, each timed once: less than a minute
    #[arg(long)]
    quick: bool,
    /// Only settings whose name contains this: quasi-static-bspline2, L0.1-
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Measure everything again; otherwise an interrupted sweep is continued
    #[arg(long)]
    fresh: bool,
    /// Write the report of a finished sweep in this folder again, without a measurement
    #[arg(long, value_name = "DIR", conflicts_with_all = ["quick", "only", "fresh"])]
    from: Option<PathBuf>,
    /// Folder for the results
    #[arg(long, value_name = "DIR", default_value = "reports/speed-against-error", help_heading = "Output")]
    out: PathBuf,
    /// Print errors only
    #[arg(long, help_heading = "Output")]
    quiet: bool,
    /// Print the rows of cheapest.csv as JSON on standard output
    #[arg(long, help_heading = "Output")]
    json: bool,
}

const EXAMPLES: &str = "Examples:
  mpm-bench --quick                       a first picture
  mpm-bench --only quasi-static-bspline2  one integrator and scheme
  mpm-bench --from DIR --out DIR          the report of a finished sweep again";

/// Why a sweep did not succeed.
#[derive(Debug, thiserror::Error)]
enum Failure {
    /// Bad input or usage, nothing was run: exit code 2.
    #[error("{0}")]
    BadInput(String),
    /// A run failed, and what was computed is kept: exit code 3.
    #[error("{0}")]
    RunFailed(String),
}

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            ExitCode::from(match failure {
                Failure::BadInput(_) => 2,
                Failure::RunFailed(_) => 3,
            })
        }
    }
}

fn run(cli: &Cli) -> Result<(), Failure> {
    let base = mpm_verify::scenes::terzaghi();
    let mut plan = Plan::new(&base, cli.quick).map_err(|e| Failure::BadInput(e.to_string()))?;
    if let Some(text) = &cli.only {
        plan.only(text).map_err(|e| Failure::BadInput(e.to_string()))?;
    }
    let peers = peers().map_err(|e| Failure::BadInput(format!("peers/terzaghi.csv: {e}")))?;
    let read = |from: &PathBuf| Findings::read(from, peers.clone(), plan.left_out.clone());
    let stored = cli.from.as_ref().map(read).transpose().map_err(|e| Failure::BadInput(format!("--from: {e}")))?;
    let folder = Folder::take(&cli.out).map_err(|e| Failure::BadInput(format!("--out: {e}")))?;
    let findings = match stored {
        Some(findings) => findings,
        None => measured(cli, &base, plan, peers)?,
    };
    cli.from.iter().try_for_each(|from| copy(from, folder.stage())).map_err(|e| Failure::RunFailed(e.to_string()))?;
    findings.write(folder.stage()).map_err(|e| Failure::RunFailed(e.to_string()))?;
    folder.publish().map_err(|e| Failure::RunFailed(e.to_string()))?;
    // A home page of someone else stays as it is.
    let home = site::home(&cli.out);
    if site::is_free(&home).is_ok() {
        site::refresh(&home).map_err(|e| Failure::RunFailed(e.to_string()))?;
    }
    if cli.json {
        print_json(&findings);
    }
    let quiet = cli.quiet || cli.json;
    for answer in answers(&findings) {
        say(quiet, &format!("{:>6}: {}", answer.wanted, answer.answer));
    }
    say(quiet, &findings.notes[0]);
    say(quiet, &format!("page: {}", cli.out.join("index.html").display()));
    Ok(())
}

/// Findings of a sweep, with those of its runs that the store has.
fn measured(cli: &Cli, base: &Scene, plan: Plan, peers: Vec<Peer>) -> Result<Findings, Failure> {
    let start = std::time::Instant::now();
    let manifest = Manifest { command: command(), ..Manifest::new(base, 1) };
    let mut store = open(&cli.out, &build(&manifest), cli.fresh)?;
    let mut notes = store.opened.notes();
    let quiet = cli.quiet || cli.json;
    notes.iter().for_each(|note| say(quiet, note));

    let progress = Progress::new("speed against error", quiet);
    let rows = sweep(&plan, base, &mut store, &progress).map_err(|e| match e {
        SweepError::Setting(why) => Failure::BadInput(why.to_string()),
        e => Failure::RunFailed(e.to_string()),
    })?;
    let kernel = kept_or_measured(&cli.out, &build(&manifest), (cli.quick, cli.fresh), &|line| progress.line(line));
    progress.finish();
    let kernel = kernel.map_err(|e| Failure::RunFailed(e.to_string()))?;
    let (wall, count) = (start.elapsed().as_secs_f64(), rows.len());
    notes.insert(
        0,
        format!("{count} settings, each timed at most {} times; {wall:.0} s of wall-clock time.", plan.visits),
    );
    if cfg!(debug_assertions) {
        notes.push("Debug build: its times are not those of a release build.".to_owned());
    }
    let mut findings = Findings::new(manifest, rows, peers, plan.left_out, notes);
    findings.kernel = Some(kernel);
    Ok(findings)
}

/// Opens the store of a folder.
fn open(folder: &Path, build: &str, fresh: bool) -> Result<Store, Failure> {
    let refused = |e: std::io::Error| {
        Failure::BadInput(format!("--out: expected a folder that can be written to, found {}: {e}", folder.display()))
    };
    Store::open(&folder.join("store.jsonl"), build, fresh).map_err(refused)
}

/// The arguments as given, without the path of the program.
fn command() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("mpm-bench {}", arguments.join(" ")).trim().to_owned()
}

/// Prints a line unless quiet. A closed pipe is no error.
fn say(quiet: bool, line: &str) {
    if !quiet {
        let _ = writeln!(std::io::stdout(), "{line}");
    }
}

/// The rows of `cheapest.csv` as objects.
fn print_json(findings: &Findings) {
    let names: Vec<&str> = cheapest::COLUMNS.split(',').collect();
    let objects: Vec<serde_json::Value> = cheapest::table(&findings.rows)
        .iter()
        .map(|row| {
            let value = |text: String| match text.parse::<f64>() {
                Ok(number) if number.is_finite() => serde_json::json!(number),
                Ok(_) => serde_json::Value::Null,
                Err(_) => serde_json::json!(text),
            };
            names.iter().map(|n| (*n).to_owned()).zip(row.fields().into_iter().map(value)).collect()
        })
        .map(serde_json::Value::Object)
        .collect();
    if let Ok(text) = serde_json::to_string_pretty(&objects) {
        let _ = writeln!(std::io::stdout(), "{text}");
    }
}

//! The command line. `mpm-verify` alone runs the accuracy study and writes its report.

mod commands;
#[cfg(test)]
mod promised;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, FromArgMatches, Parser, Subcommand};
use commands::{
    cases, check, gallery, gate, help, leaderboard, levee, list, merge, metamorphic, mutants, nightly, prove, publish,
    report, score, slope, solve, stability, study,
};

/// Verifies a two-phase double-point material point method (soil and water) against exact solutions.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    study: study::Options,
    #[command(flatten)]
    common: Common,
}

/// Options of every command.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Output")]
pub struct Common {
    /// Folder for the results, in place of one below reports/
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of threads; 0 uses all cores
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    jobs: u16,
    /// Print errors only
    #[arg(long)]
    quiet: bool,
    /// Print the results as JSON on standard output
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Seepage through a levee until it fails: animation, events, factors of safety
    Levee {
        #[command(flatten)]
        options: levee::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Factor of safety of a slope by strength reduction and limit equilibrium
    Slope {
        #[command(flatten)]
        options: slope::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Accuracy study of the paper's column: errors, orders, claims (the default)
    Study {
        #[command(flatten)]
        options: study::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Verification suite: test cases against exact solutions, or a scene of your own
    Check {
        #[command(flatten)]
        options: check::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Neutral cases for other codes: write them, answer them
    Cases {
        #[command(flatten)]
        options: cases::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Score the answers of other codes: errors, orders, verdicts, mistakes
    Score {
        #[command(flatten)]
        options: score::Options,
        #[command(flatten)]
        common: Common,
    },
    /// One page of the scores of several codes
    Leaderboard {
        #[command(flatten)]
        options: leaderboard::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Run one scene: history, profiles, maps and a page
    Solve {
        #[command(flatten)]
        options: solve::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Ten engineering scenes: embankment, footing, drawdown, rain and others
    Gallery {
        #[command(flatten)]
        options: gallery::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Time-step limits and stress tests of every scheme
    Stability {
        #[command(flatten)]
        options: stability::Options,
        #[command(flatten)]
        common: Common,
    },
    #[command(about = nightly::about())]
    Nightly {
        #[command(flatten)]
        options: nightly::Options,
        #[command(flatten)]
        common: Common,
    },
    #[command(about = prove::about())]
    Prove {
        #[command(flatten)]
        options: prove::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Write the report of a stored study again
    Report {
        /// Folder with study.json
        #[arg(value_name = "DIR", default_value = "reports/accuracy")]
        folder: PathBuf,
        #[command(flatten)]
        common: Common,
    },
    /// Make what the README and the guide show, from a clean commit, in reports/published
    Publish {
        #[command(flatten)]
        options: publish::Options,
        #[command(flatten)]
        common: Common,
    },
    /// List test cases, scenes, stress tests, variants and schemes
    List {
        #[command(flatten)]
        options: list::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Plant known faults in a copy of the source; every one must be caught
    Mutants {
        #[command(flatten)]
        options: mutants::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Random scenes and relations between their runs: mirrored, rescaled, resumed, refined
    Metamorphic {
        #[command(flatten)]
        options: metamorphic::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Report of a study that was run in shares by `study --shard`
    Merge {
        /// Folders of the shares
        #[arg(required = true, value_name = "DIR")]
        folders: Vec<PathBuf>,
        #[command(flatten)]
        common: Common,
    },
    /// Options that are rarely needed
    #[command(hide = true)]
    Advanced,
    /// One run of a work gate, whose instructions another program counts
    #[command(hide = true)]
    Gate {
        /// Name of the gate
        name: String,
    },
}

fn main() -> ExitCode {
    commands::ignore_hang_up_under_nohup();
    let cli = Cli::from_arg_matches(&help::cli().get_matches()).unwrap_or_else(|e| e.exit());
    let outcome = match cli.command {
        None => study::run(&cli.study, &cli.common),
        Some(Command::Levee { options, common }) => levee::run(&options, &common),
        Some(Command::Study { options, common }) => study::run(&options, &common),
        Some(Command::Check { options, common }) => check::run(&options, &common),
        Some(Command::Cases { options, common }) => cases::run(&options, &common),
        Some(Command::Score { options, common }) => score::run(&options, &common),
        Some(Command::Leaderboard { options, common }) => leaderboard::run(&options, &common),
        Some(Command::Solve { options, common }) => solve::run(&options, &common),
        Some(Command::Gallery { options, common }) => gallery::run(&options, &common),
        Some(Command::Slope { options, common }) => slope::run(&options, &common),
        Some(Command::Stability { options, common }) => stability::run(&options, &common),
        Some(Command::Nightly { options, common }) => nightly::run(&options, &common),
        Some(Command::Prove { options, common }) => prove::run(&options, &common),
        Some(Command::Report { folder, common }) => report::run(&folder, &common),
        Some(Command::Publish { options, common }) => publish::run(&options, &common),
        Some(Command::List { options, common }) => list::run(&options, &common),
        Some(Command::Mutants { options, common }) => mutants::run(&options, &common),
        Some(Command::Metamorphic { options, common }) => metamorphic::run(&options, &common),
        Some(Command::Merge { folders, common }) => merge::run(&folders, &common),
        Some(Command::Advanced) => help::run(),
        Some(Command::Gate { name }) => gate::run(&name),
    };
    match outcome.and_then(|()| commands::terminal::all_printed()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            anstream::eprintln!("{}", commands::terminal::coloured(&failure.to_string()));
            ExitCode::from(failure.code())
        }
    }
}

//! The command line. `mpm-verify` alone is the main job: the accuracy study with its report.

mod commands;
#[cfg(test)]
mod promised;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use commands::{
    Failure, check, gallery, gate, levee, list, merge, metamorphic, mutants, nightly, report, solve, stability, study,
};

/// Verification of the two-layer material point method against exact solutions.
///
/// Without a command: the accuracy study on the paper's Table 1, with its report in reports/index.html.
#[derive(Debug, Parser)]
#[command(version, about, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    study: study::Options,
    #[command(flatten)]
    common: Common,
}

/// Flags of every command.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// Folder for what is written
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Threads; 0 takes as many as there are cores
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    jobs: u16,
    /// Say nothing but errors
    #[arg(long)]
    quiet: bool,
    /// Print the result as JSON on standard output
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The accuracy study: mesh x particles per cell x load, errors, budget, claims, plots, report
    Study {
        #[command(flatten)]
        options: study::Options,
        #[command(flatten)]
        common: Common,
    },
    /// The report of a study whose shares were run apart, by `study --shard`
    Merge {
        /// Folders of the shares
        #[arg(required = true, value_name = "DIR")]
        folders: Vec<PathBuf>,
        #[command(flatten)]
        common: Common,
    },
    /// Run one scene file
    Solve {
        #[command(flatten)]
        options: solve::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Ten real scenes: an embankment on clay, a footing, a levee with a core, drawdown and others, each with its page
    Gallery {
        #[command(flatten)]
        options: gallery::Options,
        #[command(flatten)]
        common: Common,
    },
    /// The levee of the paper's section 4: seepage and failure, claims, pictures, sensitivity
    Levee {
        #[command(flatten)]
        options: levee::Options,
        #[command(flatten)]
        common: Common,
    },
    /// The verification suite: every case, or those named, or a scene of your own; exit code 1 when one falls short
    Check {
        #[command(flatten)]
        options: check::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Time-step limits, predicted and measured, and the checkerboard index of both Darcy operators
    Stability {
        #[command(flatten)]
        options: stability::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Study, suite, stability, levee, random scenes and work, compared with the accepted baselines and remembered; exit code 1 when
    /// something moved
    Nightly {
        #[command(flatten)]
        options: nightly::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Plant known faults in a copy of the source, and show which check catches each; exit code 1 if one is not caught
    Mutants {
        #[command(flatten)]
        options: mutants::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Random scenes, and relations that must hold between their runs: mirrored, in other units, resumed, refined; exit code 1
    /// when one fails
    Metamorphic {
        #[command(flatten)]
        options: metamorphic::Options,
        #[command(flatten)]
        common: Common,
    },
    /// Rebuild the report from a stored study
    Report {
        /// Folder that holds study.json
        #[arg(default_value = "reports/accuracy")]
        folder: PathBuf,
        #[command(flatten)]
        common: Common,
    },
    /// One run of a gate of the work, to be counted by others
    #[command(hide = true)]
    Gate {
        /// Its name
        name: String,
    },
    /// What there is: cases, scenes, schemes
    List {
        /// What scenes can have beside what: the table that scenes are checked against
        #[arg(long)]
        capabilities: bool,
        #[command(flatten)]
        common: Common,
    },
}

fn main() -> ExitCode {
    commands::hold_back_hang_up();
    let cli = Cli::parse();
    let outcome = match cli.command {
        None => study::run(&cli.study, &cli.common),
        Some(Command::Study { options, common }) => study::run(&options, &common),
        Some(Command::Merge { folders, common }) => merge::run(&folders, &common),
        Some(Command::Solve { options, common }) => solve::run(&options, &common),
        Some(Command::Gallery { options, common }) => gallery::run(&options, &common),
        Some(Command::Levee { options, common }) => levee::run(&options, &common),
        Some(Command::Check { options, common }) => check::run(&options, &common),
        Some(Command::Stability { options, common }) => stability::run(&options, &common),
        Some(Command::Nightly { options, common }) => nightly::run(&options, &common),
        Some(Command::Metamorphic { options, common }) => metamorphic::run(&options, &common),
        Some(Command::Mutants { options, common }) => mutants::run(&options, &common),
        Some(Command::Gate { name }) => gate::run(&name),
        Some(Command::Report { folder, common }) => report::run(&folder, &common),
        Some(Command::List { capabilities: true, common }) => list::capabilities(&common),
        Some(Command::List { common, .. }) => list::run(&common),
    };
    match outcome.and_then(|()| commands::all_printed()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            ExitCode::from(failure.code())
        }
    }
}

/// How a command ends when it does not succeed.
impl Failure {
    fn code(&self) -> u8 {
        match self {
            Self::CheckFailed(_) => 1,
            Self::BadInput(_) => 2,
            Self::RunFailed(_) => 3,
        }
    }
}

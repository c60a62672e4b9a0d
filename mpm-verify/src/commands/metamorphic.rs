//! `metamorphic`: random scenes that make sense, and relations that must hold between their runs.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Args;
use mpm_verify::manifest::Manifest;
use mpm_verify::metamorphic::{Found, OfLaw, Outcome, Reason, scenes, scenes_of};
use mpm_verify::progress::{Progress, time};
use serde::Serialize;

use super::{Failure, inside, into_folder, jobs, print_json, say, write_csv, write_json};
use crate::Common;

/// Which scenes.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Scenes
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    scenes: u64,
    /// Seed of their random numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// This scene of the seed alone, which is written as scene.toml
    #[arg(long, value_name = "INDEX", conflicts_with = "scenes")]
    only: Option<u64>,
    /// Seconds after which no further scene is begun
    #[arg(long, value_name = "S", value_parser = super::seconds)]
    time_limit: Option<f64>,
}

/// summary.json.
#[derive(Debug, Serialize)]
struct Summary<'a> {
    manifest: Manifest,
    seed: u64,
    scenes: usize,
    wall_s: f64,
    laws: &'a [OfLaw],
    reasons: &'a [Reason],
    failures: Vec<String>,
}

/// Runs the scenes, and writes what was found.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let path = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/metamorphic"));
    let indices: Vec<u64> = options.only.map_or_else(|| (0..options.scenes).collect(), |index| vec![index]);
    let names = ["laws.csv", "summary.json"];
    let found = into_folder(&path, &names, |folder| {
        if let Some(index) = options.only {
            let path = folder.stage().join("scene.toml");
            let text = scenes::scene(options.seed, index).toml();
            fs::write(&path, text).map_err(|e| Failure::RunFailed(format!("{}: {e}", path.display())))?;
        }
        measure((options.seed, &indices, options.time_limit), common, folder.stage())
    })?;
    match found.failures.len() {
        0 => Ok(()),
        count => {
            let list: Vec<String> = found.failures.iter().map(|f| format!("{}: {}", f.name(), f.found[1])).collect();
            let folder = path.join("failures");
            Err(Failure::CheckFailed(format!("{count} failures, in {}:\n{}", folder.display(), list.join("\n"))))
        }
    }
}

/// Runs scenes of a seed, and writes their tables and failures into a folder.
pub fn measure(
    (seed, indices, limit_s): (u64, &[u64], Option<f64>),
    common: &Common,
    folder: &Path,
) -> Result<Found, Failure> {
    let progress = Progress::new("metamorphic", common.quiet || common.json);
    let done = AtomicU64::new(0);
    let count = indices.len() as u64;
    let told = |_| progress.set(1_000_000 * (done.fetch_add(1, Ordering::Relaxed) + 1) / count.max(1));
    let limits = (jobs(common.jobs), limit_s.unwrap_or(f64::INFINITY));
    let found = scenes_of(seed, indices, limits, &told);
    progress.finish();
    let (laws, reasons) = (found.laws(), found.reasons());
    inside(folder)?;
    write_csv(&folder.join("laws.csv"), &laws)?;
    write_csv(&folder.join("reasons.csv"), &reasons)?;
    write_csv(&folder.join("scenes.csv"), &found.rows)?;
    if !found.failures.is_empty() {
        inside(&folder.join("failures"))?;
    }
    for failure in &found.failures {
        let path = folder.join("failures").join(failure.name());
        fs::write(&path, failure.text(seed)).map_err(|e| Failure::RunFailed(format!("{}: {e}", path.display())))?;
    }
    let summary = Summary {
        manifest: Manifest::new(&mpm_verify::scenes::terzaghi(), jobs(common.jobs)),
        seed,
        scenes: found.scenes,
        wall_s: found.wall_s,
        laws: &laws,
        reasons: &reasons,
        failures: found.failures.iter().map(|failure| failure.name()).collect(),
    };
    write_json(&folder.join("summary.json"), &summary)?;
    if common.json {
        print_json(&summary);
    }
    said(&found, &laws, &reasons, common.quiet || common.json);
    Ok(found)
}

fn said(found: &Found, laws: &[OfLaw], reasons: &[Reason], quiet: bool) {
    let Found { seed, scenes, wall_s, .. } = found;
    say(quiet, &format!("{scenes} scenes of seed {seed} in {}", time(*wall_s)));
    let head = format!("{:<12} {:>7} {:>7} {:>7} {:>7}", "relation", "passed", "failed", "ended", "refused");
    say(quiet, &format!("{head} {:>14}  {:>13}", "not applicable", "largest ratio"));
    for law in laws {
        let OfLaw { law, passed, failed, ended, refused, not_applicable, largest_ratio, .. } = law;
        let counts = format!("{law:<12} {passed:>7} {failed:>7} {ended:>7} {refused:>7}");
        say(quiet, &format!("{counts} {not_applicable:>14}  {largest_ratio:>13.1e}"));
    }
    for Reason { kind, law, outcome, why, count, first } in reasons.iter().filter(|reason| reason.law == "run") {
        let word = if *outcome == Outcome::Refused { "refused" } else { "ended" };
        say(quiet, &format!("{word} {count} ({law}, {kind}, first {first}): {why}"));
    }
}

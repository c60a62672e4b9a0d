//! `metamorphic`: valid random scenes, and relations that must hold between their runs.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Args;
use mpm_verify::manifest::Manifest;
use mpm_verify::metamorphic::{Found, OfLaw, Outcome, Reason, scenes, scenes_of};
use mpm_verify::progress::{Progress, time};
use serde::Serialize;

use super::{Failure, make_folder, write_csv, write_file, write_json};
use crate::Common;

/// Which scenes.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Number of scenes
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    scenes: u64,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Run this scene of the seed alone, and write it as scene.toml
    #[arg(long, value_name = "INDEX", conflicts_with = "scenes")]
    only: Option<u64>,
    /// Time in seconds after which no further scene is started
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

/// Runs the scenes, and writes the results.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let indices: Vec<u64> = options.only.map_or_else(|| (0..options.scenes).collect(), |index| vec![index]);
    let found = common.publish("metamorphic", &["laws.csv", "summary.json"], |folder| {
        if let Some(index) = options.only {
            write_file(&folder.stage().join("scene.toml"), scenes::scene(options.seed, index).toml())?;
        }
        measure((options.seed, &indices, options.time_limit), common, folder.stage())
    })?;
    let path = common.folder("metamorphic");
    common.say(&format!("table: {}", path.join("laws.csv").display()));
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
    let progress = Progress::new("metamorphic", common.silent());
    let done = AtomicU64::new(0);
    let count = indices.len() as u64;
    let told = |_| progress.set(1_000_000 * (done.fetch_add(1, Ordering::Relaxed) + 1) / count.max(1));
    let limits = (common.jobs(), limit_s.unwrap_or(f64::INFINITY));
    let found = scenes_of(seed, indices, limits, &told);
    progress.finish();
    let (laws, reasons) = (found.laws(), found.reasons());
    make_folder(folder)?;
    write_csv(&folder.join("laws.csv"), &laws)?;
    write_csv(&folder.join("reasons.csv"), &reasons)?;
    write_csv(&folder.join("scenes.csv"), &found.rows)?;
    if !found.failures.is_empty() {
        make_folder(&folder.join("failures"))?;
    }
    for failure in &found.failures {
        write_file(&folder.join("failures").join(failure.name()), failure.text(seed))?;
    }
    let summary = Summary {
        manifest: Manifest::new(&mpm_verify::scenes::terzaghi(), common.jobs()),
        seed,
        scenes: found.scenes,
        wall_s: found.wall_s,
        laws: &laws,
        reasons: &reasons,
        failures: found.failures.iter().map(|failure| failure.name()).collect(),
    };
    write_json(&folder.join("summary.json"), &summary)?;
    common.json(&summary);
    said(&found, &laws, &reasons, common);
    Ok(found)
}

fn said(found: &Found, laws: &[OfLaw], reasons: &[Reason], common: &Common) {
    let Found { seed, scenes, wall_s, .. } = found;
    let head = format!("{:<12} {:>7} {:>7} {:>7} {:>7}", "relation", "passed", "failed", "stopped", "refused");
    common.say(&format!("{head} {:>14}  {:>13}", "not applicable", "largest ratio"));
    for law in laws {
        let OfLaw { law, passed, failed, ended, refused, not_applicable, largest_ratio, .. } = law;
        let counts = format!("{law:<12} {passed:>7} {failed:>7} {ended:>7} {refused:>7}");
        common.say(&format!("{counts} {not_applicable:>14}  {largest_ratio:>13.1e}"));
    }
    for Reason { kind, law, outcome, why, count, first } in reasons.iter().filter(|reason| reason.law == "run") {
        let word = if *outcome == Outcome::Refused { "refused" } else { "stopped" };
        common.say(&format!("{word} {count} ({law}, {kind}, first {first}): {why}"));
    }
    let failed = found.failures.len();
    common.say(&format!("{scenes} scenes of seed {seed} in {}: {failed} relations failed", time(*wall_s)));
}

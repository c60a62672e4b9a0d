//! `nightly`: everything, compared with the accepted baselines.

use std::fs;
use std::path::PathBuf;

use mpm_verify::baseline;
use mpm_verify::levee::limits;
use mpm_verify::report;
use serde::Serialize;

use super::{Failure, check, levee, say, stability, study, writable, write_csv};
use crate::Common;

/// A line of `nightly.csv`.
#[derive(Debug, Serialize)]
struct Night {
    date: String,
    commit: String,
    rungs: usize,
    fallen: usize,
    drifts: usize,
    largest_drift: f64,
    study_cpu_s: f64,
    limits: usize,
    limits_fallen: usize,
    levee_failure_h: Option<f64>,
    levee_toe_m: Option<f64>,
    levee_ended: String,
    levee_limits: usize,
    levee_limits_fallen: usize,
}

/// Runs study, ladder, stability and levee; appends a line to `nightly.csv` and writes `accepted.csv`, the baselines as they
/// would be with these results.
pub fn run(common: &Common) -> Result<(), Failure> {
    let folder = common.out.clone().unwrap_or_else(|| PathBuf::from("reports"));
    writable(&folder)?;
    let accuracy = folder.join("accuracy");
    let study = study::compute(&study::Options::paper(), common, &accuracy)?;
    // The study's page links to that of the ladder, but does not wait for one that fails.
    let steps = check::climb(&[], common, &folder.join("ladder"));
    report::write(&study, &accuracy).map_err(|e| Failure::RunFailed(e.to_string()))?;
    let steps = steps?;
    let steps_measured = stability::measure(&stability::Options::default(), common, &folder.join("stability"))?;
    let levee = levee::night(&folder.join("levee"))?;
    let drifts = baseline::compare(&study.results);
    write_csv(&folder.join("drift.csv"), &drifts)?;
    let (path, rows) = (folder.join("accepted.csv"), baseline::accepted(&study.results));
    fs::write(&path, rows).map_err(|e| Failure::RunFailed(format!("{}: {e}", path.display())))?;
    let (limits, limits_fallen) = study.sweeps.limits();
    let fallen = steps.iter().filter(|s| !s.held()).count();
    let drifted = drifts.iter().filter(|d| !d.held()).count();
    let kept = limits::of(&levee);
    let night = Night {
        date: study.manifest.date.clone(),
        commit: study.manifest.commit.clone(),
        rungs: steps.len(),
        fallen,
        drifts: drifted,
        largest_drift: drifts.iter().map(|d| d.relative_change).fold(0.0, f64::max),
        study_cpu_s: study.results.iter().map(|r| r.cpu_s).sum(),
        limits,
        limits_fallen,
        levee_failure_h: levee.failure_start_h,
        levee_toe_m: levee.toe_x_m,
        levee_ended: levee.ended.clone(),
        levee_limits: kept.len(),
        levee_limits_fallen: kept.iter().filter(|limit| !limit.held()).count(),
    };
    append(&folder.join("nightly.csv"), &night)?;
    let line = format!(
        "{} of {} rungs held, {drifted} of {} errors drifted, {limits_fallen} of {limits} sweeps fell short, {} of {} limits of \
         the levee not held",
        steps.len() - fallen,
        steps.len(),
        drifts.len(),
        night.levee_limits_fallen,
        night.levee_limits
    );
    say(common.quiet, &line);
    for limit in kept.iter().filter(|limit| !limit.held()) {
        say(common.quiet, &format!("levee: {}", limit.said()));
    }
    stability::verdict(&steps_measured)?;
    let unfinished = limits::unfinished(&levee.ended, levee.trouble.as_deref());
    if let Some(how) = &unfinished {
        say(common.quiet, &format!("levee: {how}"));
    }
    if unfinished.is_some() || fallen + drifted + limits_fallen + night.levee_limits_fallen > 0 {
        Err(Failure::FellShort(line))
    } else {
        Ok(())
    }
}

/// Appends a row, with a header if the file is new or has another one.
fn append(path: &std::path::Path, night: &Night) -> Result<(), Failure> {
    let lost = |e: String| Failure::RunFailed(format!("{}: {e}", path.display()));
    let known = fs::read_to_string(path).unwrap_or_default();
    let new = !known.lines().any(|line| line.ends_with("levee_ended,levee_limits,levee_limits_fallen"));
    let file = fs::OpenOptions::new().create(true).append(true).open(path).map_err(|e| lost(e.to_string()))?;
    let mut writer = csv::WriterBuilder::new().has_headers(new).from_writer(file);
    writer.serialize(night).map_err(|e| lost(e.to_string()))?;
    writer.flush().map_err(|e| lost(e.to_string()))
}

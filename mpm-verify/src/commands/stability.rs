//! `stability`: time-step limits and the checkerboard index.

use std::path::{Path, PathBuf};

use clap::Args;
use mpm_verify::progress::Progress;
use mpm_verify::report::plots;
use mpm_verify::report::plots::stability_map::figures;
use mpm_verify::stability::map::{self, Extent, Row, Summary};
use mpm_verify::stability::{Limit, checkerboard, limits};
use serde::Serialize;

use super::{Failure, jobs, print_json, say, writable, write_csv, write_json};
use crate::Common;

/// What is measured.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Options {
    /// Measure the ends and the middle of every range of the map only
    #[arg(long)]
    quick: bool,
}

/// What the command found.
#[derive(Debug, Serialize)]
pub struct Findings {
    limits: Vec<Limit>,
    checkerboard_face: f64,
    checkerboard_nodal: f64,
    map: Vec<Summary>,
    map_troubles: Vec<String>,
}

/// The measured limit may be this far from the predicted one.
const AGREEMENT: [f64; 2] = [0.95, 1.25];

/// Measures and writes `stability.csv`, `stability_map.csv` and its pictures, and `stability.json`; falls short if `auto`
/// would not be safe or a measured limit is not that of the theory.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let folder = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/stability"));
    let findings = measure(options, common, &folder)?;
    if common.json {
        print_json(&findings);
    }
    verdict(&findings)
}

/// Measures, writes and prints.
pub fn measure(options: &Options, common: &Common, folder: &Path) -> Result<Findings, Failure> {
    writable(folder)?;
    let quiet = common.quiet || common.json;
    let limits = limits();
    let [checkerboard_face, checkerboard_nodal] = checkerboard();
    say(quiet, "dimension     darcy  inertia  L (m)  ppc  predicted (s)  measured/predicted");
    for l in &limits {
        let row = format!("{:<13} {:<6} {:<8} {:<6} {:<4}", l.dimension, l.darcy, l.darcy_inertia, l.mesh_m, l.ppc);
        say(quiet, &format!("{row} {:<14.4e} {:.3}", l.predicted_s, l.ratio));
    }
    say(quiet, &format!("checkerboard index: face {checkerboard_face:.4}, nodal {checkerboard_nodal:.4}"));
    write_csv(&folder.join("stability.csv"), &limits)?;
    let rows = map(options, common, folder)?;
    let map = map::summaries(&rows);
    say(quiet, "scheme                   dimension     darcy  rows   measured/theory   auto/measured");
    for s in &map {
        let row = format!("{:<24} {:<13} {:<6} {:<6}", s.scheme, s.dimension, s.darcy, s.rows);
        let [low, high] = s.ratio;
        say(quiet, &format!("{row} {low:.3} to {high:.3}    {:.3e} to {:.3}", s.auto[0], s.auto[1]));
    }
    let map_troubles = rows.iter().filter_map(Row::trouble).collect();
    let findings = Findings { limits, checkerboard_face, checkerboard_nodal, map, map_troubles };
    write_json(&folder.join("stability.json"), &findings)?;
    Ok(findings)
}

/// The map, its table and its pictures.
fn map(options: &Options, common: &Common, folder: &Path) -> Result<Vec<Row>, Failure> {
    let extent = if options.quick { Extent::Thin } else { Extent::Whole };
    let progress = Progress::new("stability map", common.quiet || common.json);
    let rows = map::rows(&map::settings(extent), jobs(common.jobs), &progress).map_err(Failure::RunFailed)?;
    progress.finish();
    write_csv(&folder.join("stability_map.csv"), &rows)?;
    let pictures = folder.join("plots");
    writable(&pictures)?;
    for figure in figures(&rows) {
        plots::write(&figure, &pictures).map_err(|e| Failure::RunFailed(e.to_string()))?;
    }
    Ok(rows)
}

/// Whether every measured limit agrees with the predicted one.
pub fn verdict(findings: &Findings) -> Result<(), Failure> {
    if let Some(first) = findings.map_troubles.first() {
        let count = findings.map_troubles.len();
        return Err(Failure::FellShort(format!("stability map, {count} rows: {first}")));
    }
    let off = |l: &&Limit| !(AGREEMENT[0]..=AGREEMENT[1]).contains(&l.ratio);
    match findings.limits.iter().find(off) {
        None => Ok(()),
        Some(l) => Err(Failure::FellShort(format!(
            "stability: expected a measured limit of {} to {} times the predicted one, found {:.3} ({} {} L = {} ppc {})",
            AGREEMENT[0], AGREEMENT[1], l.ratio, l.dimension, l.darcy, l.mesh_m, l.ppc
        ))),
    }
}

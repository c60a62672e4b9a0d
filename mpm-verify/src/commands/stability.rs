//! `stability`: time-step limits and the checkerboard index.

use std::path::{Path, PathBuf};

use mpm_verify::stability::{Limit, checkerboard, limits};
use serde::Serialize;

use super::{Failure, print_json, say, writable, write_csv, write_json};
use crate::Common;

/// What the command found.
#[derive(Debug, Serialize)]
pub struct Findings {
    limits: Vec<Limit>,
    checkerboard_face: f64,
    checkerboard_nodal: f64,
}

/// The measured limit may be this far from the predicted one.
const AGREEMENT: [f64; 2] = [0.95, 1.25];

/// Measures and writes `stability.csv` and `checkerboard.json`; falls short if `auto` would not be safe.
pub fn run(common: &Common) -> Result<(), Failure> {
    let folder = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/stability"));
    let findings = measure(common, &folder)?;
    if common.json {
        print_json(&findings);
    }
    verdict(&findings)
}

/// Measures, writes and prints.
pub fn measure(common: &Common, folder: &Path) -> Result<Findings, Failure> {
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
    let findings = Findings { limits, checkerboard_face, checkerboard_nodal };
    write_json(&folder.join("stability.json"), &findings)?;
    Ok(findings)
}

/// Whether every measured limit agrees with the predicted one.
pub fn verdict(findings: &Findings) -> Result<(), Failure> {
    let off = |l: &&Limit| !(AGREEMENT[0]..=AGREEMENT[1]).contains(&l.ratio);
    match findings.limits.iter().find(off) {
        None => Ok(()),
        Some(l) => Err(Failure::FellShort(format!(
            "stability: expected a measured limit of {} to {} times the predicted one, found {:.3} ({} {} L = {} ppc {})",
            AGREEMENT[0], AGREEMENT[1], l.ratio, l.dimension, l.darcy, l.mesh_m, l.ppc
        ))),
    }
}

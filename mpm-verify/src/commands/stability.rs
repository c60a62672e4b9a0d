//! `stability`: time-step limits, the checkerboard index, and stress tests.

use std::path::Path;

use clap::Args;
use mpm_verify::manifest::Manifest;
use mpm_verify::progress::Progress;
use mpm_verify::report::plots::figure::Figure;
use mpm_verify::report::plots::stability_map::figures;
use mpm_verify::report::{self, plots};
use mpm_verify::stability::map::{self, Extent, Row, Summary};
use mpm_verify::stability::{Limit, checkerboard, limits};
use mpm_verify::stress::{self, CASES, Case, Found, MatrixRow};
use mpm_verify::study::word;
use serde::Serialize;

use super::{Failure, make_folder, write_csv, write_json};
use crate::Common;

/// What is measured.
#[derive(Debug, Clone, Default, Args)]
pub struct Options {
    /// Stress tests to run, without the map; all of them and the map without a name
    #[arg(value_name = "TEST")]
    cases: Vec<String>,
    /// Only the default schemes, and the ends and the middle of every range of the map
    #[arg(long)]
    quick: bool,
    /// Only the default schemes in the stress tests, and the whole map
    #[arg(skip)]
    defaults: bool,
}

impl Options {
    /// What a night measures: the map, and of all schemes or of the default ones what they bear.
    pub fn of_a_night(all: bool) -> Self {
        Self { defaults: !all, ..Self::default() }
    }
}

/// Results of the command.
#[derive(Debug, Serialize)]
pub struct Findings {
    limits: Vec<Limit>,
    checkerboard_face: f64,
    checkerboard_nodal: f64,
    map: Vec<Summary>,
    map_troubles: Vec<String>,
    matrix: Vec<MatrixRow>,
    broken_defaults: Vec<String>,
    degraded_defaults: Vec<String>,
}

impl Findings {
    /// Every scheme in every stress test.
    pub fn matrix(&self) -> &[MatrixRow] {
        &self.matrix
    }

    /// Summaries of the map.
    pub fn summaries(&self) -> &[Summary] {
        &self.map
    }
}

/// Allowed range of measured over predicted limits.
const AGREEMENT: [f64; 2] = [0.95, 1.25];

/// Measures and writes `stability.csv`, `stability_map.csv`, `matrix.csv`, `stress_tests.csv`, the page with its pictures, and
/// `stability.json`; fails if `auto` would not be safe, a measured limit differs from the theory, or a default scheme fails.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let findings = common
        .publish("stability", &["index.html", "stability.json"], |folder| measure(options, common, folder.stage()))?;
    common.json(&findings);
    let counts = report::stress::counts(findings.matrix.iter().map(|row| row.verdict)).words();
    common.say(&format!("{counts} of {} schemes in stress tests", findings.matrix.len()));
    findings.degraded_defaults.iter().for_each(|line| common.say(line));
    if !findings.map.is_empty() {
        let (groups, off) = (findings.map.len(), findings.map_troubles.len());
        common.say(&format!("{groups} groups of time-step limits, {off} rows failed"));
    }
    common.page(&common.folder("stability").join("index.html"));
    verdict(&findings)
}

/// Measures, writes and prints.
pub fn measure(options: &Options, common: &Common, folder: &Path) -> Result<Findings, Failure> {
    let cases = chosen(&options.cases)?;
    make_folder(&folder.join("plots"))?;
    let mut findings = Findings {
        limits: Vec::new(),
        checkerboard_face: f64::NAN,
        checkerboard_nodal: f64::NAN,
        map: Vec::new(),
        map_troubles: Vec::new(),
        matrix: Vec::new(),
        broken_defaults: Vec::new(),
        degraded_defaults: Vec::new(),
    };
    let mut pictures = Vec::new();
    if options.cases.is_empty() {
        pictures = steps(options, common, folder, &mut findings)?;
    }
    let found = stress_tests(&cases, options, common, folder)?;
    findings.matrix = found.iter().map(|f| f.row(&cases)).collect();
    findings.degraded_defaults = report::stress::degraded_defaults(&cases, &found);
    findings.broken_defaults = report::stress::broken_defaults(&cases, &found);
    for row in &findings.matrix {
        let value = row.value.map_or_else(|| "-".to_owned(), |v| format!("{v:.1e}"));
        let verdict = word(row.verdict);
        let scheme = format!("{} {}", row.integrator, row.scheme);
        common
            .say(&format!("{:<22} {scheme:<26} {verdict:<8} {value:<8} at {} {:.1e}", row.case, row.parameter, row.at));
    }
    let manifest = Manifest::new(&mpm_verify::scenes::terzaghi(), common.jobs());
    let page = report::stress::write((&cases, &found), (&pictures, &findings.map), &manifest, folder);
    page.map_err(Failure::run_failed)?;
    write_json(&folder.join("stability.json"), &findings)?;
    Ok(findings)
}

/// The chosen stress tests, or all.
fn chosen(names: &[String]) -> Result<Vec<Case>, Failure> {
    let chosen = super::chosen(("the name of a stress test", "stress-tests"), names, &CASES, |case| case.name)?;
    Ok(chosen.into_iter().copied().collect())
}

/// Every scheme in every stress test, or the default schemes alone.
fn stress_tests(cases: &[Case], options: &Options, common: &Common, folder: &Path) -> Result<Vec<Found>, Failure> {
    let progress = Progress::new("stress tests", common.silent());
    let asked = |case: &Case, scheme: &stress::Scheme| {
        !(options.quick || options.defaults) || scheme.is_default(case.dimension)
    };
    let found = stress::matrix(cases, asked, common.jobs(), &progress);
    progress.finish();
    write_csv(&folder.join("matrix.csv"), &found.iter().map(|f| f.row(cases)).collect::<Vec<_>>())?;
    let points: Vec<_> = found.iter().flat_map(|f| f.point_rows(cases)).collect();
    write_csv(&folder.join("stress_tests.csv"), &points)?;
    Ok(found)
}

/// Time-step limits and checkerboard indices.
fn steps(options: &Options, common: &Common, folder: &Path, findings: &mut Findings) -> Result<Vec<Figure>, Failure> {
    findings.limits = limits().map_err(Failure::run_failed)?;
    [findings.checkerboard_face, findings.checkerboard_nodal] = checkerboard();
    common.say("dimension     darcy  inertia  L (m)  ppc  predicted (s)  measured/predicted");
    for l in &findings.limits {
        let row = format!("{:<13} {:<6} {:<8} {:<6} {:<4}", l.dimension, l.darcy, l.darcy_inertia, l.mesh_m, l.ppc);
        common.say(&format!("{row} {:<14.4e} {:.3}", l.predicted_s, l.ratio));
    }
    let [face, nodal] = [findings.checkerboard_face, findings.checkerboard_nodal];
    common.say(&format!("checkerboard index: face {face:.4}, nodal {nodal:.4}"));
    write_csv(&folder.join("stability.csv"), &findings.limits)?;
    let rows = map(options, common, folder)?;
    findings.map = map::summaries(&rows);
    common.say("scheme                   dimension     darcy  rows   measured/theory   auto/measured");
    for s in &findings.map {
        let row = format!("{:<24} {:<13} {:<6} {:<6}", s.scheme, s.dimension, s.darcy, s.rows);
        let [low, high] = s.ratio;
        common.say(&format!("{row} {low:.3} to {high:.3}    {:.3e} to {:.3}", s.auto[0], s.auto[1]));
    }
    findings.map_troubles = rows.iter().filter_map(Row::trouble).collect();
    Ok(figures(&rows))
}

/// The map, its table and its pictures.
fn map(options: &Options, common: &Common, folder: &Path) -> Result<Vec<Row>, Failure> {
    let extent = if options.quick { Extent::Thin } else { Extent::Whole };
    let progress = Progress::new("stability map", common.silent());
    let rows = map::rows(&map::settings(extent), common.jobs(), &progress).map_err(Failure::run_failed)?;
    progress.finish();
    write_csv(&folder.join("stability_map.csv"), &rows)?;
    for figure in figures(&rows) {
        plots::write(&figure, &folder.join("plots")).map_err(Failure::run_failed)?;
    }
    Ok(rows)
}

/// Whether every measured limit agrees with the predicted one, and no default scheme fails.
pub fn verdict(findings: &Findings) -> Result<(), Failure> {
    if let Some(first) = findings.map_troubles.first() {
        let count = findings.map_troubles.len();
        return Err(Failure::CheckFailed(format!("stability map, {count} rows: {first}")));
    }
    if !findings.broken_defaults.is_empty() {
        return Err(Failure::CheckFailed(findings.broken_defaults.join("; ")));
    }
    let off = |l: &&Limit| !(AGREEMENT[0]..=AGREEMENT[1]).contains(&l.ratio);
    match findings.limits.iter().find(off) {
        None => Ok(()),
        Some(l) => Err(Failure::CheckFailed(format!(
            "stability: expected a measured limit of {} to {} times the predicted one, found {:.3} ({} {} L = {} ppc {})",
            AGREEMENT[0], AGREEMENT[1], l.ratio, l.dimension, l.darcy, l.mesh_m, l.ppc
        ))),
    }
}

//! `publish`: makes all reports that the README and the guide show, from one clean commit in release, copies what is shown to the folder
//! that git tracks, and writes the numbers of the pages anew.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use clap::Args;
use clap::builder::PossibleValuesParser;
use mpm_core::scene::read_text;
use mpm_verify::book::stored;
use mpm_verify::error::Error;
use mpm_verify::files::{Folder, FolderError};
use mpm_verify::page::site::RECORD;
use mpm_verify::progress::time;
use mpm_verify::provenance::Made;

use super::{Failure, make_folder};
use crate::Common;

/// A report that is published.
struct Report {
    /// Folder of the report, below `reports` and among the published ones.
    name: &'static str,
    /// Pictures and tables that the README and the guide show, and what these are made of.
    files: &'static str,
    /// Arguments of the program that makes it, one call a line; the folder is added to each.
    made_by: &'static [&'static [&'static str]],
}

/// Published reports in the order in which they are made. Times are those of two cores.
const PUBLISHED: [Report; 9] = [
    // 1 min.
    Report {
        name: "accuracy",
        files: "budget.csv claims.csv claims_integrators.csv consolidation.csv cost.csv displaced.csv errors.csv grid_shift.csv \
                manifest.json orders.csv plots/at-a-glance.csv plots/at-a-glance.svg plots/time-step.svg plots/consolidation.csv plots/consolidation.svg plots/crossings.csv plots/crossings.svg \
                plots/displaced.csv plots/displaced.svg plots/energy.csv plots/energy.svg plots/error-against-factorisations.csv \
                plots/error-against-factorisations.svg plots/error-against-steps.csv plots/error-against-steps.svg \
                plots/error-against-time-particles.csv plots/error-against-time-particles.svg \
                plots/error-against-time-surface.csv plots/error-against-time-surface.svg plots/error-budget-late.csv \
                plots/error-budget-late.svg plots/error-budget.csv plots/error-budget.svg plots/error-of-all-schemes.csv \
                plots/error-of-all-schemes.svg plots/grid-shift.csv plots/grid-shift.svg plots/isochrones-bspline2.csv \
                plots/isochrones-bspline2.svg plots/isochrones.csv plots/isochrones.svg \
                plots/max-error-against-mesh-compressible.csv plots/max-error-against-mesh-compressible.svg \
                plots/max-error-against-mesh-terzaghi.csv plots/max-error-against-mesh-terzaghi.png \
                plots/max-error-against-mesh-terzaghi.svg plots/mesh.csv plots/mesh.svg plots/profile-error-against-mesh.csv \
                plots/profile-error-against-mesh.svg plots/profile-error-of-all-schemes.csv \
                plots/profile-error-of-all-schemes.svg report.json report.md time_error.csv",
        made_by: &[&["study"]],
    },
    // 3 min.
    Report { name: "suite", files: "cases.csv manifest.json report.json", made_by: &[&["check"]] },
    // 6 min.
    Report { name: "stability", files: "matrix.csv manifest.json report.json", made_by: &[&["stability"]] },
    // A second.
    Report {
        name: "dam",
        files: "map-water.csv map-water.png map-water_lines.csv report.json summary.json water.csv",
        made_by: &[&["solve", "reference-data/scenes/dam.toml"]],
    },
    // 6 min, most of it for the ensemble on its finest mesh.
    Report {
        name: "levee",
        files: "claims.csv ensemble.csv events.csv levee.png plots/levee-failure.png plots/levee-probability.png \
                plots/levee-safety.png probability.csv report.json safety_factor.csv sensitivity.csv summary.json",
        made_by: &[
            &["levee", "--no-run", "--ensemble", "9", "--full"],
            &["levee", "--sensitivity", "--probability", "--safety-factor", "8,10,12,14"],
        ],
    },
    // 6 min.
    Report { name: "slopes", files: "report.json slopes.csv", made_by: &[&["slope"]] },
    // 3 min. Scores of other codes are those that are published: they are results of other programs, which this one cannot make.
    Report {
        name: "leaderboard",
        files: "leaderboard.csv plots/solved-against-cpu.svg report.json scores/finite-volumes.json scores/kratos-geo.json \
                scores/kratos-mpm.json scores/mpm-verify.json scores/opengeosys.json scores/student-mpm.json scores/toy.json",
        made_by: &[
            &[
                "score",
                "--name",
                "mpm-verify",
                "--run",
                "target/release/mpm-verify cases answer {case} {out} --refinement {refinement} --quiet",
            ],
            &[
                "leaderboard",
                "target/publish/reports/leaderboard",
                "reports/published/leaderboard/scores/finite-volumes.json",
                "reports/published/leaderboard/scores/kratos-geo.json",
                "reports/published/leaderboard/scores/kratos-mpm.json",
                "reports/published/leaderboard/scores/opengeosys.json",
                "reports/published/leaderboard/scores/student-mpm.json",
                "reports/published/leaderboard/scores/toy.json",
            ],
        ],
    },
    // 8 min, with nothing beside it.
    Report {
        name: "speed-against-error",
        files: "cheapest.csv cost.csv growth.csv kernel.json kernel_limits.csv kernel_sizes.csv kernel_stages.csv manifest.json \
                plane_solves.csv plots/cpu-against-mesh.csv plots/cpu-against-mesh.svg plots/error-against-cpu-by-scheme.csv \
                plots/error-against-cpu-by-scheme.svg plots/fronts.csv plots/fronts.svg plots/kernel-cost-against-points.csv \
                plots/kernel-cost-against-points.svg report.json report.md",
        made_by: &[&["mpm-bench", "--fresh"]],
    },
    // 2 min. Not its tests: they read the published files, which are not there yet.
    Report {
        name: "prove",
        files: "manifest.json prove.csv",
        made_by: &[&["prove", "format", "lints", "suite", "study", "levee", "documentation"]],
    },
];

/// Folder of the reports that are made to be published: apart from those of other runs.
const MADE: &str = "target/publish/reports";
/// Folder of the published files, in one of the same name for each report.
const TARGET: &str = "reports/published";
/// Largest record of a report, bytes.
const LARGEST: u64 = 1 << 20;

/// Which reports.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Reports to publish; all without a name
    #[arg(value_name = "NAME", value_parser = PossibleValuesParser::new(PUBLISHED.map(|report| report.name)))]
    names: Vec<String>,
}

/// Makes the reports that this very program has not made yet; when all are there, copies their files and fills the pages.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    if !Path::new("mpm-core/Cargo.toml").is_file() {
        return Err(Failure::BadInput("publish: expected to be run in the root of the source".to_owned()));
    }
    Made::here().publishable("publish").map_err(Failure::bad_input)?;
    let is_asked = |report: &&Report| options.names.is_empty() || options.names.iter().any(|name| name == report.name);
    for report in PUBLISHED.iter().filter(is_asked) {
        let folder = Path::new(MADE).join(report.name);
        let clock = Instant::now();
        if report.check(&folder).is_ok_and(|made| made == Made::here()) {
            common.say(&format!("{:<20} made before", report.name));
            continue;
        }
        report.make(&folder)?;
        report.check(&folder).map_err(Failure::run_failed)?;
        common.say(&format!("{:<20} {}", report.name, time(clock.elapsed().as_secs_f64())));
    }
    let target = common.out.clone().unwrap_or_else(|| PathBuf::from(TARGET));
    let mut copied = Vec::new();
    for report in PUBLISHED.iter().filter(is_asked) {
        let to = target.join(report.name);
        copy(&Path::new(MADE).join(report.name), &to, report.files)?;
        common.say(&format!("published: {}", to.display()));
        copied.extend(report.files.split_whitespace().map(|file| to.join(file)));
    }
    if common.out.is_none() {
        copied.extend(fill(Path::new("."))?);
    }
    common.json(&copied);
    Ok(())
}

/// Writes the numbers of the pages of a repository anew. Returns the pages that have changed.
fn fill(root: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut changed = Vec::new();
    for page in stored::pages() {
        let path = root.join(page);
        let text = fs::read_to_string(&path).map_err(Failure::unwritable(&path))?;
        let filled = stored::filled(&text, &root.join(TARGET)).map_err(Failure::run_failed)?;
        if filled != text {
            fs::write(&path, filled).map_err(Failure::unwritable(&path))?;
            changed.push(path);
        }
    }
    Ok(changed)
}

impl Report {
    /// Runs the commands that make the report. One that judges may judge that something is not met: that is a result.
    fn make(&self, folder: &Path) -> Result<(), Failure> {
        let _ = fs::remove_dir_all(folder);
        for arguments in self.made_by {
            let (program, arguments) = match arguments.split_first() {
                Some((&"mpm-bench", rest)) => {
                    let bench = ["run", "--release", "--locked", "--quiet", "-p", "mpm-bench", "--"];
                    (std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()), [&bench, rest].concat())
                }
                _ => (std::env::current_exe().map_err(Failure::run_failed)?.into_os_string(), arguments.to_vec()),
            };
            let mut command = Command::new(program);
            let command = command.args(arguments).arg("--quiet").arg("--out").arg(folder).stdin(Stdio::null());
            let status = command.status().map_err(Failure::run_failed)?;
            if !status.success() && status.code() != Some(1) {
                return Err(Failure::run_failed(format!("{}: {status}", self.made_by.concat().join(" "))));
            }
        }
        Ok(())
    }

    /// The program that made the report in a folder. Refuses one that lacks a file, and one of a program that nobody could build again.
    fn check(&self, folder: &Path) -> Result<Made, Error> {
        let name = folder.display().to_string();
        if let Some(missing) = self.files.split_whitespace().find(|file| !folder.join(file).is_file()) {
            let expected = format!("all files that are published, {missing} among them");
            return Err(Error::refused(name, expected, "no such file"));
        }
        let path = folder.join(record(self.files));
        let text = read_text(&path, LARGEST).map_err(Error::at(&path))?;
        let made: Made = serde_json::from_str(&text).map_err(Error::at(&path))?;
        made.publishable(&name)?;
        Ok(made)
    }
}

/// A Markdown text without links to what is not published: of a picture its vector form is shown, of another file only the name.
fn linked(text: &str, files: &[&str]) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, (target, after))) = rest.split_once("](").and_then(|(a, b)| Some((a, b.split_once(')')?))) {
        let (ahead, name) = before.rsplit_once('[').unwrap_or((before, ""));
        let vector = target.replace(".png", ".svg");
        let is_there = |target: &str| target.contains(':') || target.starts_with('#') || files.contains(&target);
        out += &match target {
            _ if is_there(target) => format!("{before}]({target})"),
            _ if ahead.ends_with('!') && is_there(&vector) => format!("{before}]({vector})"),
            _ => format!("{}{name}", ahead.trim_end_matches('!')),
        };
        rest = after;
    }
    out + rest
}

/// Which of the files of a report says from which commit it is.
fn record(files: &str) -> &'static str {
    if files.split_whitespace().any(|file| file == RECORD) { RECORD } else { "manifest.json" }
}

/// Copies the files of a report in place of those that were published before.
fn copy(report: &Path, to: &Path, files: &str) -> Result<(), Failure> {
    let refused = |e: FolderError| Failure::BadInput(format!("--out: {e}"));
    let folder = Folder::take(to).map_err(refused)?;
    let files: Vec<&str> = files.split_whitespace().collect();
    folder.has_room_for(&files).map_err(refused)?;
    for file in &files {
        let staged = folder.stage().join(file);
        staged.parent().map_or(Ok(()), make_folder)?;
        if file.ends_with(".md") {
            let text = fs::read_to_string(report.join(file)).map_err(Failure::unwritable(&staged))?;
            fs::write(&staged, linked(&text, &files)).map_err(Failure::unwritable(&staged))?;
        } else {
            fs::copy(report.join(file), &staged).map_err(Failure::unwritable(&staged))?;
        }
    }
    folder.publish().map_err(Failure::run_failed)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use mpm_verify::files::RECORD as RESULTS;
    use serde_json::Value;

    use super::*;

    const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

    fn made(commit: &str, profile: &str) -> Made {
        Made { commit: commit.to_owned(), sources: "0123456789abcdef".to_owned(), profile: profile.to_owned() }
    }

    /// A report with these files, written by a program.
    fn report(folder: &Path, files: &str, made: &Made) {
        for file in files.split_whitespace().filter(|file| *file != RECORD) {
            let path = folder.join(file);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, format!("{file} of {}", made.commit)).expect("written");
        }
        fs::write(folder.join(RECORD), serde_json::to_string(made).expect("text")).expect("written");
    }

    #[test]
    fn a_report_is_published_whole_and_replaces_the_one_before() {
        let root = tempfile::tempdir().expect("a folder");
        let (from, to) = (root.path().join("levee"), root.path().join("published/levee"));
        report(&from, "a.csv plots/b.png report.json", &made("0123456789ab", "release"));
        copy(&from, &to, "a.csv plots/b.png report.json").expect("published");
        assert_eq!(fs::read_to_string(to.join("plots/b.png")).expect("a file"), "plots/b.png of 0123456789ab");
        report(&from, "a.csv report.json", &made("ba9876543210", "release"));
        copy(&from, &to, "a.csv report.json").expect("published");
        assert_eq!(fs::read_to_string(to.join("a.csv")).expect("a file"), "a.csv of ba9876543210");
        assert!(!to.join("plots").exists(), "a file that is published no more");
        // What is not of this program stays.
        fs::write(to.join("c.csv"), "theirs").expect("written");
        let error = copy(&from, &to, "a.csv c.csv").expect_err("refused");
        assert!(error.code() == 2 && error.to_string().contains("c.csv"), "{error}");
    }

    /// Markdown that is committed links to nothing that is not.
    #[test]
    fn links_lead_to_what_is_published() {
        let text = "![A](a.png) [csv](a.csv) [png](a.png) [page](index.html) [far](https://b.c) [here](#d)";
        let linked = |files: &[&str]| linked(text, files);
        assert_eq!(linked(&["a.png", "a.csv", "index.html"]), text);
        assert_eq!(linked(&["a.svg", "a.csv"]), "![A](a.svg) [csv](a.csv) png page [far](https://b.c) [here](#d)");
    }

    #[test]
    fn only_whole_reports_of_a_commit_in_release_are_published() {
        let root = tempfile::tempdir().expect("a folder");
        let checked = |files| Report { name: "a", files, made_by: &[] }.check(root.path());
        for (commit, profile, words) in [
            ("0123456789ab", "release", ""),
            ("0123456789ab", "debug", "found the profile debug"),
            ("0123456789ab-dirty", "release", "found the commit 0123456789ab-dirty"),
            ("unknown", "release", "found the commit unknown"),
            ("", "release", "found the commit unknown"),
        ] {
            report(root.path(), "a.csv report.json", &made(commit, profile));
            let said = checked("a.csv report.json").map_or_else(|e| e.to_string(), |_| String::new());
            assert!(said.is_empty() == words.is_empty() && said.ends_with(words), "{commit}: {said}");
        }
        let error = checked("a.csv b.csv report.json").expect_err("refused").to_string();
        assert!(error.contains("b.csv among them"), "{error}");
    }

    /// A fresh clone publishes over what is committed: the list of results names each file, and `PUBLISHED` no others.
    #[test]
    fn what_is_committed_is_what_is_published() {
        let folder = Path::new(ROOT).join(TARGET);
        for Report { name, files, .. } in PUBLISHED {
            let results = fs::read_to_string(folder.join(name).join(RESULTS)).expect("a list of results");
            let results: BTreeSet<&str> = results.lines().skip(1).collect();
            assert!(results.iter().all(|file| folder.join(name).join(file).is_file()), "{name}");
            assert_eq!(results, files.split_whitespace().collect(), "{name}");
        }
        let names = fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
        assert_eq!(names.count(), PUBLISHED.len());
    }

    /// Values of a key anywhere in a record.
    fn values<'v>(value: &'v Value, key: &str, found: &mut Vec<&'v str>) {
        match value {
            Value::Object(map) => map.iter().for_each(|(name, value)| match value {
                Value::String(text) if name == key => found.push(text),
                _ => values(value, key, found),
            }),
            Value::Array(list) => list.iter().for_each(|value| values(value, key, found)),
            _ => {}
        }
    }

    /// All that is published is of one clean commit in release, but for the scores of other codes.
    #[test]
    fn published_reports_are_of_one_commit() {
        let folder = Path::new(ROOT).join(TARGET);
        let mut all: Option<Made> = None;
        for report in &PUBLISHED {
            let made = report.check(&folder.join(report.name)).unwrap_or_else(|e| panic!("{e}"));
            let one = all.get_or_insert_with(|| made.clone());
            assert_eq!(*one, made, "{}", report.name);
            for file in
                report.files.split_whitespace().filter(|file| file.ends_with(".json") && !file.starts_with("scores/"))
            {
                let text = fs::read_to_string(folder.join(report.name).join(file)).expect("a file");
                let value: Value = serde_json::from_str(&text).expect("JSON");
                for (key, wanted) in [("commit", &one.commit), ("sources", &one.sources), ("profile", &one.profile)] {
                    let mut found = Vec::new();
                    values(&value, key, &mut found);
                    assert!(found.iter().all(|found| found == wanted), "{}/{file}: {key}: {found:?}", report.name);
                }
            }
        }
    }

    /// No number of the README or the guide that is measured here is typed: each is what the published files have. `UPDATE_PAGES=1`
    /// writes them anew.
    #[test]
    fn numbers_of_the_pages_are_those_of_the_published_reports() {
        let root = Path::new(ROOT);
        if std::env::var_os("UPDATE_PAGES").is_some() {
            fill(root).expect("filled");
        }
        for page in stored::pages() {
            let text = fs::read_to_string(root.join(&page)).expect("a page");
            let filled = stored::filled(&text, &root.join(TARGET)).unwrap_or_else(|e| panic!("{page}: {e}"));
            let apart = text.lines().zip(filled.lines()).find(|(typed, stored)| typed != stored);
            assert!(text == filled, "{page}: expected what publish writes, {apart:?}");
        }
    }
}

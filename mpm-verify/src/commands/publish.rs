//! `publish`: copies what the README and the guide show from the folders of finished runs, which git ignores, to those that it tracks.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;
use mpm_core::scene::read_text;
use mpm_verify::error::Error;
use mpm_verify::files::{Folder, FolderError};
use mpm_verify::page::site::RECORD;
use mpm_verify::provenance::require_clean;
use serde::Deserialize;

use super::{Failure, make_folder};
use crate::Common;

/// Reports that are published, and the files of each: pictures and tables that the README and the guide show, and what these are
/// made of.
const PUBLISHED: [(&str, &str); 7] = [
    (
        "accuracy",
        "budget.csv claims.csv claims_integrators.csv consolidation.csv cost.csv displaced.csv errors.csv grid_shift.csv \
         manifest.json orders.csv plots/consolidation.csv plots/consolidation.svg plots/crossings.csv plots/crossings.svg \
         plots/displaced.csv plots/displaced.svg plots/energy.csv plots/energy.svg plots/error-against-factorisations.csv \
         plots/error-against-factorisations.svg plots/error-against-steps.csv plots/error-against-steps.svg \
         plots/error-against-time-particles.csv plots/error-against-time-particles.svg plots/error-against-time-surface.csv \
         plots/error-against-time-surface.svg plots/error-budget-late.csv plots/error-budget-late.svg plots/error-budget.csv \
         plots/error-budget.svg plots/error-of-all-schemes.csv plots/error-of-all-schemes.svg plots/grid-shift.csv \
         plots/grid-shift.svg plots/isochrones-bspline2.csv plots/isochrones-bspline2.svg plots/isochrones.csv \
         plots/isochrones.svg plots/max-error-against-mesh-compressible.csv plots/max-error-against-mesh-compressible.svg \
         plots/max-error-against-mesh-terzaghi.csv plots/max-error-against-mesh-terzaghi.png \
         plots/max-error-against-mesh-terzaghi.svg plots/mesh.csv plots/mesh.svg plots/profile-error-against-mesh.csv \
         plots/profile-error-against-mesh.svg plots/profile-error-of-all-schemes.csv plots/profile-error-of-all-schemes.svg \
         report.json report.md time_error.csv",
    ),
    ("dam", "map-water.csv map-water.png map-water_lines.csv report.json summary.json water.csv"),
    (
        "leaderboard",
        "leaderboard.csv plots/solved-against-cpu.svg report.json scores/finite-volumes.json scores/kratos-geo.json \
         scores/kratos-mpm.json scores/mpm-verify.json scores/opengeosys.json scores/student-mpm.json scores/toy.json",
    ),
    (
        "levee",
        "claims.csv ensemble.csv events.csv levee.png plots/levee-failure.png plots/levee-probability.png \
         plots/levee-safety.png probability.csv report.json safety_factor.csv sensitivity.csv summary.json",
    ),
    ("prove", "manifest.json prove.csv"),
    ("slopes", "report.json slopes.csv"),
    (
        "speed-against-error",
        "cheapest.csv growth.csv kernel.json kernel_limits.csv kernel_sizes.csv kernel_stages.csv manifest.json \
         plane_solves.csv plots/cpu-against-mesh.csv plots/cpu-against-mesh.svg plots/error-against-cpu-by-scheme.csv \
         plots/error-against-cpu-by-scheme.svg plots/error-against-cpu.csv plots/error-against-cpu.png \
         plots/error-against-cpu.svg plots/error-against-particles.csv plots/error-against-particles.svg \
         plots/error-against-steps.csv plots/error-against-steps.svg plots/kernel-cost-against-points.csv \
         plots/kernel-cost-against-points.svg report.json report.md speed_against_error.csv",
    ),
];

/// Folder of the reports of finished runs.
const REPORTS: &str = "reports";
/// Folder of the published files, in one of the same name for each report.
const TARGET: &str = "reports/published";
/// Largest record of a report, bytes.
const LARGEST: u64 = 1 << 20;

/// Which reports.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Reports to publish; without a name all that have been run
    #[arg(value_name = "NAME", value_parser = PossibleValuesParser::new(PUBLISHED.map(|(name, _)| name)))]
    names: Vec<String>,
}

/// Publishes reports: all are checked before a file of one is copied.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let mut reports = PUBLISHED.to_vec();
    reports.retain(|(name, files)| match &options.names[..] {
        [] => Path::new(REPORTS).join(name).join(record(files)).is_file(),
        names => names.iter().any(|asked| asked == name),
    });
    if reports.is_empty() {
        let names = PUBLISHED.map(|(name, _)| name).join(", ");
        return Err(Failure::bad_input(Error::refused(REPORTS, format!("a finished run of {names}"), "none")));
    }
    for (name, files) in &reports {
        check(&Path::new(REPORTS).join(name), files).map_err(Failure::bad_input)?;
    }
    let target = common.out.clone().unwrap_or_else(|| PathBuf::from(TARGET));
    let mut copied = Vec::new();
    for (name, files) in &reports {
        let to = target.join(name);
        copy(&Path::new(REPORTS).join(name), &to, files)?;
        common.say(&format!("published: {}", to.display()));
        copied.extend(files.split_whitespace().map(|file| to.join(file)));
    }
    common.json(&copied);
    Ok(())
}

/// Refuses a report of a program that is not that of a commit, and one that lacks a file.
fn check(report: &Path, files: &str) -> Result<(), Error> {
    let name = report.display().to_string();
    if let Some(missing) = files.split_whitespace().find(|file| !report.join(file).is_file()) {
        return Err(Error::refused(
            name,
            format!("all files that are published, {missing} among them"),
            "no such file",
        ));
    }
    let path = report.join(record(files));
    let text = read_text(&path, LARGEST).map_err(Error::at(&path))?;
    let record: Record = serde_json::from_str(&text).map_err(Error::at(&path))?;
    require_clean(&name, &record.commit)
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

/// What that file says of it.
#[derive(Deserialize)]
struct Record {
    #[serde(default)]
    commit: String,
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

    use super::*;

    /// A report with these files, written by the program of a commit.
    fn report(folder: &Path, files: &str, commit: &str) {
        for file in files.split_whitespace().filter(|file| *file != RECORD) {
            let path = folder.join(file);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, format!("{file} of {commit}")).expect("written");
        }
        let record = format!("{{\"kind\": \"slopes\", \"commit\": \"{commit}\"}}");
        fs::write(folder.join(RECORD), record).expect("written");
    }

    #[test]
    fn a_report_is_published_whole_and_replaces_the_one_before() {
        let root = tempfile::tempdir().expect("a folder");
        let (from, to) = (root.path().join("levee"), root.path().join("published/levee"));
        report(&from, "a.csv plots/b.png report.json", "0123456789ab");
        copy(&from, &to, "a.csv plots/b.png report.json").expect("published");
        assert_eq!(fs::read_to_string(to.join("plots/b.png")).expect("a file"), "plots/b.png of 0123456789ab");
        report(&from, "a.csv report.json", "ba9876543210");
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
        for (name, files) in PUBLISHED {
            let files: Vec<&str> = files.split_whitespace().collect();
            for file in files.iter().filter(|file| file.ends_with(".md")) {
                let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(TARGET).join(name).join(file);
                let text = fs::read_to_string(path).expect("a page");
                assert!(super::linked(&text, &files) == text, "{name}/{file}: links to what is not published");
            }
        }
    }

    #[test]
    fn only_whole_reports_of_a_commit_are_published() {
        let root = tempfile::tempdir().expect("a folder");
        let files = "a.csv report.json";
        for (commit, words) in [
            ("0123456789ab", ""),
            ("0123456789ab-dirty", "found the commit 0123456789ab-dirty"),
            ("unknown", "found the commit unknown"),
            ("", "found the commit unknown"),
        ] {
            report(root.path(), files, commit);
            let said = check(root.path(), files).map_or_else(|e| e.to_string(), |()| String::new());
            assert!(said.is_empty() == words.is_empty() && said.ends_with(words), "{commit}: {said}");
        }
        let error = check(root.path(), "a.csv b.csv report.json").expect_err("refused").to_string();
        assert!(error.contains("b.csv among them"), "{error}");
    }

    /// A fresh clone publishes over what is committed: the list of results names each file, and `PUBLISHED` no others.
    #[test]
    fn what_is_committed_is_what_is_published() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(TARGET);
        for (name, files) in PUBLISHED {
            let mut known = files.split_whitespace().collect::<BTreeSet<_>>();
            let results = fs::read_to_string(folder.join(name).join(RESULTS)).expect("a list of results");
            let results: BTreeSet<&str> = results.lines().skip(1).collect();
            assert!(results.iter().all(|file| folder.join(name).join(file).is_file()), "{name}");
            // Reports of versions before have no record beside them.
            if !results.contains(RECORD) {
                known.remove(RECORD);
            }
            assert_eq!(results, known, "{name}");
        }
        let names = fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
        assert_eq!(names.count(), PUBLISHED.len());
    }
}

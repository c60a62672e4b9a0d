//! Studies in shares: shares that are merged make the same report, a stop keeps the finished cases, a folder has one run at a time.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};

use crate::program::{self, met, stderr};

/// Some dozens of cases, less than a second each, without anything that differs from run to run.
const STUDY: [&str; 8] = [
    "study",
    "--integrator",
    "semi-implicit,quasi-static",
    "--mesh",
    "0.1,0.05",
    "--no-sweeps",
    "--no-times",
    "--quiet",
];

fn start(out: &Path, more: &[&str]) -> Child {
    program::start(Path::new("."), &[more, &["--out", out.to_str().expect("a path")]].concat())
}

fn run(out: &Path, more: &[&str]) -> Output {
    start(out, more).wait_with_output().expect("an end")
}

fn succeeds(out: &Path, more: &[&str]) {
    let output = run(out, more);
    assert!(output.status.success(), "{more:?}: {}", stderr(&output));
}

/// Waits for the first finished case of a study that writes to a folder.
fn first_case(child: &mut Child, out: &Path) {
    let cases = || fs::read_dir(out.join("cases")).map_or(0, |files| files.flatten().count());
    assert!(met(child, || cases() > 0), "it ended");
}

/// Every file below a folder and its bytes, but for locks.
fn tree(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let (mut files, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).expect("a folder") {
            let path = entry.expect("an entry").path();
            let name = path.strip_prefix(folder).expect("below").to_owned();
            if path.is_dir() {
                folders.push(path);
            } else if !path.ends_with(".lock") {
                files.push((name, fs::read(&path).expect("a file")));
            }
        }
    }
    files.sort();
    files
}

fn same(one: &Path, other: &Path) {
    let (one, other) = (tree(one), tree(other));
    let names = |tree: &[(PathBuf, Vec<u8>)]| tree.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&one), names(&other));
    for ((name, one), (_, other)) in one.iter().zip(&other) {
        assert!(one == other, "{} differs", name.display());
    }
    assert!(one.len() > 30, "{} files", one.len());
}

#[test]
fn shares_that_are_merged_make_the_report_of_the_whole() {
    let root = tempfile::tempdir().expect("a folder");
    let at = |name: &str| root.path().join(name);
    succeeds(&at("whole/accuracy"), &STUDY);
    let merge =
        ["merge", &at("1").to_string_lossy(), &at("2").to_string_lossy(), &at("3").to_string_lossy()].map(String::from);
    let merge: Vec<&str> = merge.iter().map(String::as_str).chain(["--quiet"]).collect();
    for which in ["1", "2"] {
        succeeds(&at(which), &[&STUDY[..], &["--shard", &format!("{which}/3")]].concat());
    }
    let output = run(&at("merged/accuracy"), &merge[..3]);
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(3), "{error}");
    assert!(error.contains("missing: ") && error.contains("--shard 3/3, and merge again"), "{error}");
    // One that is killed and resumed, as a batch system does.
    let mut third = start(&at("3"), &[&STUDY[..], &["--shard", "3/3", "--jobs", "1"]].concat());
    first_case(&mut third, &at("3"));
    third.kill().expect("killed");
    third.wait().expect("an end");
    succeeds(&at("3"), &[&STUDY[..], &["--shard", "3/3", "--resume"]].concat());
    succeeds(&at("merged/accuracy"), &merge);
    same(&at("whole"), &at("merged"));
    // A share of another study is none of this one.
    succeeds(&at("4"), &[&STUDY[..], &["--ppc", "4", "--shard", "3/3"]].concat());
    let other = run(&at("other"), &["merge", &at("1").to_string_lossy(), &at("4").to_string_lossy()]);
    assert_eq!(other.status.code(), Some(2));
    assert!(stderr(&other).contains("expected a share of the study in"));
}

#[test]
fn the_list_of_cases_is_that_of_the_shares() {
    let root = tempfile::tempdir().expect("a folder");
    let output = run(&root.path().join("none"), &[&STUDY[..], &["--list-cases", "--json"]].concat());
    let listed: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a list");
    let listed = listed.as_array().expect("a list");
    let names: Vec<&str> = listed.iter().filter_map(|one| one["case"].as_str()).collect();
    assert_eq!(names.len(), listed.len());
    assert!(!root.path().join("none").exists(), "nothing is run or written");
    succeeds(&root.path().join("5"), &[&STUDY[..], &["--shard", "5/7"]].concat());
    let own: Vec<String> = names.iter().skip(4).step_by(7).map(|name| format!("{name}.json")).collect();
    let mut found: Vec<String> =
        tree(&root.path().join("5/cases")).into_iter().map(|(name, _)| name.display().to_string()).collect();
    let mut expected = own;
    expected.sort();
    found.sort();
    assert_eq!(found, expected);
}

#[cfg(unix)]
#[test]
fn a_study_that_is_interrupted_keeps_what_is_done_and_goes_on() {
    let root = tempfile::tempdir().expect("a folder");
    let at = |name: &str| root.path().join(name);
    succeeds(&at("whole/accuracy"), &STUDY);
    let one_by_one = [&STUDY[..], &["--jobs", "1"]].concat();
    let mut child = start(&at("in-two/accuracy"), &one_by_one);
    first_case(&mut child, &at("in-two/accuracy"));
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().expect("a signal").success());
    let output = child.wait_with_output().expect("an end");
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(3), "{error}");
    assert!(error.contains(" cases are done; missing: ") && error.contains("--jobs 1 --out"), "{error}");
    assert!(error.trim_end().ends_with("--resume"), "{error}");
    assert!(!at("in-two/accuracy/errors.csv").exists(), "no report of a part");
    let done = tree(&at("in-two/accuracy/cases")).len();
    assert!(done > 0, "{error}");
    succeeds(&at("in-two/accuracy"), &[&one_by_one[..], &["--resume"]].concat());
    same(&at("whole"), &at("in-two"));
}

#[test]
fn two_runs_into_one_folder_are_refused() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("accuracy");
    let mut first = start(&out, &["study", "--integrator", "explicit", "--mesh", "0.01", "--quiet", "--no-cost"]);
    assert!(met(&mut first, || out.join("cases").exists()), "it ended");
    for second in [&STUDY[..], &["check", "hydrostatic", "--quiet"], &["levee", "--quiet"]] {
        let output = run(&out, second);
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains("no other run is writing to"), "{error}");
    }
    first.kill().expect("killed");
    first.wait().expect("an end");
    succeeds(&out, &STUDY);
}

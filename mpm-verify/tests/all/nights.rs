//! The nightly run from the command line: a part of it, accepted baselines, numbers that moved, and what is refused.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::program::{stderr as error, verify};

fn nightly(folder: &Path, arguments: &[&str]) -> Output {
    verify(folder, &[&["nightly"], arguments].concat())
}

fn summary(night: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(night.join("summary.json")).expect("a summary")).expect("JSON")
}

/// The last nightly run in a folder.
fn night(folder: &Path) -> std::path::PathBuf {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut nights: Vec<_> = entries.filter(|path| path.join("summary.json").exists()).collect();
    nights.sort();
    nights.pop().expect("a night")
}

/// Lets a nightly run be one of a commit, whatever the sources of this test are.
fn of_commit(night: &Path, commit: &str) {
    let mut summary = summary(night);
    summary["commit"] = commit.into();
    fs::write(night.join("summary.json"), summary.to_string()).expect("written");
}

#[test]
fn a_nightly_run_is_accepted_and_numbers_that_move_are_reported() {
    let root = tempfile::tempdir().expect("a folder");
    let baselines = root.path().join("reference-data/baselines");
    fs::create_dir_all(&baselines).expect("a folder");
    let file = baselines.join("accepted.csv");
    fs::write(&file, "case,quantity,label,value,relative,absolute,since,why\n").expect("written");
    let work = ["--only", "work", "--no-instructions", "--quiet", "--out", "one"];
    // Without baselines every number is new.
    let first = nightly(root.path(), &work);
    assert_eq!(first.status.code(), Some(1), "{}", error(&first));
    assert!(
        error(&first).starts_with("MOVED: ") && error(&first).contains("work-krylov solves new"),
        "{}",
        error(&first)
    );
    let one = night(&root.path().join("one"));
    assert!(!root.path().join("one/history.csv").exists(), "a part is not recorded");
    let from = one.to_string_lossy().into_owned();
    of_commit(&one, "0123456789ab-dirty");
    let refused = nightly(root.path(), &["--accept", "a test", "--from", &from]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(error(&refused).ends_with("found the commit 0123456789ab-dirty\n"), "{}", error(&refused));
    of_commit(&one, "0123456789ab");
    let accepted = nightly(root.path(), &["--accept", "a test", "--from", &from]);
    assert!(accepted.status.success(), "{}", error(&accepted));
    let text = fs::read_to_string(&file).expect("a table");
    assert!(text.starts_with("# What `mpm-verify nightly`") && text.contains(",a test\n"), "{text}");
    let second = nightly(root.path(), &[&work[..5], &["two"]].concat());
    assert!(second.status.success(), "an unchanged program passes: {}", error(&second));
    assert_eq!(summary(&night(&root.path().join("two")))["verdict"], "unchanged");
    // A count that is off by one, and an obsolete one.
    let line = text.lines().find(|line| line.starts_with("work-explicit-column,steps,")).expect("a count");
    let value = line.split(',').nth(3).expect("a value");
    let more = format!("{:?}", value.parse::<f64>().expect("a number") + 1.0);
    let other = text.replace(line, &line.replacen(value, &more, 1)) + "work-gone,steps,count,1.0,0.0,0.0,d c,w\n";
    fs::write(&file, other).expect("written");
    let third = nightly(root.path(), &[&work[..5], &["three"]].concat());
    assert_eq!(third.status.code(), Some(1));
    let moved = summary(&night(&root.path().join("three")))["moved"].clone();
    let names: Vec<&str> = moved.as_array().expect("a list").iter().filter_map(|m| m["case"].as_str()).collect();
    assert_eq!(names, ["work-explicit-column"], "numbers of other parts are not obsolete");
    assert_eq!(moved[0]["direction"], "better");
    assert!(error(&third).contains("work-explicit-column steps better: was"), "{}", error(&third));
    // Accepting a part of a night leaves what the other parts would have measured.
    let three = night(&root.path().join("three"));
    of_commit(&three, "0123456789ab");
    let from = three.to_string_lossy().into_owned();
    let part = nightly(root.path(), &["--accept", "a part", "--from", &from]);
    assert!(part.status.success(), "{}", error(&part));
    let text = fs::read_to_string(&file).expect("a table");
    assert!(text.contains("work-gone,steps,count") && text.matches(",a part\n").count() == 1, "{text}");
}

#[test]
fn what_cannot_be_accepted_is_refused() {
    let root = tempfile::tempdir().expect("a folder");
    let baselines = root.path().join("reference-data/baselines");
    fs::create_dir_all(&baselines).expect("a folder");
    fs::write(baselines.join("accepted.csv"), "case,quantity,label,value,relative,absolute,since,why\n")
        .expect("written");
    for (arguments, words) in [
        (&["--accept", " "][..], "--accept: expected a reason"),
        (&["--accept", "why", "--from", "nowhere"], "nowhere"),
        (&["--from", "nowhere"], "--accept <WHY>"),
        (&["--only", "nothing"], "possible values: study, suite, stability, levee, metamorphic, work, instructions"),
        (&["--baselines", "nowhere"], "nowhere"),
    ] {
        let output = nightly(root.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", error(&output));
        assert!(error(&output).contains(words), "{arguments:?}: {}", error(&output));
    }
    fs::write(root.path().join("accepted.csv"), "case,quantity\na,b\n").expect("written");
    let output = nightly(root.path(), &["--baselines", "."]);
    assert_eq!(output.status.code(), Some(2));
    assert!(error(&output).contains("accepted.csv:2: expected case,quantity,label"), "{}", error(&output));
}

/// A folder with a program `valgrind` that says of every run that it has an instruction unknown to it.
#[cfg(target_os = "linux")]
fn without_instructions(root: &Path) -> std::path::PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let folder = root.join("programs");
    fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("valgrind");
    let text = "#!/bin/sh\nfor word; do case $word in\n--version) echo valgrind-0; exit;;\n\
                --callgrind-out-file=*nothing.callgrind) echo 'totals: 1' > \"${word#*=}\"; exit;;\nesac; done\n\
                echo 'Illegal opcode' >&2\nexit 1\n";
    fs::write(&path, text).expect("written");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("a program");
    folder
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn a_part_that_measured_nothing_fails_the_run() {
    let root = tempfile::tempdir().expect("a folder");
    let programs = without_instructions(root.path());
    let with_path = |path: &Path, out: &str| {
        let mut command = std::process::Command::new(crate::program::PROGRAM);
        command.args(["nightly", "--only", "instructions", "--quiet", "--out", out]);
        command.env("PATH", path).current_dir(root.path()).output().expect("a run")
    };
    let failed = with_path(&programs, "one");
    assert_eq!(failed.status.code(), Some(1), "{}", error(&failed));
    assert!(error(&failed).contains("failed: instructions: no numbers were measured"), "{}", error(&failed));
    assert_eq!(summary(&night(&root.path().join("one")))["parts"][0]["finish"], "failed");
    // Without valgrind the part is not run, which is not a pass of the run if there is no other.
    let lacks = with_path(root.path(), "two");
    assert_eq!(lacks.status.code(), Some(1), "{}", error(&lacks));
    assert!(error(&lacks).contains("failed: no part could be run"), "{}", error(&lacks));
    assert_eq!(summary(&night(&root.path().join("two")))["parts"][0]["finish"], "not-run");
}

#[test]
fn the_help_names_what_is_run() {
    use mpm_verify::nightly::part::Part;
    let root = tempfile::tempdir().expect("a folder");
    let output = nightly(root.path(), &["--help"]);
    let text = String::from_utf8_lossy(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    for part in Part::ALL {
        assert!(text.contains(&part.what()) && text.contains(part.name()), "{part:?}: {text}");
    }
    let guide = fs::read_to_string(format!("{}/mpm-verify/docs/commands.md", crate::program::ROOT)).expect("a page");
    let row = guide.lines().find(|line| line.contains("`mpm-verify nightly`")).expect("a row").to_lowercase();
    assert!(row.contains(&Part::list()), "{row}\n{}", Part::list());
}

//! The program among other programs: folders that hold more than its results, pipes, full disks, signals, sizes without sense.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use mpm_verify::provenance;

use crate::program::{PROGRAM, ROOT, changed, met, run, scene, start, stderr, verify};

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .expect("a folder")
        .map(|e| e.expect("an entry").file_name().to_string_lossy().into())
        .collect();
    names.sort();
    names
}

/// An end in time, or none.
fn ends(mut child: Child, patience: Duration) -> Option<Output> {
    let clock = Instant::now();
    while child.try_wait().expect("a process").is_none() {
        if clock.elapsed() > patience {
            child.kill().expect("killed");
            child.wait().expect("an end");
            return None;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Some(child.wait_with_output().expect("an end"))
}

#[test]
fn results_of_a_run_are_those_of_that_run_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join("out").join(name);
    fs::create_dir_all(at(".part")).expect("a folder");
    let theirs = [".part/theirs", "notes.txt", "checkpoint.bin.part"];
    for name in theirs {
        fs::write(at(name), "theirs").expect("written");
    }
    let solve = |name: &str| verify(folder.path(), &["solve", &scene(name), "--out", "out"]);
    for (name, more) in [("dam.toml", true), ("terzaghi-quasi-static.toml", false), ("dry-bar.toml", false)] {
        let output = solve(name);
        assert!(output.status.success(), "{name}: {}", stderr(&output));
        assert!(at("history.csv").exists() && at("water.csv").exists() == more, "{name}: {:?}", names(&at("")));
        assert!(theirs.iter().all(|name| at(name).exists()), "{name}: {:?}", names(&at("")));
    }
    let output = verify(folder.path(), &["check", "dry-bar", "--out", "out"]);
    assert!(output.status.success() && at("cases.csv").exists() && !at("history.csv").exists(), "{}", stderr(&output));
    assert!(theirs.iter().all(|name| at(name).exists()));
}

#[test]
fn files_of_others_are_left_and_no_page_is_announced() {
    let folder = tempfile::tempdir().expect("a folder");
    let solve = |out: &str| verify(folder.path(), &["solve", &scene("dry-bar.toml"), "--out", out]);
    let refused = |out: &str, words: &str| {
        let output = solve(out);
        let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), stderr(&output));
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(words) && !said.contains("page: "), "{said}");
    };
    for (out, name) in [("1", "history.csv"), ("2", "checkpoint.bin"), ("3", "summary.json")] {
        let path = folder.path().join(out).join(name);
        fs::create_dir_all(&path).expect("a folder");
        refused(out, name);
        fs::remove_dir(&path).expect("still empty");
        fs::write(&path, "theirs").expect("written");
        refused(out, name);
        assert_eq!(fs::read_to_string(&path).expect("a file"), "theirs");
        fs::remove_file(&path).expect("removed");
        assert!(solve(out).status.success());
    }
    refused("/", "root of the file system");
    // A page of someone else's above the folder of a study; cases of someone else's in it.
    fs::write(folder.path().join("index.html"), "theirs").expect("written");
    let study = "study --mesh 0.1 --ppc 1 --quiet --no-cost --no-sweeps --no-budget --integrator quasi-static --out";
    let study = |out: &str| verify(folder.path(), &[study.split(' ').collect::<Vec<_>>(), vec![out]].concat());
    let output = study("accuracy");
    assert!(output.status.code() == Some(2) && stderr(&output).contains("index.html"), "{}", stderr(&output));
    fs::create_dir_all(folder.path().join("web/accuracy/cases")).expect("a folder");
    let theirs = ["web/accuracy/cases/theirs.json", "web/accuracy/cases/notes.txt"];
    theirs.iter().for_each(|path| fs::write(folder.path().join(path), "theirs").expect("written"));
    for _ in 0..2 {
        let output = study("web/accuracy");
        assert!(output.status.success(), "{}", stderr(&output));
        assert_eq!(names(&folder.path().join("web/accuracy/cases")), ["notes.txt", "theirs.json"]);
    }
}

#[cfg(unix)]
#[test]
fn special_files_are_refused_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe.toml")).status().expect("mkfifo").success());
    let arguments =
        [["solve", "pipe.toml"], ["solve", "/dev/zero"], ["solve", "/dev/tty"], ["solve", "."], ["report", "pipes"]];
    fs::create_dir(folder.path().join("pipes")).expect("a folder");
    assert!(Command::new("mkfifo").arg(folder.path().join("pipes/study.json")).status().expect("mkfifo").success());
    let others: [&[&str]; 4] = [
        &["check", "--scene", "pipe.toml"],
        &["study", "--scene", "pipe.toml"],
        &["levee", "--scene", "pipe.toml"],
        &["merge", "pipes"],
    ];
    assert!(Command::new("mkfifo").arg(folder.path().join("pipes/shard.json")).status().expect("mkfifo").success());
    for arguments in arguments.iter().map(|a| &a[..]).chain(others) {
        let output = ends(start(folder.path(), arguments), Duration::from_secs(20));
        let output = output.unwrap_or_else(|| panic!("{arguments:?} waits for ever"));
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_does_not_arrive_is_a_failure() {
    let folder = tempfile::tempdir().expect("a folder");
    let dry = scene("dry-bar.toml");
    for arguments in [&["list", "--json"][..], &["list"], &["solve", &dry, "--json"], &["check", "undrained", "--json"]]
    {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a full disk");
        let mut command = Command::new(PROGRAM);
        let output = command.args(arguments).current_dir(folder.path()).stdout(full).output().expect("a run");
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains("standard output: No space left"), "{}", stderr(&output));
    }
    // Who reads no further wants no more.
    let mut child = start(folder.path(), &["list", "--json"]);
    drop(child.stdout.take());
    assert_eq!(child.wait_with_output().expect("an end").status.code(), Some(0));
}

#[cfg(unix)]
#[test]
fn a_run_that_is_told_to_end_keeps_its_state() {
    let folder = tempfile::tempdir().expect("a folder");
    let long = changed(folder.path(), "terzaghi.toml", &[("cell = 0.02", "cell = 0.01")]);
    // A process that was started under nohup passes that on, and then no hang-up ends a run.
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|l| u64::from_str_radix(l.strip_prefix("SigIgn:")?.trim(), 16).ok());
    let nohup = ignored.is_some_and(|mask| mask & 1 == 1);
    let told = |signal: &str, prefix: &[&str], out: &str| {
        let solve = [PROGRAM, "solve", long, "--quiet", "--checkpoint-every", "0.1", "--out", out];
        let program = [prefix, &solve].concat();
        let mut command = Command::new(program[0]);
        let command = command.args(&program[1..]).current_dir(folder.path());
        let mut child =
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("a process");
        let checkpoint = folder.path().join(out).join("checkpoint.bin");
        let id = child.id().to_string();
        // Once there is a checkpoint it listens to signals. What is there later has been written later.
        let mut goes_on = || {
            assert!(met(&mut child, || checkpoint.exists()), "it ended");
            fs::remove_file(&checkpoint).expect("removed");
        };
        goes_on();
        let kill = |signal: &str| Command::new("kill").args([signal, &id]).status();
        assert!(kill(signal).expect("a signal").success());
        if !prefix.is_empty() {
            goes_on();
            assert!(kill("-TERM").expect("a signal").success());
        }
        let output = child.wait_with_output().expect("an end");
        assert_eq!(output.status.code(), Some(3), "{signal}: {}", stderr(&output));
        assert!(stderr(&output).contains("to continue: ") && checkpoint.exists(), "{signal}: {}", stderr(&output));
    };
    told("-TERM", &[], "1");
    told("-INT", &[], "2");
    if !nohup {
        told("-HUP", &[], "3");
    }
    if cfg!(target_os = "linux") {
        told("-HUP", &["nohup"], "4");
    }
}

#[test]
fn impossible_sizes_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let column = scene("terzaghi.toml");
    let implicit = scene("terzaghi-quasi-static.toml");
    let refused: [(&[&str], &str); 7] = [
        (&["check", "dry-bar", "--jobs", "100000"], "--jobs"),
        (&["study", "--jobs", "257"], "--jobs"),
        (&["solve", &column, "--jobs=-1"], "--jobs"),
        (&["check", "--scene", &column, "--rows", "10,20,100000000"], "--rows: expected a scene that fits into 16 GiB"),
        (
            &["check", "--scene", &implicit, "--rows", "10,20,10000000"],
            "--rows: expected a scene that fits into 16 GiB",
        ),
        (&["check", "--scene", &column, "--rows", "10,20,18446744073709551615"], "--rows: expected a scene that fits"),
        (&["study", "--mesh", "1e-8"], "expected a scene that fits into 16 GiB"),
    ];
    for (arguments, words) in refused {
        let output = ends(start(folder.path(), arguments), Duration::from_secs(20)).expect("an end");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(words), "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn a_run_of_hours_says_so_before_it_starts_and_then_how_far_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let long = changed(folder.path(), "terzaghi.toml", &[("until.time_factor = 1.0", "until.time_factor = 1.0e6")]);
    let mut quiet = start(folder.path(), &["solve", long, "--quiet", "--checkpoint-every", "0", "--out", "0"]);
    assert!(met(&mut quiet, || folder.path().join("0/checkpoint.bin").exists()), "it runs");
    quiet.kill().expect("killed");
    assert_eq!(stderr(&quiet.wait_with_output().expect("an end")), "");
    let mut child = start(folder.path(), &["solve", long, "--out", "1"]);
    let (clock, mut lines) = (Instant::now(), BufReader::new(child.stderr.take().expect("a pipe")).lines());
    let mut line = || lines.next().expect("a line").expect("text");
    let (first, second) = (line(), line());
    assert!(first.starts_with("terzaghi: this will take about ") && first.contains("--integrator "), "{first}");
    assert!(second.starts_with("terzaghi: ") && second.contains(" %, after "), "{second}");
    assert!(clock.elapsed() >= Duration::from_secs(2), "no progress is reported earlier");
    child.kill().expect("killed");
    child.wait().expect("an end");
    // The integrator that it names does what it says.
    let quicker = first.split("--integrator ").nth(1).and_then(|rest| rest.split(' ').next()).expect("a word");
    let output = verify(folder.path(), &["solve", long, "--integrator", quicker, "--out", "2"]);
    assert!(output.status.success() && !stderr(&output).contains("this will take"), "{}", stderr(&output));
    // Short runs say nothing of that kind.
    let output = verify(folder.path(), &["solve", &scene("dry-bar.toml")]);
    assert!(output.status.success() && stderr(&output).is_empty(), "{}", stderr(&output));
}

#[test]
fn check_reads_the_accepted_errors_that_lie_on_the_disk_and_says_which() {
    let folder = tempfile::tempdir().expect("a folder");
    let check = |more: &[&str]| {
        let output = verify(folder.path(), &[&["check", "dry-bar"], more].concat());
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned() + &stderr(&output))
    };
    let (code, said) = check(&[]);
    assert!(code == Some(0) && said.contains("accepted errors: built in"), "{said}");
    let own = folder.path().join("reference-data/baselines");
    fs::create_dir_all(&own).expect("a folder");
    let text = include_str!("../../../reference-data/baselines/accepted.csv");
    let spoilt = |line: &str| match line.strip_prefix("dry-bar,error,") {
        Some(_) => "dry-bar,error,verified,1e-300,1e-6,1e-300,today,why\n".to_owned(),
        None => line.to_owned() + "\n",
    };
    fs::write(own.join("accepted.csv"), text.lines().map(spoilt).collect::<String>()).expect("written");
    let (code, said) = check(&[]);
    assert!(code == Some(1) && said.contains("reference-data/baselines/accepted.csv"), "{said}");
    let suite = fs::read_to_string(folder.path().join("reports/suite/cases.csv")).expect("a suite");
    assert!(suite.contains("it was 1.000e-300 (baseline)"), "{suite}");
    fs::create_dir(folder.path().join("other")).expect("a folder");
    fs::write(folder.path().join("other/accepted.csv"), text).expect("written");
    let (code, said) = check(&["--baselines", "other"]);
    assert!(code == Some(0) && said.contains("accepted errors: other"), "{said}");
    // What is known to be right is accepted, with its reason.
    let (code, said) = check(&["--accept", " "]);
    assert!(code == Some(2) && said.contains("--accept: expected a reason"), "{said}");
    let (code, said) = check(&["--accept", "a test"]);
    let text = fs::read_to_string(own.join("accepted.csv")).expect("a table");
    // Rows name the commit that measured them: there must be one.
    if provenance::require_clean("--accept", provenance::commit()).is_ok() {
        assert!(said.contains("numbers accepted: reference-data/baselines/accepted.csv"), "{said}");
        assert!(text.contains(",a test\n") && check(&[]).0 == Some(0), "{text}");
    } else {
        assert!(code == Some(2) && said.contains("--accept: expected numbers of a program whose sources"), "{said}");
        assert!(!text.contains(",a test\n"), "{text}");
    }
    for (name, text) in [("none", None), ("bad", Some("case,kind\nx"))] {
        fs::create_dir(folder.path().join(name)).expect("a folder");
        text.iter().for_each(|text| fs::write(folder.path().join(name).join("accepted.csv"), text).expect("written"));
        let (code, said) = check(&["--baselines", name]);
        assert!(code == Some(2) && said.contains(&format!("{name}/accepted.csv")), "{said}");
    }
}

/// Columns of a table, or keys of a record.
fn names_in(file: &Path) -> Option<Vec<String>> {
    let text = fs::read_to_string(file).ok()?;
    if file.extension().is_some_and(|end| end == "csv") {
        return Some(text.lines().next()?.split(',').map(str::to_owned).collect());
    }
    let record: serde_json::Value = serde_json::from_str(&text).ok()?;
    Some(record.as_object()?.keys().cloned().collect())
}

/// What is published has the columns and keys that this program writes.
#[test]
fn published_files_have_the_columns_of_this_program() {
    let folder = tempfile::tempdir().expect("a folder");
    let runs = [
        ("dam", format!("solve {} --quiet --out reports/dam", scene("dam.toml"))),
        ("suite", "check dry-bar --quiet --out reports/suite".to_owned()),
        ("stability", "stability patch --quick --quiet --out reports/stability".to_owned()),
        ("levee", "levee --mesh 0.4 --until 6.2 --no-vtk --quiet --out reports/levee".to_owned()),
        (
            "accuracy",
            "study --mesh 0.1,0.05 --ppc 1 --integrator quasi-static --no-cost --quiet --out reports/accuracy"
                .to_owned(),
        ),
    ];
    let mut compared = 0;
    for (name, line) in runs {
        let output = run(folder.path(), &line);
        assert!(output.status.success(), "{line}: {}", stderr(&output));
        let (own, published) =
            (folder.path().join("reports").join(name), Path::new(ROOT).join("reports/published").join(name));
        for file in names(&published).iter().map(Path::new) {
            if let (Some(own), Some(there)) = (names_in(&own.join(file)), names_in(&published.join(file))) {
                assert_eq!(there, own, "{name}/{}: publish makes it anew", file.display());
                compared += 1;
            }
        }
    }
    assert!(compared > 15, "{compared} files");
}

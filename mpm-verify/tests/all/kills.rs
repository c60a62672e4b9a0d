//! Runs that are killed and resumed end with the same bits: at their start, while a checkpoint is written, after some of them, while
//! checkpoints are written as fast as the disk takes them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};

use mpm_core::random::Random;

use crate::program::{self, PROGRAM, edited, met, stderr};

/// Kills of each job, unless [`ASKED`] asks for another number.
const KILLS: usize = 3;
/// `MPM_KILLS=30 cargo test -p mpm-verify --test all kills::`.
const ASKED: &str = "MPM_KILLS";

/// A run, and what its folder must hold in the end.
struct Job {
    name: &'static str,
    arguments: Vec<String>,
    compared: &'static [&'static str],
}

fn job(name: &'static str, compared: &'static [&'static str], arguments: &[&str]) -> Job {
    Job { name, arguments: arguments.iter().map(|a| (*a).to_owned()).collect(), compared }
}

/// Jobs of each kind of result, long enough to be killed a few times. Resumes of every integrator are tested in the core.
fn jobs(scenes: &Path) -> Vec<Job> {
    let scene = |name: &str, edits: &[(&str, &str)]| {
        let number = fs::read_dir(scenes).expect("a folder").count();
        let path = scenes.join(format!("{number}-{name}.toml"));
        fs::write(&path, edited(&format!("{name}.toml"), edits)).expect("a scene");
        path.to_string_lossy().into_owned()
    };
    let solved = &["history.csv", "profiles.csv"];
    let coarse = ("cell = 0.02", "cell = 0.05");
    vec![
        job("column", solved, &["solve", &scene("terzaghi", &[coarse])]),
        job("sdirk", &["history.csv"], &["solve", &scene("terzaghi-large-strain", &[])]),
        job("dam", &["history.csv", "water.csv", "field.csv"], &["solve", &scene("dam", &[])]),
        job(
            "levee",
            &["history.csv", "paths.csv", "events.csv", "frames.bin"],
            &["levee", "--no-vtk", "--until", "6.4"],
        ),
    ]
}

fn start(job: &Job, out: &Path, more: &[&str]) -> Child {
    let arguments: Vec<&str> = job.arguments.iter().map(String::as_str).collect();
    let more = [&["--quiet", "--checkpoint-every", "0", "--out", out.to_str().expect("a path")], more].concat();
    program::start(Path::new("."), &[arguments, more].concat())
}

fn files(job: &Job, out: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    job.compared.iter().map(|name| (PathBuf::from(name), fs::read(out.join(name)).expect("a file"))).collect()
}

/// Runs a job to its end, killing it some times on the way. Returns the kills that met it alive, of each kind of moment.
fn kill_and_resume(job: &Job, out: &Path, kills: usize, dice: &mut Random) -> [usize; 3] {
    let (checkpoint, part) = (out.join("checkpoint.bin"), out.join(".mpm-verify.checkpoint.bin.part"));
    let (mut alive, mut more) = ([0; 3], &[][..]);
    for kill in 0..kills {
        let mut child = start(job, out, more);
        // At its start; after some checkpoints; while one is written.
        let (moment, some) = (kill % 3, 1 + dice.bits() % 8);
        let (mut written, mut last) = (0, None);
        let met = met(&mut child, || match moment {
            0 => true,
            1 => {
                let now = fs::metadata(&checkpoint).and_then(|file| file.modified()).ok();
                written += u64::from(now.is_some() && now != last);
                last = now;
                written >= some
            }
            _ => part.exists(),
        });
        child.kill().expect("killed"); // SIGKILL: nothing is cleaned up
        let output = child.wait_with_output().expect("an end");
        if !met {
            assert!(output.status.success(), "{}: {}", job.name, stderr(&output));
            return alive;
        }
        alive[moment] += 1;
        more = &["--resume"];
    }
    let output = start(job, out, more).wait_with_output().expect("an end");
    assert!(output.status.success(), "{}: {}", job.name, stderr(&output));
    alive
}

/// No file may grow beyond some kilobytes: as good as a full disk, and it is not this machine's.
#[cfg(unix)]
#[test]
fn a_full_disk_stops_no_run_and_takes_no_result_away() {
    let root = tempfile::tempdir().expect("a folder");
    let scene = program::scene("terzaghi-semi-implicit.toml");
    let (out, other) = (root.path().join("out"), root.path().join("other"));
    let solve = |out: &Path, limit: bool, more: &[&str]| {
        let mut command = Command::new("sh");
        let limited = if limit { "trap '' XFSZ; ulimit -f 8; exec \"$@\"" } else { "exec \"$@\"" };
        command.args(["-c", limited, "sh", PROGRAM, "solve", &scene, "--quiet"]);
        command.args(["--checkpoint-every", "0", "--out"]).arg(out).args(more);
        let output = command.output().expect("a process");
        (output.status.code(), stderr(&output))
    };
    assert_eq!(solve(&out, false, &[]).0, Some(0));
    let whole = fs::read(out.join("history.csv")).expect("a history");
    let (code, error) = solve(&out, true, &[]);
    assert_eq!(code, Some(3), "{error}");
    assert!(error.contains("the last checkpoint could not be written") && error.contains("history.csv"), "{error}");
    assert!(fs::read(out.join("history.csv")).expect("a history") == whole, "that of the run before");
    assert!(!out.join(".mpm-verify.checkpoint.bin.part").exists() && !out.join(".mpm-verify.part").exists());
    // With room again, from whatever was kept.
    let mut child = start(&job("full", &[], &["solve", &scene]), &other, &[]);
    assert!(met(&mut child, || other.join("checkpoint.bin").exists()), "it ended");
    child.kill().expect("killed");
    child.wait().expect("an end");
    assert_ne!(solve(&other, true, &["--resume"]).0, Some(0));
    assert!(other.join("checkpoint.bin").exists(), "a state that was there still is");
    assert_eq!(solve(&other, false, &["--resume"]).0, Some(0));
    assert!(fs::read(other.join("history.csv")).expect("a history") == whole, "other bits");
}

#[cfg(unix)]
#[test]
fn a_proof_keeps_each_part_when_that_has_ended() {
    use std::os::unix::fs::PermissionsExt;
    let root = tempfile::tempdir().expect("a folder");
    let cargo = root.path().join("cargo");
    fs::create_dir(root.path().join("mpm-core")).expect("a folder");
    fs::write(root.path().join("mpm-core/Cargo.toml"), "").expect("a file");
    // All but the format passes only where the row of the format is stored already.
    fs::write(&cargo, "#!/bin/sh\n[ $1 = fmt ] || grep format reports/prove/prove.csv\n").expect("a script");
    fs::set_permissions(&cargo, fs::Permissions::from_mode(0o755)).expect("a script");
    let prove = |parts: &[&str]| {
        let mut command = Command::new(PROGRAM);
        command.env("CARGO", &cargo).current_dir(root.path()).arg("prove").args(parts);
        let output = command.output().expect("a process");
        assert_eq!(output.status.code(), Some(0), "{}{}", program::stdout(&output), stderr(&output));
    };
    prove(&["format", "lints"]);
    prove(&["documentation"]);
    let folder = root.path().join("reports/prove");
    let table = fs::read_to_string(folder.join("prove.csv")).expect("a table");
    for part in ["format", "lints", "documentation"] {
        assert!(table.contains(&format!("\n{part},")), "{table}");
        assert!(folder.join(format!("{part}.txt")).is_file(), "what {part} said");
    }
}

#[test]
fn killed_runs_lose_nothing_and_end_with_the_same_bits() {
    let root = tempfile::tempdir().expect("a folder");
    let scenes = root.path().join("scenes");
    fs::create_dir(&scenes).expect("a folder");
    let asked = std::env::var(ASKED).ok();
    let kills = asked.map_or(KILLS, |text| text.parse().unwrap_or_else(|e| panic!("{ASKED}={text}: {e}")));
    let (mut dice, mut alive) = (Random(8), [0; 3]);
    for job in jobs(&scenes) {
        let [whole, out] = ["whole", "killed"].map(|name| root.path().join(job.name).join(name));
        let output = start(&job, &whole, &[]).wait_with_output().expect("an end");
        assert!(output.status.success(), "{}: {}", job.name, stderr(&output));
        for (count, more) in alive.iter_mut().zip(kill_and_resume(&job, &out, kills, &mut dice)) {
            *count += more;
        }
        for ((name, expected), (_, found)) in files(&job, &whole).iter().zip(files(&job, &out)) {
            assert!(*expected == found, "{}: {} has other bits", job.name, name.display());
        }
        assert!(!out.join("checkpoint.bin").exists() && !out.join(".mpm-verify.part").exists(), "{}", job.name);
    }
    println!("killed at the start, after checkpoints, while one was written: {alive:?}");
    assert!(alive.iter().all(|count| *count >= 3), "the runs are too short to be killed: {alive:?}");
}

//! Runs that are killed at random moments and resumed end with the same bits: more than two hundred kills, while checkpoints are
//! written as fast as the disk takes them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use mpm_core::random::Random;

/// Kills in all, unless [`ASKED`] asks for another number.
const KILLS: usize = 210;
/// `MPM_KILLS=1000 cargo test --release --test kills`.
const ASKED: &str = "MPM_KILLS";

/// A run, what its folder must hold in the end, and how long it lasts here.
struct Job {
    name: &'static str,
    arguments: Vec<String>,
    compared: &'static [&'static str],
}

fn job(name: &'static str, compared: &'static [&'static str], arguments: &[&str]) -> Job {
    Job { name, arguments: arguments.iter().map(|a| (*a).to_owned()).collect(), compared }
}

/// One of each integrator and water, long enough to be killed a few times.
fn jobs(scenes: &Path) -> Vec<Job> {
    let scene = |name: &str, edits: &[(&str, &str)]| {
        let path = format!("{}/../reference-data/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let mut text = fs::read_to_string(path).expect("a scene");
        for (from, to) in edits {
            assert_eq!(text.matches(from).count(), 1, "{name}: {from}");
            text = text.replace(from, to);
        }
        let number = fs::read_dir(scenes).expect("a folder").count();
        let path = scenes.join(format!("{number}-{name}.toml"));
        fs::write(&path, text).expect("a scene");
        path.to_string_lossy().into_owned()
    };
    let solved = &["history.csv", "profiles.csv"];
    let coarse = ("cell = 0.02", "cell = 0.05");
    let plane = ("dimension = \"column\"", "dimension = \"plane-strain\"");
    let short = ("until.time_factor = 1.0", "until.time_factor = 0.02");
    let times = ("time_factors = [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0]", "time_factors = [0.01, 0.02]");
    let collapse = [("until.time = 4.0", "until.time = 0.1"), ("times = [0.25, 0.5, 1.0, 2.0]", "times = [0.05, 0.1]")];
    vec![
        job("column", solved, &["solve", &scene("terzaghi", &[coarse])]),
        job("plane-strain", solved, &["solve", &scene("terzaghi", &[coarse, plane, short, times]), "--threads", "2"]),
        job("gimp", solved, &["solve", &scene("terzaghi", &[coarse, short, times]), "--scheme", "gimp"]),
        job("semi-implicit", solved, &["solve", &scene("terzaghi-semi-implicit", &[])]),
        job("sdirk", &["history.csv"], &["solve", &scene("terzaghi-large-strain", &[])]),
        job("krylov", solved, &["solve", &scene("mandel", &[])]),
        job("dam", &["history.csv", "water.csv", "field.csv"], &["solve", &scene("dam", &[])]),
        job("collapse", &["history.csv"], &["solve", &scene("collapse-saturated", &collapse)]),
        job(
            "levee",
            &["history.csv", "paths.csv", "events.csv", "frames.bin"],
            &["levee", "--no-vtk", "--until", "6.4"],
        ),
    ]
}

fn start(job: &Job, out: &Path, more: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_mpm-verify"))
        .args(&job.arguments)
        .args(["--quiet", "--out"])
        .arg(out)
        .args(more)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a process")
}

fn files(job: &Job, out: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    job.compared.iter().map(|name| (PathBuf::from(name), fs::read(out.join(name)).expect("a file"))).collect()
}

/// Runs a job to its end, killing it some times on the way. Returns the kills that met it alive.
fn kill_and_resume(job: &Job, out: &Path, kills: usize, whole: Duration, dice: &mut Random) -> usize {
    let (mut met, mut more) = (0, vec!["--checkpoint-every", "0"]);
    loop {
        let mut child = start(job, out, &more);
        if met == kills {
            let output = child.wait_with_output().expect("an end");
            assert!(output.status.success(), "{}: {}", job.name, String::from_utf8_lossy(&output.stderr));
            return met;
        }
        std::thread::sleep(whole.mul_f64(0.02 + 0.4 * dice.unit()));
        if let Some(status) = child.try_wait().expect("a process") {
            assert!(status.success(), "{}", job.name);
            return met;
        }
        child.kill().expect("killed"); // SIGKILL: nothing is cleaned up
        child.wait().expect("an end");
        met += 1;
        more = vec!["--checkpoint-every", "0", "--resume"];
    }
}

/// No file may grow beyond some kilobytes: as good as a full disk, and it is not this machine's.
#[cfg(unix)]
#[test]
fn a_full_disk_stops_no_run_and_takes_no_result_away() {
    let root = tempfile::tempdir().expect("a folder");
    let scene = format!("{}/../reference-data/scenes/terzaghi-semi-implicit.toml", env!("CARGO_MANIFEST_DIR"));
    let (out, other) = (root.path().join("out"), root.path().join("other"));
    let solve = |out: &Path, limit: bool, more: &[&str]| {
        let mut command = Command::new("sh");
        let limited = if limit { "trap '' XFSZ; ulimit -f 8; exec \"$@\"" } else { "exec \"$@\"" };
        command.args(["-c", limited, "sh", env!("CARGO_BIN_EXE_mpm-verify"), "solve", &scene, "--quiet"]);
        command.args(["--checkpoint-every", "0", "--out"]).arg(out).args(more);
        let output = command.output().expect("a process");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    assert_eq!(solve(&out, false, &[]).0, Some(0));
    let whole = fs::read(out.join("history.csv")).expect("a history");
    let (code, error) = solve(&out, true, &[]);
    assert_eq!(code, Some(3), "{error}");
    assert!(error.contains("the last checkpoint could not be written") && error.contains("history.csv"), "{error}");
    assert!(fs::read(out.join("history.csv")).expect("a history") == whole, "that of the run before");
    assert!(!out.join(".mpm-verify.checkpoint.bin.part").exists() && !out.join(".mpm-verify.part").exists());
    // With room again, from whatever was kept.
    let mut child = start(&job("full", &[], &["solve", &scene]), &other, &["--checkpoint-every", "0"]);
    std::thread::sleep(Duration::from_millis(40));
    let _ = child.kill();
    child.wait().expect("an end");
    let kept = fs::read(other.join("checkpoint.bin"));
    assert_ne!(solve(&other, true, &["--resume"]).0, Some(0));
    assert!(kept.is_err() || fs::read(other.join("checkpoint.bin")).is_ok(), "a state that was there still is");
    assert_eq!(solve(&other, false, &["--resume"]).0, Some(0));
    assert!(fs::read(other.join("history.csv")).expect("a history") == whole, "other bits");
}

#[test]
fn killed_runs_lose_nothing_and_end_with_the_same_bits() {
    let root = tempfile::tempdir().expect("a folder");
    let scenes = root.path().join("scenes");
    fs::create_dir(&scenes).expect("a folder");
    let jobs = jobs(&scenes);
    let mut wholes = Vec::new();
    for job in &jobs {
        let out = root.path().join(job.name);
        let clock = Instant::now();
        let output = start(job, &out, &["--checkpoint-every", "0"]).wait_with_output().expect("an end");
        assert!(output.status.success(), "{}: {}", job.name, String::from_utf8_lossy(&output.stderr));
        wholes.push((clock.elapsed(), files(job, &out)));
        println!("{}: {:.2} s", job.name, clock.elapsed().as_secs_f64());
    }
    let asked = std::env::var(ASKED).ok();
    let wanted = asked.map_or(KILLS, |text| text.parse().unwrap_or_else(|e| panic!("{ASKED}={text}: {e}")));
    let (mut dice, mut kills, mut runs) = (Random(8), 0, 0);
    while kills < wanted {
        // The last three take seconds: one of them in turn after eleven others.
        let quick = jobs.len() - 3;
        let number = if runs % 12 == 11 { quick + runs / 12 % 3 } else { runs % quick };
        let (job, (whole, expected)) = (&jobs[number], &wholes[number]);
        let out = root.path().join(format!("killed-{runs}"));
        kills += kill_and_resume(job, &out, 4, *whole, &mut dice);
        for ((name, expected), (_, found)) in expected.iter().zip(files(job, &out)) {
            assert!(*expected == found, "{}: {} has other bits after {kills} kills", job.name, name.display());
        }
        assert!(!out.join("checkpoint.bin").exists() && !out.join(".mpm-verify.part").exists(), "{}", job.name);
        fs::remove_dir_all(&out).expect("removed");
        runs += 1;
        assert!(runs < 4 * wanted, "the runs are too short to be killed: {kills} kills in {runs} runs");
    }
    assert!(wanted < KILLS || runs >= 36, "every job was killed: {runs} runs");
    println!("{kills} kills in {runs} runs: nothing lost, no other bits");
}

//! The program as a user starts it, and what it leaves.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_mpm-verify");
/// The top of the repository.
pub const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Path of a file of `reference-data/scenes`.
pub fn scene(name: &str) -> String {
    format!("{ROOT}/reference-data/scenes/{name}")
}

/// Starts the program in a folder, its output piped.
pub fn start(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = Command::new(PROGRAM);
    let command = command.args(arguments).current_dir(folder).stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("a process")
}

/// Runs the program in a folder.
pub fn verify(folder: &Path, arguments: &[&str]) -> Output {
    start(folder, arguments).wait_with_output().expect("an end")
}

/// Runs a command line without quotes in a folder.
pub fn run(folder: &Path, line: &str) -> Output {
    verify(folder, &line.split_whitespace().collect::<Vec<_>>())
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A file of `reference-data/scenes` with parts replaced, each of which must occur once.
pub fn edited(name: &str, edits: &[(&str, &str)]) -> String {
    let text = fs::read_to_string(scene(name)).expect("a scene");
    edits.iter().fold(text, |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{name}: {from}");
        text.replace(from, to)
    })
}

/// `scene.toml` in a folder: a scene with parts replaced.
pub fn changed(folder: &Path, name: &str, edits: &[(&str, &str)]) -> &'static str {
    fs::write(folder.join("scene.toml"), edited(name, edits)).expect("a scene");
    "scene.toml"
}

/// Waits until something is so while a process lives; false if the process ended before. A process that writes files offers nothing to
/// wait on: it is asked every millisecond, for a minute.
pub fn met(child: &mut Child, mut condition: impl FnMut() -> bool) -> bool {
    let clock = Instant::now();
    while !condition() {
        if child.try_wait().expect("a process").is_some() {
            return false;
        }
        assert!(clock.elapsed() < Duration::from_secs(60), "a minute without what was waited for");
        std::thread::sleep(Duration::from_millis(1));
    }
    true
}

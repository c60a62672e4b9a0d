//! The guides do what they say: their commands are run in their order, in a folder of their own.

use std::fs;
use std::path::Path;
use std::process::Command;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Blocks of a page: what follows the fence, and the lines.
fn blocks(page: &str) -> Vec<(String, String)> {
    let mut blocks = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if let Some(kind) = line.strip_prefix("```").filter(|kind| !kind.is_empty()) {
            let inside: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            blocks.push((kind.to_owned(), inside.join("\n")));
        }
    }
    blocks
}

/// Runs a line of a shell block.
fn run(line: &str, folder: &Path) {
    let words: Vec<&str> = line.split_whitespace().collect();
    let status = match words.as_slice() {
        ["cargo", "run", "--release", "--", arguments @ ..] => {
            let mut command = Command::new(env!("CARGO_BIN_EXE_mpm-verify"));
            let output = command.args(arguments).arg("--quiet").current_dir(folder).output().expect("a run");
            let error = String::from_utf8_lossy(&output.stderr).into_owned();
            // A night without baselines of its own is red: all else must succeed.
            let red = arguments[0] == "nightly" && output.status.code() == Some(1);
            assert!(output.status.success() || red, "{line}: {error}");
            return;
        }
        ["test", "-f", path] => folder.join(path).is_file(),
        ["cmp", one, other] => {
            fs::read(folder.join(one)).expect("a file") == fs::read(folder.join(other)).expect("a file")
        }
        _ => panic!("no guide may need another program: {line}"),
    };
    assert!(status, "{line}");
}

fn follow(name: &str) {
    let page = fs::read_to_string(format!("{ROOT}/mpm-verify/docs/{name}")).expect("a page");
    let folder = tempfile::tempdir().expect("a folder");
    let scenes = folder.path().join("reference-data/scenes");
    fs::create_dir_all(&scenes).expect("a folder");
    fs::copy(format!("{ROOT}/reference-data/scenes/dry-bar.toml"), scenes.join("dry-bar.toml")).expect("a scene");
    let mut commands = 0;
    for (kind, text) in blocks(&page) {
        match kind.split_once(" file=") {
            Some(("toml", file)) => fs::write(folder.path().join(file), text).expect("written"),
            // What is quoted stands in the source as it is quoted.
            Some((_, file)) => {
                let source = fs::read_to_string(format!("{ROOT}/{file}")).expect("a source");
                assert!(source.contains(&text), "{name}: {file} reads otherwise");
            }
            None if kind == "sh" => {
                for line in text.lines() {
                    run(line, folder.path());
                    commands += 1;
                }
            }
            None => {}
        }
    }
    assert!(commands > 0, "{name}");
}

#[test]
fn add_a_case() {
    follow("add-a-case.md");
}

#[test]
fn read_a_report() {
    follow("read-a-report.md");
}

#[test]
fn accept_a_baseline() {
    follow("accept-a-baseline.md");
}

#[test]
fn many_machines() {
    follow("many-machines.md");
}

#[test]
fn every_guide_is_in_the_list() {
    let list = fs::read_to_string(format!("{ROOT}/mpm-verify/docs/README.md")).expect("a page");
    for entry in fs::read_dir(format!("{ROOT}/mpm-verify/docs")).expect("a folder") {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        assert!(name == "README.md" || list.contains(&format!("({name})")), "{name}");
    }
}

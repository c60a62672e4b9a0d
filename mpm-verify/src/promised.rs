//! Commands and files in the README, the guides and the workflows exist: every command parses, every file is there.

use std::fs;
use std::path::Path;

use clap::{CommandFactory, Parser};
use saphyr::{LoadableYamlNode, Yaml};

use crate::Cli;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

fn text(path: &str) -> String {
    fs::read_to_string(format!("{ROOT}/{path}")).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn files(folder: &str, ending: &str) -> Vec<String> {
    let entries = fs::read_dir(format!("{ROOT}/{folder}")).unwrap_or_else(|e| panic!("{folder}: {e}"));
    let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut files: Vec<String> = names.filter(|n| n.ends_with(ending)).map(|n| format!("{folder}/{n}")).collect();
    files.sort();
    files
}

/// Words of a shell line, without quotes.
pub fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote, mut open) = (Vec::new(), String::new(), None, false);
    for c in line.chars() {
        match (quote, c) {
            (None, '"' | '\'') => (quote, open) = (Some(c), true),
            (Some(q), c) if q == c => quote = None,
            (None, '#') if !open => break,
            (None, c) if c.is_whitespace() => {
                if open {
                    words.push(std::mem::take(&mut word));
                }
                open = false;
            }
            (_, c) => {
                word.push(c);
                open = true;
            }
        }
    }
    if open {
        words.push(word);
    }
    words
}

/// Whether a command line is one of this program; why not, if it is not.
fn parses(arguments: &[String]) -> Result<(), clap::Error> {
    // Placeholders for what the reader chooses.
    let own = |word: &String| match word.as_str() {
        "SCENE" | "SCENE.toml" => "scene.toml".to_owned(),
        "DIR" => "folder".to_owned(),
        "..." => String::new(),
        other => other.to_owned(),
    };
    let arguments = arguments.iter().map(own).filter(|word| !word.is_empty());
    Cli::try_parse_from(std::iter::once("mpm-verify".to_owned()).chain(arguments)).map(drop)
}

/// Checks a command line of any kind. Returns whether it is one of this program.
fn check(place: &str, line: &str) -> bool {
    let mut words = words(line);
    words.retain(|word| word != "--locked" && !word.starts_with('+'));
    let of: Vec<&str> = words.iter().map(String::as_str).collect();
    match of.as_slice() {
        ["cargo", "run", "--release"] => true,
        ["cargo", "run", "--release", "--", ..] => {
            parses(&words[4..]).unwrap_or_else(|e| panic!("{place}: {line}: {e}"));
            true
        }
        ["cargo", "run", "--release", "-p", "mpm-bench", ..] => false,
        ["cargo", "test" | "bench" | "build" | "check" | "fmt" | "clippy" | "doc", ..] => {
            for pair in of.windows(2).filter(|pair| pair[0] == "-p") {
                assert!(Path::new(&format!("{ROOT}/{}", pair[1])).is_dir(), "{place}: {line}");
            }
            // A program of tests of that crate, and modules of it.
            if let Some(at) = of.iter().position(|word| *word == "--test") {
                let package = of.iter().position(|word| *word == "-p").map(|p| of[p + 1]).expect("a crate");
                let is_file = |path: &str| Path::new(&format!("{ROOT}/{package}/tests/{path}.rs")).is_file();
                let program = of[at + 1];
                assert!(is_file(program) || is_file(&format!("{program}/main")), "{place}: {line}");
                let module = |word: &&str| is_file(&format!("{program}/{}", word.trim_end_matches(':')));
                assert!(of[at + 2..].iter().filter(|word| !word.starts_with('-')).all(module), "{place}: {line}");
            }
            false
        }
        ["cargo", "install", "cargo-mutants"] => false,
        _ => panic!("{place}: expected a command that the README explains, found {line}"),
    }
}

/// Commands in the text of a page: lines of its shell blocks, and text between backquotes.
fn commands(page: &str) -> Vec<String> {
    let mut commands = Vec::new();
    let mut block = None;
    for line in page.lines() {
        match (line.strip_prefix("```"), block) {
            (Some(kind), None) => block = Some(kind.starts_with("sh") || kind == "text"),
            (Some(_), Some(_)) => block = None,
            (None, Some(true)) if line.starts_with("cargo ") => commands.push(line.to_owned()),
            (None, Some(_)) => {}
            (None, None) => {
                commands
                    .extend(line.split('`').skip(1).step_by(2).filter(|c| c.starts_with("cargo ")).map(str::to_owned));
            }
        }
    }
    commands
}

#[test]
fn commands_of_the_pages_parse() {
    let mut pages = vec!["README.md".to_owned(), "CONTRIBUTING.md".to_owned()];
    pages.extend(files("mpm-verify/docs", ".md"));
    let mut own = 0;
    for page in &pages {
        for command in commands(&text(page)) {
            own += usize::from(check(page, &command));
        }
    }
    assert!(own > 20, "{own} commands");
}

#[test]
fn commands_that_the_guide_lists_exist() {
    let readme = text("mpm-verify/docs/commands.md");
    let mut known: Vec<String> =
        Cli::command().get_subcommands().filter(|c| !c.is_hide_set()).map(|c| c.get_name().to_owned()).collect();
    known.sort();
    for name in &known {
        assert!(readme.contains(&format!("`mpm-verify {name}")), "the guide does not say what {name} does");
    }
    for part in readme.split("`mpm-verify ").skip(1) {
        let line = part.split('`').next().unwrap_or_default();
        let name = line.split_whitespace().next().unwrap_or_default().to_owned();
        assert!(name == "..." || known.contains(&name), "guide: mpm-verify {line}");
    }
}

/// Steps of a job.
fn steps<'a>(job: &'a Yaml<'a>, place: &str) -> Vec<&'a Yaml<'a>> {
    let steps = job.as_mapping_get("steps").and_then(Yaml::as_sequence);
    steps.unwrap_or_else(|| panic!("{place}: no steps")).iter().collect()
}

#[test]
fn workflows_parse_and_call_nothing_that_does_not_exist() {
    let found = files(".github/workflows", ".yml");
    assert_eq!(found.len(), 3, "{found:?}");
    let (mut own, mut tests) = (0, 0);
    for path in &found {
        let text = text(path);
        let all = Yaml::load_from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"));
        let top = all.first().unwrap_or_else(|| panic!("{path}: empty"));
        assert!(top.as_mapping_get("on").is_some(), "{path}: never");
        let jobs = top.as_mapping_get("jobs").and_then(Yaml::as_mapping).unwrap_or_else(|| panic!("{path}: no jobs"));
        for (name, job) in jobs {
            let place = format!("{path}, {}", name.as_str().unwrap_or_default());
            assert!(job.as_mapping_get("runs-on").is_some(), "{place}: runs nowhere");
            for step in steps(job, &place) {
                let of = |key: &str| step.as_mapping_get(key).and_then(Yaml::as_str);
                match (of("uses"), of("run")) {
                    (Some(uses), None) => {
                        let known = ["actions/", "Swatinem/rust-cache@", "EmbarkStudios/cargo-deny-action@"];
                        assert!(known.iter().any(|k| uses.starts_with(k)) && uses.contains("@v"), "{place}: {uses}");
                    }
                    (None, Some(run)) => {
                        for line in run.lines().filter(|line| line.starts_with("cargo ")) {
                            own += usize::from(check(&place, line));
                            tests += usize::from(line.starts_with("cargo test --workspace"));
                        }
                        let other = run.lines().filter(|line| !line.starts_with("cargo "));
                        for line in other {
                            let first = line.split_whitespace().next().unwrap_or_default();
                            let script = first.starts_with(".ci/") && Path::new(&format!("{ROOT}/{first}")).is_file();
                            assert!(script || ["rustup", "sudo", "cat", "npm"].contains(&first), "{place}: {line}");
                        }
                    }
                    _ => panic!("{place}: expected a step that uses or runs something"),
                }
            }
        }
        for entry in top
            .as_mapping_get("on")
            .and_then(|on| on.as_mapping_get("schedule"))
            .and_then(Yaml::as_sequence)
            .into_iter()
            .flatten()
        {
            let cron = entry.as_mapping_get("cron").and_then(Yaml::as_str).unwrap_or_default();
            assert_eq!(cron.split_whitespace().count(), 5, "{path}: {cron}");
        }
    }
    assert!(own >= 2 && tests == 1, "{own} commands of this program, {tests} times the tests");
    let readme = text("README.md");
    assert!(readme.contains("cargo test --workspace") && text(".ci/run").contains("cargo test --workspace"));
}

/// The number between two parts of a page, as it is written.
fn written<'a>(page: &'a str, start: &str, end: &str) -> &'a str {
    let (_, rest) = page.split_once(start).unwrap_or_else(|| panic!("{start}"));
    rest.split_once(end).unwrap_or_else(|| panic!("{start} ... {end}")).0
}

#[test]
fn help_names_every_word_of_a_scene() {
    use mpm_core::scene::{INTEGRATORS, SHAPES};
    for command in ["solve", "check"] {
        let mut cli = Cli::command();
        let command = cli.find_subcommand_mut(command).expect("a command");
        let words = |flag: &str| -> Vec<String> {
            let option = command.get_arguments().find(|a| a.get_long() == Some(flag)).expect("an option");
            option.get_possible_values().iter().map(|word| word.get_name().to_owned()).collect()
        };
        assert_eq!(words("scheme"), SHAPES.map(|(word, _)| word));
        assert_eq!(words("integrator"), INTEGRATORS.map(|(word, _)| word));
    }
}

#[test]
fn a_command_that_does_not_exist_is_found() {
    for line in ["nightly --frobnicate", "nigthly", "study --mesh", "check --scene a.toml --mutants"] {
        assert!(parses(&words(line)).is_err(), "{line}");
    }
    assert_eq!(words("a \"b c\" --d 'e'  # f"), ["a", "b c", "--d", "e"]);
    assert_eq!(
        commands("x `cargo run` y\n```sh\ncargo test\nls\n```\n```rust\ncargo doc\n```\n"),
        ["cargo run", "cargo test"]
    );
}

#[test]
fn scripts_read_files_and_run_cases_that_exist() {
    for script in [".ci/widths", ".ci/second-opinion"] {
        let text = text(script);
        for (at, _) in text.match_indices("reference-data/") {
            let path = text[at..].split([' ', ',', '"', '\n']).next().unwrap_or_default();
            assert!(Path::new(&format!("{ROOT}/{path}")).exists(), "{script}: {path}");
        }
        // What `check` writes: a name of another file was read in vain once.
        for (at, ending) in text.match_indices(".csv\"") {
            let path = text[..at + ending.len() - 1].rsplit(['"', ' ']).next().unwrap_or_default();
            assert!(["cases.csv", "second-opinion.csv"].iter().any(|name| path.ends_with(name)), "{script}: {path}");
        }
    }
    let text = text(".ci/widths");
    let cases = written(&text, "    cases=(", ")").split_whitespace();
    let known = mpm_verify::cases::suite();
    for case in cases {
        assert!(known.iter().any(|one| one.name == case), ".ci/widths: {case}");
    }
}

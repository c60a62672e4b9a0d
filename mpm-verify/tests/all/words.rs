//! Guards plain language: the words of `reference-data/words.csv` are not in README, guide, changelog, page templates, help, or lists.

use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{ROOT, stdout, verify};

/// Where a word to avoid is the right one: a part of the line, and why.
const ALLOWED: &[(&str, &str, &str)] = &[
    ("two-layer", "\"two-layer MPM\" of its paper", "the README says once what the paper calls the method"),
    ("two-layer", "method two-layer MPM", "the guide says once what the paper calls the method"),
];

/// A word to avoid, and what to say.
struct Word {
    avoid: String,
    say: String,
    /// Kinds of text in which it is looked for; `everywhere` is all.
    place: String,
}

fn words() -> Vec<Word> {
    let mut table = csv::Reader::from_path(format!("{ROOT}/reference-data/words.csv")).expect("the table of words");
    assert_eq!(table.headers().expect("columns"), &csv::StringRecord::from(vec!["avoid", "say", "where"]));
    let row = |row: csv::StringRecord| Word { avoid: row[0].to_lowercase(), say: row[1].into(), place: row[2].into() };
    table.records().map(|record| row(record.expect("a row"))).collect()
}

/// Whether a phrase stands in a line as whole words.
fn has(line: &str, phrase: &str) -> bool {
    let inside = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    line.match_indices(phrase)
        .any(|(at, _)| !inside(line[..at].chars().next_back()) && !inside(line[at + phrase.len()..].chars().next()))
}

/// What a text says that it should not: place, line, word, and what to say.
fn found(kind: &str, place: &str, text: &str, words: &[Word]) -> Vec<String> {
    let mut all = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let small = line.to_lowercase();
        for word in words.iter().filter(|word| word.place == "everywhere" || word.place.split(' ').any(|p| p == kind)) {
            let allowed = ALLOWED.iter().any(|(avoid, part, _)| *avoid == word.avoid && line.contains(part));
            if has(&small, &word.avoid) && !allowed {
                all.push(format!("{place}:{}: {:?}, say {:?}: {}", number + 1, word.avoid, word.say, line.trim()));
            }
        }
    }
    all
}

/// The same lines without what stands between two marks.
fn without(text: &str, start: &str, end: &str) -> String {
    let (mut rest, mut left) = (text, String::new());
    while let Some((before, after)) = rest.split_once(start) {
        left.push_str(before);
        let (inside, after) = after.split_once(end).unwrap_or((after, ""));
        left.push_str(&"\n".repeat(inside.matches('\n').count()));
        rest = after;
    }
    left + rest
}

/// Files of a folder and of those in it, by ending.
fn files(folder: &Path, ending: &str, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files(&path, ending, all);
        } else if path.extension().is_some_and(|e| e == ending) {
            all.push(path);
        }
    }
}

fn output(arguments: &[&str]) -> String {
    let output = verify(Path::new(ROOT), arguments);
    assert!(output.status.success(), "{arguments:?}");
    stdout(&output)
}

#[test]
fn words_to_avoid_are_absent() {
    let words = words();
    let mut all = Vec::new();
    let read = |path: &Path| fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let named = |path: &Path| path.strip_prefix(ROOT).expect("below the root").display().to_string();
    // Prose of the pages: names of keys, cases and files in it are checked where they are made.
    let mut pages: Vec<PathBuf> =
        ["README.md", "CHANGELOG.md", "CONTRIBUTING.md"].map(|f| Path::new(ROOT).join(f)).into();
    pages.extend(
        ["reference-data/README.md", "reference-data/scenes/README.md", "reference-data/others/README.md"]
            .map(|f| Path::new(ROOT).join(f)),
    );
    files(&Path::new(ROOT).join("mpm-verify/docs"), "md", &mut pages);
    for page in &pages {
        let prose = without(&without(&read(page), "```", "```"), "`", "`");
        all.extend(found("docs", &named(page), &prose, &words));
    }
    let mut templates = Vec::new();
    files(&Path::new(ROOT).join("mpm-verify/src"), "html", &mut templates);
    for template in &templates {
        let marks =
            [("<style", "</style>"), ("<script", "</script>"), ("{#", "#}"), ("{%", "%}"), ("{{", "}}"), ("<", ">")];
        let text = marks.iter().fold(read(template), |text, (start, end)| without(&text, start, end));
        all.extend(found("templates", &named(template), &text, &words));
    }
    let top = output(&["--help"]);
    all.extend(found("help", "mpm-verify --help", &top, &words));
    let commands = top.split_once("Commands:").expect("commands").1.lines().skip(1).take_while(|line| !line.is_empty());
    // A description that goes on in a second line is indented further.
    let names = commands.filter_map(|line| line.strip_prefix("  ").filter(|rest| !rest.starts_with(' ')));
    for name in names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help") {
        all.extend(found("help", &format!("mpm-verify {name} --help"), &output(&[name, "--help"]), &words));
    }
    all.extend(found("list", "mpm-verify list", &output(&["list"]), &words));
    all.extend(found("list", "mpm-verify list --capabilities", &output(&["list", "--capabilities"]), &words));
    assert!(all.is_empty(), "{} places:\n{}", all.len(), all.join("\n"));
}

#[test]
fn the_readme_is_one_page() {
    let readme = fs::read_to_string(format!("{ROOT}/README.md")).expect("the README");
    // Names of stored passages are comments, which no page shows.
    let count = without(&readme, "<!--", "-->").split_whitespace().count();
    assert!(count <= 900, "{count} words");
}

#[test]
fn a_word_is_found_as_a_word() {
    assert!(has("the rung of", "rung") && has("rung", "rung") && has("(rung)", "rung"));
    assert!(!has("sprung", "rung") && !has("rungs", "rung") && !has("bar_rung", "rung"));
    assert_eq!(without("a `b\nc` d", "`", "`"), "a \n d");
}

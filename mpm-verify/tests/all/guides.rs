//! Guards the guide: its commands are run in their order in a folder of their own, its links lead somewhere, its tables are the program's.

use std::fs;
use std::path::Path;
use std::process::Command;

use mpm_verify::book::{CHAPTERS, anchor as anchor_of, reference};

use crate::program::{PROGRAM, ROOT, stderr, stdout};

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

/// Commands of the pages that are not run here, each with the reason. Whatever else stands in a block `sh` is run as it is written.
const NOT_RUN: &[(&str, &str)] = &[
    ("levee", "quick only in release: the part `levee` of prove runs it"),
    ("levee --safety-factor 8,10,12,14", "minutes: publish runs it"),
    ("levee --ensemble 9 --full", "minutes: publish runs it"),
    ("levee --probability", "minutes: publish runs it"),
    ("slope", "minutes: publish runs it"),
    ("publish", "an hour, from a clean commit"),
    ("prove", "runs these tests"),
    ("nightly --accept \"second order in time: half the steps for the same error\"", "changes what is accepted"),
    ("check dry-bar --accept \"a shorter step\"", "changes what is accepted"),
];

/// Files of the repository by their paths, as git knows them; none, with the reason said, where there is no git.
fn tracked() -> Option<Vec<String>> {
    let listed = Command::new("git").args(["-C", ROOT, "ls-files", "-z"]).output();
    let Some(listed) = listed.ok().filter(|output| output.status.success()) else {
        eprintln!("skipped: no git, or no checkout of it, to say what a clone has");
        return None;
    };
    let names = String::from_utf8(listed.stdout).expect("names");
    Some(names.split_terminator('\0').filter(|name| Path::new(ROOT).join(name).is_file()).map(str::to_owned).collect())
}

/// A fresh clone in which the program has been built: what git tracks, and a `cargo` that runs that program.
fn clone() -> Option<tempfile::TempDir> {
    let folder = tempfile::tempdir().expect("a folder");
    for name in tracked()?.iter().filter(|name| !name.starts_with("reports/")) {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::copy(Path::new(ROOT).join(name), path).expect("a file");
    }
    let (built, bin) = (folder.path().join("target/release"), folder.path().join("target/bin"));
    for folder in [&built, &bin] {
        fs::create_dir_all(folder).expect("a folder");
    }
    let program = built.join("mpm-verify");
    fs::hard_link(PROGRAM, &program).or_else(|_| fs::copy(PROGRAM, &program).map(drop)).expect("a program");
    let cargo = "#!/bin/sh\n[ \"$1 $2\" = \"run --release\" ] || exit 99\nshift 2\n[ \"$1\" = -- ] && shift\n\
                 exec \"$(dirname \"$0\")/../release/mpm-verify\" \"$@\"\n";
    fs::write(bin.join("cargo"), cargo).expect("written");
    assert!(Command::new("chmod").arg("+x").arg(bin.join("cargo")).status().expect("chmod").success());
    Some(folder)
}

/// Runs a line of a shell block as a reader does, and compares its exit code with the one that the line ends with, `# exit code 1`. What it
/// says, with single spaces.
fn run(line: &str, folder: &Path) -> String {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(folder.join("target/bin")).chain(std::env::split_paths(&path)));
    let mut shell = Command::new("sh");
    let shell = shell.args(["-c", line]).current_dir(folder).env("PATH", path.expect("a path"));
    let output = shell.env("PYTHONDONTWRITEBYTECODE", "1").output().expect("a shell");
    let code = line.split_once("# exit code ").map_or("0", |(_, code)| code);
    assert_eq!(output.status.code().map(|code| code.to_string()).as_deref(), Some(code), "{line}: {}", stderr(&output));
    single_spaced(&(stdout(&output) + &stderr(&output)))
}

fn single_spaced(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Whether a line is not run here: one of those, or tests, which are run with this one.
fn is_left_out(line: &str) -> bool {
    line.starts_with("cargo test ")
        || NOT_RUN.iter().any(|(command, _)| *command == line.trim_start_matches("cargo run --release -- "))
}

/// Does all that a page says, in its order, in a fresh clone, and leaves every file there as it was.
fn follow(page: &str) {
    let content = text(page);
    let (Some(folder), Some(files)) = (clone(), tracked()) else { return };
    let python = Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success());
    let mut said = String::new();
    for (kind, text) in blocks(&content) {
        match kind.split_once(" file=") {
            Some(("toml", file)) => fs::write(folder.path().join(file), text).expect("written"),
            // What is quoted stands in a case as it is quoted.
            None if kind == "rust,ignore" => {
                let cases = fs::read_dir(format!("{ROOT}/mpm-verify/src/cases")).expect("a folder");
                let sources = cases.filter_map(|entry| fs::read_to_string(entry.expect("an entry").path()).ok());
                assert!(sources.into_iter().any(|source| source.contains(&text)), "{page}: no case reads so:\n{text}");
            }
            None if kind == "sh" => {
                for line in text.lines().filter(|line| !is_left_out(line)) {
                    if line.contains("python3") && !python {
                        eprintln!("skipped, no python3: {line}");
                    } else {
                        said = run(line, folder.path());
                    }
                }
            }
            None if kind == "text output" => assert!(said.contains(&single_spaced(&text)), "{page}: {said}"),
            _ => {
                assert!(!text.lines().any(|line| line.starts_with("cargo ")), "{page}: a command outside of a block sh")
            }
        }
    }
    let read = |root: &Path, file: &str| fs::read(root.join(file)).ok();
    let own = files.iter().filter(|file| !file.starts_with("reports/"));
    let changed: Vec<&String> = own.filter(|file| read(folder.path(), file) != read(Path::new(ROOT), file)).collect();
    assert!(changed.is_empty() && !folder.path().join("reports/published").exists(), "{page} changes {changed:?}");
}

#[test]
fn every_command_of_the_pages_runs_in_a_fresh_clone() {
    let pages: Vec<String> = pages().into_iter().filter(|page| !page.starts_with("reference-data/")).collect();
    let next = std::sync::atomic::AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(page) = pages.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
                    follow(page);
                }
            });
        }
    });
    let all: String = pages.iter().map(|page| text(page)).collect();
    let unused = NOT_RUN.iter().find(|(command, _)| !all.lines().any(|line| line.ends_with(command)));
    assert!(unused.is_none(), "{unused:?} is on no page");
}

/// Numbers with a unit that the pages state: inputs, definitions, and what others have published. All others are stored ones.
const STATED: &[(&str, &str)] = &[
    ("8.66 h", "the paper: progressive failure"),
    ("12.5 h 13.0 h 13.2 h", "the experiment: its events (Mori 2008)"),
    ("6 h 9 h", "when the computation of the levee begins; when its tank is empty"),
    (
        "0.5 % 1 % 5 %",
        "shares of the cross-section that define the events; bounds of verdicts; dilation of the levee's soil",
    ),
    ("0.4 %", "spread of the cohesion of an ensemble"),
    ("36 s", "start of a comparison of drivers"),
    ("95 %", "confidence intervals"),
    ("2 % 3 %", "tolerances of accepted values and of published slopes"),
    ("1 % 0.3 % 0.1 % 0.02 % 0.01 %", "wanted errors"),
    ("0.2 % 10 %", "criteria of a slope that stands or slides"),
    ("93 %", "Terzaghi's degree of consolidation at Tv = 1"),
    ("8 h 10 h 12 h 14 h", "times of factors of safety"),
    ("1e-6", "tolerance of accepted errors"),
];

/// The text of a page without code, formulas, targets of links, and what is stored.
fn prose(page: &str) -> String {
    let without = |text: &str, open: &str, close: &str| {
        let mut parts = text.split(open);
        let first = parts.next().unwrap_or_default().to_owned();
        parts.fold(first, |out, part| out + " " + part.split_once(close).map_or("", |(_, rest)| rest))
    };
    let text = without(page, "<!-- stored: ", "<!-- -->");
    let text = without(&text, "](", ")");
    let odd = |text: &str, fence: &str| text.split(fence).step_by(2).collect::<Vec<_>>().join(" ");
    ["```", "$$", "$", "`"].iter().fold(text, |text, fence| odd(&text, fence))
}

/// A number that is measured is not typed: what has an exponent or a unit of time or share is stored, or stated with its source.
#[test]
fn numbers_of_the_pages_are_stored_or_stated() {
    let stated: Vec<&str> = STATED.iter().map(|(numbers, _)| *numbers).collect();
    let is_stated = |number: &str| stated.iter().any(|all| format!(" {all} ").contains(&format!(" {number} ")));
    let guide = mpm_verify::book::stored::pages().into_iter().filter(|page| !page.starts_with("reference-data/"));
    let mut typed = Vec::new();
    // Theory states formulas and their constants; the reference is generated.
    for page in guide.filter(|page| !page.ends_with("theory.md") && !page.ends_with("scene-reference.md")) {
        let prose = prose(&text(&page));
        let words: Vec<&str> =
            prose.split(|c: char| c.is_whitespace() || "(),;:|*".contains(c)).filter(|w| !w.is_empty()).collect();
        for pair in words.windows(2) {
            let number = pair[0].trim_end_matches('.');
            let unit = pair[1].trim_end_matches('.');
            let is_unit = ["%", "h", "s", "ms", "µs", "ns", "min"].contains(&unit);
            let said = if number.contains('e') { number.to_owned() } else { format!("{number} {unit}") };
            if number.parse::<f64>().is_ok() && (is_unit || number.contains('e')) && !is_stated(&said) {
                typed.push(format!("{page}: {said}"));
            }
        }
    }
    assert!(typed.is_empty(), "typed numbers, neither stored nor stated: {typed:#?}");
}

/// On GitHub a link or a picture leads to what git tracks, or nowhere.
#[test]
fn links_of_every_tracked_page_lead_to_tracked_files() {
    let Some(files) = tracked() else { return };
    // Templates, whose links are those of the pages that are made of them.
    let templates = ["mpm-verify/src/book/reference.md", "mpm-verify/src/page/page.md"];
    let mut dead = Vec::new();
    for page in files.iter().filter(|file| file.ends_with(".md") && !templates.contains(&file.as_str())) {
        let content = text(page);
        for part in content.split("](").skip(1) {
            let link = part.split([')', '#', ' ']).next().unwrap_or_default();
            if link.is_empty() || link.contains("://") {
                continue;
            }
            let mut target: Vec<&str> = page.split('/').collect();
            target.pop();
            for step in link.split('/').filter(|step| !step.is_empty() && *step != ".") {
                match step {
                    ".." => _ = target.pop(),
                    _ => target.push(step),
                }
            }
            let target = target.join("/");
            if !files.iter().any(|file| *file == target || file.starts_with(&format!("{target}/"))) {
                dead.push(format!("{page}: {link}"));
            }
        }
    }
    assert!(dead.is_empty(), "links to what git does not track: {dead:#?}");
}

fn text(page: &str) -> String {
    fs::read_to_string(format!("{ROOT}/{page}")).unwrap_or_else(|e| panic!("{page}: {e}"))
}

/// Pages that people read in the repository.
fn pages() -> Vec<String> {
    let docs = fs::read_dir(format!("{ROOT}/mpm-verify/docs")).expect("a folder");
    let docs = docs.map(|entry| format!("mpm-verify/docs/{}", entry.expect("an entry").file_name().to_string_lossy()));
    let others =
        ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "reference-data/README.md", "reference-data/others/README.md"];
    docs.filter(|name| name.ends_with(".md")).chain(others.map(str::to_owned)).collect()
}

#[test]
fn every_chapter_is_in_the_list() {
    let list = text("mpm-verify/docs/README.md");
    for (i, chapter) in CHAPTERS.iter().enumerate() {
        assert!(
            list.contains(&format!("\n{}. [", i + 1)) && list.contains(&format!("]({}.md)", chapter.name)),
            "{}",
            chapter.name
        );
    }
    assert_eq!(fs::read_dir(format!("{ROOT}/mpm-verify/docs")).expect("a folder").count(), CHAPTERS.len() + 1);
}

/// Links lead to files and headings, and paths of the repository that are named in code exist.
#[test]
fn links_and_paths_lead_somewhere() {
    for page in pages() {
        let folder = Path::new(ROOT).join(&page).parent().expect("a folder").to_owned();
        let content = text(&page);
        for part in content.split("](").skip(1) {
            let link = part.split(')').next().unwrap_or_default();
            let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
            if link.contains("://") || link.contains(' ') {
                continue;
            }
            let target = if path.is_empty() { Path::new(ROOT).join(&page) } else { folder.join(path) };
            assert!(target.exists(), "{page}: {link}");
            if !anchor.is_empty() {
                let target = fs::read_to_string(&target).expect("a page");
                let headings =
                    target.lines().filter_map(|line| line.strip_prefix('#')).map(|h| h.trim_start_matches('#').trim());
                assert!(headings.map(anchor_of).any(|name| name == anchor), "{page}: {link}");
            }
        }
        for word in content.split('`').skip(1).step_by(2).flat_map(str::split_whitespace) {
            let tops = ["mpm-core/", "mpm-verify/", "mpm-bench/", "reference-data/", ".ci/", ".github/"];
            if tops.iter().any(|top| word.starts_with(top)) && !word.contains(['*', 'N']) {
                assert!(Path::new(ROOT).join(word).exists(), "{page}: {word}");
            }
        }
    }
}

#[test]
fn the_guide_is_written_as_pages_without_network_or_dead_links() {
    let reports = tempfile::tempdir().expect("a folder");
    mpm_verify::book::write(reports.path()).expect("a guide");
    let guide = reports.path().join("guide");
    for name in CHAPTERS.iter().map(|chapter| chapter.name).chain(["index"]) {
        let page = fs::read_to_string(guide.join(format!("{name}.html"))).expect("a page");
        assert!(!page.contains("<script src") && !page.contains("src=\"http"), "{name}");
        for part in page.split("href=\"").skip(1) {
            let link = part.split('"').next().unwrap_or_default().replace("&#x2f;", "/");
            let (path, anchor) = link.split_once('#').unwrap_or((&link, ""));
            if link.contains("://") || path == "../index.html" {
                continue;
            }
            let target = if path.is_empty() { guide.join(format!("{name}.html")) } else { guide.join(path) };
            let target = fs::read_to_string(&target).unwrap_or_else(|e| panic!("{name}: {link}: {e}"));
            assert!(anchor.is_empty() || target.contains(&format!("id=\"{anchor}\"")), "{name}: {link}");
        }
    }
}

/// `UPDATE_PAGES=1 cargo test -p mpm-verify --test all guides::` writes the chapter anew.
#[test]
fn the_scene_reference_is_what_the_checker_says() {
    let path = format!("{ROOT}/mpm-verify/docs/scene-reference.md");
    let chapter = reference::chapter();
    if std::env::var_os("UPDATE_PAGES").is_some() {
        fs::write(&path, &chapter).expect("written");
    }
    assert!(text("mpm-verify/docs/scene-reference.md") == chapter, "out of date: UPDATE_PAGES=1 writes it");
    let bare: Vec<String> =
        reference::keys().into_iter().filter(|key| key.row.is_none() && !key.holds).map(|key| key.path).collect();
    assert!(bare.is_empty(), "no meaning in reference-data/scenes/README.md: {bare:?}");
}

//! Guards the guide: its commands are run in their order in a folder of their own, its links lead somewhere, its tables are the program's.

use std::fs;
use std::path::Path;
use std::process::Command;

use mpm_verify::book::{CHAPTERS, anchor as anchor_of, reference};

use crate::program::{PROGRAM, ROOT, stderr};

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

/// Words of a line; what stands between double quotes is one.
fn words(line: &str) -> Vec<String> {
    let parts = line.split('"').enumerate();
    parts
        .flat_map(|(i, part)| match i % 2 {
            0 => part.split_whitespace().map(str::to_owned).collect::<Vec<_>>(),
            _ => vec![part.to_owned()],
        })
        .collect()
}

/// Runs a line of a shell block.
fn run(line: &str, folder: &Path) {
    let words = words(line);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let status = match words.as_slice() {
        ["cargo", "run", "--release", "--", arguments @ ..] => {
            let mut command = Command::new(PROGRAM);
            // A command that a chapter has run finds the program, and Python leaves nothing behind.
            let own = Path::new(PROGRAM).parent().expect("a folder").to_owned();
            let path = std::env::var_os("PATH").unwrap_or_default();
            let path = std::env::join_paths(std::iter::once(own).chain(std::env::split_paths(&path))).expect("a path");
            command.env("PATH", path).env("PYTHONDONTWRITEBYTECODE", "1");
            let output = command.args(arguments).arg("--quiet").current_dir(folder).output().expect("a run");
            let error = stderr(&output);
            // A nightly run without baselines of its own fails: all else must succeed.
            let compared = arguments[0] == "nightly" && output.status.code() == Some(1);
            // What is wrong on purpose must be found.
            let wrong = arguments[0] == "score" && arguments.contains(&"wrong");
            let right = if wrong { output.status.code() == Some(1) } else { output.status.success() };
            assert!(right || compared, "{line}: {error}");
            return;
        }
        ["test", "-f", path] => folder.join(path).is_file(),
        ["cmp", one, other] => {
            fs::read(folder.join(one)).expect("a file") == fs::read(folder.join(other)).expect("a file")
        }
        _ => panic!("no chapter may need another program: {line}"),
    };
    assert!(status, "{line}");
}

fn follow(name: &str) {
    let page = fs::read_to_string(format!("{ROOT}/mpm-verify/docs/{name}")).expect("a page");
    let folder = tempfile::tempdir().expect("a folder");
    let scenes = folder.path().join("reference-data/scenes");
    fs::create_dir_all(&scenes).expect("a folder");
    fs::copy(format!("{ROOT}/reference-data/scenes/dry-bar.toml"), scenes.join("dry-bar.toml")).expect("a scene");
    for file in ["toy.py", "wrong.py"] {
        let source = format!("{ROOT}/mpm-verify/adapters/toy/{file}");
        fs::copy(source, folder.path().join(file)).expect("a code of the tutorial");
    }
    let mut commands = 0;
    for (kind, text) in blocks(&page) {
        match kind.split_once(" file=") {
            Some(("toml", file)) => fs::write(folder.path().join(file), text).expect("written"),
            // What is quoted stands in a case as it is quoted.
            None if kind == "rust,ignore" => {
                let cases = fs::read_dir(format!("{ROOT}/mpm-verify/src/cases")).expect("a folder");
                let sources = cases.filter_map(|entry| fs::read_to_string(entry.expect("an entry").path()).ok());
                assert!(sources.into_iter().any(|source| source.contains(&text)), "{name}: no case reads so:\n{text}");
            }
            None if kind == "sh" => {
                for line in text.lines() {
                    run(line, folder.path());
                    commands += 1;
                }
            }
            _ => {}
        }
    }
    assert!(commands > 0, "{name}");
}

#[test]
fn tutorial() {
    follow("tutorial.md");
}

/// Python is no part of what is needed to test; where it is, the code of the chapter is run.
#[test]
fn own_code() {
    if Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success()) {
        follow("own-code.md");
    } else {
        eprintln!("own-code.md: no python3 here");
    }
}

#[test]
fn free_surface() {
    follow("free-surface.md");
}

#[test]
fn reports() {
    follow("reports.md");
}

#[test]
fn extending() {
    follow("extending.md");
}

#[test]
fn reliability() {
    follow("reliability.md");
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

//! Records a hash of the sources and the compiler for the manifest of reports, and embeds the scenes and cases of `reference-data`.
//! Git is not asked: which commit the sources are is found when a report is written.

#[path = "src/sources.rs"]
mod sources;

use std::fs;
use std::path::Path;
use std::process::Command;

use sha2::{Digest, Sha256};

fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.lines().next().unwrap_or("").to_owned())
}

/// Folders whose files of an ending the program carries, each as a list of names and texts in a file of its name.
const EMBEDDED: [(&str, &str); 7] = [
    ("cases", "toml"),
    ("gallery", "toml"),
    ("mutants", "patch"),
    ("others", "toml"),
    ("protocol", "toml"),
    ("scenes", "toml"),
    ("slopes", "toml"),
];

/// Writes `NAME.rs` with the names and texts of all such files of a folder, in the order of their names.
fn embed(workspace: &Path, name: &str, ending: &str, out: &Path) -> std::io::Result<()> {
    let folder = workspace.join("reference-data").join(name);
    let mut files: Vec<_> = fs::read_dir(&folder)?.flatten().map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|other| other == ending));
    files.sort();
    let entry = |path: &std::path::PathBuf| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        format!("    ({stem:?}, include_str!({path:?})),\n")
    };
    let entries: String = files.iter().map(entry).collect();
    fs::write(out.join(format!("{name}.rs")), format!("&[\n{entries}]\n"))
}

fn main() {
    let manifest = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let workspace = Path::new(&manifest).parent().unwrap_or(Path::new(".."));
    let hash = sources::hash(workspace, |bytes| format!("{:x}", Sha256::digest(bytes)));
    println!("cargo::rustc-env=MPM_SOURCES={}", hash.unwrap_or_else(|error| panic!("sources: {error}")));
    sources::ROOTS.iter().for_each(|root| println!("cargo::rerun-if-changed={}", workspace.join(root).display()));
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let compiler = first_line(&rustc, &["--version"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=MPM_COMPILER={compiler}");
    // Where cargo builds for a profile: target/PROFILE/build/PACKAGE/out.
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    let profile =
        Path::new(&out).ancestors().nth(3).and_then(|folder| folder.file_name()?.to_str()).unwrap_or("unknown");
    println!("cargo::rustc-env=MPM_PROFILE={profile}");
    println!("cargo::rustc-env=MPM_TARGET={}", std::env::var("TARGET").unwrap_or_default());
    for (name, ending) in EMBEDDED {
        embed(workspace, name, ending, Path::new(&out))
            .unwrap_or_else(|error| panic!("reference-data/{name}: {error}"));
    }
}

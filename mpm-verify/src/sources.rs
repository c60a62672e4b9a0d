//! The files that the program consists of, and their hash. `build.rs` includes this file, so that the build and the running program
//! read the same files in the same way.

use std::fs;
use std::io;
use std::path::Path;

/// Files and folders that the program consists of, from the root of the workspace. Tests, `mpm-bench` and reports are none of it;
/// accepted values (`reference-data/baselines`) are its results.
pub const ROOTS: [&str; 20] = [
    "Cargo.lock",
    "Cargo.toml",
    "mpm-core/Cargo.toml",
    "mpm-core/src",
    "mpm-verify/Cargo.toml",
    "mpm-verify/assets",
    "mpm-verify/build.rs",
    "mpm-verify/docs",
    "mpm-verify/src",
    "reference-data/cases",
    "reference-data/exact",
    "reference-data/gallery",
    "reference-data/literature",
    "reference-data/mutants",
    "reference-data/others",
    "reference-data/paper",
    "reference-data/protocol",
    "reference-data/renames.csv",
    "reference-data/scenes",
    "reference-data/slopes",
];

/// Hash of the names and contents of all files of [`ROOTS`] in a workspace, 16 hexadecimal digits, from a `digest` in such digits.
/// Carriage returns do not count, so that checkouts of all systems agree; hidden files are those of editors.
///
/// # Errors
/// A file that is missing or cannot be read.
pub fn hash(workspace: &Path, digest: impl Fn(&[u8]) -> String) -> io::Result<String> {
    let mut files = Vec::new();
    ROOTS.iter().try_for_each(|root| list(workspace, root, &mut files))?;
    files.sort();
    let mut sums = String::new();
    for file in files {
        let mut bytes = fs::read(workspace.join(&file))?;
        bytes.retain(|byte| *byte != b'\r');
        sums += &format!("{}  {file}\n", digest(&bytes));
    }
    Ok(digest(sums.as_bytes())[..16].to_owned())
}

/// Adds a file, or the files of a folder, by their paths from the workspace.
fn list(workspace: &Path, path: &str, files: &mut Vec<String>) -> io::Result<()> {
    if !workspace.join(path).is_dir() {
        files.push(path.to_owned());
        return Ok(());
    }
    for entry in fs::read_dir(workspace.join(path))? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if !name.starts_with('.') {
            list(workspace, &format!("{path}/{name}"), files)?;
        }
    }
    Ok(())
}

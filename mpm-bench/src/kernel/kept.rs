//! What was measured by the same build is not measured again: `kernel.json`.

use std::fs;
use std::io;
use std::path::Path;

use mpm_verify::files;
use serde::{Deserialize, Serialize};

use super::{Kernel, measure};
use crate::sweep::SweepError;

/// The file.
pub(crate) const NAME: &str = "kernel.json";

/// What the file holds.
#[derive(Debug, Serialize, Deserialize)]
struct Kept {
    build: String,
    quick: bool,
    kernel: Kernel,
}

/// Findings of an earlier run, and its build; whether it was a quick look.
fn read(folder: &Path) -> Option<Kept> {
    serde_json::from_slice(&fs::read(folder.join(NAME)).ok()?).ok()
}

/// Findings of an earlier run of any build.
pub fn stored(folder: &Path) -> Option<Kernel> {
    read(folder).map(|kept| kept.kernel)
}

/// Copies what an earlier run found to another folder, if it found something.
///
/// # Errors
/// A file that cannot be written.
pub fn copy(from: &Path, to: &Path) -> io::Result<()> {
    read(from).map_or(Ok(()), |kept| keep(to, &kept))
}

/// What an earlier run of this build found with as much effort or more.
fn kept(folder: &Path, build: &str, quick: bool) -> Option<Kernel> {
    read(folder).filter(|kept| kept.build == build && (quick || !kept.quick)).map(|kept| kept.kernel)
}

fn keep(folder: &Path, kept: &Kept) -> io::Result<()> {
    files::write(&folder.join(NAME), serde_json::to_string(kept)?.as_bytes())
}

/// What was kept in a folder, or what is measured now and kept there.
///
/// # Errors
/// As [`measure`], or a file that cannot be written.
pub fn kept_or_measured(
    folder: &Path,
    build: &str,
    (quick, fresh): (bool, bool),
    say: &dyn Fn(&str),
) -> Result<Kernel, SweepError> {
    if let Some(kernel) = kept(folder, build, quick).filter(|_| !fresh) {
        return Ok(kernel);
    }
    let found = Kept { build: build.to_owned(), quick, kernel: measure(quick, say)? };
    keep(folder, &found).map_err(SweepError::Kernel)?;
    Ok(found.kernel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::kernel::tests::example;

    #[test]
    fn another_build_and_a_quick_look_are_not_taken_over() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        assert!(kept(folder, "one", true).is_none());
        let save = |quick| {
            keep(folder, &Kept { build: "one".to_owned(), quick, kernel: example() }).expect("a file");
        };
        save(true);
        assert_eq!(kept(folder, "one", true), Some(example()), "the same to the last digit");
        assert!(kept(folder, "one", false).is_none() && kept(folder, "two", true).is_none());
        save(false);
        assert!(kept(folder, "one", true).is_some() && kept(folder, "one", false).is_some());
        fs::write(folder.join(NAME), "{\"build\"").expect("half a file");
        assert!(kept(folder, "one", true).is_none());
    }
}

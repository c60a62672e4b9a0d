//! A copy of the source with every fault in it, each behind its switch.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::patches::Mutant;
use super::{SWITCH, detected};
use crate::error::Error;

/// What the workspace is made of.
const PARTS: [&str; 7] =
    ["Cargo.toml", "Cargo.lock", "clippy.toml", "mpm-core", "mpm-verify", "mpm-bench", "reference-data"];

/// The switch: a file that is added to `mpm-core`.
const PLANTED: &str = "\
//! Which planted fault is on.

use std::sync::OnceLock;

/// Whether the fault of a number is on.
#[inline]
pub fn is(number: u32) -> bool {
    static ON: OnceLock<u32> = OnceLock::new();
    *ON.get_or_init(|| std::env::var(\"SWITCH\").ok().and_then(|text| text.parse().ok()).unwrap_or(0)) == number
}
";

/// Copies the workspace in `source` to `to` and plants the faults. Files that are the same already keep their times, so that
/// they are not built again, and what faults were detected by before stays out of it. Returns how many files were written.
///
/// # Errors
/// A file that cannot be read or written; a fault that does not fit its file.
pub fn plant(source: &Path, to: &Path, mutants: &[Mutant]) -> Result<usize, Error> {
    let mut files = Vec::new();
    for part in PARTS {
        list(source, Path::new(part), &mut files).map_err(Error::at(source.join(part)))?;
    }
    let mut written = 0;
    for file in &files {
        let own: Vec<(u32, &Mutant)> =
            (1..).zip(mutants).filter(|(_, mutant)| Path::new(&mutant.file) == file.as_path()).collect();
        if file == Path::new(detected::FILE) && to.join(file).is_file() {
            continue;
        }
        let path = source.join(file);
        let mut bytes = fs::read(&path).map_err(Error::at(&path))?;
        if !own.is_empty() {
            bytes = with_faults(&String::from_utf8_lossy(&bytes), &own)?.into_bytes();
        }
        if file == Path::new("mpm-core/src/lib.rs") {
            bytes.extend_from_slice(b"\n/// Planted faults.\npub mod planted;\n");
        }
        written += usize::from(put(&to.join(file), &bytes)?);
    }
    let planted = PLANTED.replace("SWITCH", SWITCH);
    written += usize::from(put(&to.join("mpm-core/src/planted.rs"), planted.as_bytes())?);
    for mutant in mutants {
        if !files.iter().any(|file| Path::new(&mutant.file) == file.as_path()) {
            return Err(Error::Found(format!("expected the file {} in the source", mutant.file)).of(mutant.name));
        }
    }
    Ok(written)
}

/// Whether a file had to be written.
fn put(path: &Path, bytes: &[u8]) -> Result<bool, Error> {
    if fs::read(path).is_ok_and(|known| known == bytes) {
        return Ok(false);
    }
    let write = || {
        path.parent().map_or(Ok(()), fs::create_dir_all)?;
        fs::write(path, bytes)
    };
    write().map(|()| true).map_err(Error::at::<io::Error>(path))
}

/// Files below a path, from the root of the source; what builds leave is no source.
fn list(root: &Path, path: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    let whole = root.join(path);
    if whole.is_file() {
        files.push(path.to_owned());
        return Ok(());
    }
    for entry in fs::read_dir(&whole)? {
        let name = entry?.file_name();
        if name != "target" && name != ".git" {
            list(root, &path.join(name), files)?;
        }
    }
    Ok(())
}

/// A text with faults in it, each behind its number.
fn with_faults(text: &str, mutants: &[(u32, &Mutant)]) -> Result<String, Error> {
    let switched = |(number, mutant): &(u32, &Mutant)| {
        let krate = if mutant.file.starts_with("mpm-core/") { "crate" } else { "mpm_core" };
        mutant.switched(text, &format!("{krate}::planted::is({number})"))
    };
    let mut pieces = mutants.iter().map(switched).collect::<Result<Vec<_>, Error>>()?;
    pieces.sort_by_key(|(place, _)| place.start);
    if let Some(pair) = pieces.windows(2).find(|pair| pair[0].0.end > pair[1].0.start) {
        return Err(Error::Found(format!("two faults in one place: {} and {}", pair[0].1, pair[1].1)));
    }
    let mut planted = text.to_owned();
    for (place, piece) in pieces.iter().rev() {
        planted.replace_range(place.clone(), piece);
    }
    Ok(planted)
}

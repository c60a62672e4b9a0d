//! A copy of the source with every fault in it, each behind its switch.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::SWITCH;
use super::table::Mutant;
use crate::error::Error::{self, Unfit};

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
/// they are not built again. Returns how many files were written.
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
            (1..).zip(mutants).filter(|(_, mutant)| Path::new(mutant.file) == file.as_path()).collect();
        let path = source.join(file);
        let mut bytes = fs::read(&path).map_err(Error::at(&path))?;
        if !own.is_empty() {
            let mut text = String::from_utf8_lossy(&bytes).into_owned();
            for (number, mutant) in own {
                text = with_fault(&text, number, mutant)?;
            }
            bytes = text.into_bytes();
        }
        if file == Path::new("mpm-core/src/lib.rs") {
            bytes.extend_from_slice(b"\n/// Planted faults.\npub mod planted;\n");
        }
        written += usize::from(put(&to.join(file), &bytes)?);
    }
    let planted = PLANTED.replace("SWITCH", SWITCH);
    written += usize::from(put(&to.join("mpm-core/src/planted.rs"), planted.as_bytes())?);
    for mutant in mutants {
        if !files.iter().any(|file| Path::new(mutant.file) == file.as_path()) {
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

/// A text with a fault in it.
fn with_fault(text: &str, number: u32, mutant: &Mutant) -> Result<String, Error> {
    let Mutant { name, file, find, replace, .. } = mutant;
    let found = text.matches(find).count();
    if found != 1 {
        return Err(Error::refused(name, format!("`{find}` once in {file}"), format!("it {found} times")));
    }
    let krate = if file.starts_with("mpm-core/") { "crate" } else { "mpm_core" };
    let on = format!("{krate}::planted::is({number})");
    let planted = match (find.strip_prefix("let "), replace.strip_prefix("let ")) {
        (Some(_), Some(_)) => {
            // A name that is bound must outlive the choice.
            let halves = |text: &str| {
                let text = text.trim_end_matches(';');
                text.split_once(" = ").map(|(name, value)| (name.to_owned(), value.to_owned()))
            };
            let (Some((bound, sound)), Some((other, spoilt))) = (halves(find), halves(replace)) else {
                return Err(Unfit("expected `let NAME = VALUE;`").of(name));
            };
            if bound != other {
                return Err(Error::refused(name, "the same name bound", format!("{bound} and {other}")));
            }
            format!("{bound} = if {on} {{ {spoilt} }} else {{ {sound} }};")
        }
        _ if find.ends_with([';', '}']) => format!("if {on} {{ {replace} }} else {{ {find} }}"),
        _ => format!("(if {on} {{ {replace} }} else {{ {find} }})"),
    };
    Ok(text.replacen(find, &planted, 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mutant(find: &'static str, replace: &'static str) -> Mutant {
        Mutant { name: "a", what: "", file: "mpm-core/src/a.rs", find, replace }
    }

    #[test]
    fn expressions_statements_and_bindings_get_a_switch() {
        let planted = |text: &str, find, replace| with_fault(text, 3, &mutant(find, replace)).expect("it fits");
        assert_eq!(planted("x = a + b;", "a + b", "a - b"), "x = (if crate::planted::is(3) { a - b } else { a + b });");
        assert_eq!(planted("{ go(); }", "go();", "stop();"), "{ if crate::planted::is(3) { stop(); } else { go(); } }");
        let bound = planted("let mut x = 1.0;", "let mut x = 1.0;", "let mut x = 2.0;");
        assert_eq!(bound, "let mut x = if crate::planted::is(3) { 2.0 } else { 1.0 };");
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let refused =
            |text: &str, find, replace| with_fault(text, 3, &mutant(find, replace)).expect_err("refused").to_string();
        assert!(refused("a a", "a", "b").contains("found it 2 times"));
        assert!(refused("c", "a", "b").contains("found it 0 times"));
        assert!(refused("let x = 1;", "let x = 1;", "let y = 1;").contains("the same name"));
    }
}

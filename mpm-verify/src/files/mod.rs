//! Files that are whole or not there: written under another name, brought to the disk, renamed.
//!
//! [`write()`]: one file. [`Folder`]: all files of a run, by one process at a time, published together at its end.

mod folder;

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

pub use folder::{Folder, FolderError, RECORD, STAGE};

/// Beginning and end of the names under which files are written: no other program's.
const PART: [&str; 2] = [".mpm-verify.", ".part"];

/// Writes a file whole: whatever happens meanwhile, its name stands for the old bytes or the new ones.
///
/// A link of that name is replaced, not followed. Two processes must not write one file at once ([`Folder`] sees to that).
///
/// # Errors
/// What the system says, or what stands there in place of a file; it is then as it was.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let part = part_of(path)?;
    if fs::symlink_metadata(path).is_ok_and(|there| !there.is_file() && !there.is_symlink()) {
        return Err(io::Error::other("no regular file"));
    }
    // One that is left over may be a link to somewhere: it is taken away, never opened.
    match fs::remove_file(&part) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
        _ => {}
    }
    let written = || {
        let mut file = OpenOptions::new().write(true).create_new(true).open(&part)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&part, path)
    };
    if let Err(e) = written() {
        // What could not be written whole is of no use; that it is there is said by the error.
        let _ = fs::remove_file(&part);
        return Err(e);
    }
    settle(path)
}

/// The name under which a file is written.
pub fn part_of(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "no name of a file"))?;
    let mut part = std::ffi::OsString::from(PART[0]);
    part.push(name);
    part.push(PART[1]);
    Ok(path.with_file_name(part))
}

/// Brings a new name to the disk: that is done once its folder is. Not every system opens folders.
fn settle(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    File::open(folder).and_then(|folder| folder.sync_all()).or(Ok(()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_leaves_no_part() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.csv");
        write(&path, b"one").expect("written");
        fs::write(part_of(&path).expect("a name"), b"half of").expect("a part that a kill has left");
        write(&path, b"two").expect("written");
        assert_eq!(fs::read(&path).expect("a file"), b"two");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_replaced_and_never_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, precious) = (folder.path().join("a.csv"), folder.path().join("precious"));
        fs::write(&precious, b"precious").expect("written");
        for name in [path.clone(), part_of(&path).expect("a name")] {
            std::os::unix::fs::symlink(&precious, &name).expect("a link");
            write(&path, b"new").expect("written");
            assert_eq!(fs::read(&precious).expect("a file"), b"precious");
            assert_eq!(fs::read(&path).expect("a file"), b"new");
            fs::remove_file(&path).expect("removed");
        }
    }

    #[test]
    fn a_file_that_cannot_be_written_stays_as_it_was() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.csv");
        write(&path, b"one").expect("written");
        // A folder stands where the part would: as good as a full disk.
        fs::create_dir(part_of(&path).expect("a name")).expect("a folder");
        assert!(write(&path, b"two").is_err());
        assert_eq!(fs::read(&path).expect("a file"), b"one");
    }
}

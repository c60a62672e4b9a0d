//! A folder of results: one process writes to it at a time, and what it writes appears when the run has ended.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Held by the process that writes to the folder. The system lets go of it when the process ends, however it ends.
const LOCK: &str = ".lock";
/// Where files are until they are published.
const STAGE: &str = ".part";

/// A folder that this process alone writes to.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    stage: PathBuf,
    /// Locked as long as it is open.
    _lock: File,
}

/// Why a folder cannot be written to.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The system refuses.
    #[error("expected a folder that can be written to, found {}: {cause}", path.display())]
    Refused {
        /// Which file or folder.
        path: PathBuf,
        /// Why.
        #[source]
        cause: io::Error,
    },
    /// Another run writes there.
    #[error("expected a folder that no other run is writing to, found {}: another run holds its {LOCK}", path.display())]
    Taken {
        /// The folder.
        path: PathBuf,
    },
    /// A link stands where a folder of results would be: it leads elsewhere.
    #[error("expected a folder, found a symbolic link: {}", path.display())]
    Link {
        /// The link.
        path: PathBuf,
    },
}

impl Folder {
    /// Makes a folder, proves that it can be written to, and takes it for this process.
    ///
    /// # Errors
    /// It cannot be made or written to, or another run is writing to it.
    pub fn take(path: &Path) -> Result<Self, FolderError> {
        let refused = |cause| FolderError::Refused { path: path.to_owned(), cause };
        fs::create_dir_all(path).map_err(refused)?;
        let lock_path = path.join(LOCK);
        if is_link(&lock_path) {
            return Err(FolderError::Link { path: lock_path });
        }
        let lock = OpenOptions::new().create(true).truncate(false).write(true).open(&lock_path).map_err(refused)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(FolderError::Taken { path: path.to_owned() }),
            Err(TryLockError::Error(cause)) => return Err(refused(cause)),
        }
        let stage = path.join(STAGE);
        clear(&stage).map_err(refused)?;
        fs::create_dir(&stage).map_err(refused)?;
        Ok(Self { path: path.to_owned(), stage, _lock: lock })
    }

    /// The folder itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where to write what is to appear in the folder.
    pub fn stage(&self) -> &Path {
        &self.stage
    }

    /// Lets everything that was written appear, each file in place of the one before.
    ///
    /// # Errors
    /// A file cannot be moved, or a link stands where a folder would be.
    pub fn publish(&self) -> Result<(), FolderError> {
        self.move_all(&self.stage, &self.path)
    }

    fn move_all(&self, from: &Path, to: &Path) -> Result<(), FolderError> {
        let refused = |path: &Path| {
            let path = path.to_owned();
            move |cause| FolderError::Refused { path, cause }
        };
        let mut entries: Vec<PathBuf> = Vec::new();
        for entry in fs::read_dir(from).map_err(refused(from))? {
            entries.push(entry.map_err(refused(from))?.path());
        }
        // Pages last: what they show is there before them.
        entries.sort_by_key(|path| (path.extension().is_some_and(|e| e == "html"), path.clone()));
        for source in entries {
            let Some(name) = source.file_name() else { continue };
            let target = to.join(name);
            if source.is_dir() {
                if is_link(&target) {
                    return Err(FolderError::Link { path: target });
                }
                fs::create_dir_all(&target).map_err(refused(&target))?;
                self.move_all(&source, &target)?;
            } else {
                // Flushing needs the right to write on some systems.
                let file = OpenOptions::new().append(true).open(&source).map_err(refused(&source))?;
                file.sync_all().map_err(refused(&source))?;
                fs::rename(&source, &target).map_err(refused(&target))?;
            }
        }
        super::settle(&to.join(STAGE)).map_err(refused(to))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left there was not published; the next run would clear it.
        let _ = clear(&self.stage);
    }
}

fn is_link(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_symlink())
}

/// Removes a folder or whatever stands in its place; a link itself, not what it leads to.
fn clear(path: &Path) -> io::Result<()> {
    match fs::symlink_metadata(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(e) => Err(e),
        Ok(metadata) if metadata.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(path: &Path) -> Vec<String> {
        let entries = fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn what_is_written_appears_when_it_is_published() {
        let root = tempfile::tempdir().expect("a folder");
        let path = root.path().join("reports");
        let folder = Folder::take(&path).expect("taken");
        fs::create_dir(folder.stage().join("plots")).expect("a folder");
        fs::write(folder.stage().join("plots/a.csv"), "new").expect("written");
        fs::write(folder.stage().join("index.html"), "new").expect("written");
        fs::write(path.join("index.html"), "old").expect("written");
        assert_eq!(names(&path), [".lock", ".part", "index.html"]);
        folder.publish().expect("published");
        drop(folder);
        assert_eq!(names(&path), [".lock", "index.html", "plots"]);
        assert_eq!(fs::read_to_string(path.join("index.html")).expect("a file"), "new");
        let folder = Folder::take(&path).expect("free again");
        fs::write(folder.stage().join("index.html"), "newer").expect("written");
        drop(folder);
        assert_eq!(fs::read_to_string(path.join("index.html")).expect("a file"), "new", "not published");
    }

    #[test]
    fn two_runs_into_one_folder_are_refused() {
        let root = tempfile::tempdir().expect("a folder");
        let folder = Folder::take(root.path()).expect("taken");
        let second = Folder::take(root.path()).expect_err("taken").to_string();
        assert!(second.contains("another run holds its .lock"), "{second}");
        drop(folder);
        assert!(Folder::take(root.path()).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn links_do_not_lead_out() {
        use std::os::unix::fs::symlink;
        let (root, other) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        fs::write(other.path().join("a.csv"), "precious").expect("written");
        symlink(other.path(), root.path().join(STAGE)).expect("a link");
        let folder = Folder::take(root.path()).expect("taken");
        assert_eq!(names(other.path()), ["a.csv"], "the stage was a link, and is a folder now");
        symlink(other.path().join("a.csv"), root.path().join("a.csv")).expect("a link");
        symlink(other.path(), root.path().join("plots")).expect("a link");
        fs::write(folder.stage().join("a.csv"), "new").expect("written");
        folder.publish().expect("published");
        assert_eq!(fs::read_to_string(root.path().join("a.csv")).expect("a file"), "new");
        fs::create_dir(folder.stage().join("plots")).expect("a folder");
        fs::write(folder.stage().join("plots/a.csv"), "new").expect("written");
        assert!(matches!(folder.publish(), Err(FolderError::Link { .. })));
        assert_eq!(fs::read_to_string(other.path().join("a.csv")).expect("a file"), "precious");
        drop(folder);
        symlink(other.path(), root.path().join("lock")).expect("a link");
        fs::remove_file(root.path().join(LOCK)).expect("removed");
        fs::rename(root.path().join("lock"), root.path().join(LOCK)).expect("renamed");
        assert!(matches!(Folder::take(root.path()), Err(FolderError::Link { .. })));
    }
}

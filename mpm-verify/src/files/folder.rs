//! A folder of results: one process writes to it at a time, what it writes appears when the run has ended, and what an earlier run left
//! goes then. Files of others stay as they are.
//!
//! [`RECORD`] lists the files of the last run. A run is published in three steps, each of which can be done again after a kill: the record
//! names the files of both runs and a second one, in the stage, those of the new run alone; the files of the old run go and those of
//! the new one come; the second record takes the place of the first.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Component, Path, PathBuf};

/// Held by the process that writes to the folder. The system lets go of it when the process ends, however it ends.
const LOCK: &str = ".lock";
/// Where files are until they are published. The name is this program's: what is found there is its own.
pub const STAGE: &str = ".mpm-verify.part";
/// The files of the last run: a line for the kind of the run, and one for each file.
pub const RECORD: &str = ".mpm-verify.results";
/// The record of a run that is being published, in the stage.
const NEXT: &str = ".next";
/// Longest file that is looked into for signs of an earlier version of this program, bytes.
const LOOKED_INTO: u64 = 64 << 20;

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
    /// The root of a file system.
    #[error("expected a folder for results, found the root of the file system")]
    Root,
    /// Something stands where a result would be.
    #[error(
        "expected nothing there, or a result of this program, found {}: it is not in {RECORD} and was left as it is; move it away, or \
         choose another folder", path.display()
    )]
    Foreign {
        /// What stands there.
        path: PathBuf,
    },
    /// The same, once there were results.
    #[error("{cause}. What was computed is in {}", kept.display())]
    Unpublished {
        /// What stands there.
        cause: Box<FolderError>,
        /// Where the results are.
        kept: PathBuf,
    },
}

/// The files of a run.
#[derive(Debug, Clone, Default, PartialEq)]
struct Record {
    kind: String,
    files: BTreeSet<PathBuf>,
}

impl Record {
    fn text(&self) -> String {
        let line = |file: &PathBuf| {
            let parts: Vec<String> = file.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            parts.join("/") + "\n"
        };
        format!("{}\n{}", self.kind, self.files.iter().map(line).collect::<String>())
    }

    /// A path that leads out of the folder is none of a result.
    fn parse(text: &str) -> Self {
        let inside = |path: &PathBuf| path.components().all(|part| matches!(part, Component::Normal(_)));
        let mut lines = text.lines();
        let kind = lines.next().unwrap_or_default().to_owned();
        Self { kind, files: lines.filter(|line| !line.is_empty()).map(PathBuf::from).filter(inside).collect() }
    }

    /// None where nothing was published yet.
    fn read(path: &Path) -> io::Result<Option<Self>> {
        match fs::read_to_string(path) {
            Ok(text) => Ok(Some(Self::parse(&text))),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(e),
        }
    }
}

/// A path is refused with what the system says.
fn refused(path: &Path) -> impl FnOnce(io::Error) -> FolderError {
    let path = path.to_owned();
    move |cause| FolderError::Refused { path, cause }
}

impl Folder {
    /// Makes a folder, proves that it can be written to, and takes it for this process.
    ///
    /// # Errors
    /// It cannot be made or written to, it is the root of the file system, or another run is writing to it.
    pub fn take(path: &Path) -> Result<Self, FolderError> {
        fs::create_dir_all(path).map_err(refused(path))?;
        if path.canonicalize().map_err(refused(path))?.parent().is_none() {
            return Err(FolderError::Root);
        }
        let lock_path = path.join(LOCK);
        match fs::symlink_metadata(&lock_path) {
            Ok(there) if there.is_symlink() => return Err(FolderError::Link { path: lock_path }),
            // A pipe would be waited for.
            Ok(there) if !there.is_file() => return Err(FolderError::Foreign { path: lock_path }),
            _ => {}
        }
        let lock =
            OpenOptions::new().create(true).truncate(false).write(true).open(&lock_path).map_err(refused(path))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(FolderError::Taken { path: path.to_owned() }),
            Err(TryLockError::Error(cause)) => return Err(refused(path)(cause)),
        }
        let folder = Self { path: path.to_owned(), stage: path.join(STAGE), _lock: lock };
        // A run that was killed while it was published is published now.
        if !is_link(&folder.stage) && folder.stage.join(NEXT).is_file() {
            folder.exchange()?;
        }
        clear(&folder.stage).map_err(refused(path))?;
        fs::create_dir(&folder.stage).map_err(refused(path))?;
        Ok(folder)
    }

    /// The folder itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where to write what is to appear in the folder.
    pub fn stage(&self) -> &Path {
        &self.stage
    }

    /// Whether results of these names can be published, before anything is computed.
    ///
    /// # Errors
    /// Something that is not of this program stands there.
    pub fn has_room_for(&self, names: &[&str]) -> Result<(), FolderError> {
        let known = self.known()?;
        names.iter().try_for_each(|name| self.is_free(Path::new(name), &known))
    }

    /// Lets everything that was written appear in place of all that earlier runs left. Nothing happens where nothing was written.
    ///
    /// # Errors
    /// A file cannot be moved, or something that is not of this program stands where it would be.
    pub fn publish(&self) -> Result<(), FolderError> {
        self.publish_beside("run", &|_| false)
    }

    /// [`Folder::publish`] for a run of a kind: what earlier runs of the same kind left, and `stays`, stays.
    ///
    /// # Errors
    /// As [`Folder::publish`].
    pub fn publish_beside(&self, kind: &str, stays: &dyn Fn(&Path) -> bool) -> Result<(), FolderError> {
        let mut own = BTreeSet::new();
        list(&self.stage, Path::new(""), &mut own).map_err(refused(&self.stage))?;
        if own.is_empty() {
            return Ok(());
        }
        let known = self.known()?;
        if let Err(cause) = own.iter().try_for_each(|file| self.is_free(file, &known)) {
            return Err(self.beside(cause));
        }
        for file in &own {
            // Flushing needs the right to write on some systems.
            let path = self.stage.join(file);
            let flush = OpenOptions::new().append(true).open(&path).and_then(|file| file.sync_all());
            flush.map_err(refused(&path))?;
        }
        let known = known.unwrap_or_default();
        let same = known.kind == kind;
        let mut next = Record { kind: kind.to_owned(), files: own };
        next.files.extend(known.files.iter().filter(|file| same && stays(file)).cloned());
        let both = Record { kind: known.kind, files: known.files.union(&next.files).cloned().collect() };
        let record = self.path.join(RECORD);
        super::write(&record, both.text().as_bytes()).map_err(refused(&record))?;
        super::write(&self.stage.join(NEXT), next.text().as_bytes()).map_err(refused(&self.stage))?;
        self.exchange()
    }

    /// Takes the files of the old run away, and lets those of the new one appear. What was done before a kill is not done again.
    fn exchange(&self) -> Result<(), FolderError> {
        let (record, next) = (self.path.join(RECORD), self.stage.join(NEXT));
        let known = Record::read(&record).map_err(refused(&record))?.unwrap_or_default();
        let wanted = Record::read(&next).map_err(refused(&next))?.unwrap_or_default();
        let mut own = BTreeSet::new();
        list(&self.stage, Path::new(""), &mut own).map_err(refused(&self.stage))?;
        // A file that is wanted and no longer in the stage has been moved, or stays.
        for file in known.files.iter().filter(|file| own.contains(*file) || !wanted.files.contains(*file)) {
            let path = self.path.join(file);
            // What others have put in its place is theirs.
            if self.through_folders(file).is_err() || !fs::symlink_metadata(&path).is_ok_and(|there| there.is_file()) {
                continue;
            }
            fs::remove_file(&path).map_err(refused(&path))?;
            for above in file.ancestors().skip(1).filter(|above| !above.as_os_str().is_empty()) {
                // One that is not empty stays.
                let _ = fs::remove_dir(self.path.join(above));
            }
        }
        let mut own: Vec<PathBuf> = own.into_iter().collect();
        // Pages last: what they show is there before them.
        own.sort_by_key(|file| (file.extension().is_some_and(|e| e == "html"), file.clone()));
        for file in &own {
            let target = self.path.join(file);
            self.through_folders(file)?;
            target.parent().map_or(Ok(()), fs::create_dir_all).map_err(refused(&target))?;
            fs::rename(self.stage.join(file), &target).map_err(refused(&target))?;
            super::settle(&target).map_err(refused(&target))?;
        }
        fs::rename(&next, &record).map_err(refused(&record))?;
        super::settle(&record).map_err(refused(&record))
    }

    /// What earlier runs have left; none where there is no record.
    fn known(&self) -> Result<Option<Record>, FolderError> {
        let path = self.path.join(RECORD);
        Record::read(&path).map_err(refused(&path))
    }

    /// Whether a result may stand in a place: nothing does, or a file that an earlier run left there.
    fn is_free(&self, file: &Path, known: &Option<Record>) -> Result<(), FolderError> {
        self.through_folders(file)?;
        let path = self.path.join(file);
        let Ok(there) = fs::symlink_metadata(&path) else { return Ok(()) };
        let own = match known {
            Some(known) => known.files.contains(file),
            None => is_of_an_earlier_version(&self.path),
        };
        if own && there.is_file() { Ok(()) } else { Err(FolderError::Foreign { path }) }
    }

    /// Whether all that stands above a file in the folder is a folder.
    fn through_folders(&self, file: &Path) -> Result<(), FolderError> {
        for above in file.ancestors().skip(1).filter(|above| !above.as_os_str().is_empty()) {
            let path = self.path.join(above);
            match fs::symlink_metadata(&path) {
                Ok(there) if there.is_symlink() => return Err(FolderError::Link { path }),
                Ok(there) if !there.is_dir() => return Err(FolderError::Foreign { path }),
                _ => {}
            }
        }
        Ok(())
    }

    /// Keeps what cannot be published.
    fn beside(&self, cause: FolderError) -> FolderError {
        let name = |n: u32| self.path.join(if n == 1 { "unpublished".to_owned() } else { format!("unpublished-{n}") });
        let Some(kept) = (1..1000).map(name).find(|path| fs::symlink_metadata(path).is_err()) else { return cause };
        match fs::rename(&self.stage, &kept) {
            Ok(()) => FolderError::Unpublished { cause: Box::new(cause), kept },
            Err(_) => cause,
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left there was not published; the next run would clear it. What is half published, the next run publishes.
        if !self.stage.join(NEXT).is_file() {
            let _ = clear(&self.stage);
        }
    }
}

/// Files below a folder that are results.
fn list(root: &Path, below: &Path, files: &mut BTreeSet<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(root.join(below))? {
        let entry = entry?;
        let name = entry.file_name();
        // The next record, and what a kill has left of one.
        if name == NEXT || name.to_string_lossy().starts_with(super::PART[0]) {
            continue;
        }
        let path = below.join(name);
        if entry.file_type()?.is_dir() {
            list(root, &path, files)?;
        } else {
            files.insert(path);
        }
    }
    Ok(())
}

/// Versions without a record left the conditions of a run in its folder, or a history of nights.
fn is_of_an_earlier_version(folder: &Path) -> bool {
    let text = |name: &str| mpm_core::scene::read_text(&folder.join(name), LOOKED_INTO).unwrap_or_default();
    let conditions =
        |name| Some(text(name)).is_some_and(|text| text.contains("\"scene_hash\"") && text.contains("\"mpm-"));
    conditions("manifest.json")
        || conditions("summary.json")
        || conditions("shard.json")
        || text("history.csv").starts_with("date,commit,case,quantity,value")
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

    /// Publishes files of one run.
    fn run(path: &Path, files: &[&str]) -> Result<(), FolderError> {
        let folder = Folder::take(path).expect("taken");
        write(&folder, files);
        folder.publish()
    }

    fn write(folder: &Folder, files: &[&str]) {
        for file in files {
            let path = folder.stage().join(file);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, "new").expect("written");
        }
    }

    #[test]
    fn what_is_written_appears_when_it_is_published() {
        let root = tempfile::tempdir().expect("a folder");
        let path = root.path().join("reports");
        run(&path, &["index.html"]).expect("published");
        fs::write(path.join("index.html"), "old").expect("written");
        let folder = Folder::take(&path).expect("taken");
        write(&folder, &["plots/a.csv", "index.html"]);
        assert_eq!(names(&path), [".lock", ".mpm-verify.part", RECORD, "index.html"]);
        folder.publish().expect("published");
        drop(folder);
        assert_eq!(names(&path), [".lock", RECORD, "index.html", "plots"]);
        assert_eq!(fs::read_to_string(path.join("index.html")).expect("a file"), "new");
        let folder = Folder::take(&path).expect("free again");
        fs::write(folder.stage().join("index.html"), "newer").expect("written");
        drop(folder);
        assert_eq!(fs::read_to_string(path.join("index.html")).expect("a file"), "new", "not published");
    }

    #[test]
    fn results_are_those_of_one_run_and_files_of_others_stay() {
        let root = tempfile::tempdir().expect("a folder");
        let path = root.path();
        fs::write(path.join("notes.txt"), "mine").expect("written");
        fs::create_dir_all(path.join(".part")).expect("a folder");
        fs::write(path.join(".part/theirs"), "theirs").expect("written");
        fs::write(path.join("history.csv.part"), "theirs").expect("written");
        run(path, &["history.csv", "plots/a.svg", "plots/b.svg"]).expect("published");
        fs::write(path.join("plots/mine.svg"), "mine").expect("written");
        run(path, &["history.csv", "water.csv"]).expect("published");
        let there = [".lock", RECORD, ".part", "history.csv", "history.csv.part", "notes.txt", "plots", "water.csv"];
        assert_eq!(names(path), there);
        assert_eq!(
            (names(&path.join("plots")), names(&path.join(".part"))),
            (vec!["mine.svg".into()], vec!["theirs".into()])
        );
        // Nothing written: what is there stays as a whole.
        Folder::take(path).expect("taken").publish().expect("nothing");
        assert_eq!(names(path), there);
        // A record that leads out of the folder takes nothing away.
        let out = path.join("out");
        fs::create_dir(&out).expect("a folder");
        fs::write(out.join(RECORD), "run\n../notes.txt\n/tmp\n").expect("written");
        run(&out, &["history.csv"]).expect("published");
        assert_eq!(fs::read_to_string(path.join("notes.txt")).expect("a file"), "mine");
    }

    #[test]
    fn what_is_not_in_the_record_is_not_replaced_and_no_result_is_lost() {
        let root = tempfile::tempdir().expect("a folder");
        let path = root.path();
        fs::write(path.join("history.csv"), "theirs").expect("written");
        let folder = Folder::take(path).expect("taken");
        assert!(matches!(folder.has_room_for(&["history.csv"]), Err(FolderError::Foreign { .. })));
        folder.has_room_for(&["summary.json"]).expect("room");
        drop(folder);
        let error = run(path, &["history.csv", "summary.json"]).expect_err("refused");
        assert!(error.to_string().contains("What was computed is in"), "{error}");
        assert_eq!(fs::read_to_string(path.join("history.csv")).expect("a file"), "theirs");
        assert_eq!(names(&path.join("unpublished")), ["history.csv", "summary.json"]);
        assert!(!path.join("summary.json").exists());
        // A folder in place of a file that was there before.
        fs::remove_file(path.join("history.csv")).expect("removed");
        run(path, &["history.csv"]).expect("published");
        fs::remove_file(path.join("history.csv")).expect("removed");
        fs::create_dir(path.join("history.csv")).expect("a folder");
        assert!(matches!(run(path, &["history.csv"]), Err(FolderError::Unpublished { .. })));
        run(path, &["water.csv"]).expect("it is left alone");
        assert!(path.join("history.csv").is_dir());
    }

    #[test]
    fn a_run_that_is_killed_while_it_is_published_is_published_by_the_next_one() {
        // After so many of the steps: old files taken away, then new ones moved.
        for steps in 0..=4 {
            let root = tempfile::tempdir().expect("a folder");
            let path = root.path();
            run(path, &["a.csv", "old.csv"]).expect("published");
            fs::write(path.join("a.csv"), "old").expect("written");
            let folder = Folder::take(path).expect("taken");
            write(&folder, &["a.csv", "b.csv"]);
            let both = "run\na.csv\nb.csv\nold.csv\n";
            fs::write(path.join(RECORD), both).expect("written");
            fs::write(folder.stage().join(NEXT), "run\na.csv\nb.csv\n").expect("written");
            let moved = |name: &str| fs::rename(folder.stage().join(name), path.join(name));
            let done: [&dyn Fn() -> io::Result<()>; 4] = [
                &|| fs::remove_file(path.join("a.csv")),
                &|| fs::remove_file(path.join("old.csv")),
                &|| moved("a.csv"),
                &|| moved("b.csv"),
            ];
            done.iter().take(steps).for_each(|step| step().expect("done"));
            drop(folder);
            drop(Folder::take(path).expect("taken"));
            assert_eq!(names(path), [".lock", RECORD, "a.csv", "b.csv"], "after {steps} steps");
            assert_eq!(fs::read_to_string(path.join("a.csv")).expect("a file"), "new", "after {steps} steps");
            assert_eq!(fs::read_to_string(path.join(RECORD)).expect("a file"), "run\na.csv\nb.csv\n");
        }
    }

    #[test]
    fn runs_of_a_kind_may_stand_beside_each_other() {
        let root = tempfile::tempdir().expect("a folder");
        let path = root.path();
        let beside = |kind: &str, files: &[&str], stays: &dyn Fn(&Path) -> bool| {
            let folder = Folder::take(path).expect("taken");
            write(&folder, files);
            folder.publish_beside(kind, stays).expect("published");
        };
        beside("levee 1", &["safety.csv"], &|_| true);
        beside("levee 1", &["history.csv", "plots/a.svg"], &|file| file == Path::new("safety.csv"));
        assert_eq!(names(path), [".lock", RECORD, "history.csv", "plots", "safety.csv"]);
        beside("levee 1", &["history.csv"], &|file| file == Path::new("safety.csv"));
        assert_eq!(names(path), [".lock", RECORD, "history.csv", "safety.csv"]);
        beside("levee 2", &["history.csv"], &|file| file == Path::new("safety.csv"));
        assert_eq!(names(path), [".lock", RECORD, "history.csv"]);
    }

    #[cfg(unix)]
    #[test]
    fn the_root_of_the_file_system_is_no_folder_for_results() {
        assert!(matches!(Folder::take(Path::new("/")), Err(FolderError::Root)));
        assert!(matches!(Folder::take(Path::new("/tmp/..")), Err(FolderError::Root)));
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
        drop(folder);
        symlink(other.path().join("a.csv"), root.path().join("a.csv")).expect("a link");
        assert!(run(root.path(), &["a.csv"]).is_err());
        fs::remove_file(root.path().join("a.csv")).expect("removed");
        run(root.path(), &["plots/a.csv"]).expect("published");
        fs::remove_dir_all(root.path().join("plots")).expect("removed");
        symlink(other.path(), root.path().join("plots")).expect("a link");
        assert!(run(root.path(), &["plots/a.csv"]).is_err());
        run(root.path(), &["b.csv"]).expect("nothing behind a link is taken away");
        assert_eq!(fs::read_to_string(other.path().join("a.csv")).expect("a file"), "precious");
        symlink(other.path(), root.path().join("lock")).expect("a link");
        fs::remove_file(root.path().join(LOCK)).expect("removed");
        fs::rename(root.path().join("lock"), root.path().join(LOCK)).expect("renamed");
        assert!(matches!(Folder::take(root.path()), Err(FolderError::Link { .. })));
    }
}

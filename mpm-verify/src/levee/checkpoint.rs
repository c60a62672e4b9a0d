//! A state on disk, to go on from after a stop: all of it is checked before any of it is believed.
//!
//! Layout: magic, version of the layout, build, hash of the plan, length and hash of what follows, then three parts,
//! each with its length: a line of JSON, frames, the state of the driver. It is written under another name, brought to
//! the disk and renamed: a stop while writing leaves the one before.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::moments::{Album, Kept};
use crate::frames;

/// Name of the file in the folder of a run.
pub const NAME: &str = "checkpoint.bin";
const MAGIC: &[u8; 8] = b"MPMLEVEE";
const VERSION: u32 = 1;
/// States of other builds may differ in their layout, and their runs in the last bit.
const BUILD: &str = concat!(env!("CARGO_PKG_VERSION"), " ", env!("MPM_COMMIT"));

/// A state to go on from.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint {
    /// What is not in the other parts.
    pub notes: Notes,
    /// Frames so far.
    pub album: Album,
    /// The driver's own bytes.
    pub state: Vec<u8>,
}

/// Small things.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Notes {
    /// CPU time so far, s.
    pub cpu_s: f64,
    /// Whether the driver of the scene has taken over.
    pub switched: bool,
    /// How frames were taken.
    pub kept: Kept,
}

/// Why there is nothing to go on from.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file cannot be read or written.
    #[error("{}: {cause}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: io::Error,
    },
    /// It was read and refused.
    #[error("{}: expected {expected}, found {found}", path.display())]
    Refused {
        /// Which.
        path: PathBuf,
        /// What would have been accepted.
        expected: String,
        /// What is there.
        found: String,
    },
}

impl Checkpoint {
    /// Writes the file of a folder. `plan` is the fingerprint of the plan.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, plan: &[u8; 32], folder: &Path) -> Result<(), CheckpointError> {
        let (path, part) = (folder.join(NAME), folder.join(format!("{NAME}.part")));
        let written = || {
            let mut file = File::create(&part)?;
            file.write_all(&self.bytes(plan)?)?;
            file.sync_all()?;
            fs::rename(&part, &path)?;
            // The new name is on the disk once its folder is. Not every system opens folders.
            File::open(folder).and_then(|folder| folder.sync_all()).or(Ok(()))
        };
        written().map_err(|cause| CheckpointError::File { path: path.clone(), cause })
    }

    /// Reads the file of a folder, if it is of the plan with this fingerprint.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, or of another plan or build.
    pub fn read(plan: &[u8; 32], folder: &Path) -> Result<Self, CheckpointError> {
        let path = folder.join(NAME);
        let bytes = fs::read(&path).map_err(|cause| CheckpointError::File { path: path.clone(), cause })?;
        Self::from_bytes(&bytes, plan).map_err(|[expected, found]| CheckpointError::Refused { path, expected, found })
    }

    fn bytes(&self, plan: &[u8; 32]) -> io::Result<Vec<u8>> {
        let notes = Notes { kept: self.album.kept.clone(), ..self.notes.clone() };
        let mut pictures = Vec::new();
        frames::write_to(&self.album.shots, &mut pictures)?;
        let mut payload = Vec::new();
        for part in [&serde_json::to_vec(&notes)?, &pictures, &self.state] {
            put(&mut payload, part);
        }
        let mut all = MAGIC.to_vec();
        all.extend(VERSION.to_le_bytes());
        put(&mut all, BUILD.as_bytes());
        all.extend(plan);
        all.extend(Sha256::digest(&payload));
        put(&mut all, &payload);
        Ok(all)
    }

    fn from_bytes(bytes: &[u8], plan: &[u8; 32]) -> Result<Self, [String; 2]> {
        let refused = |expected: &str, found: &str| [expected.to_owned(), found.to_owned()];
        let damaged = || refused("a whole checkpoint", "one that is damaged or cut short");
        let mut rest = bytes;
        let not_one = || refused("a checkpoint of a levee", "something else");
        if take(&mut rest, MAGIC.len()).ok_or_else(not_one)? != MAGIC {
            return Err(not_one());
        }
        let version = take(&mut rest, 4).ok_or_else(damaged)?;
        if version != VERSION.to_le_bytes() {
            let number = u32::from_le_bytes([version[0], version[1], version[2], version[3]]);
            return Err(refused(&format!("version {VERSION}"), &format!("version {number}")));
        }
        let build = part(&mut rest).ok_or_else(damaged)?;
        if build != BUILD.as_bytes() {
            let other = String::from_utf8_lossy(build).into_owned();
            return Err(refused(&format!("a checkpoint of this build, {BUILD}"), &format!("one of {other}")));
        }
        if take(&mut rest, 32).ok_or_else(damaged)? != plan {
            return Err(refused("a checkpoint of this scene and these flags", "one of others"));
        }
        let sum = take(&mut rest, 32).ok_or_else(damaged)?;
        let payload = part(&mut rest).filter(|_| rest.is_empty()).ok_or_else(damaged)?;
        if sum != Sha256::digest(payload).as_slice() {
            return Err(damaged());
        }
        let mut rest = payload;
        let mut next = || part(&mut rest).ok_or_else(damaged);
        let (notes, mut pictures, state) = (next()?, next()?, next()?.to_vec());
        let notes: Notes = serde_json::from_slice(notes).map_err(|_| damaged())?;
        let shots = frames::read_from(&mut pictures).map_err(|_| damaged())?;
        Ok(Self { album: Album { shots, kept: notes.kept.clone() }, notes, state })
    }
}

/// Removes the file of a folder, if there is one.
pub fn remove(folder: &Path) {
    // A file that is not there needs no removal; one that stays is refused or taken up by the next run.
    let _ = fs::remove_file(folder.join(NAME));
}

fn put(into: &mut Vec<u8>, bytes: &[u8]) {
    into.extend((bytes.len() as u64).to_le_bytes());
    into.extend(bytes);
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, left) = rest.split_at_checked(count)?;
    *rest = left;
    Some(taken)
}

fn part<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let count = u64::from_le_bytes(take(rest, 8)?.try_into().ok()?);
    take(rest, usize::try_from(count).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Shot, made_up, rounded};

    fn checkpoint() -> Checkpoint {
        let shots = made_up::shots(2, 1).into_iter().map(|s| Shot { frame: rounded(&s.frame), ..s }).collect();
        let notes = Notes { cpu_s: 1.25, switched: true, kept: Kept::default() };
        Checkpoint { notes, album: Album { shots, kept: Kept::default() }, state: vec![1, 2, 3] }
    }

    #[test]
    fn what_was_written_comes_back_and_leaves_no_part() {
        let folder = tempfile::tempdir().expect("a folder");
        let plan = [7; 32];
        checkpoint().write(&plan, folder.path()).expect("written");
        assert_eq!(Checkpoint::read(&plan, folder.path()).expect("read"), checkpoint());
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
        let other = Checkpoint::read(&[8; 32], folder.path()).expect_err("refused").to_string();
        assert!(other.contains("checkpoint.bin: expected a checkpoint of this scene"), "{other}");
        remove(folder.path());
        assert!(Checkpoint::read(&plan, folder.path()).is_err());
    }

    #[test]
    fn what_is_damaged_or_of_another_version_is_refused() {
        let plan = [7; 32];
        let whole = checkpoint().bytes(&plan).expect("bytes");
        let found = |bytes: &[u8]| Checkpoint::from_bytes(bytes, &plan).expect_err("refused")[1].clone();
        for cut in (0..whole.len()).step_by(997) {
            assert!(Checkpoint::from_bytes(&whole[..cut], &plan).is_err(), "{cut} bytes");
        }
        for place in [whole.len() - 1, whole.len() / 2, 8 + 4 + 8 + BUILD.len() + 32] {
            let mut bytes = whole.clone();
            bytes[place] ^= 1;
            assert!(found(&bytes).contains("damaged"), "{place}");
        }
        let mut bytes = whole.clone();
        bytes[8] = 9;
        assert_eq!(found(&bytes), "version 9");
        let mut bytes = whole;
        bytes[8 + 4 + 8] ^= 1;
        assert!(found(&bytes).starts_with("one of "));
        assert_eq!(found(b"something"), "something else");
    }
}

//! States on disk, to go on from after a stop: all of a file is checked before any of it is believed.
//!
//! Layout: magic, version of the layout, build, hash of the plan, hash of what follows and its length, then the parts, each
//! with its length. A file is written whole ([`crate::files::write`]): a stop while writing leaves the one before.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mpm_core::hash::{Digest, sha256};

use crate::files;

/// Name of the file in the folder of a run.
pub const NAME: &str = "checkpoint.bin";
/// Version and hash of the sources: states of other sources may differ in their layout, and their runs in the last bit.
pub const BUILD: &str = concat!(env!("CARGO_PKG_VERSION"), " ", env!("MPM_SOURCES"));
/// First bytes of every kind.
const MAKER: &[u8] = b"MPM";
/// No state is larger: what claims to be is refused before it is read, bytes.
const LARGEST: u64 = 16 << 30;

/// What a file is a state of.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// First bytes.
    pub magic: &'static [u8; 8],
    /// Version of the parts.
    pub version: u32,
    /// In words, as in "a checkpoint of a scene".
    pub of: &'static str,
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

impl Kind {
    /// Writes the file of a folder. `plan` is the fingerprint of what is run.
    ///
    /// # Errors
    /// A file that cannot be written; the one before is then still there.
    pub fn write(&self, plan: &Digest, parts: &[&[u8]], folder: &Path) -> Result<(), CheckpointError> {
        let path = folder.join(NAME);
        files::write(&path, &self.bytes(plan, parts)).map_err(|cause| CheckpointError::File { path, cause })
    }

    /// The N parts of the file of a folder, if it is of the plan with this fingerprint; `None` if there is no such file.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, or of another plan or build.
    pub fn read<const N: usize>(&self, plan: &Digest, folder: &Path) -> Result<Option<[Vec<u8>; N]>, CheckpointError> {
        let path = folder.join(NAME);
        let unreadable = |cause| CheckpointError::File { path: path.clone(), cause };
        let refused = |[expected, found]: [String; 2]| CheckpointError::Refused { path: path.clone(), expected, found };
        match fs::metadata(&path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(unreadable(e)),
            Ok(file) if !file.is_file() || file.len() > LARGEST => {
                return Err(refused(["a file of a state".to_owned(), "something else".to_owned()]));
            }
            Ok(_) => {}
        }
        let bytes = fs::read(&path).map_err(unreadable)?;
        self.parts(&bytes, plan).map(Some).map_err(refused)
    }

    /// The bytes of a file.
    pub fn bytes(&self, plan: &Digest, parts: &[&[u8]]) -> Vec<u8> {
        let mut payload = Vec::with_capacity(parts.iter().map(|part| part.len() + 8).sum());
        for part in parts {
            put(&mut payload, part);
        }
        let mut all = self.magic.to_vec();
        all.extend(self.version.to_le_bytes());
        put(&mut all, BUILD.as_bytes());
        all.extend(plan);
        all.extend(sha256(&payload));
        put(&mut all, &payload);
        all
    }

    /// The parts in the bytes of a file.
    ///
    /// # Errors
    /// What was expected and what was found.
    pub fn parts<const N: usize>(&self, bytes: &[u8], plan: &Digest) -> Result<[Vec<u8>; N], [String; 2]> {
        let refused = |expected: &str, found: &str| [expected.to_owned(), found.to_owned()];
        let damaged = || refused("a whole checkpoint", "one that is damaged or cut short");
        let mut rest = bytes;
        let not_one = || [format!("a checkpoint of {}", self.of), "something else".to_owned()];
        if take(&mut rest, self.magic.len()).ok_or_else(not_one)? != self.magic {
            return Err(not_one());
        }
        let version = take(&mut rest, 4).ok_or_else(damaged)?;
        if version != self.version.to_le_bytes() {
            let number = u32::from_le_bytes([version[0], version[1], version[2], version[3]]);
            return Err([format!("version {}", self.version), format!("version {number}")]);
        }
        let build = part(&mut rest).ok_or_else(damaged)?;
        if build != BUILD.as_bytes() {
            let other: String = String::from_utf8_lossy(build).chars().take(80).collect();
            return Err([format!("a checkpoint of this build, {BUILD}"), format!("one of {other}")]);
        }
        if take(&mut rest, 32).ok_or_else(damaged)? != plan {
            return Err(refused("a checkpoint of this scene and these flags", "one of others"));
        }
        let sum = take(&mut rest, 32).ok_or_else(damaged)?;
        let payload = part(&mut rest).filter(|_| rest.is_empty()).ok_or_else(damaged)?;
        if sum != sha256(payload) {
            return Err(damaged());
        }
        let mut rest = payload;
        let mut parts = [const { Vec::new() }; N];
        for one in &mut parts {
            *one = part(&mut rest).ok_or_else(damaged)?.to_vec();
        }
        if rest.is_empty() { Ok(parts) } else { Err(damaged()) }
    }
}

/// Whether what stands in a folder under the name of a checkpoint, if anything does, is one of this program: it is replaced and removed.
///
/// # Errors
/// It is not, or cannot be read.
pub fn is_own(folder: &Path) -> Result<(), CheckpointError> {
    let path = folder.join(NAME);
    let mut start = Vec::new();
    match fs::symlink_metadata(&path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(cause) => return Err(CheckpointError::File { path, cause }),
        Ok(there) if there.is_file() => {
            let read = fs::File::open(&path).and_then(|file| file.take(MAKER.len() as u64).read_to_end(&mut start));
            read.map_err(|cause| CheckpointError::File { path: path.clone(), cause })?;
        }
        Ok(_) => {}
    }
    if start == MAKER {
        return Ok(());
    }
    let expected = "no such file, or a checkpoint of this program";
    Err(CheckpointError::Refused {
        path,
        expected: expected.to_owned(),
        found: "something else, which was left as it is".to_owned(),
    })
}

/// Removes the file of a folder, if there is one.
pub fn remove(folder: &Path) {
    // A file that is not there needs no removal; one that stays is refused or taken up by the next run.
    let _ = is_own(folder).map(|()| fs::remove_file(folder.join(NAME)));
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

    const KIND: Kind = Kind { magic: b"MPMTESTS", version: 3, of: "a test" };

    #[test]
    fn what_was_written_comes_back_and_leaves_no_part() {
        let folder = tempfile::tempdir().expect("a folder");
        let plan = [7; 32];
        assert!(KIND.read::<2>(&plan, folder.path()).expect("no file").is_none());
        KIND.write(&plan, &[b"one", b""], folder.path()).expect("written");
        let parts = KIND.read(&plan, folder.path()).expect("read").expect("a state");
        assert_eq!(parts, [b"one".to_vec(), Vec::new()]);
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
        let other = KIND.read::<2>(&[8; 32], folder.path()).expect_err("refused").to_string();
        assert!(other.contains("checkpoint.bin: expected a checkpoint of this scene"), "{other}");
        assert!(KIND.read::<1>(&plan, folder.path()).is_err() && KIND.read::<3>(&plan, folder.path()).is_err());
        remove(folder.path());
        assert!(KIND.read::<2>(&plan, folder.path()).expect("no file").is_none());
    }

    #[test]
    fn a_stop_while_writing_leaves_the_one_before() {
        let (folder, plan) = (tempfile::tempdir().expect("a folder"), [7; 32]);
        KIND.write(&plan, &[b"before"], folder.path()).expect("written");
        let next = KIND.bytes(&plan, &[b"after"]);
        // Power goes while the file is written, and after it was, before it has its name.
        for cut in 0..=next.len() {
            fs::write(files::part_of(&folder.path().join(NAME)).expect("a name"), &next[..cut]).expect("written");
            let read = KIND.read(&plan, folder.path()).expect("read").expect("a state");
            assert_eq!(read, [b"before".to_vec()]);
        }
        KIND.write(&plan, &[b"after"], folder.path()).expect("written");
        assert_eq!(KIND.read(&plan, folder.path()).expect("read").expect("a state"), [b"after".to_vec()]);
    }

    #[test]
    fn what_is_damaged_or_of_another_version_is_refused() {
        let plan = [7; 32];
        let whole = KIND.bytes(&plan, &[b"one", b"two"]);
        let found = |bytes: &[u8]| KIND.parts::<2>(bytes, &plan).expect_err("refused")[1].clone();
        for cut in 0..whole.len() {
            assert!(KIND.parts::<2>(&whole[..cut], &plan).is_err(), "{cut} bytes");
        }
        for place in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[place] ^= 1;
            assert!(KIND.parts::<2>(&bytes, &plan).is_err(), "byte {place}");
        }
        let mut bytes = whole.clone();
        bytes[8] = 9;
        assert_eq!(found(&bytes), "version 9");
        let mut bytes = whole.clone();
        bytes[8 + 4 + 8] ^= 1;
        assert!(found(&bytes).starts_with("one of "));
        assert_eq!(found(b"something"), "something else");
        let mut bytes = whole;
        bytes.push(0);
        assert!(found(&bytes).contains("damaged"));
    }
}

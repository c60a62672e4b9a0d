//! The state of a levee's run on disk: small things, frames so far, the driver's own bytes.

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::moments::{Album, Kept};
use crate::checkpoint::{self, CheckpointError, Kind};
use crate::frames;

const KIND: Kind = Kind { magic: b"MPMLEVEE", version: 3, of: "a levee" };

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

impl Checkpoint {
    /// Writes the file of a folder. `plan` is the fingerprint of the plan.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, plan: &[u8; 32], folder: &Path) -> Result<(), CheckpointError> {
        let parts = self.parts();
        let unwritable = |cause| CheckpointError::File { path: folder.join(checkpoint::NAME), cause };
        let [notes, pictures] = parts.map_err(unwritable)?;
        KIND.write(plan, &[&notes, &pictures, &self.state], folder)
    }

    /// Reads the file of a folder, if it is of the plan with this fingerprint; `None` if there is none.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, or of another plan or build.
    pub fn read(plan: &[u8; 32], folder: &Path) -> Result<Option<Self>, CheckpointError> {
        let Some([notes, pictures, state]) = KIND.read(plan, folder)? else { return Ok(None) };
        let damaged = || CheckpointError::Refused {
            path: folder.join(checkpoint::NAME),
            expected: "a whole checkpoint".to_owned(),
            found: "one that is damaged".to_owned(),
        };
        let notes: Notes = serde_json::from_slice(&notes).map_err(|_| damaged())?;
        let shots = frames::read_from(&mut pictures.as_slice()).map_err(|_| damaged())?;
        Ok(Some(Self { album: Album { shots, kept: notes.kept.clone() }, notes, state }))
    }

    fn parts(&self) -> io::Result<[Vec<u8>; 2]> {
        let notes = Notes { kept: self.album.kept.clone(), ..self.notes.clone() };
        let mut pictures = Vec::new();
        frames::write_to(&self.album.shots, &mut pictures)?;
        Ok([serde_json::to_vec(&notes)?, pictures])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Shot, made_up, rounded};

    #[test]
    fn what_was_written_comes_back() {
        let shots = made_up::shots(2, 1).into_iter().map(|s| Shot { frame: rounded(&s.frame), ..s }).collect();
        let notes = Notes { cpu_s: 1.25, switched: true, kept: Kept::default() };
        let written = Checkpoint { notes, album: Album { shots, kept: Kept::default() }, state: vec![1, 2, 3] };
        let (folder, plan) = (tempfile::tempdir().expect("a folder"), [7; 32]);
        assert_eq!(Checkpoint::read(&plan, folder.path()).expect("no file"), None);
        written.write(&plan, folder.path()).expect("written");
        assert_eq!(Checkpoint::read(&plan, folder.path()).expect("read"), Some(written));
        assert!(Checkpoint::read(&[8; 32], folder.path()).is_err());
    }
}

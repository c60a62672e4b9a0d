//! Checkpoint of a run: its results so far, where it is, and its model.

use super::Drive;
use crate::checkpoint::{Archive, RestoreError, archive, restore, save, sealed, unsealed};
use crate::hash::{Digest, sha256};

impl Drive<'_> {
    /// The state, from which [`Self::restore`] resumes.
    pub fn checkpoint(&mut self) -> Vec<u8> {
        sealed(&save(|archive| self.save_or_restore(archive)), &self.fingerprint())
    }

    /// Restores a state of the same scene, of the same version of this program.
    ///
    /// # Errors
    /// The bytes are not those of such a state. Nothing is then to be made of the run: its model may be in pieces.
    pub fn restore(&mut self, checkpoint: &[u8]) -> Result<(), RestoreError> {
        restore(unsealed(checkpoint, &self.fingerprint())?, |archive| self.save_or_restore(archive))
    }

    /// Of all that a state depends on.
    fn fingerprint(&self) -> Digest {
        sha256(format!("{:?} {:016x}", self.scene, self.run.dt.to_bits()).as_bytes())
    }

    fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        let run = &mut self.run;
        archive!(archive.value: self.at, run.steps, run.bytes, run.stages, run.samples);
        if archive.restores() && self.at.stage as usize >= self.scene.stages.len() {
            return Err(RestoreError);
        }
        // The model last: it builds from what it reads.
        self.model.save_or_restore(archive)
    }
}

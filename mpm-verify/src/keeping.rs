//! Attends to the run of a scene: progress, a checkpoint every so often, an end by Ctrl-C.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use mpm_core::drive::{Monitor, Wish};
use mpm_core::hash::{Digest, sha256};
use mpm_core::observe::SolidState;
use mpm_core::scene::Scene;
use mpm_core::step::Model;
use serde::{Deserialize, Serialize};

use crate::checkpoint::{CheckpointError, Kind};
use crate::frames::Recorded;

const KIND: Kind = Kind { magic: b"MPMSCENE", version: 1, of: "a scene" };

/// A state that was kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// What is not the run's own.
    pub notes: Notes,
    /// The run's own bytes: [`mpm_core::run::run_monitored`] goes on from them.
    pub state: Vec<u8>,
}

/// What has been used so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Notes {
    /// CPU time, s.
    pub cpu_s: f64,
    /// Time on the clock, s.
    pub wall_s: f64,
}

/// Reads the state of a scene that was kept in a folder; `None` if there is none.
///
/// # Errors
/// A file that cannot be read, is damaged, or of another scene or build.
pub fn kept(scene: &Scene, folder: &Path) -> Result<Option<Kept>, CheckpointError> {
    let Some([notes, state]) = KIND.read(&plan(scene), folder)? else { return Ok(None) };
    let damaged = |_| CheckpointError::Refused {
        path: folder.join(crate::checkpoint::NAME),
        expected: "a whole checkpoint".to_owned(),
        found: "one that is damaged".to_owned(),
    };
    Ok(Some(Kept { notes: serde_json::from_slice(&notes).map_err(damaged)?, state }))
}

/// All of a scene that its run depends on.
fn plan(scene: &Scene) -> Digest {
    sha256(format!("{scene:?}").as_bytes())
}

/// Keeps the states of a run.
pub struct Keeping<'a> {
    /// Of the scene.
    pub scene: &'a Scene,
    /// Where the checkpoint is written.
    pub folder: PathBuf,
    /// Time between two of them.
    pub every: Duration,
    /// Called with the share of its stage that the run has come to.
    pub progress: &'a mut dyn FnMut(f64),
    /// Set when the run is to stop.
    pub stop: Arc<AtomicBool>,
    /// What the run has used so far.
    pub used: &'a dyn Fn() -> Notes,
    /// When the last one was written.
    pub last: Instant,
    /// Why the last one could not be written, if it could not.
    pub trouble: Option<CheckpointError>,
    /// The particles of the end, where they are wanted.
    pub end: Option<Vec<SolidState>>,
    /// Frames of the start and of the observed times, where they are wanted.
    pub frames: Option<Recorded>,
}

impl Monitor for Keeping<'_> {
    fn look(&mut self, share: f64) -> Wish {
        (self.progress)(share);
        if self.stop.load(Ordering::Relaxed) {
            Wish::Stop
        } else if self.last.elapsed() >= self.every {
            Wish::Save
        } else {
            Wish::GoOn
        }
    }

    fn save(&mut self, state: Vec<u8>) {
        let notes = serde_json::to_vec(&(self.used)()).unwrap_or_default();
        let written = KIND.write(&plan(self.scene), &[&notes, &state], &self.folder);
        // A disk that is full now may have room later, and the run itself needs none.
        self.trouble = written.err();
        self.last = Instant::now();
    }

    fn observed(&mut self, model: &dyn Model, time: f64) {
        if let Some(frames) = &mut self.frames {
            frames.take(model, time);
        }
    }

    fn ended(&mut self, model: &dyn Model) {
        self.end = self.end.as_ref().map(|_| model.particles());
    }
}

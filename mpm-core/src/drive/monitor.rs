//! Monitoring of a run: progress, checkpoints, and requests to stop.

use crate::step::Model;

/// A request to a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// To continue.
    GoOn,
    /// To give its state, and continue.
    Save,
    /// To give its state, and stop.
    Stop,
}

/// Monitors a run.
pub trait Monitor {
    /// The request to a run that has completed a share (0 to 1) of its stage. It is asked several times a second.
    fn look(&mut self, share: f64) -> Wish;
    /// Takes the state that was asked for: the bytes from which [`super::Drive::restore`] resumes.
    fn save(&mut self, checkpoint: Vec<u8>);
    /// Receives the model of a run at its start and at each observed time (s since the start).
    fn observed(&mut self, _: &dyn Model, _time: f64) {}
    /// Sees the model at the end of a run.
    fn ended(&mut self, _: &dyn Model) {}
}

/// A run without checkpoints; the completed share of its stage is reported.
pub struct Alone<'a>(pub &'a mut dyn FnMut(f64));

impl Monitor for Alone<'_> {
    fn look(&mut self, share: f64) -> Wish {
        (self.0)(share);
        Wish::GoOn
    }

    fn save(&mut self, _: Vec<u8>) {}
}

//! What may be asked of a run on its way.

use crate::step::Model;

/// What is wished of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// To go on.
    GoOn,
    /// To give its state, and go on.
    Save,
    /// To give its state, and stop.
    Stop,
}

/// Attends to a run.
pub trait Attend {
    /// Says what is wished of a run that has come to a share (0 to 1) of its stage. It is asked some times a second.
    fn look(&mut self, share: f64) -> Wish;
    /// Takes the state that was wished for: the bytes that [`super::Drive::restore`] goes on from.
    fn save(&mut self, checkpoint: Vec<u8>);
    /// Takes note of the model of a run at its start and at each observed time (s since the start).
    fn observed(&mut self, _: &dyn Model, _time: f64) {}
    /// Looks at the model of a run that has ended.
    fn ended(&mut self, _: &dyn Model) {}
}

/// A run that no one wants to save; the share of its stage is reported.
pub struct Alone<'a>(pub &'a mut dyn FnMut(f64));

impl Attend for Alone<'_> {
    fn look(&mut self, share: f64) -> Wish {
        (self.0)(share);
        Wish::GoOn
    }

    fn save(&mut self, _: Vec<u8>) {}
}

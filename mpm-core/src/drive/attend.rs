//! What may be asked of a run on its way.

/// What is wished of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// To go on.
    GoOn,
    /// To give its state, and go on.
    Keep,
    /// To give its state, and stop.
    Stop,
}

/// Attends to a run.
pub trait Attend {
    /// Says what is wished of a run that has come to a share (0 to 1) of its stage. It is asked some times a second.
    fn look(&mut self, share: f64) -> Wish;
    /// Takes the state that was wished for: the bytes that [`super::Drive::take_up`] reads.
    fn keep(&mut self, state: Vec<u8>);
}

/// A run that no one wants to keep; the share of its stage is reported.
pub struct Alone<'a>(pub &'a mut dyn FnMut(f64));

impl Attend for Alone<'_> {
    fn look(&mut self, share: f64) -> Wish {
        (self.0)(share);
        Wish::GoOn
    }

    fn keep(&mut self, _: Vec<u8>) {}
}

//! What a run that goes on elsewhere needs: what it has found so far, where it is, and its model.

use super::{At, Drive, Sample, StageRecord};
use crate::keep::{Keeper, Unfit, check_sum, sealed, unsealed};

impl Drive<'_> {
    /// The state, to be taken up by [`Self::take_up`].
    pub fn kept(&mut self) -> Vec<u8> {
        let mut keeper = Keeper::writes();
        self.keep(&mut keeper);
        sealed(&keeper.into_bytes(), self.fingerprint())
    }

    /// Takes up a kept state of the same scene, of the same version of this program.
    ///
    /// # Errors
    /// The bytes are not those of such a state. Nothing is then to be made of the run: its model may be in pieces.
    pub fn take_up(&mut self, state: Vec<u8>) -> Result<(), Unfit> {
        let mut keeper = Keeper::reads(unsealed(state, self.fingerprint())?);
        self.keep(&mut keeper);
        keeper.finish()
    }

    /// Of all that a state depends on.
    fn fingerprint(&self) -> u64 {
        check_sum(format!("{:?} {:016x}", self.scene, self.run.dt.to_bits()).as_bytes())
    }

    fn keep(&mut self, keeper: &mut Keeper) {
        self.at.keep(keeper);
        keeper.u64(&mut self.run.steps);
        let mut bytes = self.run.bytes as u64;
        keeper.u64(&mut bytes);
        self.run.bytes = bytes as usize;
        keeper.list(&mut self.run.stages, &StageRecord::default(), StageRecord::keep);
        keeper.list(&mut self.run.samples, &Sample::default(), Sample::keep);
        if self.at.stage as usize >= self.scene.stages.len() {
            keeper.refuse();
        }
        // The model last: it builds from what it reads.
        self.model.keep(keeper);
    }
}

impl At {
    fn keep(&mut self, keeper: &mut Keeper) {
        let Self { stage, entered, first_step, next, now, left, step, time, reached, looks } = self;
        for number in [stage, first_step, next, left, looks] {
            keeper.u64(number);
        }
        keeper.bool(entered);
        for number in [now, step, time, reached] {
            keeper.f64(number);
        }
    }
}

impl StageRecord {
    fn keep(&mut self, keeper: &mut Keeper) {
        let Self { name, duration_s, steps } = self;
        keeper.text(name);
        keeper.f64(duration_s);
        keeper.u64(steps);
    }
}

impl Sample {
    fn keep(&mut self, keeper: &mut Keeper) {
        let Self { stage, stage_time, step, observed, state, ledger } = self;
        let mut number = *stage as u64;
        keeper.u64(&mut number);
        *stage = number as usize;
        keeper.f64(stage_time);
        keeper.u64(step);
        keeper.bool(observed);
        state.keep(keeper);
        ledger.keep(keeper);
    }
}

//! What a checkpoint holds of a quasi-static run. Mesh, matrix and factors are made anew from it, to the same bits.

use super::march::factors;
use super::sdirk::Sdirk;
use super::{Method, QuasiStatic};
use crate::checkpoint::{Archive, RestoreError, archive};
use crate::constitutive::Law;

impl<L: Law, const D: usize> QuasiStatic<L, D> {
    /// Saves or restores the state.
    pub(super) fn whole_state(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        let mut laid = self.soil.is_some();
        archive!(archive.slice: self.points, *self.carried.as_flattened_mut(), self.states);
        archive!(archive.value: self.drained, self.sides, self.settled, self.time, self.stage_time, self.stage_end, self.until);
        archive!(archive.value: self.counted, self.trouble, self.done, self.totals, self.spent, laid);
        archive!(archive.value: self.ramp, self.rejected, self.rejected_path, self.pushes, self.started);
        archive!(archive.value: self.resolves, self.damping);
        if !laid {
            return Ok(());
        }
        if archive.restores() {
            self.lay_again()?;
        }
        for (_, [_, before]) in self.soil.iter_mut().flat_map(|soil| &mut soil.plates) {
            archive.value(before)?;
        }
        archive.value(&mut self.loose)?;
        archive!(archive.slice: self.y, self.content);
        archive!(archive.value: self.work.reference);
        let (time, ramp) = (self.time, self.ramp);
        self.soil.iter_mut().for_each(|soil| soil.bear(time, ramp));
        self.soil_and_method(archive)
    }

    /// Builds the mesh of the restored particles; what it would start from is restored next.
    fn lay_again(&mut self) -> Result<(), RestoreError> {
        // A surface that has gone further than the soil is high would have a mesh without end.
        let bounded = self.settled.abs() < self.scene.height;
        let (done, spent) = (self.done, std::mem::take(&mut self.spent));
        (self.soil, self.method) = (None, None);
        if !bounded || self.build(self.drained).is_err() || self.spent.len() != spent.len() {
            return Err(RestoreError);
        }
        (self.spent, self.done) = (spent, done);
        Ok(())
    }

    /// What a law with a memory has come to, the fields, the work of the present system, and how the stage is advanced.
    fn soil_and_method(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        let Some(soil) = &mut self.soil else { return Err(RestoreError) };
        if !soil.linear() {
            for part in &mut soil.solid {
                archive!(archive.value: part.strain, part.stress, part.state);
            }
        }
        archive!(archive.slice: soil.p, *soil.u.as_flattened_mut());
        if let Some(motion) = &mut soil.motion {
            archive!(archive.slice: *motion.velocity.as_flattened_mut(), *motion.flux.as_flattened_mut());
        }
        archive!(archive.value: soil.system.factorisations, soil.system.solves, self.method);
        if !archive.restores() {
            return Ok(());
        }
        match &mut self.method {
            Some(Method::Krylov(stage)) if !stage.fits(soil.unknowns()) => Err(RestoreError),
            Some(Method::Sdirk { stepper, factored, .. }) => {
                **stepper = Sdirk::new(soil.p.len(), soil.unknowns());
                // Factors of a linear soil serve the next steps; others are made for every step.
                if factored.is_finite() && soil.linear() {
                    let done = [soil.system.factorisations, soil.system.solves];
                    factors(soil, &self.y, *factored).map_err(|_| RestoreError)?;
                    [soil.system.factorisations, soil.system.solves] = done;
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

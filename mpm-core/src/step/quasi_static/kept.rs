//! What is kept of a quasi-static run. Mesh, matrix and factors are made anew from it, to the same bits.

use super::krylov::Krylov;
use super::march::factors;
use super::sdirk::Sdirk;
use super::{KrylovStage, Method, QuasiStatic};
use crate::constitutive::Law;
use crate::keep::Keeper;
use crate::particles::SolidPoint;

impl<L: Law, const D: usize> QuasiStatic<L, D> {
    /// Writes or reads the state.
    pub(super) fn keep_all(&mut self, keeper: &mut Keeper) {
        keeper.entries(&mut self.points, SolidPoint::keep);
        keeper.entries(&mut self.carried, |carried, keeper| keeper.f64s(carried));
        keeper.entries(&mut self.states, |state, keeper| keeper.f64s(state));
        self.drained.iter_mut().for_each(|drained| keeper.bool(drained));
        for value in [&mut self.settled, &mut self.time, &mut self.stage_time, &mut self.stage_end, &mut self.until] {
            keeper.f64(value);
        }
        keeper.bool(&mut self.counted);
        keeper.maybe(&mut self.trouble, &String::new(), |trouble, keeper| keeper.text(trouble));
        self.done.keep(keeper);
        self.totals.keep(keeper);
        keeper.numbers(&mut self.spent);
        let mut laid = self.soil.is_some();
        keeper.bool(&mut laid);
        if !laid {
            return;
        }
        if keeper.is_reading() {
            // A surface that has gone further than the soil is high would have a mesh without end.
            let bounded = self.settled.abs() < self.scene.height;
            if !bounded {
                keeper.refuse();
                return;
            }
            // The mesh that was laid over these particles; what it would start from is read below.
            let done = self.done;
            self.soil = None;
            self.method = None;
            let spent = std::mem::take(&mut self.spent);
            if self.lay(self.drained).is_err() || self.spent.len() != spent.len() {
                keeper.refuse();
                return;
            }
            (self.spent, self.done) = (spent, done);
        }
        keeper.all(&mut self.y);
        keeper.all(&mut self.content);
        keeper.f64(&mut self.work.reference);
        self.keep_soil(keeper);
        self.keep_method(keeper);
    }

    /// What a law with a memory has come to, the fields, and the work of the present system.
    fn keep_soil(&mut self, keeper: &mut Keeper) {
        let Some(soil) = &mut self.soil else { return };
        if !soil.linear() {
            keeper.entries(&mut soil.solid, |part, keeper| {
                keeper.f64s(&mut part.strain);
                keeper.f64s(&mut part.stress);
                keeper.f64s(&mut part.state);
            });
        }
        keeper.all(&mut soil.p);
        keeper.entries(&mut soil.u, |u, keeper| keeper.f64s(u));
        for count in [&mut soil.system.factorisations, &mut soil.system.solves] {
            keeper.u64(count);
        }
    }

    fn keep_method(&mut self, keeper: &mut Keeper) {
        let mut kind = match &self.method {
            None => 0,
            Some(Method::Krylov(_)) => 1,
            Some(Method::Sdirk { .. }) => 2,
        };
        keeper.u32(&mut kind);
        if keeper.is_reading() {
            let Some(soil) = &self.soil else { return };
            self.method = match kind {
                0 => None,
                1 => Some(Method::Krylov(Box::new(KrylovStage::empty(soil.unknowns())))),
                _ => {
                    let stepper = Box::new(Sdirk::new(soil.p.len(), soil.unknowns()));
                    Some(Method::Sdirk { stepper, step: 0.0, factored: f64::NAN })
                }
            };
        }
        match &mut self.method {
            None => {}
            Some(Method::Krylov(stage)) => stage.keep(keeper),
            Some(Method::Sdirk { step, factored, .. }) => {
                keeper.f64(step);
                keeper.f64(factored);
                if keeper.is_reading() && factored.is_finite() {
                    let factored = *factored;
                    let Some(soil) = &mut self.soil else { return };
                    let done = [soil.system.factorisations, soil.system.solves];
                    // Those of a linear soil serve the next steps; others are made for every step.
                    if soil.linear() && factors(soil, &self.y, factored).is_err() {
                        keeper.refuse();
                    }
                    [soil.system.factorisations, soil.system.solves] = done;
                }
            }
        }
    }
}

impl KrylovStage {
    fn empty(unknowns: usize) -> Self {
        Self {
            evolution: Krylov::empty(unknowns),
            integral: vec![0.0; unknowns],
            held: 0.0,
            out_before: 0.0,
            work_before: 0.0,
            dissipation_before: 0.0,
        }
    }

    fn keep(&mut self, keeper: &mut Keeper) {
        let Self { evolution, integral, held, out_before, work_before, dissipation_before } = self;
        evolution.keep(keeper);
        keeper.all(integral);
        for value in [held, out_before, work_before, dissipation_before] {
            keeper.f64(value);
        }
    }
}

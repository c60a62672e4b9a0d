//! Time marching through a stage: one Krylov basis, or steps whose length follows from their error.

use super::failures::{describe, inverted, nothing};
use super::krylov::{Goal, Krylov};
use super::remesh::REMESH_STRAIN;
use super::sdirk::{GAMMA, Sdirk, StepSums};
use super::soil::{HELD, Impulses, Soil};
use super::tangent::Stuck;
use super::{KrylovStage, Method, QuasiStatic};
use crate::constitutive::{Flow, Law};
use crate::real::array_of;
use crate::scene::{Course, FaceLoad, Fields, Integrator, PASSAGES, Start, StepChoice, StrainChoice, TimeMethod};
use crate::step::Fault;

/// The first step of a stage as a share of L^2/c_v: shorter ones overshoot where the mesh cannot resolve the drained
/// layer, and the error estimate shortens it where accuracy asks for it.
const FIRST_STEP: f64 = 0.3;
/// The estimate of a step beside the tolerance. It is of order 3 while the solution that is kept is of order 4: on
/// the study's column the error in time was a 200th of the estimate, so that this leaves a tenth of the tolerance.
const CAUTION: f64 = 10.0;
/// The same with inertia: errors of waves add up, those of what drains die away with it.
const CAUTION_IN_MOTION: f64 = 0.1;
/// So many first steps of a stage damp the waves that a jump of its load excites where they are not resolved, whatever their error
/// (Rannacher 1984, doi:10.1007/BF01390130).
const STARTING: u32 = 3;
/// The least of these beside any other first step, where waves need no longer ones.
const STARTING_STEP: f64 = 1e-2;
/// Tolerance from which on they may be as long as any first step.
const UNCHECKED: f64 = 1e-3;
/// Least step as a share of the stage.
const LEAST_STEP: f64 = 1e-12;
/// The same of soil without water, as a share of the ramp of its load: that soil knows time from its load alone, and what it does
/// not bear is not worth more digits.
const LEAST_LOAD_STEP: f64 = 1e-5;
/// A step without water that took fewer iterations may be followed by a longer one.
const EASY: f64 = 6.0;
/// Ramp of a sudden load as a share of the first step.
const SUDDEN: f64 = 1e-3;
/// Unknowns times steps between two requests to the monitor: some tenths of a second.
const UNKNOWNS_AT_ONCE: usize = 1 << 18;
/// Residual of a nonlinear stage beside the tolerance.
pub(crate) const NEWTON: f64 = 1e-3;
/// The pole of the Krylov method as a share of the last time.
const POLE: f64 = 0.1;
/// Changes of the step between these factors are not worth another factorisation of a linear scene.
const STEADY: std::ops::Range<f64> = 0.9..1.6;

impl<L: Law, const D: usize> QuasiStatic<L, D> {
    /// Whether the Krylov method can take a stage: linear, constant load, no weight, water that can flow.
    pub(super) fn krylov_holds(&self) -> bool {
        let linear = self.scene.strain == StrainChoice::Small && self.seeding.law.are_linear();
        let linear = linear && self.scene.integrator == Integrator::QuasiStatic;
        let steady = |load: &FaceLoad| load.course == Course::Constant;
        let constant = self.time >= self.scene.surcharge.map_or(0.0, |s| s.ramp_time);
        let constant = constant && self.scene.loads.iter().all(steady) && !self.scene.has_water_outside();
        let constant = constant && self.scene.plates.is_empty() && self.scene.wells.is_empty();
        linear && constant && self.scene.gravity.is_none() && self.scene.water.is_some()
    }

    /// All times of a stage at once; `None` where the basis would grow too large.
    pub(super) fn krylov(&mut self, times: &[f64]) -> Result<Option<Method>, Fault> {
        let end = times.last().copied().unwrap_or(0.0);
        let already = self.seeding.first_settlement + self.settled;
        let pressure = self.pressure_size();
        let volume = self.seeding.thickness * self.scene.height * if D == 2 { self.scene.width } else { 1.0 };
        let goal = Goal {
            pole: POLE * end,
            tolerance: self.scene.tolerance,
            weights: self.settle.clone(),
            already,
            pressure_norm: pressure * (volume * self.scene.storage()).sqrt(),
        };
        let held = self.soil.as_ref().map_or(0.0, |soil| soil.held(&self.content));
        let totals = &self.totals;
        let (out_before, work_before, dissipation_before) =
            (totals.water_out, totals.external_work, totals.darcy_dissipation);
        let Some(soil) = &mut self.soil else { return Err(nothing()) };
        let fields = (soil.u.clone(), soil.p.clone());
        let evolution =
            Krylov::new(soil, &self.content, times, &goal, &mut self.work).map_err(|stuck| self.fault(&stuck, None))?;
        // The basis was built in the fields of the soil, which are those of the start of the stage again: at sides that drain from
        // now on, too.
        if let Some(soil) = &mut self.soil {
            (soil.u, soil.p) = fields;
        }
        if evolution.estimate.is_nan() || evolution.estimate > self.scene.tolerance {
            if self.scene.method == TimeMethod::Auto {
                return Ok(None);
            }
            let (vectors, estimate) = (evolution.vectors(), evolution.estimate);
            let what = format!(
                "the Krylov method did not reach the tolerance {:e} with {vectors} basis vectors: the last one still \
                 changed the state by {estimate:.1e}; the method sdirk divides the time instead",
                self.scene.tolerance
            );
            return Err(Fault { place: "the whole soil".to_owned(), what });
        }
        self.done.accepted += evolution.vectors() as u64;
        Ok(Some(Method::Krylov(Box::new(KrylovStage { evolution, held, out_before, work_before, dissipation_before }))))
    }

    /// The time (s) within which the load grows. A law with a path has to be led along that of the load: a sudden one grows within
    /// a thousandth of what flows from cell to cell, and of what is observed.
    pub(super) fn ramp(&self, times: &[f64]) -> f64 {
        let ramp = self.scene.surcharge.map_or(0.0, |s| s.ramp_time);
        let sudden = self.scene.loads.iter().any(|load| load.course == Course::Constant);
        let carried = (self.scene.surcharge.is_none() || self.scene.start == Start::UndrainedEquilibrium) && !sudden;
        let given = matches!(self.scene.step, StepChoice::Fixed(_)) || self.scene.integrator == Integrator::Implicit;
        if ramp > 0.0 || carried || given || self.seeding.law.are_linear() {
            return ramp;
        }
        let first = times.iter().copied().find(|time| *time > 0.0).unwrap_or(0.0);
        SUDDEN * self.first_step(times).min(first)
    }

    /// The first step of a stage, s.
    pub(super) fn first_step(&self, times: &[f64]) -> f64 {
        let end = times.last().copied().unwrap_or(f64::INFINITY);
        // Inertia is of importance where times are asked for in which waves have not died out.
        let asked = times.iter().copied().find(|time| *time > 0.0 && self.resolves);
        let end = asked.unwrap_or(end);
        // Of layers the fastest: its neighbours are drained as suddenly as the surface is.
        let of = |scene: &Fields| {
            scene
                .water
                .map_or(f64::INFINITY, |w| FIRST_STEP * scene.cell.powi(2) / (w.mobility() * scene.oedometer_modulus()))
        };
        let drained = self.scene.by_soil().iter().map(|scene| of(scene)).fold(f64::INFINITY, f64::min);
        match self.scene.step {
            StepChoice::Fixed(step) => step,
            // Steps whose error does not count are as long as waves need to be damped, and no longer than what flows allows, the less the
            // less error is wanted: it goes with their fourth power.
            _ if self.damps() => {
                let short = (PASSAGES * self.scene.passage()).max(STARTING_STEP * drained);
                short.min(drained * (self.scene.tolerance / UNCHECKED).powf(0.25).min(1.0)).min(end)
            }
            _ => drained.min(end),
        }
    }

    /// Steps until `end` (s since the start of the stage), or until so many were tried that the run may be asked for.
    pub(super) fn steps_until(&mut self, end: f64, done: &mut u64) -> Result<(), Fault> {
        let fixed = matches!(self.scene.step, StepChoice::Fixed(_));
        let mut tries = (UNKNOWNS_AT_ONCE / self.y.len().max(1)).max(1);
        self.until = end;
        while self.stage_time < end {
            if tries == 0 {
                return Ok(());
            }
            tries -= 1;
            let Some(Method::Sdirk { step, .. }) = &self.method else { return Err(nothing()) };
            // The load has a corner where its ramp ends, which no estimate of an error sees: a step ends there.
            let courses = self.scene.loads.iter().map(|load| &load.course);
            let courses = courses.chain(self.scene.wells.iter().map(|well| &well.course));
            let corners = courses.flat_map(Course::corners).chain([self.ramp]);
            let ahead = corners.filter(|corner| corner - self.time > 1e-12 * corner).fold(f64::INFINITY, f64::min);
            let (wanted, to_end, to_corner) = (*step, end - self.stage_time, ahead - self.time);
            let corner = to_corner < to_end - 1e-12 * end;
            let left = if corner { to_corner } else { to_end };
            // Equal steps to the next time, so that none of them is tiny.
            let h = left / (left / wanted - 1e-6).ceil().max(1.0);
            let grown = self.step(h)?;
            let last = !corner && left - h <= 1e-12 * end;
            if grown.accepted {
                self.stage_time = if last { end } else { self.stage_time + h };
                *done += 1;
            }
            if let Some(Method::Sdirk { step, .. }) = &mut self.method
                && !fixed
            {
                // A step that was only shortened to hit a time says nothing against the longer one.
                *step = if grown.accepted && h < wanted { wanted.max(h * grown.factor) } else { h * grown.factor };
                let step = *step;
                if step < self.least_step() {
                    return Err(self.too_small(step));
                }
            }
        }
        Ok(())
    }

    /// Least step, s.
    fn least_step(&self) -> f64 {
        let loading = if self.ramp > 0.0 { self.ramp.min(self.stage_end) } else { self.stage_end };
        if self.scene.water.is_none() { LEAST_LOAD_STEP * loading } else { LEAST_STEP * self.stage_end }
    }

    /// One step of `h` (s); the state moves only if it is accepted.
    fn step(&mut self, h: f64) -> Result<Grown, Fault> {
        let fixed = matches!(self.scene.step, StepChoice::Fixed(_));
        self.factorise(h)?;
        let (time, ramp) = (self.time, self.ramp);
        let bear = |soil: &mut Soil<L, D>, c: f64| soil.bear(time + c * h, ramp);
        let tolerance = (NEWTON * self.scene.tolerance).max(1e-12);
        let (Some(soil), Some(Method::Sdirk { stepper, .. })) = (&mut self.soil, &mut self.method) else {
            return Err(nothing());
        };
        let stepped = stepper.step(soil, (&self.y, &self.content), h, bear, (&mut self.work, tolerance));
        let sums = match stepped {
            Ok(sums) => sums,
            // Half the step may be less of a stretch.
            Err(stuck) if !fixed && !matches!(stuck, Stuck::Unsolved(_)) => {
                self.done.rejected += 1;
                self.rejected = true;
                self.trouble = Some(describe(&stuck, &self.points));
                return Ok(Grown { accepted: false, factor: 0.5 });
            }
            Err(stuck) => return Err(self.fault(&stuck, Some(h))),
        };
        let (of_water, along_path) = (self.error(), self.follow_path());
        let moves = self.scene.integrator == Integrator::Implicit;
        let caution = if self.resolves { CAUTION_IN_MOTION } else { CAUTION };
        let (allowed, tolerance) = (caution * self.scene.tolerance, self.scene.tolerance);
        // The error of a step goes with h^4: the estimate is of order 3. That of the law along its path goes with h^2.
        let by_water = (0.9 * (allowed / of_water.max(1e-300)).powf(0.25)).clamp(0.1, 5.0);
        // An error that goes with less than the root of h is that of a jump, of a weight or a pressure: the law has followed it in parts.
        let jumps = self.rejected_path.take().is_some_and(|(of, before)| along_path > (h / of).sqrt() * before);
        let along_path = if jumps { 0.0 } else { along_path };
        let by_path = (0.9 * (tolerance / along_path.max(1e-300)).sqrt()).clamp(0.1, 5.0);
        // Without water no estimate sees a limit load ahead: Newton's iteration does.
        let blind = self.scene.water.is_none() && !moves;
        let ahead = if blind { (EASY / self.work.iterations() as f64).clamp(1.0, 5.0) } else { 5.0 };
        // What was too much just now is not tried again at once.
        let most = if std::mem::take(&mut self.rejected) && !self.seeding.law.are_linear() { 1.0 } else { 5.0 };
        let factor = by_water.min(by_path).min(ahead).min(most);
        // Written so that a NaN is rejected.
        let starts = self.damps() && self.started < STARTING;
        let accepted = fixed || starts || (of_water <= allowed && along_path <= tolerance);
        if !accepted {
            self.done.rejected += 1;
            self.rejected = true;
            self.rejected_path = Some((h, along_path));
            self.trouble = Some(format!(
                "estimated error {of_water:.3e}, allowed {allowed:.3e}, and {along_path:.3e} of the stress along its path, allowed \
                 {tolerance:.3e}"
            ));
            let unknown = of_water.is_nan() || along_path.is_nan();
            return Ok(Grown { accepted: false, factor: if unknown { 0.1 } else { factor } });
        }
        self.done.accepted += 1;
        self.started += 1;
        self.book(&sums, h);
        self.time += h;
        let (strained, linear) = (self.commit(), self.soil.as_ref().is_some_and(Soil::linear));
        if strained > REMESH_STRAIN && self.scene.strain == StrainChoice::Large && self.flat() {
            self.count_work();
            self.build(self.drained)?;
            if let (Some(soil), Some(Method::Sdirk { stepper, factored, .. })) = (&self.soil, &mut self.method) {
                **stepper = Sdirk::new(soil.p.len(), soil.unknowns());
                *factored = f64::NAN;
            }
        }
        Ok(Grown { accepted: true, factor: if linear && STEADY.contains(&factor) { 1.0 } else { factor } })
    }

    /// Factors for a step of `h` (s), unless those at hand are.
    fn factorise(&mut self, h: f64) -> Result<(), Fault> {
        let (Some(soil), Some(Method::Sdirk { factored, .. })) = (&mut self.soil, &mut self.method) else {
            return Err(nothing());
        };
        if *factored == h && soil.linear() {
            return Ok(());
        }
        *factored = f64::NAN;
        if let Err(stuck) = factors(soil, &self.y, h) {
            if let Stuck::InsideOut(e) = stuck {
                return Err(inverted(&self.points, e.point));
            }
            let mut fault = self.fault(&stuck, Some(h));
            if let Some(trouble) = &self.trouble {
                fault.what = format!("{}; before: {trouble}", fault.what);
            }
            return Err(fault);
        }
        *factored = h;
        Ok(())
    }

    /// Estimated error of the last step in what flows: of the settlement, relative to it, and of the pressure, RMS beside that of
    /// the load.
    fn error(&self) -> f64 {
        let (Some(soil), Some(Method::Sdirk { stepper, .. })) = (&self.soil, &self.method) else { return f64::NAN };
        if self.scene.water.is_none() && soil.motion.is_none() {
            return 0.0;
        }
        let size = self.pressure_size();
        let least = 1e-3 * size * self.scene.height / soil.scales[1];
        let already = self.seeding.first_settlement + self.settled;
        let whole = (already + self.settlement_of(&stepper.end)).abs().max(least);
        let (mut sum, mut count) = (0.0, 0u32);
        for map in soil.water_map.iter().filter(|map| **map != HELD) {
            sum += (soil.scales[1] * stepper.error[*map as usize]).powi(2);
            count += 1;
        }
        let pressure = (sum / f64::from(count.max(1))).sqrt() / size;
        // Written so that a NaN of either stays.
        let settlement = self.settlement_of(&stepper.error).abs() / whole;
        let worst = |a: f64, b: f64| if a > b || a.is_nan() { a } else { b };
        worst(worst(settlement, pressure), self.error_of_motion(soil, &stepper.error))
    }

    /// That of displacements with inertia, RMS beside what load and weight strain the soil by, or what it has been strained by.
    fn error_of_motion(&self, soil: &Soil<L, D>, error: &[f64]) -> f64 {
        if !self.resolves {
            return 0.0;
        }
        let (mut sum, mut count, mut moved) = (0.0, 0.0, [[0.0; 2]; D]);
        for (map, u) in soil.soil_map.iter().zip(&soil.u) {
            for d in (0..D).filter(|d| map[*d] != HELD) {
                sum += (soil.scales[0] * error[map[d] as usize]).powi(2);
                count += 1.0;
            }
            (0..D).for_each(|d| moved[d] = [moved[d][0] + u[d], moved[d][1] + u[d] * u[d]]);
        }
        // Strain is what differs from the mean.
        let functions = soil.u.len() as f64;
        let strained: f64 =
            moved.iter().map(|[sum, squares]| (squares - sum * sum / functions).max(0.0) / functions).sum();
        let still = self.pressure_size() / self.scene.oedometer_modulus() * self.scene.height;
        (sum / f64::max(count, 1.0)).sqrt() / still.max(strained.sqrt())
    }

    /// Records the work and the water of the last step of `h` (s), under the mean load, and moves the unknowns to its end.
    fn book(&mut self, sums: &StepSums, h: f64) {
        let (time, ramp) = (self.time, self.ramp);
        let (Some(soil), Some(Method::Sdirk { stepper, .. })) = (&mut self.soil, &self.method) else { return };
        soil.expand(&self.y);
        let works = |soil: &mut Soil<L, D>| {
            let of = |soil: &mut Soil<L, D>, time: f64| {
                soil.bear(time, ramp);
                work_of(&soil.load, &soil.u)
            };
            [0.5 * (of(soil, time) + of(soil, time + h)), soil.weight_work()]
        };
        let before = works(soil);
        soil.expand(&stepper.end);
        let after = works(soil);
        for ((push, now), (plate, _)) in self.pushes.iter_mut().zip(soil.pushed()).zip(&soil.plates) {
            // The mean of the forces at both ends; the plate moves along the normal of its side.
            let (then, moved) = (push.force.unwrap_or_default(), plate.at(time + h) - plate.at(time));
            let mean = array_of::<_, 2, _>(|d| 0.5 * (then[d] + now[d]));
            let (axis, inwards) =
                (usize::from(plate.on as usize > 1), if plate.on as usize % 2 == 1 { -1.0 } else { 1.0 });
            if soil.motion.is_none() {
                self.totals.external_work += inwards * moved * mean[axis];
            }
            (0..2).for_each(|d| push.impulse[d] += h * mean[d]);
            push.force = Some(now);
        }
        let gained = soil.values.content.iter().zip(&self.content).map(|(now, then)| now - then);
        self.totals.external_work += after[0] - before[0] + sums.pressed_in + soil.pressed_in(gained);
        self.totals.gravity_work += after[1] - before[1];
        let moved = self.loose.iter().zip(&stepper.end).zip(&self.y);
        self.totals.released -= moved.map(|((force, end), y)| force * (end - y)).sum::<f64>();
        let held = soil.held(&soil.values.content) - soil.held(&self.content);
        self.totals.water_out += sums.outflow + sums.put_in - held;
        self.totals.water_in += sums.put_in;
        self.totals.darcy_dissipation += sums.dissipation;
        self.totals.flow_body_work += sums.body_work;
        let Impulses { kinetic, momentum, damping, damping_force, load, weight, support, plates } = sums.motion;
        self.totals.external_work += plates;
        self.totals.kinetic_gain += kinetic;
        self.totals.damping_loss += damping;
        self.totals.load_impulse += load[1];
        for d in 0..D {
            self.totals.momentum_gain[d] += momentum[d + 2 - D];
            self.totals.damping_impulse[d] += damping_force[d + 2 - D];
            self.totals.gravity_impulse[d] += weight[d + 2 - D];
            self.totals.support_impulse[d] += support[d + 2 - D];
        }
        if let Some(motion) = &mut soil.motion {
            motion.accept();
        }
        self.y.copy_from_slice(&stepper.end);
        self.content.copy_from_slice(&soil.values.content);
    }

    /// Where the step leads the soil's laws, into `ends`. Returns how far a single step of them is off, RMS beside the load.
    fn follow_path(&mut self) -> f64 {
        self.ends.clear();
        let Some(soil) = self.soil.as_ref().filter(|soil| !soil.linear()) else { return 0.0 };
        let allowed = self.scene.tolerance * self.pressure_size();
        let (mut sum, mut whole) = (0.0, 0.0);
        for part in &soil.solid {
            let Some(end) = soil.strained(part) else { return f64::NAN };
            let (end, off) = soil.followed(part, &end, allowed);
            sum += part.weight * off * off;
            whole += part.weight;
            self.ends.push(end);
        }
        (sum / whole).sqrt() / self.pressure_size()
    }

    /// The soil goes on to the end of the step. Returns the largest strain since the mesh was built.
    fn commit(&mut self) -> f64 {
        let Some(soil) = &mut self.soil else { return 0.0 };
        let mut strained: f64 = 0.0;
        for (i, end) in self.ends.drain(..).enumerate() {
            let part = &soil.solid[i];
            if end.flow.residual > f64::NEG_INFINITY {
                // Of the work done along the step what is not stored.
                let stored = |stress, strain| soil.stored(part.mark, stress, strain);
                let ((before, from), (after, to)) =
                    (stored(&part.stress, &part.strain), stored(&end.stress, &end.strain));
                let work: f64 = (0..4).map(|s| 0.5 * (from[s] + to[s]) * (end.strain[s] - part.strain[s])).sum();
                let dissipation = work - (after - before);
                self.totals.flowed.add(part.weight, &Flow { dissipation, ..end.flow });
            }
            let part = &mut soil.solid[i];
            (part.strain, part.stress, part.state) = (end.strain, end.stress, end.state);
            strained = end.strain.iter().fold(strained, |m, e| m.max(e.abs()));
        }
        strained
    }
}

/// Factors for a step of `h` (s) at unknowns `y`.
pub(super) fn factors<L: Law, const D: usize>(soil: &mut Soil<L, D>, y: &[f64], h: f64) -> Result<(), Stuck<D>> {
    soil.evaluate(y).map_err(Stuck::InsideOut)?;
    soil.refresh(GAMMA * h)
}

/// How a step went.
#[derive(Debug, Clone, Copy)]
struct Grown {
    accepted: bool,
    /// The next step as a multiple of this one.
    factor: f64,
}

/// Work of nodal forces (N) on displacements (m), J.
pub(super) fn work_of<const D: usize>(load: &[f64], u: &[[f64; D]]) -> f64 {
    u.iter().enumerate().map(|(i, u)| (0..D).map(|d| load[i * D + d] * u[d]).sum::<f64>()).sum()
}

//! Blocks and slabs on a base with friction.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::Scene;

use super::Compare;
use crate::error::Error::{self, Lacks};
use crate::exact::slab::Slab;
use crate::exact::sliding::Sliding;
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::spec::Measure;

/// Way of the centre of a block over the whole one; the end counts.
pub fn way(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = Sliding::new(scene).ok_or(Lacks("block on a base"))?;
    Ok(Box::new(move |run| way_of(run, &exact)))
}

/// The same of a run.
pub(crate) fn way_of(run: &Run, exact: &Sliding) -> Result<Comparison, Error> {
    let [first, last] = [run.samples.first(), run.samples.last()].map(|s| s.ok_or(Lacks("sample")));
    let (first, last) = (first?, last?);
    let whole = exact.distance(last.state.time);
    let look = |s: &Sample| Compared {
        counts: s.state.time == last.state.time,
        ..Compared::one(
            s.state.time,
            (s.state.centre[0] - first.state.centre[0]) / whole,
            exact.distance(s.state.time) / whole,
        )
    };
    Ok(Comparison::worst("way of the block over the whole one", run.samples[1..].iter().map(look).collect()))
}

/// Work of friction on the base of soil that does not slide, of what its weight would do over its height.
pub fn friction_work(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let gravity = scene.gravity.ok_or(Lacks("gravity"))?;
    let work = scene.mixture_density() * scene.width * scene.height * gravity * scene.height;
    Ok(Box::new(move |run| {
        let last = run.samples.last().ok_or(Lacks("sample"))?;
        let found = last.balance.base_friction_j.abs() / work;
        Ok(Comparison::single("work of friction over that of the weight", run, found, 0.0))
    }))
}

/// Velocity of a slab without ends over the exact one at the end. It is read from the kinetic energy, which the shear wave of the start
/// hardly changes: the particles come in again at the other side.
pub fn slab(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = Slab::new(scene).ok_or(Lacks("slab on a base"))?;
    let end = scene.observe_times.last().copied().ok_or(Lacks("time to look at"))?;
    let (mass, whole) = (exact.mass * scene.width, exact.speed(end));
    Ok(Box::new(move |run| {
        let look = |s: &Sample| {
            let speed = (2.0 * s.balance.kinetic_j / mass).sqrt();
            Compared::one(s.stage_time, speed / whole, exact.speed(s.stage_time) / whole)
        };
        Ok(Comparison::worst("velocity over the last one", run.observed().map(look).collect()))
    }))
}

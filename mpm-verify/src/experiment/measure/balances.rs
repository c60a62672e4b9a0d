//! Balances of a run: rest, energy and water.

use mpm_core::drive::Sample;
use mpm_core::scene::Scene;

use super::Compare;
use crate::error::Error::{self, Lacks};
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::spec::Measure;

/// The largest speed of all particles over that of free fall for as long as the stage, where nothing should move.
pub fn speed(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let end = scene.observe_times.last().copied().ok_or(Lacks("time to look at"))?;
    let fall = scene.gravity.ok_or(Lacks("gravity"))? * end;
    Ok(Box::new(move |run| {
        let look = |s: &Sample| Compared::one(s.stage_time, s.state.max_speed / fall, 0.0);
        Ok(Comparison::worst("largest speed over that of free fall", run.observed().map(look).collect()))
    }))
}

/// Energy that is stored and booked as lost, over the work of the load and of the flow so far: all of it.
pub fn energy(_: &Scene, _: &Measure) -> Result<Compare, Error> {
    Ok(Box::new(move |run| {
        let look = |s: &Sample| {
            let work = s.balance.external_work_j + s.balance.flow_body_work_j;
            Compared::one(s.stage_time, (work + s.balance.energy_residual_j) / work, 1.0)
        };
        Ok(Comparison::worst("energy stored and lost over the work", run.observed().map(look).collect()))
    }))
}

/// Water that is booked as gone, with what its balance lacks, over what has gone: what a cell holds follows from its porosity, its
/// volume and its pressure; what has gone is added up over the drained faces and the steps. Neither knows of the other.
pub fn water_balance(_: &Scene, _: &Measure) -> Result<Compare, Error> {
    Ok(Box::new(move |run| {
        let look = |s: &Sample| {
            let (out, lacking) = (s.balance.water_out_kg, s.balance.water_residual_kg);
            Compared::one(s.stage_time, 1.0 + lacking / out, 1.0)
        };
        Ok(Comparison::worst("water that is accounted for, of what has gone", run.observed().map(look).collect()))
    }))
}

//! Pore pressures of Mandel's block.

use mpm_core::drive::Run;
use mpm_core::observe::FieldPoint;
use mpm_core::scene::Scene;

use super::Compare;
use crate::error::Error::{self, Unfit};
use crate::exact::mandel::Mandel;
use crate::experiment::comparison::Comparison;
use crate::experiment::spec::Measure;

/// Times T = c t/a^2 from this one on count: before, the zone that drains is thinner than the cells.
pub(crate) const TIME_FACTOR: f64 = 0.1;

/// Over the undrained pressure in every cell; `from_time_factor` is T = c t/a^2.
pub fn pressure(scene: &Scene, measure: &Measure) -> Result<Compare, Error> {
    let exact = Mandel::new(scene).ok_or(Unfit("not Mandel's problem"))?;
    let from = measure.from_time_factor;
    Ok(Box::new(move |run| Ok(from_factor(looks(run, &exact, 0.0), from))))
}

/// Counts from a time T on alone.
pub(crate) fn from_factor(mut looks: Comparison, from: f64) -> Comparison {
    looks
        .rows
        .iter_mut()
        .for_each(|look| look.counts = look.factor.is_some_and(|factor| factor >= from * (1.0 - 1e-6)));
    looks
}

/// Pressure over p_0 in every cell at the sample times of a run that begins at a time `start` (s) of the exact solution.
pub(crate) fn looks(run: &Run, exact: &Mandel, start: f64) -> Comparison {
    let of = |point: &FieldPoint, time: f64| {
        Some([point.pressure_pa, exact.pressure(point.x_m, time + start)].map(|p| p / exact.undrained))
    };
    let mut looks = Comparison::field("p/p_0", run.observed(), of);
    looks.rows.iter_mut().for_each(|look| look.factor = Some(exact.time_factor(look.time + start)));
    looks
}

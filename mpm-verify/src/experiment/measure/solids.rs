//! Stresses, forces and displacements of soil at rest.

use mpm_core::drive::Sample;
use mpm_core::observe::FieldPoint;
use mpm_core::scene::{Integrator, Scene};

use super::Compare;
use crate::error::Error::{self, Lacks, Unfit};
use crate::exact::settlement::Settlement;
use crate::exact::strip::StripLoad;
use crate::experiment::comparison::{Compared, Comparison, Norm};
use crate::experiment::spec::Measure;
use crate::norms::worst;

/// Mean stress at every particle under a strip of load over the load, at the end: root mean square.
pub fn strip_stress(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = StripLoad::dry(scene).ok_or(Lacks("strip on dry soil"))?;
    let load = scene.surcharge.map_or(f64::NAN, |load| load.pressure);
    Ok(Box::new(move |run| {
        let places = &run.places.solid;
        let row = Compared {
            computed: places.iter().map(|p| p[2] / load).collect(),
            exact: places.iter().map(|p| -exact.pressure(p[0], p[1]) / load).collect(),
            places: places.iter().map(|p| [p[0], p[1]]).collect(),
            ..Compared::one(run.samples.last().map_or(f64::NAN, |s| s.stage_time), 0.0, 0.0)
        };
        Ok(Comparison { over_places: Norm::Rms, ..Comparison::worst("mean stress over the load", vec![row]) })
    }))
}

/// Settlement on average under a strip or disc of load over the exact one, as the energy that the soil stores: twice what is stored
/// over the load.
pub fn mean_settlement(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = Settlement::of(scene).ok_or(Lacks("strip on dry soil"))?.energy();
    Ok(Box::new(move |run| {
        let stored = run.samples.last().ok_or(Lacks("sample"))?.balance.strain_j;
        Ok(Comparison::single("mean settlement under the load over the exact one", run, stored / exact, 1.0))
    }))
}

/// Force on a plate that presses a column, between the last two times, over `M u/H`.
pub fn plate_force(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let plate = scene.plates.first().ok_or(Unfit("no plate"))?.clone();
    let end = scene.observe_times.last().copied().unwrap_or(f64::NAN);
    let exact = -scene.oedometer_modulus() * plate.at(end) / scene.height * scene.width;
    Ok(Box::new(move |run| {
        let got = |s: &Sample| Some((s.state.time, s.state.plates.first()?.impulse[1]));
        let all: Vec<_> = run.observed().filter_map(got).collect();
        let [.., (before, then), (time, now)] = all[..] else { return Err(Lacks("two times")) };
        let force = (now - then) / (time - before);
        Ok(Comparison::single("force of the plate over the exact one", run, force / exact, 1.0))
    }))
}

/// How thin a block gets whose wall is taken away, over `nu (1 + nu)/E s H`, or where its particles move how wide, over
/// `(1 - nu^2)/E s W`: nothing else presses it. Before, nothing moves.
pub fn released(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let stress = -scene.initial.as_ref().ok_or(Unfit("no given state"))?.at(&[0.0, 0.0])[1];
    let (e, nu) = (scene.elastic.youngs_modulus, scene.elastic.poisson_ratio);
    let thinner = stress * nu * (1.0 + nu) / e * scene.height;
    let (wider, first) = (stress * (1.0 - nu * nu) / e, scene.width - 0.5 * scene.spacing());
    let moves = scene.integrator != Integrator::QuasiStatic;
    Ok(Box::new(move |run| {
        let before = run.samples.iter().filter(|s| s.stage == 0);
        let mut rows: Vec<_> = before.map(|s| Compared::one(s.stage_time, s.state.settlement / thinner, 0.0)).collect();
        let last = run.observed().last().ok_or(Lacks("sample"))?;
        let reached = worst(run.places.solid.iter().map(|place| place[0]));
        let now = if moves { (reached / first - 1.0) / wider } else { last.state.settlement / thinner };
        rows.push(Compared::one(last.stage_time, now, 1.0));
        Ok(Comparison::worst("displacement over the exact one", rows))
    }))
}

/// Pore pressures of an undrained block under a strip of load, over the load, beside the sum of cosines: root mean square.
pub fn strip_pressure(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = StripLoad::new(scene).ok_or(Lacks("strip"))?;
    let load = scene.surcharge.ok_or(Lacks("load"))?.pressure;
    Ok(Box::new(move |run| {
        let of = |at: &FieldPoint, _: f64| Some([at.pressure_pa, exact.pressure(at.x_m, at.y_m)].map(|p| p / load));
        Ok(Comparison { over_places: Norm::Rms, ..Comparison::field("p over the load", run.samples.last(), of) })
    }))
}

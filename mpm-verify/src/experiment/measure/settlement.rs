//! Settlement of a column over time, and its profile of pore pressure, beside an exact column.

use mpm_core::drive::Sample;
use mpm_core::scene::{Course, LoadOn, Scene, Surcharge};

use super::Compare;
use crate::error::Error::{self, Unfit};
use crate::exact::dynamic::DynamicColumn;
use crate::exact::large_strain::LargeStrain;
use crate::exact::layered::Layered;
use crate::exact::self_weight::SelfWeight;
use crate::exact::terzaghi::Terzaghi;
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::spec::Measure;
use crate::norms::{largest, profile_error};

/// Exact settlement (m) at a time (s).
type Exact = Box<dyn Fn(f64) -> f64>;

/// The exact settlement of a scene and what it ends at, m.
fn exact(scene: &Scene, reference: &str) -> Result<(Exact, f64), Error> {
    let load = scene.surcharge.map_or(f64::NAN, |load| load.pressure);
    let whole = if scene.surcharge.is_some() { load * scene.height / scene.oedometer_modulus() } else { 1.0 };
    let none = Unfit("a column to which the reference of its case does not apply");
    let column = |exact: Option<Terzaghi>| {
        let exact: Option<Exact> = exact.map(|exact| Box::new(move |time| exact.settlement(time)) as Exact);
        exact
    };
    let exact: Option<Exact> = match reference {
        "terzaghi" => column(Terzaghi::compressible(scene)),
        "terzaghi-incompressible" => column(Terzaghi::incompressible(scene)),
        "dynamic" => DynamicColumn::new(scene).map(|exact| Box::new(move |t| exact.settlement(t)) as Exact),
        // Between the rows of the table there is no number.
        "large-strain" => {
            LargeStrain::new(scene).map(|exact| Box::new(move |t| exact.settlement(t).unwrap_or(f64::NAN)) as Exact)
        }
        "layers" => Layered::of(scene).map(|exact| Box::new(move |t| exact.settlement(t)) as Exact),
        // A load that comes and goes: ramps one after the other, over the largest settlement.
        "superposed" => {
            let (column, times) = Terzaghi::under_one_load(scene).ok_or(none)?;
            let at = move |time| column.under(&times, time);
            let largest = largest(scene.observe_times.iter().map(|time| at(*time)));
            return Ok((Box::new(at), largest));
        }
        "outline" => column(Terzaghi::compressible(&plain(scene)?)),
        "self-weight" => {
            let exact = SelfWeight::new(scene).ok_or(none)?;
            let whole = exact.final_settlement();
            return Ok((Box::new(move |time| exact.settlement(time)), whole));
        }
        other => {
            let expected =
                "terzaghi, terzaghi-incompressible, dynamic, large-strain, layers, superposed, outline or self-weight";
            return Err(Error::refused("measure.reference", expected, other));
        }
    };
    Ok((exact.ok_or(none)?, whole))
}

/// The column that an outline is, under its load that grows.
fn plain(scene: &Scene) -> Result<Scene, Error> {
    let Some(Course::Ramp(ramp_time)) = scene.loads.first().map(|load| load.course.clone()) else {
        return Err(Unfit("a load that grows"));
    };
    Ok(scene.edited(|scene| {
        scene.outline = None;
        scene.cell = scene.height / 10.0;
        (scene.width, scene.cells) = (scene.cell, [1, 10]);
        let pressure = scene.load_on_top();
        scene.loads.clear();
        scene.surcharge = Some(Surcharge { pressure, ramp_time, on: LoadOn::Surface, strip: None });
    })?)
}

/// The degree of consolidation U = S/(q H/M).
pub fn settlement(scene: &Scene, measure: &Measure) -> Result<Compare, Error> {
    let (exact, whole) = exact(scene, &measure.reference)?;
    let (counts, one) = (measure.counts(scene), scene.time_per_factor());
    let relative = measure.relative;
    Ok(Box::new(move |run| {
        let at = |s: &Sample| Compared {
            factor: one.map(|one| s.stage_time / one),
            counts: counts(s.stage_time),
            ..Compared::one(s.stage_time, s.state.settlement / whole, exact(s.stage_time) / whole)
        };
        Ok(Comparison { relative, ..Comparison::worst("U", run.observed().map(at).collect()) })
    }))
}

/// The profile error of [`crate::norms`].
pub fn profile(scene: &Scene, measure: &Measure) -> Result<Compare, Error> {
    let exact = match measure.reference.as_str() {
        "terzaghi-incompressible" => Terzaghi::incompressible(scene),
        _ => Terzaghi::compressible(scene),
    };
    let exact = exact.ok_or(Unfit("no plain column"))?;
    let (counts, one) = (measure.counts(scene), scene.time_per_factor());
    Ok(Box::new(move |run| {
        let at = |s: &Sample| Compared {
            factor: one.map(|one| s.stage_time / one),
            counts: counts(s.stage_time),
            ..Compared::one(s.stage_time, profile_error(&s.state.profile, &exact, s.stage_time), 0.0)
        };
        Ok(Comparison::worst("RMS(p - p_exact)/p_0", run.observed().map(at).collect()))
    }))
}

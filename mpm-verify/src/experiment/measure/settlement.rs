//! Settlement of a column over time, and its profile of pore pressure, beside an exact column.

use mpm_core::drive::Sample;
use mpm_core::scene::{Course, LoadOn, Scene, Surcharge};

use super::Compare;
use crate::error::Error::{self, Unfit};
use crate::exact::cam_clay::SOIL;
use crate::exact::damped_column::DampedColumn;
use crate::exact::dynamic::DynamicColumn;
use crate::exact::large_strain::LargeStrain;
use crate::exact::layered::Layered;
use crate::exact::oedometer::Oedometer;
use crate::exact::oracle::Table;
use crate::exact::self_weight::SelfWeight;
use crate::exact::terzaghi::Terzaghi;
use crate::experiment::comparison::{Compared, Comparison, Norm};
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
        "self-weight-drained" => {
            let whole = drained(scene).ok_or(none)?;
            return Ok((Box::new(move |_| whole), whole));
        }
        // The top of a bar moves at q/(rho c) until the wave comes back at 2 H/c.
        "dry-wave" => {
            let speed = (scene.oedometer_modulus() / scene.mixture_density()).sqrt();
            let velocity = load / (scene.mixture_density() * speed);
            return Ok((Box::new(move |time| velocity * time), whole));
        }
        "damped" => {
            let exact = DampedColumn::new(scene).ok_or(none)?;
            return Ok((Box::new(move |time| exact.settlement(time)), exact.whole));
        }
        "cam-clay" => return cam_clay(scene).ok_or(none),
        // Slopes over those of the table: strains are as much smaller, stresses the same.
        "cam-clay-oedometer" => {
            let soil = scene.cam_clay.ok_or(none)?;
            let whole = scene.height * -f64::exp_m1(-soil.lambda / SOIL.lambda * OEDOMETER_STRAIN);
            return Ok((Box::new(move |_| whole), whole));
        }
        // Under the load of the time, over the last one.
        "oedometer" => {
            let (soil, load) = (Oedometer::new(scene).ok_or(none)?, scene.surcharge.ok_or(Unfit("no load"))?);
            let height = scene.height;
            let whole = height * soil.strain(load.pressure);
            return Ok((Box::new(move |time| height * soil.strain(load.at(time))), whole));
        }
        other => {
            let expected = "terzaghi, terzaghi-incompressible, dynamic, large-strain, layers, superposed, outline, self-weight, \
                            self-weight-drained, dry-wave, damped, cam-clay, cam-clay-oedometer or oedometer";
            return Err(Error::refused("measure.reference", expected, other));
        }
    };
    Ok((exact.ok_or(none)?, whole))
}

/// The drained column under its own weight: each of its grains bears what lies above it, less its buoyancy, `sigma = -a Z` with
/// a = (1 - n) (rho_s - rho_w) g at the first depth Z, and is compressed by `exp(-a Z/M)`: what is left of the height is
/// `M/a (1 - exp(-a H/M))`.
fn drained(scene: &Scene) -> Option<f64> {
    let buoyant = (1.0 - scene.porosity) * (scene.grain_density - scene.water?.density) * scene.gravity?;
    let modulus = scene.oedometer_modulus();
    Some(scene.height + modulus / buoyant * (-buoyant * scene.height / modulus).exp_m1())
}

/// Final strain of the table of a layer of Cam-Clay.
const CAM_CLAY_STRAIN: f64 = 0.138_633_760_970_038_43;

/// Strain of the table of the oedometer under a load of four times the attraction.
const OEDOMETER_STRAIN: f64 = 0.149_235_500_269_318_5;

/// A layer of Cam-Clay that consolidates, by its table: between the rows there is no number.
fn cam_clay(scene: &Scene) -> Option<(Exact, f64)> {
    let table = Table::parse(include_str!("../../../../reference-data/exact/13_cam_clay_consolidation.csv"));
    let rows = table.rows(["tau", "S_over_H"]);
    let height = scene.height;
    let rate = scene.water?.mobility() * scene.cam_clay?.attraction / (height * height);
    let at = move |time: f64| {
        let row = rows.iter().find(|row| (row[0] / (rate * time) - 1.0).abs() < 1e-9);
        row.map_or(f64::NAN, |row| row[1] * height)
    };
    Some((Box::new(at), CAM_CLAY_STRAIN * height))
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

/// Pressures in the rows of a column of layers over the largest p_0: root mean square over the height.
pub fn in_layers(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = Layered::of(scene).ok_or(Unfit("not a column of layers"))?;
    Ok(Box::new(move |run| {
        let found = Comparison::profile("p over the largest p_0", run.observed(), |height, row, time| {
            [row.pressure_pa, exact.pressure(height, time)].map(|p| p / exact.largest_undrained())
        });
        Ok(Comparison { over_places: Norm::Rms, ..found })
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

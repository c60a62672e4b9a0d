//! Flow in unsaturated soil beside exact and published numbers.

use mpm_core::drive::Sample;
use mpm_core::scene::{Course, Feed, FreeSurfaceWater, Scene};
use mpm_core::water::retention::Retention;

use super::Compare;
use crate::error::Error::{self, Lacks, Unfit};
use crate::exact::richards::{Infiltration, WettedBox, between};
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::spec::Measure;

/// Discharge of the dam of Clement, Wise, Molz & Wen 1996 (doi:10.1016/0022-1694(95)02987-8) by several codes, m2/s.
const CAPILLARY_DAM: [f64; 2] = [6.066e-5, 6.076e-5];
/// Where water leaves it, m above its base.
const EXIT: [f64; 2] = [4.8, 5.0];

const SATURATION: &str = "effective saturation";

fn gardner(scene: &Scene) -> Result<(&FreeSurfaceWater, f64, f64), Error> {
    let free = scene.free_surface.as_ref().ok_or(Lacks("free surface"))?;
    let Some(Retention::Gardner { alpha }) = free.retention else {
        return Err(Unfit("the soil is not Gardner's"));
    };
    Ok((free, alpha, scene.water.ok_or(Lacks("water"))?.hydraulic_conductivity))
}

/// Effective saturation of a column after its rain has changed (Srivastava & Yeh 1991).
pub fn infiltration(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (free, alpha, conductivity) = gardner(scene)?;
    let (Some(Feed::Velocity { speed, .. }), Course::Times(times)) = (free.feeds[3], &free.courses[3]) else {
        return Err(Unfit("no rain that changes"));
    };
    let ends = [times[0], times[times.len() - 1]].map(|[_, factor]| factor * speed);
    let exact = Infiltration::new(alpha, scene.height, conductivity, scene.mobile_porosity(), ends);
    Ok(Box::new(move |run| {
        Ok(Comparison::field(SATURATION, run.observed(), |point, time| {
            Some([point.saturation, exact.at(point.y_m, time)])
        }))
    }))
}

/// Effective saturation of a column in steady flow between a water table and a suction at its top (Gardner 1958).
pub fn steady(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (free, alpha, _) = gardner(scene)?;
    let Some(Feed::Head(head)) = free.feeds[3] else { return Err(Unfit("no head at the top")) };
    let (height, at_top) = (scene.height, (alpha * (head - scene.height).min(0.0)).exp());
    Ok(Box::new(move |run| {
        Ok(Comparison::field(SATURATION, run.observed(), |point, _| {
            Some([point.saturation, between(alpha, height, at_top, point.y_m)])
        }))
    }))
}

/// Effective saturation of a box whose top is wetted (Tracy 2006).
pub fn wetted_box(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (free, alpha, conductivity) = gardner(scene)?;
    let suction = free.suction.ok_or(Lacks("suction at first"))?;
    let size = [scene.width, scene.height];
    let exact = WettedBox { alpha, size, conductivity, fillable: scene.mobile_porosity(), suction };
    Ok(Box::new(move |run| {
        Ok(Comparison::field(SATURATION, run.observed(), |point, time| {
            Some([point.saturation, exact.at([point.x_m, point.y_m], time)])
        }))
    }))
}

/// Inflow and outflow of a dam with a capillary fringe over the middle of what is published.
pub fn capillary_dam(_: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = 0.5 * (CAPILLARY_DAM[0] + CAPILLARY_DAM[1]);
    at_the_end("inflow and outflow over those of other codes", "-", move |sample| {
        let water = sample.state.water?;
        Some((vec![water.inflow_m3_s / exact, water.outflow_m3_s / exact], vec![1.0; 2]))
    })
}

/// Height of the highest water at a pressure in the last column of cells of that dam, m.
pub fn capillary_exit(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let cell = scene.cell;
    let last = scene.width - cell;
    at_the_end("height of the exit point", "m", move |sample| {
        let wet = |x: f64| sample.state.field.iter().filter(move |p| p.x_m > x && p.pressure_pa > 0.0);
        let top = wet(last).map(|p| p.y_m + 0.5 * cell).fold(0.0, f64::max);
        Some((vec![top], vec![0.5 * (EXIT[0] + EXIT[1])]))
    })
}

/// One look at the end of a run.
fn at_the_end(
    quantity: &'static str,
    unit: &'static str,
    look: impl Fn(&Sample) -> Option<(Vec<f64>, Vec<f64>)> + 'static,
) -> Result<Compare, Error> {
    Ok(Box::new(move |run| {
        let sample = run.samples.last().ok_or(Lacks("sample"))?;
        let (computed, exact) = look(sample).ok_or(Lacks("free surface"))?;
        let row = Compared { computed, exact, ..Compared::one(sample.stage_time, 0.0, 0.0) };
        Ok(Comparison { unit, ..Comparison::worst(quantity, vec![row]) })
    }))
}

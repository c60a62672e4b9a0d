//! Pore pressures in the cells of a section, beside exact fields.

use mpm_core::observe::FieldPoint;
use mpm_core::scene::Scene;

use super::Compare;
use crate::error::Error::{self, Unfit};
use crate::exact::pressed_pores::PressedPores;
use crate::exact::radial::Radial;
use crate::exact::seabed::Seabed;
use crate::exact::wells::Confined;
use crate::experiment::comparison::Comparison;
use crate::experiment::spec::Measure;

/// Cells with less of their area in the soil have their pressure elsewhere than in their middle.
const WHOLE: f64 = 0.99;
/// Nearer to a well than this (m) its pressure is that of the cell, not of the place.
const NEAR: f64 = 0.4;

/// Over the undrained pressure of a sphere or cylinder that is loaded all around, everywhere and at all times.
pub fn radial(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = Radial::of(scene).ok_or(Unfit("no ball or cylinder under one pressure"))?;
    Ok(Box::new(move |run| {
        let of = |at: &FieldPoint, time: f64| {
            let radius = if exact.is_sphere { at.x_m.hypot(at.y_m) } else { at.x_m };
            (at.soil > WHOLE).then(|| [at.pressure_pa, exact.pressure(radius, time)].map(|p| p / exact.undrained()))
        };
        Ok(Comparison::field("p/p_0", run.observed().filter(|sample| sample.stage_time > 0.0), of))
    }))
}

/// Over the pressure of a standing wave on the seabed, everywhere and at all times.
pub fn seabed(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let bed = Seabed::of(scene).ok_or(Unfit("no bed under a standing wave"))?;
    Ok(Box::new(move |run| {
        let of = |at: &FieldPoint, time: f64| {
            Some([at.pressure_pa, bed.pressure([at.x_m, at.y_m], time)].map(|p| p / bed.load()))
        };
        Ok(Comparison::field("p over the pressure of the wave", run.observed(), of))
    }))
}

/// Everywhere but near a well, over Theis' drawdown there.
pub fn around_well(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = Confined::of(scene).ok_or(Unfit("one well between walls"))?;
    let [x, y] = scene.wells[0].at;
    Ok(Box::new(move |run| {
        let of = |at: &FieldPoint, time: f64| {
            let far = (at.x_m - x).hypot(at.y_m - y) > NEAR;
            let drawdown = exact.drawdown(NEAR, time);
            far.then(|| [at.pressure_pa, exact.pressure([at.x_m, at.y_m], time)].map(|p| p / drawdown))
        };
        Ok(Comparison::field("p over the drawdown at 0.4 m", run.observed(), of))
    }))
}

/// In a closed disc of plane strain that is pressed all around, over the one undrained pressure `q Q/(lambda + G + Q)`, at the end.
pub fn sealed_disc(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let stiffness = scene.pore_stiffness();
    let share = stiffness / (scene.elastic.lame() + scene.elastic.shear_modulus() + stiffness);
    let exact = share * scene.largest_load();
    Ok(Box::new(move |run| {
        let of = |at: &FieldPoint, _: f64| (at.soil > WHOLE).then(|| [at.pressure_pa / exact, 1.0]);
        Ok(Comparison::field("p over the undrained pressure", run.samples.last(), of))
    }))
}

/// Along a column beside a line of wells, over the drawdown there.
pub fn beside_wells(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = Confined::of(scene).ok_or(Unfit("one well in a column"))?;
    Ok(Box::new(move |run| {
        Ok(Comparison::profile("p over the largest drawdown", run.observed(), |height, row, time| {
            [row.pressure_pa, exact.pressure([0.0, height], time)].map(|p| p / exact.drawdown(0.0, time))
        }))
    }))
}

/// Along a column from both ends of which steady flow goes to a well, over that at the well, `gamma_w q/(2 k) H/2`.
pub fn steady_well(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (Some(water), [well]) = (scene.water, &scene.wells[..]) else { return Err(Unfit("one well in a column")) };
    let gradient = -water.unit_weight * well.rate / (2.0 * scene.width * water.hydraulic_conductivity);
    let (height, largest) = (scene.height, (0.25 * gradient * scene.height).abs() * 2.0);
    Ok(Box::new(move |run| {
        Ok(Comparison::profile("p over that at the well", run.observed().last(), |_, row, _| {
            [row.pressure_pa, gradient * row.height_m.min(height - row.height_m)].map(|p| p / largest)
        }))
    }))
}

/// Along a column whose pores a load has narrowed and through which water rises, over that at the base, at the end.
pub fn narrowed_pores(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = PressedPores::of(scene).ok_or(Unfit("a column that a load presses and water rises through"))?;
    Ok(Box::new(move |run| {
        Ok(Comparison::profile("p over that at the base", run.observed().last(), |height, row, _| {
            [row.pressure_pa, exact.pressure(height)].map(|p| p / exact.pressure(0.0))
        }))
    }))
}

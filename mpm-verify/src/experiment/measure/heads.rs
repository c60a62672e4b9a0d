//! Hydraulic heads, discharges and water contents of flow through soil at rest.

use mpm_core::drive::Sample;
use mpm_core::observe::FieldPoint;
use mpm_core::scene::{Feed, Scene};

use super::Compare;
use crate::error::Error::{self, Lacks, Unfit};
use crate::experiment::comparison::{Compared, Comparison, Norm};
use crate::experiment::spec::Measure;
use crate::norms::worst;

/// Pieces of a path along which resistances are added up.
const PIECES: u32 = 4000;

/// Resistance (s) of the soils between the left side and a place x (m): the soil changes at upright lines.
fn resistance(scene: &Scene) -> impl Fn(f64) -> f64 + use<> {
    let (ground, width, middle) = (scene.ground(), scene.width, 0.5 * scene.height);
    move |x: f64| {
        let length = width / f64::from(PIECES);
        let of = |left: f64| {
            (x - left).clamp(0.0, length) / ground.at(&[left + 0.5 * length, middle]).hydraulic_conductivity
        };
        (0..PIECES).map(|i| of(f64::from(i) * length)).sum()
    }
}

/// Heads at the end between two reservoirs, over the difference of their levels.
fn between(scene: &Scene, [left, right]: [f64; 2], exact: impl Fn(f64) -> f64 + 'static) -> Result<Compare, Error> {
    let weight = scene.water.ok_or(Unfit("the scene is dry"))?.unit_weight;
    Ok(Box::new(move |run| {
        let of = |at: &FieldPoint, _: f64| {
            Some([at.pressure_pa / weight + at.y_m, exact(at.x_m)].map(|head| (head - right) / (left - right)))
        };
        Ok(Comparison::field("head over the difference of the levels", run.observed().last(), of))
    }))
}

/// Levels of two reservoirs at the start, m.
fn levels(scene: &Scene) -> Result<[f64; 2], Error> {
    let fed = scene.free_surface.as_ref().map(|free| free.feeds);
    let level = |feed: Option<Feed>| if let Some(Feed::Head(level)) = feed { level } else { 0.0 };
    if let Some([left, right, ..]) = fed {
        return Ok([level(left), level(right)]);
    }
    let levels: Vec<f64> = scene.loads.iter().map(|load| load.course.at(0.0, 0.0)).collect();
    <[f64; 2]>::try_from(levels).map_err(|_| Unfit("two reservoirs"))
}

/// Heads that fall along a row of soils.
pub fn in_series(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let ([left, right], resistance) = (levels(scene)?, resistance(scene));
    let whole = resistance(scene.width);
    between(scene, [left, right], move |x| left + (right - left) * resistance(x) / whole)
}

/// Heads along layers side by side.
pub fn along_layers(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let ([left, right], width) = (levels(scene)?, scene.width);
    between(scene, [left, right], move |x| left + (right - left) * x / width)
}

/// The same heads, and the discharge over the exact one between the last two times: quasi-static runs do not book what enters apart
/// from what leaves.
pub fn flow_along_layers(scene: &Scene, measure: &Measure) -> Result<Compare, Error> {
    let heads = along_layers(scene, measure)?;
    let [left, right] = levels(scene)?;
    let density = scene.water.map_or(f64::NAN, |water| water.density);
    let conductance: f64 =
        scene.by_layer().iter().map(|(d, soil)| d * soil.water.map_or(0.0, |w| w.hydraulic_conductivity)).sum();
    let exact = conductance * (left - right) / scene.width;
    Ok(Box::new(move |run| {
        let left = |s: &Sample| (s.state.time, s.balance.water_out_kg / density, s.state.water.map(|w| w.outflow_m3_s));
        let flowed: Vec<(f64, f64, Option<f64>)> = run.observed().map(left).collect();
        let [.., (before, then, _), (time, now, outflow)] = flowed[..] else { return Err(Lacks("two times")) };
        let found = outflow.unwrap_or((now - then) / (time - before));
        let mut all = heads(run)?;
        let last = all.rows.last_mut().ok_or(Lacks("sample"))?;
        last.computed.push(found / exact);
        last.exact.push(1.0);
        all.quantity += ", and discharge over the exact one";
        Ok(all)
    }))
}

/// Inflow and outflow of a dam of upright zones over the discharge of Girinskii's potential, at the end.
pub fn discharge_of_zones(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let ([left, right], resistance) = (levels(scene)?, resistance(scene)(scene.width));
    let exact = (left.powi(2) - right.powi(2)) / (2.0 * resistance);
    Ok(Box::new(move |run| {
        let last = run.samples.last().ok_or(Lacks("sample"))?;
        let water = last.state.water.ok_or(Lacks("free surface"))?;
        let computed = [water.inflow_m3_s, water.outflow_m3_s].map(|q| q / exact).to_vec();
        let row = Compared { computed, exact: vec![1.0; 2], ..Compared::one(last.stage_time, 1.0, 1.0) };
        Ok(Comparison::worst("inflow and outflow over the exact discharge", vec![row]))
    }))
}

/// Flow across the middle of a block, m, between two soils: k_1 over k_2, and the angle of the normal of their interface to the
/// horizontal; the head in the middle, m, and its fall along the level streamlines of the first soil.
pub(crate) const MIDDLE: [f64; 2] = [0.5, 0.5];
pub(crate) const RATIO: f64 = 4.0;
pub(crate) const TURNED: f64 = 0.4;
const HEAD: f64 = 4.0;
const FALL: f64 = 0.5;

/// The head at a place, m: linear in each soil, with one value and one normal flux at the interface.
pub(crate) fn refracted_head([x, y]: [f64; 2]) -> f64 {
    let (normal, along) = ([TURNED.cos(), TURNED.sin()], [-TURNED.sin(), TURNED.cos()]);
    let from = [x - MIDDLE[0], y - MIDDLE[1]];
    let dot = |a: [f64; 2]| a[0] * from[0] + a[1] * from[1];
    let across = if dot(normal) > 0.0 { RATIO } else { 1.0 };
    HEAD - FALL * (across * normal[0] * dot(normal) + along[0] * dot(along))
}

/// Heads of streamlines that are refracted, over what the head falls by in the block, at the end: root mean square.
pub fn refraction(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let weight = scene.water.map_or(f64::NAN, |water| water.unit_weight);
    let end = refracted_head([scene.width, scene.height]);
    let span = refracted_head([0.0, 0.0]) - end;
    Ok(Box::new(move |run| {
        let of = |at: &FieldPoint, _: f64| {
            let heads = [at.pressure_pa / weight + at.y_m, refracted_head([at.x_m, at.y_m])];
            Some(heads.map(|head| (head - end) / span))
        };
        let found = Comparison::field("head over its fall in the block", run.observed().last(), of);
        Ok(Comparison { over_places: Norm::Rms, ..found })
    }))
}

/// Pressures of seepage along a slope over that at the base, `rho_w g d cos(b)`, at the end.
pub fn along_slope(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (weight, height) = (-scene.water_weight()[1], scene.height);
    Ok(Box::new(move |run| {
        let of =
            |at: &FieldPoint, _: f64| Some([at.pressure_pa, weight * (height - at.y_m)].map(|p| p / (weight * height)));
        Ok(Comparison::field("p over that at the base", run.observed().last(), of))
    }))
}

/// How far the water particles of seepage along a slope have gone, over how far they should have: k sin(b)/n.
pub fn way_along_slope(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (spacing, end) = (scene.spacing(), scene.observe_times.last().copied().unwrap_or(f64::NAN));
    let k = scene.water.map_or(f64::NAN, |water| water.hydraulic_conductivity);
    let way = k * scene.slope_angle.unwrap_or(0.0).to_radians().sin() / scene.porosity * end;
    Ok(Box::new(move |run| {
        // Places modulo the spacing: particles start half a spacing from the faces of cells, and periodic sides are no matter.
        let gone = |place: &[f64; 3]| ((place[0] / spacing - 0.5).rem_euclid(1.0) * spacing) / way;
        let furthest = 1.0 + worst(run.places.water.iter().map(|place| gone(place) - 1.0));
        Ok(Comparison::single("way of the water particles over the exact one", run, furthest, 1.0))
    }))
}

/// Water in the cells of a column that rain fills, and what ran off, or came out again at the full surface, over its pores.
pub fn filled_by_rain(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let Some(Feed::Velocity { speed, .. }) = scene.free_surface.as_ref().and_then(|free| free.feeds[3]) else {
        return Err(Lacks("rain"));
    };
    let taken = speed.min(scene.water.map_or(f64::NAN, |water| water.hydraulic_conductivity));
    let (width, pores) = (scene.width, scene.mobile_porosity() * scene.width * scene.height);
    Ok(Box::new(move |run| {
        let at = |s: &Sample| {
            let water = s.state.water?;
            let inside = (taken * width * s.stage_time).min(pores);
            let computed = [water.mobile_m3, water.ran_off_m3 + water.out_m3];
            let exact = [inside, speed * width * s.stage_time - inside];
            let [computed, exact] = [computed, exact].map(|volumes| volumes.map(|v| v / pores).to_vec());
            Some(Compared { computed, exact, ..Compared::one(s.stage_time, 0.0, 0.0) })
        };
        Ok(Comparison::worst("water in cells, and run-off, over the pores", run.observed().filter_map(at).collect()))
    }))
}

/// Power that a uniform flow under its weight dissipates between the last two times, over `V rho_w^2 g^T K g/gamma_w`.
pub fn dissipation(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (water, gravity) = scene.water.zip(scene.gravity_vector()).ok_or(Unfit("water under its weight"))?;
    let (sin, cos) = water.fabric.bedding_angle.to_radians().sin_cos();
    let [along, across] = [gravity[0] * cos + gravity[1] * sin, gravity[1] * cos - gravity[0] * sin];
    let of_gravity = water.mobility() * (water.anisotropy * along * along + across * across);
    let exact = scene.width * scene.height * water.density.powi(2) * of_gravity;
    Ok(Box::new(move |run| {
        let all: Vec<_> = run.observed().map(|s| (s.state.time, s.balance.darcy_dissipation_j)).collect();
        let [.., (before, then), (time, now)] = all[..] else { return Err(Lacks("two times")) };
        let power = (now - then) / (time - before);
        Ok(Comparison::single("power dissipated over the exact one", run, power / exact, 1.0))
    }))
}

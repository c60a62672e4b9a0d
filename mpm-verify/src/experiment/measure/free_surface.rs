//! Fronts that wet dry soil, and water with a free surface in a dam.

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::{FieldPoint, WaterState};
use mpm_core::scene::{Dimension, Feed, Scene};

use super::Compare;
use crate::cases::own::applies::{Solution, solution};
use crate::error::Error::{self, Lacks, Unfit};
use crate::exact::boussinesq::Wetting;
use crate::exact::dam::Dam;
use crate::exact::wetting_front::{Way, WettingFront};
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::spec::Measure;

/// Place of a front that wets dry or moist soil from a side, m: sqrt(2 k h t/n) without gravity, Green and Ampt's with it.
pub fn front(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let Solution::Front(exact) = solution(scene)? else { return Err(Unfit("no front into dry soil")) };
    let scene = scene.clone();
    Ok(Box::new(move |run| Ok(front_of(&scene, run, &exact))))
}

/// The same in a run, at the times from the first on that was asked for.
pub(crate) fn front_of(scene: &Scene, run: &Run, exact: &WettingFront) -> Comparison {
    let from = scene.observe_times.first().copied().unwrap_or(0.0);
    let seen = |s: &&Sample| s.stage_time >= from * (1.0 - 1e-9);
    let states = run.samples.iter().filter(seen).filter_map(|s| Some((s.stage_time, s.state.water?)));
    let look =
        |(time, water): (f64, WaterState)| Compared::one(time, place_of(scene, &water, exact), exact.position(time));
    Comparison { unit: "m", ..Comparison::worst("place of the front", states.map(look).collect()) }
}

/// Place of the front of all the water that is in the soil, m.
pub(crate) fn place_of(scene: &Scene, water: &WaterState, exact: &WettingFront) -> f64 {
    let section = match (scene.dimension, exact.way) {
        (Dimension::PlaneStrain, Way::Horizontal) => scene.height,
        _ => scene.width,
    };
    water.mobile_m3 / (water.mobile_porosity * section)
}

/// Tip of the water that spreads on a level base, m: Boussinesq's lambda sqrt(k H t/n), from the level on its left.
pub fn tip(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let Solution::Mound(exact) = solution(scene)? else { return Err(Unfit("no water on a level base")) };
    let scene = scene.clone();
    Ok(Box::new(move |run| tip_of(&scene, run, &exact)))
}

/// The same in a run.
pub(crate) fn tip_of(scene: &Scene, run: &Run, exact: &Wetting) -> Result<Comparison, Error> {
    let mut rows = Vec::new();
    for sample in run.observed() {
        let found = tip_at(&filled(scene, &sample.state.field), scene.cell).ok_or(Lacks("water on the base"))?;
        rows.push(Compared::one(sample.stage_time, found, exact.front(sample.stage_time)));
    }
    Ok(Comparison { unit: "m", ..Comparison::worst("tip of the water", rows) })
}

/// The number of a column of cells, of a mesh that may be longer than that of the sound scene.
fn column(levels: &mut Vec<f64>, place: f64) -> &mut f64 {
    let place = place as usize;
    levels.resize(levels.len().max(place + 1), 0.0);
    &mut levels[place]
}

/// Height of the water in each column of cells, m.
fn filled(scene: &Scene, field: &[FieldPoint]) -> Vec<f64> {
    let mut levels = vec![0.0; scene.cells[0]];
    for point in field {
        *column(&mut levels, point.x_m / scene.cell) += point.saturation * scene.cell;
    }
    levels
}

/// Where the surface of the water meets the base, m. The surface is straight there: the flow behind a tip that moves at v is level, and
/// its slope is n v/k. So the line through the levels two and three columns behind the last wet one is carried on.
fn tip_at(levels: &[f64], cell: f64) -> Option<f64> {
    let last = levels.iter().rposition(|level| *level > 1e-6 * cell)?;
    let (behind, before) = (*levels.get(last.checked_sub(3)?)?, levels[last - 2]);
    let slope = (before - behind) / cell;
    Some((last as f64 - 1.5) * cell - before / slope)
}

fn dam(scene: &Scene) -> Result<Dam, Error> {
    if let Solution::Dam(dam) = solution(scene)? { Ok(dam) } else { Err(Unfit("no rectangular dam")) }
}

/// What a dam shows at the times of its scene; the end, when the flow is steady, counts.
fn of_dam(
    quantity: &'static str,
    unit: &'static str,
    shown: impl Fn(&Sample, WaterState) -> (Vec<f64>, Vec<f64>, Vec<[f64; 2]>) + 'static,
) -> Compare {
    Box::new(move |run| {
        let last = run.samples.last().ok_or(Lacks("sample"))?;
        let mut rows = Vec::new();
        for sample in run.observed().chain([last]) {
            let (computed, exact, places) = shown(sample, sample.state.water.ok_or(Lacks("free surface"))?);
            let counts = sample.stage_time == last.stage_time;
            rows.push(Compared { computed, exact, places, counts, ..Compared::one(sample.stage_time, 0.0, 0.0) });
        }
        Ok(Comparison { unit, ..Comparison::worst(quantity, rows) })
    })
}

/// Inflow and outflow of a dam over the steady discharge k (H1^2 - H2^2)/(2 l).
pub fn discharge(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = dam(scene)?.discharge(scene.water.ok_or(Unfit("the scene is dry"))?.hydraulic_conductivity);
    let shown = move |_: &Sample, water: WaterState| {
        ([water.inflow_m3_s, water.outflow_m3_s].map(|flow| flow / exact).to_vec(), vec![1.0; 2], Vec::new())
    };
    Ok(of_dam("inflow and outflow over the discharge of the steady flow", "-", shown))
}

/// Height of the standing water in each column of cells, m.
fn standing(scene: &Scene, sample: &Sample) -> Vec<f64> {
    let mut levels = vec![0.0; scene.cells[0]];
    for point in sample.state.field.iter().filter(|point| point.pressure_pa > 0.0) {
        let level = column(&mut levels, point.x_m / scene.cell);
        *level = level.max(point.y_m - 0.5 * scene.cell + point.saturation.min(1.0) * scene.cell);
    }
    levels
}

/// Height up to which water stands in the last column of cells of a dam, m.
pub fn exit(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (exact, scene) = (dam(scene)?, scene.clone());
    let shown = move |sample: &Sample, _| {
        let found = standing(&scene, sample).last().copied().unwrap_or(f64::NAN);
        (vec![found], vec![exact.exit_height()], Vec::new())
    };
    Ok(of_dam("height of the exit point", "m", shown))
}

/// Level and exact surface at the middles of the columns of cells over nine tenths of the length of a dam, m.
pub fn surface(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (exact, scene) = (dam(scene)?, scene.clone());
    let shown = move |sample: &Sample, _| {
        let middle = |i: usize| (i as f64 + 0.5) * scene.cell;
        let mut levels = standing(&scene, sample);
        levels.truncate((0..levels.len()).take_while(|i| middle(*i) <= 0.9 * scene.width).count());
        let places: Vec<[f64; 2]> = (0..levels.len()).map(|i| [middle(i), 0.0]).collect();
        (levels, places.iter().map(|place| exact.surface(place[0])).collect(), places)
    };
    Ok(of_dam("height of the free surface", "m", shown))
}

/// Water in cells and in particles over n times the area under the steady surface.
pub fn stored(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let exact = dam(scene)?.stored(scene.porosity);
    let shown = move |_: &Sample, water: WaterState| {
        // Faces that would draw water in leave steps unsettled.
        let lost = water.unsettled as f64;
        (vec![water.mobile_m3 / exact + lost, water.particles_m3 / exact + lost], vec![1.0; 2], Vec::new())
    };
    Ok(of_dam("water in cells and in particles over n times the area under the steady surface", "-", shown))
}

/// Water in a full column that drains at its base, over that of the full one: its level falls at k/n, and no water enters.
pub fn drains(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let speed = scene.water.ok_or(Unfit("the scene is dry"))?.hydraulic_conductivity / scene.porosity / scene.height;
    let whole = scene.porosity * scene.width * scene.height;
    Ok(Box::new(move |run| {
        // Faces that would draw water in leave steps unsettled.
        let entered = |water: &WaterState| water.in_m3 + water.unsettled as f64;
        let wet = run.observed().filter_map(|s| Some((s.stage_time, s.state.water?)));
        let look = |(time, water): (f64, WaterState)| Compared {
            computed: vec![water.mobile_m3 / whole, entered(&water) / whole],
            exact: vec![1.0 - speed * time, 0.0],
            ..Compared::one(time, 0.0, 0.0)
        };
        Ok(Comparison::worst("water, and what has entered, over that of the full column", wet.map(look).collect()))
    }))
}

/// What rain on soil of any outline was asked to bring, and what came in or ran off, over the rate times the width under the sky.
pub fn rain(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let Some(Feed::Velocity { speed, .. }) = scene.free_surface.as_ref().and_then(|free| free.feeds[3]) else {
        return Err(Lacks("rain"));
    };
    let outline = scene.outline.as_ref().ok_or(Lacks("outline"))?;
    let places = || outline.iter().map(|corner| corner[0]);
    let wide = places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min);
    Ok(Box::new(move |run| {
        let look = |s: &Sample| {
            let (water, asked) = (s.state.water?, speed * wide * s.stage_time);
            let computed = [water.asked_m3, water.in_m3 + water.ran_off_m3].map(|volume| volume / asked).to_vec();
            Some(Compared { computed, exact: vec![1.0; 2], ..Compared::one(s.stage_time, 1.0, 1.0) })
        };
        Ok(Comparison::worst("rain over the rate times the width", run.observed().filter_map(look).collect()))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_water_ends_where_its_line_does() {
        let cell = 0.1;
        let levels: Vec<f64> = (0..20).map(|i| (0.2 * (1.23 - (f64::from(i) + 0.5) * cell)).max(0.0)).collect();
        assert!((tip_at(&levels, cell).unwrap() - 1.23).abs() < 1e-12);
    }
}

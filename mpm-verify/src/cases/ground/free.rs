//! Water with a free surface: a dam of zones, rain on a column, seepage along a slope that its water particles follow.

use mpm_core::observe::WaterState;
use mpm_core::scene::{Feed, Fields, FreeSurfaceWater, Integrator, Scene, ShapeChoice, Until};

use super::super::{FASTER, Lacks, faster, sound};
use super::*;
use crate::norms::largest;

const CORE: Setup = Setup {
    scene: "dam-with-core",
    change: sound,
    mesh: refined,
    measure: zones,
    cells: &[10.0, 20.0],
    required: 1.2e-2,
    order: None,
};
const RAIN: Setup = Setup {
    scene: "rain-on-column",
    change: sound,
    mesh: refined,
    measure: fills,
    cells: &[10.0, 20.0],
    required: 1e-9,
    order: None,
};
const ALONG: Setup = Setup {
    scene: "seepage-along-slope",
    change: steady,
    mesh: refined,
    measure: along_slope,
    cells: &[8.0],
    required: 1e-9,
    order: None,
};

/// All of them.
pub const CASES: [Program; 5] = [
    case!(
        "dam-core",
        "discharge of a dam with an upright clay core between two levels",
        "conductivity of the core 5 % too high",
        faster_core,
        CORE
    ),
    case!(
        "dam-core-dry-side",
        "the same without tail water",
        "conductivity of the core 5 % too high",
        faster_core,
        Setup { change: without_tail, ..CORE }
    ),
    case!(
        "rain-fills",
        "rain fills a column in n (1 - S_0) H/v and runs off from then on: water in cells, run-off",
        "rain 0.1 % too strong",
        stronger,
        RAIN
    ),
    case!(
        "rain-above-k",
        "rain stronger than k: k enters, the rest runs off",
        FASTER,
        faster,
        Setup { change: cloudburst, ..RAIN }
    ),
    case!(
        "seepage-along-slope-flow",
        "k sin(b) of Darcy flow along an infinite slope full of water: how far its water particles go",
        FASTER,
        faster,
        ALONG
    ),
];

fn without_tail(scene: &mut Fields) {
    if let Some(free) = &mut scene.free_surface {
        free.feeds[1] = None;
    }
}

fn faster_core(scene: &mut Fields) {
    scene.regions[0].soil.hydraulic_conductivity *= 1.05;
}

fn rain(scene: &mut Fields, factor: f64) {
    if let Some(Feed::Velocity { speed, .. }) = scene.free_surface.as_mut().and_then(|free| free.feeds[3].as_mut()) {
        *speed *= factor;
    }
}

fn stronger(scene: &mut Fields) {
    rain(scene, 1.001);
}

/// Twice what the soil takes.
fn cloudburst(scene: &mut Fields) {
    rain(scene, 5.0);
    scene.observe_times = vec![100.0, 200.0, 300.0, 400.0, 450.0, 500.0, 700.0];
    scene.stages[0].until = Until::Time(700.0);
}

/// The slope with water that seeps by itself, for as long as its particles take for a quarter of their spacing.
fn steady(scene: &mut Fields) {
    (scene.integrator, scene.shape) = (Integrator::Staggered, ShapeChoice::Centre);
    let (saturation, level) = (0.0, Some(scene.height));
    scene.free_surface =
        Some(FreeSurfaceWater { saturation, level, wet: None, feeds: [None; 4], courses: Default::default() });
    let time = 0.25 * scene.spacing() / speed(scene);
    scene.stages[0].drained = [false; 4];
    scene.stages[0].until = Until::Time(time);
    scene.observe_times = vec![time];
}

/// Speed of the water in the pores, k sin(b)/n, m/s.
fn speed(scene: &Fields) -> f64 {
    let k = scene.water.map_or(f64::NAN, |water| water.hydraulic_conductivity);
    k * scene.slope_angle.unwrap_or(0.0).to_radians().sin() / scene.porosity
}

/// Outflow over that of zones one behind the other: potential of Girinskii.
fn zones(scene: &Scene) -> Measured {
    let feeds = scene.free_surface.as_ref().ok_or(Lacks("free surface"))?.feeds;
    let level = |side: usize| if let Some(Feed::Head(level)) = feeds[side] { level } else { 0.0 };
    let (ground, width, height) = (scene.ground(), scene.width, scene.height);
    let resistance: f64 = {
        let pieces: u32 = 4000;
        let length = width / f64::from(pieces);
        let middle = |i: u32| [(f64::from(i) + 0.5) * length, 0.5 * height];
        (0..pieces).map(|i| length / ground.at(&middle(i)).hydraulic_conductivity).sum()
    };
    let exact = (level(0).powi(2) - level(1).powi(2)) / (2.0 * resistance);
    Ok(Box::new(move |run| {
        let Some(water) = run.samples.last().and_then(|s| s.state.water) else { return f64::NAN };
        largest([water.inflow_m3_s, water.outflow_m3_s].map(|q| q / exact - 1.0).into_iter())
    }))
}

/// Water in the cells and what ran off, or came out again at the full surface, over the pores of the column, at every time.
fn fills(scene: &Scene) -> Measured {
    let Some(Feed::Velocity { speed, .. }) = scene.free_surface.as_ref().and_then(|free| free.feeds[3]) else {
        return Err(Lacks("rain"));
    };
    let taken = speed.min(scene.water.map_or(f64::NAN, |water| water.hydraulic_conductivity));
    let (width, pores) = (scene.width, scene.mobile_porosity() * scene.width * scene.height);
    Ok(Box::new(move |run| {
        let off = |(time, water): (f64, WaterState)| {
            let inside = (taken * width * time).min(pores);
            let ran_off = water.ran_off_m3 + water.out_m3 - (speed * width * time - inside);
            largest([water.mobile_m3 - inside, ran_off].map(|off| off / pores).into_iter())
        };
        largest(run.observed().filter_map(|s| Some((s.stage_time, s.state.water?))).map(off))
    }))
}

/// How far the water particles have gone, over how far they should have: all by a quarter of their spacing along the slope.
fn along_slope(scene: &Scene) -> Measured {
    let (spacing, end) = (scene.spacing(), scene.observe_times.last().copied().unwrap_or(f64::NAN));
    let sought = speed(scene) * end;
    Ok(Box::new(move |run| {
        // Places modulo the spacing: particles start half a spacing from the faces of cells, and periodic sides are no matter.
        let gone = |place: &[f64; 3]| ((place[0] / spacing - 0.5).rem_euclid(1.0) * spacing) / sought - 1.0;
        largest(run.places.water.iter().map(gone))
    }))
}

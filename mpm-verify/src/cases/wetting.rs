//! Sharp fronts that wet dry soil: level, down and up, in soil that is dry or moist; and the ledger of the water.

use mpm_core::drive::Run;
use mpm_core::observe::WaterState;
use mpm_core::scene::{Dimension, Fields, Scene};

use super::{Error, FASTER, Mutant, Outcome, Program, Unfit, faster, finished, integrator, sound};
use crate::exact::wetting_front::{Way, WettingFront};
use crate::experiment::comparison::{Compared, Comparison, in_particles};
use crate::norms::largest;

/// A level front.
pub const HORIZONTAL: Program = Program {
    name: "front-horizontal",
    about: "a front without gravity stands at sqrt(2 k h t/n), to half a cell on every mesh",
    run: || fronts(&scene("wetting-front", 0.0)?, Way::Horizontal, sound),
    mutant: Some(Mutant { what: FASTER, run: || fronts(&scene("wetting-front", 0.0)?, Way::Horizontal, faster) }),
};

/// A front that goes down.
pub const DOWN: Program = Program {
    name: "front-down",
    about: "infiltration from 0.25 m of water: the front of Green & Ampt",
    run: || fronts(&scene("infiltration", 0.0)?, Way::Down, sound),
    mutant: Some(Mutant { what: FASTER, run: || fronts(&scene("infiltration", 0.0)?, Way::Down, faster) }),
};

/// A front that rises.
pub const UP: Program = Program {
    name: "front-up",
    about: "a front that rises against its weight",
    run: || fronts(&scene("rising-front", 0.0)?, Way::Up, sound),
    mutant: Some(Mutant { what: FASTER, run: || fronts(&scene("rising-front", 0.0)?, Way::Up, faster) }),
};

/// A level front in moist soil.
pub const MOIST: Program = Program {
    name: "front-moist",
    about: "a front in soil with S_0 = 0.5 has half the pores to fill",
    run: || fronts(&scene("wetting-front", 0.5)?, Way::Horizontal, sound),
    mutant: Some(Mutant {
        what: "the soil ahead of the front dry",
        run: || {
            fronts(&scene("wetting-front", 0.5)?, Way::Horizontal, |scene| {
                if let Some(free) = &mut scene.free_surface {
                    free.saturation = 0.0;
                }
            })
        },
    }),
};

/// The water of all three, in cells and in particles.
pub const LEDGER: Program = Program {
    name: "front-water-balance",
    about: "no water is made or lost, in cells or in particles, at 4 and 9 per cell",
    run: || ledger(0.0),
    mutant: Some(Mutant { what: "one water particle lost", run: || ledger(1.0) }),
};

/// The scene of a front, in soil with a first saturation.
fn scene(name: &str, saturation: f64) -> Result<Scene, Error> {
    let mut scene = crate::scenes::built_in(name).expect("the built-in scene holds").edited(|scene| {
        if let Some(free) = &mut scene.free_surface {
            free.saturation = saturation;
        }
    })?;
    if saturation > 0.0 {
        // Half of the pores are filled in half of the time.
        scene = scene.edited(|scene| {
            for time in &mut scene.observe_times {
                *time *= 1.0 - saturation;
            }
            scene.stages[0].until = mpm_core::scene::Until::Time(scene.observe_times.last().copied().unwrap_or(1.0));
        })?;
    }
    Ok(scene)
}

/// The exact front of a scene.
fn exact(scene: &Scene, way: Way) -> Option<WettingFront> {
    let free = scene.free_surface.as_ref()?;
    let head = free.feeds.iter().flatten().find_map(|feed| match feed {
        mpm_core::scene::Feed::Head(head) => Some(*head),
        mpm_core::scene::Feed::Velocity { .. } => None,
    })?;
    let head = if way == Way::Down { head - scene.height } else { head };
    Some(WettingFront {
        way,
        conductivity: scene.water?.hydraulic_conductivity,
        head,
        porosity: scene.porosity,
        initial_saturation: free.saturation,
    })
}

/// Cross section of the front, m2.
fn section(scene: &Scene, way: Way) -> f64 {
    match (scene.dimension, way) {
        (Dimension::PlaneStrain, Way::Horizontal) => scene.height,
        _ => scene.width,
    }
}

/// How far the water has come, m.
fn place(water: &WaterState, section: f64) -> f64 {
    water.mobile_m3 / (water.mobile_porosity * section)
}

/// Edges of the cells, m.
const CELLS: [f64; 4] = [0.1, 0.05, 0.025, 0.0125];

fn fronts(scene: &Scene, way: Way, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let exact = exact(scene, way).ok_or(Unfit("the scene has no feed"))?;
    let seen = |mut scene: Scene| {
        scene = scene.edited(fault)?;
        let run = finished(&scene)?;
        Ok::<_, Error>((looks(&scene, &run, way, &exact), of_layer(&scene, &run)))
    };
    let (mut errors, mut samples, mut in_layer) = (Vec::new(), Vec::new(), Vec::new());
    for cell in CELLS {
        let (looks, of_layer) = seen(on(scene, cell)?)?;
        errors.push((cell, looks.error().abs()));
        in_layer.push(of_layer);
        samples = looks.samples();
    }
    let finest = errors[errors.len() - 1].0;
    let with =
        |particles_per_cell| Ok(seen(on(scene, CELLS[1])?.edited(|s| s.particles_per_cell = particles_per_cell)?)?.0);
    Ok(Outcome {
        integrator: integrator(scene),
        scheme: "free surface".to_owned(),
        errors,
        required_error: 0.5 * finest,
        required_order: Some([0.9, 4.0]),
        required_everywhere: Some(0.5),
        notes: vec![(
            "water in particles over water in cells - 1, largest".to_owned(),
            largest(in_layer.into_iter()),
            "-".to_owned(),
        )],
        samples,
        refinements: vec![in_particles(with, CELLS[1], &[1, 4, 9, 16], 0.5 * CELLS[1])?],
        ..Outcome::default()
    })
}

/// The samples from the first time that was asked for on, with their water.
fn wet<'a>(scene: &Scene, run: &'a Run) -> impl Iterator<Item = (f64, WaterState)> + 'a {
    let from = scene.observe_times.first().copied().unwrap_or(0.0);
    let seen = move |time: f64| time >= from * (1.0 - 1e-9);
    let states = run.samples.iter().filter(move |s| seen(s.stage_time));
    states.filter_map(|s| Some((s.stage_time, s.state.water?)))
}

/// Where the front stands.
pub(super) fn looks(scene: &Scene, run: &Run, way: Way, exact: &WettingFront) -> Comparison {
    let look = |(time, water): (f64, WaterState)| {
        Compared::one(time, place(&water, section(scene, way)), exact.position(time))
    };
    Comparison { unit: "m", ..Comparison::worst("place of the front", wet(scene, run).map(look).collect()) }
}

/// How far the water in particles is off that in cells, as a share, at most.
fn of_layer(scene: &Scene, run: &Run) -> f64 {
    largest(wet(scene, run).map(|(_, water)| water.particles_m3 / water.mobile_m3 - 1.0))
}

/// The scene on square cells of an edge (m).
fn on(scene: &Scene, cell: f64) -> Result<Scene, Error> {
    Ok(scene.with_cell(cell)?)
}

/// What is left of the water's balance, as a share of what came in: `lost` particles are taken away on the way.
fn ledger(lost: f64) -> Result<Outcome, Error> {
    let mut offs = Vec::new();
    for (name, per_cell) in [("wetting-front", 4), ("infiltration", 9), ("rising-front", 4), ("dam", 9)] {
        let scene = scene(name, 0.0)?.edited(|scene| scene.particles_per_cell = per_cell)?;
        for sample in finished(&scene)?.samples {
            let Some(water) = sample.state.water.filter(|w| w.in_m3 > 0.0) else { continue };
            let cells = water.mobile_m3 - water.in_m3 + water.out_m3;
            let one = water.particles_m3 / water.particles.max(1) as f64;
            let layer = water.particles_m3 - lost * one + water.pending_m3 - water.in_m3 + water.out_m3;
            let count = water.spawned as f64 - water.removed as f64 - water.particles as f64;
            let ledger = sample.balance.water_residual_kg / 1000.0;
            offs.extend([cells, layer, count * one, ledger].map(|off| off / water.in_m3));
        }
    }
    Ok(Outcome {
        integrator: "staggered".to_owned(),
        scheme: "free surface".to_owned(),
        errors: vec![(0.05, largest(offs.into_iter()))],
        required_error: 1e-12,
        ..Outcome::default()
    })
}

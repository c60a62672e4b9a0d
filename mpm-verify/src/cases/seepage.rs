//! Faces to the air: a full column that drains, where suction must not draw water in, and rain on soil of any outline.

use mpm_core::observe::WaterState;
use mpm_core::scene::{Dimension, Feed, Fields, Scene, Side, SolidSide, Until};

use super::{Error, FASTER, Lacks, Mutant, Outcome, Program, Unfit, faster, finished, integrator, sound};
use crate::experiment::comparison::{Compared, Comparison};
use crate::norms::largest;

/// A column that drains.
pub const DRAINS: Program = Program {
    name: "column-drains",
    about: "the level of a full column that drains at its base falls at k/n, and no water enters through its top",
    run: || drains(sound),
    mutant: Some(Mutant { what: FASTER, run: || drains(faster) }),
};

/// Rain.
pub const RAIN: Program = Program {
    name: "rain",
    about: "rain on slopes, berms and peaks: what enters is the rate times the width under the sky, on every mesh",
    run: || rain(1.0),
    mutant: Some(Mutant { what: "rain 0.1 % too strong", run: || rain(1.001) }),
};

/// A scene of a column or an outline that is `wide` and 1 m high, dry or full, on a mesh.
fn scene(dimension: Dimension, outline: &[[f64; 2]], cell: f64) -> Result<Scene, Error> {
    let dam = crate::scenes::built_in("dam")?;
    let edit = |scene: &mut Fields| {
        (scene.dimension, scene.width, scene.cell, scene.history) = (dimension, 0.1, cell, 0);
        scene.stages[0].drained = [false; 4];
        if !outline.is_empty() {
            scene.width = outline.iter().map(|x| x[0]).fold(0.0, f64::max);
            scene.outline = Some(outline.to_vec());
            // Its right wall need not be where the mesh ends.
            scene.solid_sides[Side::Right as usize] = SolidSide::Free;
        }
        if let Some(free) = &mut scene.free_surface {
            free.feeds = [None; 4];
        }
    };
    Ok(dam.edited(edit)?)
}

/// Darcy: under a gradient of one all water of a full column falls at k, its pressure zero, and its level at k/n. The times end
/// before the level, which is smeared as it falls, comes near the base.
fn drains(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let (mut errors, mut samples, mut entered) = (Vec::new(), Vec::new(), Vec::new());
    for rows in [10, 20, 40] {
        let mut scene = scene(Dimension::Column, &[], 1.0 / f64::from(rows))?;
        let speed = scene.water.ok_or(Unfit("the scene is dry"))?.hydraulic_conductivity / scene.porosity;
        scene = scene.edited(|scene| {
            if let Some(free) = &mut scene.free_surface {
                free.level = Some(1.0);
            }
            scene.stages[0].drained = [false, false, true, true];
            scene.stages[0].until = Until::Time(0.4 / speed);
            scene.observe_times = [0.1, 0.2, 0.3, 0.4].map(|fallen| fallen / speed).into();
        })?;
        let whole = scene.porosity * scene.width;
        scene = scene.edited(fault)?;
        let run = finished(&scene)?;
        let wet = |s: &mpm_core::drive::Sample| Some((s.stage_time, s.state.water?));
        let look = |(time, water): (f64, WaterState)| Compared::one(time, water.mobile_m3 / whole, 1.0 - speed * time);
        let looks =
            Comparison::worst("water over that of the full column", run.observed().filter_map(wet).map(look).collect());
        errors.push((scene.cell, looks.error().abs()));
        // Faces that would draw water in leave steps unsettled.
        entered.extend(run.samples.iter().filter_map(wet).map(|(_, water)| water.in_m3 + water.unsettled as f64));
        samples = looks.samples();
    }
    let entered = largest(entered.into_iter());
    if entered > 0.0 {
        errors.push((0.0, entered));
    }
    Ok(Outcome {
        integrator: "staggered".to_owned(),
        scheme: "free surface".to_owned(),
        required_error: 1e-4,
        required_everywhere: Some(0.02),
        errors,
        notes: vec![("water that entered, largest".to_owned(), entered, "m3".to_owned())],
        samples,
        ..Outcome::default()
    })
}

/// Outlines by their corners, m: a levee, a peak, a berm, an overhang and a slope between walls.
const OUTLINES: [&[[f64; 2]]; 5] = [
    &[[0.0, 0.0], [3.1, 0.0], [1.05, 1.0], [0.0, 1.0]],
    &[[0.13, 0.0], [2.9, 0.0], [1.3, 1.0]],
    &[[0.0, 0.0], [3.0, 0.0], [2.2, 0.47], [1.7, 0.47], [0.9, 1.0], [0.4, 1.0]],
    &[[0.5, 0.0], [2.0, 0.0], [2.0, 0.6], [2.6, 0.6], [2.6, 1.0], [0.5, 1.0]],
    &[[0.0, 0.0], [2.0, 0.0], [2.0, 0.3], [0.0, 1.0]],
];

/// Rain at a tenth of k, for as long as fills a tenth of a metre of pores; its strength is wrong by a factor.
fn rain(factor: f64) -> Result<Outcome, Error> {
    let mut errors = Vec::new();
    for outline in OUTLINES {
        let along = |d: usize| outline.iter().map(move |x| x[d]);
        let (left, right) = (along(0).fold(f64::INFINITY, f64::min), along(0).fold(0.0, f64::max));
        for (cell, per_cell) in [(0.2, 4), (0.13, 4), (0.1, 9)] {
            let mut scene = scene(Dimension::PlaneStrain, outline, cell)?;
            let speed = 0.1 * scene.water.ok_or(Unfit("the scene is dry"))?.hydraulic_conductivity;
            let time = 0.1 * scene.porosity / speed;
            scene = scene.edited(|scene| {
                scene.particles_per_cell = per_cell;
                if let Some(free) = &mut scene.free_surface {
                    free.feeds[3] = Some(Feed::Velocity { speed: factor * speed, height: 1.0 });
                }
                (scene.stages[0].drained, scene.stages[0].until) = ([false; 4], Until::Time(time));
                scene.observe_times = vec![time];
            })?;
            let run = finished(&scene)?;
            let water = run.samples.last().and_then(|s| s.state.water).ok_or(Lacks("free surface"))?;
            let asked = speed * (right - left) * time;
            let off = [water.asked_m3, water.in_m3 + water.ran_off_m3].map(|entered| entered / asked - 1.0);
            errors.push((cell, largest(off.into_iter())));
        }
    }
    let worst = largest(errors.iter().map(|(_, error)| *error));
    Ok(Outcome {
        integrator: integrator(&scene(Dimension::PlaneStrain, OUTLINES[0], 0.1)?),
        scheme: "free surface".to_owned(),
        errors: vec![(0.1, worst)],
        required_error: 1e-9,
        ..Outcome::default()
    })
}

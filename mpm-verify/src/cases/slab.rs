//! A slab without ends on a tilted base: adhesion, a normal load that grows and is remembered, and water under it.
//!
//! What the slab has of velocity is read from its kinetic energy, which the shear wave of the start hardly changes: its
//! particles come in again at the other side. Water that fills its cells does not: its slab slides for less than half a cell.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{
    Base, Coupling, Fields, Integrator, LoadOn, NormalStress, Scene, Side, SolidSide, Surcharge, Until,
};

use super::{Error, Lacks, Mutant, Outcome, Program, finished, integrator, scheme, sound};
use crate::exact::slab::Slab;
use crate::experiment::comparison::{Compared, Comparison};

/// A dry one under a load that grows.
pub const REMEMBERS: Program = Program {
    name: "slab-remembers",
    about: "a dry slab with adhesion under a normal load that grows, friction that lags behind it: velocity",
    run: || outcome(loaded, FAR, sound),
    mutant: Some(Mutant { what: "a tenth more memory", run: || outcome(loaded, FAR, forgetting) }),
};

/// A full one.
pub const SATURATED: Program = Program {
    name: "slab-on-water",
    about: "a slab with adhesion that is full of water, whose pressure on the base takes from its friction: velocity",
    run: || outcome(saturated, NEAR, sound),
    mutant: Some(Mutant { what: STICKIER, run: || outcome(saturated, NEAR, stickier) }),
};

/// The same whose water has a free surface.
pub const FREE_SURFACE: Program = Program {
    name: "slab-on-free-water",
    about: "the same with a free surface and given pressures",
    run: || outcome(seeping, FAR, sound),
    mutant: Some(Mutant { what: STICKIER, run: || outcome(seeping, FAR, stickier) }),
};

/// Cells over the height, and how long the slab slides, s.
type Slide = ([usize; 3], f64);
const FAR: Slide = ([4, 8, 16], 0.3);
const NEAR: Slide = ([2, 4, 8], 0.15);
const STICKIER: &str = "a tenth more adhesion";

fn forgetting(scene: &mut Fields) {
    scene.base = scene.base.map(|base| Base { memory: 1.1 * base.memory, ..base });
}

fn stickier(scene: &mut Fields) {
    scene.base = scene.base.map(|base| Base { adhesion: 1.1 * base.adhesion, ..base });
}

fn built_in(name: &str) -> Result<Scene, Error> {
    crate::scenes::built_in(name)
}

/// The slope of a scene, thinner and stiffer, on a base that it slides on.
fn slab(mut scene: Scene, memory: f64, end: f64) -> Result<Scene, Error> {
    scene = scene.edited(|scene| {
        (scene.height, scene.elastic.youngs_modulus) = (0.4, 1e9);
        on_mesh(scene, 4);
        if let Some(free) = &mut scene.free_surface {
            free.level = Some(scene.height);
        }
        scene.base = Some(Base {
            peak_angle: 15.0,
            residual_angle: 15.0,
            slip_distance: None,
            adhesion: 300.0,
            memory,
            normal_stress: NormalStress::Effective,
        });
        scene.solid_sides[Side::Bottom as usize] = SolidSide::Roller;
    })?;
    let last = scene.stages.len() - 1;
    Ok(scene.edited(|scene| {
        scene.stages[last].until = Until::Time(end);
        scene.observe_times = [0.25, 0.5, 0.75, 1.0].map(|share| share * end).to_vec();
        (scene.history, scene.safety) = (0, 0.9);
    })?)
}

/// Thrown, so that it slides under the whole load.
fn loaded() -> Result<Scene, Error> {
    Ok(slab(built_in("infinite-slope")?, 0.05, FAR.1)?.edited(|scene| {
        scene.start_velocity = Some([1.0, 0.0]);
        scene.surcharge = Some(Surcharge { pressure: 1e4, on: LoadOn::Surface, ramp_time: FAR.1, strip: None });
    })?)
}

fn saturated() -> Result<Scene, Error> {
    // No file has soil full of water on a slope yet.
    let scene = slab(built_in("infinite-slope")?, 0.0, NEAR.1)?.altered_unchecked(|scene| {
        (scene.water, scene.particles_per_cell) = (crate::scenes::terzaghi().water, 1);
        if let Some(water) = &mut scene.water {
            // Nothing drains within a second.
            water.hydraulic_conductivity = 1e-12;
        }
    });
    Ok(scene)
}

fn seeping() -> Result<Scene, Error> {
    Ok(slab(built_in("slope-seepage")?, 0.0, FAR.1)?.edited(|scene| {
        (scene.strength, scene.integrator) = (None, Integrator::Staggered);
        if let Some(soil) = scene.stages.last_mut() {
            (soil.damping, soil.coupling) = (0.0, Coupling::Soil);
        }
    })?)
}

/// The slab on a mesh of so many cells over its height, four wide.
fn on_mesh(scene: &mut Fields, rows: usize) {
    scene.cell = scene.height / rows as f64;
    (scene.cells, scene.width) = ([4, rows], 4.0 * scene.cell);
}

/// The velocity over the exact one at the end.
fn looks(run: &Run, scene: &Scene, exact: &Slab, end: f64) -> Comparison {
    let mass = exact.mass * scene.width;
    let whole = exact.speed(end);
    let look = |s: &Sample| {
        Compared::one(
            s.stage_time,
            (2.0 * s.balance.kinetic_j / mass).sqrt() / whole,
            exact.speed(s.stage_time) / whole,
        )
    };
    Comparison::worst("velocity over the last one", run.observed().map(look).collect())
}

fn outcome(scene: fn() -> Result<Scene, Error>, (rows, end): Slide, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let base = scene()?;
    let exact = Slab::new(&base).ok_or(Lacks("slab on a base"))?;
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for rows in rows {
        // One of the slabs is no scene.
        let scene = base.clone().altered_unchecked(|scene| {
            on_mesh(scene, rows);
            fault(scene);
        });
        let looks = looks(&finished(&scene)?, &scene, &exact, end);
        errors.push((scene.cell, looks.error()));
        samples = looks.samples();
    }
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 5e-4,
        required_everywhere: Some(0.01),
        samples,
        ..Outcome::default()
    })
}

//! Strength reduction against the same slope whose scene has the reduced strength: they slide alike, to round-off.
//!
//! The factor divides c, tan(phi) and tan(psi) of the soil, and adhesion, peak and residual friction of the base; nothing else
//! changes. Two models that differ in how they came by their strength are driven by the same steps.

use mpm_core::constitutive::Altered;
use mpm_core::observe::SolidState;
use mpm_core::run::failing;
use mpm_core::scene::{Base, Scene, Strength};
use mpm_core::stability::choose_step;
use mpm_core::step::Pace;
use mpm_core::water::Pressures;

use super::{Error, Lacks, Mutant, Outcome, Program, Unfit};
use crate::experiment::refinement::RUNS;
use crate::norms::largest;

/// The case.
pub const CASE: Program = Program {
    name: "reduced-strength",
    about: "strength reduction by 1.5 and 3 against scenes with the reduced strength of soil and base: how apart they slide",
    run: || outcome(1.0),
    mutant: Some(Mutant { what: "a factor 0.1 % too large", run: || outcome(1.001) }),
};

const FACTORS: [f64; 2] = [1.5, 3.0];
/// Steps of the soil: it slides further than its base takes to weaken.
const STEPS: u64 = 600;

/// The levee on coarse cells, with dilation and on a base that sticks, as it stands or with a strength of its own.
pub(super) fn levee(edits: &[(&str, &str)]) -> Result<Scene, Error> {
    let text = crate::scenes::BUILT_IN.iter().find(|(name, _)| *name == "levee").ok_or(Lacks("such scene"))?.1;
    let mut text = text.to_owned();
    let coarse = [("cell = 0.2 #", "cell = 0.75 #"), ("empty_cells_beside = 28", "empty_cells_beside = 8")];
    for (from, to) in coarse.iter().chain(edits) {
        if !text.contains(from) {
            return Err(Error::refused("the levee", format!("`{from}` in its scene"), "none"));
        }
        text = text.replace(from, to);
    }
    Ok(Scene::parse(&text, "levee")?)
}

/// The same slope with its strength divided by a factor.
fn weaker(scene: &Scene, factor: f64) -> Result<Scene, Error> {
    let angle = |angle: f64| (angle.to_radians().tan() / factor).atan().to_degrees();
    let strength = scene.strength.ok_or(Unfit("the soil is elastic"))?;
    let base = scene.base.ok_or(Lacks("friction on the base"))?;
    let strength = Strength {
        cohesion: strength.cohesion / factor,
        friction_angle: angle(strength.friction_angle),
        dilation_angle: angle(strength.dilation_angle),
        ..strength
    };
    let base = Base {
        adhesion: base.adhesion / factor,
        peak_angle: angle(base.peak_angle),
        residual_angle: angle(base.residual_angle),
        ..base
    };
    Ok(scene.edited(|s| {
        s.strength = Some(strength);
        s.base = Some(base);
    })?)
}

/// Lets a slope slide with its strength divided by a factor.
fn slide(scene: &Scene, factor: f64, dt: f64) -> Result<Vec<SolidState>, Error> {
    let mut model = failing(scene)?;
    model.enter_stage(&scene.stages[0], &[])?;
    model.feel(1.0);
    model.count_from_here();
    model.alter(&Altered { factor, ..Altered::NOTHING });
    let pace = Pace { dt, steps: STEPS, damping: 0.0, pressures: Pressures::Held };
    model.move_soil(&pace, &mut 0)?;
    let mut states = Vec::new();
    model.each(&mut |state| states.push(*state));
    states.sort_by_key(|state| state.id);
    Ok(states)
}

/// Largest distance between the particles of two slopes over how far they have come; the factor is off by a factor.
fn outcome(off: f64) -> Result<Outcome, Error> {
    let scene = levee(&[
        ("dilation_angle = 0.0", "dilation_angle = 12.0"),
        ("slip_distance = 0.02", "slip_distance = 0.02\nadhesion = 400.0"),
    ])?;
    let dt = choose_step(&scene)?;
    let (mut apart, mut notes) = (Vec::new(), Vec::new());
    for factor in FACTORS {
        let reduced = slide(&scene, off * factor, dt)?;
        let own = slide(&weaker(&scene, factor)?, 1.0, dt)?;
        let way = |s: &SolidState| s.displacement[0].hypot(s.displacement[1]);
        let furthest = largest(own.iter().map(way));
        let between = |(a, b): (&SolidState, &SolidState)| (a.x[0] - b.x[0]).hypot(a.x[1] - b.x[1]) / furthest;
        apart.push(largest(reduced.iter().zip(&own).map(between)));
        notes.push((format!("furthest a particle has come with the strength over {factor}"), furthest, "m".to_owned()));
    }
    Ok(Outcome {
        integrator: "staggered".to_owned(),
        scheme: "centroid".to_owned(),
        errors: vec![(apart.len() as f64, largest(apart.into_iter()))],
        required_error: 1e-7,
        refined_by: RUNS,
        notes,
        ..Outcome::default()
    })
}

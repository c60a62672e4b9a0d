//! Infinite slopes with seepage: the factor of safety at which they start to slide, found by reducing the strength.
//!
//! The base of the scene is level and gravity tilted, the sides are one place, so that one column of cells is a slope without
//! end. The water seeps first; the soil then moves under its pressures, damped, and comes to rest or slides on.
//!
//! One column lets nothing vary along the slope, as limit equilibrium has it. Between two columns a soil without
//! dilation finds a weaker way: blocks that tilt against the slope like books on a shelf (de Josselin de Jong 1971,
//! Geotechnique 21, 155-163). What the factor then is stands in the notes.

use std::f64::consts::FRAC_PI_6;

use mpm_core::failure::Scales;
use mpm_core::run::run;
use mpm_core::scene::{Coupling, Feed, Fields, Scene, Until};

use super::{Error, Lacks, Mutant, Outcome, Program, Unfit, integrator, sound};
use crate::exact::infinite_slope::{InfiniteSlope, Seepage, Strength};
use crate::experiment::refinement::{PARTICLES, Refinement};
use crate::norms::worst;

/// With the flow rule that limit equilibrium stands for.
pub const ASSOCIATED: Program = Program {
    name: "slope-seepage",
    about: "factor of safety of infinite slopes, dry, half full, full, and with water leaving them: within 5 %",
    run: || outcome(FRAC_PI_6, sound),
    mutant: Some(Mutant { what: "no pore pressure", run: || outcome(FRAC_PI_6, without_water) }),
};

/// Without dilation: the strength is that of Davis.
pub const WITHOUT_DILATION: Program = Program {
    name: "slope-seepage-psi-0",
    about: "the same without dilation, against the strength in simple shear of Davis",
    run: || outcome(0.0, sound),
    mutant: Some(Mutant { what: "with dilation", run: || outcome(0.0, dilating) }),
};

/// Vertical depth (m) and seepage of what is looked at.
const SLOPES: [(f64, Seepage); 5] = [
    (1.0, Seepage::Parallel { share: 0.0 }),
    (1.0, Seepage::Parallel { share: 0.5 }),
    (1.0, Seepage::Parallel { share: 1.0 }),
    (2.0, Seepage::Parallel { share: 1.0 }),
    (1.0, Seepage::Leaving { angle: 13.282_525_588_538_995 * std::f64::consts::PI / 180.0 }),
];
/// Without dilation a slope as steep as this has no strength left to divide where it is full of water.
const WITHOUT_DILATION_SLOPES: [(f64, Seepage); 3] = [
    (1.0, Seepage::Parallel { share: 0.0 }),
    (1.0, Seepage::Parallel { share: 0.25 }),
    (1.0, Seepage::Parallel { share: 0.5 }),
];

/// Cells over the depth; the worse of the two counts.
const ROWS: [usize; 2] = [14, 20];

/// Where the bracket of a factor of safety is narrow enough, relative.
const NARROW: f64 = 4e-3;
/// Slower than this a slope rests, as a share of the speed at which it would slide without any strength, g/damping. Its speed is what
/// damping takes from: particles keep motion that the mesh does not see, the softer the soil the more.
const AT_REST: f64 = 1e-5;
/// How long it is watched, in passages of the shear wave over its height. Close to its limit a slope takes hundreds to rest.
const PASSAGES: f64 = 400.0;

fn without_water(scene: &mut Fields) {
    if let Some(free) = &mut scene.free_surface {
        (free.level, free.feeds) = (None, [None; 4]);
    }
}

fn dilating(scene: &mut Fields) {
    if let Some(strength) = &mut scene.strength {
        strength.dilation_angle = strength.friction_angle;
    }
}

fn base() -> Scene {
    crate::scenes::built_in("slope-seepage").expect("the built-in scene holds")
}

/// A slope on a mesh, with the strength (at an angle of dilation psi, rad) divided by a factor.
pub(super) fn slope(
    base: &Scene,
    (columns, rows): (usize, usize),
    depth: f64,
    seepage: Seepage,
    psi: f64,
    factor: f64,
) -> Result<Scene, Error> {
    let angle = base.slope_angle.ok_or(Lacks("slope"))?.to_radians();
    let water = base.water.ok_or(Unfit("the scene is dry"))?;
    let slope = |scene: &mut Fields| {
        let height = depth * angle.cos();
        (scene.height, scene.cell) = (height, height / rows as f64);
        (scene.width, scene.cells) = (columns as f64 * scene.cell, [columns, rows]);
        // Water of unsaturated soil is that of the scene.
        if let Some(free) = scene.free_surface.as_mut().filter(|free| free.retention.is_none()) {
            match seepage {
                Seepage::Parallel { share } => free.level = (share > 0.0).then_some(share * height),
                Seepage::Leaving { angle: delta } => {
                    free.level = Some(height);
                    // u = gamma_w d cos(beta) (cos(beta) + sin(beta) tan(delta)): what the gradient asks for above still water.
                    let speed = water.hydraulic_conductivity * angle.sin() * delta.tan();
                    free.feeds[2] = Some(Feed::Velocity { speed, height });
                }
            }
        }
        if let Some(strength) = &mut scene.strength {
            strength.cohesion /= factor;
            strength.friction_angle = reduced(strength.friction_angle, factor);
            strength.dilation_angle = if psi > 0.0 { strength.friction_angle } else { 0.0 };
        }
        // As in strength reduction: the strength that is needed is no matter of stiffness, and so the layer keeps its depth.
        scene.elastic.youngs_modulus *= Scales::of(scene).stiffening();
        // Shear waves pass the slope a few times in every period of damping.
        let speed = (scene.elastic.shear_modulus() / scene.mixture_density()).sqrt();
        let passage = height / speed;
        let end = PASSAGES * passage;
        scene.stages[1].coupling = Coupling::Soil;
        (scene.stages[1].damping, scene.stages[1].until) = (1.0 / passage, Until::Time(end));
        (scene.observe_times, scene.history) = (vec![1.0 / 3.0 * end, 2.0 / 3.0 * end, end], 0);
    };
    Ok(base.edited(slope)?)
}

/// An angle (degrees) whose tangent is divided by a factor.
fn reduced(angle: f64, factor: f64) -> f64 {
    (angle.to_radians().tan() / factor).atan().to_degrees()
}

/// Whether a slope comes to rest: it does, or its speed still falls by more than half in the last third of the time.
pub(super) fn stands(scene: &Scene) -> Result<bool, Error> {
    let run = run(scene, &mut |_| {})?;
    match &run.failure {
        Some(failure) if failure.what.contains("outside the mesh") => return Ok(false),
        Some(failure) => return Err(failure.clone().into()),
        None => {}
    }
    let losses: Vec<f64> = run.observed().map(|s| s.balance.damping_loss_j).collect();
    let [first, second, last] = losses[..] else { return Err(Unfit("three losses in damping expected")) };
    let (Some(stage), Some(gravity)) = (scene.stages.last(), scene.gravity) else { return Err(Lacks("slope")) };
    let Until::Time(end) = stage.until else { return Err(Lacks("time")) };
    let mass = scene.mixture_density() * scene.height * scene.width;
    let [before, after] =
        [second - first, last - second].map(|loss| (loss / (stage.damping * mass * end / 3.0)).sqrt());
    Ok(after < AT_REST * gravity / stage.damping || after < 0.5 * before)
}

/// The factor by which the strength can be divided before a slope slides, bracketed about a guess.
pub(super) fn factor(guess: f64, stands: impl Fn(f64) -> Result<bool, Error>) -> Result<f64, Error> {
    let (mut low, mut high) = (0.9 * guess, 1.1 * guess);
    while !stands(low)? {
        low *= 0.8;
    }
    while stands(high)? {
        high *= 1.25;
    }
    while high - low > NARROW * low {
        let middle = 0.5 * (low + high);
        if stands(middle)? { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

/// The factor of a scene of one's own on so many rows of cells, over the exact one, and that one. Its flow rule is associated or without
/// dilation.
pub(super) fn own(
    scene: &Scene,
    (depth, seepage): (f64, Seepage),
    rows: usize,
    fault: super::own::Fault<'_>,
) -> Result<(f64, f64), Error> {
    let psi = scene.strength.map_or(0.0, |strength| strength.dilation_angle).to_radians();
    let exact = exact(scene, depth, seepage, psi)?;
    let found = factor(exact, |factor| stands(&fault(&slope(scene, (1, rows), depth, seepage, psi, factor)?)?))?;
    Ok((found / exact, exact))
}

/// The factor of a slope of associated flow with water along it up to a share of its depth (m), bracketed about 1.
pub(crate) fn parallel(scene: &Scene, depth: f64, share: f64, rows: usize) -> Result<f64, Error> {
    let psi = scene.strength.map_or(0.0, |strength| strength.dilation_angle).to_radians();
    let seepage = Seepage::Parallel { share };
    factor(1.0, |factor| stands(&slope(scene, (1, rows), depth, seepage, psi, factor)?))
}

/// What limit equilibrium says of a slope.
fn exact(scene: &Scene, depth: f64, seepage: Seepage, psi: f64) -> Result<f64, Error> {
    let gravity = scene.gravity.ok_or(Lacks("gravity"))?;
    let strength = scene.strength.ok_or(Unfit("the soil is elastic"))?;
    let whole = Strength { cohesion: strength.cohesion, friction: strength.friction_angle.to_radians() };
    let slope = |strength| InfiniteSlope {
        angle: scene.slope_angle.unwrap_or(0.0).to_radians(),
        dry_weight: scene.dry_density() * gravity,
        saturated_weight: scene.mixture_density() * gravity,
        water_weight: scene.water.map_or(0.0, |w| w.unit_weight),
        strength,
        seepage,
    };
    if psi > 0.0 {
        return slope(whole).factor(depth).ok_or(Lacks("effective stress"));
    }
    // Davis' reduction depends on the strength that is left: the factor is where the reduced slope just stands.
    let margin = |factor: f64| {
        let left = Strength { cohesion: whole.cohesion / factor, friction: (whole.friction.tan() / factor).atan() };
        slope(left.reduced(0.0)).factor(depth).unwrap_or(0.0) - 1.0
    };
    let (mut low, mut high) = (0.05, 10.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if margin(middle) > 0.0 { low = middle } else { high = middle }
    }
    Ok(low)
}

fn outcome(psi: f64, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let (mut errors, mut notes) = (Vec::new(), Vec::new());
    let slopes = if psi > 0.0 { &SLOPES[..] } else { &WITHOUT_DILATION_SLOPES };
    let found_with = |particles_per_cell, mesh: (usize, usize), depth, seepage, guess| {
        factor(guess, |factor| {
            let mut scene = slope(&base(), mesh, depth, seepage, psi, factor)?
                .edited(|s| s.particles_per_cell = particles_per_cell)?;
            scene = scene.edited(fault)?;
            stands(&scene)
        })
    };
    let found_on = |mesh, depth, seepage, guess| found_with(base().particles_per_cell, mesh, depth, seepage, guess);
    for rows in ROWS {
        let mut offs = Vec::new();
        for &(depth, seepage) in slopes {
            let exact = exact(&base(), depth, seepage, psi)?;
            let found = found_on((1, rows), depth, seepage, exact)?;
            let off = found / exact - 1.0;
            offs.push(off);
            if rows == ROWS[1] {
                notes.push((format!("factor found, d = {depth} m, {}", words(seepage)), found, "-".to_owned()));
                notes.push((format!("factor exact, d = {depth} m, {}", words(seepage)), exact, "-".to_owned()));
            }
        }
        errors.push((1.0 / rows as f64, worst(offs.into_iter())));
    }
    let (depth, seepage) = slopes[0];
    let dry = exact(&base(), depth, seepage, psi)?;
    let wide = found_on((4, 10), depth, seepage, dry)?;
    let counted = |count: &usize| Ok((*count as f64, found_with(*count, (1, 10), depth, seepage, dry)? / dry - 1.0));
    let counted = [1, 4, 9].iter().map(counted).collect::<Result<_, Error>>()?;
    let against = format!("the exact factor, 10 cells over the depth, {}", words(seepage));
    notes.push((format!("factor found with 4 columns of 10 cells, {}", words(seepage)), wide, "-".to_owned()));
    Ok(Outcome {
        integrator: integrator(&base()),
        scheme: "centre/free surface".to_owned(),
        errors,
        required_error: 0.05,
        refined_by: ("mesh L over the depth", "-"),
        notes,
        refinements: vec![Refinement { required_error: Some(0.05), ..Refinement::new(PARTICLES, counted, against) }],
        ..Outcome::default()
    })
}

fn words(seepage: Seepage) -> String {
    match seepage {
        Seepage::Parallel { share } => format!("water along it, {share} of the depth"),
        Seepage::Leaving { angle } => format!("water leaving at {:.1} degrees", angle.to_degrees()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_does_not_depend_on_stiffness_or_size() {
        let (depth, seepage) = SLOPES[2];
        let guess = exact(&base(), depth, seepage, FRAC_PI_6).expect("a factor");
        // The same slope: as it is, soft, and of another size with as much cohesion per depth.
        let found = [(1.0, 1.0), (1e-2, 1.0), (1.0, 20.0)].map(|(stiffness, size)| {
            let found = factor(guess, |factor| {
                let scene = base()
                    .edited(|scene| {
                        scene.elastic.youngs_modulus *= stiffness;
                        if let Some(strength) = &mut scene.strength {
                            strength.cohesion *= size;
                        }
                    })
                    .expect("a sound scene");
                stands(&slope(&scene, (1, 10), size * depth, seepage, FRAC_PI_6, factor)?)
            });
            found.expect("a factor")
        });
        let [usual, soft, large] = found;
        println!("{}: {found:?}, exact {guess}", words(seepage));
        assert!((soft / usual - 1.0).abs() < 0.05 && (large / usual - 1.0).abs() < 2.0 * NARROW, "{found:?}");
    }

    /// On 14 rows a cut leaves round-off of water in a cell, which has no particle for it: the balance of water has to bear that.
    #[test]
    fn water_that_is_less_than_round_off_is_not_missed() {
        let (depth, seepage) = SLOPES[0];
        assert!(stands(&slope(&base(), (1, 14), depth, seepage, FRAC_PI_6, 1.0).expect("a scene")).expect("a run"));
    }
}

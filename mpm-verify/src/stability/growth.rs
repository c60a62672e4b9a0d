//! How much a perturbation grows per step of a run.
//!
//! The perturbation: soil in undrained equilibrium under a load that is not there, or only on a part of the top, with
//! drainage that opens at once. Neither forces nor flow balance, so that all waves of soil and pressure are stirred at
//! once, none by less than about a hundredth of the whole, and none waits to grow out of round-off. The load is so small
//! that the particles stand still: the run is linear, and what grows does so by the same factor in every step.
//!
//! The norm is the energy that is stored: motion, strain of the skeleton, compression of the water. Without instability
//! it is bounded, whether the waves persist or die out, and no state can grow without it.

use mpm_core::run::model;
use mpm_core::scene::{Dimension, LoadedStrip, Scene, Start, Surcharge, Until};
use mpm_core::step::Model;

use super::assembled::NEUTRAL;
use crate::error::Error;

/// Load that the first state would balance, Pa: strains of 1e-13, so that a growth by a factor of 1e9 still is linear.
const LOAD: f64 = 1e-6;
/// Steps of a block, and between two looks at the energy in it. The beat of a wave just below its limit, of the angle
/// pi - sqrt(8 e) per step at a share e below, lasts `2 pi/(2 sqrt(8 e))`: 36 steps at 0.1 %. A block has one of them.
const BLOCK: u64 = 64;
const LOOK: u64 = 8;
/// Fewest and most blocks of a run. A bounded beat, of a factor of two in energy between blocks, feigns a growth of
/// `2^(1/1024) = 1.0007` per step in half of the shortest run, which is below what counts: [`NEUTRAL`].
const BLOCKS: [usize; 2] = [16, 320];
/// Share of the whole that a wave is stirred by at least. Under a strip on stiff water the whole is what the load would
/// store drained, of which the first state has `M/Q` (4e-5 at 2e11 Pa), and a wave a hundredth of that amplitude.
const STIRRED: f64 = 5e-5;
/// Growth of the energy that ends a run. Below its limit a wave swings by at most the square root of 1/(2 e) more than
/// it was stirred by: 1e3 in energy at 0.1 %. In the longest run what grows by no more than counts as none comes to 1e18.
const BURST: f64 = 1e18;
/// Blocks of a run that is to show a growth per step: until what was stirred least has become as large as the whole,
/// `ln(1/5e-5)` over the logarithm of the growth, and as long again to see it grow. At 1 % above its limit a flow that
/// turns round in every step grows by 1.02: 1024 steps. Waves are steeper, by `1 + sqrt(8 e)` at a share e; only where
/// inertia that comes late feeds a wave is a growth so slow that a run is cut off before.
pub fn blocks_for(growth: f64) -> usize {
    let steps = 2.0 * STIRRED.recip().ln() / growth.ln().max(1e-9);
    ((steps / BLOCK as f64).ceil() as usize).clamp(BLOCKS[0], BLOCKS[1])
}

/// What a run did with its perturbation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Growth {
    /// Factor on the amplitude per step, over the later half of the run, or all of it if that is short.
    pub per_step: f64,
    /// Whether it is unstable: grown beyond doubt, or not carried on.
    pub unstable: bool,
}

/// A scene that is off balance from its start.
///
/// It runs for ever, and under a load that grows as slowly: no file says that.
pub fn stirred(scene: &Scene) -> Scene {
    let strip = match scene.dimension {
        Dimension::Column => None,
        // Neither symmetric nor periodic on any mesh, so that no wave across the soil is left out.
        _ => Some(LoadedStrip { from: 0.0, to: 0.37 * scene.width, taper: 0.0 }),
    };
    // A ramp without an end leaves the top free.
    let ramp_time = if strip.is_some() { 0.0 } else { f64::MAX };
    scene.clone().altered_unchecked(|scene| {
        scene.start = Start::UndrainedEquilibrium;
        scene.surcharge = scene.surcharge.map(|s| Surcharge { pressure: LOAD, ramp_time, strip, ..s });
        scene.observe_times = Vec::new();
        for stage in &mut scene.stages {
            (stage.damping, stage.until) = (0.0, Until::Time(f64::MAX));
        }
    })
}

/// Runs a [`stirred`] scene with a step (s) for some blocks, or until it is clear what becomes of it.
///
/// # Errors
/// Particles that cannot be placed.
pub fn growth(scene: &Scene, dt: f64, blocks: usize) -> Result<Growth, Error> {
    let mut model = model(scene)?;
    let entered = scene.stages.last().map_or(Ok(()), |stage| model.enter_stage(stage, &[]));
    entered?;
    // A load that stays does work: beside what it can store drained, what it stores at first may be nothing.
    let load = scene.surcharge.filter(|s| s.strip.is_some()).map_or(0.0, |s| s.pressure);
    let whole = load * load / scene.oedometer_modulus() * scene.height * scene.width;
    let energy = |model: &dyn Model| whole + stored(model);
    let first = energy(model.as_ref());
    let half = blocks / 2;
    let mut middle = first;
    let mut last = first;
    for block in 0..blocks {
        last = 0.0;
        for _ in 0..BLOCK / LOOK {
            if model.advance(dt, LOOK, &mut 0).is_err() {
                return Ok(Growth { per_step: f64::INFINITY, unstable: true });
            }
            last = last.max(energy(model.as_ref()));
        }
        // Also if it is not a number.
        let bounded = last < BURST * first;
        if !bounded {
            let per_step = (last / first).powf(0.5 / ((block as u64 + 1) * BLOCK) as f64);
            return Ok(Growth { per_step, unstable: true });
        }
        if block + 1 + half == blocks {
            middle = last;
        }
    }
    let steps = half as u64 * BLOCK;
    let per_step = (last / middle).powf(0.5 / steps as f64);
    Ok(Growth { per_step, unstable: per_step > NEUTRAL })
}

/// Energy that is stored, J.
fn stored(model: &dyn Model) -> f64 {
    let ledger = model.observe().1;
    let stored = ledger.kinetic_j + ledger.strain_j + ledger.water_j;
    if stored.is_finite() { stored } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::super::assembled::{Assembled, NEUTRAL};
    use super::super::bisection::largest_stable;
    use super::super::map::Setting;
    use super::*;
    use mpm_core::scene::{DarcyChoice, Integrator, ShapeChoice};

    #[test]
    fn runs_tell_stable_from_unstable_steps() {
        for (integrator, conductivity) in
            [(Integrator::Explicit, 1e-2), (Integrator::Explicit, 1e-9), (Integrator::SemiImplicit, 1e-5)]
        {
            let setting = Setting {
                dimension: Dimension::Column,
                integrator,
                shape: ShapeChoice::Centre,
                darcy: DarcyChoice::Face,
                inertia: false,
                mesh: 0.05,
                ppc: 4,
                conductivity,
                bulk_modulus: 2e9,
            };
            let scene = setting.scene().expect("a sound scene");
            let assembled = Assembled::of(&scene).expect("a column");
            let guess = mpm_core::stability::stable_limit(&scene);
            let limit = largest_stable(guess, 1e-4, |dt| assembled.growth(dt) > NEUTRAL).stable;
            let blocks = blocks_for(assembled.growth_above(limit));
            let scene = stirred(&scene);
            let unstable = |factor: f64| growth(&scene, factor * limit, blocks).expect("a run").unstable;
            assert_eq!([0.985, 1.015].map(unstable), [false, true], "{integrator:?}, k = {conductivity}");
            // A run that is far too short cannot tell: the length is not for nothing.
            let short = growth(&scene, 1.015 * limit, 1).expect("a run");
            assert!(conductivity < 1e-2 || !short.unstable, "{short:?}");
        }
    }
}

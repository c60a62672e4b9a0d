//! Limit equilibrium of a scene's levee with the water of a run.

use mpm_core::failure::Row;

use super::figures::site;
use super::plan::Plan;
use super::safety::phreatic;
use crate::exact::infinite_slope::Strength;
use crate::exact::slip_circle::FirmBase;
use crate::exact::slip_circle::factor::Method;
use crate::exact::slip_circle::levee::Levee;
use crate::exact::slip_circle::water::Equipotentials;

/// Least depth of the slides, m: that of the event E2.
const DEPTH: f64 = 0.3;
/// Water is at the toe when it is no further than this from it, m.
const AT_TOE: f64 = 0.05;
/// Less water than this (m3) is no outflow.
const DROPS: f64 = 1e-4;

/// Factors of safety with one strength of the soil.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Factors {
    /// Of the infinite slope at the toe, from when water is there.
    pub infinite_slope: Option<f64>,
    /// Of the critical slide by Bishop's method.
    pub bishop: Option<f64>,
    /// By Spencer's method.
    pub spencer: Option<f64>,
}

/// The scene's levee: crest and slope between wall and toe; the base has its friction before any slip. `None` for soil
/// of another shape or without limits.
pub fn levee(plan: &Plan) -> Option<Levee> {
    let scene = &plan.scene;
    let (strength, base, water) = (scene.strength?, scene.base?, scene.water?);
    let outline = scene.outline.as_ref().filter(|corners| corners.len() == 4)?;
    let (height, toe) = (scene.height, scene.width);
    let crest = outline.iter().filter(|x| x[1] == height).map(|x| x[0]).fold(0.0, f64::max);
    let gravity = scene.gravity?;
    let moist = scene.free_surface.as_ref().map_or(0.0, |w| w.saturation) * scene.porosity * water.density;
    let friction = base.peak_angle.to_radians();
    Some(Levee {
        crest,
        height,
        run: toe - crest,
        strength: Strength { cohesion: strength.cohesion, friction: strength.friction_angle.to_radians() },
        dilation: strength.dilation_angle.to_radians(),
        dry_weight: (scene.dry_density() + moist) * gravity,
        saturated_weight: scene.mixture_density() * gravity,
        water_weight: water.density * gravity,
        base: FirmBase {
            height: 0.0,
            strength: Strength { cohesion: base.adhesion, friction },
            normal_stress: base.normal_stress,
        },
    })
}

/// Factors with the strength of the soil and with Davis' reduced one.
pub fn factors(plan: &Plan, row: &Row) -> [Factors; 2] {
    let Some(levee) = levee(plan) else { return [Factors::default(); 2] };
    let line = phreatic(plan, row, site(&plan.scene).tank_m);
    // Water that leaves the slope does so from the toe up.
    let at_toe = row.front_x_m >= plan.scene.width - AT_TOE || row.water_out_m3 > DROPS;
    let of = |strength: Strength| {
        let critical = |method| {
            let limits = levee.limits(DEPTH, method);
            levee.critical(strength, &line, Equipotentials::Vertical, &limits).map(|c| c.factor)
        };
        let slope = levee.toe(strength).factor(DEPTH).filter(|_| at_toe);
        Factors { infinite_slope: slope, bishop: critical(Method::Bishop), spencer: critical(Method::Spencer) }
    };
    [of(levee.strength), of(levee.strength.reduced(levee.dilation))]
}

#[cfg(test)]
mod tests {
    use mpm_core::scene::{Flags, NormalStress};

    use super::super::plan::scene;
    use super::*;

    #[test]
    fn the_scene_s_levee_is_the_paper_s() {
        let dry = super::super::variants::named("saturation-0");
        let plan = Plan::new(scene("levee", &Flags::default(), dry).expect("a scene"), None, None, false);
        let found = levee(&plan.expect("a plan")).expect("a levee");
        let strength = Strength { cohesion: 0.0, friction: 30.0_f64.to_radians() };
        let base = FirmBase { height: 0.0, strength, normal_stress: NormalStress::Effective };
        let paper = Levee::paper(base);
        assert_eq!(
            (found.crest, found.height, found.run, found.base),
            (paper.crest, paper.height, paper.run, paper.base)
        );
        for (a, b) in [
            (found.dry_weight, paper.dry_weight),
            (found.saturated_weight, paper.saturated_weight),
            (found.water_weight, paper.water_weight),
        ] {
            assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
        }
    }
}

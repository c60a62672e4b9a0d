//! Rain on a slope without end whose soil holds it by suction, until it slides.
//!
//! On a plane at a height z above the base the strength is `c + (W cos(beta) + S_e gamma_w s) tan(phi)` and the shear stress
//! `W sin(beta)`, of the weight W of what lies above it, water with it (Lu & Godt 2008, doi:10.1029/2008WR006976). Suction is that of
//! Srivastava & Yeh's column with gravity along the slope's normal; the plane with the least factor decides.

use mpm_core::scene::{Feed, Fields, Scene, Until};
use mpm_core::water::retention::Retention;

use super::infinite_slope::{factor, slope, stands};
use super::{Error, Lacks, Mutant, Outcome, Program, Unfit, integrator, scheme, sound};
use crate::exact::infinite_slope::Seepage;
use crate::exact::richards::Infiltration;

/// The case.
pub const CASE: Program = Program {
    name: "slope-rain",
    about: "factor of safety of an infinite slope of unsaturated soil before, during and after rain that makes it slide: within 3 %",
    run: || outcome(sound),
    mutant: Some(Mutant { what: "soil that feels no suction", run: || outcome(without_suction) }),
};

/// Times after the rain begins, s: none yet, an hour and three.
const TIMES: [f64; 3] = [1.0, 3600.0, 10_800.0];
/// Rows of cells over the height.
const ROWS: usize = 10;

fn without_suction(scene: &mut Fields) {
    if let Some(free) = &mut scene.free_surface {
        free.retention = Some(Retention::VanGenuchten { alpha: 50.0, n: 4.0, entry: 0.0 });
    }
}

fn outcome(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let base = crate::scenes::built_in("slope-rain")?;
    let mut errors = Vec::new();
    for time in TIMES {
        let exact = exact(&base, time)?;
        let of = |strength: f64| {
            let depth = base.height / base.slope_angle.ok_or(Lacks("slope"))?.to_radians().cos();
            let scene = slope(&base, (1, ROWS), depth, Seepage::Parallel { share: 0.0 }, 1.0, strength)?;
            stands(&scene.edited(|scene| {
                scene.stages[0].until = Until::Time(time);
                fault(scene);
            })?)
        };
        errors.push((base.cell, factor(exact, of)? / exact - 1.0));
    }
    let worst = crate::norms::worst(errors.iter().map(|(_, error)| *error));
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors: vec![(base.cell, worst)],
        required_error: 0.03,
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

/// Least factor of all planes at a time after the rain begins, s.
fn exact(scene: &Scene, time: f64) -> Result<f64, Error> {
    /// Planes that are looked at.
    const PLANES: u32 = 400;
    let (free, water) = (scene.free_surface.as_ref().ok_or(Lacks("free surface"))?, scene.water.ok_or(Lacks("water"))?);
    let strength = scene.strength.ok_or(Unfit("the soil is elastic"))?;
    let (Some(Retention::Gardner { alpha }), Some(Feed::Velocity { speed, .. }), Some(Feed::Head(head))) =
        (free.retention, free.feeds[3], free.feeds[2])
    else {
        return Err(Unfit("no rain on Gardner's soil"));
    };
    let (sin, cos) = scene.slope_angle.ok_or(Lacks("slope"))?.to_radians().sin_cos();
    // Gravity along the normal alone moves water across the layer; heads are along that axis as well.
    let fillable = scene.mobile_porosity();
    let conductivity = water.hydraulic_conductivity * cos;
    let column =
        Infiltration::new(alpha * cos, scene.height, conductivity, fillable, [0.0, speed]).above_suction(-head);
    let gravity = scene.gravity.ok_or(Lacks("gravity"))?;
    let part = scene.height / f64::from(PLANES);
    let (mut weight, mut least) = (0.0, f64::INFINITY);
    for i in (0..PLANES).rev() {
        let share = |z: f64| column.at(z, time);
        let held = scene.porosity - fillable + fillable * share((f64::from(i) + 0.5) * part);
        weight += gravity * (scene.dry_density() + water.density * held) * part;
        let wet = share(f64::from(i) * part);
        let suction = -wet * water.unit_weight * wet.ln() / alpha;
        let resists = strength.cohesion + (weight * cos + suction) * strength.friction_angle.to_radians().tan();
        least = least.min(resists / (weight * sin));
    }
    Ok(least)
}

//! Columns that nothing here was tuned on: other heights, stiffnesses, porosities, softer water, Poisson's ratio 0 and 0.45.
//!
//! Each goes through the very check of `mpm-verify check --scene`, under a load so light that strains of finite size do not
//! stand in the way of the order; errors that it allows are those of strangers' scenes, and the baselines hold these closer.

use mpm_core::scene::{Fields, Integrator, Scene, ShapeChoice, StrainChoice, Surcharge, Until};

use super::own::OwnScene;
use super::{Error, FASTER, Mutant, Outcome, Program, faster, sound};
use crate::norms::SAMPLE_TV;

/// How the column differs from Table 1's.
type Change = fn(&mut Fields);

/// A case of one column and one integrator.
macro_rules! case {
    ($name:literal, $about:literal, $change:ident, $integrator:ident, $rows:expr) => {
        Program {
            name: $name,
            about: $about,
            run: || outcome($change, Integrator::$integrator, &$rows, sound),
            mutant: Some(Mutant { what: FASTER, run: || outcome($change, Integrator::$integrator, &$rows, faster) }),
        }
    };
}

/// All of them: four columns, three integrators. An explicit run needs 2 (H/L)^2 (M + Q)/M steps per unit of Tv, which is why
/// the soft tall column and Poisson's ratio 0 end at coarser meshes.
pub const CASES: [Program; 12] = [
    case!("tall-explicit", "H = 5 m, E = 2 MPa, n = 0.45: explicit", tall, Explicit, [10, 12, 14, 17, 20]),
    case!("tall-semi-implicit", "the same semi-implicit", tall, SemiImplicit, [20, 28, 40, 56]),
    case!("tall-quasi-static", "the same without inertia, B-splines", tall, QuasiStatic, [14, 17, 20, 24]),
    case!("soft-water-explicit", "K_w so low that p_0 = q/2: explicit", soft_water, Explicit, [20, 28, 40, 56, 80]),
    case!("soft-water-semi-implicit", "the same semi-implicit", soft_water, SemiImplicit, [20, 28, 40, 56]),
    case!("soft-water-quasi-static", "the same without inertia, B-splines", soft_water, QuasiStatic, [14, 17, 20, 24]),
    case!("poisson-0-explicit", "Poisson's ratio 0: explicit", uncoupled, Explicit, [14, 17, 20, 24, 28]),
    case!("poisson-0-semi-implicit", "the same semi-implicit", uncoupled, SemiImplicit, [20, 28, 40, 56]),
    case!("poisson-0-quasi-static", "the same without inertia, B-splines", uncoupled, QuasiStatic, [14, 17, 20, 24]),
    case!("poisson-45-explicit", "Poisson's ratio 0.45: explicit", stiff, Explicit, [14, 20, 28, 40]),
    case!("poisson-45-semi-implicit", "the same semi-implicit", stiff, SemiImplicit, [20, 28, 40, 56]),
    case!("poisson-45-quasi-static", "the same without inertia, B-splines", stiff, QuasiStatic, [14, 17, 20, 24]),
];

fn tall(scene: &mut Fields) {
    (scene.height, scene.porosity, scene.elastic.youngs_modulus) = (5.0, 0.45, 2.0e6);
}

/// p_0 = q Q/(M + Q) is half of q where Q = K_w/n is M. Without inertia in Darcy's law, which would make waves grow here
/// (`exact::dynamic`), and in steps that follow the first wave: it hardly decays in such water.
fn soft_water(scene: &mut Fields) {
    (scene.darcy_inertia, scene.safety) = (false, 0.1);
    let bulk_modulus = scene.porosity * scene.oedometer_modulus();
    scene.water = scene.water.map(|water| mpm_core::scene::WaterProperties { bulk_modulus, ..water });
}

fn uncoupled(scene: &mut Fields) {
    scene.elastic.poisson_ratio = 0.0;
}

fn stiff(scene: &mut Fields) {
    scene.elastic.poisson_ratio = 0.45;
}

fn outcome(change: Change, integrator: Integrator, rows: &[usize], fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    OwnScene::new(&column(change, integrator)?, rows)?.outcome(fault)
}

/// First time factor of the explicit runs.
const EXPLICIT_FROM: f64 = 0.05;
/// q/M.
const LIGHT: f64 = 1e-6;

/// Table 1's column with a change, at the nine time factors of its own.
fn column(change: Change, integrator: Integrator) -> Result<Scene, Error> {
    let mut scene = crate::scenes::terzaghi();
    scene = scene.edited(change)?;
    let pressure = LIGHT * scene.oedometer_modulus();
    scene = scene.edited(|scene| scene.surcharge = scene.surcharge.map(|load| Surcharge { pressure, ..load }))?;
    let one = scene.time_per_factor().unwrap_or(f64::NAN);
    // On the meshes that an explicit run can afford, the zone that drains is two cells thin at the first times.
    let from = if integrator == Integrator::Explicit { EXPLICIT_FROM } else { 0.0 };
    scene = scene.edited(|scene| {
        scene.observe_times = SAMPLE_TV.iter().filter(|tv| **tv >= from).map(|tv| tv * one).collect();
        scene.stages[0].until = Until::Time(one);
        scene.integrator = integrator;
    })?;
    if integrator == Integrator::QuasiStatic {
        scene = scene.edited(|scene| {
            (scene.shape, scene.strain, scene.particles_per_cell) = (ShapeChoice::Bspline2, StrainChoice::Small, 9);
            scene.darcy_inertia = false;
        })?;
    }
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_are_what_they_are_called() {
        let share = |change: Change| {
            let scene = column(change, Integrator::Explicit).expect("a sound scene");
            scene.undrained_pressure() / scene.surcharge.map_or(f64::NAN, |load| load.pressure)
        };
        assert!((share(soft_water) - 0.5).abs() < 1e-12 && share(tall) > 0.999);
        let poisson =
            |change: Change| column(change, Integrator::Explicit).expect("a sound scene").elastic.poisson_ratio;
        assert_eq!((poisson(uncoupled), poisson(stiff), poisson(tall)), (0.0, 0.45, 0.30));
    }

    #[test]
    fn quick_ones_hold_and_their_mutants_fall_short() {
        let quick = CASES.iter().filter(|r| r.name.ends_with("quasi-static") || r.name == "poisson-45-semi-implicit");
        for case in quick {
            let judged = case.judged().expect("runs that finish");
            assert!(judged.row.passed(), "{}: {}", case.name, judged.reason);
            let spoilt = case.mutant_judged().expect("a mutant").expect("runs that finish");
            assert!(!spoilt.row.passed(), "{}: {}", case.name, spoilt.reason);
        }
    }
}

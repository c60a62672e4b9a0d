//! Conductivity that goes with the pores, and that of an inclined bedding.

use mpm_core::observe::ProfileRow;
use mpm_core::scene::{Fields, Integrator, Scene, ShapeChoice};

use super::setup::{Measured, Setup, case, refined};
use super::wells::around;
use super::{Case, Unfit, sound};
use crate::exact::pressed_pores::PressedPores;
use crate::norms::largest;

const PRESSED: Setup = Setup {
    scene: "kozeny-carman",
    change: sound,
    mesh: refined,
    measure: through,
    cells: &[10.0, 20.0, 40.0],
    required: 1e-3,
    order: None,
};
const UNIFORM: Setup = Setup {
    scene: "bedding",
    change: sound,
    mesh: refined,
    measure: dissipated,
    cells: &[5.0, 10.0],
    required: 1e-9,
    order: None,
};
const WELL: Setup = Setup {
    scene: "well-bedding",
    change: sound,
    mesh: refined,
    measure: around,
    cells: &[20.0, 28.0, 40.0],
    required: 1e-2,
    order: None,
};

const CONSTANT: &str = "conductivity that stays";
const LEVEL: &str = "level bedding";

/// All of them.
pub const CASES: [Case; 6] = [
    case!("kozeny-carman", "flow through pores that a load has narrowed, B-splines", CONSTANT, constant, PRESSED),
    case!(
        "kozeny-carman-centre",
        "the same with faces of cells",
        CONSTANT,
        constant,
        Setup { change: centre, required: 1e-2, ..PRESSED }
    ),
    case!(
        "kozeny-carman-semi-implicit",
        "the same semi-implicit",
        CONSTANT,
        constant,
        Setup { change: semi_implicit, required: 1e-2, ..PRESSED }
    ),
    case!(
        "kozeny-carman-explicit",
        "the same explicit",
        CONSTANT,
        constant,
        Setup { change: explicit, cells: &[10.0, 20.0], required: 1e-2, ..PRESSED }
    ),
    case!("bedding", "uniform flow through inclined bedding", LEVEL, level, UNIFORM),
    case!("well-bedding", "drawdown around a well in inclined bedding", LEVEL, level, WELL),
];

fn centre(scene: &mut Fields) {
    scene.shape = ShapeChoice::Centre;
}

fn explicit(scene: &mut Fields) {
    (scene.integrator, scene.shape) = (Integrator::Explicit, ShapeChoice::Centre);
}

fn semi_implicit(scene: &mut Fields) {
    (scene.integrator, scene.shape) = (Integrator::SemiImplicit, ShapeChoice::Centre);
}

fn constant(scene: &mut Fields) {
    if let Some(water) = &mut scene.water {
        water.fabric.kozeny_carman = false;
    }
}

fn level(scene: &mut Fields) {
    if let Some(water) = &mut scene.water {
        water.fabric.bedding_angle = 0.0;
    }
}

/// Pore pressure at all heights over that at the base, at the end.
fn through(scene: &Scene) -> Measured {
    let exact = PressedPores::of(scene).ok_or(Unfit("a column that a load presses and water rises through"))?;
    Ok(Box::new(move |run| {
        let Some(last) = run.observed().last() else { return f64::NAN };
        let off = |row: &ProfileRow| row.pressure_pa - exact.pressure(row.material_height_m);
        largest(last.state.profile.iter().map(off)) / exact.pressure(0.0)
    }))
}

/// Power that a uniform flow under its weight dissipates between the last two samples, `V rho_w^2 g^T K g/gamma_w`, over itself.
fn dissipated(scene: &Scene) -> Measured {
    let (water, gravity) = scene.water.zip(scene.gravity_vector()).ok_or(Unfit("water under its weight"))?;
    let (sin, cos) = water.fabric.bedding_angle.to_radians().sin_cos();
    let [along, across] = [gravity[0] * cos + gravity[1] * sin, gravity[1] * cos - gravity[0] * sin];
    let of_gravity = water.mobility() * (water.anisotropy * along * along + across * across);
    let exact = scene.width * scene.height * water.density.powi(2) * of_gravity;
    Ok(Box::new(move |run| {
        let all: Vec<_> = run.observed().map(|s| (s.state.time, s.balance.darcy_dissipation_j)).collect();
        let [.., (before, then), (time, now)] = all[..] else { return f64::NAN };
        ((now - then) / (time - before) / exact - 1.0).abs()
    }))
}

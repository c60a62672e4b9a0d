//! Wells in a confined layer against Theis, in one dimension and in two.

use mpm_core::observe::{FieldPoint, ProfileRow};
use mpm_core::scene::{Fields, Integrator, Scene, ShapeChoice, StepChoice, StrainChoice};

use super::setup::{Measured, Setup, case, refined};
use super::{FASTER, Program, Unfit, faster, sound};
use crate::exact::wells::Confined;
use crate::norms::largest;

/// Nearer to a well than this (m) its pressure is that of the cell, not of the place.
const NEAR: f64 = 0.4;
const PUMPED: &str = "rate of the well 5 % too high";

const LINE: Setup = Setup {
    scene: "well-line",
    change: sound,
    mesh: refined,
    measure: drawdown,
    cells: &[20.0, 40.0, 80.0],
    required: 1e-3,
    order: None,
};
const LINE_IN_STEPS: Setup =
    Setup { change: in_steps, cells: &[20.0, 28.0, 40.0, 56.0, 80.0], required: 5e-3, order: Some([1.7, 2.3]), ..LINE };
const WELL: Setup = Setup {
    scene: "well",
    change: sound,
    mesh: refined,
    measure: around,
    cells: &[20.0, 28.0, 40.0],
    required: 5e-3,
    order: None,
};
const WELL_BY_FACES: Setup =
    Setup { change: semi_implicit, cells: &[20.0, 28.0, 40.0, 56.0], required: 2e-2, order: Some([1.5, 2.5]), ..WELL };

/// What flows to the well in the time is more than a cell of its pores holds: water particles would leave some bare.
const FOR_LONG: Setup =
    Setup { change: for_long, measure: steady, cells: &[20.0], required: 1e-2, order: None, ..LINE };

/// All of them.
pub const CASES: [Program; 7] = [
    case!("well-line", "drawdown beside a line of wells, B-splines", FASTER, faster, LINE),
    case!("well-line-semi-implicit", "the same semi-implicit, order 2", PUMPED, pumped, LINE_IN_STEPS),
    // What a pump sets swinging when it starts is no part of the solution: no order is expected.
    case!(
        "well-line-explicit",
        "the same explicit",
        PUMPED,
        pumped,
        Setup { change: explicit, required: 1e-2, ..LINE }
    ),
    case!("well", "drawdown around a well (Theis and his images), B-splines", FASTER, faster, WELL),
    // Its steps in time are of first order, which shows on the finer meshes.
    case!("well-semi-implicit", "the same semi-implicit", PUMPED, pumped, Setup { order: None, ..WELL_BY_FACES }),
    case!("well-explicit", "the same explicit, order 2", PUMPED, pumped, Setup { change: explicit, ..WELL_BY_FACES }),
    case!("well-for-long", "steady flow from both ends of a column to a well, explicit", PUMPED, pumped, FOR_LONG),
];

fn explicit(scene: &mut Fields) {
    (scene.integrator, scene.shape, scene.strain) = (Integrator::Explicit, ShapeChoice::Centre, StrainChoice::Large);
    scene.particles_per_cell = 4;
}

fn semi_implicit(scene: &mut Fields) {
    explicit(scene);
    scene.integrator = Integrator::SemiImplicit;
}

/// Pressures that are solved for know no limit from so little flow, and no wave of interest: a step is as long as the well asks for.
fn in_steps(scene: &mut Fields) {
    semi_implicit(scene);
    scene.step = StepChoice::Fixed(2e-3);
}

/// Ends that drain, and flow of centimetres per second.
fn for_long(scene: &mut Fields) {
    explicit(scene);
    scene.wells.iter_mut().for_each(|well| well.rate = 1e-2);
    if let Some(water) = &mut scene.water {
        (water.hydraulic_conductivity, water.bulk_modulus) = (1e-3, 2e7);
    }
    scene.stages.iter_mut().for_each(|stage| stage.drained = [false, false, true, true]);
}

fn pumped(scene: &mut Fields) {
    scene.wells.iter_mut().for_each(|well| well.rate *= 1.05);
}

/// Pore pressure at all heights over the largest drawdown.
fn drawdown(scene: &Scene) -> Measured {
    let exact = Confined::of(scene).ok_or(Unfit("one well in a column"))?;
    Ok(Box::new(move |run| {
        let of = |sample: &mpm_core::drive::Sample| {
            let off = |row: &ProfileRow| {
                let exact = exact.pressure([0.0, row.material_height_m], sample.stage_time);
                row.pressure_pa - exact
            };
            largest(sample.state.profile.iter().map(off)) / exact.drawdown(0.0, sample.stage_time)
        };
        largest(run.observed().map(of))
    }))
}

/// Pore pressure everywhere but near the well, over Theis' drawdown there.
pub(super) fn around(scene: &Scene) -> Measured {
    let exact = Confined::of(scene).ok_or(Unfit("one well between walls"))?;
    let [x, y] = scene.wells[0].at;
    Ok(Box::new(move |run| {
        let of = |sample: &mpm_core::drive::Sample| {
            let far = |at: &&FieldPoint| (at.x_m - x).hypot(at.y_m - y) > NEAR;
            let off = |at: &FieldPoint| at.pressure_pa - exact.pressure([at.x_m, at.y_m], sample.stage_time);
            largest(sample.state.field.iter().filter(far).map(off)) / exact.drawdown(NEAR, sample.stage_time)
        };
        largest(run.observed().map(of))
    }))
}

/// Pore pressure at all heights in steady flow over that at the well, `gamma_w q/(2 k) H/2`.
fn steady(scene: &Scene) -> Measured {
    let (Some(water), [well]) = (scene.water, &scene.wells[..]) else { return Err(Unfit("one well in a column")) };
    let gradient = -water.unit_weight * well.rate / (2.0 * scene.width * water.hydraulic_conductivity);
    let height = scene.height;
    Ok(Box::new(move |run| {
        let off = |row: &ProfileRow| row.pressure_pa - gradient * row.height_m.min(height - row.height_m);
        let last = run.observed().last().map(|sample| largest(sample.state.profile.iter().map(off)));
        last.unwrap_or(f64::NAN) / (0.5 * gradient * height).abs()
    }))
}

//! Sections about an axis: De Leeuw's cylinder and Cryer's sphere, whose middles first rise above their undrained pressure.

use mpm_core::drive::Sample;
use mpm_core::observe::FieldPoint;
use mpm_core::scene::{Course, Dimension, Fields, Integrator, Scene, ShapeChoice, StrainChoice, Until};

use super::setup::{Measured, Setup, case, refined};
use super::{Program, Unfit, sound};
use crate::exact::radial::Radial;
use crate::norms::largest;

const DE_LEEUW: Setup = Setup {
    scene: "de-leeuw",
    change: sound,
    mesh: refined,
    measure: radial,
    cells: &[2.0, 3.0, 4.0, 6.0],
    required: 1e-3,
    order: None,
};
/// Errors of cut cells go up and down with how they are cut, so that the order is that of many meshes.
const CRYER: Setup = Setup {
    scene: "cryer",
    change: sound,
    mesh: refined,
    measure: radial,
    cells: &[8.0, 10.0, 12.0, 16.0, 20.0, 24.0, 32.0],
    required: 1e-2,
    order: SECOND,
};
const SECOND: Option<[f64; 2]> = Some([1.6, 2.6]);

/// All of them.
pub const CASES: [Program; 5] = [
    case!("de-leeuw", "De Leeuw's cylinder about an axis: B-splines, quasi-static", PLANE, plane, DE_LEEUW),
    case!(
        "de-leeuw-centre",
        "the same, centre values",
        PLANE,
        plane,
        Setup { change: at_centres, cells: &[2.0, 3.0, 4.0, 6.0, 8.0], required: 2e-2, order: SECOND, ..DE_LEEUW }
    ),
    case!(
        "de-leeuw-semi-implicit",
        "the same semi-implicit",
        PLANE,
        plane,
        Setup { change: slow_semi_implicit, cells: &[3.0, 4.0, 6.0, 8.0], required: 2e-2, order: SECOND, ..DE_LEEUW }
    ),
    case!(
        "de-leeuw-explicit",
        "the same explicit",
        PLANE,
        plane,
        Setup { change: slow_explicit, cells: &[2.0, 3.0, 4.0], required: 3e-2, ..DE_LEEUW }
    ),
    case!("cryer", "Cryer's sphere in cells that its outline cuts: semi-implicit", PLANE, plane, CRYER),
];

/// What the mutants of axisymmetric cases are.
const PLANE: &str = "plane strain";

fn plane(scene: &mut Fields) {
    scene.dimension = Dimension::PlaneStrain;
}

fn at_centres(scene: &mut Fields) {
    (scene.shape, scene.tolerance) = (ShapeChoice::Centre, 1e-6);
}

/// Ten times less permeable, so that waves have died away before it drains.
fn slow_semi_implicit(scene: &mut Fields) {
    const SLOWER: f64 = 10.0;
    (scene.integrator, scene.shape, scene.strain) = (Integrator::SemiImplicit, ShapeChoice::BBar, StrainChoice::Large);
    if let Some(water) = &mut scene.water {
        water.hydraulic_conductivity /= SLOWER;
    }
    scene.observe_times.iter_mut().for_each(|time| *time *= SLOWER);
    for stage in &mut scene.stages {
        if let Until::Time(time) = &mut stage.until {
            *time *= SLOWER;
        }
    }
    scene.loads.iter_mut().for_each(|load| load.course = Course::Ramp(0.01));
}

fn slow_explicit(scene: &mut Fields) {
    slow_semi_implicit(scene);
    scene.integrator = Integrator::Explicit;
}

/// Pore pressure over the undrained one, everywhere and at all samples.
fn radial(scene: &Scene) -> Measured {
    let exact = Radial::of(scene).ok_or(Unfit("no ball or cylinder under one pressure"))?;
    Ok(Box::new(move |run| {
        let of = |sample: &Sample| {
            let off = |at: &FieldPoint| {
                let radius = if exact.is_sphere { at.x_m.hypot(at.y_m) } else { at.x_m };
                (at.pressure_pa - exact.pressure(radius, sample.stage_time)) / exact.undrained()
            };
            // Cells that the outline cuts have their pressure elsewhere than in their middle.
            let whole: Vec<f64> = sample.state.field.iter().filter(|at| at.soil > 0.99).map(off).collect();
            if whole.is_empty() { f64::NAN } else { largest(whole.into_iter()) }
        };
        largest(run.observed().filter(|sample| sample.stage_time > 0.0).map(of))
    }))
}

#[cfg(test)]
mod tests {
    use super::super::setup::hold_and_find_their_faults;
    use super::*;

    #[test]
    fn all_hold_and_find_their_faults() {
        hold_and_find_their_faults(&CASES);
    }
}

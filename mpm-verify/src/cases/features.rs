//! What scenes combine beside Table 1's column: loads in time, water before the soil, regions, Biot's coefficient, plates,
//! seepage in series. Each is a built-in scene, run on a few meshes, against its exact solution.

use mpm_core::scene::{Course, Fields, Integrator, Scene, ShapeChoice, StrainChoice};

use super::setup::{Measured, Setup, case, refined};
use super::{FASTER, Program, Unfit, faster, sound};
use crate::exact::seabed::Seabed;
use crate::exact::terzaghi::Terzaghi;
use crate::norms::{LATE_TV, largest};

const CYCLIC: Setup = Setup {
    scene: "cyclic-load",
    change: sound,
    mesh: refined,
    measure: superposed,
    cells: &[10.0, 14.0, 20.0],
    required: 1e-3,
    order: None,
};
const BIOT: Setup = Setup {
    scene: "biot-column",
    change: sound,
    mesh: refined,
    measure: consolidation,
    cells: &[10.0, 14.0, 20.0, 28.0, 40.0],
    // The series leaves out inertia, and the steps are at their limit: no order is expected, as of `semi-implicit`.
    required: 3e-3,
    order: None,
};
const WAVE: Setup = Setup {
    scene: "seabed-wave",
    change: sound,
    mesh: refined,
    measure: wave,
    cells: &[5.0, 10.0, 20.0],
    required: 1e-3,
    order: None,
};
const SERIES: Setup = Setup {
    scene: "flow-in-series",
    change: sound,
    mesh: refined,
    measure: series,
    cells: &[8.0],
    required: 1e-8,
    order: None,
};
const PRESSED: Setup = Setup {
    scene: "pressed",
    change: sound,
    mesh: refined,
    measure: pressed,
    cells: &[10.0],
    required: 1e-9,
    order: None,
};

/// All of them.
pub const CASES: [Program; 9] = [
    case!("load-in-time", "a load that comes, goes and comes again: superposed ramps", FASTER, faster, CYCLIC),
    case!(
        "load-in-time-explicit",
        "the same explicit, centre values",
        FASTER,
        faster,
        Setup { change: explicit, required: 1e-2, ..CYCLIC }
    ),
    case!("biot", "Terzaghi's column with Biot's coefficient 0.6: semi-implicit", "coefficient 1", without_biot, BIOT),
    case!(
        "biot-explicit",
        "the same explicit",
        "coefficient 1",
        without_biot,
        Setup { change: explicit, cells: &[10.0, 14.0, 20.0], required: 5e-3, ..BIOT }
    ),
    case!(
        "biot-quasi-static",
        "the same without inertia, B-splines",
        "coefficient 1",
        without_biot,
        Setup { change: quasi_static, cells: &[10.0, 14.0, 20.0], required: 1e-5, order: None, ..BIOT }
    ),
    case!("seabed-wave", "pore pressure under a standing wave, B-splines", "a longer period", longer, WAVE),
    case!("flow-in-series", "seepage through three soils one behind the other", FASTER, faster_region, SERIES),
    case!("pressed", "force of a plate that presses soil", "E 5 % too low", softer, PRESSED),
    case!(
        "pressed-explicit",
        "the same explicit",
        "E 5 % too low",
        softer,
        Setup { change: damped, required: 1e-3, ..PRESSED }
    ),
];

pub(super) fn explicit(scene: &mut Fields) {
    (scene.integrator, scene.shape, scene.strain) = (Integrator::Explicit, ShapeChoice::Centre, StrainChoice::Large);
}

pub(super) fn quasi_static(scene: &mut Fields) {
    (scene.integrator, scene.shape, scene.strain) =
        (Integrator::QuasiStatic, ShapeChoice::Bspline2, StrainChoice::Small);
    (scene.darcy_inertia, scene.particles_per_cell, scene.tolerance) = (false, 9, 1e-7);
}

fn damped(scene: &mut Fields) {
    explicit(scene);
    scene.stages[0].damping = 200.0;
}

fn without_biot(scene: &mut Fields) {
    scene.biot = None;
}

pub(super) fn softer(scene: &mut Fields) {
    scene.elastic.youngs_modulus *= 0.95;
}

fn longer(scene: &mut Fields) {
    for load in &mut scene.loads {
        if let Course::Wave { period, .. } = &mut load.course {
            *period *= 1.05;
        }
    }
}

fn faster_region(scene: &mut Fields) {
    scene.regions.iter_mut().for_each(|region| region.soil.hydraulic_conductivity *= 1.05);
}

/// Settlement over the largest, against ramps one after the other.
fn superposed(scene: &Scene) -> Measured {
    let (column, times) = Terzaghi::under_one_load(scene).ok_or(Unfit("a column under one load"))?;
    Ok(Box::new(move |run| {
        let exact: Vec<f64> = run.observed().map(|s| column.under(&times, s.stage_time)).collect();
        let most = largest(exact.iter().copied());
        largest(run.observed().zip(&exact).map(|(s, exact)| (s.state.settlement - exact) / most))
    }))
}

/// The error of the column of Table 1 from Tv = 0.1 on.
fn consolidation(scene: &Scene) -> Measured {
    let exact = Terzaghi::compressible(scene).ok_or(Unfit("no plain column"))?;
    let late = (1.0 - 1e-9) * LATE_TV * scene.time_per_factor().ok_or(Unfit("no plain column"))?;
    Ok(Box::new(move |run| {
        let late = run.observed().filter(|s| s.stage_time >= late);
        largest(late.map(|s| s.state.settlement / exact.settlement(s.stage_time) - 1.0))
    }))
}

/// Pore pressure over that of the wave, everywhere and at all samples.
fn wave(scene: &Scene) -> Measured {
    let bed = Seabed::of(scene).ok_or(Unfit("no bed under a standing wave"))?;
    Ok(Box::new(move |run| {
        let of = |sample: &mpm_core::drive::Sample| {
            let off = |at: &mpm_core::observe::FieldPoint| {
                (at.pressure_pa - bed.pressure([at.x_m, at.y_m], sample.stage_time)) / bed.load()
            };
            largest(sample.state.field.iter().map(off))
        };
        largest(run.observed().map(of))
    }))
}

/// Pore pressure over the difference of the reservoirs, at the end: heads that fall along a row of soils.
fn series(scene: &Scene) -> Measured {
    let weight = scene.water.map_or(f64::NAN, |water| water.unit_weight);
    let levels: Vec<f64> = scene.loads.iter().map(|load| load.course.at(0.0, 0.0)).collect();
    let [left, right] = levels[..] else { return Err(Unfit("two reservoirs")) };
    let (ground, width, middle) = (scene.ground(), scene.width, 0.5 * scene.height);
    // Resistance from the left side to a place, s: the soil changes at upright lines.
    let resistance = move |x: f64| -> f64 {
        let pieces: u32 = 4000;
        let length = width / f64::from(pieces);
        let of = |left: f64| {
            (x - left).clamp(0.0, length) / ground.at(&[left + 0.5 * length, middle]).hydraulic_conductivity
        };
        (0..pieces).map(|i| of(f64::from(i) * length)).sum()
    };
    Ok(Box::new(move |run| {
        let Some(last) = run.observed().last() else { return f64::NAN };
        let whole = resistance(width);
        let off = |at: &mpm_core::observe::FieldPoint| {
            let head = left + (right - left) * resistance(at.x_m) / whole;
            (at.pressure_pa / weight + at.y_m - head) / (left - right)
        };
        largest(last.state.field.iter().map(off))
    }))
}

/// Force on a plate between the last two samples against `M u/H`.
fn pressed(scene: &Scene) -> Measured {
    let plate = scene.plates.first().ok_or(Unfit("no plate"))?.clone();
    let end = scene.observe_times.last().copied().unwrap_or(f64::NAN);
    let exact = -scene.oedometer_modulus() * plate.at(end) / scene.height * scene.width;
    Ok(Box::new(move |run| {
        let all: Vec<_> = run.observed().map(|s| (s.state.time, s.state.plates[0].impulse[1])).collect();
        let [.., (before, then), (time, now)] = all[..] else { return f64::NAN };
        ((now - then) / (time - before) / exact - 1.0).abs()
    }))
}

#[cfg(test)]
mod tests {
    use super::super::setup::hold_and_find_their_faults;
    use super::*;

    #[test]
    fn quick_ones_hold_and_their_mutants_fall_short() {
        hold_and_find_their_faults(CASES.iter().filter(|case| !case.name.starts_with("biot-explicit")));
    }
}

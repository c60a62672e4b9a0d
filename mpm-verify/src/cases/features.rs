//! What scenes combine beside Table 1's column: loads in time, water before the soil, regions, Biot's coefficient, plates, given states,
//! stages that drain and hold other sides. Each is a built-in scene, run on a few meshes, against its exact solution.

use std::f64::consts::PI;

use mpm_core::drive::Run;
use mpm_core::scene::{Course, Dimension, Fields, Integrator, Scene, ShapeChoice, Side, StrainChoice, Until};

use super::{Error, FASTER, Mutant, Outcome, Rung, Unfit, asked, faster, finished, integrator, scheme, sound};
use crate::exact::radial::Radial;
use crate::exact::seabed::Seabed;
use crate::exact::terzaghi::Terzaghi;
use crate::norms::{LATE_TV, largest};
use crate::scenes::built_in;

/// What tells the error of a run.
pub(super) type Measured = Result<Box<dyn Fn(&Run) -> f64>, Error>;

/// The same from the scene that it should have been.
pub(super) type Measure = fn(&Scene) -> Measured;

/// A scene, how it is measured, and what that must show.
pub(super) struct Case {
    pub scene: &'static str,
    pub change: fn(&mut Fields),
    pub measure: Measure,
    pub rows: &'static [usize],
    pub required: f64,
    pub order: Option<[f64; 2]>,
}

/// A case of the verification suite with its planted fault.
macro_rules! case {
    ($name:literal, $about:literal, $what:expr, $fault:expr, $case:expr) => {
        Rung {
            name: $name,
            about: $about,
            climb: || climb(&$case, sound),
            mutant: Some(Mutant { what: $what, climb: || climb(&$case, $fault) }),
        }
    };
}
pub(super) use case;

const CYCLIC: Case =
    Case { scene: "cyclic-load", change: sound, measure: superposed, rows: &[10, 14, 20], required: 1e-3, order: None };
const BIOT: Case = Case {
    scene: "biot-column",
    change: sound,
    measure: consolidation,
    rows: &[10, 14, 20, 28, 40],
    // The series leaves out inertia, and the steps are at their limit: no order is expected, as of `semi-implicit`.
    required: 3e-3,
    order: None,
};
const WAVE: Case =
    Case { scene: "seabed-wave", change: sound, measure: wave, rows: &[5, 10, 20], required: 1e-3, order: None };
const SERIES: Case =
    Case { scene: "flow-in-series", change: sound, measure: series, rows: &[8], required: 1e-8, order: None };
const PRESSED: Case =
    Case { scene: "pressed", change: sound, measure: pressed, rows: &[10], required: 1e-9, order: None };

const DE_LEEUW: Case =
    Case { scene: "de-leeuw", change: sound, measure: radial, rows: &[2, 3, 4, 6], required: 1e-3, order: None };
/// Two-point flow in cells that are cut across is of first order, about an axis as in plane strain.
const CRYER: Case = Case {
    scene: "cryer",
    change: sound,
    measure: radial,
    rows: &[8, 12, 16, 24],
    required: 4e-2,
    order: Some([0.7, 1.5]),
};
const SECOND: Option<[f64; 2]> = Some([1.6, 2.6]);

/// Second order: the square of a cell over the height, on the finest mesh.
const TRIANGLE: Case = Case {
    scene: "triangular-start",
    change: centre,
    measure: by_modes,
    rows: &[10, 14, 20],
    required: 2.5e-3,
    order: None,
};
const STAGES: Case = Case { scene: "drainage-in-stages", ..TRIANGLE };
const RELEASED: Case =
    Case { scene: "released-side", change: sound, measure: released, rows: &[4], required: 1e-9, order: None };

/// All of them.
pub const CASES: [Rung; 22] = [
    case!(
        "given-start",
        "a column from a pressure that is linear over its height: quasi-static, B-splines",
        FASTER,
        faster,
        Case { change: quasi_static, rows: &[10, 14, 20, 28], required: 1e-5, order: Some([3.0, 5.0]), ..TRIANGLE }
    ),
    case!(
        "given-start-centre",
        "the same with values at the centre and flow through faces: order 2",
        FASTER,
        faster,
        Case { rows: &[10, 14, 20, 28], order: Some([1.7, 2.3]), ..TRIANGLE }
    ),
    case!(
        "given-start-semi-implicit",
        "the same semi-implicit",
        FASTER,
        faster,
        Case { change: semi_implicit, ..TRIANGLE }
    ),
    case!("given-start-explicit", "the same explicit", FASTER, faster, Case { change: explicit, ..TRIANGLE }),
    case!(
        "drainage-in-stages",
        "a column that drains at its top, at both ends, and is shut in: quasi-static, B-splines",
        TIGHT,
        tight,
        Case { change: quasi_static, required: 1e-5, order: None, ..STAGES }
    ),
    case!("drainage-in-stages-explicit", "the same explicit", TIGHT, tight, Case { change: explicit, ..STAGES }),
    case!("released-side", "a block under a horizontal stress loses a wall", "E 5 % too low", softer, RELEASED),
    case!(
        "released-side-explicit",
        "the same explicit and damped",
        HELD,
        held,
        Case { change: damped_release, required: 1e-3, ..RELEASED }
    ),
    case!("load-in-time", "a load that comes, goes and comes again: superposed ramps", FASTER, faster, CYCLIC),
    case!(
        "load-in-time-explicit",
        "the same explicit, centre values",
        FASTER,
        faster,
        Case { change: explicit, required: 1e-2, ..CYCLIC }
    ),
    case!("biot", "Terzaghi's column with Biot's coefficient 0.6: semi-implicit", "coefficient 1", without_biot, BIOT),
    case!(
        "biot-explicit",
        "the same explicit",
        "coefficient 1",
        without_biot,
        Case { change: explicit, rows: &[10, 14, 20], required: 5e-3, ..BIOT }
    ),
    case!(
        "biot-quasi-static",
        "the same without inertia, B-splines",
        "coefficient 1",
        without_biot,
        Case { change: quasi_static, rows: &[10, 14, 20], required: 1e-5, order: None, ..BIOT }
    ),
    case!("seabed-wave", "pore pressure under a standing wave, B-splines", "a longer period", longer, WAVE),
    case!("flow-in-series", "seepage through three soils one behind the other", FASTER, faster_region, SERIES),
    case!("pressed", "force of a plate that presses soil", "E 5 % too low", softer, PRESSED),
    case!(
        "pressed-explicit",
        "the same explicit",
        "E 5 % too low",
        softer,
        Case { change: damped, required: 1e-3, ..PRESSED }
    ),
    case!("de-leeuw", "De Leeuw's cylinder about an axis: B-splines, quasi-static", PLANE, plane, DE_LEEUW),
    case!(
        "de-leeuw-centre",
        "the same, centre values",
        PLANE,
        plane,
        Case { change: at_centres, rows: &[2, 3, 4, 6, 8], required: 2e-2, order: SECOND, ..DE_LEEUW }
    ),
    case!(
        "de-leeuw-semi-implicit",
        "the same semi-implicit",
        PLANE,
        plane,
        Case { change: slow_semi_implicit, rows: &[3, 4, 6, 8], required: 2e-2, order: SECOND, ..DE_LEEUW }
    ),
    case!(
        "de-leeuw-explicit",
        "the same explicit",
        PLANE,
        plane,
        Case { change: slow_explicit, rows: &[2, 3, 4], required: 3e-2, ..DE_LEEUW }
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

pub(super) fn climb(case: &Case, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let base = built_in(case.scene)?.edited(case.change)?;
    let error = (case.measure)(&base)?;
    let base = base.edited(fault)?;
    let on = |rows: &usize| {
        let scene = base.with_rows(*rows)?;
        Ok((scene.cell, error(&finished(&scene)?)))
    };
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        tolerance: asked(&base),
        errors: case.rows.iter().map(on).collect::<Result<_, Error>>()?,
        required_error: case.required,
        required_order: case.order,
        ..Outcome::default()
    })
}

const TIGHT: &str = "the base drains in no stage";
const HELD: &str = "the wall stays";

fn tight(scene: &mut Fields) {
    scene.stages.iter_mut().for_each(|stage| stage.drained[Side::Bottom as usize] = false);
}

fn held(scene: &mut Fields) {
    scene.stages.iter_mut().for_each(|stage| stage.solid_sides = None);
}

fn centre(scene: &mut Fields) {
    (scene.shape, scene.darcy_inertia) = (ShapeChoice::Centre, false);
}

fn semi_implicit(scene: &mut Fields) {
    explicit(scene);
    scene.integrator = Integrator::SemiImplicit;
}

fn damped_release(scene: &mut Fields) {
    explicit(scene);
    scene.stages.iter_mut().for_each(|stage| stage.damping = 200.0);
}

fn explicit(scene: &mut Fields) {
    (scene.integrator, scene.shape, scene.strain) = (Integrator::Explicit, ShapeChoice::Centre, StrainChoice::Large);
}

fn quasi_static(scene: &mut Fields) {
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

fn softer(scene: &mut Fields) {
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

/// Points over the height, and modes, of a pressure.
const POINTS: u32 = 4000;
const MODES: u32 = 300;

/// Settlement over that of all pressure, at all samples: of a column that starts from a pressure and is under a constant total stress.
/// In every stage the pressure is a sum of the modes of its drained ends.
fn by_modes(scene: &Scene) -> Measured {
    let (initial, water) = (scene.initial.clone().ok_or(Unfit("no given state"))?, scene.water.ok_or(Unfit("dry"))?);
    let (height, modulus, stages) = (scene.height, scene.oedometer_modulus(), scene.stages.clone());
    let coefficient = water.mobility() / scene.storage() / (height * height);
    let mean = |p: &[f64]| p.iter().sum::<f64>() / p.len() as f64;
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(POINTS);
    // p after a time, from p before it.
    let after = move |p: &[f64], drained: [bool; 4], time: f64| {
        let mut now = vec![0.0; p.len()];
        for k in 0..MODES {
            let k = f64::from(k);
            let (number, shift) = match (drained[Side::Bottom as usize], drained[Side::Top as usize]) {
                (false, true) => (k + 0.5, 0.0),
                (true, true) => (k + 1.0, 0.5),
                (false, false) => (k, 0.0),
                (true, false) => (k + 0.5, 0.5),
            };
            let mode: Vec<f64> = (0..POINTS).map(|i| (PI * (number * at(i) - shift)).cos()).collect();
            let share = if number == 0.0 { 1.0 } else { 2.0 };
            let amount = share * mode.iter().zip(p).map(|(m, p)| m * p).sum::<f64>() / p.len() as f64;
            let decay = (-coefficient * time * (PI * number).powi(2)).exp();
            now.iter_mut().zip(&mode).for_each(|(now, m)| *now += amount * decay * m);
        }
        now
    };
    Ok(Box::new(move |run| {
        let mut p: Vec<f64> = (0..POINTS).map(|i| initial.at(&[0.0, height * at(i)])[0]).collect();
        let whole = mean(&p);
        let mut off = Vec::new();
        for (number, stage) in stages.iter().enumerate() {
            let mut now = Vec::new();
            for sample in run.samples.iter().filter(|s| s.stage == number && s.stage_time > 0.0) {
                now = after(&p, stage.drained, sample.stage_time);
                off.push(sample.state.settlement * modulus / (whole * height) - (1.0 - mean(&now) / whole));
            }
            p = now;
        }
        largest(off.into_iter())
    }))
}

/// How thin a block gets whose wall is taken away against `nu (1 + nu)/E s H`, or where its particles move how wide against
/// `(1 - nu^2)/E s W`: nothing else presses it. Before, nothing moves.
fn released(scene: &Scene) -> Measured {
    let stress = -scene.initial.as_ref().ok_or(Unfit("no given state"))?.at(&[0.0, 0.0])[1];
    let (e, nu) = (scene.elastic.youngs_modulus, scene.elastic.poisson_ratio);
    let thinner = stress * nu * (1.0 + nu) / e * scene.height;
    let (wider, first) = (stress * (1.0 - nu * nu) / e, scene.width - 0.5 * scene.spacing());
    let moves = scene.integrator != Integrator::QuasiStatic;
    Ok(Box::new(move |run| {
        let before = run.samples.iter().filter(|s| s.stage == 0).map(|s| s.state.settlement / thinner);
        let last = run.observed().last().map_or(f64::NAN, |s| s.state.settlement / thinner);
        let reached = largest(run.places.solid.iter().map(|place| place[0]));
        let last = if moves { (reached / first - 1.0) / wider } else { last };
        largest(before.chain([last - 1.0]))
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

/// Pore pressure over the undrained one, everywhere and at all samples.
fn radial(scene: &Scene) -> Measured {
    let exact = Radial::of(scene).ok_or(Unfit("no ball or cylinder under one pressure"))?;
    Ok(Box::new(move |run| {
        let of = |sample: &mpm_core::drive::Sample| {
            let off = |at: &mpm_core::observe::FieldPoint| {
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
    use super::*;

    #[test]
    fn quick_ones_hold_and_their_mutants_fall_short() {
        for case in CASES.iter().filter(|case| !case.name.starts_with("biot-explicit")) {
            let climb = case.climb().expect("runs that finish");
            assert!(climb.step.held(), "{}: {}", case.name, climb.reason);
            let spoilt = case.climb_mutant().expect("a mutant").expect("runs that finish");
            assert!(!spoilt.step.held(), "{}: {}", case.name, spoilt.reason);
        }
    }
}

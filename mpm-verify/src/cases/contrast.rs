//! Two layers, in conductivity or in stiffness orders of magnitude apart, against the eigenfunctions of the column.

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::ProfileRow;
use mpm_core::scene::{Fields, Integrator, Scene, ShapeChoice, StepChoice};
use mpm_core::stability::stable_limit;

use super::{Error, Lacks, Mutant, Outcome, Program, Unfit, asked, integrator, scheme};
use super::{FIRST_ORDER, HALVINGS, PARTICLE_COUNTS};
use crate::exact::layered::Layered;
use crate::experiment::comparison::{Compared, Comparison, Norm, in_particles, in_time};
use crate::experiment::refinement::{MESH, Refinement, TOLERANCE};
use crate::norms::largest;
use crate::stress::contrast::{Contrast, Quantity, conductivity, executed, found, scene, stiffness};

/// Conductivity, B-splines.
pub const CONDUCTIVITY: Program = Program {
    name: "contrast-k",
    about: "two layers, k x 10 to 1e6 both ways, B-splines: settlement, order 3 or more",
    run: || splines(CONDUCTIVITIES, SETTLEMENT, 1e-6, SOUND),
    mutant: Some(Mutant { what: TIGHT, run: || splines(CONDUCTIVITIES, SETTLEMENT, 1e-6, SLOWER) }),
};

/// Its pressures.
pub const CONDUCTIVITY_PROFILE: Program = Program {
    name: "contrast-k-profile",
    about: "the same: pore pressure, order 3 or more",
    run: || splines(CONDUCTIVITIES, PROFILE, 3e-5, SOUND),
    mutant: Some(Mutant { what: TIGHT, run: || splines(CONDUCTIVITIES, PROFILE, 3e-5, SLOWER) }),
};

/// Conductivity, the paper's scheme.
pub const CONDUCTIVITY_CENTRE: Program = Program {
    name: "contrast-k-centre",
    about: "the same with centre values and the harmonic mean at the interface: order 2",
    run: || centre(CONDUCTIVITIES, SOUND),
    mutant: Some(Mutant { what: TIGHT, run: || centre(CONDUCTIVITIES, SLOWER) }),
};

/// Conductivity with an implicit pressure: a jump of 1e6 takes 2e7 steps on 20 cells.
pub const CONDUCTIVITY_SEMI: Program = Program {
    name: "contrast-k-semi",
    about: "two layers, k x 10 and 1e3 both ways, implicit pressure: settlement, order 2",
    run: || implicit_pressure(DYNAMIC_CONDUCTIVITIES, SOUND),
    mutant: Some(Mutant { what: TIGHT, run: || implicit_pressure(DYNAMIC_CONDUCTIVITIES, SLOWER) }),
};

/// Conductivity with the paper's step, whose limit is that of the faster layer: a jump of 1e6 takes 1e9 steps on ten
/// cells.
pub const CONDUCTIVITY_EXPLICIT: Program = Program {
    name: "contrast-k-explicit",
    about: "two layers, k x 10 both ways, explicit: settlement, order 2",
    run: || explicit(&[conductivity(10.0), conductivity(0.1)], SOUND),
    mutant: Some(Mutant { what: TIGHT, run: || explicit(&[conductivity(10.0), conductivity(0.1)], SLOWER) }),
};

/// Stiffness, B-splines.
pub const STIFFNESS: Program = Program {
    name: "contrast-e",
    about: "two layers, E x 10 to 1e4 both ways, B-splines: settlement, order 3 or more",
    run: || splines(STIFFNESSES, SETTLEMENT, 1e-6, SOUND),
    mutant: Some(Mutant { what: TIGHT, run: || splines(STIFFNESSES, SETTLEMENT, 1e-6, SLOWER) }),
};

/// Its pressures.
pub const STIFFNESS_PROFILE: Program = Program {
    name: "contrast-e-profile",
    about: "the same: pore pressure, order 3 or more",
    run: || splines(STIFFNESSES, PROFILE, 3e-5, SOUND),
    mutant: Some(Mutant { what: TIGHT, run: || splines(STIFFNESSES, PROFILE, 3e-5, SLOWER) }),
};

/// Stiffness, the paper's scheme.
pub const STIFFNESS_CENTRE: Program = Program {
    name: "contrast-e-centre",
    about: "the same with centre values: order 2",
    run: || centre(STIFFNESSES, SOUND),
    mutant: Some(Mutant { what: TIGHT, run: || centre(STIFFNESSES, SLOWER) }),
};

/// Stiffness with an implicit pressure: a jump of 1e4 takes 2e5 steps on 20 cells.
pub const STIFFNESS_SEMI: Program = Program {
    name: "contrast-e-semi",
    about: "two layers, E x 10 and 100 both ways, implicit pressure: settlement, order 2",
    run: || implicit_pressure(DYNAMIC_STIFFNESSES, SOUND),
    mutant: Some(Mutant { what: TIGHT, run: || implicit_pressure(DYNAMIC_STIFFNESSES, SLOWER) }),
};

/// Stiffness with the paper's step: a jump of 1e4 takes 9e6 steps on ten cells.
pub const STIFFNESS_EXPLICIT: Program = Program {
    name: "contrast-e-explicit",
    about: "two layers, E x 10 both ways, explicit: settlement, order 2",
    run: || explicit(&[stiffness(10.0), stiffness(0.1)], SOUND),
    mutant: Some(Mutant { what: TIGHT, run: || explicit(&[stiffness(10.0), stiffness(0.1)], SLOWER) }),
};

const CONDUCTIVITIES: &[Contrast] = &[
    conductivity(10.0),
    conductivity(1e3),
    conductivity(1e6),
    conductivity(1e-1),
    conductivity(1e-3),
    conductivity(1e-6),
];
const STIFFNESSES: &[Contrast] =
    &[stiffness(10.0), stiffness(1e2), stiffness(1e4), stiffness(1e-1), stiffness(1e-2), stiffness(1e-4)];

const DYNAMIC_CONDUCTIVITIES: &[Contrast] =
    &[conductivity(10.0), conductivity(1e3), conductivity(1e-1), conductivity(1e-3)];
const DYNAMIC_STIFFNESSES: &[Contrast] = &[stiffness(10.0), stiffness(1e2), stiffness(1e-1), stiffness(1e-2)];
/// Share of the passage until which steps that have a limit are followed.
const DYNAMIC_UNTIL: f64 = 0.1;

/// What of a run is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Number {
    /// S over the exact S.
    Settlement,
    /// Pressures in the rows over the largest p_0: RMS.
    Pressure,
}
const SETTLEMENT: Number = Number::Settlement;
const PROFILE: Number = Number::Pressure;

impl Number {
    /// The same of a run, at its sample times.
    fn looks(self, run: &Run, exact: &Layered, contrast: Contrast) -> Comparison {
        let what = match contrast.quantity {
            Quantity::Conductivity => format!("k x {}", contrast.ratio),
            Quantity::Stiffness => format!("E x {}", contrast.ratio),
        };
        let settlement =
            |s: &Sample| Compared::one(s.stage_time, s.state.settlement / exact.settlement(s.stage_time), 1.0);
        let pressures = |s: &Sample| {
            let of = |pressure: &dyn Fn(&ProfileRow) -> f64| {
                s.state.profile.iter().map(|row| pressure(row) / exact.largest_undrained()).collect()
            };
            Compared {
                time: s.stage_time,
                factor: None,
                computed: of(&|row| row.pressure_pa),
                exact: of(&|row| exact.pressure(row.material_height_m, s.stage_time)),
                counts: true,
                places: Vec::new(),
            }
        };
        match self {
            Self::Settlement => {
                Comparison::worst(format!("S over the exact S; {what}"), run.observed().map(settlement).collect())
            }
            Self::Pressure => {
                let looks = Comparison::worst(
                    format!("p over the largest p_0; {what}"),
                    run.observed().map(pressures).collect(),
                );
                Comparison { over_places: Norm::Rms, ..looks }
            }
        }
    }
}

/// What is planted: a factor on the conductivity of the slower or softer layer.
const SOUND: f64 = 1.0;
const SLOWER: f64 = 0.95;
/// The fault in words.
const TIGHT: &str = "conductivity of the slower layer 5 % too low";

fn splines(contrasts: &[Contrast], number: Number, required: f64, fault: f64) -> Result<Outcome, Error> {
    let by = (Integrator::QuasiStatic, ShapeChoice::Bspline2);
    refined(by, contrasts, &[14, 20, 28, 40, 56], 1.0, number, (required, [3.0, 7.0]), fault)
}

/// The slower layer fills half of the column and drains a quarter as fast as the whole would: the error of U at the
/// first time is that of a column on half as many cells.
fn centre(contrasts: &[Contrast], fault: f64) -> Result<Outcome, Error> {
    let by = (Integrator::QuasiStatic, ShapeChoice::Centre);
    refined(by, contrasts, &[20, 28, 40, 56, 80], 1.0, SETTLEMENT, (5e-3, [1.9, 2.2]), fault)
}

fn implicit_pressure(contrasts: &[Contrast], fault: f64) -> Result<Outcome, Error> {
    let by = (Integrator::SemiImplicit, ShapeChoice::Centre);
    refined(by, contrasts, &[10, 14, 20, 28, 40], DYNAMIC_UNTIL, SETTLEMENT, (2e-2, [1.8, 2.4]), fault)
}

fn explicit(contrasts: &[Contrast], fault: f64) -> Result<Outcome, Error> {
    let by = (Integrator::Explicit, ShapeChoice::Centre);
    let rows = [10, 14, 20, 28, 40];
    let mut outcome = refined(by, contrasts, &rows, DYNAMIC_UNTIL, SETTLEMENT, (2e-2, [1.8, 2.4]), fault)?;
    outcome.refinements.push(late(by, contrasts, &rows, fault)?);
    Ok(outcome)
}

/// The settlement of the last time alone: what the largest error, that of the first time, does not know of the interface.
fn late(
    (by, shape): (Integrator, ShapeChoice),
    contrasts: &[Contrast],
    rows: &[usize],
    fault: f64,
) -> Result<Refinement, Error> {
    let mut errors = Vec::with_capacity(rows.len());
    for rows in rows {
        let (mut off, mut cell) = (Vec::new(), 0.0);
        for contrast in contrasts {
            let mut scene = scene(by, shape, *contrast, *rows, DYNAMIC_UNTIL)?;
            let exact = Layered::of(&scene).ok_or(Unfit("not a column of layers"))?;
            scene = scene.edited(|scene| plant(scene, fault))?;
            let looks = SETTLEMENT.looks(&executed(&scene)?, &exact, *contrast);
            let last = looks.rows.last().ok_or(Lacks("sample"))?;
            off.push(last.computed[0] - last.exact[0]);
            cell = scene.cell;
        }
        errors.push((cell, largest(off.into_iter())));
    }
    let late = Refinement::new(MESH, errors, "the exact settlement of the last time");
    Ok(Refinement { required_finest: Some(LATE), ..late })
}

/// Largest error of the last settlement on the finest mesh.
const LATE: f64 = 1e-3;

/// The worst of several contrasts on each mesh.
fn refined(
    (by, shape): (Integrator, ShapeChoice),
    contrasts: &[Contrast],
    rows: &[usize],
    until: f64,
    number: Number,
    (required_error, order): (f64, [f64; 2]),
    fault: f64,
) -> Result<Outcome, Error> {
    let mut errors = Vec::with_capacity(rows.len());
    let (mut notes, mut samples) = (Vec::new(), Vec::new());
    let mut outcome = Outcome { required_error, required_order: Some(order), ..Outcome::default() };
    for rows in rows {
        let (mut worst, mut cell) = (0.0_f64, 0.0);
        let mut outside = 0.0_f64;
        samples = Vec::new();
        for contrast in contrasts {
            let mut scene = scene(by, shape, *contrast, *rows, until)?;
            let exact = Layered::of(&scene).ok_or(Unfit("not a column of layers"))?;
            scene = scene.edited(|scene| plant(scene, fault))?;
            let run = executed(&scene)?;
            let looks = number.looks(&run, &exact, *contrast);
            let error = looks.error().abs();
            samples.extend(looks.samples());
            // A NaN must not be lost in a maximum.
            worst = if error.is_nan() { f64::NAN } else { worst.max(error) };
            outside = outside.max(found(&run, &scene, &exact, *contrast, until).outside);
            cell = scene.cell;
            (outcome.integrator, outcome.scheme) = (integrator(&scene), scheme(&scene));
            outcome.tolerance = asked(&scene);
        }
        errors.push((cell, worst));
        notes = vec![(
            "pressure outside of the exact range at the interface, share of p_0".to_owned(),
            outside,
            "-".to_owned(),
        )];
    }
    let coarse = errors.first().map_or(f64::NAN, |(_, error)| *error);
    let first = contrasts.first().ok_or(Lacks("contrast"))?;
    let refinements = refinements((by, shape), *first, (rows[0], until), number, coarse, fault)?;
    Ok(Outcome { errors, notes, samples, refinements, ..outcome })
}

/// The first contrast on the coarsest mesh: in steps or under tolerances, and with particles, whose errors may be twice
/// what the mesh leaves of the worst contrast.
fn refinements(
    (by, shape): (Integrator, ShapeChoice),
    contrast: Contrast,
    (rows, until): (usize, f64),
    number: Number,
    coarse: f64,
    fault: f64,
) -> Result<Vec<Refinement>, Error> {
    let mut base = scene(by, shape, contrast, rows, until)?;
    let exact = Layered::of(&base).ok_or(Unfit("not a column of layers"))?;
    base = base.edited(|base| plant(base, fault))?;
    let looks = |scene: &Scene| Ok::<_, Error>(number.looks(&executed(scene)?, &exact, contrast));
    let quasi_static = by == Integrator::QuasiStatic;
    let in_time = if quasi_static {
        let finest = looks(&base.edited(|s| s.tolerance = 1e-9)?)?;
        let error =
            |tolerance: f64| Ok((tolerance, looks(&base.edited(|s| s.tolerance = tolerance)?)?.difference(&finest)));
        let errors = [1e-3, 1e-4, 1e-5, 1e-6].into_iter().map(error).collect::<Result<_, Error>>()?;
        let against = format!("the same run under a tolerance of 1e-9, L = {} m", base.cell);
        Refinement { required_share: Some(1.0), ..Refinement::new(TOLERANCE, errors, against) }
    } else {
        let step = |dt| looks(&base.edited(|s| s.step = StepChoice::Fixed(dt))?);
        in_time(step, base.cell, 0.9 * stable_limit(&base), HALVINGS, FIRST_ORDER)?
    };
    // Four points per cell do not integrate B-splines to their order.
    let counts = if shape == ShapeChoice::Bspline2 { &PARTICLE_COUNTS[2..] } else { &PARTICLE_COUNTS[..] };
    let with = |count| looks(&base.edited(|s| s.particles_per_cell = count)?);
    Ok(vec![in_time, in_particles(with, base.cell, counts, 2.0 * coarse)?])
}

/// Plants a factor on the conductivity of the layer that takes the longest.
fn plant(scene: &mut Fields, factor: f64) {
    let slowness =
        |layer: &mpm_core::scene::SoilLayer| 1.0 / (layer.hydraulic_conductivity * layer.elastic.oedometer_modulus());
    if let Some(layer) = scene.layers.iter_mut().max_by(|a, b| slowness(a).total_cmp(&slowness(b))) {
        layer.hydraulic_conductivity *= factor;
    }
}

#[cfg(test)]
mod tests {
    use super::super::suite;

    #[test]
    fn contrasts_hold_and_a_fault_in_a_layer_is_found() {
        for case in suite().iter().filter(|case| case.name.starts_with("contrast-")) {
            let judged = case.judged().expect("runs that finish");
            println!("{}: {} {:?}", case.name, judged.reason, judged.errors);
            assert!(judged.row.passed(), "{}: {}", case.name, judged.reason);
            let mutant = case.mutant_judged().expect("a mutant").expect("runs that finish");
            assert!(!mutant.row.passed(), "{}: {}", case.name, mutant.reason);
        }
    }
}

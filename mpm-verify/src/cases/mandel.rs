//! Mandel's problem: pore pressure over the half width, where it first rises above its undrained value, at single times
//! and as profiles.

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::FieldPoint;
use mpm_core::scene::{Fields, Scene, ShapeChoice, StepChoice, TimeMethod, Until};

use super::PARTICLE_COUNTS;
use super::degree::{Degree, Errors};
use super::{Error, FASTER, Mutant, Outcome, Program, Unfit, asked, faster, finished, integrator, scheme, sound};
use crate::exact::mandel::Mandel;
use crate::experiment::comparison::{Compared, Comparison, in_particles, in_time};
use crate::experiment::refinement::Sampled;
use crate::norms::worst;

/// Quadratic B-splines, eight cells per side on the finest mesh.
pub const SPLINES: Program = Program {
    name: "mandel",
    about: "Mandel's problem, B-splines: p at T = 0.1 with 8 cells per side",
    run: || splines(sound),
    mutant: Some(Mutant { what: FASTER, run: || splines(faster) }),
};

/// The paper's scheme.
pub const CENTRE: Program = Program {
    name: "mandel-centre",
    about: "the same with centre values and pressures constant in a cell",
    run: || centre(sound),
    mutant: Some(Mutant { what: FASTER, run: || centre(faster) }),
};

/// Cubic B-splines.
pub const CUBIC: Program = Program {
    name: "mandel-cubic",
    about: "the same, cubic B-splines: order 4 or more",
    run: || cubic(sound),
    mutant: Some(Mutant { what: FASTER, run: || cubic(faster) }),
};

/// Profiles from early to late.
pub const PROFILE: Program = Program {
    name: "mandel-profile",
    about: "the same, B-splines: profiles of p from T = 0.02 to 2, largest error of all",
    run: || profiles(sound),
    mutant: Some(Mutant { what: FASTER, run: || profiles(faster) }),
};

/// Times T = c t/a^2 of the profiles: the zone that drains is as thick as two cells of the finest mesh at the first.
const PROFILE_TIMES: [f64; 8] = [0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0];

/// Times T = c t/a^2 from this one on count: before, the zone that drains is thinner than the cells.
pub(super) const TIME_FACTOR: f64 = 0.1;

/// First of the given steps of SDIRK4(3), s: forty to T = 0.1.
const SDIRK_STEP: f64 = 1.8e-3;
/// Times T at which steps are compared.
const STEPPED: [f64; 3] = [0.1, 0.2, 0.3];
/// Its order: of the jump at t = 0 nothing is left then that these steps do not follow.
const FOURTH_ORDER: Option<[f64; 2]> = Some([3.5, 4.5]);

/// Whether a time (s) counts.
pub(super) fn counts(exact: &Mandel, time: f64) -> bool {
    exact.time_factor(time) >= TIME_FACTOR * (1.0 - 1e-6)
}

fn splines(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    outcome(ShapeChoice::Bspline2, &[2, 4, 6, 8], 1e-4, [3.0, 6.0], fault)
}

fn cubic(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    outcome(ShapeChoice::Bspline3, &[4, 6, 8, 10, 12], 1e-5, [4.0, 8.0], fault)
}

fn centre(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    outcome(ShapeChoice::Centre, &[8, 12, 16, 24, 32], 1e-3, [1.7, 2.3], fault)
}

fn outcome(
    shape: ShapeChoice,
    sides: &[usize],
    required_error: f64,
    order: [f64; 2],
    fault: fn(&mut Fields),
) -> Result<Outcome, Error> {
    let (mut base, exact) = block(shape)?;
    base = base.edited(fault)?;
    // Products of slopes of cubic B-splines are splines of degree 4.
    base = base.edited(|base| {
        base.particles_per_cell = if shape == ShapeChoice::Bspline3 { 16 } else { base.particles_per_cell }
    })?;
    let scenes: Vec<Scene> = sides.iter().map(|side| on(&base, *side)).collect::<Result<_, _>>()?;
    let (errors, samples) = refined(&scenes, &exact)?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::relative(&base, &settlement);
    let coarse = on(&base, sides[1])?;
    let counts = if shape.spline_degree().is_some() { &PARTICLE_COUNTS[1..] } else { &PARTICLE_COUNTS[..3] };
    let smallest = on(&base, sides[0].max(4))?;
    let until = Until::Time(STEPPED[STEPPED.len() - 1] / exact.time_factor(1.0));
    let stepped = smallest.edited(|s| s.method = TimeMethod::Sdirk)?.edited(|stepped| {
        stepped.observe_times = STEPPED.map(|t| t / exact.time_factor(1.0)).to_vec();
        stepped.stages[0].until = until;
    })?;
    let step = |dt| Ok(looks(&finished(&stepped.edited(|s| s.step = StepChoice::Fixed(dt))?)?, &exact, 0.0));
    let refinements = vec![
        degree.in_tolerance(&stepped, &[1e-3, 1e-4, 1e-5, 1e-6], 1.0)?,
        in_time(step, stepped.cell, SDIRK_STEP, 4, FOURTH_ORDER)?,
        degree.in_particles(&coarse, counts, 2e-2)?,
    ];
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    Ok(Outcome {
        integrator,
        scheme,
        tolerance: asked(&base),
        errors,
        required_error,
        required_order: Some(order),
        samples,
        refinements,
        ..Outcome::default()
    })
}

/// The scene without inertia, all but exact in time.
pub(super) fn block(shape: ShapeChoice) -> Result<(Scene, Mandel), Error> {
    let base = crate::scenes::built_in("mandel")?
        .edited(|base| (base.shape, base.history, base.tolerance) = (shape, 0, 1e-7))?;
    let exact = Mandel::new(&base).ok_or(Unfit("not Mandel's problem"))?;
    Ok((base, exact))
}

fn profiles(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let (mut base, exact) = block(ShapeChoice::Bspline2)?;
    let one = 1.0 / exact.time_factor(1.0);
    base = base.edited(|base| {
        base.observe_times = PROFILE_TIMES.map(|t| t * one).to_vec();
        base.stages[0].until = Until::Time(PROFILE_TIMES[PROFILE_TIMES.len() - 1] * one);
    })?;
    base = base.edited(fault)?;
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for side in [4, 8, 12, 16] {
        let scene = on(&base, side)?;
        let run = finished(&scene)?;
        errors.push((scene.cell, looks(&run, &exact, 0.0).error()));
        samples = profile(&run, &exact, 0.0);
    }
    let coarse = on(&base, 8)?;
    let with = |count| {
        let scene = coarse.edited(|s| s.particles_per_cell = count)?;
        Ok(looks(&finished(&scene)?, &exact, 0.0))
    };
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    Ok(Outcome {
        integrator,
        scheme,
        tolerance: asked(&base),
        errors,
        required_error: 1e-4,
        required_order: Some([3.0, 6.0]),
        samples,
        // Four points per cell do not integrate B-splines to their order.
        refinements: vec![in_particles(with, coarse.cell, &PARTICLE_COUNTS[1..], 1e-2)?],
        ..Outcome::default()
    })
}

/// Pressure over p_0 in every cell at the sample times of a run that begins at a time `start` (s) of the exact
/// solution.
pub(super) fn looks(run: &Run, exact: &Mandel, start: f64) -> Comparison {
    let look = |s: &Sample| {
        let time = s.stage_time + start;
        let of = |pressure: &dyn Fn(&FieldPoint) -> f64| {
            s.state.field.iter().map(|point| pressure(point) / exact.undrained).collect()
        };
        Compared {
            time: s.stage_time,
            factor: Some(exact.time_factor(time)),
            computed: of(&|point| point.pressure_pa),
            exact: of(&|point| exact.pressure(point.x_m, time)),
            counts: true,
            places: Vec::new(),
        }
    };
    Comparison::worst("p/p_0", run.observed().map(look).collect())
}

/// The profiles of such a run: the lowest row of cells, from the middle to the drained side.
pub(super) fn profile(run: &Run, exact: &Mandel, start: f64) -> Vec<Sampled> {
    let mut samples = Vec::new();
    for s in run.observed() {
        let time = s.stage_time + start;
        let lowest = s.state.field.iter().map(|point| point.y_m).fold(f64::INFINITY, f64::min);
        let row = s.state.field.iter().filter(|point| point.y_m <= lowest);
        samples.extend(row.map(|point| {
            let [computed, exact_there] =
                [point.pressure_pa, exact.pressure(point.x_m, time)].map(|p| p / exact.undrained);
            Sampled {
                quantity: format!("p/p_0 at x = {:.4} m", point.x_m),
                unit: "-".to_owned(),
                time: s.stage_time,
                factor: Some(exact.time_factor(time)),
                computed,
                exact: exact_there,
                error: computed - exact_there,
                counts: true,
            }
        }));
    }
    samples
}

/// The block with so many cells per side.
pub(super) fn on(base: &Scene, side: usize) -> Result<Scene, Error> {
    Ok(base.edited(|s| {
        s.cell = base.width / side as f64;
        s.cells = [side; 2];
    })?)
}

/// Errors on meshes, and the finest at every sample time: the pressure where it is furthest off, over p_0.
pub(super) fn refined(scenes: &[Scene], exact: &Mandel) -> Result<(Errors, Vec<Sampled>), Error> {
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for scene in scenes {
        samples = finished(scene)?.observed().filter_map(|s| furthest(s, exact)).collect();
        errors.push((scene.cell, worst(samples.iter().filter(|s| s.counts).map(|s| s.error))));
    }
    Ok((errors, samples))
}

/// The pressure where it is furthest off.
fn furthest(sample: &Sample, exact: &Mandel) -> Option<Sampled> {
    let time = sample.stage_time;
    let off = |point: &FieldPoint| (point.pressure_pa - exact.pressure(point.x_m, time)) / exact.undrained;
    // A number that is not one is the furthest off.
    let size = |point: &FieldPoint| off(point).abs();
    let point = sample.state.field.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?;
    Some(Sampled {
        quantity: format!("p/p_0 at x = {:.4} m, where it is furthest off", point.x_m),
        unit: "-".to_owned(),
        time,
        factor: Some(exact.time_factor(time)),
        computed: point.pressure_pa / exact.undrained,
        exact: exact.pressure(point.x_m, time) / exact.undrained,
        error: off(point),
        counts: counts(exact, time),
    })
}

//! Consolidation under the own weight, from the undrained state of it, against its series.

use mpm_core::scene::{
    Fields, Integrator, Quadrature, Scene, ShapeChoice, StepChoice, StrainChoice, TimeMethod, Until,
};
use mpm_core::stability::stable_limit;

use super::degree::Degree;
use super::{
    Error, FASTER, Lacks, Mutant, Outcome, Program, Unfit, asked, faster, finished, integrator, scheme, slower, sound,
};
use super::{FIRST_ORDER, HALVINGS, PARTICLE_COUNTS};
use crate::exact::self_weight::SelfWeight;
use crate::experiment::refinement::{MESH, Refinement};
use crate::norms::LATE_TV;

/// The paper's scheme.
pub const EXPLICIT: Program = Program {
    name: "self-weight",
    about: "consolidation under the own weight, the paper's scheme: settlement, order 2",
    run: || outcome(&WITH_INERTIA, sound),
    mutant: Some(Mutant { what: FASTER, run: || outcome(&WITH_INERTIA, faster) }),
};

/// Implicit pressure.
pub const SEMI_IMPLICIT: Program = Program {
    name: "self-weight-semi-implicit",
    about: "the same with implicit pressure",
    run: || outcome(&IMPLICIT_PRESSURE, sound),
    mutant: Some(Mutant { what: FASTER, run: || outcome(&IMPLICIT_PRESSURE, faster) }),
};

/// Without inertia.
pub const QUASI_STATIC: Program = Program {
    name: "self-weight-quasi-static",
    about: "the same without inertia, B-splines",
    run: || outcome(&WITHOUT_INERTIA, sound),
    mutant: Some(Mutant { what: FASTER, run: || outcome(&WITHOUT_INERTIA, faster) }),
};

/// Without inertia, the paper's scheme.
pub const CENTRE: Program = Program {
    name: "self-weight-centre",
    about: "the same without inertia, values at the centre and flow through faces: order 2",
    run: || outcome(&WITH_FACES, sound),
    mutant: Some(Mutant { what: FASTER, run: || outcome(&WITH_FACES, faster) }),
};

/// Much strain.
pub const SOFT: Program = Program {
    name: "self-weight-soft",
    about: "soft soil under its own weight, B-splines and centre values, drained: settlement at 10 % strain",
    run: || soft(sound),
    mutant: Some(Mutant { what: "grains 1 % too light", run: || soft(lighter) }),
};

/// A way to run the column, and what it must show.
struct Way {
    change: fn(&mut Fields),
    /// Times count from this time factor on.
    from: f64,
    rows: &'static [usize],
    required_error: f64,
    order: [f64; 2],
    /// Largest error on the coarsest mesh with any number of particles.
    particles_leave: f64,
}

const WITH_INERTIA: Way = Way {
    change: explicit,
    from: LATE_TV,
    rows: &[10, 14, 20, 28, 40],
    required_error: 5e-4,
    order: [1.7, 2.3],
    particles_leave: 2e-3,
};
const IMPLICIT_PRESSURE: Way = Way {
    change: semi_implicit,
    from: 0.01,
    rows: &[10, 14, 20, 28, 40],
    required_error: 3e-4,
    order: [1.7, 2.3],
    particles_leave: 3e-3,
};
const WITHOUT_INERTIA: Way = Way {
    change: quasi_static,
    from: 0.01,
    rows: &[10, 14, 20, 28, 40],
    required_error: 2e-6,
    order: [1.9, 5.0],
    particles_leave: 5e-4,
};

const WITH_FACES: Way = Way {
    change: with_faces,
    from: 0.01,
    rows: &[20, 28, 40, 56],
    required_error: 1e-3,
    order: [1.7, 2.3],
    particles_leave: 5e-3,
};

fn explicit(_: &mut Fields) {}

fn with_faces(scene: &mut Fields) {
    quasi_static(scene);
    scene.shape = ShapeChoice::Centre;
}

fn semi_implicit(scene: &mut Fields) {
    scene.integrator = Integrator::SemiImplicit;
}

fn quasi_static(scene: &mut Fields) {
    (scene.integrator, scene.shape, scene.method) = (Integrator::QuasiStatic, ShapeChoice::Bspline2, TimeMethod::Auto);
    (scene.step, scene.tolerance, scene.particles_per_cell) = (StepChoice::Auto, 1e-7, 9);
}

/// The column whose water drains so many times as slowly.
fn column(way: &Way, slow: f64) -> Result<(Scene, SelfWeight), Error> {
    let mut base = crate::scenes::built_in("self-weight-consolidation")?;
    let end = *base.observe_times.last().ok_or(Lacks("time to look at"))? * slow;
    base = base.edited(|base| {
        base.history = 0;
        (way.change)(base);
        // Strains of the weight itself, and what inertia does to a consolidation of this speed, would stand in the way of
        // the order. Where water weighs less, as much less passes under its weight.
        base.gravity = base.gravity.map(|g| 0.01 * g);
        if let Some(water) = &mut base.water {
            water.unit_weight *= 0.01;
            water.hydraulic_conductivity *= 0.01;
        }
        slower(base, slow);
        base.observe_times.iter_mut().for_each(|t| *t *= slow);
        base.stages[0].until = Until::Time(end);
    })?;
    let exact = SelfWeight::new(&base).ok_or(Unfit("not a column under its own weight"))?;
    Ok((base, exact))
}

/// How much slower than in the scene file water drains.
const SLOW: f64 = 20.0;

fn outcome(way: &Way, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let (mut base, exact) = column(way, SLOW)?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::of_whole(&base, exact.final_settlement(), &settlement).from(way.from / exact.time_factor(1.0));
    base = base.edited(fault)?;
    let (errors, samples) = degree.refine(&base, way.rows)?;
    let coarse = base.with_rows(way.rows[0])?;
    let quasi_static = base.integrator == Integrator::QuasiStatic;
    let in_time = match quasi_static {
        true => degree.in_tolerance(&coarse, &[1e-3, 1e-4, 1e-5, 1e-6], 1.0)?,
        false => {
            // As fast as in the scene file: slower, the error of the step is lost in what is left of the first wave.
            let (mut quick, exact) = column(way, 1.0)?;
            let settlement = |time| exact.settlement(time);
            let late = LATE_TV / exact.time_factor(1.0);
            let degree = Degree::of_whole(&quick, exact.final_settlement(), &settlement).from(late);
            quick = quick.edited(fault)?;
            let coarse = quick.with_rows(way.rows[0])?;
            degree.in_time(&coarse, 0.9 * stable_limit(&coarse), HALVINGS, FIRST_ORDER)?
        }
    };
    let counts = if quasi_static { &PARTICLE_COUNTS[1..] } else { &PARTICLE_COUNTS };
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    Ok(Outcome {
        integrator,
        scheme,
        tolerance: asked(&base),
        errors,
        required_error: way.required_error,
        required_order: Some(way.order),
        samples,
        refinements: vec![in_time, degree.in_particles(&coarse, counts, way.particles_leave)?],
        ..Outcome::default()
    })
}

/// Time factors (small strain) until the column has drained.
const DRAINED: f64 = 12.0;

fn lighter(scene: &mut Fields) {
    scene.grain_density *= 0.99;
}

/// The drained column: each of its grains bears what lies above it, less its buoyancy, `sigma = -a Z` with a = (1 - n) (rho_s -
/// rho_w) g at the first depth Z, and is compressed by `exp(-a Z/M)`: what is left of the height is `M/a (1 - exp(-a H/M))`.
fn soft(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut base = crate::scenes::built_in("self-weight-consolidation")?;
    base = base.edited(|base| {
        quasi_static(base);
        (base.history, base.strain, base.quadrature) = (0, StrainChoice::Large, Quadrature::Fitted);
    })?;
    let (water, gravity) = (base.water.ok_or(Unfit("the scene is dry"))?, base.gravity.ok_or(Lacks("weight"))?);
    let buoyant = (1.0 - base.porosity) * (base.grain_density - water.density) * gravity;
    base = base.edited(|base| base.elastic.youngs_modulus *= 5.0 * buoyant * base.height / base.oedometer_modulus())?;
    let modulus = base.oedometer_modulus();
    let exact = base.height + modulus / buoyant * (-buoyant * base.height / modulus).exp_m1();
    let end = DRAINED * base.time_per_factor().ok_or(Unfit("the scene is dry"))?;
    base = base.edited(|base| (base.observe_times, base.stages[0].until) = (vec![end], Until::Time(end)))?;
    base = base.edited(fault)?;
    let found = |shape: ShapeChoice, rows: usize| {
        let run = finished(&base.edited(|s| s.shape = shape)?.with_rows(rows)?)?;
        let last = run.observed().last().ok_or(Lacks("sample"))?;
        Ok::<_, Error>(last.state.settlement / exact - 1.0)
    };
    let on = |shape| ROWS.iter().map(|rows| Ok((base.height / *rows as f64, found(shape, *rows)?))).collect();
    let (splines, centre): (Result<Vec<_>, Error>, Result<Vec<_>, Error>) =
        (on(ShapeChoice::Bspline2), on(ShapeChoice::Centre));
    let of_centre = Refinement {
        required_finest: Some(1e-4),
        ..Refinement::new(MESH, centre?, "the drained column, values at the centre and flow through faces")
    };
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    let refinements = vec![of_centre];
    Ok(Outcome { integrator, scheme, errors: splines?, required_error: 1e-5, refinements, ..Outcome::default() })
}

const ROWS: [usize; 4] = [10, 14, 20, 28];

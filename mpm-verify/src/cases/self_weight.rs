//! Consolidation under the own weight, from the undrained state of it, against its series.

use mpm_core::scene::{Integrator, Scene, ShapeChoice, StepChoice, TimeMethod, Until};
use mpm_core::stability::stable_limit;

use super::degree::Degree;
use super::terzaghi::{FIRST_ORDER, HALVINGS, PARTICLE_COUNTS};
use super::{FASTER, Mutant, Outcome, Rung, asked, faster, integrator, scheme, slower, sound, with_rows};
use crate::exact::self_weight::SelfWeight;
use crate::norms::LATE_TV;

/// The paper's scheme.
pub const EXPLICIT: Rung = Rung {
    name: "self-weight",
    about: "consolidation under the own weight, the paper's scheme: settlement, order 2",
    climb: || climb(&WITH_INERTIA, sound),
    mutant: Some(Mutant { what: FASTER, climb: || climb(&WITH_INERTIA, faster) }),
};

/// Implicit pressure.
pub const SEMI_IMPLICIT: Rung = Rung {
    name: "self-weight-semi-implicit",
    about: "the same with implicit pressure",
    climb: || climb(&IMPLICIT_PRESSURE, sound),
    mutant: Some(Mutant { what: FASTER, climb: || climb(&IMPLICIT_PRESSURE, faster) }),
};

/// Without inertia.
pub const QUASI_STATIC: Rung = Rung {
    name: "self-weight-quasi-static",
    about: "the same without inertia, B-splines",
    climb: || climb(&WITHOUT_INERTIA, sound),
    mutant: Some(Mutant { what: FASTER, climb: || climb(&WITHOUT_INERTIA, faster) }),
};

/// A way to run the column, and what it must show.
struct Way {
    change: fn(&mut Scene),
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

fn explicit(_: &mut Scene) {}

fn semi_implicit(scene: &mut Scene) {
    scene.integrator = Integrator::SemiImplicit;
}

fn quasi_static(scene: &mut Scene) {
    (scene.integrator, scene.shape, scene.method) = (Integrator::QuasiStatic, ShapeChoice::Bspline2, TimeMethod::Auto);
    (scene.step, scene.tolerance, scene.particles_per_cell) = (StepChoice::Auto, 1e-7, 9);
}

/// The column whose water drains so many times as slowly.
fn column(way: &Way, slow: f64) -> Result<(Scene, SelfWeight), String> {
    let mut base =
        crate::scenes::built_in("self-weight-consolidation").ok_or("no such scene")?.map_err(|e| e.to_string())?;
    base.history = 0;
    (way.change)(&mut base);
    // Strains of the weight itself, and what inertia does to a consolidation of this speed, would stand in the way of
    // the order.
    base.gravity = base.gravity.map(|g| 0.01 * g);
    slower(&mut base, slow);
    let end = *base.observe_times.last().ok_or("no time to look at")? * slow;
    base.observe_times.iter_mut().for_each(|t| *t *= slow);
    base.stages[0].until = Until::Time(end);
    let exact = SelfWeight::new(&base).ok_or("not a column under its own weight")?;
    Ok((base, exact))
}

/// How much slower than in the scene file water drains.
const SLOW: f64 = 20.0;

fn climb(way: &Way, fault: fn(&mut Scene)) -> Result<Outcome, String> {
    let (mut base, exact) = column(way, SLOW)?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::of_whole(&base, exact.final_settlement(), &settlement).from(way.from / exact.time_factor(1.0));
    fault(&mut base);
    let (errors, samples) = degree.refine(&base, way.rows)?;
    let coarse = with_rows(base.clone(), way.rows[0]);
    let quasi_static = base.integrator == Integrator::QuasiStatic;
    let in_time = match quasi_static {
        true => degree.in_tolerance(&coarse, &[1e-3, 1e-4, 1e-5, 1e-6], 1.0)?,
        false => {
            // As fast as in the scene file: slower, the error of the step is lost in what is left of the first wave.
            let (mut quick, exact) = column(way, 1.0)?;
            let settlement = |time| exact.settlement(time);
            let late = LATE_TV / exact.time_factor(1.0);
            let degree = Degree::of_whole(&quick, exact.final_settlement(), &settlement).from(late);
            fault(&mut quick);
            let coarse = with_rows(quick, way.rows[0]);
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

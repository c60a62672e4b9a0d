//! Mandel's problem: pore pressure over the half width at T = 0.1, where it first rises above its undrained value.

use mpm_core::drive::Sample;
use mpm_core::observe::FieldPoint;
use mpm_core::scene::{Scene, ShapeChoice};

use super::degree::{Degree, Errors};
use super::evidence::Sampled;
use super::terzaghi::PARTICLE_COUNTS;
use super::{FASTER, Mutant, Outcome, Rung, faster, finished, integrator, scheme, sound};
use crate::exact::mandel::Mandel;
use crate::norms::worst;

/// Quadratic B-splines, eight cells per side on the finest mesh.
pub const SPLINES: Rung = Rung {
    name: "mandel",
    about: "Mandel's problem, B-splines: p at T = 0.1 with 8 cells per side",
    climb: || splines(sound),
    mutant: Some(Mutant { what: FASTER, climb: || splines(faster) }),
};

/// The paper's scheme.
pub const CENTRE: Rung = Rung {
    name: "mandel-centre",
    about: "the same with centre values and pressures constant in a cell",
    climb: || centre(sound),
    mutant: Some(Mutant { what: FASTER, climb: || centre(faster) }),
};

/// Times T = c t/a^2 from this one on count: before, the zone that drains is thinner than the cells.
pub(super) const TIME_FACTOR: f64 = 0.1;

/// Whether a time (s) counts.
pub(super) fn counts(exact: &Mandel, time: f64) -> bool {
    exact.time_factor(time) >= TIME_FACTOR * (1.0 - 1e-6)
}

fn splines(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    climb(ShapeChoice::Bspline2, &[2, 4, 8], 1e-4, [3.0, 6.0], fault)
}

fn centre(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    climb(ShapeChoice::Centre, &[8, 16, 32], 1e-3, [1.7, 2.3], fault)
}

fn climb(
    shape: ShapeChoice,
    sides: &[usize],
    required_error: f64,
    order: [f64; 2],
    fault: fn(&mut Scene),
) -> Result<Outcome, String> {
    let mut base = crate::scenes::built_in("mandel").ok_or("no such scene")?.map_err(|e| e.to_string())?;
    (base.shape, base.history, base.tolerance) = (shape, 0, 1e-7);
    let exact = Mandel::new(&base).ok_or("not Mandel's problem")?;
    fault(&mut base);
    let scenes: Vec<Scene> = sides.iter().map(|side| on(&base, *side)).collect();
    let (errors, samples) = refined(&scenes, &exact)?;
    let settlement = |time| exact.settlement(time);
    let degree = Degree::relative(&base, &settlement);
    let coarse = on(&base, sides[1]);
    let counts = if shape == ShapeChoice::Bspline2 { &PARTICLE_COUNTS[1..] } else { &PARTICLE_COUNTS[..3] };
    let refinements = vec![
        degree.in_tolerance(&coarse, &[1e-3, 1e-4, 1e-5, 1e-6], 1.0)?,
        degree.in_particles(&coarse, counts, 2e-2)?,
    ];
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    Ok(Outcome {
        integrator,
        scheme,
        errors,
        required_error,
        required_order: Some(order),
        samples,
        refinements,
        ..Outcome::default()
    })
}

/// The block with so many cells per side.
fn on(base: &Scene, side: usize) -> Scene {
    Scene { cell: base.width / side as f64, cells: [side; 2], ..base.clone() }
}

/// Errors on meshes, and the finest at every sample time: the pressure where it is furthest off, over p_0.
pub(super) fn refined(scenes: &[Scene], exact: &Mandel) -> Result<(Errors, Vec<Sampled>), String> {
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

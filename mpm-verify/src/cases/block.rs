//! A stiff elastic block on a base with Coulomb friction, against a rigid one: it is stopped, it slides, it runs away as the
//! base weakens, and it stays where it is.
//!
//! The error is that of the way its centre has come, relative; it is of first order in the time step, which goes with the
//! mesh.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{Base, Fields, Scene, StepChoice};
use mpm_core::stability::choose_step;

use super::{Error, Lacks, Mutant, Outcome, Program, finished, integrator, scheme, sound};
use crate::exact::sliding::Sliding;
use crate::experiment::comparison::{Compared, Comparison, in_particles, in_time};

/// Thrown along a flat base.
pub const STOPS: Program = Program {
    name: "block-stops",
    about: "a block thrown along a base comes to rest after v^2/(2 mu g)",
    run: || way("block-stops", sound),
    mutant: Some(Mutant { what: "friction 5 % too high", run: mutant }),
};

/// Steeper than its friction.
pub const SLIDES: Program = Program {
    name: "block-slides",
    about: "a block on an incline slides with g (sin b - mu cos b)",
    run: || way("block-on-incline", sound),
    mutant: Some(Mutant { what: "gravity tilted by one degree too much", run: mutant_of_gravity }),
};

/// Friction that falls with slip.
pub const WEAKENS: Program = Program {
    name: "block-weakens",
    about: "a base that weakens with slip: cosh(w t), then the residual friction",
    run: || way("block-weakens", sound),
    mutant: Some(Mutant { what: "a slip distance 5 % too short", run: mutant_of_weakening }),
};

/// Less steep than its friction.
pub const STICKS: Program = Program {
    name: "block-sticks",
    about: "a block on an incline below the friction angle: no friction work at all",
    run: || sticks(30.0),
    mutant: Some(Mutant { what: "a friction angle half a degree below the slope", run: mutant_of_sticking }),
};

const ROWS: [usize; 4] = [1, 2, 3, 4];

/// The way of the block in a scene, whose base or gravity `spoil` may change behind the exact solution's back.
fn way(name: &str, spoil: fn(&mut Fields)) -> Result<Outcome, Error> {
    let base = scene(name)?;
    let exact = Sliding::new(&base).ok_or(Lacks("block on a base"))?;
    let looks_at = |mut scene: Scene| {
        scene = scene.edited(spoil)?;
        looks(&finished(&scene)?, &exact)
    };
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for rows in ROWS {
        let scene = on_mesh(base.clone(), rows)?;
        let (cell, looks) = (scene.cell, looks_at(scene)?);
        errors.push((cell, looks.error()));
        samples = looks.samples();
    }
    let coarse = on_mesh(base.clone(), ROWS[0])?;
    let step = choose_step(&coarse)?;
    let stepped = |step| looks_at(coarse.edited(|s| s.step = StepChoice::Fixed(step))?);
    let with = |particles_per_cell| looks_at(coarse.edited(|s| s.particles_per_cell = particles_per_cell)?);
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 5e-4,
        required_order: Some([0.6, 1.4]),
        samples,
        refinements: vec![
            in_time(stepped, coarse.cell, step, 4, Some([0.8, 1.2]))?,
            in_particles(with, coarse.cell, &[1, 4, 9, 16], 2e-3)?,
        ],
        ..Outcome::default()
    })
}

/// The way of the centre over the whole one; the end counts.
pub(super) fn looks(run: &Run, exact: &Sliding) -> Result<Comparison, Error> {
    let [first, last] = [run.samples.first(), run.samples.last()].map(|s| s.ok_or(Lacks("sample")));
    let (first, last) = (first?, last?);
    let whole = exact.distance(last.state.time);
    let look = |s: &Sample| Compared {
        counts: s.state.time == last.state.time,
        ..Compared::one(
            s.state.time,
            (s.state.centre[0] - first.state.centre[0]) / whole,
            exact.distance(s.state.time) / whole,
        )
    };
    Ok(Comparison::worst("way of the block over the whole one", run.samples[1..].iter().map(look).collect()))
}

/// The same block on 10 degrees: its base must not have taken any energy, because no node of it has slid.
fn sticks(friction_angle: f64) -> Result<Outcome, Error> {
    let scene = scene("block-on-incline")?.edited(|scene| {
        scene.slope_angle = Some(10.0);
        scene.base = scene.base.map(|b| Base { peak_angle: friction_angle, residual_angle: friction_angle, ..b });
    })?;
    let run = finished(&scene)?;
    let last = run.samples.last().ok_or(Lacks("sample"))?;
    // As a share of what the weight would do over the height of the block.
    let weight = scene.mixture_density() * scene.width * scene.height * scene.gravity.unwrap_or(0.0);
    let lost = last.balance.base_friction_j.abs() / (weight * scene.height);
    Ok(Outcome {
        integrator: integrator(&scene),
        scheme: scheme(&scene),
        errors: vec![(scene.cell, lost)],
        required_error: 0.0,
        required_order: None,
        ..Outcome::default()
    })
}

fn scene(name: &str) -> Result<Scene, Error> {
    Ok(crate::scenes::built_in(name)?.edited(|scene| scene.history = 0)?)
}

/// The block with so many cells over its height, in the same room.
fn on_mesh(scene: Scene, rows: usize) -> Result<Scene, Error> {
    let room = scene.empty_cells_beside as f64 * scene.cell;
    Ok(scene.edited(|scene| {
        scene.cell = scene.height / rows as f64;
        scene.cells = [(scene.width / scene.cell).round() as usize, rows];
        scene.empty_cells_beside = (room / scene.cell).round() as usize;
    })?)
}

/// Friction that is 5 % too high.
fn mutant() -> Result<Outcome, Error> {
    way("block-stops", |scene| turn_base(scene, |angle| (1.05 * angle.to_radians().tan()).atan().to_degrees()))
}

/// Gravity that is tilted by one degree too much.
fn mutant_of_gravity() -> Result<Outcome, Error> {
    way("block-on-incline", |scene| scene.slope_angle = scene.slope_angle.map(|angle| angle + 1.0))
}

/// A base that weakens over 5 % less slip.
fn mutant_of_weakening() -> Result<Outcome, Error> {
    way("block-weakens", |scene| {
        scene.base = scene.base.map(|b| Base { slip_distance: b.slip_distance.map(|d| 0.95 * d), ..b });
    })
}

/// A block that sticks only if its friction is what it should be.
fn mutant_of_sticking() -> Result<Outcome, Error> {
    sticks(9.5)
}

fn turn_base(scene: &mut Fields, angle: fn(f64) -> f64) {
    scene.base =
        scene.base.map(|b| Base { peak_angle: angle(b.peak_angle), residual_angle: angle(b.residual_angle), ..b });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cases_pass_and_their_mutants_fall_short() {
        for case in [STOPS, SLIDES, WEAKENS, STICKS] {
            let judged = case.judged().expect("runs that finish");
            assert!(judged.row.passed(), "{}: {}", case.name, judged.reason);
            let spoilt = case.mutant_judged().expect("a mutant").expect("runs that finish");
            assert!(!spoilt.row.passed(), "{}: {}", case.name, spoilt.reason);
        }
    }
}

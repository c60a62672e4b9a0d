//! A flexible strip on weightless Mohr-Coulomb soil with associated flow: the load that it no longer bears ([`crate::exact::bearing`]).
//!
//! The load grows until Newton's iteration finds no equilibrium however short the step is: the limit load, to 1e-5 of the ramp.
//! Where the dilation is one value per cell and the shear strain is not, as with b-bar, gimp and B-splines, the dilation of the
//! largest shear strain is forced upon the whole cell, and soil that dilates bears too much: strains are those of the centre here.

use mpm_core::run::run;
use mpm_core::scene::Scene;

use super::{Error, Lacks, Mutant, Outcome, Program, Unfit, asked, integrator, scheme};
use crate::exact::bearing::n_c;

/// Tresca soil.
pub const UNDRAINED: Program = Program {
    name: "footing-phi-0",
    about: "strip footing on weightless soil without friction: limit load (2 + pi) c within 1 %",
    run: || outcome(0.0, 0.0, 0.01),
    mutant: Some(Mutant { what: STRONGER, run: || outcome(0.0, 1.0, 0.01) }),
};

/// 20 degrees.
pub const PHI_20: Program = Program {
    name: "footing-phi-20",
    about: "the same with phi = psi = 20 degrees: Prandtl's N_c c within 2 %",
    run: || outcome(20.0, 0.0, 0.02),
    mutant: Some(Mutant { what: STRONGER, run: || outcome(20.0, 1.0, 0.02) }),
};

/// 30 degrees.
pub const PHI_30: Program = Program {
    name: "footing-phi-30",
    about: "the same with phi = psi = 30 degrees",
    run: || outcome(30.0, 0.0, 0.02),
    mutant: Some(Mutant { what: STRONGER, run: || outcome(30.0, 1.0, 0.02) }),
};

const STRONGER: &str = "angles of friction and dilation one degree too large";

/// Half of a strip that is 1 m wide. The mechanism for 30 degrees reaches 4.8 m from the axis and 1.6 m down.
const SCENE: &str = r#"
name = "footing"
dimension = "plane-strain"
geometry.column = { height = 2.5, width = 5.0 }
mesh = { cell = 0.25, particles_per_cell = 1 }
boundaries = { left = "roller", right = "roller", bottom = "fixed" }
scheme.shape = "centre"
time = { integrator = "quasi-static", tolerance = 1e-4 }
stages = [{ until.time = 1.0 }]
observe.times = [0.4, 0.6, 0.7]
[soil]
grain_density = 2650.0
porosity = 0.4
strain = "small"
law.mohr_coulomb = { youngs_modulus = 1e7, poisson_ratio = 0.3, cohesion = 1e3, friction_angle = 0.0 }
[surcharge]
pressure = 1.0
ramp_time = 1.0
strip = { from = 0.0, to = 0.5 }
"#;
/// The load at the end of the ramp over the exact limit load.
const BEYOND: f64 = 1.25;
/// Rows of cells.
const ROWS: [usize; 2] = [10, 20];

/// The scene on so many rows of cells, and the exact limit load (Pa); its soil has more friction than that by some degrees.
fn footing(friction_angle: f64, more: f64, rows: usize) -> Result<(Scene, f64), Error> {
    let scene = Scene::parse(SCENE, "footing").and_then(|scene| scene.with_rows(rows))?;
    let exact = n_c(friction_angle) * scene.strength.ok_or(Unfit("the soil is elastic"))?.cohesion;
    let law = |name: &str| format!("soil.law.mohr_coulomb.{name}");
    let angle = friction_angle + more;
    let changes = [
        (law("friction_angle"), angle.into()),
        (law("dilation_angle"), angle.into()),
        ("surcharge.pressure".to_owned(), (BEYOND * exact).into()),
    ];
    Ok((scene.patched(&changes)?, exact))
}

/// What a footing bears.
struct Limit {
    /// The load, Pa.
    load: f64,
    /// Steps, those that found no equilibrium among them, and Newton iterations of all of them.
    steps: u64,
    iterations: u64,
}

/// Loads a footing until it fails.
fn limit(scene: &Scene) -> Result<Limit, Error> {
    let surcharge = scene.surcharge.ok_or(Lacks("load"))?;
    let run = run(scene, &mut |_| {})?;
    let time = match &run.failure {
        Some(failure) if failure.what.contains("the load may exceed the bearing capacity") => failure.time,
        Some(failure) => return Err(failure.clone().into()),
        None => surcharge.ramp_time,
    };
    let steps = run.work.accepted + run.work.rejected;
    Ok(Limit { load: surcharge.at(time), steps, iterations: run.work.solves })
}

fn outcome(friction_angle: f64, more: f64, required_error: f64) -> Result<Outcome, Error> {
    let (base, exact) = footing(friction_angle, more, ROWS[0])?;
    let (mut errors, mut notes) = (Vec::new(), vec![("limit load, exact".to_owned(), exact, "Pa".to_owned())]);
    for rows in ROWS {
        let (scene, _) = footing(friction_angle, more, rows)?;
        let found = limit(&scene)?;
        errors.push((scene.cell, found.load / exact - 1.0));
        let mut note = |what: &str, value: f64, unit: &str| {
            notes.push((format!("{what}, L = {} m", scene.cell), value, unit.to_owned()));
        };
        note("limit load found", found.load, "Pa");
        note("steps of the load, those without equilibrium too", found.steps as f64, "-");
        note("Newton iterations in all of them", found.iterations as f64, "-");
    }
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        tolerance: asked(&base),
        errors,
        required_error,
        notes,
        scene: Some(base),
        ..Outcome::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_mesh_tells_one_degree() {
        for angle in [0.0, 20.0, 30.0] {
            let error = |more| {
                let (scene, exact) = footing(angle, more, ROWS[0]).expect("a scene");
                limit(&scene).expect("a limit").load / exact - 1.0
            };
            let (own, other) = (error(0.0), error(1.0));
            assert!(own.abs() < 0.01 && other > 0.03, "{angle}: {own:.4} {other:.4}");
        }
    }

    #[test]
    fn a_dilation_that_is_one_per_cell_locks() {
        let (scene, exact) = footing(20.0, 0.0, ROWS[0]).expect("a scene");
        let scene = scene.patched(&[("scheme.shape", "b-bar".into()), ("mesh.particles_per_cell", 4.into())]);
        let scene = scene.expect("a scene");
        assert!(limit(&scene).expect("a load").load > 1.2 * exact);
    }
}

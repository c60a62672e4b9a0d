//! A saturated column under gravity stays at rest, in plane strain and with both Darcy operators.
//!
//! This decides the sign in the paper's Eq. (2): as printed, still water would flow at 2 k.

use mpm_core::scene::{DarcyChoice, Dimension, Start, Until};

use super::{Mutant, Outcome, Rung, finished, integrator, scheme};

/// The rung.
pub const RUNG: Rung = Rung {
    name: "hydrostatic",
    about: "still water stays still (sign of Eq. 2)",
    climb: || climb(Start::Geostatic),
    mutant: Some(Mutant { what: "no water pressure at the start", climb: || climb(Start::Unloaded) }),
};

fn climb(start: Start) -> Result<Outcome, String> {
    let mut worst: f64 = 0.0;
    let mut name = String::new();
    for darcy in [DarcyChoice::Face, DarcyChoice::Nodal] {
        let mut scene = crate::scenes::terzaghi();
        (scene.dimension, scene.cell, scene.cells) = (Dimension::PlaneStrain, 0.05, [2, 20]);
        (scene.gravity, scene.start, scene.surcharge, scene.darcy) = (Some(9.81), start, None, darcy);
        scene.stages[0].until = Until::Time(1e-2);
        (scene.observe_times, scene.history) = (vec![1e-2], 0);
        name = scheme(&scene);
        let run = finished(&scene)?;
        let last = run.samples.last().ok_or("no sample")?;
        // Speed against that of free fall over the same time.
        worst = worst.max(last.state.max_speed / (9.81 * 1e-2));
    }
    let scheme = name.replace("nodal", "face and nodal");
    let integrator = integrator(&crate::scenes::terzaghi());
    Ok(Outcome {
        integrator,
        scheme,
        errors: vec![(0.05, worst)],
        required_error: 1e-9,
        required_order: None,
        ..Outcome::default()
    })
}

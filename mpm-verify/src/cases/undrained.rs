//! Undrained compression: load on a closed, damped column; p -> q (K_w/n)/(M + K_w/n) = 9963.4 Pa.
//!
//! This decides the sign in the paper's Eq. (5): as printed, compressing the skeleton would lower the pressure.

use mpm_core::scene::{Scene, Start, Until};

use super::{Mutant, Outcome, Rung, finished, integrator, scheme, sound, with_rows};

/// The rung.
pub const RUNG: Rung = Rung {
    name: "undrained",
    about: "pore pressure of a closed column under load (sign of Eq. 5)",
    climb: || climb(sound),
    mutant: Some(Mutant { what: "water 1 % too stiff", climb: || climb(stiffer) }),
};

fn stiffer(scene: &mut Scene) {
    if let Some(water) = &mut scene.water {
        water.bulk_modulus *= 1.01;
    }
}

fn climb(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    let mut scene = with_rows(crate::scenes::terzaghi(), 20);
    scene.start = Start::Unloaded;
    scene.stages[0].drained = [false; 4];
    // Critical damping of the first undrained mode, 2 omega = pi c_u/H, kills the wave within milliseconds. What it
    // leaves uneven flows off inside the column, and only in the time of a consolidation: three times Tv = 1.
    let speed = ((scene.oedometer_modulus() + scene.pore_stiffness()) / scene.mixture_density()).sqrt();
    scene.stages[0].damping = std::f64::consts::PI * speed / scene.height;
    let end = 3.0 * crate::scenes::terzaghi().time_per_factor().ok_or("the scene is dry")?;
    scene.stages[0].until = Until::Time(end);
    (scene.observe_times, scene.history) = (vec![end], 0);
    let expected = scene.undrained_pressure();
    fault(&mut scene);
    let run = finished(&scene)?;
    let last = run.samples.last().ok_or("no sample")?;
    let worst = last.state.profile.iter().map(|row| (row.pressure_pa / expected - 1.0).abs()).fold(0.0, f64::max);
    // The analysis is linear; strains of q/(M + Q) = 1.4e-6 change volumes by as much.
    Ok(Outcome {
        integrator: integrator(&scene),
        scheme: scheme(&scene),
        errors: vec![(scene.cell, worst)],
        required_error: 1e-5,
        required_order: None,
        ..Outcome::default()
    })
}

//! A dry bar under a step load: its top moves at q/(rho c) until the wave comes back (d'Alembert).

use mpm_core::scene::{Scene, Start, Until};

use super::{Mutant, Outcome, Rung, finished, integrator, scheme, sound, with_rows};

/// The rung.
pub const RUNG: Rung = Rung {
    name: "dry-bar",
    about: "elastic wave in a bar without water",
    climb: || climb(sound),
    mutant: Some(Mutant { what: "skeleton 5 % too stiff", climb: || climb(stiffer) }),
};

fn stiffer(scene: &mut Scene) {
    scene.elastic.youngs_modulus *= 1.05;
}

fn climb(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    let mut base = crate::scenes::terzaghi();
    (base.water, base.start, base.history) = (None, Start::Unloaded, 0);
    base.stages[0].drained = [false; 4];
    let speed = (base.oedometer_modulus() / base.mixture_density()).sqrt();
    let there_and_back = 2.0 * base.height / speed;
    base.stages[0].until = Until::Time(there_and_back);
    base.observe_times = vec![there_and_back];
    // u = q t/(rho c) up to 2 H/c: there twice the static settlement.
    let expected = 2.0 * 1.0e4 * base.height / base.oedometer_modulus();
    fault(&mut base);
    let mut errors = Vec::new();
    for rows in [40, 80, 160] {
        let scene = with_rows(base.clone(), rows);
        let run = finished(&scene)?;
        let last = run.samples.last().ok_or("no sample")?;
        errors.push((scene.cell, last.state.settlement / expected - 1.0));
    }
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1.0e-2,
        required_order: Some([0.5, 1.5]),
        ..Outcome::default()
    })
}

//! An oedometer made of particles: dry soil that yields along the edge s1 = s2 under a load that grows slowly.

use mpm_core::scene::{Dimension, Scene, ShapeChoice};

use super::super::{Mutant, Outcome, Rung, finished, integrator, scheme};
use crate::exact::oedometer::Oedometer;

/// The rung.
pub const RUNG: Rung = Rung {
    name: "mc-oedometer",
    about: "Mohr-Coulomb soil compressed beyond yield by particles, one and two dimensions: settlement",
    climb: || settles(|_| {}),
    mutant: Some(Mutant { what: "angle of friction one degree too large", climb: mutant }),
};

/// A friction angle that is one degree off.
fn mutant() -> Result<Outcome, String> {
    settles(|scene| {
        if let Some(strength) = &mut scene.strength {
            strength.friction_angle += 1.0;
        }
    })
}

/// The largest error of the settlement at rest over columns and blocks. Strains of q/M = 5e-4 change volumes by as much.
fn settles(change: impl Fn(&mut Scene)) -> Result<Outcome, String> {
    let base = crate::scenes::oedometer();
    let exact = Oedometer::new(&base).ok_or("soil without strength")?;
    let load = base.surcharge.ok_or("no load")?.pressure;
    let expected = base.height * exact.strain(load);
    let mut worst = 0.0_f64;
    for dimension in [Dimension::Column, Dimension::PlaneStrain] {
        for shape in [ShapeChoice::Centre, ShapeChoice::Bspline2] {
            let mut scene = Scene { dimension, shape, ..base.clone() };
            if dimension == Dimension::PlaneStrain {
                scene.cells[0] = (scene.width / scene.cell).round() as usize;
            }
            change(&mut scene);
            let run = finished(&scene)?;
            let last = run.samples.last().ok_or("no sample")?;
            worst = worst.max((last.state.settlement / expected - 1.0).abs());
        }
    }
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: format!("{} and bspline2", scheme(&base)),
        errors: vec![(base.cell, worst)],
        required_error: 1e-3,
        required_order: None,
        ..Outcome::default()
    })
}

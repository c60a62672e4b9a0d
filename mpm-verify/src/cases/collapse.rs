//! Collapse of granular columns: run-out against the band of published laws. There is no exact solution.
//!
//! Experiments differ by a factor of two and more (reference-data/literature/column_collapse.csv, which says how each law is
//! known), so the error is the distance from the middle of their band in half widths of the band: up to 1 is inside.

use mpm_core::scene::Scene;

use super::{Mutant, Outcome, Rung, finished, integrator, scheme, sound};
use crate::baseline::ladder::Kind as Baseline;
use crate::literature::{Kind, run_out};

/// Dry columns.
pub const DRY: Rung = Rung {
    name: "collapse-dry",
    about: "run-out of dry columns of aspect ratio 1, 2 and 4 within the scatter of published laws",
    climb: || climb("collapse-dry", &[0.1, 0.05], &[1.0, 2.0, 4.0], Kind::Dry, sound),
    mutant: Some(Mutant {
        what: "friction of 60 degrees",
        climb: || climb("collapse-dry", &[0.1, 0.05], &[1.0, 2.0, 4.0], Kind::Dry, rough),
    }),
};

/// Columns full of water.
pub const SATURATED: Rung = Rung {
    name: "collapse-saturated",
    about: "run-out of saturated columns in air of aspect ratio 1 and 2 within the scatter of laws for immersed ones",
    climb: || climb("collapse-saturated", &[0.1], &[1.0, 2.0], Kind::Immersed, sound),
    mutant: Some(Mutant {
        what: "friction of 60 degrees",
        climb: || climb("collapse-saturated", &[0.1], &[1.0, 2.0], Kind::Immersed, rough),
    }),
};

fn rough(scene: &mut Scene) {
    if let Some(strength) = &mut scene.strength {
        strength.friction_angle = 60.0;
    }
}

fn climb(name: &str, meshes: &[f64], aspects: &[f64], kind: Kind, fault: fn(&mut Scene)) -> Result<Outcome, String> {
    let base = crate::scenes::built_in(name).and_then(Result::ok).expect("the built-in scene holds");
    let (mut errors, mut notes) = (Vec::new(), Vec::new());
    for &cell in meshes {
        let mut worst: f64 = 0.0;
        for &aspect in aspects {
            let mut scene = base.clone();
            scene.height = aspect * scene.width;
            scene.cell = cell;
            scene.cells = [scene.width, scene.height].map(|length| (length / cell).round() as usize);
            scene.sideroom_cells = (8.0 / cell).round() as usize;
            fault(&mut scene);
            let run = finished(&scene)?;
            let last = run.samples.last().ok_or("no sample")?;
            let reach = last.state.reach;
            let found = (reach[0] - scene.width) / scene.width;
            let (low, high) = run_out(kind, aspect).ok_or("no law for this aspect ratio")?;
            let off = (found - 0.5 * (low + high)) / (0.5 * (high - low));
            worst = if off.abs() > worst.abs() { off } else { worst };
            let of = format!("H_0/L_0 = {aspect}, L = {cell} m");
            let mut note =
                |what: &str, value, unit: &str| notes.push((format!("{what}, {of}"), value, unit.to_owned()));
            note("run-out (L_inf - L_0)/L_0", found, "-");
            note("published, lowest", low, "-");
            note("published, highest", high, "-");
            note("height H_inf/L_0", reach[1] / scene.width, "-");
            note("energy closing over work of gravity", last.ledger.energy_closing_j / last.ledger.gravity_work_j, "-");
            note("water closing", last.ledger.water_closing_kg, "kg");
        }
        errors.push((cell, worst));
    }
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 1.0,
        notes,
        kind: Baseline::Regression,
        ..Outcome::default()
    })
}

//! Consolidation to a final strain of 30 %: particles cross cells whenever the mesh is laid anew.

use mpm_core::drive::Sample;
use mpm_core::scene::{Scene, ShapeChoice, Surcharge};

use super::{FASTER, Mutant, Outcome, Rung, faster, finished, integrator, scheme, sound, with_rows};
use crate::exact::large_strain::LargeStrain;
use crate::norms::{largest, relative};

/// Without inertia, 30 %.
pub const SPLINES: Rung = Rung {
    name: "large-strain-30",
    about: "consolidation to 30 % strain, B-splines without inertia: settlement, order 2 or more",
    climb: || splines(sound),
    mutant: Some(Mutant { what: FASTER, climb: || splines(faster) }),
};

/// The column whose length ends as a share of its first.
fn column(left: f64) -> Result<Scene, String> {
    let mut base =
        crate::scenes::built_in("terzaghi-large-strain").ok_or("no such scene")?.map_err(|e| e.to_string())?;
    let pressure = -base.oedometer_modulus() * f64::ln(left);
    base.surcharge = base.surcharge.map(|s| Surcharge { pressure, ..s });
    base.history = 0;
    Ok(base)
}

fn splines(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    climb(column(0.7)?, ShapeChoice::Bspline2, 1e-4, fault)
}

fn climb(mut base: Scene, shape: ShapeChoice, required_error: f64, fault: fn(&mut Scene)) -> Result<Outcome, String> {
    base.shape = shape;
    let exact = LargeStrain::new(&base).ok_or("not a column of the tables")?;
    fault(&mut base);
    let error = |s: &Sample| {
        exact.settlement(s.stage_time).map_or(f64::NAN, |settlement| relative(s.state.settlement, settlement))
    };
    let mut notes = Vec::new();
    let on = |rows: &usize| {
        let scene = with_rows(base.clone(), *rows);
        let run = finished(&scene)?;
        let crossings = run.samples.last().map_or(0, |s| s.state.solid_crossings);
        notes.push((format!("{rows} cells: crossings"), crossings as f64, "-".to_owned()));
        Ok((scene.cell, largest(run.observed().map(error))))
    };
    let errors = [10, 20, 40].iter().map(on).collect::<Result<_, String>>()?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error,
        required_order: Some([2.0, 4.0]),
        notes,
        ..Outcome::default()
    })
}

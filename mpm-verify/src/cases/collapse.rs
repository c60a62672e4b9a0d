//! Collapse of granular columns: run-out against the band of published laws. There is no exact solution.
//!
//! Experiments differ by a factor of two and more (reference-data/literature/column_collapse.csv, which says how each law is
//! known), so the error is the distance from the middle of their band in half widths of the band: up to 1 is inside.

use mpm_core::scene::{Fields, Scene, Until};

use super::{Error, Lacks, Mutant, Outcome, Program, integrator, scheme, sound};
use crate::experiment::number::Label;
use crate::experiment::refinement::{MESH, PARTICLES, Refinement};
use crate::experiment::shared::shared;
use crate::literature::{Kind, run_out};
use crate::norms::worst;

/// Dry columns.
pub const DRY: Program = Program {
    name: "collapse-dry",
    about: "run-out of dry columns of aspect ratio 1, 2 and 4 within the scatter of published laws",
    run: || outcome("collapse-dry", &[0.1, 0.05], &[1.0, 2.0, 4.0], Kind::Dry, sound),
    mutant: Some(Mutant {
        what: "friction of 60 degrees",
        run: || outcome("collapse-dry", &[0.1, 0.05], &[1.0, 2.0, 4.0], Kind::Dry, rough),
    }),
};

/// Columns full of water.
pub const SATURATED: Program = Program {
    name: "collapse-saturated",
    about: "run-out of saturated columns in air of aspect ratio 1 and 2 within the scatter of laws for immersed ones",
    run: || outcome("collapse-saturated", &[0.1], &[1.0, 2.0], Kind::Immersed, sound),
    mutant: Some(Mutant {
        what: "friction of 60 degrees",
        run: || outcome("collapse-saturated", &[0.1], &[1.0, 2.0], Kind::Immersed, rough),
    }),
};

fn rough(scene: &mut Fields) {
    if let Some(strength) = &mut scene.strength {
        strength.friction_angle = 60.0;
    }
}

/// Particles per cell: one per cell would leave holes in what has spread.
const COUNTS: [usize; 2] = [4, 9];

/// Wet columns have collapsed after this, s: of the work of gravity less than 1e-4 is motion then.
const WET: f64 = 1.6;

/// A column of an aspect ratio on a mesh (m).
fn column(base: &Scene, aspect: f64, cell: f64) -> Result<Scene, Error> {
    let mut scene = base.edited(|scene| {
        scene.height = aspect * scene.width;
        scene.cell = cell;
        scene.cells = [scene.width, scene.height].map(|length| (length / cell).round() as usize);
        scene.empty_cells_beside = (8.0 / cell).round() as usize;
    })?;
    // Water that goes on to trickle through cells which soil fills by less than `LEAST_FILLING` does work that no ledger knows:
    // with 9 particles per cell the balance of energy ends the run at 2.0 s.
    let end = scene.stages.len() - 1;
    if let (Until::Time(time), true) = (scene.stages[end].until, scene.water.is_some()) {
        scene = scene.edited(|scene| {
            scene.stages[end].until = Until::Time(time.min(WET));
            scene.observe_times.retain(|at| *at < WET);
            scene.observe_times.push(WET.min(time));
        })?;
    }
    Ok(scene)
}

/// Distance from the middle of a band, in half widths of it.
fn in_band(found: f64, (low, high): (f64, f64)) -> f64 {
    (found - 0.5 * (low + high)) / (0.5 * (high - low))
}

fn outcome(name: &str, meshes: &[f64], aspects: &[f64], kind: Kind, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let base = crate::scenes::built_in(name).expect("the built-in scene holds");
    let (mut errors, mut notes) = (Vec::new(), Vec::new());
    for &cell in meshes {
        let mut offs = Vec::new();
        for &aspect in aspects {
            let mut scene = column(&base, aspect, cell)?;
            scene = scene.edited(fault)?;
            let run = shared(&scene)?;
            let last = run.samples.last().ok_or(Lacks("sample"))?;
            let reach = last.state.reach;
            let found = (reach[0] - scene.width) / scene.width;
            let (low, high) = run_out(kind, aspect).ok_or(Lacks("law for this aspect ratio"))?;
            let off = in_band(found, (low, high));
            offs.push(off);
            let of = format!("H_0/L_0 = {aspect}, L = {cell} m");
            let mut note =
                |what: &str, value, unit: &str| notes.push((format!("{what}, {of}"), value, unit.to_owned()));
            note("run-out (L_inf - L_0)/L_0", found, "-");
            note("published, lowest", low, "-");
            note("published, highest", high, "-");
            note("height H_inf/L_0", reach[1] / scene.width, "-");
            note(
                "energy closing over work of gravity",
                last.balance.energy_residual_j / last.balance.gravity_work_j,
                "-",
            );
            note("water closing", last.balance.water_residual_kg, "kg");
        }
        errors.push((cell, worst(offs.into_iter())));
    }
    let fine = meshes[meshes.len() - 1];
    let with = |count: &usize| {
        let mut scene = column(&base, aspects[0], fine)?.edited(|s| s.particles_per_cell = *count)?;
        scene = scene.edited(fault)?;
        let run = shared(&scene)?;
        let reach = run.samples.last().ok_or(Lacks("sample"))?.state.reach[0];
        let band = run_out(kind, aspects[0]).ok_or(Lacks("law for this aspect ratio"))?;
        Ok((*count as f64, in_band((reach - scene.width) / scene.width, band)))
    };
    let counted = COUNTS.iter().map(with).collect::<Result<_, Error>>()?;
    let against = format!("the band of published laws, H_0/L_0 = {}, L = {fine} m", aspects[0]);
    // A place in a band has no order: the finest mesh is judged, the other one shown beside it.
    let finest = errors.last().copied().ok_or(Lacks("mesh"))?;
    let on_meshes = Refinement::new(MESH, errors, "the band of published laws, the ratio that is farthest out");
    let on_counts = Refinement { required_error: Some(1.0), ..Refinement::new(PARTICLES, counted, against) };
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors: vec![finest],
        required_error: 1.0,
        notes,
        refinements: if meshes.len() > 1 { vec![on_meshes, on_counts] } else { vec![on_counts] },
        kind: Label::Regression,
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

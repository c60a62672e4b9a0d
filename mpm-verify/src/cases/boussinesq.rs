//! A tongue of water that wets a dry aquifer on a tight base: its tip against the similarity solution of Boussinesq.

use mpm_core::drive::Run;
use mpm_core::observe::FieldPoint;
use mpm_core::scene::{Fields, Scene};

use super::{Error, FASTER, Lacks, Mutant, Outcome, Program, Unfit, faster, finished, integrator, sound};
use crate::exact::boussinesq::Wetting;
use crate::experiment::comparison::{Compared, Comparison, in_particles};

/// The case.
pub const CASE: Program = Program {
    name: "front-boussinesq",
    about: "tip of the water at lambda sqrt(k H t/n) from 4 H on, to half a cell on every mesh",
    run: || outcome(sound),
    mutant: Some(Mutant { what: FASTER, run: || outcome(faster) }),
};

/// Rows of cells over the height.
const ROWS: [usize; 4] = [5, 10, 15, 20];

fn outcome(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let base = crate::scenes::built_in("boussinesq").expect("the built-in scene holds");
    let water = base.water.ok_or(Unfit("the scene is dry"))?;
    let exact = Wetting::new(water.hydraulic_conductivity, base.porosity, 1.0);
    let (mut errors, mut notes, mut samples) = (Vec::new(), Vec::new(), Vec::new());
    for rows in ROWS {
        let mut scene = base.with_rows(rows)?;
        scene = scene.edited(fault)?;
        let run = finished(&scene)?;
        let tips = tips(&scene, &run, &exact)?;
        errors.push((scene.cell, tips.error().abs()));
        samples = tips.samples();
        for sample in run.observed().filter(|_| rows == ROWS[ROWS.len() - 1]) {
            let Some(state) = sample.state.water else { continue };
            let off = state.mobile_m3 / exact.stored(sample.stage_time) - 1.0;
            let what = format!("stored water over Dupuit's - 1 at x_f = {:.0} m", exact.front(sample.stage_time));
            notes.push((what, off, "-".to_owned()));
        }
    }
    let coarse = base.with_rows(ROWS[0])?;
    let with = |particles_per_cell| {
        let mut scene = coarse.edited(|s| s.particles_per_cell = particles_per_cell)?;
        scene = scene.edited(fault)?;
        tips(&scene, &finished(&scene)?, &exact)
    };
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: "free surface".to_owned(),
        required_error: 0.5 * errors[errors.len() - 1].0,
        errors,
        required_order: Some([0.9, 4.0]),
        required_everywhere: Some(0.5),
        notes,
        samples,
        refinements: vec![in_particles(with, coarse.cell, &[1, 4, 9], 0.5 * coarse.cell)?],
        ..Outcome::default()
    })
}

/// Where the tip stands.
pub(super) fn tips(scene: &Scene, run: &Run, exact: &Wetting) -> Result<Comparison, Error> {
    let mut rows = Vec::new();
    for sample in run.observed() {
        let tip = tip(&levels(scene, &sample.state.field), scene.cell).ok_or(Lacks("tongue of water"))?;
        rows.push(Compared::one(sample.stage_time, tip, exact.front(sample.stage_time)));
    }
    Ok(Comparison { unit: "m", ..Comparison::worst("tip of the water", rows) })
}

/// Height of the water in each column of cells, m.
fn levels(scene: &Scene, field: &[FieldPoint]) -> Vec<f64> {
    let mut levels = vec![0.0; scene.cells[0]];
    for point in field {
        levels[(point.x_m / scene.cell) as usize] += point.saturation * scene.cell;
    }
    levels
}

/// Where the surface of the tongue meets the base, m. The surface is straight there: the flow behind a tip that moves at v is level,
/// and its slope is n v/k. So the line through the levels two and three columns behind the last wet one is carried on.
fn tip(levels: &[f64], cell: f64) -> Option<f64> {
    let last = levels.iter().rposition(|level| *level > 1e-6 * cell)?;
    let (behind, before) = (*levels.get(last.checked_sub(3)?)?, levels[last - 2]);
    let slope = (before - behind) / cell;
    Some((last as f64 - 1.5) * cell - before / slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_tongue_ends_where_its_line_does() {
        let cell = 0.1;
        let levels: Vec<f64> = (0..20).map(|i| (0.2 * (1.23 - (i as f64 + 0.5) * cell)).max(0.0)).collect();
        assert!((tip(&levels, cell).unwrap() - 1.23).abs() < 1e-12);
    }
}

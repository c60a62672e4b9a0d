//! Particles in an outline: clipped by it they have its mass and centre on every mesh; whole squares are off by the mesh.

use mpm_core::run::outline_parts;
use mpm_core::scene::{Scene, SeedingChoice};
use mpm_core::seeding;

use super::{Error, Lacks, Mutant, Outcome, Program, integrator};
use crate::norms::largest;
use crate::rates::fit;

/// The case.
pub const CASE: Program = Program {
    name: "outline-seeding",
    about: "mass and centre of particles clipped by a slope, and of whole squares",
    run: || outcome(SeedingChoice::Clipped),
    mutant: Some(Mutant { what: "whole squares in place of clipped ones", run: mutant }),
};

/// Cells (m) that divide neither height nor slope.
const CELLS: [f64; 6] = [0.7, 0.37, 0.19, 0.093, 0.047, 0.023];

fn outcome(judged: SeedingChoice) -> Result<Outcome, Error> {
    let base = crate::scenes::built_in("slope-at-rest")?;
    let errors = errors(&base, judged)?;
    let whole = self::errors(&base, SeedingChoice::Whole)?;
    let (first, last) = (whole[0].1, whole[whole.len() - 1].1);
    let order = fit(&whole).map_or(f64::NAN, |fit| fit.order);
    // Of all meshes: round-off does not converge.
    let worst = largest(errors.iter().map(|(_, error)| *error));
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: "clipped".to_owned(),
        errors: vec![(CELLS[CELLS.len() - 1], worst)],
        required_error: 1e-12,
        notes: vec![
            ("error of whole squares, coarsest".to_owned(), first, "-".to_owned()),
            ("error of whole squares, finest".to_owned(), last, "-".to_owned()),
            ("order of whole squares".to_owned(), order, "-".to_owned()),
        ],
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

/// (mesh in m, error): the larger of that of the area, relative, and of the centre over the height.
fn errors(base: &Scene, seeding: SeedingChoice) -> Result<Vec<(f64, f64)>, Error> {
    let outline = base.outline.as_ref().ok_or(Lacks("outline"))?;
    let (exact, middle) = (seeding::area(outline), seeding::centroid(outline));
    let on = |cell: f64| {
        let scene = base.edited(|s| {
            s.cell = cell;
            s.seeding = seeding;
        })?;
        let (area, centre) = seeding::total(&outline_parts(&scene).ok_or(Lacks("outline"))?);
        let off = (0..2).map(|d| (centre[d] - middle[d]).abs() / base.height);
        Ok((cell, largest(off.chain([area / exact - 1.0]))))
    };
    CELLS.into_iter().map(on).collect()
}

/// Whole squares in place of clipped ones.
fn mutant() -> Result<Outcome, Error> {
    outcome(SeedingChoice::Whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipped_squares_hold_and_whole_ones_fall_short() {
        let judged = CASE.judged().expect("parts");
        assert!(judged.row.passed(), "{}", judged.reason);
        let spoilt = CASE.mutant_judged().expect("a mutant").expect("parts");
        assert!(!spoilt.row.passed(), "{}", spoilt.reason);
    }
}

//! Consolidation of a soft layer to a strain of 14 %, on a mesh that goes along.
//!
//! At first all strain is within a cell of the drained surface: looks begin at tau = 0.005, 0.07 of the way in depth.

use mpm_core::scene::{Fields, Scene};

use super::super::degree::Degree;
use super::super::{Error, FASTER, Lacks, Mutant, Outcome, Program, Unfit, asked, faster, integrator, scheme, sound};
use crate::exact::oracle::Table;

/// The case.
pub const CASE: Program = Program {
    name: "cc-soft-layer",
    about: "a layer of Cam-Clay that settles by 14 %, without inertia: settlement",
    run: || quasi_static(sound),
    mutant: Some(Mutant { what: FASTER, run: || quasi_static(faster) }),
};

/// Final strain, that of the table.
const WHOLE: f64 = 0.138_633_760_970_038_43;

/// The first observed time that counts.
const FIRST: usize = 2;

/// The scene, and its settlement over its height at a time (s).
fn layer() -> Result<(Scene, impl Fn(f64) -> f64), Error> {
    let scene = crate::scenes::built_in("soft-layer")?;
    let soil = scene.cam_clay.ok_or(Unfit("not Cam-Clay"))?;
    let table = Table::parse(include_str!("../../../../reference-data/exact/13_cam_clay_consolidation.csv"));
    let rows = table.rows(["tau", "S_over_H"]);
    let rate = scene.water.ok_or(Lacks("water"))?.mobility() * soil.attraction / (scene.height * scene.height);
    let height = scene.height;
    let exact = move |time: f64| {
        // Between the rows of the table there is no number.
        let row = rows.iter().find(|row| (row[0] / (rate * time) - 1.0).abs() < 1e-9);
        row.map_or(f64::NAN, |row| row[1] * height)
    };
    Ok((scene, exact))
}

fn quasi_static(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let (mut base, exact) = layer()?;
    base = base.edited(|base| base.history = 0)?;
    let degree = Degree::of_whole(&base, WHOLE * base.height, &exact).from(base.observe_times[FIRST]);
    base = base.edited(fault)?;
    let (errors, samples) = degree.refine(&base, &[10, 14, 20, 28, 40])?;
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        tolerance: asked(&base),
        errors,
        required_error: 5e-4,
        required_order: Some([1.3, 4.0]),
        samples,
        ..Outcome::default()
    })
}

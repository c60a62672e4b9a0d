//! Streamlines that an inclined interface refracts: every face of a cell at the sides bears the exact head there, so that the loads are
//! those of a mesh and no file has them.

use mpm_core::scene::{Bearing, Course, FaceLoad, Fields, Scene, Side, Until};

use super::{Error, Mutant, Outcome, Program, finished, integrator, scheme, sound};
use crate::experiment::measure::heads::{MIDDLE, RATIO, TURNED, refracted_head};
use crate::experiment::spec::Measure;

/// The case.
pub const CASE: Program = Program {
    name: "refraction",
    about: "streamlines at an inclined interface, tan(a)/tan(b) = k1/k2 = 4: heads",
    run: || outcome(sound),
    mutant: Some(Mutant { what: "conductivity of one soil 20 % too high", run: || outcome(faster) }),
};

/// A load on every face at the sides: no more than 64.
const CELLS: [usize; 5] = [6, 8, 12, 14, 16];

fn faster(scene: &mut Fields) {
    scene.regions.iter_mut().for_each(|region| region.soil.hydraulic_conductivity *= 1.2);
}

fn outcome(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let base = crate::scenes::built_in("flow-in-series")?;
    let measure = Measure { of: "heads-refracted".to_owned(), ..Measure::default() };
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for cells in CELLS {
        let scene: Scene = base.with_rows(cells)?.edited(|scene| inclined(scene, cells as f64))?;
        let found = measure.of_scene(&scene)?(&finished(&scene.edited(fault)?)?)?;
        errors.push((scene.cell, found.error()));
        samples = found.samples();
    }
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: 2e-3,
        required_order: Some(1.0),
        samples,
        scene: Some(base.clone()),
        ..Outcome::default()
    })
}

/// The block, its sides under the exact heads, one for each face of a cell.
fn inclined(scene: &mut Fields, cells: f64) {
    (scene.width, scene.cells[0]) = (scene.height, scene.cells[1]);
    scene.observe_times = vec![20.0];
    scene.stages[0].until = Until::Time(20.0);
    let (sin, cos) = TURNED.sin_cos();
    let far = 10.0;
    let corner =
        |along: f64, across: f64| [MIDDLE[0] + across * cos - along * sin, MIDDLE[1] + across * sin + along * cos];
    scene.regions[0].polygon = vec![corner(-far, 0.0), corner(-far, far), corner(far, far), corner(far, 0.0)];
    let first = scene.water.map_or(0.0, |water| water.hydraulic_conductivity);
    scene.regions[0].soil.hydraulic_conductivity = first / RATIO;
    let cell = scene.height / cells;
    let range = |i: usize| [i as f64 * cell, (i + 1) as f64 * cell];
    let middle = |i: usize| (i as f64 + 0.5) * cell;
    let face = |on: Side, i: usize| {
        let upright = matches!(on, Side::Left | Side::Right);
        let place = match on {
            Side::Left => [0.0, middle(i)],
            Side::Right => [scene.width, middle(i)],
            Side::Bottom => [middle(i), 0.0],
            Side::Top => [middle(i), scene.height],
        };
        let (x, y) = if upright { (None, Some(range(i))) } else { (Some(range(i)), None) };
        FaceLoad {
            on: Some(on),
            x,
            y,
            bearing: Bearing::Reservoir,
            course: Course::Times(vec![[0.0, refracted_head(place)]]),
        }
    };
    let [columns, rows] = scene.cells;
    let sides = [(Side::Left, rows), (Side::Right, rows), (Side::Bottom, columns), (Side::Top, columns)];
    scene.loads =
        sides.into_iter().flat_map(|(on, count)| (0..count).map(move |i| (on, i))).map(|(on, i)| face(on, i)).collect();
}

//! A flexible strip of load on dry elastic soil: stresses below it as a sum of cosines.

use mpm_core::scene::{Fields, Scene, ShapeChoice};

use super::super::{Lacks, sound};
use super::*;
use crate::exact::strip::StripLoad;

const STRESS: Case = Case {
    scene: "strip-on-sand",
    change: sound,
    mesh: refined,
    measure: stress,
    cells: &[8.0, 16.0, 24.0, 32.0],
    required: 3e-4,
    order: Some([1.8, 2.3]),
};

/// All of them.
pub const CASES: [Rung; 2] = [
    case!(
        "strip-stress",
        "stress under a strip of load on elastic soil, B-splines: order 2",
        "load 2 % too large",
        heavier,
        STRESS
    ),
    case!(
        "strip-stress-centre",
        "the same with centre values: order 1, one stress in a cell",
        "load 2 % too large",
        heavier,
        Case { change: centre, required: 6e-3, order: Some([0.9, 1.1]), ..STRESS }
    ),
];

fn centre(scene: &mut Fields) {
    (scene.shape, scene.particles_per_cell) = (ShapeChoice::Centre, 4);
}

fn heavier(scene: &mut Fields) {
    if let Some(load) = &mut scene.surcharge {
        load.pressure *= 1.02;
    }
}

/// Mean stress at every particle over the load: root of the mean square.
fn stress(scene: &Scene) -> Measured {
    let exact = StripLoad::dry(scene).ok_or(Lacks("strip on dry soil"))?;
    let load = scene.surcharge.map_or(f64::NAN, |load| load.pressure);
    Ok(Box::new(move |run| {
        let square = |p: &[f64; 3]| ((p[2] + exact.pressure(p[0], p[1])) / load).powi(2);
        let places = &run.places.solid;
        (places.iter().map(square).sum::<f64>() / places.len() as f64).sqrt()
    }))
}

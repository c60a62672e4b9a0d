//! A flexible strip or disc of load on dry elastic soil: stresses below it, and how far the soil settles under it.

use mpm_core::scene::{Dimension, Fields, Scene, ShapeChoice};

use super::super::{Lacks, sound};
use super::*;
use crate::exact::settlement::Settlement;
use crate::exact::strip::StripLoad;

const STRESS: Setup = Setup {
    scene: "strip-on-sand",
    change: sound,
    mesh: refined,
    measure: stress,
    cells: &[8.0, 16.0, 24.0, 32.0],
    required: 3e-4,
    order: Some([1.8, 2.3]),
};
/// Settlement under the load, as the energy that the soil stores.
const SETTLEMENT: Setup =
    Setup { measure: settlement, cells: &[4.0, 8.0, 12.0, 16.0], required: 5e-4, order: FOURTH, ..STRESS };
/// Energies converge with the square of stresses.
const FOURTH: Option<[f64; 2]> = Some([3.5, 5.0]);

/// All of them.
pub const CASES: [Case; 4] = [
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
        Setup { change: centre, required: 6e-3, order: Some([0.9, 1.1]), ..STRESS }
    ),
    case!(
        "strip-settlement",
        "settlement under a strip of load on an elastic layer, B-splines",
        "load 2 % too large",
        heavier,
        SETTLEMENT
    ),
    case!(
        "disc-settlement",
        "settlement under a disc of load about an axis, as Boussinesq found it, on a layer",
        "load 2 % too large",
        heavier,
        Setup { change: about_axis, ..SETTLEMENT }
    ),
];

fn about_axis(scene: &mut Fields) {
    scene.dimension = Dimension::Axisymmetric;
}

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

/// Settlement on average under the load over the exact one: twice what is stored over the load.
fn settlement(scene: &Scene) -> Measured {
    let exact = Settlement::of(scene).ok_or(Lacks("strip on dry soil"))?;
    Ok(Box::new(move |run| {
        run.samples.last().map_or(f64::NAN, |end| (end.balance.strain_j / exact.energy() - 1.0).abs())
    }))
}

//! Affine velocities give the nodes a linear field.

use pulp::Scalar;

use super::*;
use crate::boundary::{FaceLoads, Filled, SurfaceLoad};
use crate::constitutive::{LinearElastic, Material, Materials};
use crate::grid::Grid;
use crate::observe::Seed;
use crate::particles::even_positions;
use crate::scene::{Elastic, LoadOn};
use crate::step::kernel::{Basis, Bspline, Functions, Gimp, LINEAR, Over, Vectorised};

/// A number in [-1, 1] without system.
fn noise(i: usize) -> f64 {
    (12.9898 * (i as f64 + 1.0)).sin() * 43758.5453 % 1.0
}

/// A linear field of velocities, m/s, and its gradient, 1/s.
fn linear(x: [f64; 2]) -> [f64; 2] {
    [1.0 + 2.0 * x[0] - 3.0 * x[1], -2.0 + 3.0 * x[0] + 0.5 * x[1]]
}
const GRADIENT: [f64; 4] = [2.0, -3.0, 3.0, 0.5];

/// Largest difference of the velocities of the nodes from a linear field (m/s) that the particles have, which have moved in 3 x 3
/// cells of 0.5 m. `mapped` asks for those mapped back; `stands` says where a function stands, in cells.
fn off_linear<F: Functions<2>>(functions: F, affine: bool, mapped: bool, stands: impl Fn(usize) -> f64) -> f64 {
    let grid = Grid::new([3, 3], 0.5);
    let points = even_positions([3, 3], 2).enumerate().map(|(i, x)| {
        let x = [0.5 * (x[0] + 0.2 * noise(i)), 0.5 * (x[1] + 0.2 * noise(7 * i))];
        SolidPoint { x, v: linear(x), stress: [0.0; 4], mass: 1.0, volume: 0.0625 }
    });
    let law = LinearElastic::new(&Elastic { youngs_modulus: 1.0, poisson_ratio: 0.3 });
    let body = Body {
        solid: Layer::new(points.collect(), &grid).expect("inside"),
        grid,
        water: None,
        materials: Materials::one(Material::Elastic(law), 1.0 / 2700.0),
        surface: SurfaceLoad::new(Vec::new(), 0.0, LoadOn::Surface),
        filled: Filled::default(),
        surcharge: None,
        loads: FaceLoads::default(),
        gravity: None,
        flip: 1.0,
        apart: 0.0,
        null_space: None,
        contiguous: false,
        most_crossings: u64::MAX,
        period: None,
        seed: Seed { per_row: 6, spacing: 0.25, heights: Vec::new() },
        first_settlement: 0.0,
    };
    let mut run =
        Explicit::new((Box::new(Vectorised { simd: Scalar, functions }), None), body, Vec::new(), (affine, mapped));
    run.body = run.whole();
    run.kept.1 = GRADIENT.repeat(run.kept.1.len() / 4);
    run.settle_in();
    run.equation_of_motion(0.0).expect("motion");
    run.map_back();
    let velocity = run.mapped.as_ref().map_or(&run.nodes.motion, |mapped| &mapped.motion).velocity.clone();
    let frame = run.nodes.frame;
    let mut worst = 0.0_f64;
    for node in (0..frame.count()).filter(|node| run.nodes.sum(SOLID_MASS, *node) > 0.0) {
        let expected = linear(frame.position(node).map(|i| 0.5 * stands(i - frame.before)));
        (0..2).for_each(|d| worst = worst.max((velocity[d][node] - expected[d]).abs()));
    }
    worst
}

#[test]
fn affine_velocities_give_nodes_a_linear_field() {
    let node = |i: usize| i as f64;
    let spline = |i: usize| Bspline::<2>.stands_at(i, 3);
    let cubic = |i: usize| Bspline::<3>.stands_at(i, 3);
    let off = [
        off_linear(LINEAR, true, false, node),
        off_linear(LINEAR, true, true, node),
        off_linear(Over(Gimp::new(2)), true, true, node),
        off_linear(Over(Bspline::<2>), true, false, spline),
        off_linear(Over(Bspline::<2>), true, true, spline),
        off_linear(Over(Bspline::<3>), true, true, cubic),
    ];
    assert!(off.iter().all(|off| *off < 1e-12), "{off:?}");
    assert!(off_linear(LINEAR, false, false, node) > 0.1);
    assert!(off_linear(Over(Bspline::<2>), false, true, spline) > 0.1);
}

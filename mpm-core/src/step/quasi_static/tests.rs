//! The matrix of a step against finite differences of what it is the derivative of.

use super::newton::{Stage as Balance, Workspace, largest};
use super::soil::{HELD, Soil};
use super::tangent::Stuck;
use super::{QuasiStatic, Seeding};
use crate::constitutive::{Law, LinearElastic, Materials, MohrCoulomb};
use crate::particles::{SolidPoint, even_positions};
use crate::scene::{
    Dimension, Elastic, Integrator, LoadedStrip, Scene, ShapeChoice, SolidSide, Stage, Start, StrainChoice, Strength,
    Surcharge, Until, Waves,
};
use crate::step::Model;

const SOIL: Elastic = Elastic { youngs_modulus: 2.0e7, poisson_ratio: 0.3 };

fn scene(dimension: Dimension, shape: ShapeChoice, strain: StrainChoice) -> Scene {
    let text = include_str!("../../../../reference-data/scenes/terzaghi.toml");
    let scene = Scene::parse(text, "terzaghi.toml").expect("the default scene");
    // One side free in a column, to have a term for every side.
    scene.altered_unchecked(|scene| {
        (scene.dimension, scene.shape, scene.strain) = (dimension, shape, strain);
        (scene.integrator, scene.particles_per_cell) = (Integrator::QuasiStatic, 9);
        (scene.cell, scene.height, scene.width) = (0.25, 1.0, 0.75);
        scene.cells = if dimension == Dimension::Column { [1, 4] } else { [3, 4] };
        scene.solid_sides[1] = SolidSide::Free;
        scene.gravity = Some(9.81);
        scene.jump_penalty = Some(1e-3);
    })
}

fn entered<L: Law, const D: usize>(scene: &Scene, law: L) -> QuasiStatic<L, D> {
    let cells = std::array::from_fn(|d| if d == D - 1 { 4 } else { 3 });
    let along = scene.particles_per_direction();
    let thickness = if D == 1 { scene.width } else { 1.0 };
    let volume = thickness * (scene.cell / along as f64).powi(D as i32);
    let mut stress = [0.0; 4];
    stress[1] = -3e3;
    let point = |x: [f64; D]| SolidPoint {
        x: x.map(|x| x * scene.cell),
        v: [0.0; D],
        stress,
        mass: scene.dry_density() * volume,
        volume,
    };
    let points: Vec<_> = even_positions(cells, along).map(point).collect();
    let mut model = QuasiStatic::new(
        scene,
        Seeding {
            points,
            law: Materials::one(law, 1.0 / scene.grain_density),
            top: Vec::new(),
            thickness,
            first_pressure: |_, [_, height]| 1e3 * height,
            first_settlement: 0.0,
        },
    );
    let stage = Stage {
        name: String::new(),
        drained: [false, false, false, true],
        solid_sides: None,
        damping: 0.0,
        coupling: crate::scene::Coupling::default(),
        until: Until::Time(1.0),
    };
    model.enter_stage(&stage, &[1.0]).expect("a stage");
    model
}

/// Forces, then minus the water content with `a` times the flow, in the scale of the matrix.
fn residual<L: Law, const D: usize>(soil: &mut Soil<L, D>, y: &[f64], a: f64) -> Vec<f64> {
    soil.evaluate(y).expect("a sound state");
    let mut out = vec![0.0; y.len()];
    for (function, map) in soil.soil_map.iter().enumerate() {
        for d in 0..D {
            if map[d] != HELD {
                out[map[d] as usize] += soil.scales[0] * soil.values.force[function * D + d];
            }
        }
    }
    for (function, map) in soil.water_map.iter().enumerate() {
        if *map != HELD {
            let sum = soil.values.content[function] + a * soil.values.flow[function];
            out[*map as usize] -= soil.scales[1] * sum;
        }
    }
    out
}

/// The largest difference between a column of the matrix and a finite difference, as a share of its largest entry.
fn departure<L: Law, const D: usize>(model: &mut QuasiStatic<L, D>, size: f64) -> f64 {
    let soil = model.soil.as_mut().expect("a mesh");
    let a = 2e-3;
    let y: Vec<f64> = (0..soil.unknowns()).map(|i| size * (1.7 * i as f64).sin()).collect();
    if let Some(motion) = &mut soil.motion {
        motion.flux.iter_mut().flatten().for_each(|flux| *flux = 1e-3);
        motion.damping = 30.0;
        motion.begin(&[], a);
    }
    residual(soil, &y, a);
    soil.refresh(a).expect("factors");
    let (mut worst, mut product) = (0.0_f64, vec![0.0; y.len()]);
    for unknown in 0..y.len() {
        let step = 1e-6;
        let moved = |sign: f64| {
            let mut moved = y.clone();
            moved[unknown] += sign * step;
            moved
        };
        let (up, down) = (residual(soil, &moved(1.0), a), residual(soil, &moved(-1.0), a));
        let mut unit = vec![0.0; y.len()];
        unit[unknown] = 1.0;
        soil.system.matrix.multiply(&unit, &mut product);
        let largest = product.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        for i in 0..y.len() {
            worst = worst.max(((up[i] - down[i]) / (2.0 * step) - product[i]).abs() / largest);
        }
    }
    worst
}

#[test]
fn the_matrix_is_the_derivative_of_the_balances() {
    let splines = [ShapeChoice::Bspline2, ShapeChoice::Bspline3];
    for shape in [ShapeChoice::Centre, ShapeChoice::Linear, ShapeChoice::Gimp].into_iter().chain(splines) {
        for strain in [StrainChoice::Small, StrainChoice::Large] {
            // At large strain what is left out is of the order of the strain.
            let allowed = if strain == StrainChoice::Small { 1e-7 } else { 2e-2 };
            let one = scene(Dimension::Column, shape, strain);
            let column = departure(&mut entered::<_, 1>(&one, LinearElastic::new(&SOIL)), 1e-3);
            let two = scene(Dimension::PlaneStrain, shape, strain);
            let plane = departure(&mut entered::<_, 2>(&two, LinearElastic::new(&SOIL)), 1e-3);
            assert!(column < allowed && plane < allowed, "{shape:?} {strain:?} {column:.1e} {plane:.1e}");
        }
    }
}

#[test]
fn the_matrix_is_the_derivative_with_few_particles_and_with_inertia() {
    let water = [(true, true), (true, false), (false, false)];
    for shape in [ShapeChoice::Bspline2, ShapeChoice::Bspline3] {
        for (strain, allowed) in [(StrainChoice::Small, 1e-7), (StrainChoice::Large, 2e-2)] {
            for (ppc, inertia) in water.into_iter().map(|water| (9, Some(water))).chain([(4, None)]) {
                let of = |dimension| {
                    scene(dimension, shape, strain).altered_unchecked(|scene| {
                        scene.particles_per_cell = ppc;
                        if let Some((inertia, relative)) = inertia {
                            scene.integrator = Integrator::Implicit;
                            (scene.darcy_inertia, scene.relative_acceleration) = (inertia, relative);
                        }
                    })
                };
                let column = departure(&mut entered::<_, 1>(&of(Dimension::Column), LinearElastic::new(&SOIL)), 1e-3);
                let plane =
                    departure(&mut entered::<_, 2>(&of(Dimension::PlaneStrain), LinearElastic::new(&SOIL)), 1e-3);
                assert!(
                    column < allowed && plane < allowed,
                    "{shape:?} {strain:?} {ppc} {inertia:?} {column:.1e} {plane:.1e}"
                );
            }
        }
    }
}

#[test]
fn a_new_mesh_moves_and_damps_as_the_one_before() {
    let scene = scene(Dimension::PlaneStrain, ShapeChoice::Bspline2, StrainChoice::Large).altered_unchecked(|scene| {
        (scene.integrator, scene.relative_acceleration) = (Integrator::Implicit, true);
        scene.observe_times = vec![1.0];
        scene.waves = Waves::Damped;
    });
    let mut model = entered::<_, 2>(&scene, LinearElastic::new(&SOIL));
    model.damping = 30.0;
    let (free, moving) = {
        let soil = model.soil.as_mut().expect("a mesh");
        let free: Vec<bool> = soil.soil_map.iter().map(|map| map[1] != HELD).collect();
        let motion = soil.motion.as_mut().expect("inertia");
        for (i, v) in motion.velocity.iter_mut().enumerate().filter(|(i, _)| free[*i]) {
            *v = [0.0, (0.7 * i as f64).sin()];
        }
        (free, motion.velocity.clone())
    };
    model.build([false, false, false, true]).expect("a mesh");
    let motion = model.soil.as_ref().and_then(|soil| soil.motion.as_ref()).expect("inertia");
    assert!(motion.damping == 30.0 && !motion.resolves && !motion.viscosity.is_empty());
    let apart = motion.velocity.iter().zip(&moving).zip(&free).filter(|(_, free)| **free);
    let apart = apart.map(|((a, b), _)| (a[1] - b[1]).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-9, "{apart:e}");
}

/// Residuals of Newton's iteration for a strip load on soil that yields beneath it: down to round-off, as none meets a tolerance of
/// zero.
fn residuals_of_yielding(dilation_angle: f64) -> Vec<f64> {
    let scene = scene(Dimension::PlaneStrain, ShapeChoice::Centre, StrainChoice::Small);
    let scene = scene.edited(|scene| {
        (scene.water, scene.gravity, scene.start) = (None, None, Start::Unloaded);
        (scene.darcy_inertia, scene.jump_penalty) = (false, None);
        scene.stages.iter_mut().for_each(|stage| stage.drained = [false; 4]);
        scene.solid_sides[1] = SolidSide::Roller;
        let strip = Some(LoadedStrip { from: 0.0, to: 0.25, taper: 0.0 });
        scene.surcharge = scene.surcharge.map(|load| Surcharge { strip, ..load });
    });
    let scene = scene.expect("a sound scene");
    let load = scene.surcharge.expect("a load");
    let strength = Strength {
        cohesion: 0.2 * load.pressure,
        friction_angle: 20.0,
        dilation_angle,
        tension_cutoff: None,
        dilation_fades_over: None,
    };
    let mut model = entered::<_, 2>(&scene, MohrCoulomb::new(&SOIL, &strength));
    model.points.iter_mut().for_each(|point| point.stress = [0.0; 4]);
    model.build([false; 4]).expect("a mesh");
    let soil = model.soil.as_mut().expect("a mesh");
    soil.bear(1.0, 0.0);
    let mut y = vec![0.0; soil.unknowns()];
    let mut work = Workspace::new(y.len(), soil.scales[0] * largest(&soil.load));
    soil.evaluate(&y).expect("a sound state");
    soil.refresh(0.0).expect("factors");
    let balance = Balance { a: 0.0, target: &[], tolerance: 0.0 };
    match soil.fulfil(&balance, &mut y, &mut work) {
        Err(Stuck::NotConverged(residuals)) => residuals,
        other => panic!("{other:?}"),
    }
}

/// Whether residuals fall quadratically down to round-off: r' <= 10 r^2 in the last three iterations.
fn fall_quadratically(residuals: &[f64]) -> bool {
    let round_off = 1e-12;
    let Some(end) = residuals.iter().position(|r| *r < round_off) else { return false };
    residuals[..=end].windows(2).rev().take(3).all(|pair| pair[1] <= (10.0 * pair[0] * pair[0]).max(round_off))
}

#[test]
fn newtons_iteration_converges_quadratically_where_soil_yields() {
    for dilation_angle in [20.0, 0.0] {
        let residuals = residuals_of_yielding(dilation_angle);
        assert!(fall_quadratically(&residuals), "{residuals:?}");
    }
    // Each a hundredth of the one before.
    assert!(!fall_quadratically(&std::array::from_fn::<_, 8, _>(|k| 1e-2_f64.powi(k as i32))));
}

#[test]
fn the_check_of_the_matrix_can_fail() {
    let scene = scene(Dimension::PlaneStrain, ShapeChoice::Bspline2, StrainChoice::Small);
    let mut model = entered::<_, 2>(&scene, LinearElastic::new(&SOIL));
    let soil = model.soil.as_mut().expect("a mesh");
    let a = 2e-3;
    // Balances with a penalty, a matrix without.
    let jumps = soil.jumps.clone();
    let y = vec![1e-3; soil.unknowns()];
    soil.jumps.clear();
    residual(soil, &y, a);
    soil.refresh(a).expect("factors");
    let without = soil.system.matrix.clone();
    soil.jumps = jumps;
    soil.refresh(a).expect("factors");
    assert!(difference(&without.values, &soil.system.matrix.values) > 1e-7);
    // A soil that is a ten-thousandth stiffer than its matrix.
    let kept = soil.system.matrix.clone();
    let stiffer = Elastic { youngs_modulus: 1.0001 * SOIL.youngs_modulus, ..SOIL };
    soil.law = Materials::one(LinearElastic::new(&stiffer), 1.0 / 2700.0);
    soil.refresh(a).expect("factors");
    assert!(difference(&kept.values, &soil.system.matrix.values) > 1e-7);
}

/// The largest difference as a share of the largest value.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

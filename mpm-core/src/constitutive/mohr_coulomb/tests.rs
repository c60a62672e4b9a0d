//! Returns against an enumeration of all sets of planes, tangents against differences, and properties that hold on any path.

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use super::*;

const SOIL: Elastic = Elastic { youngs_modulus: 2.0e7, poisson_ratio: 0.3 };

fn strength(cohesion: f64, friction_angle: f64, dilation_angle: f64, tension_cutoff: Option<f64>) -> Strength {
    Strength { cohesion, friction_angle, dilation_angle, tension_cutoff, dilation_fades_over: None }
}

/// Planes a.s <= k with flow along b, of all orders of the principal stresses.
fn planes(s: &Surface) -> Vec<([f64; 3], [f64; 3], f64)> {
    let mut planes = Vec::new();
    for high in 0..3 {
        for low in (0..3).filter(|low| *low != high) {
            let (mut a, mut b) = ([0.0; 3], [0.0; 3]);
            (a[high], a[low]) = (s.normal[0], -s.normal[1]);
            (b[high], b[low]) = (s.along[0], s.along[1]);
            planes.push((a, b, s.strength));
        }
        if s.soil.cutoff.is_finite() {
            let mut a = [0.0; 3];
            a[high] = 1.0;
            planes.push((a, a, s.soil.cutoff));
        }
    }
    planes
}

/// Every stress that a trial stress may be returned to: all sets of up to three planes, non-negative multipliers, no
/// plane violated.
fn enumerated(surface: &Surface, trial: &[f64; 3]) -> Vec<[f64; 3]> {
    let planes = planes(surface);
    let tolerance = 1e-10 * (surface.strength + trial.iter().fold(0.0_f64, |most, s| most.max(s.abs())));
    let push = |b: &[f64; 3]| -> [f64; 3] {
        let volumetric = surface.soil.lame * b.iter().sum::<f64>();
        b.map(|b| volumetric + 2.0 * surface.soil.shear * b)
    };
    let dot = |a: &[f64; 3], b: &[f64; 3]| -> f64 { (0..3).map(|i| a[i] * b[i]).sum() };
    let inside = |s: &[f64; 3]| planes.iter().all(|(a, _, k)| dot(a, s) - k <= tolerance);
    let mut found: Vec<[f64; 3]> = Some(*trial).filter(inside).into_iter().collect();
    let count = planes.len();
    for set in (1u32..1 << count).filter(|set| set.count_ones() <= 3) {
        let active: Vec<usize> = (0..count).filter(|i| set & (1 << i) != 0).collect();
        let n = active.len();
        let matrix = DMatrix::from_fn(n, n, |i, j| dot(&planes[active[i]].0, &push(&planes[active[j]].1)));
        let over = DVector::from_fn(n, |i, _| dot(&planes[active[i]].0, trial) - planes[active[i]].2);
        let Some(gamma) = matrix.clone().lu().solve(&over) else { continue };
        let off = (matrix * &gamma - &over).amax();
        if gamma.iter().any(|g| *g < 0.0 || !g.is_finite()) || off > tolerance {
            continue;
        }
        let mut stress = *trial;
        for (plane, gamma) in active.iter().zip(gamma.iter()) {
            let push = push(&planes[*plane].1);
            for i in 0..3 {
                stress[i] -= gamma * push[i];
            }
        }
        if inside(&stress) {
            found.push(stress);
        }
    }
    found
}

fn largest(stress: &[f64]) -> f64 {
    stress.iter().fold(0.0, |most, s| most.max(s.abs()))
}

fn any_strength() -> impl Strategy<Value = Strength> {
    let cohesion = prop_oneof![Just(0.0), 100.0..2000.0];
    let friction = prop_oneof![Just(30.0), 1.0..60.0];
    let dilation = prop_oneof![Just(0.0), Just(1.0), 0.0..1.0];
    let cutoff = prop_oneof![Just(None), Just(Some(0.0)), Just(Some(1.0)), (0.0..1.0_f64).prop_map(Some)];
    (cohesion, friction, dilation, cutoff).prop_map(|(c, phi, part, cutoff)| {
        let whole = Strength {
            cohesion: c,
            friction_angle: phi,
            dilation_angle: part * phi,
            tension_cutoff: None,
            dilation_fades_over: None,
        };
        Strength { tension_cutoff: cutoff.map(|part| (part * whole.apex()).min(whole.apex())), ..whole }
    })
}

/// Principal stresses, often two or three of them equal.
fn any_trial() -> impl Strategy<Value = [f64; 3]> {
    let size = prop_oneof![1.0e2..1.0e5];
    (size, prop::array::uniform3(-1.0..1.0), 0..6, -1.0..1.0).prop_map(
        |(size, mut s, equal, mean): (f64, [f64; 3], i32, f64)| {
            match equal {
                0 => s[1] = s[0],
                1 => s[1] = s[2],
                2 => s = [s[0]; 3],
                _ => {}
            }
            s.sort_by(|a, b| b.total_cmp(a));
            s.map(|s| size * (s + mean))
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_return_is_that_of_the_active_planes(
        strength in any_strength(),
        trial in any_trial(),
        poisson_ratio in prop_oneof![Just(0.3), Just(0.0), -0.9..0.49],
    ) {
        let surface = Surface::new(&Elastic { poisson_ratio, ..SOIL }, &strength);
        let (region, found) = surface.back(&trial);
        let all = enumerated(&surface, &trial);
        let scale = largest(&trial) + surface.strength;
        // Without dilation nothing returns from beyond the apex: the one region that is a convention.
        prop_assert!(!all.is_empty() || (region == Region::Apex && strength.dilation_angle == 0.0), "{region:?} {found:?}");
        if region != Region::Apex || strength.dilation_angle > 0.0 {
            let off = |one: &[f64; 3]| (0..3).map(|i| (one[i] - found[i]).abs()).fold(0.0, f64::max);
            let least = all.iter().map(off).fold(f64::INFINITY, f64::min);
            prop_assert!(least <= 1e-8 * scale, "{region:?}: {found:?} is none of {all:?}");
        }
    }

    #[test]
    fn no_path_leaves_the_surface(
        strength in any_strength(),
        path in prop::collection::vec((prop::array::uniform4(-1.0..1.0), 1e-6..1e-2), 1..30),
    ) {
        // 1e-9 of the cohesion; 1e-9 of the scale that stands for it without one.
        let law = MohrCoulomb::new(&SOIL, &strength);
        let (mut stress, mut column) = ([0.0; 4], [0.0; 4]);
        for (strain, size) in path {
            let strain: [f64; 4] = strain.map(|e: f64| e * size);
            let flows = [
                (law.update(&mut stress, &strain, &mut [0.0]), law.yield_residual(&stress, &[0.0]), largest(&stress)),
                (law.update(&mut column, &[0.0, strain[1], 0.0, 0.0], &mut [0.0]), law.yield_residual(&column, &[0.0]), largest(&column)),
            ];
            for (flow, residual, size) in flows {
                prop_assert_eq!(flow.residual, residual);
                let round_off = 1e-15 * size * law.surface.excess_per_stress();
                prop_assert!(residual <= 1e-9 + round_off, "{residual:e} at {size:e} Pa");
                if strength.dilation_angle == strength.friction_angle {
                    let trial = size + 2.0 * SOIL.youngs_modulus * largest(&strain);
                    prop_assert!(flow.dissipation >= -1e-14 * trial * trial / SOIL.youngs_modulus, "{flow:?}");
                }
            }
        }
    }

    #[test]
    fn axes_do_not_matter(strength in any_strength(), trial in any_trial(), angle in 0.0..3.2, zz in 0..3usize) {
        let law = MohrCoulomb::new(&SOIL, &strength);
        let (_, found) = law.surface.back(&trial);
        let turned = |s: &[f64; 3]| {
            let [a, b] = [s[(zz + 1) % 3], s[(zz + 2) % 3]];
            let (centre, half, twice): (f64, f64, f64) = (0.5 * (a + b), 0.5 * (a - b), 2.0 * angle);
            [centre + half * twice.cos(), centre - half * twice.cos(), s[zz], half * twice.sin()]
        };
        let mut stress = turned(&trial);
        law.update(&mut stress, &[0.0; 4], &mut [0.0]);
        let expected = turned(&found);
        let scale = largest(&trial) + law.surface.strength;
        for i in 0..4 {
            prop_assert!((stress[i] - expected[i]).abs() < 1e-9 * scale, "{stress:?} {expected:?}");
        }
    }
}

#[test]
fn every_region_is_reached_and_has_its_tangent() {
    let mut seen = std::collections::HashMap::new();
    let mut random = crate::random::Random(1);
    let mut number = || random.unit() * 2.0 - 1.0;
    for (dilation, cutoff) in [(0.0, None), (30.0, None), (0.0, Some(300.0)), (10.0, Some(0.0)), (30.0, Some(500.0))] {
        let law = MohrCoulomb::new(&SOIL, &strength(500.0, 30.0, dilation, cutoff));
        for try_ in 0..4000 {
            let mean = 2e3 * number();
            let mut stress = [mean, mean, mean, 0.0];
            law.update(&mut stress, &[number() * 1e-5; 4], &mut [0.0]);
            // Some start with two equal stresses and strain them alike.
            let mut strain = [(); 4].map(|()| 3e-4 * number());
            if try_ % 4 == 0 {
                strain[2] = strain[1];
                strain[3] = 1e-9 * number();
            }
            let region = law.region(&stress, &strain);
            let near = |h: f64| {
                (0..4).any(|j| {
                    let mut to = strain;
                    to[j] += h;
                    law.region(&stress, &to) != region
                })
            };
            // No difference across the edge of a region.
            if near(1e-7) || near(-1e-7) {
                continue;
            }
            check_tangent!(law, stress, strain, SOIL.youngs_modulus);
            *seen.entry(region).or_insert(0) += 1;
        }
    }
    println!("{seen:?}");
    assert_eq!(seen.len(), 11, "{seen:?}");
}

#[test]
fn inside_it_is_the_elastic_law() {
    let law = MohrCoulomb::new(&SOIL, &strength(500.0, 30.0, 0.0, Some(100.0)));
    check_law!(law, [-3e-5, 1e-6, 0.0, 2e-6]);
    let (mut ours, mut theirs) = ([-1e3, -2e3, -1.5e3, 100.0], [-1e3, -2e3, -1.5e3, 100.0]);
    let strain = [1e-6, -2e-6, 0.0, 3e-6];
    assert!(law.update(&mut ours, &strain, &mut [0.0]).residual < 0.0);
    LinearElastic::new(&SOIL).hooke(&mut theirs, &strain);
    assert_eq!(ours, theirs);
}

/// Between an associated flow with Davis' strength and the planes of the scene the strength in simple shear is always Davis'.
#[test]
fn strength_in_simple_shear_is_constant_while_dilation_fades() {
    for (phi, psi) in [(30.0, 0.0), (40.0, 10.0), (20.0, 20.0), (0.0, 0.0)] {
        let soil = Strength { dilation_fades_over: Some(0.1), ..strength(700.0, phi, psi, None) };
        let (fading, davis) = (Fading::of(&soil).expect("it fades"), soil.reduced(1.0, crate::scene::Reduction::Davis));
        let tangent = davis.friction_angle.to_radians().tan();
        for slip in [0.0, 0.03, 0.1, 0.5] {
            let planes = fading.planes(slip);
            let (v, sin) = (planes.dilation, planes.sin);
            let share = (1.0 - v * v).sqrt() / (1.0 - sin * v);
            assert!((share * sin - tangent).abs() < 1e-14, "{planes:?}");
            assert!((0.5 * planes.strength * share - davis.cohesion).abs() < 1e-11, "{planes:?}");
            let one = MohrCoulomb::new(&SOIL, &soil).surface(&[slip]);
            assert!(phi == 0.0 || (one.strength / (2.0 * sin) - soil.apex()).abs() < 1e-9 * soil.apex(), "{planes:?}");
        }
        let (first, last) = (fading.planes(0.0), fading.planes(0.1));
        assert!((first.dilation - first.sin).abs() < 1e-15, "{first:?}");
        assert!(
            (last.dilation - psi.to_radians().sin()).abs() < 1e-15 && (last.sin - phi.to_radians().sin()).abs() < 1e-15
        );
    }
}

#[test]
fn comparison_with_the_enumeration_can_fail() {
    let (own, other) = (strength(500.0, 30.0, 0.0, None), strength(500.0, 30.0, 1.0, None));
    let trial = [1e3, -2e3, -1e4];
    let (_, found) = Surface::new(&SOIL, &own).back(&trial);
    let all = enumerated(&Surface::new(&SOIL, &other), &trial);
    assert!(all.iter().all(|one| (one[2] - found[2]).abs() > 1e-3 * largest(&trial)));
}

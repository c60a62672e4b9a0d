//! Guards the transfer between particles and mesh: the fast moments of the basis against plain loops over N_i.

use mpm_core::dimension::{self, basis, coefficients, gradient, to_corners, value};
use mpm_core::grid::Grid;
use proptest::array::{uniform2, uniform4};
use proptest::prelude::*;

/// Round-off of a sum of a few terms, relative to the sum of their sizes.
const ROUND_OFF: f64 = 1e-14;
/// 1/L in 1/m.
const INVERSE_SIZE: f64 = 10.0;

/// N_a at a point: bit d of the corner number says at which end of axis d it stands.
fn shape<const D: usize>(a: usize, xi: &[f64; D]) -> f64 {
    (0..D).map(|d| if a >> d & 1 == 1 { xi[d] } else { 1.0 - xi[d] }).product()
}

/// dN_a/dx_j at a point.
fn slope<const D: usize>(a: usize, j: usize, xi: &[f64; D]) -> f64 {
    let across: f64 = (0..D).filter(|&d| d != j).map(|d| if a >> d & 1 == 1 { xi[d] } else { 1.0 - xi[d] }).product();
    across * INVERSE_SIZE * if a >> j & 1 == 1 { 1.0 } else { -1.0 }
}

fn close(a: f64, b: f64, size: f64) -> bool {
    (a - b).abs() <= ROUND_OFF * size
}

/// The first D coordinates of a point.
fn first<const D: usize>(point: &[f64; 2]) -> [f64; D] {
    std::array::from_fn(|d| point[d])
}

fn coordinates() -> impl Strategy<Value = [f64; 2]> {
    uniform2(0.0..1.0)
}

/// A particle: place in the cell, mass (kg), velocity (m/s).
fn particle() -> impl Strategy<Value = ([f64; 2], f64, [f64; 2])> {
    (coordinates(), 0.1..10.0, uniform2(-5.0..5.0))
}

fn partition_of_unity<const D: usize>(point: &[f64; 2]) {
    let xi = first::<D>(point);
    let n = to_corners::<D, 1, _>(&basis(&xi).map(|phi| [phi]));
    let mut sum = 0.0;
    for a in 0..Grid::<D>::CORNERS {
        assert!(close(n[a][0], shape(a, &xi), 1.0), "N_{a} = {} at {xi:?}", n[a][0]);
        sum += n[a][0];
    }
    assert!(close(sum, 1.0, 1.0), "sum N = {sum} at {xi:?}");
    for j in 0..D {
        let slopes: f64 = (0..Grid::<D>::CORNERS).map(|a| slope(a, j, &xi)).sum();
        assert!(close(slopes, 0.0, 4.0 * INVERSE_SIZE), "sum dN/dx_{j} = {slopes} at {xi:?}");
    }
}

fn constant_field<const D: usize>(point: &[f64; 2], velocity: &[f64; 2]) {
    let xi = first::<D>(point);
    let k = coefficients::<D, D, _>(&[first::<D>(velocity); 4]);
    // Exactly: a uniform velocity must never strain the soil.
    assert_eq!(gradient(&k, &xi, INVERSE_SIZE), [[0.0; D]; D]);
    assert_eq!(value::<D, D, _>(&k, &basis(&xi)), first::<D>(velocity));
}

fn mass_and_momentum<const D: usize>(particles: &[([f64; 2], f64, [f64; 2])]) {
    let (mut mass, mut momentum) = ([[0.0]; 4], [[0.0; D]; 4]);
    let (mut plain_mass, mut plain_momentum) = ([0.0; 4], [[0.0; D]; 4]);
    let (mut total, mut totals) = (0.0, [0.0; D]);
    for (point, m, v) in particles {
        let xi = first::<D>(point);
        let phi = basis(&xi);
        total += m;
        for k in 0..4 {
            mass[k][0] += m * phi[k];
        }
        for d in 0..D {
            totals[d] += m * v[d];
            for k in 0..4 {
                momentum[k][d] += m * v[d] * phi[k];
            }
        }
        for a in 0..Grid::<D>::CORNERS {
            plain_mass[a] += m * shape(a, &xi);
            for d in 0..D {
                plain_momentum[a][d] += m * v[d] * shape(a, &xi);
            }
        }
    }
    let (mass, momentum) = (to_corners::<D, 1, _>(&mass), to_corners::<D, D, _>(&momentum));
    let size = 5.0 * total;
    for a in 0..Grid::<D>::CORNERS {
        assert!(close(mass[a][0], plain_mass[a], total));
        for d in 0..D {
            assert!(close(momentum[a][d], plain_momentum[a][d], size));
        }
    }
    assert!(close(mass.iter().map(|m| m[0]).sum(), total, total));
    for d in 0..D {
        assert!(close(momentum.iter().map(|p| p[d]).sum(), totals[d], size));
    }
}

/// v_i = a_i + b_ij x_j, x in m from the first corner of the cell.
fn linear_field<const D: usize>(point: &[f64; 2], a: &[f64; 2], b: &[[f64; 2]; 2]) {
    let at = |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|i| a[i] + (0..D).map(|j| b[i][j] * x[j] / INVERSE_SIZE).sum::<f64>())
    };
    let corner = |c: usize| -> [f64; D] { at(&std::array::from_fn(|d| (c >> d & 1) as f64)) };
    let k = coefficients::<D, D, _>(&std::array::from_fn(corner));
    let xi = first::<D>(point);
    let (v, g) = (value::<D, D, _>(&k, &basis(&xi)), gradient(&k, &xi, INVERSE_SIZE));
    for i in 0..D {
        assert!(close(v[i], at(&xi)[i], 20.0), "v = {v:?} at {xi:?}");
        for j in 0..D {
            assert!(close(g[i][j], b[i][j], 20.0 * INVERSE_SIZE), "gradient {g:?}, expected {b:?}");
        }
    }
}

/// (T u) . m = u . (T^t m)
fn transpose<const D: usize>(nodal: &[[f64; 1]; 4], moments: &[[f64; 1]; 4]) {
    let dot =
        |a: &[[f64; 1]; 4], b: &[[f64; 1]; 4]| -> f64 { (0..Grid::<D>::CORNERS).map(|k| a[k][0] * b[k][0]).sum() };
    let there = dot(&coefficients::<D, 1, _>(nodal), moments);
    let back = dot(nodal, &to_corners::<D, 1, _>(moments));
    assert!(close(there, back, 16.0 * 25.0), "{there} {back}");
}

/// f_ai = sum_p V sigma_ij dN_a/dx_j, against the loop; its sum over the corners vanishes.
fn internal_force<const D: usize>(particles: &[([f64; 2], f64, [f64; 4])], tensor: fn(&[f64; 4]) -> [[f64; D]; D]) {
    let (mut mean, mut moments) = ([0.0; 4], [[0.0; 4]; D]);
    let (mut plain, mut size) = ([[0.0; D]; 4], 0.0);
    for (point, volume, stress) in particles {
        let xi = first::<D>(point);
        for s in 0..4 {
            mean[s] += volume * stress[s];
            for d in 0..D {
                moments[d][s] += volume * stress[s] * xi[d];
            }
            size += 4.0 * INVERSE_SIZE * volume * stress[s].abs();
        }
        for a in 0..Grid::<D>::CORNERS {
            for i in 0..D {
                for j in 0..D {
                    plain[a][i] += volume * tensor(stress)[i][j] * slope(a, j, &xi);
                }
            }
        }
    }
    let force = to_corners::<D, D, _>(&dimension::internal_force(&mean, &moments, INVERSE_SIZE));
    for i in 0..D {
        for a in 0..Grid::<D>::CORNERS {
            assert!(close(force[a][i], plain[a][i], size), "{force:?} {plain:?}");
        }
        assert!(close(force.iter().map(|f| f[i]).sum(), 0.0, size), "{force:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn shape_functions_sum_to_one(point in coordinates()) {
        partition_of_unity::<1>(&point);
        partition_of_unity::<2>(&point);
    }

    #[test]
    fn a_constant_field_has_no_gradient(point in coordinates(), velocity in uniform2(-5.0..5.0)) {
        constant_field::<1>(&point, &velocity);
        constant_field::<2>(&point, &velocity);
    }

    #[test]
    fn mass_and_momentum_arrive_whole(particles in prop::collection::vec(particle(), 1..20)) {
        mass_and_momentum::<1>(&particles);
        mass_and_momentum::<2>(&particles);
    }

    #[test]
    fn linear_fields_are_exact(point in coordinates(), a in uniform2(-5.0..5.0), b in uniform2(uniform2(-50.0..50.0))) {
        linear_field::<1>(&point, &a, &b);
        linear_field::<2>(&point, &a, &b);
    }

    #[test]
    fn to_corners_is_the_transpose_of_coefficients(
        nodal in uniform4(-5.0..5.0),
        moments in uniform4(-5.0..5.0),
    ) {
        transpose::<1>(&nodal.map(|u| [u]), &moments.map(|m| [m]));
        transpose::<2>(&nodal.map(|u| [u]), &moments.map(|m| [m]));
    }

    #[test]
    fn stress_becomes_the_plain_nodal_force(
        particles in prop::collection::vec((coordinates(), 0.1..10.0, uniform4(-100.0..100.0)), 1..20),
    ) {
        internal_force::<1>(&particles, |s| [[s[1]]]);
        internal_force::<2>(&particles, |s| [[s[0], s[3]], [s[3], s[1]]]);
    }
}

#[test]
fn the_round_off_check_can_fail() {
    assert!(close(1.0, 1.0 + 1e-15, 1.0));
    assert!(!close(1.0, 1.0 + 1e-13, 1.0));
    // A corner left out of the sum, or two corners swapped, is far above round-off.
    let n = to_corners::<2, 1, _>(&basis(&[0.2, 0.7]).map(|phi| [phi]));
    assert!(!close(n[0][0] + n[1][0] + n[2][0], 1.0, 1.0));
    assert!(!close(n[1][0], shape(2, &[0.2, 0.7]), 1.0));
}

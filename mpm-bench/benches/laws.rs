//! Constitutive laws: one particle after the other, and as many at once as the machine has lanes.
//!
//! criterion prints time per update of one particle. Stresses stay in the first-level cache; a strain increment goes to
//! and fro, so that nothing grows. A return starts from the same trial stress every time, so that it ends in its region.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mpm_core::constitutive::{Law, LinearElastic, MohrCoulomb, Region};
use mpm_core::real::{Real, SimdReal};
use mpm_core::scene::{Elastic, Strength};
use pulp::{Arch, Simd, WithSimd};

/// Particles: a multiple of the lanes of any machine.
const PARTICLES: usize = 512;
const SOIL: Elastic = Elastic { youngs_modulus: 1.0e7, poisson_ratio: 0.3 };

/// Updates all stresses, vectorised. Stresses stand component by component.
struct OverLanes<'a, L> {
    law: &'a L,
    stress: &'a mut [Vec<f64>; 4],
    strain: [f64; 4],
}

impl<L: Law> WithSimd for OverLanes<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, simd: V) {
        let strain = self.strain.map(|e| SimdReal::splat(simd, e));
        for first in (0..PARTICLES).step_by(V::F64_LANES) {
            let mut stress = std::array::from_fn(|s| SimdReal::load(simd, &self.stress[s][first..]));
            let there = strain[0].like(0.0).below(strain[0].like(1.0));
            self.law.update_lanes(&mut stress, &strain, &mut [strain[0]], there);
            for s in 0..4 {
                stress[s].store(&mut self.stress[s][first..]);
            }
        }
    }
}

fn law<L: Law>(c: &mut Criterion, name: &str, law: L, strain: [f64; 4]) {
    let mut group = c.benchmark_group(name);
    group.sample_size(20);
    group.throughput(Throughput::Elements(2 * PARTICLES as u64));
    group.bench_function(BenchmarkId::from_parameter("one at a time"), |b| {
        let mut stress = [[0.0; 4]; PARTICLES];
        b.iter(|| {
            for sign in [1.0, -1.0] {
                let strain = black_box(strain.map(|e| sign * e));
                stress.iter_mut().for_each(|stress| {
                    law.update(black_box(stress), &strain, &mut [0.0]);
                });
            }
        });
    });
    group.bench_function(BenchmarkId::from_parameter("lanes"), |b| {
        let mut stress = [(); 4].map(|()| vec![0.0; PARTICLES]);
        let arch = Arch::new();
        b.iter(|| {
            for sign in [1.0, -1.0] {
                let strain = black_box(strain.map(|e| sign * e));
                arch.dispatch(OverLanes { law: &law, stress: black_box(&mut stress), strain });
            }
        });
    });
    group.finish();
}

fn laws(c: &mut Criterion) {
    law(c, "linear elastic", LinearElastic::new(&SOIL), [-1e-5, 2e-6, 0.0, 5e-6]);
}

const STRENGTH: Strength = Strength {
    cohesion: 500.0,
    friction_angle: 30.0,
    dilation_angle: 10.0,
    tension_cutoff: Some(400.0),
    dilation_fades_over: None,
};

/// Updates copies of the same stresses, vectorised, and books the flow as a step does.
struct Returns<'a, L> {
    law: &'a L,
    trial: [f64; 4],
    stress: &'a mut [Vec<f64>; 4],
}

impl<L: Law> WithSimd for Returns<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, simd: V) {
        let none = SimdReal::splat(simd, 0.0);
        let there = none.below(SimdReal::splat(simd, 1.0));
        for first in (0..PARTICLES).step_by(V::F64_LANES) {
            let mut stress = self.trial.map(|s| SimdReal::splat(simd, s));
            black_box(self.law.update_lanes(&mut stress, &[none; 4], &mut [none], there).dissipation.value);
            for s in 0..4 {
                stress[s].store(&mut self.stress[s][first..]);
            }
        }
    }
}

fn returns(c: &mut Criterion, region: Region, principal: [f64; 3]) {
    let law = MohrCoulomb::new(&SOIL, &STRENGTH);
    let [a, zz, b] = principal;
    // The axes stand at 30 degrees.
    let (centre, half) = (0.5 * (a + b), 0.5 * (a - b));
    let trial = [centre + 0.5 * half, centre - 0.5 * half, zz, 0.75_f64.sqrt() * half];
    assert_eq!(law.region(&trial, &[0.0; 4]), region);
    let mut group = c.benchmark_group(format!("Mohr-Coulomb, plane strain, {region:?}"));
    group.sample_size(20);
    group.throughput(Throughput::Elements(PARTICLES as u64));
    group.bench_function(BenchmarkId::from_parameter("one at a time"), |b| {
        let mut stress = [[0.0; 4]; PARTICLES];
        b.iter(|| {
            let trial = black_box(trial);
            for stress in &mut stress {
                *stress = trial;
                black_box(law.update(stress, &[0.0; 4], &mut [0.0]));
            }
        });
    });
    group.bench_function(BenchmarkId::from_parameter("lanes"), |b| {
        let mut stress = [(); 4].map(|()| vec![0.0; PARTICLES]);
        let arch = Arch::new();
        b.iter(|| arch.dispatch(Returns { law: &law, trial: black_box(trial), stress: black_box(&mut stress) }));
    });
    group.finish();
}

fn mohr_coulomb(c: &mut Criterion) {
    let strong = Strength { cohesion: 1.0e6, ..STRENGTH };
    law(c, "Mohr-Coulomb inside", MohrCoulomb::new(&SOIL, &strong), [-1e-5, 2e-6, 0.0, 5e-6]);
    returns(c, Region::Face, [-1.0e3, -6.0e3, -1.0e4]);
    returns(c, Region::CompressionEdge, [-1.0e3, -1.1e3, -1.0e4]);
    returns(c, Region::ExtensionEdge, [-1.0e3, -9.9e3, -1.0e4]);
    returns(c, Region::Tension, [6.0e2, 0.0, -1.0e2]);
    returns(c, Region::TensionCorner, [2.0e3, 1.9e3, 1.8e3]);
    returns(c, Region::Seam, [2.0e3, -1.5e3, -4.0e3]);
}

criterion_group!(benches, laws, mohr_coulomb);
criterion_main!(benches);

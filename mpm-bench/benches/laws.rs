//! Constitutive laws: one particle after the other, and as many at once as the machine has lanes.
//!
//! criterion prints time per update of one particle. Stresses stay in the first-level cache; a strain increment goes to
//! and fro, so that nothing grows.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mpm_core::constitutive::{Law, LinearElastic};
use mpm_core::real::Lanes;
use mpm_core::scene::Elastic;
use pulp::{Arch, Simd, WithSimd};

/// Particles: a multiple of the lanes of any machine.
const PARTICLES: usize = 512;
const SOIL: Elastic = Elastic { youngs_modulus: 1.0e7, poisson_ratio: 0.3 };

/// Updates all stresses over lanes. Stresses stand component by component.
struct OverLanes<'a, L, const S: usize> {
    law: &'a L,
    stress: &'a mut [Vec<f64>; S],
    strain: [f64; S],
}

impl<L: Law<S>, const S: usize> WithSimd for OverLanes<'_, L, S> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, simd: V) {
        let strain = self.strain.map(|e| Lanes::splat(simd, e));
        for first in (0..PARTICLES).step_by(V::F64_LANES) {
            let mut stress = std::array::from_fn(|s| Lanes::load(simd, &self.stress[s][first..]));
            self.law.update_lanes(&mut stress, &strain);
            for s in 0..S {
                stress[s].store(&mut self.stress[s][first..]);
            }
        }
    }
}

fn law<L: Law<S>, const S: usize>(c: &mut Criterion, name: &str, law: L, strain: [f64; S]) {
    let mut group = c.benchmark_group(name);
    group.sample_size(20);
    group.throughput(Throughput::Elements(2 * PARTICLES as u64));
    group.bench_function(BenchmarkId::from_parameter("one at a time"), |b| {
        let mut stress = [[0.0; S]; PARTICLES];
        b.iter(|| {
            for sign in [1.0, -1.0] {
                let strain = black_box(strain.map(|e| sign * e));
                stress.iter_mut().for_each(|stress| law.update(black_box(stress), &strain));
            }
        });
    });
    group.bench_function(BenchmarkId::from_parameter("lanes"), |b| {
        let mut stress = [(); S].map(|()| vec![0.0; PARTICLES]);
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
    law(c, "linear elastic, column", LinearElastic::column(&SOIL), [-1e-5, 0.0]);
    law(c, "linear elastic, plane strain", LinearElastic::plane_strain(&SOIL), [-1e-5, 2e-6, 0.0, 5e-6]);
}

criterion_group!(benches, laws);
criterion_main!(benches);

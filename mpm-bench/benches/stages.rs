//! Every stage of the explicit step by itself, at 1e4 points of plane strain with water: one number at a
//! time and vectorised.
//!
//! With a step of no time nothing moves, so a stage may be done again and again. criterion prints time per solid particle
//! with its water particle. The kernel goes over its particles once per step; the stage in which they only
//! give to the mesh comes after a change of cells alone.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mpm_bench::block;
use mpm_core::hardware::{Hardware, Width};
use mpm_core::run::model_on;

fn stages(c: &mut Criterion) {
    let scene = block([50, 50]).expect("a sound scene");
    for (kernel, width) in [("one at a time", Width::One), ("vectorised", Width::Widest)] {
        let mut model = model_on(&Hardware::plain(width), &scene).expect("a model");
        model.enter_stage(&scene.stages[0], &[]).expect("a stage");
        let mut group = c.benchmark_group(format!("stages, {kernel}"));
        group.sample_size(20);
        group.throughput(Throughput::Elements(model.solid_count() as u64));
        for (stage, name) in model.stages().iter().enumerate() {
            group.bench_function(BenchmarkId::from_parameter(name), |b| b.iter(|| model.do_stage(stage, 0.0)));
        }
        group.finish();
    }
}

criterion_group!(benches, stages);
criterion_main!(benches);

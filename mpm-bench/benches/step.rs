//! Whole explicit steps: each path at 1000 points, plane strain with water from 1e3 to 1e6 points.
//!
//! criterion prints time per element; an element is one solid particle, with its water particle, and one step.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mpm_bench::{block, paths};
use mpm_core::run::model;
use mpm_core::scene::Scene;
use mpm_core::stability::choose_step;

fn step(c: &mut Criterion, group: &str, name: &str, scene: &Scene) {
    let dt = choose_step(scene).expect("a stable step");
    let mut model = model(scene).expect("a model");
    model.enter_stage(&scene.stages[0], &[]).expect("a stage");
    let steps = (20_000 / model.solid_count()).max(1) as u64;
    let mut group = c.benchmark_group(group);
    group.sample_size(20);
    group.throughput(Throughput::Elements(steps * model.solid_count() as u64));
    group.bench_function(BenchmarkId::from_parameter(name), |b| {
        b.iter(|| model.advance(dt, steps, &mut 0).expect("steps"));
    });
    group.finish();
}

fn by_path(c: &mut Criterion) {
    for (name, scene) in paths() {
        step(c, "path", name, &scene);
    }
}

fn by_size(c: &mut Criterion) {
    for cells in [[5, 50], [50, 50], [250, 100], [500, 500]] {
        let points = 4 * cells[0] * cells[1];
        step(c, "points", &points.to_string(), &block(cells));
    }
}

criterion_group!(benches, by_path, by_size);
criterion_main!(benches);

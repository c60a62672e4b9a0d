//! Whole explicit steps: each path at 1000 points; plane strain with water from 1e3 to 1e6 points with one thread, two
//! threads and by the plain kernel.
//!
//! criterion prints time per element; an element is one solid particle, with its water particle, and one step. The
//! program `mpm-bench` measures the second part with more care and draws it.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mpm_bench::{block, paths};
use mpm_core::hardware::{Hardware, Width};
use mpm_core::run::model_on;
use mpm_core::scene::Scene;
use mpm_core::stability::choose_step;

fn step(c: &mut Criterion, group: &str, name: &str, scene: &Scene, hardware: &Hardware) {
    let dt = choose_step(scene).expect("a stable step");
    let mut model = model_on(hardware, scene).expect("a model");
    model.enter_stage(&scene.stages[0], &[]).expect("a stage");
    let steps = (20_000 / model.solid_count()).max(1) as u64;
    let mut group = c.benchmark_group(group);
    group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(3));
    group.throughput(Throughput::Elements(steps * model.solid_count() as u64));
    group.bench_function(BenchmarkId::from_parameter(name), |b| {
        b.iter(|| model.advance(dt, steps, &mut 0).expect("steps"));
    });
    group.finish();
}

fn by_path(c: &mut Criterion) {
    for (name, scene) in paths().expect("sound scenes") {
        step(c, "path", name, &scene, &Hardware::default());
    }
}

fn by_size(c: &mut Criterion) {
    let hardware = [
        ("one thread", Hardware::default()),
        ("two threads", Hardware::threads(2).expect("two threads")),
        ("plain kernel", Hardware::plain(Width::One)),
    ];
    for cells in [[5, 50], [50, 50], [250, 100], [500, 500]] {
        let points = 4 * cells[0] * cells[1];
        for (name, hardware) in &hardware {
            step(c, &format!("{points} points"), name, &block(cells).expect("a sound scene"), hardware);
        }
    }
}

criterion_group!(benches, by_path, by_size);
criterion_main!(benches);

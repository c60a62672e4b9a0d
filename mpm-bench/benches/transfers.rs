//! Particles to mesh and back for each kind of shape functions, at 1e4 points of plane strain with water: what a wider stencil
//! costs, one number at a time and vectorised.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mpm_bench::block;
use mpm_core::hardware::{Hardware, Width};
use mpm_core::run::model_on;
use mpm_core::scene::ShapeChoice;

fn transfers(c: &mut Criterion) {
    let shapes = [
        ("centre", ShapeChoice::Centre),
        ("linear", ShapeChoice::Linear),
        ("gimp", ShapeChoice::Gimp),
        ("bspline2", ShapeChoice::Bspline2),
    ];
    for (name, shape) in shapes {
        let scene = block([50, 50]).expect("a sound scene").edited(|scene| scene.shape = shape).expect("a sound scene");
        let mut group = c.benchmark_group(format!("transfers, {name}"));
        group.sample_size(20);
        for (kernel, width) in [("", Width::One), (", vectorised", Width::Widest)] {
            let mut model = model_on(&Hardware::plain(width), &scene).expect("a model");
            model.enter_stage(&scene.stages[0], &[]).expect("a stage");
            group.throughput(Throughput::Elements(model.solid_count() as u64));
            let transfers =
                model.stages().iter().enumerate().filter(|(_, s)| s.contains("to mesh") || s.contains("to particles"));
            for (stage, what) in transfers {
                let id = BenchmarkId::from_parameter(format!("{what}{kernel}"));
                group.bench_function(id, |b| b.iter(|| model.do_stage(stage, 0.0)));
            }
        }
        group.finish();
    }
}

criterion_group!(benches, transfers);
criterion_main!(benches);

//! Whole quasi-static solves, set-up included: the study's column for an error of 2e-4 and of 2e-5, the same by steps,
//! and Mandel's problem.
//!
//! The errors that belong to the settings are asserted before anything is timed.

use criterion::{Criterion, criterion_group, criterion_main};
use mpm_core::run::run;
use mpm_core::scene::{Scene, TimeMethod};
use mpm_verify::exact::terzaghi::Terzaghi;
use mpm_verify::scenes::built_in;

/// The study's column on so many cells, to a tolerance in time.
fn column(rows: usize, tolerance: f64, method: TimeMethod) -> Scene {
    let scene = built_in("terzaghi-quasi-static").expect("a sound scene");
    scene
        .edited(|s| {
            s.cell = scene.height / rows as f64;
            s.cells = [1, rows];
            s.tolerance = tolerance;
            s.method = method;
            s.history = 0;
        })
        .expect("a sound scene")
}

/// Largest error of U against compressible water.
fn error(scene: &Scene) -> f64 {
    let exact = Terzaghi::compressible(scene).expect("a column");
    let run = run(scene, &mut |_| {}).expect("a start");
    let errors = run.observed().map(|s| (s.state.settlement / exact.settlement(s.stage_time) - 1.0).abs());
    errors.fold(0.0, f64::max)
}

fn solve(c: &mut Criterion) {
    let settings = [
        ("column, error 2e-4", column(8, 1e-3, TimeMethod::Auto), 2e-4),
        ("column, error 2e-5", column(10, 1e-4, TimeMethod::Auto), 2e-5),
        ("column by steps, error 2e-4", column(8, 1e-3, TimeMethod::Sdirk), 2e-4),
    ];
    let mut group = c.benchmark_group("solve");
    for (name, scene, allowed) in settings {
        let found = error(&scene);
        assert!(found <= allowed, "{name}: {found:.1e}");
        group.bench_function(name, |b| b.iter(|| run(&scene, &mut |_| {})));
    }
    let mandel = built_in("mandel").expect("a sound scene");
    group.bench_function("Mandel, 8 cells per side", |b| b.iter(|| run(&mandel, &mut |_| {})));
    group.finish();
}

criterion_group!(benches, solve);
criterion_main!(benches);

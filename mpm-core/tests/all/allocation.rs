//! Guards memory: a step allocates nothing, and a soil point takes what the scene reader counts with.
#![allow(unsafe_code)] // an allocator can only be counted by implementing one

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use crate::common::scene;
use mpm_core::run::model;
use mpm_core::scene::Scene;
use mpm_core::stability::stable_limit;

/// The system's allocator, counting what each thread asks of it.
struct Counting;

thread_local! {
    static CALLS: Cell<u64> = const { Cell::new(0) };
    static BYTES: Cell<usize> = const { Cell::new(0) };
}

/// Notes one call; a thread that is ending has no counters any more.
fn note(more: usize, less: usize) {
    let _ = CALLS.try_with(|calls| calls.set(calls.get() + u64::from(more > 0)));
    let _ = BYTES.try_with(|bytes| bytes.set(bytes.get().wrapping_add(more).wrapping_sub(less)));
}

// SAFETY: every call is passed on unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size(), 0);
        // SAFETY: the caller's promises are those that the system's allocator asks for.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        note(0, layout.size());
        // SAFETY: as above.
        unsafe { System.dealloc(place, layout) }
    }
    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size, layout.size());
        // SAFETY: as above.
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Calls of the allocator after a first step until a time (s), and how many particles changed their cell.
fn calls(scene: &Scene, time: f64) -> (u64, u64) {
    let mut model = model(scene).expect("a model");
    let stage = &scene.stages[0];
    model.enter_stage(stage, &[]).expect("a stage");
    let dt = 0.9 * stable_limit(scene);
    let mut done = 0;
    model.advance(dt, 1, &mut done).expect("a first step");
    let before = CALLS.get();
    let outcome = model.advance(dt, (time / dt) as u64, &mut done);
    let calls = CALLS.get() - before;
    assert!(outcome.is_ok(), "{outcome:?}");
    assert!(done > 1000, "{done} steps");
    let state = model.observe().0;
    (calls, state.solid_crossings + state.water_crossings)
}

#[test]
fn a_step_allocates_nothing() {
    for dimension in ["column", "plane-strain"] {
        for on in ["surface", "particles"] {
            for darcy in ["face", "nodal"] {
                let wet = scene(&[
                    &format!("dimension = \"{dimension}\""),
                    &format!("on = \"{on}\""),
                    &format!("darcy = \"{darcy}\""),
                ]);
                assert_eq!(calls(&wet, 1.5e-3).0, 0, "{dimension} {on} {darcy}");
            }
            let dry = scene(&[
                &format!("dimension = \"{dimension}\""),
                &format!("on = \"{on}\""),
                "-[water]",
                "-darcy",
                "-darcy_inertia",
                "start = \"unloaded\"",
                "drained -> damping = 10.0",
                "until.time_factor -> until.time = 1.0",
                "-time_factors",
            ]);
            assert_eq!(calls(&dry, 0.5).0, 0, "{dimension} {on} dry");
        }
    }
}

#[test]
fn a_step_over_stencils_allocates_nothing() {
    for dimension in ["column", "plane-strain"] {
        for shape in ["centre", "linear", "gimp", "bspline2"] {
            for integrator in ["explicit", "semi-implicit"] {
                let wet = scene(&[
                    &format!("dimension = \"{dimension}\""),
                    &format!("integrator = \"{integrator}\""),
                    &format!("shape = \"{shape}\""),
                ]);
                let time = 1100.0 * 0.9 * stable_limit(&wet);
                assert_eq!(calls(&wet, time).0, 0, "{dimension} {integrator} {shape}");
            }
        }
    }
}

#[test]
fn a_quasi_static_step_allocates_nothing() {
    for dimension in ["column", "plane-strain"] {
        for shape in ["linear", "bspline2"] {
            for strain in ["small", "large"] {
                let scene = scene(&[
                    &format!("dimension = \"{dimension}\""),
                    "integrator = \"quasi-static\"",
                    &format!("shape = \"{shape}\""),
                    &format!("porosity -> porosity = 0.30\nstrain = \"{strain}\""),
                    "step = 1e-3",
                    "cell = 0.05",
                    "particles_per_cell = 9",
                    "-safety",
                    "-flip",
                    "-darcy_inertia",
                ]);
                let mut model = model(&scene).expect("a model");
                model.enter_stage(&scene.stages[0], &[1.0]).expect("a stage");
                let mut done = 0;
                model.advance(0.01, 1, &mut done).expect("first steps");
                let before = CALLS.get();
                model.advance(0.1, 1, &mut done).expect("steps");
                assert_eq!((CALLS.get() - before, done), (0, 110), "{dimension} {shape} {strain}");
            }
        }
    }
}

#[test]
fn crossing_cells_allocates_nothing() {
    for dimension in ["column", "plane-strain"] {
        for darcy in ["face", "nodal"] {
            // A heavy load: water leaves the top, and particles of both layers change their cells.
            let scene = scene(&[
                &format!("dimension = \"{dimension}\""),
                &format!("darcy = \"{darcy}\""),
                "pressure = 1.5e6",
                "cell = 0.05",
                "particles_per_cell = 49",
                "darcy_inertia = false",
            ]);
            let (calls, crossings) = calls(&scene, 8.0e-3);
            println!("{dimension} {darcy}: {crossings} crossings");
            assert!(crossings > 0);
            assert_eq!(calls, 0, "{dimension} {darcy}");
        }
    }
}

/// Bytes per soil point: as the model counts them, and as they were asked of the allocator.
fn bytes_per_point(per_cell: usize, darcy: &str) -> [f64; 2] {
    let scene = scene(&[
        "dimension = \"plane-strain\"",
        "width = 1.0",
        &format!("particles_per_cell = {per_cell}"),
        &format!("darcy = \"{darcy}\""),
    ]);
    let before = BYTES.get();
    let mut model = model(&scene).expect("a model");
    model.enter_stage(&scene.stages[0], &[]).expect("a stage");
    model.advance(1e-7, 1, &mut 0).expect("a step");
    let held = BYTES.get().wrapping_sub(before);
    [model.bytes(), held].map(|bytes| bytes as f64 / model.solid_count() as f64)
}

#[test]
fn a_soil_point_takes_less_than_300_bytes() {
    for per_cell in [4, 9] {
        for darcy in ["face", "nodal"] {
            let [counted, held] = bytes_per_point(per_cell, darcy);
            println!("{per_cell} per cell, {darcy}: {counted:.0} bytes counted, {held:.0} held");
            if per_cell == 1 {
                continue;
            }
            assert!(held < 300.0, "{per_cell} per cell, {darcy}: {held:.0} bytes per point");
            assert!((held / counted - 1.0).abs() < 0.05, "{per_cell} per cell, {darcy}: {counted:.0} {held:.0}");
        }
    }
}

#[test]
fn allocation_check_can_fail() {
    let before = (CALLS.get(), BYTES.get());
    let list = vec![0_u8; 1000];
    assert_eq!(CALLS.get() - before.0, 1);
    assert_eq!(BYTES.get().wrapping_sub(before.1), list.capacity());
    drop(list);
    assert_eq!(BYTES.get(), before.1);
}

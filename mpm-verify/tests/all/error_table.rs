//! Guards the error table of the study: regression values as strings, `{:.3e}`.

use mpm_core::scene::{Integrator, LoadOn, ShapeChoice};
use mpm_verify::progress::Progress;
use mpm_verify::study::{CaseResult, Family, Plan, SHAPES, TOLERANCE};

fn table(results: &[CaseResult]) -> String {
    with_digits(results, 3)
}

fn with_digits(results: &[CaseResult], digits: usize) -> String {
    let mut lines = vec!["case | Terzaghi | late | compressible | late | profile | crossings".to_owned()];
    for r in results {
        assert_eq!(r.failure, None, "{}", r.case);
        let errors = [
            r.max_error_terzaghi,
            r.late_error_terzaghi,
            r.max_error_compressible,
            r.late_error_compressible,
            r.profile_error_compressible,
        ];
        let errors = errors.map(|e| format!("{e:.digits$e}")).join(" | ");
        lines.push(format!("{} | {errors} | {}", r.case, r.cell_crossings));
    }
    lines.join("\n")
}

fn plan(meshes: &[f64]) -> Plan {
    Plan {
        base: mpm_verify::scenes::terzaghi(),
        families: vec![Family::whole(Integrator::Explicit, ShapeChoice::Centre)],
        meshes: meshes.to_vec(),
        particles_per_cell: vec![1, 4, 9],
        loads: vec![LoadOn::Particles, LoadOn::Surface],
        tolerance: TOLERANCE,
        budget: false,
        jobs: 2,
    }
}

#[test]
fn the_error_table_has_not_moved() {
    let results = plan(&[0.1, 0.05]).run(&Progress::new("", true)).expect("a study");
    insta::with_settings!({ description => "Guards the errors of the study. Regression: against ourselves, not truth." }, {
        insta::assert_snapshot!("errors", table(&results));
    });
}

#[test]
fn the_required_accuracy_is_reached_at_two_centimetres() {
    let mut plan = plan(&[0.02]);
    (plan.loads, plan.particles_per_cell) = (vec![LoadOn::Surface], vec![4]);
    for result in plan.run(&Progress::new("", true)).expect("a study") {
        assert!(result.max_error_compressible <= 3e-3, "{}: {:.3e}", result.case, result.max_error_compressible);
    }
}

/// Every scheme of two integrators on two meshes with the load on the surface; the time of quasi-static runs is exact.
fn others(integrator: Integrator) -> Vec<CaseResult> {
    let plan = Plan {
        families: Family::of(Some(&[integrator]), Some(&SHAPES)),
        particles_per_cell: vec![4, 9],
        loads: vec![LoadOn::Surface],
        tolerance: 1e-9,
        ..plan(&[0.1, 0.05])
    };
    plan.run(&Progress::new("", true)).expect("a study")
}

#[test]
fn the_errors_of_semi_implicit_runs_have_not_moved() {
    let results = others(Integrator::SemiImplicit);
    insta::with_settings!({ description => "Guards the errors of the semi-implicit integrator. Regression: against ourselves, not truth." }, {
        insta::assert_snapshot!("semi_implicit", table(&results));
    });
}

#[test]
fn the_errors_of_quasi_static_runs_have_not_moved() {
    let results = others(Integrator::QuasiStatic);
    // Two digits: errors of 1e-7 are differences of numbers that linear solves leave uncertain.
    insta::with_settings!({ description => "Guards the errors of the quasi-static integrator. Regression: against ourselves, not truth." }, {
        insta::assert_snapshot!("quasi_static", with_digits(&results, 1));
    });
}

#[test]
fn ten_quadratic_cells_are_enough() {
    let results = others(Integrator::QuasiStatic);
    let spline = |mesh: f64| {
        let own = |r: &&CaseResult| r.scheme == "bspline2" && r.ppc == 9 && r.mesh_m == mesh;
        results.iter().find(own).expect("a run").max_error_compressible
    };
    let [coarse, fine] = [0.1, 0.05].map(spline);
    assert!(coarse <= 1e-5 && fine <= 0.25 * coarse, "{coarse:.3e} {fine:.3e}");
}

#[test]
fn the_table_check_can_fail() {
    let mut plan = plan(&[0.1]);
    let as_it_is = table(&plan.run(&Progress::new("", true)).expect("a study"));
    // The times stay: they are no time factors any more.
    let other = plan.base.edited(|scene| {
        if let Some(water) = &mut scene.water {
            water.hydraulic_conductivity *= 1.01;
        }
    });
    plan.base = other.expect("a sound scene");
    assert_ne!(as_it_is, table(&plan.run(&Progress::new("", true)).expect("a study")));
}

//! Guards the error table of the study: regression values as strings, `{:.3e}`.

use mpm_core::scene::LoadOn;
use mpm_verify::progress::Progress;
use mpm_verify::study::{CaseResult, Plan};

fn table(results: &[CaseResult]) -> String {
    let mut lines = vec!["case | Terzaghi | late | compressible | late | profile | crossings".to_owned()];
    for r in results {
        lines.push(format!(
            "{} | {:.3e} | {:.3e} | {:.3e} | {:.3e} | {:.3e} | {}",
            r.case,
            r.max_error_terzaghi,
            r.late_error_terzaghi,
            r.max_error_compressible,
            r.late_error_compressible,
            r.profile_error_compressible,
            r.cell_crossings
        ));
    }
    lines.join("\n")
}

fn plan(meshes: &[f64]) -> Plan {
    Plan {
        base: mpm_verify::scenes::terzaghi(),
        meshes: meshes.to_vec(),
        particles_per_cell: vec![1, 4, 9],
        loads: vec![LoadOn::Particles, LoadOn::Surface],
        budget: false,
        jobs: 2,
    }
}

#[test]
fn the_error_table_has_not_moved() {
    let results = plan(&[0.1, 0.05, 0.025]).run(&Progress::new("", true)).expect("a study");
    insta::with_settings!({ description => "Guards the errors of the study. Regression: against ourselves, not truth." }, {
        insta::assert_snapshot!("errors", table(&results));
    });
}

#[test]
fn the_required_accuracy_is_reached_at_two_centimetres() {
    let mut plan = plan(&[0.02]);
    plan.loads = vec![LoadOn::Surface];
    for result in plan.run(&Progress::new("", true)).expect("a study") {
        assert!(result.max_error_compressible <= 3e-3, "{}: {:.3e}", result.case, result.max_error_compressible);
    }
}

#[test]
fn the_table_check_can_fail() {
    let mut plan = plan(&[0.1]);
    let as_it_is = table(&plan.run(&Progress::new("", true)).expect("a study"));
    if let Some(water) = &mut plan.base.water {
        water.hydraulic_conductivity *= 1.01;
    }
    assert_ne!(as_it_is, table(&plan.run(&Progress::new("", true)).expect("a study")));
}

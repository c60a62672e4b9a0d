//! Guards particles that are boxes: they fill the soil as it settles, and are as points where it does not move.

use crate::common::completed;
use mpm_core::drive::Run;
use mpm_core::scene::{DomainChoice, Integrator, Scene, ShapeChoice, Until};

/// The column of large strain, which settles through three of its cells, in steps with inertia; in plane strain if that is asked for.
fn column(integrator: Integrator, plane: bool, domain: DomainChoice) -> Scene {
    let text = crate::common::edited(
        &crate::common::scene_text("terzaghi-large-strain"),
        &[
            ("bulk_modulus = inf", "bulk_modulus = 1e6"),
            ("porosity = 0.30", "porosity = 0.6"),
            ("particles_per_cell = 9", "particles_per_cell = 4"),
            ("integrator = \"quasi-static\"\ntolerance = 1.0e-5", "integrator = \"semi-implicit\""),
            ("shape = \"bspline2\"", "shape = \"centre\"\ndarcy_inertia = false"),
            ("cell = 0.1", "cell = 0.05"),
        ],
    );
    let text = if plane { text.replace("\"column\"", "\"plane-strain\"") } else { text };
    let scene = Scene::parse(&text, "column.toml").expect("a sound scene");
    let scene = scene.edited(|scene| {
        (scene.integrator, scene.particle_domain, scene.safety) = (integrator, domain, 0.5);
        scene.shape = if plane { ShapeChoice::BBar } else { ShapeChoice::Centre };
        scene.stages[0].until = Until::Time(40.0);
        scene.observe_times = vec![10.0, 40.0];
    });
    scene.expect("a sound scene")
}

/// How far the settlement of the surface is from what the volumes of particles have lost, as a share of it.
fn gap(run: &Run) -> f64 {
    let (first, last) = (&run.samples[0].state, &run.samples.last().expect("samples").state);
    let lost = 1.0 - last.soil_volume / first.soil_volume; // of 1 m
    (last.settlement - lost).abs() / lost
}

#[test]
fn boxes_fill_the_soil() {
    for integrator in [Integrator::Explicit, Integrator::SemiImplicit] {
        for plane in [false, true] {
            let boxes = gap(&completed(&column(integrator, plane, DomainChoice::Contiguous)));
            let points = gap(&completed(&column(integrator, plane, DomainChoice::Point)));
            let case = format!("{integrator:?}, plane {plane}: boxes {boxes:.1e}, points {points:.1e}");
            println!("{case}");
            assert!(boxes < if plane { 1e-3 } else { 1e-9 }, "{case}");
            assert!(points > 1e-3, "{case}");
        }
    }
}

#[test]
fn soil_that_does_not_move_is_as_of_points() {
    let base = crate::common::scene(&["cell = 0.1", "until.time_factor = 0.01", "-time_factors"]);
    let [points, boxes] = [DomainChoice::Point, DomainChoice::Contiguous].map(|domain| {
        let run = completed(&base.edited(|scene| scene.particle_domain = domain).expect("a sound scene"));
        run.samples.last().expect("samples").state.settlement
    });
    assert!(crate::common::apart(points, boxes) < 1e-4, "{points} {boxes}");
}

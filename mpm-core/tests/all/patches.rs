//! Guards that a scene is changed through the checker: a patched scene is that of the edited text, and is refused like it.

use crate::common::{edited, terzaghi};
use mpm_core::scene::capabilities::{Feature, RULES};
use mpm_core::scene::{Change, Displaced, Fields, LoadOn, Scene, ShapeChoice, StepChoice, Until};

fn base() -> Scene {
    Scene::parse(&terzaghi(), "scene.toml").expect("the default scene")
}

fn refused(changes: &[(&str, Change)]) -> String {
    base().patched(changes).expect_err("a refusal").to_string()
}

#[test]
fn a_patched_scene_is_that_of_the_edited_text() {
    let edits = [
        ("cell = 0.02", "cell = 0.1"),
        ("shape = \"centre\"", "shape = \"gimp\""),
        ("until.time_factor = 1.0", "until.time = 30.0"),
        ("on = \"surface\"", "on = \"particles\""),
        ("hydraulic_conductivity = 5.0e-4", "hydraulic_conductivity = 1.0e-4"),
    ];
    let text = edited(&terzaghi(), &edits);
    let written = Scene::parse(&text, "scene.toml").expect("the edited scene");
    let patch: [(&str, Change); 5] = [
        ("mesh.cell", 0.1.into()),
        ("scheme.shape", ShapeChoice::Gimp.into()),
        ("stages.0.until", Until::Time(30.0).into()),
        ("surcharge.on", LoadOn::Particles.into()),
        ("water.hydraulic_conductivity", 1.0e-4.into()),
    ];
    let patched = base().patched(&patch).expect("a sound patch");
    assert_eq!(patched, written);
    // One after the other is the same, and so are words of the file.
    let steps = patch
        .iter()
        .rev()
        .fold(base(), |scene, change| scene.patched(std::slice::from_ref(change)).unwrap_or_else(|e| panic!("{e}")));
    assert_eq!(steps, written);
    assert_eq!(base().patched(&[("scheme.shape", "gimp".into())]).expect("gimp").shape, ShapeChoice::Gimp);
    assert_eq!(base().patched::<&str>(&[]).expect("no change"), base());
}

#[test]
fn what_follows_from_a_changed_key_follows() {
    let conductivity = 2.0 * base().water.expect("water").hydraulic_conductivity;
    let faster = base().patched(&[("water.hydraulic_conductivity", conductivity.into())]).expect("faster");
    let end = |scene: &Scene| scene.observe_times[scene.observe_times.len() - 1];
    assert!((end(&faster) / end(&base()) - 0.5).abs() < 1e-12, "time factors are of the new water");
}

#[test]
fn a_patch_that_breaks_a_rule_is_refused_in_its_words() {
    let of = |feature: Feature| RULES.iter().find(|rule| rule.of == feature).expect("a rule").expected;
    let message = refused(&[("mesh.displaced", Displaced { smooth: 0.0, jitter: 0.1, seed: 1 }.into())]);
    let expected =
        format!("patch: mesh.displaced: expected {}, found mesh.displaced with \"explicit\"", of(Feature::Displaced));
    assert_eq!(message, expected);
    assert_eq!(
        refused(&[("mesh.cell", 0.3.into())]),
        "patch: mesh.cell: expected a cell that divides the height into whole cells, here height 1 m, found 0.3 m (3.3333333333333335 cells)"
    );
    // What the file says beside a patch is named with its line.
    let message = refused(&[("time.integrator", "quasi-static".into())]);
    assert!(message.starts_with("scene.toml:"), "{message}");
}

#[test]
fn a_patch_of_what_no_scene_has_is_refused() {
    let cases: [(&str, Change); 7] = [
        ("mesh.cel", 0.1.into()),
        ("mesh.cell", "wide".into()),
        ("mesh.cell.size", 0.1.into()),
        ("stages.4.damping", 1.0.into()),
        ("stages.first.damping", 1.0.into()),
        ("mesh.cell", Change::NONE),
        ("mesh.particles_per_cell", u64::MAX.into()),
    ];
    for (key, change) in cases {
        let message = refused(&[(key, change.clone())]);
        let removed = key == "mesh.cell" && message.contains("expected the key `cell`, found none");
        assert!(removed || message.starts_with(&format!("patch: {key}: expected ")), "{key} {change:?}: {message}");
    }
}

#[test]
fn numbers_keep_their_bits() {
    for modulus in [2.0e9_f64.next_up(), 2.0e9 / 3.0, 1.0e9_f64.next_down(), 1.0e9 * (0.1 + 0.2)] {
        let scene = base().patched(&[("water.bulk_modulus", modulus.into())]).expect("water");
        assert_eq!(scene.water.map(|w| w.bulk_modulus.to_bits()), Some(modulus.to_bits()));
        let again = scene.edited(|fields| fields.history += 1).expect("one more look");
        assert_eq!(again.water, scene.water);
        let bits = |scene: &Scene| scene.observe_times.iter().map(|time| time.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&again), bits(&scene));
    }
}

#[test]
fn every_scene_file_is_written_as_what_it_is() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../reference-data/scenes");
    for entry in std::fs::read_dir(folder).expect("the scenes") {
        let path = entry.expect("a file").path();
        if path.extension().is_some_and(|e| e == "toml") {
            let scene = Scene::load(&path).expect("a scene");
            assert_eq!(scene.edited(|_| {}).unwrap_or_else(|e| panic!("{}: {e}", path.display())), scene);
        }
    }
}

#[test]
fn an_edit_that_makes_no_scene_is_refused() {
    let edit = |edit: fn(&mut Fields)| base().edited(edit).expect_err("a refusal").to_string();
    assert_eq!(edit(|scene| scene.cells[1] = 7), "patch: cells: expected [1, 50], found [1, 7]");
    let rule = RULES.iter().find(|rule| rule.of == Feature::Displaced).expect("a rule");
    let displaced = edit(|scene| scene.displaced = Some(Displaced { smooth: 0.0, jitter: 0.1, seed: 1 }));
    assert_eq!(
        displaced,
        format!("patch: mesh.displaced: expected {}, found mesh.displaced with \"explicit\"", rule.expected)
    );
    let stiff = edit(|scene| scene.elastic.poisson_ratio = 0.5);
    assert_eq!(stiff, "patch: soil.law.linear_elastic.poisson_ratio: expected -1 < nu < 0.5, found 0.5");
}

#[test]
fn a_key_that_is_taken_out_is_no_more_there() {
    let dry = base().patched(&[
        ("water", Change::NONE),
        ("start", Change::NONE),
        ("scheme.darcy", Change::NONE),
        ("scheme.darcy_inertia", None::<bool>.into()),
        ("stages.0.drained", Change::NONE),
        ("stages.0.until", Until::Time(1.0).into()),
        ("observe", Change::NONE),
        ("failure.continue_if_unstable", Change::NONE),
        ("failure.continue_after_collapse", Change::NONE),
    ]);
    assert_eq!(dry.expect("a dry scene").water, None);
}

#[test]
fn a_step_and_a_mesh_are_changed_with_what_belongs_to_them() {
    let careful = base().patched(&[("time.safety", 0.5.into())]).expect("a safety factor");
    let stepped = careful.edited(|scene| scene.step = StepChoice::Fixed(1e-6)).expect("a step");
    assert_eq!((stepped.step, stepped.safety), (StepChoice::Fixed(1e-6), 0.9));
    let roomy = base().patched(&[("mesh.empty_cells_above", 3.into())]).expect("room");
    let fine = roomy.with_rows(100).expect("a finer mesh");
    assert_eq!((fine.cells[1], fine.empty_cells_above), (100, 6));
    assert_eq!(roomy.edited(|scene| scene.cell = 0.01).expect("a finer mesh").cells[1], 100, "cells follow");
    assert!(!fine.force && fine.forced().with_rows(50).expect("coarser").force);
}

#[test]
fn stages_are_added_and_taken_out() {
    let stage = toml::toml! {
        drained = "none"
        until.time = 1.0
    };
    let two =
        base().patched(&[("stages.0", stage.clone().into()), ("stages.1", stage.into()), ("observe", Change::NONE)]);
    let two = two.expect("two stages");
    assert_eq!(two.stages.len(), 2);
    let one = two.patched(&[("stages.last", Change::NONE)]).expect("one stage");
    assert_eq!(one.stages.len(), 1);
}

#[test]
fn what_no_checker_has_seen_is_not_lost_in_a_patch() {
    let altered = base().altered_unchecked(|scene| scene.gravity = Some(-1.0));
    let message = altered.patched(&[("mesh.cell", 0.1.into())]).expect_err("a refusal").to_string();
    assert!(message.starts_with("patch: gravity: expected a finite number above 0"), "{message}");
}

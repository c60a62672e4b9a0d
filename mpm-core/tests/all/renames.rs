//! Guards that scene files of the last version are read under their old names, with a warning, and written under the new ones.

use crate::common::scene_text;
use mpm_core::scene::{Change, Flags, Scene};

/// A scene file with its present names, and the same with those of the last version.
fn both(name: &str, renames: &[(&str, &str)]) -> [String; 2] {
    let new = scene_text(name);
    let old = renames.iter().fold(new.clone(), |text, (old, new)| {
        assert!(text.contains(new), "{name}: {new}");
        text.replace(new, old)
    });
    [new, old]
}

#[test]
fn old_names_are_read_with_a_warning_each() {
    let levee = [
        ("integrator = \"two-clocks\"", "integrator = \"staggered\""),
        ("clock = \"both\"", "coupling = \"full\""),
        ("headroom_cells", "empty_cells_above"),
        ("sideroom_cells", "empty_cells_beside"),
    ];
    let [new, old] = both("levee", &levee);
    let [new, old] = [new, old].map(|text| Scene::parse(&text, "scene.toml").expect("a scene"));
    assert!(new == old && new.warnings().is_empty());
    let warnings: Vec<String> = old.warnings().iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 5, "{warnings:#?}");
    let coupling = warnings.iter().find(|text| text.contains("`clock`")).expect("a warning");
    assert!(coupling.starts_with("scene.toml:") && coupling.contains("warning: stages.coupling: "), "{coupling}");
    assert!(coupling.contains("`clock` is now called `coupling`"), "{coupling}");
}

#[test]
fn a_key_under_both_names_is_refused() {
    let text = scene_text("levee").replace("[mesh]", "[mesh]\nheadroom_cells = 3");
    let refused = Scene::parse(&text, "scene.toml").expect_err("two names").to_string();
    assert!(refused.contains("headroom_cells"), "{refused}");
}

#[test]
fn flags_and_patches_take_old_names_too() {
    let text = scene_text("levee");
    let flags = Flags { driver: Some("two-clocks".to_owned()), ..Flags::default() };
    let scene = Scene::parse_with(&text, "scene.toml", &flags).expect("a scene");
    assert_eq!(scene.warnings().first().map(|warning| warning.key.as_str()), Some("--driver"));
    let patched =
        scene.patched(&[("mesh.headroom_cells", Change::from(scene.empty_cells_above + 1))]).expect("a scene");
    assert_eq!(patched.empty_cells_above, scene.empty_cells_above + 1);
    let staggered = scene.patched(&[("stages.0.clock", Change::from("staggered"))]).expect("a scene");
    assert!(staggered.may_fail());
}

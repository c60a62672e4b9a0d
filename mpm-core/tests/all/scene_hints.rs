//! Guards what the scene reader says beside a fault: all faults at once, names that were probably meant, and slips of units.

use std::path::Path;

use crate::common::{edited, terzaghi};
use mpm_core::scene::Scene;

fn refusal(edits: &[(&str, &str)]) -> String {
    Scene::parse(&edited(&terzaghi(), edits), "scene.toml").expect_err("a fault").to_string()
}

#[test]
fn all_faults_are_listed_with_their_lines() {
    let text = refusal(&[
        ("porosity", "porosty"),
        ("poisson_ratio = 0.30", "poisson_ratio = 0.6"),
        ("unit_weight = 9810.0", "unit_weight = -1.0"),
        ("shape = \"centre\"", "shape = \"center\""),
    ]);
    let faults: Vec<&str> = text.lines().filter(|line| line.starts_with("scene.toml:")).collect();
    assert_eq!(faults.len(), 4, "{text}");
    for key in ["porosty", "soil.law.linear_elastic.poisson_ratio", "water.unit_weight", "scheme.shape"] {
        assert!(faults.iter().any(|fault| fault.contains(&format!(": {key}: expected "))), "{key}: {text}");
    }
    for name in ["porosity", "centre"] {
        assert!(text.contains(&format!("    did you mean `{name}`?")), "{name}: {text}");
    }
}

#[test]
fn names_that_are_nothing_alike_are_not_suggested() {
    assert!(!refusal(&[("start =", "zebra = 1\nstart =")]).contains("did you mean"));
}

#[test]
fn a_unit_slip_stands_before_the_fault_that_it_causes() {
    let text = refusal(&[
        ("youngs_modulus = 2.0e7", "youngs_modulus = 20.0"),
        ("poisson_ratio = 0.30", "poisson_ratio = 0.6"),
    ]);
    let first = text.lines().next().expect("a line");
    assert!(first.contains("warning: soil.law.linear_elastic.youngs_modulus: 20 Pa"), "{text}");
    assert!(first.contains("MPa") && first.ends_with("2e7"), "{text}");
    assert!(text.lines().nth(1).is_some_and(|line| line.contains("poisson_ratio: expected")), "{text}");
}

#[test]
fn unit_slips_are_warnings_with_the_likely_unit() {
    for (from, to, key, unit) in [
        ("hydraulic_conductivity = 5.0e-4", "hydraulic_conductivity = 43.2", "hydraulic_conductivity", "m/day"),
        ("pressure = 1.0e4", "pressure = 10.0", "surcharge.pressure", "kPa"),
        ("unit_weight = 9810.0", "unit_weight = 9.81", "water.unit_weight", "kN/m3"),
    ] {
        match Scene::parse(&edited(&terzaghi(), &[(from, to)]), "scene.toml") {
            Ok(scene) => {
                let warning = scene.warnings().first().expect("a warning").to_string();
                assert!(warning.contains(key) && warning.contains(unit), "{warning}");
            }
            Err(error) => assert!(error.to_string().contains(unit), "{error}"),
        }
    }
}

#[test]
fn scenes_of_the_repository_have_no_warnings() {
    let mut warned = Vec::new();
    for folder in ["scenes", "gallery"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data").join(folder);
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
                warned.extend(scene.warnings().iter().map(|warning| format!("{}: {}", scene.name, warning.what)));
            }
        }
    }
    // Its soil is soft, so that strains are large.
    warned.retain(|warning| !warning.starts_with("terzaghi-large-strain: 33290.5"));
    assert!(warned.is_empty(), "{warned:#?}");
}

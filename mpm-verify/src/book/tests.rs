use pulldown_latex::config::DisplayMode;

use toml::{Table, Value};

use super::{formula, links, reference};
use crate::scenes::BUILT_IN;

#[test]
fn a_formula_becomes_mathml_and_what_is_no_tex_an_error() {
    let math =
        formula::mathml(r"\frac{n}{K_w}\,\dot p = -\nabla\cdot\mathbf v", DisplayMode::Block).expect("a formula");
    // A block scrolls by itself: a page on a phone does not.
    assert!(math.starts_with("<span class=\"formula\"") && math.contains("<mfrac>"), "{math}");
    let less = formula::mathml("a < b", DisplayMode::Inline).expect("a formula");
    assert!(less.contains("&lt;") && !less.contains("><<"), "{less}");
    assert!(formula::mathml(r"\frac{1}{", DisplayMode::Inline).is_err());
    assert!(formula::mathml(r"\nosuchcommand", DisplayMode::Inline).is_err());
}

#[test]
fn links_lead_to_pages_or_are_dropped() {
    let reports = tempfile::tempdir().expect("a folder");
    std::fs::write(reports.path().join("there.csv"), "").expect("a file");
    let on_pages = |link| links::on_pages(link, reports.path());
    assert_eq!(on_pages("theory.md#balance-laws").as_deref(), Some("theory.html#balance-laws"));
    assert_eq!(on_pages("#here").as_deref(), Some("#here"));
    assert_eq!(on_pages("../../reports/there.csv").as_deref(), Some("../there.csv"));
    assert_eq!(on_pages("../../reports/not.csv"), None);
    assert_eq!(on_pages("../../mpm-core/src/lib.rs"), None);
    assert_eq!(links::anchor("5. Verify it (2 minutes)"), "5-verify-it-2-minutes");
}

#[test]
fn the_checker_names_every_key_with_its_kind_and_bounds() {
    let keys = reference::keys();
    let of = |path: &str| keys.iter().find(|key| key.path == path).unwrap_or_else(|| panic!("{path}"));
    assert_eq!(of("soil.porosity").kind, "number");
    assert_eq!(of("mesh.particles_per_cell").kind, "whole number");
    assert_eq!(of("stages").kind, "a list of tables");
    assert!(of("soil.law.linear_elastic.poisson_ratio").bounds.as_deref().is_some_and(|b| b.contains("0.5")));
    assert!(of("water.free_surface.feed.*.head").row.is_some());
    assert!(keys.len() > 150, "{}", keys.len());
}

/// Every number of a scene a little smaller, lengths and cells alike.
fn smaller(value: &mut Value) {
    match value {
        Value::Float(number) => *number *= 1.0 - 1.0 / 1024.0,
        Value::Array(list) => list.iter_mut().for_each(smaller),
        Value::Table(table) => table.iter_mut().for_each(|(_, value)| smaller(value)),
        _ => {}
    }
}

#[test]
fn a_bound_of_the_reference_is_a_rule_and_no_number_of_a_scene() {
    let scenes = BUILT_IN.iter().map(|(name, text)| (name, text.parse::<Table>().expect("a scene")));
    let (mut compared, mut numbers) = (0, Vec::new());
    let keys: Vec<Vec<String>> = reference::keys()
        .iter()
        .map(|key| key.path.replace('*', "left").split('.').map(str::to_owned).collect())
        .collect();
    for (name, scene) in scenes {
        let mut other = Value::Table(scene.clone());
        smaller(&mut other);
        let Value::Table(other) = other else { unreachable!() };
        for path in keys.iter().filter(|path| reference::find(&scene, path).is_some()) {
            let (Some(one), Some(two)) = (reference::beyond(&scene, path), reference::beyond(&other, path)) else {
                continue;
            };
            compared += 1;
            if one != two {
                numbers.push(format!("{name}: {}: {one} | {two}", path.join(".")));
            }
        }
    }
    assert!(compared > 500 && numbers.is_empty(), "{compared} compared: {numbers:#?}");
}

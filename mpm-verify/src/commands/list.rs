//! `list`: what there is.

use std::collections::BTreeMap;

use mpm_core::scene::capabilities::{FEATURES, RULES, conflict};
use mpm_core::scene::{INTEGRATORS, SHAPES};
use mpm_verify::cases::suite;
use mpm_verify::levee::variants::VARIANTS;
use mpm_verify::scenes::BUILT_IN;
use mpm_verify::stress::CASES;
use mpm_verify::study::MESHES;

use super::{Failure, print_json, say};
use crate::Common;

/// Words of `levee --driver`.
const DRIVERS: [&str; 3] = ["staggered", "coupled", "explicit"];

/// Names of the cases that have a mutant, and its fault.
fn mutants() -> impl Iterator<Item = (&'static str, &'static str)> {
    suite().iter().filter_map(|case| Some((case.name, case.mutant?)))
}

/// Prints which features of scenes do not go together, and what is expected in their place.
pub fn capabilities(common: &Common) -> Result<(), Failure> {
    if common.json {
        let rule = |rule: &mpm_core::scene::capabilities::Rule| {
            let beside: Vec<String> = rule.beside.iter().map(|other| other.name()).collect();
            serde_json::json!({ "what": rule.of.name(), "not_beside": beside, "expected": rule.expected })
        };
        print_json(&serde_json::json!({
            "features": FEATURES.iter().map(|(feature, ..)| feature.name()).collect::<Vec<_>>(),
            "rules": RULES.iter().map(rule).collect::<Vec<_>>(),
        }));
        return Ok(());
    }
    let names: Vec<_> = FEATURES.iter().map(|(feature, ..)| *feature).collect();
    let pairs = || names.iter().enumerate().flat_map(|(i, a)| names[..i].iter().map(move |b| (*a, *b)));
    let refused = pairs().filter(|(a, b)| conflict(*a, *b).is_some()).count();
    say(
        false,
        &format!(
            "{} features, {} pairs of them, {refused} refused; all others go together.",
            names.len(),
            pairs().count()
        ),
    );
    for rule in RULES {
        let beside: Vec<String> = rule.beside.iter().map(|other| other.name()).collect();
        say(false, &format!("  {}", rule.of.name()));
        say(false, &format!("      not beside {}", beside.join(", ")));
        say(false, &format!("      expected   {}", rule.expected));
    }
    Ok(())
}

/// Prints cases, mutants, scenes and schemes.
pub fn run(common: &Common) -> Result<(), Failure> {
    if common.json {
        let names = |list: Vec<&str>| serde_json::Value::from(list);
        print_json(&serde_json::json!({
            "cases": names(suite().iter().map(|case| case.name).collect()),
            "mutants": mutants().collect::<BTreeMap<_, _>>(),
            "stress_tests": names(CASES.iter().map(|case| case.name).collect()),
            "scenes": names(BUILT_IN.iter().map(|(name, _)| *name).collect()),
            "integrators": names(INTEGRATORS.map(|(word, _)| word).to_vec()),
            "variants": names(VARIANTS.iter().map(|v| v.name).collect()),
            "drivers": names(DRIVERS.to_vec()),
            "schemes": names(SHAPES.map(|(word, _)| word).to_vec()),
            "darcy": names(vec!["face", "nodal"]),
            "meshes_m": MESHES,
        }));
        return Ok(());
    }
    say(false, "cases (mpm-verify check [CASE..])");
    for case in suite() {
        say(false, &format!("  {:<22} {}", case.name, case.about));
    }
    say(false, "mutants (mpm-verify check --mutants [CASE..]): the same checks with a fault that they must find");
    for (name, what) in mutants() {
        say(false, &format!("  {name:<22} {what}"));
    }
    say(false, "stress tests (mpm-verify stability [CASE..])");
    for case in &CASES {
        say(false, &format!("  {:<22} {}", case.name, case.measures));
    }
    say(false, "scenes (reference-data/scenes, mpm-verify solve SCENE.toml)");
    for (name, text) in BUILT_IN {
        let about = text.lines().next().unwrap_or("").trim_start_matches(['#', ' ']);
        say(false, &format!("  {name:<22} {about}"));
    }
    say(false, "variants of the levee (mpm-verify levee --variant NAME)");
    for variant in &VARIANTS {
        say(false, &format!("  {:<22} {}: {}", variant.name, variant.what, variant.label));
    }
    say(false, &format!("drivers           {}", DRIVERS.join(", ")));
    say(false, &format!("integrators       {}", INTEGRATORS.map(|(word, _)| word).join(", ")));
    say(false, &format!("schemes           {}", SHAPES.map(|(word, _)| word).join(", ")));
    say(false, "darcy operators   face, nodal");
    say(false, &format!("meshes (m)        {}", MESHES.map(|m| m.to_string()).join(", ")));
    Ok(())
}

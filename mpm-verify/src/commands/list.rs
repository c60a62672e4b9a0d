//! `list`: names of everything that can be run.

use clap::{Args, ValueEnum};
use mpm_core::scene::capabilities::{FEATURES, RULES, conflict};
use mpm_core::scene::{INTEGRATORS, SHAPES};
use mpm_verify::cases::{Case, suite};
use mpm_verify::levee::variants::VARIANTS;
use mpm_verify::mutants::detected::{Detected, alone};
use mpm_verify::mutants::patches;
use mpm_verify::protocol::case::titles;
use mpm_verify::scenes::{BUILT_IN, GALLERY};
use mpm_verify::stress::CASES;
use mpm_verify::study::MESHES;
use serde_json::{Value, json};

use super::terminal::{print_json, say};
use super::{Failure, levee};
use crate::Common;

/// What to list.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Only this kind
    kind: Option<Kind>,
    /// What cannot be combined in a scene, and what is expected instead
    #[arg(long, conflicts_with = "kind")]
    capabilities: bool,
}

/// Kinds of names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    Cases,
    Mutants,
    NeutralCases,
    StressTests,
    Scenes,
    Gallery,
    Variants,
    Faults,
    Words,
}

/// A list: its kind, where its names go, names and descriptions.
type Names = (Kind, &'static str, Vec<(&'static str, String)>);

fn names() -> Vec<Names> {
    let first = |text: &str| text.lines().next().unwrap_or("").trim_start_matches(['#', ' ']).to_owned();
    let mutants = suite().iter().filter_map(|case| Some((case.name, case.mutant?.to_owned())));
    let words = |words: &[&str]| words.join(", ");
    let detected = Detected::built_in();
    let case = |case: &'static Case| {
        let only = alone(&detected, case.name);
        let only = if only.is_empty() { String::new() } else { format!("; alone detects {}", only.join(", ")) };
        (case.name, format!("{} ({:.2} s{only})", case.about, case.cost()))
    };
    vec![
        (Kind::Cases, "test cases: mpm-verify check CASE", suite().iter().map(case).collect()),
        (
            Kind::Mutants,
            "mutants, the same checks with a fault that they must catch: mpm-verify check --mutants CASE",
            mutants.collect(),
        ),
        (
            Kind::NeutralCases,
            "neutral cases for other codes: mpm-verify cases export DIR",
            titles().iter().map(|(name, title)| (name.as_str(), title.clone())).collect(),
        ),
        (
            Kind::StressTests,
            "stress tests: mpm-verify stability TEST",
            CASES.iter().map(|case| (case.name, case.measures.to_owned())).collect(),
        ),
        (
            Kind::Scenes,
            "scenes (files in reference-data/scenes): mpm-verify solve SCENE",
            BUILT_IN.iter().map(|(name, text)| (*name, first(text))).collect(),
        ),
        (
            Kind::Gallery,
            "gallery scenes: mpm-verify gallery SCENE, or solve SCENE",
            GALLERY.iter().map(|scene| (scene.name, first(scene.text))).collect(),
        ),
        (
            Kind::Variants,
            "variants of the levee: mpm-verify levee --variant NAME",
            VARIANTS.iter().map(|variant| (variant.name, format!("{}: {}", variant.what, variant.label))).collect(),
        ),
        (
            Kind::Faults,
            "faults planted in a copy of the source: mpm-verify mutants FAULT",
            patches::mutants().unwrap_or_default().into_iter().map(|mutant| (mutant.name, mutant.what)).collect(),
        ),
        (
            Kind::Words,
            "words of options and scene files",
            vec![
                ("drivers", words(&levee::DRIVERS.map(|(word, ())| word))),
                ("integrators", words(&INTEGRATORS.map(|(word, _)| word))),
                ("schemes", words(&SHAPES.map(|(word, _)| word))),
                ("darcy operators", words(&["face", "nodal"])),
                ("meshes (m)", MESHES.map(|mesh| mesh.to_string()).join(", ")),
            ],
        ),
    ]
}

/// Prints names of one kind or of all.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    if options.capabilities {
        return capabilities(common);
    }
    let wanted = names().into_iter().filter(|(kind, ..)| options.kind.is_none_or(|only| only == *kind));
    if common.json {
        print_json(&json(wanted));
        return Ok(());
    }
    for (_, title, names) in wanted {
        say(title);
        for (name, about) in names {
            say(&format!("  {name:<22} {about}"));
        }
    }
    Ok(())
}

/// The same as one object of lists.
fn json(names: impl Iterator<Item = Names>) -> Value {
    let mut all = serde_json::Map::new();
    for (kind, _, names) in names {
        let list = || Value::from(names.iter().map(|(name, _)| *name).collect::<Vec<_>>());
        let (key, value) = match kind {
            Kind::Cases => ("cases", list()),
            Kind::Mutants => ("mutants", names.iter().map(|(name, what)| (*name, what.as_str())).collect()),
            Kind::NeutralCases => ("neutral_cases", list()),
            Kind::StressTests => ("stress_tests", list()),
            Kind::Scenes => ("scenes", list()),
            Kind::Gallery => ("gallery", list()),
            Kind::Variants => ("variants", list()),
            Kind::Faults => ("faults", list()),
            Kind::Words => {
                let words = json!({
                    "drivers": levee::DRIVERS.map(|(word, ())| word),
                    "integrators": INTEGRATORS.map(|(word, _)| word),
                    "schemes": SHAPES.map(|(word, _)| word),
                    "darcy": ["face", "nodal"],
                    "meshes_m": MESHES,
                });
                all.extend(words.as_object().cloned().unwrap_or_default());
                continue;
            }
        };
        all.insert(key.to_owned(), value);
    }
    Value::Object(all)
}

/// Prints which features of scenes cannot be combined, and what is expected instead.
fn capabilities(common: &Common) -> Result<(), Failure> {
    if common.json {
        let rule = |rule: &mpm_core::scene::capabilities::Rule| {
            let beside: Vec<String> = rule.beside.iter().map(|other| other.name()).collect();
            json!({ "what": rule.of.name(), "not_beside": beside, "expected": rule.expected })
        };
        print_json(&json!({
            "features": FEATURES.iter().map(|(feature, ..)| feature.name()).collect::<Vec<_>>(),
            "rules": RULES.iter().map(rule).collect::<Vec<_>>(),
        }));
        return Ok(());
    }
    let features: Vec<_> = FEATURES.iter().map(|(feature, ..)| *feature).collect();
    let pairs = || features.iter().enumerate().flat_map(|(i, a)| features[..i].iter().map(move |b| (*a, *b)));
    let refused = pairs().filter(|(a, b)| conflict(*a, *b).is_some()).count();
    let counts = format!("{} features, {} pairs", features.len(), pairs().count());
    say(&format!("{counts}: {refused} cannot be combined, all others can"));
    for rule in RULES {
        let beside: Vec<String> = rule.beside.iter().map(|other| other.name()).collect();
        say(&format!("  {}", rule.of.name()));
        say(&format!("      not with   {}", beside.join(", ")));
        say(&format!("      expected   {}", rule.expected));
    }
    Ok(())
}

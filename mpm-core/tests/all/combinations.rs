//! Every combination of what an engineer's scene may have is read, or the table of capabilities refuses it; scenes in which every three
//! of these words stand together run a few steps, and their balances close.

use std::collections::HashSet;

use mpm_core::drive::drive;
use mpm_core::random::Random;
use mpm_core::run::model;
use mpm_core::scene::Scene;
use mpm_core::scene::capabilities::RULES;
use mpm_core::stability::choose_step;

const INTEGRATORS: [&str; 5] = ["explicit", "semi-implicit", "quasi-static", "staggered", "coupled"];

/// What a scene may have, one word of each row.
const PARTS: [&[&str]; 8] = [
    &["column", "block", "outline"],
    &["dry", "full of water", "free surface"],
    &["elastic", "plastic"],
    &["one soil", "layers"],
    &["no load", "load", "strip"],
    &["rollers", "run-out", "periodic"],
    &["fixed base", "friction"],
    &["level", "tilted"],
];

type Choice = [&'static str; PARTS.len()];

/// Those that mean something: a column has no sides and no base that slides, the ends of an outline do not meet.
fn choices() -> Vec<Choice> {
    let of_planes = ["strip", "run-out", "periodic", "friction", "tilted"];
    let word = |number: &mut usize, words: &[&'static str]| {
        let word = words[*number % words.len()];
        *number /= words.len();
        word
    };
    let count = PARTS.iter().map(|words| words.len()).product();
    let all = (0..count).map(|mut number| PARTS.map(|words| word(&mut number, words)));
    let is_one = |choice: &Choice| match choice[0] {
        "column" => !choice.iter().any(|word| of_planes.contains(word)),
        "outline" => !choice.contains(&"periodic"),
        _ => true,
    };
    all.filter(is_one).collect()
}

/// The scene file of a choice.
fn text(choice: &Choice, integrator: &str) -> String {
    let has = |word: &str| choice.contains(&word);
    let when = |word: &str, text: &'static str| if has(word) { text } else { "" };
    let law = |modulus: &str| {
        let elastic = format!("youngs_modulus = {modulus}, poisson_ratio = 0.3");
        if has("plastic") {
            format!("law.mohr_coulomb = {{ {elastic}, cohesion = 2e4, friction_angle = 30.0 }}\n")
        } else {
            format!("law.linear_elastic = {{ {elastic} }}\n")
        }
    };
    let layers = || format!("[[layers]]\nup_to = 0.5\n{}[[layers]]\nup_to = 1.0\n{}", law("1e7"), law("5e6"));
    [
        "name = \"combination\"\ngravity = 9.81\nstart = \"geostatic\"\n",
        if has("column") { "dimension = \"column\"\n" } else { "dimension = \"plane-strain\"\n" },
        when("tilted", "slope_angle = 5.0\n"),
        if has("outline") {
            "[geometry.outline]\npoints = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [1.0, 1.0], [0.0, 1.0]]\n"
        } else {
            "[geometry.column]\nheight = 1.0\nwidth = 2.0\n"
        },
        "[mesh]\ncell = 0.25\nparticles_per_cell = 4\n",
        when("run-out", "empty_cells_beside = 4\n"),
        "[soil]\ngrain_density = 2700.0\nporosity = 0.4\n",
        &law("1e7"),
        &if has("layers") { layers() } else { String::new() },
        if has("dry") {
            ""
        } else {
            "[water]\nhydraulic_conductivity = 1e-3\nbulk_modulus = 2e8\nunit_weight = 9810.0\n"
        },
        when("free surface", "free_surface = { saturation = 0.1, level = 0.5 }\n"),
        "[boundaries]\n",
        match (has("column"), has("friction")) {
            (true, _) => "bottom = \"roller\"\n",
            (_, true) => "bottom = \"coulomb\"\n",
            _ => "bottom = \"fixed\"\n",
        },
        if has("periodic") {
            "left = \"periodic\"\nright = \"periodic\"\n"
        } else {
            "left = \"roller\"\nright = \"roller\"\n"
        },
        when("friction", "[base]\nfriction_angle = 30.0\n"),
        if has("no load") { "" } else { "[surcharge]\npressure = 1e3\n" },
        when("strip", "strip = { from = 0.0, to = 0.5 }\n"),
        &format!("[time]\nintegrator = \"{integrator}\"\n[[stages]]\n"),
        when("full of water", "drained = [\"top\"]\n"),
        when("free surface", "drained = \"none\"\n"),
        match integrator {
            "staggered" => "coupling = \"soil\"\n",
            "coupled" => "coupling = \"full\"\n",
            _ => "",
        },
        "until.time = 0.01\n[observe]\nhistory = 0\n",
    ]
    .concat()
}

/// Runs a scene; the reason if it cannot be run.
fn runs(scene: &Scene) -> Result<(), String> {
    let mut model = model(scene).map_err(|error| error.to_string())?;
    let dt = choose_step(scene).map_err(|error| error.to_string())?;
    let run = drive(scene, model.as_mut(), dt, &mut |_| {}).whole().map_err(|error| error.to_string())?;
    let verdict = run.trust.map_or("none", |trust| trust.verdict);
    if verdict == "closed" { Ok(()) } else { Err(format!("balances: {verdict}")) }
}

#[test]
fn a_combination_runs_and_closes_or_the_table_refuses_it() {
    let mut choices = choices();
    let mut random = Random(1);
    choices.sort_by_cached_key(|_| random.bits());
    let (mut seen, mut running, mut runs_made) = (HashSet::new(), 0, 0);
    for choice in &choices {
        let mut refusals = Vec::new();
        for integrator in INTEGRATORS {
            match Scene::parse(&text(choice, integrator), "combination.toml") {
                // What three of the words do together has been seen once: any of them may need the other two.
                Ok(scene) => {
                    if triples(choice, integrator).filter(|triple| seen.insert(*triple)).count() > 0 {
                        assert_eq!(runs(&scene), Ok(()), "{} by {integrator}", choice.join(", "));
                        runs_made += 1;
                    }
                }
                Err(error) => refusals.push(error),
            }
        }
        if refusals.len() < INTEGRATORS.len() {
            running += 1;
            continue;
        }
        for error in refusals {
            assert!(RULES.iter().any(|rule| rule.expected == error.expected), "{}: {error}", choice.join(", "));
        }
    }
    println!("{runs_made} runs for {} triples", seen.len());
    // All of them make sense: none may be lost.
    assert_eq!((choices.len(), running), (744, 744));
}

/// Every three words of a scene, that of its integrator among them.
fn triples(choice: &Choice, integrator: &'static str) -> impl Iterator<Item = [&'static str; 3]> {
    let words: Vec<&'static str> = choice.iter().copied().chain([integrator]).collect();
    let count = words.len();
    let places = (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)));
    places
        .flat_map(move |(i, j)| (j + 1..count).map(move |k| (i, j, k)))
        .map(move |(i, j, k)| [words[i], words[j], words[k]])
}

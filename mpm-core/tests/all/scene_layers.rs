//! Guards soil in layers: what is read from a scene, and every message about what is refused.

use crate::common::{edited, terzaghi};
use crate::refusal::{Edits, TIME_FACTORS, WATER, refusal};
use mpm_core::scene::Scene;

/// The law of the default scene.
const LAW: &str = "[soil.law.linear_elastic]
youngs_modulus = 2.0e7
poisson_ratio = 0.30
";

/// The default scene in two layers.
const LAYERS: &str = "[soil.law.linear_elastic]
youngs_modulus = 2.0e7
poisson_ratio = 0.30

[[layers]]
up_to = 0.5
hydraulic_conductivity = 5.0e-7

[[layers]]
up_to = 1.0
youngs_modulus = 2.0e8
";

/// What is wrong with layers, and the edits of the default scene in two layers that make it so.
const LAYER_CASES: &[(&str, Edits)] = &[
    ("misspelt key", &[("up_to = 0.5", "up_too = 0.5")]),
    ("missing top", &[("up_to = 0.5\n", "")]),
    (
        "no layers",
        &[
            ("name = \"terzaghi\"", "name = \"terzaghi\"\nlayers = []"),
            (
                "[[layers]]\nup_to = 0.5\nhydraulic_conductivity = 5.0e-7\n\n[[layers]]\nup_to = 1.0\nyoungs_modulus = 2.0e8\n",
                "",
            ),
        ],
    ),
    (
        "a single table",
        &[(
            "[[layers]]\nup_to = 0.5\nhydraulic_conductivity = 5.0e-7\n\n[[layers]]\nup_to = 1.0",
            "[layers]\nup_to = 1.0",
        )],
    ),
    ("tops that do not ascend", &[("up_to = 0.5", "up_to = 1.0")]),
    ("a layer of no thickness", &[("up_to = 0.5", "up_to = 0.0")]),
    ("a layer above the soil", &[("up_to = 1.0", "up_to = 1.5")]),
    ("soil above the last layer", &[("up_to = 1.0", "up_to = 0.9")]),
    ("an interface inside a cell", &[("up_to = 0.5", "up_to = 0.51")]),
    ("a layer thinner than a cell", &[("up_to = 0.5", "up_to = 0.01")]),
    ("a top that is not a number", &[("up_to = 0.5", "up_to = nan")]),
    ("a layer without stiffness", &[("youngs_modulus = 2.0e8", "youngs_modulus = 0.0")]),
    ("a layer with nu = 0.5", &[("youngs_modulus = 2.0e8", "poisson_ratio = 0.5")]),
    ("a tight layer", &[("hydraulic_conductivity = 5.0e-7", "hydraulic_conductivity = 0.0")]),
    (
        "conductivity of a dry layer",
        &[
            (WATER, ""),
            ("start = \"undrained-equilibrium\"", "start = \"unloaded\""),
            ("drained = [\"top\"]\n", ""),
            ("until.time_factor = 1.0", "until.time = 1.0"),
            (TIME_FACTORS, ""),
            ("darcy = \"face\"\ndarcy_inertia = true\n", ""),
        ],
    ),
    (
        "elasticity with a law",
        &[(
            "up_to = 0.5",
            "up_to = 0.5\nyoungs_modulus = 1e6\nlaw.linear_elastic = { youngs_modulus = 2.0e7, poisson_ratio = 0.3 }",
        )],
    ),
    ("nodal velocities", &[("darcy = \"face\"", "darcy = \"nodal\"")]),
    (
        "waiting for a pressure",
        &[("until.time_factor = 1.0", "until.pore_pressure_within = 0.01"), (TIME_FACTORS, ""), ("history = 60\n", "")],
    ),
    (
        "a mesh that is laid anew",
        &[
            ("integrator = \"explicit\"\nstep = \"auto\"\nsafety = 0.9", "integrator = \"quasi-static\""),
            ("flip = 1.0\n", ""),
            ("darcy_inertia = true\n", ""),
        ],
    ),
    (
        "a shifted mesh",
        &[
            ("integrator = \"explicit\"\nstep = \"auto\"\nsafety = 0.9", "integrator = \"quasi-static\""),
            ("flip = 1.0\n", ""),
            ("darcy_inertia = true\n", ""),
            ("porosity = 0.30", "porosity = 0.30\nstrain = \"small\""),
            ("particles_per_cell = 4", "particles_per_cell = 4\nshift = 0.3"),
        ],
    ),
    ("staggered", &[("integrator = \"explicit\"\nstep = \"auto\"\nsafety = 0.9", "integrator = \"staggered\"")]),
];

#[test]
fn layers_take_from_soil_and_water_what_they_do_not_say() {
    let text = edited(&terzaghi(), &[(LAW, LAYERS)]);
    let scene = Scene::parse(&text, "scene.toml").expect("a scene that holds");
    assert_eq!(scene.layers.len(), 2);
    let modulus = |height| scene.ground().at(&[0.0, height]).elastic.youngs_modulus;
    assert_eq!((modulus(0.3), modulus(0.7)), (2.0e7, 2.0e8));
    assert_eq!(scene.layers.iter().map(|l| l.hydraulic_conductivity).collect::<Vec<_>>(), [5.0e-7, 5.0e-4]);
    // Every layer has its own undrained pressure, and settles by itself.
    let share = |m: f64| 2.2e9 / 0.3 / (2.2e9 / 0.3 + m);
    let (soft, stiff) = (scene.oedometer_modulus(), 10.0 * scene.oedometer_modulus());
    assert!((scene.undrained_pressure_at(0.2) / (1e4 * share(soft)) - 1.0).abs() < 1e-14);
    assert!((scene.undrained_pressure_at(0.8) / (1e4 * share(stiff)) - 1.0).abs() < 1e-14);
    let settled = 1e4 * 0.5 * ((1.0 - share(soft)) / soft + (1.0 - share(stiff)) / stiff);
    assert!((scene.first_settlement() / settled - 1.0).abs() < 1e-12);
}

#[test]
fn every_message_about_layers() {
    let base = edited(&terzaghi(), &[(LAW, LAYERS)]);
    let mut list = String::new();
    for (case, edits) in LAYER_CASES {
        let error = refusal(case, &edited(&base, edits));
        list += &format!("{case}\n    {error}\n");
    }
    insta::with_settings!({
        description => "Guards the words and the line of every refusal of soil in layers.",
        omit_expression => true,
    }, {
        insta::assert_snapshot!(list);
    });
}

#[test]
fn there_are_no_more_soils_than_a_run_can_tell_apart() {
    let tops = (1..=33).map(|row| format!("[[layers]]\nup_to = {:.2}\n", 0.02 * f64::from(row)));
    let many = edited(&terzaghi(), &[(LAW, &format!("{LAW}\n{}", tops.collect::<String>()))]);
    let error = refusal("33 layers", &many);
    assert_eq!((error.expected.as_str(), error.found.as_str()), ("at most 32 layers", "33"));
}

#[test]
fn a_region_lies_over_the_layers_and_the_last_one_over_all() {
    let regions =
        "[[regions]]\nlevels = [0.3, 0.6]\nporosity = 0.5\n[[regions]]\nlevels = [0.5, 0.9]\nanisotropy = 4.0\n";
    let scene =
        Scene::parse(&edited(&terzaghi(), &[(LAW, &format!("{LAYERS}{regions}"))]), "scene.toml").expect("sound");
    let ground = scene.ground();
    let of = |height| {
        let soil = ground.at(&[0.0, height]);
        (soil.porosity, soil.anisotropy, soil.hydraulic_conductivity, soil.elastic.youngs_modulus)
    };
    // What a region does not say is that of [soil] and [water], whatever layer it lies in.
    let seen = [0.1, 0.4, 0.55, 0.95].map(of);
    assert_eq!(seen, [(0.3, 1.0, 5e-7, 2e7), (0.5, 1.0, 5e-4, 2e7), (0.3, 4.0, 5e-4, 2e7), (0.3, 1.0, 5e-4, 2e8)]);
    assert_eq!(scene.edited(|_| {}).expect("the same scene"), scene);
}

//! Guards which integrators, schemes and loads go together: every refusal, and what must be accepted.

use crate::common::{edited, terzaghi};
use crate::refusal::{Edits, SURCHARGE, TIME_FACTORS, WATER, refusal};
use mpm_core::scene::{Flags, Integrator, Scene, ShapeChoice};

/// The default scene becomes quasi-static by these edits.
const QUASI_STATIC: Edits = &[
    ("integrator = \"explicit\"\nstep = \"auto\"\nsafety = 0.9", "integrator = \"quasi-static\""),
    ("darcy_inertia = true\nflip = 1.0\n", ""),
];
const PLANE: (&str, &str) = ("\"column\"", "\"plane-strain\"");
const STRIP: (&str, &str) = ("on = \"surface\"", "on = \"surface\"\nstrip = { from = 0.0, to = 0.04, taper = 0.02 }");
const UNLOADED: (&str, &str) = ("\"undrained-equilibrium\"", "\"unloaded\"");
const HELD: Edits = &[
    ("start = \"undrained-equilibrium\"\n", "gravity = 9.81\n"),
    (SURCHARGE, ""),
    ("top = \"free\"", "top = \"roller\""),
    ("bulk_modulus = 2.2e9", "bulk_modulus = inf"),
    ("drained = [\"top\"]", "drained = \"none\""),
    ("until.time_factor = 1.0", "until.time = 1.0"),
    (TIME_FACTORS, ""),
];

/// What the explicit default scene may not say.
const EXPLICIT_CASES: &[(&str, Edits)] = &[
    ("a method", &[("safety = 0.9", "safety = 0.9\nmethod = \"sdirk\"")]),
    ("a tolerance", &[("safety = 0.9", "safety = 0.9\ntolerance = 1.0e-4")]),
    ("small strain", &[("porosity = 0.30", "porosity = 0.30\nstrain = \"small\"")]),
    ("unknown strain", &[("porosity = 0.30", "porosity = 0.30\nstrain = \"tiny\"")]),
    ("a shift", &[("cell = 0.02", "cell = 0.02\nshift = 0.5")]),
    ("displaced particles", &[("cell = 0.02", "cell = 0.02\ndisplaced.smooth = 0.1")]),
    (
        "a plate in a mesh with room",
        &[("on = \"surface\"", "on = \"plate\""), ("cell = 0.02", "cell = 0.02\nempty_cells_above = 2")],
    ),
    (
        "affine velocities with an implicit pressure",
        &[
            ("integrator = \"explicit\"", "integrator = \"semi-implicit\""),
            ("flip = 1.0", "flip = 1.0\ntransfer = \"affine\""),
        ],
    ),
    (
        "an update of another integrator",
        &[
            ("integrator = \"explicit\"", "integrator = \"semi-implicit\""),
            ("flip = 1.0", "flip = 1.0\nupdate = \"musl\""),
        ],
    ),
    ("an unknown transfer", &[("flip = 1.0", "flip = 1.0\ntransfer = \"apic\"")]),
    ("inertia in soft water", &[("bulk_modulus = 2.2e9", "bulk_modulus = 8.0e6")]),
    ("nodal Darcy with gimp", &[("shape = \"centre\"\ndarcy = \"face\"", "shape = \"gimp\"\ndarcy = \"nodal\"")]),
    ("cubic B-splines in an explicit step", &[("shape = \"centre\"", "shape = \"bspline3\"")]),
    ("incompressible water", &[("bulk_modulus = 2.2e9", "bulk_modulus = inf")]),
    ("jump penalty of another shape", &[("flip = 1.0", "flip = 1.0\njump_penalty = 1.0e-3")]),
    (
        "quasi-static: more than fits into memory",
        &[
            ("integrator = \"explicit\"", "integrator = \"quasi-static\""),
            ("dimension = \"column\"", "dimension = \"plane-strain\""),
            ("width = 0.1", "width = 1000.0"),
            ("darcy_inertia = true\nflip = 1.0\n", ""),
            ("safety = 0.9\n", ""),
        ],
    ),
    (
        "jump penalty without its integrator",
        &[("shape = \"centre\"", "shape = \"bspline2\""), ("flip = 1.0", "flip = 1.0\njump_penalty = 1.0e-3")],
    ),
    (
        "semi-implicit: a tolerance",
        &[("integrator = \"explicit\"", "integrator = \"semi-implicit\"\ntolerance = 1.0e-4")],
    ),
    (
        "semi-implicit: nodal Darcy",
        &[("integrator = \"explicit\"", "integrator = \"semi-implicit\""), ("darcy = \"face\"", "darcy = \"nodal\"")],
    ),
    (
        "semi-implicit: dry",
        &[
            ("integrator = \"explicit\"", "integrator = \"semi-implicit\""),
            (WATER, ""),
            ("\"undrained-equilibrium\"", "\"unloaded\""),
            ("darcy = \"face\"\ndarcy_inertia = true\n", ""),
            ("drained = [\"top\"]\n", ""),
            ("until.time_factor = 1.0", "until.time = 1.0"),
            (TIME_FACTORS, ""),
        ],
    ),
    (
        "semi-implicit: a plate in a mesh with room",
        &[
            ("integrator = \"explicit\"", "integrator = \"semi-implicit\""),
            ("on = \"surface\"", "on = \"plate\""),
            ("cell = 0.02", "cell = 0.02\nempty_cells_above = 2"),
        ],
    ),
    (
        "semi-implicit: displaced particles",
        &[
            ("integrator = \"explicit\"", "integrator = \"semi-implicit\""),
            ("cell = 0.02", "cell = 0.02\ndisplaced.jitter = 0.1"),
        ],
    ),
    (
        "semi-implicit: pore pressure of incompressible water",
        &[
            ("integrator = \"explicit\"", "integrator = \"semi-implicit\""),
            ("bulk_modulus = 2.2e9", "bulk_modulus = inf"),
            ("until.time_factor = 1.0", "until.pore_pressure_within = 0.1"),
        ],
    ),
    ("a column drained at its left", &[("drained = [\"top\"]", "drained = [\"left\"]")]),
];

/// What the quasi-static scene may not say.
const QUASI_STATIC_CASES: &[(&str, Edits)] = &[
    ("safety", &[("\"quasi-static\"", "\"quasi-static\"\nsafety = 0.9")]),
    ("the paper's step", &[("\"quasi-static\"", "\"quasi-static\"\nstep = \"paper\"")]),
    ("zero step", &[("\"quasi-static\"", "\"quasi-static\"\nstep = 0.0")]),
    ("unknown method", &[("\"quasi-static\"", "\"quasi-static\"\nmethod = \"euler\"")]),
    ("Krylov with large strain", &[("\"quasi-static\"", "\"quasi-static\"\nmethod = \"krylov\"")]),
    (
        "Krylov with a given step",
        &[
            ("\"quasi-static\"", "\"quasi-static\"\nmethod = \"krylov\"\nstep = 0.1"),
            ("porosity = 0.30", "porosity = 0.30\nstrain = \"small\""),
        ],
    ),
    ("zero tolerance", &[("\"quasi-static\"", "\"quasi-static\"\ntolerance = 0.0")]),
    ("tolerance below round-off", &[("\"quasi-static\"", "\"quasi-static\"\ntolerance = 9.0e-11")]),
    ("tolerance above a tenth", &[("\"quasi-static\"", "\"quasi-static\"\ntolerance = 0.11")]),
    ("tolerance that is not a number", &[("\"quasi-static\"", "\"quasi-static\"\ntolerance = nan")]),
    ("tolerance with a given step", &[("\"quasi-static\"", "\"quasi-static\"\ntolerance = 1.0e-4\nstep = 0.1")]),
    ("nodal Darcy", &[("darcy = \"face\"", "darcy = \"nodal\"")]),
    ("inertia in Darcy's law", &[("darcy = \"face\"", "darcy = \"face\"\ndarcy_inertia = true")]),
    ("flip", &[("darcy = \"face\"", "darcy = \"face\"\nflip = 1.0")]),
    ("damping", &[("drained = [\"top\"]", "drained = [\"top\"]\ndamping = 100.0")]),
    (
        "until by pore pressure",
        &[("until.time_factor = 1.0", "until.pore_pressure_within = 0.1"), (TIME_FACTORS, ""), ("history = 60", "")],
    ),
    ("whole shift", &[("cell = 0.02", "cell = 0.02\nshift = 1.0")]),
    ("negative shift", &[("cell = 0.02", "cell = 0.02\nshift = -0.1")]),
    ("unknown displacement", &[("cell = 0.02", "cell = 0.02\ndisplaced.wave = 0.1")]),
    ("smooth displacement by more than half a spacing", &[("cell = 0.02", "cell = 0.02\ndisplaced.smooth = 0.6")]),
    ("negative jitter", &[("cell = 0.02", "cell = 0.02\ndisplaced.jitter = -0.1")]),
    ("negative seed", &[("cell = 0.02", "cell = 0.02\ndisplaced.jitter = 0.1\ndisplaced.seed = -1")]),
    ("seed that is no count", &[("cell = 0.02", "cell = 0.02\ndisplaced.jitter = 0.1\ndisplaced.seed = 1.5")]),
    ("displaced as a word", &[("cell = 0.02", "cell = 0.02\ndisplaced = \"smooth\"")]),
    ("unknown quadrature", &[("shape = \"centre\"", "shape = \"bspline2\"\nquadrature = \"gauss\"")]),
    ("negative jump penalty", &[("shape = \"centre\"", "shape = \"bspline2\"\njump_penalty = -1.0e-3")]),
    ("vast jump penalty", &[("shape = \"centre\"", "shape = \"bspline2\"\njump_penalty = 1.5")]),
    (
        "bspline2 with one particle per cell",
        &[("shape = \"centre\"", "shape = \"bspline2\""), ("particles_per_cell = 4", "particles_per_cell = 1")],
    ),
    (
        "dry: jump penalty",
        &[
            (WATER, ""),
            ("\"undrained-equilibrium\"", "\"unloaded\""),
            ("shape = \"centre\"\ndarcy = \"face\"\n", "shape = \"bspline2\"\njump_penalty = 1.0e-3\n"),
            ("drained = [\"top\"]\n", ""),
        ],
    ),
    ("strip in a column", &[STRIP]),
    (
        "strip under a plate",
        &[PLANE, UNLOADED, ("on = \"surface\"", "on = \"plate\"\nstrip = { from = 0.0, to = 0.04 }")],
    ),
    (
        "a plate that a fixed side holds",
        &[PLANE, ("on = \"surface\"", "on = \"plate\""), ("left = \"roller\"", "left = \"fixed\"")],
    ),
    ("strip in equilibrium", &[PLANE, STRIP]),
    ("strip that starts outside", &[PLANE, UNLOADED, ("on = \"surface\"", "strip = { from = 0.1, to = 0.2 }")]),
    ("strip that ends outside", &[PLANE, UNLOADED, ("on = \"surface\"", "strip = { from = 0.0, to = 0.2 }")]),
    ("strip of no width", &[PLANE, UNLOADED, ("on = \"surface\"", "strip = { from = 0.02, to = 0.02 }")]),
    (
        "strip with a negative taper",
        &[PLANE, UNLOADED, ("on = \"surface\"", "strip = { from = 0.0, to = 0.04, taper = -0.1 }")],
    ),
    ("strip without its end", &[PLANE, ("on = \"surface\"", "strip = { from = 0.0 }")]),
    ("equilibrium with a free side", &[PLANE, ("right = \"roller\"", "right = \"free\"")]),
    ("held, closed and incompressible", HELD),
    ("negative water stiffness", &[("bulk_modulus = 2.2e9", "bulk_modulus = -inf")]),
];

/// Edits of the explicit and of the quasi-static scene that are sound.
const SOUND: [(&str, bool, Edits); 16] = [
    ("a strip, explicit", false, &[PLANE, STRIP, UNLOADED]),
    ("semi-implicit", false, &[("\"explicit\"", "\"semi-implicit\"")]),
    (
        "semi-implicit, incompressible, the paper's step",
        false,
        &[
            (
                "integrator = \"explicit\"\nstep = \"auto\"\nsafety = 0.9",
                "integrator = \"semi-implicit\"\nstep = \"paper\"",
            ),
            ("bulk_modulus = 2.2e9", "bulk_modulus = inf"),
        ],
    ),
    ("gimp", false, &[("\"centre\"", "\"gimp\"")]),
    ("bspline2 with one particle per cell", false, &[("\"centre\"", "\"bspline2\""), ("per_cell = 4", "per_cell = 1")]),
    ("quasi-static", true, &[]),
    ("incompressible", true, &[("bulk_modulus = 2.2e9", "bulk_modulus = inf")]),
    ("the smallest tolerance", true, &[("\"quasi-static\"", "\"quasi-static\"\ntolerance = 1.0e-10")]),
    ("the largest tolerance", true, &[("\"quasi-static\"", "\"quasi-static\"\ntolerance = 0.1")]),
    ("given steps", true, &[("\"quasi-static\"", "\"quasi-static\"\nmethod = \"sdirk\"\nstep = 0.1")]),
    (
        "Krylov",
        true,
        &[
            ("\"quasi-static\"", "\"quasi-static\"\nmethod = \"krylov\""),
            ("porosity = 0.30", "porosity = 0.30\nstrain = \"small\""),
        ],
    ),
    (
        "every key of bspline2",
        true,
        &[
            ("\"centre\"", "\"bspline2\"\nquadrature = \"volumes\"\njump_penalty = 0.0\ndarcy_inertia = false"),
            ("cell = 0.02", "cell = 0.02\nshift = 0.5\ndisplaced = { smooth = 0.5, jitter = 0.5, seed = 7 }"),
        ],
    ),
    ("a plate", true, &[("on = \"surface\"", "on = \"plate\"")]),
    ("a strip", true, &[PLANE, STRIP, UNLOADED]),
    ("drained sideways", true, &[PLANE, ("drained = [\"top\"]", "drained = [\"left\", \"right\"]")]),
    (
        // The equilibrium of the soil, not only its volume, decides the pressure under a free top.
        "incompressible and closed under a load",
        true,
        &[
            ("bulk_modulus = 2.2e9", "bulk_modulus = inf"),
            ("drained = [\"top\"]", "drained = \"none\""),
            ("until.time_factor = 1.0", "until.time = 1.0"),
            (TIME_FACTORS, ""),
        ],
    ),
];

/// The default scene, explicit or quasi-static.
fn base(quasi_static: bool) -> String {
    if quasi_static { edited(&terzaghi(), QUASI_STATIC) } else { terzaghi() }
}

#[test]
fn every_message_about_methods() {
    let mut list = String::new();
    for (integrator, cases) in [("explicit", EXPLICIT_CASES), ("quasi-static", QUASI_STATIC_CASES)] {
        for (case, edits) in cases {
            let error = refusal(case, &edited(&base(integrator == "quasi-static"), edits));
            list += &format!("{integrator}: {case}\n    {error}\n");
        }
    }
    insta::with_settings!({
        description => "Guards the words and the line of every refusal that depends on the integrator.",
        omit_expression => true,
    }, {
        insta::assert_snapshot!(list);
    });
}

#[test]
fn sound_combinations_are_accepted() {
    for (case, quasi_static, edits) in SOUND {
        let text = edited(&base(quasi_static), edits);
        if let Err(error) = Scene::parse(&text, "scene.toml") {
            panic!("{case}: {error}\n{text}");
        }
    }
    // Any one way out makes the held and closed scene sound.
    for (from, to) in [
        ("drained = \"none\"", "drained = [\"top\"]"),
        ("bulk_modulus = inf", "bulk_modulus = 2.2e9"),
        ("top = \"roller\"", "top = \"free\""),
        ("cell = 0.02", "cell = 0.02\nempty_cells_above = 1"),
    ] {
        let text = edited(&edited(&base(true), HELD), &[(from, to)]);
        Scene::parse(&text, "scene.toml").unwrap_or_else(|error| panic!("{to}: {error}"));
    }
}

#[test]
fn flags_pass_the_same_checks_and_are_named_in_their_refusal() {
    let flags = |integrator: &str, scheme: &str, tolerance: f64| Flags {
        integrator: Some(integrator.to_owned()),
        scheme: Some(scheme.to_owned()),
        tolerance: Some(tolerance),
        ..Flags::default()
    };
    let text = edited(&base(true), &[("[time]\nintegrator = \"quasi-static\"\n", "")]);
    let scene = Scene::parse_with(&text, "scene.toml", &flags("quasi-static", "bspline2", 1e-6)).expect("a scene");
    assert_eq!((scene.integrator, scene.shape), (Integrator::QuasiStatic, ShapeChoice::Bspline2));
    assert_eq!(scene.tolerance, 1e-6);
    let message = |flags: &Flags| Scene::parse_with(&text, "scene.toml", flags).expect_err("a bad flag").to_string();
    let words = "expected one of \"explicit\", \"semi-implicit\", \"quasi-static\", \"implicit\", \"staggered\", \"coupled\", found \"implicitly\"";
    assert_eq!(
        message(&flags("implicitly", "linear", 1e-4)),
        format!("--integrator: {words}\n    did you mean `implicit`?")
    );
    let words = "expected one of \"centre\", \"centroid\", \"linear\", \"b-bar\", \"gimp\", \"bspline2\", \"bspline3\", found \"cubic\"";
    assert_eq!(message(&flags("quasi-static", "cubic", 1e-4)), format!("--scheme: {words}"));
    let words = "expected 1e-10 <= tolerance <= 0.1 (-), found 0.5";
    assert_eq!(message(&flags("quasi-static", "linear", 0.5)), format!("--tolerance: {words}"));
    let words =
        "expected integrator = \"quasi-static\" or \"implicit\" with it, found time.tolerance with \"explicit\"";
    assert_eq!(message(&flags("explicit", "linear", 1e-4)), format!("--tolerance: {words}"));
    // What stands in the file is still named with its line.
    let one = edited(&text, &[("particles_per_cell = 4", "particles_per_cell = 1")]);
    let error = Scene::parse_with(&one, "scene.toml", &flags("quasi-static", "bspline2", 1e-4)).expect_err("one point");
    assert_eq!((error.line, error.key.as_str()), (13, "mesh.particles_per_cell"));
}

#[test]
fn the_drainage_path_is_the_shortest_way_out() {
    let path = |sides: &str| {
        let sides = format!("drained = [{sides}]");
        let edits: &[(&str, &str)] = &[PLANE, ("width = 0.1", "width = 1.2"), ("drained = [\"top\"]", &sides)];
        Scene::parse(&edited(&base(true), edits), "scene.toml").expect("a scene").drainage_path()
    };
    assert_eq!(path("\"top\""), 1.0);
    assert_eq!(path("\"top\", \"bottom\""), 0.5);
    assert_eq!(path("\"right\""), 1.2);
    assert_eq!(path("\"left\", \"right\""), 0.6);
    assert_eq!(path("\"top\", \"right\""), 1.0);
    assert_eq!(path("\"left\", \"right\", \"top\""), 0.6);
    assert_eq!(path("\"left\", \"right\", \"top\", \"bottom\""), 0.5);
}

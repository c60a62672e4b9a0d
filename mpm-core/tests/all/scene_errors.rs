//! Guards every message of the scene reader: what is refused, at which line, in which words.

use std::path::Path;

use crate::common::{edited, scene_text, terzaghi};
use crate::refusal::{Edits, SURCHARGE, TIME_FACTORS, WATER, refusal};
use mpm_core::scene::{Flags, Scene};
use proptest::prelude::*;

const STAGE: &str = "[[stages]]
name = \"drain\"
drained = [\"top\"]
until.time_factor = 1.0
";
const LAW: &str = "[soil.law.linear_elastic]
youngs_modulus = 2.0e7
poisson_ratio = 0.30
";

/// A start from a given state.
const GIVEN: (&str, &str) = ("\"undrained-equilibrium\"", "\"given\"");

/// What is wrong, and the edits of the default scene that make it so.
const CASES: &[(&str, Edits)] = &[
    // keys, tables and types
    ("misspelt key", &[("porosity", "porosty")]),
    ("misspelt key at the root", &[("start =", "strat =")]),
    ("misspelt table", &[("[mesh]", "[msh]")]),
    ("misspelt optional table", &[("[surcharge]", "[surchage]")]),
    ("misspelt law", &[("[soil.law.linear_elastic]", "[soil.law.linear_elastc]")]),
    ("misspelt geometry", &[("[geometry.column]", "[geometry.colum]")]),
    ("key in the wrong table", &[("width = 0.1", "width = 0.1\ncell = 0.02")]),
    ("missing key", &[("cell = 0.02\n", "")]),
    ("missing key of the water", &[("bulk_modulus = 2.2e9\n", "")]),
    ("missing key of the law", &[("poisson_ratio = 0.30\n", "")]),
    ("missing name", &[("name = \"terzaghi\"\n", "")]),
    ("a name that leads elsewhere", &[("name = \"terzaghi\"", "name = \"../../etc/passwd\"")]),
    ("a name that hides", &[("name = \"terzaghi\"", "name = \".terzaghi\"")]),
    ("no letter in a name", &[("name = \"terzaghi\"", "name = \"\"")]),
    ("a name with a line in it", &[("name = \"terzaghi\"", "name = \"a\\nb\"")]),
    ("missing table", &[("[mesh]\ncell = 0.02\nparticles_per_cell = 4\n", "")]),
    ("missing law", &[(LAW, "")]),
    ("no stages", &[(STAGE, "")]),
    ("an empty list of stages", &[(STAGE, ""), ("name = \"terzaghi\"", "name = \"terzaghi\"\nstages = []")]),
    ("stages as one table", &[("[[stages]]", "[stages]")]),
    ("key given twice", &[("cell = 0.02", "cell = 0.02\ncell = 0.05")]),
    ("table given twice", &[("[water]", "[soil]\n[water]")]),
    ("no value", &[("cell = 0.02", "cell =")]),
    ("two decimal points", &[("cell = 0.02", "cell = 0.0.2")]),
    ("a unit behind the number", &[("cell = 0.02", "cell = 0.02 m")]),
    ("unclosed string", &[("on = \"surface\"", "on = \"surface")]),
    ("unclosed list", &[("drained = [\"top\"]", "drained = [\"top\"")]),
    ("string for a number", &[("cell = 0.02", "cell = \"0.02\"")]),
    ("number for a word", &[("shape = \"centre\"", "shape = 1")]),
    ("string for a switch", &[("darcy_inertia = true", "darcy_inertia = \"yes\"")]),
    ("decimal for a count", &[("particles_per_cell = 4", "particles_per_cell = 4.0")]),
    ("a count that no machine holds", &[("particles_per_cell = 4", "particles_per_cell = 99999999999999999999")]),
    ("number for a list", &[("history = 60", "times = 0.1")]),
    ("word for a table", &[(LAW, "law = \"linear_elastic\"\n")]),
    ("unknown word for a table", &[(LAW, "law = \"elastic\"\n")]),
    ("values without their keys", &[(SURCHARGE, ""), ("start =", "surcharge = [1.0e4, \"surface\"]\nstart =")]),
    ("list for a table", &[(SURCHARGE, "[[surcharge]]\npressure = 1.0e4\n")]),
    // words
    ("unknown dimension", &[("\"column\"", "\"spherical\"")]),
    ("unknown start", &[("\"undrained-equilibrium\"", "\"undrained\"")]),
    ("unknown side condition", &[("top = \"free\"", "top = \"open\"")]),
    ("unknown load", &[("on = \"surface\"", "on = \"nodes\"")]),
    ("unknown shape", &[("shape = \"centre\"", "shape = \"center\"")]),
    ("unknown darcy", &[("darcy = \"face\"", "darcy = \"faces\"")]),
    ("unknown integrator", &[("integrator = \"explicit\"", "integrator = \"implicit\"")]),
    ("unknown step", &[("step = \"auto\"", "step = \"automatic\"")]),
    ("unknown drained side", &[("drained = [\"top\"]", "drained = [\"up\"]")]),
    ("unknown drained word", &[("drained = [\"top\"]", "drained = \"top\"")]),
    // numbers
    ("zero height", &[("height = 1.0", "height = 0.0")]),
    ("negative width", &[("width = 0.1", "width = -0.1")]),
    ("zero cell", &[("cell = 0.02", "cell = 0.0")]),
    ("cell that is not a number", &[("cell = 0.02", "cell = nan")]),
    ("infinite stiffness", &[("youngs_modulus = 2.0e7", "youngs_modulus = inf")]),
    ("number beyond the range", &[("youngs_modulus = 2.0e7", "youngs_modulus = 2.0e777")]),
    ("cell that does not divide the height", &[("cell = 0.02", "cell = 0.03")]),
    ("cell larger than the column", &[("cell = 0.02", "cell = 2.0")]),
    ("cell that does not divide the width", &[("cell = 0.02", "cell = 0.04"), ("\"column\"", "\"plane-strain\"")]),
    ("no particles", &[("particles_per_cell = 4", "particles_per_cell = 0")]),
    ("negative particles", &[("particles_per_cell = 4", "particles_per_cell = -4")]),
    ("particles that make no square", &[("particles_per_cell = 4", "particles_per_cell = 5")]),
    (
        "1e9 particles",
        &[("\"column\"", "\"plane-strain\""), ("particles_per_cell = 4", "particles_per_cell = 4000000")],
    ),
    ("1e9 particles in a column", &[("particles_per_cell = 4", "particles_per_cell = 400000000000000")]),
    (
        "1e9 cells",
        &[
            ("\"column\"", "\"plane-strain\""),
            ("cell = 0.02\nparticles_per_cell = 4", "cell = 1.0e-5\nparticles_per_cell = 1"),
        ],
    ),
    ("1e9 cells in a column", &[("cell = 0.02", "cell = 1.0e-9")]),
    (
        "a negative number of empty cells",
        &[("particles_per_cell = 4", "particles_per_cell = 4\nempty_cells_above = -1")],
    ),
    (
        "a vast number of empty cells",
        &[("particles_per_cell = 4", "particles_per_cell = 4\nempty_cells_above = 2000000")],
    ),
    ("nu = 0.6", &[("poisson_ratio = 0.30", "poisson_ratio = 0.6")]),
    ("nu = 0.5", &[("poisson_ratio = 0.30", "poisson_ratio = 0.5")]),
    ("nu = -1", &[("poisson_ratio = 0.30", "poisson_ratio = -1.0")]),
    ("negative stiffness", &[("youngs_modulus = 2.0e7", "youngs_modulus = -2.0e7")]),
    ("negative porosity", &[("porosity = 0.30", "porosity = -0.1")]),
    ("porosity of nothing", &[("porosity = 0.30", "porosity = 1e-320")]),
    ("height of nothing", &[("height = 1.0", "height = 1e-320")]),
    ("porosity 1", &[("porosity = 0.30", "porosity = 1.0")]),
    ("porosity in percent", &[("porosity = 0.30", "porosity = 30")]),
    ("zero grain density", &[("grain_density = 1800.0", "grain_density = 0.0")]),
    ("bulk density below its water", &[("grain_density = 1800.0", "bulk_density = 250.0")]),
    ("bedding of a column", &[("conductivity = 5.0e-4", "conductivity = 5.0e-4\nbedding_angle = 30.0")]),
    (
        "bedding beyond upright",
        &[
            ("conductivity = 5.0e-4", "conductivity = 5.0e-4\nbedding_angle = 91.0"),
            ("\"column\"", "\"plane-strain\""),
            ("shape = \"centre\"", "shape = \"bspline2\""),
            ("darcy_inertia = true\nflip = 1.0\n", ""),
            ("integrator = \"explicit\"\nstep = \"auto\"\nsafety = 0.9", "integrator = \"quasi-static\""),
        ],
    ),
    ("a word for a switch", &[("conductivity = 5.0e-4", "conductivity = 5.0e-4\nkozeny_carman = \"yes\"")]),
    ("a well above the soil", &[("[scheme]", "[[wells]]\nat = 1.5\nrate = 1.0e-6\n[scheme]")]),
    ("a well beside the soil", &[("[scheme]", "[[wells]]\nat = [0.2, 0.5]\nrate = 1.0e-6\n[scheme]")]),
    ("a well without a rate", &[("[scheme]", "[[wells]]\nat = 0.5\n[scheme]")]),
    ("a well that takes nothing", &[("[scheme]", "[[wells]]\nat = 0.5\nrate = 0.0\n[scheme]")]),
    (
        "a well with two courses",
        &[("[scheme]", "[[wells]]\nat = 0.5\nrate = 1.0\nramp_time = 1.0\nsine.period = 1.0\n[scheme]")],
    ),
    ("an unknown key of a well", &[("[scheme]", "[[wells]]\nat = 0.5\nrates = 1.0\n[scheme]")]),
    ("negative conductivity", &[("conductivity = 5.0e-4", "conductivity = -5.0e-4")]),
    ("zero water stiffness", &[("bulk_modulus = 2.2e9", "bulk_modulus = 0.0")]),
    ("zero unit weight", &[("unit_weight = 9810.0", "unit_weight = 0.0")]),
    ("negative water density", &[("unit_weight = 9810.0", "unit_weight = 9810.0\ndensity = -1000.0")]),
    ("zero surcharge", &[("pressure = 1.0e4", "pressure = 0.0")]),
    ("negative ramp", &[("pressure = 1.0e4", "pressure = 1.0e4\nramp_time = -1.0")]),
    ("upward gravity", &[("dimension =", "gravity = -9.81\ndimension =")]),
    ("zero gravity", &[("dimension =", "gravity = 0.0\ndimension =")]),
    ("flip above 1", &[("flip = 1.0", "flip = 1.5")]),
    ("negative flip", &[("flip = 1.0", "flip = -0.1")]),
    ("safety above 1", &[("safety = 0.9", "safety = 1.1")]),
    ("zero safety", &[("safety = 0.9", "safety = 0.0")]),
    ("zero step", &[("step = \"auto\"", "step = 0.0"), ("safety = 0.9\n", "")]),
    ("negative step", &[("step = \"auto\"", "step = -1.0e-6"), ("safety = 0.9\n", "")]),
    ("step that is not a number", &[("step = \"auto\"", "step = nan"), ("safety = 0.9\n", "")]),
    ("step as a list", &[("step = \"auto\"", "step = [1.0e-6]"), ("safety = 0.9\n", "")]),
    ("negative damping", &[("drained = [\"top\"]", "drained = [\"top\"]\ndamping = -1.0")]),
    ("negative history", &[("history = 60", "history = -1")]),
    ("vast history", &[("history = 60", "history = 2000000")]),
    // one of two keys
    (
        "neither density",
        &[("grain_density = 1800.0 # Table 1 says \"density of soil\"; read as that of the grains\n", "")],
    ),
    ("both densities", &[("grain_density = 1800.0", "bulk_density = 1800.0\ngrain_density = 1800.0")]),
    ("neither conductivity nor permeability", &[("hydraulic_conductivity = 5.0e-4\n", "")]),
    (
        "both conductivity and permeability",
        &[("hydraulic_conductivity = 5.0e-4", "hydraulic_conductivity = 5.0e-4\nintrinsic_permeability = 5.0e-11")],
    ),
    ("permeability without viscosity", &[("hydraulic_conductivity = 5.0e-4", "intrinsic_permeability = 5.0e-11")]),
    (
        "permeability with a bad viscosity",
        &[("hydraulic_conductivity = 5.0e-4", "intrinsic_permeability = 5.0e-11\nviscosity = 0.0")],
    ),
    (
        "negative permeability",
        &[("hydraulic_conductivity = 5.0e-4", "intrinsic_permeability = -5.0e-11\nviscosity = 1.0e-3")],
    ),
    (
        "viscosity with conductivity",
        &[("hydraulic_conductivity = 5.0e-4", "hydraulic_conductivity = 5.0e-4\nviscosity = 1.0e-3")],
    ),
    // drainage
    ("drained not said", &[("drained = [\"top\"]\n", "")]),
    ("drained by an empty list", &[("drained = [\"top\"]", "drained = []")]),
    ("time factor without drainage", &[("drained = [\"top\"]", "drained = \"none\"")]),
    ("drained everywhere", &[("drained = [\"top\"]", "drained = [\"left\", \"right\", \"bottom\", \"top\"]")]),
    ("drained at a side", &[("drained = [\"top\"]", "drained = [\"top\", \"right\"]")]),
    ("side drained twice", &[("drained = [\"top\"]", "drained = [\"top\", \"top\"]")]),
    ("side by number", &[("drained = [\"top\"]", "drained = [4]")]),
    ("drained by a switch", &[("drained = [\"top\"]", "drained = true")]),
    // boundaries and load
    ("surcharge on a roller", &[("top = \"free\"", "top = \"roller\"")]),
    ("surcharge on a fixed top", &[("top = \"free\"", "top = \"fixed\"")]),
    ("free bottom", &[("bottom = \"roller\"", "bottom = \"free\"")]),
    ("column free at its side", &[("right = \"roller\"", "right = \"free\"")]),
    ("column fixed at its side", &[("left = \"roller\"", "left = \"fixed\"")]),
    // start
    ("equilibrium without a load", &[(SURCHARGE, "")]),
    ("equilibrium with a ramp", &[("pressure = 1.0e4", "pressure = 1.0e4\nramp_time = 0.1")]),
    ("equilibrium on a slope", &[("dimension =", "gravity = 9.81\nslope_angle = 10.0\ndimension =")]),
    ("geostatic without gravity", &[("\"undrained-equilibrium\"", "\"geostatic\"")]),
    ("nothing given", &[("\"undrained-equilibrium\"", "\"given\"")]),
    ("an empty state", &[("\"undrained-equilibrium\"", "\"given\"\n[initial]")]),
    ("a state with another start", &[("[surcharge]", "[initial]\npressure = 1e3\n[surcharge]")]),
    ("misspelt state", &[GIVEN, ("[surcharge]", "[initial]\npresure = 1e3\n[surcharge]")]),
    ("heights that fall", &[GIVEN, ("[surcharge]", "[initial]\npressure = [[1, 0], [0, 1e3]]\n[surcharge]")]),
    ("a pressure that is not a number", &[GIVEN, ("[surcharge]", "[initial]\npressure = nan\n[surcharge]")]),
    ("a pressure in words", &[GIVEN, ("[surcharge]", "[initial]\npressure = \"high\"\n[surcharge]")]),
    ("shear in a column", &[GIVEN, ("[surcharge]", "[initial]\nstress_xy = 1.0\n[surcharge]")]),
    ("a table that is not there", &[GIVEN, ("[surcharge]", "[initial]\ntable = \"no.csv\"\n[surcharge]")]),
    ("a table by number", &[GIVEN, ("[surcharge]", "[initial]\ntable = 7\n[surcharge]")]),
    (
        "a table with a pressure",
        &[GIVEN, ("[surcharge]", "[initial]\npressure = 1e3\ntable = \"no.csv\"\n[surcharge]")],
    ),
    // supports of a stage
    ("unknown support of a stage", &[("drained = [\"top\"]", "drained = [\"top\"]\nboundaries.right = \"open\"")]),
    ("a column that is let go", &[("drained = [\"top\"]", "drained = [\"top\"]\nboundaries.bottom = \"free\"")]),
    ("a column released sideways", &[("drained = [\"top\"]", "drained = [\"top\"]\nboundaries.right = \"free\"")]),
    ("periodic in a stage", &[("drained = [\"top\"]", "drained = [\"top\"]\nboundaries.right = \"periodic\"")]),
    // until
    ("no until", &[("until.time_factor = 1.0\n", "")]),
    ("an empty until", &[("until.time_factor = 1.0", "until = {}")]),
    ("two ends", &[("until.time_factor = 1.0", "until.time_factor = 1.0\nuntil.time = 1.0")]),
    ("misspelt until", &[("until.time_factor", "until.time_facto")]),
    ("zero time", &[("until.time_factor = 1.0", "until.time = 0.0")]),
    ("negative time factor", &[("until.time_factor = 1.0", "until.time_factor = -1.0")]),
    ("at_most with a time", &[("until.time_factor = 1.0", "until.time_factor = 1.0\nuntil.at_most = 1.0")]),
    ("pressure tolerance of 1", &[("until.time_factor = 1.0", "until.pore_pressure_within = 1.0")]),
    ("zero pressure tolerance", &[("until.time_factor = 1.0", "until.pore_pressure_within = 0.0")]),
    ("zero at_most", &[("until.time_factor = 1.0", "until.pore_pressure_within = 0.1\nuntil.at_most = 0.0")]),
    (
        "pore pressure without a load",
        &[
            (SURCHARGE, ""),
            ("\"undrained-equilibrium\"", "\"unloaded\""),
            ("until.time_factor = 1.0", "until.pore_pressure_within = 0.1"),
        ],
    ),
    // observe
    ("time factor after the end", &[("0.7, 1.0]", "0.7, 1.5]")]),
    ("zero time factor", &[("[0.01,", "[0.0,")]),
    ("negative time", &[("history = 60", "times = [-0.1]")]),
    ("time after the end", &[("history = 60", "times = [0.1, 2.0]")]),
    // what would not be used
    ("everywhere with a time", &[("until.time_factor = 1.0", "until.time_factor = 1.0\nuntil.everywhere = true")]),
    ("safety with a given step", &[("step = \"auto\"", "step = 1.0e-7")]),
    (
        "times to observe in a stage that ends by its pressure",
        &[("until.time_factor = 1.0", "until.pore_pressure_within = 0.1")],
    ),
    (
        "history of a stage that ends by its pressure",
        &[("until.time_factor = 1.0", "until.pore_pressure_within = 0.1"), (TIME_FACTORS, "")],
    ),
    // a dry scene
    (
        "dry: darcy inertia",
        &[
            (WATER, ""),
            ("\"undrained-equilibrium\"", "\"unloaded\""),
            ("darcy = \"face\"\n", ""),
            ("drained = [\"top\"]\n", ""),
        ],
    ),
    ("dry: darcy", &[(WATER, ""), ("\"undrained-equilibrium\"", "\"unloaded\""), ("drained = [\"top\"]\n", "")]),
    (
        "dry: drained",
        &[(WATER, ""), ("\"undrained-equilibrium\"", "\"unloaded\""), ("darcy = \"face\"\ndarcy_inertia = true\n", "")],
    ),
    (
        "dry: time factor",
        &[
            (WATER, ""),
            ("\"undrained-equilibrium\"", "\"unloaded\""),
            ("darcy = \"face\"\ndarcy_inertia = true\n", ""),
            ("drained = [\"top\"]\n", ""),
        ],
    ),
    (
        "dry: pore pressure",
        &[
            (WATER, ""),
            ("\"undrained-equilibrium\"", "\"unloaded\""),
            ("darcy = \"face\"\ndarcy_inertia = true\n", ""),
            ("drained = [\"top\"]\n", ""),
            ("until.time_factor = 1.0", "until.pore_pressure_within = 0.1"),
        ],
    ),
    (
        "dry: time factors to observe",
        &[
            (WATER, ""),
            ("\"undrained-equilibrium\"", "\"unloaded\""),
            ("darcy = \"face\"\ndarcy_inertia = true\n", ""),
            ("drained = [\"top\"]\n", ""),
            ("until.time_factor = 1.0", "until.time = 1.0"),
        ],
    ),
];

/// The law of the default scene with a strength, line by line.
const STRENGTH: &str = "[soil.law.mohr_coulomb]
youngs_modulus = 2.0e7
poisson_ratio = 0.30
cohesion = 500.0
friction_angle = 30.0
dilation_angle = 10.0
tension_cutoff = 100.0
";

/// What is wrong, and the edits of the default scene with that law that make it so.
const STRENGTH_CASES: &[(&str, Edits)] = &[
    ("misspelt key", &[("cohesion", "cohesian")]),
    ("missing cohesion", &[("cohesion = 500.0\n", "")]),
    ("missing friction", &[("friction_angle = 30.0\n", "")]),
    ("two laws", &[("[soil.law.mohr_coulomb]", "[soil.law.linear_elastic]\n[soil.law.mohr_coulomb]")]),
    ("negative cohesion", &[("cohesion = 500.0", "cohesion = -1.0")]),
    ("cohesion that is not a number", &[("cohesion = 500.0", "cohesion = nan")]),
    ("nu = 0.5", &[("poisson_ratio = 0.30", "poisson_ratio = 0.5")]),
    ("negative stiffness", &[("youngs_modulus = 2.0e7", "youngs_modulus = -2.0e7")]),
    ("no friction", &[("friction_angle = 30.0", "friction_angle = 0.0")]),
    ("a right angle of friction", &[("friction_angle = 30.0", "friction_angle = 90.0")]),
    ("dilation above friction", &[("dilation_angle = 10.0", "dilation_angle = 30.5")]),
    ("negative dilation", &[("dilation_angle = 10.0", "dilation_angle = -1.0")]),
    ("cut-off above the apex", &[("tension_cutoff = 100.0", "tension_cutoff = 867.0")]),
    ("negative cut-off", &[("tension_cutoff = 100.0", "tension_cutoff = -1.0")]),
    ("cut-off without cohesion", &[("cohesion = 500.0", "cohesion = 0.0")]),
];

#[test]
fn every_message_about_strength() {
    let base = edited(&terzaghi(), &[(LAW, STRENGTH)]);
    let scene = Scene::parse(&base, "scene.toml").expect("a scene that holds");
    let strength = scene.strength.expect("a strength");
    assert_eq!([strength.cohesion, strength.dilation_angle], [500.0, 10.0]);
    let sparse = edited(&base, &[("dilation_angle = 10.0\ntension_cutoff = 100.0\n", "")]);
    let strength = Scene::parse(&sparse, "scene.toml").expect("a scene that holds").strength.expect("a strength");
    assert_eq!((strength.dilation_angle, strength.tension_cutoff), (0.0, None));
    let mut list = String::new();
    for (case, edits) in STRENGTH_CASES {
        let error = refusal(case, &edited(&base, edits));
        list += &format!("{case}\n    {error}\n");
    }
    insta::with_settings!({
        description => "Guards the words and the line of every refusal of a Mohr-Coulomb soil.",
        omit_expression => true,
    }, {
        insta::assert_snapshot!(list);
    });
}

#[test]
fn every_message() {
    let base = terzaghi();
    let mut list = String::new();
    for (case, edits) in CASES {
        let error = refusal(case, &edited(&base, edits));
        list += &format!("{case}\n    {error}\n");
    }
    insta::with_settings!({
        description => "Guards the words and the line of every refusal of a scene.",
        omit_expression => true,
    }, {
        insta::assert_snapshot!(list);
    });
}

#[test]
fn truncated_files() {
    let base = terzaghi();
    let ends = [
        "",
        "name = \"terz",
        "[geometry.col",
        "[geometry.column]",
        "height = ",
        "[mesh]\ncell = 0.0",
        "law.linear_elastic]\n",
        "youngs_modulus = 2.0e",
        "left = \"roller",
        "darcy_inertia = tr",
        "[[stages]]\n",
        "drained = [\"to",
        "drained = [\"top\"",
        "until.time_f",
        "until.time_factor =",
    ];
    let mut list = String::new();
    for end in ends {
        let cut = base.find(end).expect("a part of the scene") + end.len();
        list += &format!("after {end:?}\n    {}\n", refusal(end, &base[..cut]));
    }
    insta::with_settings!({
        description => "Guards the words and the line for a scene file that ends too early.",
        omit_expression => true,
    }, {
        insta::assert_snapshot!(list);
    });
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let base = terzaghi();
    // From here on everything that is left out has a default.
    let complete = base.find("until.time_factor = 1").expect("the last stage") + "until.time_factor = 1".len();
    for cut in 0..complete {
        refusal(&format!("cut at byte {cut}"), &base[..cut]);
    }
    for cut in complete..base.len() {
        if Scene::parse(&base[..cut], "scene.toml").is_err() {
            refusal(&format!("cut at byte {cut}"), &base[..cut]);
        }
    }
}

#[test]
fn an_unreadable_file_is_named() {
    let path = Path::new("no/such/scene.toml");
    let message = Scene::load(path).expect_err("there is no such file").to_string();
    assert!(message.starts_with("no/such/scene.toml: expected a readable scene file, found: "), "{message}");
}

#[test]
fn endless_nesting_is_refused() {
    let text = format!("name = {}", "[".repeat(100_000));
    refusal("nesting", &text);
}

#[test]
fn the_line_check_can_fail() {
    let base = terzaghi();
    let text = edited(&base, &[("porosity = 0.30", "porosity = 1.0")]);
    let line = base.lines().position(|line| line.starts_with("porosity")).expect("a porosity") + 1;
    assert_eq!(refusal("porosity", &text).line, line);
    // A line added above must move the line that is reported.
    assert_eq!(refusal("porosity", &format!("\n{text}")).line, line + 1);
}

/// Scenes that cannot mean what they say, and still pass.
#[test]
fn contradictions_are_refused() {
    let cases: [(&str, Edits); 3] = [
        (
            "undrained equilibrium of a dry scene",
            &[
                (WATER, ""),
                ("darcy = \"face\"\ndarcy_inertia = true\n", ""),
                ("drained = [\"top\"]\n", ""),
                ("until.time_factor = 1.0", "until.time = 1.0"),
                (TIME_FACTORS, ""),
            ],
        ),
        (
            "a density that is not the unit weight over gravity",
            &[
                ("dimension =", "gravity = 9.81\ndimension ="),
                ("\"undrained-equilibrium\"", "\"geostatic\""),
                ("unit_weight = 9810.0", "unit_weight = 9810.0\ndensity = 500.0"),
            ],
        ),
        (
            "more nodes than memory holds",
            &[
                ("\"column\"", "\"plane-strain\""),
                ("width = 0.1", "width = 1000.0"),
                ("particles_per_cell = 4", "particles_per_cell = 1\nempty_cells_above = 1000000"),
            ],
        ),
    ];
    let base = terzaghi();
    for (case, edits) in cases {
        println!("{case}\n    {}", refusal(case, &edited(&base, edits)));
    }
}

/// Where numbers stand in a text.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let digits = |c: char| c.is_ascii_digit() || ".e-".contains(c);
    let start = |at: &usize| text[*at..].starts_with(|c: char| c.is_ascii_digit()) && text[..*at].ends_with([' ', '[']);
    let end = |at: usize| text[at..].find(|c| !digits(c)).map_or(text.len(), |length| at + length);
    (1..text.len()).filter(start).map(|at| at..end(at)).collect()
}

/// Numbers of any kind and size, as they may be written.
fn number() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<f64>().prop_map(|x| format!("{x:?}")),
        any::<i64>().prop_map(|x| x.to_string()),
        (-330..320_i32).prop_map(|exponent| format!("1.0e{exponent}")),
        (0..100_000_i64).prop_map(|x| x.to_string()),
    ]
}

/// Neither panics nor names a line that is not there.
fn survives(what: &str, text: &str) {
    if Scene::parse(text, "scene.toml").is_err() {
        refusal(what, text);
    }
}

/// The line of slope-at-rest.toml that no implicit integrator takes.
const FLIP: &str =
    "flip = 0.99 # takes the motions of particles that no node sees; at rest there are none, and nothing is lost\n";

/// Edits of scenes with a free surface and what each must name.
#[test]
fn bad_water_is_refused() {
    const FEED: &str = "left = { head = 1.0 }";
    const TABLE: &str = "[water.free_surface.feed]\nleft = { head = 1.0 }";
    const BLOCK: &str = "[geometry.column]\nheight = 1.0\nwidth = 1.0";
    const LEVEE: &str = "[geometry.outline]\npoints = [[0.0, 0.0], [3.0, 0.0], [1.0, 1.0], [0.0, 1.0]]";
    let cases: [(&str, &str, Edits, &str); 22] = [
        (
            "head below the base",
            "dam",
            &[(FEED, "left = { head = -0.5 }")],
            "a head above the lowest soil at the side (m), here above 0 m",
        ),
        ("head at the base", "dam", &[(FEED, "left = { head = 0.0 }")], "above 0 m"),
        (
            "no room for water",
            "infiltration",
            &[("porosity = 0.30", "porosity = 0.01")],
            "mobile water needs open pores",
        ),
        ("pond below the top", "infiltration", &[("head = 1.25", "head = 0.9")], "the top of the soil"),
        ("no pressure head", "wetting-front", &[("head = 0.25", "head = 0.0")], "pressure head above 0"),
        (
            "feed on a wall with no soil",
            "dam",
            &[(FEED, "right = { head = 1.0 }"), ("cell = 0.05", "cell = 0.05\nempty_cells_beside = 2")],
            "wall with no soil",
        ),
        (
            "feed under a soil that is not there",
            "dam",
            &[(FEED, "top = { head = 1.5 }"), ("cell = 0.05", "cell = 0.05\nempty_cells_above = 2")],
            "wall with no soil",
        ),
        (
            "water outside the soil",
            "dam",
            &[(TABLE, "[water.free_surface]\nwet = [[0.0, 0.0], [1.2, 0.0], [0.0, 1.0]]")],
            "outside its outline",
        ),
        ("a level above the soil", "dam", &[(TABLE, "[water.free_surface]\nlevel = 1.1")], "here top 1 m"),
        (
            "two first states",
            "dam",
            &[(TABLE, "[water.free_surface]\nlevel = 0.5\nwet = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]")],
            "not both",
        ),
        (
            "a line of water",
            "dam",
            &[(TABLE, "[water.free_surface]\nwet = [[0.0, 0.0], [1.0, 0.0]]")],
            "at least 3 points",
        ),
        ("full before any front", "dam", &[(TABLE, "[water.free_surface]\nsaturation = 1.0")], "0 <= saturation < 1"),
        ("head and velocity", "dam", &[(FEED, "left = { head = 1.0, velocity = 1e-5 }")], "exactly one"),
        ("neither", "dam", &[(FEED, "left = {}")], "exactly one"),
        ("a head above an outline", "dam", &[(BLOCK, LEVEE), ("head = 1.0", "head = 1.1")], "here top 1 m"),
        ("a height with a head", "dam", &[(FEED, "left = { head = 1.0, height = 1.0 }")], "which is one"),
        ("a feed that takes", "dam", &[(FEED, "left = { velocity = -1e-5 }")], "above 0"),
        ("a feed beside a column", "infiltration", &[("top = {", "left = {")], "bottom or the top"),
        ("one integrator for both phases", "dam", &[("\"staggered\"", "\"explicit\"")], "staggered"),
        ("no free surface", "dam", &[(TABLE, "")], "[water.free_surface] with it"),
        ("an unknown coupling", "dam", &[("drained = [", "coupling = \"sun\"\ndrained = [")], "\"seepage\""),
        (
            "a coupling without staggered steps",
            "hydrostatic",
            &[("drained = [", "coupling = \"soil\"\ndrained = [")],
            "staggered",
        ),
    ];
    for (case, scene, edits, names) in cases {
        let error = refusal(case, &edited(&scene_text(scene), edits));
        println!("{case}\n    {error}");
        assert!(error.to_string().contains(names), "{case}: {error}");
    }
}

/// Edits of the scene of a levee, or of one that is not for failure, and what each must name.
#[test]
fn bad_failure_is_refused() {
    const HEAD: &str = "feed.left = { head = 2.3 }";
    const WET: &str = "wet = [[0.0, 0.0], [8.35, 0.0], [0.0, 2.3]]";
    const DRIVER: &str = "integrator = \"staggered\"";
    const BASE: &str = "peak_angle = 30.0\nresidual_angle = 8.5\nslip_distance = 0.02";
    const OUTLINE: &str = "[[0.0, 0.0], [9.0, 0.0], [3.0, 3.0], [0.0, 3.0]]";
    let cases: [(&str, &str, Edits, &str); 40] = [
        ("head above the crest", "levee", &[(HEAD, "feed.left = { head = 3.1 }")], "here top 3 m"),
        ("a feed above the crest", "levee", &[(HEAD, "feed.left = { velocity = 1e-5, height = 3.5 }")], "here top 3 m"),
        ("head at the base", "levee", &[(HEAD, "feed.left = { head = 0.0 }")], "above 0 m"),
        ("head that is not a number", "levee", &[(HEAD, "feed.left = { head = nan }")], "above 0 m"),
        ("feed on a missing wall", "levee", &[(HEAD, "feed.right = { head = 1.0 }")], "a wall with no soil"),
        (
            "feed on a side the soil meets in a point",
            "levee",
            &[(HEAD, "feed.right = { head = 1.0 }"), ("empty_cells_beside = 28\n", "")],
            "a wall with no soil",
        ),
        ("a tank and no wall", "levee", &[("left = \"roller\"", "left = \"free\"")], "boundaries.left = \"roller\""),
        (
            "failure in dry soil",
            "collapse-dry",
            &[("[[stages]]\n", "[[stages]]\ncoupling = \"full\"\n")],
            "[water.free_surface] with coupling = \"full\"",
        ),
        ("feed in the air", "levee", &[(HEAD, "feed.top = { head = 3.1 }")], "a wall with no soil"),
        ("rain with a height", "levee", &[(HEAD, "feed.top = { velocity = 1e-5, height = 3.5 }")], "it is rain"),
        (
            "a pond on the crest",
            "levee",
            &[(HEAD, "feed.top = { head = 3.5 }"), ("empty_cells_above = 2\n", "")],
            "no water may pond",
        ),
        ("an unknown side", "levee", &[(HEAD, "feed.front = { head = 1.0 }")], "left"),
        (
            "water above the slope",
            "levee",
            &[(WET, "wet = [[0.0, 0.0], [9.0, 0.0], [6.0, 2.0]]")],
            "outside its outline",
        ),
        (
            "water above the crest",
            "levee",
            &[(WET, "wet = [[0.0, 0.0], [2.0, 0.0], [0.0, 3.2]]")],
            "outside its outline",
        ),
        ("a level above the crest", "levee", &[(WET, "level = 3.2")], "here top 3 m"),
        (
            "soil without strength",
            "levee",
            &[("\nfriction_angle = 30.0", "\nfriction_angle = 0.0"), ("\ncohesion = 500.0", "\ncohesion = 0.0")],
            "a cohesion above 0",
        ),
        ("friction of 90", "levee", &[("\nfriction_angle = 30.0", "\nfriction_angle = 90.0")], "0 <= phi < 90"),
        ("a smooth base", "levee", &[(BASE, "friction_angle = 0.0")], "or an adhesion"),
        (
            "a base that peaks at 0",
            "levee",
            &[("peak_angle = 30.0\nresidual_angle = 8.5", "peak_angle = 0.0\nresidual_angle = 0.0")],
            "or an adhesion",
        ),
        (
            "rain that rises",
            "infiltration",
            &[("head = 1.25", "velocity = 1e-5, times = [[0.0, -1.0]]")],
            "factor of 0 or more",
        ),
        (
            "a head in time",
            "infiltration",
            &[("head = 1.25", "head = 1.25, times = [[0.0, 1.0]]")],
            "times with a velocity",
        ),
        ("a base of 90", "levee", &[("peak_angle = 30.0", "peak_angle = 90.0")], "0 <= angle < 90"),
        ("a coarse mesh", "levee", &[("cell = 0.2 ", "cell = 0.8 ")], "a cell of at most 0.75 m"),
        (
            "a flat slope on a coarse mesh",
            "levee",
            &[
                ("[3.0, 3.0], [0.0, 3.0]", "[3.0, 1.5], [0.0, 1.5]"),
                ("cell = 0.2 ", "cell = 0.4 "),
                (WET, "level = 1.0"),
                (HEAD, "feed.left = { head = 1.0 }"),
            ],
            "at most 0.375 m",
        ),
        ("failure and no stage for it", "levee", &[("coupling = \"full\"\n", "")], "a stage with coupling = \"full\""),
        (
            "two stages",
            "levee",
            &[("[[stages]]\n", "[[stages]]\ncoupling = \"full\"\ndrained = \"none\"\nuntil.time = 1.0\n[[stages]]\n")],
            "one stage with coupling = \"full\"",
        ),
        (
            "until it rests",
            "levee",
            &[("until.time = 64800.0 # to 24 h", "until.rest = { speed = 1e-3, at_most = 1.0 }")],
            "a time (s)",
        ),
        ("no time at all", "levee", &[("until.time = 64800.0", "until.time = 0.0")], "above 0"),
        ("an unknown driver", "levee", &[(DRIVER, "integrator = \"three-clocks\"")], "\"coupled\""),
        ("another driver", "levee", &[(DRIVER, "integrator = \"semi-implicit\"")], "\"coupled\" or \"explicit\""),
        (
            "explicit and incompressible",
            "levee",
            &[(DRIVER, "integrator = \"explicit\""), ("bulk_modulus = 2.2e9", "bulk_modulus = inf")],
            "finite bulk modulus",
        ),
        (
            "together without a stage for it",
            "dam",
            &[(DRIVER, "integrator = \"coupled\"")],
            "coupling = \"full\" with it",
        ),
        ("a point in the air", "levee", &[("[5.5, 1.2]]", "[5.5, 2.2]]")], "a place in the soil"),
        ("a point that is not a number", "levee", &[("[5.5, 1.2]]", "[nan, 1.2]]")], "a place in the soil"),
        ("a point on a line", "levee", &[("[5.5, 1.2]]", "[5.5]]")], "2"),
        ("a level beyond the toe", "levee", &[("7.0, 8.0]", "7.0, 9.5]")], "here width 9 m"),
        ("a level that is not a number", "levee", &[("7.0, 8.0]", "7.0, nan]")], "here width 9 m"),
        ("a clock before its time", "levee", &[("starts_at = 21600.0", "starts_at = -1.0")], "0 or more (s)"),
        ("an unknown key", "levee", &[("starts_at = 21600.0", "start_at = 21600.0")], "starts_at"),
        ("soil above the mesh", "levee", &[(OUTLINE, "[[0.0, 0.0], [9.0, 0.0], [3.0, -3.0]]")], "y >= 0"),
    ];
    for (case, scene, edits, names) in cases {
        let error = refusal(case, &edited(&scene_text(scene), edits));
        println!("{case}\n    {error}");
        assert!(error.to_string().contains(names), "{case}: {error}");
        let is_fault = |line: &str| line.starts_with("scene.toml:") || line.starts_with("    did you mean `");
        assert!(error.to_string().lines().all(is_fault), "{case}: {error}");
    }
    // What is sound beside them: water up to the crest, a base that is held by adhesion alone, pressure from below.
    for edits in [
        &[(HEAD, "feed.left = { head = 3.0 }")][..],
        &[(BASE, "friction_angle = 0.0\nadhesion = 1000.0")],
        &[(HEAD, "feed.bottom = { head = 4.0 }")],
        &[(WET, "level = 3.0")],
        &[(HEAD, "feed.left = { velocity = 2e-5 }")],
    ] {
        let text = edited(&scene_text("levee"), edits);
        if let Err(error) = Scene::parse(&text, "scene.toml") {
            panic!("{edits:?}: {error}");
        }
    }
}

/// The drivers of a levee from the command line.
#[test]
fn bad_flags_of_a_levee_are_named() {
    let text = scene_text("levee");
    let message = |flags: Flags| Scene::parse_with(&text, "scene.toml", &flags).expect_err("a bad flag").to_string();
    let driver = |word: &str| Flags { driver: Some(word.to_owned()), ..Flags::default() };
    let unknown = message(driver("clockwork"));
    assert!(unknown.starts_with("--driver: expected one of") && unknown.contains("\"staggered\""), "{unknown}");
    let coarse = message(Flags { cell: Some(1.0), ..Flags::default() });
    assert!(
        coarse
            .starts_with("--mesh: expected at least 4 cells over the height of a slope, here a cell of at most 0.75 m"),
        "{coarse}"
    );
    let zero = message(Flags { cell: Some(0.0), ..Flags::default() });
    assert!(zero.starts_with("--mesh: "), "{zero}");
    let odd = message(Flags { particles_per_cell: Some(5), ..Flags::default() });
    assert!(odd.starts_with("--ppc: "), "{odd}");
    for word in ["staggered", "coupled", "explicit"] {
        Scene::parse_with(&text, "scene.toml", &driver(word)).unwrap();
    }
}

/// Edits of the scene of a slope (or of a block) and what each must name.
#[test]
fn bad_ground_is_refused() {
    let cases: [(&str, &str, Edits, &str); 27] = [
        ("crossing", "slope-at-rest", &[("[3.0, 3.0], [0.0, 3.0]", "[0.0, 3.0], [3.0, 3.0]")], "simple polygon"),
        ("two points", "slope-at-rest", &[(", [3.0, 3.0], [0.0, 3.0]", "")], "at least 3 points"),
        ("left of the wall", "slope-at-rest", &[("[0.0, 3.0]]", "[-0.1, 3.0]]")], "x >= 0"),
        ("three numbers", "slope-at-rest", &[("[0.0, 3.0]]", "[0.0, 3.0, 0.0]]")], "points"),
        ("an outline of a column", "slope-at-rest", &[("\"plane-strain\"", "\"column\"")], "plane-strain"),
        (
            "implicit",
            "slope-at-rest",
            &[
                ("\"explicit\"", "\"quasi-static\""),
                ("safety = 0.5\n", ""),
                (FLIP, ""),
                ("damping = 40.0", "damping = 0.0"),
            ],
            "explicit",
        ),
        ("splines", "slope-at-rest", &[("\"centre\"", "\"bspline2\"")], "\"linear\""),
        ("unknown seeding", "slope-at-rest", &[("empty_cells_above = 1", "seeding = \"cut\"")], "\"whole\""),
        (
            "seeding of a column",
            "self-weight",
            &[("particles_per_cell", "seeding = \"whole\"\nparticles_per_cell")],
            "outline",
        ),
        (
            "rest and time",
            "slope-at-rest",
            &[("at_most = 20.0 }", "at_most = 20.0 }\nuntil.time = 1.0")],
            "exactly one",
        ),
        ("no speed of rest", "slope-at-rest", &[("speed = 1.0e-12", "speed = 0.0")], "above 0"),
        (
            "no gravity to turn",
            "block-on-incline",
            &[("start = \"geostatic\"\nstart_k0 = 0.0\ngravity = 9.81\n", "")],
            "gravity with it",
        ),
        ("vertical slope", "block-on-incline", &[("slope_angle = 25.0", "slope_angle = 90.0")], "-90 < angle < 90"),
        (
            "too strong an earthquake",
            "block-on-incline",
            &[("slope_angle = 25.0", "seismic_coefficient = 1.5")],
            "-1 < coefficient < 1",
        ),
        (
            "slope of a column",
            "block-on-incline",
            &[
                ("\"plane-strain\"", "\"column\""),
                ("empty_cells_beside = 24\n", ""),
                ("left = \"free\"\nright = \"free\"\n", ""),
            ],
            "plane-strain",
        ),
        (
            "empty cells beside a column",
            "block-on-incline",
            &[("\"plane-strain\"", "\"column\"")],
            "column cannot move",
        ),
        ("one side periodic", "infinite-slope", &[("left = \"periodic\"", "left = \"free\"")], "both sides"),
        (
            "periodic with room",
            "infinite-slope",
            &[("empty_cells_above = 1", "empty_cells_beside = 1")],
            "without empty_cells_beside",
        ),
        ("coulomb without base", "infinite-slope", &[("[base]\nfriction_angle = 30.0\n", "")], "[base]"),
        ("base without coulomb", "infinite-slope", &[("bottom = \"coulomb\"", "bottom = \"fixed\"")], "\"coulomb\""),
        ("friction of 90", "infinite-slope", &[("friction_angle = 30.0", "friction_angle = 90.0")], "0 <= angle < 90"),
        (
            "both frictions",
            "infinite-slope",
            &[("friction_angle = 30.0", "friction_angle = 30.0\npeak_angle = 30.0")],
            "alone",
        ),
        (
            "residual above peak",
            "block-weakens",
            &[("residual_angle = 8.5", "residual_angle = 20.5")],
            "peak_angle (degrees), here peak_angle = 20",
        ),
        ("no slip distance", "block-weakens", &[("slip_distance = 0.05", "slip_distance = 0.0")], "above 0"),
        (
            "negative adhesion",
            "block-weakens",
            &[("slip_distance = 0.05", "slip_distance = 0.05\nadhesion = -1.0")],
            "0 or more",
        ),
        (
            "one component",
            "block-stops",
            &[("start_velocity = [1.0, 0.0]", "start_velocity = [1.0]")],
            "start_velocity",
        ),
        ("K0 without weight", "block-stops", &[("start = \"geostatic\"", "start = \"unloaded\"")], "geostatic"),
    ];
    for (case, scene, edits, names) in cases {
        let error = refusal(case, &edited(&scene_text(scene), edits));
        println!("{case}\n    {error}");
        assert!(error.to_string().contains(names), "{case}: {error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn deletions_never_panic(start in 0..1000_usize, length in 1..200_usize) {
        let base = terzaghi();
        prop_assume!(start < base.len());
        let end = (start + length).min(base.len());
        prop_assume!(base.is_char_boundary(start) && base.is_char_boundary(end));
        survives("deletion", &format!("{}{}", &base[..start], &base[end..]));
    }

    #[test]
    fn insertions_never_panic(
        start in 0..1000_usize,
        what in "\\PC{0,6}|[\\x00-\\x20\"'\\[\\]{}=.,#eé漢🦀-]{1,6}",
    ) {
        let base = terzaghi();
        prop_assume!(start <= base.len() && base.is_char_boundary(start));
        survives("insertion", &format!("{}{what}{}", &base[..start], &base[start..]));
    }

    #[test]
    fn other_numbers_never_panic(
        which in any::<prop::sample::Index>(),
        number in number(),
        plane in any::<bool>(),
        scene in any::<prop::sample::Index>(),
    ) {
        let scenes = [terzaghi(), scene_text("terzaghi-quasi-static"), scene_text("mandel"), scene_text("strip"), scene_text("terzaghi-large-strain"), scene_text("oedometer-plastic")];
        let base = &scenes[scene.index(scenes.len())];
        let places = numbers(base);
        prop_assert!(places.len() > 15);
        let place = &places[which.index(places.len())];
        let text = format!("{}{number}{}", &base[..place.start], &base[place.end..]);
        survives("number", &if plane { text.replace("\"column\"", "\"plane-strain\"") } else { text });
    }
}

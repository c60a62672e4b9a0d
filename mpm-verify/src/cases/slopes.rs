//! Factors of safety of slopes of several soils by strength reduction, beside published ones.
//!
//! Without dilation, as here, a soil bears less than limit equilibrium says, and the less the finer the mesh: ACADS 1(c) has 1.37 on cells
//! of 1 m and 1.345 on 0.5 m; with associated flow 1.40 to 1.42 on 1 m. Programs of limit equilibrium have 1.35 to 1.41.

use mpm_core::failure::{Driver, Outcome as Settled};
use mpm_core::scene::Scene;

use super::{Error, Mutant, Outcome, Program, Unfit};
use crate::experiment::number::Label;
use crate::experiment::refinement::RUNS;
use crate::norms::worst;

/// A slope with its published factor of safety.
struct Slope {
    what: &'static str,
    /// Corners of the outline, m; the toe is on the right.
    points: &'static [[f64; 2]],
    /// Whether the ground ends at a wall on the right; else there is room for what slides.
    walled: bool,
    /// Weight, cohesion (kN/m3, kPa) and friction (degrees) where no region says otherwise.
    soil: [f64; 3],
    /// Corners (m) of the other soils with the same three numbers.
    regions: &'static [(&'static [[f64; 2]], [f64; 3])],
    published: f64,
}

/// Three layers, upside right: c = 0 and 38 degrees, 5.3 kPa and 23 degrees, 7.2 kPa and 20 degrees, 19.5 kN/m3 (Giam & Donald 1989).
const ACADS: [Slope; 1] = [Slope {
    what: "ACADS 1(c)",
    points: &[[0.0, 0.0], [50.0, 0.0], [50.0, 5.0], [40.0, 5.0], [20.0, 15.0], [0.0, 15.0]],
    walled: true,
    soil: [19.5, 7.2, 20.0],
    regions: &[
        (
            &[[40.0, 5.0], [20.0, 15.0], [0.0, 15.0], [0.0, 11.0], [16.0, 11.0], [20.0, 9.0], [30.0, 7.0]],
            [19.5, 0.0, 38.0],
        ),
        (&[[30.0, 7.0], [20.0, 9.0], [16.0, 11.0], [0.0, 11.0], [0.0, 4.0], [18.0, 4.0]], [19.5, 5.3, 23.0]),
    ],
    published: 1.39,
}];

/// A slope 2:1 on a firm base, phi = 20 degrees and c = 0.05 gamma H, below and above the level of still water (Griffiths & Lane 1999,
/// example 5): what the water bears of the soil below its level is left out of its weight.
const DRAWDOWN: [Slope; 3] = [
    Slope {
        what: "water at the crest",
        regions: &[(&[[0.0, -1.0], [40.0, -1.0], [40.0, 11.0], [0.0, 11.0]], UNDER_WATER)],
        published: 1.85,
        ..DRY
    },
    Slope {
        what: "water down by 0.7 H",
        regions: &[(&[[0.0, -1.0], [40.0, -1.0], [40.0, 3.0], [0.0, 3.0]], UNDER_WATER)],
        published: 1.30,
        ..DRY
    },
    Slope { what: "no water", ..DRY },
];
const DRY: Slope = Slope {
    what: "",
    points: &[[0.0, 0.0], [32.0, 0.0], [12.0, 10.0], [0.0, 10.0]],
    walled: false,
    soil: [20.0, 10.0, 20.0],
    regions: &[],
    published: 1.40,
};
const UNDER_WATER: [f64; 3] = [20.0 - 9.81, 10.0, 20.0];

/// A friction that is lower.
const WEAKER: &str = "friction 10 % lower";

/// Three layers.
pub const ACADS_1C: Program = Program {
    name: "slope-acads-1c",
    about: "factor of safety of ACADS 1(c), three layers: 1.39 published",
    run: || outcome(&ACADS, 1.0),
    mutant: Some(Mutant { what: WEAKER, run: || outcome(&ACADS, 0.9) }),
};

/// Water that falls.
pub const FALLING_WATER: Program = Program {
    name: "slope-drawdown",
    about: "factor of safety of a slope whose water falls (Griffiths & Lane, example 5): 1.85, 1.30, 1.40 published",
    run: || outcome(&DRAWDOWN, 1.0),
    mutant: Some(Mutant { what: WEAKER, run: || outcome(&DRAWDOWN, 0.9) }),
};

/// The scene of a slope.
fn scene(slope: &Slope, friction: f64) -> Result<Scene, Error> {
    let law = |[_, cohesion, angle]: [f64; 3]| {
        format!(
            "law.mohr_coulomb = {{ youngs_modulus = 1e8, poisson_ratio = 0.3, cohesion = {:?}, friction_angle = {:?} }}",
            1e3 * cohesion,
            friction * angle
        )
    };
    // Porosity 0.3, no water in the pores.
    let density = |weight: f64| 1e3 * weight / 9.81 / 0.7;
    let regions: String = slope
        .regions
        .iter()
        .map(|(polygon, soil)| {
            format!("[[regions]]\npolygon = {polygon:?}\ngrain_density = {:?}\n{}\n", density(soil[0]), law(*soil))
        })
        .collect();
    let (right, room) = if slope.walled { ("roller", 0) } else { ("free", 5) };
    let text = format!(
        "name = \"slope\"
dimension = \"plane-strain\"
start = \"geostatic\"
gravity = 9.81
geometry.outline = {{ points = {:?} }}
mesh = {{ cell = 1.0, particles_per_cell = 4, empty_cells_above = 1, empty_cells_beside = {room} }}
[soil]
grain_density = {:?}
porosity = 0.3
{}
{regions}
[water]
hydraulic_conductivity = 1e-5
bulk_modulus = 2.2e9
unit_weight = 9810.0
free_surface.saturation = 0.0
[boundaries]
bottom = \"fixed\"
right = \"{right}\"
[scheme]
shape = \"centroid\"
flip = 0.99
[time]
integrator = \"staggered\"
safety = 0.5
[[stages]]
coupling = \"full\"
drained = \"none\"
until.time = 3600.0
",
        slope.points,
        density(slope.soil[0]),
        law(slope.soil),
    );
    Ok(Scene::parse(&text, slope.what)?)
}

/// Factors over the published ones, the friction angles wrong by a factor.
fn outcome(slopes: &[Slope], friction: f64) -> Result<Outcome, Error> {
    let (mut off, mut notes) = (Vec::new(), Vec::new());
    for slope in slopes {
        let scene = scene(slope, friction)?;
        let mut driver = Driver::new(&scene)?;
        if driver.load()?.outcome != Settled::Stands {
            return Err(Unfit("the slope does not stand"));
        }
        let found = driver.safety(WITHIN, &mut |_| ())?;
        let middle = 0.5 * (found.low + found.high);
        off.push(middle / slope.published - 1.0);
        notes.push((format!("factor found, {}", slope.what), middle, "-".to_owned()));
        notes.push((format!("factor published, {}", slope.what), slope.published, "-".to_owned()));
    }
    Ok(Outcome {
        integrator: "staggered".to_owned(),
        scheme: "centroid".to_owned(),
        errors: vec![(off.len() as f64, worst(off.into_iter()))],
        required_error: 0.05,
        refined_by: RUNS,
        notes,
        kind: Label::Regression,
        ..Outcome::default()
    })
}

/// Width of the bracket.
const WITHIN: f64 = 0.02;

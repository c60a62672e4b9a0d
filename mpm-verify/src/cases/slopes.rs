//! Factors of safety of published slopes by strength reduction with associated flow, on their coarser meshes. All of them on two meshes, and
//! with Davis' strength: `mpm-verify slope`.

use mpm_core::failure::Search;
use mpm_core::scene::{Flags, Reduction, Scene};

use super::{Error, Lacks, Mutant, Outcome, Program};
use crate::experiment::number::Label;
use crate::experiment::refinement::RUNS;
use crate::norms::worst;
use crate::scenes::SLOPES;
use crate::slope::State;
use crate::slope::ladder::{Published, published};

/// Slopes by their names in `reference-data/slopes`.
const LAYERS: [&str; 1] = ["acads-1c"];
const DRAWDOWN: [&str; 3] = ["griffiths-lane-5-full", "griffiths-lane-5-low", "griffiths-lane-1"];
/// A friction that is lower.
const WEAKER: &str = "friction 10 % lower";

/// Three layers.
pub const ACADS_1C: Program = Program {
    name: "slope-acads-1c",
    about: "factor of safety of ACADS 1(c), three layers: 1.39 published",
    run: || outcome(&LAYERS, 1.0),
    mutant: Some(Mutant { what: WEAKER, run: || outcome(&LAYERS, 0.9) }),
};

/// Water that falls.
pub const FALLING_WATER: Program = Program {
    name: "slope-drawdown",
    about: "factor of safety of a slope whose water falls (Griffiths & Lane, example 5): 1.85, 1.30, 1.38 published",
    run: || outcome(&DRAWDOWN, 1.0),
    mutant: Some(Mutant { what: WEAKER, run: || outcome(&DRAWDOWN, 0.9) }),
};

/// Davis' strength against what it comes to for one soil without dilation.
pub const DAVIS: Program = Program {
    name: "slope-davis",
    about: "factor of safety with Davis' strength against the closed form for one soil, sqrt(F^2 - tan^2 phi) of the associated factor F",
    run: || davis(|factor, tangent| (factor * factor - tangent * tangent).sqrt()),
    mutant: Some(Mutant {
        what: "Davis A, F cos phi, in its place",
        run: || davis(|factor, tangent| factor / tangent.hypot(1.0)),
    }),
};

/// Size and stiffness do not matter by themselves.
pub const SIMILAR: Program = Program {
    name: "slope-similar",
    about: "factor of safety of a slope ten times as large, and of soil ten times as stiff: as it was, within 0.01",
    run: || similar(TIMES),
    mutant: Some(Mutant { what: "cohesion 20 % short of what the size asks for", run: || similar(0.8 * TIMES) }),
};

/// A published slope on its coarser mesh, the friction angles wrong by a factor.
fn scene(slope: &Published, friction: f64) -> Result<Scene, Error> {
    let text = SLOPES.iter().find(|(name, _)| *name == slope.name).ok_or(Lacks("scene of that name"))?.1;
    let scene = Scene::parse_with(text, &slope.name, &Flags { cell: Some(slope.coarse_m), ..Flags::default() })?;
    if friction == 1.0 {
        return Ok(scene);
    }
    let soils = std::iter::once("soil".to_owned()).chain((0..scene.regions.len()).map(|k| format!("regions.{k}")));
    let keys = soils.map(|soil| format!("{soil}.law.mohr_coulomb.friction_angle"));
    let changes: Vec<_> = keys.filter_map(|key| Some((key.clone(), (friction * scene.number(&key)?).into()))).collect();
    Ok(scene.patched(&changes)?)
}

/// Factors over the published ones, the friction angles wrong by a factor.
fn outcome(names: &[&str], friction: f64) -> Result<Outcome, Error> {
    let (mut off, mut notes) = (Vec::new(), Vec::new());
    let all = published()?;
    for name in names {
        let slope = all.iter().find(|slope| slope.name == *name).ok_or(Lacks("slope of that name"))?;
        let scene = scene(slope, friction)?;
        let search = Search { by: Reduction::Associated, within: WITHIN, guess: slope.factor };
        let found = State::after(&scene, 0.0)?.factor(&search, &mut |_, _| ())?.bracket;
        let middle = 0.5 * (found.low + found.high);
        off.push(middle / slope.factor - 1.0);
        notes.push((format!("factor found, {}", slope.title), middle, "-".to_owned()));
        notes.push((format!("factor published, {}", slope.title), slope.factor, "-".to_owned()));
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

/// The factor with Davis' strength over a function of the associated one and tan(phi).
fn davis(exact: fn(f64, f64) -> f64) -> Result<Outcome, Error> {
    let all = published()?;
    let slope = all.iter().find(|slope| slope.name == "griffiths-lane-1").ok_or(Lacks("slope of that name"))?;
    let scene = scene(slope, 1.0)?;
    let state = State::after(&scene, 0.0)?;
    let factor = |by: Reduction| {
        let search = Search { by, within: 0.25 * WITHIN, guess: slope.factor };
        let found = state.factor(&search, &mut |_, _| ())?.bracket;
        Ok::<f64, Error>(0.5 * (found.low + found.high))
    };
    let [associated, davis] = [factor(Reduction::Associated)?, factor(Reduction::Davis)?];
    let tangent = scene.strength.ok_or(Lacks("strength"))?.friction_angle.to_radians().tan();
    let expected = exact(associated, tangent);
    let notes = [("associated", associated), ("Davis", davis), ("expected of Davis", expected)];
    Ok(Outcome {
        integrator: "staggered".to_owned(),
        scheme: "centroid".to_owned(),
        errors: vec![(1.0, (davis / expected - 1.0).abs())],
        required_error: 0.01,
        refined_by: RUNS,
        notes: notes.map(|(what, factor)| (what.to_owned(), factor, "-".to_owned())).to_vec(),
        ..Outcome::default()
    })
}

/// How much larger and stiffer the slopes of [`SIMILAR`] are.
const TIMES: f64 = 10.0;

/// The associated factor of one soil against that of a slope of more size, its cohesion so many times what it was, and of stiffer soil.
/// Weight over stiffness is ten times what it was in the first, a tenth in the second.
fn similar(cohesion: f64) -> Result<Outcome, Error> {
    let all = published()?;
    let slope = all.iter().find(|slope| slope.name == "acads-1a").ok_or(Lacks("slope of that name"))?;
    let small = scene(slope, 1.0)?;
    let points: Vec<[f64; 2]> = small.outline_or_box().into_iter().map(|point| point.map(|x| TIMES * x)).collect();
    let number = |key: &str| small.number(key).ok_or(Lacks("strength of one soil"));
    let (c, modulus) = ("soil.law.mohr_coulomb.cohesion", "soil.law.mohr_coulomb.youngs_modulus");
    let large = small.patched(&[
        ("geometry.outline.points", points.into()),
        ("mesh.cell", (TIMES * small.cell).into()),
        (c, (cohesion * number(c)?).into()),
    ])?;
    let stiff = small.patched(&[(modulus, TIMES * number(modulus)?)].map(|(key, value)| (key, value.into())))?;
    let search = Search { by: Reduction::Associated, within: 0.25 * WITHIN, guess: slope.factor };
    let factor = |scene: &Scene| {
        let found = State::after(scene, 0.0)?.factor(&search, &mut |_, _| ())?.bracket;
        Ok::<f64, Error>(0.5 * (found.low + found.high))
    };
    let [small, large, stiff] = [factor(&small)?, factor(&large)?, factor(&stiff)?];
    let notes = [("as published", small), ("ten times as large", large), ("ten times as stiff", stiff)];
    Ok(Outcome {
        integrator: "staggered".to_owned(),
        scheme: "centroid".to_owned(),
        errors: vec![(1.0, worst([large - small, stiff - small].into_iter()))],
        required_error: 0.01,
        refined_by: RUNS,
        notes: notes.map(|(what, factor)| (what.to_owned(), factor, "-".to_owned())).to_vec(),
        kind: Label::Regression,
        ..Outcome::default()
    })
}

/// Width of the bracket.
const WITHIN: f64 = 0.02;

//! A neutral case: what is given, what is asked, and what an answer is compared with.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::{FieldPoint, Places, ProfileRow};
use mpm_core::random::Random;
use mpm_core::scene::{Dimension, Fields, Scene, Until};
use serde_json::{Value as Json, json};

use super::equations::governing;
use super::given::{given, scaled};
use super::quantity::{At, Quantity, is_large, moves, of_measure};
use super::results::Row;
use super::units::Scale;
use super::values::{self, Values};
use crate::cases::suite::{problems, suite};
use crate::error::Error::{self, Found, Lacks};
use crate::experiment::comparison::Comparison;
use crate::experiment::spec::{Measure, Problem, Spec};

/// Largest errors of schemes of first and of second order on the finest mesh, where a case says nothing else.
const EXPECTED: [f64; 2] = [0.05, 0.01];
/// A case of ours that is off by less is right to round-off on any mesh: so may be any other code.
const BY_NATURE: f64 = 1e-5;
/// Least factor on stiffness, conductivity and load that a seed chooses; the largest is one over it.
const LEAST: f64 = 0.6;

/// A neutral case.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its name.
    pub name: String,
    /// What it is called.
    pub title: String,
    /// The problem in words.
    pub problem: String,
    /// The equations that it solves, in LaTeX: none of them is a solution.
    pub equations: Vec<String>,
    /// Where its solution is from.
    pub sources: Vec<String>,
    /// What is given, with units in the names of keys.
    pub given: Json,
    /// What is asked.
    pub wanted: Vec<Wanted>,
    /// What is refined.
    pub refined_by: String,
    /// Refinements, coarse to fine.
    pub refinements: Vec<f64>,
    /// Largest errors of schemes of first and of second order on the finest.
    pub expected: [f64; 2],
    /// Whether an answer without error is no sign that it was copied.
    pub exact_by_nature: bool,
    /// Whether the exact solution has inertia, and whether strains are large in it.
    pub physics: [bool; 2],
    /// What hidden parameters were drawn from; 0 for the published ones.
    pub seed: u64,
    /// Unit of its errors, `-` for shares.
    pub error_unit: &'static str,
    truth: Truth,
}

/// Something that is asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// Name of the quantity.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// What it is, with its sign.
    pub meaning: String,
    /// Times, s, or shares of a path.
    pub times: Vec<f64>,
    /// Where.
    pub place: Place,
}

/// Where something is asked.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// One number at each time.
    None,
    /// Numbers at heights y of the solver's own choice, one in each of its cells at least.
    Heights,
    /// Numbers at places (x, y) of the solver's own choice, one in each of its cells at least.
    Field,
    /// At these places, m.
    Given(Vec<[f64; 2]>),
}

/// What an answer is compared with.
#[derive(Debug, Clone)]
enum Truth {
    /// The measure of a case of the suite, on the scene that it runs.
    Scene { spec: &'static Spec, scene: Box<Scene>, quantities: &'static [&'static Quantity] },
    /// Numbers.
    Values { values: Box<Values>, scene: Option<Box<Scene>> },
}

/// What a neutral case is made of.
enum Source {
    Spec(&'static Spec, &'static Problem),
    Values(Box<Values>),
}

/// Names of all neutral cases, each with what it is made of.
fn listed() -> Result<Vec<(String, Source)>, Error> {
    let mut all: Vec<(String, Source)> = Vec::new();
    let mut seen = BTreeSet::new();
    for case in suite() {
        let (Some(spec), problem) = (case.spec(), &problems()[case.problem]) else { continue };
        let Some(measure) = &spec.measure else { continue };
        let named = spec.neutral.name.is_some();
        // Cases of one problem that differ in the method alone are one neutral case: the first of them.
        let first = seen.insert((case.problem, spec.scene.clone(), measure.of.clone()));
        let can = of_measure(&measure.of).is_some() && meshes(spec).is_some();
        if can && !spec.neutral.skip && (first || named) {
            all.push((spec.neutral.name.clone().unwrap_or_else(|| spec.name.clone()), Source::Spec(spec, problem)));
        }
    }
    all.extend(values::all()?.into_iter().map(|(name, values)| (name.to_owned(), Source::Values(Box::new(values)))));
    Ok(all)
}

/// Meshes that others can have: whole cells, two at least.
fn meshes(spec: &Spec) -> Option<&Vec<f64>> {
    let meshes = if spec.neutral.meshes.is_empty() { &spec.meshes } else { &spec.neutral.meshes };
    (meshes.len() >= 2 && meshes.iter().all(|cells| cells.fract() == 0.0)).then_some(meshes)
}

/// Names and titles of all neutral cases, read once.
static TITLES: LazyLock<Vec<(String, String)>> = LazyLock::new(|| match listed() {
    Ok(all) => {
        let title = |source: &Source| match source {
            Source::Spec(_, problem) => problem.title.clone(),
            Source::Values(values) => values.title.clone(),
        };
        all.into_iter().map(|(name, source)| (name, title(&source))).collect()
    }
    // A test reads them.
    Err(error) => panic!("neutral cases: {error}"),
});

/// Names and titles of all neutral cases.
pub fn titles() -> &'static [(String, String)] {
    &TITLES
}

/// Those that names choose, all without names, with the parameters of a seed; only these are made.
///
/// # Errors
/// A name that is not known, or parameters that no case can have.
pub fn chosen(names: &[String], seed: u64) -> Result<Vec<Case>, Error> {
    let all = listed()?;
    if let Some(wrong) = names.iter().find(|name| all.iter().all(|(own, _)| own != *name)) {
        let known = all.iter().map(|(name, _)| name.as_str());
        return Err(Error::unknown(("the name of a neutral case", "neutral-cases"), wrong, known));
    }
    let made = |(name, source): (String, Source)| {
        let case = match source {
            Source::Spec(spec, problem) => Case::of_spec(spec, problem).and_then(|case| case.ok_or(Lacks("mesh"))),
            Source::Values(values) => Case::of_values(&name, *values),
        };
        case.and_then(|case| case.drawn(seed)).map_err(|error| error.of(&name))
    };
    all.into_iter().filter(|(name, _)| names.is_empty() || names.contains(name)).map(made).collect()
}

impl Case {
    /// The neutral case of one of the suite; `None` where it has no meshes that others can have.
    ///
    /// # Errors
    /// A scene that is refused.
    pub fn of_spec(spec: &'static Spec, problem: &Problem) -> Result<Option<Self>, Error> {
        let measure = spec.measure.as_ref().ok_or(Lacks("measure"))?;
        let Some(quantities) = of_measure(&measure.of) else { return Ok(None) };
        let Some(meshes) = meshes(spec) else { return Ok(None) };
        let scene = spec.bases()?.into_iter().next().ok_or(Lacks("scene"))?;
        let case = Self {
            name: spec.neutral.name.clone().unwrap_or_else(|| spec.name.clone()),
            title: problem.title.clone(),
            problem: problem.problem.replace('\n', " "),
            equations: Vec::new(),
            sources: problem.sources.clone(),
            given: Json::Null,
            wanted: Vec::new(),
            refined_by: "cells over the height".to_owned(),
            refinements: meshes.clone(),
            expected: spec.neutral.expected.unwrap_or(EXPECTED),
            exact_by_nature: spec.error <= BY_NATURE && spec.order.is_none(),
            physics: [moves(&measure.of, &measure.reference), is_large(&measure.of, &measure.reference)],
            seed: 0,
            error_unit: if measure.of == "front" { "m" } else { "-" },
            truth: Truth::Scene { spec, scene: Box::new(scene), quantities },
        };
        case.asked().map(Some).map_err(|error| error.of(&spec.name))
    }

    fn of_values(name: &str, values: Values) -> Result<Self, Error> {
        let scene = values.scene.as_deref().map(|name| crate::scenes::load(name, &mpm_core::scene::Flags::default()));
        Self {
            name: name.to_owned(),
            title: values.title.clone(),
            problem: values.problem.replace('\n', " "),
            equations: values.equations.clone(),
            sources: values.sources.clone(),
            given: Json::Null,
            wanted: Vec::new(),
            refined_by: values.refined_by.clone(),
            refinements: values.refinements.clone(),
            expected: values.expected,
            exact_by_nature: values.exact_by_nature,
            physics: [values.inertia, values.large_strain],
            seed: 0,
            error_unit: "-",
            truth: Truth::Values { values: Box::new(values), scene: scene.transpose()?.map(Box::new) },
        }
        .asked()
    }

    /// With what is given and asked.
    fn asked(mut self) -> Result<Self, Error> {
        (self.given, self.wanted) = match &self.truth {
            Truth::Scene { scene, quantities, .. } => {
                let times = self.times(scene)?;
                self.equations = governing(scene, self.physics[0], self.physics[1]);
                let wanted = |quantity: &&Quantity| Wanted {
                    quantity: quantity.name.to_owned(),
                    unit: quantity.unit.to_owned(),
                    meaning: quantity.meaning.to_owned(),
                    times: times.clone(),
                    place: match quantity.at {
                        At::Whole { .. } => Place::None,
                        At::Height { .. } => Place::Heights,
                        At::Place { .. } | At::Soil if scene.dimension == Dimension::Column => Place::Heights,
                        At::Place { .. } | At::Soil => Place::Field,
                    },
                };
                (given(scene)?, quantities.iter().map(wanted).collect())
            }
            Truth::Values { values, scene } => {
                let wanted = |asked: &values::Asked| {
                    let mut times: Vec<f64> = asked.points.iter().map(|point| point.time).collect();
                    times.sort_by(f64::total_cmp);
                    times.dedup();
                    let places = asked.points.iter().filter_map(|point| Some([point.x?, point.y?]));
                    let mut places: Vec<[f64; 2]> = places.collect();
                    places.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
                    places.dedup();
                    Wanted {
                        quantity: asked.quantity.clone(),
                        unit: asked.unit.clone(),
                        meaning: asked.meaning.clone(),
                        times,
                        place: if places.is_empty() { Place::None } else { Place::Given(places) },
                    }
                };
                let known = scene.as_ref().map(|scene| given(scene)).transpose()?.or_else(|| values.given.clone());
                (known.ok_or(Lacks("given"))?, values.wanted.iter().map(wanted).collect())
            }
        };
        Ok(self)
    }

    /// Times at which an answer counts: those of the scene less those that its measure leaves out.
    fn times(&self, scene: &Scene) -> Result<Vec<f64>, Error> {
        let mut times = scene.observe_times.clone();
        // Where particles are is known at the end.
        let at_end = |quantity: &&Quantity| matches!(quantity.at, At::Soil);
        let only_end = matches!(&self.truth, Truth::Scene { quantities, .. } if quantities.iter().any(at_end));
        if let (Some(Until::Time(end)), true) =
            (scene.stages.last().map(|stage| stage.until), times.is_empty() || only_end)
        {
            times = vec![end];
        }
        let rows = |times: &[f64]| -> Vec<Row> {
            let Truth::Scene { quantities, .. } = &self.truth else { return Vec::new() };
            let at = |quantity: usize, time: f64, share: f64| Row {
                quantity,
                time,
                place: Some([share * scene.width, share * scene.height]),
                value: 1.0,
                line: 0,
            };
            let each = (0..quantities.len()).flat_map(|q| times.iter().map(move |time| (q, *time)));
            each.flat_map(|(q, time)| [at(q, time, 0.3), at(q, time, 0.6)]).collect()
        };
        // Some look at pairs of times, which have no row of their own.
        let Ok(found) = self.compared_with(scene, &rows(&times), &times) else { return Ok(times) };
        let dropped =
            |time: f64| found.rows.iter().any(|row| (row.time - time).abs() <= 1e-9 * time.abs() && !row.counts);
        times.retain(|time| !dropped(*time));
        Ok(times)
    }

    /// The problem of the suite that it belongs to, and the scene of its first mesh.
    pub fn scene(&self) -> Option<&Scene> {
        match &self.truth {
            Truth::Scene { scene, .. } => Some(scene),
            Truth::Values { scene, .. } => scene.as_deref(),
        }
    }

    /// The case of the suite that it is made of.
    pub fn spec(&self) -> Option<&'static Spec> {
        if let Truth::Scene { spec, .. } = self.truth { Some(spec) } else { None }
    }

    /// Lengths of the cells, m; nothing where something else is refined.
    pub fn cell(&self, refinement: f64) -> Option<f64> {
        let cells = self.refined_by.starts_with("cells");
        self.scene().filter(|_| cells).map(|scene| scene.height / refinement)
    }

    /// The same with parameters that are drawn from a seed: stiffness, conductivity and load where the exact solution is one for any
    /// of them, and another scale of lengths, times and stresses. Seed 0 is the published case.
    ///
    /// # Errors
    /// Parameters that the case cannot have.
    pub fn drawn(&self, seed: u64) -> Result<Self, Error> {
        if seed == 0 {
            return Ok(self.clone());
        }
        let own: u64 = self.name.bytes().fold(seed, |sum, byte| sum.wrapping_mul(0x100_0000_01b3) ^ u64::from(byte));
        let mut random = Random(own);
        let mut factor = || LEAST.powf(1.0 - 2.0 * random.unit());
        // Three digits: what is printed is what is meant.
        let rounded = |x: f64| (x * 1e3).round() / 1e3;
        let scale = Scale { length: rounded(factor()), time: rounded(factor()), stress: rounded(factor()) };
        let truth = match &self.truth {
            Truth::Values { values, scene: None } => {
                Truth::Values { values: Box::new(values.scaled(scale)?), scene: None }
            }
            Truth::Values { values, scene: Some(scene) } => {
                let scene = Some(Box::new(scaled(scene, scale)?));
                Truth::Values { values: Box::new(values.scaled(scale)?), scene }
            }
            Truth::Scene { spec, quantities, .. } => {
                let factors: Vec<f64> = ALTERED.iter().map(|_| rounded(factor())).collect();
                let scene = self.altered(spec, &factors)?;
                Truth::Scene { spec, scene: Box::new(scaled(&scene, scale)?), quantities }
            }
        };
        // Errors of places are in m.
        let expected = self.expected.map(|error| if self.error_unit == "m" { error * scale.length } else { error });
        // Words tell of the published case.
        let problem = format!(
            "{} Other numbers than these words have are given here: they are what counts.",
            self.problem.trim()
        );
        Self { seed, truth, expected, problem, ..self.clone() }.asked()
    }

    /// The scene of a case with other parameters, as far as its times follow them and its exact solution is one for any.
    fn altered(&self, spec: &Spec, factors: &[f64]) -> Result<Scene, Error> {
        let first = |bases: Vec<Scene>| bases.into_iter().next().ok_or(Lacks("scene"));
        let base = first(spec.bases()?)?;
        let number = |key: &str| base.number(key);
        let last = format!("stages.{}.until.time_factor", base.stages.len() - 1);
        if number(&last).is_none() {
            return Ok(base);
        }
        let mut patch = toml::Table::new();
        for (key, factor) in ALTERED.iter().zip(factors) {
            if let Some(value) = number(key) {
                patch.insert((*key).to_owned(), toml::Value::Float(value * factor));
            }
        }
        let Ok(scene) = spec.bases_with(&patch).and_then(first) else { return Ok(base) };
        let times = scene.observe_times.clone();
        let rows: Vec<Row> = times.iter().map(|time| Row::one(0, *time, 1.0)).collect();
        let known = |found: Comparison| found.rows.iter().flat_map(|row| &row.exact).all(|exact| exact.is_finite());
        let fits = self.compared_with(&scene, &rows, &times).is_ok_and(known);
        Ok(if fits { scene } else { base })
    }

    /// An answer on a refinement beside the exact one.
    ///
    /// # Errors
    /// A mesh that does not fit, or an answer that is too short for what is measured.
    pub(crate) fn compared(&self, refinement: f64, rows: &[Row]) -> Result<Comparison, Error> {
        self.compared_as(refinement, rows, &mut |_| {})
    }

    /// The same beside the exact solution of an altered problem; of numbers there is none.
    ///
    /// # Errors
    /// As [`Case::compared`], or a problem that has no exact solution.
    pub(crate) fn compared_as(
        &self,
        refinement: f64,
        rows: &[Row],
        alter: &mut dyn FnMut(&mut Fields),
    ) -> Result<Comparison, Error> {
        match &self.truth {
            Truth::Scene { spec, scene, .. } => {
                let before = spec.on(scene, refinement)?;
                let altered = before.edited(|fields| alter(fields))?;
                self.compared_with(&altered, rows, &scene.observe_times)
            }
            Truth::Values { values, .. } => Ok(values.compared(|asked, point| {
                let quantity = self.wanted.iter().position(|wanted| wanted.quantity == asked.quantity);
                let place = point.x.zip(point.y).map(|(x, y)| [x, y]);
                let is = |row: &&Row| Some(row.quantity) == quantity && row.is_at(point.time) && row.stands(place);
                rows.iter().find(is).map_or(f64::NAN, |row| row.value)
            })),
        }
    }

    fn compared_with(&self, scene: &Scene, rows: &[Row], observed: &[f64]) -> Result<Comparison, Error> {
        let Truth::Scene { spec, quantities, .. } = &self.truth else { return Err(Found("no scene".to_owned())) };
        let run = run(scene, quantities, rows, observed);
        let measure: &Measure = spec.measure.as_ref().ok_or(Lacks("measure"))?;
        measure.of_scene(scene)?(&run)
    }

    /// What a run of ours says to this case on a refinement.
    ///
    /// # Errors
    /// A quantity that the run does not have.
    pub fn answers(&self, run: &Run) -> Result<Vec<Row>, Error> {
        let Truth::Scene { quantities, .. } = &self.truth else { return Err(Found("no scene".to_owned())) };
        let first = run.samples.first().ok_or(Lacks("sample"))?;
        let mut rows = Vec::new();
        for (number, (quantity, wanted)) in quantities.iter().zip(&self.wanted).enumerate() {
            for time in &wanted.times {
                let near = |s: &&Sample| (s.stage_time - time).abs() <= 1e-9 * time.abs();
                let last = run.samples.last().map(|s| s.stage);
                let sample = run.samples.iter().rev().filter(|s| Some(s.stage) == last).find(near);
                let sample = sample.ok_or_else(|| Found(format!("no sample at {time} s")))?;
                let row = |place, value| Row { quantity: number, time: *time, place, value, line: 0 };
                match &quantity.at {
                    At::Whole { get, .. } => rows.push(row(None, get(first, sample))),
                    At::Height { get, .. } => {
                        let all = sample.state.profile.iter();
                        rows.extend(all.map(|p| row(Some([0.0, p.material_height_m]), get(p))));
                    }
                    At::Place { get, .. } => {
                        let whole = sample.state.field.iter().filter(|p| p.soil > WHOLE);
                        rows.extend(whole.map(|p| row(Some([p.x_m, p.y_m]), get(p))));
                    }
                    At::Soil => rows.extend(run.places.solid.iter().map(|p| row(Some([p[0], p[1]]), p[2]))),
                }
            }
        }
        if let Some(row) = rows.iter().find(|row| row.value.is_nan()) {
            return Err(Found(format!("no {} at {} s in this run", self.wanted[row.quantity].quantity, row.time)));
        }
        Ok(rows)
    }

    /// `case.json`.
    pub fn json(&self) -> Json {
        let wanted = |wanted: &Wanted| {
            let place = match &wanted.place {
                Place::None => json!("none: one number at each time, x_m and y_m empty"),
                Place::Heights => json!("y_m of your own choice, one in each cell at least; x_m empty or 0"),
                Place::Field => json!("x_m and y_m of your own choice, one in each cell inside the soil at least"),
                Place::Given(places) => json!(places),
            };
            json!({ "quantity": wanted.quantity, "unit": wanted.unit, "meaning": wanted.meaning, "times_s": wanted.times, "places": place })
        };
        let refinement = |number: &f64| json!({ "refinement": number, "cell_m": self.cell(*number) });
        let [first, second] = self.expected;
        json!({
            "schema": SCHEMA,
            "name": self.name,
            "title": self.title,
            "problem": self.problem,
            "equations": self.equations,
            "seed": self.seed,
            "units": "SI: m, s, kg, Pa, N, J; angles in degrees; the unit of a number is the end of its key",
            "conventions": CONVENTIONS,
            "physics": {
                "inertia": self.physics[0],
                "strain": if self.physics[1] { "large" } else { "small" },
            },
            "given": self.given,
            "refined_by": self.refined_by,
            "refinements": self.refinements.iter().map(refinement).collect::<Vec<_>>(),
            "wanted": self.wanted.iter().map(wanted).collect::<Vec<_>>(),
            "expected": { "error_at_first_order": first, "error_at_second_order": second, "on_refinement": self.refinements.last() },
        })
    }
}

/// Name and version of the form of `case.json`.
pub const SCHEMA: &str = "mpm-verify/case/1";

/// Signs and places, in words.
const CONVENTIONS: &str = "x to the right, y upwards from the base, t = 0 at the start (of the last stage, where there are several); \
    a column is along y; about an axis x is the radius and amounts are those of one radian; a plane section is 1 m thick. Pore pressure is above \
    zero in compression, stress in tension; stresses that are given are effective ones. Places are those that the soil has at t = 0. Settlement \
    is downwards and counts from the state without load and stress: where the start is undrained equilibrium, some of it is there at t = 0; where the \
    start is given it counts from the start. Heads are total heads above the base. A well takes its rate from a slice 1 m thick; in a column from \
    the whole width.";

/// Cells with less of their area in the soil have their pressure elsewhere than in their middle.
const WHOLE: f64 = 0.99;

/// Keys that a seed changes where a case allows.
const ALTERED: [&str; 3] =
    ["soil.law.linear_elastic.youngs_modulus", "water.hydraulic_conductivity", "surcharge.pressure"];

/// The run of ours that would give an answer.
fn run(scene: &Scene, quantities: &[&Quantity], rows: &[Row], observed: &[f64]) -> Run {
    let stage = scene.stages.len() - 1;
    let before: f64 =
        scene.stages[..stage].iter().map(|s| if let Until::Time(time) = s.until { time } else { 0.0 }).sum();
    let mut times: Vec<f64> = rows.iter().map(|row| row.time).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let blank = |time: f64, observed: bool| {
        let mut sample = Sample { stage, stage_time: time, observed, ..Sample::default() };
        sample.state.time = before + time;
        if scene.free_surface.is_some() {
            let water = sample.state.water.get_or_insert_default();
            water.mobile_porosity = scene.mobile_porosity();
        }
        sample
    };
    let mut samples = vec![blank(0.0, false)];
    samples[0].stage = 0;
    samples[0].state.time = 0.0;
    let mut solid = Vec::new();
    for time in times {
        let mut sample = blank(time, observed.iter().any(|at| (at - time).abs() <= 1e-9 * time.abs()));
        for row in rows.iter().filter(|row| row.time == time) {
            let [x, y] = row.place.unwrap_or_default();
            match &quantities[row.quantity].at {
                At::Whole { set, .. } => set(&mut sample, row.value),
                At::Height { set, .. } => {
                    let mut own = ProfileRow { height_m: y, material_height_m: y, ..ProfileRow::default() };
                    set(&mut own, row.value);
                    sample.state.profile.push(own);
                }
                At::Place { set, .. } => {
                    let mut own = FieldPoint { x_m: x, y_m: y, pressure_pa: 0.0, saturation: 1.0, soil: 1.0 };
                    set(&mut own, row.value);
                    sample.state.field.push(own);
                }
                At::Soil => solid.push([x, y, row.value]),
            }
        }
        sample.state.profile.sort_by(|a, b| a.height_m.total_cmp(&b.height_m));
        samples.push(sample);
    }
    Run { samples, places: Places { solid, water: Vec::new() }, ..Run::default() }
}

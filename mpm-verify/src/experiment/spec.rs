//! Experiments as data: a file of `reference-data/cases` holds a problem with its equations and sources, and its cases.
//!
//! A case is a scene with a patch, what is measured and against which reference, the meshes, what else is refined, what that must
//! show, and a fault that the case must find. What a case does not say its file's `[defaults]` say.

use mpm_core::scene::{Change, Scene, StepChoice, Until};
use mpm_core::stability::stable_limit;
use serde::Deserialize;
use toml::{Table, Value};

use super::number::Label;
use crate::error::Error::{self, Lacks, Unfit};
use crate::exact::layered::Layered;
use crate::scenes::{BUILT_IN, built_in};

/// A problem with its cases.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Problem {
    /// What it is called.
    pub title: String,
    /// The problem in words: geometry, loads, drainage, what is asked.
    #[serde(default)]
    pub problem: String,
    /// Its equations, in LaTeX.
    #[serde(default)]
    pub equations: Vec<String>,
    /// Assumptions of the exact solution, one sentence each.
    #[serde(default)]
    pub assumptions: Vec<String>,
    /// Where the exact solution is from: book and page, paper, DOI.
    #[serde(default)]
    pub sources: Vec<String>,
    /// What its cases have in common.
    #[serde(default)]
    defaults: Table,
    /// Its cases.
    case: Vec<Table>,
}

/// A case as it is written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spec {
    /// Name on the command line.
    pub name: String,
    /// What the case shows, against what.
    #[serde(default)]
    pub about: String,
    /// Whether a function of the program of the same name runs it.
    #[serde(default)]
    pub program: bool,
    /// Name of a built-in scene.
    #[serde(default)]
    pub scene: String,
    /// Keys of the scene that are another here, by their dotted names.
    #[serde(default)]
    pub patch: Table,
    /// Keys of the scene that are taken out.
    #[serde(default)]
    pub without: Vec<String>,
    /// Further patches, each of a run of its own; the worst of all runs counts.
    #[serde(default)]
    pub variants: Vec<Table>,
    /// What is measured.
    pub measure: Option<Measure>,
    /// Cells over the height, coarse to fine; not whole numbers where the mesh ends above the soil.
    #[serde(default)]
    pub meshes: Vec<f64>,
    /// Evenly spaced times to the end at which a run is looked at, in place of those of the scene.
    pub looks: Option<u32>,
    /// The same as shares of the time in which pressure passes all layers of a column.
    #[serde(default)]
    pub passages: Vec<f64>,
    /// Whether the case's own errors are those of halved steps (`steps`) against the reference, in place of finer meshes.
    #[serde(default)]
    pub by_steps: bool,
    /// Whether the scene is judged as `check --scene` judges one of the user: `meshes` apart, nothing is asked here.
    #[serde(default)]
    pub as_own_scene: bool,
    /// Width of the soil in cells, where it changes with the mesh: an outline is a rectangle then.
    pub width_in_cells: Option<usize>,
    /// Steps that fall with a power of the cell.
    pub falling_steps: Option<FallingSteps>,
    /// Largest error allowed on the finest mesh.
    #[serde(default = "nothing")]
    pub error: f64,
    /// Order of theory.
    pub order: Option<f64>,
    /// Whether the finest mesh is judged alone where no order is: else the last two are.
    #[serde(default)]
    pub finest_alone: bool,
    /// Largest error on every mesh, as a share of the cell in m.
    pub everywhere: Option<f64>,
    /// Refinement in the time step.
    pub steps: Option<Steps>,
    /// Refinement in the particles.
    pub particles: Option<Particles>,
    /// Refinement in the tolerance of error-controlled time.
    pub tolerances: Option<Tolerances>,
    /// What else the problem must show, each on meshes of its own.
    #[serde(default)]
    pub also: Vec<Also>,
    /// What the error is measured against.
    #[serde(default = "verified")]
    pub kind: Label,
    /// The same case with a fault, which it must find.
    pub mutant: Option<Fault>,
    /// What it is as a neutral case, for other codes.
    #[serde(default)]
    pub neutral: Neutral,
}

/// A case as one for other codes: the first of a problem, scene and quantity is one without being told.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Neutral {
    /// Its name there, if it is another; a case that is named is one whatever stands before it.
    pub name: Option<String>,
    /// Whether it is none.
    #[serde(default)]
    pub skip: bool,
    /// Cells over the height there, if they are others.
    #[serde(default)]
    pub meshes: Vec<f64>,
    /// Largest errors of schemes of first and of second order on the finest mesh.
    pub expected: Option<[f64; 2]>,
}

fn nothing() -> f64 {
    f64::NAN
}

fn verified() -> Label {
    Label::Verified
}

/// What is measured in a run: a word of `MEASURES` in [`super::measure`] and what that asks for.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// The quantity.
    pub of: String,
    /// The reference, where a quantity has several.
    #[serde(default)]
    pub reference: String,
    /// Whether differences are shares of the exact value at their time, in place of a size common to all times.
    #[serde(default)]
    pub relative: bool,
    /// Times from this time factor on count.
    #[serde(default)]
    pub from_time_factor: f64,
    /// Only this time factor counts.
    pub at_time_factor: Option<f64>,
    /// Only the last time counts.
    #[serde(default)]
    pub at_end: bool,
}

/// Another look at the same problem.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Also {
    /// What it is compared with, in words.
    pub against: String,
    /// Keys of the scene that are another here.
    #[serde(default)]
    pub patch: Table,
    /// What is measured, if not what the case measures.
    pub measure: Option<Measure>,
    /// Cells over the height, coarse to fine.
    pub meshes: Vec<f64>,
    /// Largest error on every mesh.
    pub at_most: Option<f64>,
    /// Largest error on the finest one.
    pub finest: Option<f64>,
    /// Order of theory.
    pub order: Option<f64>,
}

/// Steps that fall with a power of the cell from a share of the limit on one mesh.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FallingSteps {
    /// Share of the stable step on the mesh of `cells`.
    #[serde(default = "nothing")]
    share: f64,
    /// The same in s, in place of a share.
    first_s: Option<f64>,
    /// Cells over the height of that mesh.
    cells: f64,
    /// The power.
    power: i32,
}

/// Halved steps on one mesh.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steps {
    /// Cells over the height.
    pub cells: f64,
    /// Keys of the scene that are another here.
    #[serde(default)]
    pub patch: Table,
    /// First step as a share of the stable one.
    #[serde(default = "Steps::usual")]
    share: f64,
    /// The same in s, in place of a share.
    first_s: Option<f64>,
    /// Differences between runs of half the step.
    #[serde(default = "Steps::four")]
    pub halvings: u32,
    /// Order of theory in the step.
    pub order: Option<f64>,
    /// Largest difference.
    pub at_most: Option<f64>,
}

impl Steps {
    fn usual() -> f64 {
        0.9
    }

    fn four() -> u32 {
        4
    }

    /// The first step, s.
    pub fn first(&self, scene: &Scene) -> f64 {
        self.first_s.unwrap_or_else(|| self.share * stable_limit(scene))
    }
}

/// Numbers of particles per cell on one mesh.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Particles {
    /// Cells over the height.
    pub cells: f64,
    /// Particles per cell.
    #[serde(default = "Particles::usual")]
    pub counts: Vec<usize>,
    /// Largest error with any of them.
    pub at_most: f64,
}

impl Particles {
    fn usual() -> Vec<usize> {
        vec![1, 4, 9, 16]
    }
}

/// Tolerances on one mesh.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerances {
    /// Cells over the height.
    pub cells: f64,
    /// Keys of the scene that are another here.
    #[serde(default)]
    pub patch: Table,
    /// The tolerances.
    #[serde(default = "Tolerances::usual")]
    pub values: Vec<f64>,
    /// Largest difference to a run under a hundredth of the smallest tolerance, over the run's own tolerance.
    #[serde(default = "Tolerances::once")]
    pub times: f64,
}

impl Tolerances {
    fn usual() -> Vec<f64> {
        vec![1e-3, 1e-4, 1e-5, 1e-6]
    }

    fn once() -> f64 {
        1.0
    }
}

/// A fault that is planted in the scene after the exact solution has been made from it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// In words.
    pub what: String,
    /// Factors on numbers of the scene.
    #[serde(default)]
    scale: Table,
    /// Keys that are another.
    #[serde(default)]
    set: Table,
    /// Keys that are taken out.
    #[serde(default)]
    without: Vec<String>,
    /// A factor on what is measured, where the fault is in the reading.
    #[serde(default = "one")]
    pub reading: f64,
}

fn one() -> f64 {
    1.0
}

impl Fault {
    /// The scene with the fault. Times are those of the sound scene, in seconds.
    ///
    /// # Errors
    /// A key that is not there, or a scene that is refused with the fault.
    pub fn planted(&self, scene: &Scene) -> Result<Scene, Error> {
        let scene = scene.edited(|_| {})?;
        let scaled = |(key, factor): (&String, &Value)| {
            let number = scene.number(key).zip(number(factor));
            let (was, factor) =
                number.ok_or_else(|| Error::refused(key, "a number of the scene and its factor", factor))?;
            Ok((key.clone(), Change::from(was * factor)))
        };
        let mut changes = self.scale.iter().map(scaled).collect::<Result<Vec<_>, Error>>()?;
        changes.extend(set(&self.set, &self.without));
        // What would be refused as a mistake is what a fault is.
        Ok(scene.patched(&changes)?.forced())
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|number| number as f64))
}

fn set(patch: &Table, without: &[String]) -> Vec<(String, Change)> {
    let changed = patch.iter().map(|(key, value)| (key.clone(), Change::from(value)));
    changed.chain(without.iter().map(|key| (key.clone(), Change::NONE))).collect()
}

impl Problem {
    /// Reads a file of cases.
    ///
    /// # Errors
    /// File, line, what was expected and what was found.
    pub fn parse(text: &str, file: &str) -> Result<(Self, Vec<Spec>), Error> {
        let refused = |what: toml::de::Error| {
            let line = what.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            Error::refused(format!("{file}:{line}"), "a problem with its cases", what.message())
        };
        let problem: Self = toml::from_str(text).map_err(refused)?;
        let spec = |case: &Table| {
            let mut whole = problem.defaults.clone();
            merge(&mut whole, case);
            let name = case.get("name").and_then(Value::as_str).unwrap_or("a case without a name").to_owned();
            Spec::deserialize(whole).map_err(|why| Error::refused(format!("{file}: {name}"), "a case", why.message()))
        };
        let specs = problem.case.iter().map(spec).collect::<Result<_, Error>>()?;
        Ok((problem, specs))
    }
}

/// Puts a value at a dotted key, or takes the key out; nothing if the key leads through what is no table.
fn put(value: &mut Value, key: &str, to: Option<Value>) -> Option<()> {
    let (first, rest) = key.split_once('.').map_or((key, None), |(first, rest)| (first, Some(rest)));
    match (value, rest) {
        (Value::Array(items), Some(rest)) => put(items.get_mut(first.parse::<usize>().ok()?)?, rest, to),
        (Value::Table(table), Some(rest)) => {
            if to.is_none() && !table.contains_key(first) {
                return Some(());
            }
            put(table.entry(first).or_insert_with(|| Value::Table(Table::new())), rest, to)
        }
        (Value::Table(table), None) => {
            match to {
                Some(to) => table.insert(first.to_owned(), to),
                None => table.remove(first),
            };
            Some(())
        }
        _ => None,
    }
}

/// Puts the entries of a table over those of another; patches are merged key by key.
fn merge(under: &mut Table, over: &Table) {
    for (key, value) in over {
        match (under.get_mut(key), value) {
            (Some(Value::Table(under)), Value::Table(over)) if key == "patch" => under.extend(over.clone()),
            _ => {
                under.insert(key.clone(), value.clone());
            }
        }
    }
}

impl Spec {
    /// The scenes that the case is about, one per variant, on the mesh of their file; a history costs time and is left out.
    ///
    /// # Errors
    /// No such scene, or one that is refused with the patch.
    pub fn bases(&self) -> Result<Vec<Scene>, Error> {
        self.bases_with(&Table::new())
    }

    /// The same with one more patch.
    ///
    /// # Errors
    /// As [`Spec::bases`].
    pub fn bases_with(&self, more: &Table) -> Result<Vec<Scene>, Error> {
        let one = |variant: &Table| {
            let (mut patch, mut own) = (self.patch.clone(), variant.clone());
            let named = own.remove("scene");
            let scene = built_in(named.as_ref().and_then(Value::as_str).unwrap_or(&self.scene))?;
            patch.extend(own);
            patch.extend(more.clone());
            let without = self.taken_out();
            Ok(self.looked_at(&scene.patched(&set(&patch, &without))?)?.edited(|scene| scene.history = 0)?)
        };
        if self.variants.is_empty() { Ok(vec![one(&Table::new())?]) } else { self.variants.iter().map(one).collect() }
    }

    /// Whether the case runs a scene as its file has it, but for the mesh.
    pub fn is_of(&self, scene: &Scene) -> bool {
        let as_it_is =
            self.patch.is_empty() && self.without.is_empty() && self.variants.is_empty() && self.looks.is_none();
        as_it_is && self.passages.is_empty() && built_in(&self.scene).is_ok_and(|own| own == *scene)
    }

    /// Keys that are taken out of the scene: times to look at too, where the case has its own.
    fn taken_out(&self) -> Vec<String> {
        let own = self.looks.is_some() || !self.passages.is_empty();
        let times = ["observe.times", "observe.time_factors"].into_iter().filter(|_| own).map(str::to_owned);
        self.without.iter().cloned().chain(times).collect()
    }

    /// The scene, observed at as many times as the case asks for.
    fn looked_at(&self, scene: &Scene) -> Result<Scene, Error> {
        if let Some(last) = self.passages.last() {
            let passage = Layered::of(scene).ok_or(Unfit("not a column of layers"))?.passage_time();
            let times = self.passages.iter().map(|share| share * passage).collect();
            return Ok(scene.edited(|scene| {
                scene.observe_times = times;
                scene.stages.iter_mut().for_each(|stage| stage.until = Until::Time(last * passage));
            })?);
        }
        let Some(looks) = self.looks else { return Ok(scene.clone()) };
        let Some(Until::Time(end)) = scene.stages.last().map(|stage| stage.until) else {
            return Err(Unfit("`looks` needs a stage that ends at a time"));
        };
        let times = (1..=looks).map(|i| end * f64::from(i) / f64::from(looks)).collect();
        Ok(scene.edited(|scene| scene.observe_times = times)?)
    }

    /// The scene of the case as a file: that of its name with what the case changes, its first variant where it has several.
    ///
    /// # Errors
    /// No such scene, or a key that is of nothing.
    pub fn written(&self) -> Result<String, Error> {
        let mut patch = self.patch.clone();
        patch.extend(self.variants.first().cloned().unwrap_or_default());
        let named = patch.remove("scene");
        let name = named.as_ref().and_then(Value::as_str).unwrap_or(&self.scene);
        let text = BUILT_IN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text).ok_or(Lacks("scene"))?;
        let without = self.taken_out();
        if patch.is_empty() && without.is_empty() {
            return Ok(text.to_owned());
        }
        let unread = |why: &dyn std::fmt::Display| Error::Found(why.to_string()).of(&self.name);
        let mut scene = Value::Table(text.parse::<Table>().map_err(|why| unread(&why))?);
        for (key, value) in without.iter().map(|key| (key, None)).chain(patch.iter().map(|(k, v)| (k, Some(v)))) {
            put(&mut scene, key, value.cloned()).ok_or_else(|| unread(key))?;
        }
        let written = toml::to_string(&scene).map_err(|why| unread(&why))?;
        Ok(format!(
            "# The scene {name} as the case {} runs it; the meshes are those of the case.\n{written}",
            self.name
        ))
    }

    /// The scene on a mesh of so many cells over its height, in steps that fall with the cells if the case has some.
    ///
    /// # Errors
    /// A mesh that does not fit.
    pub fn on(&self, base: &Scene, cells: f64) -> Result<Scene, Error> {
        let scene = match self.width_in_cells {
            Some(count) => base.edited(|scene| {
                scene.cell = scene.height / cells;
                (scene.width, scene.cells) = (count as f64 * scene.cell, [count, cells.ceil() as usize]);
                let [width, height] = [scene.width, scene.height];
                let rectangle = || vec![[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
                scene.outline = scene.outline.is_some().then(rectangle);
            })?,
            None => base.with_cell(base.height / cells)?,
        };
        let Some(FallingSteps { share, first_s, cells: first, power }) = self.falling_steps else { return Ok(scene) };
        let coarse = base.with_cell(base.height / first)?;
        let step = first_s.unwrap_or_else(|| share * stable_limit(&coarse)) * (scene.cell / coarse.cell).powi(power);
        Ok(scene.edited(|scene| scene.step = StepChoice::Fixed(step))?)
    }
}

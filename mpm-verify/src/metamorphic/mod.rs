//! Metamorphic tests: random scenes that make sense, and relations between runs that must hold without knowing the answer.
//!
//! # Reading order
//! 1. [`written`]: a scene as data. [`scenes`]: one for each seed and number. 2. [`seen`]: what two runs say, and how far apart
//!    they may be. 3. [`laws`]: the relations. 4. [`shrink`]: failures made small. 5. This file: run, count, keep.

pub mod laws;
pub mod scenes;
pub mod seen;
pub mod shrink;
pub mod written;

#[cfg(test)]
mod found;

use std::collections::BTreeMap;
use std::time::Instant;

use mpm_core::drive::Run;
use mpm_core::hardware::Hardware;
use mpm_core::scene::Scene;
use serde::Serialize;

use self::laws::{Base, LAWS, Law, Verdict, run_of};
use self::written::Written;
use crate::error::Error;
use crate::experiment::pool;
use crate::unpanicked::unpanicked;

/// How a scene or a relation came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The run came to its end with closed balances; the relation holds.
    Passed,
    /// The relation does not hold.
    Failed,
    /// The run ended early, or its balances did not close.
    Ended,
    /// The checker refused the scene.
    Refused,
    /// The relation does not concern the scene.
    NotApplicable,
}

/// A row of `scenes.csv`: a scene and a relation; of a scene without a run there is one row without a relation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Number of the scene.
    pub index: u64,
    /// What it is made of.
    pub kind: String,
    /// Name of the relation; `run` for that of the scene itself.
    pub law: &'static str,
    /// How it came out.
    pub outcome: Outcome,
    /// Difference over what is allowed.
    pub ratio: Option<f64>,
    /// Why it did not pass.
    pub why: String,
}

/// A relation that does not hold, on the smallest scene found.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// Number of the scene.
    pub index: u64,
    /// Name of the relation.
    pub law: &'static str,
    /// What was found, on the scene itself and on the small one.
    pub found: [String; 2],
    /// The small scene.
    pub small: String,
}

impl Failure {
    /// Its file.
    pub fn name(&self) -> String {
        format!("{}-{}.toml", self.law, self.index)
    }

    /// The text of its file.
    pub fn text(&self, seed: u64) -> String {
        let Self { index, law, found: [own, small], small: scene } = self;
        let about = LAWS.iter().find(|known| known.name == *law).map_or("the run does not panic", |known| known.about);
        format!(
            "# {law}: {about}. Scene {index} of seed {seed} fails: {own}.\n# Made smaller: {small}.\n# To see it again: \
             mpm-verify metamorphic --seed {seed} --only {index}\n{scene}"
        )
    }
}

/// What one scene says.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Told {
    /// Its rows.
    pub rows: Vec<Row>,
    /// Its failures.
    pub failures: Vec<Failure>,
}

/// How a scene itself is run.
enum Started {
    Refused(String),
    Ended(String),
    Ran(Box<(Scene, Run)>),
    /// It came to its end as if it were right.
    Silent(String),
}

fn started(written: &Written) -> Started {
    let scene = match written.scene() {
        Ok(scene) => scene,
        Err(e) => return Started::Refused(format!("{}: expected {}", e.key, e.expected)),
    };
    match run_of(&Hardware::default(), &scene) {
        Err(why @ Error::Of { .. }) => Started::Refused(why.to_string()),
        Err(why) => Started::Ended(why.to_string()),
        Ok(Run { failure: Some(failure), .. }) => Started::Ended(format!("{}: {}", failure.place, failure.what)),
        Ok(run) => match &run.trust {
            Some(trust) if trust.verdict != "closed" => {
                let times = (trust.gap / trust.allowed).abs();
                Started::Silent(format!("{} not closed, {times:.1e} times what is allowed", trust.balance))
            }
            _ => Started::Ran(Box::new((scene, run))),
        },
    }
}

/// Nothing planted.
pub fn sound(_: &mut Written) {}

/// Holds one relation against a scene that is run anew.
fn judged(written: &Written, law: &Law, fault: fn(&mut Written)) -> Option<Verdict> {
    let Started::Ran(ran) = started(written) else { return None };
    Some((law.check)(&Base { written, scene: &ran.0, run: &ran.1, fault }))
}

/// The words of a verdict that fails.
fn broken(verdict: &Verdict) -> Option<String> {
    match verdict {
        Verdict::Compared(apart) if apart.too_far() => Some(apart.sentence()),
        _ => None,
    }
}

/// Holds all relations against one scene, with a fault planted in every changed scene.
pub fn scene(seed: u64, index: u64, fault: fn(&mut Written)) -> Told {
    let written = scenes::scene(seed, index);
    let kind = written.kind();
    let mut told = Told::default();
    let row = |law, outcome, ratio, why| Row { index, kind: kind.clone(), law, outcome, ratio, why };
    let panicked =
        |law: &'static str, why: String| Failure { index, law, found: [why.clone(), why], small: written.toml() };
    let ran = match unpanicked(|| started(&written)).map_err(|panic| panic.to_string()) {
        Err(why) | Ok(Started::Silent(why)) => {
            told.rows.push(row("run", Outcome::Failed, None, why.clone()));
            told.failures.push(panicked("run", why));
            return told;
        }
        Ok(Started::Refused(why)) => {
            told.rows.push(row("run", Outcome::Refused, None, why));
            return told;
        }
        Ok(Started::Ended(why)) => {
            told.rows.push(row("run", Outcome::Ended, None, why));
            return told;
        }
        Ok(Started::Ran(ran)) => ran,
    };
    told.rows.push(row("run", Outcome::Passed, None, String::new()));
    let base = Base { written: &written, scene: &ran.0, run: &ran.1, fault };
    for law in &LAWS {
        match unpanicked(|| (law.check)(&base)).map_err(|panic| panic.to_string()) {
            Err(why) => {
                told.rows.push(row(law.name, Outcome::Failed, None, why.clone()));
                told.failures.push(panicked(law.name, why));
            }
            Ok(Verdict::Apart) => told.rows.push(row(law.name, Outcome::NotApplicable, None, String::new())),
            Ok(Verdict::Unfinished(why)) => told.rows.push(row(law.name, Outcome::Ended, None, why)),
            Ok(Verdict::Compared(apart)) if !apart.too_far() => {
                told.rows.push(row(law.name, Outcome::Passed, Some(apart.ratio), apart.what));
            }
            Ok(Verdict::Compared(apart)) => {
                told.rows.push(row(law.name, Outcome::Failed, Some(apart.ratio), apart.sentence()));
                let fails = |w: &Written| {
                    let verdict = unpanicked(|| judged(w, law, fault)).ok().flatten();
                    verdict.as_ref().and_then(broken).is_some()
                };
                let small = shrink::shrunk(&written, fails);
                let found = unpanicked(|| judged(&small, law, fault)).ok().flatten().as_ref().and_then(broken);
                let found = [apart.sentence(), found.unwrap_or_default()];
                told.failures.push(Failure { index, law: law.name, found, small: small.toml() });
            }
        }
    }
    told
}

/// What came out of all scenes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Found {
    /// Seed of the scenes.
    pub seed: u64,
    /// Rows in the order of the scenes.
    pub rows: Vec<Row>,
    /// Failures in the order of the scenes.
    pub failures: Vec<Failure>,
    /// Scenes that there was time for.
    pub scenes: usize,
    /// Time by the clock on the wall, s.
    pub wall_s: f64,
}

/// Runs scenes of a seed on some threads, until there are no more or a time (s) is over; `done` is told of each.
pub fn scenes_of(seed: u64, indices: &[u64], (jobs, limit_s): (usize, f64), done: &(dyn Fn(u64) + Sync)) -> Found {
    let clock = Instant::now();
    let work = |_, index: &u64| (clock.elapsed().as_secs_f64() <= limit_s).then(|| scene(seed, *index, sound));
    let results = pool::each(jobs, indices, work, |at, result| {
        if matches!(result, Ok(Some(_))) {
            done(indices[at]);
        }
    });
    let mut found = Found { seed, ..Found::default() };
    for told in results.into_iter().filter_map(|result| result.ok().flatten()) {
        found.scenes += 1;
        found.rows.extend(told.rows);
        found.failures.extend(told.failures);
    }
    found.wall_s = clock.elapsed().as_secs_f64();
    found
}

/// A row of `laws.csv`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OfLaw {
    /// The relation; `run` for the scenes themselves.
    pub law: &'static str,
    /// What it says.
    pub about: &'static str,
    /// Scenes that passed.
    pub passed: usize,
    /// Scenes that failed.
    pub failed: usize,
    /// Scenes, or their changed ones, whose run ended early or did not balance.
    pub ended: usize,
    /// Scenes that were refused.
    pub refused: usize,
    /// Scenes that it does not concern.
    pub not_applicable: usize,
    /// Largest difference over what is allowed, of those that passed.
    pub largest_ratio: f64,
}

/// A row of `reasons.csv`: scenes of a kind that gave no answer, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reason {
    /// What the scenes are made of.
    pub kind: String,
    /// The relation.
    pub law: &'static str,
    /// Refused or ended.
    pub outcome: Outcome,
    /// Why, without its numbers.
    pub why: String,
    /// How many.
    pub count: usize,
    /// The first of them.
    pub first: u64,
}

impl Found {
    /// Counts by relation.
    pub fn laws(&self) -> Vec<OfLaw> {
        let names =
            std::iter::once(("run", "the scene itself comes to its end")).chain(LAWS.iter().map(|l| (l.name, l.about)));
        let of = |(law, about): (&'static str, &'static str)| {
            let rows: Vec<&Row> = self.rows.iter().filter(|row| row.law == law).collect();
            let count = |outcome| rows.iter().filter(|row| row.outcome == outcome).count();
            let passed = rows.iter().filter(|row| row.outcome == Outcome::Passed);
            OfLaw {
                law,
                about,
                passed: count(Outcome::Passed),
                failed: count(Outcome::Failed),
                ended: count(Outcome::Ended),
                refused: count(Outcome::Refused),
                not_applicable: count(Outcome::NotApplicable),
                largest_ratio: passed.filter_map(|row| row.ratio).fold(0.0, f64::max),
            }
        };
        names.map(of).collect()
    }

    /// Why scenes gave no answer, by kind.
    pub fn reasons(&self) -> Vec<Reason> {
        let mut all: BTreeMap<(String, &'static str, Outcome, String), (usize, u64)> = BTreeMap::new();
        for row in self.rows.iter().filter(|row| matches!(row.outcome, Outcome::Ended | Outcome::Refused)) {
            let key = (row.kind.clone(), row.law, row.outcome, without_numbers(&row.why));
            all.entry(key).or_insert((0, row.index)).0 += 1;
        }
        let reason = |((kind, law, outcome, why), (count, first))| Reason { kind, law, outcome, why, count, first };
        all.into_iter().map(reason).collect()
    }
}

/// Words by which reasons are counted.
fn without_numbers(text: &str) -> String {
    let number = |word: &str| word.chars().any(|c| c.is_ascii_digit());
    let words: Vec<&str> = text.split(' ').map(|word| if number(word) { "#" } else { word }).collect();
    words.join(" ").chars().take(120).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A seed and a number of scenes that take few seconds.
    const SOME: (u64, u64) = (1, 40);

    #[test]
    fn relations_hold_for_some_scenes() {
        let indices: Vec<u64> = (0..SOME.1).collect();
        let found = scenes_of(SOME.0, &indices, (2, f64::INFINITY), &|_| {});
        let failures: Vec<String> = found.failures.iter().map(|failure| failure.text(SOME.0)).collect();
        assert!(failures.is_empty(), "{}", failures.join("\n\n"));
        let laws = found.laws();
        assert!(laws[0].passed * 2 > found.scenes, "{:?}", found.reasons());
        let again = scenes_of(SOME.0, &indices[..10], (1, f64::INFINITY), &|_| {});
        assert_eq!(again.rows[..], found.rows[..again.rows.len()], "a scene is a function of seed and number");
    }

    /// A load, or a weight, that is larger by a share.
    fn heavier(written: &mut Written, share: f64) {
        written.load.iter_mut().for_each(|load| load.pressure *= 1.0 + share);
        written.gravity.iter_mut().for_each(|g| *g *= 1.0 + share);
        written.water.iter_mut().for_each(|water| water.unit_weight *= 1.0 + share);
    }

    /// Finds a scene with which a relation fails once a fault is planted in the changed scene.
    fn finds(law: &Law, fault: fn(&mut Written)) -> bool {
        (0..400).any(|index| {
            let written = scenes::scene(2, index);
            judged(&written, law, fault).as_ref().and_then(broken).is_some()
        })
    }

    #[test]
    fn each_relation_can_fail() {
        for law in &LAWS {
            assert!(finds(law, |w| heavier(w, 3e-3)), "{}: a load larger by 3e-3 is not found", law.name);
        }
        // Relations between bits and round-off find much less.
        for name in ["units", "threads", "resumed", "mirrored", "words"] {
            let law = LAWS.iter().find(|law| law.name == name).expect("a relation");
            assert!(finds(law, |w| heavier(w, 1e-8)), "{name}: a load larger by 1e-8 is not found");
        }
    }

    #[test]
    fn a_scene_that_is_refused_or_ends_is_counted_with_its_reason() {
        let row = |index, law, outcome, why: &str| Row {
            index,
            kind: "column".to_owned(),
            law,
            outcome,
            ratio: None,
            why: why.to_owned(),
        };
        let rows = vec![
            row(3, "run", Outcome::Refused, "expected 1 m, found 2.5 m"),
            row(5, "run", Outcome::Refused, "expected 7 m, found 9e-3 m"),
            row(6, "run", Outcome::Passed, ""),
        ];
        let found = Found { rows, scenes: 3, ..Found::default() };
        let reasons = found.reasons();
        assert_eq!((reasons.len(), reasons[0].count, reasons[0].first), (1, 2, 3));
        assert_eq!(reasons[0].why, "expected # m, found # m");
        assert_eq!((found.laws()[0].passed, found.laws()[0].refused), (1, 2));
    }
}

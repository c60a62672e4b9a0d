//! What changes the result: the scene and all its variants, one run each, on cells of twice the size.

use std::path::Path;

use mpm_core::scene::{Flags, Scene};
use serde::{Deserialize, Serialize};

use super::ensemble;
use super::figures::Picture;
use super::plan::{self, Plan};
use super::run::{Ended, Followed, follow_quietly};
use super::tables::OfScene;
use super::variants::{VARIANTS, Variant};
use crate::error::Error;
use crate::experiment::pool;
use crate::report::ReportError;
use crate::report::content::table::{Cell, Table, table};
use crate::report::numbers::short;
use crate::report::plots::levee::tornado::{self, Outcome, Varied};
use crate::report::plots::write_drawn;
use crate::unpanicked::unpanicked;

/// Name of the table in the folder of a run.
pub const NAME: &str = "sensitivity.csv";

/// What a variant came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Its name; `base` for the scene itself.
    pub variant: String,
    /// What is changed.
    pub what: String,
    /// The changed value.
    pub label: String,
    /// E2, h.
    pub failure_start_h: Option<f64>,
    /// E3, h.
    pub rapid_failure_h: Option<f64>,
    /// Toe at the end, m.
    pub toe_x_m: Option<f64>,
    /// Settlement of the crest at the end, m.
    pub crest_settlement_m: Option<f64>,
    /// `failed`, `did-not-fail`, `does-not-stand` or `run-failed`.
    pub verdict: String,
    /// Why, where it is not plain.
    pub why: String,
    /// E1, h.
    pub raveling_h: Option<f64>,
    /// When water reached the toe, h.
    pub front_at_toe_h: Option<f64>,
    /// When water left the slope, h.
    pub first_outflow_h: Option<f64>,
    /// Largest displacement before water reached the toe, m.
    pub max_displacement_before_failure_m: Option<f64>,
    /// CPU time, s.
    pub cpu_s: f64,
    /// Of which scene it is a variant: [`Plan::scene_word`].
    pub scene: String,
}

impl OfScene for Line {
    fn scene(&self) -> &str {
        &self.scene
    }
}

impl Line {
    pub(super) fn named(variant: &str, what: &str, label: &str) -> Self {
        Self {
            variant: variant.to_owned(),
            what: what.to_owned(),
            label: label.to_owned(),
            failure_start_h: None,
            rapid_failure_h: None,
            toe_x_m: None,
            crest_settlement_m: None,
            verdict: "run-failed".to_owned(),
            why: String::new(),
            raveling_h: None,
            front_at_toe_h: None,
            first_outflow_h: None,
            max_displacement_before_failure_m: None,
            cpu_s: 0.0,
            scene: String::new(),
        }
    }

    fn with(self, run: &Followed) -> Self {
        let (events, last) = (&run.events, run.rows.last());
        let verdict = match (&run.ended, events.failure_h) {
            (Ended::DoesNotStand(_), _) => "does-not-stand",
            (Ended::Failed(_), _) => "run-failed",
            (_, Some(_)) => "failed",
            (_, None) => "did-not-fail",
        };
        Self {
            failure_start_h: events.failure_h,
            rapid_failure_h: events.collapse_h,
            toe_x_m: last.map(|r| r.toe_x_m),
            crest_settlement_m: last.map(|r| r.crest_settlement_m),
            verdict: verdict.to_owned(),
            why: run.ended.trouble().unwrap_or_default().to_owned(),
            raveling_h: events.raveling_h,
            front_at_toe_h: events.front_at_toe_h,
            first_outflow_h: events.first_outflow_h,
            max_displacement_before_failure_m: last.map(|_| events.displacement_before_toe_m),
            cpu_s: run.cpu_s,
            ..self
        }
    }

    fn outcome(&self) -> Outcome {
        Outcome {
            failure_h: self.failure_start_h,
            rapid_h: self.rapid_failure_h,
            toe_m: self.toe_x_m,
            crest_m: self.crest_settlement_m,
        }
    }

    /// Whether it can be compared with others: it ran through.
    fn is_comparable(&self) -> bool {
        matches!(self.verdict.as_str(), "failed" | "did-not-fail")
    }
}

/// What is varied.
#[derive(Debug, Clone)]
pub struct Base<'a> {
    /// Name or file of the scene.
    pub source: &'a str,
    /// Its flags.
    pub flags: &'a Flags,
    /// Where to end, h.
    pub until_h: Option<f64>,
    /// Long variants too.
    pub full: bool,
}

/// Runs the scene and every variant that differs from it, `jobs` at a time; the scene first. None takes another down.
pub fn compute(base: &Base, jobs: usize, tell: &(dyn Fn(&str) + Sync)) -> Vec<Line> {
    let whole = plan::scene(base.source, base.flags, None);
    let cell = whole.as_ref().ok().map(|scene| plan::COARSER * scene.cell);
    let flags = Flags { cell, ..base.flags.clone() };
    let of = |variant| plan::scene(base.source, &flags, variant);
    let usual = of(None);
    let asked = |v: &&Variant| base.full || !v.long;
    let mut all: Vec<(Line, Result<Scene, Error>)> = vec![(Line::named("base", "", ""), of(None))];
    for v in VARIANTS.iter().filter(asked) {
        let scene = of(Some(v));
        if scene.as_ref().map_err(Error::to_string) != usual.as_ref().map_err(Error::to_string) {
            all.push((Line::named(v.name, v.what, v.label), scene));
        }
    }
    let word =
        whole.and_then(|scene| Plan::new(scene, None, None, false)).map(|plan| plan.scene_word()).unwrap_or_default();
    for (line, _) in &mut all {
        line.scene.clone_from(&word);
    }
    let (count, mut done) = (all.len(), 0);
    let one = |_: usize, (line, scene): &(Line, Result<Scene, Error>)| match scene {
        Ok(scene) => run(line.clone(), scene, base.until_h),
        Err(why) => Line { why: why.to_string(), ..line.clone() },
    };
    let told = |_: usize, line: &Result<Line, Error>| {
        done += 1;
        let Ok(line) = line else { return };
        let failure = line.failure_start_h.map_or_else(|| line.verdict.clone(), |h| format!("failure at {h:.3} h"));
        tell(&format!("{done}/{count} {}: {failure} ({:.0} s)", line.variant, line.cpu_s));
    };
    let found = pool::each(jobs, &all, one, told).into_iter().zip(&all);
    found.map(|(found, (line, _))| found.unwrap_or_else(|why| Line { why: why.to_string(), ..line.clone() })).collect()
}

fn run(line: Line, scene: &Scene, until_h: Option<f64>) -> Line {
    let followed = Plan::new(scene.clone(), None, until_h, false)
        .and_then(|plan| unpanicked(|| follow_quietly(&plan, &mut |_| false)).flatten());
    match followed {
        Ok(followed) => line.with(&followed),
        Err(why) => Line { why: why.to_string(), ..line },
    }
}

/// Draws them: two variants of an input per row.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn picture(lines: &[Line], folder: &Path) -> Result<Picture, ReportError> {
    let base = lines.first().map(Line::outcome).unwrap_or_default();
    let rows = rows(lines);
    tornado::write(&base, &rows, folder)?;
    let mut figure = tornado::figure(&base, &rows);
    let left_out: Vec<String> = lines
        .iter()
        .skip(1)
        .filter(|l| !l.is_comparable())
        .map(|l| format!("{} {} ({})", l.what, l.label, l.verdict.replace('-', " ")))
        .collect();
    if !left_out.is_empty() {
        figure.caption.push_str(&format!(" Not shown: {}.", left_out.join("; ")));
    }
    let svg = write_drawn(&figure, folder)?;
    Ok(Picture::new(figure, &svg))
}

fn rows(lines: &[Line]) -> Vec<Varied> {
    let found = |v: &Variant| {
        let line = lines.iter().find(|l| l.variant == v.name && l.is_comparable())?;
        Some(tornado::Variant { label: line.label.clone(), outcome: line.outcome() })
    };
    let same = VARIANTS.chunk_by(|a, b| a.what == b.what);
    let pairs = same.flat_map(|group| {
        // Of many values, those that were run stand together; of two, each has its place.
        let ran = |v: &&Variant| group.len() <= 2 || lines.iter().any(|line| line.variant == v.name);
        let ran: Vec<&Variant> = group.iter().filter(ran).collect();
        ran.chunks(2).map(<[&Variant]>::to_vec).collect::<Vec<_>>()
    });
    pairs
        .map(|pair| Varied {
            what: pair[0].what.to_owned(),
            low: pair.first().and_then(|v| found(v)),
            high: pair.get(1).and_then(|v| found(v)),
        })
        .filter(|row| row.low.is_some() || row.high.is_some())
        .collect()
}

/// A table for the page, with the scatter of `runs` that should be equal.
pub fn shown(lines: &[Line], runs: &[ensemble::Line]) -> Table {
    let head =
        ["changed", "value", "front at toe (h)", "E1 (h)", "E2 (h)", "E3 (h)", "toe (m)", "crest (m)", "verdict"];
    let number = |v: Option<f64>| Cell::new(v.map_or_else(|| "–".to_owned(), |v| short(v, 3)));
    let row = |l: &Line| {
        let what = if l.what.is_empty() { "nothing" } else { &l.what };
        let mark = if l.is_comparable() { "" } else { "bad" };
        vec![
            Cell::new(what).marked(l.variant.clone(), ""),
            Cell::new(l.label.clone()),
            number(l.front_at_toe_h),
            number(l.raveling_h),
            number(l.failure_start_h),
            number(l.rapid_failure_h),
            number(l.toe_x_m),
            number(l.crest_settlement_m),
            Cell::new(l.verdict.replace('-', " ")).marked("", mark),
        ]
    };
    let scatter = ensemble::cells(runs).first().map_or_else(String::new, |cell| {
        let said = |quantity: &ensemble::Quantity| {
            let [low, high] = ensemble::spread(runs, *cell, quantity.of)?.range.map(|v| short(v, 3));
            Some(format!("{}, {low} to {high} {}", quantity.words, quantity.unit))
        };
        let all: Vec<String> = ensemble::QUANTITIES.iter().filter_map(said).collect();
        format!(" Four of five runs that should be equal, on cells of {} m: {}.", short(*cell, 2), all.join("; "))
    });
    let note = format!(
        "One input changed at a time, on cells of twice the size of the scene's; in small letters the name for `mpm-verify levee \
         --variant`.{scatter}"
    );
    table("Sensitivity".to_owned(), &head, lines.iter().map(row).collect(), &note)
}

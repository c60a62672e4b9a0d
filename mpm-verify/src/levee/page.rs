//! The page of a run: headline numbers, claims, pictures, assumptions, how to run it again.

use std::path::Path;

use mpm_core::failure::Scales;
use serde::Serialize;
use serde_json::json;

use super::assumptions;
use super::claims::{Claim, Verdict};
use super::figures::Picture;
use super::limits::{self, Limit};
use super::plan::Plan;
use super::run::Followed;
use super::summary::Summary;
use crate::report::content;
use crate::report::content::table::{Cell, Table, table};
use crate::report::html::render;
use crate::report::numbers::short;
use crate::report::plots::figure::Figure;
use crate::report::plots::levee::clock;
use crate::report::{ReportError, save};

const TEMPLATE: &str = include_str!("page.html");

#[derive(Debug, Serialize)]
struct Page {
    title: String,
    summary: String,
    troubles: Vec<String>,
    numbers: Vec<Table>,
    claims: Vec<Table>,
    papers: bool,
    further: Vec<Table>,
    assumptions: Vec<(&'static str, String)>,
    manifest: Vec<(&'static str, String)>,
    files: Vec<&'static str>,
    animation: bool,
}

/// Files that the page links to where they are there.
const FILES: [&str; 11] = [
    "summary.json",
    "history.csv",
    "events.csv",
    "paths.csv",
    "claims.csv",
    "safety_factor.csv",
    "sensitivity.csv",
    "convergence.csv",
    "drivers.csv",
    "frames.bin",
    "vtk/solid.pvd",
];

/// What a page is made of.
#[derive(Debug)]
pub struct Parts<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// The run.
    pub run: &'a Followed,
    /// Its numbers.
    pub summary: &'a Summary,
    /// Judged claims of the paper, of its levee.
    pub claims: Option<&'a [Claim]>,
    /// Pictures in their order.
    pub pictures: &'a [Picture],
    /// Further tables: factors of safety, variants.
    pub further: Vec<Table>,
    /// Tables in the folder that are of other scenes.
    pub others: Vec<String>,
}

/// Writes `index.html`.
///
/// # Errors
/// A file that cannot be written, or a template that does not fit.
pub fn write(parts: Parts, (known, folder): (&Path, &Path)) -> Result<(), ReportError> {
    let Parts { plan, run, summary, claims, pictures, further, others } = parts;
    let page = Page {
        title: title(plan, summary),
        summary: words(summary, claims),
        papers: claims.is_some(),
        troubles: run.ended.trouble().map(str::to_owned).into_iter().chain(others).collect(),
        numbers: numbers(summary, &plan.scales(), claims.is_some()),
        claims: claims.map(judged).into_iter().collect(),
        further,
        assumptions: assumptions::of(&plan.scene, summary),
        manifest: summary.manifest.entries().to_vec(),
        files: FILES
            .into_iter()
            .filter(|file| folder.join(file).exists() || known.join(file).exists())
            .filter(|file| claims.is_some() || *file != "claims.csv")
            .collect(),
        animation: folder.join("failure.html").exists(),
    };
    let figures: Vec<Figure> = pictures.iter().map(|p| p.figure.clone()).collect();
    let drawn: Vec<String> = pictures.iter().map(|p| p.svg.clone()).collect();
    let path = folder.join("index.html");
    let html = render(TEMPLATE, json!(page), &content::Picture::all(&figures), (&figures, &drawn), ".");
    save(&path, html.map_err(|cause| ReportError::Page { path: path.clone(), cause })?)
}

fn title(plan: &Plan, summary: &Summary) -> String {
    let variant = summary.variant.as_ref().map_or_else(String::new, |name| format!(", variant {name}"));
    let subject = if plan.papers() { "Seepage failure of a levee" } else { "Seepage and stability of a slope" };
    format!("{subject}: {}{variant}", plan.scene.name)
}

fn words(s: &Summary, claims: Option<&[Claim]>) -> String {
    let at = |time: Option<f64>| time.map(|h| clock(3600.0 * h));
    let subject = if claims.is_some() { "levee" } else { "slope" };
    let judged = claims.map_or_else(String::new, |claims| {
        let count = |verdict: Verdict| claims.iter().filter(|c| c.verdict == verdict).count();
        format!(
            " Of {} statements of the paper and the experiment {} hold, {} differ, {} cannot be compared.",
            claims.len(),
            count(Verdict::Holds),
            count(Verdict::Differs),
            count(Verdict::NotComparable)
        )
    });
    let story = match (at(s.failure_start_h), at(s.rapid_failure_h)) {
        (Some(failure), Some(rapid)) => format!(
            "Failure starts at {failure}, rapid failure at {rapid}; soil rests again {} s later with its toe at {} m.",
            s.rapid_failure_lasts_s.map_or_else(|| "–".to_owned(), |t| short(t, 3)),
            s.toe_x_m.map_or_else(|| "–".to_owned(), |x| short(x, 4))
        ),
        (Some(failure), None) => format!("Failure starts at {failure}; it does not become rapid."),
        (None, _) => match at(s.end_h) {
            Some(end) => format!("The {subject} has not failed when the run ends at {end}."),
            None if s.ended == "run-failed" => "The run failed before any water seeped.".to_owned(),
            None => format!("The {subject} does not stand before any water seeps."),
        },
    };
    format!("{story}{judged}")
}

fn numbers(s: &Summary, scales: &Scales, papers: bool) -> Vec<Table> {
    let time = |name: &str, value: Option<f64>| {
        let small = value.map_or_else(String::new, |h| clock(3600.0 * h));
        vec![
            Cell::new(name),
            Cell::new(value.map_or_else(|| "did not happen".to_owned(), |h| short(h, 6))).marked(small, ""),
            Cell::new("h"),
        ]
    };
    let other = |name: &str, value: Option<f64>, unit: &str| {
        vec![Cell::new(name), Cell::new(value.map_or_else(|| "–".to_owned(), |v| short(v, 4))), Cell::new(unit)]
    };
    let count = |name: &str, value: u64| vec![Cell::new(name), Cell::new(value.to_string()), Cell::new("")];
    let head = ["", "value", "unit"];
    let happened = vec![
        time("water reaches the toe", s.front_at_toe_h),
        time("water leaves the slope", s.first_outflow_h),
        time("E1: the toe ravels", s.raveling_h),
        time("E2: failure starts", s.failure_start_h),
        time("E3: rapid failure", s.rapid_failure_h),
        time("the end", s.end_h),
        other("from E3 to the end", s.rapid_failure_lasts_s, "s"),
        other("where failure starts, x", s.failure_at_m, "m"),
        other("toe at the end, x", s.toe_x_m, "m"),
        other("settlement of the crest", s.crest_settlement_m, "m"),
        other("largest displacement before failure starts", s.displacement_before_failure_m, "m"),
        other("largest deviator strain", s.max_deviator_strain, "–"),
    ];
    let operators = [
        other("checkerboard index, steady with a point source, faces (default)", s.checkerboard_face_operator, "–"),
        other("the same, the paper's nodal operator", s.checkerboard_nodal_operator, "–"),
    ];
    let mut took = vec![
        count("steps of the water", s.steps_seepage),
        count("steps of soil that comes to rest", s.steps_relaxing),
        count("steps of soil that moves", s.steps_moving),
        other("CPU time", Some(s.cpu_s), "s"),
    ];
    let mut about = "";
    if papers {
        took.splice(0..0, operators);
        about = "Both indices of a point source are those of the last frame before failure.";
    }
    let kept = |limit: Limit| {
        let (verdict, mark) = if limit.passed() { ("held", "good") } else { ("not held", "bad") };
        vec![
            Cell::new(limit.name),
            Cell::new(limit.found.map_or_else(|| "–".to_owned(), |v| short(v, 3))),
            Cell::new(short(limit.allowed, 2)),
            Cell::new(limit.unit),
            Cell::new(verdict).marked("", mark),
        ]
    };
    let [e1, e2, e3] = scales.events().map(|way| short(way, 2));
    let events = format!(
        "E1: 0.5 % of the section has moved more than {e1} m, or soil does not come to rest. E2: 1 % of the section, deeper than {} m, \
         has moved more than {e2} m. E3: 5 % has moved more than {e3} m. All are shares of the height, beyond what the water can move \
         the soil elastically.",
        short(scales.depth(), 2)
    );
    vec![
        table("What happened".to_owned(), &head, happened, &events),
        table(
            "How sound it is".to_owned(),
            &["largest over the run", "value", "at most", "unit", ""],
            limits::of(s).into_iter().map(kept).collect(),
            "Gaps as shares of the water in the soil and of the works and losses booked.",
        ),
        table("What it took".to_owned(), &head, took, about),
    ]
}

fn judged(claims: &[Claim]) -> Table {
    let row = |c: &Claim| {
        let mark = match c.verdict {
            Verdict::Holds => "good",
            Verdict::Differs => "bad",
            Verdict::NotComparable => "",
        };
        vec![
            Cell::new(c.paper.clone()).marked(c.rule.clone(), ""),
            Cell::new(c.value.clone()),
            Cell::new(c.verdict.words()).marked("", mark),
        ]
    };
    let note = "In small letters: the rule that the verdict follows.";
    table(
        "Statements of the paper and the experiment".to_owned(),
        &["said", "this run", "verdict"],
        claims.iter().map(row).collect(),
        note,
    )
}

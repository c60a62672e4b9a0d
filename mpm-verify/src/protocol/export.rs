//! Neutral cases as files: `case.json` for programs, a page for people, no answer in either.

use std::fs;
use std::path::Path;

use serde_json::Value as Json;

use super::case::{Case, Place};
use crate::page::table::{Cell, Table};
use crate::page::{Page, Section};
use crate::report::case::{STYLE, exact_section, problem_of};
use crate::report::numbers::{brief, short};
use crate::report::{ReportError, save, unwritable};

/// Name of the file of a case.
pub const CASE: &str = "case.json";

/// The form of `case.json`, as a JSON schema.
pub const FORM: &str = include_str!("case.schema.json");

/// Writes cases, each into a folder of its name, the form of their files, and a page that lists them.
///
/// # Errors
/// A file that cannot be written.
pub fn write(cases: &[Case], folder: &Path) -> Result<(), ReportError> {
    for case in cases {
        one(case, &folder.join(&case.name))?;
    }
    save(&folder.join("case.schema.json"), FORM)?;
    let row = |case: &Case| {
        let wanted: Vec<&str> = case.wanted.iter().map(|wanted| wanted.quantity.as_str()).collect();
        vec![
            Cell::new(case.name.clone()).linked(&format!("{}/index.html", case.name)),
            Cell::new(case.title.clone()),
            Cell::new(wanted.join(", ")),
            Cell::new(listed(&case.refinements)).small(case.refined_by.clone()),
        ]
    };
    let head = ["case", "problem", "asked", "refinements"];
    let table = Table::new("Cases", &head, cases.iter().map(row).collect(), "").words();
    Page::new("Neutral cases")
        .lead(format!("{} problems for any code; `mpm-verify score` says how good its answers are.", cases.len()))
        .section(Section::new("cases", "Cases").index(table))
        .section(how())
        .section(Section::new("form", "Form of case.json").files(["case.schema.json"]))
        .write(&folder.join("index.html"))
}

fn listed(refinements: &[f64]) -> String {
    refinements.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

/// What an answer looks like.
fn how() -> Section {
    Section::new("answer", "Answers").list(vec![
        "Write `results.csv` with the columns `refinement,quantity,time_s,x_m,y_m,value`, in any order, in the units of `case.json`."
            .to_owned(),
        "Run two refinements at least; all are better, an order is told with its confidence then.".to_owned(),
        "`run.json` beside it may say `code`, `version`, `settings`, `machine` and what each refinement took: `runs`, a list of \
         `refinement`, `cpu_s`, `wall_s`, `peak_mib`."
            .to_owned(),
        "`mpm-verify score DIR` scores a folder with a folder of results for each case; `mpm-verify score --run COMMAND` runs the code itself."
            .to_owned(),
    ])
}

/// Writes one case.
fn one(case: &Case, folder: &Path) -> Result<(), ReportError> {
    fs::create_dir_all(folder).map_err(|e| unwritable(folder, e))?;
    let text = serde_json::to_string_pretty(&case.json()).map_err(|e| unwritable(folder, e))?;
    save(&folder.join(CASE), text + "\n")?;
    Page::new(case.name.clone())
        .lead(case.title.clone())
        .style(STYLE)
        .section(problem_of((&case.title, &case.problem), case.scene()))
        .section(exact_section(&case.equations, &[], &case.sources))
        .section(given(case))
        .section(asked(case))
        .section(expected(case))
        .section(how())
        .below("Neutral cases", "../index.html")
        .write(&folder.join("index.html"))
}

/// All numbers and words that are given, by their keys.
fn given(case: &Case) -> Section {
    let mut rows = Vec::new();
    flat(&case.given, "", &mut rows);
    let physics = [
        (
            "inertia",
            if case.physics[0] {
                "in the exact solution"
            } else {
                "none in the exact solution: leave it out, or let it die away"
            },
        ),
        ("strain", if case.physics[1] { "large" } else { "small: all on the first geometry" }),
    ];
    rows.extend(physics.map(|(key, word)| (key.to_owned(), word.to_owned())));
    let rows = rows.into_iter().map(|(key, value)| vec![Cell::new(key), Cell::new(value)]).collect();
    Section::new("given", "Given").tables([Table::new(
        "Given",
        &["key of case.json, with its unit", "value"],
        rows,
        "",
    )
    .words()])
}

fn flat(value: &Json, path: &str, rows: &mut Vec<(String, String)>) {
    match value {
        Json::Object(all) => {
            for (key, value) in all {
                flat(value, &if path.is_empty() { key.clone() } else { format!("{path}.{key}") }, rows);
            }
        }
        Json::Array(list) if list.iter().any(Json::is_object) => {
            for (number, value) in list.iter().enumerate() {
                flat(value, &format!("{path}[{number}]"), rows);
            }
        }
        Json::String(word) => rows.push((path.to_owned(), word.clone())),
        other => rows.push((path.to_owned(), other.to_string())),
    }
}

/// What is asked.
fn asked(case: &Case) -> Section {
    let row = |wanted: &super::case::Wanted| {
        let times: Vec<String> = wanted.times.iter().map(|time| short(*time, 6)).collect();
        let shown = if times.len() > 12 {
            format!("{} times from {} to {}", times.len(), times[0], times[times.len() - 1])
        } else {
            times.join(", ")
        };
        let place = match &wanted.place {
            Place::None => "one number at each time".to_owned(),
            Place::Heights => "heights of your own choice, one in each cell at least".to_owned(),
            Place::Field => "places of your own choice, one in each cell inside the soil at least".to_owned(),
            Place::Given(places) => places
                .iter()
                .map(|[x, y]| format!("({}, {})", short(*x, 4), short(*y, 4)))
                .collect::<Vec<_>>()
                .join(", "),
        };
        vec![
            Cell::new(wanted.quantity.clone()).small(wanted.unit.clone()),
            Cell::new(wanted.meaning.clone()),
            Cell::new(shown),
            Cell::new(place),
        ]
    };
    let rows = case.wanted.iter().map(row).collect();
    let head = ["quantity and unit", "meaning", "times (s)", "where (m)"];
    Section::new("asked", "Asked").tables([Table::new(
        "Asked",
        &head,
        rows,
        "All digits of the times are in case.json.",
    )
    .words()])
}

/// How accurate an answer should be.
fn expected(case: &Case) -> Section {
    let finest = case.refinements.last().copied().unwrap_or(1.0);
    let row = |refinement: &f64| {
        let ratio = finest / refinement;
        let [first, second] = case.expected;
        let cell = case.cell(*refinement).map_or_else(|| "–".to_owned(), |cell| short(cell, 4));
        vec![
            Cell::new(refinement.to_string()),
            Cell::new(cell),
            Cell::new(brief(first * ratio, 2)),
            Cell::new(brief(second * ratio * ratio, 2)),
        ]
    };
    let rows = case.refinements.iter().map(row).collect();
    let head = [case.refined_by.as_str(), "cell (m)", "error at first order", "error at second order"];
    Section::new("expected", "Expected accuracy").tables([Table::new(
        "Errors at most",
        &head,
        rows,
        "An answer passes where its error on the finest refinement is within the last column and its order is 1.5 or more, or all its errors are \
         within a tenth of that; it passes at first order where that is so for the column before, with an order of 0.6.",
    )])
}

//! The page of the stress tests: a table of schemes and cases to read before choosing a scheme, a picture per case, and the
//! largest stable steps.

use std::path::Path;

use serde::Serialize;

use super::content::Picture;
use super::content::table::{Cell, Table, table};
use super::html::render;
use super::numbers::{brief, short};
use super::plots::figure::Figure;
use super::plots::{self, stress_test};
use super::{ReportError, save};
use crate::manifest::Manifest;
use crate::stability::map::Summary;
use crate::stress::{Case, Found, Verdict};
use crate::study::word;

const TEMPLATE: &str = include_str!("stress.html");

#[derive(Debug, Serialize)]
struct Page {
    title: &'static str,
    summary: String,
    warnings: Vec<String>,
    matrix: Vec<Table>,
    stops: Vec<Table>,
    steps: Vec<Table>,
    map_pictures: Vec<&'static str>,
    manifest: Vec<(&'static str, String)>,
}

/// Writes the pictures of the cases into `plots` beside those of the map, `manifest.json` and `index.html`.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(
    (cases, found): (&[Case], &[Found]),
    (map, steps): (&[Figure], &[Summary]),
    manifest: &Manifest,
    folder: &Path,
) -> Result<(), ReportError> {
    let of = |(number, case): (usize, &Case)| {
        stress_test::figure(case, &found.iter().filter(|f| f.case == number).collect::<Vec<_>>())
    };
    let mut figures: Vec<Figure> = cases.iter().enumerate().map(of).collect();
    let pictures = folder.join("plots");
    for figure in &figures {
        plots::write(figure, &pictures)?;
    }
    figures.extend(map.iter().cloned());
    let drawn = figures
        .iter()
        .map(|f| plots::svg_text(f).map_err(|cause| ReportError::Draw { path: pictures.join(f.name), cause }))
        .collect::<Result<Vec<_>, _>>()?;
    let conditions = folder.join("manifest.json");
    let json = serde_json::to_string_pretty(manifest).map_err(|e| super::unwritable(&conditions, e))?;
    save(&conditions, json)?;
    let page = Page {
        title: "Where every scheme holds, degrades and breaks",
        summary: summary(cases, found),
        warnings: broken_defaults(cases, found),
        matrix: tables(cases, found),
        stops: vec![stops(cases, found)],
        steps: vec![steps_table(steps)],
        map_pictures: map.iter().map(|f| f.name).collect(),
        manifest: manifest.entries().into_iter().filter(|(name, _)| *name != "scene hash").collect(),
    };
    let path = folder.join("index.html");
    let html = render(TEMPLATE, serde_json::json!(page), &Picture::all(&figures), (&figures, &drawn), ".");
    save(&path, html.map_err(|cause| ReportError::Page { path: path.clone(), cause })?)
}

/// What a scene gets without a word about its scheme must not break anywhere: one line for each that does.
pub fn broken_defaults(cases: &[Case], found: &[Found]) -> Vec<String> {
    let broken = |f: &&Found| f.judged.verdict == Verdict::Failed && f.scheme.is_default(cases[f.case].dimension);
    let line = |f: &Found| {
        let case = &cases[f.case];
        format!("{}: the default {} breaks at {}", case.name, word(f.scheme.integrator), at(case, f))
    };
    found.iter().filter(broken).map(line).collect()
}

fn summary(cases: &[Case], found: &[Found]) -> String {
    let count = |verdict: Verdict| found.iter().filter(|f| f.judged.verdict == verdict).count();
    let defaults = if broken_defaults(cases, found).is_empty() {
        "No integrator breaks with the shape functions that it takes when a scene names none: it holds, degrades, or the \
         program says why not."
    } else {
        "Some breaks with the shape functions that it takes when a scene names none."
    };
    format!(
        "{} stress tests, {} pairs of a scheme and a case: {} hold, {} degrade to a number, {} are refused or stopped by the \
         program with a reason, {} break. {defaults}",
        cases.len(),
        found.len(),
        count(Verdict::Passed),
        count(Verdict::Degraded),
        count(Verdict::Stopped),
        count(Verdict::Failed),
    )
}

/// A table for every integrator: cases down, schemes across.
fn tables(cases: &[Case], found: &[Found]) -> Vec<Table> {
    let mut integrators: Vec<String> = Vec::new();
    for f in found {
        let name = word(f.scheme.integrator);
        if !integrators.contains(&name) {
            integrators.push(name);
        }
    }
    let both = integrators.iter().flat_map(|integrator| [false, true].map(|option| (integrator, option)));
    both.map(|(integrator, option)| of_integrator(integrator, option, cases, found))
        .filter(|t| !t.rows.is_empty())
        .collect()
}

/// The schemes of an integrator that carry velocities as usual, or with an option.
fn of_integrator(integrator: &str, option: bool, cases: &[Case], found: &[Found]) -> Table {
    let asked = |f: &&Found| word(f.scheme.integrator) == integrator && f.scheme.has_option() == option;
    let own: Vec<&Found> = found.iter().filter(asked).collect();
    let mut schemes: Vec<String> = Vec::new();
    for f in &own {
        if !schemes.contains(&f.scheme.name()) {
            schemes.push(f.scheme.name());
        }
    }
    let asked = |number: &usize| own.iter().any(|f| f.case == *number);
    let row = |number: usize| {
        let case = &cases[number];
        let cell = |scheme: &String| {
            let found = own.iter().find(|f| f.case == number && f.scheme.name() == *scheme);
            found.map_or_else(|| Cell::new(""), |f| verdict(case, f))
        };
        let holds = format!("{}; holds to {}", case.parameter, brief(case.holds, 2));
        std::iter::once(Cell::new(case.name).marked(holds, "")).chain(schemes.iter().map(cell)).collect()
    };
    let head: Vec<&str> = std::iter::once("case").chain(schemes.iter().map(String::as_str)).collect();
    let rows = (0..cases.len()).filter(asked).map(row).collect();
    let note = "Small: the largest value that was measured; where a scheme breaks or the program stops, the parameter there. \
                In capitals: what a scene gets that names no scheme. Empty: not asked.";
    let title = if option { format!("{integrator}, velocities carried in another way") } else { integrator.to_owned() };
    table(title, &head, rows, note)
}

fn verdict(case: &Case, found: &Found) -> Cell {
    let default = found.scheme.is_default(case.dimension);
    let (word, small, mark) = match found.judged.verdict {
        Verdict::Passed => ("holds", value(found), "good"),
        Verdict::Degraded => ("degrades", format!("to {}", value(found)), "warn"),
        Verdict::Stopped => ("stops", format!("at {}", short(found.judged.at, 2)), "warn"),
        Verdict::Failed => ("breaks", format!("at {}", short(found.judged.at, 2)), "bad"),
    };
    let word = if default { word.to_uppercase() } else { word.to_owned() };
    Cell::new(word).marked(small, mark)
}

fn value(found: &Found) -> String {
    found.judged.value.map_or_else(|| "–".to_owned(), |v| short(v, 2))
}

/// `300 cells crossed`, `k = 1e-11 m/s`.
fn at(case: &Case, found: &Found) -> String {
    let number = short(found.judged.at, 2);
    match case.parameter.split_once(" (") {
        Some((name, unit)) => {
            let unit = unit.trim_end_matches(')');
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            format!("{name} = {number}{unit}")
        }
        None => format!("{number} ({})", case.parameter),
    }
}

/// What the program said where it stopped.
fn stops(cases: &[Case], found: &[Found]) -> Table {
    let row = |f: &Found| {
        let case = &cases[f.case];
        vec![
            Cell::new(case.name),
            Cell::new(word(f.scheme.integrator)).marked(f.scheme.name(), ""),
            Cell::new(at(case, f)),
            Cell::new(f.judged.reason.clone()),
        ]
    };
    let stopped = found.iter().filter(|f| f.judged.verdict == Verdict::Stopped);
    let head = ["case", "scheme", "stops at", "reason"];
    table("Reasons of the runs that stopped".to_owned(), &head, stopped.map(row).collect(), "")
}

fn steps_table(steps: &[Summary]) -> Table {
    let row = |s: &Summary| {
        let range = |[low, high]: [f64; 2]| format!("{} to {}", short(low, 3), short(high, 3));
        vec![
            Cell::new(s.scheme.clone()).marked(format!("{}, {}", s.dimension, s.darcy), ""),
            Cell::new(s.rows.to_string()),
            Cell::new(range(s.ratio)),
            Cell::new(range(s.auto)),
        ]
    };
    let note = "Measured: the largest step at which a run does not grow, by bisection. Theory: a plane wave where it holds, the \
                spectral radius of the assembled step elsewhere. auto is the step that a scene takes by itself.";
    let head = ["scheme", "rows", "measured / theory", "auto / measured"];
    table("Measured limits".to_owned(), &head, steps.iter().map(row).collect(), note)
}

//! The page of one test case: verdict, the computed beside the exact, convergence, the problem with its equations, the scene.

use std::fs;
use std::path::Path;

use mpm_core::scene::Scene;
use pulldown_latex::config::DisplayMode;

use super::content::table::order_cell;
use super::numbers::{brief, exact, short};
use super::plots::{self, case, comparison, curves, field};
use super::{ReportError, tables, unwritable};
use crate::book::formula::mathml;
use crate::cases::suite::{problems, suite};
use crate::experiment::spec::Problem;
use crate::experiment::{Judged, Refinement};
use crate::page::table::{Cell, Table};
use crate::page::verdict::Verdict;
use crate::page::{Block, Link, Page, Section, sketch};
use crate::rates::Order;

/// Endings of the files of a picture of a case.
const FILES: &[&str] = &["csv", "svg"];

/// Writes the folder of a case: `index.html`, its pictures with their numbers, and `scene.toml` where a scene of a file is run. `all`
/// are the cases whose pages are written with it.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(judged: &Judged, all: &[Judged], folder: &Path) -> Result<(), ReportError> {
    let folder = folder.join(judged.case.name);
    fs::create_dir_all(&folder).map_err(|e| unwritable(&folder, e))?;
    let known = suite().iter().find(|case| case.name == judged.case.name);
    let problem = known.map(|case| &problems()[case.problem]);
    let spec = known.and_then(|case| case.spec());
    let mut pictures = Section::new("pictures", "Computed and exact");
    for figure in comparison::curves(judged).into_iter().chain(curves::figure(judged)) {
        plots::write_svg_and_numbers(&figure, &folder)?;
        pictures = pictures.figure_in(&figure, ".", FILES);
    }
    for map in comparison::fields(judged) {
        field::write(&map, &folder)?;
        pictures = pictures.figure_in(&field::figure(&map), ".", crate::page::ALL_FILES);
    }
    let mut convergence = Section::new("convergence", "Convergence");
    let figure = plots::figure::Figure { name: "convergence", ..case::figure(judged) };
    plots::write_svg_and_numbers(&figure, &folder)?;
    let header = format!("{},error", case::column(judged.refined_by));
    let rows = judged.errors.iter().map(|(parameter, error)| vec![exact(*parameter), exact(*error)]);
    tables::table(&folder.join("errors.csv"), &header, rows)?;
    convergence = convergence.figure_in(&figure, ".", FILES).tables([refinements(judged)]).files(["errors.csv"]);
    // A test writes the scenes of all cases.
    let scene = spec.and_then(|spec| spec.written().ok());
    if let Some(text) = &scene {
        super::save(&folder.join("scene.toml"), text.clone())?;
    }
    let beside = known.map(|case| neighbours((case.name, case.problem), all)).unwrap_or_default();
    let page = Page::new(format!("{}: {}", judged.case.name, judged.case.about))
        .verdict(verdict(judged))
        .section(pictures)
        .section(convergence)
        .section(problem_section(judged, problem, judged.scene.as_ref()))
        .section(numbers(judged))
        .section(again(judged, scene))
        .below("Verification suite", "../index.html")
        .beside(beside);
    page.write(&folder.join("index.html"))
}

fn verdict(judged: &Judged) -> Verdict {
    let row = &judged.row;
    let order = match judged.convergence.order {
        Order::NotExpected => String::new(),
        _ => format!(", order {}", judged.convergence.words()),
    };
    let said = format!("Error {} of {} allowed{order}.", short(row.error, 3), brief(row.required_error, 3));
    Verdict::new(row.verdict, said)
}

/// Other cases of the same problem.
fn neighbours((name, problem): (&str, usize), all: &[Judged]) -> Vec<Link> {
    let written = |name: &str| all.iter().any(|judged| judged.case.name == name);
    let others = suite().iter().filter(|case| case.problem == problem && case.name != name && written(case.name));
    others.map(|case| Link::new(case.name, format!("../{}/index.html", case.name))).collect()
}

/// The problem of a case, with how it was run.
fn problem_section(judged: &Judged, problem: Option<&Problem>, scene: Option<&Scene>) -> Section {
    let none = Problem::default();
    let Problem { title, problem, equations, sources, .. } = problem.unwrap_or(&none);
    section_of((title, problem), scene, equations, sources).note(format!(
        "Integrator: {}; shape functions and Darcy operator: {}.",
        judged.row.integrator, judged.row.scheme
    ))
}

/// A problem (title and words), its sketch, its equations and where they are from.
pub fn section_of(
    (title, words): (&str, &str),
    scene: Option<&Scene>,
    equations: &[String],
    sources: &[String],
) -> Section {
    let mut section = Section::new("problem", "Problem");
    if !title.is_empty() {
        section = section.with(Block::Heading(title.to_owned())).text(words.trim().replace('\n', " "));
    }
    if let Some(scene) = scene {
        section = section.with(Block::Html(sketch::svg(scene))).note(sketch::words(scene));
    }
    for equation in equations {
        // A test renders the equations of all problems.
        let shown = mathml(equation, DisplayMode::Block).unwrap_or_else(|_| crate::page::escaped(equation));
        section = section.with(Block::Html(shown));
    }
    section.list(sources.iter().map(|source| linked(source)).collect())
}

/// A source whose DOI is a link.
fn linked(source: &str) -> String {
    match source.split_once("doi:") {
        Some((before, doi)) => format!("{before}[doi:{doi}](https://doi.org/{doi})"),
        None => source.to_owned(),
    }
}

/// Every refinement with its order.
fn refinements(judged: &Judged) -> Table {
    let row = |refinement: &Refinement| {
        let errors: Vec<String> = refinement.errors.iter().map(|(_, error)| short(*error, 2)).collect();
        let convergence = refinement.convergence();
        vec![
            Cell::new(refinement.by.0).small(format!("against {}", refinement.against)),
            refinement.state().map_or_else(|| Cell::new("–"), Cell::state),
            Cell::new(errors.join(", ")),
            order_cell(&convergence),
            Cell::new(convergence.theory_words()),
        ]
    };
    let head = ["refined by", "verdict", "errors, coarse to fine", "order", "theory"];
    Table::new("Refinements", &head, judged.all_refinements().iter().map(row).collect(), "")
}

/// What else the case says.
fn numbers(judged: &Judged) -> Section {
    let mut rows = vec![
        vec![Cell::new("error"), Cell::new(short(judged.row.error, 4))],
        vec![Cell::new("tolerance"), Cell::new(brief(judged.row.required_error, 3))],
        vec![
            Cell::new("accepted error"),
            Cell::new(judged.row.baseline.map_or_else(|| "none".to_owned(), |e| short(e, 4))),
        ],
        vec![Cell::new("CPU time (s)"), Cell::new(short(judged.row.cpu_s, 3))],
    ];
    rows.extend(judged.notes.iter().map(|(what, value, unit)| {
        let unit = if unit == "-" { String::new() } else { format!(" {unit}") };
        vec![Cell::new(what.clone()), Cell::new(format!("{}{unit}", short(*value, 4)))]
    }));
    let section = Section::new("numbers", "Numbers").text(judged.reason.clone());
    let section = section.tables([Table::new("Numbers", &["quantity", "value"], rows, "")]);
    match judged.case.mutant {
        Some(fault) => section.note(format!(
            "Mutant: {fault}. The check must find it: `mpm-verify check --mutants {}`.",
            judged.case.name
        )),
        None => section,
    }
}

/// How to run it again, with the scene.
fn again(judged: &Judged, scene: Option<String>) -> Section {
    let section =
        Section::new("again", "Run it again").with(Block::Command(format!("mpm-verify check {}", judged.case.name)));
    match scene {
        Some(scene) => section.text("The scene of the case:").with(Block::Command(scene)).files(["scene.toml"]),
        None => section.note("The case makes its scenes by itself: see its source."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_equations_of_all_problems_are_rendered() {
        for problem in problems() {
            for equation in &problem.equations {
                let shown = mathml(equation, DisplayMode::Block);
                assert!(
                    shown.is_ok_and(|html| html.contains("<math")
                        && !html.contains("merror")
                        && !html.contains("&amp;")),
                    "{}: {equation}",
                    problem.title
                );
            }
        }
    }
}

//! The page of one test case: the problem with its sketch and parameters, the exact solution with source and assumptions, the result beside it,
//! orders of convergence, further numbers, how to run it again.

use std::fs;
use std::path::Path;

use mpm_core::scene::Scene;
use pulldown_latex::config::DisplayMode;

use super::content::table::order_cell;
use super::numbers::{column, exact, print, short};
use super::plots::{self, case, comparison, curves, field};
use super::{ReportError, capital, parameters, tables, unwritable};
use crate::book::formula::mathml;
use crate::cases::suite::{problems, suite};
use crate::experiment::spec::Problem;
use crate::experiment::{Judged, Refinement, Sampled};
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
    let mut pictures = Section::new("result", "Result and error").text(format!("{}.", capital(&judged.reason)));
    for figure in comparison::curves(judged).into_iter().chain(curves::figure(judged)) {
        plots::write_svg_and_numbers(&figure, &folder)?;
        pictures = pictures.figure_in(&figure, ".", FILES);
    }
    for map in comparison::fields(judged) {
        field::write(&map, &folder)?;
        pictures = pictures.figure_in(&field::figure(&map), ".", crate::page::ALL_FILES);
    }
    let mut convergence = Section::new("convergence", "Convergence");
    pictures = pictures.tables(samples(judged));
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
    let page = Page::new(format!("{}: {}", judged.case.name, alone(judged.case.about, problem)))
        .verdict(verdict(judged))
        .style(STYLE)
        .section(problem_section(judged, problem))
        .section(exact_of(problem))
        .section(pictures)
        .section(convergence)
        .section(numbers(judged))
        .section(again(judged, scene))
        .below("Verification suite", "../index.html")
        .beside(beside);
    page.write(&folder.join("index.html"))
}

/// Description of a case, in words that need no case before it.
fn alone(about: &str, problem: Option<&Problem>) -> String {
    match (about.strip_prefix("the same"), problem) {
        (Some(rest), Some(problem)) => format!("{}, {}", problem.title, rest.trim_start_matches([',', ':', ' '])),
        _ => about.to_owned(),
    }
}

fn verdict(judged: &Judged) -> Verdict {
    let row = &judged.row;
    let order = match judged.convergence.order {
        Order::NotExpected => String::new(),
        _ => format!(", order {}", judged.convergence.words()),
    };
    let said = format!("Error {}, tolerance {}{order}.", print(row.error, 3), print(row.required_error, 3));
    Verdict::new(row.verdict, said)
}

/// Other cases of the same problem.
fn neighbours((name, problem): (&str, usize), all: &[Judged]) -> Vec<Link> {
    let written = |name: &str| all.iter().any(|judged| judged.case.name == name);
    let others = suite().iter().filter(|case| case.problem == problem && case.name != name && written(case.name));
    others.map(|case| Link::new(case.name, format!("../{}/index.html", case.name))).collect()
}

/// The problem of a case, with how it was run.
fn problem_section(judged: &Judged, problem: Option<&Problem>) -> Section {
    let none = Problem::default();
    let Problem { title, problem, .. } = problem.unwrap_or(&none);
    problem_of((title, problem), judged.scene.as_ref()).note(format!(
        "Integrator: {}; shape functions and Darcy operator: {}.",
        judged.row.integrator, judged.row.scheme
    ))
}

/// The exact solution of a case: its equations, assumptions and sources.
fn exact_of(problem: Option<&Problem>) -> Section {
    let none = Problem::default();
    let Problem { equations, sources, assumptions, .. } = problem.unwrap_or(&none);
    exact_section(equations, assumptions, sources)
}

/// Sketch and parameters side by side where there is room.
pub const STYLE: &str = "@media (min-width: 900px) {
  :is(#scene, #problem):has(> .sketch) { display: grid; grid-template-columns: minmax(0, 27rem) minmax(0, 1fr); gap: 0 2rem; align-items: start; }
  :is(#scene, #problem) > * { grid-column: 1 / -1; }
  :is(#scene, #problem) > .sketch, :is(#scene, #problem) > .table + .note { grid-column: 1; }
  :is(#scene, #problem) > .sketch + .table { grid-column: 2; grid-row: span 2; margin-top: 0.4rem; }
}
";

/// A problem (title and words), its sketch and parameters.
pub fn problem_of((title, words): (&str, &str), scene: Option<&Scene>) -> Section {
    let mut section = Section::new("problem", "Problem");
    if !title.is_empty() {
        section = section.with(Block::Heading(title.to_owned())).text(words.trim().replace('\n', " "));
    }
    match scene {
        Some(scene) => scene_section(section, scene),
        None => section,
    }
}

/// A section with the sketch and the parameters of a scene.
pub fn scene_section(section: Section, scene: &Scene) -> Section {
    let section = section.with(Block::Html(sketch::svg(scene))).tables([parameters::table(scene)]);
    section.note(sketch::words(scene))
}

/// Equations of an exact solution, what it assumes and where it is from.
pub fn exact_section(equations: &[String], assumptions: &[String], sources: &[String]) -> Section {
    let mut section = Section::new("exact", "Exact solution");
    for equation in equations {
        // A test renders the equations of all problems.
        let shown = mathml(equation, DisplayMode::Block).unwrap_or_else(|_| crate::page::escaped(equation));
        section = section.with(Block::Html(shown));
    }
    for (title, items) in
        [("Assumptions", assumptions.to_vec()), ("Sources", sources.iter().map(|s| linked(s)).collect())]
    {
        if !items.is_empty() {
            section = section.with(Block::Heading(title.to_owned())).list(items);
        }
    }
    section
}

/// A source whose DOIs are links. A DOI ends at a space; a sign before that belongs to the sentence.
fn linked(source: &str) -> String {
    let mut parts = source.split("doi:");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let doi = part.split(' ').next().unwrap_or_default().trim_end_matches([',', ';', ':', '.']);
        format!("{text}[doi:{doi}](https://doi.org/{doi}){}", &part[doi.len()..])
    })
}

/// Most samples that a table of the page holds; `samples.csv` has all.
const SAMPLES: usize = 12;

/// The finest run beside the exact numbers at the sample times that count.
fn samples(judged: &Judged) -> Option<Table> {
    let counting: Vec<&Sampled> = judged.samples.iter().filter(|s| s.counts).collect();
    let every = counting.len().div_ceil(SAMPLES).max(1);
    let some: Vec<&Sampled> = counting.into_iter().rev().step_by(every).collect::<Vec<_>>().into_iter().rev().collect();
    let numbers = |of: fn(&Sampled) -> f64, digits| column(&some.iter().map(|s| of(s)).collect::<Vec<_>>(), digits);
    let (times, found) = (numbers(|s| s.time, 4), numbers(|s| s.computed, 5));
    let (exact, errors) = (numbers(|s| s.exact, 5), numbers(|s| s.error, 2));
    let row = |(k, s): (usize, &&Sampled)| {
        let unit = if s.unit == "-" { String::new() } else { format!(" ({})", s.unit) };
        let quantity = Cell::new(format!("{}{unit}", capital(&s.quantity)));
        let cells = [&times[k], &found[k], &exact[k], &errors[k]].map(Cell::new);
        std::iter::once(quantity).chain(cells).collect()
    };
    let rows: Vec<Vec<Cell>> = some.iter().enumerate().map(row).collect();
    let head = ["quantity", "time (s)", "computed", "exact", "error"];
    (!rows.is_empty()).then(|| Table::new("The finest run at its sample times", &head, rows, ""))
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
    let row = |what: &str, value: f64, digits, unit: &str| {
        let unit = if unit == "-" { "–" } else { unit };
        vec![Cell::new(what), Cell::new(print(value, digits)), Cell::new(unit)]
    };
    let mut rows = vec![row("error", judged.row.error, 4, "-"), row("tolerance", judged.row.required_error, 3, "-")];
    rows.extend(judged.row.baseline.map(|accepted| row("accepted error", accepted, 4, "-")));
    rows.push(row("CPU time", judged.row.cpu_s, 3, "s"));
    rows.extend(judged.notes.iter().map(|(what, value, unit)| row(what, *value, 4, unit)));
    let table = Table::new("Numbers", &["quantity", "value", "unit"], rows, "");
    let section = Section::new("numbers", "Numbers").tables([table]);
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

    /// Titles of pages need no case before them.
    #[test]
    fn the_title_of_a_page_names_the_problem() {
        for case in suite() {
            let title = alone(case.about, Some(&problems()[case.problem]));
            assert!(!title.starts_with("the same"), "{}: {title}", case.name);
        }
    }

    #[test]
    fn a_link_to_a_source_ends_where_its_doi_ends() {
        let link = |doi: &str| format!("[doi:{doi}](https://doi.org/{doi})");
        assert_eq!(
            linked("A 1, doi:10.1/a.b; B: doi:10.2/c"),
            format!("A 1, {}; B: {}", link("10.1/a.b"), link("10.2/c"))
        );
        for source in problems().iter().flat_map(|problem| &problem.sources) {
            let shown = linked(source);
            let targets: Vec<&str> = shown.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
            assert_eq!(targets.len(), source.matches("doi:").count(), "{source}");
            assert!(targets.iter().all(|target| target.ends_with(char::is_alphanumeric)), "{source}: {shown}");
        }
    }

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

//! The leaderboard: codes by cases, error at equal cells, order, CPU time against error; a page for each case and each code.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::case::Case;
use super::code::Code;
use super::mistakes::MISTAKES;
use super::score::{Level, Score, Verdict};
use crate::page::site::{Kind, Report};
use crate::page::table::{Cell, Table};
use crate::page::{Block, Image, Page, Section};
use crate::provenance;
use crate::report::case::section_of;
use crate::report::numbers::{exact, short};
use crate::report::plots::axis::Axis;
use crate::report::plots::figure::{Figure, Mark, Panel, Point, Series};
use crate::report::plots::look::{BLACK, Dash, GREY, Look, Marker, nth};
use crate::report::plots::{self};
use crate::report::{ReportError, save, tables, unwritable};

/// Name of the table of all scores.
pub const BOARD: &str = "leaderboard.csv";
const COLUMNS: &str = "code,version,date,case,seed,verdict,refinement,error,order,order_half_width,expected_first,expected_second,\
    cpu_s,wall_s,peak_mib,conservation,mistakes,flags,reason";

/// All scores, codes of one name together, in the order of their names but ours first.
pub fn merged(codes: Vec<Code>) -> Vec<Code> {
    let mut all: BTreeMap<(bool, String), Code> = BTreeMap::new();
    for code in codes {
        let key = (code.name != OWN, code.name.clone());
        let known = all.entry(key).or_insert_with(|| Code { scores: Vec::new(), ..code.clone() });
        code.scores.into_iter().for_each(|score| known.add(score));
    }
    all.into_values().collect()
}

/// Smaller errors are round-off, and have no place in a picture.
const FLOOR: f64 = 1e-13;

/// Name under which our own code stands.
pub const OWN: &str = "mpm-verify";

fn badge(verdict: Verdict) -> Cell {
    let mark = match verdict {
        Verdict::Passes => "good",
        Verdict::FirstOrder => "warn",
        Verdict::Wrong => "bad",
        Verdict::NotRun => "",
    };
    Cell::badge(verdict.word(), mark)
}

/// The finest refinement on which all codes that answered a case have an error.
fn common(codes: &[Code], case: &str) -> Option<f64> {
    let of = |code: &Code| code.scores.iter().find(|score| score.case == case && score.finest().is_some()).cloned();
    let all: Vec<Score> = codes.iter().filter_map(of).collect();
    let known = |score: &Score, refinement: f64| {
        score.levels.iter().any(|level| level.refinement == refinement && level.error.is_some())
    };
    let first = all.first()?;
    let levels = first.levels.iter().rev().map(|level| level.refinement);
    levels.into_iter().find(|refinement| all.iter().all(|score| known(score, *refinement)))
}

fn level(score: &Score, refinement: f64) -> Option<&Level> {
    score.levels.iter().find(|level| level.refinement == refinement)
}

/// Writes `leaderboard.csv`, the page of all, one for each case with its curves and one for each code.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(codes: &[Code], cases: &[Case], folder: &Path) -> Result<(), ReportError> {
    plots::ready();
    let scored = |case: &&Case| {
        codes
            .iter()
            .flat_map(|code| &code.scores)
            .any(|score| score.case == case.name && score.verdict != Verdict::NotRun)
    };
    let cases: Vec<&Case> = cases.iter().filter(scored).collect();
    tables::table(&folder.join(BOARD), COLUMNS, rows(codes))?;
    let scores = folder.join("scores");
    fs::create_dir_all(&scores).map_err(|e| unwritable(&scores, e))?;
    for code in codes {
        let text = serde_json::to_string_pretty(code).map_err(|e| unwritable(&scores, e))?;
        save(&scores.join(format!("{}.json", file_name(&code.name))), text + "\n")?;
    }
    for case in &cases {
        case_page(codes, case, &folder.join("cases").join(&case.name))?;
    }
    for code in codes {
        let own = folder.join("codes").join(file_name(&code.name));
        fs::create_dir_all(&own).map_err(|e| unwritable(&own, e))?;
        code_page(code, Some("../../cases")).below("Leaderboard", "../../index.html").write(&own.join("index.html"))?;
    }
    let picture = speed(codes, &cases);
    let plots = folder.join("plots");
    fs::create_dir_all(&plots).map_err(|e| unwritable(&plots, e))?;
    plots::write(&picture, &plots)?;
    let report = Report::new(Kind::Leaderboard)
        .picture("plots/cpu-against-error.png", "CPU time against error of all codes on one case");
    let sentence = format!("{} codes on {} cases with exact or published solutions.", codes.len(), cases.len());
    let mut page = Page::new("Leaderboard")
        .lead(format!(
            "{sentence} Each code answers the same `case.json` by itself, is measured from outside, and is judged in the norms of the \
             verification suite."
        ))
        .section(Section::new("speed", "CPU time against error").figure(&picture))
        .section(matrix(codes, &cases))
        .section(Section::new("codes", "Codes").tables([table_of_codes(codes)]))
        .section(Section::new("data", "Data").files([BOARD]))
        .report(Report { date: latest(codes), commit: provenance::commit().to_owned(), ..report });
    page.sections.retain(|section| !section.blocks.is_empty());
    page.write(&folder.join("index.html"))
}

/// The day of the last score.
fn latest(codes: &[Code]) -> String {
    codes.iter().map(|code| code.date.clone()).max().unwrap_or_default()
}

/// A name as that of a folder.
pub fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' }).collect()
}

fn rows(codes: &[Code]) -> Vec<Vec<String>> {
    let maybe = |value: Option<f64>| value.map_or_else(String::new, exact);
    let mut rows = Vec::new();
    for code in codes {
        for score in &code.scores {
            let none = [Level { refinement: f64::NAN, error: None, cpu_s: None, wall_s: None, peak_mib: None }];
            let levels = if score.levels.is_empty() { &none[..] } else { &score.levels[..] };
            for level in levels {
                let refinement = if level.refinement.is_nan() { String::new() } else { level.refinement.to_string() };
                rows.push(vec![
                    code.name.clone(),
                    code.about.version.clone(),
                    code.date.clone(),
                    score.case.clone(),
                    score.seed.to_string(),
                    score.verdict.word().to_owned(),
                    refinement,
                    maybe(level.error),
                    maybe(score.order),
                    maybe(score.order_half_width),
                    exact(score.expected[0]),
                    exact(score.expected[1]),
                    maybe(level.cpu_s),
                    maybe(level.wall_s),
                    maybe(level.peak_mib),
                    maybe(score.conservation),
                    score.mistakes.join("; "),
                    score.flags.join("; "),
                    score.reason.clone(),
                ]);
            }
        }
    }
    rows
}

/// Codes by cases.
fn matrix(codes: &[Code], cases: &[&Case]) -> Section {
    let row = |case: &&Case| {
        let at = common(codes, &case.name);
        let on = at.map_or_else(String::new, |at| format!("{at} {}", case.refined_by));
        let mut row = vec![Cell::new(case.name.clone()).linked(&format!("cases/{}/index.html", case.name)).small(on)];
        row.extend(codes.iter().map(|code| match code.scores.iter().find(|score| score.case == case.name) {
            None => Cell::new("–"),
            Some(score) if score.verdict == Verdict::NotRun => Cell::new("–").small("not run"),
            Some(score) => {
                let error =
                    at.and_then(|at| level(score, at)?.error).map_or_else(|| "–".to_owned(), |e| short(e.abs(), 2));
                let order = score.order.map_or_else(String::new, |order| format!(", order {}", short(order, 2)));
                badge(score.verdict).small(format!("{error}{order}"))
            }
        }));
        row
    };
    let mut head = vec!["case, refinement of the errors"];
    head.extend(codes.iter().map(|code| code.name.as_str()));
    let note = "Verdict; below it the error on the finest refinement that all codes with an answer have, and the order over all refinements. A dash: the code \
                does not answer the case.";
    let table = Table::new("Codes by cases", &head, cases.iter().map(row).collect(), note);
    Section::new("scores", "Scores").index(table)
}

fn table_of_codes(codes: &[Code]) -> Table {
    let row = |code: &Code| {
        let count = |verdict: Verdict| Cell::new(code.count(verdict).to_string());
        vec![
            Cell::new(code.name.clone()).linked(&format!("codes/{}/index.html", file_name(&code.name))),
            Cell::new(code.about.version.clone()),
            count(Verdict::Passes),
            count(Verdict::FirstOrder),
            count(Verdict::Wrong),
            count(Verdict::NotRun),
            Cell::new(code.date.get(..10).unwrap_or(&code.date).to_owned()),
        ]
    };
    let head = ["code", "version", "passes", "passes at first order", "wrong", "not run", "date"];
    Table::new("Codes", &head, codes.iter().map(row).collect(), "")
}

/// Codes with their looks: ours is black, the others follow each other.
fn looks(codes: &[Code]) -> impl Iterator<Item = (&Code, Look)> {
    let mut place = 0;
    codes.iter().map(move |code| {
        if code.name == OWN {
            return (code, Look::new(BLACK, Marker::Star).radius(5.0));
        }
        place += 1;
        // The sixth look is black as well.
        (code, nth(place - 1 + (place - 1) / 5))
    })
}

/// Errors of all codes on a case against cells and against CPU time.
fn curves(codes: &[Code], case: &Case, name: &'static str) -> Figure {
    let by = case.refined_by.as_str();
    let mut mesh = Panel::new("", Axis::log(by, "refinement"), Axis::log("|error|", "error"));
    let mut cost = Panel::new("", Axis::log("CPU time (s)", "cpu_s"), Axis::log("|error|", "error"));
    for (code, look) in looks(codes) {
        let Some(score) = code.scores.iter().find(|score| score.case == case.name) else { continue };
        let known = || score.levels.iter().filter_map(|level| Some((level, level.error?)));
        let point = |x: f64, error: f64| Point::new(x, error.abs()).open(error < 0.0);
        mesh.add(Series::new(&code.name, look, Mark::LinePoints, known().map(|(level, e)| point(level.refinement, e))));
        let timed = known().filter_map(|(level, e)| Some(point(level.cpu_s?, e)));
        cost.add(Series::new(&code.name, look, Mark::LinePoints, timed).unlisted());
    }
    let ticks = case.refinements.iter().map(|refinement| (*refinement, refinement.to_string())).collect();
    let finest = case.refinements[case.refinements.len() - 1];
    let (first, last) = (case.refinements[0] / 1.15, finest * 1.15);
    mesh.x = mesh.x.clone().named(ticks).range(first, last);
    for (error, order, dash) in [(case.expected[0], 1, Dash::Dotted), (case.expected[1], 2, Dash::Dashed)] {
        let line = [first, last].map(|refinement| (refinement, error * (finest / refinement).powi(order)));
        let word = format!("expected of order {order}");
        mesh.add(Series::line(word, Look::new(GREY, Marker::Dot).dash(dash).width(1.2), line).guide());
    }
    // Room for what is expected on the finest mesh, and for round-off no more than that.
    let known = [mesh.all_y(), cost.all_y(), case.expected.to_vec()].concat();
    let placed = known.into_iter().filter(|error| *error > FLOOR);
    let (low, high) = placed.fold((f64::INFINITY, 0.0_f64), |(low, high), y| (low.min(y), high.max(y)));
    let mut panels = vec![mesh, cost];
    panels.iter_mut().for_each(|panel| panel.y.range = Some((0.5 * low, 2.0 * high)));
    Figure {
        name,
        title: format!("{}: error against cells and against CPU time", case.name),
        caption: "Error in the norm of the case. Filled: too large; open: too small. CPU time is that of the whole command, start of the program \
                  included."
            .to_owned(),
        height: 320.0,
        panels,
        missing: Vec::new(),
    }
}

/// The picture of the leaderboard: of the cases that have an order the one that most codes answer.
fn speed(codes: &[Code], cases: &[&Case]) -> Figure {
    let answered = |case: &&&Case| {
        let known = codes.iter().flat_map(|code| &code.scores).filter(|s| s.case == case.name && s.finest().is_some());
        known.count()
    };
    // Of as many the first.
    match cases.iter().filter(|case| !case.exact_by_nature).rev().max_by_key(answered) {
        Some(case) => curves(codes, case, "cpu-against-error"),
        None => Figure { panels: vec![Panel::blank()], ..empty() },
    }
}

fn empty() -> Figure {
    Figure {
        name: "cpu-against-error",
        title: String::new(),
        caption: String::new(),
        height: 100.0,
        panels: Vec::new(),
        missing: vec!["no code has answered a case".to_owned()],
    }
}

fn case_page(codes: &[Code], case: &Case, folder: &Path) -> Result<(), ReportError> {
    fs::create_dir_all(folder).map_err(|e| unwritable(folder, e))?;
    let figure = curves(codes, case, "errors");
    plots::write_svg_and_numbers(&figure, folder)?;
    let row = |code: &Code| {
        let score = code.scores.iter().find(|score| score.case == case.name)?;
        let finest = score.levels.iter().rev().find(|level| level.error.is_some());
        let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| short(value, 2));
        Some(vec![
            Cell::new(code.name.clone()).linked(&format!("../../codes/{}/index.html", file_name(&code.name))),
            badge(score.verdict),
            Cell::new(errors(score)),
            order(score),
            Cell::new(number(finest.and_then(|level| level.cpu_s))),
            Cell::new(number(finest.and_then(|level| level.peak_mib))),
            Cell::prose(score.reason.clone()).small(score.flags.join("; ")),
        ])
    };
    let head = ["code", "verdict", "errors, coarse to fine", "order", "CPU (s)", "memory (MiB)", "why"];
    let table = Table::new(
        "Codes",
        &head,
        codes.iter().filter_map(row).collect(),
        "CPU time and peak memory on the finest refinement.",
    );
    Page::new(format!("Leaderboard: {}", case.name))
        .lead(case.title.clone())
        .section(Section::new("errors", "Errors").figure_in(&figure, ".", &["csv", "svg"]))
        .section(Section::new("codes", "Codes").tables([table.words()]))
        .section(section_of((&case.title, &case.problem), case.scene(), &case.equations, &case.sources))
        .below("Leaderboard", "../../index.html")
        .write(&folder.join("index.html"))
}

/// Errors from the coarsest refinement on.
fn errors(score: &Score) -> String {
    let one = |level: &Level| level.error.map_or_else(|| "–".to_owned(), |error| short(error, 2));
    score.levels.iter().map(one).collect::<Vec<_>>().join(", ")
}

fn order(score: &Score) -> Cell {
    let text = score.order.map_or_else(|| "–".to_owned(), |order| short(order, 3));
    Cell::new(text).small(score.order_half_width.map_or_else(String::new, |half| format!("± {}", short(half, 2))))
}

/// The page of a code: every case with its verdict and why. `cases` is where the pages of cases are, if there are any.
pub fn code_page(code: &Code, cases: Option<&str>) -> Page {
    let row = |score: &Score| {
        let name = Cell::new(score.case.clone());
        let linked = cases.filter(|_| score.verdict != Verdict::NotRun);
        let more: Vec<&str> = score.flags.iter().chain(&score.faults).map(String::as_str).collect();
        let cpu: f64 = score.levels.iter().filter_map(|level| level.cpu_s).sum();
        vec![
            match linked {
                Some(cases) => name.linked(&format!("{cases}/{}/index.html", score.case)),
                None => name,
            },
            badge(score.verdict),
            Cell::new(errors(score)),
            order(score),
            Cell::new(if cpu > 0.0 { short(cpu, 2) } else { "–".to_owned() }),
            Cell::new(score.reason.clone()).small(more.join("; ")),
        ]
    };
    let head = ["case", "verdict", "errors, coarse to fine", "order", "CPU (s)", "why"];
    let rows = code.scores.iter().map(row).collect();
    let made: Vec<(String, String)> = MISTAKES
        .iter()
        .filter(|mistake| code.scores.iter().any(|score| score.mistakes.iter().any(|name| name == mistake.name)))
        .map(|mistake| (mistake.name.to_owned(), mistake.words.to_owned()))
        .collect();
    let mut page = Page::new(format!("Score of {}", code.name)).lead(format!("{}.", code.sentence())).section(
        Section::new("cases", "Cases").index(Table::new("Cases", &head, rows, "CPU time of all refinements.").words()),
    );
    if !made.is_empty() {
        page = page.section(Section::new("mistakes", "What wrong results look like").with(Block::Terms(made)));
    }
    let settings = if code.about.settings.is_null() { String::new() } else { code.about.settings.to_string() };
    let said = [
        ("version", &code.about.version),
        ("settings", &settings),
        ("machine", &code.about.machine),
        ("command", &code.command),
        ("date", &code.date),
    ];
    page.conditions =
        said.into_iter().filter(|(_, text)| !text.is_empty()).map(|(n, t)| (n.to_owned(), t.clone())).collect();
    page
}

/// The page of a score with its curves.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write_code(code: &Code, cases: &[Case], folder: &Path) -> Result<(), ReportError> {
    plots::ready();
    let mut page = code_page(code, None).report(Report { date: code.date.clone(), ..Report::new(Kind::Score) });
    let mut section = Section::new("curves", "Errors against cells and CPU time");
    let plots = folder.join("plots");
    fs::create_dir_all(&plots).map_err(|e| unwritable(&plots, e))?;
    let one = std::slice::from_ref(code);
    let mut images = Vec::new();
    for case in cases.iter().filter(|case| code.scores.iter().any(|s| s.case == case.name && s.finest().is_some())) {
        let own = plots.join(&case.name);
        fs::create_dir_all(&own).map_err(|e| unwritable(&own, e))?;
        plots::write_svg_and_numbers(&curves(one, case, "errors"), &own)?;
        let alt = format!("Errors of {} on the case {} against cells and against CPU time", code.name, case.name);
        let src = format!("plots/{}/errors.svg", case.name);
        images.push(Image { href: src.clone(), src, alt, caption: case.name.clone() });
    }
    if !images.is_empty() {
        section = section.with(Block::Images(images));
    }
    page = page.section(section);
    page.write(&folder.join("index.html"))
}

//! The leaderboard: how many cases each code solves to 1 % and 0.1 % at which cost; codes by cases; a page for each case and each
//! code.

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
use crate::rates::Order;
use crate::report::case::{STYLE, exact_section, problem_of};
use crate::report::content::table::{order_cell, order_rule};
use crate::report::numbers::{exact, short};
use crate::report::plots::axis::Axis;
use crate::report::plots::figure::{Figure, Mark, Panel, Point, Series};
use crate::report::plots::look::{BLACK, Dash, GREY, Look, Marker, nth};
use crate::report::plots::{self};
use crate::report::{ReportError, save, tables, unwritable};
use crate::study::word;

/// Name of the table of all scores.
pub const BOARD: &str = "leaderboard.csv";
const COLUMNS: &str = "code,version,date,case,seed,verdict,refinement,error,order,order_half_width,expected_first,expected_second,\
    cpu_s,wall_s,peak_mib,conservation,mistakes,flags,reason,order_verdict,solve_s";

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

/// Errors within which a case counts as solved, in words.
const WITHIN: [(f64, &str); 2] = [(1e-2, "1 %"), (1e-3, "0.1 %")];
/// Errors that differ by a smaller factor are alike.
const ALIKE: f64 = 1.5;

/// Smaller errors are round-off, and have no place in a picture.
const FLOOR: f64 = 1e-13;

/// Judges stored scores by the rule of today.
pub fn judge(codes: &mut [Code], cases: &[Case]) {
    for score in codes.iter_mut().flat_map(|code| &mut code.scores) {
        if let Some(case) = cases.iter().find(|case| case.name == score.case) {
            score.judge(case);
        }
    }
}

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
    let picture = solved(codes, &cases);
    let plots = folder.join("plots");
    fs::create_dir_all(&plots).map_err(|e| unwritable(&plots, e))?;
    plots::write(&picture, &plots)?;
    let (shared, alone): (Vec<&Case>, Vec<&Case>) = cases.iter().partition(|case| answers(codes, case).count() > 1);
    let report = Report::new(Kind::Leaderboard)
        .picture("plots/solved-against-cpu.svg", "Share of all cases that each code solves within a CPU time");
    let sentence = format!("{} codes on {} cases with exact or published solutions.", codes.len(), cases.len());
    let mut page = Page::new("Leaderboard")
        .lead(format!(
            "{sentence} Each code answers the same `case.json` by itself, is measured from outside, and is judged in the norms of the \
             verification suite."
        ))
        .section(Section::new("solved", "Cases solved").figure(&picture).tables([totals(codes, &cases)]).note(MEASURED))
        .section(Section::new("cheaper", "Where another code is cheaper").tables(cheaper(codes, &cases)))
        .section(matrix(codes, &shared, ("scores", "Cases that several codes answer")))
        .section(matrix(codes, &alone, ("alone", "Cases that one code answers")).folded())
        .section(Section::new("codes", "Verdicts by code").tables([table_of_codes(codes)]))
        .section(Section::new("data", "Data").files([BOARD]))
        .report(Report { date: latest(codes), ..report });
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
            let none =
                [Level { refinement: f64::NAN, error: None, cpu_s: None, wall_s: None, peak_mib: None, solve_s: None }];
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
                    score.convergence().order.word().to_owned(),
                    maybe(level.solve_s),
                ]);
            }
        }
    }
    rows
}

/// Codes by cases.
fn matrix(codes: &[Code], cases: &[&Case], (id, title): (&str, &str)) -> Section {
    if cases.is_empty() {
        return Section::new(id, title);
    }
    let row = |case: &&Case| {
        let at = common(codes, &case.name);
        let on = at.map_or_else(String::new, |at| format!("{at} {}", case.refined_by));
        let mut row = vec![Cell::new(case.name.clone()).linked(&format!("cases/{}/index.html", case.name)).small(on)];
        row.extend(codes.iter().map(|code| match code.scores.iter().find(|score| score.case == case.name) {
            Some(score) if score.verdict != Verdict::NotRun => {
                let error =
                    at.and_then(|at| level(score, at)?.error).map_or_else(|| "–".to_owned(), |e| short(e.abs(), 2));
                let found = score.convergence();
                let order = match found.order {
                    Order::NotExpected | Order::NotEstablished => String::new(),
                    Order::RoundOff => ", round-off".to_owned(),
                    Order::Passed | Order::Failed => format!(", order {}", found.words()),
                };
                badge(score.verdict).small(format!("{error}{order}"))
            }
            _ => Cell::new("–"),
        }));
        row
    };
    let mut head = vec!["case, refinement of the errors"];
    head.extend(codes.iter().map(|code| code.name.as_str()));
    let note = format!(
        "Verdict; below it the error on the finest refinement that all codes with an answer have, and the order over all refinements where it is \
         established. A dash: the code does not answer the case. {}",
        order_rule()
    );
    let table = Table::new("Codes by cases", &head, cases.iter().map(row).collect(), &note);
    Section::new(id, title).index(table)
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
    let head = ["code", "version", "passes", "passes at first order", "wrong", "not answered", "date"];
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
        let stated: Vec<Point> = known().filter_map(|(level, e)| Some(point(level.solve_s?, e))).collect();
        if !stated.is_empty() {
            let look = look.dash(Dash::Dashed);
            cost.add(Series::new(format!("{}, solution alone", code.name), look, Mark::LinePoints, stated));
        }
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
        caption: format!("Error in the norm of the case. Filled: too large; open: too small. {MEASURED}"),
        height: 320.0,
        panels,
        missing: Vec::new(),
    }
}

/// Definition of the CPU time.
const MEASURED: &str = "CPU time is that of the whole command, measured from outside, the start of the program included: alike for all \
                        codes. That of the solution alone is what a code says of itself in `run.json`.";

/// The answers to a case.
fn answers<'a>(codes: &'a [Code], case: &'a Case) -> impl Iterator<Item = (&'a Code, &'a Score)> {
    codes.iter().filter_map(move |code| {
        let own = code.scores.iter().find(|score| score.case == case.name && score.verdict != Verdict::NotRun)?;
        Some((code, own))
    })
}

/// The coarsest refinement from which on all errors are within a share; errors in m are shares of the longer side of the soil.
fn within<'a>(case: &Case, score: &'a Score, share: f64) -> Option<&'a Level> {
    let side = case.scene().filter(|_| case.error_unit == "m").map_or(1.0, |scene| scene.height.max(scene.width));
    let fine = |level: &&Level| level.error.is_some_and(|error| error.abs() <= share * side);
    score.levels.iter().rev().filter(|level| level.error.is_some()).take_while(fine).last()
}

/// The share of all cases that each code solves within a CPU time (Dolan & More 2002, More & Wild 2009).
fn solved(codes: &[Code], cases: &[&Case]) -> Figure {
    let panel = |(share, words): (f64, &str)| {
        let mut panel = Panel::new(
            &format!("Error of at most {words}"),
            Axis::log("CPU time (s)", "cpu_s"),
            Axis::linear("share of all cases (%)", "share_percent").range(0.0, 100.0),
        );
        for (code, look) in looks(codes) {
            let cost = |case: &&Case| {
                let (_, score) = answers(std::slice::from_ref(code), case).next()?;
                within(case, score, share)?.cpu_s
            };
            let mut costs: Vec<f64> = cases.iter().filter_map(cost).collect();
            costs.sort_by(f64::total_cmp);
            let percent = |n: usize| 100.0 * n as f64 / cases.len() as f64;
            let steps = costs.iter().enumerate().flat_map(|(n, cost)| [(*cost, percent(n)), (*cost, percent(n + 1))]);
            panel.add(Series::line(&code.name, look.width(2.0), steps));
        }
        panel
    };
    let panels: Vec<Panel> = WITHIN.map(panel).to_vec();
    Figure {
        name: "solved-against-cpu",
        title: "Cases solved within a CPU time".to_owned(),
        caption: format!(
            "Share of all {} cases that a code solves to 1 % (left) and to 0.1 % (right) within a CPU time, on the coarsest refinement from which \
             on all errors are within that. Higher and further left is better; a case that a code does not answer is not solved.",
            cases.len()
        ),
        height: 300.0,
        missing: Vec::new(),
        panels,
    }
}

/// Shares of the cases that each code solves, and their cost.
fn totals(codes: &[Code], cases: &[&Case]) -> Table {
    let row = |code: &Code| {
        let own = || cases.iter().filter_map(|case| Some((*case, answers(std::slice::from_ref(code), case).next()?.1)));
        let answered = own().count();
        let levels = |share: f64| own().filter_map(move |(case, score)| within(case, score, share));
        let mut row = vec![
            Cell::new(code.name.clone()).linked(&format!("codes/{}/index.html", file_name(&code.name))),
            Cell::new(answered.to_string()),
        ];
        for (share, _) in WITHIN {
            let solved = levels(share).count();
            let of = |all: usize| format!("{:.0} %", 100.0 * solved as f64 / all.max(1) as f64);
            row.extend([Cell::new(of(answered)), Cell::new(of(cases.len()))]);
        }
        row.push(median(levels(WITHIN[0].0).filter_map(|level| level.cpu_s)));
        row.push(median(levels(WITHIN[0].0).filter_map(|level| level.solve_s)));
        let runs = code.scores.iter().flat_map(|score| &score.levels).filter_map(|level| level.cpu_s);
        let least = runs.fold(f64::INFINITY, f64::min);
        row.push(Cell::new(if least.is_finite() { short(least, 2) } else { "–".to_owned() }));
        row
    };
    let head = [
        "code",
        "cases answered",
        "1 %: of answered",
        "1 %: of all",
        "0.1 %: of answered",
        "0.1 %: of all",
        "CPU for 1 %, median (s)",
        "solution alone (s)",
        "least CPU of a run (s)",
    ];
    let note = format!(
        "Solved: every error from one refinement on is within 1 % or 0.1 %; of {} cases that any code answers. Medians are over the cases that \
         the code itself solves. The least CPU time of any run is close to what starting the program takes.",
        cases.len()
    );
    Table::new("Cases solved by each code", &head, codes.iter().map(row).collect(), &note)
}

/// The middle of some times, s.
fn median(times: impl Iterator<Item = f64>) -> Cell {
    let mut times: Vec<f64> = times.collect();
    times.sort_by(f64::total_cmp);
    Cell::new(times.get(times.len() / 2).map_or_else(|| "–".to_owned(), |time| short(*time, 2)))
}

/// Cases on which another code is about as accurate as ours for less CPU time, and why.
fn cheaper(codes: &[Code], cases: &[&Case]) -> Option<Table> {
    let row = |case: &&Case| {
        let at = common(codes, &case.name)?;
        let found = |score: &Score| {
            let level = level(score, at)?;
            Some((level.error?.abs(), level.cpu_s?))
        };
        let (error, cpu) = answers(codes, case).find(|(code, _)| code.name == OWN).and_then(|(_, own)| found(own))?;
        let others = answers(codes, case).filter(|(code, _)| code.name != OWN);
        let alike = others.filter_map(|(code, score)| Some((code, found(score)?)));
        let alike = alike.filter(|(_, (other, time))| *other <= ALIKE * error && *time < cpu);
        let (code, (other, time)) = alike.min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
        let method = case.scene().map_or_else(|| "–".to_owned(), |scene| word(scene.integrator));
        Some(vec![
            Cell::new(case.name.clone()).linked(&format!("cases/{}/index.html", case.name)),
            Cell::new(code.name.clone()),
            Cell::new(short(other, 2)),
            Cell::new(short(time, 2)),
            Cell::new(short(error, 2)),
            Cell::new(short(cpu, 2)),
            Cell::new(method),
        ])
    };
    let rows: Vec<_> = cases.iter().filter_map(row).collect();
    let head = ["case", "code", "its error", "its CPU (s)", "our error", "our CPU (s)", "our integrator"];
    let note = format!(
        "On the finest refinement that all codes with an answer have, errors at most {ALIKE} times ours; the cheapest of the other codes. Our \
         answers take the method of the case in the suite. Where that is the paper's explicit scheme, the wave speed bounds its steps; the toy \
         (finite differences) and the finite volumes solve the one-dimensional diffusion of pressure alone, in a few hundred implicit steps that \
         no wave speed bounds."
    );
    (!rows.is_empty())
        .then(|| Table::new("Cases on which another code is as accurate for less CPU time", &head, rows, &note))
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
            order_cell(&score.convergence()),
            Cell::new(number(finest.and_then(|level| level.cpu_s))),
            Cell::new(number(finest.and_then(|level| level.solve_s))),
            Cell::new(number(finest.and_then(|level| level.peak_mib))),
            Cell::prose(score.reason.clone()).small(score.flags.join("; ")),
        ])
    };
    let head = ["code", "verdict", "errors, coarse to fine", "order", "CPU (s)", "solution (s)", "memory (MiB)", "why"];
    let table = Table::new(
        "Codes",
        &head,
        codes.iter().filter_map(row).collect(),
        "CPU time of the whole command, of the solution alone as the code says, and peak memory on the finest refinement.",
    );
    Page::new(format!("Leaderboard: {}", case.name))
        .lead(case.title.clone())
        .section(Section::new("errors", "Errors").figure_in(&figure, ".", &["csv", "svg"]))
        .section(Section::new("codes", "Codes").tables([table.words()]))
        .style(STYLE)
        .section(problem_of((&case.title, &case.problem), case.scene()))
        .section(exact_section(&case.equations, &[], &case.sources))
        .below("Leaderboard", "../../index.html")
        .write(&folder.join("index.html"))
}

/// Errors from the coarsest refinement on.
fn errors(score: &Score) -> String {
    let one = |level: &Level| level.error.map_or_else(|| "–".to_owned(), |error| short(error, 2));
    score.levels.iter().map(one).collect::<Vec<_>>().join(", ")
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
            order_cell(&score.convergence()),
            Cell::new(if cpu > 0.0 { short(cpu, 2) } else { "–".to_owned() }),
            Cell::new(score.reason.clone()).small(more.join("; ")),
        ]
    };
    let head = ["case", "verdict", "errors, coarse to fine", "order", "CPU (s)", "why"];
    let (answered, rest): (Vec<&Score>, Vec<&Score>) =
        code.scores.iter().partition(|score| score.verdict != Verdict::NotRun);
    let rows = answered.into_iter().map(row).collect();
    let not_answered = |score: &&Score| vec![Cell::new(score.case.clone()), Cell::prose(score.reason.clone())];
    let not_answered: Vec<_> = rest.iter().map(not_answered).collect();
    let made: Vec<(String, String)> = MISTAKES
        .iter()
        .filter(|mistake| code.scores.iter().any(|score| score.mistakes.iter().any(|name| name == mistake.name)))
        .map(|mistake| (mistake.name.to_owned(), mistake.words.to_owned()))
        .collect();
    let mut page = Page::new(format!("Score of {}", code.name)).lead(format!("{}.", code.sentence())).section(
        Section::new("cases", "Cases").index(Table::new("Cases", &head, rows, "CPU time of all refinements.").words()),
    );
    if !not_answered.is_empty() {
        let table = Table::new("Cases without an answer", &["case", "why"], not_answered, "").words();
        page = page.section(Section::new("not-answered", "Not answered").tables([table]).folded());
    }
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

#[cfg(test)]
mod tests {
    use super::super::case::chosen;
    use super::*;

    /// A score with these errors, each of so much CPU time.
    fn scored(case: &Case, runs: &[(f64, f64)]) -> Score {
        let level = |(refinement, (error, cpu)): (&f64, &(f64, f64))| Level {
            refinement: *refinement,
            error: Some(*error),
            cpu_s: Some(*cpu),
            wall_s: None,
            peak_mib: None,
            solve_s: Some(0.1 * cpu),
        };
        let levels = case.refinements.iter().zip(runs).map(level).collect();
        let mut score = Score { levels, ..Score::not_run(case, "") };
        score.judge(case);
        score
    }

    #[test]
    fn the_board_opens_on_all_cases_and_folds_what_one_code_answers() {
        let names = ["consolidation", "two-layers", "flow-in-series"].map(str::to_owned);
        let cases = chosen(&names, 0).expect("cases");
        let find = |name: &str| cases.iter().find(|case| case.name == name).expect(name);
        let code = |name: &str, scores: Vec<Score>| Code { name: name.to_owned(), scores, ..Code::default() };
        // An error that is small on one mesh by chance does not count; the order of -10.2 of what is exact by nature is none.
        let series = scored(find("flow-in-series"), &[(-2.6e-13, 1.0), (-2.9e-10, 2.0)]);
        assert_eq!((series.verdict, series.convergence().order), (Verdict::Passes, Order::NotExpected));
        let own = code(
            OWN,
            vec![
                scored(find("consolidation"), &[(5e-3, 1.0), (2e-2, 2.0), (8e-3, 3.0)]),
                scored(find("two-layers"), &[(2e-2, 1.0), (5e-3, 2.0), (5e-4, 4.0)]),
                series,
            ],
        );
        let toy = code("toy", vec![scored(find("consolidation"), &[(6e-2, 0.1), (1.5e-2, 0.2), (3.8e-3, 0.3)])]);
        let consolidation = within(find("consolidation"), &own.scores[0], 1e-2).expect("a level");
        assert_eq!(consolidation.cpu_s, Some(3.0));
        let folder = tempfile::tempdir().expect("a folder");
        write(&[own, toy], &cases, folder.path()).expect("pages");
        let page = fs::read_to_string(folder.path().join("index.html")).expect("a page");
        let places = ["Cases solved by each code", "as accurate for less CPU time", "id=\"scores\"", "id=\"alone\""];
        let places = places.map(|part| page.find(part).unwrap_or_else(|| panic!("{part}")));
        assert!(places.is_sorted(), "{places:?}");
        // Of three cases ours solves all to 1 %, two to 0.1 %; the toy one of its one.
        for part in
            ["<td>100 %</td><td>100 %</td><td>67 %</td><td>67 %</td>", "<td>100 %</td><td>33 %</td><td>0 %</td>"]
        {
            assert!(page.contains(part), "{part}");
        }
        assert!(page[places[2]..].contains("<details") && !page[..places[2]].contains("flow-in-series"));
        assert!(!page.contains("not run") && !page.contains("-10.1"));
    }
}

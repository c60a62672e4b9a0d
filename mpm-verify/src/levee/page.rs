//! The page of a run: verdict, the run as a moving picture, claims, numbers, further pictures, assumptions, how to run it again.

use std::path::Path;

use mpm_core::failure::Scales;

use super::assumptions;
use super::claims::Claim;
use super::figures::Picture;
use super::limits::{self, Limit};
use super::plan::Plan;
use super::ranges::{Range, Ranges, Spread};
use super::run::Followed;
use super::safety;
use super::summary::Summary;
use crate::page::picture::alternative;
use crate::page::site::{Kind, Report};
use crate::page::table::{Cell, Table};
use crate::page::verdict::{Counts, State, Tally, Verdict};
use crate::page::{Block, Image, Page, Section, escaped};
use crate::report::animation::{self, Player};
use crate::report::numbers::short;
use crate::report::{ReportError, solved};

/// Looks of the headline numbers.
const STYLE: &str = ".facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(10.4rem, 1fr)); gap: 0.6rem; margin: 0.8rem 0; }
.facts > div { display: block; padding: 0.5rem 0.8rem; background: var(--band); border: 1px solid var(--line); border-radius: 6px; }
.facts dt { font-weight: 400; font-size: 0.84rem; color: var(--soft); }
.facts dd { font-size: 0.84rem; }
.facts dd.value { font-size: 1.3rem; font-weight: 600; line-height: 1.3; }
";

/// A headline number.
#[derive(Debug)]
struct Fact {
    name: &'static str,
    value: String,
    /// How far it moves with the mesh and the assumptions.
    ranges: String,
    /// What paper and experiment say; empty for other scenes.
    compared: &'static str,
}

/// Files that the page links to where they are there.
const FILES: [&str; 16] = [
    "summary.json",
    "history.csv",
    "events.csv",
    "paths.csv",
    "claims.csv",
    "safety_factor.csv",
    "sensitivity.csv",
    "ensemble.csv",
    "probability.csv",
    "convergence.csv",
    "drivers.csv",
    "frames.bin",
    "levee.png",
    "vtk/solid.pvd",
    "vtk/water.pvd",
    "vtk/view.py",
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
    /// How far these move with the mesh and the assumptions.
    pub ranges: &'a Ranges,
    /// Factors of safety over time, if they were computed.
    pub factors: &'a [safety::Line],
    /// The run as a moving picture, if it has frames.
    pub player: Option<Player>,
    /// Judged claims of the paper, of its levee.
    pub claims: Option<&'a [Claim]>,
    /// Pictures in their order.
    pub pictures: &'a [Picture],
    /// Further tables: factors of safety, variants.
    pub further: Vec<Table>,
    /// Tables in the folder that are of other scenes.
    pub others: Vec<String>,
}

/// Writes `index.html`, and `report.json` beside it.
///
/// # Errors
/// A file that cannot be written, or a template that does not fit.
pub fn write(parts: Parts, (known, folder): (&Path, &Path)) -> Result<(), ReportError> {
    let Parts { plan, run, summary, ranges, factors, player, claims, pictures, further, others } = parts;
    let papers = claims.is_some();
    let there = |file: &&str| folder.join(file).exists() || known.join(file).exists();
    let files = FILES.into_iter().filter(there).filter(|file| papers || *file != "claims.csv");
    let counted = claims.map(counts);
    let facts = facts(summary, ranges, papers).into_iter().chain(interval(factors)).collect::<Vec<_>>();
    let assumed = if papers {
        "Input of this run; the paper does not print all of it. How much each assumption matters: `mpm-verify levee --sensitivity`."
    } else {
        "Input of this run."
    };
    let terms = assumptions::of(&plan.scene, summary).into_iter().map(|(name, value)| (name.to_owned(), value));
    let command = summary.manifest.entries().into_iter().find(|(name, _)| *name == "command");
    let again = command.map_or_else(Vec::new, |(_, command)| vec![Block::Command(command)]);
    let moving = player.as_ref().map(|player| Block::Html(player.html()));
    let summary_of_frames = player.map(|player| Block::Note(player.summary));
    let headline = (!facts.is_empty()).then(|| Block::Html(cards(&facts)));
    let first = Section { id: "run".to_owned(), ..Section::default() };
    let tallies = counted.map(|counts| Tally::new("Claims on the levee", counts));
    // The moving picture is what is seen without scrolling.
    let first = [moving, headline, summary_of_frames].into_iter().flatten().fold(first, Section::with);
    let report = Report::new(if papers { Kind::Levee } else { Kind::Scene })
        .counts(tallies)
        .picture("levee.png", "Water seeps through the soil until its slope fails, as an animation");
    Page::new(title(plan, summary))
        .verdict(verdict(summary, counted.as_ref()))
        .lead(story(summary, papers))
        .warnings(run.ended.trouble().map(str::to_owned).into_iter().chain(others))
        .style(format!("{STYLE}{}", animation::STYLE))
        .section(first)
        .section(Section::new("claims", "Claims").tables(claims.map(judged)))
        .section(Section::new("numbers", "Numbers").tables(numbers(summary, ranges, &plan.scales(), papers)))
        .section(Section::new("further", "Factor of safety, meshes, assumptions").folded().tables(further))
        .section(drawn(pictures))
        .section(Section::new("assumptions", "Assumptions").text(assumed).with(Block::Terms(terms.collect())))
        .section(again.into_iter().fold(Section::new("again", "Run it again"), Section::with).files(files))
        .conditions(&summary.manifest)
        .report(report)
        .write(&folder.join("index.html"))
}

/// Pictures: as drawings where they are light, as images of files beside the page where they are not.
fn drawn(pictures: &[Picture]) -> Section {
    pictures.iter().fold(Section::new("pictures", "Further pictures").folded(), |section, picture| {
        let figure = &picture.figure;
        if picture.is_light {
            return section.figure(figure);
        }
        let [image, table] = ["png", "csv"].map(|ending| format!("plots/{}.{ending}", figure.name));
        let caption = format!("{}. {} [numbers]({table})", figure.title, figure.caption);
        section.with(Block::Images(vec![Image { src: image.clone(), alt: alternative(figure), caption, href: image }]))
    })
}

/// The headline numbers side by side.
fn cards(facts: &[Fact]) -> String {
    let card = |fact: &Fact| {
        let compared = match fact.compared {
            "" => String::new(),
            said => format!("<dd class=\"soft\">{}</dd>", escaped(said)),
        };
        format!(
            "<div><dt>{}</dt><dd class=\"value\">{}</dd><dd>{}</dd>{compared}</div>\n",
            escaped(fact.name),
            escaped(&fact.value),
            escaped(&fact.ranges)
        )
    };
    format!("<dl class=\"facts\">\n{}</dl>", facts.iter().map(card).collect::<String>())
}

fn title(plan: &Plan, summary: &Summary) -> String {
    let variant = summary.variant.as_ref().map_or_else(String::new, |name| format!(", variant {name}"));
    let subject = if plan.papers() { "Seepage failure of a levee" } else { "Seepage and stability of a slope" };
    // The scene that is called as its subject adds nothing to the title.
    let name = if subject.ends_with(&plan.scene.name) {
        String::new()
    } else {
        format!(": {}", solved::title(&plan.scene.name))
    };
    format!("{subject}{name}{variant}")
}

fn counts(claims: &[Claim]) -> Counts {
    Counts::of_claims(claims.iter().map(|claim| claim.verdict))
}

/// The verdict: of a levee that ended as it should, how many claims are reproduced; of another slope, whether its checks passed.
fn verdict(s: &Summary, claims: Option<&Counts>) -> Verdict {
    let failed: Vec<&str> = limits::of(s).iter().filter(|limit| !limit.passed()).map(|limit| limit.name).collect();
    if matches!(s.ended.as_str(), "run-failed" | "stopped" | "does-not-stand") {
        return Verdict::new(State::Stopped, format!("The run ended early: {}.", s.ended.replace('-', " ")));
    }
    if let [first, ..] = failed[..] {
        let more = if failed.len() > 1 { format!(" and {} more", failed.len() - 1) } else { String::new() };
        return Verdict::new(State::Failed, format!("A check of the run failed: {first}{more}."));
    }
    let Some(claims) = claims else { return Verdict::new(State::Complete, "All checks of the run passed.") };
    let sentence = format!("Claims of the paper and the experiment: {}; all checks of the run passed.", claims.words());
    Verdict::new(claims.state(), sentence)
}

/// Whether and how it failed.
fn story(s: &Summary, papers: bool) -> String {
    let subject = if papers { "levee" } else { "slope" };
    let Some(failure) = s.failure_start_h else {
        return match s.end_h {
            Some(end) => format!("The {subject} has not failed when the run ends at {end:.1} h."),
            None if s.ended == "run-failed" => "The run stopped with an error before any water seeped.".to_owned(),
            None => format!("The {subject} does not stand before any water seeps."),
        };
    };
    let after = |seconds: f64| lasting(3600.0 * seconds);
    let onset = match s.raveling_h.map(|first| failure - first).filter(|span| 3600.0 * span >= 0.05) {
        Some(span) => format!("first the toe (E1), {} later the deeper soil (E2)", after(span)),
        None => "at the toe and deeper at the same time (E1, E2)".to_owned(),
    };
    let rapid = match s.rapid_failure_h {
        Some(rapid) => format!(", rapidly {} after that (E3)", after(rapid - failure)),
        None => "; the failure does not become rapid".to_owned(),
    };
    let rest = match (s.ended.as_str(), s.failure_lasts_s) {
        ("collapsed", Some(lasts)) => format!("; the soil is at rest {} after E2.", lasting(lasts)),
        _ => ".".to_owned(),
    };
    format!("The {subject} fails: {onset}{rapid}{rest}")
}

/// A time span for readers, with two digits.
fn lasting(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{} s", short(s, 2)),
        s if s < 7200.0 => format!("{} min", short(s / 60.0, 2)),
        s => format!("{} h", short(s / 3600.0, 2)),
    }
}

fn facts(s: &Summary, ranges: &Ranges, papers: bool) -> Vec<Fact> {
    let fact = |name, value: Option<f64>, spread: Spread, (unit, decimals): (&'static str, usize), said| {
        let text = ranges.beside(value?, spread, (unit, decimals));
        let (value, beside) = text.split_once(" (").unwrap_or((&text, ""));
        let compared = if papers { said } else { "" };
        Some(Fact { name, value: value.to_owned(), ranges: beside.trim_end_matches(')').to_owned(), compared })
    };
    let paper = "paper 8.7 h; experiment 13 h";
    let lasts = s.failure_lasts_s.filter(|_| s.ended == "collapsed").map(|seconds| Fact {
        name: "From failure (E2) to rest",
        value: lasting(seconds),
        ranges: "one mesh".to_owned(),
        compared: if papers { "paper 72 s; experiment 10 min, of which 30 s rapid" } else { "" },
    });
    let three = [
        fact("Failure starts (E2)", s.failure_start_h, ranges.failure_h, ("h", 1), paper),
        fact("Run-out of the toe", s.runout_m, ranges.runout_m, ("m", 1), "no number in the paper"),
        fact("Settlement of the crest", s.crest_settlement_m, ranges.crest_m, ("m", 2), "no number in the paper"),
    ];
    three.into_iter().flatten().chain(lasts).collect()
}

/// When the slope fails by its factors of safety: an interval, from Davis' strength to the full one.
fn interval(factors: &[safety::Line]) -> Option<Fact> {
    let value = match safety::fails_between(factors) {
        [Some(from), Some(to)] => format!("{from:.1} to {to:.1} h"),
        [Some(from), None] => format!("from {from:.1} h"),
        [None, Some(to)] => format!("until {to:.1} h"),
        [None, None] => return None,
    };
    let ranges = "from Davis' to the full strength".to_owned();
    Some(Fact { name: "Factor of safety falls to 1", value, ranges, compared: "" })
}

fn numbers(s: &Summary, ranges: &Ranges, scales: &Scales, papers: bool) -> Vec<Table> {
    let said = |range: Option<Range>, decimals| Cell::new(range.map_or_else(dash, |range| range.said(decimals)));
    let row = |name: &str, value: Option<f64>, (unit, decimals): (&str, usize), spread: Spread| {
        let value = value.map_or_else(dash, |v| format!("{v:.decimals$}").replace('-', "\u{2212}"));
        let cells = [Cell::new(name), Cell::new(value), Cell::new(unit)];
        cells.into_iter().chain([said(spread.meshes, decimals), said(spread.assumptions, decimals)]).collect::<Vec<_>>()
    };
    let none = Spread::default();
    let time = |name: &str, value: Option<f64>, spread: Spread| {
        let mut cells = row(name, value, ("h", 1), spread);
        if value.is_none() {
            cells[1] = Cell::new("did not happen");
        }
        cells
    };
    let span = |name: &str, from: Option<f64>, to: Option<f64>| {
        let text = from.zip(to).map_or_else(dash, |(from, to)| short(3600.0 * (to - from), 2));
        [name, &text, "s", "–", "–"].map(Cell::new).to_vec()
    };
    let strain = s.max_deviator_strain.map_or_else(dash, |v| short(v, 2));
    let before = s.displacement_before_failure_m.map_or_else(dash, |v| short(v, 2));
    let end = s.end_h.filter(|_| s.ended == "collapsed");
    let happened = vec![
        time("water reaches the toe", s.front_at_toe_h, none),
        time("water flows out of the slope", s.first_outflow_h, none),
        time("E1: the toe fails", s.raveling_h, none),
        time("E2: failure starts", s.failure_start_h, ranges.failure_h),
        time("E3: rapid failure", s.rapid_failure_h, none),
        time(if end.is_some() { "the soil is at rest" } else { "end of the run" }, s.end_h, none),
        span("from E1 to E2", s.raveling_h, s.failure_start_h),
        span("from E2 to E3", s.failure_start_h, s.rapid_failure_h),
        span("from E3 to rest", s.rapid_failure_h, end),
        row("where failure starts, x", s.failure_at_m, ("m", 1), none),
        row("toe at the end, x", s.toe_x_m, ("m", 1), none),
        row("run-out, from the toe of the particles at the start", s.runout_m, ("m", 1), ranges.runout_m),
        row("settlement of the crest", s.crest_settlement_m, ("m", 2), ranges.crest_m),
        ["largest displacement before failure starts", &before, "m", "–", "–"].map(Cell::new).to_vec(),
        ["largest deviator strain", &strain, "–", "–", "–"].map(Cell::new).to_vec(),
    ];
    let [e1, e2, e3] = scales.events().map(|moved| short(moved, 2));
    let [all, collapse] = ranges.variants;
    let counted = if all > 0 {
        format!(
            " The assumptions: {collapse} of {all} variants of an input collapse and make up the range; the others do not stand or do not \
             collapse."
        )
    } else {
        String::new()
    };
    let events = format!(
        "E1: 0.5 % of the section has moved more than {e1} m, or the soil does not come to rest. E2: 1 % of the section, deeper than \
         {} m, has moved more than {e2} m. E3: 5 % has moved more than {e3} m. These displacements are shares of the height, beyond the \
         elastic displacement under all that water can add. Run-out and settlement of single runs scatter by a quarter.{counted}",
        short(scales.depth(), 2)
    );
    let head = ["", "this run", "unit", "over meshes", "over the assumptions"];
    vec![
        Table::new("Events and displacements", &head, happened, &events),
        Table::new(
            "Checks of this run",
            &["largest value over the run", "measured", "tolerance", "unit", "verdict"],
            limits::of(s).into_iter().map(kept).collect(),
            "Balance residuals are shares of the mass, of the water in the soil and of the works and losses.",
        ),
        took(s, papers),
    ]
}

fn kept(limit: Limit) -> Vec<Cell> {
    let (verdict, mark) = if limit.passed() { ("passed", "good") } else { ("failed", "bad") };
    vec![
        Cell::new(limit.name),
        Cell::new(limit.found.map_or_else(dash, |v| short(v, 2))),
        Cell::new(short(limit.allowed, 2)),
        Cell::new(limit.unit),
        Cell::badge(verdict, mark),
    ]
}

/// Steps and time.
fn took(s: &Summary, papers: bool) -> Table {
    let count = |name: &str, value: u64| vec![Cell::new(name), Cell::new(value.to_string()), Cell::new("")];
    let other = |name: &str, value: Option<f64>, unit: &str| {
        vec![Cell::new(name), Cell::new(value.map_or_else(dash, |v| short(v, 2))), Cell::new(unit)]
    };
    let mut rows = vec![
        count("seepage steps", s.steps_seepage),
        count("steps in which the soil comes to rest", s.steps_relaxing),
        count("steps of moving soil", s.steps_moving),
        other("CPU time", Some(s.cpu_s), "s"),
    ];
    let mut note = "";
    if papers {
        rows.extend([
            other("checkerboard index, steady with a point source, faces (default)", s.checkerboard_face_operator, "–"),
            other("the same, the paper's nodal operator", s.checkerboard_nodal_operator, "–"),
        ]);
        note = "Both indices of a point source are those of the last frame before failure.";
    }
    Table::new("Cost and operators", &["", "value", "unit"], rows, note)
}

fn dash() -> String {
    "–".to_owned()
}

fn judged(claims: &[Claim]) -> Table {
    let row = |c: &Claim| {
        vec![
            Cell::new(c.paper.clone()).marked(c.rule.clone(), ""),
            Cell::badge(c.verdict.words(), c.verdict.mark()),
            Cell::new(c.value.clone()),
        ]
    };
    let note = "In small letters: the rule that the verdict follows.";
    let head = ["claim", "verdict", "this run"];
    Table::new("Claims of the paper and observations of the experiment", &head, claims.iter().map(row).collect(), note)
        .words()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_of_time_read_well() {
        assert_eq!([0.052, 5.381, 72.4, 600.0, 8000.0].map(lasting), ["0.052 s", "5.4 s", "72 s", "10 min", "2.2 h"]);
    }
}

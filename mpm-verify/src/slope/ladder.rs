//! Published slopes: what strength reduction finds, beside what others have found.
//!
//! Each is run on two meshes. Required: the associated factor on the finer mesh within 3 % of the published one, or inside the spread of
//! published ones; both meshes within 0.02.

use std::path::Path;

use cpu_time::ThreadTime;
use mpm_core::failure::Search;
use mpm_core::scene::{Flags, Reduction, Scene};
use serde::{Deserialize, Serialize};

use super::page::Shown;
use super::{State, distinct, guesses};
use crate::error::Error::{self, Lacks};
use crate::experiment::pool;
use crate::manifest::Manifest;
use crate::page::site::{Kind, Report};
use crate::page::table::{Cell, Table};
use crate::page::verdict::{Checks, Counts, State as Judged, Tally, Verdict};
use crate::page::{Block, Image, Page, Section};
use crate::report::numbers::short;
use crate::report::{ReportError, unwritable};
use crate::scenes::SLOPES;

/// The published factors.
const PUBLISHED: &str = include_str!("../../../reference-data/slopes/published.csv");
/// Name of the table of results.
pub const NAME: &str = "slopes.csv";

/// How far the factor may be from the published one, and two meshes from each other.
const CLOSE: f64 = 0.03;
const MESHES: f64 = 0.02;
/// CPU time that a slope may take, s.
const TIME_S: f64 = 60.0;
/// Width of a bracket.
const WITHIN: f64 = 0.01;

/// A published slope.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Published {
    /// Name of its scene.
    pub name: String,
    /// What it is.
    pub title: String,
    /// Cells of the coarser mesh, m; the finer one is that of the scene.
    pub coarse_m: f64,
    /// The factor of the referee, the authors, or the exact one.
    pub factor: f64,
    /// Least and largest published factor.
    pub low: f64,
    /// See `low`.
    pub high: f64,
    /// Where from.
    pub source: String,
}

/// What is found of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Line {
    /// Name of the scene.
    pub name: String,
    /// Published factor.
    pub published: f64,
    /// Spread of published factors.
    pub published_low: f64,
    /// See `published_low`.
    pub published_high: f64,
    /// Associated, on the coarser mesh.
    pub associated_coarse: f64,
    /// Associated, on the finer mesh.
    pub associated: f64,
    /// Davis B, on the coarser mesh.
    pub davis_coarse: f64,
    /// Davis B, on the finer mesh.
    pub davis: f64,
    /// With the dilation of the scene, on the finer mesh.
    pub as_given: f64,
    /// Spencer's method, circles.
    pub spencer: Option<f64>,
    /// Spencer's method, any shape.
    pub any_shape: Option<f64>,
    /// Cells of both meshes, m.
    pub coarse_m: f64,
    /// See `coarse_m`.
    pub fine_m: f64,
    /// What the associated factor tends to if its error falls with the cells.
    pub associated_limit: f64,
    /// CPU time of all, s.
    pub cpu_s: f64,
    /// What is wrong; empty for nothing.
    pub trouble: String,
}

fn found(error: impl ToString) -> Error {
    Error::Found(error.to_string())
}

/// The list of published slopes.
///
/// # Errors
/// A table that cannot be read.
pub fn published() -> Result<Vec<Published>, Error> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(PUBLISHED.as_bytes());
    reader.deserialize().collect::<Result<_, csv::Error>>().map_err(found)
}

/// Runs slopes, so many at once, each with a page in a folder of its name.
///
/// # Errors
/// What went wrong in a run, or a file that cannot be written.
pub fn run(
    slopes: &[&Published],
    (folder, jobs): (&Path, usize),
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Line>, Error> {
    let told = |_: usize, line: &Result<Result<Line, Error>, Error>| {
        if let Ok(Ok(line)) = line {
            progress(&said(line));
        }
    };
    let lines = pool::each(jobs, slopes, |_, slope| one(slope, folder), told);
    lines.into_iter().map(|line| line.and_then(|line| line)).collect()
}

/// One slope on both meshes.
fn one(slope: &Published, folder: &Path) -> Result<Line, Error> {
    let clock = ThreadTime::now();
    let text = SLOPES.iter().find(|(name, _)| *name == slope.name).ok_or(Lacks("scene of that name"))?.1;
    let fine = Scene::parse(text, &slope.name)?;
    let coarse = Scene::parse_with(text, &slope.name, &Flags { cell: Some(slope.coarse_m), ..Flags::default() })?;
    let state = State::after(&fine, 0.0)?;
    let slices = state.slices();
    let factors = state.factors((WITHIN, guesses(&slices)), 1, &|_| ())?;
    let on_coarse = State::after(&coarse, 0.0)?;
    let coarse = |by: Reduction, guess: f64| {
        let found = on_coarse.factor(&Search { by, within: WITHIN, guess }, &mut |_, _| ())?;
        Ok::<f64, Error>(0.5 * (found.bracket.low + found.bracket.high))
    };
    let middle = |k: usize| 0.5 * (factors.found[k].bracket.low + factors.found[k].bracket.high);
    let rules = [Reduction::Davis, Reduction::Associated];
    let (first, of) = distinct(&fine, rules);
    let found_coarse = first.iter().map(|place| coarse(rules[*place], 1.05 * middle(*place)));
    let found_coarse = found_coarse.collect::<Result<Vec<_>, _>>()?;
    let [davis_coarse, associated_coarse] = of.map(|place| found_coarse[place]);
    let (spencer, any_shape) = slices.as_ref().map_or((None, None), |s| (s[0].spencer, s[0].any_shape));
    let mut line = Line {
        name: slope.name.clone(),
        published: slope.factor,
        published_low: slope.low,
        published_high: slope.high,
        associated_coarse,
        associated: middle(1),
        davis_coarse,
        davis: middle(0),
        as_given: middle(2),
        spencer,
        any_shape,
        coarse_m: slope.coarse_m,
        fine_m: fine.cell,
        associated_limit: middle(1) - (associated_coarse - middle(1)) * fine.cell / (slope.coarse_m - fine.cell),
        cpu_s: clock.elapsed().as_secs_f64(),
        trouble: String::new(),
    };
    line.trouble = trouble(&line);
    let own = folder.join(&slope.name);
    std::fs::create_dir_all(&own).map_err(|e| found(unwritable(&own, e)))?;
    let shown = Shown {
        scene: &fine,
        found: &factors,
        slices: &slices,
        level: &state.level,
        manifest: &Manifest::new(&fine, 1),
    };
    shown.write(&own).map_err(found)?;
    Ok(line)
}

/// What is not as required, in words.
fn trouble(line: &Line) -> String {
    let mut troubles = Vec::new();
    let off = line.associated / line.published - 1.0;
    let inside =
        line.associated >= line.published_low - 0.5 * WITHIN && line.associated <= line.published_high + 0.5 * WITHIN;
    if off.abs() > CLOSE && !inside {
        troubles.push(format!("{:+.1} % from the published factor", 100.0 * off));
    }
    let apart = (line.associated - line.associated_coarse).abs();
    if apart > MESHES {
        troubles.push(format!("meshes {apart:.3} apart"));
    }
    if line.cpu_s > TIME_S {
        troubles.push(format!("{:.0} s", line.cpu_s));
    }
    troubles.join(", ")
}

/// A line in words.
pub fn said(line: &Line) -> String {
    let verdict = if line.trouble.is_empty() { "passed".to_owned() } else { format!("failed: {}", line.trouble) };
    format!(
        "{:<24} Davis {:.3}, associated {:.3} (coarse {:.3}), published {:.3}, {:.0} s  {verdict}",
        line.name, line.davis, line.associated, line.associated_coarse, line.published, line.cpu_s
    )
}

/// Writes table and page of all lines.
///
/// # Errors
/// A file that cannot be written, or a template that does not fit.
pub fn write(slopes: &[&Published], lines: &[Line], folder: &Path) -> Result<(), ReportError> {
    let path = folder.join(NAME);
    let mut writer = csv::Writer::from_path(&path).map_err(|e| unwritable(&path, e))?;
    lines.iter().try_for_each(|line| writer.serialize(line)).map_err(|e| unwritable(&path, e))?;
    writer.flush().map_err(|e| unwritable(&path, e))?;
    let failed = lines.iter().filter(|line| !line.trouble.is_empty()).count();
    let number = |value: f64| Cell::new(format!("{value:.3}"));
    let or_none = |value: Option<f64>| value.map_or_else(|| Cell::new("none"), number);
    let row = |(slope, line): (&&Published, &Line)| {
        let state = Judged::of(line.trouble.is_empty());
        let spread = if line.published_low < line.published_high {
            format!("{} to {}", line.published_low, line.published_high)
        } else {
            String::new()
        };
        vec![
            Cell::new(&slope.title).linked(&format!("{}/index.html", line.name)),
            Cell::badge(state.word(), state.mark()).small(line.trouble.clone()),
            Cell::new(line.published.to_string()).marked(spread, ""),
            number(line.associated).marked(format!("{:+.1} %", 100.0 * (line.associated / line.published - 1.0)), ""),
            number(line.associated_coarse).marked(format!("{} and {} m", line.fine_m, line.coarse_m), ""),
            number(line.associated_limit),
            number(line.davis).marked(format!("coarse {:.3}", line.davis_coarse), ""),
            number(line.as_given),
            or_none(line.spencer),
            or_none(line.any_shape),
            Cell::new(short(line.cpu_s, 2)),
        ]
    };
    let head = [
        "slope",
        "verdict",
        "published",
        "associated",
        "coarser mesh",
        "limit",
        "Davis B",
        "as given",
        "Spencer",
        "any shape",
        "CPU (s)",
    ];
    let rows = slopes.iter().zip(lines).map(row).collect();
    let note = format!(
        "Required: the associated factor within {:.0} % of the published one or inside the spread of published ones; both meshes within \
         {MESHES}; at most {TIME_S:.0} s of CPU time for all of it. Limit: if the error falls with the size of the cells.",
        100.0 * CLOSE
    );
    let image = |(slope, line): (&&Published, &Line)| Image {
        src: format!("{}/plots/mechanism.png", line.name),
        alt: format!("Where the soil of {} shears", slope.title),
        caption: format!("[{}]({}/index.html): {:.2}", slope.title, line.name, line.associated),
        href: format!("{}/index.html", line.name),
    };
    let sources: Vec<String> = slopes.iter().map(|slope| format!("{}: {}", slope.title, slope.source)).collect();
    let sentence = match failed {
        0 => format!("All {} published slopes are met.", lines.len()),
        _ => format!("{failed} of {} published slopes are not met.", lines.len()),
    };
    let counts = Counts::Checks(Checks { passed: lines.len() - failed, failed, ..Checks::default() });
    let report = Report::new(Kind::Slopes).counts([Tally::new("Published slopes", counts)]);
    let report = match lines.first() {
        Some(line) => report.picture(format!("{}/plots/mechanism.png", line.name), "Where the soil of a slope shears"),
        None => report,
    };
    Page::new("Factors of safety of published slopes")
        .verdict(Verdict::new(Judged::of(failed == 0), sentence))
        .section(Section::new("slopes", "Slopes").tables([Table::new("Factors of safety", &head, rows, &note)]))
        .section(
            Section::new("mechanisms", "How they slide")
                .with(Block::Images(slopes.iter().zip(lines).map(image).collect())),
        )
        .section(Section::new("sources", "Published factors").folded().list(sources))
        .section(
            Section::new("again", "Run it again").with(Block::Command("mpm-verify slope".to_owned())).files([NAME]),
        )
        .report(report)
        .write(&folder.join("index.html"))
}

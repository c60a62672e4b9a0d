//! What a night leaves: `summary.json`, `summary.md` and `index.html` on one page, `values.csv`, `moved.csv`.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::moved::Moved;
use super::tables;
use crate::error::Error;
use crate::experiment::number::{Label, Number};
use crate::manifest::Manifest;
use crate::page::verdict::{State, Verdict};
use crate::page::{Link, Page, Section};
use crate::report::{ReportError, save, unwritable};

/// Moved numbers that a page for reading lists; `moved.csv` has all.
pub const LISTED: usize = 60;

/// A part of the night.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// What came out, in a line.
    pub line: String,
    /// CPU time, s.
    pub cpu_s: f64,
    /// Time on the clock, s.
    pub wall_s: f64,
}

/// `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Night {
    /// `passed`: all checks passed and no number moved. `failed`: a check failed or a number moved.
    pub verdict: String,
    /// Numbers that have moved.
    pub moved: Vec<Moved>,
    /// Failed checks, in words.
    pub fell: Vec<String>,
    /// CPU time, s.
    pub cpu_s: f64,
    /// Time on the clock, s.
    pub wall_s: f64,
    /// Numbers that were compared.
    pub compared: usize,
    /// Of them counts of work.
    pub counts: usize,
    /// When, UTC.
    pub date: String,
    /// Commit.
    pub commit: String,
    /// Where the accepted numbers came from.
    pub baselines: String,
    /// The parts.
    pub parts: Vec<Part>,
    /// What else a reader should know.
    pub notes: Vec<String>,
    /// Under which conditions.
    pub manifest: Manifest,
}

impl Night {
    /// Whether nothing fell and nothing moved.
    pub fn is_green(&self) -> bool {
        self.moved.is_empty() && self.fell.is_empty()
    }

    /// The state of the night.
    pub fn state(&self) -> State {
        if self.is_green() { State::Unchanged } else { State::Moved }
    }

    /// What was found, in a line.
    pub fn found(&self) -> String {
        let checks = if self.fell.len() == 1 { "1 check".to_owned() } else { format!("{} checks", self.fell.len()) };
        format!("{} of {} numbers moved, {checks} failed", self.moved.len(), self.compared)
    }

    /// The night in one line.
    pub fn headline(&self) -> String {
        let Self { verdict, compared, moved, fell, date, commit, .. } = self;
        format!(
            "{}: {} of {compared} numbers moved, {} {} failed ({date}, {commit})",
            verdict.to_uppercase(),
            moved.len(),
            fell.len(),
            if fell.len() == 1 { "check" } else { "checks" }
        )
    }

    /// One page in Markdown, for a job summary or a mail.
    pub fn markdown(&self) -> String {
        let mut lines = vec![format!("# Nightly: {}", self.headline()), String::new()];
        for what in &self.fell {
            lines.push(format!("- failed: {what}"));
        }
        if !self.moved.is_empty() {
            lines.push(String::new());
            lines.push("| case | quantity | | was | is | may move by | since |".to_owned());
            lines.push("|---|---|---|---|---|---|---|".to_owned());
            for m in self.moved.iter().take(LISTED) {
                let number = |value: Option<f64>| value.map_or_else(|| "nothing".to_owned(), |v| format!("{v:.6e}"));
                let [was, is] = [m.was, m.is].map(number);
                let Moved { case, quantity, direction, tolerance, since, .. } = m;
                lines.push(format!(
                    "| `{case}` | {quantity} | {direction} | {was} | {is} | {tolerance:.1e} | {since} |"
                ));
            }
            if self.moved.len() > LISTED {
                lines.push(format!("\nand {} more in `moved.csv`", self.moved.len() - LISTED));
            }
            lines.push(String::new());
            lines.push(
                "If this is as it should be: `cargo run --release -- nightly --accept \"why\" --from` this night's folder."
                    .to_owned(),
            );
        }
        lines.push(String::new());
        lines.push("| part | | CPU (s) | clock (s) |".to_owned());
        lines.push("|---|---|---|---|".to_owned());
        for part in &self.parts {
            lines.push(format!("| {} | {} | {:.0} | {:.0} |", part.name, part.line, part.cpu_s, part.wall_s));
        }
        lines.push(String::new());
        lines.push(format!(
            "{} numbers compared, {} of them counts of work; accepted numbers: {}.",
            self.compared, self.counts, self.baselines
        ));
        lines.extend(self.notes.iter().map(|note| format!("\n{note}")));
        lines.join("\n") + "\n"
    }
}

/// Pages of the parts in the folder of a night.
const PAGES: [(&str, &str); 4] = [
    ("accuracy/index.html", "Accuracy study"),
    ("suite/index.html", "Verification suite"),
    ("stability/index.html", "Stress tests"),
    ("levee/index.html", "Levee"),
];

/// Writes everything into the folder of the night, where the pages of its parts are; a `whole` night is part of a trend.
///
/// # Errors
/// A file that cannot be written.
pub fn write(night: &Night, measures: &[Number], whole: bool, folder: &Path) -> Result<(), ReportError> {
    let path = folder.join("summary.json");
    let text = serde_json::to_string_pretty(night).map_err(|e| unwritable(&path, e))?;
    save(&path, text + "\n")?;
    save(&folder.join("summary.md"), night.markdown())?;
    rows(measures, &folder.join(VALUES))?;
    rows(&night.moved, &folder.join("moved.csv"))?;
    let found = PAGES.into_iter().filter(|(page, _)| folder.join(page).exists());
    let trends = whole.then_some(("../trends/errors.html", "Trends"));
    let links = found.chain(trends).map(|(page, text)| Link::new(text, page)).collect();
    let moved = (!night.moved.is_empty()).then(|| tables::moved(night));
    let accept = "If the new numbers are correct, `cargo run --release -- nightly --accept \"why\" --from` this folder \
                  makes them the baseline. All of them: [moved.csv](moved.csv).";
    let (compared, counts, baselines) = (night.compared, night.counts, &night.baselines);
    let about = format!(
        "{compared} numbers were compared, {counts} of them counts of work: [values.csv](values.csv). Accepted numbers: {baselines}."
    );
    let mut parts = Section::new("parts", "Parts").tables([tables::parts(night)]).note(about);
    for note in &night.notes {
        parts = parts.note(note.clone());
    }
    let mut changes = Section::new("moved", "Moved numbers").tables(moved);
    if !changes.blocks.is_empty() {
        changes = changes.note(accept);
    }
    let mut speed = Section::new("speed", "Speed against error").tables(tables::speed(measures));
    if !speed.blocks.is_empty() {
        speed = speed.note(
            "The least work among the cases whose largest error of U, relative to the exact solution with finite bulk modulus of \
             the pore water, is that small: particles times steps, or times solves without inertia. A dash: no case. \
             Counts are compared within 2 %.",
        );
    }
    let mut work = Section::new("work", "Work in counts").tables(tables::work(measures));
    if !work.blocks.is_empty() {
        work = work.note("Counts are compared. Times, divided by that of a fixed kernel timed beside them, are not.");
    }
    let mut page = Page::new(format!("Nightly run of {}", night.date))
        .verdict(Verdict::new(night.state(), format!("{}.", night.found())))
        .warnings(night.fell.iter().cloned())
        .section(changes)
        .section(parts)
        .section(speed)
        .section(work)
        .conditions(&night.manifest)
        .beside(links);
    page.conditions.retain(|(name, _)| name != "scene hash");
    if whole {
        page = page.below("Nightly runs", "../index.html");
    }
    page.write(&folder.join("index.html"))
}

/// Name of the table of all numbers.
pub const VALUES: &str = "values.csv";

/// A row of `values.csv`.
#[derive(Debug, Serialize, Deserialize)]
struct Value {
    case: String,
    quantity: String,
    label: Label,
    value: Option<f64>,
    relative: f64,
    absolute: f64,
}

fn rows<T: Row>(rows: &[T], path: &Path) -> Result<(), ReportError> {
    let mut writer = csv::Writer::from_path(path).map_err(|e| unwritable(path, e))?;
    if rows.is_empty() {
        writer.write_record(T::HEADER.split(',')).map_err(|e| unwritable(path, e))?;
    }
    for row in rows {
        writer.serialize(row.flat()).map_err(|e| unwritable(path, e))?;
    }
    writer.flush().map_err(|e| unwritable(path, e))
}

/// What is a row of a table without nesting.
trait Row {
    const HEADER: &str;
    fn flat(&self) -> impl Serialize;
}

impl Row for Number {
    const HEADER: &str = "case,quantity,label,value,relative,absolute";
    fn flat(&self) -> impl Serialize {
        Value {
            case: self.case.clone(),
            quantity: self.quantity.clone(),
            label: self.label,
            value: Some(self.value).filter(|v| !v.is_nan()),
            relative: self.tolerance.relative,
            absolute: self.tolerance.absolute,
        }
    }
}

impl Row for Moved {
    const HEADER: &str = "case,quantity,was,is,tolerance,since,label,direction";
    fn flat(&self) -> impl Serialize {
        self
    }
}

/// Reads `values.csv` of a night.
///
/// # Errors
/// A file that is not such a table: file, line, expected and found.
pub fn stored(path: &Path) -> Result<Vec<Number>, Error> {
    let mut reader = csv::Reader::from_path(path).map_err(Error::at(path))?;
    reader
        .deserialize()
        .map(|row: Result<Value, csv::Error>| {
            let file = || path.display().to_string();
            let row = row.map_err(|source| Error::Row { file: file(), columns: Number::HEADER, source })?;
            let tolerance = crate::experiment::number::Tolerance { relative: row.relative, absolute: row.absolute };
            Ok(Number::new(&row.case, &row.quantity, row.label, row.value.unwrap_or(f64::NAN), tolerance))
        })
        .collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::experiment::number::Tolerance;

    fn night(moved: Vec<Moved>) -> Night {
        Night {
            verdict: if moved.is_empty() { "passed" } else { "failed" }.to_owned(),
            moved,
            fell: Vec::new(),
            cpu_s: 1.5,
            wall_s: 1.0,
            compared: 3,
            counts: 1,
            date: "2026-01-01".to_owned(),
            commit: "abc".to_owned(),
            baselines: "built in".to_owned(),
            parts: vec![Part { name: "study".to_owned(), line: "all held".to_owned(), cpu_s: 1.0, wall_s: 0.5 }],
            notes: Vec::new(),
            manifest: Manifest::new(&crate::scenes::terzaghi(), 1),
        }
    }

    fn one_moved() -> Moved {
        Moved {
            case: "terzaghi".to_owned(),
            quantity: "error".to_owned(),
            was: Some(1e-3),
            is: Some(2e-3),
            tolerance: 1e-9,
            since: "2026-01-01 abc".to_owned(),
            label: Label::Verified,
            direction: "worse".to_owned(),
        }
    }

    /// Writes a nightly run with the pages above it into a folder.
    pub fn write_small(folder: &Path) {
        let (night, own, trends) = (night(vec![one_moved()]), folder.join("2026-01-01"), folder.join("trends"));
        [&own, &trends].into_iter().for_each(|path| std::fs::create_dir_all(path).expect("a folder"));
        let measure = Number::new("terzaghi", "error", Label::Verified, 2e-3, Tolerance::relative(1e-6));
        write(&night, std::slice::from_ref(&measure), true, &own).expect("written");
        let mut history = crate::nightly::history::History::default();
        history.note("2026-01-01 abc", &[measure]);
        crate::nightly::trends::write(&history, &trends).expect("written");
        std::fs::write(folder.join("history.csv"), "").expect("written");
        crate::nightly::nights::write(folder, ("2026-01-01", &night), folder).expect("written");
    }

    #[test]
    fn a_red_night_names_the_case_everywhere_and_links_what_there_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let measures = [
            Number::new("terzaghi", "error", Label::Verified, 2e-3, Tolerance::relative(1e-6)),
            Number::new("gone", "error", Label::Verified, f64::NAN, Tolerance::relative(1e-6)),
        ];
        write(&night(vec![one_moved()]), &measures, false, folder.path()).expect("written");
        for name in ["summary.json", "summary.md", "index.html", "moved.csv", VALUES] {
            let text = std::fs::read_to_string(folder.path().join(name)).expect("a file");
            assert!(text.contains("terzaghi"), "{name}");
        }
        let back = stored(&folder.path().join(VALUES)).expect("values");
        assert_eq!(format!("{back:?}"), format!("{measures:?}"));
        let json: serde_json::Value =
            serde_json::from_slice(&std::fs::read(folder.path().join("summary.json")).expect("a file")).expect("JSON");
        assert_eq!(json["verdict"], "failed");
        for key in ["case", "quantity", "was", "is", "tolerance", "since"] {
            assert!(!json["moved"][0][key].is_null(), "{key}");
        }
        assert_eq!(json["cpu_s"], 1.5);
        let links = |whole| {
            write(&night(Vec::new()), &measures, whole, folder.path()).expect("written");
            let page = std::fs::read_to_string(folder.path().join("index.html")).expect("a page");
            ["Accuracy study</a>", "Verification suite</a>", "Trends</a>"].map(|link| page.contains(link))
        };
        assert_eq!(links(false), [false; 3], "no link to a part that was not run");
        std::fs::create_dir(folder.path().join("suite")).expect("a folder");
        std::fs::write(folder.path().join("suite/index.html"), "").expect("a page");
        assert_eq!(links(true), [false, true, true]);
        let page = night(vec![one_moved(); 100]).markdown();
        assert!(page.contains("and 40 more in `moved.csv`") && page.lines().count() < 90, "one page");
    }

    #[test]
    fn a_run_that_passed_says_so() {
        let night = night(Vec::new());
        assert!(night.is_green() && night.headline().starts_with("PASSED: 0 of 3 numbers moved"));
        assert!(!night.markdown().contains("--accept"));
    }
}

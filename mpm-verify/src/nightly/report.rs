//! What a night leaves: `summary.json`, `summary.md` and `index.html` on one page, `values.csv`, `moved.csv`.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::history::History;
use super::moved::Moved;
use super::part::{Finish, Part};
use super::{tables, trends};
use crate::error::Error;
use crate::experiment::accepted::Accepted;
use crate::experiment::number::{Direction, Label, Number};
use crate::manifest::Manifest;
use crate::page::verdict::{State, Verdict};
use crate::page::{Link, Page, Section};
use crate::report::plots::{self, figure::Figure};
use crate::report::{ReportError, save, unwritable};

/// Moved numbers of a kind that a page for reading lists; `moved.csv` has all.
pub const LISTED: usize = 60;

/// A part of the night.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartRow {
    /// The part.
    pub name: Part,
    /// End of the part.
    #[serde(default)]
    pub finish: Finish,
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
    /// `unchanged`: no number moved and no check failed. `moved`: a number did. `failed`: a check or a part failed.
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
    pub parts: Vec<PartRow>,
    /// What else a reader should know.
    pub notes: Vec<String>,
    /// Under which conditions.
    pub manifest: Manifest,
}

impl Night {
    /// Whether no number moved and no check failed.
    pub fn is_unchanged(&self) -> bool {
        self.moved.is_empty() && self.fell.is_empty()
    }

    /// The state of the night.
    pub fn state(&self) -> State {
        let is_worse = self.moved.iter().any(|moved| moved.direction.mark() == "bad");
        let all_ran = self.parts.iter().all(|part| part.finish == Finish::Ran);
        match (self.fell.is_empty(), self.moved.is_empty()) {
            (false, _) => State::Failed,
            (true, false) => {
                if is_worse {
                    State::Worse
                } else {
                    State::Moved
                }
            }
            (true, true) => {
                if all_ran {
                    State::Unchanged
                } else {
                    State::NotEstablished
                }
            }
        }
    }

    fn verdict(&self) -> Verdict {
        Verdict::new(self.state(), format!("{}.", self.found()))
    }

    /// What was found, in a line.
    pub fn found(&self) -> String {
        let Self { moved, compared, parts, fell, .. } = self;
        let ran = parts.iter().filter(|part| part.finish == Finish::Ran).count();
        let checks = match fell.len() {
            0 => "no check failed".to_owned(),
            1 => "1 check failed".to_owned(),
            count => format!("{count} checks failed"),
        };
        format!("{} of {compared} numbers moved, {ran} of {} parts ran, {checks}", moved.len(), Part::ALL.len())
    }

    /// The night in one line.
    pub fn headline(&self) -> String {
        format!("{}: {} ({}, {})", self.verdict.to_uppercase(), self.found(), self.date, self.commit)
    }

    /// One page in Markdown, for a job summary or a mail.
    pub fn markdown(&self) -> String {
        let mut lines = vec![format!("# Nightly: {}", self.headline()), String::new()];
        for what in &self.fell {
            lines.push(format!("- failed: {what}"));
        }
        if !self.moved.is_empty() {
            lines.push(String::new());
            lines.push("| case | quantity | | change | accepted | tonight | may move by | since |".to_owned());
            lines.push("|---|---|---|---|---|---|---|---|".to_owned());
            for m in self.moved.iter().take(LISTED) {
                let number = |value: Option<f64>| value.map_or_else(|| "nothing".to_owned(), |v| format!("{v:.6e}"));
                let [was, is] = [m.was, m.is].map(number);
                let Moved { case, quantity, tolerance, since, .. } = m;
                let (word, change) = (m.direction.word(), tables::percent(m.share()));
                lines.push(format!(
                    "| `{case}` | {quantity} | {word} | {change} | {was} | {is} | {tolerance:.1e} | {since} |"
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
        lines.push("| part | | what came out | CPU (s) | clock (s) |".to_owned());
        lines.push("|---|---|---|---|---|".to_owned());
        for PartRow { name, finish, line, cpu_s, wall_s } in &self.parts {
            lines.push(format!("| {} | {} | {line} | {cpu_s:.0} | {wall_s:.0} |", name.name(), finish.word()));
        }
        lines.push(String::new());
        lines.push(self.about());
        lines.extend(self.notes.iter().map(|note| format!("\n{note}")));
        lines.join("\n") + "\n"
    }

    /// Counts of the comparison.
    fn about(&self) -> String {
        let Self { compared, counts, baselines, .. } = self;
        format!("{compared} numbers compared, {counts} of them counts of work; accepted numbers: {baselines}.")
    }
}

/// Content of the page of a night beside the night itself.
#[derive(Debug)]
pub struct Shown<'a> {
    /// Numbers of the night.
    pub measures: &'a [Number],
    /// Numbers that they are compared with.
    pub known: &'a [Accepted],
    /// The nights so far, with this one if it is recorded.
    pub history: &'a History,
    /// Errors over the mesh, if the study was run.
    pub convergence: Option<&'a Figure>,
    /// Whether the night is recorded.
    pub recorded: bool,
}

/// Pages of the parts in the folder of a night.
const PAGES: [(&str, &str); 4] = [
    ("accuracy/index.html", "Accuracy study"),
    ("suite/index.html", "Verification suite"),
    ("stability/index.html", "Stress tests"),
    ("levee/index.html", "Levee"),
];

/// Writes everything into the folder of the night, where the pages of its parts are.
///
/// # Errors
/// A file that cannot be written.
pub fn write(night: &Night, shown: &Shown, folder: &Path) -> Result<(), ReportError> {
    let path = folder.join("summary.json");
    let text = serde_json::to_string_pretty(night).map_err(|e| unwritable(&path, e))?;
    save(&path, text + "\n")?;
    save(&folder.join("summary.md"), night.markdown())?;
    rows(shown.measures, &folder.join(VALUES))?;
    rows(&night.moved, &folder.join("moved.csv"))?;
    let over_nights = trends::figure(shown.history);
    for figure in shown.convergence.into_iter().chain(&over_nights) {
        plots::write_svg_and_numbers(figure, folder)?;
    }
    let figures = |section: Section, figure: Option<&Figure>| {
        figure.into_iter().fold(section, |section, figure| section.figure_in(figure, ".", &["csv", "svg"]))
    };
    let mut sections = vec![figures(Section::new("convergence", "Convergence tonight"), shown.convergence)];
    let kind = |id: &str, title: &str, of: &[Direction]| {
        let moved: Vec<&Moved> = night.moved.iter().filter(|m| of.contains(&m.direction)).collect();
        let section = Section::new(id, title);
        if moved.is_empty() { section.text("Nothing.") } else { section.tables([tables::moved(&moved, folder)]) }
    };
    sections.push(kind("worse", "What got worse", &[Direction::Worse, Direction::Gone]));
    sections.push(kind("better", "What got better", &[Direction::Better]));
    let neither = [Direction::Up, Direction::Down, Direction::New];
    if night.moved.iter().any(|m| neither.contains(&m.direction)) {
        sections.push(kind("moved", "What moved otherwise", &neither));
    }
    if let Some(last) = sections.last_mut().filter(|_| !night.moved.is_empty()) {
        *last = last.clone().note(
            "If the new numbers are correct, `cargo run --release -- nightly --accept \"why\" --from` this folder makes them the \
             baseline. All of them: [moved.csv](moved.csv).",
        );
    }
    if let Some(table) = tables::cost(night, shown) {
        sections.push(Section::new("cost", "Cost of single runs").tables([table]).note(tables::about_cost(shown)));
    }
    if let Some(table) = tables::speed(shown.measures) {
        sections.push(Section::new("speed", "Least work for an error").tables([table]).note(
            "The least work among the cases whose largest error of U, relative to the exact solution with finite bulk modulus of \
             the pore water, is that small: particles times steps, or times solves without inertia. A dash: no case. \
             Counts are compared within 2 %.",
        ));
    }
    let trends = Section::new("trends", "Trends over the nights");
    sections.push(match shown.history.entries.len() {
        0 | 1 => trends.text("They begin with the second night."),
        _ => figures(trends, over_nights.as_ref()),
    });
    let mut parts = Section::new("parts", "Parts").tables([tables::parts(night)]).note(night.about());
    parts = night.notes.iter().fold(parts.files([VALUES, "moved.csv"]), |parts, note| parts.note(note.clone()));
    sections.push(parts);
    let found = PAGES.into_iter().filter(|(page, _)| folder.join(page).exists());
    let all_trends = shown.recorded.then(trends::links).into_iter().flatten();
    let links = found.map(|(page, text)| Link::new(text, page)).chain(all_trends).collect();
    let page = Page::new(format!("Nightly run of {} UTC", tables::date(&night.date)))
        .verdict(night.verdict())
        .warnings(night.fell.iter().cloned());
    let mut page = sections.into_iter().fold(page, Page::section).conditions(&night.manifest).beside(links);
    page.conditions.retain(|(name, _)| name != "scene hash");
    if shown.recorded {
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
        let parts = Part::ALL.map(|name| PartRow {
            name,
            finish: Finish::Ran,
            line: "3 cases".to_owned(),
            cpu_s: 1.0,
            wall_s: 0.5,
        });
        Night {
            verdict: if moved.is_empty() { "unchanged" } else { "moved" }.to_owned(),
            moved,
            fell: Vec::new(),
            cpu_s: 1.5,
            wall_s: 1.0,
            compared: 3,
            counts: 1,
            date: "2026-01-01".to_owned(),
            commit: "abc".to_owned(),
            baselines: "built in".to_owned(),
            parts: parts.to_vec(),
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
            direction: Direction::Worse,
            page: "suite/terzaghi/index.html".to_owned(),
        }
    }

    /// Writes a night whose numbers are compared with nothing.
    fn write_alone(night: &Night, measures: &[Number], recorded: bool, folder: &Path) {
        let history = History::default();
        let shown = Shown { measures, known: &[], history: &history, convergence: None, recorded };
        write(night, &shown, folder).expect("written");
    }

    /// Writes a nightly run with the pages above it into a folder.
    pub fn write_small(folder: &Path) {
        let (night, own, trends) = (night(vec![one_moved()]), folder.join("2026-01-01"), folder.join("trends"));
        [&own, &trends].into_iter().for_each(|path| std::fs::create_dir_all(path).expect("a folder"));
        let measure = Number::new("terzaghi", "error", Label::Verified, 2e-3, Tolerance::relative(1e-6));
        write_alone(&night, std::slice::from_ref(&measure), true, &own);
        let mut history = History::default();
        history.note("2026-01-01 abc", &[measure]);
        trends::write(&history, &trends).expect("written");
        std::fs::write(folder.join("history.csv"), "").expect("written");
        std::fs::write(own.join("error-against-mesh.svg"), "").expect("written");
        crate::nightly::nights::write(folder, ("2026-01-01", &night), folder).expect("written");
    }

    #[test]
    fn a_red_night_names_the_case_everywhere_and_links_what_there_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let measures = [
            Number::new("terzaghi", "error", Label::Verified, 2e-3, Tolerance::relative(1e-6)),
            Number::new("gone", "error", Label::Verified, f64::NAN, Tolerance::relative(1e-6)),
        ];
        write_alone(&night(vec![one_moved()]), &measures, false, folder.path());
        for name in ["summary.json", "summary.md", "index.html", "moved.csv", VALUES] {
            let text = std::fs::read_to_string(folder.path().join(name)).expect("a file");
            assert!(text.contains("terzaghi"), "{name}");
        }
        let back = stored(&folder.path().join(VALUES)).expect("values");
        assert_eq!(format!("{back:?}"), format!("{measures:?}"));
        let json: serde_json::Value =
            serde_json::from_slice(&std::fs::read(folder.path().join("summary.json")).expect("a file")).expect("JSON");
        assert_eq!(json["verdict"], "moved");
        for key in ["case", "quantity", "was", "is", "tolerance", "since"] {
            assert!(!json["moved"][0][key].is_null(), "{key}");
        }
        assert_eq!(json["cpu_s"], 1.5);
        let links = |whole| {
            write_alone(&night(Vec::new()), &measures, whole, folder.path());
            let page = std::fs::read_to_string(folder.path().join("index.html")).expect("a page");
            ["Accuracy study</a>", "Verification suite</a>", "Errors over the nights</a>"]
                .map(|link| page.contains(link))
        };
        assert_eq!(links(false), [false; 3], "no link to a part that was not run");
        std::fs::create_dir(folder.path().join("suite")).expect("a folder");
        std::fs::write(folder.path().join("suite/index.html"), "").expect("a page");
        assert_eq!(links(true), [false, true, true]);
        let page = night(vec![one_moved(); 100]).markdown();
        assert!(page.contains("and 40 more in `moved.csv`") && page.lines().count() < 90, "one page");
    }

    #[test]
    fn the_verdict_says_what_moved_and_whether_all_ran() {
        let unchanged = night(Vec::new());
        let headline = "UNCHANGED: 0 of 3 numbers moved, 7 of 7 parts ran, no check failed";
        assert!(unchanged.is_unchanged() && unchanged.headline().starts_with(headline), "{}", unchanged.headline());
        assert!(!unchanged.markdown().contains("--accept"));
        let of = |directions: &[Direction], fell: &[&str], finish: Finish| {
            let moved = directions.iter().map(|direction| Moved { direction: *direction, ..one_moved() }).collect();
            let mut night = night(moved);
            night.fell = fell.iter().map(|what| (*what).to_owned()).collect();
            night.parts[6].finish = finish;
            (night.state().word().into_owned(), night.state().mark())
        };
        let is = |word: &str, mark: &'static str| (word.to_owned(), mark);
        assert_eq!(of(&[], &[], Finish::Ran), is("unchanged", "good"));
        assert_eq!(of(&[], &[], Finish::NotRun), is("not established", "warn"));
        assert_eq!(of(&[Direction::Better, Direction::New], &[], Finish::Ran), is("moved", "warn"));
        assert_eq!(of(&[Direction::Better, Direction::Worse], &[], Finish::Ran), is("moved", "bad"));
        assert_eq!(of(&[Direction::Gone], &[], Finish::Ran), is("moved", "bad"));
        assert_eq!(of(&[Direction::Better], &["a check"], Finish::Ran), is("failed", "bad"));
    }

    #[test]
    fn the_page_begins_with_convergence_and_links_the_cases_that_there_are() {
        use crate::report::plots::error_against_mesh::over_accepted;
        use crate::report::select::Cases;
        let mut results = Vec::new();
        for (mesh, error) in [(0.1, 4e-2), (0.05, 1e-2), (0.02, 2e-3)] {
            for ppc in [1, 4, 9] {
                let mut r = crate::study::tests::result(mesh, ppc, "surface");
                r.max_error_compressible = error / ppc as f64;
                results.push(r);
            }
        }
        let figure = over_accepted(&Cases::of(&results), |r| Some(0.5 * r.max_error_compressible));
        let labels: Vec<&str> =
            figure.panels[1].series.iter().filter(|s| s.is_data).map(|s| s.label.as_str()).collect();
        let points = ["1 particle per cell", "4 particles per cell", "9 particles per cell"];
        assert_eq!(labels, [&["accepted"; 3][..], &points].concat());
        let accepted: Vec<f64> = figure.panels[1].series[2].points.iter().map(|p| p.y).collect();
        assert_eq!(accepted, [2.0, 0.5, 0.1], "one particle per cell, half of tonight's error in per cent");
        let folder = tempfile::tempdir().expect("a folder");
        let [suite, accuracy] = ["suite/terzaghi", "accuracy"].map(|name| folder.path().join(name));
        [&suite, &accuracy].into_iter().for_each(|path| std::fs::create_dir_all(path).expect("a folder"));
        std::fs::write(suite.join("index.html"), "").expect("a page");
        std::fs::write(accuracy.join("cases.html"), "<th id=\"one\">").expect("a page");
        let better = |case: &str, page: &str| Moved {
            case: case.to_owned(),
            page: page.to_owned(),
            is: Some(5e-4),
            direction: Direction::Better,
            ..one_moved()
        };
        let moved = vec![
            one_moved(),
            better("one", "accuracy/cases.html#one"),
            better("other", "accuracy/cases.html#other"),
            better("none", "stability/index.html#steps"),
        ];
        let mut history = History::default();
        for (day, error) in [1e-3, 2e-3].into_iter().enumerate() {
            let number =
                Number::new("a", crate::nightly::collect::ERROR, Label::Verified, error, Tolerance::relative(0.0));
            history.note(&format!("2026-01-0{day} c"), &[number]);
        }
        let shown = Shown { measures: &[], known: &[], history: &history, convergence: Some(&figure), recorded: false };
        write(&night(moved), &shown, folder.path()).expect("written");
        let page = std::fs::read_to_string(folder.path().join("index.html")).expect("a page");
        let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
        let order =
            ["convergence", "worse", "better", "trends", "parts"].map(|id| place(&format!("<section id=\"{id}\"")));
        assert!(order.is_sorted(), "{order:?}");
        for link in ["suite/terzaghi/index.html\">terzaghi", "cases.html#one\">one", "cases.html\">other"] {
            assert!(place(&format!("{link}</a>")) > 0);
        }
        assert!(!page.contains("stability/index.html"), "no link to a page that was not written");
        assert!(page.contains("+100 %<small>worse") && page.contains("-50.00 %<small>better"), "{page}");
        for file in ["error-against-mesh.svg", "error-against-mesh.csv", "over-nights.svg", "over-nights.csv"] {
            assert!(folder.path().join(file).is_file() && page.contains(file), "{file}");
        }
    }
}

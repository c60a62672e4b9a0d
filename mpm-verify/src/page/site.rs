//! The site that the reports form: every report leaves a `report.json` beside its first page, and the home page lists them all.
//!
//! Home is `index.html` in the folder named `reports` above a report, or in the folder above the report where there is none of that name.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::table::{Cell, Table};
use super::verdict::{Counts, State, Tally, Verdict};
use super::{Block, Image, Page, Section, escaped};
use crate::files::STAGE;
use crate::provenance::Made;
use crate::report::{ReportError, save, unwritable};

/// Name of the file beside the first page of a report.
pub const RECORD: &str = "report.json";
/// Name of the folder of all reports.
const ROOT: &str = "reports";
/// Folders between home and a report at most.
const DEPTH: usize = 3;
/// In the head of the home page alone.
const HOME: &str = "<meta name=\"mpm-verify-page\" content=\"home\">";
/// In the head of every page of this program that is not the home page.
const OTHER: &str = "<meta name=\"mpm-verify-page\" content=\"report\">";
/// In the head of every page of this program.
const MADE_BY: &str = "<meta name=\"generator\" content=\"mpm-verify\">";
/// The same of versions before that.
const MADE_BY_EARLIER: &str = ":root { color-scheme: light dark; --text: #1b1f24;";

/// What a report is about; the order is that of the home page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The levee.
    Levee,
    /// The accuracy study.
    Study,
    /// The verification suite.
    Suite,
    /// Stress tests and time-step limits.
    StressTests,
    /// Nightly runs.
    Nightly,
    /// Speed against error.
    Speed,
    /// Factors of safety of published slopes.
    Slopes,
    /// Scores of several codes.
    Leaderboard,
    /// Scores of one code.
    Score,
    /// The gallery.
    Gallery,
    /// One scene.
    Scene,
    /// Guides.
    Guide,
}

/// What the home page says about a report: `report.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// What it is about.
    pub kind: Kind,
    /// Its title.
    #[serde(default)]
    pub title: String,
    /// Its verdict; none where nothing is judged.
    #[serde(default)]
    pub verdict: Option<Verdict>,
    /// When it was made, UTC.
    #[serde(default)]
    pub date: String,
    /// Program that made it.
    #[serde(flatten)]
    pub made: Made,
    /// Verdicts, counted.
    #[serde(default)]
    pub counts: Vec<Tally>,
    /// File of its main picture, relative to its folder; empty for none.
    #[serde(default)]
    pub picture: String,
    /// What is seen in the picture.
    #[serde(default)]
    pub alt: String,
    /// Further pages: text and target, relative to its folder.
    #[serde(default)]
    pub links: Vec<(String, String)>,
}

impl Report {
    /// A report of a kind; title, verdict, date, commit and links are those of its page.
    pub fn new(kind: Kind) -> Self {
        Self {
            kind,
            title: String::new(),
            verdict: None,
            date: String::new(),
            made: Made::default(),
            counts: Vec::new(),
            picture: String::new(),
            alt: String::new(),
            links: Vec::new(),
        }
    }

    /// With counted verdicts.
    pub fn counts(self, counts: impl IntoIterator<Item = Tally>) -> Self {
        Self { counts: counts.into_iter().collect(), ..self }
    }

    /// With its main picture and what is seen in it.
    pub fn picture(self, file: impl Into<String>, alt: impl Into<String>) -> Self {
        Self { picture: file.into(), alt: alt.into(), ..self }
    }

    /// Writes `report.json` with what the page says.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write(&self, page: &Page, folder: &Path) -> Result<(), ReportError> {
        let known = |name: &str| page.conditions.iter().find(|(n, _)| n == name).map(|(_, value)| value.clone());
        let or = |own: &String, name: &str| if own.is_empty() { known(name).unwrap_or_default() } else { own.clone() };
        let conditions = || {
            let of = |name| known(name).unwrap_or_default();
            Some(Made { commit: known("commit")?, sources: of("sources"), profile: of("profile") })
        };
        let own = Some(self.made.clone()).filter(|made| *made != Made::default());
        let made = own.or_else(conditions).unwrap_or_else(Made::here);
        let report = Self {
            title: if self.title.is_empty() { page.title.clone() } else { self.title.clone() },
            verdict: self.verdict.clone().or_else(|| page.verdict.clone()),
            date: or(&self.date, "date"),
            made,
            links: page.beside.iter().map(|link| (link.text.clone(), link.href.clone())).collect(),
            ..self.clone()
        };
        let path = folder.join(RECORD);
        let text = serde_json::to_string_pretty(&report).map_err(|e| unwritable(&path, e))?;
        save(&path, text + "\n")
    }
}

/// The folder of the home page for something that stands, or will stand, in a folder.
pub fn home(report: &Path) -> PathBuf {
    let report = std::path::absolute(report).unwrap_or_else(|_| report.to_owned());
    // What is written to a stage will stand in the folder of the stage.
    let staged = report.ancestors().find(|above| above.file_name().is_some_and(|name| name == STAGE));
    let own = staged.and_then(Path::parent).unwrap_or(&report);
    let root = own.ancestors().skip(1).find(|above| above.file_name().is_some_and(|name| name == ROOT));
    root.or_else(|| own.parent()).unwrap_or(own).to_owned()
}

/// Link from a page to the home page, by the place where the page will be published.
pub(super) fn home_link(page: &Path) -> String {
    let page = std::path::absolute(page).unwrap_or_else(|_| page.to_owned());
    let folder = page.parent().unwrap_or(&page);
    let root = home(folder);
    let below = folder.strip_prefix(&root).unwrap_or(Path::new(""));
    let deep = below.components().filter(|part| *part != Component::Normal(STAGE.as_ref())).count();
    "../".repeat(deep) + "index.html"
}

/// Whether the home page of a folder may be written: there is none, or one of this program.
///
/// # Errors
/// A page of someone else stands there.
pub fn is_free(root: &Path) -> Result<(), ReportError> {
    let path = root.join("index.html");
    let free = match fs::symlink_metadata(&path) {
        Err(e) => e.kind() == io::ErrorKind::NotFound,
        Ok(there) => {
            let own =
                |text: String| (text.contains(MADE_BY) || text.contains(MADE_BY_EARLIER)) && !text.contains(OTHER);
            there.is_file() && fs::read_to_string(&path).is_ok_and(own)
        }
    };
    let cause = "expected none, or a page of this program, found another, which was left as it is";
    if free { Ok(()) } else { Err(unwritable(&path, io::Error::other(cause))) }
}

/// A report with its folder, relative to home.
#[derive(Debug, Clone)]
struct Known {
    folder: String,
    report: Report,
}

/// Reports below a folder, in the order of the home page.
fn reports(root: &Path) -> Vec<Known> {
    let mut known = Vec::new();
    find(root, "", DEPTH, &mut known);
    known.sort_by(|a, b| (a.report.kind, &a.folder).cmp(&(b.report.kind, &b.folder)));
    known
}

fn find(root: &Path, below: &str, depth: usize, known: &mut Vec<Known>) {
    for entry in fs::read_dir(root.join(below)).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with('.') || !entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            continue;
        }
        let folder = if below.is_empty() { name } else { format!("{below}/{name}") };
        let text = fs::read_to_string(root.join(&folder).join(RECORD)).ok();
        // One that was published has no page.
        let has_page = root.join(&folder).join("index.html").is_file();
        match text.and_then(|text| serde_json::from_str(&text).ok()).filter(|_| has_page) {
            // What stands below a report is reached from there.
            Some(report) => known.push(Known { folder, report }),
            None if depth > 1 => find(root, &folder, depth - 1, known),
            None => {}
        }
    }
}

/// Rebuilds the home page from every `report.json` below a folder. Returns its path.
///
/// # Errors
/// A page of someone else stands there, or a file cannot be written.
pub fn refresh(root: &Path) -> Result<PathBuf, ReportError> {
    is_free(root)?;
    let known = reports(root);
    let path = root.join("index.html");
    let page = page(root, &known).html(&path)?.replacen(OTHER, HOME, 1);
    // Under a name of this process: two commands may end at once.
    let part = root.join(format!(".mpm-verify.home.{}.part", std::process::id()));
    save(&part, page)?;
    fs::rename(&part, &path).map_err(|e| unwritable(&path, e))?;
    Ok(path)
}

/// Counts of all reports, one of each kind in the order of [`Counts`]. A page of a run counts as one.
fn summed(known: &[Known]) -> Vec<Counts> {
    let run = |report: &Report| match report.verdict.as_ref()?.state {
        State::Complete => Some(Counts::Runs { complete: 1, stopped: 0 }),
        State::Stopped if report.counts.is_empty() => Some(Counts::Runs { complete: 0, stopped: 1 }),
        _ => None,
    };
    let all = known.iter().flat_map(|k| run(&k.report).into_iter().chain(k.report.counts.iter().map(|t| t.counts)));
    let mut sums: Vec<Counts> = Vec::new();
    for counts in all {
        match sums.iter_mut().find_map(|sum| sum.with(&counts).map(|more| (sum, more))) {
            Some((sum, more)) => *sum = more,
            None => sums.push(counts),
        }
    }
    sums.sort_by_key(Counts::kind);
    sums
}

/// Runs, checks, claims and nights, each with its own count and word.
fn summary(known: &[Known]) -> Table {
    let row = |counts: &Counts| {
        vec![Cell::new(counts.kind().words()), Cell::state(counts.state()), Cell::new(counts.words())]
    };
    Table::new("Summary", &["kind", "state", "of which"], summed(known).iter().map(row).collect(), "").words()
}

fn page(root: &Path, known: &[Known]) -> Page {
    let hero = hero(root, known);
    let first = match hero {
        Some(image) => Section::new("picture", "").with(Block::Images(vec![image])),
        None => Section::new("picture", ""),
    };
    let glance: Vec<Image> = stills(root, known, true).collect();
    let pictures = (!glance.is_empty()).then_some(Block::Images(glance));
    let glance = pictures.into_iter().fold(Section::new("glance", "At a glance"), Section::with);
    Page {
        home: true,
        ..Page::new("Verification of a two-phase double-point material point method")
            .lead(if known.len() == 1 { "1 report.".to_owned() } else { format!("{} reports.", known.len()) })
            .section(Section::new("summary", "Summary").tables([summary(known)]))
            .section(first)
            .section(Section::new("verdicts", "Verdicts").tables([verdicts(known)]))
            .section(glance)
            .section(Section::new("reports", "Reports").with(Block::Html(list(known))))
    }
}

/// The main picture: the levee, moving if there is an animation; otherwise that of the first report that has one and is not seen at a glance.
fn hero(root: &Path, known: &[Known]) -> Option<Image> {
    let moving = known.iter().filter(|k| k.report.kind == Kind::Levee).find_map(|k| {
        let file = ["levee.png", "levee.gif"].into_iter().find(|file| root.join(&k.folder).join(file).is_file())?;
        Some(image(k, file, "A levee through which water seeps until its slope fails, as an animation"))
    });
    moving.or_else(|| stills(root, known, false).next())
}

/// Main pictures of reports: those of accuracy and of speed, which are seen at a glance, or those of all others.
fn stills<'a>(root: &'a Path, known: &'a [Known], at_a_glance: bool) -> impl Iterator<Item = Image> + 'a {
    let own = known.iter().filter(move |k| matches!(k.report.kind, Kind::Study | Kind::Speed) == at_a_glance);
    own.filter(|k| root.join(&k.folder).join(&k.report.picture).is_file())
        .map(|k| image(k, &k.report.picture, &k.report.alt))
}

fn image(known: &Known, file: &str, alt: &str) -> Image {
    let folder = &known.folder;
    let (src, href) = (format!("{folder}/{file}"), format!("{folder}/index.html"));
    Image { src, alt: alt.to_owned(), caption: String::new(), href }
}

/// One table of all verdicts.
fn verdicts(known: &[Known]) -> Table {
    let mut rows = Vec::new();
    for Known { folder, report } in known {
        let date = report.date.get(..10).unwrap_or(&report.date).to_owned();
        for tally in &report.counts {
            rows.push(vec![
                Cell::new(tally.label.clone()).linked(&format!("{folder}/index.html")),
                Cell::state(tally.counts.state()),
                Cell::new(tally.counts.words()),
                Cell::new(date.clone()),
            ]);
        }
    }
    Table::new("Verdicts", &["checked", "verdict", "of which", "date"], rows, "").words()
}

/// Links to all reports with state and date.
fn list(known: &[Known]) -> String {
    let mut html = "<ul class=\"reports\">".to_owned();
    for Known { folder, report } in known {
        let badge = report.verdict.as_ref().map_or_else(String::new, |v| {
            format!("<span class=\"badge {}\">{}</span> ", v.state.mark(), escaped(&v.state.word()))
        });
        let said = report.verdict.as_ref().map_or("", |v| &v.sentence);
        let when: Vec<&str> =
            [report.date.as_str(), report.made.commit.as_str()].into_iter().filter(|t| !t.is_empty()).collect();
        let link = |(text, href): &(String, String)| {
            format!("<a href=\"{}/{}\">{}</a>", escaped(folder), escaped(href), escaped(text))
        };
        let when = Some(escaped(&when.join(", "))).filter(|when| !when.is_empty());
        let below: Vec<String> = when.into_iter().chain(report.links.iter().map(link)).collect();
        let (title, said, below) = (escaped(&report.title), escaped(said), below.join(" · "));
        html += &format!(
            "<li><a href=\"{}/index.html\">{title}</a> {badge}<p>{said}</p><p class=\"note\">{below}",
            escaped(folder)
        );
        html += "</p></li>";
    }
    html + "</ul>"
}

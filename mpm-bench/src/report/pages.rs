//! The pages: `index.html` and `report.md`, with the same words.

use std::fs;
use std::path::Path;

use mpm_verify::page::site::{Kind, Report};
use mpm_verify::page::{self, Block, Page};
use mpm_verify::report::ReportError;
use mpm_verify::report::plots::figure::Figure;

use super::Findings;
use super::answers::{Answer, answers, summary};
use super::section::{Section, sections};

/// Sections that are folded up at first.
const FOLDED: [&str; 5] = ["growth", "kernel", "peers", "left-out", "measured"];

/// Writes both pages.
///
/// # Errors
/// A file that cannot be written, a figure that cannot be drawn.
pub fn write(findings: &Findings, figures: &[Figure], folder: &Path) -> Result<(), ReportError> {
    let all = sections(findings);
    let first = figures.first();
    let mut page = Page::new("What accuracy costs: speed against error of every integrator and scheme")
        .lead(summary(findings))
        .section(first.iter().fold(page::Section::new("picture", "Error against CPU time"), |s, f| s.figure(f)));
    let found = answers(findings).iter().fold(page::Section::new("answers", "What to use for a wanted error"), answer);
    page = page.section(found);
    for own in &all {
        page = page.section(section(own, figures, first));
    }
    let files = ["speed_against_error.csv", "cheapest.csv", "growth.csv", "manifest.json"];
    let report = Report::new(Kind::Speed);
    let report = first.map_or(report.clone(), |f| report.picture(format!("plots/{}.svg", f.name), &*f.title));
    let page =
        page.section(page::Section::new("files", "Files").files(files)).conditions(&findings.manifest).report(report);
    page.write(&folder.join("index.html"))?;
    let path = folder.join("report.md");
    let text = page.markdown(&path)?;
    fs::write(&path, text).map_err(|cause| ReportError::Write { path, cause })
}

fn answer(section: page::Section, answer: &Answer) -> page::Section {
    let mut section = section
        .with(Block::Heading(format!("For {}", answer.wanted)))
        .text(answer.answer.clone())
        .list(answer.beside.clone());
    if !answer.command.is_empty() {
        section = section.with(Block::Command(answer.command.clone()));
    }
    section
}

/// A section with its figures, without the one that the page begins with.
fn section(own: &Section, figures: &[Figure], first: Option<&Figure>) -> page::Section {
    let mut section = page::Section::new(own.id, own.title);
    section.folded = FOLDED.contains(&own.id);
    for text in &own.text {
        section = section.text(text.clone());
    }
    section = section.list(own.items.clone());
    let known = own.pictures.iter().filter_map(|name| figures.iter().find(|f| f.name == *name));
    for figure in known.filter(|figure| first.is_none_or(|first| first.name != figure.name)) {
        section = section.figure(figure);
    }
    section.tables(own.tables.iter().cloned())
}

//! The pages: `index.html` and `report.md`, with the same words.

use std::fs;
use std::path::Path;

use mpm_verify::page::site::{Kind, Report};
use mpm_verify::page::{self, Block, Page};
use mpm_verify::report::ReportError;
use mpm_verify::report::plots::figure::Figure;

use super::Findings;
use super::answers::{Answer, answers, summary};
use super::section::{COST, Section, sections};

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
        .section(
            first.iter().fold(page::Section::new("picture", "Speed against error at a glance"), |s, f| s.figure(f)),
        );
    for own in &all {
        page = page.section(section(own, figures));
        if own.id == COST {
            let found = page::Section::new("answers", "What to use for a wanted error");
            let answers = answers(findings);
            page = page.section(answers.chunk_by(|a, b| a.answer == b.answer).fold(found, answer));
        }
    }
    let files = ["speed_against_error.csv", "cost.csv", "cheapest.csv", "growth.csv", "manifest.json"];
    let report = Report::new(Kind::Speed);
    let report = first.map_or(report.clone(), |f| report.picture(format!("plots/{}.svg", f.name), &*f.title));
    let page =
        page.section(page::Section::new("files", "Files").files(files)).conditions(&findings.manifest).report(report);
    page.write(&folder.join("index.html"))?;
    let path = folder.join("report.md");
    let text = page.markdown(&path)?;
    fs::write(&path, text).map_err(|cause| ReportError::Write { path, cause })
}

/// An answer for the wanted errors that it serves.
fn answer(section: page::Section, same: &[Answer]) -> page::Section {
    let Some(first) = same.first() else { return section };
    let wanted: Vec<&str> = same.iter().map(|answer| answer.wanted.as_str()).collect();
    let section = section.with(Block::Heading(format!("For {}", wanted.join(", ")))).text(first.answer.clone());
    if first.command.is_empty() { section } else { section.with(Block::Command(first.command.clone())) }
}

fn section(own: &Section, figures: &[Figure]) -> page::Section {
    let mut section = page::Section::new(own.id, own.title);
    section.folded = FOLDED.contains(&own.id);
    for text in &own.text {
        section = section.text(text.clone());
    }
    section = section.list(own.items.clone());
    for figure in own.pictures.iter().filter_map(|name| figures.iter().find(|f| f.name == *name)) {
        section = section.figure(figure);
    }
    section.tables(own.tables.iter().cloned())
}

//! The pages: `index.html` and `report.md`, with the same words.

use std::fs;
use std::path::Path;

use mpm_verify::report::ReportError;
use mpm_verify::report::content::Picture;
use mpm_verify::report::html::render;
use mpm_verify::report::markdown::{list, with_note};
use mpm_verify::report::plots::figure::Figure;
use serde::Serialize;

use super::Findings;
use super::answers::{Answer, answers, summary};
use super::section::{Section, sections};

const TEMPLATE: &str = include_str!("template.html");

/// What both pages say.
#[derive(Debug, Serialize)]
struct Page {
    title: &'static str,
    summary: String,
    answers: Vec<Answer>,
    sections: Vec<Section>,
    manifest: Vec<(&'static str, String)>,
}

/// Writes both pages.
///
/// # Errors
/// A file that cannot be written, a template that does not fit.
pub fn write(findings: &Findings, figures: &[Figure], drawn: &[String], folder: &Path) -> Result<(), ReportError> {
    let page = Page {
        title: "What accuracy costs: speed against error of every integrator and scheme",
        summary: summary(findings),
        answers: answers(findings),
        sections: sections(findings),
        manifest: findings.manifest.entries().to_vec(),
    };
    let pictures = Picture::all(figures);
    let path = folder.join("index.html");
    let html = render(TEMPLATE, serde_json::json!(page), &pictures, (figures, drawn), ".")
        .map_err(|cause| ReportError::Page { path: path.clone(), cause })?;
    let save = |path: &Path, text: String| {
        fs::write(path, text).map_err(|cause| ReportError::Write { path: path.to_owned(), cause })
    };
    save(&path, html)?;
    save(&folder.join("report.md"), markdown(&page, &pictures))
}

fn markdown(page: &Page, pictures: &[Picture]) -> String {
    let mut text = format!("# {}\n\n{}\n", page.title, page.summary);
    for answer in &page.answers {
        text += &format!("\n**For {}**: {}\n\n", answer.wanted, answer.answer);
        text.extend(answer.beside.iter().map(|line| format!("- {line}\n")));
        if !answer.command.is_empty() {
            text += &format!("\n```sh\n{}\n```\n", answer.command);
        }
    }
    for section in &page.sections {
        text += &format!("\n## {}\n\n", section.title);
        text.extend(section.text.iter().map(|t| format!("{t}\n\n")));
        text.extend(section.items.iter().map(|t| format!("- {t}\n")));
        for picture in section.pictures.iter().filter_map(|name| pictures.iter().find(|p| p.name == *name)) {
            let Picture { name, number, title, caption } = picture;
            text += &format!("![{title}](plots/{name}.svg)\n\n**Figure {number}. {title}.** {caption} ");
            text += &format!("([numbers](plots/{name}.csv))\n\n");
        }
        section.tables.iter().for_each(|table| with_note(&mut text, table));
    }
    list(&mut text, "Conditions", page.manifest.iter().map(|(name, value)| format!("{name}: `{value}`")));
    text
}

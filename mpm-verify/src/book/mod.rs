//! The guide as pages: the chapters of `docs/`, with their formulas as MathML, which a browser shows without a script or network.
//!
//! # Reading order
//! 1. [`CHAPTERS`]: the chapters in their order. [`write()`]: all of them as pages.
//! 2. `render.rs`: Markdown to HTML. `formula.rs`: TeX to MathML. `links.rs`: where links of a chapter lead on the pages.
//! 3. [`reference`]: the chapter of scene keys, made by asking the checker.

pub use links::anchor;

pub(crate) mod formula;
mod links;
pub mod reference;
mod render;

use std::fs;
use std::path::Path;

use crate::error::Error;
use crate::{files, report};

/// A chapter of the guide.
#[derive(Debug, Clone, Copy)]
pub struct Chapter {
    /// Name of its file without the ending: `theory.md` in `docs/`, `theory.html` among the pages.
    pub name: &'static str,
    /// Its text, Markdown.
    pub text: &'static str,
}

macro_rules! chapters {
    ($($name:literal),* $(,)?) => {
        &[$(Chapter { name: $name, text: include_str!(concat!("../../docs/", $name, ".md")) }),*]
    };
}

/// The chapters in their order.
pub const CHAPTERS: &[Chapter] = chapters![
    "tutorial",
    "theory",
    "integrators",
    "levee",
    "free-surface",
    "scene-reference",
    "commands",
    "reports",
    "extending",
    "reliability",
];

impl Chapter {
    /// The text of its first heading.
    pub fn title(&self) -> &'static str {
        self.text.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or(self.name)
    }
}

/// Writes the guide into the folder `guide` of the reports: a page for each chapter and `index.html`, the list of them.
/// Links and pictures that lead to other reports are kept where these exist.
///
/// # Errors
/// A formula that is not TeX, or a file that cannot be written.
pub fn write(reports: &Path) -> Result<(), Error> {
    let folder = reports.join("guide");
    fs::create_dir_all(&folder).map_err(Error::at(&folder))?;
    let list = Chapter { name: "index", text: include_str!("../../docs/README.md") };
    for chapter in CHAPTERS.iter().chain([&list]) {
        let path = folder.join(format!("{}.html", chapter.name));
        files::write(&path, page(chapter, reports)?.as_bytes()).map_err(Error::at(&path))?;
    }
    Ok(())
}

/// The page of a chapter.
fn page(chapter: &Chapter, reports: &Path) -> Result<String, Error> {
    let place = CHAPTERS.iter().position(|c| c.name == chapter.name);
    let beside = |other: Option<usize>| other.and_then(|i| CHAPTERS.get(i)).map(entry);
    let (body, sections) = render::html(chapter, reports)?;
    let number = place.map(|i| i + 1);
    let content = serde_json::json!({
        "title": number.map_or_else(|| "Guide".to_owned(), |n| format!("{n}. {}", chapter.title())),
        "name": chapter.name,
        "chapters": CHAPTERS.iter().map(entry).collect::<Vec<_>>(),
        "sections": sections,
        "before": beside(place.and_then(|i| i.checked_sub(1))),
        "after": beside(Some(place.map_or(0, |i| i + 1))),
        "body": body,
    });
    let page = report::html::render(include_str!("page.html"), content, &[], (&[], &[]), "");
    let page = page.map_err(|why| Error::Found(why.to_string()).of(chapter.name))?;
    Ok(page.replacen("</style>", concat!(include_str!("style.css"), "</style>"), 1))
}

fn entry(chapter: &Chapter) -> serde_json::Value {
    serde_json::json!({ "name": chapter.name, "title": chapter.title() })
}

#[cfg(test)]
mod tests;

//! The guide as pages: the chapters of `docs/`, with their formulas as MathML, which a browser shows without a script or network.
//!
//! # Reading order
//! 1. [`CHAPTERS`]: the chapters in their order. [`write()`]: all of them as pages.
//! 2. `render.rs`: Markdown to sections of a page. `formula.rs`: TeX to MathML. `links.rs`: where links of a chapter lead on the pages.
//! 3. [`mod@reference`]: the chapter of scene keys, made by asking the checker.

pub use links::anchor;

pub(crate) mod formula;
mod links;
pub mod reference;
mod render;
pub mod stored;

use std::path::{Path, PathBuf};

use crate::page::site::{Kind, Report};
use crate::page::{Link, Page, Section};
use crate::report::ReportError;

/// Why the guide cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A formula that is not TeX, or has a command that is not known.
    #[error("{tex}: {why}")]
    Formula {
        /// The formula.
        tex: String,
        /// What is wrong with it.
        why: String,
    },
    /// A folder that cannot be made.
    #[error("{}: {source}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A page that cannot be made.
    #[error(transparent)]
    Page(#[from] ReportError),
}

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
    "own-code",
    "theory",
    "integrators",
    "levee",
    "slopes",
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
    std::fs::create_dir_all(&folder).map_err(|source| Error::Folder { path: folder.clone(), source })?;
    let all: Vec<Link> = CHAPTERS.iter().zip(1..).map(|(chapter, n)| link(n, chapter)).collect();
    for (i, chapter) in CHAPTERS.iter().enumerate() {
        let mut sections = render::sections(chapter.text, reports)?;
        let turn = [i.checked_sub(1).map(|i| ("Previous", i)), Some(("Next", i + 1))];
        let turn = turn.into_iter().flatten().filter_map(|(word, i)| Some(format!("{word}: {}", shown(all.get(i)?))));
        sections.push(Section::new("turn", "").text(turn.collect::<Vec<_>>().join(" · ")));
        let page =
            Page::new(format!("{}. {}", i + 1, chapter.title())).below("Guide", "index.html").beside(all.clone());
        page_of(page, sections).write(&folder.join(format!("{}.html", chapter.name)))?;
    }
    let list = render::sections(include_str!("../../docs/README.md"), reports)?;
    let page = Page::new("Guide").beside(all).report(Report::new(Kind::Guide));
    page_of(page, list).write(&folder.join("index.html"))?;
    Ok(())
}

fn page_of(page: Page, sections: Vec<Section>) -> Page {
    sections.into_iter().fold(page, Page::section)
}

fn link(number: usize, chapter: &Chapter) -> Link {
    Link::new(format!("{number}. {}", chapter.title()), format!("{}.html", chapter.name))
}

/// A link as the text of a page has it.
fn shown(link: &Link) -> String {
    format!("[{}]({})", link.text, link.href)
}

#[cfg(test)]
mod tests;

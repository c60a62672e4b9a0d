//! The page of the gallery.

use std::fs;
use std::path::Path;

use serde::Deserialize;

use super::numbers::short;
use super::{ReportError, capital, solved};
use crate::cases::own::compared::Found;
use crate::page::site::{Kind, Report};
use crate::page::table::{Cell, Table};
use crate::page::verdict::{Counts, State, Tally, Verdict};
use crate::page::{Block, Image, Page, Section};
use crate::scenes::{self, Exhibit};

/// A scene that was solved.
#[derive(Debug)]
pub struct Shown {
    name: &'static str,
    about: String,
    lines: usize,
    time: String,
    exact: Option<Found>,
    trouble: Option<String>,
}

/// Part of the `summary.json` of a scene that the gallery shows.
#[derive(Debug, Default, Deserialize)]
struct Summary {
    exact: Option<Found>,
}

impl Shown {
    /// A scene with its time (s), what went wrong, and its results in a folder of its name beside the page.
    pub fn new(scene: &Exhibit, wall_s: f64, trouble: Option<String>, folder: &Path) -> Self {
        let Exhibit { name, text } = *scene;
        let summary = fs::read_to_string(folder.join(name).join("summary.json")).unwrap_or_default();
        let Summary { exact } = serde_json::from_str(&summary).unwrap_or_default();
        let (about, lines) = (scenes::about_text(text), text.lines().count());
        Self { name, about, lines, time: short(wall_s, 2), exact, trouble }
    }

    /// The first sentence of what is said of the scene.
    fn first_sentence(&self) -> &str {
        self.about.split_inclusive(". ").next().map_or("", str::trim)
    }

    fn title(&self) -> String {
        solved::title(self.name)
    }

    fn page(&self) -> String {
        format!("{}/index.html", self.name)
    }

    fn picture(&self) -> String {
        format!("{}/{}", self.name, solved::THUMBNAIL)
    }

    fn image(&self) -> Image {
        let exact = self.exact.as_ref().map_or_else(String::new, |found| format!(" {}.", capital(&found.headline())));
        Image {
            src: self.picture(),
            alt: self.about.clone(),
            caption: format!("[{}]({}): {}{exact}", self.title(), self.page(), self.first_sentence()),
            href: self.page(),
        }
    }

    fn row(&self) -> Vec<Cell> {
        let ran = self.trouble.is_none();
        let state = if ran { State::Complete } else { State::Stopped };
        let name = if ran { Cell::new(self.title()).linked(&self.page()) } else { Cell::new(self.title()) };
        let exact = self.exact.as_ref().map_or_else(|| "no exact solution".to_owned(), Found::headline);
        vec![
            name,
            Cell::state(state).small(self.trouble.clone().unwrap_or_default()),
            Cell::new(exact),
            Cell::new(self.time.clone()),
            Cell::new(format!("{}.toml", self.name))
                .linked(&format!("{}.toml", self.name))
                .small(format!("{} lines", self.lines)),
        ]
    }
}

/// Writes `index.html` beside the folders of the scenes.
///
/// # Errors
/// A file that cannot be written, or a template that does not fit.
pub fn write(scenes: &[Shown], folder: &Path) -> Result<(), ReportError> {
    let complete: Vec<&Shown> = scenes.iter().filter(|scene| scene.trouble.is_none()).collect();
    let stopped = scenes.len() - complete.len();
    let counts = Counts::Runs { complete: complete.len(), stopped };
    let sentence = match stopped {
        0 if scenes.len() == 1 => "The scene ran to its end.".to_owned(),
        0 => format!("All {} scenes ran to their end.", scenes.len()),
        _ => format!("{stopped} of {} scenes stopped before their end.", scenes.len()),
    };
    let head = ["scene", "run", "against the exact solution", "time (s)", "file"];
    let table = Table::new("Scenes", &head, scenes.iter().map(Shown::row).collect(), "").words();
    let images = Block::Images(complete.iter().map(|scene| scene.image()).collect());
    let report = Report::new(Kind::Gallery).counts([Tally::new("Gallery", counts)]);
    let report = match complete.first() {
        Some(scene) => report.picture(scene.picture(), scene.about.clone()),
        None => report,
    };
    Page::new("Gallery of scenes")
        .verdict(Verdict::new(counts.state(), sentence))
        .lead("Each scene is one file, solved by `mpm-verify solve`. A picture leads to the page of its scene.")
        .section(Section::new("pictures", "Pictures").with(images))
        .section(Section::new("scenes", "Scenes").tables([table]))
        .report(report)
        .write(&folder.join("index.html"))
}

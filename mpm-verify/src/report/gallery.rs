//! The page of the gallery.

use std::path::Path;

use super::ReportError;
use super::numbers::short;
use crate::page::site::{Kind, Report};
use crate::page::table::{Cell, Table};
use crate::page::verdict::{Counts, State, Tally, Verdict};
use crate::page::{Block, Image, Page, Section};
use crate::scenes::Exhibit;

/// A scene that was solved.
#[derive(Debug)]
pub struct Shown {
    name: &'static str,
    about: String,
    picture: &'static str,
    lines: usize,
    time: String,
    trouble: Option<String>,
}

impl Shown {
    /// One that took so long (s), and what went wrong.
    pub fn new(scene: &Exhibit, wall_s: f64, trouble: Option<String>) -> Self {
        let Exhibit { name, picture, text } = *scene;
        let comment = text.lines().next().unwrap_or_default();
        let about = comment.trim_start_matches('#').trim().to_owned();
        Self { name, about, picture, lines: text.lines().count(), time: short(wall_s, 2), trouble }
    }

    fn page(&self) -> String {
        format!("{}/index.html", self.name)
    }

    fn image(&self) -> Image {
        Image {
            src: format!("{}/{}.svg", self.name, self.picture),
            alt: self.about.clone(),
            caption: format!("[{}]({}): {}", self.name, self.page(), self.about),
            href: self.page(),
        }
    }

    fn row(&self) -> Vec<Cell> {
        let state = if self.trouble.is_none() { State::Complete } else { State::Stopped };
        let name =
            if self.trouble.is_none() { Cell::new(self.name).linked(&self.page()) } else { Cell::new(self.name) };
        vec![
            name,
            Cell::state(state).small(self.trouble.clone().unwrap_or_default()),
            Cell::new(self.time.clone()),
            Cell::new(format!("{}.toml", self.name)).linked(&format!("{}.toml", self.name)),
            Cell::new(self.lines.to_string()),
        ]
    }
}

/// Writes `index.html` beside the folders of the scenes.
///
/// # Errors
/// A file that cannot be written, or a template that does not fit.
pub fn write(scenes: &[Shown], folder: &Path) -> Result<(), ReportError> {
    let solved: Vec<&Shown> = scenes.iter().filter(|scene| scene.trouble.is_none()).collect();
    let stopped = scenes.len() - solved.len();
    let counts = Counts::Runs { complete: solved.len(), stopped };
    let sentence = match stopped {
        0 if scenes.len() == 1 => "The scene ran to its end.".to_owned(),
        0 => format!("All {} scenes ran to their end.", scenes.len()),
        _ => format!("{stopped} of {} scenes stopped before their end.", scenes.len()),
    };
    let head = ["scene", "run", "time (s)", "file", "lines"];
    let table = Table::new("Scenes", &head, scenes.iter().map(Shown::row).collect(), "");
    let images = Block::Images(solved.iter().map(|scene| scene.image()).collect());
    let report = Report::new(Kind::Gallery).counts([Tally::new("Gallery", counts)]);
    let report = match solved.first() {
        Some(scene) => report.picture(format!("{}/{}.svg", scene.name, scene.picture), scene.about.clone()),
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

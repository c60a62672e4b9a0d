//! The page of the gallery.

use std::path::Path;

use serde::Serialize;
use serde_json::json;

use super::html::render;
use super::numbers::short;
use super::{ReportError, save};
use crate::scenes::Exhibit;

const TEMPLATE: &str = include_str!("gallery.html");

/// A scene that was solved.
#[derive(Debug, Serialize)]
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
}

/// Writes `index.html` beside the folders of the scenes.
///
/// # Errors
/// A file that cannot be written, or a template that does not fit.
pub fn write(scenes: &[Shown], folder: &Path) -> Result<(), ReportError> {
    let path = folder.join("index.html");
    let page = json!({ "title": "Gallery", "scenes": scenes });
    let html = render(TEMPLATE, page, &[], (&[], &[]), ".");
    save(&path, html.map_err(|cause| ReportError::Page { path: path.clone(), cause })?)
}

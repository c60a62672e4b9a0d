//! The page of all nights.

use std::fs;
use std::path::Path;

use serde::Serialize;

use super::report::Night;
use crate::report::content::Picture;
use crate::report::content::table::{Cell, Table, table};
use crate::report::html::render;
use crate::report::{ReportError, save};

const TEMPLATE: &str = include_str!("nights.html");

#[derive(Debug, Serialize)]
struct Page {
    title: &'static str,
    nights: Vec<Table>,
}

/// Writes `index.html` with the nights in a folder, and the one that is about to appear there under a name.
///
/// # Errors
/// A file that cannot be written.
pub fn write(known: &Path, (name, night): (&str, &Night), folder: &Path) -> Result<(), ReportError> {
    let mut nights = vec![(name.to_owned(), night.clone())];
    // A folder without a summary is no night.
    for entry in fs::read_dir(known).into_iter().flatten().flatten() {
        let text = fs::read(entry.path().join("summary.json"));
        if let Some(night) = text.ok().and_then(|text| serde_json::from_slice::<Night>(&text).ok()) {
            nights.push((entry.file_name().to_string_lossy().into_owned(), night));
        }
    }
    nights.sort_by(|a, b| b.1.date.cmp(&a.1.date));
    let row = |(name, night): &(String, Night)| {
        vec![
            Cell::new(night.date.clone()).linked(&format!("{name}/index.html")),
            Cell::new(night.commit.clone()),
            Cell::new(night.verdict.clone()).marked("", if night.is_green() { "good" } else { "bad" }),
            Cell::new(night.moved.len().to_string()),
            Cell::new(night.fell.len().to_string()),
            Cell::new(night.compared.to_string()),
            Cell::new(format!("{:.0}", night.cpu_s)),
            Cell::new(format!("{:.0}", night.wall_s)),
        ]
    };
    let head = ["night", "commit", "verdict", "moved", "fell short", "compared", "CPU (s)", "clock (s)"];
    let page =
        Page { title: "Nights", nights: vec![table(String::new(), &head, nights.iter().map(row).collect(), "")] };
    let path = folder.join("index.html");
    let html = render(TEMPLATE, serde_json::json!(page), &Picture::all(&[]), (&[], &[]), ".");
    save(&path, html.map_err(|cause| ReportError::Page { path: path.clone(), cause })?)
}

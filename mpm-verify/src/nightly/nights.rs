//! The page of all nightly runs.

use std::fs;
use std::path::Path;

use super::report::Night;
use super::{history, tables, trends};
use crate::page::site::{Kind, Report};
use crate::page::table::{Cell, Table};
use crate::page::verdict::{Counts, State, Tally, Verdict};
use crate::page::{Block, Image, Link, Page, Section};
use crate::report::ReportError;
use crate::report::plots::error_against_mesh;

/// Writes `index.html` with the nightly runs in a folder, and the one that is about to appear there under a name; the history is linked
/// if it is in the folder.
///
/// # Errors
/// A file that cannot be written.
pub fn write(known: &Path, (name, night): (&str, &Night), folder: &Path) -> Result<(), ReportError> {
    let mut nights = vec![(name.to_owned(), night.clone())];
    // A folder without a summary is no nightly run.
    for entry in fs::read_dir(known).into_iter().flatten().flatten() {
        let text = fs::read(entry.path().join("summary.json"));
        if let Some(night) = text.ok().and_then(|text| serde_json::from_slice::<Night>(&text).ok()) {
            nights.push((entry.file_name().to_string_lossy().into_owned(), night));
        }
    }
    nights.sort_by(|a, b| b.1.date.cmp(&a.1.date));
    let row = |(name, night): &(String, Night)| {
        vec![
            Cell::new(tables::date(&night.date)).linked(&format!("{name}/index.html")),
            Cell::badge(night.state().word(), night.state().mark()),
            Cell::new(night.commit.clone()),
            Cell::new(night.moved.len().to_string()),
            Cell::new(night.fell.len().to_string()),
            Cell::new(night.compared.to_string()),
            Cell::new(format!("{:.0}", night.cpu_s)),
            Cell::new(format!("{:.0}", night.wall_s)),
        ]
    };
    let head = ["run", "verdict", "commit", "moved numbers", "failed checks", "compared", "CPU (s)", "clock (s)"];
    let table = Table::new("All nightly runs", &head, nights.iter().map(row).collect(), "");
    let count = |states: &[State]| nights.iter().filter(|(_, night)| states.contains(&night.state())).count();
    let counts = Counts::Nights {
        unchanged: count(&[State::Unchanged]),
        moved: count(&[State::Moved]),
        worse: count(&[State::Worse, State::Failed]),
        in_part: count(&[State::NotEstablished]),
    };
    let Some((latest_name, latest)) = nights.first() else { return Ok(()) };
    let verdict = Verdict::new(latest.state(), format!("The latest run: {}.", latest.found()));
    let own_history = folder.join(history::NAME).exists();
    let runs = Section::new("runs", "Runs").tables([table]);
    let runs = if own_history { runs.files([history::NAME]) } else { runs };
    let mut report = Report {
        date: latest.date.clone(),
        made: latest.manifest.made(),
        ..Report::new(Kind::Nightly).counts([Tally::new("Nightly runs", counts)])
    };
    // The pictures of the latest run, as far as it has them: that of convergence first.
    let picture = |(name, alt): (&str, &str)| {
        let src = format!("{latest_name}/{name}.svg");
        let is_there = [known, folder].into_iter().any(|folder| folder.join(&src).exists());
        let (href, caption) = (format!("{latest_name}/index.html"), String::new());
        is_there.then(|| Image { src, alt: alt.to_owned(), caption, href })
    };
    let pictures: Vec<Image> = [
        (error_against_mesh::NIGHTLY, "Largest error of U against the mesh, tonight and accepted"),
        (trends::OVER_NIGHTS, "Errors and costs over the nights"),
    ]
    .into_iter()
    .filter_map(picture)
    .collect();
    if let Some(first) = pictures.first() {
        report = report.picture(&first.src, &first.alt);
    }
    let mut convergence = Section::new("latest", "The latest run");
    if !pictures.is_empty() {
        convergence = convergence.with(Block::Images(pictures));
    }
    Page::new("Nightly runs")
        .verdict(verdict)
        .section(convergence)
        .section(runs)
        .beside(trends::links().map(|Link { text, href }| Link::new(text, href.trim_start_matches("../"))).into())
        .report(report)
        .write(&folder.join("index.html"))
}

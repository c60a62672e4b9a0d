//! The page of all nightly runs.

use std::fs;
use std::path::Path;

use super::report::Night;
use super::{history, tables, trends};
use crate::page::site::{Kind, Report};
use crate::page::table::{Cell, Table};
use crate::page::verdict::{Counts, State, Tally, Verdict};
use crate::page::{Link, Page, Section};
use crate::report::ReportError;

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
    let own_history = folder.join(history::NAME).exists();
    let table = Table::new("All nightly runs", &head, nights.iter().map(row).collect(), "");
    let count = |states: &[State]| nights.iter().filter(|(_, night)| states.contains(&night.state())).count();
    let counts = Counts::Nights {
        unchanged: count(&[State::Unchanged]),
        moved: count(&[State::Moved]),
        worse: count(&[State::Worse, State::Failed]),
        in_part: count(&[State::NotEstablished]),
    };
    let latest = nights.first().map(|(_, night)| night);
    let verdict = latest.map_or_else(
        || Verdict::new(State::NotEstablished, "No nightly run yet."),
        |night| Verdict::new(night.state(), format!("The latest run: {}.", night.found())),
    );
    let section = Section::new("runs", "Runs").tables([table]);
    let section = if own_history { section.files([history::NAME]) } else { section };
    let report = Report {
        date: latest.map_or_else(String::new, |night| night.date.clone()),
        commit: latest.map_or_else(String::new, |night| night.commit.clone()),
        ..Report::new(Kind::Nightly).counts([Tally::new("Nightly runs", counts)])
    };
    Page::new("Nightly runs")
        .verdict(verdict)
        .section(section)
        .beside(trends::links().map(|Link { text, href }| Link::new(text, href.trim_start_matches("../"))).into())
        .report(report)
        .write(&folder.join("index.html"))
}

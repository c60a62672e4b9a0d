//! Every figure and table of the paper with its counterpart here.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::claims::{Claim, Verdict};
use crate::files::STAGE;
use crate::page::site;
use crate::page::table::{Cell, Table};
use crate::page::verdict::Counts;

const BOOK: &str = include_str!("../../../../reference-data/paper/items.toml");
/// Stands in the book for the page of the levee.
const LEVEE: &str = "(@levee)";

/// A figure or table of the paper.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Item {
    /// Which: `Figure 4b`.
    pub item: String,
    /// What it shows.
    pub shows: String,
    /// The numbers that the paper prints.
    pub numbers: String,
    /// The counterpart.
    pub ours: String,
    /// How it differs, and why.
    pub differs: String,
    /// Names of the claims on it.
    #[serde(default)]
    claims: Vec<String>,
    /// The verdicts on them, with what was found.
    #[serde(skip)]
    pub verdicts: Vec<(Verdict, String)>,
}

#[derive(Debug, Deserialize)]
struct Book {
    item: Vec<Item>,
}

/// A row of the claims of the levee.
#[derive(Debug, Deserialize)]
struct Row {
    claim: String,
    value: String,
    verdict: String,
}

/// All items, with the verdicts of a study that is written into a folder, and of the levee if there is one beside it.
pub fn items(claims: &[Claim], folder: &Path) -> Vec<Item> {
    let home = site::home(folder);
    let levee = home.join("levee");
    let mut known: Vec<(String, Verdict, String)> =
        claims.iter().map(|c| (c.id.clone(), c.verdict, c.evidence.clone())).collect();
    if let Ok(mut reader) = csv::Reader::from_path(levee.join("claims.csv")) {
        let rows = reader.deserialize::<Row>().flatten();
        known.extend(rows.filter_map(|row| Some((row.claim, Verdict::read(&row.verdict)?, row.value))));
    }
    let page = levee.join("index.html").is_file() && home.join("accuracy") == published(folder);
    let book: Book = toml::from_str(BOOK).unwrap_or(Book { item: Vec::new() });
    let filled = |mut item: Item| {
        let found = |name: &String| known.iter().find(|(id, ..)| id == name).map(|(_, v, e)| (*v, e.clone()));
        item.verdicts = item.claims.iter().filter_map(found).collect();
        item.ours = if page {
            item.ours.replace(LEVEE, "(../levee/index.html)")
        } else {
            item.ours.replace(&format!("[The levee]{LEVEE}"), "`mpm-verify levee`")
        };
        item
    };
    book.item.into_iter().map(filled).collect()
}

/// The folder that something written into a stage will stand in.
fn published(folder: &Path) -> PathBuf {
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    match folder.file_name() {
        Some(name) if name == STAGE => folder.parent().unwrap_or(&folder).to_owned(),
        _ => folder,
    }
}

/// Verdicts on all items, counted.
pub fn counts(items: &[Item]) -> Counts {
    Counts::of_claims(items.iter().flat_map(|item| item.verdicts.iter().map(|(verdict, _)| *verdict)))
}

/// The table of all items.
pub fn table(items: &[Item]) -> Table {
    let row = |item: &Item| {
        let (mut word, mut mark) = ("not compared", "");
        if !item.verdicts.is_empty() {
            let is = |one: Verdict| item.verdicts.iter().any(|(verdict, _)| *verdict == one);
            let agrees = is(Verdict::Reproduced) || is(Verdict::ReproducedForAnotherReason);
            (word, mark) = match (agrees, is(Verdict::NotReproduced)) {
                (true, false) => ("agrees", "good"),
                (false, true) => ("differs", "bad"),
                (true, true) => ("agrees in part", "warn"),
                (false, false) => ("not comparable", ""),
            };
        }
        let found: Vec<String> =
            item.verdicts.iter().map(|(verdict, found)| format!("{}: {found}", verdict.words())).collect();
        vec![
            Cell::new(item.item.clone()),
            Cell::badge(word, mark),
            Cell::new(item.shows.clone()).small(format!("Numbers: {}", item.numbers)),
            Cell::prose(item.ours.clone()).small(found.join("\n")),
            Cell::prose(item.differs.clone()),
        ]
    };
    let head = ["in the paper", "verdict", "what it shows", "here", "what differs, and why"];
    Table::new("Figures and tables of the paper", &head, items.iter().map(row).collect(), "").words()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_and_table_of_the_paper_has_its_place() {
        let folder = tempfile::tempdir().expect("a folder");
        let items = items(&crate::claims::judge(&[]), &folder.path().join("reports/accuracy"));
        let names: Vec<&str> = items.iter().map(|item| item.item.as_str()).collect();
        for name in ["Figure 1", "Figure 2", "Figure 3", "Table 1", "Figure 4a", "Figure 4b", "Figure 4c", "Table 2"] {
            assert!(names.contains(&name), "{name}");
        }
        for name in ["Figure 5", "Figure 6", "Table 3", "Figure 7a", "Figure 7b", "Figure 7c", "Figure 8", "Figure 9"] {
            assert!(names.contains(&name), "{name}");
        }
        // Every claim of section 3 is about one of them, and no link leads to a levee that is not there.
        let judged: usize = items.iter().map(|item| item.verdicts.len()).sum();
        assert_eq!(judged, crate::claims::judge(&[]).len());
        assert!(items.iter().all(|item| !item.ours.contains("levee/index.html") && !item.ours.contains('@')));
    }
}

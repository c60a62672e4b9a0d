//! Every figure and table of the paper with its counterpart here.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::book::anchor;
use crate::claims::{Claim, Verdict};
use crate::files::STAGE;
use crate::page::table::{Cell, Table};
use crate::page::verdict::Counts;
use crate::page::{Block, Image, Section, site, sketch};
use crate::report::plots::figure::Figure;
use crate::report::study::{badge, page_of};

const BOOK: &str = include_str!("../../../../reference-data/paper/items.toml");
/// Stands in the book for the page of the levee.
const LEVEE: &str = "(@levee)";

/// A figure, table or passage of the paper.
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
    /// The picture of the counterpart.
    picture: Option<Picture>,
    /// Names of the claims on it.
    #[serde(default)]
    claims: Vec<String>,
    /// Verdicts on its claims.
    #[serde(skip)]
    pub verdicts: Vec<Checked>,
}

/// A picture of this program beside an item.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Picture {
    /// A figure of the study, by its name.
    Figure(String),
    /// A file of the levee's report.
    Levee(String),
    /// A sketch of a scene, by its name.
    Sketch(String),
}

/// A claim of the paper that was checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    id: String,
    /// Words of the paper.
    pub said: String,
    /// Evidence found here.
    pub found: String,
    /// The verdict.
    pub verdict: Verdict,
}

/// A row of the claims of the levee.
#[derive(Debug, Deserialize)]
struct Row {
    claim: String,
    paper: String,
    value: String,
    verdict: String,
}

#[derive(Debug, Deserialize)]
struct Book {
    item: Vec<Item>,
}

/// Items of the paper: those with a claim that was checked first, those that are not compared last, each in the order of the paper; with the verdicts
/// of a study that is written into a folder, and of the levee if there is one beside it.
pub fn items(claims: &[Claim], folder: &Path) -> Vec<Item> {
    let levee = site::home(folder).join("levee");
    let of_study =
        |c: &Claim| Checked { id: c.id.clone(), said: c.said.clone(), found: c.evidence.clone(), verdict: c.verdict };
    let mut known: Vec<Checked> = claims.iter().map(of_study).collect();
    if let Ok(mut reader) = csv::Reader::from_path(levee.join("claims.csv")) {
        let rows = reader.deserialize::<Row>().flatten();
        known.extend(rows.filter_map(|row| {
            let verdict = Verdict::read(&row.verdict)?;
            Some(Checked { id: row.claim, said: row.paper, found: row.value, verdict })
        }));
    }
    let has_page = levee.join("index.html").is_file() && levee.with_file_name("accuracy") == published(folder);
    let book: Book = toml::from_str(BOOK).unwrap_or(Book { item: Vec::new() });
    let filled = |mut item: Item| {
        item.verdicts = item.claims.iter().filter_map(|id| known.iter().find(|c| c.id == *id).cloned()).collect();
        item.ours = if has_page {
            item.ours.replace(LEVEE, "(../levee/index.html)")
        } else {
            item.ours.replace(&format!("[The levee]{LEVEE}"), "`mpm-verify levee`")
        };
        item.picture = item.picture.filter(|picture| match picture {
            Picture::Levee(file) => has_page && levee.join(file).is_file(),
            _ => true,
        });
        item
    };
    let mut items: Vec<Item> = book.item.into_iter().map(filled).collect();
    items.sort_by_key(|item| item.verdicts.is_empty());
    items
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
    Counts::of_claims(items.iter().flat_map(|item| item.verdicts.iter().map(|checked| checked.verdict)))
}

/// A row for every claim in words, and one for every item without.
pub fn table(items: &[Item]) -> Table {
    let mut rows = Vec::new();
    for item in items {
        let name = || Cell::new(item.item.clone()).linked(&format!("#{}", anchor(&item.item)));
        for claim in &item.verdicts {
            rows.push(vec![
                name(),
                Cell::new(claim.said.clone()),
                Cell::new(claim.found.clone()),
                badge(claim.verdict),
            ]);
        }
        if item.verdicts.is_empty() {
            rows.push(vec![name(), Cell::new(item.shows.clone()), Cell::prose(&item.ours), Cell::new("not compared")]);
        }
    }
    let head = ["in the paper", "the paper says", "ours", "verdict"];
    Table::new("The paper and ours", &head, rows, "").words()
}

/// A section for every item: what the paper's text says of it, and ours.
pub fn sections(items: &[Item], figures: &[Figure]) -> Vec<Section> {
    let section = |item: &Item| {
        let terms = [
            ("The paper", &item.shows),
            ("Numbers in print", &item.numbers),
            ("Ours", &item.ours),
            ("What differs", &item.differs),
        ];
        let terms = terms.map(|(name, text)| (name.to_owned(), text.to_owned())).to_vec();
        let picture = item.picture.iter().filter_map(|picture| block(picture, item, figures));
        picture.fold(Section::new(&anchor(&item.item), &item.item).with(Block::Terms(terms)), Section::with)
    };
    items.iter().map(section).collect()
}

fn block(picture: &Picture, item: &Item, figures: &[Figure]) -> Option<Block> {
    let image =
        |src: String, alt: String, href: String| Block::Images(vec![Image { src, alt, caption: String::new(), href }]);
    match picture {
        Picture::Figure(name) => {
            let figure = figures.iter().find(|figure| figure.name == name)?;
            let href = format!("{}#fig-{name}", page_of(figure.name));
            Some(image(format!("plots/{name}.svg"), figure.title.clone(), href))
        }
        Picture::Levee(file) => {
            let alt = format!("The same in this program's run of the levee. {}", item.shows);
            Some(image(format!("../levee/{file}"), alt, "../levee/index.html".to_owned()))
        }
        Picture::Sketch(name) => Some(Block::Html(sketch::svg(&crate::scenes::built_in(name).ok()?))),
    }
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

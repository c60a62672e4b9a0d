//! Tables of a page.

use serde::Serialize;

use crate::book::anchor;

use crate::verdict::State;

/// A table.
#[derive(Debug, Clone, Serialize)]
pub struct Table {
    /// Its caption.
    pub title: String,
    /// Names that span several columns, with their number of columns; may be empty.
    pub groups: Vec<(String, usize)>,
    /// Names of the columns with units.
    pub head: Vec<String>,
    /// Rows; the first cell of a row names it.
    pub rows: Vec<Vec<Cell>>,
    /// A note below it.
    pub note: String,
    /// Whether its cells hold sentences rather than numbers.
    pub words: bool,
}

impl Table {
    /// A table without names over its columns.
    pub fn new(title: impl Into<String>, head: &[&str], rows: Vec<Vec<Cell>>, note: &str) -> Self {
        let head = head.iter().map(|h| (*h).to_owned()).collect();
        Self { title: title.into(), groups: Vec::new(), head, rows, note: note.to_owned(), words: false }
    }

    /// With sentences in its cells.
    pub fn words(self) -> Self {
        Self { words: true, ..self }
    }
}

/// A cell of a table.
#[derive(Debug, Clone, Serialize)]
pub struct Cell {
    /// Its text.
    pub text: String,
    /// A remark in small letters below the text.
    pub small: String,
    /// Its class: empty, `good`, `warn`, `bad` or `paper` (the paper's own setting).
    pub mark: &'static str,
    /// Target of a link; empty for none.
    pub link: String,
    /// Anchor of its place on the page; empty for none.
    pub id: String,
    /// Whether the text is shown as a badge.
    pub badge: bool,
    /// Whether the text may hold links and code, as texts of a [`super::Block`] may.
    pub prose: bool,
}

impl Cell {
    /// A plain cell.
    pub fn new(text: impl Into<String>) -> Self {
        let empty = String::new;
        Self { text: text.into(), small: empty(), mark: "", link: empty(), id: empty(), badge: false, prose: false }
    }

    /// A badge: a verdict with the class of its colour.
    pub fn badge(text: impl Into<String>, mark: &'static str) -> Self {
        Self { mark, badge: true, ..Self::new(text) }
    }

    /// The badge of a state.
    pub fn state(state: State) -> Self {
        Self::badge(state.word(), state.mark())
    }

    /// A cell whose text may hold `code` between backticks and links as `[text](target)`.
    pub fn prose(text: impl Into<String>) -> Self {
        Self { prose: true, ..Self::new(text) }
    }

    /// With a remark and a class.
    pub fn marked(self, small: impl Into<String>, mark: &'static str) -> Self {
        Self { small: small.into(), mark, ..self }
    }

    /// With a remark in small letters.
    pub fn small(self, small: impl Into<String>) -> Self {
        Self { small: small.into(), ..self }
    }

    /// The cell with the anchor of a name, which links lead to.
    pub fn anchored(self, name: &str) -> Self {
        Self { id: anchor(name), ..self }
    }

    /// With a link.
    pub fn linked(self, link: &str) -> Self {
        Self { link: link.to_owned(), ..self }
    }
}

//! Every number at every entry: `history.csv`. A row stands for its entry and all that follow, until the next of its number:
//! most numbers never change, and the row of one that does names the commit that moved it.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use mpm_core::scene::read_text;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::experiment::number::Number;

/// Name of the file.
pub const NAME: &str = "history.csv";
/// The number that every entry has: how many others had moved.
pub const ENTRY: (&str, &str) = ("nightly", "moved");
/// No file of this kind is larger, bytes.
const LARGEST: u64 = 1 << 30;

/// A row of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// When, UTC.
    pub date: String,
    /// With which commit.
    pub commit: String,
    /// Of what.
    pub case: String,
    /// Which number.
    pub quantity: String,
    /// The number from this entry on; nothing if it could not be had.
    pub value: Option<f64>,
}

/// All entries, and the numbers that changed at each.
#[derive(Debug, Clone, Default)]
pub struct History {
    /// Date and commit of every entry, in the order in which they were made.
    pub entries: Vec<String>,
    /// For each case and quantity: number of the entry, and value from it on.
    series: HashMap<(String, String), Vec<(usize, f64)>>,
    /// Rows that are not in the file yet.
    new: Vec<Row>,
}

impl History {
    /// Reads a file; nothing if there is none.
    ///
    /// # Errors
    /// A file that is not such a table: file, line, expected and found.
    pub fn read(path: &Path) -> Result<Self, Error> {
        match fs::metadata(path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Self::default()),
            Err(e) => return Err(Error::at(path)(e)),
            Ok(_) => {}
        }
        let text = read_text(path, LARGEST).map_err(Error::at(path))?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// File, line, expected and found.
    pub fn parse(text: &str, file: &str) -> Result<Self, Error> {
        let mut history = Self::default();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        for row in reader.deserialize() {
            let columns = "date,commit,case,quantity,value";
            let row: Row = row.map_err(|source| Error::Row { file: file.to_owned(), columns, source })?;
            let entry = format!("{} {}", row.date, row.commit);
            if history.entries.last() != Some(&entry) {
                history.entries.push(entry);
            }
            let number = history.entries.len() - 1;
            history.enter(row.case, row.quantity, number, row.value.unwrap_or(f64::NAN));
        }
        Ok(history)
    }

    fn enter(&mut self, case: String, quantity: String, entry: usize, value: f64) {
        self.series.entry((case, quantity)).or_default().push((entry, value));
    }

    /// Adds an entry with its numbers; `entry` is its date and commit with a space between them.
    pub fn note(&mut self, entry: &str, measures: &[Number]) {
        self.entries.push(entry.to_owned());
        let number = self.entries.len() - 1;
        let (date, commit) = entry.split_once(' ').unwrap_or((entry, ""));
        for m in measures {
            let known = self.last(&m.case, &m.quantity);
            let same = known.is_some_and(|value| value.to_bits() == m.value.to_bits());
            if same && (m.case.as_str(), m.quantity.as_str()) != ENTRY {
                continue;
            }
            self.enter(m.case.clone(), m.quantity.clone(), number, m.value);
            self.new.push(Row {
                date: date.to_owned(),
                commit: commit.to_owned(),
                case: m.case.clone(),
                quantity: m.quantity.clone(),
                value: Some(m.value).filter(|v| !v.is_nan()),
            });
        }
    }

    /// The file with the new rows after those that it has.
    ///
    /// # Errors
    /// A file that cannot be read; a row that cannot be written.
    pub fn text(&self, path: &Path) -> Result<Vec<u8>, Error> {
        let known = match fs::read(path) {
            Ok(known) => known,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(e) => return Err(Error::at(path)(e)),
        };
        let header = known.is_empty();
        let mut writer = csv::WriterBuilder::new().has_headers(header).from_writer(known);
        for row in &self.new {
            writer.serialize(row).map_err(Error::at(path))?;
        }
        writer.into_inner().map_err(|e| Error::at(path)(e.into_error()))
    }

    /// The last value of a number.
    pub fn last(&self, case: &str, quantity: &str) -> Option<f64> {
        self.steps(case, quantity).last().map(|(_, value)| *value)
    }

    /// Values of a number at the last entries, at most so many, from the first that has it.
    pub fn values(&self, case: &str, quantity: &str, most: usize) -> Vec<f64> {
        let steps = self.steps(case, quantity);
        let at = |entry: usize| steps.iter().rev().find(|(from, _)| *from <= entry).map(|(_, value)| *value);
        (self.entries.len().saturating_sub(most)..self.entries.len()).filter_map(at).collect()
    }

    /// Entries at which a number changed, with its values.
    pub fn steps(&self, case: &str, quantity: &str) -> &[(usize, f64)] {
        let key = (case.to_owned(), quantity.to_owned());
        self.series.get(&key).map_or(&[], Vec::as_slice)
    }

    /// All numbers, by case and quantity.
    pub fn numbers(&self) -> Vec<(&str, &str)> {
        let mut names: Vec<(&str, &str)> = self.series.keys().map(|(c, q)| (c.as_str(), q.as_str())).collect();
        names.sort_unstable();
        names
    }

    /// The entry from which on a number has been off without a break, if it is now.
    pub fn off_since(&self, case: &str, quantity: &str, holds: &dyn Fn(f64) -> bool) -> Option<String> {
        let steps = self.steps(case, quantity);
        let last_good = steps.iter().rposition(|(_, value)| holds(*value));
        let first_off = steps.get(last_good.map_or(0, |at| at + 1))?;
        self.entries.get(first_off.0).cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::number::{Label, Tolerance};

    fn measure(case: &str, value: f64) -> Number {
        Number::new(case, "error", Label::Verified, value, Tolerance::relative(0.0))
    }

    #[test]
    fn only_changes_are_written_and_the_file_says_all() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(NAME);
        let mut count = Number::new(ENTRY.0, ENTRY.1, Label::Count, 0.0, Tolerance::relative(0.0));
        for (number, value) in [1.0, 1.0, 2.0, f64::NAN, 2.0].into_iter().enumerate() {
            let mut history = History::read(&path).expect("a history");
            assert_eq!(history.entries.len(), number);
            count.value = 0.0;
            history.note(
                &format!("2026-01-0{} c{number}", number + 1),
                &[measure("a", value), measure("b", 7.0), count.clone()],
            );
            fs::write(&path, history.text(&path).expect("a text")).expect("written");
        }
        let history = History::read(&path).expect("a history");
        let text = fs::read_to_string(&path).expect("a text");
        assert_eq!(text.lines().count(), 1 + 5 + 4 + 1, "{text}");
        assert!(text.starts_with("date,commit,case,quantity,value\n2026-01-01,c0,a,error,1.0\n"));
        let steps: Vec<usize> = history.steps("a", "error").iter().map(|(entry, _)| *entry).collect();
        assert_eq!(steps, [0, 2, 3, 4]);
        assert_eq!((history.last("b", "error"), history.entries.len()), (Some(7.0), 5));
        assert_eq!((history.values("b", "error", 3), history.values("c", "error", 3)), (vec![7.0; 3], vec![]));
        let values = format!("{:?}", history.values("a", "error", 9));
        assert_eq!(values, "[1.0, 1.0, 2.0, NaN, 2.0]");
        let since = |good: f64| history.off_since("a", "error", &|value| value == good);
        assert_eq!(since(1.0).as_deref(), Some("2026-01-03 c2"));
        assert_eq!(since(2.0), None);
        assert_eq!(since(5.0).as_deref(), Some("2026-01-01 c0"));
        let error =
            History::parse("date,commit,case,quantity,value\na,b,c,d,e\n", NAME).expect_err("refused").to_string();
        assert!(error.starts_with("history.csv:2: expected date,commit"), "{error}");
    }
}

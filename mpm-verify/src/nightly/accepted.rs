//! The accepted numbers: `reference-data/baselines/nightly.csv`, and how they are renewed.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use mpm_core::scene::read_text;
use serde::{Deserialize, Serialize};

use super::measure::{Label, Measure, Tolerance};
use crate::baseline::FOLDER;
use crate::error::Error;
use crate::files;

/// Name of the file.
pub const NAME: &str = "nightly.csv";
/// As it was when the program was built.
const BUILT_IN: &str = include_str!("../../../reference-data/baselines/nightly.csv");
/// No file of this kind is larger, bytes.
const LARGEST: u64 = 64 << 20;

/// An accepted number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Accepted {
    /// Of what.
    pub case: String,
    /// Which number.
    pub quantity: String,
    /// What it is held against.
    pub label: Label,
    /// The number.
    pub value: f64,
    /// How far it may move, as a share of it.
    pub relative: f64,
    /// How far in its own unit.
    pub absolute: f64,
    /// When it was accepted, and with which commit.
    pub since: String,
    /// Why.
    pub why: String,
}

impl Accepted {
    /// How far it may move.
    pub fn tolerance(&self) -> Tolerance {
        Tolerance { relative: self.relative, absolute: self.absolute }
    }
}

/// First lines of the file.
const HEAD: &str = "\
# What `mpm-verify nightly` has measured when it was last accepted; renewed by `mpm-verify nightly --accept WHY`.
# verified: against an exact solution. regression: against this code itself. count: work, in counts.
";

/// The accepted numbers of a folder; those of the source tree where there are any, or else those that were built in.
///
/// # Errors
/// A file that is not such a table: file, line, expected and found.
pub fn read(folder: Option<&Path>) -> Result<(Vec<Accepted>, Option<PathBuf>), Error> {
    let own = folder.unwrap_or(Path::new(FOLDER)).join(NAME);
    match fs::metadata(&own) {
        Ok(_) => {
            let text = read_text(&own, LARGEST).map_err(Error::at(&own))?;
            Ok((parse(&text, &own.display().to_string())?, Some(own)))
        }
        Err(e) if folder.is_none() && e.kind() == ErrorKind::NotFound => {
            Ok((parse(BUILT_IN, &format!("built-in {NAME}"))?, None))
        }
        Err(e) => Err(Error::at(own)(e)),
    }
}

/// Reads the text of the file.
///
/// # Errors
/// File, line, expected and found.
pub fn parse(text: &str, file: &str) -> Result<Vec<Accepted>, Error> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let mut rows: Vec<Accepted> = Vec::new();
    for row in reader.deserialize() {
        let columns = "case,quantity,label,value,relative,absolute,since,why";
        let row: Accepted = row.map_err(|source| Error::Row { file: file.to_owned(), columns, source })?;
        if !(row.relative >= 0.0 && row.absolute >= 0.0) {
            let found = format!("{} and {}", row.relative, row.absolute);
            let key = format!("{file}: {} {}", row.case, row.quantity);
            return Err(Error::refused(key, "tolerances of 0 or more", found));
        }
        rows.push(row);
    }
    let mut names: Vec<(&str, &str)> = rows.iter().map(|r| (r.case.as_str(), r.quantity.as_str())).collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(Error::refused(file, "every number once", format!("{} {} twice", pair[0].0, pair[0].1))),
        None => Ok(rows),
    }
}

/// What a night makes of the accepted numbers.
#[derive(Debug, PartialEq)]
pub struct Renewed {
    /// The rows, in their order; a new one stands behind that which is measured before it.
    pub rows: Vec<Accepted>,
    /// Rows that are new or have moved.
    pub new: usize,
    /// Rows that are there no more.
    pub gone: usize,
}

/// The accepted numbers with those of a night in their place. A number that has not moved keeps its row; a tolerance is that of the
/// program; a row that was not measured stays unless it `goes`.
pub fn renewed(
    known: &[Accepted],
    measures: &[Measure],
    (date, commit): (&str, &str),
    why: &str,
    goes: impl Fn(&Accepted) -> bool,
) -> Renewed {
    let measures = || measures.iter().filter(|m| m.label != Label::Time && !m.value.is_nan());
    let measured = |row: &Accepted| measures().any(|m| m.is_of(&row.case, &row.quantity));
    let mut rows: Vec<Accepted> = known.iter().filter(|row| measured(row) || !goes(row)).cloned().collect();
    let gone = known.len() - rows.len();
    let (mut new, mut next) = (0, rows.len());
    for m in measures() {
        let place = rows.iter().position(|row| m.is_of(&row.case, &row.quantity));
        let Measure { case, quantity, label, value, tolerance: Tolerance { relative, absolute } } = m.clone();
        if let Some(row) =
            place.map(|i| &mut rows[i]).filter(|row| row.tolerance().holds(row.value, value) && row.label == label)
        {
            (row.relative, row.absolute) = (relative, absolute);
        } else {
            new += 1;
            let (since, why) = (format!("{date} {commit}"), why.to_owned());
            let row = Accepted { case, quantity, label, value, relative, absolute, since, why };
            match place {
                Some(i) => rows[i] = row,
                None => rows.insert(next, row),
            }
        }
        next = place.unwrap_or(next) + 1;
    }
    Renewed { rows, new, gone }
}

/// Writes the file.
///
/// # Errors
/// What the system says.
pub fn write(rows: &[Accepted], path: &Path) -> Result<(), Error> {
    let text = text(rows).map_err(Error::at(path))?;
    files::write(path, text.as_bytes()).map_err(Error::at(path))
}

/// The text of the file.
fn text(rows: &[Accepted]) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let bytes = writer.into_inner().unwrap_or_default();
    Ok(HEAD.to_owned() + &String::from_utf8_lossy(&bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measure(case: &str, value: f64) -> Measure {
        Measure::new(case, "error", Label::Verified, value, Tolerance::relative(1e-6))
    }

    #[test]
    fn the_built_in_file_holds() {
        let rows = parse(BUILT_IN, NAME).expect("it holds");
        assert!(rows.len() > 500, "{} rows", rows.len());
        assert!(rows.iter().all(|row| !row.since.is_empty() && !row.why.is_empty() && row.label != Label::Time));
        let of = |label| rows.iter().filter(|row| row.label == label).count();
        assert!(of(Label::Verified) > 100 && of(Label::Regression) > 100 && of(Label::Count) > 100);
    }

    #[test]
    fn only_what_has_moved_gets_a_new_reason() {
        let all = |_: &Accepted| true;
        let Renewed { rows: first, new, .. } =
            renewed(&[], &[measure("a", 1.0), measure("b", 2.0), measure("e", 4.0)], ("d1", "c1"), "the first", all);
        assert_eq!(new, 3);
        let night = [measure("a", 1.0 + 1e-9), measure("c", 3.0), measure("b", 2.5), measure("e", f64::NAN)];
        let told = |second: &Renewed| {
            let row = |row: &Accepted| format!("{} {} {} {}", row.case, row.value, row.since, row.why);
            second.rows.iter().map(row).collect::<Vec<_>>()
        };
        let second = renewed(&first, &night, ("d2", "c2"), "better", all);
        assert_eq!((second.new, second.gone), (2, 1));
        let three = ["a 1 d1 c1 the first", "c 3 d2 c2 better", "b 2.5 d2 c2 better"];
        assert_eq!(told(&second), three);
        let part = renewed(&first, &night[3..], ("d2", "c2"), "better", |row| row.case != "e");
        assert_eq!(told(&part), ["e 4 d1 c1 the first"]);
        let part = renewed(&first, &night, ("d2", "c2"), "better", |_| false);
        assert_eq!(
            (part.new, part.gone, &told(&part)[..3], part.rows[3].case.as_str()),
            (2, 0, &three.map(str::to_owned)[..], "e")
        );
        let second = second.rows;
        assert_eq!(parse(&text(&second).expect("a text"), NAME).expect("it holds"), second);
    }

    #[test]
    fn what_is_no_such_table_is_refused_with_its_line() {
        let head = "case,quantity,label,value,relative,absolute,since,why\n";
        let row = "a,error,verified,1.0,1e-6,0,d c,why\n";
        assert_eq!(parse(&format!("{head}{row}"), NAME).expect("it holds").len(), 1);
        for (rows, words) in [
            (format!("{row}{row}"), "a error twice"),
            (row.replace("1e-6", "-1"), "tolerances of 0 or more"),
            (row.replace("1e-6", "NaN"), "tolerances of 0 or more"),
            (row.replace("verified", "true"), "2: expected case,quantity"),
            (row.replace("1.0", "one"), "2: expected case,quantity"),
        ] {
            let error = parse(&format!("{head}{rows}"), NAME).expect_err("refused").to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}

//! The accepted numbers: `reference-data/baselines/nightly.csv`, and how they are renewed.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::measure::{Label, Measure, Tolerance};
use crate::files;

/// Name of the file.
pub const NAME: &str = "nightly.csv";
/// Where it is in the source tree.
pub const FOLDER: &str = "reference-data/baselines";
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
pub fn read(folder: Option<&Path>) -> Result<(Vec<Accepted>, Option<PathBuf>), String> {
    let own = folder.unwrap_or(Path::new(FOLDER)).join(NAME);
    match fs::metadata(&own) {
        Ok(file) if file.len() > LARGEST => {
            Err(format!("{}: expected less than {LARGEST} bytes, found {}", own.display(), file.len()))
        }
        Ok(_) => {
            let text = fs::read_to_string(&own).map_err(|e| format!("{}: {e}", own.display()))?;
            Ok((parse(&text).map_err(|e| format!("{}:{e}", own.display()))?, Some(own)))
        }
        Err(e) if folder.is_none() && e.kind() == ErrorKind::NotFound => {
            Ok((parse(BUILT_IN).map_err(|e| format!("built-in {NAME}:{e}"))?, None))
        }
        Err(e) => Err(format!("{}: {e}", own.display())),
    }
}

/// Reads the text of the file.
///
/// # Errors
/// Line, expected and found.
pub fn parse(text: &str) -> Result<Vec<Accepted>, String> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let mut rows: Vec<Accepted> = Vec::new();
    for row in reader.deserialize() {
        let row: Accepted = row.map_err(|e| {
            let line = e.position().map_or(0, csv::Position::line);
            format!("{line}: expected case,quantity,label,value,relative,absolute,since,why, found: {e}")
        })?;
        if !(row.relative >= 0.0 && row.absolute >= 0.0) {
            let found = format!("{} and {}", row.relative, row.absolute);
            return Err(format!(" {} {}: expected tolerances of 0 or more, found {found}", row.case, row.quantity));
        }
        rows.push(row);
    }
    let mut names: Vec<(&str, &str)> = rows.iter().map(|r| (r.case.as_str(), r.quantity.as_str())).collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(format!(" expected every number once, found {} {} twice", pair[0].0, pair[0].1)),
        None => Ok(rows),
    }
}

/// The accepted numbers with those of a night in their place, and how many are new. A number that has not moved keeps its
/// row; a tolerance is that of the program.
pub fn renewed(
    known: &[Accepted],
    measures: &[Measure],
    (date, commit): (&str, &str),
    why: &str,
) -> (Vec<Accepted>, usize) {
    let mut new = 0;
    let rows = measures
        .iter()
        .filter(|m| m.label != Label::Time && !m.value.is_nan())
        .map(|m| {
            let old = known.iter().find(|row| m.is_of(&row.case, &row.quantity));
            let same = old.filter(|row| row.tolerance().holds(row.value, m.value) && row.label == m.label);
            let Measure { case, quantity, label, value, tolerance: Tolerance { relative, absolute } } = m.clone();
            if let Some(row) = same {
                return Accepted { relative, absolute, ..row.clone() };
            }
            new += 1;
            let (since, why) = (format!("{date} {commit}"), why.to_owned());
            Accepted { case, quantity, label, value, relative, absolute, since, why }
        })
        .collect();
    (rows, new)
}

/// Writes the file.
///
/// # Errors
/// What the system says.
pub fn write(rows: &[Accepted], path: &Path) -> Result<(), String> {
    let text = text(rows).map_err(|e| format!("{}: {e}", path.display()))?;
    files::write(path, text.as_bytes()).map_err(|e| format!("{}: {e}", path.display()))
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
        let rows = parse(BUILT_IN).expect("it holds");
        assert!(rows.len() > 500, "{} rows", rows.len());
        assert!(rows.iter().all(|row| !row.since.is_empty() && !row.why.is_empty() && row.label != Label::Time));
        let of = |label| rows.iter().filter(|row| row.label == label).count();
        assert!(of(Label::Verified) > 100 && of(Label::Regression) > 100 && of(Label::Count) > 100);
    }

    #[test]
    fn only_what_has_moved_gets_a_new_reason() {
        let (first, new) = renewed(&[], &[measure("a", 1.0), measure("b", 2.0)], ("d1", "c1"), "the first");
        assert_eq!(new, 2);
        let night = [measure("a", 1.0 + 1e-9), measure("b", 2.5), measure("c", 3.0), measure("d", f64::NAN)];
        let (second, new) = renewed(&first, &night, ("d2", "c2"), "better");
        assert_eq!((new, second.len()), (2, 3));
        let told: Vec<(f64, &str, &str)> =
            second.iter().map(|row| (row.value, row.since.as_str(), row.why.as_str())).collect();
        assert_eq!(told, [(1.0, "d1 c1", "the first"), (2.5, "d2 c2", "better"), (3.0, "d2 c2", "better")]);
        assert_eq!(parse(&text(&second).expect("a text")).expect("it holds"), second);
    }

    #[test]
    fn what_is_no_such_table_is_refused_with_its_line() {
        let head = "case,quantity,label,value,relative,absolute,since,why\n";
        let row = "a,error,verified,1.0,1e-6,0,d c,why\n";
        assert_eq!(parse(&format!("{head}{row}")).map(|rows| rows.len()), Ok(1));
        for (rows, words) in [
            (format!("{row}{row}"), "a error twice"),
            (row.replace("1e-6", "-1"), "tolerances of 0 or more"),
            (row.replace("1e-6", "NaN"), "tolerances of 0 or more"),
            (row.replace("verified", "true"), "2: expected case,quantity"),
            (row.replace("1.0", "one"), "2: expected case,quantity"),
        ] {
            let error = parse(&format!("{head}{rows}")).expect_err("refused");
            assert!(error.contains(words), "{error}");
        }
    }
}

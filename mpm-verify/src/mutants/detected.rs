//! Which checks have detected which fault: `reference-data/baselines/detected.csv`, which `mpm-verify mutants --record` writes. Searches
//! ask these checks first.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::cases::suite;
use crate::error::Error;
use crate::files;

/// The file, from the root of the source.
pub const FILE: &str = "reference-data/baselines/detected.csv";
/// Text of the file when the program was built.
const BUILT_IN: &str = include_str!("../../../reference-data/baselines/detected.csv");

/// A row of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Detected {
    /// Name of the fault.
    pub fault: String,
    /// Whether every check was asked, so that the others do not detect it.
    pub all: bool,
    /// Names of the checks, cheapest first: cases of the suite and counts of work.
    pub by: Vec<String>,
}

/// The row as it is written.
#[derive(Debug, Serialize, Deserialize)]
struct Written {
    fault: String,
    all_checks_run: bool,
    detected_by: String,
}

impl Detected {
    /// Notes what checks have detected. Without `all` they are the first that did so, and those that are known and come before them did
    /// not.
    pub fn note(known: &mut Vec<Self>, fault: &str, all: bool, by: Vec<String>) {
        let cost =
            |name: &String| suite().iter().find(|case| case.name == name).map_or(f64::INFINITY, |case| case.cost());
        match known.iter_mut().find(|row| row.fault == fault) {
            Some(row) if !all && let Some(first) = row.by.iter().position(|name| by.contains(name)) => {
                row.all &= first == 0;
                row.by.drain(..first);
            }
            Some(row) => (row.all, row.by) = (all, by),
            None => known.push(Self { fault: fault.to_owned(), all, by }),
        }
        for row in known.iter_mut().filter(|row| row.fault == fault) {
            row.by.sort_by(|a, b| cost(a).total_cmp(&cost(b)).then_with(|| a.cmp(b)));
            row.by.dedup();
        }
        known.sort_by(|a, b| a.fault.cmp(&b.fault));
    }

    /// The rows that the program was built with.
    pub fn built_in() -> Vec<Self> {
        // A test reads them.
        parse(BUILT_IN, FILE).unwrap_or_default()
    }

    /// The rows of a source tree; none without the file.
    ///
    /// # Errors
    /// A file that is not such a table.
    pub fn read(source: &Path) -> Result<Vec<Self>, Error> {
        let path = source.join(FILE);
        fs::read_to_string(&path).map_or_else(|_| Ok(Vec::new()), |text| parse(&text, &path.display().to_string()))
    }

    /// Writes the rows to a source tree, if they are others. Returns whether they were.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(rows: &[Self], source: &Path) -> Result<bool, Error> {
        if Self::read(source)? == rows {
            return Ok(false);
        }
        let path = source.join(FILE);
        let mut writer = csv::Writer::from_writer(Vec::new());
        for Self { fault, all, by } in rows {
            let row = Written { fault: fault.clone(), all_checks_run: *all, detected_by: by.join(" ") };
            writer.serialize(row).map_err(Error::at(&path))?;
        }
        files::write(&path, &writer.into_inner().unwrap_or_default()).map_err(Error::at(&path))?;
        Ok(true)
    }
}

/// Faults that a case alone detects, of those for which every check was asked.
pub fn alone(rows: &[Detected], case: &str) -> Vec<String> {
    rows.iter().filter(|row| row.all && row.by == [case]).map(|row| row.fault.clone()).collect()
}

fn parse(text: &str, file: &str) -> Result<Vec<Detected>, Error> {
    let row = |row: Result<Written, csv::Error>| {
        let columns = "fault,all_checks_run,detected_by";
        let row = row.map_err(|source| Error::Row { file: file.to_owned(), columns, source })?;
        let by = row.detected_by.split_whitespace().map(str::to_owned).collect();
        Ok(Detected { fault: row.fault, all: row.all_checks_run, by })
    };
    csv::Reader::from_reader(text.as_bytes()).deserialize().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mutants::patches::mutants;

    #[test]
    fn the_built_in_table_names_faults_and_checks() {
        let rows = parse(BUILT_IN, FILE).expect("a table");
        let faults = mutants().expect("patches");
        for row in &rows {
            assert!(faults.iter().any(|fault| fault.name == row.fault), "{}: obsolete", row.fault);
            for check in row.by.iter().filter(|check| !check.starts_with("work")) {
                assert!(suite().iter().any(|case| case.name == check), "{}: {check}", row.fault);
            }
        }
    }

    #[test]
    fn checks_are_noted_in_the_order_of_their_cost_and_read_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        fs::create_dir_all(root.join(FILE).parent().expect("a folder")).expect("a folder");
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let mut rows = Detected::read(root).expect("none yet");
        Detected::note(&mut rows, "b", true, names(&["work-dry-bar", "capillary-dam", "hydrostatic"]));
        Detected::note(&mut rows, "a", true, names(&["strip"]));
        assert_eq!(rows[1].by, ["hydrostatic", "capillary-dam", "work-dry-bar"]);
        Detected::note(&mut rows, "b", false, names(&["hydrostatic"]));
        assert!(rows[1].all && rows[1].by.len() == 3);
        Detected::note(&mut rows, "b", false, names(&["capillary-dam"]));
        assert_eq!((rows[1].all, rows[1].by.len()), (false, 2));
        assert!(Detected::write(&rows, root).expect("written") && !Detected::write(&rows, root).expect("the same"));
        assert_eq!(Detected::read(root).expect("a table"), rows);
        assert_eq!((alone(&rows, "strip"), alone(&rows, "hydrostatic")), (names(&["a"]), Vec::new()));
    }
}

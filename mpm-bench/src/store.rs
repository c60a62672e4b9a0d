//! What is done stays done: every visit is a line of `store.jsonl`, written when it ends.
//!
//! A line belongs to a build and to the input of its case. Times of another build are not taken over: they are of
//! another program.

use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::measure::Times;
use crate::row::{Found, Row};

/// A line of the store.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Line {
    /// Build that it was measured with.
    build: String,
    /// Name of the case.
    case: String,
    /// Hash of what the case is made of.
    input: String,
    /// Which visit, from 0.
    visit: usize,
    /// What was found; of the first visit only.
    found: Option<Found>,
    /// CPU time per run of each sample, s.
    samples: Vec<f64>,
    /// Runs in all samples.
    runs: u64,
}

/// All visits of a case.
#[derive(Debug, Clone, Default, PartialEq)]
struct Kept {
    input: String,
    found: Option<Found>,
    visits: Vec<Times>,
}

/// Finished visits, in memory and on disk.
#[derive(Debug)]
pub struct Store {
    file: File,
    build: String,
    cases: HashMap<String, Kept>,
    /// What was found in the file when it was opened.
    pub opened: Opened,
}

/// What an existing file gave.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Opened {
    /// Visits taken over.
    pub kept: usize,
    /// Visits of another build.
    pub foreign: usize,
    /// Lines that cannot be read, as a kill in the middle of one leaves.
    pub broken: usize,
}

impl Opened {
    /// A sentence for each thing worth saying.
    pub fn notes(&self) -> Vec<String> {
        let says = [
            (self.kept, "visits taken over from an earlier run of this build"),
            (self.foreign, "stored visits are of another build and are measured again"),
            (self.broken, "stored lines could not be read, as after a kill, and are measured again"),
        ];
        says.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}.")).collect()
    }
}

impl Store {
    /// Opens or makes a store for a build; forgets what is in it if `fresh`.
    ///
    /// # Errors
    /// A file that cannot be read or written.
    pub fn open(path: &Path, build: &str, fresh: bool) -> io::Result<Self> {
        let text = match fs::read(path) {
            Ok(bytes) if !fresh => String::from_utf8_lossy(&bytes).into_owned(),
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
            _ => String::new(),
        };
        let (mut opened, mut good, mut cases) = (Opened::default(), String::new(), HashMap::new());
        for line in text.lines() {
            match serde_json::from_str::<Line>(line) {
                Err(_) => opened.broken += 1,
                Ok(read) if read.build != build => opened.foreign += 1,
                Ok(read) => {
                    opened.kept += 1;
                    good += line;
                    good.push('\n');
                    enter(&mut cases, read);
                }
            }
        }
        // Written anew, so that nothing is appended to half a line.
        let fresh_file = path.with_extension("jsonl.new");
        fs::write(&fresh_file, good)?;
        fs::rename(&fresh_file, path)?;
        let file = OpenOptions::new().append(true).open(path)?;
        Ok(Self { file, build: build.to_owned(), cases, opened })
    }

    /// Visits of a case that are done, if its input is still the same.
    pub fn visits(&self, case: &str, input: &str) -> usize {
        self.cases.get(case).filter(|k| k.input == input && k.found.is_some()).map_or(0, |k| k.visits.len())
    }

    /// Keeps a visit. `found` is given at the first one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&mut self, case: &str, input: &str, found: Option<Found>, times: Times) -> io::Result<()> {
        let line = Line {
            build: self.build.clone(),
            case: case.to_owned(),
            input: input.to_owned(),
            visit: self.visits(case, input),
            found,
            samples: times.samples,
            runs: times.runs,
        };
        let mut text = serde_json::to_string(&line)?;
        text.push('\n');
        self.file.write_all(text.as_bytes())?;
        enter(&mut self.cases, line);
        Ok(())
    }

    /// The row of a case; `None` where it was not run.
    pub fn row(&self, case: &str) -> Option<Row> {
        let kept = self.cases.get(case)?;
        let mut samples: Vec<f64> = kept.visits.iter().flat_map(|v| v.samples.iter().copied()).collect();
        samples.sort_by(f64::total_cmp);
        Some(Row::new(case, kept.found.as_ref()?, &samples, kept.visits.iter().map(|v| v.runs).sum()))
    }
}

fn enter(cases: &mut HashMap<String, Kept>, line: Line) {
    let kept = cases.entry(line.case).or_default();
    if line.found.is_some() {
        // A first visit begins anew: an input may have changed within a build, as between two tests of it.
        *kept = Kept { input: line.input, found: line.found, visits: Vec::new() };
    }
    kept.visits.push(Times { samples: line.samples, runs: line.runs });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found() -> Found {
        let json = r#"{"integrator":"explicit","scheme":"centre","mesh_m":0.1,"ppc":4,"dt_or_tol":1e-6,
            "max_error_terzaghi":0.1,"max_error_compressible":0.2,"steps":1,"solves":0,"peak_bytes":1,"particles":1,
            "dimension":"column","method":"","failure":null}"#;
        serde_json::from_str(json).expect("a record")
    }

    fn times(of: &[f64]) -> Times {
        Times { samples: of.to_vec(), runs: of.len() as u64 }
    }

    #[test]
    fn a_sweep_goes_on_where_it_ended_and_half_a_line_does_no_harm() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("store.jsonl");
        let mut store = Store::open(&path, "one", false).expect("a store");
        store.keep("a", "x", Some(found()), times(&[3.0, 1.0])).expect("kept");
        store.keep("a", "x", None, times(&[2.0])).expect("kept");
        store.keep("b", "y", Some(found()), times(&[1.0])).expect("kept");
        drop(store);
        let text = fs::read_to_string(&path).expect("a file");
        fs::write(&path, &text[..text.len() - 20]).expect("cut short");

        let mut store = Store::open(&path, "one", false).expect("a store");
        assert_eq!(store.opened, Opened { kept: 2, foreign: 0, broken: 1 });
        assert!(store.opened.notes().iter().any(|n| n.contains("after a kill")));
        assert_eq!((store.visits("a", "x"), store.visits("b", "y")), (2, 0));
        assert_eq!(store.visits("a", "other"), 0, "a case with another input is another case");
        let row = store.row("a").expect("a row");
        assert_eq!((row.cpu_s, row.cpu_low_s, row.cpu_high_s, row.runs), (2.0, 1.0, 3.0, 3));
        store.keep("b", "y", Some(found()), times(&[1.0])).expect("kept");
        drop(store);
        assert_eq!(Store::open(&path, "one", false).expect("a store").opened.kept, 3, "whole lines again");
    }

    #[test]
    fn another_build_and_a_fresh_start_take_nothing_over() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("store.jsonl");
        let kept = || {
            let mut store = Store::open(&path, "one", true).expect("a store");
            store.keep("a", "x", Some(found()), times(&[1.0])).expect("kept");
        };
        kept();
        let other = Store::open(&path, "two", false).expect("a store");
        assert_eq!((other.opened.foreign, other.visits("a", "x")), (1, 0));
        kept();
        assert_eq!(Store::open(&path, "one", true).expect("a store").opened, Opened::default());
    }
}

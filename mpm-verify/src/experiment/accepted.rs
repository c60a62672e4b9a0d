//! The accepted numbers: `reference-data/baselines/accepted.csv`, how a case is held against its own, and how they are renewed.
//!
//! The truth is checked by the suite itself; these say whether a change of the code has moved a number. A case that still holds, but
//! whose error has grown, has lost something; one whose error has fallen computes something else than it did, and asks to be accepted
//! as well. A night holds every number within its own tolerance; `check` lets an error move by [`GROWTH`].

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use mpm_core::scene::read_text;
use serde::{Deserialize, Serialize};

use super::number::{Label, Number, Tolerance};
use super::verdict::{CaseRow, Judged};
use crate::error::Error;
use crate::files;
use crate::provenance::require_clean;

/// Where the file is kept, from the root of the source.
pub const FOLDER: &str = "reference-data/baselines";
/// Name of the file.
pub const NAME: &str = "accepted.csv";
/// As it was when the program was built.
const BUILT_IN: &str = include_str!("../../../reference-data/baselines/accepted.csv");
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

/// Errors of cases may grow to this share of the accepted one, or fall to one over it: what other processors and compilers round
/// differently is far less.
pub const GROWTH: f64 = 1.02;
/// Absolute change of an error that is the round-off of linear solves.
pub(crate) const SOLVED: f64 = 1e-9;
/// Errors that follow from the scene alone differ in their last digits.
pub(crate) const LAST_DIGITS: f64 = 1e-6;
/// Fitted orders move with the last digits of the smallest errors.
pub(crate) const ORDER: Tolerance = Tolerance { relative: 0.0, absolute: 0.01 };
/// The numbers of a file, in place of those that were built in.
static READ: OnceLock<Vec<Accepted>> = OnceLock::new();

/// Holds all cases of this process against these numbers.
pub fn hold_against(rows: &[Accepted]) {
    READ.get_or_init(|| rows.to_vec());
}

/// The accepted error of a case.
fn of_case(case: &str) -> Option<Accepted> {
    static OWN: OnceLock<Vec<Accepted>> = OnceLock::new();
    // A test reads what is built in.
    let rows = READ.get().unwrap_or_else(|| OWN.get_or_init(|| parse(BUILT_IN, NAME).unwrap_or_default()));
    rows.iter().find(|row| row.case == case && row.quantity == "error").cloned()
}

/// Holds a case's error against the accepted one: notes both, and lets the case fail if its error has grown or fallen.
pub(crate) fn compare(judged: &mut Judged) {
    if let Some(row) = of_case(&judged.row.case) {
        compare_with(&row, judged);
    }
}

fn compare_with(accepted: &Accepted, judged: &mut Judged) {
    let (error, was) = (judged.row.error, accepted.value);
    judged.row.baseline = Some(was);
    judged.row.change = Some(if error == was { 1.0 } else { error / was }).filter(|c| c.is_finite());
    let most = 100.0 * (GROWTH - 1.0);
    if error > GROWTH * was && error - was > accepted.absolute {
        judged.fail(&format!("it was {was:.3e} (baseline) and may grow by {most:.0} %"));
    }
    if GROWTH * error < was && was - error > accepted.absolute {
        judged.fail(&format!(
            "it was {was:.3e} (baseline) and may fall by {most:.0} %; accept what it is now if you know why"
        ));
    }
}

/// Change of an error that is round-off. Runs whose steps follow from a tolerance are the same up to that: on a processor with shorter
/// vectors the sums of the linear solver have another order, and a step or a basis vector more may be taken. An error below what is left
/// open is round-off itself, and may be anything that the case allows.
fn round_off(error: f64, required: f64, tolerance: f64) -> f64 {
    let solved = SOLVED.max(tolerance);
    if error <= SOLVED { required.max(solved) } else { solved }
}

/// Whether a case follows soil that flows: what runs out of a slope or a column hangs on the last digit.
fn chaotic(case: &str) -> bool {
    ["collapse", "slope", "strip", "block"].iter().any(|start| case.starts_with(start))
}

/// Errors and orders of cases, as they are accepted. An absolute tolerance that someone has widened by hand stays.
pub fn numbers(rows: &[CaseRow]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for row in rows {
        let relative = if chaotic(&row.case) { 0.02 } else { LAST_DIGITS };
        let known = of_case(&row.case).map_or(0.0, |known| known.absolute);
        let absolute = round_off(row.error, row.required_error, row.tolerance).max(known);
        numbers.push(Number::new(&row.case, "error", row.baseline_kind, row.error, Tolerance { relative, absolute }));
        if let Some(order) = row.order {
            numbers.push(Number::new(&row.case, "order", row.baseline_kind, order, ORDER));
        }
    }
    numbers
}

/// First lines of the file.
const HEAD: &str = "\
# What `mpm-verify nightly` and `mpm-verify check` have measured when it was last accepted; renewed by their `--accept WHY`.
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

/// The file to which numbers of a commit are accepted for a reason.
///
/// # Errors
/// No reason, no commit that the program was built from ([`require_clean`]), or no such file.
pub fn target<'a>(why: &str, commit: &str, file: Option<&'a Path>) -> Result<&'a Path, Error> {
    if why.trim().is_empty() {
        return Err(Error::refused("--accept", "a reason", "nothing"));
    }
    require_clean("--accept", commit)?;
    file.ok_or_else(|| Error::refused("--accept", format!("{FOLDER} here, or --baselines DIR"), "neither"))
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

/// The accepted numbers with those of a night in their place. A number that has not moved keeps its row, if that is of a commit; a
/// tolerance is that of the program; a row that was not measured stays unless it `goes`.
pub fn renewed(
    known: &[Accepted],
    measures: &[Number],
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
        let Number { case, quantity, label, value, tolerance: Tolerance { relative, absolute }, .. } = m.clone();
        let stays = |row: &Accepted| {
            let commit = row.since.split_whitespace().last().unwrap_or_default();
            row.tolerance().holds(row.value, value) && row.label == label && require_clean("", commit).is_ok()
        };
        if let Some(row) = place.map(|i| &mut rows[i]).filter(|row| stays(row)) {
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
    use crate::cases::suite;

    fn measure(case: &str, value: f64) -> Number {
        Number::new(case, "error", Label::Verified, value, Tolerance::relative(1e-6))
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
    fn every_case_has_an_accepted_error() {
        for case in suite() {
            let row = of_case(case.name).unwrap_or_else(|| panic!("{}: `check {0} --accept WHY`", case.name));
            assert!(row.value >= 0.0 && row.absolute > 0.0, "{row:?}");
        }
    }

    #[test]
    fn round_off_may_be_anything_that_is_allowed() {
        assert_eq!((round_off(1e-3, 1e-2, 0.0), round_off(1e-12, 1e-10, 0.0)), (SOLVED, SOLVED));
        assert_eq!((round_off(1e-12, 1e-8, 0.0), round_off(1e-3, 1e-2, 1e-7)), (1e-8, 1e-7));
    }

    #[test]
    fn an_error_that_has_moved_lets_its_case_fail() {
        let case = suite().iter().find(|case| case.name == "hydrostatic").expect("a case");
        let judged = case.judged().expect("runs that finish");
        assert!(judged.row.passed(), "{}", judged.reason);
        let error = judged.row.error;
        let with = |value: f64, absolute: f64| {
            let mut judged = judged.clone();
            compare_with(&Accepted { value, absolute, ..of_case("hydrostatic").expect("a row") }, &mut judged);
            judged
        };
        assert!(with(error, 0.0).row.passed() && with(1.01 * error, 0.0).row.passed());
        assert!(with(error / 1.01, 0.0).row.passed() && with(error / 2.0, error).row.passed());
        assert!(with(1.5 * error, error).row.passed());
        let fallen = with(1.03 * error, 0.0);
        assert!(!fallen.row.passed() && fallen.reason.contains("(baseline) and may fall by 2 %"), "{}", fallen.reason);
        let grown = with(error / 1.03, 0.0);
        assert!(!grown.row.passed() && grown.reason.contains("(baseline) and may grow by 2 %"), "{}", grown.reason);
        assert_eq!(grown.reason, grown.row.reason);
        assert!(grown.row.change.is_some_and(|change| (change - 1.03).abs() < 1e-9));
    }

    #[test]
    fn numbers_are_accepted_for_a_reason_and_from_a_commit() {
        let file = Path::new("accepted.csv");
        assert_eq!(target("a reason", "0123456789ab", Some(file)).expect("accepted"), file);
        for (why, commit, file, words) in [
            (" ", "0123456789ab", Some(file), "--accept: expected a reason"),
            ("a reason", "0123456789ab-dirty", Some(file), "found the commit 0123456789ab-dirty"),
            ("a reason", "unknown", Some(file), "found the commit unknown"),
            ("a reason", "0123456789ab", None, "reference-data/baselines here"),
        ] {
            let error = target(why, commit, file).expect_err("refused").to_string();
            assert!(error.contains(words), "{error}");
        }
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
        let dirty = renewed(&[], &night[..1], ("d1", "c1-dirty"), "the first", all).rows;
        assert_eq!(
            told(&renewed(&dirty, &night[..1], ("d2", "c2"), "of a commit", all))[0],
            "a 1.000000001 d2 c2 of a commit"
        );
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

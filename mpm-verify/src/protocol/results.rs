//! Results of a solver: `results.csv`, read with all that is wrong with it, and `run.json`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use mpm_core::seeding::inside;
use serde::{Deserialize, Serialize};

use super::case::{Case, Place};

/// Name of the table of results.
pub const RESULTS: &str = "results.csv";
/// Name of what is said of a run.
pub const RUN: &str = "run.json";
/// Longest table that is read, bytes.
const LARGEST: u64 = 256 << 20;
/// Times are the same within this share.
const SAME: f64 = 1e-6;
/// Most complaints about one table.
const MOST: usize = 5;
/// Columns that a table has to have.
const COLUMNS: [&str; 6] = ["refinement", "quantity", "time_s", "x_m", "y_m", "value"];

/// A number of an answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Which of the wanted quantities.
    pub quantity: usize,
    /// s, or the share of a path.
    pub time: f64,
    /// Where, m.
    pub place: Option<[f64; 2]>,
    /// The number, in the unit of the quantity.
    pub value: f64,
    /// Line of the table; 0 for none.
    pub line: u64,
}

impl Row {
    /// One number at a time.
    pub fn one(quantity: usize, time: f64, value: f64) -> Self {
        Self { quantity, time, place: None, value, line: 0 }
    }

    /// Whether it is of a time.
    pub fn is_at(&self, time: f64) -> bool {
        (self.time - time).abs() <= SAME * time.abs()
    }

    /// Whether it is of a place: a millionth of the larger coordinate apart at most.
    pub fn stands(&self, place: Option<[f64; 2]>) -> bool {
        match (self.place, place) {
            (_, None) => true,
            (None, Some(_)) => false,
            (Some(own), Some(other)) => {
                let size = other[0].abs().max(other[1].abs()).max(f64::MIN_POSITIVE);
                (0..2).all(|i| (own[i] - other[i]).abs() <= SAME * size)
            }
        }
    }
}

/// The answer of a solver to a case.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answer {
    /// Refinements that are complete, coarse to fine, with their numbers.
    pub levels: Vec<(f64, Vec<Row>)>,
    /// What is missing or wrong, with lines.
    pub faults: Vec<String>,
}

/// What a code says of itself.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// Its version.
    #[serde(default)]
    pub version: String,
    /// Its settings, in any form.
    #[serde(default)]
    pub settings: serde_json::Value,
    /// Processor and system.
    #[serde(default)]
    pub machine: String,
}

/// What a solver says of its runs: `run.json`. Costs are those that it says where nothing has measured them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Said {
    /// Name of the code.
    #[serde(default)]
    pub code: String,
    /// What else it says of itself.
    #[serde(flatten)]
    pub about: About,
    /// When, UTC.
    #[serde(default)]
    pub date: String,
    /// Costs of each refinement.
    #[serde(default)]
    pub runs: Vec<Cost>,
}

/// What a refinement took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Which.
    pub refinement: f64,
    /// CPU time of the command and all that it started, s.
    #[serde(default)]
    pub cpu_s: Option<f64>,
    /// Time on the clock, s.
    #[serde(default)]
    pub wall_s: Option<f64>,
    /// Peak memory of all at once, MiB.
    #[serde(default)]
    pub peak_mib: Option<f64>,
}

/// Reads `run.json`; what is wrong with it is told.
pub fn said(folder: &Path) -> (Said, Option<String>) {
    let Ok(text) = fs::read_to_string(folder.join(RUN)) else { return (Said::default(), None) };
    match serde_json::from_str(&text) {
        Ok(said) => (said, None),
        Err(why) => (Said::default(), Some(format!("{RUN}: {why}"))),
    }
}

/// Reads the table of a folder as an answer to a case, or those of its folders, one for each refinement.
pub fn read(folder: &Path, case: &Case) -> Answer {
    let below = case.refinements.iter().map(|refinement| folder.join(refinement.to_string()));
    let own: Vec<PathBuf> = below.filter(|folder| folder.join(RESULTS).exists()).collect();
    if own.is_empty() {
        return whole(case, one(&folder.join(RESULTS), case));
    }
    let mut all = (Levels::new(), Vec::new());
    for folder in own {
        let (levels, faults) = one(&folder.join(RESULTS), case);
        // A refinement is that of its folder.
        let is_own = |bits: &u64| folder.file_name().is_some_and(|name| *name == *f64::from_bits(*bits).to_string());
        all.0.extend(levels.into_iter().filter(|(level, _)| is_own(level)));
        all.1.extend(faults);
    }
    whole(case, all)
}

/// The rows of one table, and what is wrong with it.
fn one(path: &Path, case: &Case) -> (Levels, Vec<String>) {
    let fault = |what: String| (Levels::new(), vec![what]);
    match fs::metadata(path) {
        Err(_) => return fault(format!("no {RESULTS}")),
        Ok(file) if !file.is_file() => return fault(format!("{RESULTS} is no file")),
        Ok(file) if file.len() > LARGEST => {
            return fault(format!("{RESULTS} has {} MiB, more than {} MiB", file.len() >> 20, LARGEST >> 20));
        }
        Ok(_) => {}
    }
    match fs::read(path) {
        Ok(bytes) => table(&bytes, case),
        Err(why) => fault(format!("{RESULTS}: {why}")),
    }
}

fn table(bytes: &[u8], case: &Case) -> (Levels, Vec<String>) {
    let mut faults = Vec::new();
    match rows(bytes, case, &mut faults) {
        Ok(levels) => (levels, faults),
        Err(why) => (Levels::new(), vec![why]),
    }
}

/// Reads the bytes of a table.
pub fn parse(bytes: &[u8], case: &Case) -> Answer {
    whole(case, table(bytes, case))
}

/// The refinements that are complete.
fn whole(case: &Case, (levels, mut faults): (Levels, Vec<String>)) -> Answer {
    let mut answer = Answer::default();
    for refinement in &case.refinements {
        match levels.get(&refinement.to_bits()) {
            None => faults.push(format!("refinement {refinement}: no rows")),
            Some(rows) => match incomplete(case, *refinement, rows) {
                Some(what) => faults.push(format!("refinement {refinement}: {what}")),
                None => answer.levels.push((*refinement, rows.clone())),
            },
        }
    }
    let more = faults.len().saturating_sub(MOST);
    faults.truncate(MOST);
    if more > 0 {
        faults.push(format!("and {more} more"));
    }
    answer.faults = faults;
    answer
}

/// Rows by the bits of their refinements.
type Levels = BTreeMap<u64, Vec<Row>>;

/// Rows by their refinements. A number that is none makes its refinement incomplete.
fn rows(bytes: &[u8], case: &Case, faults: &mut Vec<String>) -> Result<Levels, String> {
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).flexible(true).from_reader(bytes);
    let header = reader.headers().map_err(|why| format!("{RESULTS}: {why}"))?.clone();
    let place = |name: &str| header.iter().position(|own| own == name);
    let places = COLUMNS.map(place);
    if let Some(missing) = COLUMNS.iter().zip(places).find(|(_, place)| place.is_none()) {
        let found = header.iter().collect::<Vec<_>>().join(",");
        let found: String = found.chars().take(80).collect();
        return Err(format!(
            "{RESULTS}:1: expected the columns {}, found no {} in {found}",
            COLUMNS.join(","),
            missing.0
        ));
    }
    let unit = place("unit");
    let mut levels = Levels::new();
    let mut spoilt = std::collections::BTreeSet::new();
    for record in reader.into_records() {
        let record = match record {
            Ok(record) => record,
            Err(why) => {
                faults.push(format!("{RESULTS}: {why}"));
                break;
            }
        };
        let line = record.position().map_or(0, csv::Position::line);
        let field = |i: usize| places[i].and_then(|place| record.get(place)).unwrap_or("");
        let mut wrong = |expected: &str, found: &str| {
            let found: String = found.chars().take(40).collect();
            faults.push(format!("{RESULTS}:{line}: expected {expected}, found {found:?}"));
        };
        let Some(refinement) = field(0).parse::<f64>().ok().filter(|x| case.refinements.contains(x)) else {
            wrong(&format!("a refinement of {:?}", case.refinements), field(0));
            continue;
        };
        let Some(quantity) = case.wanted.iter().position(|wanted| wanted.quantity == field(1)) else {
            let names: Vec<&str> = case.wanted.iter().map(|wanted| wanted.quantity.as_str()).collect();
            wrong(&names.join(" or "), field(1));
            continue;
        };
        let wanted = &case.wanted[quantity];
        if let Some(other) = unit.and_then(|unit| record.get(unit)).filter(|own| *own != wanted.unit) {
            wrong(&format!("{} in {}", wanted.quantity, wanted.unit), other);
            spoilt.insert(refinement.to_bits());
            continue;
        }
        let Ok(time) = field(2).parse::<f64>() else {
            wrong("a time in s", field(2));
            continue;
        };
        // Other times than those that are asked for do no harm.
        let Some(time) = wanted.times.iter().copied().find(|at| (at - time).abs() <= SAME * at.abs()) else { continue };
        let [x, y] =
            [3, 4].map(|i| if field(i).is_empty() { Some(None) } else { field(i).parse::<f64>().ok().map(Some) });
        let (Some(x), Some(y)) = (x, y) else {
            wrong("places in m", &format!("{}, {}", field(3), field(4)));
            continue;
        };
        let place = match (&wanted.place, x, y) {
            (Place::None, ..) => None,
            (Place::Heights, x, Some(y)) => Some([x.unwrap_or(0.0), y]),
            (_, Some(x), Some(y)) => Some([x, y]),
            _ => {
                wrong("a place, x_m and y_m", "none");
                continue;
            }
        };
        let Some(value) = field(5).parse::<f64>().ok().filter(|value| value.is_finite()) else {
            wrong("a finite number", field(5));
            spoilt.insert(refinement.to_bits());
            continue;
        };
        levels.entry(refinement.to_bits()).or_default().push(Row { quantity, time, place, value, line });
    }
    spoilt.iter().for_each(|level| {
        levels.remove(level);
    });
    Ok(levels)
}

/// What a refinement lacks, or has twice.
fn incomplete(case: &Case, refinement: f64, rows: &[Row]) -> Option<String> {
    for (number, wanted) in case.wanted.iter().enumerate() {
        for time in &wanted.times {
            let own: Vec<&Row> = rows.iter().filter(|row| row.quantity == number && row.time == *time).collect();
            let name = format!("{} at {time} s", wanted.quantity);
            let lacks = match &wanted.place {
                Place::None => match own[..] {
                    [] => Some(format!("no {name}")),
                    [_] => None,
                    [first, second, ..] => Some(format!("{name} twice, lines {} and {}", first.line, second.line)),
                },
                Place::Given(places) => {
                    let missing = places.iter().find(|place| !own.iter().any(|row| row.stands(Some(**place))));
                    missing.map(|[x, y]| format!("no {name} at x = {x} m, y = {y} m"))
                }
                Place::Heights | Place::Field => uncovered(case, refinement, &own, wanted.place == Place::Heights)
                    .map(|[x, y]| format!("no {name} in the cell at x = {x:.4} m, y = {y:.4} m")),
            };
            if lacks.is_some() {
                return lacks;
            }
        }
    }
    None
}

/// The middle of a cell inside the soil without a number.
fn uncovered(case: &Case, refinement: f64, rows: &[&Row], along: bool) -> Option<[f64; 2]> {
    let (scene, cell) = (case.scene()?, case.cell(refinement)?);
    let columns = if along { 1 } else { (scene.width / cell - 1e-6).ceil() as usize };
    let count = [columns, refinement as usize];
    let mut filled = vec![false; count[0] * count[1]];
    for row in rows {
        let place = row.place.unwrap_or_default();
        // Nodes at the upper edge of a cell are its own where no cell follows.
        let at = |i: usize| ((place[i] / cell + 1e-9).floor().max(0.0) as usize).min(count[i] - 1);
        filled[at(1) * columns + if along { 0 } else { at(0) }] = true;
    }
    let outline = scene.outline_or_box();
    let whole = |i: usize, j: usize| {
        let corner = |a: f64, b: f64| [(i as f64 + a) * cell, (j as f64 + b) * cell];
        let inner = [[0.001, 0.001], [0.999, 0.001], [0.999, 0.999], [0.001, 0.999]];
        along || inner.iter().all(|[a, b]| inside(&outline, &corner(*a, *b)))
    };
    let empty = (0..filled.len()).find(|n| !filled[*n] && whole(n % columns, n / columns))?;
    Some([empty % columns, empty / columns].map(|i| (i as f64 + 0.5) * cell))
}

/// Writes an answer as a table.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, case: &Case, levels: &[(f64, Vec<Row>)]) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_path(path)?;
    writer.write_record(COLUMNS)?;
    for (refinement, rows) in levels {
        for row in rows {
            let wanted = &case.wanted[row.quantity];
            let [x, y] = row.place.map_or([String::new(), String::new()], |place| place.map(|x| x.to_string()));
            let numbers = [
                refinement.to_string(),
                wanted.quantity.clone(),
                row.time.to_string(),
                x,
                y,
                format!("{:e}", row.value),
            ];
            writer.write_record(numbers)?;
        }
    }
    Ok(writer.flush()?)
}

//! The tables of a run: history, stress paths, events.

use std::path::Path;

use mpm_core::failure::{Events, PathPoint, Row};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::moments::{EVENTS, times};
use crate::report::numbers::exact;
use crate::report::{ReportError, save, tables, unwritable};

/// Writes `history.csv`, with the levels of water at the places x (m) as columns after all others, `paths.csv` and
/// `events.csv`.
///
/// # Errors
/// A file that cannot be written.
pub fn write(
    rows: &[Row],
    paths: &[PathPoint],
    events: &Events,
    levels: &[f64],
    folder: &Path,
) -> Result<(), ReportError> {
    let path = folder.join("history.csv");
    let names: Vec<String> = levels.iter().map(|x| format!("level_x{x}_m")).collect();
    save(&path, history(rows, &names).map_err(|e| unwritable(&path, e))?)?;
    lines(paths, &folder.join("paths.csv"))?;
    tables::table(&folder.join("events.csv"), "event,time_h,what", happened(events))
}

/// Writes a table of lines.
///
/// # Errors
/// A file that cannot be written.
pub fn lines<T: Serialize>(lines: &[T], path: &Path) -> Result<(), ReportError> {
    let mut writer = csv::Writer::from_path(path).map_err(|e| unwritable(path, e))?;
    for line in lines {
        writer.serialize(line).map_err(|e| unwritable(path, e))?;
    }
    writer.flush().map_err(|e| unwritable(path, e))
}

/// A line of a table that stays in a folder and may be found there by the run of another scene.
pub trait OfScene {
    /// [`super::plan::Plan::scene_word`] of its scene.
    fn scene(&self) -> &str;
}

/// Reads a table back; no lines if there is no such file. One of another scene is named in `others` and gives no lines.
///
/// # Errors
/// A file that is not such a table.
pub fn stored<T: DeserializeOwned + OfScene>(
    path: &Path,
    scene: &str,
    others: &mut Vec<String>,
) -> Result<Vec<T>, ReportError> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let wrong = |cause| ReportError::Read { path: path.to_owned(), cause };
    let mut reader = csv::Reader::from_path(path).map_err(wrong)?;
    let lines: Vec<T> = reader.deserialize().collect::<Result<_, _>>().map_err(wrong)?;
    if lines.iter().all(|line| line.scene() == scene) {
        return Ok(lines);
    }
    others.push(format!("{} is of another scene: it is not shown", path.display()));
    Ok(Vec::new())
}

/// The rows as CSV. The writer of CSV takes no lists inside a row: they are joined on afterwards.
fn history(rows: &[Row], levels: &[String]) -> Result<Vec<u8>, csv::Error> {
    let mut plain = csv::Writer::from_writer(Vec::new());
    for row in rows {
        plain.serialize(row)?;
    }
    let plain = plain.into_inner().map_err(csv::IntoInnerError::into_error)?;
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(plain.as_slice());
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (number, record) in reader.records().enumerate() {
        let record = record?;
        let more: Vec<String> = match number.checked_sub(1) {
            None => levels.to_vec(),
            Some(row) => rows[row].levels.iter().map(|level| exact(*level)).collect(),
        };
        writer.write_record(record.iter().chain(more.iter().map(String::as_str)))?;
    }
    writer.into_inner().map_err(|e| e.into_error().into())
}

/// What happened, in the order of time.
fn happened(events: &Events) -> Vec<Vec<String>> {
    let named = EVENTS.iter().zip(times(events)).map(|((name, words), time)| (*name, *words, time));
    let unsettled = ("unsettled", "soil does not come to rest under the pressures", events.unsettled_h);
    let mut all: Vec<_> = named.chain([unsettled]).filter_map(|(n, w, t)| Some((t?, n, w))).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.into_iter().map(|(time, name, words)| vec![name.to_owned(), exact(time), words.to_owned()]).collect()
}

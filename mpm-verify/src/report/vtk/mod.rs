//! Frames as files of ParaView: both layers as clouds of points, the cells as squares, and a collection of each
//! that knows the times.
//!
//! # Reading order
//! 1. [`write()`]: the folder, with `view.py` that opens it. `layers`: which numbers of a particle or a cell are in the files, with
//!    their units and signs.
//! 2. `data`: points, squares and their numbers as the data sets of the crate `vtkio`.

mod data;
mod layers;

use std::fs;
use std::path::Path;

use mpm_core::observe::{Frame, SolidState};
use vtkio::Vtk;

use crate::frames::{Shot, mean_stress};
use crate::report::numbers::exact;
use crate::report::plots::levee::map::edge;
use crate::report::quantity;
use crate::report::{ReportError, save, unwritable};

/// Name of a collection and of its folder, ending of its files, the data set of a frame, whether a frame has some of it.
type Part = (&'static str, &'static str, fn(&Frame) -> Vtk, fn(&Frame) -> bool);

/// Name of an array and its values.
type Scalar = (&'static str, fn(&SolidState) -> f64);

/// What is written.
const PARTS: [Part; 3] = [
    ("solid", "vtp", layers::solid, |_| true),
    ("water", "vtp", layers::water, |frame| !frame.water.is_empty()),
    ("cells", "vtu", layers::cells, |frame| !frame.cell.is_empty()),
];
/// The state script.
const VIEW: &str = include_str!("view.py");

/// Writes `solid.pvd`, `water.pvd` and `cells.pvd`, and a file per frame in a folder beside each; without water or cells at any
/// time, not that part. `view.py` opens them in ParaView. Times are those of the reader's clock, s.
///
/// # Errors
/// A file or folder that cannot be written, with its path.
pub fn write(shots: &[Shot], folder: &Path) -> Result<(), ReportError> {
    for (part, ending, data, has) in PARTS {
        if !shots.iter().any(|shot| has(&shot.frame)) {
            continue;
        }
        let own = folder.join(part);
        fs::create_dir_all(&own).map_err(|e| unwritable(&own, e))?;
        let mut files = Vec::new();
        for (number, shot) in shots.iter().enumerate() {
            let file = format!("{part}/{part}-{number:04}.{ending}");
            let path = folder.join(&file);
            let text = text(data(&shot.frame)).map_err(|e| unwritable(&path, std::io::Error::other(e.to_string())))?;
            save(&path, text)?;
            files.push((shot.time_s, file));
        }
        save(&folder.join(format!("{part}.pvd")), collection(&files))?;
    }
    if shots.is_empty() { Ok(()) } else { save(&folder.join("view.py"), view(shots)) }
}

/// The state script for these frames.
fn view(shots: &[Shot]) -> String {
    let ranges: [Scalar; 3] =
        [(layers::STRAIN, |p| p.deviator_strain), (layers::PRESSURE, |p| p.pore_pressure), (layers::MEAN, mean_stress)];
    let is_known = |of: fn(&SolidState) -> f64| shots.iter().any(|s| s.frame.solid.iter().any(|p| of(p).is_finite()));
    let known: Vec<_> = ranges.into_iter().filter(|(_, of)| is_known(*of)).collect();
    let shown = known.first().map_or(layers::MEAN, |(name, _)| *name);
    let row = |(name, of): &Scalar| {
        let (low, high) = quantity::range(shots, *of);
        format!("    \"{name}\": ({low:?}, {high:?}),\n")
    };
    let rows: Vec<String> = known.iter().map(row).collect();
    let edge = edge(shots.first().map(|shot| &shot.frame));
    let filled =
        [("@RANGES@", format!("{{\n{}}}", rows.concat())), ("@POINT@", exact(edge)), ("@SHOWN@", shown.into())];
    filled.iter().fold(VIEW.to_owned(), |text, (mark, value)| text.replace(mark, value))
}

/// A data set as XML. The crate leaves out counts that are zero, without which ParaView refuses a file.
fn text(data: Vtk) -> Result<String, vtkio::Error> {
    let mut bytes = Vec::new();
    data.write_xml(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    Ok(text.replacen("<Piece>", "<Piece NumberOfPoints=\"0\" NumberOfVerts=\"0\">", 1))
}

/// A collection: times in s and files beside it.
fn collection(files: &[(f64, String)]) -> String {
    let row = |(time, file): &(f64, String)| {
        format!("    <DataSet timestep=\"{}\" group=\"\" part=\"0\" file=\"{file}\"/>\n", exact(*time))
    };
    let rows: String = files.iter().map(row).collect();
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  \
         <Collection>\n{rows}  </Collection>\n</VTKFile>\n"
    )
}

#[cfg(test)]
mod tests;

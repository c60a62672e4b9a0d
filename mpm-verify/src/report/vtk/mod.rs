//! Frames as files of ParaView: both layers as clouds of points, the cells as squares, and a collection of each
//! that knows the times.
//!
//! # Reading order
//! 1. [`write()`]: the folder. `layers`: which numbers of a particle or a cell are in the files, with their units.
//! 2. `data`: points, squares and their numbers as the data sets of the crate `vtkio`.

mod data;
mod layers;

use std::fs;
use std::path::Path;

use mpm_core::observe::Frame;
use vtkio::Vtk;

use crate::frames::Shot;
use crate::report::numbers::exact;
use crate::report::{ReportError, save, unwritable};

/// Name of a collection and of its folder, ending of its files, the data set of a frame.
type Part = (&'static str, &'static str, fn(&Frame) -> Vtk);

/// What is written.
const PARTS: [Part; 3] =
    [("solid", "vtp", layers::solid), ("water", "vtp", layers::water), ("cells", "vtu", layers::cells)];

/// Writes `solid.pvd`, `water.pvd` and `cells.pvd`, and a file per frame in a folder beside each. Times are those of
/// the reader's clock, s.
///
/// # Errors
/// A file or folder that cannot be written, with its path.
pub fn write(shots: &[Shot], folder: &Path) -> Result<(), ReportError> {
    for (part, ending, data) in PARTS {
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
    Ok(())
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

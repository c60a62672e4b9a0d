//! What two Darcy operators make of the same point source in the full cells of the levee: a map for each, with one range of
//! colours.

use std::path::Path;

use super::Site;
use super::map::{self, Window};
use crate::report::numbers::{exact, percent};
use crate::report::plots::field::cloud;
use crate::report::plots::figure::{Figure, Mark, Panel, Point, Series};
use crate::report::plots::look::{BLACK, Look, Marker, RED};
use crate::report::plots::write_drawn;
use crate::report::{ReportError, tables};

/// File name without ending.
pub const NAME: &str = "levee-operators";
const LABEL: &str = "pore pressure that the source adds (kPa)";
const COLUMN: &str = "response_kpa";

/// A full cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FullCell {
    /// Its middle, m.
    pub x: [f64; 2],
    /// Whether its head is given.
    pub known: bool,
    /// What the source adds under the face operator and under the nodal one, kPa.
    pub response: [f64; 2],
}

/// What is to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Responses {
    /// The full cells.
    pub cells: Vec<FullCell>,
    /// Edge of a cell, m.
    pub size: f64,
    /// Where the source is, m.
    pub source: [f64; 2],
    /// Checkerboard index of each response.
    pub index: [f64; 2],
    /// What else the reader should know.
    pub caption: String,
}

/// The picture.
pub fn figure(site: &Site, shown: &Responses) -> Figure {
    let window = Window::of(site, []);
    let unit = window.unit(2);
    let most = shown.cells.iter().flat_map(|cell| cell.response).fold(1e-9, f64::max);
    let names = ["(a) default: through faces", "(b) the paper's: at nodes"];
    let mut panels: Vec<Panel> = Vec::new();
    for (k, name) in names.into_iter().enumerate() {
        let mut panel = window.panel(&format!("{name}, index {} %", percent(shown.index[k])));
        // A little more, or seams would be seen.
        let look = Look::new(BLACK, Marker::Box).radius(0.5 * shown.size * unit + 0.35);
        let points: Vec<[f64; 3]> = shown.cells.iter().map(|cell| [cell.x[0], cell.x[1], cell.response[k]]).collect();
        cloud(&mut panel, &points, (0.0, most), look);
        let source = Look::new(RED, Marker::Star).radius(4.5);
        panel.add(Series::new("source", source, Mark::Points, [Point::new(shown.source[0], shown.source[1])]));
        map::outline(&mut panel, site);
        panels.push(panel);
    }
    panels.push(map::scale(LABEL, COLUMN, (0.0, most), 1));
    Figure {
        name: NAME,
        title: "A point source under both Darcy operators".to_owned(),
        caption: shown.caption.clone(),
        height: window.height(2),
        panels,
        missing: Vec::new(),
    }
}

/// Writes it with the values of all full cells. Returns the text of the SVG.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(figure: &Figure, shown: &Responses, folder: &Path) -> Result<String, ReportError> {
    let row = |cell: &FullCell| {
        let head = if cell.known { "given" } else { "solved" };
        let [face, nodal] = cell.response.map(exact);
        vec![exact(cell.x[0]), exact(cell.x[1]), head.to_owned(), face, nodal]
    };
    let path = folder.join(format!("{NAME}.csv"));
    tables::table(&path, "x_m,y_m,head,face_response_kpa,nodal_response_kpa", shown.cells.iter().map(row))?;
    write_drawn(figure, folder)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{folder, site};
    use super::*;

    #[test]
    fn both_maps_have_the_same_cells_and_colours() {
        let spot = |k: usize| [0.2 + 0.4 * (k % 12) as f64, 0.2 + 0.4 * (k / 12) as f64];
        let response = |k: usize| [0.5, if (k % 12 + k / 12).is_multiple_of(2) { 1.0 } else { 0.0 }];
        let cells = (0..36).map(|k| FullCell { x: spot(k), known: k % 12 == 0, response: response(k) }).collect();
        let shown = Responses { cells, size: 0.4, source: spot(18), index: [0.0, 1.0], caption: String::new() };
        let (folder, _own) = folder();
        let figure = figure(&site(), &shown);
        assert_eq!(figure.panels.iter().map(|p| p.row).collect::<Vec<_>>(), [0, 0, 1]);
        let svg = write(&figure, &shown, &folder).expect("a picture");
        for part in ["(a) default", "(b) the paper", "source", "(kPa)", "x (m)"] {
            assert!(svg.contains(part), "{part}");
        }
        let table = std::fs::read_to_string(folder.join("levee-operators.csv")).expect("a table");
        assert!(table.starts_with("x_m,y_m,head,face_response_kpa,nodal_response_kpa\n0.2,0.2,given,0.5,1.0\n"));
        assert_eq!(table.lines().count(), 37);
    }
}

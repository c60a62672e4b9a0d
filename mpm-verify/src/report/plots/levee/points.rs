//! Where the stress paths are observed (the paper's Fig. 8).

use std::path::Path;

use mpm_core::observe::Frame;

use super::Site;
use super::map::{self, Window};
use crate::frames::Shot;
use crate::report::ReportError;
use crate::report::plots;
use crate::report::plots::figure::{Figure, Mark, Point, Series};
use crate::report::plots::look::{BLACK, Look, Marker};

/// A point of observation.
#[derive(Debug, Clone, PartialEq)]
pub struct Observed {
    /// Its name: `S1`.
    pub name: String,
    /// Its place at the start, m.
    pub x: [f64; 2],
}

/// Points named `S1`, `S2`, ... in their order.
pub fn numbered(places: &[[f64; 2]]) -> Vec<Observed> {
    places.iter().enumerate().map(|(k, x)| Observed { name: format!("S{}", k + 1), x: *x }).collect()
}

/// The picture: the points on the soil and the water at the start.
pub fn figure(site: &Site, frame: &Frame, observed: &[Observed]) -> Figure {
    let shot = Shot { frame: frame.clone(), ..Shot::default() };
    let window = Window::of(site, [&shot]);
    let mut panel = window.panel("");
    map::layers(&mut panel, frame, window.unit(1));
    for series in &mut panel.series {
        series.is_data = false;
    }
    map::outline(&mut panel, site);
    let look = Look::new(BLACK, Marker::Circle).radius(11.0);
    let at = |o: &Observed| Point::new(o.x[0], o.x[1]);
    panel.add(Series::new("point of observation", look, Mark::Points, observed.iter().map(|o| at(o).open(true))));
    let names = observed.iter().map(|o| at(o).note(o.name.clone()));
    panel.add(Series::new("name", look, Mark::Middle, names).unlisted());
    Figure {
        name: "levee-points",
        title: "Points where stress paths are observed".to_owned(),
        caption: "Places at the start; every point moves with its particle.".to_owned(),
        height: window.height(1),
        panels: vec![panel],
        missing: Vec::new(),
    }
}

/// Writes it with the places of the points and of the outline. Returns the text of the SVG.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(site: &Site, frame: &Frame, observed: &[Observed], folder: &Path) -> Result<String, ReportError> {
    plots::write(&figure(site, frame, observed), folder)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{folder, site};
    use super::*;
    use crate::frames::made_up;

    #[test]
    fn the_points_are_numbered_and_in_the_table() {
        let (folder, _own) = folder();
        let places = [[2.0, 0.6], [3.6, 0.6], [5.2, 0.6], [6.8, 0.6], [8.2, 0.2], [3.4, 2.0], [5.2, 1.4]];
        let frame = &made_up::shots(1, 0)[0].frame;
        let svg = write(&site(), frame, &numbered(&places), &folder).expect("a picture");
        assert!((1..=7).all(|k| svg.contains(&format!("S{k}\n"))));
        let table = std::fs::read_to_string(folder.join("levee-points.csv")).expect("a table");
        assert!(table.contains("name,8.2,0.2,S5"), "{table}");
        assert_eq!(table.lines().count(), 1 + 5 + 2 * 7);
    }
}

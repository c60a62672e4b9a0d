//! A failure at its events: side by side the water with the slip surface, the deviator strain, and the speed of the soil.

use std::path::Path;

use super::map::{self, Window};
use super::{Site, clock};
use crate::frames::Shot;
use crate::report::numbers::exact;
use crate::report::plots::figure::{Figure, Panel, Series};
use crate::report::plots::look::{Look, Marker, RED};
use crate::report::plots::write_bitmap;
use crate::report::quantity::{self, Quantity, SPEED, STRAIN};
use crate::report::{ReportError, tables};

/// Maps beside each other.
const COLUMNS: usize = 3;
const SLIP: Look = Look::new(RED, Marker::Dot).width(2.0);

/// One row per frame; what has moved by `slipped` (m) has slipped.
pub fn figure(site: &Site, shots: &[&Shot], slipped: f64) -> Figure {
    let window = Window::of(site, shots.iter().copied());
    let unit = window.unit(COLUMNS);
    let coloured = [STRAIN, SPEED];
    let ranges = coloured.map(|quantity| range(quantity, shots));
    let mut panels: Vec<Panel> = Vec::new();
    for (row, shot) in shots.iter().enumerate() {
        let event = shot.phase.rsplit(", ").next().unwrap_or_default();
        for column in 0..COLUMNS {
            let said = [clock(shot.time_s), event.to_owned(), String::new()];
            let mut panel = window.panel(&said[column]);
            panel.row = row;
            if row + 1 < shots.len() {
                panel.x.label.clear();
            }
            if column > 0 {
                panel.y.label.clear();
            }
            match column.checked_sub(1) {
                None => map::layers(&mut panel, &shot.frame, unit),
                Some(k) => map::coloured(&mut panel, &shot.frame, coloured[k], ranges[k], unit),
            }
            map::outline(&mut panel, site);
            if column == 0 {
                map::water_level(&mut panel, &shot.frame);
                panel.add(Series::line("slip surface", SLIP, surface(shot, slipped)));
            }
            panels.push(panel);
        }
    }
    panels.extend((0..2).map(|k| map::bar(coloured[k], ranges[k], shots.len())));
    Figure {
        name: "levee-failure",
        title: "Failure at its events".to_owned(),
        caption: format!(
            "Left: soil, water and its level; above the slip surface soil has moved more than {slipped:.2} m. Middle: deviator strain. Right: \
             speed, logarithmic.{}",
            (0..2).map(|k| coloured[k].clipped(shots, ranges[k])).collect::<String>()
        ),
        height: window.height(COLUMNS),
        panels,
        missing: Vec::new(),
    }
}

/// Colours of all frames.
fn range(quantity: Quantity, shots: &[&Shot]) -> (f64, f64) {
    if quantity != SPEED {
        return quantity.range(shots.iter().copied());
    }
    let (_, above) = quantity::range(shots.iter().copied(), |p| (SPEED.of)(p) - SPEED_FROM);
    (SPEED_FROM, SPEED_FROM + above)
}

/// Slower soil has the colour of soil at rest: the logarithm (base 10) of its speed in m/s.
const SPEED_FROM: f64 = -4.0;

/// The lowest soil that has slipped in each column of cells (x, y), m, from left to right.
fn surface(shot: &Shot, slipped: f64) -> Vec<(f64, f64)> {
    let size = shot.frame.size;
    let [columns, _] = shot.frame.cells;
    let mut lowest = vec![f64::INFINITY; columns];
    for p in shot.frame.solid.iter().filter(|p| p.displacement[0].hypot(p.displacement[1]) > slipped) {
        let column = (p.x[0] / size).floor();
        if let Some(low) = lowest.get_mut(column as usize).filter(|_| column >= 0.0) {
            *low = low.min(p.x[1] - 0.5 * p.volume.sqrt());
        }
    }
    let points = lowest.iter().enumerate().filter(|(_, low)| low.is_finite());
    points.map(|(column, low)| ((column as f64 + 0.5) * size, low.max(0.0))).collect()
}

/// Writes it as PNG, with places, strain and speed of all particles as CSV.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(figure: &Figure, shots: &[&Shot], folder: &Path) -> Result<(), ReportError> {
    let rows = shots.iter().flat_map(|shot| {
        let row = |p: &mpm_core::observe::SolidState| {
            let speed = p.velocity[0].hypot(p.velocity[1]);
            [shot.time_s, p.x[0], p.x[1], p.displacement[0], p.displacement[1], p.deviator_strain, speed]
                .map(exact)
                .to_vec()
        };
        shot.frame.solid.iter().map(row)
    });
    let head = "time_s,x_m,y_m,displacement_x_m,displacement_y_m,deviator_strain,speed_m_s";
    tables::table(&folder.join(format!("{}.csv", figure.name)), head, rows)?;
    write_bitmap(figure, folder)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{folder, site};
    use super::*;
    use crate::frames::made_up;
    use crate::report::plots::svg_text;

    #[test]
    fn every_frame_has_its_row_of_three_maps() {
        let shots = made_up::shots(2, 4);
        let chosen: Vec<&Shot> = shots.iter().collect();
        let figure = figure(&site(), &chosen, 0.05);
        assert_eq!(figure.panels.len(), COLUMNS * chosen.len() + 2);
        let (folder, _own) = folder();
        write(&figure, &chosen, &folder).expect("a picture");
        assert!(folder.join("levee-failure.png").exists());
        let svg = svg_text(&figure).expect("a picture");
        assert!(svg.contains("slip surface") && svg.contains("deviator strain"));
    }

    #[test]
    fn the_slip_surface_is_the_lowest_soil_that_has_moved() {
        let mut shots = made_up::shots(1, 2);
        let shot = &mut shots[0];
        for p in &mut shot.frame.solid {
            p.displacement = if p.x[1] > 0.5 { [0.2, 0.0] } else { [0.0, 0.0] };
        }
        let line = surface(shot, 0.05);
        assert!(!line.is_empty() && line.iter().all(|(_, y)| *y > 0.2), "{line:?}");
        assert!(surface(shot, 0.3).is_empty());
    }
}

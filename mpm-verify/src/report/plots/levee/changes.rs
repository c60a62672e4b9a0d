//! How the levee changes (the paper's Fig. 7): its shape with the water in it, or a quantity, at one time or at several.

use std::path::Path;

use super::map::{self, Window};
use super::{Site, clock};
use crate::frames::Shot;
use crate::report::numbers::exact;
use crate::report::plots::figure::{Figure, Panel};
use crate::report::plots::write_bitmap;
use crate::report::quantity::Quantity;
use crate::report::{ReportError, tables};

/// What a picture shows of the soil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shown {
    /// Its shape, with the water particles and the level of the water.
    Shape,
    /// A quantity.
    Of(Quantity),
}

impl Shown {
    /// File name without ending.
    fn name(self) -> &'static str {
        match self {
            Self::Shape => "levee-shape",
            Self::Of(quantity) => quantity.picture,
        }
    }

    fn title(self) -> String {
        match self {
            Self::Shape => "Shape of the levee and water in it".to_owned(),
            // The unit stands at the colour bar.
            Self::Of(quantity) => {
                let words = quantity.label.split(" (").next().unwrap_or(quantity.label);
                words[..1].to_uppercase() + &words[1..]
            }
        }
    }
}

/// Maps side by side.
fn columns(count: usize) -> usize {
    if count > 3 { 2 } else { 1 }
}

/// One map per frame, all of the same part of the plane and with one range of colours.
pub fn figure(site: &Site, shots: &[&Shot], shown: Shown) -> Figure {
    let window = Window::of(site, shots.iter().copied());
    let columns = columns(shots.len());
    let last = shots.len().saturating_sub(1) / columns;
    let mut panels: Vec<Panel> = Vec::new();
    for (number, shot) in shots.iter().enumerate() {
        let mut panel = window.panel(&format!("{}, {}", clock(shot.time_s), shot.phase));
        panel.row = number / columns;
        if panel.row < last {
            panel.x.label.clear();
        }
        fill(&mut panel, site, shot, (shown, range(shots, shown)), window.unit(columns));
        panels.push(panel);
    }
    // A map alone in its row is no larger than the others.
    if columns == 2 && shots.len() % 2 == 1 {
        panels.push(Panel { row: last, ..Panel::blank() });
    }
    if let Shown::Of(quantity) = shown {
        panels.push(map::bar(quantity, range(shots, shown), last + 1));
    }
    Figure {
        name: shown.name(),
        title: shown.title(),
        caption: caption(shown, shots),
        height: window.height(columns),
        panels,
        missing: Vec::new(),
    }
}

/// Writes [`figure`], or what was made of it, as PNG, with the places and values of all particles as CSV.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(figure: &Figure, shots: &[&Shot], shown: Shown, folder: &Path) -> Result<(), ReportError> {
    let path = folder.join(format!("{}.csv", figure.name));
    let rows = shots.iter().flat_map(|shot| rows(shot, shown));
    let last = if let Shown::Of(quantity) = shown { quantity.column } else { "layer" };
    tables::table(&path, &format!("time_s,x_m,y_m,{last}"), rows)?;
    write_bitmap(figure, folder)
}

fn range(shots: &[&Shot], shown: Shown) -> (f64, f64) {
    match shown {
        Shown::Shape => (0.0, 1.0),
        Shown::Of(quantity) => quantity.range(shots.iter().copied()),
    }
}

fn fill(panel: &mut Panel, site: &Site, shot: &Shot, (shown, range): (Shown, (f64, f64)), unit: f64) {
    match shown {
        Shown::Shape => {
            map::layers(panel, &shot.frame, unit);
            map::water_level(panel, &shot.frame);
        }
        Shown::Of(quantity) => map::coloured(panel, &shot.frame, quantity, range, unit),
    }
    map::outline(panel, site);
}

fn caption(shown: Shown, shots: &[&Shot]) -> String {
    let each = if shots.len() > 1 { " All maps show the same part of the plane." } else { "" };
    match shown {
        Shown::Shape => format!(
            "Soil and water as particles; the level of the water is the top of the highest wet cell of each column.{each}"
        ),
        Shown::Of(quantity) => {
            let clipped = quantity.clipped(shots, range(shots, shown));
            format!("Every solid particle in the colour of its value.{clipped}{each}")
        }
    }
}

fn rows(shot: &Shot, shown: Shown) -> Vec<Vec<String>> {
    let row = |x: [f64; 2], last: String| vec![exact(shot.time_s), exact(x[0]), exact(x[1]), last];
    let solid = &shot.frame.solid;
    match shown {
        Shown::Of(quantity) => solid.iter().map(|p| row(p.x, exact((quantity.of)(p)))).collect(),
        Shown::Shape => {
            let soil = solid.iter().map(|p| row(p.x, "solid".to_owned()));
            let water = shot.frame.water.iter().map(|p| row(p.x, "water".to_owned()));
            let level = map::level(&shot.frame).into_iter().map(|(x, y)| row([x, y], "level".to_owned()));
            soil.chain(water).chain(level).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{folder, site};
    use super::*;
    use crate::frames::made_up;
    use crate::report::plots::svg_text;
    use crate::report::quantity::{DISPLACEMENT, PRESSURE, STRAIN};

    #[test]
    fn every_frame_has_its_map_and_all_share_colours() {
        let shots = made_up::shots(2, 4);
        let chosen: Vec<&Shot> = shots.iter().collect();
        let (folder, _own) = folder();
        for shown in [Shown::Shape, Shown::Of(STRAIN), Shown::Of(PRESSURE)] {
            let figure = figure(&site(), &chosen, shown);
            write(&figure, &chosen, shown, &folder).expect("a picture");
            assert!(folder.join(format!("{}.png", figure.name)).exists());
            let svg = svg_text(&figure).expect("a picture");
            for part in ["8 h 39 min 36 s, seepage", "x (m)"] {
                assert!(svg.contains(part), "{part}");
            }
            assert!(svg.len() < 1_500_000, "{}", svg.len());
            assert_eq!(svg.contains("(kPa)"), shown == Shown::Of(PRESSURE));
        }
        let table = std::fs::read_to_string(folder.join("levee-pressure.csv")).expect("a table");
        assert!(table.starts_with("time_s,x_m,y_m,pore_pressure_kpa\n21600.0,"));
        let count: usize = shots.iter().map(|s| s.frame.solid.len()).sum();
        assert_eq!(table.lines().count(), 1 + count);
    }

    #[test]
    fn few_frames_stand_below_each_other_and_an_odd_one_beside_nothing() {
        let shots = made_up::shots(1, 4);
        let chosen: Vec<&Shot> = shots.iter().collect();
        let rows = |count: usize| {
            let figure = figure(&site(), &chosen[..count], Shown::Of(DISPLACEMENT));
            figure.panels.iter().map(|p| p.row).collect::<Vec<_>>()
        };
        assert_eq!(rows(2), [0, 1, 2]);
        assert_eq!(rows(5), [0, 0, 1, 1, 2, 2, 3]);
    }
}

//! One explicit time step as a diagram: what the paper's Figures 1 and 3 describe, as this program does it.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{BLACK, BLUE, Look, Marker, RED};
use plotters::style::RGBColor;

/// File name of the figure without ending.
pub const NAME: &str = "time-step";

/// A box of the diagram: ends across, row from the top, edge, lines of text.
type Stage = ([f64; 2], usize, RGBColor, [&'static str; 2]);

const STAGES: [Stage; 9] = [
    ([0.0, 4.8], 0, RED, ["solid particles at time k:", "mass, velocity, effective stress, porosity"]),
    ([5.2, 10.0], 0, BLUE, ["water particles at time k:", "mass, pore pressure"]),
    (
        [0.0, 10.0],
        1,
        BLACK,
        [
            "nodes: mass and momentum of the soil; forces of effective stress, pore pressure, gravity, load",
            "equation of motion: acceleration of the soil",
        ],
    ),
    ([0.0, 4.8], 2, BLACK, ["nodes:", "velocity of the soil"]),
    ([5.2, 10.0], 2, BLACK, ["faces of the cells:", "velocity of the water relative to the soil, Eq. (1)"]),
    ([0.0, 4.8], 3, RED, ["solid particles: strain increment, Eq. (7),", "effective stress from the constitutive law"]),
    (
        [5.2, 10.0],
        3,
        BLUE,
        ["water particles: strain of the relative flow,", "Eq. (6), pore pressure increment, Eq. (5)"],
    ),
    ([0.0, 4.8], 4, RED, ["solid particles at time k + 1:", "velocity, position, porosity, volume"]),
    ([5.2, 10.0], 4, BLUE, ["water particles at time k + 1:", "position, porosity, volume"]),
];
/// Height of a box, and of the room below it for an arrow.
const HIGH: f64 = 1.0;
const ROOM: f64 = 0.45;
/// Rows of boxes.
const ROWS: usize = 5;

/// Boxes from the top down, with arrows between.
pub fn figure() -> Figure {
    let axis = |column, from, to| Axis::linear("", column).named(Vec::new()).range(from, to);
    let top = |row: usize| -(row as f64) * (HIGH + ROOM);
    let mut panel = Panel::new("", axis("across", -0.1, 10.1), axis("up", top(ROWS) + ROOM - 0.15, 0.15));
    for ([left, right], row, colour, texts) in STAGES {
        let (look, top, middle) = (Look::new(colour, Marker::Dot), top(row), 0.5 * (left + right));
        let low = top - HIGH;
        let edge = [(left, top), (right, top), (right, low), (left, low), (left, top)];
        panel.add(Series::line("", look, edge).unlisted());
        let lines = texts.into_iter().zip([0.3, 0.7]).map(|(text, at)| Point::new(middle, top - at).note(text));
        panel.add(Series::new("", Look::new(BLACK, Marker::Dot), Mark::Middle, lines));
    }
    for row in 1..ROWS {
        let tips = [2.4, 7.6].map(|x| Point::new(x, top(row)).from(top(row) + ROOM));
        panel.add(Series::new("", Look::new(BLACK, Marker::Dot), Mark::Arrows, tips));
    }
    Figure {
        name: NAME,
        title: "One explicit time step (the paper's Figures 1 and 3)".to_owned(),
        caption: "Drawn from the program's own step, in the order of the paper's text. All of a step follows from the state at its start."
            .to_owned(),
        height: 330.0,
        panels: vec![panel],
        missing: Vec::new(),
    }
}

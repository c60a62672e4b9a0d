//! Where particles are put when the soil has an outline: a polygon that cuts the squares of the mesh.
//!
//! Every particle stands for one square of the mesh, of edge `spacing` = L over the particles per direction. Clipped
//! ([`parts`]), a square keeps what lies inside the polygon: area and first moment of all parts are those of the
//! polygon, on every mesh. Whole ([`whole`]), a square counts if its middle lies inside: an error of first order.

mod clip;
mod crossing;
mod polygon;

pub use clip::between;
pub use polygon::{Fault, area, centroid, check, depth, folds, inside, length_along, near, passes, touch};

use std::collections::BTreeMap;

use crate::order::sort_by_number;
use crate::scene::Piece;

/// What a particle stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Its centre of area, m.
    pub centroid: [f64; 2],
    /// Its area, m2.
    pub area: f64,
}

/// A part below this share of a square is merged into a neighbour.
const SLIVER: f64 = 0.1;
/// Areas below this share of a square are round-off: a square whose edge lies on the outline.
const NOTHING: f64 = 1e-14;
/// Areas that differ by this share are equal.
const TIE: f64 = 1e-9;

/// Parts of a simple polygon (m, either way round), one for each square of edge `spacing` (m) that it covers, row by row
/// from the bottom. Slivers are merged into the largest neighbour; area and first moment are kept.
pub fn parts(polygon: &[[f64; 2]], spacing: f64) -> Vec<Part> {
    let mut squares = BTreeMap::new();
    let [_, rows] = range(polygon, 1, spacing);
    let [_, columns] = range(polygon, 0, spacing);
    for row in range(polygon, 1, spacing)[0]..rows {
        let strip = between(polygon, 1, row as f64 * spacing, (row + 1) as f64 * spacing);
        for column in range(polygon, 0, spacing)[0]..columns {
            if let Some(part) = of_square(&strip, [column, row], spacing) {
                squares.insert((row, column), part);
            }
        }
    }
    merge(&mut squares, SLIVER * (1.0 + TIE) * spacing * spacing);
    squares.into_values().collect()
}

/// What of a polygon between the lines of a row (m) lies in one square of it, by its place in squares.
pub fn of_square(strip: &[[f64; 2]], place: [usize; 2], spacing: f64) -> Option<Part> {
    let column = place[0] as f64;
    let square = between(strip, 0, column * spacing, (column + 1.0) * spacing);
    // About the middle of the square, where the moments lose no digits.
    let middle = place.map(|i| (i as f64 + 0.5) * spacing);
    let moments = polygon::moments(&square, &middle);
    let moments = moments.map(|m| m * moments[0].signum());
    (moments[0] > NOTHING * spacing * spacing).then(|| of_moments(&middle, &moments))
}

/// Whole squares of edge `spacing` (m) whose middle lies in a simple polygon (m), row by row from the bottom.
pub fn whole(polygon: &[[f64; 2]], spacing: f64) -> Vec<Part> {
    let ([first, rows], [left, columns]) = (range(polygon, 1, spacing), range(polygon, 0, spacing));
    let middles = (first..rows).flat_map(|row| (left..columns).map(move |column| [column, row]));
    let middles = middles.map(|place| place.map(|i| (i as f64 + 0.5) * spacing));
    middles.filter(|x| inside(polygon, x)).map(|centroid| Part { centroid, area: spacing * spacing }).collect()
}

/// Total area (m2) and centre (m) of parts.
pub fn total(parts: &[Part]) -> (f64, [f64; 2]) {
    let area: f64 = parts.iter().map(|part| part.area).sum();
    let moment = |d: usize| parts.iter().map(|part| part.area * part.centroid[d]).sum::<f64>();
    (area, [moment(0) / area, moment(1) / area])
}

/// Which parts lie below the crest of a polygon (m), its highest level edges or else its highest point, and how much of it each
/// has above it, m; in the order of the parts.
pub fn below_crest(polygon: &[[f64; 2]], parts: &[Part], spacing: f64) -> Vec<(usize, f64)> {
    let top = polygon.iter().fold(0.0, |top: f64, x| top.max(x[1]));
    let highest = |x: &[f64; 2]| x[1] >= top * (1.0 - 1e-9);
    let mut level: Vec<[f64; 2]> = Vec::new();
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        if highest(a) && highest(b) {
            level.push([a[0].min(b[0]), a[0].max(b[0])]);
        }
    }
    // In each column of squares the uppermost part.
    let column = |(i, part): (usize, &Part)| ((part.centroid[0] / spacing).floor(), i);
    let mut columns: Vec<(f64, usize)> = parts.iter().enumerate().map(column).collect();
    sort_by_number(&mut columns, |(column, _)| *column);
    let mut below: Vec<(usize, f64)> = Vec::new();
    for column in columns.chunk_by(|a, b| a.0 == b.0) {
        let higher = |best: usize, i: usize| if parts[i].centroid[1] > parts[best].centroid[1] { i } else { best };
        let uppermost = column.iter().fold(column[0].1, |best, (_, i)| higher(best, *i));
        let from = column[0].0 * spacing;
        let width = |[a, b]: &[f64; 2]| (b.min(from + spacing) - a.max(from)).max(0.0);
        let width: f64 = level.iter().map(width).sum();
        // A sliver says little of its edge, and its part may lie below a slope.
        if width > SLIVER * (1.0 + TIE) * spacing {
            below.push((uppermost, width));
        }
    }
    if below.is_empty() {
        let peak = polygon.iter().find(|x| highest(x)).copied().unwrap_or_default();
        let distance = |part: &Part| (part.centroid[0] - peak[0]).hypot(part.centroid[1] - peak[1]);
        let nearest = parts.iter().enumerate().min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        below.extend(nearest.map(|(i, _)| (i, spacing)));
    }
    sort_by_number(&mut below, |(i, _)| *i as f64);
    below
}

/// The outline of a polygon (m, anticlockwise) in pieces, each in one square of edge `spacing` (m).
pub fn pieces(polygon: &[[f64; 2]], spacing: f64) -> impl Iterator<Item = Piece> {
    numbered_pieces(polygon, spacing).map(|(_, piece)| piece)
}

/// The same with the number of the edge that each is of.
pub fn numbered_pieces(polygon: &[[f64; 2]], spacing: f64) -> impl Iterator<Item = (usize, Piece)> {
    polygon.iter().enumerate().flat_map(move |(i, a)| {
        let b = &polygon[(i + 1) % polygon.len()];
        let along = [b[0] - a[0], b[1] - a[1]];
        let mut cuts = vec![0.0, 1.0];
        for d in 0..2 {
            let ends = [a[d].min(b[d]) / spacing, a[d].max(b[d]) / spacing];
            let lines = (ends[0].floor() as i64 + 1)..(ends[1].ceil() as i64);
            cuts.extend(lines.map(|line| (line as f64 * spacing - a[d]) / along[d]));
        }
        cuts.retain(|cut| (0.0..=1.0).contains(cut));
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|b, a| *b - *a < 1e-9);
        let piece = move |ends: &[f64]| {
            let (middle, length) = (0.5 * (ends[0] + ends[1]), ends[1] - ends[0]);
            let middle = [a[0] + middle * along[0], a[1] + middle * along[1]];
            (i, Piece { middle, outward: [length * along[1], -length * along[0]] })
        };
        cuts.windows(2).map(piece).collect::<Vec<_>>()
    })
}

/// Finds the particles beside places on the outline: the nearest one of those in the squares of edge `spacing` (m) around.
pub struct Beside {
    squares: BTreeMap<[i64; 2], Vec<usize>>,
    places: Vec<[f64; 2]>,
    spacing: f64,
}

impl Beside {
    /// Of particles at these places, m.
    pub fn new(places: Vec<[f64; 2]>, spacing: f64) -> Self {
        let mut squares: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
        for (i, place) in places.iter().enumerate() {
            squares.entry(place.map(|x| (x / spacing).floor() as i64)).or_default().push(i);
        }
        Self { squares, places, spacing }
    }

    /// The number of the nearest one to a place (m), if any is near.
    pub fn find(&self, place: &[f64; 2]) -> Option<usize> {
        let [column, row] = place.map(|x| (x / self.spacing).floor() as i64);
        let around = (-2..=2).flat_map(|i| (-2..=2).map(move |j| [column + i, row + j]));
        let near = around.filter_map(|square| self.squares.get(&square)).flatten();
        let distance = |i: &usize| (self.places[*i][0] - place[0]).hypot(self.places[*i][1] - place[1]);
        // Of equals the first: their order is that of the particles.
        near.copied().min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)))
    }
}

/// First square that a polygon may touch along an axis, and the one after the last.
fn range(polygon: &[[f64; 2]], axis: usize, spacing: f64) -> [usize; 2] {
    let along = || polygon.iter().map(|x| x[axis] / spacing);
    let (low, high) = (along().fold(f64::INFINITY, f64::min), along().fold(0.0, f64::max));
    // A square more than round-off may call for: it is empty, and an empty square is no part.
    [low.floor() as usize, high.ceil() as usize + 1]
}

fn of_moments(middle: &[f64; 2], [area, x, y]: &[f64; 3]) -> Part {
    Part { centroid: [middle[0] + x / area, middle[1] + y / area], area: *area }
}

/// Gives every part below `least` (m2) to its largest neighbour, the smallest first.
fn merge(squares: &mut BTreeMap<(usize, usize), Part>, least: f64) {
    let mut slivers: Vec<(usize, usize)> = squares.iter().filter(|(_, p)| p.area < least).map(|(at, _)| *at).collect();
    // Equals from the bottom, which is the same in the mirror.
    slivers.sort_by_key(|at| ((squares[at].area / (TIE * least)).round() as u64, at.0));
    for at in slivers {
        let sliver = squares[&at];
        if sliver.area >= least {
            continue; // it has been given another one
        }
        let Some(neighbour) = largest_neighbour(squares, at) else { continue };
        squares.remove(&at);
        if let Some(part) = squares.get_mut(&neighbour) {
            let area = part.area + sliver.area;
            for d in 0..2 {
                part.centroid[d] += sliver.area / area * (sliver.centroid[d] - part.centroid[d]);
            }
            part.area = area;
        }
    }
}

/// Among the squares that share an edge with one, else a corner.
fn largest_neighbour(
    squares: &BTreeMap<(usize, usize), Part>,
    (row, column): (usize, usize),
) -> Option<(usize, usize)> {
    let around = |edges: bool| {
        let places = (0..9).map(|i| (row + i / 3, column + i % 3)).filter(|(r, c)| *r > 0 && *c > 0);
        let places = places.map(|(r, c)| (r - 1, c - 1)).filter(move |(r, c)| {
            let apart = r.abs_diff(row) + c.abs_diff(column);
            if edges { apart == 1 } else { apart == 2 }
        });
        let there = places.filter(|place| squares.contains_key(place));
        // Of equals, as beside a slope of 45 degrees, the one below or above: round-off would choose another one in the mirror.
        there.reduce(|a, b| {
            let (one, other) = (squares[&a].area, squares[&b].area);
            let tie = (one - other).abs() <= TIE * one.max(other);
            let first = if tie { a.0.abs_diff(row) >= b.0.abs_diff(row) } else { one > other };
            if first { a } else { b }
        })
    };
    around(true).or_else(|| around(false))
}

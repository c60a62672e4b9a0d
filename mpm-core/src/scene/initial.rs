//! The state at t = 0 that a scene gives: along the height, or in a table.

use crate::real::array_of;
use std::sync::Arc;

use nalgebra::{Matrix2, Vector2};
use serde::Serialize;

use super::{Fields, Start};

/// Points of a table that the value at a place follows from.
const NEAREST: usize = 8;
/// Points are in a line where they spread less than this share across it, squared.
const IN_LINE: f64 = 1e-9;

/// A place (m), and the values there of [`Initial::KEYS`], Pa.
pub type Row = ([f64; 2], [f64; 5]);

/// Pore pressure and effective stress at t = 0; beside a geostatic start what is added to its own.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Initial {
    /// Pairs of a height (m) and a value (Pa) of each of [`Self::KEYS`], linear between and beyond; none for zero.
    pub lines: [Vec<[f64; 2]>; 5],
    /// The table that they are from, or that has points in the plane: its path, from where the program runs.
    pub table: Option<String>,
    /// Its points in the plane, by their height.
    #[serde(skip)]
    pub rows: Arc<Vec<Row>>,
}

impl Initial {
    /// What a scene file calls the values, in their order; columns of a table end with `_pa`.
    pub const KEYS: [&str; 5] = ["pressure", "stress_xx", "stress_yy", "stress_zz", "stress_xy"];

    /// Pore pressure and effective stress xx, yy, zz, xy at a place (m), Pa. Among points in the plane they are those of the plane
    /// that fits the nearest ones best, weighted by the inverse squares of their distances: exact at the points and for linear fields.
    pub fn at(&self, place: &[f64; 2]) -> [f64; 5] {
        if self.rows.is_empty() {
            return self.lines.each_ref().map(|line| along(line, place[1]));
        }
        let mut near: Vec<(f64, &Row)> = Vec::with_capacity(NEAREST + 1);
        let (below, above) = self.rows.split_at(self.rows.partition_point(|(x, _)| x[1] < place[1]));
        for half in [&mut below.iter().rev() as &mut dyn Iterator<Item = &Row>, &mut above.iter()] {
            for row in half {
                let [x, y] = array_of::<_, 2, _>(|d| (row.0[d] - place[d]).powi(2));
                if near.len() == NEAREST && y >= near[NEAREST - 1].0 {
                    break;
                }
                near.insert(near.partition_point(|(other, _)| *other <= x + y), (x + y, row));
                near.truncate(NEAREST);
            }
        }
        let (least, nearest) = near[0];
        if least == 0.0 {
            return nearest.1;
        }
        let whole: f64 = near.iter().map(|(distance, _)| least / distance).sum();
        let share = |(distance, (x, v)): &(f64, &Row)| (least / distance / whole, Vector2::from(*x), *v);
        let near: Vec<_> = near.iter().map(share).collect();
        let middle: Vector2<f64> = near.iter().map(|(w, x, _)| *w * x).sum();
        let spread: Matrix2<f64> = near.iter().map(|(w, x, _)| *w * (x - middle) * (x - middle).transpose()).sum();
        // Points in a line say nothing of what is across it.
        let inverse = spread.pseudo_inverse(IN_LINE * spread.trace()).unwrap_or_default();
        let slope = inverse * (Vector2::from(*place) - middle);
        array_of(|i| near.iter().map(|(w, x, v)| w * v[i] * (1.0 + slope.dot(&(x - middle)))).sum())
    }

    /// Heights (m) with the values there (Pa), between which there are none larger.
    pub(super) fn corners(&self) -> impl Iterator<Item = (f64, [f64; 5])> {
        let heights = self.lines.iter().flatten().map(|[y, _]| (*y, self.at(&[0.0, *y])));
        heights.chain(self.rows.iter().map(|([_, y], values)| (*y, *values)))
    }
}

/// The value at a height of pairs of both.
fn along(line: &[[f64; 2]], y: f64) -> f64 {
    let above = line.partition_point(|[height, _]| *height <= y).clamp(1, line.len().max(2) - 1);
    match line {
        [] => 0.0,
        [[_, value]] => *value,
        _ if line[above][0] == line[above - 1][0] => line[above][1],
        _ => {
            let [a, b] = [line[above - 1], line[above]];
            a[1] + (b[1] - a[1]) * (y - a[0]) / (b[0] - a[0])
        }
    }
}

impl Fields {
    /// Largest pore pressure or stress that the scene gives at t = 0, Pa.
    pub(super) fn largest_given(&self) -> f64 {
        let values = self.initial.iter().flat_map(Initial::corners).flat_map(|(_, values)| values);
        values.fold(0.0, |most, value| most.max(value.abs()))
    }

    /// Largest pore pressure (Pa) at t = 0 that may drain: of a whole state what is beyond water at rest up to the top.
    pub(super) fn largest_excess(&self) -> f64 {
        let weight = if self.start == Start::Given { -self.water_weight()[1] } else { 0.0 };
        let excess = |(y, values): (f64, [f64; 5])| values[0] - weight * (self.height - y);
        self.initial.iter().flat_map(Initial::corners).map(excess).fold(0.0, f64::max)
    }
}

//! Stresses of few points in a cell: a polynomial through them works on the strain of the polynomial through theirs.
//!
//! Two points along an edge integrate no product of two slopes of quadratic B-splines exactly, but they carry the slopes: these are
//! linear in a cell. The polynomial of lowest squares through the stresses s of the points of a cell, R s, is integrated by Gauss
//! points, against that through the strains: the work of the cell is `s^T M e` with `M = sum_g w_g R_g^T R_g`. In one dimension
//! that is exact for points at any places; in two it is where strains are of no higher degree than the points carry.

use crate::real::array_of;
use nalgebra::DMatrix;

use super::{Axis, gauss_points};

/// The points of a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Number of the first of them; the others follow.
    pub first: usize,
    /// How many.
    pub count: usize,
    /// M by rows, m3.
    pub shares: Vec<f64>,
}

/// Least singular value, beside the largest, of places that carry a polynomial.
const CARRIED: f64 = 0.02;

/// The points (m) of cells full of soil, in the order of the cells, for B-splines of a degree; `thickness` (m^(3-D)) turns lengths into
/// volumes. `None` where those of a cell do not carry a polynomial of the degree of slopes.
pub fn groups<const D: usize>(
    axes: &[Axis; D],
    degree: usize,
    thickness: f64,
    points: &[[f64; D]],
) -> Option<Vec<Group>> {
    let cell = |x: &[f64; D]| array_of::<usize, D, _>(|d| axes[d].cell(x[d]));
    let mut groups = Vec::new();
    let mut first = 0;
    for of_cell in points.chunk_by(|a, b| cell(a) == cell(b)) {
        let cell = cell(&of_cell[0]);
        let low = array_of(|d| axes[d].knots[cell[d]]);
        let length = array_of(|d| axes[d].length(cell[d]));
        let shares = shares(&low, &length, degree, thickness, of_cell)?;
        groups.push(Group { first, count: of_cell.len(), shares });
        first += of_cell.len();
    }
    let cells: usize = axes.iter().map(Axis::cells).product();
    (groups.len() == cells).then_some(groups)
}

fn shares<const D: usize>(
    low: &[f64; D],
    length: &[f64; D],
    degree: usize,
    thickness: f64,
    points: &[[f64; D]],
) -> Option<Vec<f64>> {
    let local = |x: &[f64; D]| array_of::<f64, D, _>(|d| 2.0 * (x[d] - low[d]) / length[d] - 1.0);
    let rule = gauss_points(degree);
    let volume: f64 = length.iter().product::<f64>() * thickness;
    // Powers below the degree, along every axis.
    let terms = degree.pow(D as u32);
    let term = |x: &[f64; D], number: usize| {
        let mut rest = number;
        x.iter().fold(1.0, |product, x| {
            let power = rest % degree;
            rest /= degree;
            product * x.powi(power as i32)
        })
    };
    // A place that is no number, or far outside, is one of a state in pieces: no decomposition ends with it.
    let inside = |x: &[f64; D]| local(x).iter().all(|x| x.abs() < 2.0);
    if points.len() < terms || !points.iter().all(inside) {
        return None;
    }
    let decomposed = DMatrix::from_fn(points.len(), terms, |q, t| term(&local(&points[q]), t)).svd(true, true);
    let singular = &decomposed.singular_values;
    if singular.min() < CARRIED * singular.max() {
        return None;
    }
    let inverse = decomposed.pseudo_inverse(0.0).ok()?;
    let mut shares = vec![0.0; points.len() * points.len()];
    for number in 0..rule.len().pow(D as u32) {
        let (mut rest, mut weight) = (number, volume);
        let at: [f64; D] = array_of(|_| {
            let (xi, share) = rule[rest % rule.len()];
            rest /= rule.len();
            weight *= share;
            2.0 * xi - 1.0
        });
        let row: Vec<f64> =
            (0..points.len()).map(|q| (0..terms).map(|t| term(&at, t) * inverse[(t, q)]).sum()).collect();
        for (a, of_a) in row.iter().enumerate() {
            for (b, of_b) in row.iter().enumerate() {
                shares[a * points.len() + b] += weight * of_a * of_b;
            }
        }
    }
    Some(shares)
}

#[cfg(test)]
mod tests {
    use super::super::Basis;
    use super::*;

    #[test]
    fn products_of_linear_fields_are_integrated_exactly() {
        let axes = [Axis::new(0.0, 0.5, 0.1, 0.0, 0.5, Basis::Splines { degree: 2 })];
        let points: Vec<[f64; 1]> = (0..10).map(|i| [0.025 + 0.05 * f64::from(i) + 0.004 * f64::from(i % 3)]).collect();
        let groups = groups(&axes, 2, 2.0, &points).expect("points in every cell");
        let (a, b) = (|x: f64| 1.0 + 3.0 * x, |x: f64| 2.0 - 5.0 * x);
        let mut sum = 0.0;
        for Group { first, count, shares } in groups {
            for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
                sum += shares[i * count + j] * a(points[first + i][0]) * b(points[first + j][0]);
            }
        }
        // 2 int (2 + x - 15 x^2) dx
        let exact = 2.0 * (1.0 + 0.125 - 5.0 * 0.125);
        assert!((sum - exact).abs() < 1e-13, "{sum} {exact}");
    }

    #[test]
    fn few_points_or_points_on_a_line_carry_nothing() {
        let axes = [0.2, 0.1].map(|high| Axis::new(0.0, high, 0.1, 0.0, 0.5, Basis::Splines { degree: 2 }));
        let left = [[0.02, 0.02], [0.08, 0.02], [0.02, 0.09], [0.07, 0.08]];
        let right = left.map(|[x, y]| [x + 0.1, y]);
        let of = |left: &[[f64; 2]]| groups(&axes, 2, 1.0, &[left, &right[..]].concat());
        let all = of(&left).expect("points in both");
        assert!(all.iter().all(|group| (group.shares.iter().sum::<f64>() - 0.01).abs() < 1e-15));
        assert_eq!([of(&left[..3]), of(&[]), of(&left.map(|[x, _]| [x, 0.05]))], [None, None, None]);
        assert_eq!([of(&left.map(|[_, y]| [f64::NAN, y])), of(&left.map(|[_, y]| [-1e300, y]))], [None, None]);
    }
}

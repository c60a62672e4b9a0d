//! Two edges of a polygon that meet where they should not, found by a sweep in O(N log N) (Shamos & Hoey 1976, Geometric
//! intersection problems, 17th Symposium on Foundations of Computer Science, 208-215).
//!
//! A line goes over the plane from left to right, from below where two points lie above each other. The edges that it meets are kept in
//! their order along it. Edges that meet are neighbours in that order at some corner before, or at, the first point where they do.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::Bound;

use super::polygon::{touch, turn};

/// An edge that the line meets.
#[derive(Debug, Clone, Copy)]
struct Edge {
    /// Where the line comes to it and where it leaves it, m.
    ends: [[f64; 2]; 2],
    /// Its place in the polygon.
    number: usize,
}

/// The order in which the line comes to two points (m).
fn sooner(a: &[f64; 2], b: &[f64; 2]) -> Ordering {
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
}

impl Edge {
    /// The side of this edge on which one lies that the line comes to later: above it, below it, or on its line.
    fn side(&self, later: &Self) -> Ordering {
        let [a, b] = &self.ends;
        let above = |x: &[f64; 2]| turn(a, b, x).total_cmp(&0.0);
        let zero = |x: &[f64; 2]| turn(a, b, x) == 0.0;
        match later.ends.iter().find(|x| !zero(x)) {
            Some(x) => above(x),
            None => Ordering::Equal,
        }
    }
}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        let first = sooner(&self.ends[0], &other.ends[0]).then(self.number.cmp(&other.number));
        let order = match first {
            Ordering::Equal => return Ordering::Equal,
            Ordering::Less => self.side(other).reverse(),
            Ordering::Greater => other.side(self),
        };
        order.then(self.number.cmp(&other.number))
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Edge {
    fn eq(&self, other: &Self) -> bool {
        self.number == other.number
    }
}

impl Eq for Edge {}

/// Two edges of a polygon of `count` edges that have a point in common without sharing a corner, by their places. No edge is without
/// length, and none lies on the next one.
pub(super) fn find(count: usize, edge: &dyn Fn(usize) -> [[f64; 2]; 2]) -> Option<(usize, usize)> {
    let meet = |a: &Edge, b: &Edge| {
        let apart = a.number.abs_diff(b.number);
        (apart > 1 && apart + 1 < count && touch(&a.ends, &b.ends)).then_some((a.number, b.number))
    };
    let edges: Vec<Edge> = (0..count)
        .map(|number| {
            // There is one zero: -0.0 would be another place in the order.
            let mut ends = edge(number).map(|x| x.map(|x| x + 0.0));
            ends.sort_by(sooner);
            Edge { ends, number }
        })
        .collect();
    // Corners in the order of the line; those that begin an edge before those that end one, so that edges that only touch are met together.
    let mut corners: Vec<(usize, usize)> = (0..count).flat_map(|number| [(number, 0), (number, 1)]).collect();
    let at = |(number, end): &(usize, usize)| edges[*number].ends[*end];
    corners.sort_by(|a, b| sooner(&at(a), &at(b)).then(a.1.cmp(&b.1)));
    let mut line: BTreeSet<Edge> = BTreeSet::new();
    for (number, end) in corners {
        let edge = edges[number];
        let (there, begins) = (line.contains(&edge), end == 0);
        if there == begins {
            // The order was lost to round-off, among edges that all but touch: every pair is asked.
            return pairs(&edges, &meet);
        }
        let below = line.range((Bound::Unbounded, Bound::Excluded(edge))).next_back();
        let above = line.range((Bound::Excluded(edge), Bound::Unbounded)).next();
        let found = if begins {
            below.and_then(|below| meet(below, &edge)).or_else(|| above.and_then(|above| meet(&edge, above)))
        } else {
            below.zip(above).and_then(|(below, above)| meet(below, above))
        };
        if found.is_some() {
            return found;
        }
        if begins {
            line.insert(edge);
        } else {
            line.remove(&edge);
        }
    }
    None
}

/// Whether and where two edges meet: their numbers.
type Meet<'a> = dyn Fn(&Edge, &Edge) -> Option<(usize, usize)> + 'a;

fn pairs(edges: &[Edge], meet: &Meet) -> Option<(usize, usize)> {
    edges.iter().enumerate().find_map(|(i, a)| edges[i + 1..].iter().find_map(|b| meet(a, b)))
}

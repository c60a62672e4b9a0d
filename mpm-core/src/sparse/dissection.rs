//! Nested dissection of a mesh whose unknowns have places (George 1973, SIAM J. Numer. Anal. 10, 345-363).
//!
//! A line of unknowns that cuts a mesh in two comes last, after both halves, which are cut again: the factors of n unknowns of a
//! plane have O(n log n) entries, and take O(n^1.5) operations. Minimum degree finds about as good an order of a small mesh, and a
//! worse one the larger the mesh is.

use super::Sparse;

/// Unknowns that are not worth a further cut.
const LEAF: usize = 24;
/// An unknown with so many times as many neighbours as there are unknowns along a side comes last: a rigid plate, or a box.
const DENSE: f64 = 10.0;

/// The unknowns of a matrix in the order of their elimination; `places`: where each stands, on any lattice.
pub(super) fn dissected(matrix: &Sparse, places: &[[u32; 2]]) -> Vec<usize> {
    let size = matrix.size();
    let mut degree = vec![0_u32; size];
    for j in 0..size {
        for i in matrix.rows(j) {
            degree[*i] += 1;
            degree[j] += 1;
        }
    }
    let most = DENSE * (size as f64).sqrt();
    let (dense, mut items): (Vec<usize>, Vec<usize>) = (0..size).partition(|i| f64::from(degree[*i]) > most);
    let mut cut = Cut { matrix, places, side: vec![0; size], sides: 0 };
    cut.order(&mut items);
    items.extend(dense);
    items
}

struct Cut<'a> {
    matrix: &'a Sparse,
    places: &'a [[u32; 2]],
    /// Of every unknown the half that it was in last: an even number, or the odd one after it.
    side: Vec<u32>,
    sides: u32,
}

impl Cut<'_> {
    /// Brings some unknowns into order.
    fn order(&mut self, items: &mut [usize]) {
        let Some(axis) = self.longer(items).filter(|_| items.len() > LEAF) else { return };
        let middle = items.len() / 2;
        let places = self.places;
        let at = |item: &usize| places[*item][axis];
        // Ties by number: the order must not depend on how a median is found.
        let median = at(items.select_nth_unstable_by_key(middle, |item| (at(item), *item)).1);
        let least = items.iter().map(at).min().unwrap_or(median);
        let first = median.max(least + 1); // of the upper half
        self.sides += 2;
        for item in &*items {
            self.side[*item] = self.sides + u32::from(at(item) >= first);
        }
        // Of two neighbours on either side the upper one belongs to the cut.
        let mut of_cut = Vec::new();
        for &j in &*items {
            for &i in self.matrix.rows(j) {
                if self.side[i] ^ self.side[j] == 1 {
                    of_cut.push(if self.side[i] > self.side[j] { i } else { j });
                }
            }
        }
        for item in of_cut {
            self.side[item] = 0;
        }
        let rank = |side: u32| if side == 0 { 2 } else { side & 1 };
        items.sort_by_key(|item| (rank(self.side[*item]), places[*item][1 - axis], *item));
        let low = items.partition_point(|item| rank(self.side[*item]) == 0);
        let high = items.partition_point(|item| rank(self.side[*item]) < 2);
        self.order(&mut items[..low]);
        self.order(&mut items[low..high]);
    }

    /// The axis along which some unknowns reach farther; nothing where all stand in one place.
    fn longer(&self, items: &[usize]) -> Option<usize> {
        let reach = [0, 1].map(|axis| {
            let along = || items.iter().map(|item| self.places[*item][axis]);
            along().max().unwrap_or(0) - along().min().unwrap_or(0)
        });
        let axis = usize::from(reach[1] > reach[0]);
        (reach[axis] > 0).then_some(axis)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Factor, Ordering, Signs};
    use super::*;

    /// Unknowns of a square, each joined with its neighbours; with one more that is joined with all if there is a plate.
    fn square(side: usize, plate: bool) -> (Sparse, Vec<[u32; 2]>) {
        let number = |i: usize, j: usize| j * side + i;
        let cells = (0..side - 1).flat_map(move |j| (0..side - 1).map(move |i| (i, j)));
        let ends = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let of_cell = move |(i, j): (usize, usize)| {
            (0..16).map(move |k: usize| {
                let ([a, b], [c, d]) = (ends[k / 4].into(), ends[k % 4].into());
                (number(i + a, j + b), number(i + c, j + d))
            })
        };
        let count = side * side;
        let with = (0..if plate { count } else { 0 }).map(move |i| (i, count));
        let mut places: Vec<[u32; 2]> = (0..count).map(|n| [(n % side) as u32, (n / side) as u32]).collect();
        places.extend(plate.then_some([0, 0]));
        (Sparse::symmetric(places.len(), cells.flat_map(of_cell).chain(with)), places)
    }

    #[test]
    fn the_order_has_every_unknown_once_and_a_plate_last() {
        for plate in [false, true] {
            let (matrix, places) = square(23, plate);
            let order = dissected(&matrix, &places);
            assert!(!plate || order.last() == Some(&(places.len() - 1)));
            let mut sorted = order;
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..places.len()));
        }
    }

    #[test]
    fn the_factors_grow_as_n_log_n() {
        // Entries per unknown: a straight line over the logarithm of the size, so the differences of doublings agree.
        let per_unknown = |side: usize| {
            let (matrix, places) = square(side, false);
            let factor = Factor::new(&matrix, Signs::Definite, Ordering::Dissected(&places)).expect("a pattern");
            factor.fill() as f64 / matrix.size() as f64
        };
        let [a, b, c] = [32, 64, 128].map(per_unknown);
        assert!(c - b < 1.3 * (b - a), "{a} {b} {c}");
    }
}

//! Small symmetric systems with a narrow band, factorised anew in every step: Cholesky inside the envelope.
//!
//! Row i of the factor reaches from its first entry to the diagonal (Jennings 1966, doi:10.1093/comjnl/9.3.281). The pattern may
//! change from one step to the next at no cost, which a library's symbolic factorisation does not allow.

/// Rows that are factorised side by side: the CPU works on one while it waits for another.
const ROWS: usize = 4;

/// A symmetric positive definite matrix by rows of its lower triangle, and its factor in the same place.
#[derive(Debug, Clone, Default)]
pub struct Envelope {
    first: Vec<usize>,
    start: Vec<usize>,
    values: Vec<f64>,
}

impl Envelope {
    /// Zeros with row i from column `first(i)` on.
    pub fn clear(&mut self, size: usize, first: impl Fn(usize) -> usize) {
        self.first.clear();
        self.start.clear();
        self.start.push(0);
        for row in 0..size {
            let from = first(row).min(row);
            self.first.push(from);
            self.start.push(self.start[row] + row - from + 1);
        }
        self.values.clear();
        self.values.resize(self.start[size], 0.0);
    }

    /// Zeros in the rows that there are.
    pub fn empty(&mut self) {
        self.values.fill(0.0);
    }

    /// Rows.
    pub fn size(&self) -> usize {
        self.first.len()
    }

    /// Adds to an entry, which stands for both triangles.
    #[inline]
    pub fn add(&mut self, a: usize, b: usize, value: f64) {
        let (row, column) = (a.max(b), a.min(b));
        self.values[self.start[row] + column - self.first[row]] += value;
    }

    /// Solves `A x = b` in place; the matrix becomes its factor. The row of a pivot that is not positive, if there is one.
    ///
    /// # Errors
    /// The matrix is not positive definite.
    pub fn solve(&mut self, x: &mut [f64]) -> Result<(), usize> {
        // Sums of products as wide as the CPU has them: no product is fused with a sum, and the bits are the same.
        pulp::Arch::new().dispatch(|| self.factor_and_solve(x))
    }

    /// The pivot of a row whose entries are those of the factor.
    #[inline(always)]
    fn take_root(&mut self, row: usize) -> Result<(), usize> {
        let here = &mut self.values[self.start[row]..self.start[row + 1]];
        let last = here.len() - 1;
        let pivot = here[last] - dot(&here[..last], &here[..last]);
        if pivot <= 0.0 || pivot.is_nan() {
            return Err(row);
        }
        here[last] = pivot.sqrt();
        Ok(())
    }

    /// The entry of a row of the factor in a column of its envelope, those before it known.
    #[inline(always)]
    fn eliminate(&mut self, row: usize, column: usize) {
        let (first, other_first) = (self.first[row], self.first[column]);
        if column < first {
            return;
        }
        let (done, here) = self.values.split_at_mut(self.start[row]);
        let other = &done[self.start[column]..self.start[column + 1]];
        let from = first.max(other_first);
        let sum = dot(&here[from - first..column - first], &other[from - other_first..column - other_first]);
        here[column - first] = (here[column - first] - sum) / other[column - other_first];
    }

    #[inline(always)]
    fn factor_and_solve(&mut self, x: &mut [f64]) -> Result<(), usize> {
        for block in (0..self.size()).step_by(ROWS) {
            let rows = block..(block + ROWS).min(self.size());
            let lowest = rows.clone().map(|row| self.first[row]).min().unwrap_or(block);
            for column in lowest..rows.end {
                if column >= block {
                    self.take_root(column)?;
                }
                for row in rows.start.max(column + 1)..rows.end {
                    self.eliminate(row, column);
                }
            }
        }
        for row in 0..self.size() {
            let (first, values) = (self.first[row], &self.values[self.start[row]..self.start[row + 1]]);
            x[row] = (x[row] - dot(&values[..row - first], &x[first..row])) / values[row - first];
        }
        for row in (0..self.size()).rev() {
            let (first, values) = (self.first[row], &self.values[self.start[row]..self.start[row + 1]]);
            x[row] /= values[row - first];
            let found = x[row];
            for (x, value) in x[first..row].iter_mut().zip(values) {
                *x -= value * found;
            }
        }
        Ok(())
    }
}

/// Sum of products, in four strands that the CPU can add side by side.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut strands = [0.0; 4];
    let (fours_a, fours_b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = fours_a.remainder().iter().zip(fours_b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in fours_a.zip(fours_b) {
        for i in 0..4 {
            strands[i] += a[i] * b[i];
        }
    }
    (strands[0] + strands[1]) + (strands[2] + strands[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_solve_their_equation() {
        let size = 40;
        let first = |row: usize| row.saturating_sub(3 + row % 5);
        let entry = |a: usize, b: usize| if a == b { 9.0 + a as f64 } else { ((a * 7 + b * 3) % 5) as f64 / 3.0 - 0.6 };
        let mut matrix = Envelope::default();
        matrix.clear(size, first);
        let want: Vec<f64> = (0..size).map(|i| (i as f64).sin()).collect();
        let mut x = vec![0.0; size];
        for row in 0..size {
            for column in first(row)..=row {
                matrix.add(column, row, entry(row, column));
                x[row] += entry(row, column) * want[column];
                if column != row {
                    x[column] += entry(row, column) * want[row];
                }
            }
        }
        matrix.solve(&mut x).expect("a positive definite matrix");
        assert!(x.iter().zip(&want).all(|(found, want)| (found - want).abs() < 1e-13), "{x:?}");
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused() {
        let mut matrix = Envelope::default();
        matrix.clear(2, |_| 0);
        matrix.add(0, 0, 1.0);
        matrix.add(1, 1, 1.0);
        matrix.add(0, 1, 2.0);
        assert_eq!(matrix.solve(&mut [1.0, 1.0]), Err(1));
    }
}

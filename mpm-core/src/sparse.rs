//! Sparse systems, symmetric or not: the pattern once, then refill, factorise, solve and check the residual (faer).
//!
//! Sparse Cholesky does not pivot, and a matrix that is singular to working precision may pass it without an error.
//! So every solution is put back into its equation; a wrong one is refused with its residual. The first factors of a definite
//! matrix also solve for a right-hand side that has a part in any null space: a run whose own right-hand sides have none
//! there, as in a closed box at rest, would go on with whatever round-off makes of it.

mod dissection;

use faer::Conj;
use faer::Par;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::mat::MatMut;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::linalg::lu::{LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Side, Spec};

/// Largest residual of a solution, as a share of the largest right-hand side.
pub const RESIDUAL: f64 = 1e-8;
/// Rows of very different size, as those of layers, leave more of a small right-hand side: a solution is good that solves a
/// system with entries off by no more than this share (Oettli & Prager 1964, Numer. Math. 6, 405-409).
const BACKWARD: f64 = 1e-14;
/// What such a solution still changes by, as a share of itself, when its residual is solved for.
const SETTLED: f64 = 1e-4;
/// Residuals above this are lowered by putting them on the right-hand side once more.
const REFINE: f64 = 1e-13;
/// A solution this much larger than `||b||/||A||` means a singular matrix: nothing but round-off holds it.
const GROWTH: f64 = 1e14;

/// A system that could not be solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unsolved {
    /// The factorisation stopped.
    #[error("a singular system: {0}")]
    Factor(String),
    /// The solution does not solve its equation.
    #[error("a singular system: residual {found:.1e} of the right-hand side, expected at most {RESIDUAL:.0e}")]
    Residual {
        /// `max |A x - b| / max |b|`.
        found: f64,
    },
    /// The solution is out of all proportion.
    #[error("a singular system: a solution {found:.1e} times larger than its right-hand side explains")]
    Growth {
        /// `max |x| max |A| / max |b|`.
        found: f64,
    },
}

/// A square matrix with a fixed pattern, stored by columns; of a symmetric one the upper triangle.
#[derive(Debug, Clone, PartialEq)]
pub struct Sparse {
    symmetric: bool,
    column: Vec<usize>,
    row: Vec<usize>,
    /// Values in the order of the pattern.
    pub values: Vec<f64>,
}

impl Sparse {
    /// A symmetric matrix of zeros with `size` rows; `pairs` names its entries in any order, either triangle, repeated or
    /// not. The diagonal is always there.
    pub fn symmetric(size: usize, pairs: impl Iterator<Item = (usize, usize)> + Clone) -> Self {
        Self::with(true, size, pairs.map(|(a, b)| (a.min(b), a.max(b))))
    }

    /// A matrix that may not be symmetric, with entries on both sides of the diagonal for every pair.
    pub fn general(size: usize, pairs: impl Iterator<Item = (usize, usize)> + Clone) -> Self {
        Self::with(false, size, pairs.flat_map(|(a, b)| [(a, b), (b, a)]))
    }

    /// Of pairs of a row and a column.
    fn with(symmetric: bool, size: usize, pairs: impl Iterator<Item = (usize, usize)> + Clone) -> Self {
        // Rows by columns as they come, each column from `start` on, the diagonal first.
        let mut start = vec![1_u32; size + 1];
        pairs.clone().for_each(|(_, j)| start[j] += 1);
        let mut sum = 0;
        for at in &mut start {
            sum += std::mem::replace(at, sum);
        }
        let mut next = start.clone();
        let mut named = vec![0_u32; start[size] as usize];
        for (i, j) in (0..size).map(|j| (j, j)).chain(pairs) {
            named[next[j] as usize] = i as u32;
            next[j] += 1;
        }
        // Each row once, in order.
        let (mut column, mut row) = (Vec::with_capacity(size + 1), Vec::new());
        let mut seen = next; // the last column a row was seen in
        seen.fill(u32::MAX);
        column.push(0);
        for j in 0..size {
            let first = row.len();
            for i in &named[start[j] as usize..start[j + 1] as usize] {
                if std::mem::replace(&mut seen[*i as usize], j as u32) != j as u32 {
                    row.push(*i as usize);
                }
            }
            row[first..].sort_unstable();
            column.push(row.len());
        }
        Self { symmetric, column, values: vec![0.0; row.len()], row }
    }

    /// Whether it is symmetric by its storage.
    pub fn is_symmetric(&self) -> bool {
        self.symmetric
    }

    /// Rows (and columns).
    pub fn size(&self) -> usize {
        self.column.len() - 1
    }

    /// Place of an entry in [`Self::values`].
    ///
    /// # Panics
    /// The entry is not in the pattern.
    #[inline]
    pub fn place(&self, a: usize, b: usize) -> usize {
        let (i, j) = if self.symmetric { (a.min(b), a.max(b)) } else { (a, b) };
        let (first, last) = (self.column[j], self.column[j + 1]);
        first + self.row[first..last].binary_search(&i).expect("an entry of the pattern")
    }

    /// Adds to an entry; off the diagonal of a symmetric matrix it stands for both triangles.
    #[inline]
    pub fn add(&mut self, a: usize, b: usize, value: f64) {
        let place = self.place(a, b);
        self.values[place] += value;
    }

    /// Adds to an entry and the one on the other side of the diagonal.
    #[inline]
    pub fn add_both(&mut self, a: usize, b: usize, value: f64) {
        self.add(a, b, value);
        if !self.symmetric && a != b {
            self.add(b, a, value);
        }
    }

    /// `y = A x`.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.add_product(1.0, x, y);
    }

    /// `y += factor A x`.
    pub fn add_product(&self, factor: f64, x: &[f64], y: &mut [f64]) {
        for j in 0..self.size() {
            let (xj, mut sum) = (factor * x[j], 0.0);
            for k in self.column[j]..self.column[j + 1] {
                let (i, value) = (self.row[k], self.values[k]);
                y[i] += value * xj;
                if self.symmetric && i != j {
                    sum += value * x[i];
                }
            }
            y[j] += factor * sum;
        }
    }

    /// Adds `|A| |x|` to `y`.
    fn add_sizes(&self, x: &[f64], y: &mut [f64]) {
        for j in 0..self.size() {
            for k in self.column[j]..self.column[j + 1] {
                let (i, value) = (self.row[k], self.values[k].abs());
                y[i] += value * x[j].abs();
                if self.symmetric && i != j {
                    y[j] += value * x[i].abs();
                }
            }
        }
    }

    /// Rows of the entries of a column: of a symmetric matrix those down to its diagonal.
    fn rows(&self, column: usize) -> &[usize] {
        &self.row[self.column[column]..self.column[column + 1]]
    }

    fn pattern(&self) -> SymbolicSparseColMatRef<'_, usize> {
        SymbolicSparseColMatRef::new_checked(self.size(), self.size(), &self.column, None, &self.row)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        (self.column.capacity() + self.row.capacity()) * size_of::<usize>() + self.values.capacity() * size_of::<f64>()
    }
}

/// What is known of the signs of a matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signs {
    /// All eigenvalues positive: `L L^T`.
    Definite,
    /// A positive definite block beside a negative definite one: `L D L^T` exists in any order (Vanderbei 1995,
    /// SIAM J. Optim. 5, 100-113).
    QuasiDefinite,
    /// Nothing: `L U` with rows exchanged for large pivots. For matrices that are not symmetric.
    Unknown,
}

/// Order of elimination.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ordering<'a> {
    /// As numbered: right for a narrow band. Not for `L U`, whose columns are always ordered by minimum degree.
    AsNumbered,
    /// Approximate minimum degree.
    MinimumDegree,
    /// Nested dissection of a mesh in the plane, by the place of every unknown on any lattice. Not for `L U`.
    Dissected(&'a [[u32; 2]]),
}

/// The factors.
enum Parts {
    Cholesky { symbolic: SymbolicCholesky<usize>, values: Vec<f64> },
    Lu { symbolic: SymbolicLu<usize>, numeric: NumericLu<usize, f64> },
}

/// A factorisation whose pattern is kept.
pub struct Factor {
    parts: Parts,
    signs: Signs,
    buffer: MemBuffer,
    residual: Vec<f64>,
    largest: f64,
    probed: bool,
}

impl std::fmt::Debug for Factor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Factor").field("signs", &self.signs).field("fill", &self.fill()).finish_non_exhaustive()
    }
}

impl Factor {
    /// Symbolic factorisation of a pattern.
    ///
    /// # Errors
    /// Out of memory.
    pub fn new(matrix: &Sparse, signs: Signs, ordering: Ordering<'_>) -> Result<Self, Unsolved> {
        if signs == Signs::Unknown {
            return Self::lu(matrix);
        }
        let order = match ordering {
            Ordering::Dissected(places) => dissection::dissected(matrix, places),
            _ => Vec::new(),
        };
        let mut place_of = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, unknown)| place_of[*unknown] = place);
        let order = match ordering {
            Ordering::AsNumbered => SymmetricOrdering::Identity,
            Ordering::MinimumDegree => SymmetricOrdering::Amd,
            Ordering::Dissected(_) => SymmetricOrdering::Custom(PermRef::new_checked(&order, &place_of, order.len())),
        };
        let symbolic =
            factorize_symbolic_cholesky(matrix.pattern(), Side::Upper, order, CholeskySymbolicParams::default())
                .map_err(|e| Unsolved::Factor(format!("{e:?}")))?;
        let factor = match signs {
            Signs::Definite => symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default()),
            _ => symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Spec::default()),
        };
        let solve = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        Ok(Self {
            parts: Parts::Cholesky { values: vec![0.0; symbolic.len_val()], symbolic },
            buffer: MemBuffer::new(StackReq::or(factor, solve)),
            residual: vec![0.0; matrix.size()],
            largest: 0.0,
            probed: signs != Signs::Definite, // blocks of different units: no growth says anything
            signs,
        })
    }

    fn lu(matrix: &Sparse) -> Result<Self, Unsolved> {
        let symbolic = factorize_symbolic_lu(matrix.pattern(), LuSymbolicParams::default())
            .map_err(|e| Unsolved::Factor(format!("{e:?}")))?;
        let factor = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Spec::default());
        let solve = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        Ok(Self {
            parts: Parts::Lu { symbolic, numeric: NumericLu::new() },
            buffer: MemBuffer::new(StackReq::or(factor, solve)),
            residual: vec![0.0; matrix.size()],
            largest: 0.0,
            probed: true,
            signs: Signs::Unknown,
        })
    }

    /// Numeric factorisation of a matrix with the pattern of [`Self::new`]. No allocation after the first, but of `L U`,
    /// whose fill depends on its pivots.
    ///
    /// # Errors
    /// A pivot of the wrong sign or zero, or a first matrix that only round-off keeps from being singular.
    pub fn refresh(&mut self, matrix: &Sparse) -> Result<(), Unsolved> {
        let a = SparseColMatRef::new(matrix.pattern(), &matrix.values);
        let stack = MemStack::new(&mut self.buffer);
        self.largest = matrix.values.iter().fold(0.0, |m, v| f64::max(m, v.abs()));
        let broken = |e: &dyn std::fmt::Debug| Unsolved::Factor(format!("{e:?}"));
        match &mut self.parts {
            Parts::Cholesky { symbolic, values } if self.signs == Signs::Definite => {
                let none = LltRegularization::default();
                symbolic
                    .factorize_numeric_llt(values, a, Side::Upper, none, Par::Seq, stack, Spec::default())
                    .map_err(|e| broken(&e))?;
            }
            Parts::Cholesky { symbolic, values } => {
                let none = LdltRegularization::default();
                symbolic
                    .factorize_numeric_ldlt(values, a, Side::Upper, none, Par::Seq, stack, Spec::default())
                    .map_err(|e| broken(&e))?;
            }
            Parts::Lu { symbolic, numeric } => {
                symbolic.factorize_numeric_lu(numeric, a, Par::Seq, stack, Spec::default()).map_err(|e| broken(&e))?;
            }
        }
        if std::mem::replace(&mut self.probed, true) { Ok(()) } else { self.probe(matrix.size()) }
    }

    /// Solves for a right-hand side that no null space of a mesh is at right angles to.
    #[cold]
    fn probe(&mut self, size: usize) -> Result<(), Unsolved> {
        let mut x: Vec<f64> = (0..size).map(|i| 1.0 + (i as f64).sin()).collect();
        self.substitute(&mut x);
        let found = largest(&x) * self.largest / 2.0;
        if found <= GROWTH { Ok(()) } else { Err(Unsolved::Growth { found }) }
    }

    /// Solves `A x = b` with the factors of the last [`Self::refresh`] and checks the residual. No allocation.
    ///
    /// # Errors
    /// A residual above [`RESIDUAL`], or a solution that only round-off holds.
    pub fn solve(&mut self, matrix: &Sparse, b: &[f64], x: &mut [f64]) -> Result<(), Unsolved> {
        x.copy_from_slice(b);
        self.substitute(x);
        let size = largest(b);
        let mut found = self.residual_of(matrix, b, x);
        if found > REFINE * size && found.is_finite() {
            let mut correction = std::mem::take(&mut self.residual);
            self.substitute(&mut correction);
            for (x, c) in x.iter_mut().zip(&correction) {
                *x += c;
            }
            self.residual = correction;
            found = self.residual_of(matrix, b, x);
        }
        if found.is_nan() || (found > RESIDUAL * size && !self.holds_backward(matrix, b, x)) {
            return Err(Unsolved::Residual { found: found / size });
        }
        let growth = largest(x) * self.largest;
        if growth > GROWTH * size {
            return Err(Unsolved::Growth { found: growth / size });
        }
        Ok(())
    }

    /// Whether the residual at hand is no more than entries off by [`BACKWARD`] explain, row by row, and solving for it
    /// would hardly change the solution: of a singular system it would change all.
    #[cold]
    fn holds_backward(&mut self, matrix: &Sparse, b: &[f64], x: &[f64]) -> bool {
        let mut scale: Vec<f64> = b.iter().map(|b| b.abs()).collect(); // once in a while: kept by nobody
        matrix.add_sizes(x, &mut scale);
        let mut correction = self.residual.clone();
        self.substitute(&mut correction);
        self.residual.iter().zip(&scale).all(|(r, size)| r.abs() <= BACKWARD * size)
            && largest(&correction) <= SETTLED * largest(x)
    }

    /// `b - A x` into [`Self::residual`], and its largest entry.
    fn residual_of(&mut self, matrix: &Sparse, b: &[f64], x: &[f64]) -> f64 {
        self.residual.copy_from_slice(b);
        matrix.add_product(-1.0, x, &mut self.residual);
        largest(&self.residual)
    }

    fn substitute(&mut self, x: &mut [f64]) {
        let size = x.len();
        let stack = MemStack::new(&mut self.buffer);
        let x = MatMut::from_column_major_slice_mut(x, size, 1);
        match &self.parts {
            Parts::Cholesky { symbolic, values } if self.signs == Signs::Definite => {
                LltRef::<usize, f64>::new(symbolic, values).solve_in_place_with_conj(Conj::No, x, Par::Seq, stack);
            }
            Parts::Cholesky { symbolic, values } => {
                LdltRef::<usize, f64>::new(symbolic, values).solve_in_place_with_conj(Conj::No, x, Par::Seq, stack);
            }
            Parts::Lu { symbolic, numeric } => {
                LuRef::new_unchecked(symbolic, numeric).solve_in_place_with_conj(Conj::No, x, Par::Seq, stack);
            }
        }
    }

    /// Entries of the factor.
    pub fn fill(&self) -> usize {
        match &self.parts {
            Parts::Cholesky { values, .. } => values.len(),
            Parts::Lu { .. } => 0, // not told
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        (self.fill() + self.residual.capacity()) * size_of::<f64>()
    }
}

/// Largest magnitude; NaN if there is one.
fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, v| if v.is_nan() || m.is_nan() { f64::NAN } else { f64::max(m, v.abs()) })
}

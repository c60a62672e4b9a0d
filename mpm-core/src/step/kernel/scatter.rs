//! From the cells of a strip to its nodes, so many cells at once: upper nodes are begun, lower ones ended. A node gets what the cells
//! around it give in the order of the cells, however many are taken at once.

use pulp::Simd;

use super::{Given, MOST_REACH};
use crate::real::{MAX_LANES, Real, SimdReal, array};
use crate::step::store::Frame;
use crate::step::store::nodes::{SUMS, StripSums, sums};

/// What cells give to nodes beyond their own lanes waits here for the next cells.
#[repr(C, align(64))]
///
/// `reach` of its functions is how many of them a cell reaches along an axis: an argument, so that it is a constant where they are inlined.
pub struct Scatter<V: Simd, const D: usize> {
    /// By row of functions, column, sum.
    carry: [[[SimdReal<V>; SUMS]; MOST_REACH]; MOST_REACH],
    /// Holds in the lanes below a number.
    below: [V::m64s; MOST_REACH],
    row: usize,
    /// Whether anything waits.
    carries: bool,
}

impl<V: Simd, const D: usize> Scatter<V, D> {
    /// Whether a vector has a lane for each function of a row.
    #[inline(always)]
    fn fits(reach: usize) -> bool {
        V::F64_LANES + 1 >= reach
    }

    #[inline(always)]
    fn rows(reach: usize) -> usize {
        if D == 1 { 1 } else { reach }
    }

    /// Clears what the cells of the strip do not begin.
    #[inline(always)]
    pub fn begin(simd: V, reach: usize, to: &mut StripSums, frame: &Frame<D>) -> Self {
        for q in &mut to.0[..sums(D)] {
            let first = if Self::fits(reach) { frame.tail().min(q.len()) } else { q.len() };
            q[..first].fill(0.0); // the cells below are another strip's
        }
        let numbers = array!([0.0; MAX_LANES], i => i as f64);
        let lanes = SimdReal::load(simd, &numbers);
        let none = SimdReal::splat(simd, 0.0);
        Self {
            carry: [[[none; SUMS]; MOST_REACH]; MOST_REACH],
            below: array!([none.below(none); MOST_REACH], i => lanes.below(none.like(i as f64 - 0.5))),
            row: frame.stride[D - 1],
            carries: false,
        }
    }

    /// Adds what the cells from `cell` of the strip on give to their functions.
    #[inline(always)]
    pub fn add(&mut self, reach: usize, to: &mut StripSums, cell: usize, given: &Given<V>) {
        if !Self::fits(reach) {
            return self.add_one_by_one(reach, to, cell, given);
        }
        for q in 0..sums(D) {
            // The uppermost first: short rows lie within one vector.
            for j in (0..Self::rows(reach)).rev() {
                let to = &mut to.0[q][cell + j * self.row..][..V::F64_LANES];
                let mut begun = j + 1 < Self::rows(reach);
                let mut sum = if begun { SimdReal::load(given[0][0].simd, to) } else { given[q][0] };
                for i in (1..reach).rev() {
                    let turned = given[q][j * reach + i].turned(i);
                    let here = self.carry[j][i][q].or(self.below[i], turned);
                    sum = if begun { sum + here } else { here };
                    begun = true;
                    self.carry[j][i][q] = turned;
                }
                let own = given[q][j * reach];
                (if begun { sum + own } else { own }).store(to);
            }
        }
        self.carries = true;
    }

    /// The same for cells that give nothing.
    #[inline(always)]
    pub fn skip(&mut self, reach: usize, to: &mut StripSums, cell: usize) {
        if !Self::fits(reach) {
            return;
        }
        for q in 0..sums(D) {
            for j in 0..Self::rows(reach) {
                let is_begun = j + 1 < Self::rows(reach);
                let to = &mut to.0[q][cell + j * self.row..][..V::F64_LANES];
                if self.carries {
                    let none = self.carry[j][0][q].like(0.0);
                    let mut sum = if is_begun { SimdReal::load(none.simd, to) } else { none };
                    for i in (1..reach).rev() {
                        sum += self.carry[j][i][q].or(self.below[i], none);
                        self.carry[j][i][q] = none;
                    }
                    sum.store(to);
                } else if !is_begun {
                    to.fill(0.0);
                }
            }
        }
        self.carries = false;
    }

    /// The same with fewer lanes than functions.
    #[inline(always)]
    fn add_one_by_one(&self, reach: usize, to: &mut StripSums, cell: usize, given: &Given<V>) {
        for lane in 0..V::F64_LANES {
            for q in 0..sums(D) {
                for j in 0..Self::rows(reach) {
                    for i in 0..reach {
                        to.0[q][cell + lane + i + j * self.row] += given[q][j * reach + i].lane(lane);
                    }
                }
            }
        }
    }

    /// Gives what still waits to the nodes beyond the last cell.
    #[inline(always)]
    pub fn end(&self, reach: usize, to: &mut StripSums, length: usize) {
        if !Self::fits(reach) {
            return;
        }
        for q in 0..sums(D) {
            for j in 0..Self::rows(reach) {
                let to = &mut to.0[q][length + j * self.row..][..reach - 1];
                if j + 1 == Self::rows(reach) {
                    to.fill(0.0);
                }
                for i in (1..reach).rev() {
                    for lane in 0..i {
                        to[lane] += self.carry[j][i][q].lane(lane);
                    }
                }
            }
        }
    }
}

//! Numbers that begin at a line of the cache.

use std::ops::{Deref, DerefMut, Range};

use bytemuck::{Pod, Zeroable};

/// A line of the cache, or of a vector of the widest SIMD instructions.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([f64; LANES]);
const LANES: usize = crate::real::MAX_LANES;

/// Numbers that begin at a line of the cache, whatever the SIMD width that reads them: a vector that lies across two lines costs
/// twice as much.
#[derive(Debug, Clone, Default)]
pub struct Aligned {
    lines: Vec<Line>,
    count: usize,
}

impl Aligned {
    /// So many zeros.
    pub fn zeros(count: usize) -> Self {
        Self { lines: vec![Line::zeroed(); count.div_ceil(LANES)], count }
    }

    /// Empties it and makes room for so many numbers.
    pub fn clear_for(&mut self, count: usize) {
        self.lines.clear();
        self.lines.reserve_exact(count.div_ceil(LANES));
        self.count = 0;
    }

    /// Makes room for so many numbers, zeros where they are new, from a place on; those behind it move up. Without an allocation as
    /// long as there is room.
    pub fn insert_zeros(&mut self, at: usize, more: usize) {
        let before = self.count;
        self.count += more;
        self.lines.resize(self.count.div_ceil(LANES), Line::zeroed());
        self.copy_within(at..before, at + more);
        self[at..at + more].fill(0.0);
    }

    /// Takes numbers out; those behind them move down.
    pub fn remove(&mut self, range: Range<usize>) {
        self.copy_within(range.end.., range.start);
        self.count -= range.len();
        self.lines.truncate(self.count.div_ceil(LANES));
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.lines.capacity() * size_of::<Line>()
    }
}

impl Deref for Aligned {
    type Target = [f64];
    #[inline(always)]
    fn deref(&self) -> &[f64] {
        &bytemuck::cast_slice(&self.lines)[..self.count]
    }
}

impl DerefMut for Aligned {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut bytemuck::cast_slice_mut(&mut self.lines)[..self.count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_move_up_and_down_and_stay_on_a_line() {
        let mut numbers = Aligned::default();
        numbers.clear_for(40);
        numbers.insert_zeros(0, 13);
        (0..13).for_each(|i| numbers[i] = i as f64 + 1.0);
        numbers.insert_zeros(3, 7);
        assert_eq!(numbers[..12], [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 5.0]);
        numbers.remove(1..10);
        assert_eq!(numbers[..3], [1.0, 4.0, 5.0]);
        assert_eq!((numbers.len(), numbers.bytes()), (11, 40 * 8));
        assert_eq!(numbers.as_ptr().align_offset(64), 0);
    }
}

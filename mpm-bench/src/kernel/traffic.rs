//! Bytes that a step over lanes moves between the processor and where its data lie, counted from its records.
//!
//! Every record is read once and written once per step; only the mass of a particle stays as it is. The sums and the
//! motion of the nodes are passed from one half of the step to the other, so they are read and written once more than
//! that: a line of memory that is written is read first. What a cell shares with its
//! neighbours (corners, faces) is counted once.
//!
//! | numbers of a cell | read | written |
//! |---|---|---|
//! | state: place, volume, porosity (6) | 6 | 4 |
//! | sums of its node (6): begun by the pass, read by the equation of motion | 12 | 6 |
//! | motion of its node (6): written by the equation of motion, read by the pass | 12 | 6 |
//! | pore pressure, now and at the next step | 2 | 1 |
//! | how its lower faces conduct | 2 | 0 |

use mpm_core::particles::{SolidPoint, WaterPoint};

/// Numbers of a point and its water that are read and not written.
const MASSES: usize = 2;
/// Numbers of a cell that are read; see the table above.
const CELL_READ: usize = 6 + 12 + 12 + 2 + 2;
/// Numbers of a cell that are written.
const CELL_WRITTEN: usize = 4 + 6 + 6 + 1;

/// Bytes read and written per point-step, `ppc` points in a cell.
pub fn per_point(ppc: usize) -> [f64; 2] {
    let particles = size_of::<SolidPoint<2>>() + size_of::<WaterPoint<2>>();
    let bytes = |numbers: usize| numbers * size_of::<f64>();
    let per_point = |particles: usize, cell: usize| particles as f64 + bytes(cell) as f64 / ppc as f64;
    [per_point(particles, CELL_READ), per_point(particles - bytes(MASSES), CELL_WRITTEN)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_ten_and_seven_numbers_and_a_share_of_the_cell() {
        assert_eq!(per_point(4), [136.0 + 68.0, 120.0 + 34.0]);
        assert_eq!(per_point(1), [136.0 + 272.0, 120.0 + 136.0]);
    }
}

//! Bytes that a vectorised step moves between the processor and where its data lie, counted from its records.
//!
//! Every record is read once and written once per step; only the mass of a particle stays as it is. The sums and the
//! motion of the nodes are passed from one half of the step to the other, so they are read and written once more than
//! that: a line of memory that is written is read first. What a cell shares with its
//! neighbours (corners, faces) is counted once.
//!
//! | numbers of a cell | read | written | of dry soil |
//! |---|---|---|---|
//! | state: place, volume, porosity (6) | 6 | 4 | place and volume: 3, 2 |
//! | sums of its node (6): begun by the pass, read by the equation of motion | 12 | 6 | 10, 5 |
//! | motion of its node (6): written by the equation of motion, read by the pass | 12 | 6 | 12, 6 |
//! | pore pressure, now and at the next step | 2 | 1 | none |
//! | how its lower faces conduct | 2 | 0 | none |

use mpm_core::particles::{SolidPoint, WaterPoint};

/// Numbers of a particle that are read and not written.
const MASS: usize = 1;
/// Numbers of a cell that are read, and those that are written, with water; see the table above.
const WET_CELL: [usize; 2] = [6 + 12 + 12 + 2 + 2, 4 + 6 + 6 + 1];
/// The same of dry soil, whose nodes have no sum for the mass of the mixture, and whose cells have no pores.
const DRY_CELL: [usize; 2] = [3 + 10 + 12, 2 + 5 + 6];

/// Bytes read and written per point-step, `ppc` points in a cell, with water or without.
pub fn per_point(ppc: usize, water: bool) -> [f64; 2] {
    let bytes = |numbers: usize| numbers * size_of::<f64>();
    let mut particles = vec![size_of::<SolidPoint<2>>()];
    particles.extend(water.then_some(size_of::<WaterPoint<2>>()));
    let cell = if water { WET_CELL } else { DRY_CELL };
    let per_point = |particles: usize, cell: usize| particles as f64 + bytes(cell) as f64 / ppc as f64;
    let (read, masses) = (particles.iter().sum(), bytes(MASS * particles.len()));
    [per_point(read, cell[0]), per_point(read - masses, cell[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_ten_and_seven_numbers_and_a_share_of_the_cell() {
        assert_eq!(per_point(4, true), [136.0 + 68.0, 120.0 + 34.0]);
        assert_eq!(per_point(1, true), [136.0 + 272.0, 120.0 + 136.0]);
        assert_eq!(per_point(4, false), [80.0 + 50.0, 72.0 + 26.0]);
    }
}

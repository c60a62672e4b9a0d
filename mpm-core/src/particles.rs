//! The two layers of particles, kept in the order of their cells so that a cell's particles are one slice.
//!
//! A particle is one compact record, because every pass over the particles uses all of it.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

use crate::checkpoint::{Archive, RestoreError, archive};
use crate::grid::Grid;
use crate::random::Random;
use crate::real::array_of;
use crate::scene::Displaced;

/// A particle of the solid layer. D: dimensions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SolidPoint<const D: usize> {
    /// Position, m.
    #[serde(with = "BigArray")]
    pub x: [f64; D],
    /// Velocity, m/s.
    #[serde(with = "BigArray")]
    pub v: [f64; D],
    /// Effective stress xx, yy, zz, xy, Pa, tension positive; the axis of a column is y.
    pub stress: [f64; 4],
    /// Mass of the dry skeleton, kg.
    pub mass: f64,
    /// Volume of soil (grains and pores), m3.
    pub volume: f64,
}

/// A particle of the water layer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WaterPoint<const D: usize> {
    /// Position, m.
    #[serde(with = "BigArray")]
    pub x: [f64; D],
    /// Velocity, m/s: that of the soil plus the relative velocity v*.
    #[serde(with = "BigArray")]
    pub v: [f64; D],
    /// Mass, kg; constant.
    pub mass: f64,
    /// Control volume of soil that this water fills, m3: mass / (n rho_w).
    pub volume: f64,
    /// Pore pressure, Pa, compression positive.
    pub pressure: f64,
}

/// A particle, and its numbers, the first of them its position.
pub trait Point<const D: usize>: Copy {
    /// How many numbers it is.
    const COUNT: usize;
    /// Which of them is its volume, m3.
    const VOLUME: usize;
    /// Position, m.
    fn position(&self) -> &[f64; D];
    /// Writes its numbers.
    fn pack(&self, numbers: &mut [f64]);
    /// From its numbers.
    fn unpack(numbers: &[f64]) -> Self;
}

impl<const D: usize> Point<D> for SolidPoint<D> {
    const COUNT: usize = 2 * D + 6;
    const VOLUME: usize = 2 * D + 5;

    fn position(&self) -> &[f64; D] {
        &self.x
    }

    fn pack(&self, numbers: &mut [f64]) {
        numbers[..D].copy_from_slice(&self.x);
        numbers[D..2 * D].copy_from_slice(&self.v);
        numbers[2 * D..2 * D + 4].copy_from_slice(&self.stress);
        (numbers[2 * D + 4], numbers[2 * D + 5]) = (self.mass, self.volume);
    }

    fn unpack(numbers: &[f64]) -> Self {
        Self {
            x: array_of(|d| numbers[d]),
            v: array_of(|d| numbers[D + d]),
            stress: array_of(|s| numbers[2 * D + s]),
            mass: numbers[2 * D + 4],
            volume: numbers[2 * D + 5],
        }
    }
}

impl<const D: usize> Point<D> for WaterPoint<D> {
    const COUNT: usize = 2 * D + 3;
    const VOLUME: usize = 2 * D + 1;

    fn position(&self) -> &[f64; D] {
        &self.x
    }

    fn pack(&self, numbers: &mut [f64]) {
        numbers[..D].copy_from_slice(&self.x);
        numbers[D..2 * D].copy_from_slice(&self.v);
        numbers[2 * D..2 * D + 3].copy_from_slice(&[self.mass, self.volume, self.pressure]);
    }

    fn unpack(numbers: &[f64]) -> Self {
        Self {
            x: array_of(|d| numbers[d]),
            v: array_of(|d| numbers[D + d]),
            mass: numbers[2 * D],
            volume: numbers[2 * D + 1],
            pressure: numbers[2 * D + 2],
        }
    }
}

/// A particle that has left the mesh or has no position any more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Escaped<const D: usize> {
    /// Index in [`Layer::points`].
    pub index: usize,
    /// Its position, m.
    pub x: [f64; D],
}

/// One layer of particles in the order of their cells.
#[derive(Debug, Clone)]
pub struct Layer<P, const D: usize> {
    /// The particles.
    pub points: Vec<P>,
    /// Number each particle was seeded with.
    pub ids: Vec<u32>,
    /// First particle of each cell, and the total at the end.
    pub cell_start: Vec<u32>,
    /// How many times a particle has changed its cell.
    pub crossings: u64,
    /// Goes up whenever the order changes, so that holders of indices know.
    pub order: u64,
    /// How many were seeded: all [`Self::ids`] are below.
    numbers: usize,
    cell_of: Vec<u32>,
}

impl<P: Point<D>, const D: usize> Layer<P, D> {
    /// Sorts particles into the cells of a mesh; `ids` are their places in `points`.
    ///
    /// # Errors
    /// The first particle outside the mesh.
    pub fn new(points: Vec<P>, grid: &Grid<D>) -> Result<Self, Escaped<D>> {
        let count = points.len();
        let mut layer = Self {
            points,
            ids: (0..count as u32).collect(),
            cell_start: vec![0; grid.cell_count() + 1],
            crossings: 0,
            order: 0,
            numbers: count,
            cell_of: vec![0; count],
        };
        layer.sort(grid)?;
        layer.crossings = 0;
        Ok(layer)
    }

    /// A layer like `like` of particles that stand in its order already, `cell_start` of them before each cell.
    pub fn in_order<Q>(like: &Layer<Q, D>, points: Vec<P>, ids: Vec<u32>, cell_start: Vec<u32>) -> Self {
        let cell_of = vec![0; points.len()];
        Self { points, ids, cell_start, crossings: like.crossings, order: like.order, numbers: like.numbers, cell_of }
    }

    /// The cells and counts of a layer whose particles are elsewhere.
    pub fn without_points(self) -> Self {
        Self { points: Vec::new(), ids: Vec::new(), cell_of: Vec::new(), ..self }
    }

    /// Particles of a cell.
    #[inline]
    pub fn range(&self, cell: usize) -> std::ops::Range<usize> {
        self.cell_start[cell] as usize..self.cell_start[cell + 1] as usize
    }

    /// Restores the cell order after particles have moved, counting those that changed their cell. No allocation.
    ///
    /// # Errors
    /// The first particle outside the mesh; the order is then left as it was.
    pub fn sort(&mut self, grid: &Grid<D>) -> Result<(), Escaped<D>> {
        for (index, point) in self.points.iter().enumerate() {
            let Some(cell) = grid.cell_at(point.position()) else {
                return Err(Escaped { index, x: *point.position() });
            };
            self.cell_of[index] = cell as u32;
        }
        for cell in 0..grid.cell_count() {
            for index in self.range(cell) {
                self.crossings += u64::from(self.cell_of[index] != cell as u32);
            }
        }
        // Counting sort: `cell_start[c]` becomes the next free place of cell c, `cell_of` the place of each particle.
        self.cell_start.fill(0);
        for &cell in &self.cell_of {
            self.cell_start[cell as usize + 1] += 1;
        }
        for cell in 0..grid.cell_count() {
            self.cell_start[cell + 1] += self.cell_start[cell];
        }
        for place in &mut self.cell_of {
            let cell = *place as usize;
            *place = self.cell_start[cell];
            self.cell_start[cell] += 1;
        }
        for cell in (0..grid.cell_count()).rev() {
            self.cell_start[cell + 1] = self.cell_start[cell];
        }
        self.cell_start[0] = 0;
        // Carry every particle to its place, one cycle of the permutation at a time.
        for start in 0..self.points.len() {
            while self.cell_of[start] as usize != start {
                let to = self.cell_of[start] as usize;
                self.points.swap(start, to);
                self.ids.swap(start, to);
                self.cell_of.swap(start, to);
            }
        }
        self.order += 1;
        Ok(())
    }

    /// Removes the particles for which `leaves` holds, keeping the order, and restores the cells.
    ///
    /// # Errors
    /// As [`Layer::sort`].
    pub fn remove(&mut self, grid: &Grid<D>, mut leaves: impl FnMut(&P) -> bool) -> Result<(), Escaped<D>> {
        let mut kept = 0;
        for index in 0..self.points.len() {
            if !leaves(&self.points[index]) {
                self.points[kept] = self.points[index];
                self.ids[kept] = self.ids[index];
                kept += 1;
            }
        }
        self.points.truncate(kept);
        self.ids.truncate(kept);
        self.cell_of.truncate(kept);
        // The old cells no longer hold; count no crossings for a removal.
        let crossings = self.crossings;
        self.cell_start.fill(0);
        self.sort(grid)?;
        self.crossings = crossings;
        Ok(())
    }

    /// Saves or restores the layer.
    pub(crate) fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError>
    where
        P: Serialize + DeserializeOwned,
    {
        let cells = self.cell_start.len().saturating_sub(1);
        archive!(archive.value: self.points, self.ids, self.cell_start, self.crossings, self.order);
        if archive.restores() && !self.is_whole(cells) {
            return Err(RestoreError);
        }
        self.cell_of.resize(self.points.len(), 0);
        Ok(())
    }

    /// Whether every particle has a place in one of so many cells, and a number of its own.
    fn is_whole(&self, cells: usize) -> bool {
        let (starts, count) = (&self.cell_start, self.points.len());
        let mut seen = vec![false; self.ids.iter().max().map_or(0, |id| *id as usize + 1).min(self.numbers)];
        starts.len() == cells + 1
            && starts.first() == Some(&0)
            && starts.last().is_some_and(|last| *last as usize == count)
            && starts.windows(2).all(|pair| pair[0] <= pair[1])
            && self.ids.len() == count
            && self.ids.iter().all(|id| seen.get_mut(*id as usize).is_some_and(|seen| !std::mem::replace(seen, true)))
    }

    /// Bytes held for this layer.
    pub fn bytes(&self) -> usize {
        self.points.capacity() * size_of::<P>()
            + (self.ids.capacity() + self.cell_of.capacity() + self.cell_start.capacity()) * size_of::<u32>()
    }
}

impl<P, const D: usize> Default for Layer<P, D> {
    fn default() -> Self {
        let (points, ids, cell_start, cell_of) = Default::default();
        Self { points, ids, cell_start, crossings: 0, order: 0, numbers: 0, cell_of }
    }
}

/// Positions of `per_direction`^D particles per cell, evenly spaced, in the cells below `rows` of the last axis,
/// in units of the cell: particle i of a cell sits at (i + 1/2) / `per_direction`.
pub fn even_positions<const D: usize>(cells: [usize; D], per_direction: usize) -> impl Iterator<Item = [f64; D]> {
    let along: [usize; D] = array_of(|d| cells[d] * per_direction);
    let count: usize = along.iter().product();
    (0..count).map(move |number| {
        let mut rest = number;
        array_of(|d| {
            let i = rest % along[d];
            rest /= along[d];
            (i as f64 + 0.5) / per_direction as f64
        })
    })
}

/// Moves particles (m) from their even places, `spacing` (m) apart on the given `lengths` (m): a smooth wave and random
/// parts.
pub fn displace<'a, const D: usize>(
    places: impl Iterator<Item = &'a mut [f64; D]>,
    lengths: &[f64; D],
    spacing: f64,
    displaced: &Displaced,
) {
    let mut random = Random(displaced.seed);
    for x in places {
        for d in 0..D {
            let uniform = random.unit();
            let wave = f64::sin(2.0 * std::f64::consts::PI * x[d] / lengths[d]);
            x[d] += spacing * (displaced.smooth * wave + displaced.jitter * (2.0 * uniform - 1.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sorting_keeps_every_particle_and_counts_crossings() {
        let grid = Grid::new([3, 2], 1.0);
        let point = |x| WaterPoint { x, v: [0.0; 2], mass: 1.0, volume: 1.0, pressure: 0.0 };
        let points: Vec<WaterPoint<2>> = even_positions([3, 2], 2).map(point).collect();
        let mut layer = Layer::new(points.clone(), &grid).unwrap();
        assert_eq!(layer.crossings, 0);
        for cell in 0..6 {
            assert_eq!(layer.range(cell).len(), 4);
            for i in layer.range(cell) {
                assert_eq!(grid.cell_at(&layer.points[i].x), Some(cell));
                assert_eq!(layer.points[i].x, points[layer.ids[i] as usize].x);
            }
        }
        let moved = layer.range(0).start;
        layer.points[moved].x[0] += 1.0;
        layer.sort(&grid).unwrap();
        assert_eq!(layer.crossings, 1);
        assert_eq!((layer.range(0).len(), layer.range(1).len()), (3, 5));
        layer.points[0].x[1] = f64::NAN;
        assert_eq!(layer.sort(&grid).unwrap_err().index, 0);
    }
}

//! How the soil conducts in each half of a cell along each axis: a face lies between two of them, and the flux through it is that
//! through both in series. Amid soil of one conductivity there is nothing to know.

use serde::{Deserialize, Serialize};

use crate::grid::Grid;
use crate::particles::{Layer, SolidPoint};
use crate::real::array_of;
use crate::soils::Soils;

/// Conductivities over that of the water, by cell, axis and half (lower, upper); empty where all are 1.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Halves<const D: usize>(Vec<[[f64; 2]; 2]>);

impl<const D: usize> Halves<D> {
    /// Those of the particles where they are: in a half they conduct side by side. `full` is the volume of a cell, m3.
    pub fn of(grid: &Grid<D>, solid: &Layer<SolidPoint<D>, D>, full: f64, soils: &Soils) -> Self {
        if !soils.conduct_differently() {
            return Self::default();
        }
        let of_cell = |(cell, position): (usize, [usize; D])| {
            let (mut sums, mut volumes) = ([[0.0; 2]; D], [[0.0; 2]; D]);
            for index in solid.range(cell) {
                let (point, kind) = (&solid.points[index], soils.kind_of(solid.ids[index]));
                // Half the edge of the box of the particle, in cells; no more than keeps it out of most of the other half.
                let reach =
                    0.5 * (point.volume / (full * grid.thickness(point.x[0]))).powf(1.0 / D as f64).clamp(1e-3, 1.0);
                for axis in 0..D {
                    let at = point.x[axis] * grid.inverse_size - position[axis] as f64;
                    let lower = ((0.5 - at + reach) / (2.0 * reach)).clamp(0.0, 1.0);
                    let conductivity = kind.along(axis, D);
                    for (half, share) in [lower, 1.0 - lower].into_iter().enumerate() {
                        sums[axis][half] += share * point.volume * conductivity;
                        volumes[axis][half] += share * point.volume;
                    }
                }
            }
            array_of(|axis| {
                let axis = axis.min(D - 1);
                let mean = |half: usize| {
                    let of = |half: usize| (volumes[axis][half] > 0.0).then(|| sums[axis][half] / volumes[axis][half]);
                    of(half).or(of(1 - half)).unwrap_or(1.0)
                };
                [mean(0), mean(1)]
            })
        };
        Self(grid.walk().map(of_cell).collect())
    }

    /// Whether conductivities differ.
    pub fn differ(&self) -> bool {
        !self.0.is_empty()
    }

    /// That of one half of a cell.
    #[inline]
    pub fn at(&self, cell: usize, axis: usize, upper: bool) -> f64 {
        self.0.get(cell).map_or(1.0, |axes| axes[axis][usize::from(upper)])
    }

    /// That of a face between two cells, the harmonic mean 2 k_1 k_2/(k_1 + k_2) of the halves beside it.
    #[inline]
    pub fn between(&self, axis: usize, low: usize, high: usize) -> f64 {
        let [a, b] = [self.at(low, axis, true), self.at(high, axis, false)];
        if a == b { a } else { 2.0 * a * b / (a + b) }
    }
}

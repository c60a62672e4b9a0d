//! Water that keeps its pressures while the soil moves: what the seepage clock leaves to that of the soil.

use super::{FlowRates, Place, SoilCell, StressSums, Water};
use crate::dimension::{Kinematics, gradient, shares, trace};
use crate::grid::Grid;
use crate::nodes::NodeMotion;
use crate::particles::{Layer, SolidPoint, WaterPoint};
use crate::shape::Shape;

/// Pressures and water of the cells.
#[derive(Debug, Clone)]
pub struct Frozen {
    /// Mean over the soil of a cell of the pressure where it is positive, Pa.
    pub pressure: Vec<f64>,
    /// Water per volume of soil, kg/m3.
    pub per_volume: Vec<f64>,
    /// Height of the middle of the water above the bottom of the cell, in cells.
    pub middle: Vec<f64>,
    /// Density of the water, kg/m3.
    pub density: f64,
    /// Work that the held pressures have done on the soil as it gained volume, J.
    pub work: f64,
    /// Soil in each cell at the start of the step, m3.
    pub volume: Vec<f64>,
}

impl<K: Kinematics<D, S>, const D: usize, const S: usize> Water<K, D, S> for Frozen {
    const WET: bool = true;

    #[inline(always)]
    fn clear(&mut self) {}

    #[inline(always)]
    fn cell_to_grid<Sh: Shape>(&mut self, _: &Grid<D>, soil: &SoilCell<D>, stress: &mut StressSums<D, S>) -> [f64; 4] {
        let cell = soil.place.cell;
        // On the soil of the cell, at its centre: p carried back to particles would let a thin wet layer push too hard.
        self.volume[cell] = soil.volume;
        let pushed = self.pressure[cell] * soil.volume;
        for s in 0..S {
            stress.mean[s] += pushed * K::UNIT_PRESSURE[s];
            for d in 0..D {
                stress.first[d][s] += 0.5 * pushed * K::UNIT_PRESSURE[s];
            }
        }
        let mut middle = [0.5; D];
        middle[D - 1] = self.middle[cell];
        shares(self.per_volume[cell] * soil.volume, &middle)
    }

    #[inline(always)]
    fn flow(&mut self, _: &Grid<D>, _: &[NodeMotion<D>], _: &[f64; D]) -> FlowRates {
        FlowRates::default()
    }

    #[inline(always)]
    fn cell_to_points<Sh: Shape>(&mut self, grid: &Grid<D>, place: &Place<D>, velocity: &[[f64; D]; 4], dt: f64) {
        let cell = place.cell;
        let opening = trace(&gradient(velocity, &[0.5; D], grid.inverse_size));
        self.work += dt * self.pressure[cell] * self.volume[cell] * opening;
    }

    fn settle(&mut self, _: &Grid<D>, _: &Layer<SolidPoint<D, S>, D>) -> Result<(), (String, String)> {
        Ok(())
    }

    fn set_drained(&mut self, _: &Grid<D>, _: &Layer<SolidPoint<D, S>, D>, _: [bool; 4]) {}

    fn layer(&self) -> Option<&Layer<WaterPoint<D>, D>> {
        None
    }

    fn cell_state(&self, soil: &SoilCell<D>) -> (f64, f64) {
        (self.pressure[soil.place.cell], 0.0)
    }

    fn cell_mass(&self, soil: &SoilCell<D>) -> f64 {
        self.per_volume[soil.place.cell] * soil.volume
    }

    fn held_work(&self) -> f64 {
        self.work
    }

    fn density(&self) -> f64 {
        self.density
    }

    fn bytes(&self) -> usize {
        [&self.pressure, &self.per_volume, &self.middle, &self.volume].iter().map(|v| v.capacity()).sum::<usize>()
            * size_of::<f64>()
    }
}

//! The water's part of the implicit pressure system: storage, flow between cells, and what the body force drives.
//!
//! Every flow is that of the explicit operator, [`Face`]. Its rule for cells that are hardly filled is not needed here:
//! it keeps an explicit step stable, and without it the system is symmetric and no water is lost.

use super::saturated::DarcyOperator;
use super::{CellChange, Face, FlowRates, Place, Saturated, WaterCell};
use crate::grid::Grid;
use crate::nodes::NodeMotion;

impl<const D: usize, const LAYERED: bool> Saturated<Face<D, LAYERED>, D> {
    /// A cell as it was noted at the start of the step.
    #[inline(always)]
    pub fn cell(&self, cell: usize) -> &WaterCell {
        &self.cells[cell]
    }

    /// Water that a cell stores per pressure, V n/K_w, m3/Pa; zero for incompressible water.
    #[inline(always)]
    pub fn storage(&self, cell: usize) -> f64 {
        let WaterCell { porosity, inverse_volume, .. } = self.cells[cell];
        porosity / (inverse_volume * self.properties.bulk_modulus)
    }

    /// Flow per pressure drop between neighbours of the water's own conductivity, m3/(s Pa).
    pub fn transmissibility(&self) -> f64 {
        self.operator.transmissibility()
    }

    /// Whether conductances change with the place of the surface.
    pub fn has_surface(&self) -> bool {
        self.operator.knows_volumes()
    }

    /// Conductance between two neighbours over that, the lower one first: 1 but for layers and at the surface.
    pub fn conductance_between(&self, grid: &Grid<D>, cells: [usize; 2]) -> f64 {
        self.operator.between(grid, cells) / self.operator.reach(cells)
    }

    /// Drained faces: their cell, and their conductance over that between neighbours.
    pub fn outlets(&self, grid: &Grid<D>) -> impl Iterator<Item = (usize, f64)> {
        let drained = self.exposed.faces.iter().filter(|face| self.drained[face.side as usize]);
        drained.map(|face| {
            let cell = face.cell as usize;
            (cell, self.operator.of_cell(grid, cell) / self.operator.reach_of_surface(cell, face.side))
        })
    }

    /// Sets the pressure (Pa) of a cell for the flow.
    #[inline(always)]
    pub fn set_pressure(&mut self, cell: usize, pressure: f64) {
        self.cells[cell].pressure = pressure;
    }

    /// Darcy flow from the cells' pressures and the nodes' accelerations: the paper's Eq. (1).
    pub fn drive(&mut self, grid: &Grid<D>, motion: &[NodeMotion<D>], gravity: &[f64; D]) -> FlowRates {
        self.operator.flow(grid, &self.cells, motion, gravity, (&self.exposed, &self.drained))
    }

    /// Water that flows out of a cell, m3/s.
    #[inline(always)]
    pub fn outflow(&self, grid: &Grid<D>, place: &Place<D>) -> f64 {
        self.cells[place.cell].porosity * self.operator.cell_volume() * self.divergence(grid, place)
    }

    /// Change of a cell whose pressure rises by a known amount (Pa) while its soil gains volume at a rate (1/s).
    #[inline(always)]
    pub fn follow(&self, grid: &Grid<D>, place: &Place<D>, volume_rate: f64, rise: f64) -> CellChange {
        let filling = self.operator.cell_volume() * self.cells[place.cell].inverse_volume;
        CellChange { rise, swelling: volume_rate + filling * self.divergence(grid, place) }
    }
}

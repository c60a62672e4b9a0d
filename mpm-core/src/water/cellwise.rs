//! Water with one pressure per cell, for the kernels over stencils of any width.
//!
//! The pressure of a cell is the mean over its water particles. It pushes the soil of the cell with
//! `f_i = p_c sum_p V_p G_i`, and the cell gains volume at `sum_i f_i/p_c . v_i`: power in is power out.

use super::saturated::DarcyOperator;
use super::{Dry, Face, Place, Saturated, SoilCell, Water, WaterCell};
use crate::dimension::{Kinematics, basis, gradient, trace, value};
use crate::grid::Grid;
use crate::nodes::NodeMotion;
use crate::stencil::{Basis, Functions};

/// How the water of a cell changes during a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CellChange {
    /// Rise of the pressure, Pa.
    pub rise: f64,
    /// Rate of the volume that the water fills, 1/s.
    pub swelling: f64,
}

/// What the kernels over stencils ask of the water.
pub trait Cellwise<K: Kinematics<D, S>, const D: usize, const S: usize>: Water<K, D, S> {
    /// Notes a cell at the start of a step; returns its pressure, Pa.
    fn note(&mut self, soil: &SoilCell<D>) -> f64;

    /// Mass of the water over that of the grains in a cell, whose water moves with its soil; nothing where that of the water
    /// particles counts.
    fn ratio(&self, soil: &SoilCell<D>) -> Option<f64>;

    /// Change of a cell whose soil gains volume at a rate (1/s), by the mass balance of the start of the step.
    fn change(&self, grid: &Grid<D>, place: &Place<D>, volume_rate: f64, dt: f64) -> CellChange;

    /// Updates pressure, volume, velocity and position of the water particles of a cell.
    fn move_points<B: Basis>(
        &mut self,
        grid: &Grid<D>,
        place: &Place<D>,
        soil: (&Functions<B, D>, &[NodeMotion<D>]),
        change: &CellChange,
        dt: f64,
    );
}

impl<K: Kinematics<D, S>, const D: usize, const S: usize> Cellwise<K, D, S> for Dry {
    #[inline(always)]
    fn note(&mut self, _: &SoilCell<D>) -> f64 {
        0.0
    }

    #[inline(always)]
    fn ratio(&self, _: &SoilCell<D>) -> Option<f64> {
        None
    }

    #[inline(always)]
    fn change(&self, _: &Grid<D>, _: &Place<D>, _: f64, _: f64) -> CellChange {
        CellChange::default()
    }

    #[inline(always)]
    fn move_points<B: Basis>(
        &mut self,
        _: &Grid<D>,
        _: &Place<D>,
        _: (&Functions<B, D>, &[NodeMotion<D>]),
        _: &CellChange,
        _: f64,
    ) {
    }
}

impl<const D: usize, const LAYERED: bool> Saturated<Face<D, LAYERED>, D> {
    /// div v* of a cell full of soil, 1/s.
    #[inline(always)]
    pub(super) fn divergence(&self, grid: &Grid<D>, place: &Place<D>) -> f64 {
        let relative = self.operator.relative(grid, place, &self.cells[place.cell]);
        trace(&gradient(&relative, &[0.5; D], grid.inverse_size))
    }
}

impl<K: Kinematics<D, S>, const LAYERED: bool, const D: usize, const S: usize> Cellwise<K, D, S>
    for Saturated<Face<D, LAYERED>, D>
{
    #[inline(always)]
    fn note(&mut self, soil: &SoilCell<D>) -> f64 {
        let cell = soil.place.cell;
        let (mut weighted, mut volume) = (0.0, 0.0);
        for point in &self.points.points[self.points.range(cell)] {
            weighted += point.volume * point.pressure;
            volume += point.volume;
        }
        // Nothing in a cell at the edge whose water is in its neighbours.
        let pressure = if volume > 0.0 { weighted / volume } else { 0.0 };
        let porosity = self.porosity(soil);
        self.cells[cell] =
            WaterCell { pressure, porosity, inverse_porosity: 1.0 / porosity, inverse_volume: 1.0 / soil.filled };
        pressure
    }

    #[inline(always)]
    fn ratio(&self, soil: &SoilCell<D>) -> Option<f64> {
        self.operator.knows_volumes().then(|| self.water_ratio(soil))
    }

    #[inline(always)]
    fn change(&self, grid: &Grid<D>, place: &Place<D>, volume_rate: f64, dt: f64) -> CellChange {
        let cell = &self.cells[place.cell];
        let stiffness = self.properties.bulk_modulus * cell.inverse_porosity;
        let (filling, softer) = self.operator.filling(cell.inverse_volume, stiffness * dt);
        let flow = filling * self.divergence(grid, place);
        // Eq. (5), mended: dp = -(K_w/n) [ tr(d eps_s) + n tr(d eps*_w) ]
        let stiffness = softer * stiffness;
        CellChange { rise: -dt * stiffness * (volume_rate + cell.porosity * flow), swelling: volume_rate + flow }
    }

    #[inline(always)]
    fn move_points<B: Basis>(
        &mut self,
        grid: &Grid<D>,
        place: &Place<D>,
        (functions, motion): (&Functions<B, D>, &[NodeMotion<D>]),
        change: &CellChange,
        dt: f64,
    ) {
        let relative = self.operator.relative(grid, place, &self.cells[place.cell]);
        let range = self.points.range(place.cell);
        let mut inside = true;
        for point in &mut self.points.points[range] {
            let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - place.position[d] as f64);
            let stencil = functions.around(&place.position, &xi);
            let mut v = value::<D, D, _>(&relative, &basis(&xi)); // v_w = v_s + v*
            for a in 0..Functions::<B, D>::COUNT {
                let of_soil = &motion[stencil.node[a]].velocity;
                for d in 0..D {
                    v[d] += stencil.value[a] * of_soil[d];
                }
            }
            point.pressure += change.rise;
            point.volume *= 1.0 + dt * change.swelling;
            point.v = v;
            for d in 0..D {
                point.x[d] += dt * v[d];
                let moved = point.x[d] * grid.inverse_size - place.position[d] as f64;
                inside &= (0.0..1.0).contains(&moved);
            }
        }
        self.moved |= !inside;
    }
}

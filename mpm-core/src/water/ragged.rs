//! Saturated soil that runs out: at its edge cells lose their water, and what has lost it carries no pressure.
//!
//! A cell whose water fills less than half of its soil is open to the air. Its water moves with the soil until soil
//! and water fill it again; water that no soil surrounds any more is taken away and booked. The balance is that of the particles.
//!
//! Coarse soil holds no suction: where its pores open faster than water comes in, air does, at no pressure. A particle's
//! pressure then counts on below zero as a measure of the gap, -Q times the opening, and pushes again once the gap is closed.

use super::saturated::{DarcyOperator, Saturated, WaterCell};
use super::{Face, FlowRates, Place, SoilCell, StressSums, Water};
use crate::dimension::{Kinematics, shares, value};
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::nodes::NodeMotion;
use crate::particles::{Layer, SolidPoint, WaterPoint};
use crate::shape::Shape;

/// Share of a cell's soil that its water must fill to have a pressure.
const LEAST_FULL: f64 = 0.5;

/// Water of a saturated soil whose edge comes apart.
#[derive(Debug, Clone)]
pub struct Ragged<const D: usize> {
    inner: Saturated<Face<D>, D>,
    /// Cells whose water has a pressure.
    full: Vec<bool>,
    /// Whether those have changed.
    changed: bool,
}

impl<const D: usize> Ragged<D> {
    /// The water of a soil that is saturated at first.
    pub fn new(inner: Saturated<Face<D>, D>) -> Self {
        let cells = inner.cells.len();
        Self { inner, full: vec![true; cells], changed: false }
    }

    fn water_mass(&self, cell: usize) -> f64 {
        self.inner.points.points[self.inner.points.range(cell)].iter().map(|p| p.mass).sum()
    }
}

impl<K: Kinematics<D, S>, const D: usize, const S: usize> Water<K, D, S> for Ragged<D> {
    const WET: bool = true;

    #[inline(always)]
    fn clear(&mut self) {
        self.inner.operator.clear();
    }

    #[inline(always)]
    fn cell_to_grid<Sh: Shape>(
        &mut self,
        grid: &Grid<D>,
        soil: &SoilCell<D>,
        solid: &[f64; 4],
        stress: &mut StressSums<D, S>,
    ) -> [f64; 4] {
        let cell = soil.place.cell;
        let range = self.inner.points.range(cell);
        let water: f64 = self.inner.points.points[range.clone()].iter().map(|p| p.volume).sum();
        let full = water >= LEAST_FULL * soil.volume;
        self.changed |= full != self.full[cell];
        self.full[cell] = full;
        let mean = self.inner.points.points[range.clone()].iter().fold(0.0, |sum, p| sum + p.volume * p.pressure);
        if full && mean >= 0.0 {
            return Water::<K, D, S>::cell_to_grid::<Sh>(&mut self.inner, grid, soil, solid, stress);
        }
        let mut mass = [0.0; 4];
        for point in &mut self.inner.points.points[range] {
            if !full {
                point.pressure = point.pressure.min(0.0); // open to the air
            }
            let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - soil.place.position[d] as f64);
            let share = shares(point.mass, &xi);
            for a in 0..Grid::<D>::CORNERS {
                mass[a] += share[a];
            }
        }
        let porosity = self.inner.porosity(soil);
        let inverse_volume = 1.0 / soil.volume;
        self.inner.cells[cell] =
            WaterCell { pressure: 0.0, porosity, inverse_porosity: 1.0 / porosity, inverse_volume };
        mass
    }

    #[inline(always)]
    fn flow(&mut self, grid: &Grid<D>, motion: &[NodeMotion<D>], gravity: &[f64; D]) -> FlowRates {
        // What passes a face between two layers is in the particles; only those that are taken away have left.
        let rates = Water::<K, D, S>::flow(&mut self.inner, grid, motion, gravity);
        let Saturated { operator, exposed, drained, .. } = &mut self.inner;
        let stopped = operator.stop_inflow(motion, gravity, exposed, drained);
        FlowRates {
            dissipation: rates.dissipation - stopped.dissipation,
            body_work: rates.body_work - stopped.body_work,
            outflow: 0.0,
            inflow: 0.0,
        }
    }

    #[inline(always)]
    fn cell_to_points<Sh: Shape>(&mut self, grid: &Grid<D>, place: &Place<D>, velocity: &[[f64; D]; 4], dt: f64) {
        if self.full[place.cell] {
            Water::<K, D, S>::cell_to_points::<Sh>(&mut self.inner, grid, place, velocity, dt);
            return;
        }
        let range = self.inner.points.range(place.cell);
        let mut inside = true;
        for point in &mut self.inner.points.points[range] {
            let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - place.position[d] as f64);
            point.v = value::<D, D, _>(velocity, &crate::dimension::basis(&xi));
            for d in 0..D {
                point.x[d] += dt * point.v[d];
                let moved = point.x[d] * grid.inverse_size - place.position[d] as f64;
                inside &= (0.0..1.0).contains(&moved);
            }
        }
        self.inner.moved |= !inside;
    }

    fn settle(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D, S>, D>) -> Result<(), (String, String)> {
        let soil_changed = self.inner.solid_order != solid.order;
        if !soil_changed && !self.inner.moved && !self.changed {
            return Ok(());
        }
        let lost = |x: &[f64; D]| (format!("water particle at {x:?} m"), "outside the mesh".to_owned());
        if let Some(point) = self.inner.points.points.iter().find(|p| p.x.iter().any(|x| !x.is_finite())) {
            return Err(lost(&point.x));
        }
        let outside = |p: &WaterPoint<D>| grid.cell_at(&p.x).is_none_or(|cell| solid.range(cell).is_empty());
        if self.inner.points.points.iter().any(outside) {
            let mut removed = 0.0;
            let outcome = self.inner.points.remove(grid, |p| {
                let leaves = outside(p);
                removed += if leaves { p.mass } else { 0.0 };
                leaves
            });
            self.inner.removed_mass += removed;
            outcome.map_err(|e| lost(&e.x))?;
        } else if self.inner.moved {
            self.inner.points.sort(grid).map_err(|e| lost(&e.x))?;
        }
        (self.inner.moved, self.changed) = (false, false);
        let full = &self.full;
        let points = &self.inner.points;
        let wet: Vec<bool> = (0..grid.cell_count())
            .map(|cell| full[cell] && !solid.range(cell).is_empty() && !points.range(cell).is_empty())
            .collect();
        self.inner.rebuild_where(grid, solid, |cell| wet[cell]);
        Ok(())
    }

    fn set_drained(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D, S>, D>, drained: [bool; 4]) {
        Water::<K, D, S>::set_drained(&mut self.inner, grid, solid, drained);
    }

    fn layer(&self) -> Option<&Layer<WaterPoint<D>, D>> {
        Some(&self.inner.points)
    }

    fn cell_state(&self, soil: &SoilCell<D>) -> (f64, f64) {
        if self.full[soil.place.cell] && !self.inner.points.range(soil.place.cell).is_empty() {
            let (pressure, energy) = Water::<K, D, S>::cell_state(&self.inner, soil);
            if pressure > 0.0 { (pressure, energy) } else { (0.0, 0.0) }
        } else {
            (0.0, 0.0)
        }
    }

    fn cell_mass(&self, soil: &SoilCell<D>) -> f64 {
        self.water_mass(soil.place.cell)
    }

    fn removed_mass(&self) -> f64 {
        self.inner.removed_mass
    }

    fn leaves_as_particles(&self) -> bool {
        true
    }

    fn keep(&mut self, keeper: &mut Keeper, grid: &Grid<D>) {
        self.inner.keep_state(keeper, grid);
        keeper.entries(&mut self.full, |full, keeper| keeper.bool(full));
        keeper.bool(&mut self.changed);
    }

    fn density(&self) -> f64 {
        self.inner.properties.density
    }

    fn bytes(&self) -> usize {
        Water::<K, D, S>::bytes(&self.inner) + self.full.capacity()
    }
}

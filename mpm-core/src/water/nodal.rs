//! The paper's Darcy operator: a relative velocity v* at the nodes, Eq. (1) with the sign of the body term mended
//! (`reference-data/paper/errata.md`, 1): `v* = k [ sum V G p + sum rho_w V N (g - a_s) ] / sum n rho_w g V N`.
//!
//! v* is the true relative velocity, the Darcy flux divided by n (errata, 5).

use super::exposed::Exposed;
use super::saturated::{DarcyOperator, WaterCell, cell_coefficients};
use super::{FlowRates, Place};
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::nodes::NodeMotion;
use crate::scene::WaterProperties;

/// Relative velocities at the nodes and the sums they come from.
#[derive(Debug, Clone)]
pub struct Nodal<const D: usize> {
    /// `sum V G p`, N.
    gradient: Vec<[f64; D]>,
    /// `sum V N`, m3.
    volume: Vec<f64>,
    /// `sum n V N`, m3.
    pores: Vec<f64>,
    /// v*, m/s.
    relative: Vec<[f64; D]>,
    mobility: f64,
    density: f64,
    inertia: f64,
    area: f64,
}

impl<const D: usize> DarcyOperator<D> for Nodal<D> {
    const GATHERS: bool = true;

    fn new(grid: &Grid<D>, water: &WaterProperties, area: f64, inertia: bool) -> Self {
        let nodes = grid.node_count();
        Self {
            gradient: vec![[0.0; D]; nodes],
            volume: vec![0.0; nodes],
            pores: vec![0.0; nodes],
            relative: vec![[0.0; D]; nodes],
            mobility: water.mobility(),
            density: water.density,
            inertia: if inertia { 1.0 } else { 0.0 },
            area,
        }
    }

    fn rebuild(&mut self, _: &Grid<D>, _: impl Fn(usize) -> bool, _: &Exposed) {}

    fn clear(&mut self) {
        self.gradient.fill([0.0; D]);
        self.volume.fill(0.0);
        self.pores.fill(0.0);
    }

    #[inline(always)]
    fn gather(&mut self, corners: &[usize; 4], cell: &WaterCell, gradient: &[[f64; D]; 4], volume: &[[f64; 1]; 4]) {
        for a in 0..Grid::<D>::CORNERS {
            let node = corners[a];
            for d in 0..D {
                self.gradient[node][d] += gradient[a][d];
            }
            self.volume[node] += volume[a][0];
            self.pores[node] += cell.porosity * volume[a][0];
        }
    }

    #[inline(always)]
    fn flow(
        &mut self,
        _: &Grid<D>,
        _: &[WaterCell],
        motion: &[NodeMotion<D>],
        gravity: &[f64; D],
        (exposed, drained): (&Exposed, &[bool; 4]),
    ) -> FlowRates {
        let mut rates = FlowRates::default();
        for (node, relative) in self.relative.iter_mut().enumerate() {
            let (volume, pores) = (self.volume[node], self.pores[node]);
            if volume == 0.0 {
                *relative = [0.0; D];
                continue;
            }
            for d in 0..D {
                let body = self.density * (gravity[d] - self.inertia * motion[node].acceleration[d]);
                // Eq. (1), mended
                relative[d] = self.mobility * (self.gradient[node][d] + body * volume) / pores;
            }
        }
        // Undrained: the normal component vanishes (section 3 of the paper).
        for face in exposed.faces.iter().filter(|f| !drained[f.side as usize]) {
            for node in face.nodes {
                self.relative[node as usize][face.axis as usize] = 0.0;
            }
        }
        for (node, relative) in self.relative.iter().enumerate() {
            for d in 0..D {
                let flux = relative[d] * self.pores[node];
                let body = self.density * (gravity[d] - self.inertia * motion[node].acceleration[d]);
                if flux != 0.0 {
                    rates.dissipation += flux * flux / (self.mobility * self.volume[node]);
                    rates.body_work += flux * body;
                }
            }
        }
        for face in exposed.faces.iter().filter(|f| drained[f.side as usize]) {
            let axis = face.axis as usize;
            let outwards = if face.upper { 0.5 } else { -0.5 };
            for node in face.nodes {
                let node = node as usize;
                let porosity = self.pores[node] / self.volume[node];
                rates.pass(outwards * porosity * self.relative[node][axis] * self.area);
            }
        }
        rates
    }

    #[inline(always)]
    fn relative(&self, _: &Grid<D>, place: &Place<D>, _: &WaterCell) -> [[f64; D]; 4] {
        cell_coefficients(&self.relative, &place.corners)
    }

    #[inline(always)]
    fn filling(&self, _: f64, _: f64) -> (f64, f64) {
        (1.0, 1.0)
    }

    /// Nothing: all of it is gathered anew in every step.
    fn keep(&mut self, _: &mut Keeper) {}

    fn bytes(&self) -> usize {
        let vectors = self.gradient.capacity() + self.relative.capacity();
        vectors * size_of::<[f64; D]>() + (self.volume.capacity() + self.pores.capacity()) * size_of::<f64>()
    }
}

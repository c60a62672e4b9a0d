//! Two-point flux on cell faces: `q = -(k/gamma_w) [ (p_hi - p_lo)/L - rho_w (g - a_s) ]`, the default operator.
//!
//! In one dimension it is the paper's Eq. (1) but for a cell that is not full of soil; in two it couples cells that share a face, where the paper's nodal
//! velocity couples only diagonal neighbours (`mpm-verify stability` measures what that does).
//!
//! Between cells of different conductivity the flux is that through two half cells in series: k is the harmonic mean
//! 2 k_1 k_2/(k_1 + k_2), and the pressure on the face is the one at which both halves carry the same.

use super::exposed::Exposed;
use super::saturated::{DarcyOperator, WaterCell};
use super::{FaceFlow, FlowRates, Place};
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::nodes::NodeMotion;
use crate::scene::WaterProperties;

/// A face between two cells of soil conducts fully, a drained surface lies half a cell from the centre.
pub(crate) const DRAINED_SURFACE: f64 = 2.0;
/// A cell less full than this drains as if it were this full: with its drained face half a cell away it then has
/// the same stability limit as a full cell inside, (1 + 2)/0.75 = 4. The water this miscounts shows in the ledger.
pub(crate) const LEAST_FILLING: f64 = 0.75;

/// Fluxes normal to the faces of each axis, m/s (Darcy velocity q = n v*). LAYERED: soil whose conductivity differs
/// from row to row of the cells.
#[derive(Debug, Clone)]
pub struct Face<const D: usize, const LAYERED: bool = false> {
    flux: [Vec<f64>; D],
    /// 1 between two cells of soil, else 0; in layers the conductivity of the face over that of the water.
    open: [Vec<f64>; D],
    /// Conductivity of each row of cells over that of the water; only in layers.
    rows: Vec<f64>,
    /// k / (gamma_w L): flux per pressure drop, m/(s Pa).
    conductance: f64,
    /// rho_w L: pressure drop per m/s2.
    weight: f64,
    inertia: f64,
    area: f64,
    cell_volume: f64,
}

impl<const D: usize, const LAYERED: bool> Face<D, LAYERED> {
    /// Flow per pressure drop between two cells of soil, A k/(gamma_w L) with the water's own k, m3/(s Pa).
    pub(super) fn transmissibility(&self) -> f64 {
        self.area * self.conductance
    }

    /// Conductivity of a cell over that of the water.
    #[inline(always)]
    pub(super) fn of_cell(&self, grid: &Grid<D>, cell: usize) -> f64 {
        if LAYERED { self.rows[grid.cell_position(cell)[D - 1]] } else { 1.0 }
    }

    /// Conductivity of the face between two cells of soil over that of the water: the harmonic mean.
    #[inline(always)]
    pub(super) fn between(&self, grid: &Grid<D>, cells: [usize; 2]) -> f64 {
        let [a, b] = cells.map(|cell| self.of_cell(grid, cell));
        if LAYERED { 2.0 * a * b / (a + b) } else { 1.0 }
    }

    /// The law of a face; K_w in Pa, volume of the grains per mass in m3/kg.
    pub(super) fn flow_law(&self, bulk_modulus: f64, grain_inverse: f64) -> FaceFlow {
        let Self { conductance, weight, inertia, area, cell_volume, .. } = *self;
        FaceFlow { conductance, weight, inertia, area, cell_volume, bulk_modulus, grain_inverse }
    }

    /// Volume of a cell full of soil, m3.
    pub(super) fn cell_volume(&self) -> f64 {
        self.cell_volume
    }

    /// rho_w L (g - a_s) across a face, Pa.
    #[inline(always)]
    fn body(&self, axis: usize, gravity: &[f64; D], a: &NodeMotion<D>, b: &NodeMotion<D>) -> f64 {
        let acceleration =
            if D == 1 { a.acceleration[axis] } else { 0.5 * (a.acceleration[axis] + b.acceleration[axis]) };
        self.weight * (gravity[axis] - self.inertia * acceleration)
    }
}

impl<const D: usize> Face<D> {
    /// Stops what flows in through drained faces: outside is air, which has no water to give. Returns what was booked for it.
    pub(super) fn stop_inflow(
        &mut self,
        motion: &[NodeMotion<D>],
        gravity: &[f64; D],
        exposed: &Exposed,
        drained: &[bool; 4],
    ) -> FlowRates {
        let mut stopped = FlowRates::default();
        for face in exposed.faces.iter().filter(|face| drained[face.side as usize]) {
            let axis = face.axis as usize;
            let flux = &mut self.flux[axis][face.face as usize];
            let outwards = if face.upper { *flux } else { -*flux };
            if outwards >= 0.0 {
                continue;
            }
            let flux = std::mem::take(flux);
            let (a, b) = (&motion[face.nodes[0] as usize], &motion[face.nodes[1] as usize]);
            stopped.dissipation += self.area * flux * flux / (DRAINED_SURFACE * self.conductance);
            stopped.body_work += self.area * flux * self.body(axis, gravity, a, b) / DRAINED_SURFACE;
        }
        stopped
    }
}

impl<const D: usize, const LAYERED: bool> DarcyOperator<D> for Face<D, LAYERED> {
    const GATHERS: bool = false;

    fn new(grid: &Grid<D>, water: &WaterProperties, area: f64, inertia: bool) -> Self {
        let faces = |axis| vec![0.0; grid.face_count(axis)];
        Self {
            flux: std::array::from_fn(faces),
            open: std::array::from_fn(faces),
            rows: Vec::new(),
            conductance: water.mobility() * grid.inverse_size,
            weight: water.density * grid.size,
            inertia: if inertia { 1.0 } else { 0.0 },
            area,
            cell_volume: area * grid.size,
        }
    }

    fn lay(&mut self, rows: Vec<f64>) {
        self.rows = rows;
    }

    fn rebuild(&mut self, grid: &Grid<D>, soil: impl Fn(usize) -> bool, _: &Exposed) {
        for axis in 0..D {
            self.flux[axis].fill(0.0);
            self.open[axis].fill(0.0);
            let stride: usize = grid.cells[..axis].iter().product();
            for (cell, position) in grid.walk() {
                if position[axis] > 0 && soil(cell) && soil(cell - stride) {
                    self.open[axis][grid.face(axis, &position)] = self.between(grid, [cell - stride, cell]);
                }
            }
        }
    }

    fn clear(&mut self) {}

    fn keep(&mut self, keeper: &mut Keeper) {
        for faces in self.flux.iter_mut().chain(&mut self.open) {
            keeper.all(faces);
        }
    }

    fn gather(&mut self, _: &[usize; 4], _: &WaterCell, _: &[[f64; D]; 4], _: &[[f64; 1]; 4]) {}

    #[inline(always)]
    fn flow(
        &mut self,
        grid: &Grid<D>,
        cells: &[WaterCell],
        motion: &[NodeMotion<D>],
        gravity: &[f64; D],
        (exposed, drained): (&Exposed, &[bool; 4]),
    ) -> FlowRates {
        let mut rates = FlowRates::default();
        let rows = if D == 2 { grid.cells[D - 1] } else { 1 };
        for axis in 0..D {
            let stride = if axis == 0 { 1 } else { grid.cells[0] };
            // Faces between two cells, row by row; a face and its first node share a place in their rows.
            let along = grid.cells[0] - usize::from(axis == 0);
            for row in usize::from(D == 2 && axis == 1)..rows {
                let upper = row * grid.cells[0] + usize::from(axis == 0);
                let face = row * (grid.cells[0] + usize::from(axis == 0)) + usize::from(axis == 0);
                let node = row * (grid.cells[0] + 1) + usize::from(axis == 0);
                let other = if D == 1 {
                    0
                } else if axis == 0 {
                    grid.cells[0] + 1
                } else {
                    1
                };
                let (lower_cells, upper_cells) = (&cells[upper - stride..], &cells[upper..]);
                let (first, second) = (&motion[node..], &motion[node + other..]);
                let open = &self.open[axis][face..face + along];
                for i in 0..along {
                    let body = self.body(axis, gravity, &first[i], &second[i]);
                    // Eq. (1) on a face: pressure drop plus rho_w (g - a_s).
                    let drop = lower_cells[i].pressure - upper_cells[i].pressure + body;
                    let driven = open[i] * drop;
                    let flux = self.conductance * driven;
                    let head = if LAYERED { drop } else { driven };
                    self.flux[axis][face + i] = flux;
                    rates.dissipation += flux * head;
                    rates.body_work += flux * body;
                }
            }
        }
        for face in &exposed.faces {
            let axis = face.axis as usize;
            if !drained[face.side as usize] {
                continue; // stays zero: the undrained condition
            }
            let (a, b) = (&motion[face.nodes[0] as usize], &motion[face.nodes[1] as usize]);
            let body = self.body(axis, gravity, a, b) / DRAINED_SURFACE;
            let outwards = if face.upper { 1.0 } else { -1.0 };
            let head = outwards * cells[face.cell as usize].pressure + body; // p = 0 outside
            let mut flux = DRAINED_SURFACE * self.conductance * head;
            if LAYERED {
                flux *= self.of_cell(grid, face.cell as usize);
            }
            self.flux[axis][face.face as usize] = flux;
            rates.dissipation += flux * head;
            rates.body_work += flux * body;
            rates.pass(outwards * flux);
        }
        rates.dissipation *= self.area;
        rates.body_work *= self.area;
        rates.outflow *= self.area;
        rates.inflow *= self.area;
        rates
    }

    #[inline(always)]
    fn relative(&self, grid: &Grid<D>, place: &Place<D>, cell: &WaterCell) -> [[f64; D]; 4] {
        // Linear along each axis between the two faces, v* = q/n.
        let mut k = [[0.0; D]; 4];
        for axis in 0..D {
            let (lower, stride) = if axis == 0 {
                (if D == 1 { place.cell } else { place.corners[0] }, 1)
            } else {
                (place.cell, grid.cells[0])
            };
            let (low, high) = (self.flux[axis][lower], self.flux[axis][lower + stride]);
            k[0][axis] = low * cell.inverse_porosity;
            k[1 + axis][axis] = (high - low) * cell.inverse_porosity;
        }
        k
    }

    #[inline(always)]
    fn filling(&self, inverse_volume: f64) -> f64 {
        (self.cell_volume * inverse_volume).min(1.0 / LEAST_FILLING)
    }

    fn bytes(&self) -> usize {
        self.flux.iter().chain(&self.open).map(|f| f.capacity() * size_of::<f64>()).sum()
    }
}

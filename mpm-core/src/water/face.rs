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
use crate::boundary::{Filled, Top};
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::nodes::NodeMotion;
use crate::scene::{Side, WaterProperties};

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
    /// k/(gamma_w L^2), 1/(Pa s): `D_p/L^2` per K_w/n.
    diffusion: f64,
    /// Whether the volume of soil in each cell is known.
    known: bool,
    /// Cells that hold the surface; none where it is not known, or held.
    tops: Vec<Top>,
    /// Faces between them and the cells below.
    below_tops: Vec<FaceBelow>,
}

/// The face between a cell that holds the surface and the one below.
#[derive(Debug, Clone, Copy)]
struct FaceBelow {
    /// Cell that holds the surface, cell below.
    cells: [u32; 2],
    face: u32,
    nodes: [u32; 2],
    /// Conductivity over that of the water.
    open: f64,
}

impl FaceBelow {
    const NONE: Self = Self { cells: [0; 2], face: 0, nodes: [0; 2], open: 0.0 };

    fn keep(&mut self, keeper: &mut Keeper) {
        let Self { cells: [top, below], face, nodes: [first, second], open } = self;
        for number in [top, below, face, first, second] {
            keeper.u32(number);
        }
        keeper.f64(open);
    }
}

/// What flow may change the pressure of a cell by in a step, of it, beside waves that take most of the step: of those with
/// `(M + Q) K dt^2/rho` up to `4 - 2 FLOW` none grows.
pub(crate) const FLOW: f64 = 0.5;

/// What is left of the stiffness of the water in a cell that is filled to 1/`over_fill` under a drained surface, so that an
/// explicit step is as stable there as in a full one: its flow to the surface and to the cell below, `2/f + 2/(1 + f)`, over what
/// it stores is at most that of a full cell, 2 + 1. Where a step is far from the limit of the flow, `diffusion` = `D_p dt/L^2`, as
/// much less is asked: water that hardly flows is as stiff as ever.
#[inline(always)]
pub(crate) fn softer(over_fill: f64, diffusion: f64) -> f64 {
    let fill = 1.0 / over_fill;
    let share = 1.5 * fill * fill * (1.0 + fill) / (1.0 + 2.0 * fill);
    (share * (FLOW / 3.0 / diffusion).max(1.0)).min(1.0)
}

impl<const D: usize, const LAYERED: bool> Face<D, LAYERED> {
    /// The part of a cell below the surface that is soil: 1 but for one that holds it.
    #[inline(always)]
    fn fill_of(&self, cell: usize) -> f64 {
        match self.tops.get(cell % self.tops.len().max(1)) {
            Some(top) if top.cell as usize == cell => top.fill,
            _ => 1.0,
        }
    }

    /// Distance of the middles of two cells, the lower one first, over that of full ones.
    #[inline(always)]
    pub(super) fn reach(&self, [lower, upper]: [usize; 2]) -> f64 {
        let above = upper == lower + self.tops.len();
        if above { 0.5 * (1.0 + self.fill_of(upper)) } else { 1.0 }
    }

    /// Distance of a drained surface from the middle of its cell, over the edge of a cell.
    #[inline(always)]
    pub(super) fn reach_of_surface(&self, cell: usize, side: u8) -> f64 {
        if side == Side::Top as u8 { self.fill_of(cell) / DRAINED_SURFACE } else { 1.0 / DRAINED_SURFACE }
    }

    /// Flow between the cells that hold the surface and those below.
    fn flow_below_surface(
        &mut self,
        cells: &[WaterCell],
        motion: &[NodeMotion<D>],
        gravity: &[f64; D],
        rates: &mut FlowRates,
    ) {
        for i in 0..self.below_tops.len() {
            let FaceBelow { cells: [top, below], face, nodes, open } = self.below_tops[i];
            let conducts = 1.0 / self.reach([below as usize, top as usize]);
            let [a, b] = nodes.map(|node| &motion[node as usize]);
            let body = self.body(D - 1, gravity, a, b) / conducts;
            let drop = cells[below as usize].pressure - cells[top as usize].pressure + body;
            let flux = conducts * open * drop * self.conductance;
            self.flux[D - 1][face as usize] = flux;
            rates.dissipation += flux * drop;
            rates.body_work += flux * body;
        }
    }

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

    /// The law of a face; volume of the grains per mass in m3/kg.
    pub(super) fn flow_law(&self, water: &WaterProperties, grain_inverse: f64) -> FaceFlow {
        let Self { conductance, weight, inertia, area, cell_volume, diffusion, .. } = *self;
        let WaterProperties { bulk_modulus, density, .. } = *water;
        FaceFlow { conductance, weight, inertia, area, cell_volume, diffusion, bulk_modulus, grain_inverse, density }
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
            diffusion: water.mobility() * grid.inverse_size * grid.inverse_size,
            known: false,
            tops: Vec::new(),
            below_tops: Vec::new(),
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
        self.below_tops.clear();
        for top in &self.tops {
            let position = grid.cell_position(top.cell as usize);
            let face = grid.face(D - 1, &position);
            let open = std::mem::take(&mut self.open[D - 1][face]);
            if open > 0.0 {
                let below = top.cell - self.tops.len() as u32;
                let [a, b, ..] = grid.corners(&position).map(|node| node as u32);
                let nodes = if D == 1 { [a; 2] } else { [a, b] };
                self.below_tops.push(FaceBelow { cells: [top.cell, below], face: face as u32, nodes, open });
            }
        }
    }

    fn clear(&mut self) {}

    fn keep(&mut self, keeper: &mut Keeper) {
        for faces in self.flux.iter_mut().chain(&mut self.open) {
            keeper.all(faces);
        }
        keeper.list(&mut self.below_tops, &FaceBelow::NONE, FaceBelow::keep);
        let (faces, cells) = (self.flux[D - 1].len(), self.flux.iter().map(Vec::len).max().unwrap_or(0));
        let fits = |below: &FaceBelow| {
            (below.face as usize) < faces && below.cells.into_iter().chain(below.nodes).all(|i| (i as usize) < cells)
        };
        if keeper.is_reading() && !self.below_tops.iter().all(fits) {
            keeper.refuse();
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
        self.flow_below_surface(cells, motion, gravity, &mut rates);
        for face in &exposed.faces {
            let axis = face.axis as usize;
            if !drained[face.side as usize] {
                continue; // stays zero: the undrained condition
            }
            let (a, b) = (&motion[face.nodes[0] as usize], &motion[face.nodes[1] as usize]);
            let conducts = 1.0 / self.reach_of_surface(face.cell as usize, face.side);
            let body = self.body(axis, gravity, a, b) / conducts;
            let outwards = if face.upper { 1.0 } else { -1.0 };
            let head = outwards * cells[face.cell as usize].pressure + body; // p = 0 outside
            let mut flux = conducts * head * self.conductance;
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
    fn filling(&self, inverse_volume: f64, stiffness: f64) -> (f64, f64) {
        let over_fill = self.cell_volume * inverse_volume;
        if !self.known {
            (over_fill.min(1.0 / LEAST_FILLING), 1.0)
        } else {
            (over_fill, softer(over_fill, stiffness * self.diffusion))
        }
    }

    fn knows_volumes(&self) -> bool {
        self.known
    }

    fn under_surface(&mut self, filled: &Filled<D>) {
        self.known = filled.is_known();
        self.tops.clear();
        self.tops.extend_from_slice(filled.tops());
    }

    fn bytes(&self) -> usize {
        self.flux.iter().chain(&self.open).map(|f| f.capacity() * size_of::<f64>()).sum()
    }
}

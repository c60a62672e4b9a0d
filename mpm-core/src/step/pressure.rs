//! The pressure of the end of a step, from the mass balance of the water in every cell:
//!
//! `V n/K_w (p^{n+1} - p^n) + dt [ C^T v^{n+1} + H p^{n+1} - b ] = 0` with `v^{n+1} = v* + dt m^-1 C p^{n+1}`, so
//! `(S + dt H + dt^2 C^T m^-1 C) p^{n+1} = S p^n - dt C^T v* + dt b`.
//!
//! C is the force of unit pressures on the nodes and so, transposed, the rate of volume of the cells; H the flow between
//! neighbours; b what `rho_w (g - a_s)` drives. The matrix is symmetric and positive definite: S, H and the last term
//! each are, or have only pressures in their null space that another one resists.

use super::Fault;
use super::skeleton::Skeleton;
use crate::constitutive::Laws;
use crate::dimension::Kinematics;
use crate::grid::Grid;
use crate::particles::{Layer, Point};
use crate::sparse::{Factor, Ordering, Signs, Symmetric, Unsolved};
use crate::stencil::{Basis, Functions};
use crate::water::{Cellwise, Face, Place, Saturated};

/// The pressure system of a mesh.
#[derive(Debug)]
pub struct PressureSystem<const D: usize> {
    /// Cells with soil, in order: the rows.
    cells: Vec<u32>,
    /// The matrix and its factors, kept while the cells with soil stay the same.
    system: Option<(Symmetric, Factor)>,
    /// The entries of the matrix in its order.
    entries: Vec<Entry<D>>,
    /// H over the conductance between neighbours of the water's own conductivity, in the same order.
    laplacian: Vec<f64>,
    /// Row of each cell, and the entry of the diagonal of each row.
    row_of: Vec<u32>,
    diagonal: Vec<usize>,
    /// m^-1 C dt of every cell, m2 s/kg.
    response: Vec<[f64; D]>,
    /// 1/m of the coefficients that are free to move, 1/kg.
    inverse_mass: Vec<[f64; D]>,
    /// Pressure at the start of the step, by rows, Pa.
    before: Vec<f64>,
    right: Vec<f64>,
    pressure: Vec<f64>,
    /// Under a rigid plate: what the pressures push it with, `w`, and the system solved for that.
    plate: Option<Pushes>,
    /// Rise of the pressure in a step, by cells, Pa.
    rise: Vec<f64>,
    order: [u64; 2],
}

/// The force of unit pressures on a rigid plate, m2, and the solution for it. The plate adds `dt^2 w w^t / m` to the
/// matrix, a full block of rank one, which is left out of it and put into the solution: Sherman & Morrison (1950),
/// doi:10.1214/aoms/1177729893. So is `dt w v*`, what the plate would press out without pressures: beside a plate that is held
/// it alone makes pressures which in soil that hardly drains are larger than the true ones by as much as digits hold.
#[derive(Debug, Default)]
struct Pushes {
    w: Vec<f64>,
    solution: Vec<f64>,
    /// `dt^2/m` times what damping keeps, s2/kg.
    factor: f64,
}

/// An entry of the upper triangle.
#[derive(Debug, Clone, Copy)]
struct Entry<const D: usize> {
    row: u32,
    column: u32,
    /// Place of the column's cell minus that of the row's, in cells.
    shift: [i32; D],
}

impl<const D: usize> PressureSystem<D> {
    /// The arrays for a mesh with `count` functions.
    pub fn new<B: Basis>(grid: &Grid<D>, count: usize) -> Self {
        Self {
            cells: Vec::new(),
            system: None,
            entries: Vec::new(),
            laplacian: Vec::new(),
            row_of: Vec::new(),
            diagonal: Vec::new(),
            response: vec![[0.0; D]; grid.cell_count() * Functions::<B, D>::REACHED],
            inverse_mass: vec![[0.0; D]; count],
            before: Vec::new(),
            right: Vec::new(),
            pressure: Vec::new(),
            plate: None,
            rise: vec![0.0; grid.cell_count()],
            order: [0; 2],
        }
    }

    /// Drainage has changed.
    pub fn forget(&mut self) {
        self.system = None;
    }

    /// Rise of the pressure of a cell in this step, Pa.
    pub fn rise(&self, cell: usize) -> f64 {
        self.rise[cell]
    }

    /// Solves for the pressures of the end of the step and gives them to the water. The skeleton moves with v*.
    ///
    /// # Errors
    /// A singular system, with what shows it.
    pub fn solve<K, B, L, const LAYERED: bool, const S: usize>(
        &mut self,
        skeleton: &mut Skeleton<K, B, L, Saturated<Face<D, LAYERED>, D>, D, S>,
        dt: f64,
    ) -> Result<(), Fault>
    where
        K: Kinematics<D, S>,
        B: Basis,
        L: Laws<S>,
        Saturated<Face<D, LAYERED>, D>: Cellwise<K, D, S>,
    {
        let fault = |e: Unsolved| Fault { place: "the pore pressure".to_owned(), what: e.to_string() };
        let parts = &skeleton.parts;
        if self.system.is_none() || self.order != [parts.solid.order, parts.water.layout()] {
            self.follow::<B, _, LAYERED>(&parts.grid, &parts.solid, &parts.water).map_err(fault)?;
        }
        if parts.water.has_surface() {
            self.conduct(&parts.grid, &parts.water);
        }
        self.respond(skeleton, dt);
        self.fill::<B, LAYERED>(&skeleton.coupling, &skeleton.parts.water, dt);
        let falls = dt * hold_plate(skeleton); // dt v* of the plate
        self.right_side(skeleton, dt);
        if let Some((matrix, factor)) = &mut self.system {
            factor.refresh(matrix).map_err(fault)?;
            factor.solve(matrix, &self.right, &mut self.pressure).map_err(fault)?;
            if let Some(Pushes { w, solution, factor: share }) = &mut self.plate {
                factor.solve(matrix, w, solution).map_err(fault)?;
                let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                // dt v^{n+1} of the plate
                let moved = (falls + *share * dot(w, &self.pressure)) / (1.0 + *share * dot(w, solution));
                self.pressure.iter_mut().zip(solution).for_each(|(p, s)| *p -= moved * *s);
            }
        }
        for (row, &cell) in self.cells.iter().enumerate() {
            self.rise[cell as usize] = self.pressure[row] - self.before[row];
            skeleton.parts.water.set_pressure(cell as usize, self.pressure[row]);
        }
        Ok(())
    }

    /// The pattern, where the cells with soil are others than before: cells whose particles reach a common function.
    fn follow<B: Basis, P: Point<D>, const LAYERED: bool>(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<P, D>,
        water: &Saturated<Face<D, LAYERED>, D>,
    ) -> Result<(), Unsolved> {
        self.order = [solid.order, water.layout()];
        let soil = |cell: usize| !solid.range(cell).is_empty() && water.is_wet(cell);
        let same = self.cells.iter().map(|c| *c as usize).eq((0..grid.cell_count()).filter(|c| soil(*c)));
        if self.system.is_some() && same {
            return Ok(());
        }
        self.cells.clear();
        self.cells.extend((0..grid.cell_count() as u32).filter(|c| soil(*c as usize)));
        let count = self.cells.len();
        self.row_of.clear();
        self.row_of.resize(grid.cell_count(), u32::MAX);
        for (row, cell) in self.cells.iter().enumerate() {
            self.row_of[*cell as usize] = row as u32;
        }
        self.entries.clear();
        let reach = B::REACH as i32 - 1;
        self.diagonal.clear();
        for (column, &cell) in self.cells.iter().enumerate() {
            let position = grid.cell_position(cell as usize);
            for shift in window::<D>(reach) {
                let other: [i32; D] = std::array::from_fn(|d| position[d] as i32 - shift[d]);
                if (0..D).any(|d| other[d] < 0 || other[d] >= grid.cells[d] as i32) {
                    continue;
                }
                let other = (0..D).rev().fold(0, |cell, d| cell * grid.cells[d] + other[d] as usize);
                let row = self.row_of[other];
                if row as usize <= column {
                    self.entries.push(Entry { row, column: column as u32, shift });
                }
            }
            self.diagonal.push(self.entries.len() - 1); // rows ascend: the diagonal closes its column
        }
        self.conduct(grid, water);
        let matrix = Symmetric::new(count, self.entries.iter().map(|e| (e.row as usize, e.column as usize)));
        let ordering = if D == 1 { Ordering::AsNumbered } else { Ordering::MinimumDegree };
        let factor = Factor::new(&matrix, Signs::Definite, ordering)?;
        self.system = Some((matrix, factor));
        for values in [&mut self.before, &mut self.right, &mut self.pressure] {
            values.clear();
            values.resize(count, 0.0);
        }
        Ok(())
    }

    /// H from the conductances of the faces.
    fn conduct<const LAYERED: bool>(&mut self, grid: &Grid<D>, water: &Saturated<Face<D, LAYERED>, D>) {
        self.laplacian.clear();
        self.laplacian.resize(self.entries.len(), 0.0);
        for (k, Entry { row, column, shift }) in self.entries.iter().enumerate() {
            if shift.iter().map(|s| s.abs()).sum::<i32>() == 1 {
                let cells = [*row, *column].map(|row| self.cells[row as usize] as usize);
                let between = water.conductance_between(grid, cells);
                self.laplacian[k] -= between;
                self.laplacian[self.diagonal[*row as usize]] += between;
                self.laplacian[self.diagonal[*column as usize]] += between;
            }
        }
        for (cell, conductance) in water.outlets(grid) {
            self.laplacian[self.diagonal[self.row_of[cell] as usize]] += conductance;
        }
    }

    /// `dt m^-1 C`: the velocities that a unit pressure in a cell makes, without the held coefficients.
    fn respond<K, B, L, const LAYERED: bool, const S: usize>(
        &mut self,
        skeleton: &Skeleton<K, B, L, Saturated<Face<D, LAYERED>, D>, D, S>,
        dt: f64,
    ) where
        K: Kinematics<D, S>,
        B: Basis,
        L: Laws<S>,
        Saturated<Face<D, LAYERED>, D>: Cellwise<K, D, S>,
    {
        let keep = skeleton.kept(dt);
        for (inverse, node) in self.inverse_mass.iter_mut().zip(&skeleton.nodes) {
            *inverse = [if node.solid_mass > 0.0 { keep * dt / node.mixture_mass } else { 0.0 }; D];
        }
        skeleton.parts.supports.hold(&mut self.inverse_mass);
        self.lean_on_plate(skeleton, keep * dt * dt);
        let reached = Functions::<B, D>::REACHED;
        for &cell in &self.cells {
            let position = skeleton.parts.grid.cell_position(cell as usize);
            for k in 0..reached {
                let at = cell as usize * reached + k;
                self.response[at] = [0.0; D];
                if let Some(function) = skeleton.functions.at_place(&position, k) {
                    for d in 0..D {
                        self.response[at][d] = self.inverse_mass[function][d] * skeleton.coupling[at][d];
                    }
                }
            }
        }
    }

    /// The plate's part of the matrix; without it its nodes are held.
    fn lean_on_plate<K, B, L, const LAYERED: bool, const S: usize>(
        &mut self,
        skeleton: &Skeleton<K, B, L, Saturated<Face<D, LAYERED>, D>, D, S>,
        kept: f64,
    ) where
        K: Kinematics<D, S>,
        B: Basis,
        L: Laws<S>,
        Saturated<Face<D, LAYERED>, D>: Cellwise<K, D, S>,
    {
        let Some(plate) = &skeleton.parts.plate else { return };
        let reached = Functions::<B, D>::REACHED;
        let pushes = self.plate.get_or_insert_with(Pushes::default);
        pushes.factor = kept / plate.mass(&skeleton.nodes);
        for values in [&mut pushes.w, &mut pushes.solution] {
            values.clear();
            values.resize(self.cells.len(), 0.0);
        }
        for node in plate.nodes() {
            self.inverse_mass[node][D - 1] = 0.0;
        }
        for (row, &cell) in self.cells.iter().enumerate() {
            let position = skeleton.parts.grid.cell_position(cell as usize);
            for k in 0..reached {
                let function = skeleton.functions.at_place(&position, k);
                if function.is_some_and(|function| plate.holds(function)) {
                    pushes.w[row] += skeleton.coupling[cell as usize * reached + k][D - 1];
                }
            }
        }
    }

    /// `S + dt H + dt^2 C^T m^-1 C`.
    fn fill<B: Basis, const LAYERED: bool>(
        &mut self,
        coupling: &[[f64; D]],
        water: &Saturated<Face<D, LAYERED>, D>,
        dt: f64,
    ) {
        let Some((matrix, _)) = &mut self.system else { return };
        let flow = dt * water.transmissibility();
        let reached = Functions::<B, D>::REACHED;
        for (k, entry) in self.entries.iter().enumerate() {
            let (row, column) = (self.cells[entry.row as usize] as usize, self.cells[entry.column as usize] as usize);
            let common = in_common::<B, D>(
                &coupling[row * reached..][..reached],
                &self.response[column * reached..][..reached],
                &entry.shift,
            );
            let storage = if row == column { water.storage(row) } else { 0.0 };
            matrix.values[k] = storage + flow * self.laplacian[k] + dt * common;
        }
    }

    /// `S p^n - dt C^T v* + dt b`.
    fn right_side<K, B, L, const LAYERED: bool, const S: usize>(
        &mut self,
        skeleton: &mut Skeleton<K, B, L, Saturated<Face<D, LAYERED>, D>, D, S>,
        dt: f64,
    ) where
        K: Kinematics<D, S>,
        B: Basis,
        L: Laws<S>,
        Saturated<Face<D, LAYERED>, D>: Cellwise<K, D, S>,
    {
        let crate::step::Parts { water, grid, gravity, .. } = &mut skeleton.parts;
        for (row, &cell) in self.cells.iter().enumerate() {
            self.before[row] = water.cell(cell as usize).pressure;
            water.set_pressure(cell as usize, 0.0);
        }
        // Without pressures the body force alone drives the flow.
        water.drive(grid, &skeleton.mesh, &gravity.unwrap_or([0.0; D]));
        let reached = Functions::<B, D>::REACHED;
        for (row, &cell) in self.cells.iter().enumerate() {
            let cell = cell as usize;
            let position = grid.cell_position(cell);
            let place = Place { cell, position, corners: grid.corners_from(grid.first_corner(cell, &position)) };
            let mut gained = 0.0; // C^T v*
            for k in 0..reached {
                if let Some(function) = skeleton.functions.at_place(&position, k) {
                    for d in 0..D {
                        gained += skeleton.coupling[cell * reached + k][d] * skeleton.motion[function].velocity[d];
                    }
                }
            }
            let leaving = water.outflow(grid, &place);
            self.right[row] = water.storage(cell) * self.before[row] - dt * (gained + leaving);
        }
    }

    /// Adds the force `C p^{n+1}` to the nodes.
    pub fn push<K, B, L, const LAYERED: bool, const S: usize>(
        &self,
        skeleton: &mut Skeleton<K, B, L, Saturated<Face<D, LAYERED>, D>, D, S>,
    ) where
        K: Kinematics<D, S>,
        B: Basis,
        L: Laws<S>,
        Saturated<Face<D, LAYERED>, D>: Cellwise<K, D, S>,
    {
        let reached = Functions::<B, D>::REACHED;
        for (row, &cell) in self.cells.iter().enumerate() {
            let position = skeleton.parts.grid.cell_position(cell as usize);
            for k in 0..reached {
                if let Some(function) = skeleton.functions.at_place(&position, k) {
                    for d in 0..D {
                        let force = skeleton.coupling[cell as usize * reached + k][d] * self.pressure[row];
                        skeleton.nodes[function].force[d] += force;
                    }
                }
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let vectors = self.response.capacity() + self.inverse_mass.capacity();
        let numbers = [&self.laplacian, &self.before, &self.right, &self.pressure, &self.rise];
        vectors * size_of::<[f64; D]>()
            + numbers.iter().map(|n| n.capacity()).sum::<usize>() * size_of::<f64>()
            + self.entries.capacity() * size_of::<Entry<D>>()
            + self.cells.capacity() * size_of::<u32>()
            + self.system.as_ref().map_or(0, |(matrix, factor)| matrix.bytes() + factor.bytes())
    }
}

/// Takes the vertical velocity v* (m/s) of a rigid plate from its nodes, which is what it returns: the next equation of motion
/// gives them theirs.
fn hold_plate<K, B, L, W, const D: usize, const S: usize>(skeleton: &mut Skeleton<K, B, L, W, D, S>) -> f64 {
    let Skeleton { parts, nodes, motion, .. } = skeleton;
    let with_mass = parts.plate.iter().flat_map(|plate| plate.nodes()).filter(|node| nodes[*node].solid_mass > 0.0);
    with_mass.fold(0.0, |_, node| std::mem::take(&mut motion[node].velocity[D - 1]))
}

/// Places of a window around a cell, from those of larger to those of smaller cell numbers being subtracted: the cell
/// at `position - shift` ascends.
fn window<const D: usize>(reach: i32) -> impl Iterator<Item = [i32; D]> {
    let along = 2 * reach + 1;
    (0..along.pow(D as u32)).map(move |number| {
        let mut rest = number;
        std::array::from_fn(|_| {
            let shift = reach - rest % along;
            rest /= along;
            shift
        })
    })
}

/// `sum_i a_i . b_i` over the functions that the particles of two cells both reach.
#[inline(always)]
fn in_common<B: Basis, const D: usize>(a: &[[f64; D]], b: &[[f64; D]], shift: &[i32; D]) -> f64 {
    let range = |d: usize| {
        let low = shift[d].max(0);
        let high = (B::REACH as i32 + shift[d]).min(B::REACH as i32);
        low as usize..high as usize
    };
    let mut sum = 0.0;
    let mut row = |offset: [usize; 2]| {
        for i in range(0) {
            let (at, other) = (offset[0] + i, offset[1] + (i as i32 - shift[0]) as usize);
            for d in 0..D {
                sum += a[at][d] * b[other][d];
            }
        }
    };
    if D == 1 {
        row([0, 0]);
    } else {
        for j in range(D - 1) {
            row([j * B::REACH, (j as i32 - shift[D - 1]) as usize * B::REACH]);
        }
    }
    sum
}

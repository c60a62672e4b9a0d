//! The semi-implicit step: pore pressures of the end of the step at the cells, from the mass balance of the water in each.
//!
//! `V n/K_w (p^{n+1} - p^n) + dt [ C^T v^{n+1} + H p^{n+1} - b ] = 0` with `v^{n+1} = v* + dt m^-1 C p^{n+1}`, so
//! `(S + dt H + dt^2 C^T m^-1 C) p^{n+1} = S p^n - dt C^T v* + dt b`.
//!
//! C is the force of unit pressures on the nodes and so, transposed, the rate of volume of the cells; H the flow between
//! neighbours; b what `rho_w (g - a_s)` drives. The matrix is symmetric and positive definite: S, H and the last term
//! each are, or have only pressures in their null space that another one resists. The water neither limits the step by its wave nor
//! by its flow; what remains is the wave of the skeleton (`stability`).
//!
//! Every flow is that of the explicit step. Its rule for cells that are hardly filled is not needed here: it keeps an explicit step
//! stable, and without it the system is symmetric and no water is lost.
//!
//! `rho_w a_s` in Darcy's law is that of the step before. With the acceleration of this step the system would not be
//! symmetric, and its limit lower: at the eigenvalue -1 the term of Eq. (1) then takes `2 k/g` from dt in the
//! pressure that a strain builds up, where the lagged one adds it. Being late it feeds waves in permeable soil, above a step
//! that `stability` knows.

use super::faces::Faces;
use super::store::nodes::SOLID_MASS;
use super::store::{Frame, Nodes, Strip};
use super::{Fault, Work};
use crate::real::array_of;
use crate::sparse::{Factor, Ordering, Signs, Sparse, Unsolved};
use crate::water::FaceFlow;

/// The pressure system of a mesh. Cells and functions have the numbers of its frame.
#[derive(Debug)]
pub struct PressureSystem<const D: usize> {
    frame: Frame<D>,
    /// Rise of the pressure of each cell in a step, Pa.
    pub rise: Vec<f64>,
    /// What has been solved.
    pub work: Work,
    /// Functions that something holds along an axis, in this step.
    pub held: Vec<(usize, usize)>,
    /// Cells with soil, in order: the rows.
    cells: Vec<u32>,
    /// The matrix and its factors, kept while the cells with soil stay the same.
    system: Option<(Sparse, Factor)>,
    /// The entries of the matrix in its order.
    entries: Vec<Entry<D>>,
    /// H over the conductance between neighbours of the water's own conductivity, in the same order.
    laplacian: Vec<f64>,
    /// Row of each cell, and the entry of the diagonal of each row.
    row_of: Vec<u32>,
    diagonal: Vec<usize>,
    /// m^-1 C dt of every row, m2 s/kg.
    response: Vec<f64>,
    /// dt/m of the functions that are free to move, s/kg.
    inverse_mass: Vec<[f64; D]>,
    /// Pressure at the start of the step, by rows, Pa.
    before: Vec<f64>,
    right: Vec<f64>,
    pressure: Vec<f64>,
    /// Under a rigid plate: what the pressures push it with, `w`, and the system solved for that.
    plate: Option<Pushes>,
}

/// The force of unit pressures on a rigid plate, m2, and the solution for it. The plate adds `dt^2 w w^t / m` to the
/// matrix, a full block of rank one, which is left out of it and put into the solution: Sherman & Morrison (1950),
/// doi:10.1214/aoms/1177729893. So is `dt w v*`, what the plate would press out without pressures: beside a plate that is fixed
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

/// What a step gives the system: the flow, gravity and the accelerations of the nodes of the mesh (m/s2) that drive it, what
/// damping keeps of a velocity, and the length of the step, s.
pub struct Driving<'a, const D: usize> {
    /// How faces conduct.
    pub faces: &'a Faces<D>,
    /// Darcy's law on them.
    pub flow: &'a FaceFlow,
    /// Gravity, m/s2.
    pub gravity: [f64; D],
    /// Accelerations of the nodes of the mesh, m/s2.
    pub acceleration: &'a [Vec<f64>; 2],
    /// Share of a velocity that damping keeps.
    pub keeps: f64,
    /// Time step, s.
    pub dt: f64,
    /// Whether distances change with the place of the surface, or conductivities with the pores.
    pub has_surface: bool,
}

impl<const D: usize> PressureSystem<D> {
    /// The arrays of a mesh.
    pub fn new(frame: Frame<D>) -> Self {
        Self {
            rise: vec![0.0; frame.count()],
            work: Work::default(),
            held: Vec::new(),
            cells: Vec::new(),
            system: None,
            entries: Vec::new(),
            laplacian: Vec::new(),
            row_of: Vec::new(),
            diagonal: Vec::new(),
            response: Vec::new(),
            inverse_mass: vec![[0.0; D]; frame.length()],
            before: Vec::new(),
            right: Vec::new(),
            pressure: Vec::new(),
            plate: None,
            frame,
        }
    }

    /// Numbers of C that a cell has.
    fn of_cell(frame: &Frame<D>) -> usize {
        frame.reach.pow(D as u32) * D
    }

    /// Numbers of C that a strip has.
    pub fn of_strip(&self) -> usize {
        self.frame.strip * Self::of_cell(&self.frame)
    }

    /// Soil or drainage have changed.
    pub fn forget(&mut self) {
        self.system = None;
    }

    /// Solves for the pressures of the end of the step (Pa, from [`Frame::pad`] on), where those of its start are. The nodes move with
    /// v*, and those of [`Self::held`] do not; `plate` are those of a rigid plate.
    ///
    /// # Errors
    /// A singular system, with what shows it.
    pub fn solve(
        &mut self,
        strips: &[Strip<D>],
        nodes: &mut Nodes<D>,
        pressure: &mut [f64],
        plate: &[u32],
        by: &Driving<D>,
    ) -> Result<(), Fault> {
        let fault = |e: Unsolved| Fault { place: "the pore pressure".to_owned(), what: e.to_string() };
        if self.system.is_none() {
            self.follow(strips).map_err(fault)?;
            self.conduct(by.faces);
        } else if by.has_surface {
            self.conduct(by.faces);
        }
        self.respond(strips, nodes, plate, by);
        self.fill(strips, by);
        let falls = by.dt * by.keeps * hold_plate(nodes, plate); // dt v* of the plate
        self.right_side(strips, nodes, &pressure[self.frame.pad()..], by);
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
        self.work.factorisations += 1;
        self.work.solves += 1;
        for (row, &cell) in self.cells.iter().enumerate() {
            self.rise[cell as usize] = self.pressure[row] - self.before[row];
            pressure[self.frame.pad() + cell as usize] = self.pressure[row];
        }
        Ok(())
    }

    /// The pattern: cells whose particles reach a common function.
    fn follow(&mut self, strips: &[Strip<D>]) -> Result<(), Unsolved> {
        let frame = self.frame;
        let wet = |cell: &usize| {
            let (strip, inside) = (&strips[cell / frame.strip], cell % frame.strip);
            strip.solid.count(inside) > 0 && strip.water.count(inside) > 0
        };
        self.cells.clear();
        self.cells.extend((0..frame.count()).filter(wet).map(|cell| cell as u32));
        let count = self.cells.len();
        self.row_of.clear();
        self.row_of.resize(frame.length(), u32::MAX);
        for (row, cell) in self.cells.iter().enumerate() {
            self.row_of[*cell as usize] = row as u32;
        }
        self.entries.clear();
        self.diagonal.clear();
        for (column, &cell) in self.cells.iter().enumerate() {
            let position = frame.position(cell as usize);
            for shift in window::<D>(frame.reach as i32 - 1) {
                let other: [i32; D] = array_of(|d| position[d] as i32 - shift[d]);
                if (0..D).any(|d| other[d] < 0 || other[d] >= frame.cells[d] as i32) {
                    continue;
                }
                let row = self.row_of[frame.number(&other.map(|i| i as usize))];
                if row as usize <= column {
                    self.entries.push(Entry { row, column: column as u32, shift });
                }
            }
            self.diagonal.push(self.entries.len() - 1); // rows ascend: the diagonal closes its column
        }
        let matrix = Sparse::symmetric(count, self.entries.iter().map(|e| (e.row as usize, e.column as usize)));
        let ordering = if D == 1 { Ordering::AsNumbered } else { Ordering::MinimumDegree };
        let factor = Factor::new(&matrix, Signs::Definite, ordering)?;
        self.system = Some((matrix, factor));
        for values in [&mut self.before, &mut self.right, &mut self.pressure] {
            values.clear();
            values.resize(count, 0.0);
        }
        self.response.clear();
        self.response.resize(count * Self::of_cell(&frame), 0.0);
        Ok(())
    }

    /// H from the conductances of the faces.
    fn conduct(&mut self, faces: &Faces<D>) {
        self.laplacian.clear();
        self.laplacian.resize(self.entries.len(), 0.0);
        for (k, Entry { row, column, shift }) in self.entries.iter().enumerate() {
            if shift.iter().map(|s| s.abs()).sum::<i32>() == 1 {
                let axis = shift.iter().position(|s| *s != 0).unwrap_or(0);
                let upper = self.cells[*column.max(row) as usize] as usize;
                let between = self.frame.thickness(axis, upper) * faces.conducts[axis][upper];
                self.laplacian[k] -= between;
                self.laplacian[self.diagonal[*row as usize]] += between;
                self.laplacian[self.diagonal[*column as usize]] += between;
            }
        }
        for face in &faces.drained {
            let area = self.frame.thickness(face.axis, face.face);
            self.laplacian[self.diagonal[self.row_of[face.cell] as usize]] += area * faces.of_drained(face);
        }
        for outlet in faces.outlets.iter().filter(|outlet| outlet.outside.is_some()) {
            self.laplacian[self.diagonal[self.row_of[outlet.cell] as usize]] += outlet.conducts;
        }
    }

    /// `dt m^-1 C`: the velocities that a unit pressure in a cell makes, without the fixed functions.
    fn respond(&mut self, strips: &[Strip<D>], nodes: &Nodes<D>, plate: &[u32], by: &Driving<D>) {
        let dt = by.keeps * by.dt;
        for node in 0..self.frame.count() {
            let free = nodes.sum(SOLID_MASS, node) > 0.0;
            self.inverse_mass[node] = [if free { dt / nodes.mixture_mass(node) } else { 0.0 }; D];
        }
        for (node, axis) in &self.held {
            self.inverse_mass[*node][*axis] = 0.0;
        }
        self.lean_on_plate(strips, nodes, plate, dt * by.dt);
        let (reached, of_cell) = (self.frame.reach.pow(D as u32), Self::of_cell(&self.frame));
        for (row, &cell) in self.cells.iter().enumerate() {
            let cell = cell as usize;
            let coupling = coupling(strips, &self.frame, cell);
            for a in 0..reached {
                let inverse = &self.inverse_mass[cell + self.frame.offset(a)];
                for d in 0..D {
                    self.response[row * of_cell + a * D + d] = inverse[d] * coupling[a * D + d];
                }
            }
        }
    }

    /// The plate's part of the matrix; without it its nodes are fixed.
    fn lean_on_plate(&mut self, strips: &[Strip<D>], nodes: &Nodes<D>, plate: &[u32], kept: f64) {
        if plate.is_empty() {
            return;
        }
        let of_cell = Self::of_cell(&self.frame);
        let pushes = self.plate.get_or_insert_with(Pushes::default);
        pushes.factor = kept / plate.iter().map(|node| nodes.mixture_mass(*node as usize)).sum::<f64>();
        for values in [&mut pushes.w, &mut pushes.solution] {
            values.clear();
            values.resize(self.cells.len(), 0.0);
        }
        for node in plate {
            self.inverse_mass[*node as usize][D - 1] = 0.0;
        }
        for (row, &cell) in self.cells.iter().enumerate() {
            for a in 0..of_cell / D {
                let function = (cell as usize + self.frame.offset(a)) as u32;
                if plate.binary_search(&function).is_ok() {
                    pushes.w[row] += coupling(strips, &self.frame, cell as usize)[a * D + D - 1];
                }
            }
        }
    }

    /// `S + dt H + dt^2 C^T m^-1 C`.
    fn fill(&mut self, strips: &[Strip<D>], by: &Driving<D>) {
        let Some((matrix, _)) = &mut self.system else { return };
        let flow = by.dt * by.flow.area * by.flow.conductance;
        let (reach, of_cell) = (self.frame.reach, Self::of_cell(&self.frame));
        for (k, Entry { row, column, shift }) in self.entries.iter().enumerate() {
            let cell = self.cells[*row as usize] as usize;
            let a = coupling(strips, &self.frame, cell);
            let b = &self.response[*column as usize * of_cell..][..of_cell];
            let common = in_common(a, b, reach, shift);
            let storage = if row == column { storage(strips, &self.frame, cell, (by.flow, by.faces)) } else { 0.0 };
            matrix.values[k] = storage + flow * self.laplacian[k] + by.dt * common;
        }
    }

    /// `S p^n - dt C^T v* + dt b`.
    fn right_side(
        &mut self,
        strips: &[Strip<D>],
        nodes: &Nodes<D>,
        pressure: &[f64],
        Driving { faces, flow, gravity, acceleration, keeps, dt, .. }: &Driving<D>,
    ) {
        let of_cell = Self::of_cell(&self.frame);
        for (row, &cell) in self.cells.iter().enumerate() {
            let cell = cell as usize;
            self.before[row] = pressure[cell];
            let coupling = coupling(strips, &self.frame, cell);
            let mut gained = 0.0; // C^T v*
            for a in 0..of_cell / D {
                for d in 0..D {
                    let v = keeps * nodes.motion.velocity[d][cell + self.frame.offset(a)];
                    gained += coupling[a * D + d] * v;
                }
            }
            let mut leaving = 0.0; // -b: without pressures the body force alone drives the flow
            for d in 0..D {
                for (face, outwards) in [(cell, -1.0), (cell + self.frame.stride[d], 1.0)] {
                    if faces.conducts[d][face] > 0.0 {
                        let area = outwards * self.frame.thickness(d, face);
                        leaving += area * faces.flux(flow, (d, face), 0.0, (gravity[d], acceleration));
                    }
                }
            }
            let stored = storage(strips, &self.frame, cell, (flow, faces)) * self.before[row];
            self.right[row] = stored - dt * (gained + flow.area * leaving);
        }
        for outlet in &faces.outlets {
            let Some(outside) = outlet.outside else { continue };
            let body = faces.weight_on(outlet, flow, (gravity, acceleration));
            let row = self.row_of[outlet.cell] as usize;
            self.right[row] += dt * flow.area * flow.conductance * outlet.conducts * (outside - body);
        }
        for intake in &faces.intakes {
            self.right[self.row_of[intake.cell] as usize] -= dt * intake.rate;
        }
    }

    /// Adds the force `C p^{n+1}` to the nodes.
    pub fn push(&self, strips: &[Strip<D>], nodes: &mut Nodes<D>) {
        let of_cell = Self::of_cell(&self.frame);
        for (row, &cell) in self.cells.iter().enumerate() {
            let cell = cell as usize;
            let coupling = coupling(strips, &self.frame, cell);
            for a in 0..of_cell / D {
                for d in 0..D {
                    let force = coupling[a * D + d] * self.pressure[row];
                    nodes.push(cell + self.frame.offset(a), d, force);
                }
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let numbers = [&self.laplacian, &self.before, &self.right, &self.pressure, &self.rise, &self.response];
        self.inverse_mass.capacity() * size_of::<[f64; D]>()
            + numbers.iter().map(|n| n.capacity()).sum::<usize>() * size_of::<f64>()
            + self.entries.capacity() * size_of::<Entry<D>>()
            + (self.cells.capacity() + self.row_of.capacity()) * size_of::<u32>()
            + self.system.as_ref().map_or(0, |(matrix, factor)| matrix.bytes() + factor.bytes())
    }
}

/// C of a cell: force of a unit pressure on the functions that its particles reach, `sum_p V_p G_i`, m2: `[function][axis]`.
fn coupling<'a, const D: usize>(strips: &'a [Strip<D>], frame: &Frame<D>, cell: usize) -> &'a [f64] {
    let of_cell = PressureSystem::of_cell(frame);
    &strips[cell / frame.strip].coupling[cell % frame.strip * of_cell..][..of_cell]
}

/// Water that a cell stores per pressure, V n/K_w and what its grains give, m3/Pa; zero where neither compresses.
pub(super) fn storage<const D: usize>(
    strips: &[Strip<D>],
    frame: &Frame<D>,
    cell: usize,
    (flow, faces): (&FaceFlow, &Faces<D>),
) -> f64 {
    let [porosity, inverse_volume] = strips[cell / frame.strip].pores(cell % frame.strip);
    let of_grains = faces.biot[1].get(cell).map_or(0.0, |grains| grains / inverse_volume);
    porosity / (inverse_volume * flow.bulk_modulus) + of_grains
}

/// Takes the vertical velocity v* (m/s) of a rigid plate from its nodes, which is what it returns: the next equation of motion
/// gives them theirs.
fn hold_plate<const D: usize>(nodes: &mut Nodes<D>, plate: &[u32]) -> f64 {
    let mut falls = 0.0;
    for node in plate.iter().map(|node| *node as usize) {
        if nodes.sum(SOLID_MASS, node) > 0.0 {
            falls = std::mem::take(&mut nodes.motion.velocity[D - 1][node]);
        }
    }
    falls
}

/// Places of a window around a cell, from those of larger to those of smaller cell numbers being subtracted: the cell
/// at `position - shift` ascends.
fn window<const D: usize>(reach: i32) -> impl Iterator<Item = [i32; D]> {
    let along = 2 * reach + 1;
    (0..along.pow(D as u32)).map(move |number| {
        let mut rest = number;
        array_of(|_| {
            let shift = reach - rest % along;
            rest /= along;
            shift
        })
    })
}

/// `sum_i a_i . b_i` over the functions that the particles of two cells both reach.
#[inline(always)]
fn in_common<const D: usize>(a: &[f64], b: &[f64], reach: usize, shift: &[i32; D]) -> f64 {
    let range = |d: usize| {
        let low = shift[d].max(0);
        let high = (reach as i32 + shift[d]).min(reach as i32);
        low as usize..high as usize
    };
    let mut sum = 0.0;
    let mut row = |offset: [usize; 2]| {
        for i in range(0) {
            let (at, other) = (offset[0] + i, offset[1] + (i as i32 - shift[0]) as usize);
            for d in 0..D {
                sum += a[at * D + d] * b[other * D + d];
            }
        }
    };
    if D == 1 {
        row([0, 0]);
    } else {
        for j in range(D - 1) {
            row([j * reach, (j as i32 - shift[D - 1]) as usize * reach]);
        }
    }
    sum
}

//! One step of a whole mesh as a matrix, put together from the equations and not from the code of the step.
//!
//! With particles that stand still the step is linear in the nodal velocities `v` (m/s), the forces of the skeleton on
//! the nodes `f = -sum_p V_p G sigma'` (N) and the pore pressures p (Pa):
//!
//! - `a = m^-1 (f + C p)`, `w = v + dt a`: the velocity that strains the mesh;
//! - `v' = flip v + S (flip dt a + (1 - flip) w)`, `S = m_s^-1 sum_p m_p N N^t`: what particles take and give back;
//! - `f' = f - dt K w`, `K = sum_p V_p G^t D G`, for B-bar with the change of volume of the middle of the cell; `V n/K_w (p' - p) = -dt (C^t w + H p - B a)`, `C = sum_p V_p G`.
//!
//! H is the flow that pressures drive, B the one that `rho_w a_s` holds back. The semi-implicit step has p' for p in `a`
//! and in the flow, and the acceleration of the step before in B. The largest growth of any state is the spectral
//! radius: here open knots, held sides, few cells and lagged inertia are all in, which no plane wave knows.

use mpm_core::grid::Grid;
use mpm_core::particles::even_positions;
use mpm_core::scene::{DarcyChoice, Dimension, Integrator, Scene, ShapeChoice, SolidSide};
use mpm_core::step::kernel::{Basis, Bspline, Gimp};
use nalgebra::{DMatrix, DVector};

use super::around::{At, Gradients, Products};

/// A mesh with its particles, as matrices. Rows of `v` and `f` are the components that are free to move.
#[derive(Debug, Clone)]
pub struct Assembled {
    implicit: bool,
    flip: f64,
    /// 1/m of soil and water, 1/kg.
    inverse_mass: DVector<f64>,
    /// S.
    transfer: DMatrix<f64>,
    /// K, N/m.
    stiffness: DMatrix<f64>,
    /// Takes forces to those that stresses can make, the range of K: one particle per cell has fewer stresses than
    /// splines have coefficients, and a force that no stress makes would push for ever.
    possible: DMatrix<f64>,
    /// C, m2.
    coupling: DMatrix<f64>,
    /// V n/K_w, m3/Pa.
    storage: DVector<f64>,
    /// H, m3/(s Pa).
    flow: DMatrix<f64>,
    /// B of accelerations at the nodes of the mesh, m2 s.
    body: DMatrix<f64>,
    /// Acceleration at the nodes of the mesh from that of the coefficients.
    to_mesh: DMatrix<f64>,
    /// Angular frequency that makes forces and velocities of one size, 1/s.
    frequency: f64,
}

/// Steps of the two powers that are compared are `2^DOUBLINGS` and half of it: what grows with the number of steps, and
/// not with its exponential, looks as if it grew by `2^(1/4096)` per step.
const DOUBLINGS: u32 = 13;
/// Growth per step from which a step is unstable: well above what doubles in 4096 steps, 1.00017, and so much that a run
/// can show it.
pub const NEUTRAL: f64 = 1.001;

impl Assembled {
    /// The mesh of a saturated scene; nothing for other scenes and for integrators without a limit.
    pub fn of(scene: &Scene) -> Option<Self> {
        if !matches!(scene.integrator, Integrator::Explicit | Integrator::SemiImplicit) || scene.outline.is_some() {
            return None;
        }
        let per_direction = scene.particles_per_direction();
        match scene.shape {
            ShapeChoice::Centre | ShapeChoice::Centroid => Self::with(scene, Bspline::<1>, Gradients::AtCentre),
            ShapeChoice::Linear => Self::with(scene, Bspline::<1>, Gradients::AtParticle),
            ShapeChoice::BBar => Self::with(scene, Bspline::<1>, Gradients::Split),
            ShapeChoice::Gimp => Self::with(scene, Gimp::new(per_direction), Gradients::AtParticle),
            ShapeChoice::Bspline2 => Self::with(scene, Bspline::<2>, Gradients::AtParticle),
            ShapeChoice::Bspline3 => None,
        }
    }

    fn with<B: Basis>(scene: &Scene, basis: B, gradients: Gradients) -> Option<Self> {
        match scene.dimension {
            Dimension::Column => Builder::new(scene, (basis, gradients), [scene.cells[1]], scene.width)?.build(scene),
            _ => Builder::new(scene, (basis, gradients), scene.cells, scene.cell)?.build(scene),
        }
    }

    /// The matrix of a step (s) over states (v, f, p, and a of the step before where it is needed), in units of which
    /// none is far larger than the others.
    pub fn matrix(&self, dt: f64) -> DMatrix<f64> {
        let (free, points) = self.coupling.shape();
        let lagged = if self.implicit && self.body.iter().any(|b| *b != 0.0) { self.body.ncols() } else { 0 };
        let size = 2 * free + points + lagged;
        let rows =
            |first: usize, count: usize| DMatrix::from_fn(count, size, |i, j| if j == first + i { 1.0 } else { 0.0 });
        let (v, f, p, before) =
            (rows(0, free), rows(free, free), rows(2 * free, points), rows(2 * free + points, lagged));
        let per_mass = |force: DMatrix<f64>| scaled(force, &self.inverse_mass);
        let (acceleration, pressure, held_back) = if self.implicit {
            let dry = &v + dt * per_mass(f.clone());
            let response = per_mass(self.coupling.clone());
            let system =
                DMatrix::from_diagonal(&self.storage) + dt * &self.flow + dt * dt * self.coupling.tr_mul(&response);
            let held_back = if lagged > 0 { &self.body * before } else { DMatrix::zeros(points, size) };
            let right = scaled(p, &self.storage) - dt * (self.coupling.tr_mul(&dry) - held_back);
            let pressure = system.cholesky().map_or_else(|| right.map(|_| f64::NAN), |factor| factor.solve(&right));
            (per_mass(&f + &self.coupling * &pressure), pressure, None)
        } else {
            let acceleration = per_mass(&f + &self.coupling * &p);
            let held_back = &self.body * (&self.to_mesh * &acceleration);
            (acceleration, p, Some(held_back))
        };
        let moving = &v + dt * &acceleration;
        let change = self.flip * dt * &acceleration + (1.0 - self.flip) * &moving;
        let pressure = match held_back {
            None => pressure,
            Some(held_back) => {
                let outflow = self.coupling.tr_mul(&moving) + &self.flow * &pressure - held_back;
                pressure - dt * scaled(outflow, &self.storage.map(f64::recip))
            }
        };
        let next_v = self.flip * v + &self.transfer * change;
        let next_f = &self.possible * (f - dt * (&self.stiffness * moving));
        let mut matrix = DMatrix::zeros(size, size);
        matrix.rows_mut(0, free).copy_from(&next_v);
        matrix.rows_mut(free, free).copy_from(&next_f);
        matrix.rows_mut(2 * free, points).copy_from(&pressure);
        if lagged > 0 {
            matrix.rows_mut(2 * free + points, lagged).copy_from(&(&self.to_mesh * acceleration));
        }
        let light = self.inverse_mass.mean().sqrt();
        let unit = |i: usize| match i {
            i if i < free => self.inverse_mass[i].sqrt(),
            i if i < 2 * free => self.frequency / self.inverse_mass[i - free].sqrt(),
            i if i < 2 * free + points => 1.0 / self.storage[i - 2 * free].sqrt(),
            _ => self.frequency * light,
        };
        let units = DVector::from_fn(size, |i, _| unit(i));
        DMatrix::from_fn(size, size, |i, j| matrix[(i, j)] * units[j] / units[i])
    }

    /// Growth per step of the state that grows most, at a hundredth above a limit (s): what a run above it has to show.
    pub fn growth_above(&self, limit: f64) -> f64 {
        self.growth(1.01 * limit)
    }

    /// Growth per step of the state that grows most, for a step (s): of the norm of a high power of the matrix.
    pub fn growth(&self, dt: f64) -> f64 {
        let mut power = self.matrix(dt);
        let (mut log, mut half) = (power.norm().ln(), 0.0);
        power.unscale_mut(power.norm());
        for _ in 0..DOUBLINGS {
            power = &power * &power;
            let norm = power.norm();
            power.unscale_mut(norm);
            (half, log) = (log, 2.0 * log + norm.ln());
        }
        let growth = ((log - half) * 2.0 / f64::from(1 << DOUBLINGS)).exp();
        if growth.is_nan() { f64::INFINITY } else { growth }
    }
}

/// A matrix with its rows multiplied.
fn scaled(mut matrix: DMatrix<f64>, by: &DVector<f64>) -> DMatrix<f64> {
    for (i, factor) in by.iter().enumerate() {
        matrix.row_mut(i).scale_mut(*factor);
    }
    matrix
}

/// The projection to the range of a symmetric matrix.
fn range_of(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = matrix.clone().symmetric_eigen();
    let least = 1e-9 * eigen.eigenvalues.amax();
    let keep = eigen.eigenvalues.map(|value| if value > least { 1.0 } else { 0.0 });
    &eigen.eigenvectors * scaled(eigen.eigenvectors.transpose(), &keep)
}

/// A particle with its functions.
struct Point<const D: usize> {
    cell: usize,
    functions: Vec<At<D>>,
    /// Where the volume changes: at the particle, or for B-bar in the middle of its cell.
    volumetric: Vec<At<D>>,
}

impl<const D: usize> Point<D> {
    /// Its functions, and the same where the volume changes.
    fn both(&self) -> impl Iterator<Item = (&At<D>, &At<D>)> {
        self.functions.iter().zip(&self.volumetric)
    }
}

/// What the matrices are gathered from.
struct Builder<B, const D: usize> {
    functions: Products<B, D>,
    grid: Grid<D>,
    points: Vec<Point<D>>,
    /// Volume of a particle, m3, and area of a face, m2.
    volume: f64,
    area: f64,
    /// Row of a component of a function; `None` where it is held.
    rows: Vec<[Option<usize>; D]>,
    free: usize,
    per_cell: usize,
    drained: [bool; 4],
    mobility: f64,
    /// chi rho_w, kg/m3.
    inertia: f64,
}

impl<B: Basis, const D: usize> Builder<B, D> {
    fn new(scene: &Scene, (basis, gradients): (B, Gradients), soil_cells: [usize; D], area: f64) -> Option<Self> {
        let grid = Grid::new(soil_cells, scene.cell);
        let functions = Products::new(basis, grid.cells, grid.inverse_size);
        let per_direction = scene.particles_per_direction();
        let points = even_positions(soil_cells, per_direction).map(|x: [f64; D]| {
            let position = x.map(|x| x as usize);
            let xi = std::array::from_fn(|d| x[d] - position[d] as f64);
            let cell = (0..D).rev().fold(0, |cell, d| cell * soil_cells[d] + position[d]);
            let centre = functions.around(&position, &[0.5; D]);
            let mut own = functions.around(&position, &xi);
            if gradients == Gradients::AtCentre {
                own.iter_mut().zip(&centre).for_each(|(own, centre)| own.gradient = centre.gradient);
            }
            let volumetric = if gradients == Gradients::Split { centre } else { own.clone() };
            Point { cell, functions: own, volumetric }
        });
        let water = scene.water?;
        let mut builder = Self {
            points: points.collect(),
            per_cell: per_direction.pow(D as u32),
            volume: area * scene.cell / per_direction.pow(D as u32) as f64,
            area,
            rows: Vec::new(),
            free: 0,
            drained: scene.stages.last()?.drained,
            mobility: water.mobility(),
            inertia: if scene.darcy_inertia { water.density } else { 0.0 },
            functions,
            grid,
        };
        builder.number(&scene.solid_sides);
        Some(builder)
    }

    /// Numbers the components that are free to move.
    fn number(&mut self, sides: &[SolidSide; 4]) {
        let along = self.functions.along;
        for function in 0..self.functions.count() {
            let position: [usize; D] =
                std::array::from_fn(|d| if d == 0 { function % along[0] } else { function / along[0] });
            let mut held = [false; D];
            for axis in 0..D {
                for upper in [false, true] {
                    let edge = if upper { along[axis] - 1 } else { 0 };
                    match sides[2 * (axis + 2 - D) + usize::from(upper)] {
                        SolidSide::Roller if position[axis] == edge => held[axis] = true,
                        SolidSide::Fixed if position[axis] == edge => held = [true; D],
                        _ => {}
                    }
                }
            }
            self.rows.push(held.map(|held| {
                self.free += usize::from(!held);
                (!held).then(|| self.free - 1)
            }));
        }
    }

    fn build(self, scene: &Scene) -> Option<Assembled> {
        let functions = self.functions.count();
        let (mut mass, mut volume) = (vec![0.0; functions], vec![0.0; functions]);
        let mut shared = DMatrix::<f64>::zeros(functions, functions);
        let mut stiffness = DMatrix::<f64>::zeros(self.free, self.free);
        let (lame, shear) = (scene.elastic.lame(), scene.elastic.shear_modulus());
        // A column of soil has the stiffness without lateral strain.
        let (lame, shear) = if D == 1 { (scene.oedometer_modulus(), 0.0) } else { (lame, shear) };
        for point in &self.points {
            for (At { function: a, value, gradient: ga }, At { gradient: ca, .. }) in point.both() {
                mass[*a] += value;
                volume[*a] += self.volume * value;
                for (At { function: b, value: other, gradient: gb }, At { gradient: cb, .. }) in point.both() {
                    shared[(*a, *b)] += value * other;
                    let dot: f64 = (0..D).map(|d| ga[d] * gb[d]).sum();
                    for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                        let (Some(row), Some(column)) = (self.rows[*a][i], self.rows[*b][j]) else {
                            continue;
                        };
                        let same = if i == j { dot } else { 0.0 };
                        // B-bar adds (c - g)/3 to every normal strain: lambda tr tr + 2 mu eps : eps of that.
                        let normal = 2.0 / 3.0 * (ca[i] * cb[j] - ga[i] * gb[j]);
                        stiffness[(row, column)] +=
                            self.volume * (lame * ca[i] * cb[j] + shear * (ga[j] * gb[i] + same + normal));
                    }
                }
            }
        }
        let mut inverse_mass = DVector::zeros(self.free);
        let mut transfer = DMatrix::zeros(self.free, self.free);
        let particle = self.volume * scene.mixture_density();
        for (function, rows) in self.rows.iter().enumerate() {
            for d in 0..D {
                let Some(row) = rows[d] else { continue };
                inverse_mass[row] = 1.0 / (particle * mass[function]);
                for (other, columns) in self.rows.iter().enumerate() {
                    if let Some(column) = columns[d] {
                        transfer[(row, column)] = shared[(function, other)] / mass[function];
                    }
                }
            }
        }
        let implicit = scene.integrator == Integrator::SemiImplicit;
        // The explicit kernel of the linear functions follows the pressure at every particle; all others in a cell.
        let pointwise = !implicit && D == 2 && scene.shape == ShapeChoice::Linear;
        let coupling = self.coupling(pointwise);
        let in_cell = 1.0 / if pointwise { self.per_cell as f64 } else { 1.0 };
        let cell_volume = self.volume * self.per_cell as f64;
        let storage = DVector::from_element(coupling.ncols(), in_cell * cell_volume / scene.pore_stiffness());
        let to_mesh = self.to_mesh(&mass);
        let (flow, body) = match scene.darcy {
            DarcyChoice::Face => {
                let (flow, body) = self.through_faces();
                // A point has the mean pressure of its cell at the faces, and its share of the outflow.
                let cell_of = |point: usize| if pointwise { self.points[point].cell } else { point };
                let points = coupling.ncols();
                let flow = DMatrix::from_fn(points, points, |i, j| in_cell * in_cell * flow[(cell_of(i), cell_of(j))]);
                let body = DMatrix::from_fn(points, body.ncols(), |i, j| in_cell * body[(cell_of(i), j)]);
                (flow, body)
            }
            DarcyChoice::Nodal => {
                // v* n = k/gamma_w (C p/V - chi rho_w a), and the outflow is C^t of it. What is held is also closed.
                let mut conducted = coupling.clone();
                let mut carried = DMatrix::zeros(coupling.ncols(), to_mesh.nrows());
                for (function, rows) in self.rows.iter().enumerate() {
                    for d in 0..D {
                        let Some(row) = rows[d] else { continue };
                        conducted.row_mut(row).scale_mut(self.mobility / volume[function]);
                        let back = self.mobility * self.inertia * coupling.row(row).transpose();
                        carried.set_column(function * D + d, &back);
                    }
                }
                (coupling.tr_mul(&conducted), carried)
            }
        };
        let frequency = (scene.oedometer_modulus() / scene.mixture_density()).sqrt() / scene.cell;
        let flip = scene.flip;
        Some(Assembled {
            implicit,
            flip,
            inverse_mass,
            transfer,
            possible: range_of(&stiffness),
            stiffness,
            coupling,
            storage,
            flow,
            body,
            to_mesh,
            frequency,
        })
    }

    /// C by cells, or by particles.
    fn coupling(&self, pointwise: bool) -> DMatrix<f64> {
        let columns = if pointwise { self.points.len() } else { self.grid.cell_count() };
        let mut coupling = DMatrix::zeros(self.free, columns);
        for (index, point) in self.points.iter().enumerate() {
            let column = if pointwise { index } else { point.cell };
            for At { function, gradient, .. } in &point.volumetric {
                for d in 0..D {
                    if let Some(row) = self.rows[*function][d] {
                        coupling[(row, column)] += self.volume * gradient[d];
                    }
                }
            }
        }
        coupling
    }

    /// H and B of the two-point flux: `k/(gamma_w L) (p_low - p_high - chi rho_w L a)` through a face, twice the
    /// conductance and half the inertia at a drained one.
    fn through_faces(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let cells = self.grid.cell_count();
        let mut flow = DMatrix::zeros(cells, cells);
        let mut body = DMatrix::zeros(cells, self.grid.node_count() * D);
        let conductance = self.area * self.mobility * self.grid.inverse_size;
        let weight = conductance * self.inertia * self.grid.size;
        let across = self.grid.cells[0] + 1;
        for (cell, position) in self.grid.walk() {
            for axis in 0..D {
                let stride: usize = self.grid.cells[..axis].iter().product();
                for (upper, outwards) in [(false, -1.0), (true, 1.0)] {
                    let at_side = if upper { position[axis] + 1 == self.grid.cells[axis] } else { position[axis] == 0 };
                    if at_side && !self.drained[2 * (axis + 2 - D) + usize::from(upper)] {
                        continue;
                    }
                    if at_side {
                        flow[(cell, cell)] += 2.0 * conductance;
                    } else {
                        flow[(cell, cell)] += conductance;
                        flow[(cell, if upper { cell + stride } else { cell - stride })] -= conductance;
                    }
                    let mut corner = position;
                    corner[axis] += usize::from(upper);
                    let first = if D == 1 { corner[0] } else { corner[0] + across * corner[D - 1] };
                    let nodes = match (D, axis) {
                        (1, _) => [first, first],
                        (_, 0) => [first, first + across],
                        _ => [first, first + 1],
                    };
                    for node in nodes {
                        body[(cell, node * D + axis)] += 0.5 * outwards * weight;
                    }
                }
            }
        }
        (flow, body)
    }

    /// Accelerations at the nodes of the mesh; those of wider functions are means over the mass around a node.
    fn to_mesh(&self, mass: &[f64]) -> DMatrix<f64> {
        let nodes = self.grid.node_count();
        let across = self.grid.cells[0] + 1;
        let mut to_mesh = DMatrix::zeros(nodes * D, self.free);
        for node in 0..nodes {
            let place = std::array::from_fn(|d| match (D, d) {
                (1, _) => node,
                (_, 0) => node % across,
                _ => node / across,
            });
            let share = |function: usize| self.functions.at_node(function, &place) * mass[function];
            let shares: Vec<f64> = (0..self.rows.len()).map(share).collect();
            let whole: f64 = shares.iter().sum();
            for (function, share) in shares.iter().enumerate() {
                for d in 0..D {
                    if let Some(row) = self.rows[function][d] {
                        to_mesh[(node * D + d, row)] = share / whole;
                    }
                }
            }
        }
        to_mesh
    }
}

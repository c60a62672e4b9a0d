//! The linear system of a step: stiffness, coupling, and storage with flow,
//!
//! ```text
//! [  K    -C        ] [du]   [ force        ]
//! [ -C^T  -(S + a H)] [dp] = [ water volume ]        a = gamma dt
//! ```
//!
//! symmetric and quasi-definite, so that it has an L D L^T factorisation in any order; where a material has a tangent that is not
//! symmetric (a flow rule that is not associated) the matrix is stored whole and factorised as L U. At large strain the geometric
//! part of the stiffness and the change of H with the strain are left out: both are of the order of stress/stiffness,
//! and the iteration converges at that rate.

use super::motion::{WaterInertia, forward};
use super::soil::{FacePart, HELD, InsideOut, PorePart, PoreState, Push, Soil, SolidPart, Strained};
use crate::constitutive::Law;
use crate::real::array_of;
use crate::space::{Axis, Group, MOST, Stencil, active, strain_mode};
use crate::sparse::{Factor, Ordering, Signs, Sparse, Unsolved};

/// A matrix with its factors.
#[derive(Debug)]
pub(super) struct System {
    pub matrix: Sparse,
    pub factor: Factor,
    /// Numeric factorisations and solves so far.
    pub factorisations: u64,
    pub solves: u64,
}

/// Unknowns of the functions at a point, and how they enter it.
struct Rows {
    count: usize,
    unknown: [u32; 3 * MOST],
}

/// Where the soil, the water and its flow are integrated.
type Places<'a, const D: usize> = (&'a [SolidPart<D>], &'a [PorePart<D>], &'a [FacePart]);

impl System {
    /// The pattern of a mesh.
    pub fn new<const D: usize>(
        size: usize,
        parts: Places<D>,
        [jumps, viscosity]: [&[(u32, u32, f64)]; 2],
        maps: (&[[u32; D]], &[u32]),
        axes: &[Axis; D],
        symmetric: bool,
    ) -> Result<Self, Unsolved> {
        let (solid, pore, faces) = parts;
        // Unknowns that have an entry with each other: of the points of a cell, one after the other, and where they end.
        let (mut coupled, mut ends): (Vec<u32>, Vec<usize>) = (Vec::new(), vec![0]);
        let mut last = [u32::MAX; 4];
        let mut note = |soil: &Stencil<D>, water: Option<&Stencil<D>>| {
            let key =
                [soil.number[0], soil.number[soil.count - 1], water.map_or(HELD, |w| w.number[0]), soil.count as u32];
            if key == last {
                return;
            }
            last = key;
            let of_soil = soil.number[..soil.count].iter().flat_map(|n| maps.0[*n as usize]);
            let of_water = water.iter().flat_map(|w| w.number[..w.count].iter().map(|n| maps.1[*n as usize]));
            coupled.extend(of_soil.chain(of_water).filter(|unknown| *unknown != HELD));
            ends.push(coupled.len());
        };
        for part in solid {
            note(&part.stencil, None);
        }
        for part in pore {
            note(&part.soil, Some(&part.water));
        }
        let of_cells = ends.windows(2).flat_map(|ends| {
            let some = &coupled[ends[0]..ends[1]];
            some.iter().enumerate().flat_map(move |(i, a)| some[..=i].iter().map(move |b| (*a, *b)))
        });
        let water = |n: u32| if n == HELD { HELD } else { maps.1[n as usize] };
        let of_faces = faces.iter().map(|face| (face.cells[0], face.cells[1]));
        let of_jumps = jumps.iter().filter(|(a, b, _)| a > b).map(|(a, b, _)| (*a, *b));
        let of_water = of_faces.chain(of_jumps).map(|(a, b)| (water(a), water(b)));
        let along = |(a, b, _): &(u32, u32, f64)| {
            let [a, b] = [a, b].map(|n| maps.0[*n as usize]);
            array_of::<_, D, _>(|d| (a[d], b[d]))
        };
        let of_soil = viscosity.iter().filter(|(a, b, _)| a > b).flat_map(along);
        let pairs = of_cells.chain(of_water).chain(of_soil).filter(|(a, b)| *a != HELD && *b != HELD);
        let pairs = pairs.map(|(a, b)| (a as usize, b as usize));
        let (matrix, signs) = if symmetric {
            (Sparse::symmetric(size, pairs), Signs::QuasiDefinite)
        } else {
            (Sparse::general(size, pairs), Signs::Unknown)
        };
        // Numbered along the column, the band is narrow already.
        let places = if D == 1 { Vec::new() } else { places_of(size, maps, axes) };
        let ordering = if D == 1 { Ordering::AsNumbered } else { Ordering::Dissected(&places) };
        let factor = Factor::new(&matrix, signs, ordering)?;
        Ok(Self { matrix, factor, factorisations: 0, solves: 0 })
    }

    /// Solves with the present factors.
    pub fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<(), Unsolved> {
        self.solves += 1;
        self.factor.solve(&self.matrix, b, x)
    }
}

/// Where every unknown stands, in half cells.
fn places_of<const D: usize>(size: usize, maps: (&[[u32; D]], &[u32]), axes: &[Axis; D]) -> Vec<[u32; 2]> {
    let mut places = vec![[0; 2]; size];
    let [functions, cells] = [Axis::functions, Axis::cells].map(|of| of(&axes[0]));
    let mut stand = |unknown: u32, number: usize, across: usize, shift: usize| {
        if unknown != HELD {
            places[unknown as usize] = [number % across, number / across].map(|along| (2 * along + shift) as u32);
        }
    };
    for (function, map) in maps.0.iter().enumerate() {
        map.iter().for_each(|unknown| stand(*unknown, function, functions, 0));
    }
    let (across, shift) = if maps.1.len() == maps.0.len() { (functions, 0) } else { (cells, 1) };
    maps.1.iter().enumerate().for_each(|(number, unknown)| stand(*unknown, number, across, shift));
    places
}

impl<L: Law, const D: usize> Soil<L, D> {
    /// Assembles and factorises the matrix at the unknowns of the last evaluation, for `a` = gamma dt (s).
    pub fn refresh(&mut self, a: f64) -> Result<(), Stuck<D>> {
        self.assemble(a).map_err(Stuck::InsideOut)?;
        self.system.factorisations += 1;
        let System { matrix, factor, .. } = &mut self.system;
        factor.refresh(matrix).map_err(Stuck::Unsolved)
    }

    fn assemble(&mut self, a: f64) -> Result<(), InsideOut<D>> {
        self.system.matrix.values.fill(0.0);
        let symmetric = self.system.matrix.is_symmetric();
        let [length, pressure] = self.scales;
        let mut block = Block::new(symmetric);
        let mut groups = self.groups.iter().peekable();
        for point in 0..self.solid.len() {
            let part = &self.solid[point];
            let group = groups.next_if(|group| point + 1 == group.first + group.count).or(groups.peek().copied());
            let rows = self.rows(&part.stencil, None);
            block.turn_to(&rows, &mut self.system.matrix);
            let Strained { push, strain, .. } = self.strained(part).ok_or(InsideOut { point })?;
            let increment = array_of(|s| strain[s] - part.strain[s]);
            let tangent = self.law.law(part.mark).tangent(&part.stress, &increment, &part.state);
            // Strain modes in the frame before rotation, with gradients of the deformed soil turned back.
            let mut modes = modes_of(&push, part);
            let mut volume = length * length;
            for n in 0..part.stencil.count {
                for d in 0..D {
                    let mode = &mut modes[n * D + d];
                    if let (0, Some(hoop)) = (d, &part.hoop) {
                        mode[2] = hoop[n];
                    }
                    if let (Some(slope), Some((_, inverse))) = (&part.dilates, &push.at_centre) {
                        let centre: f64 = (0..D).map(|j| inverse[j][d] * slope[n][j]).sum();
                        let more = (centre - mode[0] - mode[1] - mode[2]) / 3.0;
                        mode[..3].iter_mut().for_each(|mode| *mode += more);
                    }
                }
            }
            if !self.small {
                volume *= 1.0 / determinant(&push.inverse);
            }
            let count = part.stencil.count * D;
            let active = if part.dilates.is_some() { 0..4 } else { active::<D>() };
            // Work of the stress of this point on strains of its own, or of all points of its cell.
            let mut work_on = |strained: &[[f64; 4]; 2 * MOST], volume: f64| {
                for i in 0..count {
                    let mut stressed = [0.0; 4];
                    for s in active.clone() {
                        stressed[s] = active.clone().map(|t| tangent[(t, s)] * strained[i][t]).sum::<f64>() * volume;
                    }
                    for j in 0..if symmetric { i + 1 } else { count } {
                        block.value[i][j] += active.clone().map(|s| stressed[s] * modes[j][s]).sum::<f64>();
                    }
                }
            };
            match group {
                None => work_on(&modes, part.weight * volume),
                Some(Group { first, count, shares }) => {
                    for i in 0..*count {
                        work_on(&modes_of(&push, &self.solid[first + i]), shares[i * count + point - first] * volume);
                    }
                }
            }
        }
        block.flush(&mut self.system.matrix);
        let inertia = self.motion.as_ref().map(|motion| (motion.inertia, motion.damping));
        // The acceleration of the soil pushes the water, which without one of its own does not push back.
        let one_sided = matches!(inertia, Some((WaterInertia::WithSoil, _)));
        block.lower = !one_sided;
        let by_cells = !self.faces.is_empty();
        for point in 0..self.pore.len() {
            let part = &self.pore[point];
            let rows = self.rows(&part.soil, Some(&part.water));
            block.turn_to(&rows, &mut self.system.matrix);
            let PoreState { change, cofactor, gradient } = self.pore_state(part).ok_or(InsideOut { point })?;
            let first = part.soil.count * D;
            let pores = if self.small { part.porosity } else { change + part.porosity };
            let ratio = if self.small { 1.0 } else { 1.0 + self.denser(part.water.scalar(&self.p)) };
            let [alpha, of_grains] = self.law.soils.kind(part.mark).biot;
            let per_pressure = pores * ratio * self.fluid.compressibility + of_grains;
            let storage = part.weight * per_pressure * pressure * pressure;
            let state = PoreState { change, cofactor, gradient };
            let own = matches!(inertia, Some((WaterInertia::Own, _))).then_some(a);
            let flow = self.conductivity_of(part, &state, own);
            if let Some((water, damping)) = inertia {
                self.inertia_at(part, &state, (water, damping), (&flow, a), &mut block);
            }
            let factor = a * part.weight * pressure * pressure;
            for b in 0..part.water.count {
                let value = part.water.value[b];
                for n in 0..part.soil.count {
                    for i in 0..D {
                        // C: int q J F^-T grad N
                        let spread: f64 = (0..D).map(|j| cofactor[j][i] * part.soil.slope[n][j]).sum();
                        let coupling = part.weight * alpha * value * spread * length * pressure;
                        block.value[first + b][n * D + i] -= coupling;
                        if one_sided {
                            block.value[n * D + i][first + b] -= coupling;
                        }
                    }
                }
                for c in 0..=b {
                    let mut sum = storage * value * part.water.value[c];
                    if !by_cells {
                        for i in 0..D {
                            let flux: f64 = (0..D).map(|j| flow[i][j] * part.water.slope[c][j]).sum();
                            sum += factor * part.water.slope[b][i] * flux;
                        }
                    }
                    block.value[first + b][first + c] -= sum;
                    if one_sided && c < b {
                        block.value[first + c][first + b] -= sum;
                    }
                }
            }
        }
        block.flush(&mut self.system.matrix);
        for number in 0..self.faces.len() {
            let face = self.faces[number];
            let (conductance, _) = self.face_state(&face).ok_or(InsideOut { point: number })?;
            let value = a * conductance * pressure * pressure;
            let matrix = &mut self.system.matrix;
            let unknown = face.cells.map(|c| if c == HELD { HELD } else { self.water_map[c as usize] });
            for u in unknown {
                if u != HELD {
                    matrix.add(u as usize, u as usize, -value);
                }
            }
            if !unknown.contains(&HELD) {
                matrix.add_both(unknown[0] as usize, unknown[1] as usize, value);
            }
        }
        for &(j, k, value) in self.motion.iter().flat_map(|motion| &motion.viscosity) {
            for d in 0..D {
                let (row, column) = (self.soil_map[j as usize][d], self.soil_map[k as usize][d]);
                if row != HELD && column != HELD && (!symmetric || row <= column) {
                    self.system.matrix.add(row as usize, column as usize, value / a * length * length);
                }
            }
        }
        for &(j, k, value) in &self.jumps {
            let (row, column) = (self.water_map[j as usize], self.water_map[k as usize]);
            if row != HELD && column != HELD && (!symmetric || row <= column) {
                self.system.matrix.add(row as usize, column as usize, -value * pressure * pressure);
            }
        }
        Ok(())
    }

    /// What a pore point adds for a = gamma dt (s): mass, and the push of accelerated soil on the water, and back.
    fn inertia_at(
        &self,
        part: &PorePart<D>,
        state: &PoreState<D>,
        (water, damping): (WaterInertia, f64),
        (flow, a): (&[[f64; D]; D], f64),
        block: &mut Block,
    ) {
        let ([length, pressure], first) = (self.scales, part.soil.count * D);
        let pores = if self.small { part.porosity } else { state.change + part.porosity };
        let (density, mass) = (self.fluid.density, self.mass_of(part, pores) * (1.0 + damping * a) / (a * a));
        // F K, and F K F^T: what the water does of an acceleration.
        let pushed: [[f64; D]; D] = array_of(|j| {
            let column = array_of(|i| flow[i][j]);
            forward(state, self.small, &column)
        });
        let along = |i: usize, j: usize| pushed[j][i];
        let mut own = [[0.0; D]; D];
        for i in 0..D {
            own[i][i] = mass;
            if water == WaterInertia::Own {
                let row = forward(state, self.small, &array_of(|j| along(i, j)));
                (0..D).for_each(|j| own[i][j] -= density * density / (a * a * a) * row[j]);
            }
        }
        let scale = part.weight * length * length;
        for n in 0..part.soil.count {
            for m in 0..part.soil.count {
                let both = scale * part.soil.value[n] * part.soil.value[m];
                for (i, row) in own.iter().enumerate() {
                    for (j, value) in row.iter().enumerate() {
                        block.value[n * D + i][m * D + j] += both * value;
                    }
                }
            }
        }
        if water == WaterInertia::None {
            return;
        }
        let scale = part.weight * length * pressure * density / a;
        for b in 0..part.water.count {
            let slope = part.water.slope[b];
            let push: [f64; D] = array_of(|i| (0..D).map(|j| along(i, j) * slope[j]).sum());
            for n in 0..part.soil.count {
                for i in 0..D {
                    block.value[first + b][n * D + i] -= scale * part.soil.value[n] * push[i];
                }
            }
        }
    }

    fn rows(&self, soil: &Stencil<D>, water: Option<&Stencil<D>>) -> Rows {
        let mut rows = Rows { count: 0, unknown: [HELD; 3 * MOST] };
        for n in 0..soil.count {
            for d in 0..D {
                rows.unknown[rows.count] = self.soil_map[soil.number[n] as usize][d];
                rows.count += 1;
            }
        }
        if let Some(water) = water {
            for n in 0..water.count {
                rows.unknown[rows.count] = self.water_map[water.number[n] as usize];
                rows.count += 1;
            }
        }
        rows
    }
}

/// Strain per displacement of the functions of a part, with the stretch of what pushes, in the frame before its rotation.
fn modes_of<const D: usize>(push: &Push<D>, part: &SolidPart<D>) -> [[f64; 4]; 2 * MOST] {
    let mut modes = [[0.0; 4]; 2 * MOST];
    for n in 0..part.stencil.count {
        let slope = part.stencil.slope[n];
        let spatial: [f64; D] = array_of(|i| (0..D).map(|j| push.inverse[j][i] * slope[j]).sum());
        let turned = array_of(|i| (0..D).map(|j| push.rotation[j][i] * spatial[j]).sum());
        for d in 0..D {
            modes[n * D + d] = strain_mode(&turned, &push.rotation[d]);
        }
    }
    modes
}

/// Why a system was not solved.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Stuck<const D: usize> {
    /// An inverted element, det F <= 0.
    InsideOut(InsideOut<D>),
    /// A singular system.
    Unsolved(Unsolved),
    /// Newton's iteration did not converge: residuals one after the other, as shares of the load.
    NotConverged(Vec<f64>),
}

/// The part of the matrix that points with the same functions add to, gathered before it goes to the matrix.
struct Block {
    /// Whether it is symmetric: its lower triangle stands for both.
    lower: bool,
    rows: Rows,
    value: [[f64; 3 * MOST]; 3 * MOST],
}

impl Block {
    fn new(lower: bool) -> Self {
        Self { lower, rows: Rows { count: 0, unknown: [HELD; 3 * MOST] }, value: [[0.0; 3 * MOST]; 3 * MOST] }
    }

    fn turn_to(&mut self, rows: &Rows, matrix: &mut Sparse) {
        if rows.count != self.rows.count || rows.unknown != self.rows.unknown {
            self.flush(matrix);
            self.rows = Rows { count: rows.count, unknown: rows.unknown };
        }
    }

    fn flush(&mut self, matrix: &mut Sparse) {
        for i in 0..self.rows.count {
            for j in 0..if self.lower { i + 1 } else { self.rows.count } {
                let value = std::mem::take(&mut self.value[i][j]);
                let (row, column) = (self.rows.unknown[i], self.rows.unknown[j]);
                if row == HELD || column == HELD || value == 0.0 {
                    continue;
                }
                if !self.lower {
                    matrix.add(row as usize, column as usize, value);
                    continue;
                }
                // Two functions that share an unknown (a rigid plate) meet on its diagonal, once from either side.
                let twice = if row == column && i != j { 2.0 } else { 1.0 };
                matrix.add_both(row as usize, column as usize, twice * value);
            }
        }
        self.rows.count = 0;
    }
}

fn determinant<const D: usize>(m: &[[f64; D]; D]) -> f64 {
    if D == 1 { m[0][0] } else { m[0][0] * m[1][1] - m[0][1] * m[1][0] }
}

//! Functions over a stencil of cells: tensor products of a [`Basis`] along each axis, so many cells at once.
//!
//! All particles of a cell reach the same functions, so a cell gathers in its own sums. What a particle gives and takes is summed up axis
//! by axis.

use pulp::{Scalar, Simd};

use super::bases::{Basis, Line};
use super::{Closing, Contribution, Fields, Functions, Given, MOST_REACH, MOST_REACHED, Moves, Relative};
use crate::dimension::{basis, value};
use crate::real::{Lanes, Real, array};
use crate::step::store::Nodes;
use crate::step::store::nodes::{MIXTURE_MASS, MOMENTUM, SOLID_MASS, force};

/// Products of a basis along each axis.
#[derive(Debug, Clone, Copy)]
pub struct Over<B>(pub B);

/// Motion of the functions that a group of cells reaches.
pub struct StencilMotion<V: Simd, const D: usize> {
    strains: [[Lanes<V>; D]; MOST_REACHED],
    velocity: [[Lanes<V>; D]; MOST_REACHED],
    change: [[Lanes<V>; D]; MOST_REACHED],
    is_mapped: bool,
}

/// What the particles of a cell give to these functions.
pub struct StencilSums<V: Simd, const D: usize> {
    solid_mass: [Lanes<V>; MOST_REACHED],
    water_mass: [Lanes<V>; MOST_REACHED],
    momentum: [[Lanes<V>; D]; MOST_REACHED],
    force: [[Lanes<V>; D]; MOST_REACHED],
    /// `sum_p V G_i`, m2.
    coupling: [[Lanes<V>; D]; MOST_REACHED],
    weighted: Lanes<V>,
    of_water: Lanes<V>,
}

impl<B: Basis> Over<B> {
    #[inline(always)]
    fn lines<V: Simd, const D: usize>(&self, edges: &[B::Edge<V>; D], xi: &[Lanes<V>; D]) -> [Line<Lanes<V>>; D] {
        let mut lines = [self.0.line(&edges[0], xi[0]); D];
        for d in 1..D {
            lines[d] = self.0.line(&edges[d], xi[d]);
        }
        lines
    }

    /// A field at the functions that cells reach.
    #[inline(always)]
    fn reached<V: Simd, const D: usize>(fields: &Fields<V, D>, field: &[Vec<f64>; 2]) -> [[Lanes<V>; D]; MOST_REACHED] {
        let mut nodal = [[Lanes::splat(fields.simd, 0.0); D]; MOST_REACHED];
        for j in 0..if D == 1 { 1 } else { B::REACH } {
            for i in 0..B::REACH {
                for d in 0..D {
                    nodal[j * B::REACH + i][d] = fields.load(&field[d], i + j * fields.frame.stride[D - 1]);
                }
            }
        }
        nodal
    }

    /// Products of the values along each axis, for one point.
    fn shares<const D: usize>(
        &self,
        position: &[usize; D],
        cells: &[usize; D],
        xi: &[f64; D],
        line: impl Fn(&B::Edge<Scalar>, Lanes<Scalar>) -> Line<Lanes<Scalar>>,
    ) -> [f64; MOST_REACHED] {
        let along = |d: usize| {
            let edge = self.0.edge(Lanes::splat(Scalar, position[d] as f64), cells[d]);
            line(&edge, Lanes::splat(Scalar, xi[d])).value
        };
        let (x, y) = (along(0), along(D - 1));
        let mut shares = [0.0; MOST_REACHED];
        for j in 0..if D == 1 { 1 } else { B::REACH } {
            for i in 0..B::REACH {
                shares[j * B::REACH + i] = x[i].lane(0) * if D == 1 { 1.0 } else { y[j].lane(0) };
            }
        }
        shares
    }

    /// Value and gradient of a vector field at particles.
    #[inline(always)]
    fn field<V: Simd, const D: usize>(
        lines: &[Line<Lanes<V>>; D],
        nodal: &[[Lanes<V>; D]; MOST_REACHED],
        inverse_size: f64,
    ) -> ([Lanes<V>; D], [[Lanes<V>; D]; D]) {
        let none = lines[0].value[0].like(0.0);
        let (mut at, mut gradient) = ([none; D], [[none; D]; D]);
        let x = &lines[0];
        for j in 0..if D == 1 { 1 } else { B::REACH } {
            let (mut row, mut slope) = ([none; D], [none; D]);
            for i in 0..B::REACH {
                for d in 0..D {
                    row[d] += nodal[j * B::REACH + i][d] * x.value[i];
                    slope[d] += nodal[j * B::REACH + i][d] * x.slope[i];
                }
            }
            if D == 1 {
                at = row;
                gradient[0] = slope;
            } else {
                let y = &lines[D - 1];
                for d in 0..D {
                    at[d] += row[d] * y.value[j];
                    gradient[d][0] += slope[d] * y.value[j];
                    gradient[d][D - 1] += row[d] * y.slope[j];
                }
            }
        }
        for i in 0..D {
            for j in 0..D {
                gradient[i][j] = gradient[i][j] * inverse_size;
            }
        }
        (at, gradient)
    }

    /// Value of a vector field at particles.
    #[inline(always)]
    fn value<V: Simd, const D: usize>(
        lines: &[Line<Lanes<V>>; D],
        nodal: &[[Lanes<V>; D]; MOST_REACHED],
    ) -> [Lanes<V>; D] {
        let none = lines[0].value[0].like(0.0);
        let mut at = [none; D];
        for j in 0..if D == 1 { 1 } else { B::REACH } {
            let mut row = [none; D];
            for i in 0..B::REACH {
                for d in 0..D {
                    row[d] += nodal[j * B::REACH + i][d] * lines[0].value[i];
                }
            }
            for d in 0..D {
                at[d] = if D == 1 { row[d] } else { at[d] + row[d] * lines[D - 1].value[j] };
            }
        }
        at
    }
}

impl<B: Basis, const D: usize> Functions<D> for Over<B> {
    const REACH: usize = B::REACH;
    const BEFORE: usize = B::BEFORE;
    const FUSED: bool = false;
    type Edges<V: Simd> = [B::Edge<V>; D];
    type Motion<V: Simd> = StencilMotion<V, D>;
    type Sums<V: Simd> = StencilSums<V, D>;

    #[inline(always)]
    fn edges<V: Simd>(&self, position: &[Lanes<V>; D], cells: &[usize; D]) -> [B::Edge<V>; D] {
        let mut edges = [self.0.edge(position[0], cells[0]); D];
        for d in 1..D {
            edges[d] = self.0.edge(position[d], cells[d]);
        }
        edges
    }

    #[inline(always)]
    fn motion<V: Simd>(&self, fields: &Fields<V, D>, _: &[Lanes<V>; D]) -> StencilMotion<V, D> {
        let velocity = Self::reached(fields, fields.velocity);
        let strains = match fields.mapped {
            Some(mapped) => Self::reached(fields, mapped),
            None => velocity,
        };
        let change = Self::reached(fields, fields.change);
        StencilMotion { strains, velocity, change, is_mapped: fields.mapped.is_some() }
    }

    #[inline(always)]
    fn middle<V: Simd>(&self, motion: &StencilMotion<V, D>, _: f64) -> Lanes<V> {
        motion.velocity[0][0].like(0.0)
    }

    #[inline(always)]
    fn moves<V: Simd>(
        &self,
        motion: &StencilMotion<V, D>,
        edges: &[B::Edge<V>; D],
        xi: &[Lanes<V>; D],
        inverse_size: f64,
    ) -> Moves<V, D> {
        let lines = self.lines(edges, xi);
        let (velocity, mut gradient) = Self::field(&lines, &motion.velocity, inverse_size);
        if motion.is_mapped {
            (_, gradient) = Self::field(&lines, &motion.strains, inverse_size);
        }
        Moves { gradient, velocity, change: Self::value(&lines, &motion.change) }
    }

    #[inline(always)]
    fn gradient_at<V: Simd>(
        &self,
        motion: &StencilMotion<V, D>,
        edges: &[B::Edge<V>; D],
        xi: &[Lanes<V>; D],
        inverse_size: f64,
    ) -> [[Lanes<V>; D]; D] {
        Self::field(&self.lines(edges, xi), &motion.velocity, inverse_size).1
    }

    #[inline(always)]
    fn with_water<V: Simd>(
        &self,
        motion: &StencilMotion<V, D>,
        edges: &[B::Edge<V>; D],
        xi: &[Lanes<V>; D],
        relative: &Relative<V, D>,
        _: f64,
    ) -> ([Lanes<V>; D], Lanes<V>) {
        let of_soil = Self::value(&self.lines(edges, xi), &motion.strains);
        let of_flow = value::<D, D, _>(relative, &basis(xi));
        (array!([xi[0]; D], d => of_soil[d] + of_flow[d]), xi[0].like(0.0))
    }

    fn values(&self, position: &[usize; D], cells: &[usize; D], xi: &[f64; D]) -> [f64; MOST_REACHED] {
        self.shares(position, cells, xi, |edge, xi| self.0.line(edge, xi))
    }

    fn at_surface(&self, position: &[usize; D], cells: &[usize; D], xi: &[f64; D], amount: f64) -> [f64; MOST_REACHED] {
        self.shares(position, cells, xi, |edge, xi| self.0.at_surface(edge, xi)).map(|share| amount * share)
    }

    /// The mean over the mass around a node.
    ///
    /// The value of a B-spline at a free surface is that of its last coefficient, which has a quarter to a third of a
    /// cell's mass. A pore pressure in the last cell would accelerate it so much that `rho_w a_s` turned the flow round.
    /// A coefficient has the share of linear functions at the place where it stands.
    fn accelerations_of_mesh(&self, nodes: &Nodes<D>, to: &mut [Vec<f64>; 2]) {
        let frame = &nodes.frame;
        // The share that a node has of each function from its own number on, none of those beyond the mesh.
        let around = |d: usize, node: usize| {
            let mut shares = [0.0; MOST_REACH];
            for (k, share) in shares.iter_mut().enumerate().take((frame.cells[d] + B::EXTRA - node).min(B::REACH)) {
                *share = (1.0 - (self.0.stands_at(node + k, frame.cells[d]) - node as f64).abs()).max(0.0);
            }
            shares
        };
        let rows = if D == 1 { 0 } else { frame.cells[D - 1] };
        // Away from the ends of a row all nodes have the same shares.
        let middle = array!([[0.0; MOST_REACH]; D], d => around(d, frame.cells[d] / 2));
        let at = |d: usize, node: usize| {
            let is_inner = node >= B::REACH && node + B::REACH <= frame.cells[d];
            if is_inner { middle[d] } else { around(d, node) }
        };
        for row in 0..=rows {
            let of_rows = if D == 1 { [1.0, 0.0, 0.0, 0.0] } else { at(D - 1, row) };
            for column in 0..=frame.cells[0] {
                let of_columns = at(0, column);
                let (mut mass, mut sum) = (0.0, [0.0; D]);
                for j in (0..MOST_REACH).filter(|j| of_rows[*j] > 0.0) {
                    for i in (0..MOST_REACH).filter(|i| of_columns[*i] > 0.0) {
                        let mut position = [column + i; D];
                        if D == 2 {
                            position[D - 1] = row + j;
                        }
                        let function = frame.function(&position);
                        let share = of_columns[i] * of_rows[j] * nodes.mixture_mass(function);
                        mass += share;
                        for d in 0..D {
                            sum[d] += share * nodes.motion.acceleration[d][function];
                        }
                    }
                }
                let node = frame.number(&std::array::from_fn(|d| if d == 0 { column } else { row }));
                for d in 0..D {
                    to[d][node] = if mass > 0.0 { sum[d] / mass } else { 0.0 };
                }
            }
        }
    }

    #[inline(always)]
    fn nothing<V: Simd>(&self, simd: V) -> StencilSums<V, D> {
        let none = Lanes::splat(simd, 0.0);
        StencilSums {
            solid_mass: [none; MOST_REACHED],
            water_mass: [none; MOST_REACHED],
            momentum: [[none; D]; MOST_REACHED],
            force: [[none; D]; MOST_REACHED],
            coupling: [[none; D]; MOST_REACHED],
            weighted: none,
            of_water: none,
        }
    }

    #[inline(always)]
    fn add<V: Simd>(
        &self,
        sums: &mut StencilSums<V, D>,
        edges: &[B::Edge<V>; D],
        point: &Contribution<V, D>,
        (coupled, inverse_size): (bool, f64),
    ) {
        let Contribution { xi, mass, volume, v, stress, affine } = point;
        let lines = self.lines(edges, xi);
        let acting = *volume * inverse_size;
        let (xx, yy, xy) = (stress[0] * acting, stress[1] * acting, stress[3] * acting);
        let x = &lines[0];
        for j in 0..if D == 1 { 1 } else { B::REACH } {
            let (value, slope) =
                if D == 1 { (mass.like(1.0), mass.like(0.0)) } else { (lines[D - 1].value[j], lines[D - 1].slope[j]) };
            let mass = *mass * value;
            let momentum = array!([mass; D], d => mass * v[d]);
            // div(sigma') - grad p, weak: f_i = - sum_p V sigma G_i
            let (mut along, mut across) = ([yy * value; D], [yy * slope; D]);
            if D == 2 {
                (along[0], along[D - 1]) = (xx * value, xy * value);
                across[0] = xy * slope;
            }
            for i in 0..B::REACH {
                let a = j * B::REACH + i;
                sums.solid_mass[a] += mass * x.value[i];
                for d in 0..D {
                    sums.momentum[a][d] += momentum[d] * x.value[i];
                    sums.force[a][d] -= along[d] * x.slope[i] + across[d] * x.value[i];
                }
                if let Some(affine) = affine {
                    let away = array!([mass; D], d => {
                        let stands = self.0.stands(&edges[d], if d == 0 { i } else { j });
                        (stands - xi[d]) * (1.0 / inverse_size)
                    });
                    let more = affine.seen_from(&[mass.like(0.0); D], &away);
                    for d in 0..D {
                        sums.momentum[a][d] += mass * x.value[i] * more[d];
                    }
                }
                if coupled {
                    let volume = *volume * inverse_size;
                    sums.coupling[a][0] += volume * (x.slope[i] * value);
                    if D == 2 {
                        sums.coupling[a][D - 1] += volume * (x.value[i] * slope);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn add_water<V: Simd>(
        &self,
        sums: &mut StencilSums<V, D>,
        edges: &[B::Edge<V>; D],
        xi: &[Lanes<V>; D],
        [mass, volume, pressure]: [Lanes<V>; 3],
    ) {
        let lines = self.lines(edges, xi);
        for j in 0..if D == 1 { 1 } else { B::REACH } {
            let mass = if D == 1 { mass } else { mass * lines[D - 1].value[j] };
            for i in 0..B::REACH {
                sums.water_mass[j * B::REACH + i] += mass * lines[0].value[i];
            }
        }
        sums.weighted += volume * pressure;
        sums.of_water += volume;
    }

    #[inline(always)]
    fn water_of<V: Simd>(&self, sums: &StencilSums<V, D>) -> [Lanes<V>; 2] {
        [sums.weighted, sums.of_water]
    }

    #[inline(always)]
    fn finish<V: Simd>(&self, sums: &mut StencilSums<V, D>, cell: &Closing<V, D>, _: f64, given: &mut Given<V>) {
        for a in 0..B::REACH.pow(D as u32) {
            let mut water = sums.water_mass[a];
            if let Some(ratio) = cell.water_ratio {
                water = (ratio * sums.solid_mass[a]).or(cell.moving_with, water);
            }
            given[SOLID_MASS][a] = sums.solid_mass[a];
            given[MIXTURE_MASS][a] = sums.solid_mass[a] + water;
            for d in 0..D {
                given[MOMENTUM + d][a] = sums.momentum[a][d];
                given[force(D) + d][a] = sums.force[a][d] * cell.share;
            }
        }
    }

    #[inline(always)]
    fn coupling<V: Simd>(
        &self,
        sums: &StencilSums<V, D>,
        cell: &Closing<V, D>,
        _: f64,
    ) -> [[Lanes<V>; D]; MOST_REACHED] {
        let mut coupling = sums.coupling;
        for of_function in &mut coupling {
            for d in 0..D {
                of_function[d] = of_function[d] * cell.share;
            }
        }
        coupling
    }
}

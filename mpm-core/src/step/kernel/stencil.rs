//! Functions over a stencil of cells: tensor products of a [`Basis`] along each axis, so many cells at once.
//!
//! A cell gathers in its own sums, for all functions that any of its particles reaches. Where the particles in all lanes reach the
//! same of these, the others are left out: they would add zeros. What a particle gives and takes is summed up axis by axis. Functions
//! beyond the sides of the mesh, where a [`Basis`] has such, are there until a cell has gathered, and then folded.

use std::ops::Range;

use pulp::{Scalar, Simd};

use super::bases::{Basis, Line};
use super::{Closing, Contribution, Fields, Functions, Given, MOST_REACH, MOST_REACHED, Moves, Nodal, Relative};
use crate::dimension::{basis, value};
use crate::real::{Real, SimdReal, array, array_of};
use crate::step::store::Nodes;
use crate::step::store::nodes::{MIXTURE_MASS, MOMENTUM, SOLID_MASS, SUMS, force, sums as of_node};

/// Products of a basis along each axis.
#[derive(Debug, Clone, Copy)]
pub struct Over<B>(pub B);

/// Motion of the functions that a group of cells reaches.
pub struct StencilMotion<V: Simd, const D: usize> {
    velocity: [Nodal<V>; D],
    change: [Nodal<V>; D],
    /// Velocities that strain the soil, if they are others.
    mapped: [Nodal<V>; D],
    is_mapped: bool,
}

/// What the particles of a cell give to these functions.
pub struct StencilSums<V: Simd, const D: usize> {
    /// As nodes have them, but for the mass of the water alone in the place of that of the mixture.
    nodal: Given<V>,
    /// `sum_p V G_i`, m2.
    coupling: [Nodal<V>; D],
    weighted: SimdReal<V>,
    of_water: SimdReal<V>,
}

/// The basis along each axis at particles.
struct Lines<V: Simd, const D: usize> {
    along: [Line<SimdReal<V>>; D],
    /// Where the functions begin that they reach, if that is the same in all lanes.
    first: Option<[usize; D]>,
}

impl<B: Basis> Over<B> {
    #[inline(always)]
    fn lines<V: Simd, const D: usize>(&self, edges: &[B::Edge<V>; D], xi: &[SimdReal<V>; D]) -> Lines<V, D> {
        let (mut first, mut agree) = ([0; D], true);
        for d in 0..D {
            match self.0.first(xi[d]) {
                Some(own) => first[d] = own,
                None => agree = false,
            }
        }
        let mut along = [self.0.line(&edges[0], xi[0], if agree { Some(first[0]) } else { None }); D];
        for d in 1..D {
            along[d] = self.0.line(&edges[d], xi[d], if agree { Some(first[d]) } else { None });
        }
        Lines { along, first: if agree { Some(first) } else { None } }
    }

    /// All functions that cells reach, those beyond the mesh folded.
    #[inline(always)]
    fn folded<V: Simd, const D: usize>(&self, edges: &[B::Edge<V>; D], xi: &[SimdReal<V>; D]) -> Lines<V, D> {
        let mut along = [self.0.line(&edges[0], xi[0], None); D];
        for d in 0..D {
            along[d] = self.0.line(&edges[d], xi[d], None);
            self.0.beyond(&edges[d], &mut along[d].value, false);
            self.0.beyond(&edges[d], &mut along[d].slope, false);
        }
        Lines { along, first: None }
    }

    /// The functions from the first that particles reach to the last, if they reach so many along each axis.
    #[inline(always)]
    fn part<const D: usize>(count: usize, first: [usize; D]) -> Range<usize> {
        let from = first[0] + if D == 1 { 0 } else { first[D - 1] * B::REACH };
        from..from + count + if D == 1 { 0 } else { (count - 1) * B::REACH }
    }

    /// Extends a field beyond the sides of the mesh, or folds what has been gathered there.
    #[inline(always)]
    fn each_line<V: Simd, const D: usize>(&self, of: &mut Nodal<V>, edges: &[B::Edge<V>; D], extends: bool) {
        if self.0.reaches_out(&edges[0]) {
            for j in 0..if D == 1 { 1 } else { B::REACH } {
                let mut line = array!([of[0]; MOST_REACH], i => of[j * B::REACH + i]);
                self.0.beyond(&edges[0], &mut line, extends);
                of[j * B::REACH..][..MOST_REACH].copy_from_slice(&line);
            }
        }
        if D == 2 && self.0.reaches_out(&edges[D - 1]) {
            for i in 0..B::REACH {
                let mut line = array!([of[0]; MOST_REACH], j => of[j * B::REACH + i]);
                self.0.beyond(&edges[D - 1], &mut line, extends);
                for j in 0..MOST_REACH {
                    of[j * B::REACH + i] = line[j];
                }
            }
        }
    }

    /// Finds a field at the functions that cells reach.
    #[inline(always)]
    fn reached<V: Simd, const D: usize>(
        &self,
        nodal: &mut [Nodal<V>; D],
        fields: &Fields<V, D>,
        edges: &[B::Edge<V>; D],
        field: &[Vec<f64>; 2],
    ) {
        for j in 0..if D == 1 { 1 } else { B::REACH } {
            for i in 0..B::REACH {
                for d in 0..D {
                    nodal[d][j * B::REACH + i] = fields.load(&field[d], i + j * fields.frame.stride[D - 1]);
                }
            }
        }
        for d in 0..D {
            self.each_line(&mut nodal[d], edges, true);
        }
    }

    /// Products of the values along each axis, for one point.
    fn shares<const D: usize>(
        &self,
        position: &[usize; D],
        cells: &[usize; D],
        xi: &[f64; D],
        line: impl Fn(&B::Edge<Scalar>, SimdReal<Scalar>) -> Line<SimdReal<Scalar>>,
    ) -> [f64; MOST_REACHED] {
        let along = |d: usize| {
            let edge = self.0.edge(SimdReal::splat(Scalar, position[d] as f64), cells[d]);
            let mut value = line(&edge, SimdReal::splat(Scalar, xi[d])).value;
            self.0.beyond(&edge, &mut value, false);
            value
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
        lines: &Lines<V, D>,
        nodal: &[Nodal<V>; D],
        inverse_size: f64,
    ) -> ([SimdReal<V>; D], [[SimdReal<V>; D]; D]) {
        match lines.first {
            Some(first) => Self::field_of(B::SPAN, first, lines, nodal, inverse_size),
            None => Self::field_of(B::REACH, [0; D], lines, nodal, inverse_size),
        }
    }

    /// The same of so many functions along an axis, from a first one on. The number is a constant where this is inlined, so that
    /// loops over it are unrolled.
    #[inline(always)]
    fn field_of<V: Simd, const D: usize>(
        count: usize,
        first: [usize; D],
        lines: &Lines<V, D>,
        nodal: &[Nodal<V>; D],
        inverse_size: f64,
    ) -> ([SimdReal<V>; D], [[SimdReal<V>; D]; D]) {
        let (x, y) = (&lines.along[0], &lines.along[D - 1]);
        let none = x.value[0].like(0.0);
        let (mut at, mut gradient) = ([none; D], [[none; D]; D]);
        let nodal = array!([&nodal[0][..]; D], d => &nodal[d][Self::part(count, first)]);
        for j in 0..if D == 1 { 1 } else { count } {
            let (mut row, mut slope) = ([none; D], [none; D]);
            for i in 0..count {
                for d in 0..D {
                    row[d] += nodal[d][j * B::REACH + i] * x.value[i];
                    slope[d] += nodal[d][j * B::REACH + i] * x.slope[i];
                }
            }
            if D == 1 {
                at = row;
                gradient[0] = slope;
            } else {
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
    fn value<V: Simd, const D: usize>(lines: &Lines<V, D>, nodal: &[Nodal<V>; D]) -> [SimdReal<V>; D] {
        match lines.first {
            Some(first) => Self::value_of(B::SPAN, first, lines, nodal),
            None => Self::value_of(B::REACH, [0; D], lines, nodal),
        }
    }

    /// The same, as [`Over::field_of`].
    #[inline(always)]
    fn value_of<V: Simd, const D: usize>(
        count: usize,
        first: [usize; D],
        lines: &Lines<V, D>,
        nodal: &[Nodal<V>; D],
    ) -> [SimdReal<V>; D] {
        let (x, y) = (&lines.along[0], &lines.along[D - 1]);
        let none = x.value[0].like(0.0);
        let mut at = [none; D];
        let nodal = array!([&nodal[0][..]; D], d => &nodal[d][Self::part(count, first)]);
        for j in 0..if D == 1 { 1 } else { count } {
            let mut row = [none; D];
            for i in 0..count {
                for d in 0..D {
                    row[d] += nodal[d][j * B::REACH + i] * x.value[i];
                }
            }
            for d in 0..D {
                at[d] = if D == 1 { row[d] } else { at[d] + row[d] * y.value[j] };
            }
        }
        at
    }

    /// Adds particles to the sums of so many functions along an axis, as [`Over::field_of`].
    #[inline(always)]
    fn add_to<V: Simd, const D: usize>(
        &self,
        (count, first): (usize, [usize; D]),
        lines: &Lines<V, D>,
        sums: &mut StencilSums<V, D>,
        edges: &[B::Edge<V>; D],
        point: &Contribution<V, D>,
        (coupled, inverse_size): (bool, f64),
    ) {
        let Contribution { xi, mass, volume, v, stress, affine, from_axis } = point;
        let acting = *volume * inverse_size;
        let (xx, yy, xy) = (stress[0] * acting, stress[1] * acting, stress[3] * acting);
        let (x, y) = (&lines.along[0], &lines.along[D - 1]);
        // Volume over the radius, about an axis.
        let round = super::radius(*from_axis, xi).map(|r| acting / r);
        for j in 0..if D == 1 { 1 } else { count } {
            let part = Self::part(count, first);
            let (value, slope) = if D == 1 { (mass.like(1.0), mass.like(0.0)) } else { (y.value[j], y.slope[j]) };
            let mass = *mass * value;
            let momentum = array!([mass; D], d => mass * v[d]);
            // div(sigma') - grad p, weak: f_i = - sum_p V sigma G_i
            let (mut along, mut across) = ([yy * value; D], [yy * slope; D]);
            if D == 2 {
                (along[0], along[D - 1]) = (xx * value, xy * value);
                across[0] = xy * slope;
                if let Some(round) = round {
                    across[0] += round * stress[2] * value;
                }
            }
            for i in 0..count {
                let a = j * B::REACH + i;
                sums.nodal[SOLID_MASS][part.clone()][a] += mass * x.value[i];
                for d in 0..D {
                    sums.nodal[MOMENTUM + d][part.clone()][a] += momentum[d] * x.value[i];
                    sums.nodal[force(D) + d][part.clone()][a] -= along[d] * x.slope[i] + across[d] * x.value[i];
                }
                if let Some(affine) = affine {
                    let away = array!([mass; D], d => {
                        let stands = self.0.stands(&edges[d], first[d] + if d == 0 { i } else { j });
                        (stands - xi[d]) * (1.0 / inverse_size)
                    });
                    let more = affine.seen_from(&[mass.like(0.0); D], &away);
                    for d in 0..D {
                        sums.nodal[MOMENTUM + d][part.clone()][a] += mass * x.value[i] * more[d];
                    }
                }
                if coupled {
                    let volume = *volume * inverse_size;
                    sums.coupling[0][part.clone()][a] += volume * (x.slope[i] * value);
                    if let Some(round) = round {
                        sums.coupling[0][part.clone()][a] += round * (x.value[i] * value);
                    }
                    if D == 2 {
                        sums.coupling[D - 1][part.clone()][a] += volume * (x.value[i] * slope);
                    }
                }
            }
        }
    }

    /// Adds the mass of water particles, as [`Over::add_to`].
    #[inline(always)]
    fn add_water_to<V: Simd, const D: usize>(
        (count, first): (usize, [usize; D]),
        lines: &Lines<V, D>,
        sums: &mut StencilSums<V, D>,
        mass: SimdReal<V>,
    ) {
        let of = &mut sums.nodal[MIXTURE_MASS][Self::part(count, first)];
        for j in 0..if D == 1 { 1 } else { count } {
            let mass = if D == 1 { mass } else { mass * lines.along[D - 1].value[j] };
            for i in 0..count {
                of[j * B::REACH + i] += mass * lines.along[0].value[i];
            }
        }
    }
}

impl<B: Basis, const D: usize> Functions<D> for Over<B> {
    const REACH: usize = B::REACH;
    const BEFORE: usize = B::BEFORE;
    const EXTRA: usize = B::EXTRA;
    const FUSED: bool = false;
    type Edges<V: Simd> = [B::Edge<V>; D];
    type Motion<V: Simd> = StencilMotion<V, D>;
    type Water<V: Simd> = Relative<V, D>;
    type Sums<V: Simd> = StencilSums<V, D>;

    #[inline(always)]
    fn edges<V: Simd>(&self, position: &[SimdReal<V>; D], cells: &[usize; D]) -> [B::Edge<V>; D] {
        let mut edges = [self.0.edge(position[0], cells[0]); D];
        for d in 1..D {
            edges[d] = self.0.edge(position[d], cells[d]);
        }
        edges
    }

    #[inline(always)]
    fn at_rest<V: Simd>(&self, simd: V) -> StencilMotion<V, D> {
        let none = [Nodal::splat(simd, 0.0); D];
        StencilMotion { velocity: none, change: none, mapped: none, is_mapped: false }
    }

    #[inline(always)]
    fn find_motion<V: Simd>(
        &self,
        motion: &mut StencilMotion<V, D>,
        fields: &Fields<V, D>,
        edges: &[B::Edge<V>; D],
        _: &[SimdReal<V>; D],
    ) {
        self.reached(&mut motion.velocity, fields, edges, fields.velocity);
        self.reached(&mut motion.change, fields, edges, fields.change);
        motion.is_mapped = fields.mapped.is_some();
        if let Some(mapped) = fields.mapped {
            self.reached(&mut motion.mapped, fields, edges, mapped);
        }
    }

    #[inline(always)]
    fn middle<V: Simd>(&self, motion: &StencilMotion<V, D>, _: super::FromAxis<V>, _: f64) -> SimdReal<V> {
        motion.velocity[0][0].like(0.0)
    }

    #[inline(always)]
    fn hoop<V: Simd>(
        &self,
        motion: &StencilMotion<V, D>,
        edges: &[B::Edge<V>; D],
        xi: &[SimdReal<V>; D],
        from_axis: SimdReal<V>,
        inverse_size: f64,
    ) -> SimdReal<V> {
        let strains = if motion.is_mapped { &motion.mapped } else { &motion.velocity };
        Self::value(&self.lines(edges, xi), strains)[0] / (from_axis + xi[0]) * inverse_size
    }

    #[inline(always)]
    fn moves<V: Simd>(
        &self,
        motion: &StencilMotion<V, D>,
        edges: &[B::Edge<V>; D],
        xi: &[SimdReal<V>; D],
        inverse_size: f64,
    ) -> Moves<V, D> {
        let lines = self.lines(edges, xi);
        let (velocity, mut gradient) = Self::field(&lines, &motion.velocity, inverse_size);
        if motion.is_mapped {
            (_, gradient) = Self::field(&lines, &motion.mapped, inverse_size);
        }
        Moves { gradient, velocity, change: Self::value(&lines, &motion.change) }
    }

    #[inline(always)]
    fn gradient_at<V: Simd>(
        &self,
        motion: &StencilMotion<V, D>,
        edges: &[B::Edge<V>; D],
        xi: &[SimdReal<V>; D],
        inverse_size: f64,
    ) -> [[SimdReal<V>; D]; D] {
        Self::field(&self.lines(edges, xi), &motion.velocity, inverse_size).1
    }

    #[inline(always)]
    fn find_water<V: Simd>(&self, _: &StencilMotion<V, D>, relative: &Relative<V, D>) -> Relative<V, D> {
        *relative
    }

    #[inline(always)]
    fn with_water<V: Simd>(
        &self,
        motion: &StencilMotion<V, D>,
        relative: &Relative<V, D>,
        edges: &[B::Edge<V>; D],
        xi: &[SimdReal<V>; D],
        _: f64,
    ) -> ([SimdReal<V>; D], SimdReal<V>) {
        let soil = if motion.is_mapped { &motion.mapped } else { &motion.velocity };
        let of_soil = Self::value(&self.lines(edges, xi), soil);
        let of_flow = value::<D, D, _>(relative, &basis(xi));
        (array!([xi[0]; D], d => of_soil[d] + of_flow[d]), xi[0].like(0.0))
    }

    fn values(&self, position: &[usize; D], cells: &[usize; D], xi: &[f64; D]) -> [f64; MOST_REACHED] {
        self.shares(position, cells, xi, |edge, xi| self.0.line(edge, xi, None))
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
        if B::EXTRA == 1 {
            // Functions stand at the nodes.
            let first = frame.function(&[0; D]) - frame.number(&[0; D]);
            for (to, from) in to.iter_mut().zip(&nodes.motion.acceleration).take(D) {
                to[..from.len() - first].copy_from_slice(&from[first..]);
            }
            return;
        }
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
                let node = frame.number(&array_of(|d| if d == 0 { column } else { row }));
                for d in 0..D {
                    to[d][node] = if mass > 0.0 { sum[d] / mass } else { 0.0 };
                }
            }
        }
    }

    #[inline(always)]
    fn nothing<V: Simd>(&self, simd: V) -> StencilSums<V, D> {
        let (nodal, none) = (Nodal::splat(simd, 0.0), SimdReal::splat(simd, 0.0));
        StencilSums { nodal: [nodal; SUMS], coupling: [nodal; D], weighted: none, of_water: none }
    }

    #[inline(always)]
    fn clear<V: Simd>(&self, simd: V, sums: &mut StencilSums<V, D>, (coupled, _): (bool, bool)) {
        let none = SimdReal::splat(simd, 0.0);
        for a in 0..B::REACH.pow(D as u32) {
            for q in 0..of_node(D) {
                sums.nodal[q][a] = none;
            }
            for d in 0..if coupled { D } else { 0 } {
                sums.coupling[d][a] = none;
            }
        }
        (sums.weighted, sums.of_water) = (none, none);
    }

    #[inline(always)]
    fn add<V: Simd>(
        &self,
        sums: &mut StencilSums<V, D>,
        edges: &[B::Edge<V>; D],
        point: &Contribution<V, D>,
        (coupled, _, inverse_size): (bool, bool, f64),
    ) {
        // A velocity that differs from node to node cannot be folded once it is gathered.
        let lines = if point.affine.is_some() { self.folded(edges, &point.xi) } else { self.lines(edges, &point.xi) };
        let how = (coupled, inverse_size);
        match lines.first {
            Some(first) => self.add_to((B::SPAN, first), &lines, sums, edges, point, how),
            None => self.add_to((B::REACH, [0; D]), &lines, sums, edges, point, how),
        }
    }

    #[inline(always)]
    fn add_water<V: Simd>(
        &self,
        sums: &mut StencilSums<V, D>,
        edges: &[B::Edge<V>; D],
        xi: &[SimdReal<V>; D],
        [mass, volume, pressure]: [SimdReal<V>; 3],
        _: super::FromAxis<V>,
    ) {
        let lines = self.lines(edges, xi);
        match lines.first {
            Some(first) => Self::add_water_to((B::SPAN, first), &lines, sums, mass),
            None => Self::add_water_to((B::REACH, [0; D]), &lines, sums, mass),
        }
        sums.weighted += volume * pressure;
        sums.of_water += volume;
    }

    #[inline(always)]
    fn water_of<V: Simd>(&self, sums: &StencilSums<V, D>) -> [SimdReal<V>; 2] {
        [sums.weighted, sums.of_water]
    }

    #[inline(always)]
    fn finish<'a, V: Simd>(
        &self,
        sums: &'a mut StencilSums<V, D>,
        edges: &[B::Edge<V>; D],
        cell: &Closing<V, D>,
        _: f64,
        _: &'a mut Given<V>,
    ) -> &'a Given<V> {
        for a in 0..B::REACH.pow(D as u32) {
            let (solid, mut water) = (sums.nodal[SOLID_MASS][a], sums.nodal[MIXTURE_MASS][a]);
            if let Some(ratio) = cell.water_ratio {
                water = (ratio * solid).or(cell.moving_with, water);
            }
            sums.nodal[MIXTURE_MASS][a] = solid + water;
            for d in 0..D {
                sums.nodal[force(D) + d][a] = sums.nodal[force(D) + d][a] * cell.share;
            }
        }
        for q in 0..of_node(D) {
            self.each_line(&mut sums.nodal[q], edges, false);
        }
        &sums.nodal
    }

    #[inline(always)]
    fn coupling<V: Simd>(
        &self,
        sums: &StencilSums<V, D>,
        edges: &[B::Edge<V>; D],
        cell: &Closing<V, D>,
        _: f64,
    ) -> [[SimdReal<V>; D]; MOST_REACHED] {
        let none = sums.weighted.like(0.0);
        let mut coupling = [[none; D]; MOST_REACHED];
        for d in 0..D {
            let mut along = sums.coupling[d];
            self.each_line(&mut along, edges, false);
            for a in 0..B::REACH.pow(D as u32) {
                coupling[a][d] = along[a] * cell.share;
            }
        }
        coupling
    }
}

//! One pass over the particles of a strip: Darcy flow and mesh to particles of this step, particles to mesh of the next.
//!
//! Between the two passes over a particle in the paper's Figure 1 nothing happens to it, so they are one: each number is
//! read and written once per step. The formulas are those of `step/explicit.rs`, in the same order, so both give a particle
//! the same bits wherever its nodes belong to one strip.

use pulp::{Simd, WithSimd};

use super::ahead::ask_for;
use super::blocks::Block;
use super::frame::{Frame, MOST_LANES, Motion};
use super::strip::{CellLanes, SUMS, Strip, Tail};
use crate::boundary::ROUND_OFF;
use crate::constitutive::{Flow, Law};
use crate::dimension::{Kinematics, PlaneStrain, basis, coefficients, gradient, shares, to_corners, trace, value};
use crate::observe::Flowed;
use crate::real::{Lanes, Real};
use crate::shape::Shape;
use crate::water::{FaceFlow, LEAST_FILLING};

/// Everything a pass reads and no strip changes.
#[derive(Debug)]
pub struct Common<'a, L> {
    /// Numbering.
    pub frame: &'a Frame,
    /// Motion of the nodes in this step.
    pub motion: &'a Motion,
    /// Pore pressure of the cells at its start, Pa; from [`Frame::row`] on.
    pub pressure: &'a [f64],
    /// How faces conduct: 0 closed, 1 between two full cells of soil, 2 at a drained side, half a cell away; else the edge of
    /// a cell over the distance.
    pub conducts: &'a [Vec<f64>; 2],
    /// Volume of soil in the cells at the end of the pass, m3, where it is known; else zero.
    pub soil: &'a [f64],
    /// Law of the skeleton.
    pub law: L,
    /// Darcy's law on a face.
    pub flow: FaceFlow,
    /// Gravity, m/s2.
    pub gravity: [f64; 2],
    /// FLIP share of the velocity update.
    pub flip: f64,
    /// Time step, s.
    pub dt: f64,
}

/// The pass over one strip. MOVE: with mesh to particles; without, the particles are only gathered.
pub struct Sweep<'a, V: Simd, Sh, L, const WET: bool, const MOVE: bool> {
    /// Leave to use the machine's instructions.
    pub simd: V,
    /// The strip.
    pub strip: &'a mut Strip<V>,
    /// What it gives to the nodes of the next strip.
    pub tail: &'a mut Tail,
    /// Where the pore pressure of its cells goes, Pa.
    pub pressure: &'a mut [f64],
    /// What all strips share.
    pub common: &'a Common<'a, L>,
    /// The shape functions.
    pub shape: std::marker::PhantomData<Sh>,
}

/// The fill of a cell whose soil is not known: its water is as stiff as in a full one.
const NOT_KNOWN: f64 = 1e60;
/// How many blocks of particles to ask for in advance.
const BLOCKS_AHEAD: usize = 12;
/// How many groups of cells to ask for in advance.
const GROUPS_AHEAD: usize = 3;

/// A vector field in a cell, as coefficients of the basis.
type Field<V> = [[Lanes<V>; 2]; 4];

/// Motion in a cell.
struct CellMotion<V: Simd> {
    velocity: Field<V>,
    change: Field<V>,
}

/// What the particles of a cell give.
struct Gathered<V: Simd> {
    mass: Lanes<V>,
    volume: Lanes<V>,
    solid_mass: [Lanes<V>; 4],
    momentum: Field<V>,
    mean: [Lanes<V>; 4],
    first: [[Lanes<V>; 4]; 2],
    water_mass: [Lanes<V>; 4],
    /// Moments of V p.
    weighted: [[Lanes<V>; 1]; 4],
    /// Moments of V of the water.
    volumes: [[Lanes<V>; 1]; 4],
}

impl<V: Simd> Gathered<V> {
    #[inline(always)]
    fn nothing(simd: V) -> Self {
        let none = Lanes::splat(simd, 0.0);
        Self {
            mass: none,
            volume: none,
            solid_mass: [none; 4],
            momentum: [[none; 2]; 4],
            mean: [none; 4],
            first: [[none; 4]; 2],
            water_mass: [none; 4],
            weighted: [[none; 1]; 4],
            volumes: [[none; 1]; 4],
        }
    }
}

/// Plastic flow of the particles of a strip, in as many parts as a machine may have lanes: the bits do not depend on how
/// many it has.
struct FlowedLanes<V: Simd> {
    dissipation: [Lanes<V>; MOST_LANES],
    residual: Lanes<V>,
}

impl<V: Simd> FlowedLanes<V> {
    #[inline(always)]
    fn nothing(simd: V) -> Self {
        let none = Lanes::splat(simd, 0.0);
        Self { dissipation: [none; MOST_LANES], residual: none.like(f64::NEG_INFINITY) }
    }

    /// Adds one particle of each cell of a group, of a volume (m3).
    #[inline(always)]
    fn add(&mut self, group: usize, volume: Lanes<V>, flow: &Flow<Lanes<V>>) {
        self.dissipation[group % (MOST_LANES / V::F64_LANES)] += volume * flow.dissipation;
        self.residual = flow.residual.larger(self.residual);
    }

    #[inline(always)]
    fn added_up(&self) -> Flowed {
        let mut flowed = Flowed::NOTHING;
        for part in 0..MOST_LANES {
            flowed.dissipation += self.dissipation[part / V::F64_LANES].lane(part % V::F64_LANES);
        }
        for lane in 0..V::F64_LANES {
            flowed.residual = flowed.residual.max(self.residual.lane(lane));
        }
        flowed
    }
}

impl<V: Simd, Sh: Shape, L: Law<4>, const WET: bool, const MOVE: bool> WithSimd for Sweep<'_, V, Sh, L, WET, MOVE> {
    type Output = ();

    #[inline(always)]
    fn with_simd<T: Simd>(mut self, _: T) {
        self.run();
    }
}

impl<V: Simd, Sh: Shape, L: Law<4>, const WET: bool, const MOVE: bool> Sweep<'_, V, Sh, L, WET, MOVE> {
    #[inline(always)]
    fn lanes(&self, value: V::f64s) -> Lanes<V> {
        Lanes { simd: self.simd, value }
    }

    #[inline(always)]
    fn run(&mut self) {
        let row = self.common.frame.row;
        for sums in &mut self.strip.sums {
            sums[..=row].fill(0.0); // the cells below are another strip's
        }
        let none = Lanes::splat(self.simd, 0.0);
        let mut carry = [[none; SUMS]; 2];
        let mut rates = [[none; MOST_LANES]; 2];
        let mut flowed = FlowedLanes::<V>::nothing(self.simd);
        let mut stays = self.lanes_that_stay();
        for group in 0..self.strip.cells.len() {
            let cell = self.strip.cells[group];
            let mut gathered = Gathered::nothing(self.simd);
            let at = self.strip.first + group * V::F64_LANES;
            let position = cell.position.map(|p| self.lanes(p));
            self.ask_for_cells::<MOVE>(group, at);
            if MOVE {
                let motion = self.cell_motion(at);
                let relative = if WET { self.darcy_flow(at, &cell, &mut rates, group) } else { [[none; 2]; 4] };
                self.solid(group, &position, Some(&motion), &mut gathered, &mut flowed, &mut stays);
                if WET {
                    let velocity = &motion.velocity;
                    self.water(group, &position, Some((velocity, &relative, &cell)), &mut gathered, &mut stays);
                }
            } else {
                self.solid(group, &position, None, &mut gathered, &mut flowed, &mut stays);
                if WET {
                    self.water(group, &position, None, &mut gathered, &mut stays);
                }
            }
            let sums = self.cell_to_grid(group, &mut gathered);
            self.scatter(group * V::F64_LANES, row, &sums, &mut carry);
        }
        let length = self.strip.cells.len() * V::F64_LANES;
        for q in 0..SUMS {
            self.strip.sums[q][length] += carry[0][q].lane(0);
            self.strip.sums[q][length + row] = carry[1][q].lane(0);
            self.tail[q].copy_from_slice(&self.strip.sums[q][length..=length + row]);
        }
        self.strip.stays = self.simd.first_true_m64s(self.simd.not_m64s(stays)) == V::F64_LANES;
        if MOVE && L::PLASTIC {
            self.strip.flowed = flowed.added_up();
        }
        if MOVE && WET {
            for (rate, lanes) in self.strip.rates.iter_mut().zip(rates) {
                *rate = 0.0;
                for part in 0..MOST_LANES {
                    *rate += lanes[part / V::F64_LANES].lane(part % V::F64_LANES);
                }
            }
        }
    }

    /// Asks for cells, upper nodes and faces of a group to come.
    #[inline(always)]
    fn ask_for_cells<const NODES: bool>(&self, group: usize, at: usize) {
        ask_for(&self.strip.cells, group + GROUPS_AHEAD);
        if NODES {
            let Common { frame, motion, pressure, conducts, .. } = self.common;
            let here = at + GROUPS_AHEAD * V::F64_LANES;
            for d in 0..2 {
                for field in [&motion.velocity[d], &motion.change[d], &motion.acceleration[d]] {
                    ask_for(field, here + frame.row);
                }
                ask_for(&conducts[d], here + d * frame.row);
            }
            ask_for(pressure, here + 2 * frame.row);
        }
    }

    #[inline(always)]
    fn lanes_that_stay(&self) -> V::m64s {
        Lanes::splat(self.simd, 0.0).in_unit_interval()
    }

    /// A field at the cells (or nodes, or faces) from `at` on and at those right of them.
    #[inline(always)]
    fn pair(&self, field: &[f64], at: usize) -> [Lanes<V>; 2] {
        let window = &field[at..][..V::F64_LANES + 1];
        [Lanes::load(self.simd, window), Lanes::load(self.simd, &window[1..])]
    }

    /// A field at the corners of the cells from `at` on.
    #[inline(always)]
    fn corners(&self, field: &[f64], at: usize) -> [Lanes<V>; 4] {
        let ([a, b], [c, d]) = (self.pair(field, at), self.pair(field, at + self.common.frame.row));
        [a, b, c, d]
    }

    /// Motion of the corners of the cells from `at` on.
    #[inline(always)]
    fn cell_motion(&self, at: usize) -> CellMotion<V> {
        let motion = self.common.motion;
        let none = Lanes::splat(self.simd, 0.0);
        let (mut velocity, mut change) = ([[none; 2]; 4], [[none; 2]; 4]);
        for d in 0..2 {
            let (v, c) = (self.corners(&motion.velocity[d], at), self.corners(&motion.change[d], at));
            for a in 0..4 {
                (velocity[a][d], change[a][d]) = (v[a], c[a]);
            }
        }
        CellMotion { velocity: coefficients::<2, 2, _>(&velocity), change: coefficients::<2, 2, _>(&change) }
    }

    /// Eq. (1) on faces normal to an axis between cells of two pressures (Pa) whose nodes accelerate (m/s2): flux (m/s),
    /// pressure drop and weight along it (Pa).
    #[inline(always)]
    fn face(
        &self,
        axis: usize,
        conducts: Lanes<V>,
        [low, high]: [Lanes<V>; 2],
        [a, b]: [Lanes<V>; 2],
    ) -> [Lanes<V>; 3] {
        let Common { flow, gravity, .. } = self.common;
        let mean = (a + b) * 0.5;
        let body = (mean.like(gravity[axis]) - mean * flow.inertia) * flow.weight;
        // Over the distance that the pressure drops along.
        let body = body / conducts.or(mean.like(0.0).below(conducts), mean.like(1.0));
        let head = low - high + body;
        [conducts * head * flow.conductance, head, body]
    }

    /// Eq. (1): relative velocity v* in the cells from `at` on, linear between their faces, as coefficients.
    #[inline(always)]
    fn darcy_flow(
        &self,
        at: usize,
        cell: &CellLanes<V>,
        rates: &mut [[Lanes<V>; MOST_LANES]; 2],
        group: usize,
    ) -> Field<V> {
        let Common { frame, motion, pressure, conducts, .. } = self.common;
        let none = Lanes::splat(self.simd, 0.0);
        let inverse_porosity = Lanes { simd: self.simd, value: cell.inverse_porosity };
        let part = group % (MOST_LANES / V::F64_LANES);
        // Pressures begin a row early, so that every face has a cell below.
        let own = &pressure[at + frame.row - 1..][..V::F64_LANES + 2];
        let left = Lanes::load(self.simd, own);
        let here = Lanes::load(self.simd, &own[1..]);
        let right = Lanes::load(self.simd, &own[2..]);
        let below = Lanes::load(self.simd, &pressure[at..]);
        let above = Lanes::load(self.simd, &pressure[at + 2 * frame.row..]);
        let x = self.corners(&motion.acceleration[0], at);
        let y = self.corners(&motion.acceleration[1], at);
        let [open_left, open_right] = self.pair(&conducts[0], at);
        let open_below = Lanes::load(self.simd, &conducts[1][at..]);
        let open_above = Lanes::load(self.simd, &conducts[1][at + frame.row..]);
        let at_left = self.face(0, open_left, [left, here], [x[0], x[2]]);
        let at_right = self.face(0, open_right, [here, right], [x[1], x[3]]);
        let at_base = self.face(1, open_below, [below, here], [y[0], y[1]]);
        let at_top = self.face(1, open_above, [here, above], [y[2], y[3]]);
        let mut relative = [[none; 2]; 4];
        for (axis, [[low, head, body], [high, ..]]) in [[at_left, at_right], [at_base, at_top]].into_iter().enumerate()
        {
            relative[0][axis] = low * inverse_porosity; // v* = q/n
            relative[1 + axis][axis] = (high - low) * inverse_porosity;
            rates[0][part] += low * head;
            rates[1][part] += low * body;
        }
        relative
    }

    /// Solid particles: strains, stresses, velocities and positions, then masses, momenta and stresses.
    #[inline(always)]
    fn solid(
        &mut self,
        group: usize,
        position: &[Lanes<V>; 2],
        motion: Option<&CellMotion<V>>,
        sum: &mut Gathered<V>,
        flowed: &mut FlowedLanes<V>,
        stays: &mut V::m64s,
    ) {
        let (simd, Common { frame, law, flip, dt, .. }) = (self.simd, self.common);
        let (start, inverse) = (&self.strip.solid.start, frame.inverse_size);
        let range = start[group] as usize..start[group + 1] as usize;
        for index in range {
            ask_for(&self.strip.solid.blocks, index + BLOCKS_AHEAD);
            let Block(block) = &mut self.strip.solid.blocks[index];
            let [x, y, u, v, xx, yy, zz, xy, mass, volume] = block.map(|value| Lanes { simd, value });
            let (mut x, mut v, mut stress, mut volume) = ([x, y], [u, v], [xx, yy, zz, xy], volume);
            let mut xi = [x[0] * inverse - position[0], x[1] * inverse - position[1]];
            if let Some(CellMotion { velocity, change }) = motion {
                let phi = basis(&xi);
                let gradient = gradient(velocity, &Sh::point(&xi), inverse);
                PlaneStrain::rotate(&mut stress, &gradient, *dt);
                let strain = PlaneStrain::strain_increment(&gradient, *dt);
                if L::PLASTIC {
                    let there = volume.like(0.0).below(volume);
                    let flow = law.flow_lanes(&mut stress, &strain, there);
                    flowed.add(group, volume, &flow);
                } else {
                    law.update_lanes(&mut stress, &strain);
                }
                volume = volume * (volume.like(1.0) + trace(&gradient) * *dt);
                let dv = value::<2, 2, _>(change, &phi);
                let moving = value::<2, 2, _>(velocity, &phi);
                for d in 0..2 {
                    v[d] = v[d] * *flip + dv[d];
                    x[d] += moving[d] * *dt;
                    xi[d] = x[d] * inverse - position[d];
                    *stays = simd.and_m64s(*stays, xi[d].in_unit_interval());
                }
                let [xx, yy, zz, xy] = stress;
                *block = [x[0], x[1], v[0], v[1], xx, yy, zz, xy, mass, volume].map(|lanes| lanes.value);
            }
            let share = shares(mass, &xi);
            sum.mass += mass;
            sum.volume += volume;
            for a in 0..4 {
                sum.solid_mass[a] += share[a];
                for d in 0..2 {
                    sum.momentum[a][d] += share[a] * v[d];
                }
            }
            for s in 0..4 {
                let weighted = volume * stress[s];
                sum.mean[s] += weighted;
                if !Sh::AT_CENTRE {
                    for d in 0..2 {
                        sum.first[d][s] += weighted * xi[d];
                    }
                }
            }
        }
    }

    /// Water particles: pressures, volumes and positions (Eqs. 5 to 7), then masses and pressures.
    #[inline(always)]
    fn water(
        &mut self,
        group: usize,
        position: &[Lanes<V>; 2],
        motion: Option<(&Field<V>, &Field<V>, &CellLanes<V>)>,
        sum: &mut Gathered<V>,
        stays: &mut V::m64s,
    ) {
        let (simd, Common { frame, flow, dt, .. }) = (self.simd, self.common);
        let (start, inverse) = (&self.strip.water.start, frame.inverse_size);
        let range = start[group] as usize..start[group + 1] as usize;
        let none = Lanes::splat(simd, 0.0);
        let mut both = [[none; 2]; 4]; // v_w = v_s + v*
        let mut centre = [none; 2];
        if let Some((velocity, relative, cell)) = motion {
            both = *velocity;
            for d in 0..2 {
                both[0][d] += relative[0][d];
                both[1 + d][d] += relative[1 + d][d];
            }
            centre = rates_at(simd, (velocity, relative), cell, (flow, *dt), &[none.like(0.5); 2], inverse);
        }
        for index in range {
            ask_for(&self.strip.water.blocks, index + BLOCKS_AHEAD);
            let Block(block) = &mut self.strip.water.blocks[index];
            let [x, y, .., mass, volume, pressure] = block.map(|value| Lanes { simd, value });
            let (mut x, mut volume, mut pressure) = ([x, y], volume, pressure);
            let mut xi = [x[0] * inverse - position[0], x[1] * inverse - position[1]];
            if let Some((velocity, relative, cell)) = motion {
                let [pressure_rate, volume_rate] = if Sh::AT_CENTRE {
                    centre
                } else {
                    rates_at(simd, (velocity, relative), cell, (flow, *dt), &xi, inverse)
                };
                let v = value::<2, 2, _>(&both, &basis(&xi));
                pressure += pressure_rate * *dt;
                volume = volume * (volume.like(1.0) + volume_rate * *dt);
                for d in 0..2 {
                    x[d] += v[d] * *dt;
                    xi[d] = x[d] * inverse - position[d];
                    *stays = simd.and_m64s(*stays, xi[d].in_unit_interval());
                }
                *block = [x[0], x[1], v[0], v[1], mass, volume, pressure].map(|lanes| lanes.value);
            }
            let share = shares(mass, &xi);
            for a in 0..4 {
                sum.water_mass[a] += share[a];
            }
            let weighted = volume * pressure;
            sum.weighted[0][0] += weighted;
            sum.volumes[0][0] += volume;
            if !Sh::AT_CENTRE {
                let phi = basis(&xi);
                for k in 1..4 {
                    sum.weighted[k][0] += weighted * phi[k];
                    sum.volumes[k][0] += volume * phi[k];
                }
            }
        }
    }

    /// Notes the state of the cells for the next step, and gives the sums at their corners.
    #[inline(always)]
    fn cell_to_grid(&mut self, group: usize, sum: &mut Gathered<V>) -> [[Lanes<V>; 4]; SUMS] {
        let Common { frame, flow, .. } = self.common;
        let none = Lanes::splat(self.simd, 0.0);
        let one = none.like(1.0);
        let full = |volume: Lanes<V>| volume.or(none.below(volume), one);
        let known = Lanes::load(self.simd, &self.common.soil[self.strip.first + group * V::F64_LANES..]);
        let is_known = none.below(known);
        // As `Filled::volume`: round-off is no difference.
        let off = (known - sum.volume).larger(sum.volume - known);
        let filled = known.or((known * ROUND_OFF).below(off), sum.volume).or(is_known, sum.volume);
        let share = filled / full(sum.volume);
        sum.mean = sum.mean.map(|s| s * share);
        if !Sh::AT_CENTRE {
            sum.first = sum.first.map(|first| first.map(|s| s * share));
        }
        if Sh::AT_CENTRE {
            // Section 2.2: G_i(x_c) for every particle of the cell.
            sum.first = [sum.mean.map(|s| s * 0.5); 2];
        }
        if WET {
            // Cells without soil have no pressure; they must not turn into NaN beside cells that have.
            let pressure = sum.weighted[0][0] / full(sum.volumes[0][0]);
            let inverse_volume = one / full(filled);
            let porosity = one - sum.mass * flow.grain_inverse / full(sum.volume);
            // Water in pores of known volume moves with its soil.
            let ratio = porosity * sum.volume * flow.density / full(sum.mass);
            for a in 0..4 {
                sum.water_mass[a] = (ratio * sum.solid_mass[a]).or(is_known, sum.water_mass[a]);
            }
            let over_fill = inverse_volume * flow.cell_volume;
            let fill = one / over_fill;
            let cell = &mut self.strip.cells[group];
            cell.filling = over_fill.or(is_known, over_fill.lesser(one.like(1.0 / LEAST_FILLING))).value;
            cell.fill = fill.or(is_known, one.like(NOT_KNOWN)).value;
            (cell.volume, cell.inverse_volume) = (sum.volume.value, inverse_volume.value);
            (cell.porosity, cell.inverse_porosity) = (porosity.value, (one / porosity).value);
            pressure.store(&mut self.pressure[group * V::F64_LANES..]);
            if Sh::AT_CENTRE {
                // Section 2.2: the pressure acts at the centre of the cell, on the soil that the water fills.
                let acting = pressure * filled;
                sum.weighted = [[acting], [acting * 0.5], [acting * 0.5], [acting * 0.25]];
            } else {
                let share = filled / full(sum.volumes[0][0]);
                sum.weighted = sum.weighted.map(|[moment]| [moment * share]);
            }
            for s in 0..3 {
                sum.mean[s] -= sum.weighted[0][0];
                for d in 0..2 {
                    sum.first[d][s] -= sum.weighted[1 + d][0];
                }
            }
        } else {
            self.strip.cells[group].volume = sum.volume.value;
        }
        // div(sigma') - grad p, weak: f_i = - sum_p V sigma G_i
        let force = PlaneStrain::internal_force(&sum.mean, &sum.first, frame.inverse_size);
        let internal = to_corners::<2, 2, _>(&force);
        let mut sums = [[none; 4]; SUMS];
        for a in 0..4 {
            let [px, py] = sum.momentum[a];
            let [fx, fy] = internal[a];
            let mixture = sum.solid_mass[a] + sum.water_mass[a];
            let at_corner = [sum.solid_mass[a], mixture, px, py, -fx, -fy];
            for q in 0..SUMS {
                sums[q][a] = at_corner[q];
            }
        }
        sums
    }

    /// Adds what the cells from `cell` of the strip on give to their corners: upper nodes are begun, lower ones ended.
    #[inline(always)]
    fn scatter(&mut self, cell: usize, row: usize, sums: &[[Lanes<V>; 4]; SUMS], carry: &mut [[Lanes<V>; SUMS]; 2]) {
        let index = self.first_lane();
        for q in 0..SUMS {
            let [left, right, upper_left, upper_right] = sums[q];
            let (turned, turned_upper) = (right.turned(), upper_right.turned());
            let to = &mut self.strip.sums[q];
            let upper = carry[1][q].or(index, turned_upper) + upper_left;
            upper.store(&mut to[cell + row..]);
            let begun = &mut to[cell..][..V::F64_LANES];
            (Lanes::load(self.simd, begun) + carry[0][q].or(index, turned) + left).store(begun);
            (carry[0][q], carry[1][q]) = (turned, turned_upper);
        }
    }

    /// Holds in the first lane only.
    #[inline(always)]
    fn first_lane(&self) -> V::m64s {
        let numbers: [f64; MOST_LANES] = std::array::from_fn(|i| i as f64);
        let lanes = Lanes::load(self.simd, &numbers);
        lanes.below(lanes.like(0.5))
    }
}

/// Rates of pressure (Pa/s) and of water volume (1/s) at a point of the cells.
#[inline(always)]
fn rates_at<V: Simd>(
    simd: V,
    (velocity, relative): (&Field<V>, &Field<V>),
    cell: &CellLanes<V>,
    (flow, dt): (&FaceFlow, f64),
    at: &[Lanes<V>; 2],
    inverse_size: f64,
) -> [Lanes<V>; 2] {
    let of = |value| Lanes { simd, value };
    let solid = trace(&gradient(velocity, at, inverse_size)); // Eq. (7a)
    let through = of(cell.filling) * trace(&gradient(relative, at, inverse_size)); // Eq. (6a)
    // As `water::face::softer`.
    let stiffness = of(cell.inverse_porosity) * flow.bulk_modulus;
    let (fill, diffusion) = (of(cell.fill), stiffness * dt * flow.diffusion);
    let one = fill.like(1.0);
    let share = fill * 1.5 * fill * (one + fill) / (one + fill * 2.0);
    let softer = (share * (one.like(crate::water::FLOW / 3.0) / diffusion).larger(one)).lesser(one);
    let stiffness = softer * stiffness;
    // Eq. (5), mended: dp = -(K_w/n) [ tr(d eps_s) + n tr(d eps*_w) ]
    [-stiffness * (solid + of(cell.porosity) * through), solid + through]
}

//! The paper's explicit step (Figure 1) in plane strain, so many cells at once as the machine has lanes, on as many
//! threads as it is given.
//!
//! `step/explicit.rs` is the same step written plainly. Particles get the same bits from both on a mesh of one strip; where strips meet, the
//! sums at their nodes have another order, and settlements and pressures may differ by 1e-7 of themselves once particles have crossed
//! cells; balances, which are sums over all cells, differ by round-off on any mesh. `tests/lanes.rs` holds both. Here cells lie
//! side by side in vectors ([`frame`]), a layer is kept in blocks of one particle of each cell ([`blocks`]), and one
//! [`sweep`] per step takes every particle from one grid to the next. The unit of work is a [`strip`] of cells, whose
//! size does not depend on the threads: nor do the bits.

mod ahead;
mod blocks;
mod crossing;
mod frame;
mod motion;
mod strip;
mod sweep;

use std::marker::PhantomData;
use std::sync::Arc;

use pulp::Simd;
use rayon::ThreadPool;
use rayon::prelude::*;

use super::{Fault, Model, Parts};
use crate::constitutive::Law;
use crate::dimension::{PlaneStrain, basis, coefficients, gradient, trace, value};
use crate::keep::Keeper;
use crate::observe::{Ledger, Observation, Totals};
use crate::particles::Layer;
use crate::scene::Stage;
use crate::shape::Shape;
use crate::water::{DRAINED_SURFACE, Resident};
use blocks::{Mover, SOLID, WATER, WATER_MASS};
use frame::{Frame, MOST_LANES, Motion};
use motion::EquationOfMotion;
use strip::{FORCE, MIXTURE_MASS, MOMENTUM, SOLID_MASS, SUMS, Strip, Tail, no_tail};
use sweep::{Common, Sweep};

/// A face that lets water out.
#[derive(Debug, Clone, Copy)]
struct DrainedFace {
    cell: usize,
    axis: usize,
    outwards: f64,
    nodes: [usize; 2],
}

/// Room for one in so many particles to change its cell in a step, before more is asked for.
const MOVERS: usize = 16;

/// The explicit integrator in plane strain over lanes. V: the machine's lanes, Sh: shape, L: law, W: water; WET: whether
/// there is any.
pub struct ExplicitLanes<V: Simd, Sh, L, W, const WET: bool> {
    simd: V,
    /// Everything but the particles, which are in the strips.
    parts: Parts<L, W, 2, 4>,
    frame: Frame,
    strips: Vec<Strip<V>>,
    /// What each strip gives to the next one.
    tails: Vec<Tail>,
    motion: Motion,
    /// Pore pressure of the cells now and at the next step, Pa, from a row before the first cell on.
    pressure: [Vec<f64>; 2],
    /// See [`Common::conducts`].
    conducts: [Vec<f64>; 2],
    /// Strip, cell in it and place in that of the particle below each strip of the surface.
    tops: Vec<[u32; 3]>,
    /// First corner of the cell that each strip of the surface pushes in this step, and the force on its corners, N.
    pushes: Vec<(usize, [f64; 4])>,
    /// Drained faces.
    drained: Vec<DrainedFace>,
    /// See [`Common::soil`].
    soil: Vec<f64>,
    /// Place (m) and volume (m3) at the end of the step of the particles below the surface.
    ahead: Vec<([f64; 2], f64)>,
    /// Particles on their way to another cell.
    movers: (Vec<Mover<SOLID>>, Vec<Mover<WATER>>),
    solid_count: usize,
    damping: f64,
    time: f64,
    totals: Totals<2>,
    pool: Option<Arc<ThreadPool>>,
    shape: PhantomData<Sh>,
}

impl<V: Simd, Sh: Shape, L: Law<4>, W: Resident, const WET: bool> ExplicitLanes<V, Sh, L, W, WET> {
    /// A run at t = 0, on the threads of a pool if there is one.
    pub fn new(simd: V, mut parts: Parts<L, W, 2, 4>, pool: Option<Arc<ThreadPool>>) -> Self {
        parts.surface.follow(&parts.solid);
        let mut totals = Totals::default();
        totals.start(&parts.cell_values::<PlaneStrain>());
        totals.flowed = parts.flowed_at_first();
        let frame = Frame::new(&parts.grid);
        let pressure = || vec![0.0; frame.count() + 2 * frame.row + 1 + MOST_LANES];
        let faces = || vec![0.0; frame.count() + frame.row + 1 + MOST_LANES];
        let mut run = Self {
            simd,
            frame,
            strips: (0..frame.strips).map(|number| Strip::new(&frame, number)).collect(),
            tails: (0..frame.strips).map(|_| no_tail(&frame)).collect(),
            motion: Motion::new(&frame),
            pressure: [pressure(), pressure()],
            conducts: [faces(), faces()],
            tops: vec![[0; 3]; parts.surface.strips().len()],
            pushes: vec![(0, [0.0; 4]); parts.surface.strips().len()],
            drained: Vec::new(),
            soil: vec![0.0; frame.count() + MOST_LANES],
            ahead: vec![([0.0; 2], 0.0); parts.surface.strips().len()],
            movers: (Vec::with_capacity(parts.solid.points.len() / MOVERS), Vec::new()),
            solid_count: parts.solid.points.len(),
            parts,
            damping: 0.0,
            time: 0.0,
            totals,
            pool,
            shape: PhantomData,
        };
        run.settle_in();
        if WET {
            run.movers.1.reserve_exact(run.solid_count / MOVERS);
        }
        run
    }

    /// Takes the particles of the parts into the strips and gathers them.
    fn settle_in(&mut self) {
        let Self { parts, frame, strips, .. } = self;
        let water = parts.water.lend();
        for strip in strips.iter_mut() {
            strip.solid.fill(frame, strip.first, &parts.solid);
            if let Some(water) = &water {
                strip.water.fill(frame, strip.first, water);
            }
        }
        // What is left of the layers are their cells and counts.
        parts.solid = std::mem::take(&mut parts.solid).without_points();
        parts.water.take(water.map(Layer::without_points));
        self.open_faces();
        for cell in 0..self.frame.count() {
            self.follow(cell);
        }
        self.find_surface();
        self.pass::<false>(0.0);
    }

    /// Finds the surface from the particles where they are.
    fn find_surface(&mut self) {
        let Self { parts, strips, tops, .. } = self;
        if parts.filled.is_known() {
            parts.filled.follow(&parts.grid, &parts.surface, |top| carrier(strips, tops, top));
            self.note_soil(true);
            self.note_reach();
        }
    }

    /// Finds it where the particles will be at the end of a step, as [`sweep`] moves them.
    fn find_surface_ahead(&mut self, dt: f64) {
        let Self { parts, frame, strips, tops, motion, ahead, .. } = self;
        if !parts.filled.is_known() {
            return;
        }
        for (top, ahead) in ahead.iter_mut().enumerate() {
            let [strip, cell, _] = tops[top].map(|i| i as usize);
            let (mut x, mut volume) = carrier(strips, tops, top);
            let number = strips[strip].first + cell;
            let position = frame.position(number).map(|i| i as f64);
            let xi: [f64; 2] = std::array::from_fn(|d| x[d] * frame.inverse_size - position[d]);
            let nodal = corners(frame, number).map(|node| std::array::from_fn(|d| motion.velocity[d][node]));
            let velocity = coefficients::<2, 2, _>(&nodal);
            let v = value::<2, 2, f64>(&velocity, &basis(&xi));
            volume *= 1.0 + dt * trace(&gradient(&velocity, &Sh::point(&xi), frame.inverse_size));
            for d in 0..2 {
                x[d] += dt * v[d];
            }
            *ahead = (x, volume);
        }
        let moved = parts.filled.follow(&parts.grid, &parts.surface, |top| ahead[top]);
        self.note_soil(moved);
    }

    /// Volumes of soil by the numbers of the frame: of all cells, or of those that hold the surface.
    fn note_soil(&mut self, all: bool) {
        let Self { parts, frame, soil, .. } = self;
        for (column, top) in parts.filled.tops().iter().enumerate().filter(|_| !all) {
            let number = frame.number(&[column, top.cell as usize / frame.cells[0]]);
            soil[number] = parts.filled.volumes()[top.cell as usize];
        }
        if !all {
            return;
        }
        for (row, volumes) in parts.filled.volumes().chunks(frame.cells[0]).enumerate() {
            soil[row * frame.row..][..volumes.len()].copy_from_slice(volumes);
        }
    }

    /// Distances between the cells that hold the surface, it, and the cells below.
    fn note_reach(&mut self) {
        let Self { parts, frame, conducts, drained, .. } = self;
        for (column, top) in parts.filled.tops().iter().enumerate() {
            let number = frame.number(&[column, top.cell as usize / frame.cells[0]]);
            if conducts[1][number] > 0.0 {
                conducts[1][number] = 2.0 / (1.0 + top.fill);
            }
        }
        for face in drained.iter().filter(|face| face.axis == 1 && face.outwards > 0.0) {
            let top = parts.filled.tops().get(face.cell % frame.row);
            if let Some(top) = top.filter(|top| top.cell as usize / frame.cells[0] == face.cell / frame.row) {
                conducts[1][face.cell + frame.row] = DRAINED_SURFACE / top.fill;
            }
        }
    }

    /// Notes where the particles below the surface are, of those in a cell.
    fn follow(&mut self, cell: usize) {
        let Self { parts, frame, strips, tops, .. } = self;
        let (strip, inside) = (cell / frame.strip, cell % frame.strip);
        let solid = &strips[strip].solid;
        for slot in 0..solid.count(inside) {
            if let Ok(top) = parts.surface.strips().binary_search_by_key(&solid.id(inside, slot), |s| s.id) {
                tops[top] = [strip, inside, slot].map(|i| i as u32);
            }
        }
    }

    /// The parts with their particles.
    fn whole(&self) -> Parts<L, W, 2, 4> {
        let mut parts = self.parts.clone();
        let cells = self.parts.grid.cell_count();
        let (mut points, mut ids, mut start) = (Vec::with_capacity(self.solid_count), Vec::new(), vec![0]);
        let (mut drops, mut drop_ids, mut drop_start) = (Vec::new(), Vec::new(), vec![0]);
        for (_, position) in self.parts.grid.walk() {
            let number = self.frame.number(&position);
            let (strip, cell) = (&self.strips[number / self.frame.strip], number % self.frame.strip);
            strip.solid.append(cell, &mut points, &mut ids);
            start.push(points.len() as u32);
            strip.water.append(cell, &mut drops, &mut drop_ids);
            drop_start.push(drops.len() as u32);
        }
        debug_assert_eq!(start.len(), cells + 1);
        parts.solid = Layer::in_order(&parts.solid, points, ids, start);
        if let Some(layer) = parts.water.lend() {
            parts.water.take(Some(Layer::in_order(&layer, drops, drop_ids, drop_start)));
        }
        parts.surface.follow(&parts.solid);
        parts
    }

    /// Finds which faces conduct.
    fn open_faces(&mut self) {
        let Self { parts, frame, conducts, drained, .. } = self;
        let (solid, grid) = (&parts.solid, &parts.grid);
        let soil = |cell: usize| solid.cell_start[cell] != solid.cell_start[cell + 1];
        for faces in conducts.iter_mut() {
            faces.fill(0.0);
        }
        for (cell, position) in grid.walk() {
            for (axis, stride) in [1, grid.cells[0]].into_iter().enumerate() {
                if position[axis] > 0 && soil(cell) && soil(cell - stride) {
                    conducts[axis][frame.number(&position)] = 1.0;
                }
            }
        }
        let (exposed, sides) = parts.water.outline();
        drained.clear();
        for face in exposed.iter().filter(|f| sides[f.side as usize]) {
            let (axis, mut position) = (face.axis as usize, grid.cell_position(face.cell as usize));
            let outwards = if face.upper { 1.0 } else { -1.0 };
            let nodes = face.nodes.map(|node| node as usize);
            drained.push(DrainedFace { cell: frame.number(&position), axis, outwards, nodes });
            position[axis] += usize::from(face.upper);
            conducts[axis][frame.number(&position)] = DRAINED_SURFACE;
        }
    }

    /// One pass over all particles, on one thread or several.
    fn pass<const MOVE: bool>(&mut self, dt: f64) {
        let Self { simd, parts, frame, strips, tails, motion, pressure: [old, new], conducts, soil, pool, .. } = self;
        let common = &Common {
            frame,
            motion,
            pressure: old,
            conducts,
            soil,
            law: parts.law,
            flow: parts.water.face_flow(),
            gravity: parts.gravity.unwrap_or([0.0; 2]),
            flip: parts.flip,
            dt,
        };
        let simd = *simd;
        let sweep = |strip: &mut Strip<V>, tail: &mut Tail, pressure: &mut [f64]| {
            simd.vectorize(Sweep::<V, Sh, L, WET, MOVE> { simd, strip, tail, pressure, common, shape: PhantomData });
        };
        let chunks = new[frame.row..][..frame.count()].chunks_mut(frame.strip);
        if pool.is_some() {
            let chunks = new[frame.row..][..frame.count()].par_chunks_mut(frame.strip);
            strips.par_iter_mut().zip(tails).zip(chunks).for_each(|((strip, tail), new)| sweep(strip, tail, new));
        } else {
            strips.iter_mut().zip(tails).zip(chunks).for_each(|((strip, tail), new)| sweep(strip, tail, new));
        }
        self.pressure.swap(0, 1);
    }

    /// One step of Figure 1, from the gathered particles to the gathered particles.
    fn step(&mut self, dt: f64) -> Result<(), Fault> {
        self.load();
        self.equation_of_motion(dt);
        if WET {
            let [x, y] = &mut self.motion.acceleration;
            self.parts.filled.calm(&self.parts.grid, |lower, upper, share| {
                for a in [&mut *x, &mut *y] {
                    a[upper] = a[lower] + share * (a[upper] - a[lower]);
                }
            });
        }
        self.through_drained_faces(dt);
        self.find_surface_ahead(dt);
        self.pass::<true>(dt);
        if self.parts.filled.is_known() {
            self.note_reach();
        }
        if WET {
            for strip in &self.strips {
                self.totals.darcy_dissipation += dt * self.parts.water.face_flow().area * strip.rates[0];
                self.totals.flow_body_work += dt * self.parts.water.face_flow().area * strip.rates[1];
            }
        }
        if L::PLASTIC {
            for strip in &self.strips {
                self.totals.flowed.join(&strip.flowed);
            }
        }
        if !self.strips.iter().all(|strip| strip.stays) {
            self.sort()?;
        }
        self.time += dt;
        Ok(())
    }

    /// Restores the order of the cells after particles have left theirs.
    fn sort(&mut self) -> Result<(), Fault> {
        let Self { frame, strips, movers: (solid, water), .. } = self;
        crossing::find(strips, frame, |s| &mut s.solid, solid);
        crossing::find(strips, frame, |s| &mut s.water, water);
        let drains = self.parts.water.outline().1.contains(&true);
        if crossing::keeps_outline(strips, frame, |s| &mut s.solid, solid, false)
            && crossing::keeps_outline(strips, frame, |s| &mut s.water, water, drains)
        {
            let mut removed = 0.0;
            crossing::carry(strips, frame, |s| &mut s.solid, solid, |_| {});
            crossing::carry(strips, frame, |s| &mut s.water, water, |gone| removed += gone.number(WATER_MASS));
            self.parts.solid.crossings += solid.len() as u64;
            self.parts.solid.order += 1;
            // As by the plain step, crossings beside a removal are not counted.
            let crossed = if removed > 0.0 { 0 } else { water.len() as u64 };
            self.parts.water.book(crossed, removed);
            for i in 0..self.movers.0.len() {
                let mover = self.movers.0[i];
                self.follow(mover.from);
                mover.to.into_iter().for_each(|to| self.follow(to));
            }
            self.find_surface();
            self.pass::<false>(0.0);
            return Ok(());
        }
        self.sort_all()
    }

    /// The same where the soil has a new outline, or a particle has left it.
    fn sort_all(&mut self) -> Result<(), Fault> {
        let mut whole = self.whole();
        let Parts { solid, water, grid, surface, .. } = &mut whole;
        solid.sort(grid).map_err(|e| Fault {
            place: format!("solid particle {} at {:?} m", solid.ids[e.index], e.x),
            what: "outside the mesh".to_owned(),
        })?;
        surface.follow(solid);
        water.settle(grid, solid).map_err(|(place, what)| Fault { place, what })?;
        self.parts = whole;
        self.settle_in();
        Ok(())
    }

    /// The surcharge at this time, Pa.
    fn surcharge(&self) -> f64 {
        self.parts.surcharge.map_or(0.0, |s| s.at(self.time))
    }

    /// The surcharge, where the scene has one; gravity comes with the equation of motion.
    fn load(&mut self) {
        if self.parts.surcharge.is_none() {
            return;
        }
        let pressure = self.surcharge();
        let Self { parts, frame, strips, tops, pushes, .. } = self;
        for top in 0..tops.len() {
            let (mut first, mut forces, mut corner) = (0, [0.0; 4], 0);
            parts.surface.push_one(top, pressure, &parts.grid, carrier(strips, tops, top), |node, force| {
                if corner == 0 {
                    first = node;
                }
                forces[corner] = force;
                corner += 1;
            });
            pushes[top] = (first, forces);
            for (node, force) in corners(frame, first).into_iter().zip(forces) {
                strips[node / frame.strip].sums[FORCE + 1][node % frame.strip] += force;
            }
        }
    }

    /// Mixture momentum: rho a_s = div(sigma') - grad p + rho g; new nodal velocities.
    fn equation_of_motion(&mut self, dt: f64) {
        let Self { simd, parts, frame, strips, tails, motion, pool, .. } = self;
        let (simd, count, length) = (*simd, frame.count(), frame.strip);
        let Motion { velocity: [vx, vy], change: [cx, cy], acceleration: [ax, ay] } = motion;
        let (gravity, flip) = (parts.gravity, parts.flip);
        let solve = |number: usize, strip: &mut Strip<V>, velocity, change, acceleration| {
            let below = number.checked_sub(1).map(|below| &tails[below]);
            let sums = &mut strip.sums;
            simd.vectorize(EquationOfMotion { simd, sums, below, velocity, change, acceleration, gravity, flip, dt });
        };
        if pool.is_some() {
            fn chunks(field: &mut [f64], length: usize) -> rayon::slice::ChunksMut<'_, f64> {
                field.par_chunks_mut(length)
            }
            let [vx, vy, cx, cy, ax, ay] = [vx, vy, cx, cy, ax, ay].map(|field| chunks(&mut field[..count], length));
            strips.par_iter_mut().enumerate().zip(vx).zip(vy).zip(cx).zip(cy).zip(ax).zip(ay).for_each(
                |(((((((number, strip), vx), vy), cx), cy), ax), ay)| {
                    solve(number, strip, [vx, vy], [cx, cy], [ax, ay]);
                },
            );
        } else {
            let mut fields = [vx, vy, cx, cy, ax, ay].map(|field| field[..count].chunks_mut(length));
            for (number, strip) in strips.iter_mut().enumerate() {
                let [vx, vy, cx, cy, ax, ay] = fields.each_mut().map(|f| f.next().unwrap_or_default());
                solve(number, strip, [vx, vy], [cx, cy], [ax, ay]);
            }
        }
        self.hold();
        if self.damping > 0.0 {
            self.damp(dt); // after the supports: a held node has no speed to lose
        }
        self.accelerated(dt);
        if self.parts.surcharge.is_some() {
            let (frame, motion) = (&self.frame, &self.motion);
            let moving = |node: usize| motion.velocity[1][node] - 0.5 * dt * motion.acceleration[1][node];
            let power = |(first, forces): &(usize, [f64; 4])| {
                let at_corners = corners(frame, *first).into_iter().zip(forces);
                at_corners.map(|(node, force)| force * moving(node)).sum::<f64>()
            };
            self.totals.external_work += dt * self.pushes.iter().map(power).sum::<f64>();
            let pressure = self.surcharge();
            self.totals.load_impulse -= dt * pressure * self.parts.surface.loaded_area();
        }
        if let Some(gravity) = self.parts.gravity {
            self.weigh(&gravity, dt);
        }
    }

    /// Stops the held components and books the impulse of the supports.
    fn hold(&mut self) {
        let Self { parts, frame, strips, motion, totals, .. } = self;
        for d in 0..2 {
            // The nodes come in ascending order.
            let mut strip = 0;
            for node in parts.supports.held(d) {
                while node >= strips[strip].first + frame.strip {
                    strip += 1;
                }
                let mass = strips[strip].sums[MIXTURE_MASS][node - strips[strip].first];
                // What the particles would have received from this node.
                totals.support_impulse[d] -= mass * motion.change[d][node];
                (motion.velocity[d][node], motion.change[d][node], motion.acceleration[d][node]) = (0.0, 0.0, 0.0);
            }
        }
    }

    /// Mass-proportional damping, implicit in the velocity: v (1 + c dt) = v + a dt.
    fn damp(&mut self, dt: f64) {
        let keep = 1.0 / (1.0 + self.damping * dt);
        let Self { frame, strips, motion, totals, .. } = self;
        for strip in strips.iter() {
            for (i, mass) in strip.sums[MIXTURE_MASS][..frame.strip].iter().enumerate() {
                for d in 0..2 {
                    let undamped = motion.velocity[d][strip.first + i];
                    let velocity = keep * undamped;
                    motion.velocity[d][strip.first + i] = velocity;
                    motion.acceleration[d][strip.first + i] -= (undamped - velocity) / dt;
                    motion.change[d][strip.first + i] -= undamped - velocity;
                    let lost = mass * (undamped - velocity);
                    totals.damping_loss += lost * velocity;
                    totals.damping_impulse[d] -= lost;
                }
            }
        }
    }

    /// Books the kinetic energy that the nodes have gained, in as many parts as a machine may have lanes.
    fn accelerated(&mut self, dt: f64) {
        let Self { parts, frame, strips, motion, totals, .. } = self;
        for d in 0..2 {
            let (mut power, mut force) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
            for strip in strips.iter() {
                let nodes = strip.first..strip.first + frame.strip;
                let (masses, _) = strip.sums[MIXTURE_MASS][..frame.strip].as_chunks::<MOST_LANES>();
                let (velocities, _) = motion.velocity[d][nodes.clone()].as_chunks::<MOST_LANES>();
                let (accelerations, _) = motion.acceleration[d][nodes].as_chunks::<MOST_LANES>();
                for ((mass, velocity), acceleration) in masses.iter().zip(velocities).zip(accelerations) {
                    for lane in 0..MOST_LANES {
                        let middle = velocity[lane] - 0.5 * dt * acceleration[lane];
                        power[lane] += mass[lane] * acceleration[lane] * middle;
                        force[lane] += mass[lane] * acceleration[lane];
                    }
                }
            }
            totals.kinetic_gain += dt * power.iter().sum::<f64>();
            totals.momentum_gain[d] += dt * force.iter().sum::<f64>();
            let flip = parts.flip;
            if flip < 1.0 {
                // As `Totals::accelerate`: what held nodes do not give.
                for strip in strips.iter() {
                    for i in (0..frame.strip).filter(|i| strip.sums[SOLID_MASS][*i] > 0.0) {
                        let (node, mass) = (strip.first + i, strip.sums[MIXTURE_MASS][i]);
                        let before = strip.sums[MOMENTUM + d][i] / strip.sums[SOLID_MASS][i];
                        let got = motion.change[d][node] - (1.0 - flip) * before;
                        totals.momentum_gain[d] += mass * (got - dt * motion.acceleration[d][node]);
                    }
                }
            }
        }
    }

    /// Books a step under gravity (m/s2), in as many parts as a machine may have lanes.
    fn weigh(&mut self, gravity: &[f64; 2], dt: f64) {
        let Self { frame, strips, motion, totals, .. } = self;
        for d in (0..2).filter(|d| gravity[*d] != 0.0) {
            let (mut impulse, mut work) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
            for strip in strips.iter() {
                let nodes = strip.first..strip.first + frame.strip;
                let (masses, _) = strip.sums[MIXTURE_MASS][..frame.strip].as_chunks::<MOST_LANES>();
                let (velocities, _) = motion.velocity[d][nodes.clone()].as_chunks::<MOST_LANES>();
                let (accelerations, _) = motion.acceleration[d][nodes].as_chunks::<MOST_LANES>();
                for ((mass, velocity), acceleration) in masses.iter().zip(velocities).zip(accelerations) {
                    for lane in 0..MOST_LANES {
                        let given = dt * mass[lane] * gravity[d];
                        impulse[lane] += given;
                        work[lane] += given * (velocity[lane] - 0.5 * dt * acceleration[lane]);
                    }
                }
            }
            totals.gravity_impulse[d] += impulse.iter().sum::<f64>();
            totals.gravity_work += work.iter().sum::<f64>();
        }
    }

    /// Books the water that leaves and enters through drained faces.
    fn through_drained_faces(&mut self, dt: f64) {
        let Self { parts, frame, motion, pressure, totals, drained, conducts, .. } = self;
        let flow = parts.water.face_flow();
        let gravity = parts.gravity.unwrap_or([0.0; 2]);
        for &DrainedFace { cell, axis, outwards, nodes: [a, b] } in drained.iter() {
            let acceleration = 0.5 * (motion.acceleration[axis][a] + motion.acceleration[axis][b]);
            let face = if outwards < 0.0 { cell } else { cell + [1, frame.row][axis] };
            let conducts = conducts[axis][face];
            let body = flow.weight * (gravity[axis] - flow.inertia * acceleration) / conducts;
            let head = outwards * pressure[0][frame.row + cell] + body;
            let through = dt * flow.area * outwards * conducts * flow.conductance * head;
            totals.water_out += through.max(0.0);
            totals.water_in -= through.min(0.0);
        }
    }

    fn steps(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault> {
        for _ in 0..steps {
            self.step(dt)?;
            *done += 1;
        }
        Ok(())
    }
}

/// Corners of a cell from its first one.
fn corners(frame: &Frame, first: usize) -> [usize; 4] {
    [first, first + 1, first + frame.row, first + frame.row + 1]
}

/// Position (m) and volume (m3) of the particle below a strip of the surface.
fn carrier<V: Simd>(strips: &[Strip<V>], tops: &[[u32; 3]], top: usize) -> ([f64; 2], f64) {
    let [strip, cell, slot] = tops[top].map(|i| i as usize);
    strips[strip].solid.place_and_volume(cell, slot)
}

impl<V: Simd, Sh: Shape, L: Law<4>, W: Resident, const WET: bool> Model for ExplicitLanes<V, Sh, L, W, WET> {
    fn advance(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault> {
        match self.pool.clone() {
            Some(pool) => pool.install(|| self.steps(dt, steps, done)),
            None => self.steps(dt, steps, done),
        }
    }

    fn enter_stage(&mut self, stage: &Stage, _: &[f64]) -> Result<(), Fault> {
        self.damping = stage.damping;
        let mut whole = self.whole();
        whole.water.set_drained(&whole.grid, &whole.solid, stage.drained);
        self.parts = whole;
        self.settle_in();
        Ok(())
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn observe(&self) -> Observation {
        self.whole().observe::<PlaneStrain>(self.time)
    }

    fn ledger(&self) -> Ledger {
        self.whole().ledger::<PlaneStrain>(&self.totals)
    }

    fn pore_pressure(&self) -> [f64; 3] {
        let (mut sum, mut volume, mut low, mut high) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
        for strip in &self.strips {
            for cell in 0..self.frame.strip {
                let v = strip.volume(cell);
                if v > 0.0 {
                    let pressure = self.pressure[0][self.frame.row + strip.first + cell];
                    sum += pressure * v;
                    volume += v;
                    low = low.min(pressure);
                    high = high.max(pressure);
                }
            }
        }
        [sum / volume, low, high]
    }

    fn bytes(&self) -> usize {
        let faces = self.pressure.iter().chain(&self.conducts).map(Vec::capacity).sum::<usize>() * size_of::<f64>();
        let movers =
            self.movers.0.capacity() * size_of::<Mover<SOLID>>() + self.movers.1.capacity() * size_of::<Mover<WATER>>();
        let tails = self.tails.len() * SUMS * (self.frame.row + 1) * size_of::<f64>();
        let strips = self.strips.iter().map(Strip::bytes).sum::<usize>() + tails;
        strips + self.motion.bytes() + faces + movers + self.parts.solid.bytes() + self.parts.water.bytes()
    }

    fn solid_count(&self) -> usize {
        self.solid_count
    }

    fn keep(&mut self, keeper: &mut Keeper) {
        let mut whole = self.whole();
        whole.keep::<PlaneStrain>(keeper);
        keeper.f64(&mut self.damping);
        keeper.f64(&mut self.time);
        self.totals.keep(keeper);
        if keeper.is_reading() {
            self.solid_count = whole.solid.points.len();
            self.parts = whole;
            self.settle_in();
        }
    }

    fn stages(&self) -> &'static [&'static str] {
        &["loads", "equation of motion", "outflow", "particles to mesh alone", "Darcy flow, mesh to particles to mesh"]
    }

    fn do_stage(&mut self, stage: usize, dt: f64) {
        let pool = self.pool.clone();
        let mut stage = || match stage {
            0 => self.load(),
            1 => self.equation_of_motion(dt),
            2 => self.through_drained_faces(dt),
            3 => self.pass::<false>(dt),
            _ => self.pass::<true>(dt),
        };
        match pool {
            Some(pool) => pool.install(stage),
            None => stage(),
        }
    }
}

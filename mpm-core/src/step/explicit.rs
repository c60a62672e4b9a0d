//! The paper's explicit step (Figure 1), as many cells at once as a SIMD vector holds, on as many threads as it is given.
//!
//! Cells lie side by side in vectors, a layer is kept in blocks of one particle of each, and one pass of the [`kernel`](super::kernel)
//! per step takes every particle from one grid to the next. The unit of work is a strip of cells, whose size does not depend
//! on the threads: nor do the bits.

mod extras;
mod grains;
mod grid;
mod model;
mod order;
mod pass;

use std::sync::Arc;

use rayon::ThreadPool;
use rayon::prelude::*;

use self::grains::Grains;
use super::body::Body;
use super::conditions::{Condition, Friction, Soil, Visit};
use super::domains::{Domains, shared};
use super::faces::Faces;
use super::free_water::FreeWater;
use super::kernel::equation::EquationOfMotion;
use super::kernel::{Common, InPores, Kept, Kernel, MOST_REACHED, Rare, Scheme};
use super::nodal::NodalFlow;
use super::pressure::{Driving, PressureSystem};
use super::store::nodes::{MOMENTUM, SOLID_MASS};
use super::store::{Frame, Motion, Movers, Nodes, Strip, StripSums, crossing};
use super::surface::Tops;
use super::{Fault, Model, Work};
use crate::checkpoint::{Archive, RestoreError, archive};
use crate::constitutive::{Law, Materials, STATES, State};
use crate::observe::{BalanceTerms, Observation, Places, Push, SolidState, Totals, WaterParticle};
use crate::particles::{Layer, Point, SolidPoint, WaterPoint};
use crate::scene::{SolidSide, Stage};
use crate::water::pores::Pores;
use crate::water::{AdvectedWater, FaceFlow};

/// Room for one in so many particles to change its cell in a step, before more is asked for.
const MOVERS: usize = 16;

/// The explicit integrator.
pub struct Explicit<const D: usize> {
    kernel: Box<dyn Kernel<D>>,
    /// The functions of the kernel.
    scheme: Scheme,
    /// Everything but the particles, which are in the strips.
    body: Body<D>,
    strips: Vec<Strip<D>>,
    nodes: Nodes<D>,
    /// Accelerations at the nodes of the mesh, where those of the functions are others.
    of_mesh: [Vec<f64>; 2],
    /// Pore pressure of the cells now and at the next step, Pa, from [`Frame::pad`] before the first cell on.
    pressure: [Vec<f64>; 2],
    /// What water passes.
    faces: Faces<D>,
    /// Flow with velocities at the nodes, where that is asked for.
    nodal: Option<Box<NodalFlow<D>>>,
    /// Water with a free surface.
    free: Option<Box<FreeWater<D>>>,
    /// Whether the soil feels other pressures than those that were gathered.
    is_stale: bool,
    /// Where the particles were when displacement and strain began to be counted, m, by their numbers.
    origin: Option<Vec<[f64; D]>>,
    /// What cells share of particles that are boxes, where they are.
    domains: Option<Box<Domains<D>>>,
    /// Pressures of the end of the step, where they are solved for.
    solver: Option<Box<PressureSystem<D>>>,
    /// See [`Common::soil`].
    soil: Vec<f64>,
    /// Particles below the surface, and behind faces that bear loads.
    tops: Tops<D>,
    loaded: Tops<D>,
    /// What acts on the nodes beside load and weight, in order.
    conditions: Vec<Box<dyn Condition<D>>>,
    /// What particles keep beside their records, so many numbers by their number.
    kept: (usize, Vec<f64>),
    places: Kept,
    /// Solid and water particles on their way to another cell.
    movers: [Movers; 2],
    /// Nodes with the velocities that strain the soil, where they are others.
    mapped: Option<Box<Nodes<D>>>,
    solid_count: usize,
    damping: f64,
    /// How the sides hold the soil in this stage, if not as in the scene.
    sides: Option<[SolidSide; 4]>,
    time: f64,
    totals: Totals<D>,
    pool: Option<Arc<ThreadPool>>,
}

impl<const D: usize> Explicit<D> {
    /// A run at t = 0, on the threads of a pool if there is one.
    pub fn new(
        (kernel, pool): (Box<dyn Kernel<D>>, Option<Arc<ThreadPool>>),
        mut body: Body<D>,
        conditions: Vec<Box<dyn Condition<D>>>,
        (affine, mapped): (bool, bool),
    ) -> Self {
        body.surface.follow(&body.solid);
        body.filled.follow_layer(&body.grid, &body.surface, &body.solid);
        let scheme = kernel.scheme();
        let frame = Frame::new(&body.grid, scheme.reach, scheme.before, body.period.is_some() && body.water.is_some());
        let wet = body.water.is_some();
        let several = wet
            && (body.materials.soils.conduct_differently() || body.water.as_ref().is_some_and(|w| w.cuts.are_known()));
        let cells = |wanted: bool| vec![0.0; if wanted { frame.length() + 2 * frame.pad() } else { 0 }];
        let both = |wanted: bool| [(); 2].map(|()| cells(wanted));
        let solid_count = body.solid.points.len();
        let movers = [true, wet].map(|any| Movers::new(if any { solid_count / MOVERS } else { 0 }, 16));
        let (more, kept, places) = order::first_kept(&body, affine);
        let mut run = Self {
            strips: (0..frame.strips).map(|number| Strip::new(&frame, number, kernel.lanes())).collect(),
            kernel,
            scheme,
            nodes: Nodes::new(frame),
            of_mesh: both(wet && !scheme.nodal),
            pressure: both(true),
            faces: Faces::new(frame, several),
            nodal: None,
            free: None,
            is_stale: false,
            origin: None,
            domains: body.contiguous.then(|| Box::new(Domains::new(frame))),
            solver: None,
            soil: cells(true),
            tops: Tops::new(body.surface.strips().iter().map(|strip| strip.id).collect()),
            loaded: Tops::new(body.loads.pieces.iter().map(|piece| piece.id).collect()),
            conditions,
            kept: (more, kept),
            places,
            mapped: mapped.then(|| Box::new(Nodes::new(frame))),
            movers,
            solid_count,
            body,
            damping: 0.0,
            sides: None,
            time: 0.0,
            totals: Totals::default(),
            pool,
        };
        for strip in run.strips.iter_mut().filter(|_| run.domains.is_some()) {
            strip.shared = vec![0.0; shared(D) * frame.strip];
        }
        run.settle_in();
        // What the cells hold is known once their soil has been sampled.
        run.begin_balances();
        run
    }

    /// One step of Figure 1, from the gathered particles to the gathered particles.
    fn step(&mut self, dt: f64) -> Result<(), Fault> {
        if self.is_stale {
            self.pass(false, 0.0);
        }
        if !self.faces.by_porosity.is_empty() {
            self.faces.follow_porosity(&self.strips);
            self.faces.note_reach(&self.body.filled, &self.body.grid);
        }
        self.share_boxes();
        self.load();
        self.look_outside(dt);
        self.solve_pressures(dt)?;
        self.equation_of_motion(dt)?;
        self.darcy_flow(dt);
        if self.mapped.is_some() {
            self.map_back();
        }
        if let Some(domains) = &mut self.domains {
            domains.find_rates(&self.strips, &self.mapped.as_deref().unwrap_or(&self.nodes).motion);
        }
        self.find_surface_ahead(dt);
        self.pass(true, dt);
        self.note_accelerations();
        self.faces.note_reach(&self.body.filled, &self.body.grid);
        self.book(dt);
        if !self.strips.iter().all(|strip| strip.sums.stays) {
            self.sort()?;
        }
        if self.strips.iter().any(|strip| strip.sums.changed) {
            self.note_open_cells();
        }
        if self.advected().is_some_and(|free| free.is_behind(&self.body.grid)) {
            self.carry_water();
        }
        self.time += dt;
        Ok(())
    }

    /// Records what the pass has added up.
    fn book(&mut self, dt: f64) {
        if self.nodal.is_some() {
            self.strips.iter().for_each(|strip| self.totals.flowed.join(&strip.sums.flowed));
            return;
        }
        let Self { body: Body { water, gravity, .. }, strips, totals, faces, pressure, nodes, .. } = self;
        let area = water.as_ref().map_or(0.0, |water| water.flow.area);
        if let (Some(water), true) = (water, faces.periodic) {
            // The pass has seen the faces of the seam from both sides. Pressures are still those of its start.
            let drive = (gravity.map_or(0.0, |g| g[0]), &nodes.motion.acceleration);
            let [dissipated, by_body] = faces.over_seam(&water.flow, &pressure[1], drive);
            totals.darcy_dissipation -= dt * area * dissipated;
            totals.flow_body_work -= dt * area * by_body;
        }
        for strip in strips.iter() {
            totals.darcy_dissipation += dt * area * strip.sums.rates[0];
            totals.flow_body_work += dt * area * strip.sums.rates[1];
            totals.flowed.join(&strip.sums.flowed);
        }
    }

    /// The loads, where the scene has some, and what the conditions do before anything moves; gravity comes with the equation of motion.
    fn load(&mut self) {
        let Self { body, strips, nodes, tops, kernel, .. } = self;
        if body.surcharge.is_some() {
            let pressure = body.pressure_at(self.time);
            let frame = nodes.frame;
            let push = |node: usize, newton: f64| nodes.push(node, D - 1, newton);
            tops.each_push(kernel.as_ref(), (&body.surface, &body.grid, -pressure), strips, &frame, push);
        }
        let Self { kernel, scheme, body, strips, nodes, conditions, pressure, time, free, loaded, .. } = self;
        let (frame, pressure, time) = (nodes.frame, &pressure[0], *time);
        let loads = (&body.loads, &body.grid, time);
        let kernel = kernel.as_ref();
        loaded.each_force(kernel, loads, strips, &frame, |node, axis, newton| nodes.push(node, axis, newton));
        let water = free.as_ref().map(|free| &free.carried);
        let soil = Grains { kernel, scheme, body, water, strips, frame, pressure, time };
        for condition in conditions {
            condition.gathered(nodes, &soil);
        }
    }

    /// Looks at the water that stands before the soil: that of the end of the step where pressures are.
    fn look_outside(&mut self, dt: f64) {
        if let Some(free) = &mut self.free {
            free.carried.look_outside(&self.body.grid, self.time);
        }
        let Self { body: Body { water: Some(water), .. }, faces, solver, time, .. } = self else { return };
        let changed = faces.look_outside(water, if solver.is_some() { *time + dt } else { *time });
        if let (Some(solver), true) = (solver, changed) {
            solver.forget();
        }
    }

    /// Mixture momentum: rho a_s = div(sigma') - grad p + rho g; new nodal velocities.
    fn equation_of_motion(&mut self, dt: f64) -> Result<(), Fault> {
        self.accelerate(dt);
        self.constrain(dt)?;
        self.book_motion(dt);
        self.nodes.reached.settle();
        Ok(())
    }

    /// Accelerations that drive the flow, and what passes the drained faces.
    fn darcy_flow(&mut self, dt: f64) {
        if let (Some(nodal), Some(water)) = (&mut self.nodal, &self.body.water) {
            let gravity = self.body.gravity.unwrap_or([0.0; D]);
            let run = (&self.strips[..], &self.nodes, water, &self.faces.grains[..]);
            return nodal.flow(run, &gravity, self.faces.outline.iter().copied(), &mut self.totals, dt);
        }
        let Self { kernel, scheme, body, nodes, of_mesh, pressure, totals, faces, solver, strips, .. } = self;
        let Some(water) = &body.water else { return };
        if solver.is_none() {
            let [x, y] = &mut nodes.motion.acceleration;
            body.filled.calm(&body.grid, |lower, upper, share| {
                for a in [&mut *x, &mut *y] {
                    a[upper] = a[lower] + share * (a[upper] - a[lower]);
                }
            });
            if !scheme.nodal {
                kernel.accelerations_of_mesh(nodes, of_mesh);
            }
        }
        let acceleration = if solver.is_some() || !scheme.nodal { of_mesh } else { &nodes.motion.acceleration };
        let drive = (&body.gravity.unwrap_or([0.0; D]), acceleration);
        faces.drain(water, &pressure[0], drive, totals, dt);
        if !faces.outflow.is_empty() {
            let strips = solver.is_none().then_some(&strips[..]);
            faces.let_out(&water.flow, (&pressure[0], strips), drive, totals, dt);
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

#[cfg(test)]
mod tests;

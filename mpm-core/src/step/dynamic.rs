//! The paper's explicit step (Figure 1), so many cells at once as the machine has lanes, on as many threads as it is given.
//!
//! Cells lie side by side in vectors, a layer is kept in blocks of one particle of each, and one pass of the [`kernel`](super::kernel)
//! per step takes every particle from one grid to the next. The unit of work is a strip of cells, whose size does not depend
//! on the threads: nor do the bits.
//!
//! `step/explicit.rs` is the same step written plainly, for what few scenes have. On a mesh of one strip in plane strain particles get the same bits from
//! both; where strips meet, sums at their nodes have another order, and settlements and pressures may differ by 1e-7 of
//! themselves once particles have crossed cells.

use std::sync::Arc;

use pulp::Simd;
use rayon::ThreadPool;
use rayon::prelude::*;

use super::body::Body;
use super::conditions::{Condition, Soil, Visit};
use super::kernel::equation::EquationOfMotion;
use super::kernel::{Common, Functions, InPores, Kept, MOST_REACHED, MapBack, Pass};
use super::store::blocks::Record;
use super::store::nodes::{MOMENTUM, SOLID_MASS};
use super::store::{Frame, Motion, Movers, Nodes, Strip, StripSums, crossing};
use super::surface::Tops;
use super::{Fault, Model};
use crate::keep::Keeper;
use crate::observe::{Ledger, Observation, Places, SolidState, Totals};
use crate::particles::{Layer, SolidPoint, WaterPoint};
use crate::scene::Stage;
use crate::water::{DRAINED_SURFACE, FaceFlow};

/// A face that lets water out.
#[derive(Debug, Clone, Copy)]
struct DrainedFace {
    cell: usize,
    axis: usize,
    outwards: f64,
    /// The face, numbered by the cell above it, and its nodes.
    face: usize,
    nodes: [usize; 2],
}

/// Room for one in so many particles to change its cell in a step, before more is asked for.
const MOVERS: usize = 16;

/// The explicit integrator. V: the machine's lanes, F: functions.
pub struct Dynamic<V: Simd, F: Functions<D>, const D: usize> {
    simd: V,
    functions: F,
    /// Everything but the particles, which are in the strips.
    body: Body<D>,
    strips: Vec<Strip<V, D>>,
    nodes: Nodes<D>,
    /// Accelerations at the nodes of the mesh, where those of the functions are others.
    of_mesh: [Vec<f64>; 2],
    /// Pore pressure of the cells now and at the next step, Pa, from [`Frame::pad`] before the first cell on.
    pressure: [Vec<f64>; 2],
    /// See [`Common::conducts`].
    conducts: [Vec<f64>; 2],
    /// See [`Common::ratio`]; empty where it is one.
    ratio: [Vec<f64>; 2],
    drained: Vec<DrainedFace>,
    /// See [`Common::soil`].
    soil: Vec<f64>,
    /// Particles below the surface.
    tops: Tops<D>,
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
    time: f64,
    totals: Totals<D>,
    pool: Option<Arc<ThreadPool>>,
}

/// The soil of a run, as conditions see it.
struct Grains<'a, V: Simd, F, const D: usize> {
    functions: &'a F,
    strips: &'a [Strip<V, D>],
    frame: Frame<D>,
    time: f64,
}

impl<V: Simd, F: Functions<D>, const D: usize> Soil<D> for Grains<'_, V, F, D> {
    fn time(&self) -> f64 {
        self.time
    }

    fn each_share(&self, visit: &mut Visit<D>) {
        let reached = F::REACH.pow(D as u32);
        let mut shares = [(0, 0.0); MOST_REACHED];
        for strip in self.strips {
            for cell in 0..self.frame.strip {
                let position = self.frame.position(strip.first + cell);
                for slot in 0..strip.solid.count(cell) {
                    let point: SolidPoint<D, 4> = strip.solid.particle(cell, slot);
                    let xi = std::array::from_fn(|d| point.x[d] * self.frame.inverse_size - position[d] as f64);
                    let values = self.functions.values(&position, &self.frame.cells, &xi);
                    for (a, value) in values.into_iter().enumerate().take(reached) {
                        shares[a] = (strip.first + cell + self.frame.offset(a), value);
                    }
                    visit(&point, &shares[..reached]);
                }
            }
        }
    }
}

impl<V: Simd, F: Functions<D>, const D: usize> Dynamic<V, F, D> {
    /// A run at t = 0, on the threads of a pool if there is one.
    pub fn new(
        (simd, pool): (V, Option<Arc<ThreadPool>>),
        functions: F,
        mut body: Body<D>,
        conditions: Vec<Box<dyn Condition<D>>>,
        (affine, mapped): (bool, bool),
    ) -> Self {
        body.surface.follow(&body.solid);
        body.filled.follow_layer(&body.grid, &body.surface, &body.solid);
        let mut totals = Totals::default();
        totals.start(&body.cell_values());
        totals.flowed = body.flowed_at_first();
        let frame = Frame::new(&body.grid, F::REACH, F::BEFORE);
        let wet = body.water.is_some();
        let layered = body.water.as_ref().is_some_and(|water| water.is_layered());
        let cells = |wanted: bool| vec![0.0; if wanted { frame.length() + 2 * frame.pad() } else { 0 }];
        let faces = |wanted: bool| [(); 2].map(|()| cells(wanted));
        let solid_count = body.solid.points.len();
        let movers = [true, wet].map(|any| Movers::new(if any { solid_count / MOVERS } else { 0 }, 16));
        let mut run = Self {
            simd,
            functions,
            strips: (0..frame.strips).map(|number| Strip::new(&frame, number)).collect(),
            nodes: Nodes::new(frame),
            of_mesh: faces(wet && !F::NODAL),
            pressure: faces(true),
            conducts: faces(true),
            ratio: faces(layered),
            drained: Vec::new(),
            soil: cells(true),
            tops: Tops::new(body.surface.strips().len()),
            conditions,
            kept: if affine { (D * D, vec![0.0; D * D * solid_count]) } else { (0, Vec::new()) },
            places: Kept { affine: affine.then_some(SolidPoint::<D, 4>::COUNT), strain: None },
            mapped: mapped.then(|| Box::new(Nodes::new(frame))),
            movers,
            solid_count,
            body,
            damping: 0.0,
            time: 0.0,
            totals,
            pool,
        };
        run.settle_in();
        run
    }

    /// Takes the particles of the body into the strips and gathers them.
    fn settle_in(&mut self) {
        let Self { body, nodes: Nodes { frame, .. }, strips, kept: (more, kept), .. } = self;
        for strip in strips.iter_mut() {
            strip.solid.fill(frame, strip.first, &body.solid, (*more, kept));
            if let Some(water) = &body.water {
                strip.water.fill(frame, strip.first, &water.layer, (0, &[]));
            }
        }
        self.open_faces();
        // What is left of the layers are their cells and counts.
        let Body { solid, water, .. } = &mut self.body;
        *solid = std::mem::take(solid).without_points();
        if let Some(water) = water {
            water.layer = std::mem::take(&mut water.layer).without_points();
        }
        for cell in 0..self.nodes.frame.count() {
            self.tops.follow(&self.body.surface, &self.strips, &self.nodes.frame, cell);
        }
        self.find_surface();
        self.pass::<false>(0.0);
    }

    /// Finds the surface from the particles where they are.
    fn find_surface(&mut self) {
        let Self { body, strips, tops, nodes, soil, .. } = self;
        if body.filled.is_known() {
            body.filled.follow(&body.grid, &body.surface, |top| tops.carrier(strips, top));
            Tops::note_soil(&body.filled, &nodes.frame, soil, true);
            self.note_reach();
        }
    }

    /// Finds it where the particles will be at the end of a step, as the kernel moves them.
    fn find_surface_ahead(&mut self, dt: f64) {
        let Self { functions, body, strips, tops, nodes, soil, .. } = self;
        if body.filled.is_known() {
            tops.look_ahead(functions, strips, nodes, dt);
            let moved = body.filled.follow(&body.grid, &body.surface, |top| tops.ahead(top));
            Tops::note_soil(&body.filled, &nodes.frame, soil, moved);
        }
    }

    /// Finds which faces conduct.
    fn open_faces(&mut self) {
        let Self {
            body: Body { grid, solid, water, .. }, nodes: Nodes { frame, .. }, conducts, ratio, drained, ..
        } = self;
        let Some(water) = water else { return };
        conducts.iter_mut().chain(&mut *ratio).for_each(|faces| faces.fill(0.0));
        water.faces(grid, solid, |axis, position, [conducted, reach]| {
            conducts[axis][frame.number(&position)] = conducted;
            if let Some(ratio) = ratio[axis].get_mut(frame.number(&position)) {
                *ratio = conducted / reach;
            }
        });
        drained.clear();
        for face in water.exposed.faces.iter().filter(|f| water.drained[f.side as usize]) {
            let (axis, position) = (face.axis as usize, grid.cell_position(face.cell as usize));
            let outwards = if face.upper { 1.0 } else { -1.0 };
            let cell = frame.number(&position);
            let first = cell + if face.upper { frame.stride[axis] } else { 0 };
            let other = if D == 1 { 0 } else { frame.stride[D - 1 - axis] };
            drained.push(DrainedFace { cell, axis, outwards, face: first, nodes: [first, first + other] });
        }
    }

    /// Distances between the cells that hold the surface, it, and the cells below.
    fn note_reach(&mut self) {
        let Self { body: Body { filled, grid, .. }, nodes: Nodes { frame, .. }, conducts, ratio, drained, .. } = self;
        let mut note = |face: usize, reach: f64| {
            if conducts[D - 1][face] > 0.0 {
                conducts[D - 1][face] = ratio[D - 1].get(face).map_or(reach, |ratio| ratio * reach);
            }
        };
        for top in filled.tops() {
            note(frame.number(&grid.cell_position(top.cell as usize)), 2.0 / (1.0 + top.fill));
        }
        for face in drained.iter().filter(|face| face.axis + 1 == D && face.outwards > 0.0) {
            let position = frame.position(face.cell);
            let top = filled.tops().get(if D == 1 { 0 } else { position[0] });
            if let Some(top) = top.filter(|top| grid.cell_position(top.cell as usize) == position) {
                note(face.face, DRAINED_SURFACE / top.fill);
            }
        }
    }

    /// One pass over all particles, on one thread or several.
    fn pass<const MOVE: bool>(&mut self, dt: f64) {
        let Self { simd, functions, body, strips, nodes, of_mesh, pressure: [old, new], conducts, ratio, soil, .. } =
            self;
        let Nodes { frame, sums, motion, .. } = nodes;
        let mapped = self.mapped.as_deref_mut();
        let water =
            if body.water.is_some() { InPores::Particles { relative: None, rise: None } } else { InPores::None };
        let common = &Common {
            frame,
            functions: *functions,
            motion,
            mapped: mapped.as_ref().map(|mapped| &mapped.motion.velocity),
            acceleration: if F::NODAL { &motion.acceleration } else { of_mesh },
            water,
            pressure: old,
            conducts,
            ratio: (!ratio[0].is_empty()).then_some(&*ratio),
            soil,
            materials: &body.materials,
            plastic: body.materials.are_plastic(),
            flow: body.water.as_ref().map_or_else(FaceFlow::default, |water| water.flow),
            gravity: body.gravity.unwrap_or([0.0; D]),
            flip: body.flip,
            apart: body.apart,
            kept: self.places,
            coupled: false,
            dt,
        };
        let simd = *simd;
        let sweep = |strip: &mut Strip<V, D>, sums: &mut StripSums, pressure: &mut [f64]| {
            simd.vectorize(Pass::<V, F, D, MOVE> { simd, strip, sums, pressure, coupling: &mut [], common });
        };
        let cells = &mut new[frame.pad()..][..frame.count()];
        if self.pool.is_some() {
            let cells = cells.par_chunks_mut(frame.strip);
            strips.par_iter_mut().zip(sums).zip(cells).for_each(|((strip, sums), cells)| sweep(strip, sums, cells));
        } else {
            let cells = cells.chunks_mut(frame.strip);
            strips.iter_mut().zip(sums).zip(cells).for_each(|((strip, sums), cells)| sweep(strip, sums, cells));
        }
        self.pressure.swap(0, 1);
        self.nodes.merge();
    }

    /// One step of Figure 1, from the gathered particles to the gathered particles.
    fn step(&mut self, dt: f64) -> Result<(), Fault> {
        self.load();
        self.equation_of_motion(dt)?;
        self.darcy_flow(dt);
        if self.mapped.is_some() {
            self.map_back();
        }
        self.find_surface_ahead(dt);
        self.pass::<true>(dt);
        self.note_reach();
        self.book(dt);
        if !self.strips.iter().all(|strip| strip.stays) {
            self.sort()?;
        }
        self.time += dt;
        Ok(())
    }

    /// Finds the velocities that strain the soil, where they are not those of the nodes.
    fn map_back(&mut self) {
        let Self { simd, functions, body, strips, nodes, mapped: Some(mapped), soil, places, .. } = self else {
            return;
        };
        let Nodes { frame, motion, .. } = &*nodes;
        let common = &Common {
            frame,
            functions: *functions,
            motion,
            mapped: None,
            acceleration: &motion.acceleration,
            water: InPores::None,
            pressure: &[],
            conducts: &motion.acceleration,
            ratio: None,
            soil,
            materials: &body.materials,
            plastic: false,
            flow: FaceFlow::default(),
            gravity: [0.0; D],
            flip: body.flip,
            apart: 0.0,
            kept: *places,
            coupled: false,
            dt: 0.0,
        };
        for (strip, sums) in strips.iter().zip(&mut mapped.sums) {
            simd.vectorize(MapBack { simd: *simd, strip, sums, common });
        }
        mapped.merge();
        for node in 0..frame.count() {
            let mass = mapped.sum(SOLID_MASS, node);
            let inverse = if mass > 0.0 { 1.0 / mass } else { 0.0 };
            for d in 0..D {
                mapped.motion.velocity[d][node] = mapped.sum(MOMENTUM + d, node) * inverse;
            }
        }
        for condition in &self.conditions {
            condition.hold(mapped);
        }
    }

    /// Books what the pass has added up.
    fn book(&mut self, dt: f64) {
        let Self { body: Body { water, .. }, strips, totals, .. } = self;
        let area = water.as_ref().map_or(0.0, |water| water.flow.area);
        for strip in strips.iter() {
            totals.darcy_dissipation += dt * area * strip.rates[0];
            totals.flow_body_work += dt * area * strip.rates[1];
            totals.flowed.join(&strip.flowed);
        }
    }

    /// Restores the order of the cells after particles have left theirs.
    fn sort(&mut self) -> Result<(), Fault> {
        let Self { nodes: Nodes { frame, .. }, strips, movers: [solid, water], .. } = self;
        crossing::find(strips, frame, |s| &mut s.solid, solid);
        crossing::find(strips, frame, |s| &mut s.water, water);
        let drains = self.body.water.as_ref().is_some_and(|water| water.drained.contains(&true));
        if crossing::keeps_outline(strips, frame, |s| &mut s.solid, solid, false)
            && crossing::keeps_outline(strips, frame, |s| &mut s.water, water, drains)
        {
            let mut removed = 0.0;
            let mass = 2 * D;
            crossing::carry(strips, frame, |s| &mut s.solid, solid, |_| {});
            crossing::carry(strips, frame, |s| &mut s.water, water, |gone| removed += gone[mass]);
            self.body.solid.crossings += solid.list.len() as u64;
            self.body.solid.order += 1;
            if let Some(own) = &mut self.body.water {
                // As where the outline changes, crossings beside a removal are not counted.
                own.layer.crossings += if removed > 0.0 { 0 } else { water.list.len() as u64 };
                own.removed_mass += removed;
            }
            for i in 0..self.movers[0].list.len() {
                let mover = self.movers[0].list[i];
                for cell in [Some(mover.from), mover.to].into_iter().flatten() {
                    self.tops.follow(&self.body.surface, &self.strips, &self.nodes.frame, cell);
                }
            }
            self.find_surface();
            self.pass::<false>(0.0);
            return self.look_at_crossings();
        }
        self.sort_all()?;
        self.look_at_crossings()
    }

    /// The same where the soil has a new outline, or a particle has left it.
    fn sort_all(&mut self) -> Result<(), Fault> {
        let mut whole = self.whole();
        let Body { solid, water, grid, surface, .. } = &mut whole;
        solid.sort(grid).map_err(|e| Fault {
            place: format!("solid particle {} at {:?} m", solid.ids[e.index], e.x),
            what: "outside the mesh".to_owned(),
        })?;
        surface.follow(solid);
        if let Some(water) = water {
            water.settle(grid, solid).map_err(|(place, what)| Fault { place, what })?;
        }
        self.kept.1 = self.kept_now();
        self.body = whole;
        self.settle_in();
        Ok(())
    }

    /// Stops before the noise of crossings is as large as the stress.
    #[cold]
    fn look_at_crossings(&self) -> Result<(), Fault> {
        let Body { solid, most_crossings, .. } = &self.body;
        if self.damping > 0.0 || solid.crossings <= *most_crossings {
            return Ok(());
        }
        let each = solid.crossings / self.solid_count as u64;
        let what = format!(
            "its particles have crossed {each} cells each: the stress of linear functions is then noise by a tenth or more \
             and grows; \"bspline2\", \"gimp\", damping or flip < 1 keeps it down, --force goes on"
        );
        Err(Fault { place: "the soil".to_owned(), what })
    }

    /// What the particles keep beside their records now, by their numbers.
    fn kept_now(&self) -> Vec<f64> {
        let (more, mut kept) = (self.kept.0, self.kept.1.clone());
        for strip in self.strips.iter().filter(|_| more > 0) {
            for cell in 0..self.nodes.frame.strip {
                for slot in 0..strip.solid.count(cell) {
                    let first = more * strip.solid.id(cell, slot) as usize;
                    for i in 0..more {
                        kept[first + i] = strip.solid.number(cell, slot, SolidPoint::<D, 4>::COUNT + i);
                    }
                }
            }
        }
        kept
    }

    /// The body with its particles.
    fn whole(&self) -> Body<D> {
        let mut body = self.body.clone();
        let frame = &self.nodes.frame;
        let (mut points, mut ids, mut start) = (Vec::with_capacity(self.solid_count), Vec::new(), vec![0]);
        let (mut drops, mut drop_ids, mut drop_start) = (Vec::<WaterPoint<D>>::new(), Vec::new(), vec![0]);
        for (_, position) in body.grid.walk() {
            let number = frame.number(&position);
            let (strip, cell) = (&self.strips[number / frame.strip], number % frame.strip);
            strip.solid.append(cell, &mut points, &mut ids);
            start.push(points.len() as u32);
            strip.water.append(cell, &mut drops, &mut drop_ids);
            drop_start.push(drops.len() as u32);
        }
        body.solid = Layer::in_order(&body.solid, points, ids, start);
        if let Some(water) = &mut body.water {
            water.layer = Layer::in_order(&water.layer, drops, drop_ids, drop_start);
        }
        body.surface.follow(&body.solid);
        body
    }

    /// The surcharge, where the scene has one, and what the conditions do before anything moves; gravity comes with the equation of motion.
    fn load(&mut self) {
        let Self { body, strips, nodes, tops, functions, .. } = self;
        if body.surcharge.is_some() {
            let pressure = body.pressure_at(self.time);
            let frame = nodes.frame;
            let push = |node: usize, newton: f64| nodes.push(node, D - 1, newton);
            tops.each_push(functions, (&body.surface, &body.grid, -pressure), strips, &frame, push);
        }
        let Self { functions, strips, nodes, conditions, time, .. } = self;
        let soil = Grains { functions, strips, frame: nodes.frame, time: *time };
        for condition in conditions {
            condition.gathered(nodes, &soil);
        }
    }

    /// Mixture momentum: rho a_s = div(sigma') - grad p + rho g; new nodal velocities.
    fn equation_of_motion(&mut self, dt: f64) -> Result<(), Fault> {
        let Self { simd, body, nodes, pool, .. } = self;
        let Nodes { frame, sums, motion, .. } = nodes;
        let (simd, count, length) = (*simd, frame.count(), frame.strip);
        let Motion { velocity: [vx, vy], change: [cx, cy], acceleration: [ax, ay] } = motion;
        let (gravity, flip) = (body.gravity, body.flip);
        let solve = |sums: &StripSums, velocity, change, acceleration| {
            simd.vectorize(EquationOfMotion { simd, sums, velocity, change, acceleration, gravity, flip, dt });
        };
        if pool.is_some() {
            fn chunks(field: &mut [f64], length: usize) -> rayon::slice::ChunksMut<'_, f64> {
                field.par_chunks_mut(length)
            }
            let [vx, vy, cx, cy, ax, ay] = [vx, vy, cx, cy, ax, ay].map(|field| chunks(&mut field[..count], length));
            sums.par_iter()
                .zip(vx)
                .zip(vy)
                .zip(cx)
                .zip(cy)
                .zip(ax)
                .zip(ay)
                .for_each(|((((((sums, vx), vy), cx), cy), ax), ay)| solve(sums, [vx, vy], [cx, cy], [ax, ay]));
        } else {
            let mut fields = [vx, vy, cx, cy, ax, ay].map(|field| field[..count].chunks_mut(length));
            for sums in sums.iter() {
                let [vx, vy, cx, cy, ax, ay] = fields.each_mut().map(|f| f.next().unwrap_or_default());
                solve(sums, [vx, vy], [cx, cy], [ax, ay]);
            }
        }
        for condition in &mut self.conditions {
            condition.accelerated(&mut self.nodes, &mut self.totals, dt)?;
        }
        self.book_motion(dt);
        Ok(())
    }

    /// Books what the nodes have gained, and the work of load and weight.
    fn book_motion(&mut self, dt: f64) {
        let Self { body, strips, nodes, tops, functions, totals, .. } = self;
        totals.book_motion(nodes, body.flip, dt);
        if body.surcharge.is_some() {
            let pressure = body.pressure_at(self.time);
            let mut power = 0.0;
            let frame = nodes.frame;
            tops.each_push(functions, (&body.surface, &body.grid, -pressure), strips, &frame, |node, newton| {
                power += newton * nodes.velocity_before(node, D - 1, 0.5 * dt);
            });
            totals.external_work += dt * power;
            totals.load_impulse -= dt * pressure * body.surface.loaded_area();
        }
        if let Some(gravity) = body.gravity {
            totals.book_weight(nodes, &gravity, dt);
        }
        for condition in &self.conditions {
            condition.book(nodes, totals, dt);
        }
    }

    /// Accelerations that drive the flow, and what passes the drained faces.
    fn darcy_flow(&mut self, dt: f64) {
        let Self { functions, body, nodes, of_mesh, pressure, totals, drained, conducts, ratio, .. } = self;
        let Some(water) = &body.water else { return };
        let [x, y] = &mut nodes.motion.acceleration;
        body.filled.calm(&body.grid, |lower, upper, share| {
            for a in [&mut *x, &mut *y] {
                a[upper] = a[lower] + share * (a[upper] - a[lower]);
            }
        });
        if !F::NODAL {
            functions.accelerations_of_mesh(nodes, of_mesh);
        }
        let Nodes { frame, motion, .. } = nodes;
        let acceleration = if F::NODAL { &motion.acceleration } else { of_mesh };
        let (flow, gravity) = (&water.flow, body.gravity.unwrap_or([0.0; D]));
        for &DrainedFace { cell, axis, outwards, face, nodes: [a, b] } in drained.iter() {
            let acceleration =
                if D == 1 { acceleration[axis][a] } else { 0.5 * (acceleration[axis][a] + acceleration[axis][b]) };
            let conducts = conducts[axis][face];
            let reach = ratio[axis].get(face).map_or(conducts, |ratio| conducts / ratio);
            let body = flow.weight * (gravity[axis] - flow.inertia * acceleration) / reach;
            let head = outwards * pressure[0][frame.pad() + cell] + body;
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

impl<V: Simd, F: Functions<D>, const D: usize> Model for Dynamic<V, F, D> {
    fn advance(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault> {
        match self.pool.clone() {
            Some(pool) => pool.install(|| self.steps(dt, steps, done)),
            None => self.steps(dt, steps, done),
        }
    }

    fn enter_stage(&mut self, stage: &Stage, _: &[f64]) -> Result<(), Fault> {
        self.damping = stage.damping;
        for condition in &mut self.conditions {
            condition.damp_by(stage.damping);
        }
        let mut whole = self.whole();
        if let Some(water) = &mut whole.water {
            water.drained = stage.drained;
            water.rebuild(&whole.grid, &whole.solid);
        }
        self.kept.1 = self.kept_now();
        self.body = whole;
        self.settle_in();
        Ok(())
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn observe(&self) -> Observation {
        self.whole().observe(self.time)
    }

    fn ledger(&self) -> Ledger {
        self.whole().ledger(&self.totals)
    }

    fn pore_pressure(&self) -> [f64; 3] {
        let (mut sum, mut volume, mut low, mut high) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
        let frame = &self.nodes.frame;
        for strip in &self.strips {
            for cell in 0..frame.strip {
                let [v, _] = strip.volume_and_mass(cell);
                if v > 0.0 {
                    let pressure = self.pressure[0][frame.pad() + strip.first + cell];
                    sum += pressure * v;
                    volume += v;
                    low = low.min(pressure);
                    high = high.max(pressure);
                }
            }
        }
        [sum / volume, low, high]
    }

    fn grid_speed(&self) -> f64 {
        let [x, y] = &self.nodes.motion.velocity;
        // One that is not a number stays: it is not at rest.
        let faster = |a: f64, b: f64| if b <= a || a.is_nan() { a } else { b };
        x.iter().zip(y).map(|(x, y)| x * x + y * y).fold(0.0, faster).sqrt()
    }

    fn bytes(&self) -> usize {
        let faces = self.pressure.iter().chain(&self.conducts).chain(&self.ratio).chain(&self.of_mesh);
        let numbers = faces.map(Vec::capacity).sum::<usize>() + self.soil.capacity() + self.kept.1.capacity();
        let strips = self.strips.iter().map(Strip::bytes).sum::<usize>();
        let water = self.body.water.as_ref().map_or(0, |water| water.layer.bytes());
        let movers = self.movers.iter().map(Movers::bytes).sum::<usize>();
        strips
            + self.nodes.bytes()
            + numbers * size_of::<f64>()
            + movers
            + self.body.solid.bytes()
            + water
            + self.tops.bytes()
    }

    fn solid_count(&self) -> usize {
        self.solid_count
    }

    fn particles(&self) -> Vec<SolidState> {
        self.whole().particles()
    }

    fn places(&self) -> Places {
        let whole = self.whole();
        Places::of(&whole.solid.points, whole.water.as_ref().map_or(&[], |water| &water.layer.points))
    }

    fn keep(&mut self, keeper: &mut Keeper) {
        let mut kept = self.kept_now();
        let mut whole = self.whole();
        whole.keep(keeper);
        keeper.all(&mut kept);
        for list in self.nodes.motion.velocity.iter_mut().chain(&mut self.of_mesh) {
            keeper.all(list);
        }
        keeper.f64(&mut self.damping);
        keeper.f64(&mut self.time);
        self.totals.keep(keeper);
        for condition in &mut self.conditions {
            condition.keep(keeper);
        }
        if keeper.is_reading() {
            for condition in &mut self.conditions {
                condition.damp_by(self.damping);
            }
            self.solid_count = whole.solid.points.len();
            self.kept.1 = kept;
            self.body = whole;
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
            1 => _ = self.equation_of_motion(dt),
            2 => self.darcy_flow(dt),
            3 => self.pass::<false>(dt),
            _ => self.pass::<true>(dt),
        };
        match pool {
            Some(pool) => pool.install(stage),
            None => stage(),
        }
    }
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;

    use super::*;
    use crate::boundary::{Filled, SurfaceLoad};
    use crate::constitutive::{LinearElastic, Material, Materials};
    use crate::grid::Grid;
    use crate::observe::Seed;
    use crate::particles::even_positions;
    use crate::scene::{Elastic, LoadOn};
    use crate::shape::Linear;
    use crate::step::kernel::{Basis, Bspline, Gimp, OnCell, Over};

    /// A number in [-1, 1] without system.
    fn noise(i: usize) -> f64 {
        (12.9898 * (i as f64 + 1.0)).sin() * 43758.5453 % 1.0
    }

    /// A linear field of velocities, m/s, and its gradient, 1/s.
    fn linear(x: [f64; 2]) -> [f64; 2] {
        [1.0 + 2.0 * x[0] - 3.0 * x[1], -2.0 + 3.0 * x[0] + 0.5 * x[1]]
    }
    const GRADIENT: [f64; 4] = [2.0, -3.0, 3.0, 0.5];

    /// Largest difference of the velocities of the nodes from a linear field (m/s) that the particles have, which have moved in 3 x 3
    /// cells of 0.5 m. `mapped` asks for those mapped back; `stands` says where a function stands, in cells.
    fn off_linear<F: Functions<2>>(functions: F, affine: bool, mapped: bool, stands: impl Fn(usize) -> f64) -> f64 {
        let grid = Grid::new([3, 3], 0.5);
        let points = even_positions([3, 3], 2).enumerate().map(|(i, x)| {
            let x = [0.5 * (x[0] + 0.2 * noise(i)), 0.5 * (x[1] + 0.2 * noise(7 * i))];
            SolidPoint { x, v: linear(x), stress: [0.0; 4], mass: 1.0, volume: 0.0625 }
        });
        let law = LinearElastic::plane_strain(&Elastic { youngs_modulus: 1.0, poisson_ratio: 0.3 });
        let body = Body {
            solid: Layer::new(points.collect(), &grid).expect("inside"),
            grid,
            water: None,
            materials: Materials::one(Material::Elastic(law)),
            surface: SurfaceLoad::new(Vec::new(), 0.0, LoadOn::Surface),
            filled: Filled::default(),
            surcharge: None,
            gravity: None,
            flip: 1.0,
            apart: 0.0,
            most_crossings: u64::MAX,
            seed: Seed { per_row: 6, spacing: 0.25, heights: Vec::new() },
            first_settlement: 0.0,
        };
        let mut run = Dynamic::new((Scalar, None), functions, body, Vec::new(), (affine, mapped));
        run.body = run.whole();
        run.kept.1 = GRADIENT.repeat(run.kept.1.len() / 4);
        run.settle_in();
        run.equation_of_motion(0.0).expect("motion");
        run.map_back();
        let velocity = run.mapped.as_ref().map_or(&run.nodes.motion, |mapped| &mapped.motion).velocity.clone();
        let frame = run.nodes.frame;
        let mut worst = 0.0_f64;
        for node in (0..frame.count()).filter(|node| run.nodes.sum(SOLID_MASS, *node) > 0.0) {
            let expected = linear(frame.position(node).map(|i| 0.5 * stands(i - frame.before)));
            (0..2).for_each(|d| worst = worst.max((velocity[d][node] - expected[d]).abs()));
        }
        worst
    }

    #[test]
    fn affine_velocities_give_nodes_a_linear_field() {
        let node = |i: usize| i as f64;
        let spline = |i: usize| Bspline::<2>.stands_at(i, 3);
        let cubic = |i: usize| Bspline::<3>.stands_at(i, 3);
        let off = [
            off_linear(OnCell(Linear), true, false, node),
            off_linear(OnCell(Linear), true, true, node),
            off_linear(Over(Gimp::new(2)), true, true, node),
            off_linear(Over(Bspline::<2>), true, false, spline),
            off_linear(Over(Bspline::<2>), true, true, spline),
            off_linear(Over(Bspline::<3>), true, true, cubic),
        ];
        assert!(off.iter().all(|off| *off < 1e-12), "{off:?}");
        assert!(off_linear(OnCell(Linear), false, false, node) > 0.1);
        assert!(off_linear(Over(Bspline::<2>), false, true, spline) > 0.1);
    }
}

//! The paper's explicit step (Figure 1): particles to mesh, equation of motion, Darcy flow, mesh to particles.

use super::track::Track;
use super::{Fault, Model, Parts, Transfer};
use crate::boundary::{Coulomb, Edges};
use crate::constitutive::{Law, Laws};
use crate::dimension::{Kinematics, basis, coefficients, gradient, shares, to_corners, trace, value};
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::nodes::{NodeMotion, NodeSums};
use crate::observe::{Flowed, Ledger, Observation, Places, SolidState, Totals};
use crate::particles::SolidPoint;
use crate::scene::Stage;
use crate::shape::Shape;
use crate::water::{Place, Pushed, SoilCell, StressSums, Water};
use std::marker::PhantomData;

/// The explicit integrator. K: dimension, Sh: shape, L: law, W: water.
#[derive(Debug)]
pub struct Explicit<K, Sh, L, W, const D: usize, const S: usize> {
    parts: Parts<L, W, D, S>,
    /// Periodic sides, light nodes, friction on the base: few scenes have any.
    edges: Option<Box<Edges<D>>>,
    /// What particles are followed by, where someone asks.
    pub(super) track: Option<Box<Track<D, S>>>,
    /// Of a water whose pressures push: inverse masses, and whom each node follows.
    inverse: Vec<[f64; D]>,
    leader: Vec<u32>,
    nodes: Vec<NodeSums<D>>,
    motion: Vec<NodeMotion<D>>,
    damping: f64,
    time: f64,
    totals: Totals<D>,
    choices: PhantomData<(K, Sh)>,
}

impl<K, Sh, L, W, const D: usize, const S: usize> Explicit<K, Sh, L, W, D, S>
where
    K: Kinematics<D, S>,
    Sh: Shape,
    L: Laws<S>,
    W: Water<K, D, S>,
{
    /// A run at t = 0.
    pub fn new(parts: Parts<L, W, D, S>) -> Self {
        Self::with_edges(parts, None)
    }

    /// A run at t = 0 of a mesh with edges.
    pub fn with_edges(mut parts: Parts<L, W, D, S>, edges: Option<Box<Edges<D>>>) -> Self {
        parts.follow_surface::<K>();
        let count = parts.grid.node_count();
        let pushed = if W::PRESSES { count } else { 0 };
        let mut run = Self {
            parts,
            edges,
            track: None,
            inverse: vec![[0.0; D]; pushed],
            leader: vec![0; pushed],
            nodes: vec![NodeSums::ZERO; count],
            motion: vec![NodeMotion::REST; count],
            damping: 0.0,
            time: 0.0,
            totals: Totals::default(),
            choices: PhantomData,
        };
        run.totals.start(&run.parts.cell_values::<K>());
        run.totals.flowed = run.parts.flowed_at_first();
        run
    }

    /// What the run is made of.
    pub(super) fn parts(&mut self) -> &mut Parts<L, W, D, S> {
        &mut self.parts
    }

    /// Gravity, m/s2.
    pub(super) fn gravity(&self) -> Option<[f64; D]> {
        self.parts.gravity
    }

    /// The mesh.
    pub(super) fn grid(&self) -> &Grid<D> {
        &self.parts.grid
    }

    /// Solid particles.
    pub(super) fn solid_points(&self) -> &[SolidPoint<D, S>] {
        &self.parts.solid.points
    }

    /// Friction on the base, if there is any.
    pub(super) fn base(&mut self) -> Option<&mut Coulomb> {
        self.edges.as_mut().and_then(|edges| edges.base.as_mut())
    }

    /// Damping from now on, 1/s.
    pub(super) fn damp_by(&mut self, rate: f64) {
        self.damping = rate;
    }

    /// All particles stop.
    pub(super) fn stop(&mut self) {
        for point in &mut self.parts.solid.points {
            point.v = [0.0; D];
        }
    }

    /// Nodes as they were in the last step.
    pub(super) fn nodes(&self) -> (&[NodeSums<D>], &[NodeMotion<D>]) {
        (&self.nodes, &self.motion)
    }

    /// Sums of the steps.
    pub(super) fn totals(&mut self) -> &mut Totals<D> {
        &mut self.totals
    }

    /// Begins the ledgers anew with the state as it is.
    pub(super) fn begin_ledgers(&mut self) {
        self.totals = Totals::default();
        self.totals.start(&self.parts.cell_values::<K>());
        self.totals.flowed = self.parts.flowed_at_first();
        self.time = 0.0;
    }

    /// Time (s) passes without a step of the soil.
    pub(super) fn pass(&mut self, time: f64) {
        self.time += time;
    }

    /// The water.
    pub(super) fn water(&self) -> &W {
        &self.parts.water
    }

    /// Solid particles and their numbers.
    pub(super) fn solid_and_ids(&self) -> (&[SolidPoint<D, S>], &[u32]) {
        (&self.parts.solid.points, &self.parts.solid.ids)
    }

    /// One step of Figure 1. ALONE gives [`Model::do_stage`] copies of the stages, so that those of a step remain one piece.
    fn step(&mut self, dt: f64) -> Result<(), Fault> {
        self.particles_to_mesh::<false>();
        if self.parts.transfer.is_some() {
            self.give_beyond();
        }
        self.load::<false>();
        self.equation_of_motion::<false>(dt)?;
        self.darcy_flow::<false>(dt);
        if self.track.is_some() {
            self.follow_particles(dt);
        }
        if self.parts.transfer.is_some() {
            self.map_back();
        }
        if self.mesh_to_particles::<false>(dt) {
            let solid = &mut self.parts.solid;
            if let Some(edges) = &self.edges {
                edges.wrap(solid);
            }
            solid.sort(&self.parts.grid).map_err(|e| Fault {
                place: format!("solid particle {} at {:?} m", solid.ids[e.index], e.x),
                what: "outside the mesh".to_owned(),
            })?;
            self.look_at_crossings()?;
        }
        self.parts.follow_surface::<K>();
        let Parts { water, grid, solid, .. } = &mut self.parts;
        water.settle(grid, solid).map_err(|(place, what)| Fault { place, what })?;
        self.time += dt;
        Ok(())
    }

    /// Masses, momenta and stresses of both layers to the nodes.
    fn particles_to_mesh<const ALONE: bool>(&mut self) {
        self.nodes.fill(NodeSums::ZERO);
        let Parts { grid, solid, water, filled, .. } = &mut self.parts;
        water.clear();
        for (cell, position) in grid.walk() {
            let range = solid.range(cell);
            if range.is_empty() {
                continue;
            }
            let (mut mass, mut volume) = (0.0, 0.0);
            let mut solid_mass = [0.0; 4];
            let mut momentum = [[0.0; D]; 4];
            let mut stress = StressSums { mean: [0.0; S], first: [[0.0; S]; D] };
            for point in &solid.points[range] {
                let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - position[d] as f64);
                let share = shares(point.mass, &xi);
                mass += point.mass;
                volume += point.volume;
                for a in 0..Grid::<D>::CORNERS {
                    solid_mass[a] += share[a];
                    for d in 0..D {
                        momentum[a][d] += share[a] * point.v[d];
                    }
                }
                for s in 0..S {
                    stress.mean[s] += point.volume * point.stress[s];
                }
                if Sh::SPLIT {
                    let mean = K::mean_stress(&point.stress);
                    for d in 0..D {
                        for s in 0..S {
                            let mean = -mean * K::UNIT_PRESSURE[s];
                            stress.first[d][s] += point.volume * ((point.stress[s] - mean) * xi[d] + 0.5 * mean);
                        }
                    }
                } else if !Sh::AT_CENTRE {
                    for d in 0..D {
                        for s in 0..S {
                            stress.first[d][s] += point.volume * point.stress[s] * xi[d];
                        }
                    }
                }
            }
            let at =
                if Sh::AT_CENTROID { centroid(grid, &position, &solid.points[solid.range(cell)]) } else { [0.5; D] };
            let soil_volume = filled.volume(cell, volume);
            if filled.is_known() {
                stress.scale(soil_volume / volume);
            }
            if Sh::AT_CENTRE {
                // Section 2.2: G_i(x_c) for every particle of the cell.
                for d in 0..D {
                    stress.first[d] = stress.mean.map(|s| at[d] * s);
                }
            }
            let corners = grid.corners_from(grid.first_corner(cell, &position));
            let place = Place { cell, position, corners };
            let soil = SoilCell { place, mass, volume, filled: soil_volume, at };
            let water_mass = water.cell_to_grid::<Sh::Pore>(grid, &soil, &solid_mass, &mut stress);
            // div(sigma') - grad p, weak: f_i = - sum_p V sigma G_i
            let internal = to_corners::<D, D, _>(&K::internal_force(&stress.mean, &stress.first, grid.inverse_size));
            for a in 0..Grid::<D>::CORNERS {
                let node = &mut self.nodes[corners[a]];
                node.solid_mass += solid_mass[a];
                node.mixture_mass += solid_mass[a] + water_mass[a];
                for d in 0..D {
                    node.momentum[d] += momentum[a][d];
                    node.force[d] -= internal[a][d];
                }
            }
        }
    }

    /// The surcharge at this time, Pa.
    fn pressure(&self) -> f64 {
        self.parts.surcharge.map_or(0.0, |s| s.at(self.time))
    }

    /// Surcharge and gravity, where the scene has them.
    fn load<const ALONE: bool>(&mut self) {
        let pressure = self.pressure();
        if self.parts.surcharge.is_some() {
            self.parts.surface.apply(pressure, &self.parts.grid, &self.parts.solid, &mut self.nodes);
        }
        if let Some(gravity) = self.parts.gravity {
            for node in &mut self.nodes {
                for d in 0..D {
                    node.force[d] += node.mixture_mass * gravity[d];
                }
            }
        }
        if self.parts.force.is_some() {
            self.force();
        }
        if let Some(plate) = &self.parts.plate {
            plate.level(&mut self.nodes);
        }
    }

    /// The given force on the soil.
    #[cold]
    #[inline(never)]
    fn force(&mut self) {
        let Parts { grid, solid, force: Some(force), .. } = &mut self.parts else { return };
        force.clear(self.nodes.len());
        for (cell, position) in grid.walk() {
            let corners = grid.corners_from(grid.first_corner(cell, &position));
            for point in &solid.points[solid.range(cell)] {
                let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - position[d] as f64);
                let (share, on) = (shares(1.0, &xi), force.on(point.mass, &point.x, self.time));
                for a in 0..Grid::<D>::CORNERS {
                    force.add(corners[a], share[a], &on);
                }
            }
        }
        force.push(&mut self.nodes);
    }

    /// Mixture momentum: rho a_s = div(sigma') - grad p + rho g; new nodal velocities.
    fn equation_of_motion<const ALONE: bool>(&mut self, dt: f64) -> Result<(), Fault> {
        if self.edges.is_some() {
            self.join();
        }
        let flip = self.parts.flip;
        for (node, motion) in self.nodes.iter().zip(&mut self.motion) {
            let with_mass = node.solid_mass > 0.0;
            let (of_solid, of_mixture) =
                if with_mass { (1.0 / node.solid_mass, 1.0 / node.mixture_mass) } else { (0.0, 0.0) };
            for d in 0..D {
                let acceleration = node.force[d] * of_mixture;
                let velocity = node.momentum[d] * of_solid + dt * acceleration;
                motion.acceleration[d] = acceleration;
                motion.velocity[d] = velocity;
                motion.change[d] = flip * dt * acceleration + (1.0 - flip) * velocity;
            }
        }
        if self.edges.is_some() {
            self.rub(dt); // before the supports: it needs what they have to take
        }
        let impulse = self.parts.supports.apply(&self.nodes, &mut self.motion);
        if self.damping > 0.0 {
            self.damp(dt); // after the supports: a held node has no speed to lose
        }
        if W::PRESSES {
            self.press(dt)?;
        }
        if self.edges.is_some() {
            self.follow(dt);
        }
        self.totals.accelerate(&self.nodes, &self.motion, self.parts.flip, dt);
        let pressure = self.pressure();
        for d in 0..D {
            self.totals.support_impulse[d] += impulse[d];
        }
        if self.parts.surcharge.is_some() {
            let Parts { surface, grid, solid, .. } = &self.parts;
            self.totals.external_work += dt * surface.power(pressure, grid, solid, &self.motion, dt);
            self.totals.load_impulse -= dt * pressure * surface.loaded_area();
        }
        if let Some(gravity) = self.parts.gravity {
            self.totals.weigh(&self.nodes, &self.motion, &gravity, dt);
        }
        if let Some(force) = &self.parts.force {
            force.book(&mut self.totals, &self.motion, dt, 0.5 * dt);
        }
        Ok(())
    }

    /// Pressures that follow the motion within the step push the soil.
    #[inline(never)]
    fn press(&mut self, dt: f64) -> Result<(), Fault> {
        let keep = 1.0 / (1.0 + self.damping * dt);
        for (node, (inverse, leader)) in self.inverse.iter_mut().zip(&mut self.leader).enumerate() {
            let mass = self.nodes[node].mixture_mass;
            *inverse = [if mass > 0.0 { keep / mass } else { 0.0 }; D];
            *leader = node as u32;
        }
        self.parts.supports.hold(&mut self.inverse);
        if let Some(edges) = &self.edges {
            for [follower, leader] in edges.joined.pairs() {
                self.leader[follower] = leader as u32;
            }
            if let Some(base) = &edges.base {
                base.stuck().for_each(|node| self.inverse[node][0] = 0.0);
            }
        }
        let Parts { water, grid, .. } = &mut self.parts;
        let pushed = Pushed { grid, inverse: &self.inverse, leader: &self.leader };
        water.press(grid, &pushed, &mut self.motion, dt).map_err(|(place, what)| Fault { place, what })
    }

    /// Momenta that particles give to nodes because these are not where they are.
    #[cold]
    #[inline(never)]
    fn give_beyond(&mut self) {
        let Parts { grid, solid, transfer: Some(transfer), .. } = &self.parts else { return };
        let Some(affine) = &transfer.affine else { return };
        for (cell, position) in grid.walk() {
            let corners = grid.corners_from(grid.first_corner(cell, &position));
            for index in solid.range(cell) {
                let point = &solid.points[index];
                let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - position[d] as f64);
                let share = shares(point.mass, &xi);
                for a in 0..Grid::<D>::CORNERS {
                    let away = to_corner(grid, &xi, a);
                    let more = Transfer::beyond(&affine[solid.ids[index] as usize], &away);
                    for d in 0..D {
                        self.nodes[corners[a]].momentum[d] += share[a] * more[d];
                    }
                }
            }
        }
    }

    /// Velocity gradients for the next step, and the velocities that strain the soil in this one.
    #[cold]
    #[inline(never)]
    fn map_back(&mut self) {
        let Parts { grid, solid, transfer: Some(transfer), supports, flip, .. } = &mut self.parts else { return };
        let Transfer { affine, mapped } = &mut **transfer;
        if let Some(mapped) = mapped {
            mapped.fill(NodeMotion::REST);
        }
        for (cell, position) in grid.walk() {
            let range = solid.range(cell);
            if range.is_empty() {
                continue;
            }
            let corners = grid.corners_from(grid.first_corner(cell, &position));
            let velocity = coefficients::<D, D, _>(&corners.map(|node| self.motion[node].velocity));
            let change = coefficients::<D, D, _>(&corners.map(|node| self.motion[node].change));
            for index in range {
                let point = &solid.points[index];
                let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - position[d] as f64);
                let own = affine.as_mut().map(|affine| {
                    let own = &mut affine[solid.ids[index] as usize];
                    *own = gradient(&velocity, &xi, grid.inverse_size);
                    *own
                });
                let Some(mapped) = mapped else { continue };
                let dv = value::<D, D, _>(&change, &basis(&xi));
                let share = shares(point.mass, &xi);
                for a in 0..Grid::<D>::CORNERS {
                    let away = to_corner(grid, &xi, a);
                    let more = own.map_or([0.0; D], |own| Transfer::beyond(&own, &away));
                    for d in 0..D {
                        mapped[corners[a]].velocity[d] += share[a] * (*flip * point.v[d] + dv[d] + more[d]);
                    }
                }
            }
        }
        let Some(mapped) = mapped else { return };
        let pairs = || self.edges.iter().flat_map(|edges| edges.joined.pairs());
        for [follower, leader] in pairs() {
            for d in 0..D {
                mapped[leader].velocity[d] += mapped[follower].velocity[d];
            }
        }
        Transfer::settle(mapped, &self.nodes, supports);
        for [follower, leader] in pairs() {
            mapped[follower] = mapped[leader];
        }
    }

    /// Displacements, strains and work of those who ask.
    #[inline(never)]
    fn follow_particles(&mut self, dt: f64) {
        let Some(track) = &mut self.track else { return };
        let Parts { grid, solid, .. } = &self.parts;
        for (cell, position) in grid.walk() {
            let range = solid.range(cell);
            if range.is_empty() {
                continue;
            }
            let corners = grid.corners_from(grid.first_corner(cell, &position));
            let velocity = coefficients::<D, D, _>(&corners.map(|node| self.motion[node].velocity));
            let at = if Sh::AT_CENTROID { centroid(grid, &position, &solid.points[range.clone()]) } else { [0.5; D] };
            let mut gradient = gradient(&velocity, &at, grid.inverse_size);
            for index in range {
                if !Sh::AT_CENTRE {
                    let x = solid.points[index].x;
                    let xi = std::array::from_fn(|d| x[d] * grid.inverse_size - position[d] as f64);
                    gradient = crate::dimension::gradient(&velocity, &xi, grid.inverse_size);
                }
                track.stretch::<K>(solid.ids[index], &gradient, dt);
            }
        }
    }

    /// Stops before the noise of crossings is as large as the stress.
    #[cold]
    fn look_at_crossings(&self) -> Result<(), Fault> {
        let Parts { solid, most_crossings, .. } = &self.parts;
        if self.damping > 0.0 || solid.crossings <= *most_crossings {
            return Ok(());
        }
        let each = solid.crossings / solid.points.len() as u64;
        let what = format!(
            "its particles have crossed {each} cells each: the stress of linear functions is then noise by a tenth or more \
             and grows; \"bspline2\", \"gimp\", damping or flip < 1 keeps it down, --force goes on"
        );
        Err(Fault { place: "the soil".to_owned(), what })
    }

    /// Sums of nodes that move with others go to these, and light ones are lent inertia.
    #[cold]
    #[inline(never)]
    fn join(&mut self) {
        if let Some(edges) = &mut self.edges {
            edges.joined.join(&mut self.nodes);
            edges.lift(&self.parts.grid, &self.parts.solid, &mut self.nodes);
        }
    }

    /// Nodes that move with others get their motion, lent inertia is taken back; the base notes its slip.
    #[cold]
    #[inline(never)]
    fn follow(&mut self, dt: f64) {
        if let Some(edges) = &mut self.edges {
            edges.joined.follow(&mut self.motion);
            if let Some(lifted) = &mut edges.lifted {
                lifted.lower(&mut self.nodes, &self.motion, dt, &mut self.totals);
            }
            if let Some(base) = &mut edges.base {
                base.slide(&self.parts.grid, &self.parts.solid, &edges.joined, &self.motion, dt);
            }
        }
    }

    /// Friction on the base, where the scene has it.
    #[cold]
    #[inline(never)]
    fn rub(&mut self, dt: f64) {
        let Some(Edges { joined, base: Some(base), .. }) = self.edges.as_deref_mut() else { return };
        let Parts { grid, solid, water, .. } = &self.parts;
        let rise = grid.size * water.density() * self.parts.gravity.map_or(0.0, |g| -g[D - 1]);
        let pressure = |cell: usize| {
            let place = Place { cell, position: grid.cell_position(cell), corners: [0; 4] };
            let points = &solid.points[solid.range(cell)];
            let (mass, volume) = points.iter().fold((0.0, 0.0), |(m, v), p| (m + p.mass, v + p.volume));
            water.on_base(&SoilCell { place, mass, volume, filled: volume, at: [0.5; D] }, rise)
        };
        base.gather(grid, solid, joined, pressure);
        let rubbed = base.rub(&self.nodes, &mut self.motion, dt);
        self.totals.support_impulse[0] += rubbed.impulse;
        self.totals.base_friction += rubbed.loss;
    }

    /// Mass-proportional damping, implicit in the velocity: v (1 + c dt) = v + a dt.
    fn damp(&mut self, dt: f64) {
        let keep = 1.0 / (1.0 + self.damping * dt);
        for (node, motion) in self.nodes.iter().zip(&mut self.motion) {
            for d in 0..D {
                let undamped = motion.velocity[d];
                let velocity = keep * undamped;
                motion.velocity[d] = velocity;
                motion.acceleration[d] -= (undamped - velocity) / dt;
                motion.change[d] -= undamped - velocity;
                let lost = node.mixture_mass * (undamped - velocity);
                self.totals.damping_loss += lost * velocity;
                self.totals.damping_impulse[d] -= lost;
            }
        }
    }

    /// Eq. (1): relative velocity of the water.
    fn darcy_flow<const ALONE: bool>(&mut self, dt: f64) {
        if W::WET {
            let gravity = self.parts.gravity.unwrap_or([0.0; D]);
            let motion = &mut self.motion;
            self.parts.filled.calm(&self.parts.grid, |lower, upper, share| {
                for d in 0..D {
                    let below = motion[lower].acceleration[d];
                    motion[upper].acceleration[d] = below + share * (motion[upper].acceleration[d] - below);
                }
            });
            let rates = self.parts.water.flow(&self.parts.grid, &self.motion, &gravity);
            self.totals.darcy_dissipation += dt * rates.dissipation;
            self.totals.flow_body_work += dt * rates.body_work;
            self.totals.water_out += dt * rates.outflow;
            self.totals.water_in += dt * rates.inflow;
        }
    }

    /// Strains, stresses, pressures, velocities and positions of both layers. True if a particle left its cell.
    fn mesh_to_particles<const ALONE: bool>(&mut self, dt: f64) -> bool {
        let Parts { grid, solid, water, law, flip, apart, transfer, .. } = &mut self.parts;
        let mapped = transfer.as_ref().and_then(|transfer| transfer.mapped.as_ref());
        let (flip, laws, apart) = (*flip, *law, *apart);
        let mut inside = true;
        let mut flowed = Flowed::NOTHING;
        for (cell, position) in grid.walk() {
            let range = solid.range(cell);
            if range.is_empty() {
                continue;
            }
            let corners = grid.corners_from(grid.first_corner(cell, &position));
            let (mut velocity, mut change) = ([[0.0; D]; 4], [[0.0; D]; 4]);
            for a in 0..Grid::<D>::CORNERS {
                velocity[a] = self.motion[corners[a]].velocity;
                change[a] = self.motion[corners[a]].change;
            }
            let velocity = coefficients::<D, D, _>(&velocity);
            let change = coefficients::<D, D, _>(&change);
            let strains = match mapped {
                Some(mapped) => coefficients::<D, D, _>(&corners.map(|node| mapped[node].velocity)),
                None => velocity,
            };
            let at = if Sh::AT_CENTROID { centroid(grid, &position, &solid.points[range.clone()]) } else { [0.5; D] };
            // B-bar: what changes volumes is that of the centre.
            let middle = if Sh::SPLIT { trace(&gradient(&strains, &[0.5; D], grid.inverse_size)) } else { 0.0 };
            for (number, point) in (range.start..).zip(&mut solid.points[range]) {
                let law = laws.law(laws.mark_of(if L::LAYERED { solid.ids[number] } else { 0 }));
                let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - position[d] as f64);
                let phi = basis(&xi);
                let here = if Sh::AT_CENTROID { at } else { Sh::point(&xi) };
                let gradient = gradient(&strains, &here, grid.inverse_size);
                K::rotate(&mut point.stress, &gradient, dt);
                let mut strain = K::strain_increment(&gradient, dt);
                let mut rate = trace(&gradient);
                if Sh::SPLIT {
                    let more = (middle - rate) * dt / 3.0;
                    for s in 0..S {
                        strain[s] -= more * K::UNIT_PRESSURE[s];
                    }
                    rate = middle;
                }
                if L::One::PLASTIC {
                    flowed.add(point.volume, &law.flow(&mut point.stress, &strain));
                } else {
                    law.update(&mut point.stress, &strain);
                }
                point.volume *= 1.0 + dt * rate;
                if L::One::PLASTIC && point.volume * apart > point.mass {
                    // Come apart: no stress until the gap is closed, or every recompression would push too early.
                    flowed.dissipation += point.volume * law.energy(&point.stress);
                    point.stress = [0.0; S];
                }
                let dv = value::<D, D, _>(&change, &phi);
                let v = value::<D, D, _>(&velocity, &phi);
                for d in 0..D {
                    point.v[d] = flip * point.v[d] + dv[d];
                    point.x[d] += dt * v[d];
                    let moved = point.x[d] * grid.inverse_size - position[d] as f64;
                    inside &= (0.0..1.0).contains(&moved);
                }
            }
            if W::WET {
                water.cell_to_points::<Sh::Pore>(grid, &Place { cell, position, corners }, &strains, dt);
            }
        }
        if L::One::PLASTIC {
            self.totals.flowed.join(&flowed);
        }
        !inside
    }
}

/// From a point of a cell to one of its corners, m.
#[inline(always)]
fn to_corner<const D: usize>(grid: &Grid<D>, xi: &[f64; D], corner: usize) -> [f64; D] {
    std::array::from_fn(|d| (((corner >> d) & 1) as f64 - xi[d]) * grid.size)
}

/// Centroid of the soil of a cell, in cell coordinates.
#[inline(always)]
fn centroid<const D: usize, const S: usize>(
    grid: &Grid<D>,
    position: &[usize; D],
    points: &[SolidPoint<D, S>],
) -> [f64; D] {
    let (mut volume, mut moment) = (0.0, [0.0; D]);
    for point in points {
        volume += point.volume;
        for d in 0..D {
            moment[d] += point.volume * point.x[d];
        }
    }
    std::array::from_fn(|d| moment[d] / volume * grid.inverse_size - position[d] as f64)
}

impl<K, Sh, L, W, const D: usize, const S: usize> Model for Explicit<K, Sh, L, W, D, S>
where
    K: Kinematics<D, S>,
    Sh: Shape,
    L: Laws<S>,
    W: Water<K, D, S>,
{
    fn advance(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault> {
        for _ in 0..steps {
            self.step(dt)?;
            *done += 1;
        }
        Ok(())
    }

    fn enter_stage(&mut self, stage: &Stage, _: &[f64]) -> Result<(), Fault> {
        self.damping = stage.damping;
        self.parts.water.set_drained(&self.parts.grid, &self.parts.solid, stage.drained);
        Ok(())
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn observe(&self) -> Observation {
        self.parts.observe::<K>(self.time)
    }

    fn ledger(&self) -> Ledger {
        self.parts.ledger::<K>(&self.totals)
    }

    fn pore_pressure(&self) -> [f64; 3] {
        self.parts.pore_pressure::<K>()
    }

    fn grid_speed(&self) -> f64 {
        let speed = |m: &NodeMotion<D>| m.velocity.iter().map(|v| v * v).sum::<f64>();
        // One that is not a number stays: it is not at rest.
        self.motion.iter().map(speed).fold(0.0, |a, b| if b <= a || a.is_nan() { a } else { b }).sqrt()
    }

    fn bytes(&self) -> usize {
        self.parts.solid.bytes()
            + self.parts.water.bytes()
            + self.nodes.capacity() * size_of::<NodeSums<D>>()
            + self.motion.capacity() * size_of::<NodeMotion<D>>()
            + self.edges.as_ref().and_then(|edges| edges.base.as_ref()).map_or(0, Coulomb::bytes)
            + self.parts.transfer.as_ref().map_or(0, |transfer| transfer.bytes())
    }

    fn solid_count(&self) -> usize {
        self.parts.solid.points.len()
    }

    fn particles(&self) -> Vec<SolidState> {
        self.parts.particles::<K>()
    }

    fn places(&self) -> Places {
        let water = self.parts.water.layer().map_or(&[][..], |layer| &layer.points);
        Places::of(&self.parts.solid.points, water)
    }

    fn keep(&mut self, keeper: &mut Keeper) {
        self.parts.keep::<K>(keeper);
        keeper.entries(&mut self.motion, NodeMotion::keep);
        keeper.f64(&mut self.damping);
        keeper.f64(&mut self.time);
        self.totals.keep(keeper);
        if let Some(base) = self.base() {
            base.keep(keeper);
        }
        if let Some(track) = &mut self.track {
            track.keep(keeper);
        }
    }

    fn stages(&self) -> &'static [&'static str] {
        &["particles to mesh", "loads", "equation of motion", "Darcy flow", "mesh to particles"]
    }

    fn do_stage(&mut self, stage: usize, dt: f64) {
        match stage {
            0 => self.particles_to_mesh::<true>(),
            1 => self.load::<true>(),
            2 => _ = self.equation_of_motion::<true>(dt),
            3 => self.darcy_flow::<true>(dt),
            _ => _ = self.mesh_to_particles::<true>(dt),
        }
    }
}

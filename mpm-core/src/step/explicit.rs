//! The paper's explicit step (Figure 1): particles to mesh, equation of motion, Darcy flow, mesh to particles.

use super::{Fault, Model, Parts};
use crate::boundary::{Coulomb, Edges};
use crate::constitutive::Law;
use crate::dimension::{Kinematics, basis, coefficients, gradient, shares, to_corners, trace, value};
use crate::grid::Grid;
use crate::nodes::{NodeMotion, NodeSums};
use crate::observe::{Flowed, Ledger, Observation, Places, Totals};
use crate::particles::SolidPoint;
use crate::scene::Stage;
use crate::shape::Shape;
use crate::water::{Place, SoilCell, StressSums, Water};
use std::marker::PhantomData;

/// The explicit integrator. K: dimension, Sh: shape, L: law, W: water.
#[derive(Debug)]
pub struct Explicit<K, Sh, L, W, const D: usize, const S: usize> {
    parts: Parts<L, W, D, S>,
    /// Periodic sides, light nodes, friction on the base: few scenes have any.
    edges: Option<Box<Edges<D>>>,
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
    L: Law<S>,
    W: Water<K, D, S>,
{
    /// A run at t = 0.
    pub fn new(parts: Parts<L, W, D, S>) -> Self {
        Self::with_edges(parts, None)
    }

    /// A run at t = 0 of a mesh with edges.
    pub fn with_edges(mut parts: Parts<L, W, D, S>, edges: Option<Box<Edges<D>>>) -> Self {
        parts.surface.follow(&parts.solid);
        let count = parts.grid.node_count();
        let mut run = Self {
            parts,
            edges,
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

    /// The mesh.
    pub(super) fn grid(&self) -> &Grid<D> {
        &self.parts.grid
    }

    /// Solid particles.
    pub(super) fn solid_points(&self) -> &[SolidPoint<D, S>] {
        &self.parts.solid.points
    }

    /// Books water (m3) that another model has let in and out, and the time (s) it took.
    pub(super) fn book_flow(&mut self, rates: [f64; 2], time: f64) {
        self.totals.water_in += rates[0];
        self.totals.water_out += rates[1];
        self.time += time;
    }

    /// One step of Figure 1. ALONE gives [`Model::do_stage`] copies of the stages, so that those of a step remain one piece.
    fn step(&mut self, dt: f64) -> Result<(), Fault> {
        self.particles_to_mesh::<false>();
        self.load::<false>();
        self.equation_of_motion::<false>(dt);
        self.darcy_flow::<false>(dt);
        if self.mesh_to_particles::<false>(dt) {
            let solid = &mut self.parts.solid;
            if let Some(edges) = &self.edges {
                edges.wrap(solid);
            }
            solid.sort(&self.parts.grid).map_err(|e| Fault {
                place: format!("solid particle {} at {:?} m", solid.ids[e.index], e.x),
                what: "outside the mesh".to_owned(),
            })?;
            self.parts.surface.follow(&self.parts.solid);
        }
        let Parts { water, grid, solid, .. } = &mut self.parts;
        water.settle(grid, solid).map_err(|(place, what)| Fault { place, what })?;
        self.time += dt;
        Ok(())
    }

    /// Masses, momenta and stresses of both layers to the nodes.
    fn particles_to_mesh<const ALONE: bool>(&mut self) {
        self.nodes.fill(NodeSums::ZERO);
        let Parts { grid, solid, water, .. } = &mut self.parts;
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
                if !Sh::AT_CENTRE {
                    for d in 0..D {
                        for s in 0..S {
                            stress.first[d][s] += point.volume * point.stress[s] * xi[d];
                        }
                    }
                }
            }
            if Sh::AT_CENTRE {
                // Section 2.2: G_i(x_c) for every particle of the cell.
                for d in 0..D {
                    stress.first[d] = stress.mean.map(|s| 0.5 * s);
                }
            }
            let corners = grid.corners_from(grid.first_corner(cell, &position));
            let soil = SoilCell { place: Place { cell, position, corners }, mass, volume };
            let water_mass = water.cell_to_grid::<Sh>(grid, &soil, &mut stress);
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
    }

    /// Mixture momentum: rho a_s = div(sigma') - grad p + rho g; new nodal velocities.
    fn equation_of_motion<const ALONE: bool>(&mut self, dt: f64) {
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
        if self.edges.is_some() {
            self.follow(dt);
        }
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
    }

    /// Sums of nodes that move with others go to these.
    #[cold]
    #[inline(never)]
    fn join(&mut self) {
        if let Some(edges) = &mut self.edges {
            edges.joined.join(&mut self.nodes);
        }
    }

    /// Nodes that move with others get their motion; the base notes its slip.
    #[cold]
    #[inline(never)]
    fn follow(&mut self, dt: f64) {
        if let Some(edges) = &mut self.edges {
            edges.joined.follow(&mut self.motion);
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
            // From the mean over the cell down to the base: under water that fills it, or stands in it up to a level.
            let mean = water.cell_state(&SoilCell { place, mass, volume }).0;
            if mean >= 0.5 * rise { mean + 0.5 * rise } else { (2.0 * rise * mean.max(0.0)).sqrt() }
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
            let rates = self.parts.water.flow(&self.parts.grid, &self.motion, &gravity);
            self.totals.darcy_dissipation += dt * rates.dissipation;
            self.totals.flow_body_work += dt * rates.body_work;
            self.totals.water_out += dt * rates.outflow;
            self.totals.water_in += dt * rates.inflow;
        }
    }

    /// Strains, stresses, pressures, velocities and positions of both layers. True if a particle left its cell.
    fn mesh_to_particles<const ALONE: bool>(&mut self, dt: f64) -> bool {
        let Parts { grid, solid, water, law, flip, apart, .. } = &mut self.parts;
        let (flip, law, apart) = (*flip, *law, *apart);
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
            for point in &mut solid.points[range] {
                let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - position[d] as f64);
                let phi = basis(&xi);
                let gradient = gradient(&velocity, &Sh::point(&xi), grid.inverse_size);
                K::rotate(&mut point.stress, &gradient, dt);
                let strain = K::strain_increment(&gradient, dt);
                if L::PLASTIC {
                    flowed.add(point.volume, &law.flow(&mut point.stress, &strain));
                } else {
                    law.update(&mut point.stress, &strain);
                }
                point.volume *= 1.0 + dt * trace(&gradient);
                if L::PLASTIC && point.volume * apart > point.mass {
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
                water.cell_to_points::<Sh>(grid, &Place { cell, position, corners }, &velocity, dt);
            }
        }
        if L::PLASTIC {
            self.totals.flowed.join(&flowed);
        }
        !inside
    }
}

impl<K, Sh, L, W, const D: usize, const S: usize> Model for Explicit<K, Sh, L, W, D, S>
where
    K: Kinematics<D, S>,
    Sh: Shape,
    L: Law<S>,
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
    }

    fn solid_count(&self) -> usize {
        self.parts.solid.points.len()
    }

    fn places(&self) -> Places {
        let water = self.parts.water.layer().map_or(&[][..], |layer| &layer.points);
        Places::of(&self.parts.solid.points, water)
    }

    fn stages(&self) -> &'static [&'static str] {
        &["particles to mesh", "loads", "equation of motion", "Darcy flow", "mesh to particles"]
    }

    fn do_stage(&mut self, stage: usize, dt: f64) {
        match stage {
            0 => self.particles_to_mesh::<true>(),
            1 => self.load::<true>(),
            2 => self.equation_of_motion::<true>(dt),
            3 => self.darcy_flow::<true>(dt),
            _ => _ = self.mesh_to_particles::<true>(dt),
        }
    }
}

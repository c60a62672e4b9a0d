//! The solid layer over stencils of any width: what the explicit and the semi-implicit step have in common.
//!
//! The order of a step is that of the paper's Figure 1; `step/explicit.rs` is the same for linear functions, faster.

use super::{Fault, Parts};
use crate::boundary::Lifted;
use crate::constitutive::{Law, Laws};
use crate::dimension::{Gradient, Kinematics, trace};
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::nodes::{NodeMotion, NodeSums};
use crate::observe::{Flowed, Totals};
use crate::stencil::{Basis, Functions, Stencil};
use crate::water::{CellChange, Cellwise, Place, SoilCell};
use std::marker::PhantomData;

/// The solid layer and the coefficients of its motion. K: dimension, B: basis, L: law, W: water.
#[derive(Debug)]
pub struct Skeleton<K, B, L, W, const D: usize, const S: usize> {
    /// Mesh, particles and conditions.
    pub parts: Parts<L, W, D, S>,
    /// Basis functions; nodes, motion and supports are numbered as they are.
    pub functions: Functions<B, D>,
    /// Sums gathered from the particles.
    pub nodes: Vec<NodeSums<D>>,
    /// How the coefficients move.
    pub motion: Vec<NodeMotion<D>>,
    /// Motion at the nodes of the mesh, for the flow.
    pub mesh: Vec<NodeMotion<D>>,
    /// C: force of a unit pressure in a cell on the functions that its particles reach, `sum_p V_p G_i`, m2. Empty
    /// where no one asks for it.
    pub coupling: Vec<[f64; D]>,
    /// Where in a step the work of the loads is taken: 1/2 for the velocity of its middle, 1 for that of its end.
    pub work_at: f64,
    /// Inertia lent to nodes too light for the step; none where soil stays in its cells.
    pub lifted: Option<Box<Lifted<D>>>,
    /// Mass-proportional damping, 1/s.
    pub damping: f64,
    /// Time since the start of the run, s.
    pub time: f64,
    /// Balances.
    pub totals: Totals<D>,
    dimension: PhantomData<K>,
}

/// What supports and damping took from the soil in a step.
#[derive(Debug, Clone, Copy)]
pub struct Taken<const D: usize> {
    support_impulse: [f64; D],
    damping_impulse: [f64; D],
    damping_loss: f64,
}

impl<K, B, L, W, const D: usize, const S: usize> Skeleton<K, B, L, W, D, S>
where
    K: Kinematics<D, S>,
    B: Basis,
    L: Laws<S>,
    W: Cellwise<K, D, S>,
{
    /// A run at t = 0; `coupled` keeps C.
    pub fn new(mut parts: Parts<L, W, D, S>, basis: B, coupled: bool) -> Self {
        parts.follow_surface::<K>();
        let functions = Functions::new(basis, &parts.grid);
        let entries = if coupled { parts.grid.cell_count() * Functions::<B, D>::REACHED } else { 0 };
        let mut skeleton = Self {
            nodes: vec![NodeSums::ZERO; functions.count()],
            motion: vec![NodeMotion::REST; functions.count()],
            mesh: vec![NodeMotion::REST; parts.grid.node_count()],
            coupling: vec![[0.0; D]; entries],
            work_at: if coupled { 1.0 } else { 0.5 },
            lifted: None,
            damping: 0.0,
            time: 0.0,
            totals: Totals::default(),
            dimension: PhantomData,
            functions,
            parts,
        };
        skeleton.totals.start(&skeleton.parts.cell_values::<K>());
        skeleton.totals.flowed = skeleton.parts.flowed_at_first();
        skeleton
    }

    /// Masses, momenta and stresses of both layers to the nodes. COUPLED leaves the pore pressure out and gathers
    /// its coupling C instead. ALONE is a copy for [`super::Model::do_stage`], so that a step remains one piece.
    pub fn particles_to_mesh<const COUPLED: bool, const ALONE: bool>(&mut self) {
        self.nodes.fill(NodeSums::ZERO);
        if COUPLED {
            self.coupling.fill([0.0; D]);
        }
        let Parts { grid, solid, water, filled, .. } = &mut self.parts;
        water.clear();
        for (cell, position) in grid.walk() {
            let range = solid.range(cell);
            if range.is_empty() {
                continue;
            }
            let middle = if B::SPLIT { Some(self.functions.centre(&position)) } else { None };
            let points = &solid.points[range];
            let (mass, volume) = points.iter().fold((0.0, 0.0), |(m, v), p| (m + p.mass, v + p.volume));
            let place = Place { cell, position, corners: grid.corners_from(grid.first_corner(cell, &position)) };
            let soil = SoilCell { place, mass, volume, filled: filled.volume(cell, volume), at: [0.5; D] };
            let (pressure, share, water_ratio) = (water.note(&soil), soil.filled / volume, water.ratio(&soil));
            let mixture = 1.0 + water_ratio.unwrap_or(0.0);
            for point in points {
                let stencil = self.functions.around(&position, &inside(grid, &position, &point.x));
                let weight = share * point.volume;
                let mut stress = point.stress;
                if !COUPLED {
                    for s in 0..S {
                        stress[s] += pressure * K::UNIT_PRESSURE[s];
                    }
                }
                for a in 0..Functions::<B, D>::COUNT {
                    // div(sigma') - grad p, weak: f_i = - sum_p V sigma G_i
                    let internal = match &middle {
                        Some(middle) => split_traction::<K, D, S>(&stress, &stencil.gradient[a], &middle.gradient[a]),
                        None => K::traction(&stress, &stencil.gradient[a]),
                    };
                    let mass = point.mass * stencil.value[a];
                    let node = &mut self.nodes[stencil.node[a]];
                    node.solid_mass += mass;
                    node.mixture_mass += mixture * mass;
                    for d in 0..D {
                        node.momentum[d] += mass * point.v[d];
                        node.force[d] -= weight * internal[d];
                    }
                    if COUPLED {
                        let reached = Functions::<B, D>::reached(&position, &stencil, a);
                        let c = &mut self.coupling[cell * Functions::<B, D>::REACHED + reached];
                        for d in 0..D {
                            c[d] += weight * middle.as_ref().unwrap_or(&stencil).gradient[a][d];
                        }
                    }
                }
            }
            if let Some(layer) = water.layer().filter(|_| water_ratio.is_none()) {
                for point in &layer.points[layer.range(cell)] {
                    let stencil = self.functions.around(&position, &inside(grid, &position, &point.x));
                    for a in 0..Functions::<B, D>::COUNT {
                        self.nodes[stencil.node[a]].mixture_mass += point.mass * stencil.value[a];
                    }
                }
            }
        }
    }

    /// The surcharge at this time, Pa.
    fn pressure(&self) -> f64 {
        self.parts.surcharge.map_or(0.0, |s| s.at(self.time))
    }

    /// Surcharge and gravity, where the scene has them.
    pub fn load(&mut self) {
        let pressure = self.pressure();
        let Parts { surface, grid, solid, surcharge, gravity, .. } = &self.parts;
        if surcharge.is_some() {
            for (position, xi, area) in surface.places(grid, solid) {
                let stencil = self.functions.at_surface(&position, &xi);
                for a in 0..Functions::<B, D>::COUNT {
                    self.nodes[stencil.node[a]].force[D - 1] -= pressure * area * stencil.value[a];
                }
            }
        }
        if let Some(gravity) = gravity {
            for node in &mut self.nodes {
                for d in 0..D {
                    node.force[d] += node.mixture_mass * gravity[d];
                }
            }
        }
        if self.parts.force.is_some() {
            self.force();
        }
    }

    /// Lends inertia to nodes too light for the step, if the soil has such.
    pub fn lift(&mut self) {
        let Some(lifted) = &mut self.lifted else { return };
        lifted.clear();
        let Parts { grid, solid, .. } = &self.parts;
        for (cell, position) in grid.walk() {
            for point in &solid.points[solid.range(cell)] {
                let stencil = self.functions.around(&position, &inside(grid, &position, &point.x));
                for a in 0..Functions::<B, D>::COUNT {
                    if stencil.value[a] > 0.0 {
                        lifted.touch(stencil.node[a], point.mass);
                    }
                }
            }
        }
        lifted.lift(&mut self.nodes);
    }

    /// The given force on the soil.
    #[cold]
    #[inline(never)]
    fn force(&mut self) {
        let Parts { grid, solid, force: Some(force), .. } = &mut self.parts else { return };
        force.clear(self.nodes.len());
        for (cell, position) in grid.walk() {
            for point in &solid.points[solid.range(cell)] {
                let stencil = self.functions.around(&position, &inside(grid, &position, &point.x));
                let on = force.on(point.mass, &point.x, self.time);
                for a in 0..Functions::<B, D>::COUNT {
                    force.add(stencil.node[a], stencil.value[a], &on);
                }
            }
        }
        force.push(&mut self.nodes);
    }

    /// Velocities at the end of the step under the forces gathered so far, supports and damping included.
    pub fn accelerate(&mut self, dt: f64) -> Taken<D> {
        if let Some(plate) = &self.parts.plate {
            plate.level(&mut self.nodes);
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
        let support_impulse = self.parts.supports.apply(&self.nodes, &mut self.motion);
        let mut taken = Taken { support_impulse, damping_impulse: [0.0; D], damping_loss: 0.0 };
        if self.damping > 0.0 {
            self.damp(dt, &mut taken); // after the supports: a held node has no speed to lose
        }
        taken
    }

    /// Share of a velocity that damping leaves, implicit in the velocity: v (1 + c dt) = v + a dt.
    pub fn kept(&self, dt: f64) -> f64 {
        1.0 / (1.0 + self.damping * dt)
    }

    fn damp(&mut self, dt: f64, taken: &mut Taken<D>) {
        let keep = self.kept(dt);
        for (node, motion) in self.nodes.iter().zip(&mut self.motion) {
            for d in 0..D {
                let undamped = motion.velocity[d];
                let velocity = keep * undamped;
                motion.velocity[d] = velocity;
                motion.acceleration[d] -= (undamped - velocity) / dt;
                motion.change[d] -= undamped - velocity;
                let lost = node.mixture_mass * (undamped - velocity);
                taken.damping_loss += lost * velocity;
                taken.damping_impulse[d] -= lost;
            }
        }
    }

    /// Mixture momentum: rho a_s = div(sigma') - grad p + rho g; new velocities, and what acted in the ledgers.
    pub fn equation_of_motion(&mut self, dt: f64) {
        let taken = self.accelerate(dt);
        if let Some(lifted) = &mut self.lifted {
            lifted.lower(&mut self.nodes, &self.motion, dt, &mut self.totals);
        }
        self.totals.accelerate(&self.nodes, &self.motion, self.parts.flip, dt);
        let pressure = self.pressure();
        for d in 0..D {
            self.totals.support_impulse[d] += taken.support_impulse[d];
            self.totals.damping_impulse[d] += taken.damping_impulse[d];
        }
        self.totals.damping_loss += taken.damping_loss;
        let before = (1.0 - self.work_at) * dt;
        let moving = |m: &NodeMotion<D>, d: usize| m.velocity[d] - before * m.acceleration[d];
        let Parts { surface, grid, solid, surcharge, gravity, .. } = &self.parts;
        if surcharge.is_some() {
            for (position, xi, area) in surface.places(grid, solid) {
                let stencil = self.functions.at_surface(&position, &xi);
                for a in 0..Functions::<B, D>::COUNT {
                    let velocity = moving(&self.motion[stencil.node[a]], D - 1);
                    self.totals.external_work -= dt * pressure * area * stencil.value[a] * velocity;
                }
            }
            self.totals.load_impulse -= dt * pressure * surface.loaded_area();
        }
        if let Some(gravity) = gravity {
            for (node, motion) in self.nodes.iter().zip(&self.motion) {
                for d in 0..D {
                    let impulse = dt * node.mixture_mass * gravity[d];
                    self.totals.gravity_impulse[d] += impulse;
                    self.totals.gravity_work += impulse * moving(motion, d);
                }
            }
        }
        if let Some(force) = &self.parts.force {
            force.book(&mut self.totals, &self.motion, dt, before);
        }
    }

    /// Acceleration at the nodes of the mesh, from the coefficients: the mean over the mass around a node.
    ///
    /// The value of a B-spline at a free surface is that of its last coefficient, which has a quarter to a third of a
    /// cell's mass. A pore pressure in the last cell would accelerate it so much that `rho_w a_s` turned the flow round.
    pub fn motion_of_mesh(&mut self) {
        if B::NODAL {
            self.mesh.copy_from_slice(&self.motion);
            return;
        }
        let across = self.parts.grid.cells[0] + 1;
        for (node, mesh) in self.mesh.iter_mut().enumerate() {
            let stencil = self.functions.at_node(&std::array::from_fn(|d| match (D, d) {
                (1, _) => node,
                (_, 0) => node % across,
                _ => node / across,
            }));
            *mesh = NodeMotion::REST;
            let mut mass = 0.0;
            for a in 0..Functions::<B, D>::COUNT {
                let share = stencil.value[a] * self.nodes[stencil.node[a]].mixture_mass;
                mass += share;
                for d in 0..D {
                    mesh.acceleration[d] += share * self.motion[stencil.node[a]].acceleration[d];
                }
            }
            if mass > 0.0 {
                mesh.acceleration = mesh.acceleration.map(|a| a / mass);
            }
        }
    }

    /// Strains, stresses, velocities and positions of both layers. `change` gives the change of the water in a cell
    /// from the rate of volume of its soil, 1/s: the adjoint of the pressure force. True if a particle left its cell.
    pub fn mesh_to_particles<const ALONE: bool>(
        &mut self,
        dt: f64,
        change: impl Fn(&W, &Grid<D>, &Place<D>, f64) -> CellChange,
    ) -> bool {
        let Parts { grid, solid, water, law, flip, transfer, .. } = &mut self.parts;
        let (flip, laws) = (*flip, *law);
        let mapped = transfer.as_ref().and_then(|transfer| transfer.mapped.as_ref());
        let strains = mapped.unwrap_or(&self.motion);
        let mut stays = true;
        let mut flowed = Flowed::NOTHING;
        for (cell, position) in grid.walk() {
            let range = solid.range(cell);
            if range.is_empty() {
                continue;
            }
            let (mut volume, mut gained) = (0.0, 0.0);
            let middle = if B::SPLIT {
                let (gradient, ..) = field::<B, D>(&self.functions.centre(&position), strains);
                Some(trace(&gradient))
            } else {
                None
            };
            for (number, point) in (range.start..).zip(&mut solid.points[range]) {
                let law = laws.law(laws.mark_of(if L::LAYERED { solid.ids[number] } else { 0 }));
                let stencil = self.functions.around(&position, &inside(grid, &position, &point.x));
                let (mut gradient, v, dv) = field::<B, D>(&stencil, &self.motion);
                if mapped.is_some() {
                    (gradient, ..) = field::<B, D>(&stencil, strains);
                }
                K::rotate(&mut point.stress, &gradient, dt);
                let mut strain = K::strain_increment(&gradient, dt);
                let mut rate = trace(&gradient);
                if let Some(middle) = middle {
                    for s in 0..S {
                        strain[s] -= (middle - rate) * dt / 3.0 * K::UNIT_PRESSURE[s];
                    }
                    rate = middle;
                }
                if L::One::PLASTIC {
                    flowed.add(point.volume, &law.flow(&mut point.stress, &strain));
                } else {
                    law.update(&mut point.stress, &strain);
                }
                volume += point.volume;
                gained += point.volume * rate; // C^T v
                point.volume *= 1.0 + dt * rate;
                for d in 0..D {
                    point.v[d] = flip * point.v[d] + dv[d];
                    point.x[d] += dt * v[d];
                    let moved = point.x[d] * grid.inverse_size - position[d] as f64;
                    stays &= (0.0..1.0).contains(&moved);
                }
            }
            if W::WET {
                let corners = grid.corners_from(grid.first_corner(cell, &position));
                let place = Place { cell, position, corners };
                let change = change(water, grid, &place, gained / volume);
                water.move_points(grid, &place, (&self.functions, strains), &change, dt);
            }
        }
        if L::One::PLASTIC {
            self.totals.flowed.join(&flowed);
        }
        !stays
    }

    /// Restores the order of the particles and ends the step.
    ///
    /// # Errors
    /// A particle outside the mesh, or soil without water.
    pub fn settle(&mut self, left: bool, dt: f64) -> Result<(), Fault> {
        if left {
            let Parts { grid, solid, .. } = &mut self.parts;
            solid.sort(grid).map_err(|e| Fault {
                place: format!("solid particle {} at {:?} m", solid.ids[e.index], e.x),
                what: "outside the mesh".to_owned(),
            })?;
        }
        self.parts.follow_surface::<K>();
        let Parts { water, grid, solid, .. } = &mut self.parts;
        water.settle(grid, solid).map_err(|(place, what)| Fault { place, what })?;
        self.time += dt;
        Ok(())
    }

    /// Writes or reads what steps to come depend on.
    pub fn keep(&mut self, keeper: &mut Keeper) {
        self.parts.keep::<K>(keeper);
        keeper.entries(&mut self.motion, NodeMotion::keep);
        keeper.entries(&mut self.mesh, NodeMotion::keep);
        keeper.f64(&mut self.damping);
        keeper.f64(&mut self.time);
        self.totals.keep(keeper);
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.parts.solid.bytes()
            + self.parts.water.bytes()
            + self.nodes.capacity() * size_of::<NodeSums<D>>()
            + (self.motion.capacity() + self.mesh.capacity()) * size_of::<NodeMotion<D>>()
            + self.coupling.capacity() * size_of::<[f64; D]>()
            + self.parts.transfer.as_ref().map_or(0, |transfer| transfer.bytes())
    }
}

/// The force of a stress where its mean acts at the centre of the cell (B-bar): `s : G_i(x_p) + sigma_m G_i(x_c)`.
#[inline(always)]
fn split_traction<K: Kinematics<D, S>, const D: usize, const S: usize>(
    stress: &[f64; S],
    at_particle: &[f64; D],
    at_centre: &[f64; D],
) -> [f64; D] {
    let mean = K::mean_stress(stress);
    let deviator = std::array::from_fn(|s| stress[s] + mean * K::UNIT_PRESSURE[s]);
    let shear = K::traction(&deviator, at_particle);
    std::array::from_fn(|d| shear[d] + mean * at_centre[d])
}

/// Cell coordinates of a place (m).
#[inline(always)]
fn inside<const D: usize>(grid: &Grid<D>, position: &[usize; D], x: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|d| x[d] * grid.inverse_size - position[d] as f64)
}

/// Velocity gradient, velocity and particle's change of velocity at a point.
#[inline(always)]
fn field<B: Basis, const D: usize>(
    stencil: &Stencil<D>,
    motion: &[NodeMotion<D>],
) -> (Gradient<D>, [f64; D], [f64; D]) {
    let (mut gradient, mut v, mut dv) = ([[0.0; D]; D], [0.0; D], [0.0; D]);
    for a in 0..Functions::<B, D>::COUNT {
        let m = &motion[stencil.node[a]];
        for i in 0..D {
            v[i] += stencil.value[a] * m.velocity[i];
            dv[i] += stencil.value[a] * m.change[i];
            for j in 0..D {
                gradient[i][j] += stencil.gradient[a][j] * m.velocity[i];
            }
        }
    }
    (gradient, v, dv)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::{Supports, SurfaceLoad};
    use crate::constitutive::LinearElastic;
    use crate::dimension::PlaneStrain;
    use crate::observe::Seed;
    use crate::particles::{Layer, SolidPoint, even_positions};
    use crate::scene::{Elastic, LoadOn};
    use crate::shape::{BBar, Centre, Linear};
    use crate::stencil::{Bspline2, Gimp};
    use crate::water::Dry;

    /// A number in [-1, 1] without system.
    fn noise(i: usize) -> f64 {
        (12.9898 * (i as f64 + 1.0)).sin() * 43758.5453 % 1.0
    }

    /// Particles that have moved, in 3 x 3 cells of 0.5 m.
    fn skeleton<B: Basis>(basis: B) -> Skeleton<PlaneStrain, B, LinearElastic<4>, Dry, 2, 4> {
        let grid = Grid::new([3, 3], 0.5);
        let points = even_positions([3, 3], 2).enumerate().map(|(i, x)| SolidPoint {
            x: [0.5 * (x[0] + 0.2 * noise(i)), 0.5 * (x[1] + 0.2 * noise(7 * i))],
            v: [0.0; 2],
            stress: [0.0; 4],
            mass: 1.0,
            volume: 0.0625 * (1.0 + 0.1 * noise(3 * i)),
        });
        let parts = Parts {
            supports: Supports::along(&Functions::new(basis, &grid).along, &[crate::scene::SolidSide::Free; 4]),
            solid: Layer::new(points.collect(), &grid).expect("inside"),
            grid,
            water: Dry,
            law: LinearElastic::plane_strain(&Elastic { youngs_modulus: 1.0, poisson_ratio: 0.3 }),
            surface: SurfaceLoad::new(Vec::new(), 0.0, LoadOn::Surface),
            filled: Default::default(),
            surcharge: None,
            gravity: None,
            force: None,
            plate: None,
            transfer: None,
            flip: 1.0,
            apart: 0.0,
            most_crossings: u64::MAX,
            seed: Seed { per_row: 6, spacing: 0.25, heights: Vec::new() },
            first_settlement: 0.0,
        };
        Skeleton::new(parts, basis, true)
    }

    /// Largest difference of `C^T v` and `sum_p V_p tr(grad v)` over the cells, for any velocities; both in m3/s.
    fn off_adjoint<B: Basis>(basis: B, spoil: f64) -> f64 {
        let mut skeleton = skeleton(basis);
        skeleton.particles_to_mesh::<true, false>();
        for (i, motion) in skeleton.motion.iter_mut().enumerate() {
            motion.velocity = [noise(i), noise(11 * i)];
        }
        let Skeleton { parts, functions, motion, coupling, .. } = &mut skeleton;
        let reached = Functions::<B, 2>::REACHED;
        coupling[5 * reached][0] += spoil;
        let mut worst = 0.0_f64;
        for (cell, position) in parts.grid.walk() {
            let mut by_force = 0.0;
            for k in 0..reached {
                if let Some(function) = functions.at_place(&position, k) {
                    let (c, v) = (coupling[cell * reached + k], motion[function].velocity);
                    by_force += c[0] * v[0] + c[1] * v[1];
                }
            }
            let by_strain: f64 = parts.solid.points[parts.solid.range(cell)]
                .iter()
                .map(|p| {
                    let around = functions.around(&position, &inside(&parts.grid, &position, &p.x));
                    let stencil = if B::SPLIT { functions.centre(&position) } else { around };
                    p.volume * trace(&field::<B, 2>(&stencil, motion).0)
                })
                .sum();
            worst = worst.max((by_force - by_strain).abs());
        }
        worst
    }

    #[test]
    fn the_force_of_a_pressure_is_the_adjoint_of_the_rate_of_volume() {
        let off = [
            off_adjoint(BBar, 0.0),
            off_adjoint(Centre, 0.0),
            off_adjoint(Linear, 0.0),
            off_adjoint(Gimp::new(2), 0.0),
            off_adjoint(Bspline2, 0.0),
        ];
        assert!(off.iter().all(|off| *off < 1e-14), "{off:?}");
        assert!(off_adjoint(Linear, 1e-10) > 1e-12);
    }
}

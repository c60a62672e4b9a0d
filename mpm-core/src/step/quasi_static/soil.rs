//! The balance laws on a mesh that was built over the soil: forces, water content and flow at given unknowns.
//!
//! Unknowns are displacements u since the mesh was built and pore pressures p:
//!
//! ```text
//! sum_p w P : grad N_i - int p J F^-T grad N_i - int rho g N_i - load = 0      momentum
//! d/dt [ int q ((J - 1 + n) r - n) + jumps ] + int grad q . r K (grad p - rho_w F^T g) = 0      water
//! ```
//!
//! with F = I + grad u, J = det F, K = (k/gamma_w) J F^-1 F^-T and r = rho/rho_0 = exp(p/K_w). Small strain puts F = I, J - 1 =
//! div u, and is linear in the pressure as well: n p/K_w in place of n (r - 1), r = 1 in the flow. With inertia g is less by
//! the acceleration, and the flow has a history: `motion.rs`. Stress and stiffness are integrated with the particles' weights, or
//! by cells where these are too few; the rest with Gauss points (`bspline2`) or with the particles (pressures that are constant
//! in a cell).

use super::motion::{Motion, WaterInertia, dragged, forward, metric};
use super::tangent::System;
use crate::constitutive::{Flow, Law, Materials, STATES, State};
use crate::real::{array_of, map_of};
use crate::scene::{Course, FaceLoad, MovedPlate, Well};
use crate::soils::at_porosity;
use crate::space::{Axis, Group, MOST, Stencil, strain_mode, stretch, tensor, turned};

/// Most that a law's results in steps and in half steps may be apart for an extrapolation, as a share of the stress.
const MOST_APART: f64 = 0.1;
/// Most parts of a step along the path of a law.
const MOST_PARTS: u32 = 64;
/// No unknown: a fixed displacement, or a pressure that is zero.
pub(super) const HELD: u32 = u32::MAX;

/// A solid particle in the integrals.
#[derive(Debug, Clone)]
pub(super) struct SolidPart<const D: usize> {
    /// Functions and gradients that strain it.
    pub stencil: Stencil<D>,
    /// Gradients at the centre of its cell, where changes of volume are taken there (B-bar), 1/m.
    pub dilates: Option<Box<[[f64; D]; MOST]>>,
    /// Functions over the radius, about an axis, 1/m: what hoop strain they make.
    pub hoop: Option<Box<[f64; MOST]>>,
    /// Volume it stands for, m3.
    pub weight: f64,
    /// Effective stress at the last step, Pa, before rotation.
    pub stress: [f64; 4],
    /// Strain since the mesh was built, at the last step.
    pub strain: [f64; 4],
    /// What its soil remembers, at the last step.
    pub state: State,
    /// Its layer.
    pub mark: u8,
}

impl<const D: usize> SolidPart<D> {
    /// Adds the forces (N) of stresses that stand for a volume.
    fn give(&self, push: &Push<D>, force: &mut [f64]) {
        for a in 0..self.stencil.count {
            let at = self.stencil.number[a] as usize * D;
            for i in 0..D {
                let mut along: f64 = (0..D).map(|j| push.piola[i][j] * self.stencil.slope[a][j]).sum();
                if let (Some(slope), Some((mean, inverse))) = (&self.dilates, &push.at_centre) {
                    along += mean * (0..D).map(|j| inverse[j][i] * slope[a][j]).sum::<f64>();
                }
                if let (0, Some(hoop)) = (i, &self.hoop) {
                    along += push.hoop * hoop[a];
                }
                force[at + i] += along;
            }
        }
    }
}

/// A point of the pore space in the integrals.
#[derive(Debug, Clone, Copy)]
pub(super) struct PorePart<const D: usize> {
    /// Functions of the displacement.
    pub soil: Stencil<D>,
    /// Functions of the pressure.
    pub water: Stencil<D>,
    /// Volume, m3.
    pub weight: f64,
    /// Porosity n when the mesh was built.
    pub porosity: f64,
    /// Its layer.
    pub mark: u8,
}

/// A face between two cells of constant pressure, or between a cell and a drained side.
#[derive(Debug, Clone, Copy)]
pub(super) struct FacePart {
    /// Cell below, cell above; [`HELD`] outside.
    pub cells: [u32; 2],
    /// Axis it is normal to.
    pub axis: usize,
    /// Area, m2.
    pub area: f64,
    /// Distance to the middle of each cell, m.
    pub reach: [f64; 2],
    /// Soil of each cell, and its porosity when the mesh was built.
    pub marks: [u8; 2],
    pub porosity: [f64; 2],
    /// Pressure of the water outside, Pa.
    pub outside: f64,
}

/// Constants of the water and of the weight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fluid<const D: usize> {
    /// k/gamma_w, m4/(N s).
    pub mobility: f64,
    /// 1/K_w, 1/Pa.
    pub compressibility: f64,
    /// rho_w, kg/m3.
    pub density: f64,
    /// g, m/s2.
    pub gravity: Option<[f64; D]>,
}

/// Values at given unknowns.
#[derive(Debug, Clone, Default)]
pub(super) struct Values {
    /// Out-of-balance force per displacement function and direction, without the load, N.
    pub force: Vec<f64>,
    /// Water content per pressure function, m3.
    pub content: Vec<f64>,
    /// Flow out of each pressure function, m3/s.
    pub flow: Vec<f64>,
    /// Water that leaves through drained faces and wells, m3/s.
    pub outflow: f64,
    /// Friction in the pores, W.
    pub dissipation: f64,
    /// Work of gravity on the flow, W.
    pub body_work: f64,
    /// Work of the water outside and of wells on what they press in, W.
    pub pressed_in: f64,
    /// Rates of inertia and of weight, but loads and supports.
    pub rates: Impulses,
}

/// Impulses (N s, x and y) and energies (J) of a step with inertia; or their rates, N and W.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Impulses {
    /// Energy and momentum that soil and water gain.
    pub kinetic: f64,
    pub momentum: [f64; 2],
    /// What damping takes of the energy, and its impulse.
    pub damping: f64,
    pub damping_force: [f64; 2],
    /// Impulses of loads, weight and supports.
    pub load: [f64; 2],
    pub weight: [f64; 2],
    pub support: [f64; 2],
    /// Work of plates that are moved.
    pub plates: f64,
}

impl Impulses {
    /// Adds some for a time, s.
    pub fn add(&mut self, time: f64, other: &Self) {
        self.kinetic += time * other.kinetic;
        self.damping += time * other.damping;
        self.plates += time * other.plates;
        let pairs = [
            (&mut self.momentum, other.momentum),
            (&mut self.damping_force, other.damping_force),
            (&mut self.load, other.load),
            (&mut self.weight, other.weight),
            (&mut self.support, other.support),
        ];
        for (sum, of) in pairs {
            (0..2).for_each(|d| sum[d] += time * of[d]);
        }
    }
}

/// The pressure functions of a well with their shares of its rate, it, and a number of it.
pub(super) type Source = (Vec<(u32, f64)>, Well, f64);

/// Where water stands before the soil.
#[derive(Debug, Clone, Copy)]
pub(super) enum Before {
    /// At a pressure function that it holds.
    Function(u32),
    /// At a face between a cell and the outside.
    Face(u32),
}

/// An element with det F <= 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct InsideOut<const D: usize> {
    /// Number of the solid or pore point.
    pub point: usize,
}

/// The soil on its mesh.
#[derive(Debug)]
pub(super) struct Soil<L: Law, const D: usize> {
    pub axes: [Axis; D],
    pub law: Materials<L>,
    pub small: bool,
    pub solid: Vec<SolidPart<D>>,
    pub pore: Vec<PorePart<D>>,
    pub faces: Vec<FacePart>,
    pub fluid: Fluid<D>,
    /// Jump penalty on dp/dt: (function, function, value), both triangles.
    pub jumps: Vec<(u32, u32, f64)>,
    /// Unknown of each displacement function and direction.
    pub soil_map: Vec<[u32; D]>,
    /// Unknown of each pressure function.
    pub water_map: Vec<u32>,
    /// Force of the loads now per displacement function and direction, N.
    pub load: Vec<f64>,
    /// The loads: force where the factor is 1, and its course in time.
    pub loads: Vec<(Vec<f64>, Course)>,
    /// Functions that go with a plate that is moved, with the axis, the direction into the soil along it (or 0) and the plate.
    pub moved: Vec<(u32, usize, f64, u16)>,
    /// The plates, how far each has moved since the mesh was built, and how far it had moved then, m.
    pub plates: Vec<(MovedPlate, [f64; 2])>,
    /// Where water stands before the soil: there, sampled at a place (m), the load of the scene, the weight of the sample.
    pub before: Vec<(Before, [f64; 2], u16, f64)>,
    /// The loads of the scene, and the weight of water, N/m3.
    pub outside: (Vec<FaceLoad>, f64),
    /// Wells: pressure functions with their shares, the well, what it takes now (m3/s).
    pub wells: Vec<Source>,
    /// Pressure of functions that are fixed, Pa; empty where all are fixed at zero.
    pub held_pressure: Vec<f64>,
    /// Displacements (m) and pressures (Pa) of the functions at the unknowns of the last evaluation.
    pub u: Vec<[f64; D]>,
    pub p: Vec<f64>,
    pub values: Values,
    /// Length (m) and pressure (Pa) that make the unknowns numbers of the same size.
    pub scales: [f64; 2],
    pub system: System,
    /// What the parts push with at the last evaluation, where those of a cell share their work; else empty.
    pub pushes: Vec<Push<D>>,
    /// Room for those of a cell.
    pub grouped: Vec<Push<D>>,
    /// The parts of each cell, where they are too few for weights of their own.
    pub groups: Vec<Group>,
    /// Velocities and accelerations, where inertia counts.
    pub motion: Option<Box<Motion<D>>>,
    /// Mean gradient of displacement per cell, for the faces.
    pub cell_gradient: Vec<([[f64; D]; D], f64)>,
}

impl<L: Law, const D: usize> Soil<L, D> {
    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.system.matrix.size()
    }

    /// Energy stored per volume when the mesh was built (J/m3), and J times the stress that stores it (Pa), of soil of a layer
    /// with a stress (Pa) and a strain.
    pub fn stored(&self, mark: u8, stress: &[f64; 4], strain: &[f64; 4]) -> (f64, [f64; 4]) {
        let law = self.law.law(mark);
        if self.small {
            return (law.energy(stress), *stress);
        }
        let volume = (strain[0] + strain[1] + strain[2]).exp();
        (volume * law.finite_energy(stress), map_of(stress, |s| volume * s))
    }

    /// Puts on the loads of a time since the start of the run; sudden ones grow within a `ramp`, both s.
    pub fn bear(&mut self, time: f64, ramp: f64) {
        let Self { load, loads, before, outside: (outside, weight), held_pressure, faces, plates, wells, .. } = self;
        wells.iter_mut().for_each(|(_, well, rate)| *rate = well.rate * well.course.at(time, 0.0));
        plates.iter_mut().for_each(|(plate, [moved, before])| *moved = plate.at(time) - *before);
        let mut set = |at: &Before, to: &dyn Fn(f64) -> f64| {
            let there = match at {
                Before::Function(function) => &mut held_pressure[*function as usize],
                Before::Face(face) => &mut faces[*face as usize].outside,
            };
            *there = to(*there);
        };
        before.iter().for_each(|(at, ..)| set(at, &|_| 0.0));
        for (at, place, which, weight_of) in &*before {
            let pressure = outside[usize::from(*which)].of_water(place, time, *weight).unwrap_or(0.0);
            set(at, &|there| there + weight_of * pressure);
        }
        for (i, (force, course)) in loads.iter().enumerate() {
            let factor = match course {
                Course::Constant if time < ramp => time / ramp,
                course => course.at(time, 0.0),
            };
            if i == 0 {
                load.iter_mut().zip(force).for_each(|(load, force)| *load = factor * force);
            } else {
                load.iter_mut().zip(force).for_each(|(load, force)| *load += factor * force);
            }
        }
    }

    /// The first part of the cell of a part that shares its work with the others there, and its shares, m3.
    pub fn group_of(&self, point: usize) -> Option<(usize, &[f64])> {
        let at = self.groups.partition_point(|group| group.first + group.count <= point);
        let Group { first, count, shares } = self.groups.get(at)?;
        Some((*first, &shares[(point - first) * count..][..*count]))
    }

    /// Whether forces, content and flow are linear in the unknowns.
    pub fn linear(&self) -> bool {
        self.small && self.law.are_linear()
    }

    /// Sum over the pressure functions that are fixed at zero.
    pub fn held(&self, values: &[f64]) -> f64 {
        values.iter().zip(&self.water_map).filter(|(_, map)| **map == HELD).map(|(value, _)| value).sum()
    }

    /// Mass of soil and water per volume of a pore part whose pores are a share of its first volume, kg/m3.
    pub fn mass_of(&self, part: &PorePart<D>, pores: f64) -> f64 {
        (1.0 - part.porosity) / self.law.soils.kind(part.mark).grain_inverse + pores * self.fluid.density
    }

    /// Work of gravity on the displacements in [`Self::u`] with the water of the start, J.
    pub fn weight_work(&self) -> f64 {
        let Some(g) = self.fluid.gravity else { return 0.0 };
        let work = |part: &PorePart<D>| {
            let u = part.soil.vector(&self.u);
            part.weight * self.mass_of(part, part.porosity) * (0..D).map(|d| g[d] * u[d]).sum::<f64>()
        };
        self.pore.iter().map(work).sum()
    }

    /// Displacements and pressures from the unknowns.
    pub fn expand(&mut self, y: &[f64]) {
        let [length, pressure] = self.scales;
        for (u, map) in self.u.iter_mut().zip(&self.soil_map) {
            for d in 0..D {
                u[d] = if map[d] == HELD { 0.0 } else { length * y[map[d] as usize] };
            }
        }
        for (p, map) in self.p.iter_mut().zip(&self.water_map) {
            *p = if *map == HELD { 0.0 } else { pressure * y[*map as usize] };
        }
        for (function, axis, inwards, plate) in &self.moved {
            self.u[*function as usize][*axis] = inwards * self.plates[usize::from(*plate)].1[0];
        }
        let held = self.p.iter_mut().zip(&self.water_map).zip(&self.held_pressure);
        held.filter(|((_, map), _)| **map == HELD).for_each(|((p, _), held)| *p = *held);
    }

    /// Forces of the plates on the soil at the last evaluation, N.
    pub fn pushed(&self) -> Vec<[f64; 2]> {
        let mut forces = vec![[0.0; 2]; self.plates.len()];
        for (function, axis, _, plate) in &self.moved {
            let at = *function as usize * D + axis;
            forces[usize::from(*plate)][axis + 2 - D] += self.values.force[at] - self.load[at];
        }
        forces
    }

    /// Rates of what inertia has to do with, at the last evaluation.
    pub fn impulses(&self) -> Impulses {
        let mut rates = self.values.rates;
        for (function, map) in self.soil_map.iter().enumerate() {
            for d in 0..D {
                let load = self.load[function * D + d];
                rates.load[d + 2 - D] += load;
                if map[d] == HELD {
                    rates.support[d + 2 - D] += self.values.force[function * D + d] - load;
                }
            }
        }
        for (function, axis, ..) in &self.moved {
            let at = *function as usize * D + axis;
            let along = self.motion.as_ref().map_or(0.0, |motion| motion.velocity_of(*function)[*axis]);
            rates.plates += (self.values.force[at] - self.load[at]) * along;
        }
        rates
    }

    /// Power of the water outside that acts on functions which are fixed, from what it gives each, W or J.
    pub fn pressed_in(&self, given: impl Iterator<Item = f64>) -> f64 {
        let held = given.zip(&self.held_pressure).zip(&self.water_map).filter(|(_, map)| **map == HELD);
        held.map(|((given, pressure), _)| given * pressure).sum()
    }

    /// The unknowns of the displacements and pressures in [`Self::u`] and [`Self::p`]: [`Self::expand`] turned round.
    pub fn unknowns_of_fields(&self) -> Vec<f64> {
        let [length, pressure] = self.scales;
        let mut y = vec![0.0; self.unknowns()];
        for (u, map) in self.u.iter().zip(&self.soil_map) {
            for d in (0..D).filter(|d| map[*d] != HELD) {
                y[map[d] as usize] = u[d] / length;
            }
        }
        for (p, map) in self.p.iter().zip(&self.water_map).filter(|(_, map)| **map != HELD) {
            y[*map as usize] = p / pressure;
        }
        y
    }

    /// Forces, content and flow at the unknowns, into [`Self::values`].
    pub fn evaluate(&mut self, y: &[f64]) -> Result<(), InsideOut<D>> {
        self.expand(y);
        self.evaluate_fields()
    }

    /// The same at the displacements and pressures that stand in [`Self::u`] and [`Self::p`].
    pub fn evaluate_fields(&mut self) -> Result<(), InsideOut<D>> {
        let v = &mut self.values;
        v.force.fill(0.0);
        v.content.fill(0.0);
        v.flow.fill(0.0);
        (v.outflow, v.dissipation, v.body_work, v.pressed_in) = (0.0, 0.0, 0.0, 0.0);
        v.rates = Impulses::default();
        if let Some(motion) = &mut self.motion {
            motion.evaluate(&self.u);
        }
        self.skeleton()?;
        self.pores()?;
        self.through_faces()?;
        for &(a, b, value) in &self.jumps {
            self.values.content[a as usize] += value * self.p[b as usize];
        }
        for (functions, _, rate) in &self.wells {
            for &(function, share) in functions {
                self.values.flow[function as usize] += rate * share;
                self.values.pressed_in -= rate * share * self.p[function as usize];
            }
            self.values.outflow += rate;
        }
        Ok(())
    }

    /// Flow alone, at the pressures in [`Self::p`]; small strain.
    pub fn flow_of_fields(&mut self) -> Result<(), InsideOut<D>> {
        self.values.flow.fill(0.0);
        self.values.outflow = 0.0;
        if self.faces.is_empty() {
            for part in &self.pore {
                let (slope, mobility) = (part.water.slope_of(&self.p), self.mobility(part, 0.0));
                let flux: [f64; D] = array_of(|i| (0..D).map(|j| mobility[i][j] * slope[j]).sum());
                for b in 0..part.water.count {
                    let along: f64 = (0..D).map(|d| flux[d] * part.water.slope[b][d]).sum();
                    self.values.flow[part.water.number[b] as usize] += part.weight * along;
                }
            }
        }
        self.through_faces()
    }

    /// Water content of the functions whose pressure is fixed, at the fields in [`Self::u`] and [`Self::p`], m3; small strain, linear.
    pub fn held_content(&self) -> f64 {
        let is_held = |function: u32| self.water_map[function as usize] == HELD;
        let mut held = 0.0;
        for part in &self.pore {
            let share = (0..part.water.count).filter(|b| is_held(part.water.number[*b])).map(|b| part.water.value[b]);
            let share: f64 = share.sum();
            if share != 0.0 {
                let change = self.opened(part).unwrap_or(0.0);
                held += share * part.weight * self.content_of(part, change);
            }
        }
        let jumps = self.jumps.iter().filter(|(a, ..)| is_held(*a));
        held + jumps.map(|(_, b, value)| value * self.p[*b as usize]).sum::<f64>()
    }

    /// Water content of a pore part per volume whose pores have opened by a share of it.
    #[inline(always)]
    fn content_of(&self, part: &PorePart<D>, change: f64) -> f64 {
        let pressure = part.water.scalar(&self.p);
        let pores = if self.small { part.porosity } else { change + part.porosity };
        let [alpha, of_grains] = self.law.soils.kind(part.mark).biot;
        alpha * change + pores * self.denser(pressure) + of_grains * pressure
    }

    /// A solid part at the displacements in [`Self::u`].
    pub fn strained(&self, part: &SolidPart<D>) -> Option<Strained<D>> {
        let gradient = part.stencil.gradient(&self.u);
        // B-bar (Hughes 1980, doi:10.1002/nme.1620150914): the change of volume at the centre in place of the particle's.
        let at_centre = part.dilates.as_ref().map(|slope| part.stencil.gradient_with(slope, &self.u));
        if self.small {
            let strain = self.small_strain(part, &gradient, at_centre.as_ref());
            let (stress, state, flow) = self.updated(part, &strain);
            let (mean, deviator) = split(&stress, at_centre.is_some());
            let at_centre = at_centre.map(|_| (mean, identity()));
            let push = Push {
                piola: tensor(&deviator),
                hoop: deviator[2],
                at_centre,
                inverse: identity(),
                rotation: identity(),
            };
            return Some(Strained { push, strain, stress, state, flow });
        }
        let mut own = stretch(&gradient)?;
        let at_centre = match at_centre {
            Some(centre) => Some(stretch(&centre)?),
            None => None,
        };
        if let Some(centre) = &at_centre {
            let more = (centre.volume / own.volume).ln() / 3.0;
            own.strain[..3].iter_mut().for_each(|strain| *strain += more);
        }
        let stretch = own;
        let (stress, state, flow) = self.updated(part, &stretch.strain);
        let (mean, deviator) = split(&stress, at_centre.is_some());
        let at_centre = at_centre.map(|centre| (mean * stretch.volume, centre.inverse));
        let sigma = tensor::<D>(&turned(&deviator, &stretch.rotation));
        // P = J sigma F^-T
        let mut piola = [[0.0; D]; D];
        for i in 0..D {
            for j in 0..D {
                for k in 0..D {
                    piola[i][j] += stretch.volume * sigma[i][k] * stretch.inverse[j][k];
                }
            }
        }
        let push = Push { piola, hoop: 0.0, at_centre, inverse: stretch.inverse, rotation: stretch.rotation };
        Some(Strained { push, strain: stretch.strain, stress, state, flow })
    }

    /// The strain of a part with a gradient of displacement, and with one at the centre of its cell if that dilates it.
    fn small_strain(&self, part: &SolidPart<D>, gradient: &[[f64; D]; D], centre: Option<&[[f64; D]; D]>) -> [f64; 4] {
        let mut strain = [0.0; 4];
        for d in 0..D {
            let mut direction = [0.0; D];
            direction[d] = 1.0;
            let mode = strain_mode(&gradient[d], &direction);
            for s in 0..4 {
                strain[s] += mode[s];
            }
        }
        if let Some(hoop) = &part.hoop {
            let of = |a: usize| hoop[a] * self.u[part.stencil.number[a] as usize][0];
            strain[2] = (0..part.stencil.count).map(of).sum();
        }
        if let Some(centre) = centre {
            let more = ((0..D).map(|d| centre[d][d] - gradient[d][d]).sum::<f64>() - strain[2]) / 3.0;
            strain[..3].iter_mut().for_each(|strain| *strain += more);
        }
        strain
    }

    /// Effective stress of a part before rotation, its vertical component as it stands (Pa), and det F.
    pub fn stressed(&self, part: &SolidPart<D>) -> Option<([f64; 4], f64, f64)> {
        let gradient = part.stencil.gradient(&self.u);
        if self.small {
            let centre = part.dilates.as_ref().map(|slope| part.stencil.gradient_with(slope, &self.u));
            let strain = self.small_strain(part, &gradient, centre.as_ref());
            let (stress, ..) = self.updated(part, &strain);
            return Some((stress, stress[1], 1.0));
        }
        let Strained { push, stress, .. } = self.strained(part)?;
        Some((stress, turned(&stress, &push.rotation)[1], stretch(&gradient)?.volume))
    }

    fn updated(&self, part: &SolidPart<D>, strain: &[f64; 4]) -> ([f64; 4], State, Flow) {
        let (mut stress, mut state) = (part.stress, part.state);
        let more = array_of(|s| strain[s] - part.strain[s]);
        let flow = self.law.law(part.mark).update(&mut stress, &more, &mut state);
        (stress, state, flow)
    }

    /// A part at the end of a step that strained it so, and how far its law's single step along that strain is off, Pa: an implicit
    /// return is of first order along the path. Half steps, halved until they are within an error (Pa), and Richardson's
    /// extrapolation are of second order, and what the single step left to the balance of forces is made good in the next step, so
    /// that errors do not add up.
    pub fn followed(&self, part: &SolidPart<D>, end: &Strained<D>, allowed: f64) -> (End, f64) {
        let law = self.law.law(part.mark);
        let norm = |x: &[f64; 4]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (mut stress, mut state, mut flow) = (end.stress, end.state, end.flow);
        let mut count = if law.is_linear() { MOST_PARTS } else { 1 };
        while count < MOST_PARTS {
            count *= 2;
            let strain = array_of(|s| (end.strain[s] - part.strain[s]) / f64::from(count));
            let before = (stress, state);
            (stress, state) = (part.stress, part.state);
            for _ in 0..count {
                flow = law.update(&mut stress, &strain, &mut state);
            }
            let apart: [f64; 4] = array_of(|s| stress[s] - before.0[s]);
            // Of parts that are further apart no limit can be told.
            if norm(&apart) <= MOST_APART * norm(&stress) && (norm(&apart) <= allowed || count == MOST_PARTS) {
                (0..4).for_each(|s| stress[s] += apart[s]);
                (0..STATES).for_each(|s| state[s] += state[s] - before.1[s]);
                flow = law.update(&mut stress, &[0.0; 4], &mut state);
                break;
            }
        }
        let off = norm(&array_of(|s| stress[s] - end.stress[s]));
        (End { strain: end.strain, stress, state, flow }, off)
    }

    fn skeleton(&mut self) -> Result<(), InsideOut<D>> {
        for point in 0..self.solid.len() {
            let part = &self.solid[point];
            let Strained { mut push, .. } = self.strained(part).ok_or(InsideOut { point })?;
            push.times(part.weight);
            match self.pushes.get_mut(point) {
                Some(kept) => *kept = push,
                None => part.give(&push, &mut self.values.force),
            }
        }
        for Group { first, count, shares } in &self.groups {
            let of = &mut self.grouped;
            of.clear();
            of.extend_from_slice(&self.pushes[*first..first + count]);
            for i in 0..*count {
                let mut sum = Push { piola: [[0.0; D]; D], ..of[i] };
                for j in 0..*count {
                    let share = shares[i * count + j] / self.solid[first + j].weight;
                    for (sum, of) in sum.piola.as_flattened_mut().iter_mut().zip(of[j].piola.as_flattened()) {
                        *sum += share * of;
                    }
                }
                self.pushes[first + i] = sum;
            }
        }
        for (part, push) in self.solid.iter().zip(&self.pushes) {
            part.give(push, &mut self.values.force);
        }
        Ok(())
    }

    /// The stretch of a pore point; `None` if it is inverted, det F <= 0.
    pub fn pore_state(&self, part: &PorePart<D>) -> Option<PoreState<D>> {
        let gradient = part.soil.gradient(&self.u);
        if self.small {
            let change = (0..D).map(|d| gradient[d][d]).sum();
            return Some(PoreState { change, cofactor: identity(), gradient });
        }
        let stretch = stretch(&gradient)?;
        // det(I + g) - 1 without cancellation.
        let mut change: f64 = (0..D).map(|d| gradient[d][d]).sum();
        if D == 2 {
            change += gradient[0][0] * gradient[1][1] - gradient[0][1] * gradient[1][0];
        }
        let cofactor = scaled(&stretch.inverse, stretch.volume);
        Some(PoreState { change, cofactor, gradient })
    }

    /// J - 1 of a pore point; `None` if it is inverted.
    pub fn opened(&self, part: &PorePart<D>) -> Option<f64> {
        if !self.small {
            return self.pore_state(part).map(|state| state.change);
        }
        let mut along = [0.0; D];
        for (number, slope) in part.soil.number.iter().zip(&part.soil.slope).take(part.soil.count) {
            let u = &self.u[*number as usize];
            (0..D).for_each(|d| along[d] += u[d] * slope[d]);
        }
        Some(along.iter().sum())
    }

    /// rho/rho_0 - 1 of the water at a pressure (Pa).
    #[inline(always)]
    pub fn denser(&self, pressure: f64) -> f64 {
        let strain = pressure * self.fluid.compressibility;
        if self.small { strain } else { strain.exp_m1() }
    }

    /// k/gamma_w at a pore part whose volume has changed by a share J - 1, m4/(N s).
    #[inline(always)]
    pub fn mobility(&self, part: &PorePart<D>, change: f64) -> [[f64; D]; D] {
        let kind = self.law.soils.kind(part.mark);
        let mobility = self.fluid.mobility * at_porosity(kind.by_porosity, (part.porosity + change) / (1.0 + change));
        let [x, y, across] = map_of(&kind.conductivity, |ratio| mobility * ratio);
        let along = |i: usize| if i + 2 - D == 0 { x } else { y };
        array_of(|i| array_of(|j| if i == j { along(i) } else { across }))
    }

    /// K of a pore part; water with an acceleration of its own flows in a stage of a = gamma dt (s) as through less of it.
    pub fn conductivity_of(&self, part: &PorePart<D>, state: &PoreState<D>, own: Option<f64>) -> [[f64; D]; D] {
        let mut through = self.mobility(part, state.change);
        if let Some(a) = own {
            through = dragged(&through, self.drag(part, state, a));
        }
        conductivity(&state.cofactor, if self.small { 0.0 } else { state.change }, &through)
    }

    /// Inertia of the water beside its friction, `rho_w/(n a)` in the pores as they are, kg/(m3 s).
    fn drag(&self, part: &PorePart<D>, state: &PoreState<D>, a: f64) -> f64 {
        let pores = if self.small { part.porosity } else { (part.porosity + state.change) / (1.0 + state.change) };
        self.fluid.density / (pores * a)
    }

    fn pores(&mut self) -> Result<(), InsideOut<D>> {
        let mut motion = self.motion.take();
        let moving = motion.as_deref_mut().filter(|motion| motion.a > 0.0);
        if let Some(motion) = &moving {
            self.values.rates.damping += motion.resist(&mut self.values.force);
        }
        let found = self.pores_that(moving);
        self.motion = motion;
        found
    }

    fn pores_that(&mut self, mut motion: Option<&mut Motion<D>>) -> Result<(), InsideOut<D>> {
        let by_cells = !self.faces.is_empty();
        if by_cells && !self.small {
            self.cell_gradient.fill(([[0.0; D]; D], 0.0));
        }
        for point in 0..self.pore.len() {
            let part = &self.pore[point];
            let PoreState { change, cofactor, gradient } = self.pore_state(part).ok_or(InsideOut { point })?;
            let pressure = part.water.scalar(&self.p);
            let Fluid { density, gravity, .. } = self.fluid;
            let pores = if self.small { part.porosity } else { change + part.porosity };
            let (more, alpha) = (self.denser(pressure), self.law.soils.kind(part.mark).biot[0]);
            let content = self.content_of(part, change);
            let mut body = gravity.map_or([0.0; D], |g| {
                let mass = self.mass_of(part, pores);
                map_of(&g, |g| mass * g)
            });
            // What pushes the water, m/s2.
            let mut pull = gravity;
            if let Some(motion) = motion.as_deref() {
                let (moving, mass) = (motion.at(&part.soil), self.mass_of(part, pores));
                let values = &mut self.values.rates;
                for d in 0..D {
                    values.weight[d + 2 - D] += part.weight * body[d];
                    let (v, rate) = (moving.velocity[d], mass * moving.acceleration[d]);
                    let taken = mass * motion.damping * v;
                    body[d] -= rate + taken;
                    values.kinetic += part.weight * rate * v;
                    values.momentum[d + 2 - D] += part.weight * rate;
                    values.damping += part.weight * taken * v;
                    values.damping_force[d + 2 - D] -= part.weight * taken;
                }
                if motion.inertia != WaterInertia::None {
                    let g = gravity.unwrap_or([0.0; D]);
                    pull = Some(array_of(|d| g[d] - moving.acceleration[d]));
                }
            }
            let (part, state) = (&self.pore[point], PoreState { change, cofactor, gradient });
            let weight =
                |g: Option<[f64; D]>| g.map_or([0.0; D], |g| turned_back(&state, self.small, &g).map(|g| density * g));
            let mut flux = [0.0; D];
            if !by_cells {
                // Darcy: K (grad p - rho_w F^T g), with K = (k/gamma_w) (J F^-1) (J F^-1)^T / J.
                let slope = part.water.slope_of(&self.p);
                let heavy = weight(pull);
                let mut push: [f64; D] = array_of(|d| slope[d] - heavy[d]);
                let from = motion.as_deref().and_then(|motion| Some((motion.flux_from(point)?, motion.a)));
                if let Some((from, a)) = &from {
                    let (drag, before) = (self.drag(part, &state, *a), metric(&state, self.small, from));
                    (0..D).for_each(|d| push[d] -= drag * before[d]);
                }
                let conductivity = self.conductivity_of(part, &state, from.map(|(_, a)| a));
                flux = array_of(|i| (0..D).map(|j| conductivity[i][j] * push[j]).sum());
                let mut friction: [f64; D] = array_of(|d| slope[d] - heavy[d]);
                let mut worked = heavy;
                if let (Some((_, a)), Some(motion)) = (from, motion.as_deref_mut()) {
                    // The flux of the water is against that of the balance of water.
                    let moving = motion.at(&part.soil);
                    let rate = motion.flows(point, &map_of(&flux, |w| -w));
                    let (along, own) = (forward(&state, self.small, &rate), metric(&state, self.small, &rate));
                    let drag = self.drag(part, &state, a);
                    worked = weight(gravity);
                    for d in 0..D {
                        let lost = density * along[d];
                        body[d] -= lost;
                        friction[d] += drag * a * own[d];
                        let values = &mut self.values.rates;
                        values.momentum[d + 2 - D] += part.weight * lost;
                        let with_water = -flux[d] * (drag * a * own[d] + worked[d] - heavy[d]);
                        values.kinetic += part.weight * (lost * moving.velocity[d] + with_water);
                    }
                }
                for d in 0..D {
                    self.values.dissipation += part.weight * flux[d] * friction[d];
                    self.values.body_work -= part.weight * flux[d] * worked[d];
                }
            }
            let values = &mut self.values;
            for a in 0..part.soil.count {
                let at = part.soil.number[a] as usize * D;
                for i in 0..D {
                    // int p J F^-T grad N
                    let spread: f64 = (0..D).map(|j| cofactor[j][i] * part.soil.slope[a][j]).sum();
                    values.force[at + i] -= part.weight * (alpha * pressure * spread + body[i] * part.soil.value[a]);
                }
            }
            for b in 0..part.water.count {
                values.content[part.water.number[b] as usize] += part.weight * content * part.water.value[b];
            }
            if by_cells {
                if !self.small {
                    let mean = &mut self.cell_gradient[part.water.number[0] as usize];
                    mean.1 += part.weight;
                    for i in 0..D {
                        for j in 0..D {
                            mean.0[i][j] += part.weight * gradient[i][j];
                        }
                    }
                }
                continue;
            }
            let ratio = if self.small { 1.0 } else { 1.0 + more };
            for b in 0..part.water.count {
                let along: f64 = (0..D).map(|d| flux[d] * part.water.slope[b][d]).sum();
                values.flow[part.water.number[b] as usize] += ratio * part.weight * along;
            }
        }
        Ok(())
    }

    /// Conductance of a face, m3/(s Pa), and the drop of rho_w g across it, Pa.
    pub fn face_state(&self, face: &FacePart) -> Option<(f64, f64)> {
        let (mut resistance, mut weight) = (0.0, 0.0);
        let gravity = self.fluid.gravity.map_or(0.0, |g| g[face.axis]);
        for i in 0..2 {
            let (cell, reach, kind) = (&face.cells[i], face.reach[i], self.law.soils.kind(face.marks[i]));
            if reach == 0.0 {
                continue; // outside
            }
            let (mut normal, mut along, mut pores) = (1.0, 1.0, face.porosity[i]);
            if !self.small {
                let (sum, volume) = &self.cell_gradient[*cell as usize];
                let gradient = map_of(sum, |row| map_of(&row, |g| g / volume));
                let found = stretch(&gradient)?;
                let cofactor = scaled(&found.inverse, found.volume);
                normal = conductivity(&cofactor, found.volume - 1.0, &identity())[face.axis][face.axis];
                along = 1.0 + gradient[face.axis][face.axis];
                pores = 1.0 - (1.0 - pores) / found.volume;
            }
            resistance += reach / (normal * kind.along(face.axis, D) * at_porosity(kind.by_porosity, pores));
            weight += self.fluid.density * gravity * along * reach;
        }
        Some((self.fluid.mobility * face.area / resistance, weight))
    }

    /// What errors of the rates of a step leave out of balance in its last stage, into a right-hand side scaled as the matrix.
    pub fn unbalanced(&self, rhs: &mut [f64]) {
        let Some(motion) = &self.motion else { return };
        let ([length, pressure], (nodal, pore), density) = (self.scales, &motion.errors, self.fluid.density);
        for (point, part) in self.pore.iter().enumerate() {
            let Some(state) = self.pore_state(part) else { continue };
            let pores = if self.small { part.porosity } else { state.change + part.porosity };
            let rate = part.soil.vector(nodal);
            let mut force = map_of(&rate, |rate| self.mass_of(part, pores) * rate);
            let mut flux = [0.0; D];
            if motion.inertia != WaterInertia::None {
                let mut push = map_of(&turned_back(&state, self.small, &rate), |rate| density * rate);
                let own = (motion.inertia == WaterInertia::Own).then_some(motion.a);
                if let Some(a) = own {
                    let (drag, own) = (self.drag(part, &state, a), metric(&state, self.small, &pore[point]));
                    (0..D).for_each(|d| push[d] += drag * own[d]);
                }
                let conductivity = self.conductivity_of(part, &state, own);
                flux = array_of(|i| (0..D).map(|j| conductivity[i][j] * push[j]).sum());
                if motion.inertia == WaterInertia::Own {
                    let rate = array_of(|d| (flux[d] - pore[point][d]) / motion.a);
                    let along = forward(&state, self.small, &rate);
                    (0..D).for_each(|d| force[d] -= density * along[d]);
                }
            }
            for a in 0..part.soil.count {
                for (d, unknown) in self.soil_map[part.soil.number[a] as usize].iter().enumerate() {
                    if *unknown != HELD {
                        rhs[*unknown as usize] += length * part.weight * part.soil.value[a] * force[d];
                    }
                }
            }
            for b in 0..part.water.count {
                let unknown = self.water_map[part.water.number[b] as usize];
                if unknown != HELD {
                    let along: f64 = (0..D).map(|d| flux[d] * part.water.slope[b][d]).sum();
                    rhs[unknown as usize] -= pressure * motion.a * part.weight * along;
                }
            }
        }
    }

    fn through_faces(&mut self) -> Result<(), InsideOut<D>> {
        for number in 0..self.faces.len() {
            let face = self.faces[number];
            let (conductance, weight) = self.face_state(&face).ok_or(InsideOut { point: number })?;
            let pressure = |cell: u32| if cell == HELD { face.outside } else { self.p[cell as usize] };
            // Eq. (1) on a face, upwards: p below - p above + rho_w g distance.
            let head = pressure(face.cells[0]) - pressure(face.cells[1]) + weight;
            let flux = conductance * head;
            self.values.dissipation += flux * head;
            self.values.body_work += flux * weight;
            // Water between two cells has the mean of their densities, and that under no pressure at a drained side.
            let ratio = match face.cells {
                [HELD, _] | [_, HELD] => 1.0,
                _ if self.small => 1.0,
                [a, b] => 1.0 + 0.5 * (self.denser(pressure(a)) + self.denser(pressure(b))),
            };
            let flux = ratio * flux;
            for (cell, sign) in face.cells.into_iter().zip([1.0, -1.0]) {
                if cell == HELD {
                    self.values.outflow -= sign * flux;
                    self.values.pressed_in += sign * flux * face.outside;
                } else {
                    self.values.flow[cell as usize] += sign * flux;
                }
            }
        }
        Ok(())
    }
}

/// Stretch of a pore point.
#[derive(Debug, Clone, Copy)]
pub(super) struct PoreState<const D: usize> {
    /// J - 1; small strain: div u.
    pub change: f64,
    /// J F^-1; small strain: I.
    pub cofactor: [[f64; D]; D],
    /// grad u.
    pub gradient: [[f64; D]; D],
}

/// A solid part at given displacements: what it pushes with, and strain, stress (Pa) and state before rotation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strained<const D: usize> {
    pub push: Push<D>,
    pub strain: [f64; 4],
    pub stress: [f64; 4],
    pub state: State,
    pub flow: Flow,
}

/// A solid part at the end of a step: strain, stress (Pa) and state before rotation, and what its law did.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    pub strain: [f64; 4],
    pub stress: [f64; 4],
    pub state: State,
    pub flow: Flow,
}

/// What carries a stress back to the mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct Push<const D: usize> {
    /// First Piola-Kirchhoff stress, without the mean stress where that acts at the centre of the cell, Pa.
    pub piola: [[f64; D]; D],
    /// The same of its hoop component about an axis; small strain.
    pub hoop: f64,
    /// That mean stress times J (Pa), and F^-1 at the centre.
    pub at_centre: Option<(f64, [[f64; D]; D])>,
    /// F^-1.
    pub inverse: [[f64; D]; D],
    /// R.
    pub rotation: [[f64; D]; D],
}

/// F^T y, with F = I + grad u.
pub(super) fn turned_back<const D: usize>(state: &PoreState<D>, small: bool, y: &[f64; D]) -> [f64; D] {
    let turn = if small { 0.0 } else { 1.0 };
    array_of(|d| y[d] + turn * (0..D).map(|i| state.gradient[i][d] * y[i]).sum::<f64>())
}

impl<const D: usize> Default for Push<D> {
    fn default() -> Self {
        Self { piola: [[0.0; D]; D], hoop: 0.0, at_centre: None, inverse: identity(), rotation: identity() }
    }
}

impl<const D: usize> Push<D> {
    /// Makes forces (N m) of stresses that stand for a volume, m3.
    fn times(&mut self, volume: f64) {
        self.piola.as_flattened_mut().iter_mut().for_each(|stress| *stress *= volume);
        self.hoop *= volume;
        if let Some((mean, _)) = &mut self.at_centre {
            *mean *= volume;
        }
    }
}

/// Mean stress (Pa) and the rest, where they are wanted apart; else the whole as the rest.
fn split(stress: &[f64; 4], apart: bool) -> (f64, [f64; 4]) {
    let [xx, yy, zz, xy] = *stress;
    let mean = if apart { (xx + yy + zz) / 3.0 } else { 0.0 };
    (mean, [xx - mean, yy - mean, zz - mean, xy])
}

/// K = mobility J F^-1 F^-T from J F^-1 and J - 1.
pub(super) fn conductivity<const D: usize>(
    cofactor: &[[f64; D]; D],
    change: f64,
    mobility: &[[f64; D]; D],
) -> [[f64; D]; D] {
    let inverse = 1.0 / (1.0 + change);
    let half = |i: usize, k: usize| (0..D).map(|l| mobility[k][l] * cofactor[i][l]).sum::<f64>();
    array_of(|i| array_of(|j| inverse * (0..D).map(|k| cofactor[j][k] * half(i, k)).sum::<f64>()))
}

pub(super) fn identity<const D: usize>() -> [[f64; D]; D] {
    array_of(|i| array_of(|j| if i == j { 1.0 } else { 0.0 }))
}

/// A matrix times a number.
fn scaled<const D: usize>(matrix: &[[f64; D]; D], by: f64) -> [[f64; D]; D] {
    map_of(matrix, |row| map_of(&row, |x| x * by))
}

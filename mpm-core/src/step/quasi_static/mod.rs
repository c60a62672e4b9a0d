//! Implicit displacement and pressure, in steps of their own choice: the quasi-static integrator, and the implicit one, which has the
//! inertia of soil and water too.
//!
//! # Reading order
//! 1. `soil.rs`: the balance laws at given unknowns. `tangent.rs`: their matrix. `build.rs`: mesh, unknowns, points.
//!    `motion.rs`: what inertia adds to them.
//! 2. `newton.rs`: equilibrium. `sdirk.rs`: one step in time. `krylov.rs`: all times of a linear stage at once.
//! 3. `march.rs`: time marching through a stage. `remesh.rs`: from one mesh to the next. `results.rs`: results of the state.
//! 4. `failures.rs`: messages of runs that cannot continue. `checkpoint.rs`: what a resumed run needs.
//!
//! A mesh is built over the soil and moves with it (total Lagrangian), from stage to stage. Its state goes to the particles, and
//! a new mesh is built, when a particle was strained by more than `REMESH_STRAIN` on it and the surface is still level.

mod build;
mod checkpoint;
mod failures;
mod krylov;
mod march;
mod motion;
mod newton;
mod remesh;
mod results;
mod sdirk;
mod sites;
mod soil;
mod tangent;
#[cfg(test)]
mod tests;

pub(crate) use march::NEWTON;

use failures::{inverted, nothing};
use krylov::Krylov;
use newton::{Workspace, largest};
use sdirk::Sdirk;
use sites::Sites;
use soil::{End, Soil};

use serde::{Deserialize, Serialize};

use super::{Fault, Model, Work};
use crate::checkpoint::{Archive, RestoreError};
use crate::constitutive::{Law, Materials, State};
use crate::dimension::in_two;
use crate::observe::{BalanceTerms, Observation, Places, Push, SolidState, Totals};
use crate::particles::SolidPoint;
use crate::scene::{Integrator, Scene, SolidSide, Stage, StepChoice, StrainChoice, TimeMethod};

/// What a quasi-static run is made of.
#[derive(Debug)]
pub struct Seeding<L, const D: usize> {
    /// Solid particles at t = 0, cell by cell.
    pub points: Vec<SolidPoint<D>>,
    /// Law of the skeleton, or those of its layers.
    pub law: Materials<L>,
    /// Numbers of the particles of the top row.
    pub top: Vec<usize>,
    /// Lengths that are not modelled, multiplied: the width of a column or 1 m, m.
    pub thickness: f64,
    /// Pore pressure at a place (m) at t = 0, Pa.
    pub first_pressure: fn(&Scene, [f64; 2]) -> f64,
    /// Settlement of the state the run starts from, counted from the unloaded one, m.
    pub first_settlement: f64,
}

/// A run that solves for displacements. D: dimension, L: law.
#[derive(Debug)]
pub struct QuasiStatic<L: Law, const D: usize> {
    scene: Scene,
    seeding: Seeding<L, D>,
    /// Particles where they were when the mesh was built, with the stress they had.
    points: Vec<SolidPoint<D>>,
    /// What their soil remembered then.
    states: Vec<State>,
    /// Their displacement before that, m.
    carried: Vec<[f64; D]>,
    /// Volume change of the pore points before that, per volume; large strain has it in the particles' volumes.
    spent: Vec<f64>,
    /// Forces of stress and weight at t = 0 on the unknowns of the first mesh, scaled as they are; empty on later ones.
    loose: Vec<f64>,
    soil: Option<Soil<L, D>>,
    sites: Sites<D>,
    /// Unknowns and water content now.
    y: Vec<f64>,
    content: Vec<f64>,
    method: Option<Method>,
    work: Workspace,
    /// The soil at the end of a step that may be accepted, and what its laws did.
    ends: Vec<End>,
    /// Whether the last step was rejected; its length (s) and its estimated error along the path, if that was why.
    rejected: bool,
    rejected_path: Option<(f64, f64)>,
    /// Time within which the load grows, s.
    ramp: f64,
    /// Settlement per unknown, m.
    settle: Vec<(u32, f64)>,
    /// Weights of the plates in it.
    settle_with: Vec<(u16, f64)>,
    /// Settlement of the surface since t = 0 when the mesh was built, m.
    settled: f64,
    drained: [bool; 4],
    /// How the sides hold the soil in this stage.
    sides: [SolidSide; 4],
    time: f64,
    stage_time: f64,
    stage_end: f64,
    /// Where the steps of [`Model::advance`] lead, s since the start of the stage.
    until: f64,
    done: Work,
    totals: Totals<D>,
    /// What the plates that are moved do to the soil.
    pushes: Vec<Push>,
    counted: bool,
    /// Steps of the stage so far.
    started: u32,
    /// Whether errors of waves count in this stage, and the damping force per mass and velocity, 1/s.
    resolves: bool,
    damping: f64,
    /// Why the last rejected step was rejected.
    trouble: Option<String>,
}

/// How a stage is advanced.
#[derive(Debug, Serialize, Deserialize)]
enum Method {
    Krylov(Box<KrylovStage>),
    Sdirk {
        #[serde(skip)]
        stepper: Box<Sdirk>,
        step: f64,
        factored: f64,
    },
}

#[derive(Debug, Serialize, Deserialize)]
struct KrylovStage {
    evolution: Krylov,
    /// Content of the fixed functions when the stage began, m3.
    held: f64,
    /// Sums when the stage began: water that had left (m3), work of the load and friction in the pores (J).
    out_before: f64,
    work_before: f64,
    dissipation_before: f64,
}

impl KrylovStage {
    /// Whether it is one of a mesh with so many unknowns.
    fn fits(&self, unknowns: usize) -> bool {
        self.evolution.fits(unknowns)
    }
}

impl<L: Law, const D: usize> QuasiStatic<L, D> {
    /// A run at t = 0, its first stage not yet entered.
    pub fn new(scene: &Scene, seeding: Seeding<L, D>) -> Self {
        let count = seeding.points.len();
        let law = &seeding.law;
        let first = |point: &SolidPoint<D>| law.law(law.soils.at(&in_two(&point.x))).first_state(&point.stress);
        Self {
            states: seeding.points.iter().map(first).collect(),
            points: seeding.points.clone(),
            carried: vec![[0.0; D]; count],
            spent: Vec::new(),
            loose: Vec::new(),
            scene: scene.clone(),
            seeding,
            soil: None,
            sites: Sites::default(),
            y: Vec::new(),
            content: Vec::new(),
            method: None,
            work: Workspace::default(),
            ends: Vec::new(),
            rejected: false,
            rejected_path: None,
            ramp: 0.0,
            settle: Vec::new(),
            settle_with: Vec::new(),
            settled: 0.0,
            drained: [false; 4],
            sides: scene.solid_sides,
            time: 0.0,
            stage_time: 0.0,
            stage_end: 0.0,
            until: 0.0,
            done: Work::default(),
            totals: Totals::default(),
            pushes: vec![Push { force: Some([0.0; 2]), ..Push::default() }; scene.plates.len()],
            counted: false,
            started: 0,
            resolves: false,
            damping: 0.0,
            trouble: None,
        }
    }

    /// Whether waves that the steps do not follow are damped.
    fn damps(&self) -> bool {
        self.scene.integrator == Integrator::Implicit && !self.resolves
    }

    /// Settlement since the mesh was built, m.
    fn settlement_of(&self, y: &[f64]) -> f64 {
        self.settle.iter().map(|(unknown, weight)| weight * y[*unknown as usize]).sum()
    }

    /// Settlement since the unloaded state, m.
    fn settlement(&self) -> f64 {
        self.seeding.first_settlement + self.settled + self.settlement_of(&self.y) + self.settled_with_plates()
    }

    /// That of functions which go with plates, m.
    fn settled_with_plates(&self) -> f64 {
        let Some(soil) = &self.soil else { return 0.0 };
        let moved = |plate: u16| {
            let (plate, [_, before]) = &soil.plates[usize::from(plate)];
            plate.at(self.time) - before
        };
        self.settle_with.iter().map(|(plate, weight)| weight * moved(*plate)).sum()
    }

    /// Size of forces that a residual is compared with.
    fn reference(&self, soil: &Soil<L, D>) -> f64 {
        let stress = self.points.iter().flat_map(|p| p.stress).fold(0.0, |m: f64, s| m.max(s.abs()));
        let pressure = largest(&soil.p);
        let face = self.seeding.thickness * self.scene.cell.powi(D as i32 - 1);
        let weight = self.scene.gravity.unwrap_or(0.0) * self.scene.mixture_density() * face * self.scene.cell;
        let loads = soil.loads.iter().map(|(force, course)| course.most() * largest(force)).sum::<f64>();
        let stress = stress + self.stress_of_start();
        let size = soil.scales[0] * (loads + face * (stress + pressure + self.scene.well_pressure()) + weight);
        let force = soil.scales[0] * face;
        force * self.at_least(f64::EPSILON / (NEWTON * self.scene.tolerance), size / force)
    }

    /// A pressure (Pa), or a share of the stiffness: stresses of a law of its own, or of a mesh that moves, are known to round-off of
    /// that only. Linear soil is as exact under any load.
    fn at_least(&self, share: f64, size: f64) -> f64 {
        let exact = self.scene.strain == StrainChoice::Small && self.seeding.law.are_linear();
        let unloaded: f64 = if size > 0.0 { 0.0 } else { 1e-9 };
        size.max(if exact { unloaded } else { unloaded.max(share) } * self.scene.oedometer_modulus())
    }

    /// Pressure that errors are compared with, Pa.
    fn pressure_size(&self) -> f64 {
        let load = self.scene.largest_load();
        let weight = self.scene.gravity.unwrap_or(0.0) * self.scene.mixture_density() * self.scene.height;
        self.at_least(16.0 * f64::EPSILON / self.scene.tolerance, load + weight + self.stress_of_start()) // after some operations
    }

    /// Stress of the wave by which supports stop the velocity of the start, rho c v, Pa; c of water no stiffer than hundred times the soil.
    fn stress_of_start(&self) -> f64 {
        let (scene, [left, right, bottom, top]) = (&self.scene, self.scene.solid_sides);
        let stops = |[along, across]: [[SolidSide; 2]; 2]| {
            along.iter().any(|side| *side != SolidSide::Free) || across.contains(&SolidSide::Fixed)
        };
        let (walls, ends) = ([left, right], [bottom, top]);
        let speed = scene.start_velocity.map_or(0.0, |[x, y]| {
            let [x, y] = [(x, [walls, ends]), (y, [ends, walls])].map(|(v, sides)| if stops(sides) { v } else { 0.0 });
            x.hypot(y)
        });
        let soil = scene.oedometer_modulus();
        let water = if scene.water.is_some() { scene.pore_stiffness().min(100.0 * soil) } else { 0.0 };
        (scene.mixture_density() * (soil + water)).sqrt() * speed
    }

    /// Work of the present system into the totals, before it is replaced.
    fn count_work(&mut self) {
        if let Some(soil) = &mut self.soil {
            self.done.factorisations += std::mem::take(&mut soil.system.factorisations);
            self.done.solves += std::mem::take(&mut soil.system.solves);
        }
    }
}

impl<L: Law, const D: usize> Model for QuasiStatic<L, D> {
    fn advance(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault> {
        // What paused goes on to the very end that it was asked for.
        let end = if self.left() > 0.0 { self.until } else { self.stage_time + dt * steps as f64 };
        match &mut self.method {
            Some(Method::Krylov(stage)) => {
                let meaning = stage.evolution.at(end, &mut self.y);
                self.time += end - self.stage_time;
                (self.stage_time, self.until) = (end, end);
                self.book_krylov(&meaning).map_err(|e| inverted(&self.points, e.point))
            }
            Some(Method::Sdirk { .. }) => self.steps_until(end, done),
            None => Err(nothing()),
        }
    }

    fn enter_stage(&mut self, stage: &Stage, times: &[f64]) -> Result<(), Fault> {
        self.count_work();
        self.method = None;
        self.stage_end = times.last().copied().unwrap_or(0.0);
        // Times between those that are asked for are for the history.
        let asked = |time: &&f64| **time == self.stage_end || self.scene.observe_times.contains(time);
        let first_asked = times.iter().filter(|time| **time > 0.0).find(asked).copied().unwrap_or(self.stage_end);
        (self.resolves, self.damping) = (self.scene.resolves_waves(first_asked), stage.damping);
        let sides = stage.solid_sides.unwrap_or(self.scene.solid_sides);
        let released = std::mem::replace(&mut self.sides, sides) != sides;
        // Soil that is only strained a little stands where it stood: its stresses go to a mesh with other unknowns.
        if self.soil.is_some() && self.scene.strain == StrainChoice::Large {
            self.drain(stage.drained)?;
        } else {
            self.build(stage.drained)?;
        }
        (self.stage_time, self.until, self.started) = (0.0, 0.0, 0);
        let first = !std::mem::replace(&mut self.counted, true);
        if first {
            self.ramp = self.ramp(times);
            let cells = self.cell_values();
            self.totals.start(&cells);
        }
        if first || released {
            self.loose = self.soil.as_ref().map_or_else(Vec::new, Soil::forces);
        }
        let krylov = match self.scene.method {
            TimeMethod::Krylov => true,
            TimeMethod::Auto => self.krylov_holds() && !matches!(self.scene.step, StepChoice::Fixed(_)),
            TimeMethod::Sdirk => false,
        };
        if krylov && !self.krylov_holds() {
            let what = "the Krylov method needs a linear scene: small strain, an elastic law, a constant load, water, no gravity";
            return Err(Fault { place: format!("stage {}", stage.name), what: what.to_owned() });
        }
        let at_once = if krylov { self.krylov(times)? } else { None };
        let steps = || {
            let soil = self.soil.as_ref().ok_or_else(nothing)?;
            let stepper = Box::new(Sdirk::new(soil.p.len(), soil.unknowns()));
            Ok(Method::Sdirk { stepper, step: self.first_step(times), factored: f64::NAN })
        };
        self.method = Some(match at_once {
            Some(method) => method,
            None => steps()?,
        });
        Ok(())
    }

    fn left(&self) -> f64 {
        (self.until - self.stage_time).max(0.0)
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn work(&self) -> Work {
        let mut work = self.done;
        if let Some(soil) = &self.soil {
            work.factorisations += soil.system.factorisations;
            work.solves += soil.system.solves;
        }
        work
    }

    fn places(&self) -> Places {
        Places::of(self.points_now().iter(), &[])
    }

    fn particles(&self) -> Vec<SolidState> {
        self.states()
    }

    fn observe(&self) -> (Observation, BalanceTerms) {
        let (cells, density) = (self.cell_values(), self.scene.water.map_or(0.0, |w| w.density));
        (self.look(&cells), self.totals.balance_terms(&cells, density, 0.0))
    }

    fn pore_pressure(&self) -> [f64; 3] {
        let cells = self.cell_values();
        let volume: f64 = cells.iter().map(|c| c.volume).sum();
        let mean = cells.iter().map(|c| c.volume * c.pressure).sum::<f64>() / volume;
        let pressures = cells.iter().map(|c| c.pressure);
        [mean, pressures.clone().fold(f64::INFINITY, f64::min), pressures.fold(f64::NEG_INFINITY, f64::max)]
    }

    fn bytes(&self) -> usize {
        let soil = self.soil.as_ref().map_or(0, |s| {
            s.solid.capacity() * size_of_val(&s.solid[0])
                + s.pore.capacity() * s.pore.first().map_or(0, size_of_val)
                + s.system.matrix.bytes()
                + s.system.factor.bytes()
        });
        self.points.capacity() * size_of::<SolidPoint<D>>() + self.sites.bytes() + soil
    }

    fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        self.whole_state(archive)
    }

    fn solid_count(&self) -> usize {
        self.points.len()
    }
}

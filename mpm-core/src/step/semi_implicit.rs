//! The semi-implicit step: explicit skeleton, pore pressure of the end of the step at the cells.
//!
//! `v* = v + dt/m (f_int(sigma') + f_ext)`, then `v^{n+1} = v* + dt m^-1 C p^{n+1}` with the pressure that leaves every
//! cell's water in balance (`step/pressure.rs`). The water neither limits the step by its wave nor by its flow; what
//! remains is the wave of the skeleton (`stability`).
//!
//! `rho_w a_s` in Darcy's law is that of the step before. With the acceleration of this step the system would not be
//! symmetric, and its limit lower: at the eigenvalue -1 the term of Eq. (1) then takes `2 k/g` from dt in the
//! pressure that a strain builds up, where the lagged one adds it. Being late it feeds waves in permeable soil, above a step
//! that `stability` knows.

use super::pressure::PressureSystem;
use super::skeleton::Skeleton;
use super::{Fault, Model, Parts, Work};
use crate::boundary::Lifted;
use crate::constitutive::Laws;
use crate::dimension::Kinematics;
use crate::keep::Keeper;
use crate::observe::{Ledger, Observation, SolidState};
use crate::scene::Stage;
use crate::stencil::Basis;
use crate::water::{Cellwise, Face, Saturated, Water};

/// The semi-implicit integrator. K: dimension, B: basis, L: law, LAYERED: conductivity by layers.
#[derive(Debug)]
pub struct SemiImplicit<K, B, L, const LAYERED: bool, const D: usize, const S: usize> {
    skeleton: Skeleton<K, B, L, Saturated<Face<D, LAYERED>, D>, D, S>,
    pressure: PressureSystem<D>,
    work: Work,
}

impl<K, B, L, const LAYERED: bool, const D: usize, const S: usize> SemiImplicit<K, B, L, LAYERED, D, S>
where
    K: Kinematics<D, S>,
    B: Basis,
    L: Laws<S>,
    Saturated<Face<D, LAYERED>, D>: Cellwise<K, D, S>,
{
    /// A run at t = 0; the supports of `parts` hold coefficients of the basis.
    /// `moves`: soil may come to fill cells in part.
    pub fn new(parts: Parts<L, Saturated<Face<D, LAYERED>, D>, D, S>, basis: B, moves: bool) -> Self {
        let functions = crate::stencil::Functions::new(basis, &parts.grid);
        let pressure = PressureSystem::new::<B>(&parts.grid, functions.count());
        let mut skeleton = Skeleton::new(parts, basis, true);
        let level = skeleton.parts.filled.is_known();
        skeleton.lifted = moves.then(|| Box::new(Lifted::new(functions.count(), level)));
        Self { skeleton, pressure, work: Work::default() }
    }

    /// One step.
    fn step(&mut self, dt: f64) -> Result<(), Fault> {
        let Self { skeleton, pressure, work } = self;
        skeleton.particles_to_mesh::<true, false>();
        skeleton.load();
        skeleton.lift();
        skeleton.accelerate(dt); // v*
        pressure.solve(skeleton, dt)?; // p^{n+1}
        work.factorisations += 1;
        work.solves += 1;
        pressure.push(skeleton);
        skeleton.equation_of_motion(dt); // v^{n+1}
        let Parts { water, grid, gravity, .. } = &mut skeleton.parts;
        let rates = water.drive(grid, &skeleton.mesh, &gravity.unwrap_or([0.0; D]));
        skeleton.totals.flow(&rates, dt);
        let left = skeleton.mesh_to_particles::<false>(dt, |water, grid, place, rate| {
            water.follow(grid, place, rate, pressure.rise(place.cell))
        });
        skeleton.motion_of_mesh(); // rho_w a_s of the next step
        skeleton.settle(left, dt)?;
        work.accepted += 1;
        Ok(())
    }
}

impl<K, B, L, const LAYERED: bool, const D: usize, const S: usize> Model for SemiImplicit<K, B, L, LAYERED, D, S>
where
    K: Kinematics<D, S>,
    B: Basis,
    L: Laws<S>,
    Saturated<Face<D, LAYERED>, D>: Cellwise<K, D, S>,
{
    fn advance(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault> {
        for _ in 0..steps {
            self.step(dt)?;
            *done += 1;
        }
        Ok(())
    }

    fn enter_stage(&mut self, stage: &Stage, _: &[f64]) -> Result<(), Fault> {
        let Parts { water, grid, solid, .. } = &mut self.skeleton.parts;
        self.skeleton.damping = stage.damping;
        Water::<K, D, S>::set_drained(water, grid, solid, stage.drained);
        self.pressure.forget();
        Ok(())
    }

    fn time(&self) -> f64 {
        self.skeleton.time
    }

    fn work(&self) -> Work {
        self.work
    }

    fn observe(&self) -> Observation {
        self.skeleton.parts.observe::<K>(self.skeleton.time)
    }

    fn ledger(&self) -> Ledger {
        self.skeleton.parts.ledger::<K>(&self.skeleton.totals)
    }

    fn pore_pressure(&self) -> [f64; 3] {
        self.skeleton.parts.pore_pressure::<K>()
    }

    fn particles(&self) -> Vec<SolidState> {
        self.skeleton.parts.particles::<K>()
    }

    fn bytes(&self) -> usize {
        self.skeleton.bytes() + self.pressure.bytes()
    }

    fn keep(&mut self, keeper: &mut Keeper) {
        self.skeleton.keep(keeper);
        self.work.keep(keeper);
        if keeper.is_reading() {
            self.pressure.forget();
        }
    }

    fn solid_count(&self) -> usize {
        self.skeleton.parts.solid.points.len()
    }
}

//! The paper's explicit step (Figure 1) over stencils of any width: uGIMP and quadratic B-splines.

use super::skeleton::Skeleton;
use super::{Fault, Model, Parts};
use crate::constitutive::Laws;
use crate::dimension::Kinematics;
use crate::keep::Keeper;
use crate::observe::{Ledger, Observation, SolidState};
use crate::scene::Stage;
use crate::stencil::Basis;
use crate::water::Cellwise;

/// The explicit integrator over stencils. K: dimension, B: basis, L: law, W: water.
#[derive(Debug)]
pub struct ExplicitWide<K, B, L, W, const D: usize, const S: usize> {
    skeleton: Skeleton<K, B, L, W, D, S>,
}

impl<K, B, L, W, const D: usize, const S: usize> ExplicitWide<K, B, L, W, D, S>
where
    K: Kinematics<D, S>,
    B: Basis,
    L: Laws<S>,
    W: Cellwise<K, D, S>,
{
    /// A run at t = 0; the supports of `parts` hold coefficients of the basis.
    pub fn new(parts: Parts<L, W, D, S>, basis: B) -> Self {
        Self { skeleton: Skeleton::new(parts, basis, false) }
    }

    /// One step of Figure 1.
    fn step(&mut self, dt: f64) -> Result<(), Fault> {
        let skeleton = &mut self.skeleton;
        skeleton.particles_to_mesh::<false, false>();
        if skeleton.parts.transfer.is_some() {
            skeleton.give_beyond();
        }
        skeleton.load();
        skeleton.equation_of_motion(dt);
        skeleton.darcy_flow(dt);
        if skeleton.parts.transfer.is_some() {
            skeleton.map_back();
        }
        let left =
            skeleton.mesh_to_particles::<false>(dt, |water, grid, place, rate| water.change(grid, place, rate, dt));
        skeleton.settle(left, dt)
    }
}

impl<K, B, L, W, const D: usize, const S: usize> Skeleton<K, B, L, W, D, S>
where
    K: Kinematics<D, S>,
    B: Basis,
    L: Laws<S>,
    W: Cellwise<K, D, S>,
{
    /// Eq. (1): relative velocity of the water.
    fn darcy_flow(&mut self, dt: f64) {
        if W::WET {
            self.motion_of_mesh();
            let gravity = self.parts.gravity.unwrap_or([0.0; D]);
            let rates = self.parts.water.flow(&self.parts.grid, &self.mesh, &gravity);
            self.totals.flow(&rates, dt);
        }
    }
}

impl<K, B, L, W, const D: usize, const S: usize> Model for ExplicitWide<K, B, L, W, D, S>
where
    K: Kinematics<D, S>,
    B: Basis,
    L: Laws<S>,
    W: Cellwise<K, D, S>,
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
        water.set_drained(grid, solid, stage.drained);
        Ok(())
    }

    fn time(&self) -> f64 {
        self.skeleton.time
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
        self.skeleton.bytes()
    }

    fn solid_count(&self) -> usize {
        self.skeleton.parts.solid.points.len()
    }

    fn keep(&mut self, keeper: &mut Keeper) {
        self.skeleton.keep(keeper);
    }

    fn stages(&self) -> &'static [&'static str] {
        &["particles to mesh", "mesh to particles"]
    }

    fn do_stage(&mut self, stage: usize, dt: f64) {
        let skeleton = &mut self.skeleton;
        if stage == 0 {
            skeleton.particles_to_mesh::<false, true>();
        } else {
            skeleton.mesh_to_particles::<true>(dt, |water, grid, place, rate| water.change(grid, place, rate, dt));
        }
    }
}

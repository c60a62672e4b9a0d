//! What the edges of the soil may do beyond holding nodes: periodic sides, light nodes, friction on the base.
//!
//! Few scenes have any of it. The explicit step asks once a step whether there is something to do.

use super::{Coulomb, Joined, Lifted, Supports};
use crate::grid::Grid;
use crate::nodes::NodeSums;
use crate::particles::{Layer, SolidPoint};
use crate::scene::Scene;

/// Joined nodes and a base with friction.
#[derive(Debug, Clone)]
pub struct Edges<const D: usize> {
    /// Nodes that move as one.
    pub joined: Joined<D>,
    /// Inertia lent to nodes of the surface that are too light for the step.
    pub lifted: Option<Lifted<D>>,
    /// Friction on the base.
    pub base: Option<Coulomb>,
    /// Width of a periodic mesh, m.
    period: Option<f64>,
}

impl<const D: usize> Edges<D> {
    /// Those of a scene, if it has any. `full_mass` is the solid mass (kg) of a node amid soil.
    pub fn of(
        scene: &Scene,
        grid: &Grid<D>,
        supports: &Supports<D>,
        particles: usize,
        full_mass: f64,
    ) -> Option<Box<Self>> {
        if !(scene.periodic || scene.light_nodes > 0.0 || scene.base.is_some() || scene.lends_inertia()) {
            return None;
        }
        let base = |base| Coulomb::new(base, grid, particles, supports.held(0), scene.water.is_some());
        Some(Box::new(Self {
            joined: Joined::new(grid, supports, scene.periodic, scene.light_nodes * full_mass),
            lifted: scene.lends_inertia().then(|| Lifted::new(grid.node_count(), true)),
            base: scene.base.map(base),
            period: scene.periodic.then(|| grid.cells[0] as f64 * grid.size),
        }))
    }

    /// Lends inertia to nodes too light for the step, if the soil may have such.
    pub fn lift<const S: usize>(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D, S>, D>,
        nodes: &mut [NodeSums<D>],
    ) {
        let Some(lifted) = &mut self.lifted else { return };
        lifted.clear();
        for (cell, position) in grid.walk() {
            let mass: f64 = solid.points[solid.range(cell)].iter().map(|point| point.mass).sum();
            if mass > 0.0 {
                let corners = grid.corners_from(grid.first_corner(cell, &position));
                corners[..Grid::<D>::CORNERS].iter().for_each(|node| lifted.touch(*node, mass));
            }
        }
        lifted.lift(nodes);
    }

    /// Lets particles that have left a periodic mesh come in at its other side.
    pub fn wrap<const S: usize>(&self, solid: &mut Layer<SolidPoint<D, S>, D>) {
        let Some(period) = self.period else { return };
        for point in &mut solid.points {
            if point.x[0] < 0.0 {
                // A hair left of zero would round to the period itself, which is outside.
                point.x[0] = (point.x[0] + period).min(period.next_down());
            } else if point.x[0] >= period {
                point.x[0] -= period;
            }
        }
    }
}

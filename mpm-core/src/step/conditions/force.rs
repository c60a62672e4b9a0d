//! A given force on the soil.

use std::fmt::Debug;

use super::{Condition, Soil};
use crate::boundary::ForceField;
use crate::observe::Totals;
use crate::step::store::Nodes;

/// A given force on the soil, gathered from its particles: `f_i = sum_p m_p b(x_p, t) N_i(x_p)`.
#[derive(Clone)]
pub struct GivenForce<const D: usize> {
    field: ForceField,
    /// Force on each node, N.
    nodes: Vec<[f64; D]>,
}

impl<const D: usize> GivenForce<D> {
    /// From the acceleration it gives, m/s2, at a place (m) and time (s).
    pub fn new(field: ForceField) -> Self {
        Self { field, nodes: Vec::new() }
    }
}

impl<const D: usize> Debug for GivenForce<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GivenForce").field("nodes", &self.nodes.len()).finish_non_exhaustive()
    }
}

impl<const D: usize> Condition<D> for GivenForce<D> {
    fn gathered(&mut self, nodes: &mut Nodes<D>, soil: &dyn Soil<D>) {
        let Self { field, nodes: forces } = self;
        forces.clear();
        forces.resize(nodes.frame.count(), [0.0; D]);
        soil.each_share(&mut |point, shares| {
            let across = if D == 2 { point.x[0] } else { 0.0 };
            let b = field([across, point.x[D - 1]], soil.time());
            for (node, share) in shares {
                for d in 0..D {
                    forces[*node][d] += share * point.mass * b[d + 2 - D];
                }
            }
        });
        for (node, newton) in forces.iter().enumerate() {
            for d in 0..D {
                nodes.push(node, d, newton[d]);
            }
        }
    }

    fn book(&self, nodes: &Nodes<D>, totals: &mut Totals<D>, dt: f64) {
        for (node, newton) in self.nodes.iter().enumerate() {
            for d in 0..D {
                totals.gravity_impulse[d] += dt * newton[d];
                totals.gravity_work += dt * newton[d] * nodes.working_velocity(node, d, dt);
            }
        }
    }
}

//! Damping of the whole soil.

use super::{Condition, Soil};
use crate::observe::Totals;
use crate::step::Fault;
use crate::step::store::Nodes;
use crate::step::store::nodes::MIXTURE_MASS;

/// Mass-proportional damping, implicit in the velocity: v (1 + c dt) = v + a dt. After the supports: a supported node has no speed to lose.
#[derive(Debug, Clone, Copy, Default)]
pub struct Damping {
    /// c, 1/s.
    rate: f64,
}

impl<const D: usize> Condition<D> for Damping {
    fn damp_by(&mut self, rate: f64) {
        self.rate = rate;
    }

    fn accelerated(
        &mut self,
        nodes: &mut Nodes<D>,
        _: &dyn Soil<D>,
        totals: &mut Totals<D>,
        dt: f64,
    ) -> Result<(), Fault> {
        if self.rate <= 0.0 {
            return Ok(());
        }
        let keep = 1.0 / (1.0 + self.rate * dt);
        let Nodes { frame, sums, reached, motion, .. } = nodes;
        for (number, (strip, runs)) in sums.iter().zip(reached.runs()).enumerate() {
            for i in runs.iter().flat_map(Clone::clone) {
                let (mass, node) = (strip.0[MIXTURE_MASS][i], number * frame.strip + i);
                for d in 0..D {
                    let undamped = motion.velocity[d][node];
                    let velocity = keep * undamped;
                    motion.velocity[d][node] = velocity;
                    motion.acceleration[d][node] -= (undamped - velocity) / dt;
                    motion.change[d][node] -= undamped - velocity;
                    let lost = mass * (undamped - velocity);
                    totals.damping_loss += lost * velocity;
                    totals.damping_impulse[d] -= lost;
                }
            }
        }
        Ok(())
    }
}

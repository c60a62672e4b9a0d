//! What plastic flow has done since the start of a run.

use serde::{Deserialize, Serialize};

use crate::constitutive::Flow;

/// Energy dissipated by plastic flow, and how far stresses were outside their surface at most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Flowed {
    /// Energy dissipated, J.
    pub dissipation: f64,
    /// Largest [`crate::constitutive::Law::yield_residual`] of any stress; negative infinity under a law without yield.
    pub residual: f64,
}

impl Flowed {
    /// Before the first step.
    pub const NOTHING: Self = Self { dissipation: 0.0, residual: f64::NEG_INFINITY };

    /// Records an update of a particle of a volume, m3.
    #[inline(always)]
    pub fn add(&mut self, volume: f64, flow: &Flow) {
        self.dissipation += volume * flow.dissipation;
        self.residual = self.residual.max(flow.residual);
    }

    /// Records what was added up elsewhere.
    pub fn join(&mut self, other: &Self) {
        self.dissipation += other.dissipation;
        self.residual = self.residual.max(other.residual);
    }
}

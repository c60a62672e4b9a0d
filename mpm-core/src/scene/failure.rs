//! Soil that may fail under water: how it is followed.

use serde::Serialize;

use super::{Coupling, Fields};

/// Options of a stage in which water seeps and the soil may fail.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Failure {
    /// Time at which the water begins to seep, s.
    pub starts_at: f64,
    /// Whether to continue with soil that is not stable under its own weight and the first water.
    pub continue_if_unstable: bool,
    /// Whether to continue, to the end of the scene, after a collapse has come to rest.
    pub continue_after_collapse: bool,
    /// Where the level of the water is recorded, x in m.
    pub levels: Vec<f64>,
    /// Places (m) whose stress is recorded: the particles nearest to them at the start.
    pub points: Vec<[f64; 2]>,
}

impl Fields {
    /// Whether water and soil run together, in the one stage there is.
    pub fn may_fail(&self) -> bool {
        self.stages.iter().any(|stage| stage.coupling == Coupling::Full)
    }
}

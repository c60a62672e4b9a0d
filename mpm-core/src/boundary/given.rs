//! Fields that a scene file cannot describe: a force on the soil, and the state at t = 0, as functions of the place.
//!
//! They are for manufactured solutions.

use std::fmt;
use std::sync::Arc;

/// Acceleration (m/s2) that a force gives to dry soil at a place (m) and a time since the start of the run (s): x, y. A
/// column has y alone.
pub type ForceField = Arc<dyn Fn([f64; 2], f64) -> [f64; 2] + Send + Sync>;

/// State of soil and water at a place (m) at t = 0.
pub type FirstField = Arc<dyn Fn([f64; 2]) -> FirstState + Send + Sync>;

/// State at a place at t = 0.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FirstState {
    /// Velocity of soil and water, m/s: x, y.
    pub velocity: [f64; 2],
    /// Effective stress, Pa: xx, yy, zz, xy.
    pub stress: [f64; 4],
    /// Pore pressure, Pa.
    pub pressure: f64,
}

/// What a run is given beside its scene. Nothing by default.
#[derive(Clone, Default)]
pub struct Given {
    /// A force on the soil. Unlike gravity it does not drive the water through the pores.
    pub force: Option<ForceField>,
    /// The state at t = 0, in place of the scene's own; the place is that of the moved particle.
    pub start: Option<FirstField>,
    /// How far from their places in the scene the particles of both layers stand, m: x, y. Sides of the mesh stay.
    pub moved: [f64; 2],
}

impl Given {
    /// Whether the scene is all there is.
    pub fn is_nothing(&self) -> bool {
        self.force.is_none() && self.start.is_none() && self.moved == [0.0; 2]
    }
}

impl fmt::Debug for Given {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let field = |is_some: bool| if is_some { "a field" } else { "none" };
        let (force, start) = (field(self.force.is_some()), field(self.start.is_some()));
        f.debug_struct("Given").field("force", &force).field("start", &start).field("moved", &self.moved).finish()
    }
}

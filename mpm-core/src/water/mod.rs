//! The water layer: water that fills the pores ([`pores`]), also of soil that runs out, and water with a free surface in soil that may
//! move ([`AdvectedWater`]).

mod advected;
mod cuts;
mod darcy;
mod exposed;
pub mod free_surface;
mod halves;
pub mod pores;
pub mod retention;

pub use advected::{AdvectedWater, Pressures};
pub use cuts::{Cuts, Opening};
pub use darcy::FaceFlow;
pub(crate) use darcy::{DRAINED_SURFACE, FLOW, LEAST_FILLING};
pub use exposed::{Exposed, ExposedFace};
pub use halves::Halves;

use crate::grid::Grid;

/// Density of water under a pressure (Pa) over that under none: `p = K_w ln(rho/rho_0)`, the law of every integrator at large
/// strain. It is what `dp = K_w drho/rho` adds up to, so that no water is made or lost however much it is compressed.
pub fn density_ratio(pressure: f64, bulk_modulus: f64) -> f64 {
    (pressure / bulk_modulus).exp()
}

/// Energy stored in water under a pressure (Pa) per volume that it fills, J/m3: `K_w (r - 1 - ln r)` with `r = rho/rho_0`, whose
/// derivative by the volume of a given mass is -p.
pub fn stored_energy(pressure: f64, bulk_modulus: f64) -> f64 {
    let x = pressure / bulk_modulus;
    // The series of exp(x) - 1 - x, without cancellation.
    0.5 * pressure * x * (1.0 + x / 3.0 * (1.0 + x / 4.0 * (1.0 + x / 5.0)))
}

/// How the nodes of the soil can be pushed.
#[derive(Debug, Clone, Copy)]
pub struct Pushed<'a, const D: usize> {
    /// The mesh.
    pub grid: &'a Grid<D>,
    /// 1/kg of each node and direction; zero where something holds it.
    pub inverse: &'a [[f64; D]],
    /// The node that each node moves with, itself if none.
    pub leader: &'a [u32],
}

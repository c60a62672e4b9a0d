//! The water layer: none at all, water that fills the pores (saturated), also of soil that runs out (ragged), water with a
//! free surface, in soil that may move (carried).
//!
//! A dry scene has no water arrays and calls nothing of this room: [`Dry`] is a type without data.

mod carried;
mod cellwise;
mod exposed;
mod face;
pub mod free_surface;
mod implicit;
mod nodal;
pub mod pores;
mod ragged;
mod resident;
mod saturated;

pub use carried::{Carried, Pressures};
pub use cellwise::{CellChange, Cellwise};
pub use exposed::{Exposed, ExposedFace};
pub use face::Face;
pub(crate) use face::{DRAINED_SURFACE, FLOW, LEAST_FILLING};
pub use nodal::Nodal;
pub use ragged::Ragged;
pub use resident::{FaceFlow, Resident};
pub use saturated::{DarcyOperator, Saturated, WaterCell};

use crate::boundary::Filled;
use crate::dimension::Kinematics;
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::nodes::NodeMotion;
use crate::particles::{Layer, SolidPoint, WaterPoint};
use crate::shape::Shape;

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

/// Rates of the flow during one step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FlowRates {
    /// Energy lost to friction in the pores, W.
    pub dissipation: f64,
    /// Work of `rho_w (g - a_s)` on the Darcy flux, W.
    pub body_work: f64,
    /// Water leaving through drained faces, m3/s.
    pub outflow: f64,
    /// Water entering through drained faces, m3/s.
    pub inflow: f64,
}

impl FlowRates {
    /// Books a flux through a drained face, outwards positive.
    #[inline(always)]
    fn pass(&mut self, outwards: f64) {
        self.outflow += outwards.max(0.0);
        self.inflow -= outwards.min(0.0);
    }
}

/// Where a cell is.
#[derive(Debug, Clone, Copy)]
pub struct Place<const D: usize> {
    /// Number of the cell.
    pub cell: usize,
    /// Its lattice position.
    pub position: [usize; D],
    /// Its corner nodes.
    pub corners: [usize; 4],
}

/// One cell of soil, as the water needs it.
#[derive(Debug, Clone, Copy)]
pub struct SoilCell<const D: usize> {
    /// Where it is.
    pub place: Place<D>,
    /// Dry mass in it, kg.
    pub mass: f64,
    /// Volume of the particles in it, m3: with their mass it says how dense the soil is.
    pub volume: f64,
    /// Volume of soil in it, m3: that of its particles where the outline of the soil is not known.
    pub filled: f64,
    /// Where in the cell its stress and pressure act if its particles share a point, in cell coordinates.
    pub at: [f64; D],
}

/// Stress sums of a cell: `sum V sigma`, and the same times each cell coordinate.
#[derive(Debug, Clone, Copy)]
pub struct StressSums<const D: usize, const S: usize> {
    /// `sum V sigma`, N m.
    pub mean: [f64; S],
    /// `sum V sigma xi_d`, N m; not used by schemes that evaluate at the centre.
    pub first: [[f64; S]; D],
}

impl<const D: usize, const S: usize> StressSums<D, S> {
    /// Multiplies all sums.
    #[inline(always)]
    pub fn scale(&mut self, factor: f64) {
        for s in 0..S {
            self.mean[s] *= factor;
            for d in 0..D {
                self.first[d][s] *= factor;
            }
        }
    }
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

impl<const D: usize> Pushed<'_, D> {
    /// The node that moves a corner of a cell.
    #[inline(always)]
    pub fn node(&self, cell: usize, corner: usize) -> usize {
        let row = if D == 2 { cell / self.grid.cells[0] } else { 0 };
        let up = if corner & 2 == 2 { self.grid.cells[0] + 1 } else { 0 };
        self.leader[cell + row + (corner & 1) + up] as usize
    }
}

/// What the step asks of the water.
pub trait Water<K: Kinematics<D, S>, const D: usize, const S: usize>: Send {
    /// Whether there is water at all.
    const WET: bool;

    /// Before the particles are gathered.
    fn clear(&mut self);

    /// Gathers the water of one cell: adds the pore pressure to the stress, returns water mass at the corners, kg. Where the
    /// geometry of the soil is known that is the water in its pores, which moves with the soil (u-p model), from `solid`, the dry
    /// mass at the corners (kg); else that of the water particles.
    fn cell_to_grid<Sh: Shape>(
        &mut self,
        grid: &Grid<D>,
        soil: &SoilCell<D>,
        solid: &[f64; 4],
        stress: &mut StressSums<D, S>,
    ) -> [f64; 4];

    /// Darcy flow from pressures and accelerations: the paper's Eq. (1).
    fn flow(&mut self, grid: &Grid<D>, motion: &[NodeMotion<D>], gravity: &[f64; D]) -> FlowRates;

    /// Whether pressures of the end of the step push the soil.
    const PRESSES: bool = false;

    /// Lets them push: forces, friction, supports and damping have acted.
    ///
    /// # Errors
    /// A place and what was found there.
    fn press(&mut self, _: &Grid<D>, _: &Pushed<D>, _: &mut [NodeMotion<D>], _: f64) -> Result<(), (String, String)> {
        Ok(())
    }

    /// Updates pressure, volume, velocity and position of the water of one cell: the paper's Eqs. (5)-(7).
    fn cell_to_points<Sh: Shape>(&mut self, grid: &Grid<D>, place: &Place<D>, velocity: &[[f64; D]; 4], dt: f64);

    /// Restores the cell order where water has moved; removes water that has left the soil.
    ///
    /// # Errors
    /// A place and what was found there.
    fn settle(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D, S>, D>) -> Result<(), (String, String)>;

    /// The surface of the soil has moved; called before [`Self::settle`].
    fn under_surface(&mut self, _: &Filled<D>) {}

    /// Which sides let water out from now on.
    fn set_drained(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D, S>, D>, drained: [bool; 4]);

    /// The water particles, if there are any.
    fn layer(&self) -> Option<&Layer<WaterPoint<D>, D>>;

    /// Pressure (Pa) and stored energy (J) of the water in a cell of soil.
    fn cell_state(&self, soil: &SoilCell<D>) -> (f64, f64);

    /// What a cell of the lowest row puts on the base: pressure there (Pa), and the share of its bottom that is under soil, if
    /// that is known. `rise` is the weight of a cell's height of water, Pa.
    fn on_base(&self, soil: &SoilCell<D>, rise: f64) -> (f64, Option<f64>) {
        // From the mean over the cell down to the base: under water that fills it, or stands in it up to a level.
        let mean = self.cell_state(soil).0;
        (if mean >= 0.5 * rise { mean + 0.5 * rise } else { (2.0 * rise * mean.max(0.0)).sqrt() }, None)
    }

    /// Mass of water in the pores of a cell of soil, `rho_w n V exp(p/K_w)`, kg.
    fn cell_mass(&self, soil: &SoilCell<D>) -> f64;

    /// Mass of the water particles that were removed because they left the soil, kg.
    fn removed_mass(&self) -> f64 {
        0.0
    }

    /// Whether water leaves with its particles, and not through faces.
    fn leaves_as_particles(&self) -> bool {
        false
    }

    /// Work that pressures which are held have done on the soil, J.
    fn held_work(&self) -> f64 {
        0.0
    }

    /// Density of the water, kg/m3.
    fn density(&self) -> f64;

    /// Writes or reads what steps to come depend on.
    fn keep(&mut self, keeper: &mut Keeper, grid: &Grid<D>);

    /// Bytes held.
    fn bytes(&self) -> usize;
}

/// No water.
#[derive(Debug, Clone, Copy)]
pub struct Dry;

impl<K: Kinematics<D, S>, const D: usize, const S: usize> Water<K, D, S> for Dry {
    const WET: bool = false;

    #[inline(always)]
    fn clear(&mut self) {}

    #[inline(always)]
    fn cell_to_grid<Sh: Shape>(
        &mut self,
        _: &Grid<D>,
        _: &SoilCell<D>,
        _: &[f64; 4],
        _: &mut StressSums<D, S>,
    ) -> [f64; 4] {
        [0.0; 4]
    }

    #[inline(always)]
    fn flow(&mut self, _: &Grid<D>, _: &[NodeMotion<D>], _: &[f64; D]) -> FlowRates {
        FlowRates::default()
    }

    #[inline(always)]
    fn cell_to_points<Sh: Shape>(&mut self, _: &Grid<D>, _: &Place<D>, _: &[[f64; D]; 4], _: f64) {}

    #[inline(always)]
    fn settle(&mut self, _: &Grid<D>, _: &Layer<SolidPoint<D, S>, D>) -> Result<(), (String, String)> {
        Ok(())
    }

    fn set_drained(&mut self, _: &Grid<D>, _: &Layer<SolidPoint<D, S>, D>, _: [bool; 4]) {}

    fn layer(&self) -> Option<&Layer<WaterPoint<D>, D>> {
        None
    }

    fn cell_state(&self, _: &SoilCell<D>) -> (f64, f64) {
        (0.0, 0.0)
    }

    fn cell_mass(&self, _: &SoilCell<D>) -> f64 {
        0.0
    }

    fn density(&self) -> f64 {
        0.0
    }

    fn keep(&mut self, _: &mut Keeper, _: &Grid<D>) {}

    fn bytes(&self) -> usize {
        0
    }
}

//! Everything a picture of a run needs at one time: both layers of particles and the cells of the mesh.

use serde::Serialize;

/// Both layers and the mesh at one time, in the plane.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Frame {
    /// Time since the start of the run, s.
    pub time_s: f64,
    /// Steps since then.
    pub step: u64,
    /// Cells of the mesh along x and y.
    pub cells: [usize; 2],
    /// Edge of a cell, m.
    pub size: f64,
    /// Particles of the solid layer.
    pub solid: Vec<SolidState>,
    /// Particles of the water layer.
    pub water: Vec<WaterParticle>,
    /// All cells, x first.
    pub cell: Vec<CellState>,
}

/// A particle of the solid layer. What its run does not compute is not a number: no value stands for one that nobody knows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SolidState {
    /// Number it was seeded with.
    pub id: u32,
    /// Position, m; that of t = 0 at small strain.
    pub x: [f64; 2],
    /// Displacement since counting began, m; not a number from stepped integrators that have not begun to count.
    pub displacement: [f64; 2],
    /// Velocity, m/s; not a number without inertia.
    pub velocity: [f64; 2],
    /// Effective stress xx, yy, zz, xy, Pa, tension positive.
    pub stress: [f64; 4],
    /// Pore pressure that its cell feels, Pa; not a number without water.
    pub pore_pressure: f64,
    /// Deviator strain sqrt(2/3 e:e) since counting began, without unit; not a number where it is not counted.
    pub deviator_strain: f64,
    /// Volume of soil, m3.
    pub volume: f64,
    /// Dry mass, kg.
    pub mass: f64,
}

/// A particle of the water layer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct WaterParticle {
    /// Position, m.
    pub x: [f64; 2],
    /// Velocity, m/s.
    pub velocity: [f64; 2],
    /// Pore pressure, Pa.
    pub pressure: f64,
    /// Volume of soil that this water fills, m3.
    pub volume: f64,
}

/// A cell of the mesh.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct CellState {
    /// Share of the cell that is soil.
    pub soil: f64,
    /// Share of the pores that mobile water fills.
    pub saturation: f64,
    /// Mean of the positive pore pressure over the soil of the cell, Pa.
    pub pressure: f64,
}

//! A strip of cells with its particles.

use pulp::Simd;
use pulp::bytemuck::Zeroable;

use super::blocks::Blocks;
use super::frame::Frame;
use crate::observe::Flowed;
use crate::real::{array, numbers, numbers_mut};

/// Soil and water of so many cells side by side, as they are at the start of a step.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct SimdCells<V: Simd, const D: usize> {
    /// Place on the lattice, cells.
    pub position: [V::f64s; D],
    /// Centroid of the particles in it, in cell coordinates; the middle unless that is asked for.
    pub at: [V::f64s; D],
    /// Dry mass, kg.
    pub mass: V::f64s,
    /// Volume of soil, m3.
    pub volume: V::f64s,
    /// 1/V, 1/m3.
    pub inverse_volume: V::f64s,
    /// Porosity.
    pub porosity: V::f64s,
    /// 1/n.
    pub inverse_porosity: V::f64s,
    /// Factor on the divergence of the flow where the cell is not full of soil.
    pub filling: V::f64s,
    /// The part of the cell that is soil; much more than all of it where that is not known.
    pub fill: V::f64s,
    /// 1 where its water has a pressure, 0 where it is open to the air: known where water may leave soil that runs out.
    pub holds: V::f64s,
}

/// A strip of cells with its particles.
#[derive(Debug, Clone)]
pub struct Strip<V: Simd, const D: usize> {
    /// Number of its first cell.
    pub first: usize,
    /// Solid particles.
    pub solid: Blocks<V>,
    /// Water particles; none when dry.
    pub water: Blocks<V>,
    /// Its cells.
    pub cells: Vec<SimdCells<V, D>>,
    /// Energy lost to Darcy flow at its lower faces, and work of `rho_w (g - a_s)` there, N m/s over the face area.
    pub rates: [f64; 2],
    /// Plastic flow of its particles in the step.
    pub flowed: Flowed,
    /// Force of a unit pressure in its cells on the functions they reach, m2: `[cell][function][axis]`; empty if no one asks.
    pub coupling: Vec<f64>,
    /// What the boxes of its cells give to these and to those around them, `[share][cell]` as `step/domains.rs` has them; empty if no
    /// one asks.
    pub shared: Vec<f64>,
    /// Whether all its particles stayed in their cells.
    pub stays: bool,
    /// Whether other cells have come to hold their water.
    pub changed: bool,
}

impl<V: Simd, const D: usize> Strip<V, D> {
    /// A strip without particles.
    pub fn new(frame: &Frame<D>, number: usize) -> Self {
        let (first, groups) = (number * frame.strip, frame.strip / V::F64_LANES);
        let none = V::f64s::zeroed();
        let mut middle = none;
        numbers_mut(std::slice::from_mut(&mut middle)).fill(0.5);
        let mut cells = vec![
            SimdCells {
                position: [none; D],
                at: [middle; D],
                mass: none,
                volume: none,
                inverse_volume: none,
                porosity: none,
                inverse_porosity: none,
                filling: none,
                fill: none,
                holds: none
            };
            groups
        ];
        for (group, cell) in cells.iter_mut().enumerate() {
            for lane in 0..V::F64_LANES {
                let place = frame.position(first + group * V::F64_LANES + lane);
                for d in 0..D {
                    numbers_mut(&mut cell.position[d..=d])[lane] = place[d] as f64;
                }
            }
        }
        Self {
            first,
            solid: Blocks::new(groups, 0),
            water: Blocks::new(groups, 0),
            cells,
            rates: [0.0; 2],
            flowed: Flowed::NOTHING,
            coupling: Vec::new(),
            shared: Vec::new(),
            stays: true,
            changed: false,
        }
    }

    /// Volume (m3) and dry mass (kg) of the soil in a cell, given by its number in the strip.
    pub fn volume_and_mass(&self, cell: usize) -> [f64; 2] {
        let lanes = &self.cells[cell / V::F64_LANES];
        [lanes.volume, lanes.mass].map(|value| numbers(std::slice::from_ref(&value))[cell % V::F64_LANES])
    }

    /// Porosity of a cell, and 1/V of its soil, 1/m3.
    pub fn pores(&self, cell: usize) -> [f64; 2] {
        let lanes = &self.cells[cell / V::F64_LANES];
        [lanes.porosity, lanes.inverse_volume].map(|value| numbers(std::slice::from_ref(&value))[cell % V::F64_LANES])
    }

    /// Whether the water of a cell has a pressure, where it may be open to the air.
    pub fn holds(&self, cell: usize) -> bool {
        let lanes = &self.cells[cell / V::F64_LANES].holds;
        numbers(std::slice::from_ref(lanes))[cell % V::F64_LANES] > 0.0
    }

    /// Where its particles have their strain if they share a place, in cell coordinates.
    pub fn centroid(&self, cell: usize) -> [f64; D] {
        let at = &self.cells[cell / V::F64_LANES].at;
        array!([0.0; D], d => numbers(&at[d..=d])[cell % V::F64_LANES])
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let coupling = (self.coupling.capacity() + self.shared.capacity()) * size_of::<f64>();
        coupling + self.solid.bytes() + self.water.bytes() + self.cells.capacity() * size_of::<SimdCells<V, D>>()
    }
}

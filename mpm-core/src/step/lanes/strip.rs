//! A strip of cells: its particles, and what they give to the nodes.

use pulp::Simd;
use pulp::bytemuck::Zeroable;

use super::blocks::{Blocks, SOLID, WATER};
use super::frame::{Frame, MOST_LANES};
use crate::observe::Flowed;
use crate::real::{numbers, numbers_mut};

/// Sums on a node: solid mass, mixture mass, momentum, force.
pub const SUMS: usize = 6;
/// Where the solid mass stands among them, kg.
pub const SOLID_MASS: usize = 0;
/// The mass of solid and water, kg.
pub const MIXTURE_MASS: usize = 1;
/// The momentum of the solid along x, then y, kg m/s.
pub const MOMENTUM: usize = 2;
/// The force on the mixture along x, then y, N.
pub const FORCE: usize = 4;

/// Soil and water of so many cells side by side, as they are at the start of a step.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct CellLanes<V: Simd> {
    /// Place on the lattice, cells.
    pub position: [V::f64s; 2],
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
}

/// A strip of cells with its particles.
#[derive(Debug, Clone)]
pub struct Strip<V: Simd> {
    /// Number of its first cell.
    pub first: usize,
    /// Solid particles.
    pub solid: Blocks<V, SOLID>,
    /// Water particles; none when dry.
    pub water: Blocks<V, WATER>,
    /// Its cells.
    pub cells: Vec<CellLanes<V>>,
    /// What its cells give to the nodes from the first of the strip on, a row and a node beyond its end.
    pub sums: [Vec<f64>; SUMS],
    /// Energy lost to Darcy flow at its lower faces, and work of `rho_w (g - a_s)` there, N m/s over the face area.
    pub rates: [f64; 2],
    /// Plastic flow of its particles in the step.
    pub flowed: Flowed,
    /// Whether all its particles stayed in their cells.
    pub stays: bool,
}

impl<V: Simd> Strip<V> {
    /// A strip without particles.
    pub fn new(frame: &Frame, number: usize) -> Self {
        let (first, groups) = (number * frame.strip, frame.strip / V::F64_LANES);
        let none = V::f64s::zeroed();
        let mut cells = vec![
            CellLanes {
                position: [none; 2],
                volume: none,
                inverse_volume: none,
                porosity: none,
                inverse_porosity: none,
                filling: none,
                fill: none
            };
            groups
        ];
        for (group, cell) in cells.iter_mut().enumerate() {
            for lane in 0..V::F64_LANES {
                let place = frame.position(first + group * V::F64_LANES + lane);
                for d in 0..2 {
                    numbers_mut(&mut cell.position[d..=d])[lane] = place[d] as f64;
                }
            }
        }
        let length = frame.strip + frame.row + 1 + MOST_LANES;
        Self {
            first,
            solid: Blocks::new(groups),
            water: Blocks::new(groups),
            cells,
            sums: [(); SUMS].map(|()| vec![0.0; length]),
            rates: [0.0; 2],
            flowed: Flowed::NOTHING,
            stays: true,
        }
    }

    /// Volume of soil in a cell, given by its number in the strip, m3.
    pub fn volume(&self, cell: usize) -> f64 {
        numbers(std::slice::from_ref(&self.cells[cell / V::F64_LANES].volume))[cell % V::F64_LANES]
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.solid.bytes()
            + self.water.bytes()
            + self.cells.capacity() * size_of::<CellLanes<V>>()
            + SUMS * self.sums[0].capacity() * size_of::<f64>()
    }
}

/// What a strip gives to the nodes of the next one, a row and a node of them.
pub type Tail = [Vec<f64>; SUMS];

/// The tail of a strip that gives nothing.
pub fn no_tail(frame: &Frame) -> Tail {
    [(); SUMS].map(|()| vec![0.0; frame.row + 1])
}

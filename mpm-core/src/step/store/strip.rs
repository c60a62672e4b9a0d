//! A strip of cells with its particles.

use pulp::Simd;

use super::aligned::Aligned;
use super::blocks::{BlockVectors, Blocks};
use super::frame::Frame;
use crate::observe::Flowed;
use crate::real::{SimdReal, array, vectors_mut};

/// Numbers of a cell, of which a group of cells has a vector each: place on the lattice and centroid of the particles along two axes,
/// then those named below.
const NUMBERS: usize = 12;
const AT: usize = 2;
/// Where the dry mass stands among them, kg.
pub const MASS: usize = 4;
/// Where the volume of soil stands, m3.
pub const VOLUME: usize = 5;
/// Where 1/V stands, 1/m3.
pub const INVERSE_VOLUME: usize = 6;
/// Where the porosity stands.
pub const POROSITY: usize = 7;
/// Where 1/n stands.
pub const INVERSE_POROSITY: usize = 8;
/// Where the factor on the divergence of the flow stands.
pub const FILLING: usize = 9;
/// Where the part of the cell that is soil stands.
pub const FILL: usize = 10;
/// Where it stands whether its water has a pressure.
pub const HOLDS: usize = 11;

/// Soil and water of so many cells side by side, as they are at the start of a step.
#[derive(Clone, Copy)]
pub struct SimdCells<V: Simd, const D: usize> {
    /// Place on the lattice, cells.
    pub position: [SimdReal<V>; D],
    /// Centroid of the particles in it, in cell coordinates; the middle unless that is asked for.
    pub at: [SimdReal<V>; D],
    /// Dry mass, kg.
    pub mass: SimdReal<V>,
    /// Volume of soil, m3.
    pub volume: SimdReal<V>,
    /// 1/V, 1/m3.
    pub inverse_volume: SimdReal<V>,
    /// Porosity.
    pub porosity: SimdReal<V>,
    /// 1/n.
    pub inverse_porosity: SimdReal<V>,
    /// Factor on the divergence of the flow where the cell is not full of soil.
    pub filling: SimdReal<V>,
    /// The part of the cell that is soil; much more than all of it where that is not known.
    pub fill: SimdReal<V>,
    /// 1 where its water has a pressure, 0 where it is open to the air: known where water may leave soil that runs out.
    pub holds: SimdReal<V>,
}

/// A strip of cells with its particles.
#[derive(Debug, Clone)]
pub struct Strip<const D: usize> {
    /// Number of its first cell.
    pub first: usize,
    /// Solid particles.
    pub solid: Blocks,
    /// Water particles; none when dry.
    pub water: Blocks,
    /// Its cells, group after group, a vector for each of their numbers.
    cells: Aligned,
    /// Cells side by side, a power of two.
    lanes: usize,
    /// What its particles and cells have added up in the step.
    pub sums: StepSums,
    /// Force of a unit pressure in its cells on the functions they reach, m2: `[cell][function][axis]`; empty if no one asks.
    pub coupling: Vec<f64>,
    /// What the boxes of its cells give to these and to those around them, `[share][cell]` as `step/domains.rs` has them; empty if no
    /// one asks.
    pub shared: Vec<f64>,
}

/// What the particles and cells of a strip have added up in a step.
#[derive(Debug, Clone, Copy)]
pub struct StepSums {
    /// Energy lost to Darcy flow at its lower faces, and work of `rho_w (g - a_s)` there, N m/s over the face area.
    pub rates: [f64; 2],
    /// Plastic flow of its particles.
    pub flowed: Flowed,
    /// Whether all its particles stayed in their cells.
    pub stays: bool,
    /// Whether other cells have come to hold their water.
    pub changed: bool,
}

/// A strip as the kernel sees it: vectors of so many cells.
pub struct StripVectors<'a, V: Simd> {
    simd: V,
    /// Number of its first cell.
    pub first: usize,
    /// Solid particles.
    pub solid: BlockVectors<'a, V>,
    /// Water particles; none when dry.
    pub water: BlockVectors<'a, V>,
    /// Its cells.
    cells: &'a mut [[V::f64s; NUMBERS]],
    /// As [`Strip::sums`].
    pub sums: &'a mut StepSums,
    /// As [`Strip::coupling`].
    pub coupling: &'a mut [f64],
    /// As [`Strip::shared`].
    pub shared: &'a mut [f64],
}

impl<V: Simd> StripVectors<'_, V> {
    /// Groups of cells.
    #[inline(always)]
    pub fn groups(&self) -> usize {
        self.cells.len()
    }

    /// The cells of a group.
    #[inline(always)]
    pub fn cell<const D: usize>(&self, group: usize) -> SimdCells<V, D> {
        let (simd, cells) = (self.simd, &self.cells[group]);
        let of = |number: usize| SimdReal { simd, value: cells[number] };
        SimdCells {
            position: array!([of(0); D], d => of(d)),
            at: array!([of(AT); D], d => of(AT + d)),
            mass: of(MASS),
            volume: of(VOLUME),
            inverse_volume: of(INVERSE_VOLUME),
            porosity: of(POROSITY),
            inverse_porosity: of(INVERSE_POROSITY),
            filling: of(FILLING),
            fill: of(FILL),
            holds: of(HOLDS),
        }
    }

    /// Notes one of their numbers.
    #[inline(always)]
    pub fn note(&mut self, group: usize, number: usize, value: SimdReal<V>) {
        self.cells[group][number] = value.value;
    }

    /// Notes the centroids of their particles, in cell coordinates.
    #[inline(always)]
    pub fn note_centroid<const D: usize>(&mut self, group: usize, at: &[SimdReal<V>; D]) {
        for d in 0..D {
            self.cells[group][AT + d] = at[d].value;
        }
    }

    /// Asks the memory for a group of cells.
    #[inline(always)]
    pub fn ask_for_cells(&self, group: usize) {
        super::ask_for(self.cells, group);
    }
}

impl<const D: usize> Strip<D> {
    /// A strip without particles, of so many cells side by side.
    pub fn new(frame: &Frame<D>, number: usize, lanes: usize) -> Self {
        let (first, groups) = (number * frame.strip, frame.strip / lanes);
        let mut strip = Self {
            first,
            solid: Blocks::new(groups, lanes),
            water: Blocks::new(groups, lanes),
            cells: Aligned::zeros(frame.strip * NUMBERS),
            lanes,
            sums: StepSums { rates: [0.0; 2], flowed: Flowed::NOTHING, stays: true, changed: false },
            coupling: Vec::new(),
            shared: Vec::new(),
        };
        for cell in 0..frame.strip {
            let place = frame.position(first + cell);
            for d in 0..D {
                let [position, at] = [d, AT + d].map(|number| strip.place(cell, number));
                (strip.cells[position], strip.cells[at]) = (place[d] as f64, 0.5);
            }
        }
        strip
    }

    /// As the kernel sees it; V has as many lanes as cells are side by side.
    #[inline(always)]
    pub fn vectors<V: Simd>(&mut self, simd: V) -> StripVectors<'_, V> {
        let Self { first, solid, water, cells, sums, coupling, shared, .. } = self;
        let (solid, water, cells) = (solid.vectors(), water.vectors(), vectors_mut(cells));
        StripVectors { simd, first: *first, solid, water, cells, sums, coupling, shared }
    }

    /// Where a number of a cell stands.
    #[inline]
    fn place(&self, cell: usize, number: usize) -> usize {
        let group = cell >> self.lanes.trailing_zeros();
        (group * NUMBERS + number) * self.lanes + (cell & (self.lanes - 1))
    }

    /// A number of a cell, given by its number in the strip.
    #[inline]
    fn of(&self, cell: usize, number: usize) -> f64 {
        self.cells[self.place(cell, number)]
    }

    /// Cells side by side.
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// Groups of cells, as many of them as are side by side.
    pub fn groups(&self) -> usize {
        self.cells.len() / (NUMBERS * self.lanes)
    }

    /// Volume (m3) and dry mass (kg) of the soil in a cell, given by its number in the strip.
    pub fn volume_and_mass(&self, cell: usize) -> [f64; 2] {
        [self.of(cell, VOLUME), self.of(cell, MASS)]
    }

    /// Porosity of a cell, and 1/V of its soil, 1/m3.
    pub fn pores(&self, cell: usize) -> [f64; 2] {
        [self.of(cell, POROSITY), self.of(cell, INVERSE_VOLUME)]
    }

    /// Whether the water of a cell has a pressure, where it may be open to the air.
    pub fn holds(&self, cell: usize) -> bool {
        self.of(cell, HOLDS) > 0.0
    }

    /// Where its particles have their strain if they share a place, in cell coordinates.
    pub fn centroid(&self, cell: usize) -> [f64; D] {
        array!([0.0; D], d => self.of(cell, AT + d))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let coupling = (self.coupling.capacity() + self.shared.capacity()) * size_of::<f64>();
        coupling + self.solid.bytes() + self.water.bytes() + self.cells.bytes()
    }
}

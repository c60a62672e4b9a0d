//! What a cell does in a step, written once: Darcy flow and mesh to particles of this step, particles to mesh of the next.
//!
//! Between the two passes over a particle in the paper's Figure 1 nothing happens to it, so they are one. The kernel is generic
//! over the dimension, over the functions that carry a field ([`Functions`]: those of one cell in `on_cell`, wider ones in
//! `stencil`), and over how many cells it takes at once: one, or as many as a SIMD vector holds. SIMD lanes do not mix and
//! products are not fused with sums, so the bits are the same.

mod bases;
mod dispatch;
pub mod equation;
mod map_back;
mod null_space;
mod on_cell;
mod scatter;
mod stencil;
mod water;

pub use bases::{Basis, Bspline, Gimp, Line};
pub use dispatch::{Kernel, Scheme, Traveller, Vectorised};
use map_back::MapBack;
pub use on_cell::{B_BAR, CENTRE, CENTROID, LINEAR};
pub use stencil::Over;

use std::ops::{Deref, DerefMut};

use pulp::{Simd, WithSimd};

use super::domains::{Around, Domains, Shared};
use super::store::nodes::{SUMS, StripSums};
use super::store::strip::{MASS, VOLUME};
use super::store::{Frame, Motion, Nodes, SimdCells, SolidLanes, Strip, StripVectors, ask_for};
use crate::boundary::ROUND_OFF;
use crate::constitutive::{Flow, LinearElastic, Materials, STATES, State};
use crate::dimension::{PRESSURE, rotate, strain_increment, trace};
use crate::observe::Flowed;
use crate::real::{MAX_LANES, Real, SimdReal, array};
use crate::water::FaceFlow;
use scatter::Scatter;

/// Most functions that the particles of a cell reach along an axis.
pub const MOST_REACH: usize = 4;
/// Most that they reach in the plane.
pub const MOST_REACHED: usize = MOST_REACH * MOST_REACH;
/// How many blocks of particles to ask for in advance.
const BLOCKS_AHEAD: usize = 12;
/// How many groups of cells to ask for in advance.
const GROUPS_AHEAD: usize = 3;
/// The fill of a cell whose soil is not known: its water is as stiff as in a full one.
const NOT_KNOWN: f64 = 1e60;

/// Fields at the functions that a group of cells reaches.
pub struct Fields<'a, V: Simd, const D: usize> {
    /// Proof that the SIMD instructions of the CPU may be used.
    pub simd: V,
    /// Velocities of the functions, m/s.
    pub velocity: &'a [Vec<f64>; 2],
    /// What a particle adds to its velocity, m/s.
    pub change: &'a [Vec<f64>; 2],
    /// Velocities that strain the soil, where they are others.
    pub mapped: Option<&'a [Vec<f64>; 2]>,
    /// Numbering.
    pub frame: &'a Frame<D>,
    /// Number of the first cell.
    pub at: usize,
    /// Whether their centroids are found ([`Frame::finds_centroids`]).
    pub found: bool,
}

impl<V: Simd, const D: usize> Fields<'_, V, D> {
    /// A field at function `a` of those that the cells reach.
    #[inline(always)]
    pub fn load(&self, field: &[f64], offset: usize) -> SimdReal<V> {
        SimdReal::load(self.simd, &field[self.at + offset..])
    }

    /// A field at the corners of the cells; in a column at both ends, twice.
    #[inline(always)]
    pub fn corners(&self, field: &[f64]) -> [SimdReal<V>; 4] {
        let row = self.frame.stride[D - 1];
        let lower = &field[self.at..][..V::F64_LANES + 1];
        let [a, b] = [SimdReal::load(self.simd, lower), SimdReal::load(self.simd, &lower[1..])];
        if D == 1 {
            return [a, b, a, b];
        }
        let upper = &field[self.at + row..][..V::F64_LANES + 1];
        [a, b, SimdReal::load(self.simd, upper), SimdReal::load(self.simd, &upper[1..])]
    }
}

/// Where cells are in a section about an axis: distance of their lower corner from that, in cells; none in plane strain.
pub type FromAxis<V> = Option<SimdReal<V>>;

/// Radius of a place in cells, in cells.
#[inline(always)]
pub fn radius<V: Simd, const D: usize>(from: FromAxis<V>, xi: &[SimdReal<V>; D]) -> Option<SimdReal<V>> {
    Some(from? + xi[0])
}

/// A number at each of the functions that a group of cells reaches. A vector that lies across two lines of the cache costs twice as much.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Nodal<V: Simd>([SimdReal<V>; MOST_REACHED]);

impl<V: Simd> Nodal<V> {
    /// The same number at all of them.
    #[inline(always)]
    pub fn splat(simd: V, number: f64) -> Self {
        Self([SimdReal::splat(simd, number); MOST_REACHED])
    }
}

impl<V: Simd> Deref for Nodal<V> {
    type Target = [SimdReal<V>; MOST_REACHED];
    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<V: Simd> DerefMut for Nodal<V> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

/// What a group of cells gives to the functions that it reaches, by sum.
pub type Given<V> = [Nodal<V>; SUMS];

/// What the mesh does to a particle.
pub struct Moves<V: Simd, const D: usize> {
    /// Velocity gradient that strains it, 1/s.
    pub gradient: [[SimdReal<V>; D]; D],
    /// Velocity that it moves with, m/s.
    pub velocity: [SimdReal<V>; D],
    /// What is added to its own, m/s.
    pub change: [SimdReal<V>; D],
}

/// A velocity gradient that a particle carries, 1/s.
#[derive(Clone, Copy)]
pub struct Affine<V: Simd, const D: usize>(pub [[SimdReal<V>; D]; D]);

impl<V: Simd, const D: usize> Affine<V, D> {
    /// Velocity (m/s) of a particle at a place away from it (m).
    #[inline(always)]
    pub fn seen_from(&self, v: &[SimdReal<V>; D], away: &[SimdReal<V>; D]) -> [SimdReal<V>; D] {
        let mut sum = *v;
        for i in 0..D {
            for j in 0..D {
                sum[i] += self.0[i][j] * away[j];
            }
        }
        sum
    }
}

/// What a particle gives to the nodes.
pub struct Contribution<V: Simd, const D: usize> {
    /// Its place in the cell.
    pub xi: [SimdReal<V>; D],
    /// Dry mass, kg.
    pub mass: SimdReal<V>,
    /// Volume, m3.
    pub volume: SimdReal<V>,
    /// Velocity, m/s.
    pub v: [SimdReal<V>; D],
    /// Stress, Pa: effective over functions of a cell, which add the pressure once; total over stencils.
    pub stress: [SimdReal<V>; 4],
    /// Its velocity gradient, where those are carried.
    pub affine: Option<Affine<V, D>>,
    /// Where its cell is about an axis.
    pub from_axis: FromAxis<V>,
}

/// What closes the sums of a cell.
pub struct Closing<V: Simd, const D: usize> {
    /// Factor on stresses times the volumes of particles: how much soil there is over that.
    pub share: SimdReal<V>,
    /// Volume of soil, m3.
    pub filled: SimdReal<V>,
    /// Centroid of the particles, in cell coordinates.
    pub at: [SimdReal<V>; D],
    /// Pore pressure that pushes, Pa; none in dry soil, or where it is solved for.
    pub pressure: Option<SimdReal<V>>,
    /// Where it acts.
    pub pressed_at: [SimdReal<V>; D],
    /// Volume of the water particles, m3, or one.
    pub full_of_water: SimdReal<V>,
    /// Whether the pressure is one number in the cell.
    pub of_cell: bool,
    /// Mass of water over that of the grains, for cells whose water moves with the soil.
    pub water_ratio: Option<SimdReal<V>>,
    /// Which cells those are.
    pub moving_with: V::m64s,
    /// Mass of water (kg) and the place in the cell where it is, where that is given.
    pub given_water: Option<(SimdReal<V>, [SimdReal<V>; D])>,
    /// Where the cells are about an axis.
    pub from_axis: FromAxis<V>,
}

impl<V: Simd, const D: usize> Closing<V, D> {
    /// Of cells whose soil fills a volume (m3) as its particles do, without water.
    #[inline(always)]
    fn of(filled: SimdReal<V>) -> Self {
        let (none, half, one) = (filled.like(0.0), filled.like(0.5), filled.like(1.0));
        Self {
            share: one,
            filled,
            at: [half; D],
            pressure: None,
            pressed_at: [half; D],
            full_of_water: one,
            of_cell: false,
            water_ratio: None,
            moving_with: one.below(none),
            given_water: None,
            from_axis: None,
        }
    }
}

/// A family of functions that carry fields, written for so many cells at once.
pub trait Functions<const D: usize>: Copy + Send + Sync + 'static {
    /// Functions that the particles of a cell reach along an axis.
    const REACH: usize;
    /// How many of those have a smaller number than the cell.
    const BEFORE: usize;
    /// How many more functions than cells there are along an axis.
    const EXTRA: usize;
    /// Whether a particle is gathered right after it has moved: the pressure of its cell is added at the end.
    const FUSED: bool;
    /// Whether what changes volumes is taken at the centre of the cell (B-bar).
    const SPLIT: bool = false;
    /// Whether all particles of a cell are strained alike.
    const OF_CELL: bool = false;
    /// Whether pore pressures follow the strains of their own particles.
    const PRESSURE_AT_PARTICLES: bool = false;
    /// Whether the functions are numbered as the nodes of the mesh, and have their values there.
    const NODAL: bool = false;
    /// What a group of cells has of the sides of the mesh.
    type Edges<V: Simd>: Copy;
    /// Motion in a group of cells.
    type Motion<V: Simd>;
    /// Motion of the water in them.
    type Water<V: Simd>: Copy;
    /// What its particles give.
    type Sums<V: Simd>;

    /// Whether all particles of a cell are strained as at the centroid of the soil in it.
    #[inline(always)]
    fn at_centroid(&self) -> bool {
        false
    }
    /// For cells at a place on the lattice of so many.
    fn edges<V: Simd>(&self, position: &[SimdReal<V>; D], cells: &[usize; D]) -> Self::Edges<V>;
    /// No motion.
    fn at_rest<V: Simd>(&self, simd: V) -> Self::Motion<V>;
    /// Finds the motion of the cells, the particles of which have a centroid (cell coordinates).
    fn find_motion<V: Simd>(
        &self,
        motion: &mut Self::Motion<V>,
        fields: &Fields<V, D>,
        edges: &Self::Edges<V>,
        centroid: &[SimdReal<V>; D],
    );
    /// Rate of volume at the centre of the cells, 1/s.
    fn middle<V: Simd>(&self, motion: &Self::Motion<V>, from_axis: FromAxis<V>, inverse_size: f64) -> SimdReal<V>;
    /// Hoop strain rate v_r/r (1/s) of particles at a place in their cells, where all particles are strained as they are.
    fn hoop<V: Simd>(
        &self,
        motion: &Self::Motion<V>,
        edges: &Self::Edges<V>,
        xi: &[SimdReal<V>; D],
        from_axis: SimdReal<V>,
        inverse_size: f64,
    ) -> SimdReal<V>;
    /// What the mesh does to particles at a place in their cells.
    fn moves<V: Simd>(
        &self,
        motion: &Self::Motion<V>,
        edges: &Self::Edges<V>,
        xi: &[SimdReal<V>; D],
        inverse_size: f64,
    ) -> Moves<V, D>;
    /// Gradient of the velocity of the functions at particles, 1/s.
    fn gradient_at<V: Simd>(
        &self,
        motion: &Self::Motion<V>,
        edges: &Self::Edges<V>,
        xi: &[SimdReal<V>; D],
        inverse_size: f64,
    ) -> [[SimdReal<V>; D]; D];
    /// Motion of water that flows through the soil with a relative velocity v*, m/s.
    fn find_water<V: Simd>(&self, motion: &Self::Motion<V>, relative: &Relative<V, D>) -> Self::Water<V>;
    /// Velocity `v_w = v_s + v*` (m/s) of water particles and, if pressures follow it, the rate of volume (1/s) of the soil there.
    fn with_water<V: Simd>(
        &self,
        motion: &Self::Motion<V>,
        water: &Self::Water<V>,
        edges: &Self::Edges<V>,
        xi: &[SimdReal<V>; D],
        inverse_size: f64,
    ) -> ([SimdReal<V>; D], SimdReal<V>);

    /// Values of the functions that a particle in a cell at a place of so many reaches.
    fn values(&self, position: &[usize; D], cells: &[usize; D], xi: &[f64; D]) -> [f64; MOST_REACHED];
    /// Shares of an amount at a point of the surface above the cell at a place of so many.
    fn at_surface(&self, position: &[usize; D], cells: &[usize; D], xi: &[f64; D], amount: f64) -> [f64; MOST_REACHED];
    /// Accelerations at the nodes of the mesh, where those of the functions are others.
    fn accelerations_of_mesh(&self, _: &Nodes<D>, _: &mut [Vec<f64>; 2]) {}

    /// Nothing gathered.
    fn nothing<V: Simd>(&self, simd: V) -> Self::Sums<V>;
    /// Forgets what was gathered; coupled and found as in [`Functions::add`].
    fn clear<V: Simd>(&self, simd: V, sums: &mut Self::Sums<V>, how: (bool, bool));
    /// Adds a particle; `coupled` if the force of a unit pressure is to be known, `found` if centroids are, 1/L in 1/m.
    fn add<V: Simd>(
        &self,
        sums: &mut Self::Sums<V>,
        edges: &Self::Edges<V>,
        point: &Contribution<V, D>,
        how: (bool, bool, f64),
    );
    /// Adds mass (kg), volume (m3) and pressure (Pa) of a water particle.
    fn add_water<V: Simd>(
        &self,
        sums: &mut Self::Sums<V>,
        edges: &Self::Edges<V>,
        xi: &[SimdReal<V>; D],
        water: [SimdReal<V>; 3],
        from_axis: FromAxis<V>,
    );
    /// Sums of V p and of V over the water particles.
    fn water_of<V: Simd>(&self, sums: &Self::Sums<V>) -> [SimdReal<V>; 2];
    /// Centroid of the particles, if strains are taken there; from their volume, or one where there are none.
    fn centroid<V: Simd>(&self, _: &Self::Sums<V>, _: SimdReal<V>, _: bool) -> Option<[SimdReal<V>; D]> {
        None
    }
    /// Gives what the cells have gathered; `room` may hold it.
    fn finish<'a, V: Simd>(
        &self,
        sums: &'a mut Self::Sums<V>,
        edges: &Self::Edges<V>,
        cell: &Closing<V, D>,
        inverse_size: f64,
        room: &'a mut Given<V>,
    ) -> &'a Given<V>;
    /// C: force of a unit pressure in the cells on their functions, m2.
    fn coupling<V: Simd>(
        &self,
        sums: &Self::Sums<V>,
        edges: &Self::Edges<V>,
        cell: &Closing<V, D>,
        inverse_size: f64,
    ) -> [[SimdReal<V>; D]; MOST_REACHED];
}

/// What particles keep beside their records, as places in these.
#[derive(Debug, Clone, Copy, Default)]
pub struct Kept {
    /// Velocity gradient, row by row.
    pub affine: Option<usize>,
    /// State of the material.
    pub state: Option<usize>,
    /// Size of the box that it is along each axis, m.
    pub extent: Option<usize>,
    /// Strain that is followed, xx, yy, zz, xy (tensor components).
    pub strain: Option<usize>,
}

/// The water of a pass.
#[derive(Debug, Clone, Copy)]
pub enum InPores<'a> {
    /// Dry soil.
    None,
    /// Particles that fill the pores; `relative` are velocities v* at the nodes, where flow is not through faces.
    Particles {
        /// v*, m/s.
        relative: Option<&'a [Vec<f64>; 2]>,
        /// Rise of the pressure of each cell in the step, Pa, where it has been solved for.
        rise: Option<&'a [f64]>,
        /// Whether water may leave soil that runs out: cells are then filled in part, and a partly drained edge lets some out.
        partly_drained: bool,
    },
    /// Pressure (Pa), mass of water per volume of soil (kg/m3), and the heights in the cell where each acts, of every cell.
    Given {
        /// Pa.
        pressure: &'a [f64],
        /// kg/m3.
        per_volume: &'a [f64],
        /// Factor on the height of the centroid.
        lower: &'a [f64],
        /// Cell coordinate.
        middle: &'a [f64],
    },
}

/// What few scenes have of [`Common`].
#[derive(Clone, Copy, Default)]
pub struct Rare<'a, const D: usize> {
    /// Velocities that strain the soil, where they are others, m/s.
    pub mapped: Option<&'a [Vec<f64>; 2]>,
    /// Conductivity of the faces over that of the water, where it is not one.
    pub ratio: Option<&'a [Vec<f64>; 2]>,
    /// Volume of the grains of the cells per mass, m3/kg, where not all weigh the same.
    pub grains: Option<&'a [f64]>,
    /// Biot's coefficient of the cells, and what their grains give per volume and pressure (1/Pa), where some compress.
    pub biot: Option<[&'a [f64]; 2]>,
    /// What leaves the cells through an outline that cuts them and through wells, m3/s.
    pub outflow: Option<&'a [f64]>,
    /// What is left of the stiffness of their water where an outline cuts them.
    pub softness: Option<&'a [f64]>,
    /// Distance of x = 0 from the axis of an axisymmetric section, in cells.
    pub axis: Option<f64>,
    /// As [`Frame::finds_centroids`].
    pub found: bool,
    /// Strain over which the null-space filter takes differences between the particles of a cell to 1/e, where it is on.
    pub null_space: Option<f64>,
    /// Strain rates of the cells, where particles are boxes.
    pub domains: Option<&'a Domains<D>>,
}

/// Everything a pass reads and no strip changes.
#[derive(Clone, Copy)]
pub struct Common<'a, const D: usize> {
    /// Numbering.
    pub frame: &'a Frame<D>,
    /// Motion of the functions in this step.
    pub motion: &'a Motion,
    /// Accelerations of the nodes of the mesh, m/s2.
    pub acceleration: &'a [Vec<f64>; 2],
    /// The water.
    pub water: InPores<'a>,
    /// Pore pressure of the cells at its start, Pa; from [`Frame::pad`] on.
    pub pressure: &'a [f64],
    /// How faces conduct, over the conductivity of the water: 0 closed, 1 between two full cells of soil, 2 at a drained side, half
    /// a cell away; else the edge of a cell over the distance.
    pub conducts: &'a [Vec<f64>; 2],
    /// What few scenes have.
    pub rare: Rare<'a, D>,
    /// Volume of soil in the cells at the end of the pass, m3, where it is known; else zero.
    pub soil: &'a [f64],
    /// Whether the mesh moves the particles; else they are only gathered.
    pub moves: bool,
    /// The only material of the skeleton, if it is elastic.
    pub elastic: Option<&'a LinearElastic>,
    /// Materials of the skeleton.
    pub materials: &'a Materials,
    /// Whether any of them dissipates.
    pub plastic: bool,
    /// Darcy's law on a face.
    pub flow: FaceFlow,
    /// Gravity, m/s2.
    pub gravity: [f64; D],
    /// FLIP share of the velocity update.
    pub flip: f64,
    /// Soil less dense than this (dry, kg/m3) is a tension gap and carries no stress; 0 if it always does.
    pub apart: f64,
    /// What particles keep.
    pub kept: Kept,
    /// Whether pressures are solved for, and the force of a unit pressure is wanted.
    pub coupled: bool,
    /// Time step, s.
    pub dt: f64,
}

impl<const D: usize> Common<'_, D> {
    /// The same, if it has none of what few scenes have: plastic or several materials, layers that conduct differently, velocities
    /// that are mapped back, what particles keep, pressures that are solved for or carried, water that runs out. The kernel is
    /// compiled a second time without all that, for room in the registers.
    #[inline(always)]
    pub fn lean(&self) -> Option<Self> {
        let elastic = Some(self.elastic?);
        let water = match self.water {
            _ if self.coupled => return None,
            InPores::None => InPores::None,
            InPores::Particles { relative: None, rise: None, partly_drained: false } => {
                InPores::Particles { relative: None, rise: None, partly_drained: false }
            }
            _ => return None,
        };
        let Rare { mapped: None, ratio: None, grains: None, biot: None, .. } = self.rare else { return None };
        let Rare { outflow: None, softness: None, axis: None, found: false, .. } = self.rare else { return None };
        let Rare { null_space: None, domains: None, .. } = self.rare else { return None };
        let Kept { affine: None, state: None, extent: None, strain: None } = self.kept else { return None };
        let kept = Kept { affine: None, state: None, extent: None, strain: None };
        Some(Self { elastic, water, kept, plastic: false, coupled: false, rare: Rare::default(), ..*self })
    }
}

/// The pass over one strip, as it is asked for. LEAN: without what few scenes have ([`Common::lean`]).
pub struct Sweep<'a, F, const D: usize, const LEAN: bool> {
    /// The functions.
    pub functions: F,
    /// The strip.
    pub strip: &'a mut Strip<D>,
    /// What it gives to the nodes.
    pub sums: &'a mut StripSums,
    /// Where the pore pressure of its cells goes, Pa.
    pub pressure: &'a mut [f64],
    /// What all strips share.
    pub common: &'a Common<'a, D>,
}

impl<F: Functions<D>, const D: usize, const LEAN: bool> WithSimd for Sweep<'_, F, D, LEAN> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, simd: V) {
        let Self { functions, strip, sums, pressure, common } = self;
        let strip = strip.vectors(simd);
        if LEAN {
            let common = &common.lean().expect("a scene without rare parts");
            Pass::<V, F, D, LEAN> { functions, sums, cells: Cells { simd, strip, pressure, common } }.run();
        } else {
            Pass::<V, F, D, LEAN> { functions, sums, cells: Cells { simd, strip, pressure, common } }.run();
        }
    }
}

/// The same as it is done, so many cells at once.
struct Pass<'a, V: Simd, F, const D: usize, const LEAN: bool> {
    cells: Cells<'a, V, D>,
    functions: F,
    sums: &'a mut StripSums,
}

/// The cells and particles of a strip, and what does not depend on the functions. It is compiled once for all of them.
struct Cells<'a, V: Simd, const D: usize> {
    simd: V,
    strip: StripVectors<'a, V>,
    pressure: &'a mut [f64],
    common: &'a Common<'a, D>,
}

impl<'a, V: Simd, F, const D: usize, const LEAN: bool> Deref for Pass<'a, V, F, D, LEAN> {
    type Target = Cells<'a, V, D>;
    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        &self.cells
    }
}

impl<V: Simd, F, const D: usize, const LEAN: bool> DerefMut for Pass<'_, V, F, D, LEAN> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.cells
    }
}

/// Plastic flow of the particles of a strip, in as many parts as the widest SIMD vector has lanes: the bits do not depend on how
/// many it has.
struct FlowedLanes<V: Simd> {
    dissipation: [SimdReal<V>; MAX_LANES],
    residual: SimdReal<V>,
}

impl<V: Simd> FlowedLanes<V> {
    #[inline(always)]
    fn nothing(simd: V) -> Self {
        let none = SimdReal::splat(simd, 0.0);
        Self { dissipation: [none; MAX_LANES], residual: none.like(f64::NEG_INFINITY) }
    }

    /// Adds one particle of each cell of a group, of a volume (m3).
    #[inline(always)]
    fn add(&mut self, group: usize, volume: SimdReal<V>, flow: &Flow<SimdReal<V>>) {
        self.dissipation[group % (MAX_LANES / V::F64_LANES)] += volume * flow.dissipation;
        self.residual = flow.residual.larger(self.residual);
    }

    #[inline(always)]
    fn added_up(&self) -> Flowed {
        let mut flowed = Flowed::NOTHING;
        for part in 0..MAX_LANES {
            flowed.dissipation += self.dissipation[part / V::F64_LANES].lane(part % V::F64_LANES);
        }
        for lane in 0..V::F64_LANES {
            flowed.residual = flowed.residual.max(self.residual.lane(lane));
        }
        flowed
    }
}

/// Has the stack of the function that it is in aligned to lines of the cache. Vectors that wait there would otherwise lie across two
/// of these, and some across two pages, which costs as much as a tenth of a step.
#[inline(always)]
fn align_stack() {
    #[repr(align(64))]
    struct Line(#[expect(dead_code, reason = "takes the place")] [u8; 64]);
    let mut line = Line([0; 64]);
    std::hint::black_box(&mut line);
}

/// A vector field in a cell that is linear along each axis, as coefficients.
pub type Relative<V, const D: usize> = [[SimdReal<V>; D]; 4];

/// Rate of volume (1/s) of a velocity gradient and a hoop strain rate.
#[inline(always)]
pub fn rate_of_volume<V: Simd, const D: usize>(
    gradient: &[[SimdReal<V>; D]; D],
    hoop: Option<SimdReal<V>>,
) -> SimdReal<V> {
    match hoop {
        Some(hoop) => trace(gradient) + hoop,
        None => trace(gradient),
    }
}

/// What a group of cells has gathered: sums for its functions, mass (kg) and volume (m3) of its soil, what its boxes share.
type Gathered<'a, V, F, const D: usize> =
    (&'a mut <F as Functions<D>>::Sums<V>, &'a mut [SimdReal<V>; 2], &'a mut Option<Shared<V, D>>);

/// What a group of cells works in.
struct Room<V: Simd, F: Functions<D>, const D: usize> {
    motion: F::Motion<V>,
    sums: F::Sums<V>,
    given: Given<V>,
}

/// What a pass over a strip adds up.
struct Running<V: Simd> {
    rates: [[SimdReal<V>; MAX_LANES]; 2],
    flowed: FlowedLanes<V>,
    stays: V::m64s,
}

impl<V: Simd, F: Functions<D>, const D: usize, const LEAN: bool> Pass<'_, V, F, D, LEAN> {
    #[inline(always)]
    fn run(mut self) {
        align_stack();
        let none = SimdReal::splat(self.simd, 0.0);
        let mut running = Running {
            rates: [[none; MAX_LANES]; 2],
            flowed: FlowedLanes::nothing(self.simd),
            stays: none.in_unit_interval(),
        };
        let functions = self.functions;
        let mut room = Room {
            motion: functions.at_rest(self.simd),
            sums: functions.nothing(self.simd),
            given: [Nodal::splat(self.simd, 0.0); SUMS],
        };
        let mut scatter = Scatter::<V, D>::begin(self.simd, F::REACH, self.sums, self.common.frame);
        // Where water particles flow, the lower faces of an empty cell may be the drained surface of the one below.
        let skips = !matches!(self.common.water, InPores::Particles { .. });
        for group in 0..self.strip.groups() {
            if skips && self.stays_empty(group) {
                scatter.skip(F::REACH, self.sums, group * V::F64_LANES);
                continue;
            }
            let given = self.group(group, &mut running, &mut room);
            scatter.add(F::REACH, self.sums, group * V::F64_LANES, given);
        }
        scatter.end(F::REACH, self.sums, self.strip.groups() * V::F64_LANES);
        self.strip.sums.stays = SimdReal::nowhere(self.simd, self.simd.not_m64s(running.stays));
        if self.common.moves && self.common.plastic {
            self.strip.sums.flowed = running.flowed.added_up();
        }
        if self.common.moves && !matches!(self.common.water, InPores::None) {
            for (rate, lanes) in self.strip.sums.rates.iter_mut().zip(running.rates) {
                *rate = 0.0;
                for part in 0..MAX_LANES {
                    *rate += lanes[part / V::F64_LANES].lane(part % V::F64_LANES);
                }
            }
        }
    }

    /// A group of cells: Figure 1 from the mesh to the particles and back.
    #[inline(always)]
    fn group<'b>(&mut self, group: usize, running: &mut Running<V>, room: &'b mut Room<V, F, D>) -> &'b Given<V> {
        let Room { motion: moving, sums, given } = room;
        let Common { frame, motion, water, rare, .. } = *self.common;
        let functions = self.functions;
        let none = SimdReal::splat(self.simd, 0.0);
        let at = self.strip.first + group * V::F64_LANES;
        let cell: SimdCells<V, D> = self.strip.cell(group);
        let position = cell.position;
        let edges = functions.edges(&position, &frame.cells);
        let wet = matches!(water, InPores::Particles { .. });
        functions.clear(self.simd, sums, (self.common.coupled, rare.found));
        let mut soil = [none; 2]; // mass, volume
        let mut shared = None;
        if rare.domains.is_some() {
            shared = Some(Shared::nothing(self.simd));
        }
        self.ask_for_cells(group, at);
        if self.common.moves {
            let Motion { velocity, change, .. } = motion;
            let Rare { mapped, found, .. } = rare;
            let fields = Fields { simd: self.simd, velocity, change, mapped, frame, at, found };
            functions.find_motion(moving, &fields, &edges, &cell.at);
            let motion = &*moving;
            let mut relative = if wet { self.darcy_flow(at, &cell, running, group) } else { [[none; D]; 4] };
            if let InPores::Particles { partly_drained: true, .. } = water {
                let holds = none.below(cell.holds);
                for k in 0..4 {
                    for d in 0..D {
                        relative[k][d] = relative[k][d].or(holds, none);
                    }
                }
            }
            let gained = self.solid(group, &position, (motion, &edges, &cell), (sums, &mut soil, &mut shared), running);
            // What is passed on to a function that is not inlined is known to be constant no more.
            if let (true, Some(strain)) = (!LEAN && (F::OF_CELL || F::SPLIT), rare.null_space) {
                let centre = array!([none; D], d => position[d].like(0.5));
                let gradient = functions.moves(motion, &edges, &centre, frame.inverse_size).gradient;
                self.filter(group, (&gradient, strain, F::SPLIT), &mut running.flowed);
            }
            if wet {
                self.water(group, &position, Some((motion, &relative, &cell, gained)), (&edges, sums), running);
            }
        } else if wet {
            self.water(group, &position, None, (&edges, sums), running);
        }
        if !(self.common.moves && self.is_fused()) {
            let pressure = self.pressure_on_particles(sums, at);
            for index in self.strip.solid.range(group) {
                let point = SolidLanes::<V, D>::read(self.simd, self.strip.solid.block(index));
                let xi = array!([none; D], d => point.x[d] * frame.inverse_size - position[d]);
                let shapes = (&edges, self.axis_of(position[0]));
                self.gather(&point, xi, pressure, index, shapes, (sums, &mut soil, &mut shared));
            }
        }
        if let Some(shared) = &shared {
            shared.store(self.strip.shared, frame.strip, group * V::F64_LANES);
        }
        self.close((group, at), &soil, &edges, sums, given)
    }

    /// Whether a particle is gathered right after it has moved: not where its stress is still to be filtered.
    #[inline(always)]
    fn is_fused(&self) -> bool {
        F::FUSED && self.common.rare.null_space.is_none()
    }

    /// Solid particles: strains, stresses, velocities and positions. Returns their volume and what it gains in time, m3 and m3/s.
    #[inline(always)]
    fn solid(
        &mut self,
        group: usize,
        position: &[SimdReal<V>; D],
        (motion, edges, cell): (&F::Motion<V>, &F::Edges<V>, &SimdCells<V, D>),
        (sums, soil, shared): Gathered<V, F, D>,
        running: &mut Running<V>,
    ) -> [SimdReal<V>; 2] {
        let Common { frame, elastic, materials, plastic, flip, apart, kept, dt, .. } = *self.common;
        let functions = self.functions;
        let (simd, inverse) = (self.simd, frame.inverse_size);
        let none = SimdReal::splat(simd, 0.0);
        let from_axis = self.axis_of(position[0]);
        let middle = if F::SPLIT { functions.middle(motion, from_axis, inverse) } else { none };
        let around = if F::OF_CELL || F::SPLIT { self.around(group) } else { None };
        let pressure = cell.volume.like(0.0);
        let mut gained = [none; 2];
        // Particles that are strained alike have their gradient once: the compiler then takes what follows from it out of the loop.
        let centre = array!([none; D], d => position[d].like(0.5));
        let alike = F::OF_CELL.then(|| functions.moves(motion, edges, &centre, inverse).gradient);
        for index in self.strip.solid.range(group) {
            self.ask_for_block(index + BLOCKS_AHEAD);
            let mut point = SolidLanes::<V, D>::read(simd, self.strip.solid.block(index));
            let mut xi = array!([none; D], d => point.x[d] * inverse - position[d]);
            let mut moves = functions.moves(motion, edges, &xi, inverse);
            moves.gradient = alike.unwrap_or(moves.gradient);
            let mut hoop = None;
            if let Some(from) = from_axis {
                hoop = Some(functions.hoop(motion, edges, &xi, from, inverse));
            }
            let of_point = rate_of_volume(&moves.gradient, hoop);
            if let Some((around, first)) = &around {
                let block = self.strip.solid.block_mut(index);
                let mut size = array!([none; D], d => SimdReal { simd, value: block[first + d] });
                around.stretch(&xi, &mut size, &mut moves, &mut hoop, dt);
                for d in 0..D {
                    block[first + d] = size[d].value;
                }
            }
            let Moves { gradient, velocity, change } = moves;
            rotate(&mut point.stress, &gradient, dt);
            let mut strain = strain_increment(&gradient, dt);
            let mut rate = rate_of_volume(&gradient, hoop);
            if let Some(hoop) = hoop {
                strain[2] = hoop * dt;
            }
            if F::SPLIT {
                let more = (middle - of_point) * (dt / 3.0);
                for s in 0..3 {
                    strain[s] += more;
                }
                rate = if around.is_some() { middle + (rate - of_point) } else { middle };
            }
            let there = none.below(point.volume);
            let ids = &self.strip.solid.ids[index * V::F64_LANES..][..V::F64_LANES];
            if let Some(law) = elastic {
                law.hooke(&mut point.stress, &strain);
            } else {
                let mut state = self.state(index);
                let flow = materials.update(&mut point.stress, &strain, &mut state, there, ids);
                if let Some(first) = kept.state {
                    for s in 0..STATES {
                        self.strip.solid.block_mut(index)[first + s] = state[s].value;
                    }
                }
                if plastic {
                    running.flowed.add(group, point.volume, &flow);
                }
            }
            if !F::OF_CELL && !F::PRESSURE_AT_PARTICLES && !F::SPLIT || self.common.coupled {
                gained[0] += point.volume;
                gained[1] += point.volume * if F::SPLIT { middle } else { of_point }; // C^T v
            }
            point.volume = point.volume * (none.like(1.0) + rate * dt);
            if plastic && apart > 0.0 {
                self.open_gap(&mut point, index, group, running);
            }
            if kept.affine.is_some() || kept.strain.is_some() {
                let own = functions.gradient_at(motion, edges, &xi, inverse);
                self.note(index, &own, &gradient);
            }
            for d in 0..D {
                point.v[d] = point.v[d] * flip + change[d];
                point.x[d] += velocity[d] * dt;
                xi[d] = point.x[d] * inverse - position[d];
                running.stays = simd.and_m64s(running.stays, xi[d].in_unit_interval());
            }
            point.write(self.strip.solid.block_mut(index));
            if self.is_fused() {
                self.gather(&point, xi, pressure, index, (edges, from_axis), (sums, soil, shared));
            }
        }
        gained
    }

    /// One particle of each cell to the mesh: masses, momenta and stresses.
    #[inline(always)]
    fn gather(
        &self,
        point: &SolidLanes<V, D>,
        xi: [SimdReal<V>; D],
        pressure: SimdReal<V>,
        index: usize,
        (edges, from_axis): (&F::Edges<V>, FromAxis<V>),
        (sums, soil, shared): Gathered<V, F, D>,
    ) {
        let Common { frame, kept, coupled, rare, .. } = *self.common;
        let functions = self.functions;
        let SolidLanes { mass, volume, v, mut stress, .. } = *point;
        soil[0] += mass;
        soil[1] += volume;
        if !F::FUSED {
            for s in 0..3 {
                stress[s] += pressure * PRESSURE[s];
            }
        }
        if let (Some(shared), Some(first)) = (shared, kept.extent) {
            let block = self.strip.solid.block(index);
            let size = array!([mass; D], d => self.of(block[first + d]) * frame.inverse_size);
            shared.add(&xi, &size, volume, &point.stress);
        }
        let mut affine = None;
        if let Some(first) = kept.affine {
            let block = self.strip.solid.block(index);
            let mut gradient = [[mass; D]; D];
            for i in 0..D {
                for j in 0..D {
                    gradient[i][j] = self.of(block[first + i * D + j]);
                }
            }
            affine = Some(Affine(gradient));
        }
        let point = Contribution { xi, mass, volume, v, stress, affine, from_axis };
        functions.add(sums, edges, &point, (coupled, rare.found, frame.inverse_size));
    }

    /// The cells' volumes are known: notes them for the next step, and gives the sums at their functions.
    #[inline(always)]
    fn close<'b>(
        &mut self,
        (group, at): (usize, usize),
        &[mass, volume]: &[SimdReal<V>; 2],
        edges: &F::Edges<V>,
        sums: &'b mut F::Sums<V>,
        room: &'b mut Given<V>,
    ) -> &'b Given<V> {
        let Common { frame, coupled, .. } = *self.common;
        let functions = self.functions;
        let none = mass.like(0.0);
        let full = volume.or_one();
        let known = SimdReal::load(self.simd, &self.common.soil[at..]);
        let is_known = none.below(known);
        // As `Filled::volume`: round-off is no difference.
        let off = (known - volume).larger(volume - known);
        let filled = known.or((known * ROUND_OFF).below(off), volume).or(is_known, volume);
        let half = none.like(0.5);
        let mut closing = Closing { of_cell: coupled, moving_with: is_known, ..Closing::of(filled) };
        if !SimdReal::nowhere(self.simd, filled.differs(volume)) {
            closing.share = filled / full;
        }
        closing.from_axis = self.axis_of(self.strip.cell::<D>(group).position[0]);
        self.strip.note(group, VOLUME, volume);
        self.strip.note(group, MASS, mass);
        if let Some(centroid) = functions.centroid(sums, full, self.common.rare.found) {
            self.strip.note_centroid(group, &centroid);
            (closing.at, closing.pressed_at) =
                (centroid, if functions.at_centroid() { closing.pressed_at } else { centroid });
        }
        match self.common.water {
            InPores::None => {}
            InPores::Particles { .. } => {
                self.close_water(group, [mass, volume], functions.water_of(sums), &mut closing);
            }
            InPores::Given { pressure, per_volume, lower, middle } => {
                closing.pressed_at = closing.at;
                if functions.centroid(sums, full, false).is_some() {
                    closing.pressed_at[D - 1] = closing.at[D - 1] * self.load(lower, at);
                }
                let mut place = [half; D];
                place[D - 1] = self.load(middle, at);
                closing.pressure = Some(self.load(pressure, at));
                closing.of_cell = true;
                closing.given_water = Some((self.load(per_volume, at) * volume, place));
            }
        }
        if coupled {
            let mut coupling = functions.coupling(sums, edges, &closing, frame.inverse_size);
            if let Some([alpha, _]) = self.common.rare.biot {
                let alpha = self.load(alpha, at);
                coupling.as_flattened_mut().iter_mut().for_each(|push| *push = *push * alpha);
            }
            let reached = F::REACH.pow(D as u32);
            for a in 0..reached {
                for d in 0..D {
                    for lane in 0..V::F64_LANES {
                        let cell = group * V::F64_LANES + lane;
                        self.strip.coupling[(cell * reached + a) * D + d] = coupling[a][d].lane(lane);
                    }
                }
            }
        }
        functions.finish(sums, edges, &closing, frame.inverse_size, room)
    }
}

impl<V: Simd, const D: usize> Cells<'_, V, D> {
    #[inline(always)]
    fn load(&self, field: &[f64], at: usize) -> SimdReal<V> {
        SimdReal::load(self.simd, &field[at..])
    }

    #[inline(always)]
    fn of(&self, value: V::f64s) -> SimdReal<V> {
        SimdReal { simd: self.simd, value }
    }

    /// Where cells at a place on the lattice are about the axis.
    #[inline(always)]
    pub(super) fn axis_of(&self, x: SimdReal<V>) -> FromAxis<V> {
        Some(x + SimdReal::splat(self.simd, self.common.rare.axis?))
    }

    /// Whether no cell of a group has soil, or had any in the last pass, which noted so.
    #[inline(always)]
    fn stays_empty(&self, group: usize) -> bool {
        let mass = self.strip.cell::<D>(group).mass;
        self.strip.solid.range(group).is_empty() && SimdReal::nowhere(self.simd, mass.like(0.0).below(mass))
    }

    /// Asks for cells, upper nodes and faces of a group to come.
    #[inline(always)]
    fn ask_for_cells(&self, group: usize, at: usize) {
        self.strip.ask_for_cells(group + GROUPS_AHEAD);
        if self.common.moves {
            let Common { frame, motion, pressure, conducts, .. } = self.common;
            let here = at + GROUPS_AHEAD * V::F64_LANES;
            for d in 0..D {
                for field in [&motion.velocity[d], &motion.change[d], &motion.acceleration[d]] {
                    ask_for(field, here + (frame.reach - 1) * frame.stride[D - 1]);
                }
                ask_for(&conducts[d], here + frame.stride[d]);
            }
            ask_for(pressure, here + 2 * frame.pad());
        }
    }

    /// Strain rates of the cells of a group and of those around them, and where particles keep their size, where they are boxes.
    #[inline(always)]
    fn around(&self, group: usize) -> Option<(Around<V, D>, usize)> {
        let domains = self.common.rare.domains?;
        Some((domains.around(self.simd, self.strip.first + group * V::F64_LANES), self.common.kept.extent?))
    }

    /// What the materials of a block of particles remember.
    #[inline(always)]
    fn state(&self, index: usize) -> State<SimdReal<V>> {
        let none = SimdReal::splat(self.simd, 0.0);
        match self.common.kept.state {
            Some(first) => array!([none; STATES], s => self.of(self.strip.solid.block(index)[first + s])),
            None => [none; STATES],
        }
    }

    /// Asks for a block of solid particles.
    #[inline(always)]
    fn ask_for_block(&self, index: usize) {
        self.strip.solid.ask_for(index, 2 * D + 6);
    }

    /// Soil in a tension gap has no stress until that is closed, or every recompression would push too early.
    #[inline(always)]
    fn open_gap(&self, point: &mut SolidLanes<V, D>, index: usize, group: usize, running: &mut Running<V>) {
        let none = point.volume.like(0.0);
        let gone = point.mass.below(point.volume * self.common.apart);
        if SimdReal::nowhere(self.simd, gone) {
            return;
        }
        let mut lost = none;
        for lane in 0..V::F64_LANES {
            if point.volume.lane(lane) * self.common.apart > point.mass.lane(lane) {
                let stress = array!([0.0; 4], s => point.stress[s].lane(lane));
                let id = self.strip.solid.ids[index * V::F64_LANES + lane];
                lost.set_lane(lane, self.common.materials.energy(id, &stress));
            }
        }
        let flow = Flow { dissipation: lost, residual: none.like(f64::NEG_INFINITY) };
        running.flowed.add(group, point.volume, &flow);
        for s in 0..4 {
            point.stress[s] = none.or(gone, point.stress[s]);
        }
    }

    /// Notes what particles keep of the motion: their own velocity gradient, and the strain that is followed.
    #[cold]
    #[inline(always)]
    fn note(&mut self, index: usize, own: &[[SimdReal<V>; D]; D], strains: &[[SimdReal<V>; D]; D]) {
        let Common { kept, dt, .. } = *self.common;
        let simd = self.simd;
        let block = self.strip.solid.block_mut(index);
        if let Some(first) = kept.affine {
            for i in 0..D {
                for j in 0..D {
                    block[first + i * D + j] = own[i][j].value;
                }
            }
        }
        if let Some(first) = kept.strain {
            let none = SimdReal::splat(simd, 0.0);
            let mut strain = array!([none; 4], s => SimdReal { simd, value: block[first + s] });
            rotate(&mut strain, strains, dt);
            let more = strain_increment(strains, dt);
            for s in 0..4 {
                // Engineering shear is twice the component of the tensor.
                let sum = strain[s] + if s == 3 { more[s] * 0.5 } else { more[s] };
                block[first + s] = sum.value;
            }
        }
    }
}

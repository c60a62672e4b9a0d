//! What the rest of a step sees of the kernel: a handful of calls, each for a strip of cells. Behind them SIMD width, functions and
//! water are types; before them nothing depends on any of these.

use pulp::{Scalar, Simd};

use super::equation::EquationOfMotion;
use super::{Common, Fields, Functions, MOST_REACHED, MapBack, Sweep, rate_of_volume};
use crate::real::{SimdReal, array};
use crate::step::domains::Domains;
use crate::step::store::{Motion, Nodes, Strip, StripSums};

/// What a step has to know of its functions; see [`Functions`].
#[derive(Debug, Clone, Copy)]
pub struct Scheme {
    /// Functions that the particles of a cell reach along an axis.
    pub reach: usize,
    /// How many of those have a smaller number than the cell.
    pub before: usize,
    /// How many more functions than cells there are along an axis.
    pub extra: usize,
    /// Whether a particle reaches all functions of its cell.
    pub on_cell: bool,
    /// Whether particles are strained as at the centroid of the soil in their cell.
    pub at_centroid: bool,
    /// Whether pore pressures follow the strains of their own particles.
    pub pressure_at_particles: bool,
    /// Whether what changes volumes is taken at the centre of the cell (B-bar).
    pub split: bool,
    /// Whether the functions are the nodes of the mesh.
    pub nodal: bool,
}

/// A particle at the start of a step, among its cell and the nodes.
pub struct Traveller<'a, const D: usize> {
    /// Position, m.
    pub x: [f64; D],
    /// Volume, m3.
    pub volume: f64,
    /// Size of the box that it is along each axis (m), and the strain rates of the cells, where particles are boxes.
    pub extent: Option<([f64; D], &'a Domains<D>)>,
    /// Number of its cell.
    pub cell: usize,
    /// Centroid of the soil in that, in cell coordinates.
    pub centroid: [f64; D],
    /// The nodes.
    pub nodes: &'a Nodes<D>,
    /// Nodes with the velocities that strain the soil, where they are others.
    pub mapped: Option<&'a Nodes<D>>,
}

/// The kernel of a run.
pub trait Kernel<const D: usize>: Send + Sync {
    /// Cells side by side: the lanes of a SIMD vector.
    fn lanes(&self) -> usize;
    /// The functions.
    fn scheme(&self) -> Scheme;
    /// One pass over the particles of a strip (Figure 1 from the mesh to the particles and back), with what it gives to the nodes and
    /// where the pore pressure of its cells goes, Pa.
    fn sweep(&self, strip: &mut Strip<D>, sums: &mut StripSums, pressure: &mut [f64], common: &Common<D>);
    /// Masses and momenta of the end of the step from the particles of a strip to the nodes.
    fn map_back(&self, strip: &mut Strip<D>, sums: &mut StripSums, common: &Common<D>);
    /// The equation of motion on the nodes of a strip.
    fn accelerate(&self, nodes: EquationOfMotion<D>);
    /// Position (m) and volume (m3) of a particle at the end of a step dt (s), to the bits that the pass will find.
    fn ahead(&self, particle: &Traveller<D>, dt: f64) -> ([f64; D], f64);
    /// As [`Functions::values`].
    fn values(&self, position: &[usize; D], cells: &[usize; D], xi: &[f64; D]) -> [f64; MOST_REACHED];
    /// As [`Functions::at_surface`].
    fn at_surface(&self, position: &[usize; D], cells: &[usize; D], xi: &[f64; D], amount: f64) -> [f64; MOST_REACHED];
    /// As [`Functions::accelerations_of_mesh`].
    fn accelerations_of_mesh(&self, nodes: &Nodes<D>, to: &mut [Vec<f64>; 2]);
}

/// The kernel of a SIMD width and a family of functions.
pub struct Vectorised<V, F> {
    /// Proof that the SIMD instructions of the CPU may be used.
    pub simd: V,
    /// The functions.
    pub functions: F,
}

impl<V: Simd, F: Functions<D>, const D: usize> Kernel<D> for Vectorised<V, F> {
    fn lanes(&self) -> usize {
        V::F64_LANES
    }

    fn scheme(&self) -> Scheme {
        Scheme {
            reach: F::REACH,
            before: F::BEFORE,
            extra: F::EXTRA,
            on_cell: F::FUSED,
            at_centroid: self.functions.at_centroid(),
            pressure_at_particles: F::PRESSURE_AT_PARTICLES,
            split: F::SPLIT,
            nodal: F::NODAL,
        }
    }

    fn sweep(&self, strip: &mut Strip<D>, sums: &mut StripSums, pressure: &mut [f64], common: &Common<D>) {
        let functions = self.functions;
        // Processors with vectors take the quicker of two loops, where they may.
        if V::F64_LANES > 1 && common.lean().is_some() {
            self.simd.vectorize(Sweep::<F, D, true> { functions, strip, sums, pressure, common });
        } else {
            self.simd.vectorize(Sweep::<F, D, false> { functions, strip, sums, pressure, common });
        }
    }

    fn map_back(&self, strip: &mut Strip<D>, sums: &mut StripSums, common: &Common<D>) {
        self.simd.vectorize(MapBack { functions: self.functions, strip, sums, common });
    }

    fn accelerate(&self, nodes: EquationOfMotion<D>) {
        self.simd.vectorize(nodes);
    }

    fn ahead(&self, particle: &Traveller<D>, dt: f64) -> ([f64; D], f64) {
        ahead(&self.functions, particle, dt)
    }

    fn values(&self, position: &[usize; D], cells: &[usize; D], xi: &[f64; D]) -> [f64; MOST_REACHED] {
        self.functions.values(position, cells, xi)
    }

    fn at_surface(&self, position: &[usize; D], cells: &[usize; D], xi: &[f64; D], amount: f64) -> [f64; MOST_REACHED] {
        self.functions.at_surface(position, cells, xi, amount)
    }

    fn accelerations_of_mesh(&self, nodes: &Nodes<D>, to: &mut [Vec<f64>; 2]) {
        self.functions.accelerations_of_mesh(nodes, to);
    }
}

/// [`Kernel::ahead`], one cell at a time.
fn ahead<F: Functions<D>, const D: usize>(functions: &F, particle: &Traveller<D>, dt: f64) -> ([f64; D], f64) {
    let Traveller { mut x, mut volume, extent, cell, centroid, nodes, mapped } = *particle;
    let Nodes { frame, motion: Motion { velocity, change, .. }, .. } = nodes;
    let mapped = mapped.map(|mapped| &mapped.motion.velocity);
    let found = frame.finds_centroids(F::SPLIT);
    let fields = Fields { simd: Scalar, velocity, change, mapped, frame, at: cell, found };
    let lone = |number: f64| SimdReal::splat(Scalar, number);
    let position = frame.position(cell);
    let position = array!([lone(0.0); D], d => lone(position[d] as f64));
    let edges = functions.edges(&position, &frame.cells);
    let centroid = array!([lone(0.0); D], d => lone(centroid[d]));
    let mut motion = functions.at_rest(Scalar);
    functions.find_motion(&mut motion, &fields, &edges, &centroid);
    let xi = array!([lone(0.0); D], d => lone(x[d] * frame.inverse_size) - position[d]);
    let mut moves = functions.moves(&motion, &edges, &xi, frame.inverse_size);
    let from_axis = frame.axis_in_cells.map(|axis| position[0] + lone(axis));
    let mut hoop = from_axis.map(|from| functions.hoop(&motion, &edges, &xi, from, frame.inverse_size));
    let of_point = rate_of_volume(&moves.gradient, hoop);
    if let Some((size, domains)) = extent {
        let mut size = array!([lone(0.0); D], d => lone(size[d]));
        domains.around(Scalar, cell).stretch(&xi, &mut size, &mut moves, &mut hoop, dt);
    }
    let mut rate = rate_of_volume(&moves.gradient, hoop);
    if F::SPLIT {
        let middle = functions.middle(&motion, from_axis, frame.inverse_size);
        rate = if extent.is_some() { middle + (rate - of_point) } else { middle };
    }
    volume *= 1.0 + dt * rate.lane(0);
    for d in 0..D {
        x[d] += dt * moves.velocity[d].lane(0);
    }
    (x, volume)
}

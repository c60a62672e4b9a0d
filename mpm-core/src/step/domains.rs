//! Particles as boxes that stretch with the soil (`scheme.particle_domain = "contiguous"`).
//!
//! Where the strain of a cell is that of its centre, so is that of a particle in it, and its stress counts in that cell, wherever it
//! lies. While particles lie evenly in their cells that is of second order. Once they have moved, a cell holds now one row more and
//! now one less, and the volumes of its particles are not that of the cell: first order in their spacing, and no order at all
//! where the spacing is a fixed share of the cell.
//!
//! A box has a size along each axis. It takes its strain rate from the cells that it lies in, by the share w of its volume, and gives
//! its stress to them by the same:
//!
//! ```text
//! grad v_p = sum_c w_pc (grad v)_c,     l' = l (grad v)_dd,     (V sigma)_c = sum_p w_pc V_p sigma_p
//! ```
//!
//! Its middle moves as the mean of its two ends does. So boxes that once filled the soil without gaps go on to do so under any strain
//! along the axes: their volumes are those of the cells, forces are the transpose of strains up to the factor that a known volume of
//! soil puts on those of a cell, and what leaves a column as water is what its soil has lost. Cells without a particle's middle take
//! no part: their share is that of the particle's own. A box is at most as long as a cell.
//!
//! Sources: contiguous particles of Bardenhagen & Kober, CMES 5(6), 2004, 477-496, doi:10.3970/cmes.2004.005.477, with gradients of the
//! centres of cells in place of those inside them.

use pulp::Simd;

use super::kernel::Moves;
use super::store::{Frame, Motion, Nodes, Strip};
use crate::real::{MAX_LANES, Real, SimdReal, array};

/// Strain rates of a cell: the velocity gradient row by row, and the hoop strain rate.
const RATES: usize = 5;
/// A cell and those around it.
const AROUND: usize = 9;
/// Those of them that there are, by rows from the lower corner.
const fn around(dimensions: usize) -> usize {
    if dimensions == 1 { 3 } else { AROUND }
}
/// What a box shares out: its stress times its volume, xx, yy, zz, xy (N m), and its volume (m3).
const SHARED: usize = 5;
/// Where the volume stands among these.
const VOLUME: usize = 4;
/// Numbers of [`Strip::shared`] that a cell has.
pub const fn shared(dimensions: usize) -> usize {
    around(dimensions) * SHARED
}

/// What cells share of the boxes. Cells have the numbers of a frame.
#[derive(Debug, Clone)]
pub struct Domains<const D: usize> {
    frame: Frame<D>,
    /// Strain rates at the centres of cells, 1/s, each from [`Domains::front`] on.
    rates: [Vec<f64>; RATES],
    /// 1 for cells with soil, else 0, from there on.
    holds: Vec<f64>,
    /// Stress times volume (xx, yy, zz, xy, N m) and volume (m3) of boxes in cells, and those of particles with their middle in them.
    boxes: Vec<[f64; SHARED]>,
    middles: Vec<[f64; SHARED]>,
}

/// Strain rates of some cells side by side and of those around them, 1/s.
pub struct Around<V: Simd, const D: usize> {
    rates: [[SimdReal<V>; RATES]; AROUND],
    size: f64,
}

impl<const D: usize> Domains<D> {
    /// The arrays of a mesh.
    pub fn new(frame: Frame<D>) -> Self {
        let cells =
            |wanted: bool| vec![0.0; if wanted { frame.length() + 2 * Self::front(&frame) + MAX_LANES } else { 0 }];
        let of_cells = vec![[0.0; SHARED]; frame.length()];
        Self {
            rates: std::array::from_fn(|k| cells(k < D * D || (k == D * D && frame.axis.is_some()))),
            holds: cells(true),
            boxes: of_cells.clone(),
            middles: of_cells,
            frame,
        }
    }

    /// Numbers before the first cell: every cell has some around it.
    fn front(frame: &Frame<D>) -> usize {
        1 + frame.stride[D - 1]
    }

    /// From a cell to the one that is so far from it along each axis, counted from the lower corner of those around it.
    fn offset(frame: &Frame<D>, k: usize) -> usize {
        k % 3 + if D == 1 { frame.stride[0] } else { k / 3 * frame.stride[D - 1] }
    }

    /// Finds the strain rates of the cells.
    pub fn find_rates(&mut self, strips: &[Strip<D>], motion: &Motion) {
        let (frame, front, corners) = (self.frame, Self::front(&self.frame), 1 << D);
        for cell in 0..frame.count() {
            let holds = strips[cell / frame.strip].solid.count(cell % frame.strip) > 0;
            self.holds[front + cell] = f64::from(u8::from(holds));
            if !holds {
                continue;
            }
            for i in 0..D {
                let (mut rates, mut sum) = ([0.0; D], 0.0);
                for a in 0..corners {
                    let v = motion.velocity[i][cell + frame.offset_of_corner(a)];
                    sum += v;
                    for j in 0..D {
                        rates[j] += v * slope_of_corner::<D>(a, j);
                    }
                }
                for j in 0..D {
                    self.rates[i * D + j][front + cell] = rates[j] * frame.inverse_size;
                }
                if i == 0 && frame.axis.is_some() {
                    self.rates[D * D][front + cell] = sum / corners as f64 / frame.thickness(1, cell);
                }
            }
        }
    }

    /// Those of some cells from one on, and of the cells around them; cells without soil have those of the cell beside.
    #[inline(always)]
    pub fn around<V: Simd>(&self, simd: V, at: usize) -> Around<V, D> {
        let none = SimdReal::splat(simd, 0.0);
        let mut rates = [[none; RATES]; AROUND];
        let own = at + Self::front(&self.frame);
        for k in 0..around(D) {
            let there = at + Self::offset(&self.frame, k);
            let holds = none.below(SimdReal::load(simd, &self.holds[there..]));
            for c in 0..RATES {
                if !self.rates[c].is_empty() {
                    let middle = SimdReal::load(simd, &self.rates[c][own..]);
                    rates[k][c] = SimdReal::load(simd, &self.rates[c][there..]).or(holds, middle);
                }
            }
        }
        Around { rates, size: 1.0 / self.frame.inverse_size }
    }

    /// Adds to the forces on the nodes (N) what boxes give to other cells than that of their middle; `known` is the volume of soil
    /// in the cells where that is known (m3), and `pressed` the pressure (Pa) that pushes in a cell. Forces of unit pressures become those of the volume of boxes.
    pub fn share_stresses(
        &mut self,
        strips: &mut [Strip<D>],
        nodes: &mut Nodes<D>,
        known: &[f64],
        pressed: impl Fn(usize) -> f64,
    ) {
        let (frame, front) = (self.frame, Self::front(&self.frame));
        self.boxes.fill([0.0; SHARED]);
        self.middles.fill([0.0; SHARED]);
        for cell in 0..frame.count() {
            let solid = &strips[cell / frame.strip].solid;
            self.holds[front + cell] = f64::from(u8::from(solid.count(cell % frame.strip) > 0));
        }
        for cell in (0..frame.count()).filter(|cell| self.holds[front + cell] > 0.0) {
            let (shared, inside) = (&strips[cell / frame.strip].shared, cell % frame.strip);
            for k in 0..around(D) {
                let there = cell + Self::offset(&frame, k);
                let to = if self.holds[there] > 0.0 { there - front } else { cell };
                for s in 0..SHARED {
                    let share = shared[(k * SHARED + s) * frame.strip + inside];
                    self.boxes[to][s] += share;
                    self.middles[cell][s] += share;
                }
            }
        }
        for cell in 0..frame.count() {
            let (boxes, middles) = (&self.boxes[cell], &self.middles[cell]);
            if middles[VOLUME] == 0.0 {
                continue;
            }
            // Where the volume of soil is known, the means act in that; else the sums do.
            let is_known = known[cell] > 0.0;
            let (mut of_boxes, mut of_middles) = (1.0, 1.0);
            if is_known {
                (of_boxes, of_middles) = (known[cell] / boxes[VOLUME], known[cell] / middles[VOLUME]);
            }
            let mut more = array!([0.0; 4], s => of_boxes * boxes[s] - of_middles * middles[s]);
            if !is_known {
                let pressed = pressed(cell) * (boxes[VOLUME] - middles[VOLUME]);
                (0..3).for_each(|s| more[s] -= pressed);
                let (strip, inside) = (&mut strips[cell / frame.strip], cell % frame.strip);
                let of_cell = strip.coupling.len() / frame.strip;
                for push in &mut strip.coupling[inside * of_cell..][..of_cell] {
                    *push *= boxes[VOLUME] / middles[VOLUME];
                }
            }
            push(&frame, nodes, cell, &more);
        }
    }

    /// Volume of the boxes in a cell, of those with a middle in it, m3.
    pub fn volume(&self, cell: usize) -> f64 {
        self.boxes[cell][VOLUME]
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let arrays: usize = self.rates.iter().chain([&self.holds]).map(Vec::capacity).sum();
        (arrays + SHARED * (self.boxes.capacity() + self.middles.capacity())) * size_of::<f64>()
    }
}

impl<V: Simd, const D: usize> Around<V, D> {
    /// A step dt (s) of boxes at a place in their cells: their velocity gradient and hoop strain rate (1/s), velocity (m/s) and size (m),
    /// given those of a point there.
    #[inline(always)]
    pub fn stretch(
        &self,
        xi: &[SimdReal<V>; D],
        size: &mut [SimdReal<V>; D],
        Moves { gradient, velocity, .. }: &mut Moves<V, D>,
        hoop: &mut Option<SimdReal<V>>,
        dt: f64,
    ) {
        let one = xi[0].like(1.0);
        let shares = array!([[one; 3]; D], d => shares(xi[d], size[d] * (1.0 / self.size)));
        let (own, rows) = (if D == 1 { 1 } else { 4 }, if D == 1 { 1 } else { 3 });
        for j in 0..rows {
            for i in 0..3 {
                let k = 3 * j + i;
                if k == own {
                    continue;
                }
                let share = if D == 1 { shares[0][i] } else { shares[0][i] * shares[D - 1][j] };
                for c in 0..D * D {
                    gradient[c / D][c % D] += share * (self.rates[k][c] - self.rates[own][c]);
                }
                if let Some(hoop) = hoop {
                    *hoop += share * (self.rates[k][D * D] - self.rates[own][D * D]);
                }
            }
        }
        for d in 0..D {
            // The mean velocity of the two ends, where the cells beside are strained otherwise.
            let along = d * D + d;
            let stride = if d == 0 { 1 } else { 3 };
            let lower = self.rates[own - stride][along] - self.rates[own][along];
            let upper = self.rates[own + stride][along] - self.rates[own][along];
            velocity[d] += (shares[d][2] * upper - shares[d][0] * lower) * size[d] * 0.5;
            size[d] = (size[d] * (one + gradient[d][d] * dt)).lesser(one * self.size);
        }
    }
}

/// What the boxes of some cells side by side give to these and to those around them.
pub struct Shared<V: Simd, const D: usize> {
    sums: [[SimdReal<V>; SHARED]; AROUND],
}

impl<V: Simd, const D: usize> Shared<V, D> {
    /// Nothing.
    #[inline(always)]
    pub fn nothing(simd: V) -> Self {
        Self { sums: [[SimdReal::splat(simd, 0.0); SHARED]; AROUND] }
    }

    /// Adds boxes at a place in their cells, of a size (in cells), volume (m3) and stress (Pa).
    #[inline(always)]
    pub fn add(
        &mut self,
        xi: &[SimdReal<V>; D],
        size: &[SimdReal<V>; D],
        volume: SimdReal<V>,
        stress: &[SimdReal<V>; 4],
    ) {
        let shares = array!([[volume; 3]; D], d => shares(xi[d], size[d]));
        let work = array!([volume; 4], s => volume * stress[s]);
        for k in 0..around(D) {
            let share = if D == 1 { shares[0][k] } else { shares[0][k % 3] * shares[D - 1][k / 3] };
            for s in 0..4 {
                self.sums[k][s] += share * work[s];
            }
            self.sums[k][VOLUME] += share * volume;
        }
    }

    /// Writes them to those of a strip of so many cells, from one of these on.
    #[inline(always)]
    pub fn store(&self, of_strip: &mut [f64], cells: usize, at: usize) {
        for k in 0..around(D) {
            for s in 0..SHARED {
                self.sums[k][s].store(&mut of_strip[(k * SHARED + s) * cells + at..]);
            }
        }
    }
}

/// Shares of boxes at a place in their cell, of a size (in cells, at most one), in the cell below, their own, and the one above.
#[inline(always)]
fn shares<V: Simd>(xi: SimdReal<V>, size: SimdReal<V>) -> [SimdReal<V>; 3] {
    let (none, one) = (xi.like(0.0), xi.like(1.0));
    // A lane without a particle has no size.
    let (half, per) = (size * 0.5, one / size.or_one());
    let (below, above) = ((half - xi).larger(none) * per, (half + xi - one).larger(none) * per);
    [below, one - below - above, above]
}

/// Slope of the function of a corner along an axis at the centre of a cell, per cell.
fn slope_of_corner<const D: usize>(corner: usize, axis: usize) -> f64 {
    let sign = if (corner >> axis) & 1 == 1 { 1.0 } else { -1.0 };
    sign / f64::from(1_u32 << (D - 1))
}

/// The force of a stress times volume xx, yy, zz, xy (N m) in a cell, as at its centre: `f_i = - V sigma G_i`.
fn push<const D: usize>(frame: &Frame<D>, nodes: &mut Nodes<D>, cell: usize, stress: &[f64; 4]) {
    let corners = 1 << D;
    for a in 0..corners {
        let node = cell + frame.offset_of_corner(a);
        for i in 0..D {
            let mut acting = 0.0;
            for j in 0..D {
                let component = if D == 1 || (i, j) == (1, 1) { 1 } else { [0, 3][i.max(j)] };
                acting += stress[component] * slope_of_corner::<D>(a, j) * frame.inverse_size;
            }
            if frame.axis.is_some() && i == 0 {
                acting += stress[2] / frame.thickness(1, cell) / corners as f64;
            }
            nodes.push(node, i, -acting);
        }
    }
}

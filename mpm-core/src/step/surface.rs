//! Where the particles below the surface are among the blocks, and where they will be at the end of a step.

use pulp::{Scalar, Simd};

use super::domains::Domains;
use super::kernel::{Fields, Functions, rate_of_volume};
use super::store::{Frame, Motion, Nodes, Strip};
use crate::boundary::{FaceLoads, Filled, SurfaceLoad};
use crate::grid::Grid;
use crate::particles::{Point, SolidPoint};
use crate::real::{SimdReal, array};

/// Particles behind the strips of a surface.
#[derive(Debug, Clone)]
pub struct Tops<const D: usize> {
    /// Their numbers, ascending; one may be there more than once.
    ids: Vec<u32>,
    /// Strip of cells, cell in it and place in that of each.
    places: Vec<[u32; 3]>,
    /// Position (m) and volume (m3) at the end of the step.
    ahead: Vec<([f64; D], f64)>,
}

impl<const D: usize> Tops<D> {
    /// Those with these numbers, ascending.
    pub fn new(ids: Vec<u32>) -> Self {
        Self { places: vec![[0; 3]; ids.len()], ahead: vec![([0.0; D], 0.0); ids.len()], ids }
    }

    /// Position (m) and volume (m3) of one.
    #[inline]
    pub fn carrier<V: Simd>(&self, strips: &[Strip<V, D>], top: usize) -> ([f64; D], f64) {
        let [strip, cell, slot] = self.places[top];
        let (solid, cell, slot) = (&strips[strip as usize].solid, cell as usize, slot as usize);
        let x = array!([0.0; D], d => solid.number(cell, slot, d));
        (x, solid.number(cell, slot, SolidPoint::<D>::VOLUME))
    }

    /// One of the numbers of one.
    fn number<V: Simd>(&self, strips: &[Strip<V, D>], top: usize, which: usize) -> f64 {
        let [strip, cell, slot] = self.places[top];
        strips[strip as usize].solid.number(cell as usize, slot as usize, which)
    }

    /// The same at the end of the step.
    pub fn ahead(&self, top: usize) -> ([f64; D], f64) {
        self.ahead[top]
    }

    /// Notes where the particles behind the surface are, of those in a cell.
    pub fn follow<V: Simd>(&mut self, strips: &[Strip<V, D>], frame: &Frame<D>, cell: usize) {
        let (strip, inside) = (cell / frame.strip, cell % frame.strip);
        let solid = &strips[strip].solid;
        for slot in 0..solid.count(inside) {
            let id = solid.id(inside, slot);
            let first = self.ids.partition_point(|other| *other < id);
            for (place, _) in self.places[first..].iter_mut().zip(&self.ids[first..]).take_while(|(_, i)| **i == id) {
                *place = [strip, inside, slot].map(|i| i as u32);
            }
        }
    }

    /// Finds where they will be, as the kernel moves and strains them: by velocities that are `mapped` back, if there are.
    pub fn look_ahead<V: Simd, F: Functions<D>>(
        &mut self,
        functions: &F,
        strips: &[Strip<V, D>],
        (nodes, mapped, boxes): (&Nodes<D>, Option<&Nodes<D>>, Option<(&Domains<D>, usize)>),
        dt: f64,
    ) {
        let Nodes { frame, motion: Motion { velocity, change, .. }, .. } = nodes;
        let mapped = mapped.map(|mapped| &mapped.motion.velocity);
        for top in 0..self.places.len() {
            let (strip, cell) = (self.places[top][0] as usize, self.places[top][1] as usize);
            let (mut x, mut volume) = self.carrier(strips, top);
            let at = strips[strip].first + cell;
            let found = frame.finds_centroids(F::SPLIT);
            let fields = Fields { simd: Scalar, velocity, change, mapped, frame, at, found };
            let lone = |number: f64| SimdReal::splat(Scalar, number);
            let position = frame.position(at);
            let position = array!([lone(0.0); D], d => lone(position[d] as f64));
            let edges = functions.edges(&position, &frame.cells);
            let centroid = strips[strip].centroid(cell);
            let centroid = array!([lone(0.0); D], d => lone(centroid[d]));
            let mut motion = functions.at_rest(Scalar);
            functions.find_motion(&mut motion, &fields, &edges, &centroid);
            let xi = array!([lone(0.0); D], d => lone(x[d] * frame.inverse_size) - position[d]);
            let mut moves = functions.moves(&motion, &edges, &xi, frame.inverse_size);
            let from_axis = frame.axis_in_cells.map(|axis| position[0] + lone(axis));
            let mut hoop = from_axis.map(|from| functions.hoop(&motion, &edges, &xi, from, frame.inverse_size));
            let of_point = rate_of_volume(&moves.gradient, hoop);
            if let Some((domains, first)) = boxes {
                let mut size = array!([lone(0.0); D], d => lone(self.number(strips, top, first + d)));
                domains.around(Scalar, at).stretch(&xi, &mut size, &mut moves, &mut hoop, dt);
            }
            let mut rate = rate_of_volume(&moves.gradient, hoop);
            if F::SPLIT {
                let middle = functions.middle(&motion, from_axis, frame.inverse_size);
                rate = if boxes.is_some() { middle + (rate - of_point) } else { middle };
            }
            volume *= 1.0 + dt * rate.lane(0);
            for d in 0..D {
                x[d] += dt * moves.velocity[d].lane(0);
            }
            self.ahead[top] = (x, volume);
        }
    }

    /// Visits the functions that a pressure (Pa, upwards) on the surface pushes, with the force, N.
    pub fn each_push<V: Simd, F: Functions<D>>(
        &self,
        functions: &F,
        (surface, grid, pressure): (&SurfaceLoad<D>, &Grid<D>, f64),
        strips: &[Strip<V, D>],
        frame: &Frame<D>,
        mut give: impl FnMut(usize, f64),
    ) {
        for top in 0..self.places.len() {
            let (position, xi) = surface.place(top, grid, self.carrier(strips, top));
            let forces = functions.at_surface(&position, &frame.cells, &xi, pressure * surface.strips()[top].loaded);
            let first = frame.number(&position);
            for row in 0..if D == 1 { 1 } else { F::REACH } {
                for i in 0..F::REACH {
                    give(first + i + row * frame.stride[D - 1], forces[row * F::REACH + i]);
                }
            }
        }
    }

    /// Volumes of soil by the numbers of the frame: of all cells, or of those that hold the surface.
    pub fn note_soil(filled: &Filled<D>, frame: &Frame<D>, soil: &mut [f64], all: bool) {
        let row = if D == 1 { 1 } else { frame.cells[0] };
        let number = |cell: usize| cell / row * frame.stride[D - 1] + cell % row;
        if all {
            for (cell, volume) in filled.volumes().iter().enumerate() {
                soil[number(cell)] = *volume;
            }
        } else {
            for top in filled.tops() {
                soil[number(top.cell as usize)] = filled.volumes()[top.cell as usize];
            }
        }
    }

    /// The same of loads on faces at a time, s: function, axis and force, N.
    pub fn each_force<V: Simd, F: Functions<D>>(
        &self,
        functions: &F,
        (loads, grid, time): (&FaceLoads<D>, &Grid<D>, f64),
        strips: &[Strip<V, D>],
        frame: &Frame<D>,
        mut give: impl FnMut(usize, usize, f64),
    ) {
        for (top, piece) in loads.pieces.iter().enumerate() {
            let (place, volume) = self.carrier(strips, top);
            let (position, xi) = piece.place(grid, (place, volume));
            let factor = loads.factor(piece, &place, time);
            let shares = functions.at_surface(&position, &frame.cells, &xi, factor);
            let first = frame.number(&position);
            for row in 0..if D == 1 { 1 } else { F::REACH } {
                for i in 0..F::REACH {
                    for d in 0..D {
                        give(first + i + row * frame.stride[D - 1], d, shares[row * F::REACH + i] * piece.force[d]);
                    }
                }
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.places.capacity() * size_of::<[u32; 3]>() + self.ahead.capacity() * size_of::<([f64; D], f64)>()
    }
}

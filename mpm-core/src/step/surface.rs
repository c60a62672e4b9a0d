//! Where the particles below the surface are among the blocks, and where they will be at the end of a step.

use super::domains::Domains;
use super::kernel::{Kernel, Traveller};
use super::store::{Frame, Nodes, Strip};
use crate::boundary::{FaceLoads, Filled, SurfaceLoad};
use crate::grid::Grid;
use crate::particles::{Point, SolidPoint};
use crate::real::array;

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
    pub fn carrier(&self, strips: &[Strip<D>], top: usize) -> ([f64; D], f64) {
        let [strip, cell, slot] = self.places[top];
        let (solid, cell, slot) = (&strips[strip as usize].solid, cell as usize, slot as usize);
        let x = array!([0.0; D], d => solid.number(cell, slot, d));
        (x, solid.number(cell, slot, SolidPoint::<D>::VOLUME))
    }

    /// One of the numbers of one.
    fn number(&self, strips: &[Strip<D>], top: usize, which: usize) -> f64 {
        let [strip, cell, slot] = self.places[top];
        strips[strip as usize].solid.number(cell as usize, slot as usize, which)
    }

    /// The same at the end of the step.
    pub fn ahead(&self, top: usize) -> ([f64; D], f64) {
        self.ahead[top]
    }

    /// Notes where the particles behind the surface are, of those in a cell.
    pub fn follow(&mut self, strips: &[Strip<D>], frame: &Frame<D>, cell: usize) {
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
    pub fn look_ahead(
        &mut self,
        kernel: &dyn Kernel<D>,
        strips: &[Strip<D>],
        (nodes, mapped, boxes): (&Nodes<D>, Option<&Nodes<D>>, Option<(&Domains<D>, usize)>),
        dt: f64,
    ) {
        for top in 0..self.places.len() {
            let [strip, inside, _] = self.places[top].map(|place| place as usize);
            let (x, volume) = self.carrier(strips, top);
            let size = |(domains, first)| (array!([0.0; D], d => self.number(strips, top, first + d)), domains);
            let (cell, centroid) = (strips[strip].first + inside, strips[strip].centroid(inside));
            let extent = boxes.map(size);
            self.ahead[top] = kernel.ahead(&Traveller { x, volume, extent, cell, centroid, nodes, mapped }, dt);
        }
    }

    /// Visits the functions that a pressure (Pa, upwards) on the surface pushes, with the force, N.
    pub fn each_push(
        &self,
        kernel: &dyn Kernel<D>,
        (surface, grid, pressure): (&SurfaceLoad<D>, &Grid<D>, f64),
        strips: &[Strip<D>],
        frame: &Frame<D>,
        mut give: impl FnMut(usize, f64),
    ) {
        for top in 0..self.places.len() {
            let (position, xi) = surface.place(top, grid, self.carrier(strips, top));
            let forces = kernel.at_surface(&position, &frame.cells, &xi, pressure * surface.strips()[top].loaded);
            let first = frame.number(&position);
            for row in 0..if D == 1 { 1 } else { frame.reach } {
                for i in 0..frame.reach {
                    give(first + i + row * frame.stride[D - 1], forces[row * frame.reach + i]);
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
    pub fn each_force(
        &self,
        kernel: &dyn Kernel<D>,
        (loads, grid, time): (&FaceLoads<D>, &Grid<D>, f64),
        strips: &[Strip<D>],
        frame: &Frame<D>,
        mut give: impl FnMut(usize, usize, f64),
    ) {
        for (top, piece) in loads.pieces.iter().enumerate() {
            let (place, volume) = self.carrier(strips, top);
            let (position, xi) = piece.place(grid, (place, volume));
            let factor = loads.factor(piece, &place, time);
            let shares = kernel.at_surface(&position, &frame.cells, &xi, factor);
            let first = frame.number(&position);
            for row in 0..if D == 1 { 1 } else { frame.reach } {
                for i in 0..frame.reach {
                    for d in 0..D {
                        give(first + i + row * frame.stride[D - 1], d, shares[row * frame.reach + i] * piece.force[d]);
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

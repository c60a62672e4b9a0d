//! The surcharge on the top of the column, and the settlement of that top.
//!
//! Each particle of the top row carries a strip of the surface. The surface lies above the particle by its first
//! distance times the stretch of the particle, V/V_0: that is the settlement "extrapolated from the particles below".

use crate::grid::Grid;
use crate::particles::{Layer, SolidPoint};
use crate::scene::LoadOn;

/// A strip of the surface above one particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strip {
    /// Particle below it, by the number it was seeded with.
    pub id: u32,
    /// Distance from the particle up to the surface at t = 0, m.
    pub offset: f64,
    /// Volume of the particle at t = 0, m3.
    pub volume: f64,
    /// Area of the strip, m2.
    pub area: f64,
    /// The part of it that carries the load, m2.
    pub loaded: f64,
}

/// The top surface and the load on it.
#[derive(Debug, Clone)]
pub struct SurfaceLoad<const D: usize> {
    strips: Vec<Strip>,
    /// Where the particle of each strip stands in the layer now.
    index: Vec<u32>,
    order: u64,
    height: f64,
    on: LoadOn,
}

impl<const D: usize> SurfaceLoad<D> {
    /// A surface at `height` (m) above the strips' particles.
    pub fn new(strips: Vec<Strip>, height: f64, on: LoadOn) -> Self {
        Self { index: vec![0; strips.len()], strips, order: 0, height, on }
    }

    /// Finds the particles again after their order has changed.
    pub fn follow(&mut self, solid: &Layer<SolidPoint<D>, D>) {
        if self.order == solid.order {
            return;
        }
        self.order = solid.order;
        for (index, &id) in solid.ids.iter().enumerate() {
            if let Ok(strip) = self.strips.binary_search_by_key(&id, |s| s.id) {
                self.index[strip] = index as u32;
            }
        }
    }

    /// The same for particles that have been restored from a checkpoint.
    pub fn find(&mut self, solid: &Layer<SolidPoint<D>, D>) {
        self.order = u64::MAX;
        self.follow(solid);
    }

    /// The particle of each strip, by its place in the layer when [`Self::follow`] last saw it.
    #[inline(always)]
    pub(super) fn carrier<'a>(&'a self, solid: &'a Layer<SolidPoint<D>, D>) -> impl Fn(usize) -> ([f64; D], f64) + 'a {
        |strip| {
            let point = &solid.points[self.index[strip] as usize];
            (point.x, point.volume)
        }
    }

    /// Strips by the number of the particle below them, in ascending order.
    pub fn strips(&self) -> &[Strip] {
        &self.strips
    }

    /// Where the load of a strip acts: place of the cell, cell coordinates of the point. The particle below it stands
    /// at `x` (m) and has a volume (m3).
    ///
    /// The cell is that of the particle, so that no force lands on nodes without mass.
    #[inline(always)]
    pub(crate) fn place(&self, strip: usize, grid: &Grid<D>, (x, volume): ([f64; D], f64)) -> ([usize; D], [f64; D]) {
        let mut position = [0; D];
        let mut xi = [0.0; D];
        for d in 0..D {
            let scaled = x[d] * grid.inverse_size;
            position[d] = (scaled.max(0.0) as usize).min(grid.cells[d] - 1);
            xi[d] = scaled - position[d] as f64;
        }
        match self.on {
            LoadOn::Particles => {}
            LoadOn::Surface => {
                let s = &self.strips[strip];
                xi[D - 1] += s.offset * (volume / s.volume) * grid.inverse_size;
            }
            // The plate is the top row of nodes.
            LoadOn::Plate => (position[D - 1], xi[D - 1]) = (grid.cells[D - 1] - 1, 1.0),
        }
        (position, xi)
    }

    /// Area that carries the load, m2.
    pub fn loaded_area(&self) -> f64 {
        self.strips.iter().map(|s| s.loaded).sum()
    }

    /// How far the surface has come down since t = 0, m.
    pub fn settlement(&self, solid: &Layer<SolidPoint<D>, D>) -> f64 {
        if self.strips.is_empty() {
            return 0.0; // no surface is followed
        }
        let mut sum = 0.0;
        for (strip, &index) in self.strips.iter().zip(&self.index) {
            let point = &solid.points[index as usize];
            let surface = point.x[D - 1] + strip.offset * point.volume / strip.volume;
            sum += (self.height - surface) * strip.area;
        }
        sum / self.strips.iter().map(|s| s.area).sum::<f64>()
    }
}

//! The surcharge on the top of the column, and the settlement of that top.
//!
//! Each particle of the top row carries a strip of the surface. The surface lies above the particle by its first
//! distance times the stretch of the particle, V/V_0: that is the settlement "extrapolated from the particles below".

use crate::dimension::{basis, coefficients, shares, value};
use crate::grid::Grid;
use crate::nodes::{NodeMotion, NodeSums};
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
    pub fn follow<const S: usize>(&mut self, solid: &Layer<SolidPoint<D, S>, D>) {
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

    /// The same for particles that have been read from a kept state.
    pub fn find<const S: usize>(&mut self, solid: &Layer<SolidPoint<D, S>, D>) {
        self.order = u64::MAX;
        self.follow(solid);
    }

    /// The particle of each strip, by its place in the layer when [`Self::follow`] last saw it.
    #[inline(always)]
    pub(super) fn carrier<'a, const S: usize>(
        &'a self,
        solid: &'a Layer<SolidPoint<D, S>, D>,
    ) -> impl Fn(usize) -> ([f64; D], f64) + 'a {
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

    /// Where the loads act: place of the cell, cell coordinates, loaded area (m2).
    #[inline(always)]
    pub fn places<'a, const S: usize>(
        &'a self,
        grid: &'a Grid<D>,
        solid: &'a Layer<SolidPoint<D, S>, D>,
    ) -> impl Iterator<Item = ([usize; D], [f64; D], f64)> {
        let carrier = self.carrier(solid);
        (0..self.strips.len()).map(move |strip| {
            let (position, xi) = self.place(strip, grid, carrier(strip));
            (position, xi, self.strips[strip].loaded)
        })
    }

    /// Adds a pressure (Pa, downwards) to the nodal forces.
    #[inline(always)]
    pub fn apply<const S: usize>(
        &self,
        pressure: f64,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D, S>, D>,
        nodes: &mut [NodeSums<D>],
    ) {
        self.push(pressure, grid, self.carrier(solid), |node, force| nodes[node].force[D - 1] += force);
    }

    /// Gives the nodes their vertical forces (N) under a pressure (Pa, downwards); `carrier` knows position (m) and volume
    /// (m3) of the particle below a strip.
    #[inline(always)]
    pub fn push(
        &self,
        pressure: f64,
        grid: &Grid<D>,
        carrier: impl Fn(usize) -> ([f64; D], f64),
        mut give: impl FnMut(usize, f64),
    ) {
        for strip in 0..self.strips.len() {
            self.push_one(strip, pressure, grid, carrier(strip), &mut give);
        }
    }

    /// [`Self::push`] of one strip.
    #[inline(always)]
    pub fn push_one(
        &self,
        strip: usize,
        pressure: f64,
        grid: &Grid<D>,
        carrier: ([f64; D], f64),
        mut give: impl FnMut(usize, f64),
    ) {
        let (position, xi) = self.place(strip, grid, carrier);
        let corners = grid.corners(&position);
        let force = -pressure * self.strips[strip].loaded;
        let share = shares(force, &xi);
        for a in 0..Grid::<D>::CORNERS {
            give(corners[a], share[a]);
        }
    }

    /// Power of a pressure (Pa) on the surface at the middle of the step, W.
    #[inline(always)]
    pub fn power<const S: usize>(
        &self,
        pressure: f64,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D, S>, D>,
        motion: &[NodeMotion<D>],
        dt: f64,
    ) -> f64 {
        let moving = |node: usize| motion[node].velocity[D - 1] - 0.5 * dt * motion[node].acceleration[D - 1];
        self.power_at(pressure, grid, self.carrier(solid), moving)
    }

    /// Power (W) of a pressure (Pa) on a surface whose nodes move at a vertical velocity (m/s); `carrier` as in
    /// [`Self::push`].
    #[inline(always)]
    pub fn power_at(
        &self,
        pressure: f64,
        grid: &Grid<D>,
        carrier: impl Fn(usize) -> ([f64; D], f64),
        moving: impl Fn(usize) -> f64,
    ) -> f64 {
        let mut power = 0.0;
        for strip in 0..self.strips.len() {
            let (position, xi) = self.place(strip, grid, carrier(strip));
            let corners = grid.corners(&position);
            let mut nodal = [[0.0]; 4];
            for a in 0..Grid::<D>::CORNERS {
                nodal[a][0] = moving(corners[a]);
            }
            let velocity = value::<D, 1, _>(&coefficients::<D, 1, _>(&nodal), &basis(&xi))[0];
            power -= pressure * self.strips[strip].loaded * velocity;
        }
        power
    }

    /// Area that carries the load, m2.
    pub fn loaded_area(&self) -> f64 {
        self.strips.iter().map(|s| s.loaded).sum()
    }

    /// How far the surface has come down since t = 0, m.
    pub fn settlement<const S: usize>(&self, solid: &Layer<SolidPoint<D, S>, D>) -> f64 {
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

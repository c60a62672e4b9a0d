//! The soil of a run, as conditions see it.

use super::*;
use crate::real::array_of;

/// The soil of a run, as conditions see it.
pub(super) struct Grains<'a, const D: usize> {
    pub(super) kernel: &'a dyn Kernel<D>,
    pub(super) scheme: &'a Scheme,
    pub(super) body: &'a Body<D>,
    pub(super) water: Option<&'a AdvectedWater<D>>,
    pub(super) strips: &'a [Strip<D>],
    pub(super) frame: Frame<D>,
    /// Pore pressure of the cells, Pa, from [`Frame::pad`] on.
    pub(super) pressure: &'a [f64],
    pub(super) time: f64,
}

impl<const D: usize> Soil<D> for Grains<'_, D> {
    fn time(&self) -> f64 {
        self.time
    }

    fn mesh(&self) -> ([usize; D], f64) {
        (self.body.grid.cells, self.body.grid.size)
    }

    fn each_in(&self, cell: usize, visit: &mut dyn FnMut(u32, &SolidPoint<D>)) {
        let number = self.frame.number(&self.body.grid.cell_position(cell));
        let (strip, cell) = (&self.strips[number / self.frame.strip], number % self.frame.strip);
        for slot in 0..strip.solid.count(cell) {
            visit(strip.solid.id(cell, slot), &strip.solid.particle(cell, slot));
        }
    }

    fn each_cell(&self, visit: &mut dyn FnMut(f64, &mut dyn Iterator<Item = usize>)) {
        if !self.scheme.on_cell {
            // A particle need not reach all functions of its cell.
            let touched = |(_, share): &&(usize, f64)| *share > 0.0;
            return self.each_share(&mut |point, shares| {
                visit(point.mass, &mut shares.iter().filter(touched).map(|(function, _)| *function));
            });
        }
        let reached = self.scheme.reach.pow(D as u32);
        for strip in self.strips {
            for cell in 0..self.frame.strip {
                let [_, mass] = strip.volume_and_mass(cell);
                if mass > 0.0 {
                    visit(mass, &mut (0..reached).map(|a| strip.first + cell + self.frame.offset(a)));
                }
            }
        }
    }

    /// From the mean over the cell down to the base: under water that fills it, or stands in it up to a level.
    fn on_base(&self, cell: usize) -> (f64, Option<f64>) {
        if let Some((pressure, cover)) = self.water.map(|water| water.on_base(cell)) {
            return (pressure, Some(cover));
        }
        let density = self.body.water.as_ref().map_or(0.0, |water| water.flow.density);
        let rise = self.body.grid.size * density * self.body.gravity.map_or(0.0, |g| -g[D - 1]);
        let mean = self.pressure[self.frame.pad() + self.frame.number(&self.body.grid.cell_position(cell))];
        (if mean >= 0.5 * rise { mean + 0.5 * rise } else { (2.0 * rise * mean.max(0.0)).sqrt() }, None)
    }

    fn each_share(&self, visit: &mut Visit<D>) {
        let reached = self.scheme.reach.pow(D as u32);
        let mut shares = [(0, 0.0); MOST_REACHED];
        for strip in self.strips {
            for cell in 0..self.frame.strip {
                let position = self.frame.position(strip.first + cell);
                for slot in 0..strip.solid.count(cell) {
                    let point: SolidPoint<D> = strip.solid.particle(cell, slot);
                    let xi = array_of(|d| point.x[d] * self.frame.inverse_size - position[d] as f64);
                    let values = self.kernel.values(&position, &self.frame.cells, &xi);
                    for (a, value) in values.into_iter().enumerate().take(reached) {
                        shares[a] = (strip.first + cell + self.frame.offset(a), value);
                    }
                    visit(&point, &shares[..reached]);
                }
            }
        }
    }
}

//! How much of each cell is soil, from where the surface is: the particles of a cell share that volume as weights.
//!
//! The force of a cell on its nodes is the integral of a stress over its soil. With the particles' own volumes the sum over a
//! cell is that integral only while they stand as they were seeded: particles that are compressed leave a gap in a cell that
//! is full of soil, and a cell that holds three rows of particles beside one that holds one is integrated over three times as
//! much soil, though both are full. The stress is off by as much in the opposite direction, by the strain before particles
//! cross and by tens of percent after. So the particles' volumes say how stress is weighted inside a cell, and the
//! geometry how much soil there is: a cell below the surface is full, and one that holds the surface is filled up to it
//! (mixed integration, Al-Kafaji 2013, *Formulation of a dynamic material point method*, section 4.2; here also for partly
//! filled cells).

use serde::{Deserialize, Serialize};

use super::SurfaceLoad;
use crate::checkpoint::{Archive, RestoreError, archive};
use crate::grid::Grid;
use crate::particles::{Layer, SolidPoint};
use crate::scene::{DarcyChoice, Fields, LoadOn, Quadrature, Scene, Side, SolidSide};

/// Volume of soil per cell where the outline of the soil is known: a box between rollers under a level or bent surface.
#[derive(Debug, Clone, Default)]
pub struct Filled<const D: usize> {
    /// Soil in each cell, m3; empty where the outline is not known.
    volumes: Vec<f64>,
    /// Volume of a cell full of soil in each column of cells, m3.
    full: Vec<f64>,
    /// The highest cell with soil above each cell of the lowest row.
    tops: Vec<Top>,
    /// Whether the surface is fixed where it was, so that the cells below it are full: under a plate, or a constrained top.
    held: bool,
    /// Whether the surface alone says how much soil there is: it is level and free.
    level: bool,
}

/// Round-off of a sum over the particles of a cell.
pub(crate) const ROUND_OFF: f64 = 1e-14;

/// Whether the volume of soil in each cell of a scene follows from where its surface is: a box of soil between supported sides, and
/// functions that reach no further than their cell.
pub fn knows_volumes(scene: &Fields) -> bool {
    let free = |side: Side| scene.supports().any(|sides| sides[side as usize] == SolidSide::Free);
    // A top that is released or fixed on the way is no surface that stays what it is.
    let top = scene.solid_sides[Side::Top as usize];
    let in_a_box = scene.outline.is_none() && scene.empty_cells_beside == 0 && !scene.periodic;
    let held = ![Side::Left, Side::Right, Side::Bottom].into_iter().any(free) && scene.base.is_none();
    let of_one_cell = !scene.shape.is_wide();
    // The nodal flow takes every cell for full of soil.
    let by_faces = scene.water.is_none() || scene.darcy == DarcyChoice::Face;
    in_a_box
        && held
        && scene.always(Side::Top, top)
        && of_one_cell
        && by_faces
        && scene.quadrature == Quadrature::Fitted
        && scene.free_surface.is_none()
}

/// The cell that holds the surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Top {
    /// Its number.
    pub cell: u32,
    /// The part of it that is soil; above 1 where the surface has left it but no particle has.
    pub fill: f64,
}

impl<const D: usize> Filled<D> {
    /// That of a scene whose cells have a `full` volume (m3), where they are 1 m thick; nothing is known of soil with an outline, with empty cells beside it,
    /// between free sides, or on a base that lets it go.
    pub fn of(scene: &Scene, grid: &Grid<D>, full: f64) -> Self {
        if !knows_volumes(scene) {
            return Self::default();
        }
        let top_is_free = scene.solid_sides[Side::Top as usize] == SolidSide::Free;
        let across: usize = grid.cells[..D - 1].iter().product();
        let plate = scene.surcharge.is_some_and(|load| load.on == LoadOn::Plate);
        let held = plate || !top_is_free;
        Self {
            volumes: vec![0.0; grid.cell_count()],
            full: (0..across).map(|column| full * grid.thickness((column as f64 + 0.5) * grid.size)).collect(),
            tops: vec![Top::default(); across],
            held,
            level: !held && scene.is_one_dimensional(),
        }
    }

    /// Whether the volumes are known.
    #[inline(always)]
    pub fn is_known(&self) -> bool {
        !self.volumes.is_empty()
    }

    /// Soil in each cell, m3; none where it is not known.
    pub fn volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// The cells that hold the surface; none where it is fixed.
    pub fn tops(&self) -> &[Top] {
        if self.held { &[] } else { &self.tops }
    }

    /// Soil in a cell whose particles have a volume (m3): theirs, where the geometry does not say it.
    #[inline(always)]
    pub fn volume(&self, cell: usize, of_particles: f64) -> f64 {
        match self.volumes.get(cell) {
            // Round-off is no difference: soil that has not been strained is as if nothing was known.
            Some(&volume) if volume > 0.0 && (volume - of_particles).abs() > ROUND_OFF * volume => volume,
            _ => of_particles,
        }
    }

    /// Soil in a cell as the balances count it: under a surface that is fixed, or bends between its particles, their strain alone
    /// says how much there is.
    pub fn counted(&self, cell: usize, of_particles: f64) -> f64 {
        if self.level { self.volume(cell, of_particles) } else { of_particles }
    }

    /// Finds the surface again after the particles have moved; `carrier` knows place (m) and volume (m3) of the particle below
    /// a strip of it. True if it has moved to other cells.
    pub fn follow(
        &mut self,
        grid: &Grid<D>,
        surface: &SurfaceLoad<D>,
        carrier: impl Fn(usize) -> ([f64; D], f64),
    ) -> bool {
        if !self.is_known() {
            return false;
        }
        let mut moved = false;
        let (count, across) = (surface.strips().len(), self.tops.len());
        let column = |x: &[f64; D]| if D == 1 { 0 } else { ((x[0] * grid.inverse_size) as usize).min(across - 1) };
        // Strips stand from left to right; those over one column of cells follow each other.
        let mut strip = 0;
        while strip < count {
            let here = column(&carrier(strip).0);
            let (mut row, mut height, mut area) = (0, 0.0, 0.0);
            while strip < count {
                let (x, volume) = carrier(strip);
                if column(&x) != here {
                    break;
                }
                let s = &surface.strips()[strip];
                row = row.max(((x[D - 1] * grid.inverse_size).max(0.0) as usize).min(grid.cells[D - 1] - 1));
                height += s.area * (x[D - 1] + s.offset * (volume / s.volume));
                area += s.area;
                strip += 1;
            }
            let fill = if self.held { 1.0 } else { height / area * grid.inverse_size - row as f64 };
            moved |= self.set(here, row, fill);
        }
        moved
    }

    /// Notes that the surface stands in a row of cells of a column, `fill` cells above its lower face. True if in another than
    /// before.
    fn set(&mut self, column: usize, row: usize, fill: f64) -> bool {
        let across = self.tops.len();
        let top = Top { cell: (row * across + column) as u32, fill };
        let before = std::mem::replace(&mut self.tops[column], top);
        let moved = top.cell != before.cell || self.volumes[top.cell as usize] == 0.0;
        if moved {
            for (row, volume) in self.volumes[column..].iter_mut().step_by(across).enumerate() {
                *volume = if row * across + column < top.cell as usize { self.full[column] } else { 0.0 };
            }
        }
        self.volumes[top.cell as usize] = fill * self.full[column];
        moved
    }

    /// [`Self::follow`] with the particles of a layer.
    #[inline(always)]
    pub fn follow_layer(&mut self, grid: &Grid<D>, surface: &SurfaceLoad<D>, solid: &Layer<SolidPoint<D>, D>) {
        if self.is_known() {
            self.follow(grid, surface, surface.carrier(solid));
        }
    }

    /// Accelerations of the nodes above the surface as Darcy's law takes them. A node above a cell that is filled to f has f^2 of
    /// the mass of a full one, and what moves it is not felt by the water below: with that share its own acceleration counts,
    /// with the rest that of the node below. `give` is told the node below, the one above, and the share.
    #[inline(always)]
    pub fn calm(&self, grid: &Grid<D>, mut give: impl FnMut(usize, usize, f64)) {
        let (tops, across) = (self.tops(), self.tops.len());
        let stride = if D == 1 { 1 } else { grid.cells[0] + 1 };
        let row = |top: &Top| top.cell as usize / across;
        for (column, top) in tops.iter().enumerate() {
            let fill = |beside: Option<&Top>| {
                let beside = beside.filter(|beside| row(beside) == row(top)).unwrap_or(top);
                0.5 * (top.fill + beside.fill)
            };
            let share = |fill: f64| (fill * fill).min(1.0);
            let lower = top.cell as usize + if D == 1 { 0 } else { row(top) };
            give(lower, lower + stride, share(fill(column.checked_sub(1).map(|left| &tops[left]))));
            if D == 2 && column + 1 == across {
                give(lower + 1, lower + 1 + stride, share(top.fill));
            }
        }
    }

    /// Saves or restores what is not found again from the particles.
    pub(crate) fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        archive!(archive.slice: self.tops, self.volumes);
        Ok(())
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.volumes.capacity() * size_of::<f64>() + self.tops.capacity() * size_of::<Top>()
    }
}

//! Where particles, pore points and cells are while a mesh stays: found once, read by every sample.

use super::build::{cell_of, middle, number, place, position, smooth, top_integrals};
use super::soil::{PorePart, Soil};
use crate::constitutive::Law;
use crate::observe::{CellValues, reach};
use crate::particles::SolidPoint;
use crate::real::array_of;
use crate::scene::Scene;
use crate::space::{Axis, Stencil};

/// The places of a mesh.
#[derive(Debug, Default)]
pub(super) struct Sites<const D: usize> {
    /// Cell of each particle, and of each pore point.
    pub solid: Vec<u32>,
    pub pore: Vec<u32>,
    /// Row, height of the middle (m) and dry mass (kg) of each cell.
    pub cells: Vec<CellValues<D>>,
    /// Functions at the middle of each cell.
    pub middles: Vec<Stencil<D>>,
    /// Integrals of the functions along the top or the base, m; 1 in a column.
    pub along: Vec<f64>,
    /// Where the soil ends: x and y, m.
    pub reach: [f64; 2],
}

impl<const D: usize> Sites<D> {
    /// Those of a mesh that was built over some particles.
    pub fn new<L: Law>(scene: &Scene, soil: &Soil<L, D>, points: &[SolidPoint<D>]) -> Self {
        let axes = &soil.axes;
        let count: usize = axes.iter().map(Axis::cells).product();
        let solid: Vec<u32> = points.iter().map(|point| number(axes, &cell_of(axes, &point.x)) as u32).collect();
        let places = (0..count).map(|cell| position(axes, cell));
        let of_place =
            |at: [usize; D]| CellValues { row: at[D - 1], height: middle(axes, &at)[D - 1], ..CellValues::default() };
        let mut cells: Vec<CellValues<D>> = places.clone().map(of_place).collect();
        for (point, cell) in points.iter().zip(&solid) {
            cells[*cell as usize].solid_mass += point.mass;
        }
        let smooth = smooth(scene.shape);
        Self {
            pore: soil.pore.iter().map(|part| cell_of_pore(axes, part, smooth)).collect(),
            middles: places.map(|at| Stencil::at(axes, &middle(axes, &at))).collect(),
            along: top_integrals(axes, |x| scene.thickness(x)),
            reach: reach(points),
            cells,
            solid,
        }
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        (self.solid.capacity() + self.pore.capacity()) * size_of::<u32>()
            + self.cells.capacity() * size_of::<CellValues<D>>()
            + self.middles.capacity() * size_of::<Stencil<D>>()
    }
}

fn cell_of_pore<const D: usize>(axes: &[Axis; D], part: &PorePart<D>, smooth: bool) -> u32 {
    if part.water.count == 0 {
        return 0; // soil without water
    }
    if !smooth {
        return part.water.number[0];
    }
    // The first function of a B-spline stencil belongs to one cell along each axis.
    let place = place(axes, part.water.number[0] as usize);
    number(axes, &array_of(|d| axes[d].splines().cell_with(place[d]))) as u32
}

//! Water that fills the pores: its particles, its outline, and what it is in a cell.

use super::darcy::DRAINED_SURFACE;
use super::exposed::Exposed;
use super::{Cuts, FaceFlow, Halves, density_ratio, stored_energy};
use crate::checkpoint::{Archive, RestoreError, archive};
use crate::grid::Grid;
use crate::particles::{Layer, Point, SolidPoint, WaterPoint};
use crate::scene::{FaceLoad, Integrator, Scene, WaterProperties, Well};
use crate::soils::{Kind, Soils};

/// Soil of a cell, as water counts it.
#[derive(Debug, Clone, Copy)]
pub struct CellSoil {
    /// Number of the cell.
    pub cell: usize,
    /// Volume of the grains, m3.
    pub grains: f64,
    /// Volume of the particles, m3.
    pub volume: f64,
    /// What they filled before any strain, m3.
    pub first: f64,
    /// Volume of soil, m3: that of the particles where the outline of the soil is not known.
    pub filled: f64,
}

/// A saturated soil's water.
#[derive(Debug, Clone)]
pub struct Pores<const D: usize> {
    /// Its particles; their cells and counts alone while a step has them.
    pub layer: Layer<WaterPoint<D>, D>,
    /// Darcy's law on a face, and what the water is.
    pub flow: FaceFlow,
    /// Faces that touch no other soil.
    pub exposed: Exposed,
    /// Which sides let water out.
    pub drained: [bool; 4],
    /// Mass of the particles taken away because they left the soil, kg.
    pub removed_mass: f64,
    /// How the soil conducts.
    pub halves: Halves<D>,
    /// How its outline cuts the cells.
    pub cuts: Cuts,
    /// What is left of the stiffness of the water in each cell that is cut, where steps are explicit; empty where none is.
    pub softness: Vec<f64>,
    /// Volume of the grains of each cell per mass, m3/kg; empty where all grains weigh the same.
    pub grain_inverse: Vec<f64>,
    /// How the conductivity of each cell goes with its porosity, as [`crate::soils::at_porosity`]; empty where it stays.
    pub by_porosity: Vec<[f64; 2]>,
    /// Biot's coefficient of each cell, and what its grains give per volume and pressure, 1/Pa; empty where no grains compress.
    pub biot: Vec<[f64; 2]>,
    /// Whether a cell at the edge of the soil may be without water particles: those of soil that moves through cells come
    /// and go beside its own. It counts as open to the outside until some arrive.
    open_edges: bool,
    /// Whether water leaves soil that runs out with its particles: a cell whose water fills less than half of its soil is open
    /// to the air, and its water moves with the soil until soil and water fill it again.
    pub partly_drained: bool,
    /// Cells that are.
    bare: Vec<u32>,
    /// Whether left and right are the same place.
    pub periodic: bool,
    /// Whether steps are explicit.
    explicit: bool,
    /// Whether the soil is as it was sampled before it was saved.
    seen: bool,
    /// The loads of the scene, some of which are water.
    pub outside: Vec<FaceLoad>,
    /// Weight of the water, N/m3.
    pub weight: f64,
    /// The wells of the scene.
    pub wells: Vec<Well>,
}

/// Share of a cell's soil that its water must fill to have a pressure, where soil runs out.
pub const LEAST_FULL: f64 = 0.5;

impl<const D: usize> Pores<D> {
    /// Water particles in the pores of a scene's soil; `face_area` in m2.
    pub fn new(
        scene: &Scene,
        (layer, solid): (Layer<WaterPoint<D>, D>, &Layer<SolidPoint<D>, D>),
        grid: &Grid<D>,
        properties: &WaterProperties,
        (face_area, open_edges, partly_drained): (f64, bool, bool),
    ) -> Self {
        let mobility = properties.mobility() * grid.inverse_size;
        Self {
            layer,
            flow: FaceFlow {
                conductance: mobility,
                weight: properties.density * grid.size,
                inertia: if scene.darcy_inertia { 1.0 } else { 0.0 },
                area: face_area,
                cell_volume: face_area * grid.size,
                diffusion: mobility * grid.inverse_size,
                bulk_modulus: properties.bulk_modulus,
                grain_inverse: 1.0 / scene.grain_density,
                density: properties.density,
            },
            exposed: Exposed::default(),
            drained: [false; 4],
            removed_mass: 0.0,
            halves: Halves::default(),
            // Where water leaves with its particles, whole cells are open or not.
            cuts: if partly_drained { Cuts::default() } else { Cuts::new(scene, solid) },
            softness: Vec::new(),
            explicit: scene.integrator == Integrator::Explicit,
            seen: false,
            outside: scene.loads.clone(),
            weight: properties.density * scene.gravity.unwrap_or(0.0),
            wells: scene.wells.clone(),
            grain_inverse: Vec::new(),
            by_porosity: Vec::new(),
            biot: Vec::new(),
            open_edges,
            partly_drained,
            bare: Vec::new(),
            periodic: scene.has_periodic_pores(),
        }
    }

    /// Looks at the particles of the soil again, which are there.
    pub fn look_at_soil(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D>, D>, soils: &Soils) {
        if std::mem::take(&mut self.seen) {
            return;
        }
        self.halves = Halves::of(grid, solid, self.flow.cell_volume, soils);
        self.cuts.follow(grid, solid, soils);
        // The mean of two numbers over the particles of each cell.
        let mean = |of: fn(&Kind) -> [f64; 2]| {
            let of_cell = |(cell, _)| {
                let (mut sums, mut volume) = ([0.0; 2], 0.0);
                for index in solid.range(cell) {
                    let (own, volume_of) = (of(soils.kind_of(solid.ids[index])), solid.points[index].volume);
                    volume += volume_of;
                    (0..2).for_each(|i| sums[i] += volume_of * own[i]);
                }
                if volume > 0.0 { sums.map(|sum| sum / volume) } else { [1.0, 0.0] }
            };
            grid.walk().map(of_cell).collect()
        };
        if soils.compress() {
            self.biot = mean(|kind| kind.biot);
        }
        if soils.go_with_porosity() {
            self.by_porosity = mean(|kind| kind.by_porosity);
        }
        if soils.weigh_differently() {
            let of_cell = |(cell, _)| {
                let mut sums = [0.0; 2];
                for index in solid.range(cell) {
                    let mass = solid.points[index].mass;
                    sums[0] += mass;
                    sums[1] += mass * soils.kind_of(solid.ids[index]).grain_inverse;
                }
                if sums[0] > 0.0 { sums[1] / sums[0] } else { self.flow.grain_inverse }
            };
            self.grain_inverse = grid.walk().map(of_cell).collect();
        }
    }

    /// Whether a cell with soil has water of its own.
    fn has_water(&self, cell: usize) -> bool {
        self.bare.binary_search(&(cell as u32)).is_err()
    }

    /// Whether cells differ by which soil is in them, or by how the outline cuts them.
    pub fn is_uneven(&self) -> bool {
        let several = !self.grain_inverse.is_empty() || !self.biot.is_empty();
        self.halves.differ() || several || self.cuts.are_known()
    }

    /// How every face conducts over the water's own conductivity, and the edge of a cell over the distance along which water weighs:
    /// axis, place of the cell above it, both, and the cells with how their halves conduct. Between two cells of different
    /// conductivity the flux is that through two half cells in series: k is the harmonic mean 2 k_1 k_2/(k_1 + k_2).
    pub fn faces<S: Point<D>>(
        &self,
        grid: &Grid<D>,
        solid: &Layer<S, D>,
        mut give: impl FnMut(usize, [usize; D], [f64; 2], [(usize, f64); 2]),
    ) {
        let wet = |cell: usize| !solid.range(cell).is_empty() && self.has_water(cell);
        for (cell, position) in grid.walk() {
            let mut stride = 1;
            for axis in 0..D {
                let over_seam = self.periodic && axis == 0 && position[0] == 0;
                let low = if over_seam { Some(cell + grid.cells[0] - 1) } else { cell.checked_sub(stride) };
                let low = low.filter(|low| (over_seam || position[axis] > 0) && wet(cell) && wet(*low));
                if let Some(low) = low {
                    let [open, reach] = self.cuts.face(grid, axis, &position, [low, cell]);
                    let conducts = [open * self.halves.between(axis, low, cell), reach];
                    let [below, above] = [self.halves.at(low, axis, true), self.halves.at(cell, axis, false)];
                    let sides = [(low, open * below), (cell, open * above)];
                    give(axis, position, conducts, sides);
                    if over_seam {
                        // The same face, seen from the other side.
                        let mut last = position;
                        last[0] = grid.cells[0];
                        give(axis, last, conducts, sides);
                    }
                }
                stride *= grid.cells[axis];
            }
        }
        let aligned = self.exposed.faces.iter().filter(|_| !self.cuts.have_openings());
        for face in aligned.filter(|f| self.drained[f.side as usize]) {
            let (axis, mut position) = (face.axis as usize, grid.cell_position(face.cell as usize));
            let ratio = self.halves.at(face.cell as usize, axis, face.upper);
            position[axis] += usize::from(face.upper);
            let side = (face.cell as usize, DRAINED_SURFACE * ratio);
            give(axis, position, [side.1, DRAINED_SURFACE], [side; 2]);
        }
    }

    /// Finds the outline of the cells that have soil and water.
    pub fn rebuild(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D>, D>) {
        let Self { exposed, bare, periodic, .. } = self;
        exposed.rebuild(grid, *periodic, |cell| {
            !solid.range(cell).is_empty() && bare.binary_search(&(cell as u32)).is_err()
        });
    }

    /// Notes which cells of soil hold no water, where it leaves with its particles.
    pub fn note_open(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D>, D>, is_open: impl Fn(&usize) -> bool) {
        self.bare.clear();
        self.bare.extend((0..grid.cell_count()).filter(is_open).map(|cell| cell as u32));
        self.rebuild(grid, solid);
    }

    /// Cells of soil with water in which a well stands, in equal shares; where there are none, the nearest.
    pub fn around_well(&self, well: &Well, grid: &Grid<D>, solid: &Layer<SolidPoint<D>, D>) -> Vec<usize> {
        let wet = |cell: &usize| !solid.range(*cell).is_empty() && self.has_water(*cell);
        let off = |cell: usize| {
            let position = grid.cell_position(cell);
            let along = |d: usize| (position[d] as f64 + 0.5 - well.at[d + 2 - D] * grid.inverse_size).abs();
            (0..D).map(along).fold(0.5 + 1e-6, f64::max)
        };
        let least = (0..grid.cell_count()).filter(wet).map(off).fold(f64::INFINITY, f64::min);
        (0..grid.cell_count()).filter(wet).filter(|cell| off(*cell) == least).collect()
    }

    /// Whether water may leave the soil.
    pub fn may_leave(&self) -> bool {
        self.partly_drained || self.drained.contains(&true)
    }

    /// Looks for cells of soil without water.
    ///
    /// # Errors
    /// One inside, or in soil that stays in its cells: its place and what is wrong.
    fn look_for_bare(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D>, D>) -> Result<(), (String, String)> {
        let soil = |cell: usize| !solid.range(cell).is_empty();
        let at_edge = |cell: usize| {
            let (position, mut stride) = (grid.cell_position(cell), 1);
            (0..D).any(|d| {
                let (first, last) = (position[d] == 0, position[d] + 1 == grid.cells[d]);
                let edge = first || last || !soil(cell - stride) || !soil(cell + stride);
                stride *= grid.cells[d];
                edge
            })
        };
        let bare = |cell: &usize| soil(*cell) && self.layer.range(*cell).is_empty();
        self.bare = (0..grid.cell_count()).filter(bare).map(|cell| cell as u32).collect();
        if let Some(cell) = self.bare.iter().find(|cell| !(self.open_edges && at_edge(**cell as usize))) {
            let middle = grid.cell_position(*cell as usize).map(|i| (i as f64 + 0.5) * grid.size);
            let place = format!("cell around {middle:.4?} m");
            return Err((place, "soil without a water particle in a saturated scene".into()));
        }
        Ok(())
    }

    /// Restores the cell order where water has moved; removes water that has left the soil, and finds its outline.
    ///
    /// # Errors
    /// A place and what was found there.
    pub fn settle(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D>, D>) -> Result<(), (String, String)> {
        let outside = |p: &WaterPoint<D>| grid.cell_at(&p.x).is_none_or(|cell| solid.range(cell).is_empty());
        let lost = |x: &[f64; D], what: &str| (format!("water particle at {x:?} m"), what.to_owned());
        if self.cuts.are_known() {
            // Water in an outline stays with its soil, of which the last bit may have left its cell.
            for point in self.layer.points.iter_mut().filter(|p| outside(p) && p.x.iter().all(|x| x.is_finite())) {
                let far = |soil: &SolidPoint<D>| (0..D).map(|d| (soil.x[d] - point.x[d]).powi(2)).sum::<f64>();
                let nearest = solid.points.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
                point.x = nearest.map_or(point.x, |soil| soil.x);
            }
        }
        if let Some(point) = self.layer.points.iter().find(|p| outside(p)) {
            if point.x.iter().any(|x| !x.is_finite()) || !self.may_leave() {
                return Err(lost(&point.x, "outside the soil, which is undrained"));
            }
            let mut removed = 0.0;
            let escaped = self.layer.remove(grid, |p| {
                let leaves = outside(p);
                removed += if leaves { p.mass } else { 0.0 };
                leaves
            });
            self.removed_mass += removed;
            escaped.map_err(|e| lost(&e.x, "outside the mesh"))?;
        } else {
            self.layer.sort(grid).map_err(|e| lost(&e.x, "outside the mesh"))?;
        }
        if !self.partly_drained {
            self.look_for_bare(grid, solid)?;
        }
        self.rebuild(grid, solid);
        Ok(())
    }

    /// Porosity from the volume of grains, which do not compress.
    pub fn porosity(&self, soil: &CellSoil) -> f64 {
        1.0 - soil.grains / soil.volume
    }

    /// Biot's coefficient of a cell, and what its grains store, as much softer as its water is, 1/Pa.
    fn biot_of(&self, cell: usize) -> [f64; 2] {
        let [alpha, grains] = self.biot.get(cell).copied().unwrap_or([1.0, 0.0]);
        [alpha, grains / self.softness.get(cell).copied().unwrap_or(1.0)]
    }

    /// Bulk modulus of the water in a cell, Pa.
    fn bulk_modulus(&self, cell: usize) -> f64 {
        self.softness.get(cell).map_or(1.0, |softness| *softness) * self.flow.bulk_modulus
    }

    /// Notes how stiff the water of each cell is, from how its faces and openings conduct over a full face.
    pub fn soften(&mut self, conducts: &[[f64; 2]]) {
        let known = self.explicit && self.cuts.are_known();
        let of = |(cell, sums): (usize, &[f64; 2])| self.cuts.softness(cell, *sums);
        self.softness = if known { conducts.iter().enumerate().map(of).collect() } else { Vec::new() };
    }

    /// Pressure (Pa) and stored energy (J) of the water in a cell of soil.
    pub fn cell_state(&self, soil: &CellSoil) -> (f64, f64) {
        let (sum, volume) = self.layer.points[self.layer.range(soil.cell)]
            .iter()
            .fold((0.0, 0.0), |(s, v), p| (s + p.volume * p.pressure, v + p.volume));
        let mut pressure = if volume > 0.0 { sum / volume } else { 0.0 };
        if self.partly_drained {
            pressure = if volume < LEAST_FULL * soil.volume { 0.0 } else { pressure.max(0.0) };
        }
        let pores = self.porosity(soil) * soil.filled;
        let [_, grains] = self.biot_of(soil.cell);
        let of_grains = 0.5 * grains * soil.filled * pressure * pressure;
        (pressure, pores * stored_energy(pressure, self.bulk_modulus(soil.cell)) + of_grains)
    }

    /// Mass of water in the pores of a cell of soil, `rho_w n V exp(p/K_w)`, kg.
    pub fn cell_mass(&self, soil: &CellSoil) -> f64 {
        if self.partly_drained {
            return self.layer.points[self.layer.range(soil.cell)].iter().map(|p| p.mass).sum();
        }
        let (pressure, _) = self.cell_state(soil);
        let pores = self.porosity(soil) * soil.filled;
        let denser = density_ratio(pressure, self.bulk_modulus(soil.cell)) - 1.0;
        // What the grains leave, so that the sum over the cells is that of the soil wherever its particles are counted.
        // Grains that compress take the rest of a change of volume, and what pressure takes from them is the water's.
        let [alpha, of_grains] = self.biot_of(soil.cell);
        let grains = soil.grains + (1.0 - alpha) * (soil.filled - soil.first) - of_grains * soil.filled * pressure;
        self.flow.density * (soil.filled - grains + pores * denser)
    }

    /// Saves or restores what steps to come depend on.
    pub(crate) fn save_or_restore(&mut self, archive: &mut Archive, grid: &Grid<D>) -> Result<(), RestoreError> {
        self.layer.save_or_restore(archive)?;
        self.exposed.save_or_restore(archive, grid)?;
        archive!(archive.value: self.drained, self.removed_mass, self.bare);
        archive!(archive.value: self.halves, self.grain_inverse, self.biot, self.by_porosity, self.cuts);
        self.seen = archive.restores();
        Ok(())
    }
}

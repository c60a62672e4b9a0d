//! Water that fills the pores: pressure from the mass balance, flow from a Darcy operator.
//!
//! Mass balance (the paper's Eq. (5) with the sign of the solid term mended, see `reference-data/paper/errata.md`):
//! `dp = -(K_w/n) [ tr(d eps_s) + div(n v*) dt ]`.

use super::exposed::Exposed;
use super::{FlowRates, Place, SoilCell, StressSums, Water, density_ratio, stored_energy};
use crate::boundary::Filled;
use crate::dimension::{Kinematics, basis, coefficients, gradient, shares, to_corners, trace, value};
use crate::grid::Grid;
use crate::keep::Keeper;
use crate::nodes::NodeMotion;
use crate::particles::{Layer, SolidPoint, WaterPoint};
use crate::scene::WaterProperties;
use crate::shape::Shape;

/// Water of one cell, gathered at the start of a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WaterCell {
    /// Pore pressure at the centre, Pa.
    pub pressure: f64,
    /// Porosity n of the soil in the cell.
    pub porosity: f64,
    /// 1/n.
    pub inverse_porosity: f64,
    /// 1/V of the soil in the cell, 1/m3.
    pub inverse_volume: f64,
}

impl WaterCell {
    fn keep(&mut self, keeper: &mut Keeper) {
        let Self { pressure, porosity, inverse_porosity, inverse_volume } = self;
        for value in [pressure, porosity, inverse_porosity, inverse_volume] {
            keeper.f64(value);
        }
    }
}

/// A way to compute the flow between cells.
pub trait DarcyOperator<const D: usize>: Send + Sized {
    /// Arrays for a mesh; `area` is that of a cell face, m2; `inertia` keeps `rho_w a_s` in Darcy's law.
    fn new(grid: &Grid<D>, water: &WaterProperties, area: f64, inertia: bool) -> Self;
    /// Soil in layers: conductivity of each row of cells over that of the water; empty where it is the same all over.
    fn lay(&mut self, _rows: Vec<f64>) {}
    /// The cells with soil, their exposed faces or the drainage have changed.
    fn rebuild(&mut self, grid: &Grid<D>, soil: impl Fn(usize) -> bool, exposed: &Exposed);
    /// Before the particles are gathered.
    fn clear(&mut self);
    /// Gathers one cell: `gradient` is `sum V G p` at the corners (N), `volume` is `sum V N` (m3).
    fn gather(&mut self, corners: &[usize; 4], cell: &WaterCell, gradient: &[[f64; D]; 4], volume: &[[f64; 1]; 4]);
    /// Whether [`Self::gather`] does anything.
    const GATHERS: bool;
    /// Flow from the pressures of the cells and the accelerations of the nodes.
    fn flow(
        &mut self,
        grid: &Grid<D>,
        cells: &[WaterCell],
        motion: &[NodeMotion<D>],
        gravity: &[f64; D],
        boundary: (&Exposed, &[bool; 4]),
    ) -> FlowRates;
    /// Relative velocity v* in a cell, as coefficients of the basis, m/s.
    fn relative(&self, grid: &Grid<D>, place: &Place<D>, cell: &WaterCell) -> [[f64; D]; 4];
    /// Factors on the divergence of the flow and on the stiffness of the water in a cell that is not full of soil, in a step dt:
    /// 1/V of the soil in 1/m3, `K_w dt/n` in Pa s.
    fn filling(&self, inverse_volume: f64, stiffness: f64) -> (f64, f64);
    /// The surface of the soil has moved.
    fn under_surface(&mut self, _: &Filled<D>) {}
    /// Whether the volume of soil in each cell is known from where the surface is.
    fn knows_volumes(&self) -> bool {
        false
    }
    /// Writes or reads what steps to come depend on.
    fn keep(&mut self, keeper: &mut Keeper);
    /// Bytes held.
    fn bytes(&self) -> usize;
}

/// A saturated soil's water.
#[derive(Debug, Clone)]
pub struct Saturated<O, const D: usize> {
    pub(super) points: Layer<WaterPoint<D>, D>,
    pub(super) cells: Vec<WaterCell>,
    pub(super) operator: O,
    pub(super) exposed: Exposed,
    pub(super) drained: [bool; 4],
    pub(super) properties: WaterProperties,
    /// Volume of the grains per mass, m3/kg.
    pub(super) grain_inverse: f64,
    pub(super) solid_order: u64,
    pub(super) moved: bool,
    pub(super) removed_mass: f64,
    /// Whether a cell at the edge of the soil may be without water particles: those of soil that moves through cells come
    /// and go beside its own. It counts as open to the outside until some arrive.
    open_edges: bool,
    /// Cells that are.
    bare: Vec<u32>,
    /// Changes whenever other cells carry a pressure.
    layout: u64,
}

impl<O: DarcyOperator<D>, const D: usize> Saturated<O, D> {
    /// Water particles in a mesh; `grain_density` in kg/m3.
    pub fn new(
        points: Layer<WaterPoint<D>, D>,
        grid: &Grid<D>,
        properties: WaterProperties,
        grain_density: f64,
        operator: O,
    ) -> Self {
        Self {
            points,
            cells: vec![WaterCell::default(); grid.cell_count()],
            operator,
            exposed: Exposed::default(),
            drained: [false; 4],
            properties,
            grain_inverse: 1.0 / grain_density,
            solid_order: 0,
            moved: false,
            removed_mass: 0.0,
            open_edges: false,
            bare: Vec::new(),
            layout: 0,
        }
    }

    /// The same in soil that moves through cells.
    pub fn with_open_edges(self, open_edges: bool) -> Self {
        Self { open_edges, ..self }
    }

    /// Whether a cell with soil has water of its own.
    pub(crate) fn is_wet(&self, cell: usize) -> bool {
        !self.points.range(cell).is_empty()
    }

    /// Writes or reads the state.
    pub(super) fn keep_state(&mut self, keeper: &mut Keeper, grid: &Grid<D>) {
        self.points.keep(keeper, &WaterPoint::NONE, WaterPoint::keep);
        keeper.entries(&mut self.cells, WaterCell::keep);
        self.operator.keep(keeper);
        self.exposed.keep(keeper, grid);
        self.drained.iter_mut().for_each(|drained| keeper.bool(drained));
        keeper.u64(&mut self.solid_order);
        keeper.bool(&mut self.moved);
        keeper.f64(&mut self.removed_mass);
        keeper.list(&mut self.bare, &0, |cell, keeper| keeper.u32(cell));
        keeper.u64(&mut self.layout);
    }

    /// Number of times that other cells have come to carry a pressure.
    pub(crate) fn layout(&self) -> u64 {
        self.layout
    }

    /// A cell at the edge whose water is in its neighbours: no pressure.
    #[cold]
    fn bare_cell(&mut self, soil: &SoilCell<D>, solid: &[f64; 4]) -> [f64; 4] {
        let porosity = self.porosity(soil);
        let (inverse_porosity, inverse_volume) = (1.0 / porosity, 1.0 / soil.filled);
        self.cells[soil.place.cell] = WaterCell { pressure: 0.0, porosity, inverse_porosity, inverse_volume };
        if self.operator.knows_volumes() { self.moving_with(soil, solid) } else { [0.0; 4] }
    }

    /// Water in the pores of a cell of known volume at its corners (kg), which have a dry mass (kg).
    #[inline(always)]
    fn moving_with(&self, soil: &SoilCell<D>, solid: &[f64; 4]) -> [f64; 4] {
        let ratio = self.water_ratio(soil);
        solid.map(|mass| ratio * mass)
    }

    /// Mass of the water over that of the grains in soil as dense as that of a cell, -. The water weighs what it does under no
    /// pressure: still water keeps `p = rho_w g d`.
    #[inline(always)]
    pub(super) fn water_ratio(&self, soil: &SoilCell<D>) -> f64 {
        self.porosity(soil) * soil.volume * self.properties.density / soil.mass
    }

    /// Looks for cells of soil without water.
    ///
    /// # Errors
    /// One inside, or in soil that stays in its cells: its place and what is wrong.
    fn look_for_bare<const S: usize>(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D, S>, D>,
    ) -> Result<bool, (String, String)> {
        let soil = |cell: usize| !solid.range(cell).is_empty();
        let bare = |cell: &usize| soil(*cell) && self.points.range(*cell).is_empty();
        let at_edge = |cell: usize| {
            let (position, mut stride) = (grid.cell_position(cell), 1);
            let beside = |d: usize, stride: usize| {
                let (first, last) = (position[d] == 0, position[d] + 1 == grid.cells[d]);
                first || last || !soil(cell - stride) || !soil(cell + stride)
            };
            (0..D).any(|d| {
                let edge = beside(d, stride);
                stride *= grid.cells[d];
                edge
            })
        };
        let found = (0..grid.cell_count()).filter(bare).map(|cell| cell as u32);
        if found.clone().eq(self.bare.iter().copied()) {
            return Ok(false);
        }
        let found: Vec<u32> = found.collect();
        if let Some(cell) = found.iter().find(|cell| !(self.open_edges && at_edge(**cell as usize))) {
            let middle = grid.cell_position(*cell as usize).map(|i| (i as f64 + 0.5) * grid.size);
            let place = format!("cell around {middle:.4?} m");
            return Err((place, "soil without a water particle in a saturated scene".into()));
        }
        self.bare = found;
        Ok(true)
    }

    /// Porosity from the volume of grains, which do not compress.
    #[inline(always)]
    pub(super) fn porosity(&self, soil: &SoilCell<D>) -> f64 {
        1.0 - soil.mass * self.grain_inverse / soil.volume
    }

    fn rebuild<const S: usize>(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D, S>, D>) {
        let bare = std::mem::take(&mut self.bare);
        self.rebuild_where(grid, solid, |cell| {
            !solid.range(cell).is_empty() && bare.binary_search(&(cell as u32)).is_err()
        });
        self.bare = bare;
    }

    /// Finds the faces of the cells for which `soil` holds.
    pub(super) fn rebuild_where<const S: usize>(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D, S>, D>,
        soil: impl Fn(usize) -> bool,
    ) {
        for (cell, water) in self.cells.iter_mut().enumerate() {
            if !soil(cell) {
                *water = WaterCell::default();
            }
        }
        self.layout += 1;
        self.exposed.rebuild(grid, &soil);
        self.operator.rebuild(grid, &soil, &self.exposed);
        self.solid_order = solid.order;
    }
}

impl<K: Kinematics<D, S>, O: DarcyOperator<D>, const D: usize, const S: usize> Water<K, D, S> for Saturated<O, D> {
    const WET: bool = true;

    #[inline(always)]
    fn clear(&mut self) {
        self.operator.clear();
    }

    #[inline(always)]
    fn cell_to_grid<Sh: Shape>(
        &mut self,
        grid: &Grid<D>,
        soil: &SoilCell<D>,
        solid: &[f64; 4],
        stress: &mut StressSums<D, S>,
    ) -> [f64; 4] {
        if self.points.range(soil.place.cell).is_empty() {
            return self.bare_cell(soil, solid);
        }
        let in_pores = self.operator.knows_volumes();
        let mut mass = [0.0; 4];
        let mut weighted = [[0.0; 1]; 4]; // moments of V p
        let mut volumes = [[0.0; 1]; 4]; // moments of V
        for point in &self.points.points[self.points.range(soil.place.cell)] {
            let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - soil.place.position[d] as f64);
            if !in_pores {
                let share = shares(point.mass, &xi);
                for a in 0..Grid::<D>::CORNERS {
                    mass[a] += share[a];
                }
            }
            weighted[0][0] += point.volume * point.pressure;
            volumes[0][0] += point.volume;
            if !Sh::AT_CENTRE {
                let phi = basis(&xi);
                for k in 1..Grid::<D>::CORNERS {
                    weighted[k][0] += point.volume * point.pressure * phi[k];
                    volumes[k][0] += point.volume * phi[k];
                }
            }
        }
        let pressure = weighted[0][0] / volumes[0][0];
        let inverse_volume = 1.0 / soil.filled;
        let porosity = self.porosity(soil);
        self.cells[soil.place.cell] =
            WaterCell { pressure, porosity, inverse_porosity: 1.0 / porosity, inverse_volume };
        if in_pores {
            mass = self.moving_with(soil, solid);
        }
        if Sh::AT_CENTRE {
            // Section 2.2: the pressure acts at the centre of the cell, on the soil that the water fills.
            let centre = basis(&[0.5; D]);
            for k in 0..Grid::<D>::CORNERS {
                weighted[k][0] = pressure * soil.filled * centre[k];
                volumes[k][0] = soil.filled * centre[k];
            }
        } else {
            // The water particles share the volume as those of the soil do.
            let share = soil.filled / volumes[0][0];
            for k in 0..Grid::<D>::CORNERS {
                weighted[k][0] *= share;
                volumes[k][0] *= share;
            }
        }
        for s in 0..S {
            stress.mean[s] += weighted[0][0] * K::UNIT_PRESSURE[s];
            for d in 0..D {
                stress.first[d][s] += weighted[1 + d][0] * K::UNIT_PRESSURE[s];
            }
        }
        if O::GATHERS {
            // sum_wp V G_i p: the force of the pressure alone.
            let mean: [f64; S] = std::array::from_fn(|s| weighted[0][0] * -K::UNIT_PRESSURE[s]);
            let first: [[f64; S]; D] =
                std::array::from_fn(|d| std::array::from_fn(|s| weighted[1 + d][0] * -K::UNIT_PRESSURE[s]));
            let force = to_corners::<D, D, _>(&K::internal_force(&mean, &first, grid.inverse_size));
            self.operator.gather(
                &soil.place.corners,
                &self.cells[soil.place.cell],
                &force,
                &to_corners::<D, 1, _>(&volumes),
            );
        }
        mass
    }

    #[inline(always)]
    fn flow(&mut self, grid: &Grid<D>, motion: &[NodeMotion<D>], gravity: &[f64; D]) -> FlowRates {
        self.operator.flow(grid, &self.cells, motion, gravity, (&self.exposed, &self.drained))
    }

    #[inline(always)]
    fn cell_to_points<Sh: Shape>(&mut self, grid: &Grid<D>, place: &Place<D>, velocity: &[[f64; D]; 4], dt: f64) {
        let cell = self.cells[place.cell];
        let relative = self.operator.relative(grid, place, &cell);
        let mut both = *velocity; // v_w = v_s + v*
        for k in 0..Grid::<D>::CORNERS {
            for d in 0..D {
                both[k][d] += relative[k][d];
            }
        }
        let stiffness = self.properties.bulk_modulus * cell.inverse_porosity;
        let (filling, softer) = self.operator.filling(cell.inverse_volume, stiffness * dt);
        let stiffness = softer * stiffness;
        // Rates of pressure and of water volume at a point of the cell.
        let rates_at = |at: &[f64; D]| {
            let solid = trace(&gradient(velocity, at, grid.inverse_size)); // Eq. (7a)
            let flow = filling * trace(&gradient(&relative, at, grid.inverse_size)); // Eq. (6a)
            // Eq. (5), mended: dp = -(K_w/n) [ tr(d eps_s) + n tr(d eps*_w) ]
            (-stiffness * (solid + cell.porosity * flow), solid + flow)
        };
        let centre = rates_at(&[0.5; D]);
        let range = self.points.range(place.cell);
        let mut inside = true;
        for point in &mut self.points.points[range] {
            let xi: [f64; D] = std::array::from_fn(|d| point.x[d] * grid.inverse_size - place.position[d] as f64);
            let phi = basis(&xi);
            let (pressure_rate, volume_rate) = if Sh::AT_CENTRE { centre } else { rates_at(&xi) };
            point.pressure += dt * pressure_rate;
            point.volume *= 1.0 + dt * volume_rate;
            point.v = value::<D, D, _>(&both, &phi);
            for d in 0..D {
                point.x[d] += dt * point.v[d];
                let moved = point.x[d] * grid.inverse_size - place.position[d] as f64;
                inside &= (0.0..1.0).contains(&moved);
            }
        }
        self.moved |= !inside;
    }

    fn under_surface(&mut self, filled: &Filled<D>) {
        self.operator.under_surface(filled);
    }

    fn settle(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D, S>, D>) -> Result<(), (String, String)> {
        let soil_changed = self.solid_order != solid.order;
        if !soil_changed && !self.moved {
            return Ok(());
        }
        self.moved = false;
        if soil_changed {
            self.rebuild(grid, solid);
        }
        let outside = |p: &WaterPoint<D>| grid.cell_at(&p.x).is_none_or(|cell| solid.range(cell).is_empty());
        if let Some(point) = self.points.points.iter().find(|p| outside(p)) {
            let lost = point.x.iter().any(|x| !x.is_finite()) || !self.drained.contains(&true);
            if lost {
                return Err((
                    format!("water particle at {:?} m", point.x),
                    "outside the soil, which is undrained".into(),
                ));
            }
            let mut removed = 0.0;
            let escaped = self.points.remove(grid, |p| {
                let leaves = outside(p);
                removed += if leaves { p.mass } else { 0.0 };
                leaves
            });
            self.removed_mass += removed;
            escaped.map_err(|e| (format!("water particle at {:?} m", e.x), "outside the mesh".into()))?;
        } else {
            self.points
                .sort(grid)
                .map_err(|e| (format!("water particle at {:?} m", e.x), "outside the mesh".into()))?;
        }
        if self.look_for_bare(grid, solid)? {
            self.rebuild(grid, solid);
        }
        Ok(())
    }

    fn set_drained(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D, S>, D>, drained: [bool; 4]) {
        self.drained = drained;
        self.rebuild(grid, solid);
    }

    fn layer(&self) -> Option<&Layer<WaterPoint<D>, D>> {
        Some(&self.points)
    }

    fn cell_state(&self, soil: &SoilCell<D>) -> (f64, f64) {
        let (sum, volume) = self.points.points[self.points.range(soil.place.cell)]
            .iter()
            .fold((0.0, 0.0), |(s, v), p| (s + p.volume * p.pressure, v + p.volume));
        let pressure = if volume > 0.0 { sum / volume } else { 0.0 };
        let pores = self.porosity(soil) * soil.filled;
        (pressure, pores * stored_energy(pressure, self.properties.bulk_modulus))
    }

    fn cell_mass(&self, soil: &SoilCell<D>) -> f64 {
        let (pressure, _) = Water::<K, D, S>::cell_state(self, soil);
        let pores = self.porosity(soil) * soil.filled;
        let denser = density_ratio(pressure, self.properties.bulk_modulus) - 1.0;
        // What the grains leave, so that the sum over the cells is that of the soil wherever its particles are counted.
        self.properties.density * (soil.filled - soil.mass * self.grain_inverse + pores * denser)
    }

    fn removed_mass(&self) -> f64 {
        self.removed_mass
    }

    fn density(&self) -> f64 {
        self.properties.density
    }

    fn keep(&mut self, keeper: &mut Keeper, grid: &Grid<D>) {
        self.keep_state(keeper, grid);
    }

    fn bytes(&self) -> usize {
        self.points.bytes() + self.cells.capacity() * size_of::<WaterCell>() + self.operator.bytes()
    }
}

/// Coefficients of a nodal field in a cell.
#[inline(always)]
pub(super) fn cell_coefficients<const D: usize>(field: &[[f64; D]], corners: &[usize; 4]) -> [[f64; D]; 4] {
    let mut nodal = [[0.0; D]; 4];
    for a in 0..Grid::<D>::CORNERS {
        nodal[a] = field[corners[a]];
    }
    coefficients::<D, D, _>(&nodal)
}

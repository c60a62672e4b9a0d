//! Faces of cells that water passes: how each conducts, and what leaves through those that are drained.

use super::pressure::storage;
use super::store::{Frame, Strip};
use crate::boundary::Filled;
use crate::grid::Grid;
use crate::observe::Totals;
use crate::particles::{Layer, SolidPoint};
use crate::real::map_of;
use crate::scene::Well;
use crate::soils::at_porosity;
use crate::water::pores::Pores;
use crate::water::{DRAINED_SURFACE, FaceFlow, Opening};

/// A face that lets water out.
#[derive(Debug, Clone, Copy)]
pub struct DrainedFace {
    /// Cell inside.
    pub cell: usize,
    /// Axis it is normal to.
    pub axis: usize,
    outwards: f64,
    /// The face, numbered by the cell above it.
    pub face: usize,
    /// How it conducts when water leaves, as [`Faces::conducts`].
    conducts: f64,
}

/// A piece of an outline that lets water through.
#[derive(Debug, Clone, Copy)]
pub struct Outlet {
    /// Cell inside.
    pub cell: usize,
    /// How it conducts, as [`Faces::conducts`], now and at first.
    pub conducts: f64,
    first: f64,
    /// From where the water of the cell weighs to the piece, m.
    away: [f64; 2],
    /// Whether the pressure of the cell is that at the piece.
    held: bool,
    /// Middle of the piece, m.
    middle: [f64; 2],
    /// The loads that may put water before it, a bit each, and whether the piece lets water out without.
    water: u64,
    drained: bool,
    /// Pressure outside, Pa; none if it is closed.
    pub outside: Option<f64>,
}

/// A face whose conductivity goes with the pores beside it: its axis, it, the cells with how the half there conducts at first, the edge
/// of a cell over the distance along which water weighs.
type Varied = (usize, usize, [(usize, f64); 2], f64);

/// A cell that a well takes water from.
#[derive(Debug, Clone, Copy)]
pub struct Intake {
    /// The cell.
    pub cell: usize,
    /// The well, and the share of its water.
    of: (usize, f64),
    /// What it takes now, m3/s; below 0 it puts some in.
    pub rate: f64,
}

/// A face at the outline of the soil: whether it lets water out, its axis, outwards (1 or -1), its nodes.
pub type Outline = (bool, usize, f64, [usize; 2]);

/// Faces, numbered by the cell above each.
#[derive(Debug, Clone)]
pub struct Faces<const D: usize> {
    frame: Frame<D>,
    /// How faces conduct, over the conductivity of the water: 0 closed, 1 between two full cells of soil, 2 at a drained side, half
    /// a cell away; else the edge of a cell over the distance.
    pub conducts: [Vec<f64>; 2],
    /// Their conductivity over that of the water; empty where it is one.
    pub ratio: [Vec<f64>; 2],
    /// Volume of the grains of each cell per mass, m3/kg; empty where all grains weigh the same.
    pub grains: Vec<f64>,
    /// Biot's coefficient of each cell, and what its grains give per volume and pressure, 1/Pa; empty where no grains compress.
    pub biot: [Vec<f64>; 2],
    /// Those that let water out.
    pub drained: Vec<DrainedFace>,
    /// Those at the outline of the soil.
    pub outline: Vec<Outline>,
    /// Pieces of an outline that cuts cells, where they let water through.
    pub outlets: Vec<Outlet>,
    /// How the conductivity of the cells goes with their porosity, and that of faces; empty where it does not.
    pub by_porosity: Vec<[f64; 2]>,
    varied: Vec<Varied>,
    /// Cells in which wells stand.
    pub intakes: Vec<Intake>,
    /// What leaves each cell through outlets and wells in the step, m3/s, and what is left of the stiffness of its water; empty where
    /// there are none, and where no outline cuts cells.
    pub outflow: Vec<f64>,
    pub softness: Vec<f64>,
    /// Whether water goes over the seam of a periodic mesh.
    pub periodic: bool,
}

impl<const D: usize> Faces<D> {
    /// Closed ones; `several`: of several conductivities.
    pub fn new(frame: Frame<D>, several: bool) -> Self {
        let closed =
            |wanted: bool| [(); 2].map(|()| vec![0.0; if wanted { frame.length() + 2 * frame.pad() } else { 0 }]);
        let (conducts, ratio) = (closed(true), closed(several));
        Self {
            frame,
            conducts,
            ratio,
            grains: Vec::new(),
            biot: [Vec::new(), Vec::new()],
            drained: Vec::new(),
            outline: Vec::new(),
            outlets: Vec::new(),
            by_porosity: Vec::new(),
            varied: Vec::new(),
            intakes: Vec::new(),
            outflow: Vec::new(),
            softness: Vec::new(),
            periodic: false,
        }
    }

    /// Finds which conduct.
    pub fn open(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D>, D>, water: &mut Pores<D>) {
        let Self { frame, conducts, ratio, grains, biot, drained, outline, periodic, by_porosity, varied, .. } = self;
        *periodic = water.periodic;
        if !water.grain_inverse.is_empty() {
            grains.resize(conducts[0].len(), water.flow.grain_inverse);
            grid.walk().for_each(|(cell, position)| grains[frame.number(&position)] = water.grain_inverse[cell]);
        }
        if !water.biot.is_empty() {
            for (i, of_cells) in biot.iter_mut().enumerate() {
                of_cells.resize(conducts[0].len(), [1.0, 0.0][i]);
                grid.walk().for_each(|(cell, position)| of_cells[frame.number(&position)] = water.biot[cell][i]);
            }
        }
        if !water.by_porosity.is_empty() {
            by_porosity.resize(conducts[0].len(), [1.0, 0.0]);
            grid.walk().for_each(|(cell, position)| by_porosity[frame.number(&position)] = water.by_porosity[cell]);
        }
        varied.clear();
        conducts.iter_mut().chain(&mut *ratio).for_each(|faces| faces.fill(0.0));
        water.cuts.open(&water.drained);
        water.faces(grid, solid, |axis, position, [conducted, reach], sides| {
            conducts[axis][frame.number(&position)] = conducted;
            if !by_porosity.is_empty() {
                let sides = map_of(&sides, |(cell, half)| (frame.number(&grid.cell_position(cell)), half));
                varied.push((axis, frame.number(&position), sides, reach));
            }
            if let Some(ratio) = ratio[axis].get_mut(frame.number(&position)) {
                *ratio = conducted / reach;
            }
        });
        drained.clear();
        outline.clear();
        for of_soil in &water.exposed.faces {
            let is_drained = water.drained[of_soil.side as usize];
            let (axis, position) = (of_soil.axis as usize, grid.cell_position(of_soil.cell as usize));
            let outwards = if of_soil.upper { 1.0 } else { -1.0 };
            let cell = frame.number(&position);
            let face = cell + if of_soil.upper { frame.stride[axis] } else { 0 };
            if is_drained {
                drained.push(DrainedFace { cell, axis, outwards, face, conducts: conducts[axis][face] });
            }
            outline.push((is_drained, axis, outwards, [face, face + frame.beside(axis)]));
        }
        if water.cuts.have_openings() {
            drained.clear();
            self.open_cuts(grid, water);
        }
        self.intakes.clear();
        for (which, well) in water.wells.iter().enumerate() {
            let cells = water.around_well(well, grid, solid);
            let (frame, share) = (self.frame, 1.0 / cells.len() as f64);
            let intake = |cell| Intake { cell: frame.number(&grid.cell_position(cell)), of: (which, share), rate: 0.0 };
            self.intakes.extend(cells.into_iter().map(intake));
            self.outflow.resize(frame.length(), 0.0);
        }
    }

    /// The same of the pieces of an outline that cuts cells.
    fn open_cuts(&mut self, grid: &Grid<D>, water: &mut Pores<D>) {
        let Self { frame, conducts, outlets, outflow, softness, .. } = self;
        let mut sums = vec![[0.0; 2]; grid.cell_count()];
        for (cell, position) in grid.walk() {
            let number = frame.number(&position);
            for axis in 0..D {
                sums[cell][0] += conducts[axis][number] + conducts[axis][number + frame.stride[axis]];
            }
        }
        outlets.clear();
        for opening in &water.cuts.openings {
            let drained = opening.looks_to(&water.drained);
            let cell = opening.cell as usize;
            // Also of what a later stage opens, so that water keeps its stiffness.
            sums[cell][1] += opening.conducts;
            let conducts = grid.thickness(opening.piece.middle[0]) * opening.conducts;
            if drained || opening.water != 0 {
                let (number, middle) = (frame.number(&grid.cell_position(cell)), opening.piece.middle);
                let outside = drained.then_some(0.0);
                let (first, Opening { away, held, water, .. }) = (conducts, *opening);
                outlets.push(Outlet { cell: number, conducts, first, away, held, middle, water, drained, outside });
            }
        }
        water.soften(&sums);
        outflow.resize(frame.length(), 0.0);
        outflow.fill(0.0);
        softness.resize(frame.length(), 1.0);
        for (cell, position) in grid.walk() {
            softness[frame.number(&position)] = water.softness.get(cell).copied().unwrap_or(1.0);
        }
    }

    /// Lets the faces conduct as the pores beside them are now.
    pub fn follow_porosity(&mut self, strips: &[Strip<D>]) {
        let Self { frame, conducts, ratio, drained, outlets, by_porosity, varied, .. } = self;
        let share =
            |cell: usize| at_porosity(by_porosity[cell], strips[cell / frame.strip].pores(cell % frame.strip)[0]);
        for (axis, face, sides, reach) in &*varied {
            let [a, b] = map_of(sides, |(cell, half)| half * share(cell));
            let mean = if a == b { a } else { 2.0 * a * b / (a + b) };
            (ratio[*axis][*face], conducts[*axis][*face]) = (mean / reach, mean);
        }
        drained.iter_mut().for_each(|face| face.conducts = conducts[face.axis][face.face]);
        outlets.iter_mut().for_each(|outlet| outlet.conducts = outlet.first * share(outlet.cell));
    }

    /// Looks at the water outside and the wells at a time, s. Whether that has opened or closed an outlet.
    pub fn look_outside(&mut self, water: &Pores<D>, time: f64) -> bool {
        for intake in &mut self.intakes {
            let Well { rate, course, .. } = &water.wells[intake.of.0];
            intake.rate = intake.of.1 * rate * course.at(time, 0.0);
        }
        let mut changed = false;
        for outlet in self.outlets.iter_mut().filter(|outlet| outlet.water != 0) {
            let (place, before) = (&outlet.middle, outlet.outside.is_some());
            let all = water.outside.iter().enumerate().filter(|(which, _)| outlet.water >> which & 1 == 1);
            let there = all.filter_map(|(_, load)| load.of_water(place, time, water.weight));
            outlet.outside = there.reduce(|a, b| a + b).or(outlet.drained.then_some(0.0));
            changed |= outlet.outside.is_some() != before;
        }
        changed
    }

    /// What drives water out through an outlet beside the pressure of its cell, Pa, between nodes that accelerate (m/s2).
    pub fn weight_on(
        &self,
        outlet: &Outlet,
        flow: &FaceFlow,
        (gravity, acceleration): (&[f64; D], &[Vec<f64>; 2]),
    ) -> f64 {
        let (mut sum, inertia) = (0.0, if outlet.held { 0.0 } else { flow.inertia });
        for d in 0..D {
            let corners = (0..1 << D).map(|a| acceleration[d][outlet.cell + self.frame.offset_of_corner(a)]);
            let mean = corners.sum::<f64>() / f64::from(1_u32 << D);
            sum += flow.density * (gravity[d] - inertia * mean) * outlet.away[d + 2 - D];
        }
        sum
    }

    /// What leaves through outlets and wells in a step dt (s) under pressures of the cells (Pa, from [`Frame::pad`] on): those of its end, or of
    /// its start, from which the cells of the strips continue.
    pub fn let_out(
        &mut self,
        flow: &FaceFlow,
        (pressure, strips): (&[f64], Option<&[Strip<D>]>),
        drive: (&[f64; D], &[Vec<f64>; 2]),
        totals: &mut Totals<D>,
        dt: f64,
    ) {
        self.outflow.fill(0.0);
        for i in 0..self.outlets.len() {
            let outlet = self.outlets[i];
            let Some(outside) = outlet.outside else { continue };
            let body = self.weight_on(&outlet, flow, drive);
            let head = pressure[self.frame.pad() + outlet.cell] - outside + body;
            let out = flow.area * flow.conductance * outlet.conducts * head;
            self.outflow[outlet.cell] += out;
            totals.water_out += dt * out.max(0.0);
            totals.water_in -= dt * out.min(0.0);
            totals.darcy_dissipation += dt * out * head;
            totals.flow_body_work += dt * out * body;
            totals.external_work -= dt * out * outside;
        }
        for Intake { cell, rate, .. } in &self.intakes {
            self.outflow[*cell] += rate;
            totals.water_out += dt * rate.max(0.0);
            totals.water_in -= dt * rate.min(0.0);
            // Under the mean of both ends: what a well itself changes in a step may be all there is.
            let stores = strips.map_or(f64::INFINITY, |strips| storage(strips, &self.frame, *cell, (flow, self)));
            totals.external_work -= dt * rate * (pressure[self.frame.pad() + cell] - 0.5 * dt * rate / stores);
        }
    }

    /// Distances between the cells that hold the surface, it, and the cells below.
    pub fn note_reach(&mut self, filled: &Filled<D>, grid: &Grid<D>) {
        let Self { frame, conducts, ratio, drained, .. } = self;
        let mut note = |face: usize, reach: f64| {
            if conducts[D - 1][face] > 0.0 {
                conducts[D - 1][face] = ratio[D - 1].get(face).map_or(reach, |ratio| ratio * reach);
            }
        };
        for top in filled.tops() {
            note(frame.number(&grid.cell_position(top.cell as usize)), 2.0 / (1.0 + top.fill));
        }
        for face in drained.iter().filter(|face| face.axis + 1 == D && face.outwards > 0.0) {
            let position = frame.position(face.cell);
            let top = filled.tops().get(if D == 1 { 0 } else { position[0] });
            if let Some(top) = top.filter(|top| grid.cell_position(top.cell as usize) == position) {
                note(face.face, DRAINED_SURFACE / top.fill);
            }
        }
    }

    /// Whether an outline cuts cells and lets water through: distances to it are those of its pieces.
    pub fn has_cuts(&self) -> bool {
        !self.outlets.is_empty()
    }

    /// Distances at the outline of the soil, where `fill` says how much of a cell is soil.
    pub fn note_fill(&mut self, fill: impl Fn(usize) -> f64) {
        let Self { frame, conducts, ratio, drained, outline, .. } = self;
        let mut note = |axis: usize, face: usize, reach: f64| {
            if conducts[axis][face] > 0.0 {
                conducts[axis][face] = ratio[axis].get(face).map_or(reach, |ratio| ratio * reach);
            }
        };
        for &(_, axis, outwards, [face, _]) in &*outline {
            let stride = frame.stride[axis];
            let (cell, inner) = if outwards > 0.0 { (face - stride, face - stride) } else { (face, face + stride) };
            note(axis, inner, 2.0 / (1.0 + fill(cell)));
        }
        for face in &*drained {
            note(face.axis, face.face, DRAINED_SURFACE / fill(face.cell));
        }
    }

    /// Eq. (1) on a face that a pressure (Pa) drops across, between nodes that accelerate (m/s2): flux, m/s.
    pub fn flux(&self, flow: &FaceFlow, (axis, face): (usize, usize), drop: f64, drive: (f64, &[Vec<f64>; 2])) -> f64 {
        self.driven(flow, (axis, face), drop, drive)[0]
    }

    /// The same, and what drives it: pressure drop and weight along it, Pa.
    fn driven(
        &self,
        flow: &FaceFlow,
        (axis, face): (usize, usize),
        drop: f64,
        (gravity, acceleration): (f64, &[Vec<f64>; 2]),
    ) -> [f64; 3] {
        let a = &acceleration[axis];
        let mean = if D == 1 { a[face] } else { 0.5 * (a[face] + a[face + self.frame.beside(axis)]) };
        let conducts = self.conducts[axis][face];
        let reach = self.ratio[axis].get(face).map_or(conducts, |ratio| conducts / ratio);
        flow.through(conducts, drop, flow.body(gravity, mean) / reach)
    }

    /// What flow over the seam of a periodic mesh dissipates, and the work of its weight there, N m/s over the face area.
    pub fn over_seam(
        &self,
        flow: &FaceFlow,
        pressure: &[f64],
        (gravity, acceleration): (f64, &[Vec<f64>; 2]),
    ) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for [last, first] in self.frame.seam().filter(|[_, first]| self.conducts[0][*first] > 0.0) {
            let drop = pressure[self.frame.pad() + last] - pressure[self.frame.pad() + first];
            let [flux, head, body] = self.driven(flow, (0, first), drop, (gravity, acceleration));
            sums[0] += flux * head;
            sums[1] += flux * body;
        }
        sums
    }

    /// How a drained face conducts now, as [`Self::conducts`].
    pub fn of_drained(&self, face: &DrainedFace) -> f64 {
        self.conducts[face.axis][face.face]
    }

    /// Records what leaves in a step dt (s) under pressures of the cells (Pa, from [`Frame::pad`] on).
    pub fn drain(
        &mut self,
        water: &Pores<D>,
        pressure: &[f64],
        (gravity, acceleration): (&[f64; D], &[Vec<f64>; 2]),
        totals: &mut Totals<D>,
        dt: f64,
    ) {
        for i in 0..self.drained.len() {
            let DrainedFace { cell, axis, outwards, face, conducts } = self.drained[i];
            if water.partly_drained {
                self.conducts[axis][face] = conducts;
            }
            let drop = outwards * pressure[self.frame.pad() + cell];
            let flux = self.flux(&water.flow, (axis, face), drop, (gravity[axis], acceleration));
            let through = dt * water.flow.area * self.frame.thickness(axis, face) * outwards * flux;
            if water.partly_drained {
                // What passes is in the particles, of which those that are taken away have left; none comes in.
                self.conducts[axis][face] = if through < 0.0 { 0.0 } else { conducts };
            } else {
                totals.water_out += through.max(0.0);
                totals.water_in -= through.min(0.0);
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.conducts.iter().chain(&self.ratio).map(Vec::capacity).sum::<usize>() * size_of::<f64>()
            + self.drained.capacity() * size_of::<DrainedFace>()
            + self.outline.capacity() * size_of::<Outline>()
    }
}

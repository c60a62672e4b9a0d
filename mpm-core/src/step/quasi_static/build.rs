//! Building a mesh for the soil: axes, unknowns, integration points, faces, loads.

use super::motion::{Motion, WaterInertia};
use super::soil::{Before, FacePart, Fluid, HELD, PorePart, Push, Soil, SolidPart, Source, Values};
use super::tangent::System;
use crate::constitutive::{Law, Materials, State};
use crate::dimension::in_two;
use crate::particles::SolidPoint;
use crate::real::array_of;
use crate::scene::{
    Bearing, Course, FaceLoad, Integrator, LoadOn, Piece, Quadrature, Scene, ShapeChoice, Side, SolidSide, Surcharge,
    Well,
};
use crate::space::{Axis, Basis, Fit, Group, MOST, Stencil, fit, gauss, gauss_points, groups};
use crate::sparse::Unsolved;

/// Least boundary cell, as a share of a whole one, tried one after the other until the weights can be fitted.
const LEAST_CELLS: [f64; 3] = [0.5, 0.75, 1.0];
/// beta of the viscosity of jumps.
const VISCOSITY: f64 = 0.01;
/// Stiffness of water over G beyond which waves are those of the penalty of jumps.
const LEAST_PENALTY: f64 = 100.0;
/// Pieces for the integral of a load along one cell.
const LOAD_PIECES: usize = 16;
/// Levels of a reservoir from one of its corners to the next: forces between are a straight line.
const LEVELS: usize = 16;

/// What a mesh is built over.
#[derive(Debug)]
pub(super) struct Ground<'a, const D: usize> {
    pub scene: &'a Scene,
    /// Particles where they are now.
    pub points: &'a [SolidPoint<D>],
    /// What their soil remembers.
    pub states: &'a [State],
    /// Numbers of the particles of the top row.
    pub top: &'a [usize],
    /// How far the surface has come down, m.
    pub settled: f64,
    /// Drained sides, and how the sides hold the soil.
    pub drained: [bool; 4],
    pub sides: [SolidSide; 4],
    /// Whether waves that the steps do not resolve are damped.
    pub damps: bool,
    /// Damping force per mass and velocity, 1/s.
    pub damping: f64,
    /// Lengths that are not modelled, multiplied: the width of a column or 1 m, m.
    pub thickness: f64,
}

/// Whether pressures are B-splines; else they are constant in a cell.
pub(super) fn smooth(shape: ShapeChoice) -> bool {
    shape.spline_degree().is_some()
}

impl<const D: usize> Ground<'_, D> {
    /// Axes of the soil with boundary cells of at least a share of a whole one.
    fn axes(&self, least: f64) -> [Axis; D] {
        let scene = self.scene;
        let basis = match scene.shape {
            ShapeChoice::Gimp => Basis::Gimp { half: 0.5 * self.spacing() },
            shape => Basis::Splines { degree: shape.spline_degree().unwrap_or(1) },
        };
        std::array::from_fn(|d| {
            let high = if d == D - 1 { scene.height - self.settled } else { scene.width };
            let axis = Axis::new(0.0, high, scene.cell, -scene.shift * scene.cell, least, basis);
            // Strain and gradient of the pressure jump between layers, and at the level of a column that a well takes water from:
            // B-splines must bend there.
            let tops = scene.layers.iter().filter(|_| d == D - 1).map(|layer| layer.up_to);
            let wells = scene.wells.iter().filter(|_| D == 1).map(|well| well.at[1]);
            let mut places = tops.chain(wells).peekable();
            if places.peek().is_none() { axis } else { axis.broken_at(places) }
        })
    }

    fn spacing(&self) -> f64 {
        self.scene.cell / self.scene.particles_per_direction() as f64
    }

    /// Functions over the radius at a place, 1/m; none but about an axis.
    fn hoop(&self, axes: &[Axis; D], x: &[f64; D]) -> Option<[f64; MOST]> {
        self.scene.axis().map(|axis| Stencil::at(axes, x).value.map(|value| value / (axis + x[0])))
    }

    /// Gradients at a place that a change of volume is found with: with v_r/r at another, about an axis.
    fn dilation(&self, axes: &[Axis; D], [x, around]: [&[f64; D]; 2]) -> [[f64; D]; MOST] {
        let mut slope = Stencil::at(axes, x).slope;
        let hoop = self.hoop(axes, around);
        slope.iter_mut().zip(hoop.iter().flatten()).for_each(|(slope, hoop)| slope[0] += hoop);
        slope
    }

    /// Axes and weights of the particles, these as in a mesh that is 1 m thick; whether they are as good as they are meant to be.
    fn axes_and_weights(&self) -> ([Axis; D], Vec<f64>, bool) {
        let volumes: Vec<f64> = self.points.iter().map(|p| p.volume / self.scene.thickness(p.x[0])).collect();
        if self.scene.quadrature == Quadrature::Volumes || self.scene.shape == ShapeChoice::Gimp {
            return (self.axes(LEAST_CELLS[0]), volumes, true);
        }
        let Some(degree) = self.scene.shape.spline_degree() else {
            let axes = self.axes(LEAST_CELLS[0]);
            let weights = self.filling(&axes, volumes);
            return (axes, weights, true);
        };
        let places: Vec<[f64; D]> = self.points.iter().map(|p| p.x).collect();
        let mut best: Option<([Axis; D], Fit)> = None;
        for least in LEAST_CELLS {
            let axes = self.axes(least);
            let fitted = fit(&axes, degree, self.thickness, &places, &volumes);
            if best.as_ref().is_none_or(|(_, b)| fitted.degree > b.degree) {
                best = Some((axes, fitted));
            }
            if best.as_ref().is_some_and(|(_, b)| b.degree == degree) {
                break;
            }
        }
        let exact = best.as_ref().is_some_and(|(_, best)| best.degree == degree);
        match best {
            Some((axes, fitted)) => (axes, fitted.weights, exact),
            None => (self.axes(LEAST_CELLS[0]), volumes, exact),
        }
    }

    /// Volumes scaled so that the particles of every cell fill it: gradients of linear functions are constant there,
    /// and a cell that particles have left or entered would else be too soft or too stiff.
    fn filling(&self, axes: &[Axis; D], mut volumes: Vec<f64>) -> Vec<f64> {
        let mut sums = vec![0.0; axes.iter().map(Axis::cells).product()];
        let place = |point: &SolidPoint<D>| number(axes, &cell_of(axes, &point.x));
        for (point, volume) in self.points.iter().zip(&volumes) {
            sums[place(point)] += volume;
        }
        for (point, volume) in self.points.iter().zip(&mut volumes) {
            let position = cell_of(axes, &point.x);
            let whole = (0..D).fold(self.thickness, |v, d| v * axes[d].length(position[d]));
            *volume *= whole / sums[number(axes, &position)];
        }
        volumes
    }

    /// Builds the mesh.
    pub fn build<L: Law>(&self, law: Materials<L>) -> Result<Soil<L, D>, Unsolved> {
        let scene = self.scene;
        let (axes, weights, good) = self.axes_and_weights();
        let smooth = smooth(scene.shape);
        let functions: usize = axes.iter().map(Axis::functions).product();
        let cells: usize = axes.iter().map(Axis::cells).product();
        let wet = scene.water.is_some();
        let pressures = if !wet {
            0
        } else if smooth {
            functions
        } else {
            cells
        };
        let solid = self.solid(&law, &axes, &weights);
        let moves = scene.integrator == Integrator::Implicit;
        let groups = if good { None } else { self.groups(&axes, &solid) };
        let pore = if wet || moves || scene.gravity.is_some() { self.pore(&law, &axes, &solid) } else { Vec::new() };
        let faces = if wet && !smooth { self.faces(&law, &axes) } else { Vec::new() };
        let moved = self.moved(&axes);
        let (soil_map, water_map, size) = self.unknowns(&axes, pressures, &moved);
        let jumps = match scene.shape.spline_degree() {
            Some(degree) if wet => self.penalty(&axes, degree),
            _ => Vec::new(),
        };
        let viscosity = match scene.shape.spline_degree() {
            Some(degree) if self.damps => self.viscosity(&axes, degree),
            _ => Vec::new(),
        };
        let maps = (soil_map.as_slice(), water_map.as_slice());
        let inertia = match (scene.relative_acceleration, scene.darcy_inertia) {
            _ if !wet => WaterInertia::None,
            (true, _) => WaterInertia::Own,
            (false, true) => WaterInertia::WithSoil,
            (false, false) => WaterInertia::None,
        };
        let modulus = scene.oedometer_modulus();
        let mass = scene.mixture_density() * self.thickness * scene.cell.powi(D as i32);
        let passage = (scene.cell * (scene.mixture_density() / modulus).sqrt(), scene.pore_stiffness() / modulus);
        let symmetric = law.are_symmetric() && !(moves && inertia == WaterInertia::WithSoil);
        let system = System::new(size, (&solid, &pore, &faces), [&jumps, &viscosity], maps, &axes, symmetric)?;
        let water = scene.water.unwrap_or(crate::scene::WaterProperties {
            hydraulic_conductivity: 0.0,
            anisotropy: 1.0,
            fabric: crate::scene::Fabric::default(),
            bulk_modulus: f64::INFINITY,
            unit_weight: 1.0,
            density: 0.0,
        });
        let gravity = scene.body_force().map(|g| array_of(|d| g[d + 2 - D]));
        let loads = self.loads(&axes, &solid);
        let before = self.before(&axes, (&faces, &water_map));
        Ok(Soil {
            // All of it, until a time is said.
            load: loads.first().map_or_else(|| vec![0.0; functions * D], |(force, _)| force.clone()),
            loads,
            values: Values {
                force: vec![0.0; functions * D],
                content: vec![0.0; pressures],
                flow: vec![0.0; pressures],
                ..Values::default()
            },
            u: vec![[0.0; D]; functions],
            p: vec![0.0; pressures],
            moved,
            plates: scene.plates.iter().map(|plate| (plate.clone(), [0.0; 2])).collect(),
            wells: self.wells(&axes),
            motion: moves.then(|| {
                Box::new(Motion::new(
                    (inertia, self.damping),
                    (passage, mass, !self.damps),
                    viscosity,
                    (functions, pore.len()),
                ))
            }),
            held_pressure: vec![0.0; if before.is_empty() { 0 } else { pressures }],
            before,
            outside: (scene.loads.clone(), water.density * scene.gravity.unwrap_or(0.0)),
            fluid: Fluid {
                mobility: water.mobility(),
                compressibility: 1.0 / water.bulk_modulus,
                density: water.density,
                gravity,
            },
            scales: [scene.cell, scene.oedometer_modulus()],
            small: scene.strain == crate::scene::StrainChoice::Small,
            pushes: vec![Push::default(); if groups.is_some() { solid.len() } else { 0 }],
            grouped: Vec::new(),
            groups: groups.unwrap_or_default(),
            cell_gradient: vec![([[0.0; D]; D], 0.0); if smooth { 0 } else { cells }],
            axes,
            law,
            solid,
            pore,
            faces,
            jumps,
            soil_map,
            water_map,
            system,
        })
    }

    fn solid<L: Law>(&self, law: &Materials<L>, axes: &[Axis; D], weights: &[f64]) -> Vec<SolidPart<D>> {
        let centre = matches!(self.scene.shape, ShapeChoice::Centre | ShapeChoice::Centroid);
        // Plastic flow that keeps its volume at every point leaves smooth functions no way to move.
        let smooth = self.scene.shape.is_wide() && !law.are_linear();
        let splits = self.scene.shape == ShapeChoice::BBar || (D == 2 && smooth);
        let part = |(i, point): (usize, &SolidPoint<D>)| {
            let mut stencil = Stencil::at(axes, &point.x);
            let middle = middle(axes, &cell_of(axes, &point.x));
            let mut centroid = middle;
            // With gradients at the centroid about an axis a stress is shared among the nodes as loads are.
            centroid[0] += self.scene.axis().map_or(0.0, |axis| self.scene.cell.powi(2) / (12.0 * (axis + middle[0])));
            let [place, around] = if centre { [centroid, middle] } else { [point.x; 2] };
            stencil.slope = Stencil::at(axes, &place).slope; // section 2.2
            let hoop = self.hoop(axes, &around);
            let of = if splits { [&centroid, &middle] } else { [&place, &around] };
            let dilates = (splits || hoop.is_some()).then(|| Box::new(self.dilation(axes, of)));
            let mark = law.soils.at(&in_two(&point.x));
            SolidPart {
                stencil,
                dilates,
                hoop: hoop.map(Box::new),
                weight: weights[i] * self.scene.thickness(point.x[0]),
                stress: point.stress,
                strain: [0.0; 4],
                state: self.states[i],
                mark,
            }
        };
        self.points.iter().enumerate().map(part).collect()
    }

    /// The points of each cell, where they are too few for weights: not of soil whose changes of volume are taken elsewhere.
    fn groups(&self, axes: &[Axis; D], solid: &[SolidPart<D>]) -> Option<Vec<Group>> {
        let degree = self.scene.shape.spline_degree()?;
        let places: Vec<[f64; D]> = self.points.iter().map(|p| p.x).collect();
        let apart = solid.iter().any(|part| part.dilates.is_some());
        if apart { None } else { groups(axes, degree, self.thickness, &places) }
    }

    /// Porosity of the cells.
    fn porosities<L: Law>(&self, law: &Materials<L>, axes: &[Axis; D]) -> Vec<f64> {
        let mut room = vec![[0.0; 2]; axes.iter().map(Axis::cells).product()];
        for point in self.points {
            let [volume, grains] = &mut room[number(axes, &cell_of(axes, &point.x))];
            *volume += point.volume;
            *grains += point.mass * law.soils.kind(law.soils.at(&in_two(&point.x))).grain_inverse;
        }
        // The grains do not compress.
        let porosity =
            |[volume, grains]: [f64; 2]| if volume > 0.0 { 1.0 - grains / volume } else { self.scene.porosity };
        room.into_iter().map(porosity).collect()
    }

    fn pore<L: Law>(&self, law: &Materials<L>, axes: &[Axis; D], solid: &[SolidPart<D>]) -> Vec<PorePart<D>> {
        let (wet, porosities) = (self.scene.water.is_some(), self.porosities(law, axes));
        let Some(degree) = self.scene.shape.spline_degree() else {
            let part = |(i, point): (usize, &SolidPoint<D>)| {
                let cell = number(axes, &cell_of(axes, &point.x));
                let mut water = Stencil::single(cell);
                water.count = usize::from(wet);
                let SolidPart { stencil: mut soil, ref dilates, weight, mark, .. } = solid[i];
                soil.slope = dilates.as_deref().copied().unwrap_or(soil.slope);
                PorePart { soil, water, weight, porosity: porosities[cell], mark }
            };
            return self.points.iter().enumerate().map(part).collect();
        };
        let rule = gauss_points(degree);
        let mut parts = Vec::with_capacity(porosities.len() * rule.len().pow(D as u32));
        for (cell, &porosity) in porosities.iter().enumerate() {
            let position = position(axes, cell);
            for local in 0..rule.len().pow(D as u32) {
                let mut rest = local;
                let (mut x, mut weight) = ([0.0; D], self.thickness);
                for d in 0..D {
                    let (xi, share) = rule[rest % rule.len()];
                    rest /= rule.len();
                    let length = axes[d].length(position[d]);
                    x[d] = axes[d].knots[position[d]] + xi * length;
                    weight *= share * length;
                }
                let mut soil = Stencil::at(axes, &x);
                let mut water = soil;
                water.count *= usize::from(wet);
                soil.slope = self.dilation(axes, [&x, &x]);
                weight *= self.scene.thickness(x[0]);
                parts.push(PorePart { soil, water, weight, porosity, mark: law.soils.at(&in_two(&x)) });
            }
        }
        parts
    }

    fn faces<L: Law>(&self, law: &Materials<L>, axes: &[Axis; D]) -> Vec<FacePart> {
        let porosities = self.porosities(law, axes);
        let mut faces = Vec::new();
        for (cell, &pores) in porosities.iter().enumerate() {
            let position = position(axes, cell);
            let mark = |position: [usize; D]| law.soils.at(&in_two(&middle(axes, &position)));
            let own = mark(position);
            let mut stride = 1;
            for axis in 0..D {
                let half = |i: usize| 0.5 * axes[axis].length(i);
                let area =
                    (0..D).filter(|d| *d != axis).fold(self.thickness, |area, d| area * axes[d].length(position[d]));
                // Of the lower face and of the upper one, which differ across a radius.
                let centroid = middle(axes, &position)[0];
                let across = if axis + 1 < D { [-half(position[axis]), half(position[axis])] } else { [0.0; 2] };
                let [below, area] = across.map(|from| area * self.scene.thickness(centroid + from));
                let (at, last) = (position[axis], axes[axis].cells() - 1);
                // The last axis is the vertical one: sides 2 and 3.
                let side = 2 * (axis + 2 - D);
                let here = cell as u32;
                let mut give = |cells, area, reach, marks, porosity| {
                    faces.push(FacePart { cells, axis, area, reach, marks, porosity, outside: 0.0 });
                };
                if at == 0 && self.is_open(side) {
                    give([HELD, here], below, [0.0, half(at)], [own; 2], [pores; 2]);
                }
                if at < last {
                    let above = (cell + stride) as u32;
                    let mut next = position;
                    next[axis] += 1;
                    let porosity = [pores, porosities[cell + stride]];
                    give([here, above], area, [half(at), half(at + 1)], [own, mark(next)], porosity);
                } else if self.is_open(side + 1) {
                    give([here, HELD], area, [half(at), 0.0], [own; 2], [pores; 2]);
                }
                stride *= axes[axis].cells();
            }
        }
        faces
    }

    /// Numbers the unknowns: along a column, displacement and pressure of the same place beside each other.
    fn unknowns(
        &self,
        axes: &[Axis; D],
        pressures: usize,
        moved: &[(u32, usize, f64, u16)],
    ) -> (Vec<[u32; D]>, Vec<u32>, usize) {
        let counts: [usize; D] = array_of(|d| axes[d].functions());
        let functions: usize = counts.iter().product();
        let smooth = smooth(self.scene.shape);
        let plate = self.scene.surcharge.is_some_and(|s| s.on == LoadOn::Plate);
        let mut next = 0;
        let mut take = || {
            next += 1;
            next - 1
        };
        let mut shared = None;
        // Soil without inertia that slides on its base and leans on nothing has its place along x from nowhere: no force moves it.
        let sides = &self.sides;
        let slides = D == 2
            && self.scene.integrator == Integrator::QuasiStatic
            && self.scene.axis().is_none()
            && !sides.contains(&SolidSide::Fixed)
            && !sides[..2].contains(&SolidSide::Roller);
        let pin = slides.then_some(counts[0] / 2);
        let (mut soil_map, mut water_map) = (vec![[HELD; D]; functions], vec![HELD; pressures]);
        for function in 0..functions.max(pressures) {
            let (mut rest, mut held, mut dry, mut top) = (function, [false; D], false, false);
            held[0] = pin == Some(function);
            for axis in 0..D {
                let at = rest % counts[axis];
                rest /= counts[axis];
                for upper in [false, true] {
                    if at != if upper { counts[axis] - 1 } else { 0 } {
                        continue;
                    }
                    let side = 2 * (axis + 2 - D) + usize::from(upper);
                    dry |= self.is_open(side);
                    top |= side == Side::Top as usize;
                    match self.sides[side] {
                        SolidSide::Free => {}
                        SolidSide::Roller => held[axis] = true,
                        SolidSide::Fixed => held = [true; D],
                    }
                }
            }
            for (_, axis, ..) in moved.iter().filter(|(number, ..)| *number as usize == function) {
                held[*axis] = true;
            }
            if function < functions {
                for d in 0..D {
                    if held[d] {
                        continue;
                    }
                    soil_map[function][d] =
                        if plate && top && d == D - 1 { *shared.get_or_insert_with(&mut take) } else { take() };
                }
            }
            if function < pressures && !(smooth && dry) {
                water_map[function] = take();
            }
        }
        (soil_map, water_map, next as usize)
    }

    /// Functions that go with a plate that is moved.
    fn moved(&self, axes: &[Axis; D]) -> Vec<(u32, usize, f64, u16)> {
        let mut moved = Vec::new();
        for (which, plate) in self.scene.plates.iter().enumerate() {
            let side = plate.on as usize;
            let (axis, upper) = (usize::from(side > 1) + D - 2, side % 2 == 1);
            let [low, high] =
                if axis + 1 == D { plate.x } else { plate.y }.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            let slack = 1e-6 * self.scene.cell;
            for function in 0..axes.iter().map(Axis::functions).product() {
                let place = place(axes, function);
                let stands = if D == 1 { 0.0 } else { axes[1 - axis].splines().stands(place[1 - axis]) };
                let edge = place[axis] == if upper { axes[axis].functions() - 1 } else { 0 };
                if edge && (D == 1 || (low - slack..=high + slack).contains(&stands)) {
                    for d in (0..D).filter(|d| *d == axis || plate.rough) {
                        let inwards = if upper { -1.0 } else { 1.0 };
                        moved.push((function as u32, d, if d == axis { inwards } else { 0.0 }, which as u16));
                    }
                }
            }
        }
        moved
    }

    /// Whether water passes a side: it is drained, or water stands before it.
    fn is_open(&self, side: usize) -> bool {
        self.drained[side]
            || self.scene.loads.iter().any(|load| load.is_water() && load.on.is_some_and(|on| on as usize == side))
    }

    /// Where water stands before the soil.
    fn before(&self, axes: &[Axis; D], (faces, water_map): (&[FacePart], &[u32])) -> Vec<(Before, [f64; 2], u16, f64)> {
        let mut before = Vec::new();
        let loads = self.scene.loads.iter().enumerate().filter(|(_, load)| load.is_water());
        for (which, load) in loads {
            let Some(side) = load.on.map(|on| on as usize) else { continue };
            let (axis, upper) = (usize::from(side > 1) + D - 2, side % 2 == 1);
            let on_line = |x: &[f64; D], d: usize| {
                let along = &axes[d].knots;
                let end = if upper { along[along.len() - 1] } else { along[0] };
                let mut x = *x;
                x[d] = end;
                in_two(&x)
            };
            for (number, face) in faces.iter().enumerate().filter(|(_, face)| face.axis == axis) {
                if face.cells[usize::from(upper)] == HELD {
                    let inside = position(axes, face.cells[usize::from(!upper)] as usize);
                    let x = on_line(&middle(axes, &inside), axis);
                    before.push((Before::Face(number as u32), x, which as u16, 1.0));
                }
            }
            if smooth(self.scene.shape) {
                for (function, _) in water_map.iter().enumerate().filter(|(_, map)| **map == HELD) {
                    let place = place(axes, function);
                    if place[axis] == if upper { axes[axis].functions() - 1 } else { 0 } {
                        let along = D - 1 - axis;
                        let samples =
                            if D == 1 { vec![(0.0, 1.0)] } else { axes[along].splines().samples(place[along]) };
                        for (at, weight) in samples {
                            let x = on_line(&[at; D], axis);
                            before.push((Before::Function(function as u32), x, which as u16, weight));
                        }
                    }
                }
            }
        }
        before
    }

    /// Wells, whose height goes with that of the soil: pressure functions with their shares.
    fn wells(&self, axes: &[Axis; D]) -> Vec<Source> {
        let of = |well: &Well| {
            let stands = 1.0 - self.settled / self.scene.height;
            let place: [f64; D] = array_of(|d| well.at[d + 2 - D] * if d + 1 == D { stands } else { 1.0 });
            let shares = if smooth(self.scene.shape) {
                let Stencil { count, number, value, .. } = Stencil::at(axes, &place);
                (0..count).map(|a| (number[a], value[a])).collect()
            } else {
                // On a line of the mesh it stands in the cells on both sides.
                let beside = |quadrant: usize| {
                    let shift = |d: usize| if quadrant >> d & 1 == 1 { 1e-6 } else { -1e-6 } * self.scene.cell;
                    let cell = cell_of(axes, &array_of(|d| place[d] + shift(d)));
                    (number(axes, &cell) as u32, 0.5_f64.powi(D as i32))
                };
                (0..1 << D).map(beside).collect()
            };
            (shares, well.clone(), 0.0)
        };
        self.scene.wells.iter().map(of).collect()
    }

    /// The loads: force where the factor is 1 (N per displacement function and direction), and its course in time.
    fn loads(&self, axes: &[Axis; D], solid: &[SolidPart<D>]) -> Vec<(Vec<f64>, Course)> {
        let surcharge = self.scene.surcharge.map(|surcharge| {
            let ramp = surcharge.ramp_time;
            (self.surcharge(&surcharge, axes, solid), if ramp > 0.0 { Course::Ramp(ramp) } else { Course::Constant })
        });
        let mut loads: Vec<_> = surcharge.into_iter().collect();
        for load in &self.scene.loads {
            if let (Bearing::Reservoir, Course::Times(levels)) = (load.bearing, &load.course) {
                loads.extend(self.reservoir(load, levels, axes));
                continue;
            }
            let parts = load.course.parts().into_iter();
            loads.extend(parts.map(|(course, along)| (self.on_side(load, axes, &|[x, _]| along(x)), course)));
        }
        loads
    }

    /// Forces of a reservoir at its levels and some between, each with a course that is 1 at its own time.
    fn reservoir(&self, load: &FaceLoad, levels: &[[f64; 2]], axes: &[Axis; D]) -> Vec<(Vec<f64>, Course)> {
        let weight = self.scene.water.map_or(0.0, |water| water.density) * self.scene.gravity.unwrap_or(0.0);
        let between = |pair: &[[f64; 2]], i: usize| {
            array_of::<_, 2, _>(|d| pair[0][d] + (pair[1][d] - pair[0][d]) * i as f64 / LEVELS as f64)
        };
        let fine = levels.windows(2).flat_map(|pair| (1..=LEVELS).map(|i| between(pair, i)));
        let fine: Vec<[f64; 2]> = levels[..1].iter().copied().chain(fine).collect();
        let force = |(i, [_, level]): (usize, &[f64; 2])| {
            let near = i.saturating_sub(1)..(i + 2).min(fine.len());
            let course = near.map(|j| [fine[j][0], if i == j { 1.0 } else { 0.0 }]).collect();
            (self.on_side(load, axes, &|[_, y]| weight * (level - y).max(0.0)), Course::Times(course))
        };
        fine.iter().enumerate().map(force).collect()
    }

    /// Force of a load on a side of the soil where its factor is `along` at a place, m.
    fn on_side(&self, load: &FaceLoad, axes: &[Axis; D], along: &dyn Fn([f64; 2]) -> f64) -> Vec<f64> {
        let functions: usize = axes.iter().map(Axis::functions).product();
        let mut forces = vec![0.0; functions * D];
        let side = load.on.unwrap_or(Side::Top) as usize;
        let (axis, upper) = (usize::from(side > 1), side % 2 == 1);
        let (axis, sign) = (axis + D - 2, if upper { 1.0 } else { -1.0 });
        let mut outward = [0.0; 2];
        outward[axis + 2 - D] = sign;
        let force = load.force(&Piece { middle: [0.0; 2], outward });
        let end = if upper { axes[axis].functions() - 1 } else { 0 };
        let place = |x: f64| {
            let mut place = [x; D];
            place[axis] = axes[axis].knots[if upper { axes[axis].cells() } else { 0 }];
            in_two(&place)
        };
        let range = if axis + 1 == D { load.x } else { load.y };
        let sums = if D == 1 {
            vec![along(place(0.0))]
        } else {
            integrals(&axes[1 - axis], range, |x| along(place(x)) * self.scene.thickness(place(x)[0]))
        };
        for (i, sum) in sums.into_iter().enumerate() {
            let function =
                if axis == 0 && D == 2 { end + i * axes[0].functions() } else { i + end * sums_before(axes) };
            for d in 0..D {
                forces[function * D + d] += self.thickness * force[d + 2 - D] * sum;
            }
        }
        forces
    }

    /// Force of the full surcharge, N per displacement function and direction.
    fn surcharge(&self, surcharge: &Surcharge, axes: &[Axis; D], solid: &[SolidPart<D>]) -> Vec<f64> {
        let functions: usize = axes.iter().map(Axis::functions).product();
        let mut load = vec![0.0; functions * D];
        let share = |x: f64| surcharge.strip.map_or(1.0, |strip| strip.share(x)) * self.scene.thickness(x);
        if surcharge.on == LoadOn::Particles {
            let area = self.thickness * self.spacing().powi(D as i32 - 1);
            for &point in self.top {
                let force = -surcharge.pressure * area * if D == 2 { share(self.points[point].x[0]) } else { 1.0 };
                let stencil = &solid[point].stencil;
                for a in 0..stencil.count {
                    load[stencil.number[a] as usize * D + D - 1] += force * stencil.value[a];
                }
            }
            return load;
        }
        let row = functions - axes[..D - 1].iter().map(Axis::functions).product::<usize>();
        for (i, integral) in top_integrals(axes, share).into_iter().enumerate() {
            load[(row + i) * D + D - 1] -= surcharge.pressure * self.thickness * integral;
        }
        load
    }

    /// `gamma/(2G)` times the jumps of the pressure.
    fn penalty(&self, axes: &[Axis; D], degree: usize) -> Vec<(u32, u32, f64)> {
        let gamma = self.scene.jump_penalty.unwrap_or_else(|| self.scene.usual_jump_penalty());
        let shear = self.scene.elastic.shear_modulus();
        // 1/G at a height over that of the scene's soil: 1 but for layers.
        let ground = self.scene.ground();
        let softer = |height: f64| shear / ground.at(&[0.5 * self.scene.width, height]).elastic.shear_modulus();
        self.jumps(axes, degree, (gamma / (2.0 * shear), softer))
    }

    /// `beta rho c/L` times the jumps of the velocity: what damps waves that are no longer than some cells, and those of pressures that
    /// no motion but the penalty of their jumps resists.
    fn viscosity(&self, axes: &[Axis; D], degree: usize) -> Vec<(u32, u32, f64)> {
        let scene = self.scene;
        let water = scene.pore_stiffness().min(LEAST_PENALTY * scene.elastic.shear_modulus());
        let impedance = (scene.mixture_density() * (scene.oedometer_modulus() + water)).sqrt();
        self.jumps(axes, degree, (VISCOSITY * impedance / scene.cell, |_| 1.0))
    }

    /// `factor L^(2p + 1) sum over inner knots [d^p p/dn^p][d^p q/dn^p]` for B-splines of degree p, integrated along the knot, times a
    /// number that goes with the height.
    fn jumps(
        &self,
        axes: &[Axis; D],
        degree: usize,
        (factor, softer): (f64, impl Fn(f64) -> f64),
    ) -> Vec<(u32, u32, f64)> {
        if factor == 0.0 {
            return Vec::new();
        }
        let factor = factor * self.scene.cell.powi(2 * degree as i32 + 1) * self.thickness;
        let mut jumps = Vec::new();
        // Of the functions along an axis each with those from `degree + 1` before it to as many behind.
        let band = 2 * degree + 3;
        for axis in 0..D {
            let along = &axes[axis];
            let (splines, vertical) = (along.splines(), axis == D - 1);
            let beside = |at: f64| if vertical { self.scene.thickness(at) } else { softer(at) };
            let across = across(axes, axis, degree, beside);
            let strides = if axis == 0 { [1, axes[0].functions()] } else { [axes[0].functions(), 1] };
            let mut between = vec![0.0; along.functions() * band];
            for knot in (1..along.cells()).filter(|knot| !along.is_break(*knot)) {
                // The cell below has all of these functions but the last, the cell above all but the first.
                let first = splines.first(knot - 1);
                let at = along.knots[knot];
                let here = if vertical { softer(at) } else { self.scene.thickness(at) };
                let (below, above) = (splines.highest(knot - 1), splines.highest(knot));
                let before = |a: usize| if a > 0 { above[a - 1] } else { 0.0 };
                let jump = |a: usize| before(a) - if a <= degree { below[a] } else { 0.0 };
                for (a, b) in (0..degree + 2).flat_map(|a| (0..degree + 2).map(move |b| (a, b))) {
                    between[(first + a) * band + b + degree + 1 - a] += here * factor * jump(a) * jump(b);
                }
            }
            for (at, jump) in between.iter().enumerate().filter(|(_, jump)| **jump != 0.0) {
                let (a, b) = (at / band, at / band + at % band - degree - 1);
                let number = |f: usize, other: usize| (f * strides[0] + other * strides[1]) as u32;
                let pair = |&(i, j, mass): &(usize, usize, f64)| (number(a, i), number(b, j), jump * mass);
                jumps.extend(across.iter().map(pair));
            }
        }
        jumps
    }
}

/// Integrals of the functions along the top times a share of the load, m; 1 in a column.
pub(super) fn top_integrals<const D: usize>(axes: &[Axis; D], share: impl Fn(f64) -> f64) -> Vec<f64> {
    if D == 1 { vec![1.0] } else { integrals(&axes[0], None, share) }
}

/// Functions in a row along the first axis; one in a column.
fn sums_before<const D: usize>(axes: &[Axis; D]) -> usize {
    axes[..D - 1].iter().map(Axis::functions).product()
}

/// Integrals of the functions of an axis times a share, m, between two places (m) or all along.
fn integrals(axis: &Axis, range: Option<[f64; 2]>, share: impl Fn(f64) -> f64) -> Vec<f64> {
    let [low, high] = range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let mut sums = vec![0.0; axis.functions()];
    for cell in 0..axis.cells() {
        let (from, to) = (axis.knots[cell].max(low), axis.knots[cell + 1].min(high));
        if from >= to {
            continue;
        }
        let first = axis.splines().first(cell);
        for (a, sum) in sums[first..].iter_mut().take(axis.splines().support()).enumerate() {
            *sum += gauss(from, to, LOAD_PIECES, |x| axis.splines().at(cell, x).value[a] * share(x));
        }
    }
    sums
}

/// Pairs of functions across an axis with the integral of their product times a weight of each cell, at its middle (m).
fn across<const D: usize>(
    axes: &[Axis; D],
    axis: usize,
    degree: usize,
    weight: impl Fn(f64) -> f64,
) -> Vec<(usize, usize, f64)> {
    if D == 1 {
        return vec![(0, 0, 1.0)];
    }
    let other = &axes[1 - axis];
    let count = other.functions();
    let mut pairs: Vec<(usize, usize, f64)> = (0..count)
        .flat_map(|i| (i.saturating_sub(degree)..(i + degree + 1).min(count)).map(move |j| (i, j, 0.0)))
        .collect();
    for cell in 0..other.cells() {
        let first = other.splines().first(cell);
        for (i, j, mass) in pairs.iter_mut().filter(|(i, j, _)| *i.min(j) >= first && *i.max(j) <= first + degree) {
            let product = |x: f64| {
                let value = other.splines().at(cell, x).value;
                value[*i - first] * value[*j - first]
            };
            *mass += weight(other.middle(cell)) * gauss(other.knots[cell], other.knots[cell + 1], 1, product);
        }
    }
    pairs
}

/// Lattice position of the cell that holds a point.
pub(super) fn cell_of<const D: usize>(axes: &[Axis; D], x: &[f64; D]) -> [usize; D] {
    array_of(|d| axes[d].cell(x[d]))
}

/// Middle of a cell, m.
pub(super) fn middle<const D: usize>(axes: &[Axis; D], position: &[usize; D]) -> [f64; D] {
    array_of(|d| axes[d].middle(position[d]))
}

/// Number of a cell, the first axis fastest.
pub(super) fn number<const D: usize>(axes: &[Axis; D], position: &[usize; D]) -> usize {
    (0..D).rev().fold(0, |n, d| n * axes[d].cells() + position[d])
}

/// Lattice position of a function.
pub(super) fn place<const D: usize>(axes: &[Axis; D], function: usize) -> [usize; D] {
    let mut rest = function;
    array_of(|d| {
        let i = rest % axes[d].functions();
        rest /= axes[d].functions();
        i
    })
}

/// Where a spline stands, m.
pub(super) fn stands<const D: usize>(axes: &[Axis; D], function: usize) -> [f64; D] {
    let place = place(axes, function);
    array_of(|d| axes[d].splines().stands(place[d]))
}

/// Lattice position of a cell.
pub(super) fn position<const D: usize>(axes: &[Axis; D], cell: usize) -> [usize; D] {
    let mut rest = cell;
    array_of(|d| {
        let i = rest % axes[d].cells();
        rest /= axes[d].cells();
        i
    })
}

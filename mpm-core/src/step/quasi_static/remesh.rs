//! New meshes: the state of the old one goes to the particles, theirs to the new one.

use super::build::{Ground, smooth, stands};
use super::failures::{inverted, nothing, unsolved};
use super::motion::{WaterInertia, forward};
use super::newton::Workspace;
use super::sites::Sites;
use super::soil::{HELD, PorePart, Soil, Strained};
use super::{QuasiStatic, build};
use crate::constitutive::Law;
use crate::dimension::in_two;
use crate::particles::SolidPoint;
use crate::real::{array_of, map_of};
use crate::scene::{SolidSide, StrainChoice};
use crate::space::{Stencil, stretch, turned};
use crate::sparse::{Factor, Ordering, Signs, Sparse, Unsolved};
use crate::step::Fault;

/// Strain on one mesh after which a new one is built. Early remeshing costs accuracy: at a final strain of 20 % and
/// L = 0.1 m the late settlement of `bspline2` is off by 1e-4 with 0.05, by 1e-6 without.
pub(super) const REMESH_STRAIN: f64 = 0.5;

impl<L: Law, const D: usize> QuasiStatic<L, D> {
    /// Builds a mesh over the soil as it is; its pressures go over.
    pub(super) fn build(&mut self, drained: [bool; 4]) -> Result<(), Fault> {
        let carried = if self.soil.is_some() { Some(self.carry().map_err(|e| unsolved(&e))?) } else { None };
        let (pressures, rates) = carried.unzip();
        let mut soil = self.mesh(drained)?;
        self.start(&mut soil, pressures.as_deref())?;
        self.set_in_motion(&mut soil, rates).map_err(|e| unsolved(&e))?;
        self.take(soil);
        Ok(())
    }

    /// Other sides drain from now on: the mesh and what it carries stay.
    pub(super) fn drain(&mut self, drained: [bool; 4]) -> Result<(), Fault> {
        let mut soil = self.mesh(drained)?;
        let Some(old) = &mut self.soil else { return Err(nothing()) };
        old.expand(&self.y);
        soil.u.copy_from_slice(&old.u);
        soil.p.copy_from_slice(&old.p);
        if let (Some(motion), Some(before)) = (&mut soil.motion, &old.motion) {
            motion.velocity.copy_from_slice(&before.velocity);
            motion.flux.copy_from_slice(&before.flux);
        }
        for (part, before) in soil.solid.iter_mut().zip(&old.solid) {
            (part.strain, part.stress, part.state) = (before.strain, before.stress, before.state);
        }
        self.y = soil.unknowns_of_fields();
        self.take(soil);
        Ok(())
    }

    /// A mesh over the soil as it was when the last one was built.
    fn mesh(&mut self, drained: [bool; 4]) -> Result<Soil<L, D>, Fault> {
        self.drained = drained;
        let large = self.scene.strain == StrainChoice::Large;
        let ground = Ground {
            scene: &self.scene,
            points: &self.points,
            states: &self.states,
            top: &self.seeding.top,
            settled: if large { self.settled } else { 0.0 },
            drained,
            sides: self.sides,
            damps: self.damps(),
            damping: self.damping,
            thickness: self.seeding.thickness,
        };
        ground.build(self.seeding.law.clone()).map_err(|e| unsolved(&e))
    }

    fn take(&mut self, mut soil: Soil<L, D>) {
        soil.plates.iter_mut().for_each(|(plate, [_, before])| *before = plate.at(self.time));
        soil.bear(self.time, self.ramp);
        self.loose.clear();
        self.sites = Sites::new(&self.scene, &soil, &self.points);
        let weights = &self.sites.along;
        let whole: f64 = weights.iter().sum();
        let row = soil.u.len() - weights.len();
        self.settle = weights
            .iter()
            .enumerate()
            .map(|(i, w)| (soil.soil_map[row + i][D - 1], -w / whole * soil.scales[0]))
            .filter(|(unknown, _)| *unknown != HELD)
            .collect();
        let on_top = soil.moved.iter().filter(|(function, axis, ..)| *axis == D - 1 && *function as usize >= row);
        let share = |(function, _, inwards, plate): &(u32, usize, f64, u16)| {
            (*plate, -weights[*function as usize - row] / whole * inwards)
        };
        self.settle_with = on_top.map(share).collect();
        self.work = Workspace::new(soil.unknowns(), self.reference(&soil));
        self.spent.resize(soil.pore.len(), 0.0);
        self.soil = Some(soil);
    }

    /// Pressures of a new mesh, from those of the particles or from the scene; the water content that they mean.
    pub(super) fn start(&mut self, soil: &mut Soil<L, D>, carried: Option<&[f64]>) -> Result<(), Fault> {
        let smooth = smooth(self.scene.shape);
        soil.u.fill([0.0; D]);
        match carried {
            None => {
                let first = self.seeding.first_pressure;
                for function in 0..soil.p.len() {
                    let place = if smooth {
                        stands(&soil.axes, function)
                    } else {
                        build::middle(&soil.axes, &build::position(&soil.axes, function))
                    };
                    soil.p[function] = first(&self.scene, in_two(&place));
                }
            }
            Some(pressures) => project(soil, &self.points, pressures, smooth).map_err(|e| unsolved(&e))?,
        }
        let y = soil.unknowns_of_fields();
        soil.evaluate_fields().map_err(|e| inverted(&self.points, e.point))?;
        self.content.clone_from(&soil.values.content);
        if self.seeding.law.soils.are_several() && smooth && carried.is_none() {
            self.first_content(soil);
        }
        self.y = y;
        Ok(())
    }

    /// Water content of the first pressures where these jump from layer to layer, which B-splines cannot: integrated
    /// as they are.
    fn first_content(&mut self, soil: &Soil<L, D>) {
        self.content.fill(0.0);
        for part in &soil.pore {
            let mut place = [0.0; D];
            for a in 0..part.soil.count {
                let stands = stands(&soil.axes, part.soil.number[a] as usize);
                (0..D).for_each(|d| place[d] += part.soil.value[a] * stands[d]);
            }
            let pressure = (self.seeding.first_pressure)(&self.scene, in_two(&place));
            let content = part.weight * part.porosity * pressure * soil.fluid.compressibility;
            for b in 0..part.water.count {
                self.content[part.water.number[b] as usize] += content * part.water.value[b];
            }
        }
    }

    /// The state of the mesh goes to the particles: stress, place, volume, velocity. Returns their pressures and the flux w of their
    /// water (m/s), that where it has an inertia of its own.
    fn carry(&mut self) -> Result<(Vec<f64>, Vec<[f64; D]>), Unsolved> {
        let Some(soil) = &mut self.soil else { return Ok(Default::default()) };
        soil.expand(&self.y);
        let large = self.scene.strain == StrainChoice::Large;
        let Some(soil) = &self.soil else { return Ok(Default::default()) };
        let fluxes = fluxes(soil)?;
        let pressures = self.points.iter().map(|point| self.pressure_at(soil, &point.x)).collect();
        for (i, point) in self.points.iter_mut().enumerate() {
            let part = &soil.solid[i];
            let Some(Strained { push, stress, state, .. }) = soil.strained(part) else { continue };
            self.states[i] = state;
            point.stress = turned(&stress, &push.rotation);
            if let Some(motion) = &soil.motion {
                point.v = part.stencil.vector(&motion.velocity);
            }
            let moved = part.stencil.vector(&soil.u);
            (0..D).for_each(|d| self.carried[i][d] += moved[d]);
            if large {
                let stretched = stretch(&part.stencil.gradient(&soil.u));
                point.volume *= stretched.map_or(1.0, |s| s.volume);
                (0..D).for_each(|d| point.x[d] += moved[d]);
            }
        }
        if !large {
            for (spent, part) in self.spent.iter_mut().zip(&soil.pore) {
                *spent += soil.pore_state(part).map_or(0.0, |state| state.change);
            }
        }
        self.settled += self.settlement_of(&self.y) + self.settled_with_plates();
        Ok((pressures, fluxes))
    }

    /// Velocities of a new mesh, from those of the particles or from the scene.
    fn set_in_motion(&self, soil: &mut Soil<L, D>, fluxes: Option<Vec<[f64; D]>>) -> Result<(), Unsolved> {
        let Some(mut motion) = soil.motion.take() else { return Ok(()) };
        let points: Vec<_> = soil.solid.iter().map(|part| (part.stencil, part.weight)).collect();
        match fluxes {
            None => {
                let start = self.scene.start_velocity.unwrap_or_default();
                motion.velocity.fill(array_of(|d| start[d + 2 - D]));
            }
            Some(fluxes) => {
                let velocities: Vec<[f64; D]> = self.points.iter().map(|point| point.v).collect();
                motion.velocity = projected(soil.u.len(), &points, &velocities)?;
                if motion.inertia == WaterInertia::Own {
                    let field = projected(soil.p.len(), &points, &fluxes)?;
                    for (flux, part) in motion.flux.iter_mut().zip(&soil.pore) {
                        *flux = part.water.vector(&field);
                    }
                }
            }
        }
        for (velocity, map) in motion.velocity.iter_mut().zip(&soil.soil_map) {
            (0..D).filter(|d| map[*d] == HELD).for_each(|d| velocity[d] = 0.0);
        }
        soil.motion = Some(motion);
        Ok(())
    }

    /// Whether the surface stays flat, so that a new mesh finds its outline.
    pub(super) fn flat(&self) -> bool {
        let held = |side: usize| self.sides[side] != SolidSide::Free;
        D == 1 || (held(0) && held(1) && self.scene.surcharge.is_none_or(|s| s.strip.is_none()))
    }
}

/// Flux w of the water at the particles (m/s), from that at the pore points.
fn fluxes<L: Law, const D: usize>(soil: &Soil<L, D>) -> Result<Vec<[f64; D]>, Unsolved> {
    let Some(motion) = soil.motion.as_ref().filter(|motion| motion.inertia == WaterInertia::Own) else {
        return Ok(Vec::new());
    };
    let stencils: Vec<_> = soil.pore.iter().map(|part| (part.water, part.weight)).collect();
    let spatial = |(part, flux): (&PorePart<D>, &[f64; D])| {
        soil.pore_state(part).map_or([0.0; D], |state| {
            map_of(&forward(&state, soil.small, flux), |w| w / if soil.small { 1.0 } else { 1.0 + state.change })
        })
    };
    let values: Vec<[f64; D]> = soil.pore.iter().zip(&motion.flux).map(spatial).collect();
    let field = projected(soil.p.len(), &stencils, &values)?;
    Ok(soil.solid.iter().map(|part| part.stencil.vector(&field)).collect())
}

/// Fields of so many functions from values at points with weights: least squares.
fn projected<const D: usize>(
    size: usize,
    points: &[(Stencil<D>, f64)],
    values: &[[f64; D]],
) -> Result<Vec<[f64; D]>, Unsolved> {
    let pairs = points.iter().flat_map(|(stencil, _)| {
        let numbers = &stencil.number[..stencil.count];
        numbers.iter().flat_map(|a| numbers.iter().map(|b| (*a as usize, *b as usize)))
    });
    let mut mass = Sparse::symmetric(size, pairs);
    let mut rhs = vec![vec![0.0; size]; D];
    for ((s, weight), value) in points.iter().zip(values) {
        for a in 0..s.count {
            (0..D).for_each(|d| rhs[d][s.number[a] as usize] += weight * s.value[a] * value[d]);
            for b in 0..=a {
                mass.add(s.number[a] as usize, s.number[b] as usize, weight * s.value[a] * s.value[b]);
            }
        }
    }
    let mut factor = Factor::new(&mass, Signs::Definite, Ordering::MinimumDegree)?;
    factor.refresh(&mass)?;
    let (mut field, mut found) = (vec![[0.0; D]; size], vec![0.0; size]);
    for d in 0..D {
        factor.solve(&mass, &rhs[d], &mut found)?;
        field.iter_mut().zip(&found).for_each(|(field, found)| field[d] = *found);
    }
    Ok(field)
}

/// Pressures of the functions from those of particles: weighted least squares, or the mean of a cell.
pub(super) fn project<L: Law, const D: usize>(
    soil: &mut Soil<L, D>,
    points: &[SolidPoint<D>],
    pressures: &[f64],
    smooth: bool,
) -> Result<(), Unsolved> {
    let size = soil.p.len();
    if size == 0 {
        return Ok(());
    }
    if !smooth {
        let mut rhs = vec![0.0; size];
        let mut volume = vec![0.0; size];
        for (point, pressure) in points.iter().zip(pressures) {
            let cell = build::number(&soil.axes, &build::cell_of(&soil.axes, &point.x));
            rhs[cell] += point.volume * pressure;
            volume[cell] += point.volume;
        }
        for cell in 0..size {
            soil.p[cell] = if volume[cell] > 0.0 { rhs[cell] / volume[cell] } else { 0.0 };
        }
        return Ok(());
    }
    let stencils: Vec<_> = soil.solid.iter().map(|part| (part.stencil, part.weight)).collect();
    let values: Vec<[f64; D]> = pressures.iter().map(|pressure| [*pressure; D]).collect();
    let field = projected(size, &stencils, &values)?;
    soil.p.iter_mut().zip(&field).for_each(|(p, field)| *p = field[0]);
    Ok(())
}

//! Results of a quasi-static state: settlement, profiles, balances.

use super::build::smooth;
use super::krylov::Meaning;
use super::motion::{WaterInertia, forward};
use super::soil::{InsideOut, Soil};
use super::{Method, QuasiStatic, build};
use crate::constitutive::Law;
use crate::dimension::in_two;
use crate::observe::{CellValues, FieldPoint, Observation, SolidState, checkerboard, profile};
use crate::particles::SolidPoint;
use crate::real::{array_of, map_of};
use crate::scene::Integrator;
use crate::space::{Stencil, turned};
use crate::water::stored_energy;

impl<L: Law, const D: usize> QuasiStatic<L, D> {
    /// The state now.
    pub(super) fn look(&self, cells: &[CellValues<D>]) -> Observation {
        let volume: f64 = cells.iter().map(|c| c.volume).sum();
        let rows = profile(cells);
        Observation {
            time: self.time,
            settlement: self.settlement(),
            mean_pressure: cells.iter().map(|c| c.volume * c.pressure).sum::<f64>() / volume,
            base_pressure: self.base_pressure(rows.first().map_or(0.0, |row| row.pressure_pa)),
            max_speed: self.max_speed(),
            centre: self.centre(),
            reach: self.sites.reach,
            least_volume: cells.iter().map(|c| c.volume).fold(f64::INFINITY, f64::min),
            soil_volume: volume,
            checkerboard: checkerboard(cells),
            solid_crossings: self.crossings(),
            water_crossings: 0,
            profile: rows,
            field: self.field(cells),
            water: None,
            plates: self.pushes.clone(),
        }
    }

    /// The particles where they are, with their stresses.
    pub(super) fn points_now(&self) -> Vec<SolidPoint<D>> {
        let mut points = self.points.clone();
        for (i, point) in points.iter_mut().enumerate() {
            let moved = self.moved(i);
            (0..D).for_each(|d| point.x[d] += moved[d]);
            point.v = self.velocity(i);
            if let Some(state) = self.soil.as_ref().and_then(|soil| soil.strained(&soil.solid[i])) {
                point.stress = turned(&state.stress, &state.push.rotation);
            }
        }
        points
    }

    /// Pore pressure at the base (Pa), where smooth functions know it; else that of the lowest row of cells.
    fn base_pressure(&self, of_row: f64) -> f64 {
        let Some(soil) = self.soil.as_ref().filter(|soil| smooth(self.scene.shape) && !soil.p.is_empty()) else {
            return of_row;
        };
        let weights = &self.sites.along;
        let sum: f64 = weights.iter().zip(&soil.p).map(|(weight, p)| weight * p).sum();
        sum / weights.iter().sum::<f64>()
    }

    /// Velocity of a particle, m/s; none without inertia.
    pub(super) fn velocity(&self, point: usize) -> [f64; D] {
        let moving = |soil: &Soil<L, D>| Some(soil.solid[point].stencil.vector(&soil.motion.as_ref()?.velocity));
        self.soil.as_ref().and_then(moving).unwrap_or([0.0; D])
    }

    fn max_speed(&self) -> f64 {
        if self.scene.integrator == Integrator::QuasiStatic {
            return 0.0;
        }
        let speed = |i: usize| self.velocity(i).iter().map(|v| v * v).sum::<f64>().sqrt();
        (0..self.points.len()).map(speed).fold(0.0, f64::max)
    }

    /// Pore pressure where a particle stood when the mesh was built, Pa.
    pub(super) fn pressure_at(&self, soil: &Soil<L, D>, x: &[f64; D]) -> f64 {
        match smooth(self.scene.shape) {
            _ if soil.p.is_empty() => 0.0,
            true => Stencil::at(&soil.axes, x).scalar(&soil.p),
            false => soil.p[build::number(&soil.axes, &build::cell_of(&soil.axes, x))],
        }
    }

    /// Centre of mass of the soil, m: x (zero in a column) and y.
    fn centre(&self) -> [f64; 2] {
        let (mut mass, mut moment) = (0.0, [0.0; 2]);
        for (i, point) in self.points.iter().enumerate() {
            let u = self.moved(i);
            mass += point.mass;
            for d in 0..D {
                moment[d + 2 - D] += point.mass * (point.x[d] + u[d]);
            }
        }
        map_of(&moment, |m| m / mass)
    }

    /// Pressures over the plane.
    fn field(&self, cells: &[CellValues<D>]) -> Vec<FieldPoint> {
        let Some(soil) = self.soil.as_ref().filter(|_| D == 2 && self.scene.profiles) else { return Vec::new() };
        let across = |cell: usize| build::middle(&soil.axes, &build::position(&soil.axes, cell))[0];
        let point = |(cell, values): (usize, &CellValues<D>)| FieldPoint {
            x_m: across(cell),
            y_m: values.material_height,
            pressure_pa: values.pressure,
            saturation: 1.0,
            soil: 1.0,
        };
        cells.iter().enumerate().map(point).collect()
    }

    /// Particles that are no longer in the mesh cell where they started.
    fn crossings(&self) -> u64 {
        if self.soil.as_ref().is_none_or(|soil| soil.small) {
            return 0;
        }
        let cell = |x: f64| (x / self.scene.cell + self.scene.shift).floor();
        let moved = self.points.iter().zip(&self.carried).enumerate().filter(|(i, (point, carried))| {
            let u = self.moved(*i);
            (0..D).any(|d| cell(point.x[d] + u[d]) != cell(point.x[d] - carried[d]))
        });
        moved.count() as u64
    }

    /// Displacement of a particle since the mesh was built, m; small strain moves none.
    fn moved(&self, point: usize) -> [f64; D] {
        match &self.soil {
            Some(soil) if !soil.small => soil.solid[point].stencil.vector(&soil.u),
            _ => [0.0; D],
        }
    }

    /// The particles with all that pictures show of them. Before the first stage there is no mesh yet, and the scene says what they have.
    pub(super) fn states(&self) -> Vec<SolidState> {
        const UNKNOWN: f64 = f64::NAN;
        let (soil, scene) = (self.soil.as_ref(), &self.scene);
        let state = |(i, point): (usize, SolidPoint<D>)| {
            let since = soil.map_or([0.0; D], |soil| soil.solid[i].stencil.vector(&soil.u));
            SolidState {
                id: i as u32,
                x: in_two(&point.x),
                displacement: in_two(&array_of::<f64, D, _>(|d| self.carried[i][d] + since[d])),
                velocity: match scene.integrator {
                    Integrator::QuasiStatic => [UNKNOWN; 2],
                    _ if soil.is_none() => scene.start_velocity.unwrap_or_default(),
                    _ => in_two(&point.v),
                },
                stress: point.stress,
                pore_pressure: match soil {
                    _ if scene.water.is_none() => UNKNOWN,
                    None => (self.seeding.first_pressure)(scene, in_two(&point.x)),
                    Some(soil) => self.pressure_at(soil, &self.points[i].x),
                },
                deviator_strain: UNKNOWN,
                volume: point.volume,
                mass: point.mass,
            }
        };
        self.points_now().into_iter().enumerate().map(state).collect()
    }

    /// Every cell of the mesh: its soil and water.
    pub(super) fn cell_values(&self) -> Vec<CellValues<D>> {
        let Some(soil) = &self.soil else { return Vec::new() };
        let mut cells = self.sites.cells.clone();
        let smooth = smooth(self.scene.shape);
        let mut shift = vec![0.0; cells.len()];
        for (i, (part, cell)) in soil.solid.iter().zip(&self.sites.solid).enumerate() {
            let cell = *cell as usize;
            let Some((stress, vertical, stretch)) = soil.stressed(part) else { continue };
            let volume = part.weight * stretch;
            let values = &mut cells[cell];
            values.effective_stress += volume * vertical;
            let law = soil.law.law(part.mark);
            let energy = |stress: &[f64; 4]| if soil.small { law.energy(stress) } else { law.finite_energy(stress) };
            values.strain_energy += match soil.group_of(i) {
                None => volume * energy(&stress),
                // Energy is a square of stress: what two of them have in common.
                Some((first, shares)) => {
                    let common = |(j, share): (usize, &f64)| {
                        let other = soil.stressed(&soil.solid[first + j]).map_or(stress, |(other, ..)| other);
                        let both = array_of(|s| stress[s] + other[s]);
                        0.5 * share * stretch * (energy(&both) - energy(&stress) - energy(&other))
                    };
                    shares.iter().enumerate().map(common).sum()
                }
            };
            values.volume += volume;
            if !soil.small {
                shift[cell] += volume * self.carried[i][D - 1];
            }
        }
        for (cell, (values, here)) in cells.iter_mut().zip(&self.sites.middles).enumerate() {
            values.effective_stress /= values.volume;
            values.material_height = values.height - shift[cell] / values.volume;
            values.height += if soil.small { 0.0 } else { here.vector(&soil.u)[D - 1] };
            values.pressure = match (soil.p.is_empty(), smooth) {
                (true, _) => 0.0,
                (false, true) => here.scalar(&soil.p),
                (false, false) => soil.p[cell],
            };
        }
        self.moving(soil, &mut cells);
        let pores = soil.pore.iter().zip(&self.spent).zip(&self.sites.pore);
        for ((part, spent), cell) in pores.filter(|((part, _), _)| part.water.count > 0) {
            let Some(change) = soil.opened(part) else { continue };
            let cell = *cell as usize;
            let pressure = part.water.scalar(&soil.p);
            let pores = if soil.small { part.porosity } else { change + part.porosity };
            let fluid = &soil.fluid;
            // Pores change with the soil even where the geometry stays.
            let [alpha, of_grains] = soil.law.soils.kind(part.mark).biot;
            let stored = pores * soil.denser(pressure) + of_grains * pressure;
            let water = part.porosity + alpha * (spent + change) + stored;
            cells[cell].water_mass += part.weight * fluid.density * water;
            let energy = if soil.small {
                0.5 * pressure * pressure * fluid.compressibility
            } else {
                stored_energy(pressure, 1.0 / fluid.compressibility)
            };
            cells[cell].water_energy += part.weight * (pores * energy + 0.5 * of_grains * pressure * pressure);
        }
        for values in &mut cells {
            let ratio = values.mixture_ratio();
            values.kinetic /= ratio;
            values.momentum = map_of(&values.momentum, |momentum| momentum / ratio);
        }
        let of_jump = |(a, b, value): &(u32, u32, f64)| 0.5 * value * soil.p[*a as usize] * soil.p[*b as usize];
        cells[0].water_energy += soil.jumps.iter().map(of_jump).sum::<f64>();
        cells
    }

    /// Kinetic energy and momentum of soil and water, as a share of the soil (`mixture_ratio`).
    fn moving(&self, soil: &Soil<L, D>, cells: &mut [CellValues<D>]) {
        let Some(motion) = &soil.motion else { return };
        for (point, part) in soil.pore.iter().enumerate() {
            let Some(state) = soil.pore_state(part) else { continue };
            let pores = if soil.small { part.porosity } else { state.change + part.porosity };
            let (mass, v) = (part.weight * soil.mass_of(part, pores), part.soil.vector(&motion.velocity));
            let water = part.weight * soil.fluid.density;
            let (mut along, mut own) = ([0.0; D], 0.0);
            if motion.inertia == WaterInertia::Own {
                along = forward(&state, soil.small, &motion.flux[point]);
                own = 0.5 * along.iter().map(|w| w * w).sum::<f64>() / pores;
            }
            let values = &mut cells[self.sites.pore[point] as usize];
            for d in 0..D {
                values.kinetic += 0.5 * mass * v[d] * v[d] + water * along[d] * v[d];
                values.momentum[d] += mass * v[d] + water * along[d];
            }
            values.kinetic += water * own;
        }
    }

    /// Balances of a Krylov stage at its present time: of the unknowns now, and integrated over the stage.
    pub(super) fn book_krylov(&mut self, [now, so_far]: &[Meaning; 2]) -> Result<(), InsideOut<D>> {
        let (Some(soil), Some(Method::Krylov(stage))) = (&mut self.soil, &mut self.method) else { return Ok(()) };
        self.totals.water_out = stage.out_before + so_far.passed - (now.held - stage.held);
        self.totals.external_work = stage.work_before + now.work;
        self.totals.darcy_dissipation = stage.dissipation_before + stage.evolution.dissipation(self.stage_time);
        if self.stage_time < (1.0 - 1e-12) * self.stage_end {
            soil.expand(&self.y);
            return Ok(());
        }
        // A stage to come begins with the water that there is.
        soil.evaluate(&self.y)?;
        self.content.copy_from_slice(&soil.values.content);
        Ok(())
    }
}

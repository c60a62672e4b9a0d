//! What a run leaves: its history, its events, and the stresses at the observed places.

use serde::{Deserialize, Serialize};

use super::events::{First, Moved};
use super::scales::Scales;
use super::{Driver, Phase};
use crate::order::sort_by_number;
use crate::step::Failing;

/// On a coarse mesh the soil of the last cell tapers off, and its water comes no nearer to the toe than this share of a cell, however
/// much of it leaves.
const AT_TOE: f64 = 0.375;

/// When something happened first, h on the clock of the run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Events {
    /// Water reached the toe.
    pub front_at_toe_h: Option<f64>,
    /// Water left the slope.
    pub first_outflow_h: Option<f64>,
    /// Soil did not come to rest under the pressures of the moment.
    pub unsettled_h: Option<f64>,
    /// E1: raveling at the toe.
    pub raveling_h: Option<f64>,
    /// E2: failure.
    pub failure_h: Option<f64>,
    /// E3: collapse.
    pub collapse_h: Option<f64>,
    /// Mean x of the soil that had moved as far as E2 takes, m.
    pub failure_at_m: Option<f64>,
    /// Largest displacement before water reached the toe, m.
    pub displacement_before_toe_m: f64,
    /// Largest displacement before E2, m.
    pub displacement_before_failure_m: f64,
}

impl Events {
    /// Soil has not come to rest.
    pub fn unsettled(&mut self, hours: f64) {
        self.unsettled_h.get_or_insert(hours);
    }

    /// Takes note of a state; the toe (x in m, and its side) is that of the start, on a mesh with such cells (m).
    pub fn note(&mut self, row: &Row, moved: &Moved, [toe, side]: [f64; 2], scales: &Scales, cell: f64) {
        let hours = row.time_h;
        let first = |event: &mut Option<f64>, is: bool| {
            if is {
                event.get_or_insert(hours);
            }
        };
        let failed = self.failure_h.is_none();
        let [raveling, failure, collapse] = moved.events();
        let near = scales.at_toe().max(AT_TOE * cell);
        first(&mut self.front_at_toe_h, side * row.front_x_m >= side * toe - near);
        first(&mut self.first_outflow_h, row.water_out_m3 > scales.drops());
        first(&mut self.raveling_h, raveling);
        first(&mut self.failure_h, failure);
        first(&mut self.collapse_h, collapse);
        if self.front_at_toe_h.is_none() {
            self.displacement_before_toe_m = self.displacement_before_toe_m.max(moved.most_m);
        }
        if self.failure_h.is_none() {
            self.displacement_before_failure_m = self.displacement_before_failure_m.max(moved.most_m);
        } else if failed {
            self.failure_at_m = Some(moved.failed_at_m);
        }
    }
}

/// The state at one time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Time on the clock of the run, h.
    pub time_h: f64,
    /// What is going on.
    pub phase: Phase,
    /// x of the water in the lowest row of cells that is nearest to the toe, m.
    pub front_x_m: f64,
    /// x beyond which, on the side of the toe, a thousandth of the soil lies, m.
    pub toe_x_m: f64,
    /// Mean settlement of the crest, m.
    pub crest_settlement_m: f64,
    /// Largest displacement, m.
    pub max_displacement_m: f64,
    /// Shares of the section that have moved as far as E1, deep soil that has as far as E2, soil that has as far as E3 takes.
    pub raveled: f64,
    /// See `raveled`.
    pub failed: f64,
    /// See `raveled`.
    pub collapsed: f64,
    /// Largest deviator strain.
    pub deviator_strain: f64,
    /// Fastest particle, m/s.
    pub speed_m_s: f64,
    /// Unbalanced share of the forces on the nodes.
    pub unbalanced: f64,
    /// Mobile water in the soil, m3.
    pub water_m3: f64,
    /// Water that has come in since the start, m3.
    pub water_in_m3: f64,
    /// Water that has left since the start, m3.
    pub water_out_m3: f64,
    /// Stored - first stored - in + out, m3.
    #[serde(alias = "water_closing_m3")]
    pub water_residual_m3: f64,
    /// Change of the dry mass, kg.
    #[serde(alias = "solid_closing_kg")]
    pub solid_residual_kg: f64,
    /// Kinetic energy, J.
    pub kinetic_j: f64,
    /// Strain energy of the skeleton, J.
    pub strain_j: f64,
    /// Work of gravity, J.
    pub gravity_work_j: f64,
    /// Work of the pore pressures on the soil, J.
    pub pressure_work_j: f64,
    /// Energy lost to plastic flow, J.
    pub plastic_j: f64,
    /// Energy lost to friction on the base, J.
    pub friction_j: f64,
    /// Energy taken by damping while soil came to rest, J.
    pub damping_j: f64,
    /// Energy that particles did not get from the nodes or lost to them, J.
    pub mapping_j: f64,
    /// What no entry explains, J.
    #[serde(alias = "energy_closing_j")]
    pub energy_residual_j: f64,
    /// The same as a share of the largest work, loss or kinetic energy recorded so far. Works change their sign: soil rises and settles.
    pub energy_error: f64,
    /// How far any stress was outside the yield surface so far, as a share of the strength.
    pub yield_residual: f64,
    /// Checkerboard index of the pore pressure.
    pub checkerboard: f64,
    /// Share of the motion in hourglass modes.
    pub hourglass: f64,
    /// Particles of water.
    pub water_particles: u64,
    /// Steps so far.
    pub steps: u64,
    /// Height of the free surface at the places of the scene, m.
    #[serde(skip)]
    pub levels: Vec<f64>,
}

impl Row {
    pub(super) fn of(driver: &Driver, moved: &Moved) -> Self {
        let model = driver.model.as_ref();
        let (state, balance) = model.observe();
        let water = state.water.unwrap_or_default();
        let [checkerboard, hourglass] = model.unevenness();
        let (mapping_j, energy_residual_j) = (balance.transfer_loss_j, balance.energy_residual_j);
        let first_water = driver.first_water();
        let row = Self {
            time_h: driver.hours(),
            phase: driver.phase,
            front_x_m: model.front(super::towards(&driver.outline)),
            toe_x_m: moved.toe_x_m,
            crest_settlement_m: moved.crest_settlement_m,
            max_displacement_m: moved.most_m,
            raveled: moved.raveled,
            failed: moved.failed,
            collapsed: moved.collapsed,
            deviator_strain: moved.deviator_strain,
            speed_m_s: moved.speed_m_s,
            unbalanced: model.unbalanced(),
            water_m3: water.mobile_m3,
            water_in_m3: water.in_m3,
            water_out_m3: water.out_m3,
            water_residual_m3: water.mobile_m3 - first_water - water.in_m3 + water.out_m3,
            solid_residual_kg: balance.solid_residual_kg,
            kinetic_j: balance.kinetic_j,
            strain_j: balance.strain_j,
            gravity_work_j: balance.gravity_work_j,
            pressure_work_j: balance.pressure_work_j,
            plastic_j: balance.plastic_dissipation_j,
            friction_j: balance.base_friction_j,
            damping_j: balance.damping_loss_j,
            mapping_j,
            energy_residual_j,
            energy_error: 0.0,
            yield_residual: balance.yield_residual_max.unwrap_or(0.0),
            checkerboard,
            hourglass,
            water_particles: water.particles,
            steps: driver.steps.all(),
            levels: driver.failure.levels.iter().map(|x| model.level(*x)).collect(),
        };
        let largest = driver.rows.iter().map(Self::largest_energy).fold(row.largest_energy(), f64::max);
        Self { energy_error: if largest > 0.0 { energy_residual_j.abs() / largest } else { 0.0 }, ..row }
    }

    /// The largest of the works and losses and the kinetic energy, J.
    fn largest_energy(&self) -> f64 {
        let all = [
            self.gravity_work_j,
            self.pressure_work_j,
            self.plastic_j,
            self.friction_j,
            self.damping_j,
            self.kinetic_j,
        ];
        all.iter().fold(0.0, |most: f64, part| most.max(part.abs()))
    }
}

/// The effective stress of an observed particle at one time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PathPoint {
    /// Time on the clock of the run, h.
    pub time_h: f64,
    /// Which of the observed places, from 1.
    pub point: u32,
    /// Where it is, m.
    pub x_m: f64,
    /// Its height, m.
    pub y_m: f64,
    /// -(xx + yy)/2, compression positive, Pa.
    pub mean_pa: f64,
    /// Radius of Mohr's circle in the plane, Pa.
    pub shear_pa: f64,
    /// Pore pressure, Pa.
    pub pore_pa: f64,
}

/// Records the observed places.
pub(super) fn paths(model: &dyn Failing, first: &First, hours: f64, into: &mut Vec<PathPoint>) {
    if first.points.is_empty() {
        return;
    }
    let start = into.len();
    model.each(&mut |s| {
        for (point, _) in first.points.iter().enumerate().filter(|(_, id)| **id == s.id) {
            let [xx, yy, _, xy] = s.stress;
            into.push(PathPoint {
                time_h: hours,
                point: point as u32 + 1,
                x_m: s.x[0],
                y_m: s.x[1],
                mean_pa: -0.5 * (xx + yy),
                shear_pa: (0.5 * (xx - yy)).hypot(xy),
                pore_pa: s.pore_pressure,
            });
        }
    });
    sort_by_number(&mut into[start..], |p| p.point.into());
}

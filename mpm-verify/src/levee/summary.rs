//! What a run came to, in numbers: `summary.json`.

use mpm_core::failure::{Row, towards};
use serde::{Deserialize, Serialize};

use super::limits::Trust;
use super::operators::{self, Numbers};
use super::plan::{Plan, driver_word};
use super::run::Followed;
use crate::manifest::Manifest;

/// The summary. A number that there is not is `null`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// E2: when the failure starts, h on the clock of the run.
    pub failure_start_h: Option<f64>,
    /// E3: when the rapid failure starts, h.
    pub rapid_failure_h: Option<f64>,
    /// When the run ended, h.
    pub end_h: Option<f64>,
    /// x beyond which a thousandth of the soil lies at the end, m.
    pub toe_x_m: Option<f64>,
    /// Mean settlement of the crest at the end, m.
    pub crest_settlement_m: Option<f64>,
    /// Largest displacement before water reached the toe, m.
    pub max_displacement_before_failure_m: Option<f64>,
    /// Largest displacement before E2, m.
    pub displacement_before_failure_m: Option<f64>,
    /// When water reached the toe, h.
    pub front_at_toe_h: Option<f64>,
    /// When water left the slope, h.
    pub first_outflow_h: Option<f64>,
    /// E1: when the toe failed, h.
    pub raveling_h: Option<f64>,
    /// When soil first did not come to rest, h.
    pub unsettled_h: Option<f64>,
    /// Mean x of the soil that had moved at E2, m.
    pub failure_at_m: Option<f64>,
    /// From E2 to the end, s.
    pub failure_lasts_s: Option<f64>,
    /// From E3 to the end, s.
    pub rapid_failure_lasts_s: Option<f64>,
    /// Largest deviator strain.
    pub max_deviator_strain: Option<f64>,
    /// How far any stress was outside the yield surface, as a share of the strength.
    pub yield_residual_max: Option<f64>,
    /// Largest checkerboard index of the pore pressure.
    pub checkerboard_index_max: Option<f64>,
    /// Checkerboard index of the steady pore pressure with a point source under the paper's nodal operator, on the full
    /// cells of the last frame before failure.
    pub checkerboard_nodal_operator: Option<f64>,
    /// The same under the operator of the run, through faces.
    pub checkerboard_face_operator: Option<f64>,
    /// All that was found about both operators there.
    pub operators: Option<Numbers>,
    /// Largest share of the motion in hourglass modes.
    pub hourglass_ratio_max: Option<f64>,
    /// Largest change of the dry mass, as a share of it.
    pub solid_mass_error: Option<f64>,
    /// Largest residual of the water balance, as a share of what was there at the start.
    pub water_ledger_error: Option<f64>,
    /// Largest residual of the energy balance, as a share of the works and losses booked.
    pub energy_error: Option<f64>,
    /// All steps.
    pub steps: u64,
    /// Steps of the water.
    pub steps_seepage: u64,
    /// Steps of soil that comes to rest.
    pub steps_relaxing: u64,
    /// Steps of soil that moves.
    pub steps_moving: u64,
    /// CPU time, s.
    pub cpu_s: f64,
    /// How it ended: `collapsed`, `time-over`, `stopped`, `does-not-stand`, `run-failed`.
    pub ended: String,
    /// What went wrong, if something did.
    pub trouble: Option<String>,
    /// Name of the scene.
    pub scene: String,
    /// Who drove.
    pub driver: String,
    /// Name of the variant, if it was one.
    pub variant: Option<String>,
    /// Edge of a cell, m.
    pub mesh_m: f64,
    /// Particles per cell.
    pub ppc: usize,
    /// Step of the soil, s.
    pub dt_s: f64,
    /// Particles of the soil.
    pub solid_particles: usize,
    /// Particles of the water at the start.
    pub water_particles: usize,
    /// Frames taken.
    pub frames: usize,
    /// What soil that water does not yet reach may move at most: the elastic displacement under all that water can add, m.
    pub displacement_allowed_m: f64,
    /// Whether its balances are met.
    pub trust: Option<Trust>,
    /// Under which conditions.
    pub manifest: Manifest,
    /// How far the toe has moved at the end, m: from the place at which the toe of the particles was measured at the start.
    #[serde(default)]
    pub runout_m: Option<f64>,
}

impl Summary {
    /// The summary of a run.
    pub fn of(plan: &Plan, run: &Followed, variant: Option<&str>, manifest: Manifest) -> Self {
        let (events, rows) = (&run.events, &run.rows);
        let last = rows.last();
        let most = |of: fn(&Row) -> f64| {
            let values = rows.iter().map(of).filter(|v| v.is_finite());
            values.fold(None, |most: Option<f64>, v| Some(most.map_or(v, |m| m.max(v))))
        };
        let water = rows.first().zip(last).map(|(first, last)| first.water_m3.max(last.water_in_m3));
        let share = |gap: Option<f64>, whole: f64| gap.filter(|_| whole > 0.0).map(|gap| gap / whole);
        let end_h = last.map(|r| r.time_h);
        let lasts = |from: Option<f64>| from.zip(end_h).map(|(from, end)| 3600.0 * (end - from));
        let operators = operators::of(&plan.scene, run).map(|compared| compared.numbers);
        let there = |value: f64| last.map(|_| value);
        let side = towards(&plan.scene.outline_or_box());
        Self {
            failure_start_h: events.failure_h,
            rapid_failure_h: events.collapse_h,
            end_h,
            toe_x_m: last.map(|r| r.toe_x_m),
            crest_settlement_m: last.map(|r| r.crest_settlement_m),
            max_displacement_before_failure_m: there(events.displacement_before_toe_m),
            displacement_before_failure_m: there(events.displacement_before_failure_m),
            front_at_toe_h: events.front_at_toe_h,
            first_outflow_h: events.first_outflow_h,
            raveling_h: events.raveling_h,
            unsettled_h: events.unsettled_h,
            failure_at_m: events.failure_at_m,
            failure_lasts_s: lasts(events.failure_h),
            rapid_failure_lasts_s: lasts(events.collapse_h),
            max_deviator_strain: most(|r| r.deviator_strain),
            yield_residual_max: most(|r| r.yield_residual),
            checkerboard_index_max: most(|r| r.checkerboard),
            checkerboard_nodal_operator: operators.as_ref().map(|o| o.index_with_source[1]),
            checkerboard_face_operator: operators.as_ref().map(|o| o.index_with_source[0]),
            operators,
            hourglass_ratio_max: most(|r| r.hourglass),
            solid_mass_error: share(most(|r| r.solid_residual_kg.abs()), run.mass_kg),
            // A slope without any water has lost none.
            water_ledger_error: match water {
                Some(0.0) => most(|r| r.water_residual_m3.abs()),
                _ => share(most(|r| r.water_residual_m3.abs()), water.unwrap_or(0.0)),
            },
            energy_error: most(|r| r.energy_error),
            steps: run.steps.all(),
            steps_seepage: run.steps.seepage,
            steps_relaxing: run.steps.relaxing,
            steps_moving: run.steps.moving,
            cpu_s: run.cpu_s,
            ended: run.ended.words().to_owned(),
            trouble: run.ended.trouble().map(str::to_owned),
            scene: plan.scene.name.clone(),
            driver: driver_word(plan.scene.integrator).to_owned(),
            variant: variant.map(str::to_owned),
            mesh_m: plan.scene.cell,
            ppc: plan.scene.particles_per_cell,
            dt_s: run.dt_s,
            solid_particles: run.particles[0],
            water_particles: run.particles[1],
            frames: run.shots.len(),
            displacement_allowed_m: plan.scales().elastic,
            trust: Trust::of(rows, run.mass_kg, water.unwrap_or(0.0)),
            manifest,
            runout_m: rows.first().zip(last).map(|(first, last)| side * (last.toe_x_m - first.toe_x_m)),
        }
    }

    /// The main numbers, for a terminal; neither the mesh nor the assumptions carry more digits.
    pub fn lines(&self) -> Vec<String> {
        let hours = |time: Option<f64>| time.map_or_else(|| "did not happen".to_owned(), |h| format!("{h:.1} h"));
        let metres =
            |x: Option<f64>, decimals| x.map_or_else(|| "none".to_owned(), |x: f64| format!("{x:.decimals$} m"));
        vec![
            format!("water reaches the toe    {}", hours(self.front_at_toe_h)),
            format!("first outflow            {}", hours(self.first_outflow_h)),
            format!("toe fails (E1)           {}", hours(self.raveling_h)),
            format!("failure starts (E2)      {}", hours(self.failure_start_h)),
            format!("rapid failure (E3)       {}", hours(self.rapid_failure_h)),
            format!("end                      {}, {}", hours(self.end_h), self.ended.replace('-', " ")),
            format!("run-out of the toe       {}", metres(self.runout_m, 1)),
            format!("settlement of the crest  {}", metres(self.crest_settlement_m, 2)),
            "one mesh; the page shows ranges over meshes and assumptions where they were computed".to_owned(),
        ]
    }
}

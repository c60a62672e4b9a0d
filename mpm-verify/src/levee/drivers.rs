//! The drivers side by side: from a common state shortly before failure, what each predicts and what its steps cost.
//!
//! The staggered integrator runs to a time before the failure; from there each driver goes on by itself until the soil rests. The cost of a whole
//! run by the paper's explicit step is that of its own steps here times the number a whole run takes: extrapolated, not run.

use cpu_time::ThreadTime;
use mpm_core::failure::Driver;
use mpm_core::scene::{Fields, Integrator};
use mpm_core::stability::stable_limit;
use serde::{Deserialize, Serialize};

use super::plan::{Plan, driver_word};
use super::tables::OfScene;
use crate::error::Error::{self, Unfit};
use crate::report::content::table::{Cell, Table, table};
use crate::report::numbers::short;

/// Name of the table in the folder of a run.
pub const NAME: &str = "drivers.csv";
/// The paper's time increment for the levee (Table 3), s.
const PAPER_STEP: f64 = 1.0e-4;
/// Share of the limit that it keeps to on finer meshes.
const SAFETY: f64 = 0.5;
/// The common state is so long before the failure that the staggered integrator finds, h.
const BEFORE: f64 = 0.01;
/// A driver that has not seen failure so long after is given up, h.
const AFTER: f64 = 0.2;

/// What a driver came to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Its word.
    pub driver: String,
    /// Time of the common state, h.
    pub from_h: f64,
    /// Step of the soil, s.
    pub dt_s: f64,
    /// E2, h.
    pub failure_start_h: Option<f64>,
    /// E3, h.
    pub rapid_failure_h: Option<f64>,
    /// Toe at the end, m.
    pub toe_x_m: f64,
    /// Settlement of the crest at the end, m.
    pub crest_settlement_m: f64,
    /// Steps of soil and water from the common state on.
    pub steps: u64,
    /// CPU time of these, s.
    pub cpu_s: f64,
    /// CPU time of a step, s.
    pub cpu_per_step_s: f64,
    /// CPU time from the start of the scene to the end, s: measured for the staggered integrator, steps times cost of a step for the others.
    pub whole_cpu_s: f64,
    /// That over the one of the staggered integrator.
    #[serde(alias = "times_two_clocks")]
    pub times_staggered: f64,
    /// Why it ended early, if it did.
    pub trouble: String,
    /// Of which scene: [`Plan::scene_word`].
    pub scene: String,
}

impl OfScene for Line {
    fn scene(&self) -> &str {
        &self.scene
    }
}

/// Runs the drivers one after the other.
///
/// # Errors
/// A scene that does not stand or does not fail, or what went wrong before the common state.
pub fn compute(plan: &Plan, tell: &mut dyn FnMut(&str)) -> Result<Vec<Line>, Error> {
    let scene = plan.scene.edited(|s| s.integrator = Integrator::Staggered)?;
    let mut driver = Driver::new(&scene)?;
    let clock = ThreadTime::now();
    driver.load()?;
    if driver.rows.is_empty() {
        return Err(Unfit("the levee does not stand before water seeps: there is no state to compare drivers from"));
    }
    while driver.end.is_none() {
        driver.advance(f64::INFINITY)?;
    }
    let whole = clock.elapsed().as_secs_f64();
    let Some(first) = driver.events.unsettled_h.or(driver.events.failure_h) else {
        let hours = driver.hours();
        return Err(Error::Found(format!("the levee has not failed at {hours:.2} h: there is no failure to compare")));
    };
    let ended = driver.time;
    tell(&format!("staggered: soil moves from {first:.4} h"));
    let from_h = first - BEFORE;
    let mut driver = Driver::new(&scene)?;
    driver.load()?;
    let from = plan.seconds(from_h);
    while driver.time < from {
        driver.advance(from)?;
    }
    let state = driver.checkpoint();
    let mut lines = Vec::new();
    for integrator in [Integrator::Staggered, Integrator::Coupled, Integrator::Explicit] {
        driver.restore(&state)?;
        let dt = if integrator == Integrator::Explicit {
            let own = SAFETY * stable_limit(&Fields { integrator, ..Fields::clone(&scene) });
            if plan.papers() { PAPER_STEP.min(own) } else { own }
        } else {
            driver.dt
        };
        driver.drive_by(integrator, dt);
        lines.push(one(&mut driver, integrator, plan.seconds(from_h + AFTER), from_h));
        let line = &lines[lines.len() - 1];
        tell(&format!("{}: failure at {:?} h, {:.1} s", line.driver, line.failure_start_h, line.cpu_s));
    }
    for line in &mut lines {
        let two = line.driver == driver_word(Integrator::Staggered);
        line.whole_cpu_s = if two { whole } else { ended / line.dt_s * line.cpu_per_step_s };
        line.times_staggered = line.whole_cpu_s / whole;
        line.scene = plan.scene_word();
    }
    Ok(lines)
}

fn one(driver: &mut Driver, integrator: Integrator, until: f64, from_h: f64) -> Line {
    let (clock, first) = (ThreadTime::now(), driver.steps.all());
    let mut trouble = String::new();
    while driver.end.is_none() && driver.time < until {
        if let Err(e) = driver.advance(f64::INFINITY) {
            trouble = e.to_string();
            break;
        }
    }
    let (cpu_s, steps) = (clock.elapsed().as_secs_f64(), driver.steps.all() - first);
    let last = driver.rows.last();
    Line {
        driver: driver_word(integrator).to_owned(),
        from_h,
        dt_s: driver.dt,
        failure_start_h: driver.events.failure_h,
        rapid_failure_h: driver.events.collapse_h,
        toe_x_m: last.map_or(f64::NAN, |row| row.toe_x_m),
        crest_settlement_m: last.map_or(f64::NAN, |row| row.crest_settlement_m),
        steps,
        cpu_s,
        cpu_per_step_s: cpu_s / steps.max(1) as f64,
        whole_cpu_s: 0.0,
        times_staggered: 0.0,
        trouble,
        scene: String::new(),
    }
}

/// A table for the page.
pub fn shown(lines: &[Line]) -> Table {
    let head =
        ["driver", "failure (h)", "rapid (h)", "toe (m)", "crest (m)", "per step (µs)", "whole run (s)", "times"];
    let hours = |time: Option<f64>| time.map_or_else(|| "–".to_owned(), |h| format!("{h:.1}"));
    let row = |l: &Line| {
        vec![
            Cell::new(l.driver.clone()).marked(format!("steps of {} s", short(l.dt_s, 3)), ""),
            Cell::new(hours(l.failure_start_h)),
            Cell::new(hours(l.rapid_failure_h)),
            Cell::new(short(l.toe_x_m, 3)),
            Cell::new(short(l.crest_settlement_m, 2)),
            Cell::new(short(1e6 * l.cpu_per_step_s, 3)),
            Cell::new(short(l.whole_cpu_s, 3)),
            Cell::new(short(l.times_staggered, 3)),
        ]
    };
    let from = lines.first().map_or(0.0, |l| l.from_h);
    let note = format!(
        "From a common state at {} h, {} h before the soil moves with the staggered integrator. CPU time; that of a whole run is measured for \
         the staggered integrator, and for the others the cost of a step here times the steps of a whole run: extrapolated.",
        short(from, 4),
        BEFORE
    );
    table("Drivers".to_owned(), &head, lines.iter().map(row).collect(), &note)
}

//! The factor of safety over time: strength reduction on the state of a run, beside limit equilibrium with its water.
//!
//! Water seeps to a time in soil that is held, whether or not it would stand; then the strength is divided by factors until the
//! deep slide starts; the state is as before afterwards, and water goes on from it to the next time.

use std::path::Path;

use mpm_core::failure::{Bracket as Found, Driver};
use serde::{Deserialize, Serialize};

use super::equilibrium::{self, Factors};
use super::figures::{Picture, events};
use super::plan::Plan;
use super::tables::OfScene;
use crate::error::Error::{self, Unfit};
use crate::report::ReportError;
use crate::report::content::table::{Cell, Table, table};
use crate::report::numbers::brief;
use crate::report::plots::levee::safety::{self as plot, Bracket, Safety};

/// Name of the table in the folder of a run.
pub const NAME: &str = "safety_factor.csv";
/// Width of the bracket.
const WITHIN: f64 = 0.01;

/// The factors at one time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Time on the clock of the run, h.
    pub time_h: f64,
    /// It stands with its strength divided by this; not a number where none was found.
    pub fs_low: f64,
    /// It slides with its strength divided by this.
    pub fs_high: f64,
    /// Of the infinite slope with water that leaves it horizontally; from when water is at the toe.
    pub infinite_slope: Option<f64>,
    /// The same with Davis' reduced strength.
    pub infinite_slope_davis: Option<f64>,
    /// By Bishop's method.
    pub bishop: Option<f64>,
    /// The same with Davis' reduced strength.
    pub bishop_davis: Option<f64>,
    /// By Spencer's method.
    pub spencer: Option<f64>,
    /// The same with Davis' reduced strength.
    pub spencer_davis: Option<f64>,
    /// Trials.
    pub trials: u32,
    /// Steps of all trials.
    pub steps: u64,
    /// Of which scene: [`Plan::scene_word`].
    pub scene: String,
    /// Least and largest factor between the two at which a trial neither came to rest nor slid.
    #[serde(default)]
    pub undecided_low: Option<f64>,
    /// See `undecided_low`.
    #[serde(default)]
    pub undecided_high: Option<f64>,
    /// Why limit equilibrium has no factors, where it has none.
    #[serde(default)]
    pub no_limit_equilibrium: String,
    /// Levels of the water at the places of the scene, m; not in the table.
    #[serde(skip)]
    pub levels_m: Vec<f64>,
}

impl OfScene for Line {
    fn scene(&self) -> &str {
        &self.scene
    }
}

/// Factors at some times (h), in their order in time.
///
/// # Errors
/// What was expected of a time and found, or what went wrong in a step.
pub fn compute(plan: &Plan, times_h: &[f64], progress: &mut dyn FnMut(&str)) -> Result<Vec<Line>, Error> {
    let mut times = times_h.to_vec();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let mut driver = Driver::new(&plan.scene)?;
    driver.load()?;
    let mut lines = Vec::new();
    for time in times {
        driver.seep_only(plan.seconds(time))?;
        let Some(row) = driver.rows.last().cloned() else {
            return Err(Unfit("the slope does not stand before water seeps: it has no factor of safety"));
        };
        let (factors, why) = match equilibrium::factors(&plan.scene, &row, &driver.surface()) {
            Ok(factors) => (factors, String::new()),
            Err(why) => ([Factors::default(); 2], why.to_string()),
        };
        let mut tell = |b: &Found| progress(&format!("{time} h: between {:.3} and {:.3}", b.low, b.high));
        let found = driver.safety(WITHIN, &mut tell)?;
        lines.push(Line {
            scene: plan.scene_word(),
            levels_m: row.levels.clone(),
            no_limit_equilibrium: why,
            ..line(time, &found, factors)
        });
    }
    Ok(lines)
}

fn line(time_h: f64, found: &Found, factors: [Factors; 2]) -> Line {
    let [full, davis] = factors;
    Line {
        time_h,
        fs_low: found.low,
        fs_high: found.high,
        infinite_slope: full.infinite_slope,
        infinite_slope_davis: davis.infinite_slope,
        bishop: full.bishop,
        bishop_davis: davis.bishop,
        spencer: full.spencer,
        spencer_davis: davis.spencer,
        trials: found.trials,
        steps: found.steps,
        undecided_low: found.undecided.map(|[low, _]| low),
        undecided_high: found.undecided.map(|[_, high]| high),
        no_limit_equilibrium: String::new(),
        scene: String::new(),
        levels_m: Vec::new(),
    }
}

impl Line {
    /// In one sentence, with what is missing and why.
    pub fn said(&self) -> String {
        let undecided = self.undecided_low.zip(self.undecided_high).map_or_else(String::new, |(low, high)| {
            format!("; from {low:.3} to {high:.3} trials neither came to rest nor slid: undecided")
        });
        let slices = match self.no_limit_equilibrium.as_str() {
            "" => String::new(),
            why => format!("; no limit equilibrium beside it: {why}"),
        };
        format!("factor of safety at {} h: {:.3} to {:.3}{undecided}{slices}", self.time_h, self.fs_low, self.fs_high)
    }
}

/// What factors of different meshes may differ by.
const ERROR: f64 = 0.05;

/// When the factor falls through a value, h, between the times of two lines.
fn falls_through(lines: &[Line], factor: f64) -> Option<f64> {
    let points = lines.iter().map(|l| (l.time_h, 0.5 * (l.fs_low + l.fs_high))).filter(|p| p.1.is_finite());
    let points: Vec<(f64, f64)> = points.collect();
    let pair = points.windows(2).find(|pair| pair[0].1 >= factor && pair[1].1 < factor)?;
    let ((t0, f0), (t1, f1)) = (pair[0], pair[1]);
    Some(t0 + (f0 - factor) / (f0 - f1) * (t1 - t0))
}

/// The time of failure that the factors imply, in words.
pub fn implied(lines: &[Line]) -> Option<String> {
    let fails = falls_through(lines, 1.0)?;
    let text = |time: Option<f64>, none: &str| time.map_or_else(|| none.to_owned(), |h| format!("{h:.1} h"));
    let (first, last) = (falls_through(lines, 1.0 + ERROR), falls_through(lines, 1.0 - ERROR));
    Some(format!(
        "The factor is 1 at {}; with an error of {ERROR} it implies failure from {} to {}",
        text(Some(fails), ""),
        text(first, "before the first time"),
        text(last, "after the last time")
    ))
}

/// Draws them, with the events of the run.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn picture(
    lines: &[Line],
    happened: Option<&mpm_core::failure::Events>,
    folder: &Path,
) -> Result<Picture, ReportError> {
    let curve = |of: fn(&Line) -> Option<f64>| lines.iter().filter_map(|l| Some((l.time_h, of(l)?))).collect();
    let found = lines.iter().filter(|l| l.fs_low.is_finite() || l.fs_high.is_finite());
    let safety = Safety {
        brackets: found.map(|l| Bracket { time_h: l.time_h, low: l.fs_low, high: l.fs_high }).collect(),
        infinite_slope: curve(|l| l.infinite_slope),
        bishop: curve(|l| l.bishop),
        spencer: curve(|l| l.spencer),
        spencer_davis: curve(|l| l.spencer_davis),
    };
    let events = happened.map(events).unwrap_or_default();
    let svg = plot::write(&safety, &events, folder)?;
    Ok(Picture::new(plot::figure(&safety, &events), &svg))
}

/// A table for the page.
pub fn shown(lines: &[Line]) -> Table {
    let head = ["time (h)", "strength reduction", "infinite slope", "Bishop", "Spencer"];
    let pair = |full: Option<f64>, davis: Option<f64>| {
        let text = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
        Cell::new(text(full)).marked(format!("Davis {}", text(davis)), "")
    };
    let row = |l: &Line| {
        let found = match l.fs_low.is_finite() {
            true => format!("{:.2} to {:.2}", l.fs_low, l.fs_high),
            false => "none found".to_owned(),
        };
        vec![
            Cell::new(brief(l.time_h, 4)),
            Cell::new(found).marked(format!("{} trials, {} steps", l.trials, l.steps), ""),
            pair(l.infinite_slope, l.infinite_slope_davis),
            pair(l.bishop, l.bishop_davis),
            pair(l.spencer, l.spencer_davis),
        ]
    };
    let implied = implied(lines).map_or_else(String::new, |text| format!(" {text}."));
    let note = "Slides at least a tenth of the height deep; limit equilibrium with the run's level of water, hydrostatic below it, and the \
                peak friction of the base. Davis: with his reduced strength for a soil without dilation. The infinite slope is \
                that at the toe, from when water is there.";
    let mut whys: Vec<&str> =
        lines.iter().map(|l| l.no_limit_equilibrium.as_str()).filter(|why| !why.is_empty()).collect();
    whys.dedup();
    let missing: String = whys.iter().map(|why| format!(" No limit equilibrium: {why}.")).collect();
    let undecided = if lines.iter().any(|l| l.undecided_low.is_some()) {
        " Wider brackets: trials between neither came to rest nor slid within their time."
    } else {
        ""
    };
    let note = format!("{note}{undecided}{missing}{implied}");
    table("Factor of safety".to_owned(), &head, lines.iter().map(row).collect(), &note)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factors_imply_a_time_and_how_uncertain_it_is() {
        let at = |time_h: f64, fs: f64| {
            let found = Found { low: fs - 0.005, high: fs + 0.005, trials: 0, steps: 0, undecided: None };
            line(time_h, &found, Default::default())
        };
        let lines = [at(10.0, 1.10), at(14.0, 0.98), at(18.0, 0.90)];
        let text = implied(&lines).expect("a time");
        assert_eq!(text, "The factor is 1 at 13.3 h; with an error of 0.05 it implies failure from 11.7 h to 15.5 h");
        let late = implied(&lines[..2]).expect("a time");
        assert!(late.ends_with("from 11.7 h to after the last time"), "{late}");
        assert_eq!(implied(&lines[1..]), None);
    }
}
